//! Enclosures along a line by bands between two parabolas.
//!
//! Over a piece of a line, `x(e) = c + e d` with `e` in [-1, 1], a quantity is known as
//!
//! ```text
//! f  is in  value + side_1 u_1 + ... + side_K u_K + slope e + bend e^2,     u_k in [-1, 1]
//! ```
//!
//! with intervals for `value`, `slope` and `bend`, and besides as an interval `range`. So one
//! evaluation says not only whether the piece is free of roots, but how far from its middle, on either
//! side, that is certain: up to a root of a quadratic polynomial ([`Parabola::halves`]). This is the
//! two-sided certificate of a jet, made an arithmetic, so that it holds for any expression.
//!
//! The `K` side symbols are shared by all quantities, like those of affine arithmetic. A beam of
//! rays has two, which say where in the beam a ray is; a single ray has none.
//!
//! **Functions** are expanded to second order about the value in the middle, with second derivatives
//! enclosed over the whole piece. Where those are unbounded, because a crease may be crossed, first
//! derivatives over the piece serve as slopes; and a minimum or maximum has the hull of its arguments'
//! slopes. **Kernels** have the best of three bounds: their jet's Taylor form, their Lipschitz bound, or
//! their range.
//!
//! [`Parabolas`] are a batch of them as a structure of arrays. An operation is a loop over the lanes
//! that loads a [`Parabola`], computes with plain numbers and stores the result: what the compiler
//! makes vector instructions of. No lane influences another.

mod batch;
mod sign;

use super::interval::{choose, pick};
use super::{Function, Interval, Local, ROUNDOFF};
pub use batch::Parabolas;
use sign::positive;

/// A quantity along a piece of a line; see the module text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parabola<const K: usize> {
    /// Where the quantity is in the middle of the piece, but for the side symbols.
    pub value: Interval,
    /// Factor of `e`.
    pub slope: Interval,
    /// Factor of `e^2`.
    pub bend: Interval,
    /// Factors of the side symbols.
    pub side: [f64; K],
    /// Encloses the quantity over the whole piece.
    pub range: Interval,
}

/// What is certain of one half of a piece, in units of its half length from the middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Half {
    /// The quantity is positive between these two places; `[1, 1]` where it is certain of none.
    pub above: [f64; 2],
    /// Nearest place where the quantity is negative for certain; 1 if there is none.
    pub below: f64,
}

/// Covers the roundings of the handful of additions inside a bound.
const ROUND_UP: f64 = 1.0 + 16.0 * ROUNDOFF;

const ZERO: Interval = Interval { lo: 0.0, hi: 0.0 };

/// `[-r, r]`
#[inline(always)]
fn radius(r: f64) -> Interval {
    Interval { lo: -r, hi: r }
}

/// `g . (x, y, z)`
#[inline(always)]
fn dot(g: [f64; 3], x: Interval, y: Interval, z: Interval) -> Interval {
    x * g[0] + y * g[1] + z * g[2]
}

/// How far a value may be from its own middle.
#[inline(always)]
fn off_middle<const K: usize>(x: &Parabola<K>) -> Interval {
    x.value - Interval::point(x.value.mid())
}

/// `a b`, where a factor that is exactly zero silences an unbounded one.
#[inline(always)]
fn silenced(a: Interval, b: Interval) -> Interval {
    let p = a * b;
    pick((b.lo == 0.0) & (b.hi == 0.0), ZERO, p)
}

/// One part of each of `N` numbers; a plain loop, since `array::map` is not always inlined, and what is
/// not inlined is not vectorised.
#[inline(always)]
fn each<T: Copy, const K: usize, const N: usize>(
    x: &[Parabola<K>; N],
    part: impl Fn(&Parabola<K>) -> T,
) -> [T; N] {
    let mut out = [part(&x[0]); N];
    for i in 1..N {
        out[i] = part(&x[i]);
    }
    out
}

impl<const K: usize> Parabola<K> {
    /// The number `c`.
    #[inline(always)]
    pub fn constant(c: Interval) -> Self {
        Parabola { value: c, slope: ZERO, bend: ZERO, side: [0.0; K], range: c }
    }

    /// A coordinate: `mid + side u + slope e`, known to within `blur`; `spread` is by how much the slope
    /// may differ across a beam.
    #[inline(always)]
    pub fn coordinate(mid: f64, slope: f64, side: [f64; K], spread: f64, blur: f64) -> Self {
        let mut reach = slope.abs() + spread + blur;
        for side in side {
            reach += side.abs();
        }
        Parabola {
            value: Interval::around(mid, blur),
            slope: Interval::around(slope, spread),
            bend: ZERO,
            side,
            range: Interval::around(mid, reach * ROUND_UP),
        }
    }

    /// Sum of the magnitudes of the side symbols' factors, rounded up.
    #[inline(always)]
    fn width(&self) -> f64 {
        let mut width = 0.0;
        for k in 0..K {
            width += self.side[k].abs();
        }
        width * ROUND_UP
    }

    /// The hull of all that the form allows.
    #[inline(always)]
    fn hull(&self) -> Interval {
        // `bend e^2` has the sign of the bend, `slope e` either one.
        let lo = self.bend.lo.min(0.0);
        let hi = self.bend.hi.max(0.0);
        self.value + radius((self.slope.mag() + self.width()) * ROUND_UP) + Interval { lo, hi }
    }

    /// Intersects with a range known otherwise; where the form has nothing to add, drops it.
    #[inline(always)]
    fn tightened(self, known: Interval) -> Self {
        let own = self.hull();
        let whole = own.lo.is_finite() & own.hi.is_finite();
        let range = pick(whole, own.meet(known), known);
        // How far the quantity may be from a straight line.
        let bent = self.bend.hi.max(0.0) - self.bend.lo.min(0.0);
        let doubt = self.value.width() + self.slope.width() + bent;
        let idle = !(whole & (doubt <= range.width()));
        let mut out = Parabola {
            value: pick(idle, range, self.value),
            slope: pick(idle, ZERO, self.slope),
            bend: pick(idle, ZERO, self.bend),
            side: self.side,
            range,
        };
        for k in 0..K {
            out.side[k] = choose(idle, 0.0, out.side[k]);
        }
        out
    }

    /// `slope + bend e`: the slope of any chord from the middle.
    #[inline(always)]
    fn chord(&self) -> Interval {
        self.slope + radius(self.bend.mag())
    }

    /// All that lies between the value in the middle, as far as that is known, and any other.
    #[inline(always)]
    fn reached(&self) -> Interval {
        self.range.hull(self.value)
    }

    #[inline(always)]
    fn is_finite(&self) -> bool {
        self.value.is_finite() & self.slope.is_finite() & self.bend.is_finite()
    }

    /// Charges the rounding of side symbols to the value: of up to six terms, which together are of
    /// this size.
    #[inline(always)]
    fn rounded(mut self, size: f64) -> Self {
        if K > 0 {
            self.value = self.value + radius(8.0 * ROUNDOFF * size + 1e-300);
        }
        self
    }

    /// Expansion to first order, with partial derivatives over the whole piece.
    #[inline(always)]
    fn sloped<F: Function<N>, const N: usize>(f: &F, x: &[Self; N], value: Interval) -> Self {
        let grad = f.grad(each(x, |x| x.reached()));
        let mut out = Parabola { value, ..Self::constant(ZERO) };
        for i in 0..N {
            out.slope = out.slope + silenced(grad[i], x[i].chord());
            out.value = out.value + silenced(grad[i], radius(x[i].width()));
        }
        out
    }

    /// A function that selects one of its arguments departs from the middle as one of them does that
    /// may be selected.
    #[inline(always)]
    fn selected<F: Function<N>, const N: usize>(f: &F, x: &[Self; N], value: Interval) -> Self {
        let grad = f.grad(each(x, |x| x.reached()));
        let none = Interval { lo: f64::INFINITY, hi: f64::NEG_INFINITY };
        let (mut slope, mut bend, mut wide) = (none, none, 0.0_f64);
        for i in 0..N {
            if grad[i].hi > 0.0 {
                (slope, bend) = (slope.hull(x[i].slope), bend.hull(x[i].bend));
                wide = wide.max(x[i].width());
            }
        }
        Parabola { value: value + radius(wide), slope, bend, ..Self::constant(ZERO) }
    }

    /// What is certain of both halves of the piece: backwards, then forwards.
    #[inline]
    pub fn halves(&self) -> [Half; 2] {
        let (v, b, wide) = (self.value, self.bend, self.width());
        let half = |slope: Interval| Half {
            above: if self.range.lo > 0.0 {
                [0.0, 1.0]
            } else {
                positive([(v.lo - wide).next_down(), slope.lo, b.lo])
            },
            below: if self.range.hi < 0.0 {
                0.0
            } else {
                positive([(-v.hi - wide).next_down(), -slope.hi, -b.hi])[0]
            },
        };
        [half(-self.slope), half(self.slope)]
    }
}

/// How far a point reaches from the middle, as lengths of vectors.
#[derive(Clone, Copy)]
struct Reach {
    /// Along the line, at its ends.
    along: f64,
    /// Across it, and by not being known.
    beside: f64,
}

impl Reach {
    #[inline(always)]
    fn new<const K: usize>(p: &[Parabola<K>; 3]) -> Reach {
        let along = norm(each(p, |x| x.slope.mag() + x.bend.mag()));
        let mut beside = norm(each(p, |x| x.value.rad()));
        if K > 0 {
            beside += norm(each(p, |x| x.width()));
        }
        Reach { along, beside: beside * ROUND_UP }
    }

    #[inline(always)]
    fn whole(self) -> f64 {
        (self.along + self.beside) * ROUND_UP
    }
}

#[inline(always)]
fn norm([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt() * ROUND_UP
}

impl<const K: usize> Parabola<K> {
    /// What is known of a kernel at a point that reaches this far.
    #[inline(always)]
    fn expand(local: &Local, error: [f64; 3], reach: Reach, p: &[Self; 3]) -> Self {
        let Local { jet, bounds: b, bow } = *local;
        let (d, w, r) = (reach.along, reach.beside, reach.whole());
        // Only the Taylor form reads the gradient, which some kernels cannot vouch for.
        let (still, tilted) = (error[0], error[0] + 2.0 * error[1] * r);
        let cone = b.lipschitz * r * ROUND_UP;
        let bent = 0.5 * b.hessian * r * r;
        let own_bow = bow.mag() < bent;
        let is_value = jet.value.is_finite();
        let is_jet = is_value & tilted.is_finite() & (jet.grad[0] + jet.grad[1] + jet.grad[2]).is_finite();
        let taylor = is_jet & (choose(own_bow, bow.mag(), bent) <= choose(cone < b.range, cone, b.range));
        let lipschitz = is_value & !taylor & (cone <= b.range);

        let all = radius(b.range);
        let flat = Interval::around(jet.value, (cone + still) * ROUND_UP).meet(all);
        let known = pick(is_value, flat, all);
        let at = Interval::around(jet.value, choose(taylor, tilted, still));
        // The three terms of `M (w + d e)^2 / 2`.
        let rest = choose(own_bow, 0.0, 0.5 * b.hessian * w * w * ROUND_UP);
        let cross = choose(own_bow, 0.0, b.hessian * d * w * ROUND_UP);
        let square = choose(own_bow, 0.0, 0.5 * b.hessian * d * d * ROUND_UP);
        let off = dot(jet.grad, off_middle(&p[0]), off_middle(&p[1]), off_middle(&p[2]));
        let value = at + off + radius(rest) + pick(own_bow, bow, ZERO);
        let slope = dot(jet.grad, p[0].slope, p[1].slope, p[2].slope) + radius(cross);
        let bend = dot(jet.grad, p[0].bend, p[1].bend, p[2].bend) + radius(square);

        let value = pick(taylor, value, pick(lipschitz, at + radius(b.lipschitz * w * ROUND_UP), known));
        let slope = pick(taylor, slope, pick(lipschitz, radius(b.lipschitz * d * ROUND_UP), ZERO));
        let bend = pick(taylor, bend, ZERO);
        let mut out = Parabola { value, slope, bend, side: [0.0; K], range: known };
        let mut size = 0.0;
        for k in 0..K {
            let (x, y, z) =
                (p[0].side[k] * jet.grad[0], p[1].side[k] * jet.grad[1], p[2].side[k] * jet.grad[2]);
            out.side[k] = choose(taylor, x + y + z, 0.0);
            size += choose(taylor, x.abs() + y.abs() + z.abs(), 0.0);
        }
        out.rounded(size).narrowed(known)
    }

    /// The range is what both the form and `known` allow.
    #[inline(always)]
    fn narrowed(mut self, known: Interval) -> Self {
        let own = self.hull();
        let whole = own.lo.is_finite() & own.hi.is_finite();
        self.range = pick(whole, own.meet(known), known);
        self
    }
}
