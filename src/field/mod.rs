//! What others ask of a field: value, derivatives, and certified bounds over a region.
//!
//! A [`Field`] owns a tape and answers with whichever kind of number fits the question. Bounds over
//! a box come from enclosures, never from guesses: the Lipschitz bound of a region is the largest
//! gradient norm that [`Slope`] arithmetic admits there, made tighter by cutting the region up.

mod beyond;
mod glance;
mod line;
mod moments;
mod region;
mod smooth;
mod terms;
mod watch;

pub use beyond::{Around, FAR, around};
pub use glance::Glance;
pub use line::{Unknown, first_inside};
pub use moments::{Moments, Survey, survey};
pub use region::{Extent, Halt, extent, extent_until, lipschitz_outside, lipschitz_until, part_within};
pub use smooth::{blame, smooth};
pub use terms::{Steepness, Terms};
pub use watch::{Stopped, Watch};

use crate::expr::{Graph, NodeId};
use crate::num::{Class, Dual, Interval, Jet, Slope};
use crate::tape::{Evaluator, Tape};
use glam::DVec3;
use std::sync::Arc;

/// An expression with the memory to evaluate it; cheap to clone, one per thread.
#[derive(Clone, Debug)]
pub struct Field {
    points: Evaluator<f64>,
    duals: Evaluator<Dual>,
    jets: Evaluator<Jet>,
    ranges: Evaluator<Interval>,
    slopes: Evaluator<Slope>,
}

impl Field {
    /// The field of an expression of the coordinates.
    pub fn new(graph: &Graph, root: NodeId) -> Self {
        Field::of_tape(&Arc::new(Tape::new(graph, &[root])))
    }

    /// The first output of a tape.
    pub fn of_tape(tape: &Arc<Tape>) -> Self {
        Field {
            points: Evaluator::new(tape.clone()),
            duals: Evaluator::new(tape.clone()),
            jets: Evaluator::new(tape.clone()),
            ranges: Evaluator::new(tape.clone()),
            slopes: Evaluator::new(tape.clone()),
        }
    }

    /// The code.
    pub fn tape(&self) -> &Arc<Tape> {
        self.points.tape()
    }

    /// Continuity class.
    pub fn class(&self) -> Class {
        self.tape().class()
    }

    /// Value at a point.
    pub fn value(&mut self, p: DVec3) -> f64 {
        *self.points.eval(&p.to_array())
    }

    /// Value and gradient at a point.
    pub fn gradient(&mut self, p: DVec3) -> (f64, DVec3) {
        let p = p.to_array();
        let dual = self.duals.eval(&std::array::from_fn(|axis| Dual::coordinate(p[axis], axis)));
        (dual.value, DVec3::from_array(dual.grad))
    }

    /// Value, gradient and Hessian at a point.
    pub fn jet(&mut self, p: DVec3) -> Jet {
        let p = p.to_array();
        *self.jets.eval(&std::array::from_fn(|axis| Jet::coordinate(p[axis], axis)))
    }

    /// Enclosure of the values over a box.
    pub fn range(&mut self, region: &[Interval; 3]) -> Interval {
        *self.ranges.eval(region)
    }

    /// Enclosure of values, gradients and gradient norms over a box.
    pub fn slope(&mut self, region: &[Interval; 3]) -> Slope {
        *self.slopes.eval(&std::array::from_fn(|axis| Slope::coordinate(region[axis], axis)))
    }

    /// Enclosure of value, gradient and Hessian over a box.
    pub fn jet_range(&self, region: &[Interval; 3]) -> Jet<Interval> {
        let mut jets = Evaluator::<Jet<Interval>>::new(self.tape().clone());
        *jets.eval(&std::array::from_fn(|axis| Jet::coordinate(region[axis], axis)))
    }

    /// Bound on `|f(a) - f(b)| / |a - b|` over a box; infinite where there is none.
    pub fn lipschitz(&mut self, region: &[Interval; 3]) -> f64 {
        self.slope(region).norm
    }
}
