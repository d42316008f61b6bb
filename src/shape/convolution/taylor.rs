//! Numbers that closed forms are written in: plain ones, and second-order Taylor polynomials in x, y, z.

use crate::num::{PAIRS, Point};
use std::ops::{Add, Div, Mul, Sub};

/// What a closed form needs.
pub(super) trait Scalar:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// A constant.
    fn of(c: f64) -> Self;
    /// The coordinate `axis` at a value.
    fn coordinate(x: f64, axis: usize) -> Self;
    /// Square root of a positive number.
    fn sqrt(self) -> Self;
    /// Arc tangent.
    fn atan(self) -> Self;
    /// Value and derivatives, as far as they are known.
    fn point(self) -> Point;

    /// `c` times this.
    fn times(self, c: f64) -> Self {
        Self::of(c) * self
    }
}

impl Scalar for f64 {
    fn of(c: f64) -> f64 {
        c
    }
    fn coordinate(x: f64, _: usize) -> f64 {
        x
    }
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
    fn atan(self) -> f64 {
        libm::atan(self)
    }
    fn point(self) -> Point {
        Point { value: self, ..Point::default() }
    }
}

/// A value with its first and second derivatives.
#[derive(Clone, Copy)]
pub(super) struct Taylor(Point);

impl Taylor {
    /// `f` of this, from the value and the derivatives of `f` there.
    fn through(self, f: f64, first: f64, second: f64) -> Taylor {
        let Point { grad, hess, .. } = self.0;
        Taylor(Point {
            value: f,
            grad: grad.map(|g| first * g),
            hess: std::array::from_fn(|k| {
                let (r, c) = PAIRS[k];
                first * hess[k] + second * grad[r] * grad[c]
            }),
        })
    }

    fn zip(self, o: Taylor, f: impl Fn(f64, f64) -> f64) -> Taylor {
        let (a, b) = (self.0, o.0);
        Taylor(Point {
            value: f(a.value, b.value),
            grad: std::array::from_fn(|k| f(a.grad[k], b.grad[k])),
            hess: std::array::from_fn(|k| f(a.hess[k], b.hess[k])),
        })
    }
}

impl Add for Taylor {
    type Output = Taylor;
    fn add(self, o: Taylor) -> Taylor {
        self.zip(o, |a, b| a + b)
    }
}

impl Sub for Taylor {
    type Output = Taylor;
    fn sub(self, o: Taylor) -> Taylor {
        self.zip(o, |a, b| a - b)
    }
}

#[allow(clippy::suspicious_arithmetic_impl)] // the product rule
impl Mul for Taylor {
    type Output = Taylor;
    fn mul(self, o: Taylor) -> Taylor {
        let (a, b) = (self.0, o.0);
        Taylor(Point {
            value: a.value * b.value,
            grad: std::array::from_fn(|k| a.value * b.grad[k] + b.value * a.grad[k]),
            hess: std::array::from_fn(|k| {
                let (r, c) = PAIRS[k];
                let cross = a.grad[r] * b.grad[c] + a.grad[c] * b.grad[r];
                a.value * b.hess[k] + b.value * a.hess[k] + cross
            }),
        })
    }
}

impl Div for Taylor {
    type Output = Taylor;
    #[allow(clippy::suspicious_arithmetic_impl)] // by the reciprocal, but for the value
    fn div(self, o: Taylor) -> Taylor {
        let inverse = 1.0 / o.0.value;
        let square = inverse * inverse;
        let product = self * o.through(inverse, -square, 2.0 * square * inverse);
        // The same bits as without derivatives.
        Taylor(Point { value: self.0.value / o.0.value, ..product.0 })
    }
}

impl Scalar for Taylor {
    fn of(c: f64) -> Taylor {
        Taylor(Point { value: c, ..Point::default() })
    }
    fn coordinate(x: f64, axis: usize) -> Taylor {
        let mut point = Point { value: x, ..Point::default() };
        point.grad[axis] = 1.0;
        Taylor(point)
    }
    fn sqrt(self) -> Taylor {
        let root = self.0.value.sqrt();
        self.through(root, 0.5 / root, -0.25 / (root * self.0.value))
    }
    fn atan(self) -> Taylor {
        let x = self.0.value;
        let slope = 1.0 / (1.0 + x * x);
        self.through(libm::atan(x), slope, -2.0 * x * slope * slope)
    }
    fn point(self) -> Point {
        self.0
    }
}
