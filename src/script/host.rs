//! What native functions share while a script runs: the graph that it builds, the parameters that
//! it asked for, what it printed.

use super::fault::{Fault, Outcome};
use crate::diag::Place;
use crate::expr::{Graph, Input, Node, NodeId};
use crate::num::Number;
use crate::op::Op;
use crate::scene::Param;
use crate::tape::{Evaluator, Tape};
use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use std::time::Instant;

/// State of one run, shared by all native functions.
pub struct Host {
    /// The expressions.
    pub graph: RefCell<Graph>,
    /// Parameters, in the order in which the script asked for them.
    pub params: RefCell<Vec<Param>>,
    /// Values that the user sets.
    pub set: BTreeMap<String, f64>,
    /// What `print` and `debug` said.
    pub output: RefCell<Vec<String>>,
    /// Animation time in seconds.
    pub time: f64,
    /// When to stop.
    pub deadline: Cell<Option<Instant>>,
    tapes: RefCell<HashMap<NodeId, Arc<Tape>>>,
}

impl Host {
    /// An empty graph of at most `nodes` nodes.
    pub fn new(nodes: usize, set: BTreeMap<String, f64>, time: f64) -> Self {
        Host {
            graph: RefCell::new(Graph::with_limit(nodes)),
            params: RefCell::default(),
            set,
            output: RefCell::default(),
            time,
            deadline: Cell::new(None),
            tapes: RefCell::default(),
        }
    }

    /// A number as a node.
    pub fn constant(&self, c: f64) -> Outcome<NodeId> {
        if c.is_nan() {
            return Err(not_a_number("a constant of the expression"));
        }
        Ok(self.graph.borrow_mut().constant(c)?)
    }

    /// A variable.
    pub fn input(&self, input: Input) -> Outcome<NodeId> {
        Ok(self.graph.borrow_mut().input(input)?)
    }

    /// The point.
    pub fn point(&self) -> Outcome<[NodeId; 3]> {
        Ok(self.graph.borrow_mut().point()?)
    }

    /// An operation on nodes.
    pub fn op(&self, op: Op, args: &[NodeId]) -> Outcome<NodeId> {
        let mut graph = self.graph.borrow_mut();
        let node = graph.op(op, args)?;
        match graph.as_const(node) {
            Some(c) if c.is_nan() => Err(not_a_number(&format!("`{}` of these constants", op.name()))),
            _ => Ok(node),
        }
    }

    /// An expression with inputs replaced.
    pub fn substitute(&self, root: NodeId, with: &[(Input, NodeId)]) -> Outcome<NodeId> {
        let mut graph = self.graph.borrow_mut();
        let node = graph.substitute(root, with)?;
        match graph.as_const(node) {
            Some(c) if c.is_nan() => Err(not_a_number("the expression at that place")),
            _ => Ok(node),
        }
    }

    /// Records where a node was made.
    pub fn set_place(&self, node: NodeId, place: &Place) {
        self.graph.borrow_mut().set_place(node, place);
    }

    /// The value of an expression at a point, or its enclosure over a box, by the kind of number.
    pub fn eval<T: Number>(&self, node: NodeId, at: &[T; 3]) -> Outcome<T> {
        Ok(Evaluator::<T>::new(self.tape(node)?).eval(at).clone())
    }

    fn tape(&self, node: NodeId) -> Outcome<Arc<Tape>> {
        if let Some(tape) = self.tapes.borrow().get(&node) {
            return Ok(tape.clone());
        }
        let time = self.constant(self.time)?;
        let still = self.substitute(node, &[(Input::Time, time)])?;
        let tape = Arc::new(Tape::new(&self.graph.borrow(), &[still]));
        let mut tapes = self.tapes.borrow_mut();
        if tapes.len() >= 64 {
            tapes.clear();
        }
        tapes.insert(node, tape.clone());
        Ok(tape)
    }

    /// Whether an expression reads an input.
    pub fn depends_on(&self, node: NodeId, inputs: &[Input]) -> bool {
        let graph = self.graph.borrow();
        let reads = |id: &NodeId| matches!(graph.node(*id), Node::Input(input) if inputs.contains(input));
        graph.reachable(&[node]).iter().any(reads)
    }
}

/// Something is not a number.
pub fn not_a_number(what: &str) -> Fault {
    Fault::new(format!("{what} is not a number"))
        .hint("it comes from something like 0.0 / 0.0 or the square root of a negative number")
}
