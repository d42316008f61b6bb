//! Comparison and rounding: operations with creases and jumps.

use crate::num::{Class, Combine, Form, Function, Interval, ROUNDOFF, Real};

/// `|x|`
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Abs;

impl Function<1> for Abs {
    fn is_even(&self) -> bool {
        true
    }
    #[inline(always)]
    fn bows(&self, x: Interval) -> Option<Interval> {
        Some(x)
    }
    fn class(&self) -> Class {
        Class::C0
    }
    #[inline(always)]
    fn roundoffs(&self) -> Option<f64> {
        Some(0.0)
    }
    #[inline(always)]
    fn value<R: Real>(&self, [x]: [R; 1]) -> R {
        x.abs()
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x]: [R; 1]) -> [R; 1] {
        [x.if_less(R::of(0.0), R::of(-1.0), R::of(1.0))]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [x]: [R; 1]) -> [[R; 1]; 1] {
        [[x.slope_of_jump()]]
    }
    /// Chord slope `s = (a + b) / (b - a)`: `|x| - s x` runs from 0 at the crease to
    /// `-2 a b / (b - a)` at both ends.
    fn form(&self, [x]: &[Interval; 1], _: Combine<'_, 1>) -> Form<1> {
        let c = Interval::point(x.mid());
        if x.lo >= 0.0 {
            return Form::linear([1.0], c);
        }
        if x.hi <= 0.0 {
            return Form::linear([-1.0], -c);
        }
        let slope = (x.lo + x.hi) / x.width();
        if !slope.is_finite() {
            return Form::constant(Real::abs(*x));
        }
        let ends = [x.lo, x.hi].map(|e| Interval::point(e.abs()) - Interval::point(e) * slope);
        Form::linear([slope], ends[0].hull(ends[1]).hull(Interval::point(0.0)) + c * slope)
    }
}

/// Form of `y + g(x - y)` where `g` is linear on either side of zero and zero there (`min(d, 0)`
/// or `max(d, 0)`), with the range `gap` of `x - y`, which correlated arguments keep narrow.
fn switch(x: &[Interval; 2], gap: Interval, g: fn(f64) -> f64) -> Form<2> {
    let [cx, cy] = x.map(|x| Interval::point(x.mid()));
    let slope = (g(gap.hi) - g(gap.lo)) / gap.width();
    if !slope.is_finite() {
        return Form::constant(Interval::new(f64::NEG_INFINITY, f64::INFINITY));
    }
    let ends = [gap.lo, gap.hi].map(|d| Interval::point(g(d)) - Interval::point(d) * slope);
    let crease = ends[0].hull(ends[1]).hull(Interval::point(0.0));
    let other = 1.0 - slope;
    // `other` is rounded: what it loses is charged over the whole of y.
    let lost = (Interval::point(1.0) - Interval::point(slope) - Interval::point(other)) * x[1];
    Form::linear([slope, other], crease + cx * slope + cy * other + lost)
}

/// The smaller of two.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Min;

impl Function<2> for Min {
    fn class(&self) -> Class {
        Class::C0
    }
    fn selects(&self) -> bool {
        true
    }
    fn shares(&self) -> Option<Interval> {
        Some(Interval::point(1.0))
    }
    #[inline(always)]
    fn value<R: Real>(&self, [x, y]: [R; 2]) -> R {
        x.min(y)
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x, y]: [R; 2]) -> [R; 2] {
        let (zero, one) = (R::of(0.0), R::of(1.0));
        [x.if_less(y, one, zero), x.if_less(y, zero, one)]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [x, y]: [R; 2]) -> [[R; 2]; 2] {
        [[(x - y).slope_of_jump(); 2]; 2]
    }
    fn steepness(&self, x: &[Interval; 2], norms: &[f64; 2], _: f64) -> f64 {
        if x[0].hi < x[1].lo {
            norms[0]
        } else if x[1].hi < x[0].lo {
            norms[1]
        } else {
            norms[0].max(norms[1])
        }
    }
    fn form(&self, x: &[Interval; 2], combine: Combine<'_, 2>) -> Form<2> {
        let gap = combine(&[1.0, -1.0]);
        if gap.hi <= 0.0 {
            return Form::linear([1.0, 0.0], Interval::point(x[0].mid()));
        }
        if gap.lo >= 0.0 {
            return Form::linear([0.0, 1.0], Interval::point(x[1].mid()));
        }
        switch(x, gap, |d| d.min(0.0))
    }
}

/// The larger of two.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Max;

impl Function<2> for Max {
    fn class(&self) -> Class {
        Class::C0
    }
    fn selects(&self) -> bool {
        true
    }
    fn shares(&self) -> Option<Interval> {
        Some(Interval::point(1.0))
    }
    #[inline(always)]
    fn value<R: Real>(&self, [x, y]: [R; 2]) -> R {
        x.max(y)
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x, y]: [R; 2]) -> [R; 2] {
        let (zero, one) = (R::of(0.0), R::of(1.0));
        [y.if_less(x, one, zero), y.if_less(x, zero, one)]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [x, y]: [R; 2]) -> [[R; 2]; 2] {
        [[(x - y).slope_of_jump(); 2]; 2]
    }
    fn steepness(&self, x: &[Interval; 2], norms: &[f64; 2], _: f64) -> f64 {
        if x[0].lo > x[1].hi {
            norms[0]
        } else if x[1].lo > x[0].hi {
            norms[1]
        } else {
            norms[0].max(norms[1])
        }
    }
    fn form(&self, x: &[Interval; 2], combine: Combine<'_, 2>) -> Form<2> {
        let gap = combine(&[1.0, -1.0]);
        if gap.lo >= 0.0 {
            return Form::linear([1.0, 0.0], Interval::point(x[0].mid()));
        }
        if gap.hi <= 0.0 {
            return Form::linear([0.0, 1.0], Interval::point(x[1].mid()));
        }
        switch(x, gap, |d| d.max(0.0))
    }
}

/// `min(max(x, low), high)`
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Clamp;

impl Function<3> for Clamp {
    fn class(&self) -> Class {
        Class::C0
    }
    #[inline(always)]
    fn value<R: Real>(&self, [x, low, high]: [R; 3]) -> R {
        x.max(low).min(high)
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x, low, high]: [R; 3]) -> [R; 3] {
        let [from_x, from_low] = Max.grad([x, low]);
        let [outer, from_high] = Min.grad([x.max(low), high]);
        [outer * from_x, outer * from_low, from_high]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [x, low, high]: [R; 3]) -> [[R; 3]; 3] {
        [[(x - low).slope_of_jump() + (x.max(low) - high).slope_of_jump(); 3]; 3]
    }
    fn apply<T: crate::num::Number>(&self, [x, low, high]: [&T; 3]) -> T {
        T::lift(&Min, [&T::lift(&Max, [x, low]), high])
    }
    fn apply_to<T: crate::num::Number>(&self, x: [&T; 3], out: &mut T) {
        *out = self.apply(x);
    }
}

/// -1, 0 or 1.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Sign;

impl Function<1> for Sign {
    fn class(&self) -> Class {
        Class::Jump
    }
    #[inline(always)]
    fn value<R: Real>(&self, [x]: [R; 1]) -> R {
        let zero = R::of(0.0);
        x.if_less(zero, R::of(-1.0), zero.if_less(x, R::of(1.0), zero))
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x]: [R; 1]) -> [R; 1] {
        [x.slope_of_jump()]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [x]: [R; 1]) -> [[R; 1]; 1] {
        [[x.slope_of_jump()]]
    }
}

/// `step(edge, x)`: 0 where `x < edge`, else 1.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Step;

impl Function<2> for Step {
    fn class(&self) -> Class {
        Class::Jump
    }
    #[inline(always)]
    fn value<R: Real>(&self, [edge, x]: [R; 2]) -> R {
        x.if_less(edge, R::of(0.0), R::of(1.0))
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [edge, x]: [R; 2]) -> [R; 2] {
        [(x - edge).slope_of_jump(); 2]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [edge, x]: [R; 2]) -> [[R; 2]; 2] {
        [[(x - edge).slope_of_jump(); 2]; 2]
    }
}

/// Largest integer not above.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Floor;

impl Function<1> for Floor {
    fn class(&self) -> Class {
        Class::Jump
    }
    #[inline(always)]
    fn value<R: Real>(&self, [x]: [R; 1]) -> R {
        x.floor()
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x]: [R; 1]) -> [R; 1] {
        [x.slope_of_floor()]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [x]: [R; 1]) -> [[R; 1]; 1] {
        [[x.slope_of_floor()]]
    }
}

/// `x - floor(x)`
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Fract;

impl Function<1> for Fract {
    fn class(&self) -> Class {
        Class::Jump
    }
    #[inline(always)]
    fn value<R: Real>(&self, [x]: [R; 1]) -> R {
        x - x.floor()
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x]: [R; 1]) -> [R; 1] {
        [R::of(1.0) + x.slope_of_floor()]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [x]: [R; 1]) -> [[R; 1]; 1] {
        [[x.slope_of_floor()]]
    }
    #[inline(always)]
    fn range(&self, x: [Interval; 1]) -> Interval {
        self.value(x).meet(Interval::UNIT)
    }
}

/// `x - period floor(x / period)`
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Modulo;

impl Function<2> for Modulo {
    fn class(&self) -> Class {
        Class::Jump
    }
    fn is_defined(&self, [_, period]: &[Interval; 2]) -> bool {
        !period.contains(0.0)
    }
    #[inline(always)]
    fn value<R: Real>(&self, [x, period]: [R; 2]) -> R {
        x - period * (x / period).floor()
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x, period]: [R; 2]) -> [R; 2] {
        let turns = x / period;
        let jump = turns.slope_of_floor();
        [R::of(1.0) + jump, -turns.floor() + jump]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [x, period]: [R; 2]) -> [[R; 2]; 2] {
        [[(x / period).slope_of_floor(); 2]; 2]
    }
    #[inline(always)]
    fn range(&self, x: [Interval; 2]) -> Interval {
        // The quotient is rounded once more than the true one, so the result may reach a little
        // beyond the period on either side.
        let reach = x[1].hull(Interval::point(0.0)) + Interval::radius(4.0 * f64::EPSILON * x[0].mag());
        self.value(x).meet(reach)
    }
}

/// `t^2 (3 - 2 t)` with `t` clamped to [0, 1].
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Smoothstep;

impl Function<1> for Smoothstep {
    fn class(&self) -> Class {
        Class::C1
    }
    #[inline(always)]
    fn value<R: Real>(&self, [x]: [R; 1]) -> R {
        let t = x.max(R::of(0.0)).min(R::of(1.0));
        t.square() * (R::of(3.0) - R::of(2.0) * t)
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x]: [R; 1]) -> [R; 1] {
        let t = x.max(R::of(0.0)).min(R::of(1.0));
        [R::of(6.0) * t * (R::of(1.0) - t)]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [x]: [R; 1]) -> [[R; 1]; 1] {
        let (zero, one) = (R::of(0.0), R::of(1.0));
        let inside = R::of(6.0) - R::of(12.0) * x;
        [[x.if_less(zero, zero, one.if_less(x, zero, inside))]]
    }
    /// Rising, so its ends bound it; beyond 0 and 1 it is a number, and nothing is rounded.
    #[inline(always)]
    fn range(&self, [x]: [Interval; 1]) -> Interval {
        let (low, high) = (self.value([Interval::point(x.lo)]), self.value([Interval::point(x.hi)]));
        let Interval { lo, hi } = low.hull(high).meet(Interval::UNIT);
        Interval { lo: if x.lo >= 1.0 { 1.0 } else { lo }, hi: if x.hi <= 0.0 { 0.0 } else { hi } }
    }
    fn form(&self, x: &[Interval; 1], _: Combine<'_, 1>) -> Form<1> {
        Form::taylor(self, x[0])
    }
}

/// `t^3 (10 - 15 t + 6 t^2)` with `t` clamped to [0, 1]: smooth also where it begins and ends (Perlin, *Improving Noise*,
/// 2002).
///
/// With `u = t - 1/2` its derivatives are `30 (1/4 - u^2)^2` and `-120 u (1/4 - u^2)`, where `u` stands but once or twice, so
/// that intervals enclose them closely; and both end at zero by themselves.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Smootherstep;

impl Smootherstep {
    /// `u`, and `1/4 - u^2 = t (1 - t)`.
    #[inline(always)]
    fn halves<R: Real>(x: R) -> [R; 2] {
        let u = x.max(R::of(0.0)).min(R::of(1.0)) - R::of(0.5);
        [u, R::of(0.25) - u.square()]
    }
}

impl Function<1> for Smootherstep {
    #[inline(always)]
    fn value<R: Real>(&self, [x]: [R; 1]) -> R {
        let t = x.max(R::of(0.0)).min(R::of(1.0));
        let rest = R::of(10.0) + t * (R::of(6.0) * t - R::of(15.0));
        (t.square() * t * rest).min(R::of(1.0))
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x]: [R; 1]) -> [R; 1] {
        let [_, both] = Self::halves(x);
        [R::of(30.0) * both.square()]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [x]: [R; 1]) -> [[R; 1]; 1] {
        let [u, both] = Self::halves(x);
        [[R::of(-120.0) * u * both]]
    }
    /// Rising, so its ends bound it, and a hair more: what is in brackets is a small number made of large ones, so that values
    /// are rounded by up to `1e-14` of them.
    #[inline(always)]
    fn range(&self, [x]: [Interval; 1]) -> Interval {
        let (low, high) = (self.value([Interval::point(x.lo)]), self.value([Interval::point(x.hi)]));
        let lo = if x.lo >= 1.0 { 1.0 } else { (low.lo * (1.0 - 1e-14)).max(0.0) };
        let hi = if x.hi <= 0.0 { 0.0 } else { (high.hi * (1.0 + 1e-14)).min(1.0) };
        Interval { lo, hi }
    }
    fn form(&self, x: &[Interval; 1], _: Combine<'_, 1>) -> Form<1> {
        Form::taylor(self, x[0])
    }
}

/// `a + (b - a) t`
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Mix;

impl Function<3> for Mix {
    #[inline(always)]
    fn value<R: Real>(&self, [a, b, t]: [R; 3]) -> R {
        a + (b - a) * t
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [a, b, t]: [R; 3]) -> [R; 3] {
        [R::of(1.0) - t, t, b - a]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, _: [R; 3]) -> [[R; 3]; 3] {
        let (zero, one) = (R::of(0.0), R::of(1.0));
        [[zero, zero, -one], [zero, zero, one], [-one, one, zero]]
    }
    /// Linear in each of the three, so that corners bound it: one end of `t` or the other, and there what `a` and `b` say.
    /// A value is that but for three roundings, of a difference, its product and their sum, which may be larger than it is.
    #[inline(always)]
    fn range(&self, [a, b, t]: [Interval; 3]) -> Interval {
        let at = |t: f64| {
            let t = Interval::point(t);
            a * (Interval::point(1.0) - t) + b * t
        };
        let whole = self.value([a, b, t]);
        let lost = Interval::radius(4.0 * ROUNDOFF * (a.mag() + b.mag()) * (1.0 + t.mag()));
        let corners = at(t.lo).hull(at(t.hi)) + lost;
        if corners.is_finite() { whole.meet(corners) } else { whole }
    }
    #[inline(always)]
    fn is_quadratic(&self) -> bool {
        true
    }
}
