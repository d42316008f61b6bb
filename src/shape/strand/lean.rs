//! Which ways gradients point in a ball, where all of them point much the same way.
//!
//! The gradient of the distance at `x` is `u_t(x)`, the direction from the nearest place `C(t)`; at a crease, any of
//! those between the directions from several. In the ball of radius `r` about `c`, with the nearest place at the
//! distance `D` in the direction `u`,
//!
//! ```text
//! f(x) <= f(c) + u . (x - c) + r^2 / 2D         g_t(x) >= g_t(c) + u_t . (x - c)
//! ```
//!
//! (see the module above), so only places with `g_t(c) - |u_t - u| r` up to `f(c) + r^2 / 2D` can be nearest. From a
//! place at a distance `D_t > r` all directions to the ball are within the angle `asin(r / D_t)` of that to its middle,
//! the chord of which is at most `sqrt 2` times its sine.

use super::piece::CHORD;
use super::{Part, Strand};
use crate::num::{Lean, ROUNDOFF};
use glam::{DVec3, Vec4Swizzles};

/// Halvings of a piece in search of parts that are in one direction, or go in one.
const LOOKS: u8 = 8;

/// How much that direction may vary, as a chord.
const NARROW: f64 = 0.1;

impl Strand {
    /// What the gradients in a ball about a point have in common.
    pub fn lean(&self, x: DVec3, radius: f64) -> Option<Lean> {
        if !Strand::reaches(x) || !Strand::reaches(DVec3::splat(radius)) {
            return None;
        }
        let (_, at) = self.reading(x);
        if at.distance <= radius {
            return None;
        }
        let slack = self.slack(x.abs().max_element() + radius);
        let limit = at.value + 0.5 * radius * radius / at.distance + slack;
        // Directions, each with the chord that others are within.
        let (mut directions, mut touched) = (Vec::new(), false);
        let mut aside = Vec::new();
        self.below(x, limit + 2.0 * radius, |i| {
            let mut next = Some(Part::whole(&self.pieces[i]));
            while let Some(part) = next.take().or_else(|| aside.pop()).filter(|_| !touched) {
                let Some(view) = part.piece.view(x, limit + 2.0 * radius) else { continue };
                let (to, distance) = (view.middle.toward, view.middle.distance);
                if view.floor - radius * ((to - at.toward).length() + view.turn).min(2.0) >= limit {
                    continue;
                }
                if part.halvings < LOOKS && view.turn > NARROW {
                    aside.extend(part.halves());
                    continue;
                }
                // The other way round than in a view.
                let least = distance * (1.0 - view.turn / CHORD);
                touched |= least <= radius;
                directions.push((to, view.turn + (CHORD * radius + slack) / least));
            }
            if touched { f64::NEG_INFINITY } else { limit + 2.0 * radius }
        });
        let axis = directions.iter().map(|(to, _)| *to).sum::<DVec3>().normalize_or_zero();
        let chord = directions.iter().fold(0.0, |m: f64, (to, chord)| m.max((*to - axis).length() + chord));
        let least = 1.0 - 0.5 * chord * chord - 16.0 * ROUNDOFF;
        (!touched && least > 0.0).then_some(Lean { axis: axis.to_array(), least })
    }

    /// Shows directions between which the tangents of each part of a piece are that is within reach of a point, until
    /// some are refused; whether none were.
    pub fn tangents(&self, x: DVec3, reach: f64, mut show: impl FnMut(usize, DVec3) -> bool) -> bool {
        let (mut fine, mut aside) = (true, Vec::new());
        self.below(x, reach, |i| {
            let mut next = Some(Part::whole(&self.pieces[i]));
            while let Some(part) = next.take().or_else(|| aside.pop()).filter(|_| fine) {
                if part.piece.view(x, reach).is_none() {
                    continue;
                }
                let [a, b, c, d] = part.piece.0.map(|p| p.xyz());
                if part.halvings < LOOKS && (d - c - (b - a)).length() > NARROW * (d - a).length() {
                    aside.extend(part.halves());
                    continue;
                }
                fine &= [b - a, c - b, d - c].into_iter().all(|tangent| show(i, tangent));
            }
            if fine { reach } else { f64::NEG_INFINITY }
        });
        fine
    }
}
