//! A quick look at a field.
//!
//! A few thousand samples cannot prove anything, but they find the mistakes that people make: a field that has no value,
//! a solid that is not there.

use super::Halt;
use crate::diag::{Diagnostic, Place};
use crate::num::Many;
use crate::scene::Aabb;
use crate::tape::{Evaluator, Tape};
use glam::DVec3;
use std::sync::Arc;

/// Samples along an axis. Odd, so that the middle is tried; 4913 points in all.
const SIDE: usize = 17;

/// Points evaluated together, and those between two looks at whether to go on.
const LANES: usize = 32;
const PIECE: usize = 16 * LANES;

/// What samples of a field in a box say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Glance {
    /// Points that were tried.
    pub points: u64,
    /// Points where the field is not a finite number.
    pub undefined: u64,
    /// Points inside the solid.
    pub inside: u64,
}

impl Glance {
    /// Samples the first output of `tape`, and tells of the points inside; `None` if that was halted.
    pub fn new(
        tape: &Arc<Tape>,
        bounds: &Aabb,
        halt: Halt<'_>,
        mut see: impl FnMut(DVec3),
    ) -> Option<Glance> {
        let mut field = Evaluator::<Many<f64, LANES>>::new(tape.clone());
        let mut glance = Glance::default();
        // Cells' centres, a little off the symmetry that scenes have and their poles lie on.
        let place = |axis: usize, i: usize| {
            let t = (i as f64 + 0.5) / SIDE as f64;
            bounds.min[axis] + (t + 1e-4 * (t - 0.37)) * (bounds.max[axis] - bounds.min[axis])
        };
        let order = |i: usize| [i % SIDE, i / SIDE % SIDE, i / (SIDE * SIDE)];
        let all = SIDE * SIDE * SIDE;
        for first in (0..all).step_by(PIECE) {
            if halt() {
                return None;
            }
            let points = first..all.min(first + PIECE);
            let at =
                [0, 1, 2].map(|axis| points.clone().map(|i| place(axis, order(i)[axis])).collect::<Vec<_>>());
            let mut values = vec![0.0; points.len()];
            field.eval_all(at.each_ref().map(Vec::as_slice), &mut values);
            for (value, i) in values.into_iter().zip(points) {
                glance.points += 1;
                glance.undefined += u64::from(!value.is_finite());
                if value < 0.0 {
                    glance.inside += 1;
                    see(DVec3::from_array([0, 1, 2].map(|axis| place(axis, order(i)[axis]))));
                }
            }
        }
        Some(glance)
    }

    /// Whether the field has no value anywhere.
    pub fn is_undefined(&self) -> bool {
        self.undefined == self.points
    }

    /// A warning about where the field has no value, if there is any of that.
    pub fn gaps(&self, place: Option<Place>) -> Option<Diagnostic> {
        let percent = 100.0 * self.undefined as f64 / self.points as f64;
        let message =
            format!("the field is undefined (NaN or infinite) in about {percent:.1}% of its bounds");
        let hint = "guard divisions, square roots and logarithms with max or abs";
        (self.undefined > 0).then(|| Diagnostic::warning(message).at(place).hint(hint))
    }
}
