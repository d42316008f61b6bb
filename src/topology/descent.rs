//! Paths downhill that stay in the solid, a batch at a time.
//!
//! To know what a point is connected with, one needs no streamline of the gradient: any path along which the
//! field never rises proves as much (Gamito 2009, 8.4, integrates streamlines instead, to an accuracy). On a ball
//! around the point the slope of the field along a straight line in direction `d` is at most
//!
//! ```text
//! g . d + s d^T H d + turn_1 |d|           at s d, 0 <= s <= 1
//! ```
//!
//! which is linear in `s`: the line is walked up to where that is no longer negative. The direction is Newton's,
//! damped so that it stays in the ball: `(H + mu I) d = -g`. The path ends in the [basin](super::basin) of a minimum.
//!
//! Where the third derivatives are bounded, `turn_1` is to the slope as the square of the radius, so that every ball
//! tells how wide the next one may be. (Doubling balls that serve and quartering those that do not took 46 balls a path
//! down gradient noise; this takes 26.)

use super::matrix::{eigen, least_eigenvalue, matrix};
use super::search::{Balls, LANES};
use crate::num::Taylor;
use crate::scene::Aabb;
use glam::{DMat3, DVec3};

/// Where a path begins.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// The point.
    pub at: DVec3,
    /// A first guess at how far one can see from there.
    pub radius: f64,
}

/// Where a path is.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    pub at: DVec3,
    /// How far it could see last.
    pub radius: f64,
    /// Whether it has settled.
    pub settled: Option<Settled>,
}

/// That a path is in a ball in which the field is convex and has a minimum, so that a straight line leads down to it.
#[derive(Clone, Copy, Debug)]
pub struct Settled {
    /// The middle of the ball.
    pub centre: DVec3,
    /// How far from there the minimum may be.
    pub within: f64,
}

/// Where a path ends.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum End<T> {
    /// At what is known by this name.
    At(T),
    /// Beyond the region.
    Beyond,
    /// Nowhere: it came to a halt, or went on for too long.
    Lost,
}

/// What `turn_1` of a ball should be as a share of the slope along the path. (Between 0.35 and 0.6 it makes little
/// difference.)
const TURN: f64 = 0.5;

/// Balls that a path may take.
const STEPS: u32 = 4000;

/// A path under way.
struct Path {
    index: usize,
    place: Place,
    steps: u32,
}

/// Follows paths downhill until `arrival` knows where they are, from their numbers and their places.
pub fn descend<T: Copy>(
    field: &mut Balls,
    mut arrival: impl FnMut(usize, &Place) -> Option<T>,
    region: &Aabb,
    starts: &[Start],
) -> Vec<End<T>> {
    let mut ends = vec![End::Lost; starts.len()];
    let mut waiting = starts.iter().enumerate();
    let mut active: Vec<Path> = Vec::with_capacity(LANES);
    let least = 1e-14 * region.diagonal();
    loop {
        let free = LANES - active.len();
        let next = waiting.by_ref().take(free);
        active.extend(next.map(|(index, s)| Path::new(index, s)));
        active.retain(|path| {
            let at = path.place.at;
            let outside = at.cmplt(region.min).any() || at.cmpgt(region.max).any();
            let end = match arrival(path.index, &path.place) {
                Some(name) => Some(End::At(name)),
                None if outside => Some(End::Beyond),
                None => (path.steps > STEPS || path.place.radius < least).then_some(End::Lost),
            };
            ends[path.index] = end.unwrap_or(End::Lost);
            end.is_none()
        });
        if active.is_empty() {
            if waiting.len() == 0 {
                return ends;
            }
            continue;
        }
        let values = field.eval(active.iter().map(|path| (path.place.at, path.place.radius)));
        for (i, path) in active.iter_mut().enumerate() {
            path.step(&values.lane(i));
        }
    }
}

impl Path {
    fn new(index: usize, start: &Start) -> Path {
        Path { index, place: Place { at: start.at, radius: start.radius, settled: None }, steps: 0 }
    }

    /// Walks as far as the ball around the point allows.
    fn step(&mut self, f: &Taylor) {
        self.steps += 1;
        let (h, g) = (matrix(f.hess), DVec3::from_array(f.grad));
        let slope = g.length();
        let least = least_eigenvalue(f.hess);
        self.place.settled = settled(f, slope)
            .map(|within| Settled { centre: self.place.at, within: self.place.radius * within });
        // Then no eigenvalue is below |g|, and the direction is no longer than the ball is wide.
        let damping = (slope - least).max(0.0);
        let direction = (h + DMat3::from_diagonal(DVec3::splat(damping))).inverse() * -g;
        let reach = direction.length();
        if !(reach > 0.0 && reach.is_finite()) {
            self.place.radius *= 0.25;
            return;
        }
        let direction = if reach > 1.0 { direction / reach } else { direction };
        let reach = reach.min(1.0);
        let along = -g.dot(direction);
        let turn = f.turn[1] * reach * (1.0 + 1e-9);
        let speed = along - turn;
        let curve = direction.dot(h * direction);
        let grow = (TURN * along / turn).sqrt();
        // The slope is `curve s - speed`; what rounding makes of it is far less than a millionth of it.
        let far = if curve > 0.0 { (speed / curve).min(1.0) } else { 1.0 };
        if speed <= 1e-6 * slope * reach || speed.is_nan() {
            // It is no number where the direction does not lead down at all.
            self.place.radius *= if grow.is_nan() { 0.25 } else { grow.clamp(0.25, 0.75) };
            return;
        }
        self.place.at += self.place.radius * far * direction;
        // There is no need to see much farther than one walks.
        self.place.radius *= grow.min((1.5 * far * reach).max(0.25)).min(2.0);
    }
}

/// How far from the middle of a ball the field's only minimum in it is at most, in units of the ball, if it is known to
/// have one there: a convex field whose slope is `|g|` and that bends by at least `m` has it within `|g| / m`.
fn settled(f: &Taylor, slope: f64) -> Option<f64> {
    let within = |least: f64| {
        let bend = least - f.twist * (1.0 + 1e-9);
        let within = slope / bend * (1.0 + 1e-9);
        (bend > 0.0 && within < 1.0).then_some(within)
    };
    let [xx, yy, zz, ..] = f.hess;
    // No eigenvalue is less than the least on the diagonal.
    within(xx.min(yy).min(zz))?;
    let ([least, _, most], _) = eigen(f.hess);
    within(least - 1e-13 * most.abs())
}
