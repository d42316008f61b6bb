//! Where the rays of a beam go: planes across them, and the part of these that they fill.

use super::gather::is_real;
use super::march::Piece;
use crate::cast::Ray;
use crate::num::{Interval, Parabola};
use crate::scene::Aabb;
use glam::DVec3;

/// More than the relative rounding of depths and places.
const HAIR: f64 = 64.0 * f64::EPSILON;

/// Planes across the rays of a group. A line has at a depth `z` the place
///
/// ```text
/// origin + z axis + x u + y v,         [x, y] = start + z slope
/// ```
///
/// where `slope` is zero for parallel lines and `start` is for lines from one origin. Others, which only run alongside one
/// another, as those through a lens or to a sun that is a disc, have both. Rays may also run towards their origin, at
/// depths below zero, as they do to the centre of a planet.
///
/// Depths are the same for all beams of the group, so that a beam starts where the one that it is a
/// part of ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    origin: DVec3,
    axis: DVec3,
    across: [DVec3; 2],
    kind: Kind,
    /// Size of the numbers that depths and places are computed from, in units of them.
    size: f64,
    /// Depths between which there is anything of the lines.
    range: [f64; 2],
}

/// What the lines of a frame have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Where they start.
    Origin,
    /// Where they go.
    Parallel,
    /// Nothing but roughly where they go.
    Alongside,
}

/// In front of the origin.
const AHEAD: [f64; 2] = [0.0, f64::INFINITY];

impl Frame {
    /// The frame of those rays of which there is anything, the first of all among them, if they keep within some 25
    /// degrees of their mean direction.
    pub(super) fn new(rays: &[Ray]) -> Option<Frame> {
        let &Ray { origin, direction, .. } = rays.first()?;
        let real = || rays.iter().filter(|r| is_real(r));
        if rays.len() < 2 {
            return None;
        }
        let kind = if real().all(|r| r.direction == direction) {
            Kind::Parallel
        } else if real().all(|r| r.origin == origin) {
            Kind::Origin
        } else {
            Kind::Alongside
        };
        let axis = real().map(|r| r.direction).sum::<DVec3>().try_normalize()?;
        let axis = if kind == Kind::Parallel { direction } else { axis };
        if real().any(|r| r.direction.dot(axis) < 0.9) {
            return None;
        }
        let u = axis.any_orthonormal_vector();
        let far = real().map(|r| r.origin.abs().max_element()).fold(0.0, f64::max);
        let size = if kind == Kind::Origin { 1.0 } else { 4.0 * far };
        Some(Frame { origin, axis, across: [u, axis.cross(u)], kind, size, range: AHEAD })
    }

    /// The frame of all lines that start at one point; the three unit vectors are at right angles.
    pub fn from_point(origin: DVec3, axis: DVec3, across: [DVec3; 2]) -> Frame {
        Frame { origin, axis, across, kind: Kind::Origin, size: 1.0, range: AHEAD }
    }

    /// The frame of parallel lines that start at most `reach` away from a point, on any axis.
    pub fn parallel(origin: DVec3, axis: DVec3, across: [DVec3; 2], reach: f64) -> Frame {
        let size = 4.0 * (origin.abs().max_element() + reach);
        Frame { origin, axis, across, kind: Kind::Parallel, size, range: AHEAD }
    }

    /// Whether lines have more in common than that they run alongside one another.
    pub(super) fn is_strict(&self) -> bool {
        self.kind != Kind::Alongside
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
        } else if self.origin == other.origin && self.kind == Kind::Origin {
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
            let (start, slope) = if self.kind == Kind::Parallel {
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

    /// A ray as it looks from the frame.
    pub(in crate::cast) fn line(&self, ray: &Ray) -> Line {
        let stretch = if self.kind == Kind::Parallel { 1.0 } else { 1.0 / ray.direction.dot(self.axis) };
        let later = match self.kind {
            Kind::Origin => 0.0,
            _ => (ray.origin - self.origin).dot(self.axis) * stretch,
        };
        let line = Line { place: self.place(ray, stretch), stretch, later, depth: [0.0; 2] };
        Line { depth: [ray.near, ray.far].map(|t| line.depth_at(t)), ..line }
    }

    /// More than the numbers that places at a depth are computed from.
    fn place_size(&self, depth: f64) -> f64 {
        match self.kind {
            Kind::Origin => depth.abs(),
            Kind::Parallel => self.size,
            Kind::Alongside => depth.abs() + self.size,
        }
    }

    /// More than the rounding of a depth or a distance of this size.
    pub(in crate::cast) fn hair(&self, depth: f64) -> f64 {
        HAIR * (depth.abs() + if self.kind == Kind::Origin { 0.0 } else { self.size })
    }

    /// Across the axis, where the line of a ray is at depth zero, and how it goes on with depth.
    fn place(&self, ray: &Ray, stretch: f64) -> Place {
        let across = |v: DVec3| self.across.map(|a| v.dot(a));
        let slope = match self.kind {
            Kind::Parallel => [0.0; 2],
            _ => across(stretch * ray.direction),
        };
        let start = match self.kind {
            Kind::Origin => [0.0; 2],
            _ => {
                let q = ray.origin - self.origin;
                let (deep, [x, y]) = (q.dot(self.axis), across(q));
                [x - deep * slope[0], y - deep * slope[1]]
            }
        };
        Place { start, slope }
    }
}

/// A ray of which there is anything, as it looks from its frame.
#[derive(Clone, Copy, Debug)]
pub(in crate::cast) struct Line {
    pub place: Place,
    /// Distance along the ray for each unit of depth, and by how much distances begin later.
    pub stretch: f64,
    later: f64,
    /// Where the ray begins and where it ends.
    pub depth: [f64; 2],
}

impl Line {
    /// Of a ray of which there is nothing.
    pub const NOTHING: Line =
        Line { place: Place::ORIGIN, stretch: 1.0, later: 0.0, depth: [f64::INFINITY, f64::NEG_INFINITY] };

    /// The depth that the ray has reached at `t`.
    fn depth_at(&self, t: f64) -> f64 {
        (t + self.later) / self.stretch
    }

    /// The distance along the ray of a depth.
    pub fn distance(&self, depth: f64) -> f64 {
        depth * self.stretch - self.later
    }

    pub(super) fn is_real(&self) -> bool {
        self.depth[0] <= self.depth[1]
    }
}

/// A line of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::cast) struct Place {
    pub start: [f64; 2],
    pub slope: [f64; 2],
}

impl Place {
    const ORIGIN: Place = Place { start: [0.0; 2], slope: [0.0; 2] };

    /// Where it is at a depth.
    fn at(&self, depth: f64) -> [f64; 2] {
        [0, 1].map(|k| self.start[k] + depth * self.slope[k])
    }
}

/// The part of a frame that some rays go through: a rectangle at each depth.
#[derive(Clone, Copy, Debug)]
pub(in crate::cast) struct Section {
    /// The line through the middles of the rectangles.
    pub centre: Place,
    /// Half the sides at depth zero, and by how much they grow with depth to either side of it.
    extent: [f64; 2],
    growth: [f64; 2],
    /// The same for half the diagonal.
    radius: [f64; 2],
    /// Depths from where the first ray begins to where the last one ends.
    pub depth: [f64; 2],
}

/// A range of numbers, to which more are added.
#[derive(Clone, Copy)]
struct Range([f64; 2]);

impl Range {
    const NONE: Range = Range([f64::INFINITY, f64::NEG_INFINITY]);

    fn add(&mut self, x: f64) {
        self.0 = [self.0[0].min(x), self.0[1].max(x)];
    }

    /// Its middle, and half of it and a hair, as numbers of this size are rounded.
    fn around(self, size: f64) -> [f64; 2] {
        let [lo, hi] = self.0;
        [0.5 * (lo + hi), 0.5 * (hi - lo) * (1.0 + 1e-12) + 16.0 * f64::EPSILON * size]
    }
}

impl Section {
    fn new(centre: Place, extent: [f64; 2], growth: [f64; 2], depth: [f64; 2]) -> Section {
        let radius = [extent, growth].map(|[x, y]| (x * x + y * y).sqrt() * (1.0 + 4.0 * f64::EPSILON));
        Section { centre, extent, growth, radius, depth }
    }

    /// The section around those lines of which there is anything.
    pub(in crate::cast) fn around(frame: &Frame, lines: &[Line]) -> Section {
        let (mut start, mut slope, mut depth) = ([Range::NONE; 2], [Range::NONE; 2], Range::NONE);
        for Line { place, depth: own, .. } in lines.iter().filter(|line| line.is_real()) {
            for k in 0..2 {
                start[k].add(place.start[k]);
                slope[k].add(place.slope[k]);
                depth.add(own[k]);
            }
        }
        // Places are known to a few roundings of the numbers that they come from; what all lines share is zero.
        let (starts, slopes) = match frame.kind {
            Kind::Origin => (0.0, 1.0),
            Kind::Parallel => (frame.size, 0.0),
            Kind::Alongside => (frame.size, 1.0),
        };
        let start = start.map(|range| range.around(starts));
        let slope = slope.map(|range| range.around(slopes));
        let centre = Place { start: start.map(|[mid, _]| mid), slope: slope.map(|[mid, _]| mid) };
        let [near, far] = depth.0;
        let depth = [near - frame.hair(near), far + frame.hair(far)];
        Section::new(centre, start.map(|[_, half]| half), slope.map(|[_, half]| half), depth)
    }

    /// The section that a rectangle of places is, one unit deep for lines from one origin, as deep as its lines are in a
    /// region; `None` if none is. Not for lines that only run alongside one another.
    pub(super) fn through(frame: &Frame, rectangle: [[f64; 2]; 2], region: &Aabb) -> Option<Section> {
        let around = rectangle.map(|range| Range(range).around(frame.size));
        let depth = frame.depths(around.map(|[mid, half]| Interval::around(mid, half)), region)?;
        let (middle, extent) = (around.map(|[mid, _]| mid), around.map(|[_, half]| half));
        Some(match frame.kind {
            Kind::Parallel => Section::new(Place { start: middle, ..Place::ORIGIN }, extent, [0.0; 2], depth),
            _ => Section::new(Place { slope: middle, ..Place::ORIGIN }, [0.0; 2], extent, depth),
        })
    }

    /// The lines in its middle and at its corners.
    pub(super) fn centre_and_corners(&self) -> [Place; 5] {
        [[0.0, 0.0], [-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]].map(|off| Place {
            start: [0, 1].map(|k| self.centre.start[k] + off[k] * self.extent[k]),
            slope: [0, 1].map(|k| self.centre.slope[k] + off[k] * self.growth[k]),
        })
    }

    /// How far its lines go across at most, for each unit of depth.
    pub(super) fn slant(&self) -> f64 {
        let [x, y] = [0, 1].map(|k| self.centre.slope[k].abs() + self.growth[k]);
        libm::hypot(x, y)
    }

    /// Half the diagonal at a depth, or a hair more.
    pub(in crate::cast) fn radius(&self, depth: f64) -> f64 {
        self.radius[0] + depth.abs() * self.radius[1]
    }

    /// Half the sides at a depth.
    fn extent(&self, depth: f64) -> [f64; 2] {
        [0, 1].map(|k| self.extent[k] + depth.abs() * self.growth[k])
    }

    /// Where a line is at a depth, from the centre, in units of the extent.
    pub(super) fn relative(&self, place: &Place, depth: f64) -> [f64; 2] {
        let ([x, y], [u, v], [a, b]) = (place.at(depth), self.centre.at(depth), self.extent(depth));
        [(x - u) / a, (y - v) / b]
    }

    /// Where a line of the section is at a depth, from the centre, in units of the extent, and how far that may be off.
    pub(super) fn known(&self, frame: &Frame, place: &Place, depth: f64) -> [[f64; 2]; 2] {
        let (at, size) = (self.relative(place, depth), frame.place_size(depth));
        let extent = self.extent(depth);
        let (mut known, mut blur) = ([0.0; 2], [1.0; 2]);
        for k in 0..2 {
            // More than what places and the centre are rounded by; no number bounds nothing.
            let off = 1e-12 + 64.0 * f64::EPSILON * size / extent[k];
            if off < 1.0 && at[k].abs() <= 1.0 + off {
                (known[k], blur[k]) = (at[k], off);
            }
        }
        [known, blur]
    }

    /// A place and how far, at most, a piece of the beam reaches from it along any axis.
    pub(super) fn around_piece(&self, frame: &Frame, piece: Piece) -> ([f64; 3], f64) {
        let Piece { mid, half } = piece;
        let (start, slope) = self.spine(frame);
        let at = start + mid * slope;
        let reach = half * slope.length() + self.radius(mid.abs() + half);
        (at.to_array(), reach + frame.hair(mid) + HAIR * (at.abs().max_element() + reach))
    }

    /// The line through the middle of the section: where it starts, and what it gains with depth.
    fn spine(&self, frame: &Frame) -> (DVec3, DVec3) {
        let aside = |[x, y]: [f64; 2]| x * frame.across[0] + y * frame.across[1];
        (frame.origin + aside(self.centre.start), frame.axis + aside(self.centre.slope))
    }

    /// How much depth, backwards and forwards, a ball around the middle of the section at a depth covers with all that
    /// is in the section; `None` if it does not cover the section there.
    pub(in crate::cast) fn covered(&self, depth: f64, ball: f64) -> Option<[f64; 2]> {
        let radius = self.radius(depth);
        // A ball that is no number covers nothing.
        if ball.is_nan() || ball <= radius {
            return None;
        }
        let [u, v] = self.centre.slope;
        let (grows, aside) = (self.radius[1], libm::hypot(u, v));
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

    /// The corners of the rectangle at a depth.
    pub(in crate::cast) fn corners(&self, frame: &Frame, depth: f64) -> [DVec3; 4] {
        let (middle, [x, y]) = (self.spine_at(frame, depth), self.extent(depth));
        let [u, v] = [x * frame.across[0], y * frame.across[1]];
        [middle - u - v, middle + u - v, middle - u + v, middle + u + v]
    }

    /// The coordinates of a piece of the beam.
    pub(super) fn coordinates(&self, frame: &Frame, piece: Piece) -> [Parabola<2>; 3] {
        let Piece { mid, half } = piece;
        let (start, slope) = self.spine(frame);
        let at = start + mid * slope;
        let [x, y] = self.extent(mid.abs() + half);
        let end = (mid.abs() + half) * slope.abs().max_element() + x + y;
        let blur = 8.0 * f64::EPSILON * (frame.origin.abs().max_element() + start.abs().max_element() + end);
        let extent = self.extent(mid);
        [0, 1, 2].map(|axis| {
            let sides = [0, 1].map(|k| extent[k] * frame.across[k][axis]);
            // The rectangles grow with depth, by half the piece.
            let spread = [0, 1].map(|k| half * self.growth[k] * frame.across[k][axis].abs());
            Parabola::coordinate(at[axis], half * slope[axis], sides, spread[0] + spread[1], blur)
        })
    }
}
