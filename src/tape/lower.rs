//! From graph to straight-line code.

use super::crown::Crown;
use super::eval::Registers;
use super::inner::{Flowed, Inner};
use super::native::Native;
use crate::expr::{Graph, Input, Node, NodeId};
use crate::grid::Grid;
use crate::noise::{Fractal, Noise};
use crate::num::{Class, Kernel};
use crate::op::{self, Op};
use crate::shape::Shape;
use std::collections::{HashMap, HashSet};
use std::sync::{Arc, OnceLock};

/// One instruction; slots are numbered by the instructions that write them.
#[derive(Clone, Debug)]
pub enum Instr {
    /// A number.
    Const(f64),
    /// The coordinate with this number (0, 1, 2).
    Coordinate(usize),
    /// A slot times a number.
    Scale(u32, f64),
    /// A slot plus a number.
    Shift(u32, f64),
    /// An operation on slots; the first `arity` entries count.
    Op(Op, [u32; 6]),
    /// A noise at a point.
    Noise(Arc<Noise>, [u32; 3]),
    /// A sum of octaves at a point, with the slots of the footprint where detail is limited, and of
    /// the exponent where that varies.
    Fractal(Arc<Fractal>, [u32; 3], [Option<u32>; 2]),
    /// The spline of a grid at a point.
    Grid(Arc<Grid>, [u32; 3]),
    /// A shape that is made of data, at a point.
    Shape(Arc<Shape>, [u32; 3]),
    /// A field where a flow carries a point to.
    Flow(Arc<Flowed>, [u32; 3]),
}

/// Instructions of a tape by how much work they are.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Census {
    /// Sums, differences and products with a number, which every kind of number knows natively.
    pub sums: u64,
    /// Operations that are lifted.
    pub functions: u64,
    /// Noises and grids; an octave of a fractal counts here, and as a function.
    pub octaves: u64,
    /// Of these, the ones that say more of a small ball than of all of space, which is looked up ball by
    /// ball.
    pub scattered: u64,
    /// Instructions of what flows carry, each time that they are run.
    pub carried: u64,
}

impl Census {
    /// Adds what it takes to carry a point along and to evaluate the field there.
    fn carry(&mut self, flowed: &Flowed) {
        let stages = 4 * u64::from(flowed.steps());
        for (times, tape) in [(stages, flowed.velocity().tape()), (1, flowed.field().tape())] {
            let one = tape.census();
            let add = |sum: &mut u64, one: u64| *sum = sum.saturating_add(one.saturating_mul(times));
            add(&mut self.sums, one.sums);
            add(&mut self.functions, one.functions);
            add(&mut self.octaves, one.octaves);
            add(&mut self.scattered, one.scattered);
            add(&mut self.carried, tape.len() as u64);
            add(&mut self.carried, one.carried);
        }
    }
}

/// Straight-line code for one or more expressions.
#[derive(Clone, Debug)]
pub struct Tape {
    pub(super) code: Vec<Instr>,
    pub(super) outputs: Vec<u32>,
    /// What each instruction computes.
    pub(super) origins: Vec<NodeId>,
    /// Of the roughest output.
    class: Class,
    /// Counted when it is first asked for.
    work: OnceLock<u64>,
    /// Chosen when the tape is first evaluated.
    pub(super) registers: OnceLock<Registers>,
    /// Found when signs are first asked for.
    pub(super) crown: OnceLock<Box<Crown>>,
    /// Made when the tape has been evaluated often.
    pub(super) native: Native,
}

/// Whether an expression reads as zero while it is not said how far apart samples are: that, and what it is divided by or
/// multiplied with.
fn reads_as_nothing(graph: &Graph, id: NodeId) -> bool {
    match graph.node(id) {
        Node::Input(Input::Footprint) => true,
        Node::Op(Op::Div(_), args) => reads_as_nothing(graph, args[0]),
        Node::Op(Op::Mul(_), args) => args.iter().any(|a| reads_as_nothing(graph, *a)),
        _ => graph.as_const(id) == Some(0.0),
    }
}

impl Tape {
    /// Lowers expressions of the coordinates. Time and footprint must have been substituted before;
    /// any that are left read as zero.
    pub fn new(graph: &Graph, roots: &[NodeId]) -> Tape {
        let mut slot: HashMap<NodeId, u32> = HashMap::new();
        let (mut code, mut origins, mut even) = (Vec::new(), Vec::new(), HashSet::new());
        for id in graph.reachable_here(roots) {
            let at = |a: &NodeId| slot[a];
            if is_even(graph, id, &even) {
                even.insert(id);
            }
            let last = match graph.node(id) {
                Node::Const(bits) => Instr::Const(f64::from_bits(*bits)),
                Node::Input(Input::X) => Instr::Coordinate(0),
                Node::Input(Input::Y) => Instr::Coordinate(1),
                Node::Input(Input::Z) => Instr::Coordinate(2),
                Node::Input(Input::Time | Input::Footprint) => Instr::Const(0.0),
                Node::Op(Op::Dot(_), args) if even.contains(&id) => weighted_sum(graph, args, at, &mut code),
                Node::Op(op, args) => lower_op(graph, *op, args, at),
                Node::Noise(noise, p) => Instr::Noise(Arc::new(*noise), [at(&p[0]), at(&p[1]), at(&p[2])]),
                Node::Grid(grid, p) => Instr::Grid(grid.clone(), [at(&p[0]), at(&p[1]), at(&p[2])]),
                Node::Shape(shape, p) => Instr::Shape(shape.clone(), [at(&p[0]), at(&p[1]), at(&p[2])]),
                Node::Flow(flow, p) => {
                    Instr::Flow(Arc::new(Inner::flowed(graph, flow)), [at(&p[0]), at(&p[1]), at(&p[2])])
                }
                Node::Fractal(fractal, p, footprint, hurst) => {
                    let limited = !reads_as_nothing(graph, *footprint);
                    let p = [at(&p[0]), at(&p[1]), at(&p[2])];
                    let further = [limited.then(|| at(footprint)), hurst.as_ref().map(at)];
                    Instr::Fractal(fractal.clone(), p, further)
                }
            };
            code.push(last);
            origins.resize(code.len(), id);
            slot.insert(id, code.len() as u32 - 1);
        }
        let outputs = roots.iter().map(|r| slot[r]).collect();
        let class = roots.iter().map(|&root| graph.class(root)).fold(Class::C2, Class::min);
        Tape::of(code, outputs, origins, class).without_dead_code()
    }

    pub(super) fn of(code: Vec<Instr>, outputs: Vec<u32>, origins: Vec<NodeId>, class: Class) -> Tape {
        let (work, registers, crown, native) = Default::default();
        Tape { code, outputs, origins, class, work, registers, crown, native }
    }

    /// Continuity class, of the roughest output where there are several.
    pub fn class(&self) -> Class {
        self.class
    }

    /// Number of instructions.
    pub fn len(&self) -> usize {
        self.code.len()
    }

    /// Whether the tape has no instructions, and so no outputs.
    pub fn is_empty(&self) -> bool {
        self.code.is_empty()
    }

    /// The instructions.
    pub fn code(&self) -> &[Instr] {
        &self.code
    }

    /// The node that each instruction computes, of the graph that the tape was made from; where several do, the last.
    pub fn origins(&self) -> &[NodeId] {
        &self.origins
    }

    /// The nodes that the outputs are.
    pub fn roots(&self) -> Vec<NodeId> {
        self.outputs.iter().filter_map(|&o| self.origins.get(o as usize)).copied().collect()
    }

    /// The instruction that computes an output.
    pub fn output(&self, k: usize) -> u32 {
        self.outputs[k]
    }

    /// Number of outputs.
    pub fn outputs(&self) -> usize {
        self.outputs.len()
    }

    /// The tape with its outputs negated: of a solid, that of its complement.
    pub fn negated(&self) -> Tape {
        let mut code = self.code.clone();
        let first = code.len() as u32;
        code.extend(self.outputs.iter().map(|&o| Instr::Op(Op::Neg(op::Neg), [o, 0, 0, 0, 0, 0])));
        let outputs = (first..code.len() as u32).collect();
        let negated = self.outputs.iter().filter_map(|&o| self.origins.get(o as usize));
        let origins = self.origins.iter().chain(negated).copied().collect();
        Tape::of(code, outputs, origins, self.class)
    }

    /// How much work there is in the tape.
    pub fn census(&self) -> Census {
        let mut census = Census::default();
        for instr in &self.code {
            match instr {
                Instr::Const(_) | Instr::Coordinate(_) => {}
                Instr::Scale(..) | Instr::Shift(..) | Instr::Op(Op::Add(_) | Op::Sub(_) | Op::Neg(_), _) => {
                    census.sums += 1;
                }
                Instr::Op(..) => census.functions += 1,
                Instr::Noise(noise, _) => {
                    census.octaves += 1;
                    census.scattered += u64::from(!noise.is_uniform());
                }
                Instr::Grid(grid, _) => {
                    census.octaves += 1;
                    census.scattered += u64::from(!grid.is_uniform());
                }
                Instr::Shape(shape, _) => {
                    census.octaves += 1;
                    census.scattered += u64::from(!shape.body().is_uniform());
                }
                Instr::Flow(flowed, _) => census.carry(flowed),
                Instr::Fractal(fractal, ..) => {
                    // A fractal's octaves fade, fold and multiply besides.
                    let octaves = u64::from(fractal.recipe().octaves);
                    census.octaves += octaves;
                    census.scattered += octaves * u64::from(!fractal.recipe().noise.is_uniform());
                    census.functions += octaves;
                }
            }
        }
        census
    }

    /// How much work an evaluation is, in about as many sums: an octave is a function at each corner of its
    /// lattice, and one that is looked up ball by ball searches besides.
    pub fn work(&self) -> u64 {
        *self.work.get_or_init(|| {
            let Census { octaves, scattered, carried, .. } = self.census();
            let octaves = octaves.saturating_mul(8).saturating_add(scattered.saturating_mul(64));
            (self.len() as u64).saturating_add(carried).saturating_add(octaves)
        })
    }

    pub(super) fn without_dead_code(self) -> Tape {
        let mut used = vec![false; self.code.len()];
        for &o in &self.outputs {
            used[o as usize] = true;
        }
        for i in (0..self.code.len()).rev() {
            if used[i] {
                self.code[i].each_arg(|a| used[a as usize] = true);
            }
        }
        let mut moved = vec![u32::MAX; self.code.len()];
        let mut code = Vec::with_capacity(self.code.len());
        let mut origins = Vec::with_capacity(self.code.len());
        for (i, mut instr) in self.code.into_iter().enumerate() {
            if used[i] {
                instr.map_args(|a| moved[a as usize]);
                moved[i] = code.len() as u32;
                code.push(instr);
                origins.extend(self.origins.get(i));
            }
        }
        Tape::of(code, self.outputs.iter().map(|&o| moved[o as usize]).collect(), origins, self.class)
    }
}

/// Whether an expression changes evenly from place to place, given which of its arguments do: it is a sum of multiples of the
/// coordinates and a number.
fn is_even(graph: &Graph, id: NodeId, even: &HashSet<NodeId>) -> bool {
    let is_number = |a: &NodeId| graph.as_const(*a).is_some();
    match graph.node(id) {
        Node::Const(_) | Node::Input(_) => true,
        Node::Op(Op::Add(_) | Op::Sub(_) | Op::Neg(_), args) => args.iter().all(|a| even.contains(a)),
        Node::Op(Op::Mul(_), args) => args.iter().all(|a| even.contains(a)) && args.iter().any(is_number),
        Node::Op(Op::Dot(_), args) => {
            args.iter().all(|a| even.contains(a)) && args.chunks(3).any(|half| half.iter().all(is_number))
        }
        _ => false,
    }
}

/// A product of even expressions with three numbers, as products and sums, which all kinds of number have of their own: the
/// last instruction of these, after the others. The bits are the same where all terms are finite, but for the sign of a zero.
fn weighted_sum(graph: &Graph, args: &[NodeId], at: impl Fn(&NodeId) -> u32, code: &mut Vec<Instr>) -> Instr {
    let (of, weights) = args.split_at(3);
    let weight = |a: &NodeId| graph.as_const(*a);
    let (of, weights) =
        if weights.iter().all(|a| weight(a).is_some()) { (of, weights) } else { (weights, of) };
    let terms = of.iter().zip(weights.iter().filter_map(weight)).filter(|(_, weight)| *weight != 0.0);
    let mut last = Instr::Const(0.0);
    let push = |code: &mut Vec<Instr>, instr: Instr| {
        code.push(instr);
        code.len() as u32 - 1
    };
    for (i, (a, weight)) in terms.enumerate() {
        let term = Instr::Scale(at(a), weight);
        last = if i == 0 {
            term
        } else {
            let [sum, term] = [last, term].map(|instr| push(code, instr));
            Instr::Op(Op::Add(op::Add), [sum, term, 0, 0, 0, 0])
        };
    }
    last
}

/// Sums and products with a number, which every kind of number does natively, and what remains.
fn lower_op(graph: &Graph, op: Op, args: &[NodeId], at: impl Fn(&NodeId) -> u32) -> Instr {
    let number = |i: usize| graph.as_const(args[i]);
    match op {
        Op::Mul(_) => {
            if let Some(k) = number(0) {
                return Instr::Scale(at(&args[1]), k);
            }
            if let Some(k) = number(1) {
                return Instr::Scale(at(&args[0]), k);
            }
        }
        Op::Add(_) => {
            if let Some(c) = number(0) {
                return Instr::Shift(at(&args[1]), c);
            }
            if let Some(c) = number(1) {
                return Instr::Shift(at(&args[0]), c);
            }
        }
        Op::Sub(_) => {
            if let Some(c) = number(1) {
                return Instr::Shift(at(&args[0]), -c);
            }
        }
        _ => {}
    }
    let mut slots = [0; 6];
    for (slot, arg) in slots.iter_mut().zip(args) {
        *slot = at(arg);
    }
    Instr::Op(op, slots)
}

impl Instr {
    pub(super) fn each_arg(&self, mut f: impl FnMut(u32)) {
        match self {
            Instr::Const(_) | Instr::Coordinate(_) => {}
            Instr::Scale(a, _) | Instr::Shift(a, _) => f(*a),
            Instr::Op(op, args) => args.iter().take(op.arity()).for_each(|a| f(*a)),
            Instr::Noise(_, p) | Instr::Grid(_, p) | Instr::Shape(_, p) | Instr::Flow(_, p) => {
                p.iter().for_each(|a| f(*a));
            }
            Instr::Fractal(_, p, further) => p.iter().chain(further.iter().flatten()).for_each(|a| f(*a)),
        }
    }

    pub(super) fn map_args(&mut self, mut f: impl FnMut(u32) -> u32) {
        match self {
            Instr::Const(_) | Instr::Coordinate(_) => {}
            Instr::Scale(a, _) | Instr::Shift(a, _) => *a = f(*a),
            Instr::Op(op, args) => args.iter_mut().take(op.arity()).for_each(|a| *a = f(*a)),
            Instr::Noise(_, p) | Instr::Grid(_, p) | Instr::Shape(_, p) | Instr::Flow(_, p) => {
                p.iter_mut().for_each(|a| *a = f(*a));
            }
            Instr::Fractal(_, p, further) => {
                p.iter_mut().chain(further.iter_mut().flatten()).for_each(|a| *a = f(*a));
            }
        }
    }
}
