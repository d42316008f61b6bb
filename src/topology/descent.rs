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
//! damped so that it stays in the ball: `(H + mu I) d = -g`. Balls grow while they serve and shrink where they
//! do not, and the path ends in the [basin](super::basin) of a minimum.

use super::matrix::{least_eigenvalue, matrix};
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

/// Where a path ends.
#[derive(Clone, Copy, PartialEq, Eq, Debug, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum End {
    /// At what is known by this number.
    At(usize),
    /// Beyond the region.
    Beyond,
    /// Nowhere: it came to a halt, or went on for too long.
    Lost,
}

/// Balls that a path may take.
const STEPS: u32 = 4000;

/// A path under way.
struct Path {
    index: usize,
    at: DVec3,
    radius: f64,
    steps: u32,
}

/// Follows paths downhill until `arrival` knows where they are.
pub fn descend(
    field: &mut Balls,
    arrival: impl Fn(DVec3) -> Option<usize>,
    region: &Aabb,
    starts: &[Start],
) -> Vec<End> {
    let mut ends = vec![End::Lost; starts.len()];
    let mut waiting = starts.iter().enumerate();
    let mut active: Vec<Path> = Vec::with_capacity(LANES);
    let least = 1e-14 * region.diagonal();
    loop {
        let free = LANES - active.len();
        let next = waiting.by_ref().take(free);
        active.extend(next.map(|(index, s)| Path { index, at: s.at, radius: s.radius, steps: 0 }));
        active.retain(|path| {
            let outside = path.at.cmplt(region.min).any() || path.at.cmpgt(region.max).any();
            let end = match arrival(path.at) {
                Some(number) => Some(End::At(number)),
                None if outside => Some(End::Beyond),
                None => (path.steps > STEPS || path.radius < least).then_some(End::Lost),
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
        let values = field.eval(active.iter().map(|path| (path.at, path.radius)));
        for (i, path) in active.iter_mut().enumerate() {
            path.step(&values.lane(i));
        }
    }
}

impl Path {
    /// Walks as far as the ball around the point allows.
    fn step(&mut self, f: &Taylor) {
        self.steps += 1;
        let (h, g) = (matrix(f.hess), DVec3::from_array(f.grad));
        let slope = g.length();
        let least = least_eigenvalue(f.hess);
        // Then no eigenvalue is below |g|, and the direction is no longer than the ball is wide.
        let damping = (slope - least).max(0.0);
        let direction = (h + DMat3::from_diagonal(DVec3::splat(damping))).inverse() * -g;
        let reach = direction.length();
        if !(reach > 0.0 && reach.is_finite()) {
            self.radius *= 0.25;
            return;
        }
        let direction = if reach > 1.0 { direction / reach } else { direction };
        let reach = reach.min(1.0);
        let speed = -(g.dot(direction) + f.turn[1] * reach * (1.0 + 1e-9));
        let bend = direction.dot(h * direction);
        // The slope is `bend s - speed`; what rounding makes of it is far less than a millionth of it.
        let far = if bend > 0.0 { (speed / bend).min(1.0) } else { 1.0 };
        if speed <= 1e-6 * slope * reach || speed.is_nan() {
            self.radius *= 0.25;
            return;
        }
        self.at += self.radius * far * direction;
        self.radius *= if reach < 0.25 {
            0.5
        } else if far * reach > 0.5 {
            2.0
        } else {
            1.0
        };
    }
}
