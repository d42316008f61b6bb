//! Creases, by chords.
//!
//! A function that is convex, or concave, has slopes of chords from a point that grow, or fall, from one end of a range to the
//! other. So where a crease is far from the middle of a piece, all that lies this side of it has hardly a doubt, while the
//! derivatives on both sides would be all that is known. For `|x|` from `m > 0` over `[-a, b]`
//!
//! ```text
//! |x| = m + s (x - m),     s in [(m - a) / (m + a), 1]
//! ```
//!
//! and a minimum or maximum of two bows along their difference.

use super::lift::points;
use super::{CHARGE, TINY, choose, pick};
use crate::num::{Function, Interval};

/// The slopes of the chords from a point to all others of a range, of a function that has these derivatives there: of one
/// that bows they are between those to its ends.
#[inline(always)]
pub(super) fn chords<F: Function<N>, const N: usize>(
    f: &F,
    m: [f64; N],
    x: Interval,
    derivatives: Interval,
) -> Interval {
    let Some(x) = f.bows(x) else { return derivatives };
    let all = chord(f, m, x.lo, derivatives).hull(chord(f, m, x.hi, derivatives));
    pick(all.lo.is_finite() & all.hi.is_finite(), all.meet(derivatives), derivatives)
}

/// The slope of the chord from a point to another; where it has no length, or one that is not represented, no more is known
/// than these derivatives.
#[inline(always)]
fn chord<F: Function<N>, const N: usize>(f: &F, m: [f64; N], e: f64, derivatives: Interval) -> Interval {
    let mut end = m;
    end[0] = e;
    let rise = f.range(points(end)) - f.range(points(m));
    let run = e - m[0];
    let (x, y) = (rise.lo / run, rise.hi / run);
    let (lo, hi) = (choose(x < y, x, y), choose(x < y, y, x));
    let slope = Interval { lo: lo - CHARGE * lo.abs() - TINY, hi: hi + CHARGE * hi.abs() + TINY };
    pick((run == 0.0) | !run.is_finite(), derivatives, slope)
}

/// Between which shares of its first argument's departure, the rest being the second's, one of two that are `apart` departs
/// that selects one of them, and is `y + g(x - y)`: the slopes of the chords of `g`, which bows, from where it is in the
/// middle to both ends.
#[inline(always)]
pub(super) fn mixture<F: Function<N>, const N: usize>(f: &F, middle: f64, apart: Interval) -> [f64; 2] {
    let g = |d: f64| {
        let mut at = [0.0; N];
        at[0] = d;
        f.value(at)
    };
    let start = g(middle);
    let (mut least, mut most) = (1.0, 0.0);
    for e in [apart.lo, apart.hi] {
        let run = e - middle;
        let share = choose(run.is_finite(), (g(e) - start) / run, f64::NAN);
        // Of what is no number nothing is known.
        let (low, high) = (share * (1.0 - CHARGE), share * (1.0 + CHARGE));
        least = choose(low >= least, least, choose(low >= 0.0, low, 0.0));
        most = choose(high <= most, most, choose(high <= 1.0, high, 1.0));
    }
    [least, most]
}

/// Between which numbers a mixture of two is, of which the first has a share between two others.
#[inline(always)]
pub(super) fn mixed(least: f64, most: f64, a: f64, b: f64) -> [f64; 2] {
    let (x, y) = (least * a + (1.0 - least) * b, most * a + (1.0 - most) * b);
    [choose(x < y, x, y), choose(x < y, y, x)]
}
