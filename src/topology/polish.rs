//! Newton's method on a batch of cells, each with at most one critical point, and the proof that there is one.
//!
//! On a ball around `x` with `Y = H^-1`, the map `u -> u - Y grad f` has its zeros of the gradient as fixed
//! points, and takes the unit ball to within `|Y| turn_1 + |I - Y H|` of `-Y g`. If that is inside of the ball
//! there is a fixed point (Brouwer), so that the gradient vanishes within that distance of the next iterate.
//! Smaller balls give smaller errors, quadratically, until rounding is all that is left.

use super::cell::Cell;
use super::matrix::inverse;
use super::point::CriticalPoint;
use super::search::{Balls, LANES};
use crate::num::Taylor;
use glam::DVec3;

/// Steps until a cell is given up.
const STEPS: usize = 24;

/// That there is exactly one critical point within `error` of `position`.
#[derive(Clone, Copy)]
struct Proof {
    position: DVec3,
    error: f64,
    /// Radius of a ball around it in which it is the only one.
    alone: f64,
    /// What is known of a ball that holds it, and the radius of that.
    over: Taylor,
    radius: f64,
}

/// The method at work on one cell.
#[derive(Clone, Copy)]
struct Newton {
    cell: Cell,
    at: DVec3,
    /// Of the ball to look at next.
    radius: f64,
    /// The best that is proven so far.
    best: Option<Proof>,
    over: bool,
}

/// Finds a critical point in the ball around each cell, where it can; counts evaluations.
pub fn polish(field: &mut Balls, cells: &[Cell], evaluations: &mut u64) -> Vec<Option<CriticalPoint>> {
    let mut all: Vec<Newton> = cells.iter().map(Newton::new).collect();
    for _ in 0..STEPS {
        let mut active: Vec<&mut Newton> = all.iter_mut().filter(|n| !n.over).collect();
        for batch in active.chunks_mut(LANES) {
            let values = field.eval(batch.iter().map(|n| (n.at, n.radius)));
            *evaluations += batch.len() as u64;
            for (i, newton) in batch.iter_mut().enumerate() {
                newton.step(&values.lane(i).on(newton.cell.free_axes()));
            }
        }
    }
    all.iter().map(Newton::found).collect()
}

impl Newton {
    fn new(cell: &Cell) -> Newton {
        Newton { cell: *cell, at: cell.centre, radius: 0.5 * cell.radius(), best: None, over: false }
    }

    /// What was proven, if it is about the ball around the cell: only there is it the one.
    fn found(&self) -> Option<CriticalPoint> {
        let best = self.best?;
        let is_here = best.position.distance(self.cell.centre) + best.error <= self.cell.radius();
        is_here.then(|| CriticalPoint::new(best.position, best.error, best.alone, best.radius, &best.over))?
    }

    /// One step, from what is known of the ball.
    fn step(&mut self, f: &Taylor) {
        let inverse = inverse(f.hess);
        if !inverse.exists() {
            self.over = true;
            return;
        }
        let move_by = -DVec3::from_array(inverse.times(f.grad));
        let rounding = 16.0 * f64::EPSILON * inverse.norm * DVec3::from_array(f.grad).length();
        let error = inverse.norm * f.turn[1] + inverse.defect + rounding;
        let next = self.at + self.radius * move_by;
        let proven = move_by.length() + error <= 1.0;
        if proven {
            let is_unique = inverse.least > f.twist;
            let slack = if is_unique { self.radius * (1.0 - move_by.length()) } else { 0.0 };
            let alone = self.best.map_or(0.0, |b| b.alone - b.position.distance(next)).max(slack);
            let size = next.abs().max_element();
            let error = self.radius * error + 4.0 * f64::EPSILON * size;
            let before = self.best.map_or(f64::INFINITY, |b| b.error);
            // Below that, rounding is most of it.
            self.over = error < 64.0 * f64::EPSILON * size;
            if error < 0.5 * before {
                self.best = Some(Proof { position: next, error, alone, over: *f, radius: self.radius });
            } else {
                self.over = true;
                return;
            }
            (self.at, self.radius) =
                (next, (2.0 * error).max(1e3 * f64::EPSILON * size).min(0.5 * self.radius));
        } else if self.best.is_some() {
            self.over = true;
        } else {
            self.retry(next, move_by.length());
        }
    }

    /// Where to go from a ball in which nothing is proven.
    fn retry(&mut self, next: DVec3, moved: f64) {
        let away = next.distance(self.cell.centre);
        if away.is_nan() || away > 2.0 * self.cell.radius() {
            self.over = true;
        } else if moved > 0.5 {
            self.at = next;
        } else {
            (self.at, self.radius) = (next, 0.25 * self.radius);
        }
    }
}
