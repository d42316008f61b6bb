//! What corners are made of, and what rounds them: norms, ramps, truncated powers, the triangle wave.
//!
//! A blend of two solids is their minimum with its corner rounded, a soft object is a sum of polynomials
//! that end smoothly, a superquadric is a unit ball of a norm. Said with `min`, `abs` and `pow`, each
//! of these would have a crease by its parts that the whole does not have, and bounds on its slope that are
//! products of slopes which are never large at once. Stated whole they have their true class, and slopes
//! that lie in [-1, 1] wherever they are asked for.

use crate::num::{Class, Combine, Form, Function, Interval, ROUNDOFF, Real, Seam};

/// `(|x|^p + |y|^p)^(1/p)` for a power `p` from 1 on, the p-norm of a vector in the plane: 1 has
/// diamonds, 2 circles and large powers squares for its unit circle. Applied again it is the norm of
/// more numbers.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Norm {
    /// The bits of the power.
    bits: u64,
}

impl Norm {
    /// The largest power. Beyond it, powers of ratios such as 1000 are no numbers any more.
    pub const LARGEST: f64 = 64.0;

    /// The norm of a power from 1 to [`Norm::LARGEST`], or the nearest one.
    pub const fn new(power: f64) -> Norm {
        Norm { bits: power.clamp(1.0, Norm::LARGEST).to_bits() }
    }

    /// The power.
    pub const fn power(&self) -> f64 {
        f64::from_bits(self.bits)
    }

    /// `x^(p + n)`, by multiplications where the power is whole.
    #[inline(always)]
    fn power_of<R: Real>(&self, x: R, n: f64) -> R {
        let p = self.power() + n;
        if p.fract() == 0.0 { x.powi(p as i32) } else { x.powf(R::of(p)) }
    }

    /// `s^(1/p)`, by square roots where the power is one of 2.
    #[inline(always)]
    fn root<R: Real>(&self, s: R) -> R {
        match self.power() {
            1.0 => s,
            2.0 => s.sqrt(),
            4.0 => s.sqrt().sqrt(),
            8.0 => s.sqrt().sqrt().sqrt(),
            p => s.powf(R::of(1.0 / p)),
        }
    }

    /// `s^(1 - 1/p)`. A product of roots, all of which grow with `s`, is as narrow for intervals as a power.
    #[inline(always)]
    fn other_root<R: Real>(&self, s: R) -> R {
        let (half, fourth) = (|| s.sqrt(), || s.sqrt().sqrt());
        match self.power() {
            1.0 => R::of(1.0),
            2.0 => half(),
            4.0 => half() * fourth(),
            8.0 => half() * fourth() * fourth().sqrt(),
            p => s.powf(R::of(1.0 - 1.0 / p)),
        }
    }

    /// `1 + t^p` for `t = b / a`, which is 0 where both are.
    #[inline(always)]
    fn sum<R: Real>(&self, a: R, b: R) -> R {
        R::of(1.0) + self.power_of(b / a.max(R::of(1e-300)), 0.0)
    }
}

impl Function<2> for Norm {
    fn is_even(&self) -> bool {
        true
    }
    /// A power of an absolute value is as smooth as its exponent is high.
    fn class(&self) -> Class {
        match self.power() {
            1.0 => Class::C0,
            p if p < 2.0 => Class::C1,
            _ => Class::C2, // everywhere but at the single point 0, as a length
        }
    }
    /// The larger times a power of the ratio, so that no power is too large or small for a number.
    #[inline(always)]
    fn value<R: Real>(&self, [x, y]: [R; 2]) -> R {
        let (x, y) = (x.abs(), y.abs());
        let most = x.max(y);
        most * self.root(self.sum(most, x.min(y)))
    }
    /// `(|x| / r)^(p - 1)` with the sign of `x`, where `|x| / r = (1 + (|y| / |x|)^p)^(-1/p)`.
    #[inline(always)]
    fn grad<R: Real>(&self, [x, y]: [R; 2]) -> [R; 2] {
        let sign = |x: R| x.if_less(R::of(0.0), R::of(-1.0), R::of(1.0));
        let (a, b) = (x.abs(), y.abs());
        [sign(x) / self.other_root(self.sum(a, b)), sign(y) / self.other_root(self.sum(b, a))]
    }
    /// With `u = |x| / r`, `v = |y| / r`: `(p - 1) / r` times `u^(p-2) v^p`, `-(uv)^(p-1)` and
    /// `u^p v^(p-2)`.
    #[inline(always)]
    fn hess<R: Real>(&self, [x, y]: [R; 2]) -> [[R; 2]; 2] {
        let (p, zero) = (self.power(), R::of(0.0));
        if p == 1.0 {
            return [[x.slope_of_jump(), zero], [zero, y.slope_of_jump()]];
        }
        let (a, b) = (x.abs(), y.abs());
        let [u, v] = [R::of(1.0) / self.root(self.sum(a, b)), R::of(1.0) / self.root(self.sum(b, a))];
        let bend = R::of(p - 1.0) / self.value([x, y]);
        let [gx, gy] = self.grad([x, y]);
        let (low, whole) = (|x: R| self.power_of(x, -2.0), |x: R| self.power_of(x, 0.0));
        let across = -(bend * gx * gy);
        [[bend * low(u) * whole(v), across], [across, bend * low(v) * whole(u)]]
    }
    /// Grows with the size of either.
    #[inline(always)]
    fn range(&self, [x, y]: [Interval; 2]) -> Interval {
        let near = self.value([Interval::point(x.mig()), Interval::point(y.mig())]);
        near.hull(self.value([Interval::point(x.mag()), Interval::point(y.mag())]))
    }
    /// The slopes are a unit vector of the dual norm, whose length is at most 1 where `p` is 2 or more,
    /// and else at most that of `(1, 1)` over its dual norm, `2^(1/p - 1/2)`.
    fn steepness(&self, x: &[Interval; 2], norms: &[f64; 2], jacobian: f64) -> f64 {
        let longest = libm::exp2((1.0 / self.power() - 0.5).max(0.0)) * (1.0 + 4.0 * f64::EPSILON);
        let partial = self.grad(*x);
        (longest * jacobian).min(partial[0].mag() * norms[0] + partial[1].mag() * norms[1])
    }
}

/// `max(x, 0)` with its corner rounded: 0 up to -1, `x` from 1 on, and between them a convex curve that is
/// its own mirror image, `f(x) - f(-x) = x`.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Ramp {
    /// A parabola: C1.
    Quadratic,
    /// Cubics that meet at 0: C2.
    Cubic,
    /// Quartics that meet at 0: C2, and rounder than cubics at the same width.
    Quartic,
    /// `ln(1 + e^x)`, which only tends to 0 and `x`: smooth to every order.
    Exponential,
}

impl Ramp {
    /// Every ramp with its name in scripts.
    pub const ALL: [(&str, Ramp); 4] = [
        ("quadratic", Ramp::Quadratic),
        ("cubic", Ramp::Cubic),
        ("quartic", Ramp::Quartic),
        ("exponential", Ramp::Exponential),
    ];

    /// What is added to `max(x, 0)` where `e = max(1 - |x|, 0)`.
    #[inline(always)]
    fn bite<R: Real>(&self, e: R) -> R {
        let c = R::of;
        match self {
            Ramp::Quadratic => c(0.25) * e.square(),
            Ramp::Cubic => e.square() * e / c(6.0),
            _ => e.square() * e * (c(4.0) - e) * c(0.0625),
        }
    }

    /// Its derivative in `e`, which rises from 0 to 1/2.
    #[inline(always)]
    fn slope<R: Real>(&self, e: R) -> R {
        let c = R::of;
        match self {
            Ramp::Quadratic => c(0.5) * e,
            Ramp::Cubic => c(0.5) * e.square(),
            _ => e.square() * (c(3.0) - e) * c(0.25),
        }
    }

    /// Its second derivative.
    #[inline(always)]
    fn bend<R: Real>(&self, e: R) -> R {
        let c = R::of;
        match self {
            Ramp::Quadratic => c(0.5),
            Ramp::Cubic => e,
            _ => (c(1.0) - (c(1.0) - e).square()) * c(0.75),
        }
    }

    /// The slope at `x` where that is below zero, and 1/2 above.
    #[inline(always)]
    fn side<R: Real>(&self, x: R) -> R {
        self.slope((R::of(1.0) + x).max(R::of(0.0)).min(R::of(1.0))).min(R::of(0.5))
    }
}

/// `max(1 - |x|, 0)`
#[inline(always)]
fn hat<R: Real>(x: R) -> R {
    (R::of(1.0) - x.abs()).max(R::of(0.0))
}

impl Function<1> for Ramp {
    fn class(&self) -> Class {
        if *self == Ramp::Quadratic { Class::C1 } else { Class::C2 }
    }
    #[inline(always)]
    fn value<R: Real>(&self, [x]: [R; 1]) -> R {
        let (zero, one) = (R::of(0.0), R::of(1.0));
        match self {
            Ramp::Exponential => x.max(zero) + (one + (-x.abs()).exp()).ln(),
            _ => x.max(zero) + self.bite(hat(x)),
        }
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x]: [R; 1]) -> [R; 1] {
        let (half, one) = (R::of(0.5), R::of(1.0));
        if let Ramp::Exponential = self {
            return [one / (one + (-x).exp())];
        }
        // Either side alone moves, while the other is 1/2: written down as an expression, the slope has no jump.
        [self.side(x) + (half - self.side(-x))]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [x]: [R; 1]) -> [[R; 1]; 1] {
        if let Ramp::Exponential = self {
            let far = (-x.abs()).exp();
            return [[far / (R::of(1.0) + far).square()]];
        }
        [[R::of(1.0).if_less(x.abs(), R::of(0.0), self.bend(hat(x)))]]
    }
    /// Rising, so its ends bound it.
    #[inline(always)]
    fn range(&self, [x]: [Interval; 1]) -> Interval {
        let (low, high) = (self.value([Interval::point(x.lo)]), self.value([Interval::point(x.hi)]));
        Interval { lo: low.lo.max(0.0), hi: high.hi }
    }
    fn form(&self, x: &[Interval; 1], _: Combine<'_, 1>) -> Form<1> {
        Form::taylor(self, x[0])
    }
}

/// The smaller of two with the corner between them rounded over a width `w`, `x - w ramp((x - y) / w)`: where they
/// differ by `w` or more it is the smaller one, and its argument alone.
///
/// The width is a part of the operation, and not a matter of three products around it, so that nothing is left of
/// a corner that is far away.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Melt {
    /// The profile of the corner.
    pub ramp: Ramp,
    /// The bits of the width.
    bits: u64,
}

impl Melt {
    /// A corner of a width above zero.
    pub const fn new(ramp: Ramp, width: f64) -> Melt {
        Melt { ramp, bits: width.to_bits() }
    }

    /// The width.
    pub const fn width(&self) -> f64 {
        f64::from_bits(self.bits)
    }

    /// The difference from which on the smaller one is all that counts, down to the last bit: of the
    /// exponential ramp `1 + e^-40` is 1. A hair more than that, for the roundings of a quotient.
    pub fn reach(&self) -> f64 {
        (1.0 + 1e-12) * self.width() * if self.ramp == Ramp::Exponential { 40.0 } else { 1.0 }
    }

    /// A difference in widths.
    #[inline(always)]
    fn apart<R: Real>(&self, x: R, y: R) -> R {
        (x - y) * R::of(1.0 / self.width())
    }
}

impl Function<2> for Melt {
    fn class(&self) -> Class {
        self.ramp.class()
    }
    fn shares(&self) -> Option<Interval> {
        Some(Interval::point(1.0))
    }
    #[inline(always)]
    fn value<R: Real>(&self, [x, y]: [R; 2]) -> R {
        let far = self.apart(x, y).abs();
        let bite = match self.ramp {
            Ramp::Exponential => (R::of(1.0) + (-far).exp()).ln(),
            _ => self.ramp.bite((R::of(1.0) - far).max(R::of(0.0))),
        };
        x.min(y) - R::of(self.width()) * bite
    }
    /// Two shares that make up 1.
    #[inline(always)]
    fn grad<R: Real>(&self, [x, y]: [R; 2]) -> [R; 2] {
        let [share] = self.ramp.grad([self.apart(y, x)]);
        [share, R::of(1.0) - share]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [x, y]: [R; 2]) -> [[R; 2]; 2] {
        let [[bend]] = self.ramp.hess([self.apart(x, y)]);
        let bend = bend * R::of(1.0 / self.width());
        [[-bend, bend], [bend, -bend]]
    }
    /// Grows with either, so its corners bound it.
    #[inline(always)]
    fn range(&self, [x, y]: [Interval; 2]) -> Interval {
        let low = self.value([Interval::point(x.lo), Interval::point(y.lo)]);
        let high = self.value([Interval::point(x.hi), Interval::point(y.hi)]);
        Interval { lo: low.lo, hi: high.hi }
    }
    /// A difference is off by three roundoffs of its size, as are what slopes of at most 1 make of it, and a polynomial
    /// or a logarithm adds five. Squares of sizes beyond 1e140 are no numbers.
    #[inline(always)]
    fn seam(&self, x: &[f64; 2], apart: Interval) -> Option<Seam> {
        let (size, width) = (x[0].abs() + x[1].abs(), self.width());
        let ordinary = (size < 1e140) & (width > 1e-140) & (width < 1e140);
        let blur = if ordinary { 16.0 * ROUNDOFF } else { f64::NAN };
        let [[bend]] = self.ramp.hess([apart * (1.0 / width)]);
        Some(Seam { reach: self.reach(), bend: -(bend * (1.0 / width)), blur: [blur * (size + width), blur] })
    }
    /// A mean of two gradients is no longer than the longer one.
    fn steepness(&self, x: &[Interval; 2], norms: &[f64; 2], _: f64) -> f64 {
        if x[0].hi + self.reach() < x[1].lo {
            norms[0]
        } else if x[1].hi + self.reach() < x[0].lo {
            norms[1]
        } else {
            norms[0].max(norms[1])
        }
    }
}

/// `max(x, 0)^n`, a power that ends at zero, with `n - 1` continuous derivatives there. Polynomials in it
/// end as smoothly.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Plus {
    /// The exponent, 2 or more.
    pub n: i32,
}

impl Function<1> for Plus {
    fn class(&self) -> Class {
        if self.n < 3 { Class::C1 } else { Class::C2 }
    }
    #[inline(always)]
    fn value<R: Real>(&self, [x]: [R; 1]) -> R {
        x.max(R::of(0.0)).powi(self.n)
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x]: [R; 1]) -> [R; 1] {
        [R::of(f64::from(self.n)) * x.max(R::of(0.0)).powi(self.n - 1)]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [x]: [R; 1]) -> [[R; 1]; 1] {
        let (n, zero) = (f64::from(self.n), R::of(0.0));
        [[zero.if_less(x, R::of(n * (n - 1.0)) * x.max(zero).powi(self.n - 2), zero)]]
    }
    fn form(&self, x: &[Interval; 1], _: Combine<'_, 1>) -> Form<1> {
        Form::taylor(self, x[0])
    }
}

/// Distance to the nearest even whole number: a wave of straight lines between 0 and 1.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Zigzag;

impl Zigzag {
    /// How far above the even number below, from 0 to 2.
    #[inline(always)]
    fn phase<R: Real>(x: R) -> R {
        x - R::of(2.0) * (x * R::of(0.5)).floor()
    }
}

impl Function<1> for Zigzag {
    fn is_even(&self) -> bool {
        true
    }
    fn class(&self) -> Class {
        Class::C0
    }
    #[inline(always)]
    fn value<R: Real>(&self, [x]: [R; 1]) -> R {
        let above = Self::phase(x.abs());
        above.min(R::of(2.0) - above)
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x]: [R; 1]) -> [R; 1] {
        [Self::phase(x).if_less(R::of(1.0), R::of(1.0), R::of(-1.0))]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [x]: [R; 1]) -> [[R; 1]; 1] {
        [[x.slope_of_floor()]]
    }
    /// Its ends, and the turning points between them.
    fn range(&self, [x]: [Interval; 1]) -> Interval {
        let ends = [x.lo, x.hi].map(|end| self.value([Interval::point(end)]));
        let has_even = |x: Interval| (0.5 * x.lo).ceil() <= (0.5 * x.hi).floor();
        let Interval { lo, hi } = ends[0].hull(ends[1]).meet(Interval::UNIT);
        Interval {
            lo: if has_even(x) { 0.0 } else { lo },
            hi: if has_even(x - Interval::point(1.0)) { 1.0 } else { hi },
        }
    }
}
