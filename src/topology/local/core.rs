//! The core of a solid: a ball that is all inside, and straight ways to it.
//!
//! What is undefined is empty, so a ball or a line is inside only where the field has a value all over it. The very
//! middle of the core is no part of it: there, directions have no value.
//!
//! A line is inside where every piece of it is. Each is looked at with one evaluation along it, by the one coordinate
//! that varies: on planets far less varies along vertical lines than in balls around them. With `-1 <= u <= 1` on
//! the piece
//!
//! ```text
//! f(u)  <=  f + f' u + f'' u^2 / 2 + bow_1
//! ```
//!
//! Sixteen lines are walked side by side, each in pieces that grow while they are found to be inside and shrink while
//! they are not; of a piece that may not be, what is inside from its beginning on counts.

use super::super::search::{Balls, LANES};
use crate::num::Taylor;
use crate::scene::Aabb;
use glam::DVec3;

/// A ball that is all inside of a solid, but for the very middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Core {
    /// The middle.
    pub centre: DVec3,
    /// The radius, which is above zero.
    pub radius: f64,
}

/// Rounds of the search for the radius; each makes the gap that is left sixteen times smaller.
const ROUNDS: usize = 5;

/// The middle, as a share of the radius.
const MIDDLE: f64 = 1e-5;

/// Pieces of a line until it is given up.
const PIECES: u32 = 400;

impl Core {
    /// The largest ball about a point in the region that one evaluation proves to be inside, but for a millionth.
    pub fn around(field: &mut Balls, centre: DVec3, largest: f64) -> Option<Core> {
        let inside = |field: &mut Balls, radii: [f64; LANES]| {
            let balls = field.eval(radii.map(|r| (centre, r)).into_iter());
            let below: [bool; LANES] = std::array::from_fn(|i| balls.lane(i).range.hi < 0.0);
            let largest = (0..LANES).rev().filter(|&i| below[i]).map(|i| radii[i]);
            let is_whole =
                |radius: f64| field.is_within(centre, radius) && field.is_defined_beside(centre, radius);
            largest.into_iter().find(|&radius| is_whole(radius))
        };
        let halves =
            |first: usize| std::array::from_fn(|i| libm::ldexp(largest, -((first + LANES - i) as i32)));
        let mut radius = inside(field, halves(0)).or_else(|| inside(field, halves(LANES)))?;
        let mut gap = radius;
        for _ in 0..ROUNDS {
            gap /= LANES as f64;
            let steps = std::array::from_fn(|i| radius + gap * i as f64);
            radius = inside(field, steps)?;
        }
        Some(Core { centre, radius })
    }

    /// Whether a point is in it.
    pub fn holds(&self, p: DVec3) -> bool {
        let distance = p.distance(self.centre);
        distance < self.radius * (1.0 - 1e-12) && distance > self.radius * MIDDLE
    }

    /// Which points a straight line that is all inside leads from to the core. Points are inside; from those beyond the
    /// region nothing is seen. `step` is how far
    /// one can see in the solid, about.
    pub fn seen_from(&self, field: &mut Balls, points: &[DVec3], step: f64) -> Vec<bool> {
        let mut seen: Vec<bool> = points.iter().map(|p| self.holds(*p)).collect();
        let is_beside = |i: &usize| !seen[*i] && field.is_within(points[*i], 0.0);
        let beyond: Vec<usize> = (0..points.len()).filter(is_beside).collect();
        let ways: Vec<[DVec3; 2]> = beyond.iter().map(|&i| self.way_from(points[i])).collect();
        for (i, is_inside) in beyond.into_iter().zip(are_inside(field, &ways, step)) {
            seen[i] = is_inside;
        }
        seen
    }

    /// The straight line from a point beside it.
    fn way_from(&self, p: DVec3) -> [DVec3; 2] {
        let way = self.centre - p;
        // The end lies well within the core.
        let share = 1.0 - self.radius * (1.0 - 1e-6) / way.length();
        [p, p + share * way]
    }
}

/// Which straight lines, given by their ends, are all inside; `step` as of [`Core::seen_from`].
pub fn are_inside(field: &mut Balls, lines: &[[DVec3; 2]], step: f64) -> Vec<bool> {
    let mut inside = vec![false; lines.len()];
    let mut waiting = lines.iter().enumerate().map(|(i, ends)| Line::new(i, *ends, step));
    let mut active: Vec<Line> = Vec::with_capacity(LANES);
    loop {
        let free = LANES - active.len();
        active.extend(waiting.by_ref().take(free));
        if active.is_empty() {
            return inside;
        }
        let values = field.along(active.iter().map(Line::piece));
        for (i, line) in active.iter_mut().enumerate() {
            line.walk(&values.lane(i), step);
        }
        active.retain(|line| {
            inside[line.index] |= line.state == State::Arrived && field.is_defined(&line.bounds());
            line.state == State::Underway
        });
    }
}

/// A line that is walked from one end to the other.
struct Line {
    index: usize,
    from: DVec3,
    direction: DVec3,
    /// How long it is.
    far: f64,
    /// How much of that is walked.
    done: f64,
    /// Half the length of the next piece.
    half: f64,
    pieces: u32,
    state: State,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    Underway,
    Arrived,
    /// There is something in the way, or there may be.
    Blocked,
}

impl Line {
    fn new(index: usize, [from, to]: [DVec3; 2], step: f64) -> Line {
        let far = from.distance(to);
        let (direction, half) = ((to - from) / far, half_of(far).min(0.25 * step));
        Line { index, from, direction, far, done: 0.0, half, pieces: 0, state: State::Underway }
    }

    /// The middle of the next piece, and half of it.
    fn piece(&self) -> (DVec3, DVec3) {
        (self.from + (self.done + self.half) * self.direction, self.half * self.direction)
    }

    /// A box that holds the line.
    fn bounds(&self) -> Aabb {
        let to = self.from + self.far * self.direction;
        let margin = 16.0 * f64::EPSILON * self.from.abs().max(to.abs()).max_element();
        Aabb { min: self.from.min(to) - margin, max: self.from.max(to) + margin }
    }

    /// Goes on by as much of the piece as is inside for certain.
    fn walk(&mut self, f: &Taylor, step: f64) {
        self.pieces += 1;
        let gained = GAINS.into_iter().find(|share| highest(f, *share) < 0.0);
        // The next piece begins in this one, and the last one ends a little beyond the line.
        self.done += 2.0 * self.half * gained.unwrap_or(0.0) * (1.0 - OVERLAP);
        let left = self.far - self.done;
        let least = if gained.is_some() { 0.0 } else { 1e-5 * step };
        self.half = (self.half * gained.map_or(SHRINK, |share| GROW * share)).min(half_of(left));
        self.state = if left <= 0.0 {
            State::Arrived
        } else if f.range.lo > 0.0 || f.value - f.bow[1] > 0.0 || self.half < least || self.pieces > PIECES {
            State::Blocked
        } else {
            State::Underway
        };
    }
}

/// Shares of a piece, from its beginning on, that may be inside.
const GAINS: [f64; 4] = [1.0, 0.75, 0.5, 0.25];

/// The next piece after one that is, and after one of which nothing is.
const GROW: f64 = 1.5;
const SHRINK: f64 = 0.35;

/// Beyond all rounding, as a share of a piece.
const OVERLAP: f64 = 1e-9;

/// Half of a piece that is all that is left.
fn half_of(left: f64) -> f64 {
    0.5 * left * (1.0 + 2.0 * OVERLAP)
}

/// Upper bound of the field on a share of a piece, from its beginning on.
fn highest(f: &Taylor, share: f64) -> f64 {
    let (slope, bend, to) = (f.grad[0], f.hess[0], 2.0 * share - 1.0);
    let at = |u: f64| f.value + u * (slope + 0.5 * u * bend);
    // The highest of the parabola: at an end, or at its vertex.
    let vertex = -slope / bend;
    let is_peak = bend < 0.0 && -1.0 < vertex && vertex < to;
    let parabola = at(-1.0).max(at(to)).max(if is_peak { at(vertex) } else { f64::NEG_INFINITY });
    let rounding = 1e-12 * (f.value.abs() + slope.abs() + bend.abs());
    (parabola + f.bow[1] * (1.0 + 1e-12) + rounding).min(f.range.hi)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Graph;
    use crate::op::{Add, Length, Mul, Op, Sub};
    use crate::tape::Tape;
    use std::sync::Arc;

    /// A ball of radius 1 with waves of height 0.1 along x on it.
    fn ball() -> Balls {
        let mut graph = Graph::default();
        let [x, y, z] = graph.point().unwrap();
        let (one, ten, tenth) =
            (graph.constant(1.0).unwrap(), graph.constant(10.0).unwrap(), graph.constant(0.1).unwrap());
        let length = graph.op(Op::Length(Length), &[x, y, z]).unwrap();
        let ball = graph.op(Op::Sub(Sub), &[length, one]).unwrap();
        let fast = graph.op(Op::Mul(Mul), &[x, ten]).unwrap();
        let wave = graph.op(Op::Sin(crate::op::Sin), &[fast]).unwrap();
        let wave = graph.op(Op::Mul(Mul), &[wave, tenth]).unwrap();
        let field = graph.op(Op::Add(Add), &[ball, wave]).unwrap();
        Balls::new(&Arc::new(Tape::new(&graph, &[field])))
    }

    #[test]
    fn the_core_is_as_large_as_can_be_proven() {
        let core = Core::around(&mut ball(), DVec3::ZERO, 8.0).unwrap();
        assert!((core.radius - 0.9).abs() < 2e-6, "{}", core.radius);
        assert!(Core::around(&mut ball(), DVec3::X * 2.0, 8.0).is_none());
    }

    #[test]
    fn lines_that_are_inside_are_seen() {
        let mut field = ball();
        let core = Core { centre: DVec3::ZERO, radius: 0.2 };
        let value = |p: DVec3| p.length() - 1.0 + 0.1 * (10.0 * p.x).sin();
        let points: Vec<DVec3> = (0..400)
            .map(|i| {
                let a = f64::from(i);
                (0.3 + 0.7 * (0.618 * a).fract()) * DVec3::new(a.sin(), a.cos(), 0.3).normalize()
            })
            .filter(|p| value(*p) < -1e-6)
            .collect();
        let seen = core.seen_from(&mut field, &points, 0.3);
        let free = |p: DVec3| (0..1000).all(|k| value(p * f64::from(k) / 1000.0) < 0.0);
        for (p, seen) in points.iter().zip(seen) {
            assert_eq!(seen, free(*p), "{p}");
        }
        // Beside the ball there is nothing, and what is beyond a gap is not seen.
        assert_eq!(core.seen_from(&mut field, &[DVec3::X * 1.3], 0.3), [false]);
    }
}
