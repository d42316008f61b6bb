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

use super::nearest::{choose, larger, square_and_away};
use super::tree::{IS_BLOCK, NOTHING, Node, Tree, WIDE, in_frame};
use crate::num::{Interval, widest};
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::hint::black_box;

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
        let below = || {
            widest(
                #[inline(always)]
                || self.below(tree, -0.25 * hi - r / 64.0),
            )
        };
        let lo = if d > r * UP { below() } else { -all };
        Interval { lo: if lo > -all { lo } else { -all }, hi }
    }

    /// The least `d_T - d - |g_T - g| r`, or less; above `enough` the search need not be exact.
    #[inline(always)]
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
                let bounds = block.map(
                    #[inline(always)]
                    |t| {
                        let (square, away) = square_and_away(t, self.centre);
                        square.sqrt() - self.distance - (away - self.away).length() * self.radius * UP
                    },
                );
                // Those of triangles that are not there are not numbers.
                least = bounds.into_iter().fold(least, |least, bound| choose(bound < least, bound, least));
            } else {
                let node = &tree.nodes[child as usize];
                let bounds = self.bounds(node);
                for i in 0..WIDE {
                    if node.child[i] != NOTHING && bounds[i] < least {
                        tree.fetch(node.child[i]);
                        parts.push(Part { bound: bounds[i], child: node.child[i] });
                    }
                }
            }
        }
        parts.pop().map_or(least, |part| if part.bound < least { part.bound } else { least })
    }

    /// What the boxes of a node contribute at least; whatever for those that are not there.
    #[inline(always)]
    fn bounds(&self, node: &Node) -> [f64; WIDE] {
        let at = in_frame(self.centre, node.origin, &node.axes).to_array();
        let away = in_frame(self.away, DVec3::ZERO, &node.axes).to_array();
        // Squares: of the distance of the box, of that of its middle, and of half its diagonal.
        let (mut near, mut far, mut reach) = ([0.0; WIDE], [0.0; WIDE], [0.0; WIDE]);
        for axis in 0..3 {
            for i in 0..WIDE {
                let (lo, hi) = (f64::from(node.lo[axis][i]), f64::from(node.hi[axis][i]));
                let off = larger(larger(lo - at[axis], at[axis] - hi), 0.0);
                let (to, half) = (at[axis] - 0.5 * (lo + hi), 0.5 * (hi - lo));
                near[i] += off * off;
                far[i] += to * to;
                reach[i] += half * half;
            }
        }
        let far = far.map(f64::sqrt);
        let mut chord = [0.0; WIDE];
        for axis in 0..3 {
            for i in 0..WIDE {
                let (lo, hi) = (f64::from(node.lo[axis][i]), f64::from(node.hi[axis][i]));
                let off = (at[axis] - 0.5 * (lo + hi)) / far[i] - away[axis];
                chord[i] += off * off;
            }
        }
        let mut bounds = [0.0; WIDE];
        for i in 0..WIDE {
            // Sine of the angle that the box is seen under, from its middle on; the chord of an angle
            // is at most s sqrt(1 + s^2).
            let sine = reach[i].sqrt() / far[i] * UP;
            let turn = (chord[i].sqrt() + sine * (1.0 + sine * sine).sqrt()) * UP;
            let turn = choose((sine < 1.0) & (turn < 2.0), turn, 2.0);
            bounds[i] = near[i].sqrt() / UP - self.distance - turn * self.radius;
        }
        // Through memory: else the compiler, which sees that the eight are looked at one by one, does
        // not compute them side by side.
        black_box(bounds)
    }
}
