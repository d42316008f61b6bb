//! Lines of sight through shells around the origin, and the steps along them.
//!
//! Everything is measured from the *perigee*, the point of a line that is nearest to the origin, at
//! radius `b`: with the signed distance `s` from there, `r^2 = b^2 + s^2` has no cancellation.

use super::medium::{Medium, TOP};
use glam::{DVec3, DVec4};

/// Most steps along a line.
const MOST: usize = 64;

/// Steps along a line: along one that only comes down, or only goes up, and along each half of one
/// that does both.
#[derive(Clone, Copy, Debug)]
pub(super) struct Count {
    pub one_way: usize,
    pub each_half: usize,
}

/// A piece of a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    perigee: DVec3,
    direction: DVec3,
    /// Radius of the perigee.
    pub b: f64,
    /// Where the piece starts and ends, as distances from the perigee.
    pub ends: [f64; 2],
}

impl Line {
    /// The piece of a line of sight of length `distance` (infinite if nothing is in the way) that is in
    /// the air, if any is.
    pub fn new(medium: &Medium, eye: DVec3, direction: DVec3, distance: f64) -> Option<Line> {
        let to_perigee = -eye.dot(direction);
        let perigee = eye + to_perigee * direction;
        let perigee = perigee - perigee.dot(direction) * direction;
        let b = perigee.length();
        if b >= medium.shell.top {
            return None;
        }
        let half = ((medium.shell.top - b) * (medium.shell.top + b)).sqrt();
        let ends = [(-to_perigee).max(-half), (distance - to_perigee).min(half)];
        (ends[0] < ends[1]).then_some(Line { perigee, direction, b, ends })
    }

    /// The point at the distance `s` from the perigee.
    pub fn point(&self, s: f64) -> DVec3 {
        self.perigee + s * self.direction
    }
}

/// Where the steps along a line begin and end, outwards from its start.
pub(super) struct Steps {
    cuts: [f64; MOST + 1],
    count: usize,
}

impl Steps {
    /// Cuts the piece of a line at the perigee radius `b` between two distances from the perigee.
    pub fn new(medium: &Medium, b: f64, [s0, s1]: [f64; 2], count: Count) -> Steps {
        let mut steps = Steps { cuts: [0.0; MOST + 1], count: 0 };
        let each = if s0 < 0.0 && s1 > 0.0 { count.each_half } else { count.one_way }.min(MOST / 2);
        if s0 < 0.0 {
            let cuts = &mut steps.cuts[..=each];
            spread(medium, b, -s1.min(0.0), -s0, cuts);
            cuts.reverse();
            cuts.iter_mut().for_each(|s| *s = -*s);
            steps.count = each;
        }
        if s1 > 0.0 {
            spread(medium, b, s0.max(0.0), s1, &mut steps.cuts[steps.count..=steps.count + each]);
            steps.count += each;
        }
        steps
    }

    /// The steps in order.
    pub fn iter(&self) -> impl Iterator<Item = [f64; 2]> {
        self.cuts[..=self.count].windows(2).map(|w| [w[0], w[1]])
    }
}

/// Distances from the perigee of nodes between the dense end `a` and the thin end `z` of a piece of
/// a line that only rises.
///
/// Heights grow as `sinh^2(k u)`, for `u` in [0, 1]: at first as `u^2`, which spaces nodes evenly along a
/// line at its perigee, then by equal factors, so that layers of any height are cut finely enough. `k`
/// is such that the first steps suit the layer of the least height.
fn spread(medium: &Medium, b: f64, a: f64, z: f64, nodes: &mut [f64]) {
    let (ra, rz) = (hypot(b, a), hypot(b, z));
    let total = (z - a) * (z + a) / (ra + rz);
    let last = nodes.len() - 1;
    let q = (total / (TOP * medium.finest)).sqrt();
    // sinh(k) = q; e^(k / last) makes sinh(k u) from one node to the next by the addition theorem.
    let e = libm::exp(libm::log(q + (1.0 + q * q).sqrt()) / last as f64);
    let (sinh, cosh) = (0.5 * (e - 1.0 / e), 0.5 * (e + 1.0 / e));
    let (mut s, mut c) = (0.0, 1.0);
    for node in &mut *nodes {
        let rise = TOP * medium.finest * (s * s);
        *node = (a * a + rise * (2.0 * ra + rise)).sqrt();
        (s, c) = (s * cosh + c * sinh, c * cosh + s * sinh);
    }
    nodes[0] = a;
    nodes[last] = z;
}

impl Medium {
    /// Amount of each kind of matter between two distances from the perigee: density times length, by
    /// Gauss's rule with two points (error below 0.2% of a step).
    pub(super) fn amount(&self, b: f64, ends: [f64; 2]) -> DVec4 {
        let [(_, near), (_, far)] = self.nodes(b, ends);
        near + far
    }

    /// The two nodes of the rule, as distances from the perigee, with the amounts that they stand for.
    pub(super) fn nodes(&self, b: f64, [from, to]: [f64; 2]) -> [(f64, DVec4); 2] {
        let (mid, half) = (0.5 * (from + to), 0.5 * (to - from));
        let off = half * 0.577_350_269_189_625_8;
        [mid - off, mid + off].map(|s| (s, half * self.density(hypot(b, s))))
    }
}

/// Length of the hypotenuse; planets are neither so large nor so small that squares overflow.
pub(super) fn hypot(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}
