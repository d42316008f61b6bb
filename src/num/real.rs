//! The scalars in which operations are written: `f64` and [`Interval`](super::Interval).
//!
//! Writing the value and derivatives of an operation over `Real` gives the point evaluation and an
//! enclosure of it (the natural interval extension) from the same line of text.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A scalar with the elementary functions.
///
/// For intervals each method encloses the image of the part of its argument that lies in the
/// domain of the function.
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// The scalar that equals `c`.
    fn of(c: f64) -> Self;
    /// `|self|`.
    fn abs(self) -> Self;
    /// `self * self`, non-negative.
    fn square(self) -> Self;
    /// Square root; undefined below zero.
    fn sqrt(self) -> Self;
    /// Integer power.
    fn powi(self, n: i32) -> Self;
    /// `self^p` for `self >= 0`.
    fn powf(self, p: Self) -> Self;
    /// e^self.
    fn exp(self) -> Self;
    /// Natural logarithm; undefined below zero.
    fn ln(self) -> Self;
    /// Sine of an angle in radians.
    fn sin(self) -> Self;
    /// Cosine of an angle in radians.
    fn cos(self) -> Self;
    /// Tangent of an angle in radians.
    fn tan(self) -> Self;
    /// Arc sine in radians; undefined outside [-1, 1].
    fn asin(self) -> Self;
    /// Arc cosine in radians; undefined outside [-1, 1].
    fn acos(self) -> Self;
    /// Arc tangent in radians.
    fn atan(self) -> Self;
    /// Angle of the point `(x, self)` in (-pi, pi].
    fn atan2(self, x: Self) -> Self;
    /// Largest integer not above.
    fn floor(self) -> Self;
    /// The smaller of two; undefined where either is.
    fn min(self, other: Self) -> Self;
    /// The larger of two; undefined where either is.
    fn max(self, other: Self) -> Self;
    /// `then` where `self < other`, else `otherwise`; the hull of both where the scalar cannot tell,
    /// and undefined where `self` or `other` is.
    fn if_less(self, other: Self, then: Self, otherwise: Self) -> Self;
    /// Derivative of a function that is constant except for a jump at zero: 0 away from zero,
    /// everything where zero may lie inside.
    fn slope_of_jump(self) -> Self;
    /// Derivative of `floor`: 0, or everything where an integer may be crossed.
    fn slope_of_floor(self) -> Self;
}

impl Real for f64 {
    #[inline(always)]
    fn of(c: f64) -> Self {
        c
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }
    #[inline(always)]
    fn square(self) -> Self {
        self * self
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    #[inline(always)]
    fn powi(self, n: i32) -> Self {
        power(self, n)
    }
    #[inline(always)]
    fn powf(self, p: Self) -> Self {
        if self < 0.0 { f64::NAN } else { libm::pow(self, p) }
    }
    #[inline(always)]
    fn exp(self) -> Self {
        libm::exp(self)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        libm::log(self)
    }
    #[inline(always)]
    fn sin(self) -> Self {
        libm::sin(self)
    }
    #[inline(always)]
    fn cos(self) -> Self {
        libm::cos(self)
    }
    #[inline(always)]
    fn tan(self) -> Self {
        libm::tan(self)
    }
    #[inline(always)]
    fn asin(self) -> Self {
        libm::asin(self)
    }
    #[inline(always)]
    fn acos(self) -> Self {
        libm::acos(self)
    }
    #[inline(always)]
    fn atan(self) -> Self {
        libm::atan(self)
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        libm::atan2(self, x)
    }
    #[inline(always)]
    fn floor(self) -> Self {
        self.floor()
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // A NaN must come through: an enclosure speaks of the defined part of its argument alone, and
        // would miss whatever value took the place of the rest.
        if self < other || self.is_nan() { self } else { other }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other || self.is_nan() { self } else { other }
    }
    #[inline(always)]
    fn if_less(self, other: Self, then: Self, otherwise: Self) -> Self {
        if self < other {
            then
        } else if self >= other {
            otherwise
        } else {
            f64::NAN
        }
    }
    #[inline(always)]
    fn slope_of_jump(self) -> Self {
        0.0
    }
    #[inline(always)]
    fn slope_of_floor(self) -> Self {
        0.0
    }
}

/// `x^n` by squaring, in a fixed order: `f64::powi` may differ between platforms.
#[inline(always)]
pub fn power<R: Real>(x: R, n: i32) -> R {
    let (mut base, mut power, mut left) = (x, R::of(1.0), n.unsigned_abs());
    while left > 0 {
        if left & 1 == 1 {
            power = power * base;
        }
        base = base * base;
        left >>= 1;
    }
    // A zero is a positive one, as in quotients.
    if n < 0 { R::of(1.0) / (power + R::of(0.0)) } else { power }
}
