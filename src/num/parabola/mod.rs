//! Enclosures along a line by bands between two parabolas.
//!
//! Over a piece of a line, `x(e) = c + e d` with `e` in [-1, 1], a quantity is known as
//!
//! ```text
//! f = mid_0 + mid_1 e + mid_2 e^2 + side_1 u_1 + ... + side_K u_K  +-  (rest_0 + rest_1 |e| + rest_2 e^2)
//! ```
//!
//! with `u_k` in [-1, 1], and besides as an interval `range`. So one evaluation says not only whether
//! the piece is free of roots, but how far from its middle, on either side, that is certain: up to a
//! root of a quadratic polynomial ([`Parabola::halves`]). This is the two-sided certificate of a jet,
//! made an arithmetic, so that it holds for any expression.
//!
//! The `K` side symbols are shared by all quantities, like those of affine arithmetic. A beam of
//! rays has two, which say where in the beam a ray is; a single ray has none.
//!
//! **Functions** (`lift.rs`) are expanded to second order about `mid_0`, with second derivatives
//! enclosed over the whole piece. Where those are unbounded, because a crease may be crossed, first
//! derivatives over the piece serve as slopes, or chords of what is convex; and a minimum or maximum departs as a mixture of
//! its arguments does (`crease.rs`). Smooth corners (`seam.rs`) bend along the difference of their arguments.
//! **Kernels** (`kernel.rs`) have the best of three bounds: their jet's Taylor form, their
//! Lipschitz bound, or their range.
//!
//! **Signs** (`sign.rs`) are certain where a band is above zero or below; of solids that are put together they are put
//! together as sets of places (`classify.rs`), for which no minimum or maximum has to be computed.
//!
//! Middles are computed with plain numbers, and what that may have rounded away is charged to the
//! rests. Numbers and charges are a third of what intervals would be, and are what the compiler makes
//! vector instructions of: [`Parabolas`] are a batch as a structure of arrays, and an operation is a
//! loop over the lanes. No lane influences another.

mod band;
mod batch;
mod classify;
mod crease;
mod kernel;
mod lift;
mod seam;
mod sign;

use super::interval::{choose, pick};
use super::{Interval, ROUNDOFF};
pub use batch::Parabolas;
pub(crate) use classify::{Classifier, Joint, Part, Signs, parts_of};
pub use classify::{Mix, Sign};
pub(super) use lift::known;
pub use sign::Half;

/// A quantity along a piece of a line; see the module text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parabola<const K: usize> {
    /// Factors of 1, `e` and `e^2`.
    pub mid: [f64; 3],
    /// How far the quantity may be from what `mid` and `side` say: factors of 1, `|e|` and `e^2`.
    pub rest: [f64; 3],
    /// Factors of the side symbols.
    pub side: [f64; K],
    /// Encloses the quantity over the whole piece.
    pub range: Interval,
}

/// How far a form may be from a straight line before it is dropped, in widths of the range: it says more of the middle
/// than the range does, even where it says less of the ends. Likewise, how far an expansion of a kernel is from its slope.
/// (Measured: with 1 instead of 2 the canyon takes a fifth longer, the shore and the vine a seventh, and with 8 or without
/// end half of that; smooth surfaces are indifferent. For kernels ground takes a twentieth more evaluations.)
const VAGUE: f64 = 2.0;

/// More than the relative rounding of two operations, and of the sum that charges it.
const CHARGE: f64 = 4.0 * ROUNDOFF;

/// Covers the roundings of the at most sixty operations inside a bound.
const ROUND_UP: f64 = 1.0 + 64.0 * ROUNDOFF;

/// Covers products that are too small to be represented.
const TINY: f64 = 1e-300;

impl<const K: usize> Parabola<K> {
    /// A number that is somewhere in `c`.
    #[inline(always)]
    pub fn constant(c: Interval) -> Self {
        Parabola { mid: [c.mid(), 0.0, 0.0], rest: [c.rad(), 0.0, 0.0], side: [0.0; K], range: c }
    }

    /// A coordinate: `mid + side u + slope e`, known to within `blur`; `spread` is by how much the slope
    /// may differ across a beam.
    #[inline(always)]
    pub fn coordinate(mid: f64, slope: f64, side: [f64; K], spread: f64, blur: f64) -> Self {
        let mut out = Parabola {
            mid: [mid, slope, 0.0],
            rest: [blur, spread, 0.0],
            side,
            range: Interval { lo: mid, hi: mid },
        };
        out.range = out.hull();
        out
    }

    /// The quantity where the side symbols are these numbers, each of which may be off by so much.
    #[inline(always)]
    pub fn at(&self, sides: [f64; K], blur: [f64; K]) -> Parabola<0> {
        let Parabola { mut mid, mut rest, side, range } = *self;
        let mut size = mid[0].abs();
        for k in 0..K {
            let part = side[k] * sides[k];
            mid[0] += part;
            size += part.abs();
            rest[0] += (side[k] * blur[k]).abs();
        }
        rest[0] = rest[0] * ROUND_UP + 2.0 * CHARGE * size + TINY;
        Parabola { mid, rest, side: [], range }
    }

    /// Sum of the magnitudes of the side symbols' factors, rounded up.
    #[inline(always)]
    fn breadth(&self) -> f64 {
        let mut breadth = 0.0;
        for k in 0..K {
            breadth += self.side[k].abs();
        }
        breadth * ROUND_UP
    }

    /// The hull of all that the form allows.
    #[inline(always)]
    fn hull(&self) -> Interval {
        let [c, b, a] = self.mid;
        let reach = self.rest[0] + self.breadth() + (b.abs() + self.rest[1]);
        // `a e^2` has the sign of `a`, `b e` either one.
        let (dip, rise) = (a - self.rest[2], a + self.rest[2]);
        let (low, high) =
            (c - reach + choose(dip < 0.0, dip, 0.0), c + reach + choose(rise > 0.0, rise, 0.0));
        // A number that is not one makes both ends so, by the charge.
        let charge = 4.0 * CHARGE * (c.abs() + reach + a.abs() + self.rest[2]);
        Interval { lo: low - charge, hi: high + charge }
    }

    /// The range is what both the form and `known` allow.
    #[inline(always)]
    fn narrowed(mut self, known: Interval) -> Self {
        let own = self.hull();
        let whole = own.lo.is_finite() & own.hi.is_finite();
        self.range = pick(whole, own.meet(known), known);
        self
    }

    /// Likewise; and where the form has next to nothing to add, drops it.
    #[inline(always)]
    fn settled(self, known: Interval) -> Self {
        let own = self.hull();
        let whole = own.lo.is_finite() & own.hi.is_finite();
        let range = pick(whole, own.meet(known), known);
        // How far the quantity may be from a straight line.
        let doubt = 2.0 * (self.rest[0] + self.rest[1] + self.rest[2]) + self.mid[2].abs();
        let idle = !(whole & (doubt <= VAGUE * range.width()));
        let flat = Self::constant(range);
        let mut out = Parabola { range, ..flat };
        for j in 0..3 {
            out.mid[j] = choose(idle, flat.mid[j], self.mid[j]);
            out.rest[j] = choose(idle, flat.rest[j], self.rest[j]);
        }
        for k in 0..K {
            out.side[k] = choose(idle, 0.0, self.side[k]);
        }
        out
    }

    /// How far the quantity may be from `mid_0` in the middle of the piece.
    #[inline(always)]
    fn off_middle(&self) -> f64 {
        (self.rest[0] + self.breadth()) * ROUND_UP
    }

    /// By how much the slope of a chord from the middle may differ from `mid_1`.
    #[inline(always)]
    fn bent(&self) -> f64 {
        (self.mid[2].abs() + self.rest[1] + self.rest[2]) * ROUND_UP
    }

    /// The box of all values and the middle, about which functions are expanded.
    #[inline(always)]
    fn reached(&self) -> Interval {
        self.range.hull(Interval { lo: self.mid[0], hi: self.mid[0] })
    }

    /// `self + other`
    #[inline(always)]
    fn plus(&self, other: &Self) -> Self {
        let mut out = Parabola { range: self.range + other.range, ..*self };
        let mut size = 0.0;
        for k in 0..K {
            out.side[k] += other.side[k];
            size += out.side[k].abs();
        }
        for j in 0..3 {
            out.mid[j] += other.mid[j];
            let rest = self.rest[j] + other.rest[j];
            out.rest[j] = rest + CHARGE * (rest + out.mid[j].abs());
        }
        if K > 0 {
            out.rest[0] += 2.0 * CHARGE * size;
        }
        out
    }

    /// `-self`
    #[inline(always)]
    pub fn negated(mut self) -> Self {
        for j in 0..3 {
            self.mid[j] = -self.mid[j];
        }
        for k in 0..K {
            self.side[k] = -self.side[k];
        }
        self.range = -self.range;
        self
    }

    /// `k self`
    #[inline(always)]
    fn times(&self, k: f64) -> Self {
        let mut out = Parabola { range: self.range * k, ..*self };
        let mut size = 0.0;
        for s in 0..K {
            out.side[s] *= k;
            size += out.side[s].abs();
        }
        for j in 0..3 {
            out.mid[j] *= k;
            let rest = self.rest[j] * k.abs();
            out.rest[j] = rest + CHARGE * (rest + out.mid[j].abs());
        }
        out.rest[0] += 2.0 * CHARGE * size + TINY;
        out
    }

    /// `self + c`
    #[inline(always)]
    fn shifted(mut self, c: f64) -> Self {
        self.mid[0] += c;
        self.rest[0] += CHARGE * (self.rest[0] + self.mid[0].abs());
        self.range = self.range + Interval { lo: c, hi: c };
        self
    }

    /// The other one if `test` holds.
    #[inline(always)]
    fn unless(mut self, test: bool, other: &Self) -> Self {
        for j in 0..3 {
            self.mid[j] = choose(test, other.mid[j], self.mid[j]);
            self.rest[j] = choose(test, other.rest[j], self.rest[j]);
        }
        for k in 0..K {
            self.side[k] = choose(test, other.side[k], self.side[k]);
        }
        self.range = pick(test, other.range, self.range);
        self
    }

    #[inline(always)]
    fn is_finite(&self) -> bool {
        let mut sum = 0.0;
        for j in 0..3 {
            sum += self.mid[j].abs() + self.rest[j];
        }
        for k in 0..K {
            sum += self.side[k].abs();
        }
        sum.is_finite()
    }
}
