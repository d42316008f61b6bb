//! The four rules, squares, roots and powers.

use crate::num::{Class, Combine, Form, Function, Interval, Number, ROUNDOFF, Real};

/// `x + y`
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Add;

impl Function<2> for Add {
    #[inline(always)]
    fn value<R: Real>(&self, [x, y]: [R; 2]) -> R {
        x + y
    }
    #[inline(always)]
    fn grad<R: Real>(&self, _: [R; 2]) -> [R; 2] {
        [R::of(1.0); 2]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, _: [R; 2]) -> [[R; 2]; 2] {
        [[R::of(0.0); 2]; 2]
    }
    #[inline(always)]
    fn apply<T: Number>(&self, [x, y]: [&T; 2]) -> T {
        x.add(y)
    }
    #[inline(always)]
    fn apply_to<T: Number>(&self, [x, y]: [&T; 2], out: &mut T) {
        x.add_to(y, out);
    }
}

/// `x - y`
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Sub;

impl Function<2> for Sub {
    #[inline(always)]
    fn value<R: Real>(&self, [x, y]: [R; 2]) -> R {
        x - y
    }
    #[inline(always)]
    fn grad<R: Real>(&self, _: [R; 2]) -> [R; 2] {
        [R::of(1.0), R::of(-1.0)]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, _: [R; 2]) -> [[R; 2]; 2] {
        [[R::of(0.0); 2]; 2]
    }
    #[inline(always)]
    fn apply<T: Number>(&self, [x, y]: [&T; 2]) -> T {
        x.sub(y)
    }
    #[inline(always)]
    fn apply_to<T: Number>(&self, [x, y]: [&T; 2], out: &mut T) {
        x.sub_to(y, out);
    }
}

/// `-x`
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Neg;

impl Function<1> for Neg {
    #[inline(always)]
    fn value<R: Real>(&self, [x]: [R; 1]) -> R {
        -x
    }
    #[inline(always)]
    fn grad<R: Real>(&self, _: [R; 1]) -> [R; 1] {
        [R::of(-1.0)]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, _: [R; 1]) -> [[R; 1]; 1] {
        [[R::of(0.0)]]
    }
    #[inline(always)]
    fn apply<T: Number>(&self, [x]: [&T; 1]) -> T {
        x.neg()
    }
    #[inline(always)]
    fn apply_to<T: Number>(&self, [x]: [&T; 1], out: &mut T) {
        *out = x.neg();
    }
}

/// `x y`
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Mul;

impl Function<2> for Mul {
    #[inline(always)]
    fn roundoffs(&self) -> Option<f64> {
        Some(1.0)
    }
    #[inline(always)]
    fn value<R: Real>(&self, [x, y]: [R; 2]) -> R {
        x * y
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x, y]: [R; 2]) -> [R; 2] {
        [y, x]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, _: [R; 2]) -> [[R; 2]; 2] {
        let (zero, one) = (R::of(0.0), R::of(1.0));
        [[zero, one], [one, zero]]
    }
    #[inline(always)]
    fn is_quadratic(&self) -> bool {
        true
    }
}

/// `x / y`
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Div;

impl Function<2> for Div {
    fn is_defined(&self, [_, y]: &[Interval; 2]) -> bool {
        !y.contains(0.0)
    }
    /// Four operations in `x (1 / y)^2`.
    #[inline(always)]
    fn roundoffs(&self) -> Option<f64> {
        Some(4.0)
    }
    /// A zero is a positive one, whatever it came from, so that it is known to which end its reciprocal goes.
    #[inline(always)]
    fn value<R: Real>(&self, [x, y]: [R; 2]) -> R {
        x / (y + R::of(0.0))
    }
    #[inline(always)]
    fn range(&self, [x, y]: [Interval; 2]) -> Interval {
        x / y
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x, y]: [R; 2]) -> [R; 2] {
        let r = R::of(1.0) / y;
        [r, -(x * r.square())]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [x, y]: [R; 2]) -> [[R; 2]; 2] {
        let r = R::of(1.0) / y;
        let (zero, xy) = (R::of(0.0), -r.square());
        [[zero, xy], [xy, R::of(2.0) * x * r.square() * r]]
    }
    /// With `q` near `xc / yc`: `x / y = q + (x - q y) / y`, and `1 / y` is `1 / yc` less
    /// `(y - yc) / (y yc)`; so `x / y = q + (x - q y) (1 - (y - yc) / y) / yc`.
    fn form(&self, x: &[Interval; 2], combine: Combine<'_, 2>) -> Form<2> {
        let [xc, yc] = x.map(Interval::mid);
        let (q, r) = (xc / yc, 1.0 / yc);
        if x[1].contains(0.0) || !q.is_finite() || !r.is_finite() {
            return Form::constant(self.range(*x));
        }
        let slope = [r, -q * r];
        let beyond = (x[1] - Interval::point(yc)) / x[1];
        let spread = combine(&[1.0, -q]);
        let rounding: f64 = 8.0 * ROUNDOFF * (r.abs() * x[0].mag() + (q * r).abs() * x[1].mag());
        let at = Interval::point(xc) / Interval::point(yc);
        Form::linear(slope, at - spread * beyond / Interval::point(yc) + Interval::radius(rounding))
    }
}

/// `x^2`
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Square;

impl Function<1> for Square {
    fn is_even(&self) -> bool {
        true
    }
    #[inline(always)]
    fn roundoffs(&self) -> Option<f64> {
        Some(1.0)
    }
    #[inline(always)]
    fn value<R: Real>(&self, [x]: [R; 1]) -> R {
        x.square()
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x]: [R; 1]) -> [R; 1] {
        [R::of(2.0) * x]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, _: [R; 1]) -> [[R; 1]; 1] {
        [[R::of(2.0)]]
    }
    #[inline(always)]
    fn is_quadratic(&self) -> bool {
        true
    }
}

/// Square root; NaN below zero.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Sqrt;

impl Function<1> for Sqrt {
    fn class(&self) -> Class {
        Class::C0 // its slope is unbounded at zero
    }
    fn is_defined(&self, [x]: &[Interval; 1]) -> bool {
        x.lo >= 0.0
    }
    fn is_undefined(&self, [x]: &[Interval; 1]) -> bool {
        x.hi < 0.0
    }
    #[inline(always)]
    fn bows(&self, x: Interval) -> Option<Interval> {
        (x.hi > 0.0).then(|| Interval::new(x.lo.max(0.0), x.hi))
    }
    /// A root, and what divides by it.
    #[inline(always)]
    fn roundoffs(&self) -> Option<f64> {
        Some(4.0)
    }
    #[inline(always)]
    fn value<R: Real>(&self, [x]: [R; 1]) -> R {
        x.sqrt()
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x]: [R; 1]) -> [R; 1] {
        [R::of(0.5) / x.sqrt()]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [x]: [R; 1]) -> [[R; 1]; 1] {
        [[R::of(-0.25) / (x * x.sqrt())]]
    }
    fn form(&self, x: &[Interval; 1], _: Combine<'_, 1>) -> Form<1> {
        if x[0].hi < 0.0 {
            return Form::constant(Interval::ENTIRE);
        }
        // Only the defined part counts; rounding may have pushed a sum of squares below zero.
        let defined = Interval::new(x[0].lo.max(0.0), x[0].hi);
        let form = Form::chord(self, defined, |slope| 0.25 / (slope * slope));
        let moved = (Interval::point(x[0].mid()) - Interval::point(defined.mid())) * form.slope[0];
        Form { rest: form.rest + moved, ..form }
    }
}

/// `x^n` for a fixed integer `n`.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Powi {
    /// The exponent.
    pub n: i32,
}

impl Powi {
    /// `c x^(n - k)`, and exactly zero where `c` is: the derivative of a polynomial that has ended.
    #[inline(always)]
    fn term<R: Real>(&self, c: f64, x: R, k: i32) -> R {
        if c == 0.0 { R::of(0.0) } else { R::of(c) * x.powi(self.n.saturating_sub(k)) }
    }
}

impl Function<1> for Powi {
    fn is_even(&self) -> bool {
        self.n % 2 == 0
    }
    fn is_defined(&self, [x]: &[Interval; 1]) -> bool {
        self.n >= 0 || !x.contains(0.0)
    }
    #[inline(always)]
    fn value<R: Real>(&self, [x]: [R; 1]) -> R {
        x.powi(self.n)
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x]: [R; 1]) -> [R; 1] {
        [self.term(f64::from(self.n), x, 1)]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [x]: [R; 1]) -> [[R; 1]; 1] {
        let n = f64::from(self.n);
        [[self.term(n * (n - 1.0), x, 2)]]
    }
    fn form(&self, x: &[Interval; 1], _: Combine<'_, 1>) -> Form<1> {
        Form::taylor(self, x[0])
    }
}

/// `x^p` for `x >= 0`.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Powf;

impl Function<2> for Powf {
    fn class(&self) -> Class {
        Class::C0 // like a square root at zero, for exponents below one
    }
    fn is_defined(&self, [x, p]: &[Interval; 2]) -> bool {
        x.lo > 0.0 || (x.lo >= 0.0 && p.lo >= 0.0)
    }
    #[inline(always)]
    fn value<R: Real>(&self, [x, p]: [R; 2]) -> R {
        x.powf(p)
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [x, p]: [R; 2]) -> [R; 2] {
        let by_x = p * x.powf(p - R::of(1.0));
        [by_x, x.powf(p) * x.ln()]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [x, p]: [R; 2]) -> [[R; 2]; 2] {
        let one = R::of(1.0);
        let xx = p * (p - one) * x.powf(p - R::of(2.0));
        let xp = x.powf(p - one) * (one + p * x.ln());
        [[xx, xp], [xp, x.powf(p) * x.ln().square()]]
    }
}
