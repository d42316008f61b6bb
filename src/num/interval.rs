//! Outward-rounded intervals.
//!
//! `[lo, hi]` stands for every number between its ends; an operation returns an interval that
//! contains every possible result (*inclusion*). Rounding: after a correctly rounded operation the
//! ends move outward by at least one unit in the last place, through a branch-free widening that is
//! monotone, so a smaller argument never gives a larger result. Functions of the mathematical
//! library are correct to within one unit in the last place here (`libm`) and are widened by four.
//!
//! Where an operation is undefined on part of its argument, the result covers the defined part;
//! where it is undefined everywhere, the result is [`Interval::ENTIRE`], which proves nothing.

use super::Real;
use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A closed interval `[lo, hi]`, `lo <= hi`, with possibly infinite ends.
#[derive(Clone, Copy, PartialEq, Debug, serde::Serialize, serde::Deserialize)]
pub struct Interval {
    /// Lower end.
    pub lo: f64,
    /// Upper end.
    pub hi: f64,
}

/// Smallest widening: far below any length of interest, yet not subnormal (which would be slow).
const TINY: f64 = 1e-300;
/// Widening of a correctly rounded result, relative.
const ULP: f64 = f64::EPSILON;
/// Widening of a library function, relative.
const LIBM: f64 = 4.0 * f64::EPSILON;

#[inline(always)]
fn down(x: f64, relative: f64) -> f64 {
    let y = x - (x.abs() * relative + TINY);
    // `inf - inf` and `inf * 0` leave no information about this end.
    if y.is_nan() { f64::NEG_INFINITY } else { y }
}

#[inline(always)]
fn up(x: f64, relative: f64) -> f64 {
    -down(-x, relative)
}

/// Widens a sum or a difference. Those too small to be rounded relative to their size are exact, so that
/// sums of what is not negative are not.
#[inline(always)]
fn outward_sum(lo: f64, hi: f64) -> Interval {
    let down = |x: f64| {
        let y = x - x.abs() * ULP;
        if y.is_nan() { f64::NEG_INFINITY } else { y }
    };
    Interval { lo: down(lo), hi: -down(-hi) }
}

#[inline(always)]
fn times(a: f64, b: f64) -> f64 {
    // An infinite end means "unbounded", and zero times any real number is zero.
    if a == 0.0 || b == 0.0 { 0.0 } else { a * b }
}

/// The smaller of two ends, which are not NaN; a single instruction.
#[inline(always)]
fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
fn most(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// A choice without a branch, as vector instructions make it.
#[inline(always)]
pub(super) fn choose(which: bool, yes: f64, no: f64) -> f64 {
    if which { yes } else { no }
}

/// Likewise.
#[inline(always)]
pub(super) fn pick(which: bool, yes: Interval, no: Interval) -> Interval {
    Interval { lo: choose(which, yes.lo, no.lo), hi: choose(which, yes.hi, no.hi) }
}

impl Interval {
    /// All real numbers.
    pub const ENTIRE: Interval = Interval { lo: f64::NEG_INFINITY, hi: f64::INFINITY };
    /// `[0, 1]`.
    pub const UNIT: Interval = Interval { lo: 0.0, hi: 1.0 };

    /// `[lo, hi]`; the ends may come in any order. A NaN end gives [`Interval::ENTIRE`].
    #[inline]
    pub fn new(lo: f64, hi: f64) -> Self {
        if lo <= hi {
            Interval { lo, hi }
        } else if hi < lo {
            Interval { lo: hi, hi: lo }
        } else {
            Interval::ENTIRE
        }
    }

    /// `[x, x]`.
    #[inline(always)]
    pub fn point(x: f64) -> Self {
        if x.is_nan() { Interval::ENTIRE } else { Interval { lo: x, hi: x } }
    }

    /// `[-r, r]` for `r >= 0`.
    #[inline(always)]
    pub fn radius(r: f64) -> Self {
        Interval { lo: -r, hi: r }
    }

    /// `[mid - r, mid + r]`, rounded outward.
    #[inline(always)]
    pub fn around(mid: f64, r: f64) -> Self {
        Interval { lo: down(mid - r, ULP), hi: up(mid + r, ULP) }
    }

    #[inline(always)]
    fn outward(lo: f64, hi: f64, relative: f64) -> Self {
        Interval { lo: down(lo, relative), hi: up(hi, relative) }
    }

    /// Whether `x` lies inside.
    #[inline(always)]
    pub fn contains(self, x: f64) -> bool {
        self.lo <= x && x <= self.hi
    }

    /// Whether every number of `other` lies inside.
    #[inline]
    pub fn encloses(self, other: Interval) -> bool {
        self.lo <= other.lo && other.hi <= self.hi
    }

    /// Distance from `mid` to the farther end, rounded up.
    #[inline(always)]
    pub fn rad(self) -> f64 {
        let m = self.mid();
        up(most(self.hi - m, m - self.lo), ULP)
    }

    /// Width.
    #[inline(always)]
    pub fn width(self) -> f64 {
        self.hi - self.lo
    }

    /// A point near the middle; finite whenever an end is.
    #[inline(always)]
    pub fn mid(self) -> f64 {
        let m = self.lo * 0.5 + self.hi * 0.5;
        let end = choose(self.lo.is_finite(), self.lo, choose(self.hi.is_finite(), self.hi, 0.0));
        choose(m.is_finite(), m, end)
    }

    /// Largest absolute value.
    #[inline(always)]
    pub fn mag(self) -> f64 {
        most(self.lo.abs(), self.hi.abs())
    }

    /// Smallest absolute value.
    #[inline(always)]
    pub fn mig(self) -> f64 {
        choose(self.lo > 0.0, self.lo, choose(self.hi < 0.0, -self.hi, 0.0))
    }

    /// Whether both ends are finite.
    #[inline(always)]
    pub fn is_finite(self) -> bool {
        self.lo.is_finite() && self.hi.is_finite()
    }

    /// Smallest interval around both.
    #[inline(always)]
    pub fn hull(self, other: Interval) -> Interval {
        Interval { lo: least(self.lo, other.lo), hi: most(self.hi, other.hi) }
    }

    /// Numbers in both. Two enclosures of one value always meet; should rounding part them, the
    /// tighter one is returned.
    #[inline(always)]
    pub fn meet(self, other: Interval) -> Interval {
        let (lo, hi) = (most(self.lo, other.lo), least(self.hi, other.hi));
        let tighter = pick(self.width() <= other.width(), self, other);
        pick(lo <= hi, Interval { lo, hi }, tighter)
    }

    /// Enclosure of a function that grows with its argument.
    #[inline]
    fn rising(self, f: impl Fn(f64) -> f64, relative: f64) -> Interval {
        Interval::outward(f(self.lo), f(self.hi), relative)
    }

    /// Clips to `[lo, hi]`; `None` when nothing is left.
    #[inline]
    fn clip(self, lo: f64, hi: f64) -> Option<Interval> {
        let x = Interval { lo: most(self.lo, lo), hi: least(self.hi, hi) };
        (x.lo <= x.hi).then_some(x)
    }

    /// Whether `phase + k * period` may lie inside for an integer `k`.
    fn meets(self, phase: f64, period: f64) -> bool {
        // The argument of a library sine is exact, so only this test is rounded: widen it.
        let slack = 4.0 * f64::EPSILON * (self.mag() + period);
        let k = ((self.lo - slack - phase) / period).ceil();
        phase + k * period <= self.hi + slack
    }
}

impl Add for Interval {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        outward_sum(self.lo + o.lo, self.hi + o.hi)
    }
}

impl Sub for Interval {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        outward_sum(self.lo - o.hi, self.hi - o.lo)
    }
}

impl Neg for Interval {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Interval { lo: -self.hi, hi: -self.lo }
    }
}

impl Mul for Interval {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        let (a, b) = (times(self.lo, o.lo), times(self.lo, o.hi));
        let (c, d) = (times(self.hi, o.lo), times(self.hi, o.hi));
        let lo = least(least(a, b), least(c, d));
        let hi = most(most(a, b), most(c, d));
        Interval::outward(lo, hi, ULP)
    }
}

impl Div for Interval {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        let reciprocal = Interval {
            lo: down(1.0 / o.hi, ULP),
            hi: choose(o.lo == 0.0, f64::INFINITY, up(1.0 / o.lo, ULP)),
        };
        // Zero is a positive one, so that below zero its reciprocal is at the other end.
        let apart = (o.lo > 0.0) | (o.hi < 0.0) | ((o.lo == 0.0) & (o.hi > 0.0));
        pick(apart, self * reciprocal, Interval::ENTIRE)
    }
}

impl Mul<f64> for Interval {
    type Output = Self;
    #[inline(always)]
    fn mul(self, k: f64) -> Self {
        let (a, b) = (times(self.lo, k), times(self.hi, k));
        Interval::outward(least(a, b), most(a, b), ULP)
    }
}

impl Real for Interval {
    #[inline(always)]
    fn of(c: f64) -> Self {
        Interval::point(c)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Interval { lo: self.mig(), hi: self.mag() }
    }
    #[inline(always)]
    fn square(self) -> Self {
        let (a, b) = (self.mig(), self.mag());
        Interval { lo: most(down(a * a, ULP), 0.0), hi: up(b * b, ULP) }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let lo = most(down(most(self.lo, 0.0).sqrt(), ULP), 0.0);
        pick(self.hi >= 0.0, Interval { lo, hi: up(self.hi.sqrt(), ULP) }, Interval::ENTIRE)
    }
    fn powi(self, n: i32) -> Self {
        if n < 0 {
            return Interval::point(1.0) / self.powi(-n);
        }
        // A squaring doubles the relative error that it is given, so the n-th power is off by up to
        // n roundings, however few multiplications there are.
        let relative = 2.0 * ULP * f64::from(n.max(1));
        let power = |x: f64| if n == 0 { 1.0 } else { Real::powi(x, n) };
        if n % 2 == 1 {
            Interval::outward(power(self.lo), power(self.hi), relative)
        } else {
            let r = Interval::outward(power(self.mig()), power(self.mag()), relative);
            Interval { lo: most(r.lo, 0.0), hi: r.hi }
        }
    }
    fn powf(self, p: Self) -> Self {
        let Some(x) = self.clip(0.0, f64::INFINITY) else { return Interval::ENTIRE };
        if p.lo == p.hi {
            // Monotone in x.
            let [low, high] = [x.lo, x.hi].map(|x| libm::pow(x, p.lo));
            let r = Interval::outward(Real::min(low, high), Real::max(low, high), LIBM);
            return Interval { lo: most(r.lo, 0.0), hi: r.hi };
        }
        // Monotone in each argument on either side of x = 1 and p = 0: extremes lie at corners.
        let corners = [(x.lo, p.lo), (x.lo, p.hi), (x.hi, p.lo), (x.hi, p.hi)].map(|(x, p)| libm::pow(x, p));
        let mut lo = corners.iter().copied().fold(f64::INFINITY, Real::min);
        let mut hi = corners.iter().copied().fold(f64::NEG_INFINITY, Real::max);
        if x.contains(1.0) || p.contains(0.0) {
            (lo, hi) = (least(lo, 1.0), most(hi, 1.0));
        }
        let r = Interval::outward(lo, hi, LIBM);
        Interval { lo: most(r.lo, 0.0), hi: r.hi }
    }
    #[inline]
    fn exp(self) -> Self {
        let r = self.rising(libm::exp, LIBM);
        Interval { lo: most(r.lo, 0.0), hi: r.hi }
    }
    #[inline]
    fn ln(self) -> Self {
        self.clip(0.0, f64::INFINITY).map_or(Interval::ENTIRE, |x| x.rising(libm::log, LIBM))
    }
    fn sin(self) -> Self {
        Interval::wave(self, libm::sin, FRAC_PI_2)
    }
    fn cos(self) -> Self {
        Interval::wave(self, libm::cos, 0.0)
    }
    fn tan(self) -> Self {
        if !self.is_finite() || self.meets(FRAC_PI_2, PI) {
            Interval::ENTIRE
        } else {
            self.rising(libm::tan, LIBM)
        }
    }
    fn asin(self) -> Self {
        self.clip(-1.0, 1.0).map_or(Interval::ENTIRE, |x| x.rising(libm::asin, LIBM))
    }
    fn acos(self) -> Self {
        self.clip(-1.0, 1.0)
            .map_or(Interval::ENTIRE, |x| Interval::outward(libm::acos(x.hi), libm::acos(x.lo), LIBM))
    }
    fn atan(self) -> Self {
        self.rising(libm::atan, LIBM)
    }
    fn atan2(self, x: Self) -> Self {
        let whole = Interval { lo: down(-PI, LIBM), hi: up(PI, LIBM) };
        if x.lo <= 0.0 && self.contains(0.0) {
            return whole; // the box meets the cut along the negative x axis, or the origin
        }
        let corners = [(self.lo, x.lo), (self.lo, x.hi), (self.hi, x.lo), (self.hi, x.hi)];
        let angles = corners.map(|(y, x)| libm::atan2(y, x));
        let lo = angles.iter().copied().fold(f64::INFINITY, Real::min);
        let hi = angles.iter().copied().fold(f64::NEG_INFINITY, Real::max);
        Interval::outward(lo, hi, LIBM)
    }
    #[inline]
    fn floor(self) -> Self {
        Interval { lo: self.lo.floor(), hi: self.hi.floor() }
    }
    #[inline(always)]
    fn min(self, o: Self) -> Self {
        Interval { lo: least(self.lo, o.lo), hi: least(self.hi, o.hi) }
    }
    #[inline(always)]
    fn max(self, o: Self) -> Self {
        Interval { lo: most(self.lo, o.lo), hi: most(self.hi, o.hi) }
    }
    #[inline(always)]
    fn if_less(self, o: Self, then: Self, otherwise: Self) -> Self {
        let either = pick(self.lo >= o.hi, otherwise, then.hull(otherwise));
        pick(self.hi < o.lo, then, either)
    }
    #[inline(always)]
    fn slope_of_jump(self) -> Self {
        pick((self.lo > 0.0) | (self.hi < 0.0), Interval { lo: 0.0, hi: 0.0 }, Interval::ENTIRE)
    }
    #[inline]
    fn slope_of_floor(self) -> Self {
        if self.lo.floor() == self.hi.floor() && self.lo.floor() != self.lo {
            Interval::point(0.0)
        } else {
            Interval::ENTIRE
        }
    }
}

impl Interval {
    /// Range of a cosine-shaped wave over `x`: the ends, and the crest at `crest + 2 k pi` and the
    /// trough half a period later where they lie inside.
    fn wave(x: Interval, f: fn(f64) -> f64, crest: f64) -> Interval {
        if !x.is_finite() || x.width() >= 2.0 * PI {
            return Interval { lo: -1.0, hi: 1.0 };
        }
        let (a, b) = (f(x.lo), f(x.hi));
        let lo = if x.meets(crest - PI, 2.0 * PI) { -1.0 } else { down(least(a, b), LIBM) };
        let hi = if x.meets(crest, 2.0 * PI) { 1.0 } else { up(most(a, b), LIBM) };
        Interval { lo: most(lo, -1.0), hi: least(hi, 1.0) }
    }
}
