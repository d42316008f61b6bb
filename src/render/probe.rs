//! A quick look at a field before it is rendered.
//!
//! A few thousand samples cannot prove anything, but they find the mistakes that people make: a
//! field that has no value, a solid that is not there, a camera inside of it.

use super::{RenderError, View};
use crate::diag::{Diagnostic, Place};
use crate::num::Many;
use crate::scene::Aabb;
use crate::tape::{Evaluator, Tape};
use glam::DVec3;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Samples along an axis. Odd, so that the middle is tried; 4913 points in all.
const SIDE: usize = 17;

/// Points evaluated together, and those between two looks at whether to go on.
const LANES: usize = 32;
const PIECE: usize = 16 * LANES;

/// What samples of a field say.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Probe {
    /// Points that were tried.
    pub points: u64,
    /// Points where the field is not a finite number.
    pub undefined: u64,
    /// Points inside the solid.
    pub inside: u64,
    /// Of these, those that are not within the picture.
    pub outside_picture: u64,
    /// Whether the camera is inside the solid.
    pub camera_inside: bool,
}

impl Probe {
    /// Samples the first output of `tape` within `bounds`, and at the eye; `None` if that was cancelled.
    pub(super) fn new(tape: &Arc<Tape>, bounds: &Aabb, view: &View, cancel: &AtomicBool) -> Option<Probe> {
        let mut field = Evaluator::<Many<f64, LANES>>::new(tape.clone());
        let mut probe =
            Probe { points: 0, undefined: 0, inside: 0, outside_picture: 0, camera_inside: false };
        // Cells' centres, a little off the symmetry that scenes have and their poles lie on.
        let place = |axis: usize, i: usize| {
            let t = (i as f64 + 0.5) / SIDE as f64;
            bounds.min[axis] + (t + 1e-4 * (t - 0.37)) * (bounds.max[axis] - bounds.min[axis])
        };
        let order = |i: usize| [i % SIDE, i / SIDE % SIDE, i / (SIDE * SIDE)];
        let all = SIDE * SIDE * SIDE;
        for first in (0..all).step_by(PIECE) {
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            let points = first..all.min(first + PIECE);
            let at =
                [0, 1, 2].map(|axis| points.clone().map(|i| place(axis, order(i)[axis])).collect::<Vec<_>>());
            let mut values = vec![0.0; points.len()];
            field.eval_all(at.each_ref().map(Vec::as_slice), &mut values);
            for (value, i) in values.into_iter().zip(points) {
                probe.points += 1;
                probe.undefined += u64::from(!value.is_finite());
                if value < 0.0 {
                    let p = DVec3::from_array([0, 1, 2].map(|axis| place(axis, order(i)[axis])));
                    probe.inside += 1;
                    probe.outside_picture += u64::from(!view.shows(p));
                }
            }
        }
        let eye = view.eye;
        let at_eye = field.eval(&eye.to_array().map(|c| Many([c; LANES]))).0[0];
        let in_bounds = eye.cmpge(bounds.min).all() && eye.cmple(bounds.max).all();
        probe.camera_inside = in_bounds && at_eye < 0.0;
        Some(probe)
    }

    /// Warnings about what was found.
    ///
    /// # Errors
    /// [`RenderError::Undefined`] if the field has no value anywhere.
    pub(super) fn judge(&self, place: Option<Place>) -> Result<Vec<Diagnostic>, RenderError> {
        let mut warnings = Vec::new();
        if self.undefined == self.points {
            return Err(RenderError::Undefined { place });
        }
        if self.undefined > 0 {
            let percent = 100.0 * self.undefined as f64 / self.points as f64;
            let message =
                format!("the field is undefined (NaN or infinite) in about {percent:.1}% of its bounds");
            let warning = Diagnostic::warning(message).at(place.clone());
            warnings.push(warning.hint("guard divisions, square roots and logarithms with max or abs"));
        }
        if self.camera_inside {
            let warning = Diagnostic::warning("the camera is inside the solid").at(place);
            warnings
                .push(warning.hint("move the camera away from the solid, or check the sign of the field"));
        }
        Ok(warnings)
    }
}
