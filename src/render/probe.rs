//! A quick look at a field before it is rendered: [`Glance`], and what is within the picture of it.

use super::{RenderError, View};
use crate::diag::{Diagnostic, Place};
use crate::field::Glance;
use crate::scene::Aabb;
use crate::tape::{Evaluator, Tape};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// What samples of a field say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Probe {
    /// Points that were tried, where the field is not a finite number, and inside the solid.
    pub glance: Glance,
    /// Points inside the solid that are not within the picture.
    pub outside_picture: u64,
    /// Whether the camera is inside the solid.
    pub camera_inside: bool,
}

impl Probe {
    /// Samples the first output of `tape` within `bounds`, and at the eye; `None` if that was cancelled.
    pub(super) fn new(tape: &Arc<Tape>, bounds: &Aabb, view: &View, cancel: &AtomicBool) -> Option<Probe> {
        let mut outside_picture = 0;
        let halt = || cancel.load(Ordering::Relaxed);
        let glance = Glance::new(tape, bounds, &halt, |p| outside_picture += u64::from(!view.shows(p)))?;
        let eye = view.eye;
        let at_eye = *Evaluator::<f64>::new(tape.clone()).eval(&eye.to_array());
        let in_bounds = eye.cmpge(bounds.min).all() && eye.cmple(bounds.max).all();
        Some(Probe { glance, outside_picture, camera_inside: in_bounds && at_eye < 0.0 })
    }

    /// Warnings about what was found.
    ///
    /// # Errors
    /// [`RenderError::Undefined`] if the field has no value anywhere.
    pub(super) fn judge(&self, place: Option<Place>) -> Result<Vec<Diagnostic>, RenderError> {
        if self.glance.is_undefined() {
            return Err(RenderError::Undefined { place });
        }
        let mut warnings = Vec::from_iter(self.glance.gaps(place.clone()));
        if self.camera_inside {
            let warning = Diagnostic::warning("the camera is inside the solid").at(place);
            warnings
                .push(warning.hint("move the camera away from the solid, or check the sign of the field"));
        }
        Ok(warnings)
    }
}
