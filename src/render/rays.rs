//! Rays: where they begin and end within the bounds, and how precisely they are cast.

use super::Prepared;
use super::surface::Patch;
use crate::cast::{Ray, Tolerance};
use crate::scene::Aabb;
use glam::DVec3;

/// The piece of a line of sight that lies within `bounds`, and not nearer than the tolerance.
pub(super) fn piece((origin, direction): (DVec3, DVec3), bounds: &Aabb, tolerance: Tolerance) -> Option<Ray> {
    let (enter, far) = bounds.clip(origin, direction)?;
    let near = enter.max(tolerance.least);
    (near < far).then_some(Ray { origin, direction, near, far, tolerance })
}

impl Prepared {
    /// The line of sight through a place in the picture, given in pixels, as far as it lies within the bounds; through the
    /// middle of a lens.
    pub fn sight(&self, x: f64, y: f64) -> Option<Ray> {
        piece(self.view.ray(x, y, [0.5, 0.5]), &self.settings.bounds, self.tolerance)
    }

    /// Tolerance of rays that begin at a point of the solid.
    fn tolerance_from(&self, p: DVec3) -> f64 {
        self.tolerance.at(p.distance(self.view.eye))
    }

    /// A point a few tolerances above a patch, or below, on a `side` of 1 or -1, where rays begin that are not to meet it.
    pub(super) fn lifted(&self, patch: &Patch, side: f64) -> DVec3 {
        let rounding = 64.0 * f64::EPSILON * patch.position.abs().max_element();
        patch.position + side * (4.0 * self.tolerance_from(patch.position) + rounding) * patch.normal
    }

    /// A ray from a point onwards, so far or as far as the bounds go.
    pub(super) fn onward_ray(&self, origin: DVec3, direction: DVec3, distance: f64) -> Option<Ray> {
        // What begins on a face of the bounds may begin outside, where nothing is promised.
        let (enter, leave) = self.settings.bounds.clip(origin, direction)?;
        let (near, far) = (enter.max(0.0), leave.min(distance));
        let tolerance = Tolerance::fixed(self.tolerance_from(origin));
        (near < far).then_some(Ray { origin, direction, near, far, tolerance })
    }

    /// Whether the ground throws shadows into the air.
    pub(super) fn has_shafts(&self) -> bool {
        self.sky.air.is_some_and(|air| air.shafts)
    }
}
