//! The arena of nodes.

use super::fold;
use crate::diag::Place;
use crate::flow::Precision;
use crate::grid::{Grid, never};
use crate::noise::{Fractal, Noise};
use crate::num::{Class, Kernel};
use crate::op::{self, Op};
use crate::shape::Shape;
use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

/// Names a node of one graph.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct NodeId(pub(crate) u32);

/// What an expression is a function of.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Input {
    /// First coordinate.
    X,
    /// Second coordinate (up).
    Y,
    /// Third coordinate.
    Z,
    /// Animation time in seconds.
    Time,
    /// Size of a pixel at the point, in the units of the coordinates.
    Footprint,
}

/// An expression.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum Node {
    /// A number, by its bits so that it can be compared and hashed.
    Const(u64),
    /// A variable.
    Input(Input),
    /// An operation on earlier nodes.
    Op(Op, Vec<NodeId>),
    /// A noise at a point.
    Noise(Noise, [NodeId; 3]),
    /// A sum of octaves at a point, with the footprint that limits its detail, and the exponent of
    /// its amplitudes where that is an expression.
    Fractal(Arc<Fractal>, [NodeId; 3], NodeId, Option<NodeId>),
    /// The spline of a grid at a point, without its level.
    Grid(Arc<Grid>, [NodeId; 3]),
    /// A shape that is made of data, at a point.
    Shape(Arc<Shape>, [NodeId; 3]),
    /// A field where a flow carries a point to.
    Flow(Arc<Flow>, [NodeId; 3]),
}

/// A field that a velocity carries along. Both are expressions of their own: their coordinates are those of where the
/// flow has come to, not those of the point where the node is asked.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Flow {
    /// The field before.
    pub field: NodeId,
    /// The velocity.
    pub velocity: [NodeId; 3],
    /// How close its steps come to the flow.
    pub precision: Precision,
}

/// A graph has as many nodes as it may.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[error("the expression has more than {limit} nodes")]
pub struct TooLarge {
    /// How many it may have.
    pub limit: usize,
}

/// A hash-consed expression graph.
#[derive(Clone, Debug)]
pub struct Graph {
    nodes: Vec<Node>,
    classes: Vec<Class>,
    places: Vec<Option<Place>>,
    index: HashMap<Node, NodeId>,
    limit: usize,
}

impl Default for Graph {
    fn default() -> Self {
        Graph::with_limit(1 << 20)
    }
}

impl Graph {
    /// An empty graph that takes at most `limit` nodes.
    pub fn with_limit(limit: usize) -> Self {
        Graph { nodes: Vec::new(), classes: Vec::new(), places: Vec::new(), index: HashMap::new(), limit }
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether there are no nodes.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The node of an id of this graph.
    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id.0 as usize]
    }

    /// Continuity class of an expression: the least of its operations.
    pub fn class(&self, id: NodeId) -> Class {
        self.classes[id.0 as usize]
    }

    /// Where in a script the node was made first.
    pub fn place(&self, id: NodeId) -> Option<&Place> {
        self.places[id.0 as usize].as_ref()
    }

    /// Records where a node was made, unless that is known already.
    pub fn set_place(&mut self, id: NodeId, place: &Place) {
        self.places[id.0 as usize].get_or_insert_with(|| place.clone());
    }

    /// Records another place.
    pub fn move_place(&mut self, id: NodeId, place: &Place) {
        self.places[id.0 as usize] = Some(place.clone());
    }

    /// The nodes that were added after the first so many.
    pub fn since(&self, before: usize) -> impl Iterator<Item = NodeId> + use<> {
        (before as u32..self.len() as u32).map(NodeId)
    }

    /// The value of a node that is a number.
    pub fn as_const(&self, id: NodeId) -> Option<f64> {
        match self.node(id) {
            Node::Const(bits) => Some(f64::from_bits(*bits)),
            _ => None,
        }
    }

    /// A number.
    ///
    /// # Errors
    /// [`TooLarge`], here and in every function that adds nodes.
    pub fn constant(&mut self, c: f64) -> Result<NodeId, TooLarge> {
        // One zero, so that `x + 0` and `x - 0` meet.
        let c = if c == 0.0 { 0.0 } else { c };
        self.intern(Node::Const(c.to_bits()))
    }

    /// A variable.
    pub fn input(&mut self, input: Input) -> Result<NodeId, TooLarge> {
        self.intern(Node::Input(input))
    }

    /// The coordinates.
    pub fn point(&mut self) -> Result<[NodeId; 3], TooLarge> {
        Ok([self.input(Input::X)?, self.input(Input::Y)?, self.input(Input::Z)?])
    }

    /// An operation; folded where that changes no bit of any result that is a number.
    pub fn op(&mut self, op: Op, args: &[NodeId]) -> Result<NodeId, TooLarge> {
        debug_assert_eq!(op.arity(), args.len());
        match fold::fold(self, op, args) {
            fold::Folded::Node(id) => Ok(id),
            fold::Folded::Const(c) => self.constant(c),
            fold::Folded::Op(op, args) => self.intern(Node::Op(op, args)),
            fold::Folded::Squares(args) => self.squares(args),
        }
    }

    /// The sum of squares, from the left.
    fn squares(&mut self, [a, b, c]: [NodeId; 3]) -> Result<NodeId, TooLarge> {
        let mut square = |x| self.op(Op::Square(op::Square), &[x]);
        let (a, b, c) = (square(a)?, square(b)?, square(c)?);
        let sum = self.op(Op::Add(op::Add), &[a, b])?;
        self.op(Op::Add(op::Add), &[sum, c])
    }

    /// A noise at a point.
    pub fn noise(&mut self, noise: Noise, p: [NodeId; 3]) -> Result<NodeId, TooLarge> {
        self.intern(Node::Noise(noise, p))
    }

    /// A sum of octaves at a point.
    pub fn fractal(
        &mut self,
        fractal: Arc<Fractal>,
        p: [NodeId; 3],
        footprint: NodeId,
    ) -> Result<NodeId, TooLarge> {
        self.intern(Node::Fractal(fractal, p, footprint, None))
    }

    /// A sum of octaves whose amplitudes fall with an exponent that is an expression.
    pub fn rough_fractal(
        &mut self,
        fractal: Arc<Fractal>,
        p: [NodeId; 3],
        footprint: NodeId,
        hurst: NodeId,
    ) -> Result<NodeId, TooLarge> {
        self.intern(Node::Fractal(fractal, p, footprint, Some(hurst)))
    }

    /// The field of a grid at a point: its spline and its level.
    pub fn grid(&mut self, grid: Arc<Grid>, p: [NodeId; 3]) -> Result<NodeId, TooLarge> {
        let _ = grid.bind(&never);
        let level = self.constant(grid.level())?;
        let spline = self.intern(Node::Grid(grid, p))?;
        self.op(Op::Add(crate::op::Add), &[spline, level])
    }

    /// A shape at a point.
    pub fn shape(&mut self, shape: Arc<Shape>, p: [NodeId; 3]) -> Result<NodeId, TooLarge> {
        self.intern(Node::Shape(shape, p))
    }

    /// A field where a flow carries a point to.
    pub fn flow(&mut self, flow: Arc<Flow>, p: [NodeId; 3]) -> Result<NodeId, TooLarge> {
        self.intern(Node::Flow(flow, p))
    }

    /// The same expression with inputs replaced by other expressions: `f.translate(..)` replaces
    /// the coordinates, an animation frame replaces the time. Within a flow the coordinates are its own, and stay; the
    /// footprint there is that of the place that the flow has come to.
    pub fn substitute(&mut self, root: NodeId, with: &[(Input, NodeId)]) -> Result<NodeId, TooLarge> {
        let is_own = |input: &Input| matches!(input, Input::X | Input::Y | Input::Z);
        let within: Vec<(Input, NodeId)> = with.iter().filter(|w| !is_own(&w.0)).copied().collect();
        let used = self.reachable_here(&[root]);
        // What flows carry, to any depth.
        let mut carried = HashMap::new();
        if !within.is_empty() {
            let flows = used.iter().filter_map(|id| match self.node(*id) {
                Node::Flow(flow, _) => Some([flow.field].into_iter().chain(flow.velocity)),
                _ => None,
            });
            for id in self.reachable(&flows.flatten().collect::<Vec<_>>()) {
                let new = self.replaced(id, &within, &carried, &carried)?;
                carried.insert(id, new);
            }
        }
        let mut image: HashMap<NodeId, NodeId> = HashMap::with_capacity(used.len());
        for id in used {
            let new = self.replaced(id, with, &image, &carried)?;
            image.insert(id, new);
        }
        Ok(image[&root])
    }

    /// The same expression with a node replaced by another one, but within flows.
    pub fn exchange(&mut self, root: NodeId, old: NodeId, new: NodeId) -> Result<NodeId, TooLarge> {
        let (mut image, carried) = (HashMap::new(), HashMap::new());
        for id in self.reachable_here(&[root]) {
            let now = if id == old { new } else { self.replaced(id, &[], &image, &carried)? };
            image.insert(id, now);
        }
        Ok(image[&root])
    }

    /// A node with inputs replaced, given what has become of its arguments, and of what it carries, if that changes.
    pub(super) fn replaced(
        &mut self,
        id: NodeId,
        with: &[(Input, NodeId)],
        image: &HashMap<NodeId, NodeId>,
        carried: &HashMap<NodeId, NodeId>,
    ) -> Result<NodeId, TooLarge> {
        let new = match self.node(id).clone() {
            Node::Const(_) => id,
            Node::Input(input) => with.iter().find(|w| w.0 == input).map_or(id, |w| w.1),
            Node::Op(op, args) => {
                let args: Vec<NodeId> = args.iter().map(|a| image[a]).collect();
                self.op(op, &args)?
            }
            Node::Noise(noise, p) => self.noise(noise, p.map(|a| image[&a]))?,
            Node::Fractal(f, p, footprint, hurst) => {
                let hurst = hurst.map(|h| image[&h]);
                self.intern(Node::Fractal(f, p.map(|a| image[&a]), image[&footprint], hurst))?
            }
            Node::Grid(grid, p) => self.intern(Node::Grid(grid, p.map(|a| image[&a])))?,
            Node::Shape(shape, p) => self.shape(shape, p.map(|a| image[&a]))?,
            Node::Flow(flow, p) => {
                let own = |a: NodeId| carried.get(&a).copied().unwrap_or(a);
                let flow = Flow { field: own(flow.field), velocity: flow.velocity.map(own), ..*flow };
                self.flow(Arc::new(flow), p.map(|a| image[&a]))?
            }
        };
        if new != id
            && let Some(place) = self.place(id).cloned()
        {
            self.set_place(new, &place);
        }
        Ok(new)
    }

    /// How many flows within flows an expression has at most.
    pub fn nesting(&self, root: NodeId) -> usize {
        let mut depths: HashMap<NodeId, usize> = HashMap::new();
        for id in self.reachable(&[root]) {
            let node = self.node(id);
            let deepest = |args: &[NodeId]| args.iter().map(|a| depths[a]).max().unwrap_or(0);
            let depth = match node {
                Node::Flow(..) => 1 + deepest(&node.args()),
                _ => deepest(&node.args()),
            };
            depths.insert(id, depth);
        }
        depths[&root]
    }

    /// The nodes that `roots` are made of, arguments before their users, and what flows among them carry. Takes time for
    /// these alone, however large the graph is: a script may build it from thousands of parts.
    pub fn reachable(&self, roots: &[NodeId]) -> Vec<NodeId> {
        self.walk(roots, Node::args)
    }

    /// The same without what flows carry: what is evaluated at the point itself.
    pub fn reachable_here(&self, roots: &[NodeId]) -> Vec<NodeId> {
        self.walk(roots, Node::outer_args)
    }

    pub(super) fn walk(&self, roots: &[NodeId], args: impl Fn(&Node) -> Vec<NodeId>) -> Vec<NodeId> {
        let mut pending: BTreeSet<u32> = roots.iter().map(|r| r.0).collect();
        let mut used = Vec::new();
        // Arguments have lower numbers than their users, so that each node comes up once.
        while let Some(id) = pending.pop_last() {
            used.push(NodeId(id));
            pending.extend(args(&self.nodes[id as usize]).iter().map(|a| a.0));
        }
        used.reverse();
        used
    }

    /// The first expression, in the order in which they are evaluated, that is rougher than a class
    /// although nothing that it is made of is: the culprit where `root` is too rough.
    pub fn first_below(&self, root: NodeId, class: Class) -> Option<NodeId> {
        if self.class(root) >= class {
            return None;
        }
        self.reachable(&[root]).into_iter().find(|&id| self.class(id) < class)
    }

    /// Continuity class of what a node does, whatever its arguments are.
    fn own_class(&self, node: &Node) -> Class {
        match node {
            Node::Const(_) | Node::Input(_) => Class::C2,
            Node::Op(op, _) => op.class(),
            Node::Noise(noise, _) => noise.class(),
            // Octaves fade with a weight that is C1 in the footprint.
            Node::Fractal(fractal, _, footprint, _) if self.varies(*footprint) => {
                fractal.class().min(Class::C1)
            }
            Node::Fractal(fractal, ..) => fractal.class(),
            Node::Grid(grid, _) => grid.class(),
            Node::Shape(shape, _) => shape.body().class(),
            // No bound is known on how second derivatives vary.
            Node::Flow(..) => Class::C1,
        }
    }

    /// Says of an expression that it is no rougher than this.
    pub(super) fn raise_class(&mut self, id: NodeId, class: Class) {
        let own = &mut self.classes[id.0 as usize];
        *own = class.max(*own);
    }

    /// Whether a footprint reads the point. As long as it is not said how far apart samples are, it is nothing.
    fn varies(&self, id: NodeId) -> bool {
        if matches!(self.node(id), Node::Const(_)) {
            return false;
        }
        let inputs = self.reachable(&[id]);
        let reads = |input: Input| inputs.iter().any(|id| *self.node(*id) == Node::Input(input));
        !reads(Input::Footprint) && [Input::X, Input::Y, Input::Z].into_iter().any(reads)
    }

    fn intern(&mut self, node: Node) -> Result<NodeId, TooLarge> {
        if let Some(&id) = self.index.get(&node) {
            return Ok(id);
        }
        if self.nodes.len() >= self.limit.min(u32::MAX as usize) {
            return Err(TooLarge { limit: self.limit });
        }
        let id = NodeId(self.nodes.len() as u32);
        let own = self.own_class(&node);
        let class = node.args().into_iter().map(|a| self.class(a)).fold(own, Class::min);
        self.nodes.push(node.clone());
        self.classes.push(class);
        self.places.push(None);
        self.index.insert(node, id);
        Ok(id)
    }
}

impl Node {
    /// The nodes that this one is made of, those included that a flow carries.
    pub fn args(&self) -> Vec<NodeId> {
        let mut args = self.outer_args();
        if let Node::Flow(flow, _) = self {
            args.push(flow.field);
            args.extend(flow.velocity);
        }
        args
    }

    /// The nodes that this one reads at the point where it is asked.
    pub(super) fn outer_args(&self) -> Vec<NodeId> {
        match self {
            Node::Const(_) | Node::Input(_) => Vec::new(),
            Node::Op(_, args) => args.clone(),
            Node::Noise(_, p) | Node::Grid(_, p) | Node::Shape(_, p) | Node::Flow(_, p) => p.to_vec(),
            Node::Fractal(_, [x, y, z], footprint, hurst) => {
                [*x, *y, *z, *footprint].into_iter().chain(*hurst).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::op::{Add, Cos, Op, Sin};

    #[test]
    fn a_node_can_be_exchanged_and_the_rest_stays() {
        let mut graph = Graph::default();
        let [x, y, _] = graph.point().unwrap();
        let op = |graph: &mut Graph, op: Op, args: &[NodeId]| graph.op(op, args).unwrap();
        let (sine, cosine) = (op(&mut graph, Op::Sin(Sin), &[x]), op(&mut graph, Op::Cos(Cos), &[x]));
        let sum = op(&mut graph, Op::Add(Add), &[sine, y]);
        let other = op(&mut graph, Op::Add(Add), &[cosine, y]);
        assert_eq!(graph.exchange(sum, sine, cosine), Ok(other));
        assert_eq!(graph.exchange(sum, sum, x), Ok(x));
        // What is not part of it changes nothing.
        assert_eq!(graph.exchange(sum, cosine, x), Ok(sum));
    }

    #[test]
    fn what_is_multiplied_by_itself_is_a_square() {
        use crate::op::{Dot, Mul, Square};
        let mut graph = Graph::default();
        let [x, y, z] = graph.point().unwrap();
        let op = |graph: &mut Graph, op: Op, args: &[NodeId]| graph.op(op, args).unwrap();
        let [a, b, c] = [x, y, z].map(|x| op(&mut graph, Op::Square(Square), &[x]));
        assert_eq!(op(&mut graph, Op::Mul(Mul), &[y, y]), b);
        assert_ne!(op(&mut graph, Op::Mul(Mul), &[x, y]), b);
        let sum = op(&mut graph, Op::Add(Add), &[a, b]);
        let sum = op(&mut graph, Op::Add(Add), &[sum, c]);
        assert_eq!(op(&mut graph, Op::Dot(Dot), &[x, y, z, x, y, z]), sum);
        assert_ne!(op(&mut graph, Op::Dot(Dot), &[x, y, z, y, x, z]), sum);
    }
}
