//! What native functions share while a script runs: the graph that it builds, the parameters that
//! it asked for, what it printed.

use super::engine::{Limits, Stop};
use super::fault::{Fault, Outcome};
use crate::diag::{Diagnostic, Place};
use crate::expr::{Graph, Input, Node, NodeId};
use crate::num::Number;
use crate::op::Op;
use crate::scene::{Param, Value};
use crate::tape::{Evaluator, Tape};
use crate::world::store::Store;
use rhai::{Dynamic, EvalAltResult, Position};
use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// State of one run, shared by all native functions.
pub struct Host {
    /// The expressions.
    pub graph: RefCell<Graph>,
    /// Parameters, in the order in which the script asked for them.
    pub params: RefCell<Vec<Param>>,
    /// Defaults that were given to parameters before they were made.
    pub presets: RefCell<BTreeMap<String, Preset>>,
    /// Values that the user sets.
    pub set: BTreeMap<String, Value>,
    /// Whether the script has to ask for all of them.
    pub strict: bool,
    /// What `print` and `debug` said.
    pub output: RefCell<Vec<String>>,
    /// What was made, but is hardly meant.
    pub odd: RefCell<Vec<Diagnostic>>,
    /// Animation time in seconds.
    pub time: f64,
    /// When to stop.
    pub deadline: Cell<Option<Instant>>,
    /// Stops the run when set.
    pub cancel: Option<Arc<AtomicBool>>,
    /// Where grids are kept that took long.
    pub store: Option<Store>,
    /// Samples that grids may still have.
    samples: Cell<usize>,
    /// Samples that all grids together may have.
    most_samples: usize,
    tapes: RefCell<HashMap<NodeId, Arc<Tape>>>,
}

/// A default that a parameter has wherever it is made.
pub struct Preset {
    /// The default.
    pub value: Value,
    /// Where the script says it.
    pub place: Option<Place>,
}

impl Host {
    /// An empty graph, and what limits there are.
    pub fn new(limits: &Limits, set: BTreeMap<String, Value>, time: f64) -> Self {
        Host {
            graph: RefCell::new(Graph::with_limit(limits.nodes)),
            params: RefCell::default(),
            presets: RefCell::default(),
            set,
            strict: true,
            output: RefCell::default(),
            odd: RefCell::default(),
            time,
            deadline: Cell::new(None),
            cancel: None,
            store: None,
            samples: Cell::new(limits.samples),
            most_samples: limits.samples,
            tapes: RefCell::default(),
        }
    }

    /// A question for long jobs on any thread: whether the run is to stop.
    pub fn halt(&self) -> impl Fn() -> bool + Sync + use<> {
        let (cancel, deadline) = (self.cancel.clone(), self.deadline.get());
        move || {
            let cancelled = cancel.as_ref().is_some_and(|c| c.load(Ordering::Relaxed));
            cancelled || deadline.is_some_and(|deadline| Instant::now() > deadline)
        }
    }

    /// What a native function came to, unless the run is to stop, which no script may catch: after a
    /// fault, since jobs fail when they are stopped, and after a call that itself took long.
    pub fn unless_stopped(
        &self,
        name: &str,
        start: Instant,
        result: Outcome<Dynamic>,
    ) -> Result<Dynamic, Box<EvalAltResult>> {
        const LONG: Duration = Duration::from_secs(1);
        let result = match result {
            Ok(value) if start.elapsed() < LONG => return Ok(value),
            other => other,
        };
        if !self.halt()() {
            return result.map_err(Box::from);
        }
        let cancelled = self.cancel.as_ref().is_some_and(|c| c.load(Ordering::Relaxed));
        let stop = if cancelled { Stop::Cancelled } else { Stop::Overran(Rc::from(name)) };
        Err(Box::new(EvalAltResult::ErrorTerminated(Dynamic::from(stop), Position::NONE)))
    }

    /// Notes something that is hardly meant, once.
    pub fn doubt(&self, doubt: Diagnostic) {
        let mut odd = self.odd.borrow_mut();
        if !odd.contains(&doubt) {
            odd.push(doubt);
        }
    }

    /// Samples that grids may still have.
    pub fn samples_left(&self) -> usize {
        self.samples.get()
    }

    /// Takes room for the samples of a grid.
    pub fn take_samples(&self, count: usize) -> Outcome<()> {
        let Some(left) = self.samples.get().checked_sub(count) else {
            let most = self.most_samples;
            return Err(Fault::new(format!(
                "the grids of the script have more than {most} samples together"
            ))
            .hint("choose a smaller `size`: a picture shows no more samples than it has pixels"));
        };
        self.samples.set(left);
        Ok(())
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

    /// Records where a node was made: the first place, but rather one of the user's than one of the standard library.
    pub fn set_place(&self, node: NodeId, place: &Place) {
        let mut graph = self.graph.borrow_mut();
        if graph.place(node).is_some_and(|known| is_better(place, known)) {
            graph.move_place(node, place);
        } else {
            graph.set_place(node, place);
        }
    }

    /// Records where all nodes were made that have come since there were so many, unless that is known.
    pub fn set_places(&self, before: usize, place: &Place) {
        let mut graph = self.graph.borrow_mut();
        graph.since(before).for_each(|node| graph.set_place(node, place));
    }

    /// The value of an expression at a point, or its enclosure over a box, by the kind of number.
    pub fn eval<T: Number>(&self, node: NodeId, at: &[T; 3]) -> Outcome<T> {
        Ok(Evaluator::<T>::new(self.tape(node)?).eval(at).clone())
    }

    /// What an expression that does not depend on the place is at the time of the run; nothing if it does.
    pub fn now(&self, node: NodeId) -> Outcome<Option<f64>> {
        if self.places(node).is_empty() { self.eval(node, &[0.0; 3]).map(Some) } else { Ok(None) }
    }

    /// An expression as a function, with memory of its own: a clone for each thread.
    pub fn sampler(
        &self,
        node: NodeId,
    ) -> Outcome<impl FnMut([f64; 3]) -> f64 + Clone + Send + Sync + use<>> {
        let mut evaluator = Evaluator::<f64>::new(self.tape(node)?);
        Ok(move |p: [f64; 3]| *evaluator.eval(&p))
    }

    /// The code of an expression at the time of the run.
    pub fn tape(&self, node: NodeId) -> Outcome<Arc<Tape>> {
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

    /// The names of what an expression depends on, other than the time.
    pub fn places(&self, node: NodeId) -> Vec<&'static str> {
        let inputs = [(Input::X, "x"), (Input::Y, "y"), (Input::Z, "z"), (Input::Footprint, "footprint")];
        inputs
            .into_iter()
            .filter(|(input, _)| self.depends_on(node, &[*input]))
            .map(|(_, name)| name)
            .collect()
    }

    /// Whether an expression reads an input.
    pub fn depends_on(&self, node: NodeId, inputs: &[Input]) -> bool {
        let graph = self.graph.borrow();
        let reads = |id: &NodeId| matches!(graph.node(*id), Node::Input(input) if inputs.contains(input));
        graph.reachable(&[node]).iter().any(reads)
    }
}

/// Whether a place says more to the user than another.
pub fn is_better(place: &Place, than: &Place) -> bool {
    than.is_embedded() && !place.is_embedded()
}

/// Something is not a number.
pub fn not_a_number(what: &str) -> Fault {
    Fault::new(format!("{what} is not a number"))
        .hint("it comes from something like 0.0 / 0.0 or the square root of a negative number")
}
