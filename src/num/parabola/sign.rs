//! Where a parabola is positive or negative for certain.

use super::classify::Stretch;
use super::{Parabola, Parabolas, choose};
use crate::num::ROUNDOFF;
use crate::num::simd::widest;

/// What is certain of one half of a piece, in units of its half length from the middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Half {
    /// The quantity is positive between these two places; `[1, 1]` where it is certain of none.
    pub above: [f64; 2],
    /// And negative between these two.
    pub below: [f64; 2],
    /// Where the band would come down to zero if it went on as it does within the piece: not certain,
    /// but how long a piece might be; at least 1, and infinite if nowhere.
    pub reach: f64,
}

impl<const K: usize> Parabola<K> {
    /// What is certain of both halves of the piece: backwards, then forwards.
    pub fn halves(&self) -> [Half; 2] {
        Parabolas::<1, K>::all(*self).halves()[0]
    }
}

impl<const B: usize, const K: usize> Parabolas<B, K> {
    /// What is certain of both halves of every lane's piece: backwards, then forwards.
    pub fn halves(&self) -> [[Half; 2]; B] {
        let mut out = [[Half { above: [1.0; 2], below: [1.0; 2], reach: 1.0 }; 2]; B];
        for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let [above, below] = widest(
                #[inline(always)]
                || [self.above(sign), self.below(sign)],
            );
            for i in 0..B {
                out[i][side] = Half {
                    above: [above.from[i], above.to[i]],
                    below: [below.from[i], below.to[i]],
                    reach: above.reach[i],
                };
            }
        }
        out
    }

    /// Where each lane is positive on the side that `sign` says, and its reach.
    #[inline(always)]
    pub(super) fn above(&self, sign: f64) -> Stretch<B> {
        let mut out = Stretch::NONE;
        for i in 0..B {
            let x = self.lane(i);
            out.set(i, positive(ends(x.mid, sign, &x)), x.range.lo > 0.0);
        }
        out
    }

    /// Where each lane is negative on the side that `sign` says.
    #[inline(always)]
    pub(super) fn below(&self, sign: f64) -> Stretch<B> {
        let mut out = Stretch::NONE;
        for i in 0..B {
            let x = self.lane(i);
            let [c, b, a] = x.mid;
            out.set(i, positive(ends([-c, -b, -a], sign, &x)), x.range.hi < 0.0);
        }
        out
    }

    /// Where each lane is expected to be negative: from a place to another, in halves of the piece from the middle.
    #[inline(always)]
    pub(super) fn expected(&self) -> [[f64; B]; 2] {
        let mut out = [[0.0; B]; 2];
        for i in 0..B {
            let [c, b, a] = self.lane(i).mid;
            let falls = b < 0.0;
            // The root next to the straight line's; where the parabola has none, the line's.
            let square = b * b - 4.0 * a * c;
            let speed = choose(square > 0.0, square, 0.0).sqrt();
            let root = -2.0 * c / (b + choose(falls, -speed, speed));
            out[0][i] = choose(falls & !root.is_nan(), root, f64::NEG_INFINITY);
            out[1][i] = choose(!falls & !root.is_nan(), root, f64::INFINITY);
        }
        out
    }
}

/// Lower bound of `mid` and the rests of `x` on the side that `sign` says, as a polynomial.
#[inline(always)]
fn ends<const K: usize>([c, b, a]: [f64; 3], sign: f64, x: &Parabola<K>) -> [f64; 3] {
    // The ends of the band are rounded: by less than half of what is charged here.
    let end = |m: f64, r: f64| m - (r + 4.0 * ROUNDOFF * (m.abs() + r));
    [end(c, x.off_middle()), end(sign * b, x.rest[1]), end(a, x.rest[2])]
}

/// The first part of [0, 1] in which `c + b t + a t^2` is positive for certain, or `[1, 1]` if there is
/// none; and the first root ahead of a polynomial that starts out positive.
///
/// Roots only propose its ends. A proposal counts where the polynomial is positive beyond rounding at
/// both ends, and at its vertex should that be a minimum between them: then it is so throughout.
#[inline(always)]
fn positive([c, b, a]: [f64; 3]) -> [f64; 3] {
    let (square, product) = (b * b, 4.0 * a * c);
    let discriminant = square - product;
    let is_real = discriminant >= 0.0;
    // At a root the polynomial falls or rises as fast as this.
    let speed = discriminant.abs().sqrt();
    // Both roots without cancellation.
    let q = -0.5 * (b + speed.copysign(b));
    let (r, s) = (q / a, c / q);
    let (low, high) = (choose(r < s, r, s), choose(r < s, s, r));
    let first = choose(low > 0.0, low, high);
    let reach = choose(is_real & (first > 0.0), first, f64::INFINITY);
    let [start, end] = proposal(c > 0.0, a < 0.0, is_real, [low, high]);
    // Draw back by as much as makes it positive beyond rounding, but for roots that nearly meet.
    let size = |t: f64| c.abs() + (b * t).abs() + (a * t * t).abs();
    let (slow, hair) = (32.0 * ROUNDOFF / speed, 32.0 * ROUNDOFF);
    let from = choose(start > 0.0, start + (slow * size(start) + hair * start), 0.0);
    let to = choose(end < 1.0, end - (slow * size(end) + hair * end), 1.0);
    let is_positive = |t: f64| c + b * t + a * t * t > 16.0 * ROUNDOFF * size(t);
    let dips = (b + 2.0 * a * from < 0.0) & (b + 2.0 * a * to > 0.0);
    // The polynomial is `(product - square) / 4 a` at its vertex.
    let stays = product - square > 16.0 * ROUNDOFF * (product.abs() + square);
    let some = (from < to) & is_positive(from) & is_positive(to) & (!dips | stays);
    [choose(some, from, 1.0), choose(some, to, 1.0), choose(c > 0.0, reach, 1.0)]
}

/// Where in [0, 1] the polynomial first becomes positive and where it ceases to be, by its roots.
#[inline(always)]
fn proposal(starts: bool, caps: bool, is_real: bool, [low, high]: [f64; 2]) -> [f64; 2] {
    let within = |t: f64| choose((t > 0.0) & (t < 1.0), t, 1.0);
    // Positive from the start, up to the first root ahead.
    let until = within(choose(low > 0.0, low, high));
    // Below at the start, above between two roots.
    let between = [choose(low > 0.0, low, 0.0), within(high)];
    // Below at the start, above from the greater root on; a straight line has one root only.
    let last = choose(high.is_finite(), high, low);
    let from = choose(last >= 0.0, last, 1.0);
    let rises = [choose(caps, between[0], from), choose(caps, between[1], 1.0)];
    [
        choose(starts, 0.0, choose(is_real, rises[0], 1.0)),
        choose(starts & !is_real, 1.0, choose(starts, until, choose(is_real, rises[1], 1.0))),
    ]
}
