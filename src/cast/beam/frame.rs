//! Where the rays of a beam go: planes across them, and the part of these that they fill.

use super::march::Piece;
use crate::cast::Ray;
use crate::num::Parabola;
use glam::DVec3;

/// More than the relative rounding of depths and places.
const HAIR: f64 = 64.0 * f64::EPSILON;

/// Whether there is anything of a ray.
pub(super) fn is_real(ray: &Ray) -> bool {
    ray.near <= ray.far
}

/// Planes across the rays of a group. A place in the plane at a depth `z` is
///
/// ```text
/// origin + z axis + s (x u + y v),     s = z for rays from one origin, 1 for parallel ones
/// ```
///
/// Rays may also run towards their origin, at depths below zero, as they do to the centre of a planet.
///
/// Depths are the same for all beams of the group, so that a beam starts where the one that it is a
/// part of ended.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    origin: DVec3,
    axis: DVec3,
    across: [DVec3; 2],
    is_parallel: bool,
    /// Size of the numbers that depths and places are computed from, in units of them.
    size: f64,
}

impl Frame {
    /// The frame of those rays of which there is anything, the first of all among them, if they have
    /// one origin and keep within about 50 degrees of one another, or are parallel.
    pub(super) fn new(rays: &[Ray]) -> Option<Frame> {
        let &Ray { origin, direction, .. } = rays.first()?;
        let real = || rays.iter().filter(|r| is_real(r));
        let is_parallel = real().all(|r| r.direction == direction);
        if rays.len() < 2 || !(is_parallel || real().all(|r| r.origin == origin)) {
            return None;
        }
        let axis = real().map(|r| r.direction).sum::<DVec3>().try_normalize()?;
        let axis = if is_parallel { direction } else { axis };
        if real().any(|r| r.direction.dot(axis) < 0.9) {
            return None;
        }
        let u = axis.any_orthonormal_vector();
        let far = real().map(|r| r.origin.abs().max_element()).fold(0.0, f64::max);
        let size = if is_parallel { 4.0 * far } else { 1.0 };
        Some(Frame { origin, axis, across: [u, axis.cross(u)], is_parallel, size })
    }

    /// Distance along a ray for each unit of depth, and by how much distances begin later.
    fn line(&self, ray: &Ray) -> [f64; 2] {
        if self.is_parallel {
            [1.0, (ray.origin - self.origin).dot(self.axis)]
        } else {
            [1.0 / ray.direction.dot(self.axis), 0.0]
        }
    }

    /// The depth that a ray has reached at `t`.
    pub(super) fn depth(&self, ray: &Ray, t: f64) -> f64 {
        let [stretch, later] = self.line(ray);
        (t + later) / stretch
    }

    /// The distance along a ray of a depth.
    pub(super) fn distance(&self, ray: &Ray, depth: f64) -> f64 {
        let [stretch, later] = self.line(ray);
        depth * stretch - later
    }

    /// More than the rounding of a depth or a distance of this size.
    pub(super) fn hair(&self, depth: f64) -> f64 {
        HAIR * (depth.abs() + if self.is_parallel { self.size } else { 0.0 })
    }

    /// Where a ray meets the plane one unit deep.
    pub(super) fn place(&self, ray: &Ray) -> [f64; 2] {
        let q = if self.is_parallel {
            ray.origin - self.origin
        } else {
            ray.direction / ray.direction.dot(self.axis)
        };
        self.across.map(|a| q.dot(a))
    }
}

/// The part of a frame that some rays go through: a rectangle one unit deep.
#[derive(Clone, Copy, Debug)]
pub(super) struct Section {
    pub centre: [f64; 2],
    /// Half the sides.
    pub extent: [f64; 2],
    /// Half the diagonal.
    radius: f64,
    /// Depths from where the first ray begins to where the last one ends.
    pub depth: [f64; 2],
}

impl Section {
    /// The section around those rays of which there is anything.
    pub(super) fn around(frame: &Frame, rays: &[Ray]) -> Section {
        const NONE: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];
        let (mut x, mut y, mut depth) = (NONE, NONE, NONE);
        let include = |all: &mut [f64; 2], from: f64, to: f64| *all = [all[0].min(from), all[1].max(to)];
        for ray in rays.iter().filter(|r| is_real(r)) {
            let [u, v] = frame.place(ray);
            include(&mut x, u, u);
            include(&mut y, v, v);
            include(&mut depth, frame.depth(ray, ray.near), frame.depth(ray, ray.far));
        }
        let centre = [x, y].map(|[lo, hi]| 0.5 * (lo + hi));
        // Places are known to a few roundings of the numbers that they come from.
        let extent =
            [x, y].map(|[lo, hi]| 0.5 * (hi - lo) * (1.0 + 1e-12) + 16.0 * f64::EPSILON * frame.size);
        let depth = [depth[0] - frame.hair(depth[0]), depth[1] + frame.hair(depth[1])];
        Section { centre, extent, radius: libm::hypot(extent[0], extent[1]), depth }
    }

    /// Half the diagonal at a depth.
    pub(super) fn radius(&self, frame: &Frame, depth: f64) -> f64 {
        if frame.is_parallel { self.radius } else { depth.abs() * self.radius }
    }

    /// A place in units of the extent, from the centre.
    pub(super) fn relative(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [(x - self.centre[0]) / self.extent[0], (y - self.centre[1]) / self.extent[1]]
    }

    /// A place and how far, at most, a piece of the beam reaches from it along any axis.
    pub(super) fn around_piece(&self, frame: &Frame, piece: Piece) -> ([f64; 3], f64) {
        let Piece { mid, half } = piece;
        let (start, slope) = self.spine(frame);
        let at = start + mid * slope;
        let reach = half * slope.length() + self.radius(frame, mid.abs() + half);
        (at.to_array(), reach + frame.hair(mid) + HAIR * (at.abs().max_element() + reach))
    }

    /// The line through the middle of the section: where it starts, and what it gains with depth.
    fn spine(&self, frame: &Frame) -> (DVec3, DVec3) {
        let [x, y] = self.centre;
        let aside = x * frame.across[0] + y * frame.across[1];
        if frame.is_parallel {
            (frame.origin + aside, frame.axis)
        } else {
            (frame.origin, frame.axis + aside)
        }
    }

    /// The coordinates of a piece of the beam.
    pub(super) fn coordinates(&self, frame: &Frame, piece: Piece) -> [Parabola<2>; 3] {
        let Piece { mid, half } = piece;
        let (start, slope) = self.spine(frame);
        // The planes grow with depth, by half the piece.
        let (scale, widening) = if frame.is_parallel { (1.0, 0.0) } else { (mid, half) };
        let at = start + mid * slope;
        let reach = self.extent[0] + self.extent[1];
        let end = (mid.abs() + half) * (slope.abs().max_element() + reach) + reach;
        let blur = 8.0 * f64::EPSILON * (frame.origin.abs().max_element() + start.abs().max_element() + end);
        [0, 1, 2].map(|axis| {
            let sides = [0, 1].map(|k| self.extent[k] * frame.across[k][axis]);
            let spread = widening * (sides[0].abs() + sides[1].abs());
            let sides = sides.map(|s| scale * s);
            Parabola::coordinate(at[axis], half * slope[axis], sides, spread, blur)
        })
    }
}
