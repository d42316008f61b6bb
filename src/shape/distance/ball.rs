//! What is known of a distance in a ball, creases and all.
//!
//! Let `d` be the distance from the surface, `c` a point where it is known, `p` the nearest place of
//! the surface and `g = (c - p) / d` the gradient. Nothing is farther from the surface than from `p`, so
//! for any `h` with `|h| <= r`
//!
//! ```text
//! d(c + h)  <=  |c + h - p|  =  sqrt(d^2 + 2 d g.h + |h|^2)  <=  d + g.h + r^2 / (2 d)       (r <= 2 d)
//! ```
//!
//! where the last step is largest at `g.h = -r^2 / (2 d)`. The other way round, `d` is the least of the
//! distances `d_T` of triangles, and each of those is convex, which puts it above its tangent plane:
//!
//! ```text
//! d(c + h)  >=  min_T  d_T + g_T . h  >=  d + g.h + min_T (d_T - d - |g_T - g| r)
//! ```
//!
//! The nearest triangle contributes zero, its like on a smooth surface next to nothing, so that
//! the enclosure is quadratic in `r` however fine the triangles are. The minimum is sought in the
//! hierarchy: over a box `d_T` is at least its distance, and `g_T` points to `c` from somewhere in it.
//! A search that gets long ends with the bounds of the boxes that are left.
//!
//! The field is `d` outside and `-d` inside, and in a ball that does not reach the surface it is one of
//! them. The first inequality holds beyond, since the field is below `d` wherever that is outside.

use super::nearest::place;
use super::tree::{BLOCK, IS_BLOCK, NOTHING, Node, Tree, WIDE, in_frame};
use crate::num::Interval;
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// A ball around a point at which the distance and its gradient are known.
pub(super) struct Ball {
    pub centre: DVec3,
    pub radius: f64,
    pub distance: f64,
    /// Gradient of the distance.
    pub away: DVec3,
}

/// Boxes that are looked into before a search gives up.
const PATIENCE: usize = 64;
/// Covers the rounding of what is computed here, relative to the numbers that go in.
const UP: f64 = 1.0 + 1e-9;

/// A box or a block, and what it contributes at least.
struct Part {
    bound: f64,
    child: u32,
}

impl PartialEq for Part {
    fn eq(&self, other: &Part) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Part {}

impl PartialOrd for Part {
    fn partial_cmp(&self, other: &Part) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Part {
    /// The least comes first.
    fn cmp(&self, other: &Part) -> Ordering {
        other.bound.total_cmp(&self.bound).then(other.child.cmp(&self.child))
    }
}

impl Ball {
    /// Encloses `d(c + h) - d - g.h`, where that is the distance with its sign up to rounding.
    pub(super) fn bow(&self, tree: &Tree) -> Interval {
        let (r, d) = (self.radius, self.distance);
        let all = 2.0 * r;
        let above = r * r / (2.0 * d) * UP;
        let hi = if above < all { above } else { all };
        let lo = if d > r * UP { self.below(tree, -0.25 * hi - r / 64.0) } else { -all };
        Interval { lo: if lo > -all { lo } else { -all }, hi }
    }

    /// The least `d_T - d - |g_T - g| r`, or less; above `enough` the search need not be exact.
    fn below(&self, tree: &Tree, enough: f64) -> f64 {
        let mut parts = BinaryHeap::from([Part { bound: f64::NEG_INFINITY, child: 0 }]);
        // The nearest triangle.
        let mut least = 0.0;
        for _ in 0..PATIENCE {
            let Some(Part { bound, child }) = parts.pop() else { return least };
            let good = if least < enough { least } else { enough };
            if bound >= good {
                return if least < bound { least } else { bound };
            }
            if child & IS_BLOCK != 0 {
                let block = &tree.blocks[(child & !IS_BLOCK) as usize];
                for lane in (0..BLOCK).take_while(|lane| !block.is_absent(*lane)) {
                    let own = place(block.triangle(lane), self.centre);
                    let bound = own.square.sqrt()
                        - self.distance
                        - (own.away - self.away).length() * self.radius * UP;
                    least = if bound < least { bound } else { least };
                }
            } else {
                let node = &tree.nodes[child as usize];
                let bounds = self.bounds(node);
                let near = (0..WIDE).filter(|i| node.child[*i] != NOTHING && bounds[*i] < least);
                parts.extend(near.map(|i| Part { bound: bounds[i], child: node.child[i] }));
            }
        }
        parts.pop().map_or(least, |part| if part.bound < least { part.bound } else { least })
    }

    /// What the boxes of a node contribute at least.
    fn bounds(&self, node: &Node) -> [f64; WIDE] {
        let at = in_frame(self.centre, node.origin, &node.axes);
        let away = in_frame(self.away, DVec3::ZERO, &node.axes);
        std::array::from_fn(|i| {
            let [lo, hi] = [&node.lo, &node.hi]
                .map(|side| DVec3::new(f64::from(side[0][i]), f64::from(side[1][i]), f64::from(side[2][i])));
            let distance = (lo - at).max(at - hi).max(DVec3::ZERO).length();
            let (to, reach) = (at - 0.5 * (lo + hi), 0.5 * (hi - lo).length());
            // Sine of the angle that the box is seen under, from its middle on; the chord of an angle
            // is at most s sqrt(1 + s^2).
            let sine = reach / to.length() * UP;
            let turn = if sine < 1.0 {
                (to / to.length() - away).length() + sine * (1.0 + sine * sine).sqrt()
            } else {
                2.0
            };
            let turn = if turn < 2.0 { turn * UP } else { 2.0 };
            distance / UP - self.distance - turn * self.radius
        })
    }
}
