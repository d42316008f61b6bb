//! Where the rays of a beam go: planes across them, and the part of these that they fill.

use super::march::Piece;
use crate::cast::Ray;
use crate::num::{Interval, Parabola};
use crate::scene::Aabb;
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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    origin: DVec3,
    axis: DVec3,
    across: [DVec3; 2],
    is_parallel: bool,
    /// Size of the numbers that depths and places are computed from, in units of them.
    size: f64,
    /// Depths between which there is anything of the lines.
    range: [f64; 2],
}

/// In front of the origin.
const AHEAD: [f64; 2] = [0.0, f64::INFINITY];

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
        Some(Frame { origin, axis, across: [u, axis.cross(u)], is_parallel, size, range: AHEAD })
    }

    /// The frame of all lines that start at one point; the three unit vectors are at right angles.
    pub fn from_point(origin: DVec3, axis: DVec3, across: [DVec3; 2]) -> Frame {
        Frame { origin, axis, across, is_parallel: false, size: 1.0, range: AHEAD }
    }

    /// The frame of parallel lines that start at most `reach` away from a point, on any axis.
    pub fn parallel(origin: DVec3, axis: DVec3, across: [DVec3; 2], reach: f64) -> Frame {
        let size = 4.0 * (origin.abs().max_element() + reach);
        Frame { origin, axis, across, is_parallel: true, size, range: AHEAD }
    }

    /// The same lines, of which there is something between two depths only; they may lie before the origin.
    pub fn between(self, range: [f64; 2]) -> Frame {
        Frame { range, ..self }
    }

    /// The depth from which on lines may meet something that meet nothing up to a depth `free` of another frame: of the
    /// same lines, with the same axis or the same origin, none of which is at more than `slant` units across for each
    /// unit of depth.
    ///
    /// By one axis depths differ by a number. From one origin a point at the distance `t` is at most `t` deep, and in a
    /// line so slanted at least `t / sqrt(1 + slant^2)`.
    pub(super) fn onward(&self, other: &Frame, free: f64, slant: f64) -> f64 {
        let from = if self.axis == other.axis {
            let later = (self.origin - other.origin).dot(self.axis);
            let size = self.origin.abs().max_element() + other.origin.abs().max_element();
            free - later - HAIR * size
        } else if self.origin == other.origin && !self.is_parallel {
            free.max(0.0) / (1.0 + slant * slant).sqrt()
        } else {
            self.range[0]
        };
        from - self.hair(from) - other.hair(free)
    }

    /// Depths between which some line through a rectangle of places may be in a region, as far as there is anything of the
    /// lines: those between its three pairs of faces, for an interval of lines.
    fn depths(&self, [x, y]: [Interval; 2], region: &Aabb) -> Option<[f64; 2]> {
        let all = region.intervals();
        let point = Interval::point;
        let deep = (0..3).map(|k| (all[k] - point(self.origin[k])) * point(self.axis[k]));
        let deep = deep.fold(point(0.0), |sum, part| sum + part);
        let mut within = Interval { lo: deep.lo.max(self.range[0]), hi: deep.hi.min(self.range[1]) };
        for axis in 0..3 {
            let at = |v: DVec3| point(v[axis]);
            let aside = at(self.across[0]) * x + at(self.across[1]) * y;
            let (start, slope) = if self.is_parallel {
                (at(self.origin) + aside, at(self.axis))
            } else {
                (at(self.origin), at(self.axis) + aside)
            };
            // Lines along both faces say nothing.
            if slope.contains(0.0) {
                continue;
            }
            let between = (all[axis] - start) / slope;
            within = Interval { lo: within.lo.max(between.lo), hi: within.hi.min(between.hi) };
        }
        let [near, far] = [within.lo - self.hair(within.lo), within.hi + self.hair(within.hi)];
        (near <= far).then_some([near, far])
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
    pub(in crate::cast) fn hair(&self, depth: f64) -> f64 {
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
pub(in crate::cast) struct Section {
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

    /// The section that a rectangle of places is, as deep as its lines are in a region; `None` if none is.
    pub(super) fn through(frame: &Frame, rectangle: [[f64; 2]; 2], region: &Aabb) -> Option<Section> {
        let centre = rectangle.map(|[lo, hi]| 0.5 * (lo + hi));
        let extent =
            rectangle.map(|[lo, hi]| 0.5 * (hi - lo) * (1.0 + 1e-12) + 16.0 * f64::EPSILON * frame.size);
        let [x, y] = [0, 1].map(|k| Interval::around(centre[k], extent[k]));
        let depth = frame.depths([x, y], region)?;
        Some(Section { centre, extent, radius: libm::hypot(extent[0], extent[1]), depth })
    }

    /// How far its lines go across at most, for each unit of depth.
    pub(super) fn slant(&self) -> f64 {
        libm::hypot(self.centre[0].abs() + self.extent[0], self.centre[1].abs() + self.extent[1])
    }

    /// Half the diagonal at a depth.
    pub(in crate::cast) fn radius(&self, frame: &Frame, depth: f64) -> f64 {
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

    /// How much depth, backwards and forwards, a ball around the middle of the section at a depth covers with all that
    /// is in the section; `None` if it does not cover the section there.
    pub(in crate::cast) fn covered(&self, frame: &Frame, depth: f64, ball: f64) -> Option<[f64; 2]> {
        let radius = self.radius(frame, depth);
        // A ball that is no number covers nothing.
        if ball.is_nan() || ball <= radius {
            return None;
        }
        let (grows, aside) = if frame.is_parallel {
            (0.0, 0.0)
        } else {
            (self.radius, libm::hypot(self.centre[0], self.centre[1]))
        };
        let slope = 1.0 + aside * aside;
        // The positive root of `a s^2 + b s = left`, without cancellation and a hair less.
        let left = (ball - radius) * (ball + radius);
        let root = |a: f64, b: f64| 2.0 * left / (b + (b * b + 4.0 * a * left).sqrt()) * (1.0 - 1e-12);
        // Backwards the section gets narrower, at depths above zero.
        let behind = root(slope, 2.0 * aside * radius).min(depth.max(0.0));
        let beyond = root(slope + grows * (2.0 * aside + grows), 2.0 * radius * (aside + grows));
        Some([behind, beyond])
    }

    /// The middle of the section at a depth.
    pub(in crate::cast) fn spine_at(&self, frame: &Frame, depth: f64) -> DVec3 {
        let (start, slope) = self.spine(frame);
        start + depth * slope
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
