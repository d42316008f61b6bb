//! Beams: rays of one origin that keep together.

use super::march::Piece;
use crate::cast::Ray;
use crate::num::{Parabola, Parabolas};
use glam::DVec3;

/// Planes across the rays of a group, in which a place is `origin + depth (axis + x u + y v)`. Depths
/// are the same for all beams of the group, so that a beam starts where the one that it is a part of
/// ended.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub origin: DVec3,
    axis: DVec3,
    across: [DVec3; 2],
}

impl Frame {
    /// The frame of rays that have one origin and keep within about 50 degrees of one another.
    pub(super) fn new(rays: &[Ray]) -> Option<Frame> {
        let first = rays.first()?;
        if rays.len() < 2 || rays.iter().any(|r| r.origin != first.origin) {
            return None;
        }
        let axis = rays.iter().map(|r| r.direction).sum::<DVec3>().try_normalize()?;
        if rays.iter().any(|r| r.direction.dot(axis) < 0.9) {
            return None;
        }
        let u = axis.any_orthonormal_vector();
        Some(Frame { origin: first.origin, axis, across: [u, axis.cross(u)] })
    }

    /// Distance along a ray for each unit of depth.
    pub(super) fn stretch(&self, ray: &Ray) -> f64 {
        1.0 / ray.direction.dot(self.axis)
    }

    /// Where a ray meets the plane one unit deep.
    pub(super) fn place(&self, ray: &Ray) -> [f64; 2] {
        let q = ray.direction * self.stretch(ray);
        self.across.map(|a| q.dot(a))
    }
}

/// The part of a frame that some rays go through: a rectangle one unit deep.
#[derive(Clone, Copy, Debug)]
pub(super) struct Section {
    pub centre: [f64; 2],
    /// Half the sides.
    pub extent: [f64; 2],
}

impl Section {
    /// The section around rays.
    pub(super) fn around(frame: &Frame, rays: &[Ray]) -> Section {
        let (mut lo, mut hi) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for ray in rays.iter().filter(|r| r.near <= r.far) {
            let place = frame.place(ray);
            for k in 0..2 {
                (lo[k], hi[k]) = (lo[k].min(place[k]), hi[k].max(place[k]));
            }
        }
        let centre = [0, 1].map(|k| 0.5 * (lo[k] + hi[k]));
        // Places are known to a few roundings of directions, which are of size one.
        let extent = [0, 1].map(|k| 0.5 * (hi[k] - lo[k]) * (1.0 + 1e-12) + 16.0 * f64::EPSILON);
        Section { centre, extent }
    }

    /// Half the diagonal at a depth.
    pub(super) fn radius(&self, depth: f64) -> f64 {
        depth * libm::hypot(self.extent[0], self.extent[1])
    }

    /// Sets a lane of the coordinates to a piece of the beam.
    pub(super) fn ask<const B: usize>(
        &self,
        frame: &Frame,
        piece: Piece,
        p: &mut [Parabolas<B, 2>; 3],
        lane: usize,
    ) {
        let [x, y] = self.centre;
        let middle = frame.axis + x * frame.across[0] + y * frame.across[1];
        let Piece { mid, half } = piece;
        let at = frame.origin + mid * middle;
        let end = (mid.abs() + half) * (middle.abs().max_element() + self.extent[0] + self.extent[1]);
        let blur = 8.0 * f64::EPSILON * (frame.origin.abs().max_element() + end);
        for axis in 0..3 {
            let sides = [0, 1].map(|k| self.extent[k] * frame.across[k][axis]);
            let spread = half * (sides[0].abs() + sides[1].abs());
            let sides = sides.map(|s| mid * s);
            p[axis].set(lane, &Parabola::coordinate(at[axis], half * middle[axis], sides, spread, blur));
        }
    }
}
