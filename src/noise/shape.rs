//! The pointwise functions out of which fractals combine their octaves.
//!
//! Each is stated once, like every [`Function`], and is thereby known to every kind of number.

use super::fractal::Term;
use crate::num::{Class, Combine, Form, Function, Interval, ROUNDOFF, Real};

/// `x (base + gain y)`: an octave's signal `y` acting on what came before.
#[derive(Clone, Copy, Debug)]
pub(super) struct Modulate {
    pub base: f64,
    pub gain: f64,
}

impl Modulate {
    /// `x y`
    pub(super) const PRODUCT: Modulate = Modulate { base: 0.0, gain: 1.0 };
}

impl Function<2> for Modulate {
    #[inline(always)]
    fn value<R: Real>(&self, [x, y]: [R; 2]) -> R {
        x * (R::of(self.base) + R::of(self.gain) * y)
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x, y]: [R; 2]) -> [R; 2] {
        [R::of(self.base) + R::of(self.gain) * y, R::of(self.gain) * x]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, _: [R; 2]) -> [[R; 2]; 2] {
        let (zero, gain) = (R::of(0.0), R::of(self.gain));
        [[zero, gain], [gain, zero]]
    }
    /// Bilinear, so the quadratic form is exact up to the rounding of its slopes.
    fn form(&self, x: &[Interval; 2], _: Combine<'_, 2>) -> Form<2> {
        let c = x.map(Interval::mid);
        let slope = self.grad(c);
        let size = self.base.abs() + self.gain.abs() * (x[0].mag() + x[1].mag());
        let error = 8.0 * ROUNDOFF * size * (x[0].rad() + x[1].rad());
        let rest = self.value(c.map(Interval::point)) + Interval::radius(error);
        Form { slope, rest, bend: Interval::point(1.0), matrix: self.hess(c) }
    }
}

/// Slope of the chord of `|x|`, and how far it rises above the function.
#[inline(always)]
fn chord_of_abs(x: Interval) -> (f64, f64) {
    if x.lo >= 0.0 {
        (1.0, 0.0)
    } else if x.hi <= 0.0 {
        (-1.0, 0.0)
    } else {
        ((x.lo + x.hi) / x.width(), -2.0 * x.lo * x.hi / x.width())
    }
}

/// `|x|`: a noise folded at its zeros (turbulence, Perlin 1985).
#[derive(Clone, Copy, Debug)]
pub(super) struct Fold;

impl Function<1> for Fold {
    fn class(&self) -> Class {
        Class::C0
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
    /// Convex, so it lies between its chord and the parallel to it through the origin.
    #[inline(always)]
    fn form(&self, [x]: &[Interval; 1], _: Combine<'_, 1>) -> Form<1> {
        if !x.is_finite() {
            return Form::constant(self.range([*x]));
        }
        let (slope, bow) = chord_of_abs(*x);
        let top = slope * x.mid() + bow;
        let error = 32.0 * ROUNDOFF * x.mag();
        Form::linear([slope], Interval { lo: top - bow - error, hi: top + error })
    }
}

/// `max(1 - |x|, 0)^2`: a ridge along the zeros of a noise (Musgrave).
#[derive(Clone, Copy, Debug)]
pub(super) struct Ridge;

impl Function<1> for Ridge {
    fn class(&self) -> Class {
        Class::C0
    }
    #[inline(always)]
    fn value<R: Real>(&self, [x]: [R; 1]) -> R {
        (R::of(1.0) - x.abs()).max(R::of(0.0)).square()
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x]: [R; 1]) -> [R; 1] {
        let slope = R::of(2.0) * (R::of(1.0) - x.abs()).max(R::of(0.0));
        [x.if_less(R::of(0.0), slope, -slope)]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [x]: [R; 1]) -> [[R; 1]; 1] {
        [[x.abs().if_less(R::of(1.0), R::of(2.0), R::of(0.0)) + x.slope_of_jump()]]
    }
    /// `(1 - |x|)^2 = 1 + x^2 - 2 |x|`, less `(1 - |x|)^2` where `|x| > 1`. The square is exact and
    /// `|x|` has the chord `s x`, above which it rises by `-2 a b / (b - a)` at most.
    #[inline(always)]
    fn form(&self, [x]: &[Interval; 1], _: Combine<'_, 1>) -> Form<1> {
        if !x.is_finite() || x.mag() > 2.0 {
            return Form::constant(self.range([*x]));
        }
        let (slope, bow) = chord_of_abs(*x);
        let c = x.mid();
        let beyond = (x.mag() - 1.0).max(0.0);
        let top = 1.0 + c * c - 2.0 * slope * c;
        let rest = Interval::new(top - 2.0 * bow - beyond * beyond, top);
        // No term is larger than 8, and there are ten.
        let rest = Interval { lo: rest.lo - 128.0 * ROUNDOFF, hi: rest.hi + 128.0 * ROUNDOFF };
        Form { slope: [2.0 * (c - slope)], rest, bend: Interval::point(2.0), matrix: [[1.0]] }
    }
}

/// `min(max(x, 0), 1)`
#[derive(Clone, Copy, Debug)]
pub(super) struct Saturate;

impl Function<1> for Saturate {
    fn class(&self) -> Class {
        Class::C0
    }
    #[inline(always)]
    fn value<R: Real>(&self, [x]: [R; 1]) -> R {
        x.max(R::of(0.0)).min(R::of(1.0))
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x]: [R; 1]) -> [R; 1] {
        let (zero, one) = (R::of(0.0), R::of(1.0));
        [x.if_less(zero, zero, x.if_less(one, one, zero))]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [x]: [R; 1]) -> [[R; 1]; 1] {
        [[x.slope_of_jump() + (x - R::of(1.0)).slope_of_jump()]]
    }
    /// Along the chord the function departs most at an end or at a corner, being linear between.
    fn form(&self, [x]: &[Interval; 1], _: Combine<'_, 1>) -> Form<1> {
        let at = |e: f64| self.value([e]);
        let slope = (at(x.hi) - at(x.lo)) / x.width();
        if !slope.is_finite() {
            return Form::constant(self.range([*x]));
        }
        let above = |e: f64| Interval::point(at(e)) - Interval::point(e) * slope;
        let mut bow = above(x.lo).hull(above(x.hi));
        for corner in [0.0, 1.0] {
            if x.contains(corner) {
                bow = bow.hull(above(corner));
            }
        }
        Form::linear([slope], bow + Interval::point(x.mid()) * slope)
    }
}

/// Weight of an octave for a footprint `s`: 1 up to `gone / 2`, 0 from `gone` on, smooth between.
///
/// It falls like a smoothstep of `2 - 2 s / gone`: a polynomial in `s`, so that enclosures are
/// tight, and C1, so that nothing pops as a camera moves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fade {
    pub gone: f64,
}

impl Fade {
    /// Whether the octave is whole, or gone, for all footprints in a range, beyond any rounding:
    /// then its weight is exactly 1, or 0, and need not be computed.
    pub(super) fn plateau(&self, footprint: Interval) -> Option<f64> {
        if self.is_whole(footprint.hi) {
            Some(1.0)
        } else if self.is_gone(footprint.lo) {
            Some(0.0)
        } else {
            None
        }
    }

    /// [`plateau`](Self::plateau) at a point.
    #[inline(always)]
    pub(super) fn is_whole(&self, s: f64) -> bool {
        s <= 0.5 * self.gone * (1.0 - 1e-12)
    }

    /// Likewise.
    #[inline(always)]
    pub(super) fn is_gone(&self, s: f64) -> bool {
        s >= self.gone * (1.0 + 1e-12)
    }

    #[inline(always)]
    fn position<R: Real>(&self, s: R) -> R {
        (R::of(2.0) - R::of(2.0 / self.gone) * s).max(R::of(0.0)).min(R::of(1.0))
    }
}

impl Function<1> for Fade {
    fn class(&self) -> Class {
        Class::C1
    }
    #[inline(always)]
    fn value<R: Real>(&self, [s]: [R; 1]) -> R {
        let t = self.position(s);
        t.square() * (R::of(3.0) - R::of(2.0) * t)
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [s]: [R; 1]) -> [R; 1] {
        let t = self.position(s);
        [R::of(-12.0 / self.gone) * t * (R::of(1.0) - t)]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [s]: [R; 1]) -> [[R; 1]; 1] {
        let t = R::of(2.0) - R::of(2.0 / self.gone) * s;
        let (zero, one) = (R::of(0.0), R::of(1.0));
        let inside = R::of(4.0 / (self.gone * self.gone)) * (R::of(6.0) - R::of(12.0) * t);
        [[t.if_less(zero, zero, one.if_less(t, zero, inside))]]
    }
    /// Falling, so its ends bound it; exactly 0 or 1 on the plateaus, where octaves can be skipped.
    fn range(&self, [s]: [Interval; 1]) -> Interval {
        let t = self.position(s);
        if t.hi == 0.0 || t.lo == 1.0 {
            return Interval::point(t.lo);
        }
        // The polynomial is monotone and has a handful of roundings; t is off by a few more.
        let [hi, lo] = [t.hi, t.lo].map(|t| t * t * (3.0 - 2.0 * t));
        Interval::around(lo, 16.0 * ROUNDOFF).hull(Interval::around(hi, 16.0 * ROUNDOFF)).meet(Interval::UNIT)
    }
    #[inline(always)]
    fn form(&self, x: &[Interval; 1], _: Combine<'_, 1>) -> Form<1> {
        let range = self.range(*x);
        if range.width() == 0.0 { Form::constant(range) } else { Form::taylor(self, x[0]) }
    }
}

/// `exp(-rate H)`: the amplitude `r^(-i H)` of octave `i`, with `rate = i ln r`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gain {
    pub rate: f64,
}

impl Function<1> for Gain {
    #[inline(always)]
    fn value<R: Real>(&self, [h]: [R; 1]) -> R {
        (R::of(-self.rate) * h).exp()
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [h]: [R; 1]) -> [R; 1] {
        [R::of(-self.rate) * self.value([h])]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [h]: [R; 1]) -> [[R; 1]; 1] {
        [[R::of(self.rate).square() * self.value([h])]]
    }
    /// Convex; the slope `-rate exp(-rate h)` is that of the chord where `h = -ln(-chord / rate) / rate`.
    fn form(&self, [h]: &[Interval; 1], _: Combine<'_, 1>) -> Form<1> {
        Form::chord(self, *h, |chord| -libm::log(-chord / self.rate) / self.rate)
    }
}

/// What a footprint leaves of the amplitudes of some octaves: `sum a_i w_i(s)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Remaining<'a> {
    pub terms: &'a [Term],
}

impl Remaining<'_> {
    #[inline(always)]
    fn sum<R: Real>(&self, part: impl Fn(&Fade) -> R) -> R {
        self.terms.iter().fold(R::of(0.0), |sum, t| sum + R::of(t.amplitude) * part(&t.fade))
    }
}

impl Function<1> for Remaining<'_> {
    fn class(&self) -> Class {
        Class::C1
    }
    fn value<R: Real>(&self, [s]: [R; 1]) -> R {
        self.sum(|fade| fade.value([s]))
    }
    fn grad<R: Real>(&self, [s]: [R; 1]) -> [R; 1] {
        [self.sum(|fade| fade.grad([s])[0])]
    }
    fn hess<R: Real>(&self, [s]: [R; 1]) -> [[R; 1]; 1] {
        [[self.sum(|fade| fade.hess([s])[0][0])]]
    }
    /// Most octaves are whole or gone, which is told at once.
    fn range(&self, [s]: [Interval; 1]) -> Interval {
        let mut sum = Interval::point(0.0);
        for term in self.terms {
            sum = match term.fade.plateau(s) {
                Some(0.0) => continue,
                Some(_) => sum + Interval::point(term.amplitude),
                None => sum + Interval::point(term.amplitude) * term.fade.range([s]),
            };
        }
        sum
    }
    /// It multiplies a quantity of which only the range is known; its own slope would say no more.
    fn is_vague(&self) -> bool {
        true
    }
    fn form(&self, s: &[Interval; 1], _: Combine<'_, 1>) -> Form<1> {
        Form::constant(self.range(*s))
    }
}
