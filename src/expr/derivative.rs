//! Gradients of expressions, as expressions.
//!
//! Operations state their partial derivatives over any [`Real`]. Here the scalar is an expression: arithmetic on
//! it adds nodes to the graph, and the chain rule puts them together. So whatever an operation states can be
//! differentiated, and one that is added needs nothing more. Noises, and plain sums of their octaves, state their
//! slopes themselves.

use super::{Graph, Input, Node, NodeId, TooLarge};
use crate::noise::{Fractal, Model, Noise, Part, Recipe};
use crate::num::{Class, Kernel, Real};
use crate::op::{self, Op};
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::ops::{Add, Div, Mul, Neg, Sub};
use std::sync::Arc;

/// Why an expression has no gradient.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum NoGradient {
    /// This part of it states no slope.
    #[error("a part of the expression has no slope that is known")]
    Of(NodeId),
    /// It would be too large.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
}

/// A gradient; parts that are zero everywhere are none.
type Gradient = [Option<NodeId>; 3];

impl Graph {
    /// The gradient of an expression by the coordinates. Time and footprint count as constants.
    ///
    /// # Errors
    /// [`NoGradient`] for grids, shapes made of data, flows, creased noises and folded sums of octaves.
    pub fn gradient(&mut self, root: NodeId) -> Result<[NodeId; 3], NoGradient> {
        let mut known: HashMap<NodeId, Gradient> = HashMap::new();
        for id in self.reachable_here(&[root]) {
            let gradient = self.gradient_of(id, &known)?;
            known.insert(id, gradient);
        }
        let zero = self.constant(0.0)?;
        let gradient = known[&root].map(|part| part.unwrap_or(zero));
        // However creased the operations are that it is written down with.
        let class = self.class(root).of_slope();
        gradient.into_iter().for_each(|part| self.raise_class(part, class));
        Ok(gradient)
    }

    fn gradient_of(&mut self, id: NodeId, known: &HashMap<NodeId, Gradient>) -> Result<Gradient, NoGradient> {
        let node = self.node(id).clone();
        if let Node::Input(input) = node {
            let one = self.constant(1.0)?;
            return Ok([Input::X, Input::Y, Input::Z].map(|axis| (input == axis).then_some(one)));
        }
        let args: Vec<Gradient> = node.outer_args().iter().map(|a| known[a]).collect();
        if args.iter().flatten().all(Option::is_none) {
            return Ok([None; 3]);
        }
        let slopes = match node {
            Node::Op(op, args) => self.partials(op, &args)?,
            Node::Noise(noise, p) if has_slope(&noise) => {
                let mut slopes = [None; 3];
                for (axis, slope) in (0..).zip(&mut slopes) {
                    *slope = Some(self.noise(noise.slope(axis), p)?);
                }
                slopes.to_vec()
            }
            Node::Fractal(fractal, p, footprint, None)
                if fractal.recipe().model == Model::FBM && has_slope(&fractal.recipe().noise) =>
            {
                let mut slopes = [None; 3];
                for (axis, slope) in (0..).zip(&mut slopes) {
                    let noise = fractal.recipe().noise.slope(axis);
                    let octaves = Fractal::new(Recipe { noise, ..fractal.recipe().clone() });
                    let octaves = Arc::new(octaves.map_err(|_| NoGradient::Of(id))?);
                    *slope = Some(self.fractal(octaves, p, footprint)?);
                }
                slopes.to_vec()
            }
            _ => return Err(NoGradient::Of(id)),
        };
        let mut gradient = [None; 3];
        for (axis, out) in gradient.iter_mut().enumerate() {
            for (slope, arg) in slopes.iter().zip(&args) {
                let (Some(slope), Some(arg)) = (*slope, arg[axis]) else { continue };
                let term = self.op(Op::Mul(op::Mul), &[slope, arg])?;
                *out = Some(match *out {
                    None => term,
                    Some(sum) => self.op(Op::Add(op::Add), &[sum, term])?,
                });
            }
        }
        Ok(gradient)
    }

    /// The partial derivatives of an operation at its arguments.
    fn partials(&mut self, op: Op, args: &[NodeId]) -> Result<Vec<Option<NodeId>>, TooLarge> {
        let page = Page { graph: RefCell::new(std::mem::take(self)), failure: Cell::new(None) };
        let partials = op.grad(|k| page.symbol(args[k]));
        let nodes = partials.into_iter().map(|p| if p.is_zero() { None } else { page.node(p) }).collect();
        *self = page.graph.into_inner();
        match page.failure.get() {
            Some(failure) => Err(failure),
            None => Ok(nodes),
        }
    }
}

fn has_slope(noise: &Noise) -> bool {
    noise.part == Part::Value && noise.class() >= Class::C1
}

/// Where expressions are written down: the graph, lent for a while.
struct Page {
    graph: RefCell<Graph>,
    failure: Cell<Option<TooLarge>>,
}

impl Page {
    fn symbol(&self, id: NodeId) -> Symbol<'_> {
        match self.graph.borrow().as_const(id) {
            Some(c) => Symbol::Number(c),
            None => Symbol::Node(self, id),
        }
    }

    /// The node of a symbol; none once there was no room.
    fn node(&self, symbol: Symbol<'_>) -> Option<NodeId> {
        match symbol {
            Symbol::Node(_, id) => Some(id),
            Symbol::Number(c) => self.added(|graph| graph.constant(c)),
        }
    }

    fn added(&self, add: impl FnOnce(&mut Graph) -> Result<NodeId, TooLarge>) -> Option<NodeId> {
        add(&mut self.graph.borrow_mut()).map_err(|failure| self.failure.set(Some(failure))).ok()
    }

    fn op<'a>(&'a self, op: Op, args: &[Symbol<'a>]) -> Symbol<'a> {
        let args: Option<Vec<NodeId>> = args.iter().map(|a| self.node(*a)).collect();
        match args.and_then(|args| self.added(|graph| graph.op(op, &args))) {
            Some(id) => self.symbol(id),
            None => Symbol::Number(f64::NAN),
        }
    }
}

/// A number that is known, or an expression.
#[derive(Clone, Copy)]
enum Symbol<'a> {
    Number(f64),
    Node(&'a Page, NodeId),
}

use Symbol::Number;

impl Symbol<'_> {
    fn is_zero(&self) -> bool {
        matches!(self, Number(c) if *c == 0.0)
    }

    fn one(self, op: Op, known: fn(f64) -> f64) -> Self {
        match self {
            Number(x) => Number(known(x)),
            Symbol::Node(page, _) => page.op(op, &[self]),
        }
    }

    fn two(self, other: Self, op: Op, known: fn(f64, f64) -> f64) -> Self {
        match (self, other) {
            (Number(x), Number(y)) => Number(known(x, y)),
            (Symbol::Node(page, _), _) | (_, Symbol::Node(page, _)) => page.op(op, &[self, other]),
        }
    }
}

/// Implements the operators.
macro_rules! operators {
    ($($op:ident $name:ident),*) => {$(
        impl $op for Symbol<'_> {
            type Output = Self;
            fn $name(self, other: Self) -> Self {
                self.two(other, Op::$op(op::$op), f64::$name)
            }
        }
    )*};
}
operators!(Add add, Sub sub, Mul mul, Div div);

impl Neg for Symbol<'_> {
    type Output = Self;
    fn neg(self) -> Self {
        self.one(Op::Neg(op::Neg), |x| -x)
    }
}

/// Implements functions that are operations.
macro_rules! functions {
    ($($name:ident $op:ident),*) => {$(
        fn $name(self) -> Self {
            self.one(Op::$op(op::$op), <f64 as Real>::$name)
        }
    )*};
}

impl Real for Symbol<'_> {
    functions!(
        abs Abs, square Square, sqrt Sqrt, exp Exp, ln Ln, sin Sin, cos Cos, tan Tan, asin Asin, acos Acos,
        atan Atan, floor Floor
    );
    fn of(c: f64) -> Self {
        Number(c)
    }
    fn powi(self, n: i32) -> Self {
        match (self, n) {
            (_, 0) => Number(1.0),
            (_, 1) => self,
            (_, 2) => self.square(),
            (Number(x), _) => Number(Real::powi(x, n)),
            (Symbol::Node(page, _), _) => page.op(Op::Powi(op::Powi { n }), &[self]),
        }
    }
    fn powf(self, p: Self) -> Self {
        self.two(p, Op::Powf(op::Powf), Real::powf)
    }
    fn atan2(self, x: Self) -> Self {
        self.two(x, Op::Atan2(op::Atan2), Real::atan2)
    }
    fn min(self, other: Self) -> Self {
        self.two(other, Op::Min(op::Min), Real::min)
    }
    fn max(self, other: Self) -> Self {
        self.two(other, Op::Max(op::Max), Real::max)
    }
    fn if_less(self, other: Self, then: Self, otherwise: Self) -> Self {
        // Whether `self` is not less.
        let not = other.two(self, Op::Step(op::Step), |edge, x| if x < edge { 0.0 } else { 1.0 });
        match not {
            Number(x) if x < 0.5 => then,
            Number(x) if x >= 0.5 => otherwise,
            _ => then + not * (otherwise - then),
        }
    }
    fn slope_of_jump(self) -> Self {
        Number(0.0)
    }
    fn slope_of_floor(self) -> Self {
        Number(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::Dual;
    use crate::tape::{Evaluator, Tape};
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    #[test]
    fn gradients_are_those_of_duals() {
        let mut rng = StdRng::seed_from_u64(7);
        for op in Op::ALL {
            let mut graph = Graph::default();
            let p = graph.point().unwrap();
            // Arguments that differ and vary along all axes; where an operation is not defined, neither is its gradient.
            let sum = graph.op(Op::Dot(op::Dot), &[p[0], p[1], p[2], p[1], p[2], p[0]]).unwrap();
            let args: Vec<NodeId> = (0..op.arity()).map(|k| [p[0], p[1], p[2], sum][k % 4]).collect();
            let root = graph.op(*op, &args).unwrap();
            let gradient = graph.gradient(root).unwrap();
            let tape = |roots: &[NodeId]| Arc::new(Tape::new(&graph, roots));
            let (mut duals, mut parts) =
                (Evaluator::<Dual>::new(tape(&[root])), Evaluator::<f64>::new(tape(&gradient)));
            for _ in 0..50 {
                let at: [f64; 3] = std::array::from_fn(|_| rng.random_range(-0.55..0.55));
                let wanted = duals.eval(&std::array::from_fn(|k| Dual::coordinate(at[k], k))).grad;
                parts.eval(&at);
                for (axis, wanted) in wanted.into_iter().enumerate() {
                    let got = *parts.output(axis);
                    let close = (got - wanted).abs() <= 1e-9 * (1.0 + wanted.abs());
                    assert!(close || (got.is_nan() && wanted.is_nan()), "{}: {got} {wanted}", op.name());
                }
            }
        }
    }
}
