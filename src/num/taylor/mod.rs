//! Second-order Taylor expansions over balls, with bounds on all that they leave out.
//!
//! Over a ball, `x(u) = c + r u` with `|u| <= 1`, a quantity is known as
//!
//! ```text
//! f(u)       =  f + g . u              +-  bow_0          f + g . u + u^T H u / 2   +-  bow_1
//! grad f(u)  =  g                      +-  turn_0         g + H u                   +-  turn_1
//! H(u)       =  H                      +-  twist
//! ```
//!
//! and besides as an interval `range`. Derivatives are by `u`, in units of the ball, so that numbers for
//! balls of different sizes are alike; bounds on gradients are Euclidean, those on matrices spectral. The
//! factors `f`, `g`, `H` are what was computed for the centre; what that may have rounded away is in the
//! bounds, and so is what they are not: where a noise turns so often within the ball that its Hessian says
//! nothing, `H` leaves it out, and `turn` and `twist` hold all of it.
//!
//! This is what the search for critical points asks of a field (Gamito 2009, 8.4, uses intervals). One
//! evaluation says whether the gradient can vanish in the ball (`|g| > turn_0`, or axis by axis with `H`),
//! whether it can vanish twice (not where the smallest eigenvalue of `H` exceeds `twist`), and whether it
//! does (Krawczyk's test with `turn_1`). Affine arithmetic with the gradient as a number of its own would
//! say no more, and would have three times the work.
//!
//! **Functions** (`lift.rs`) need no more than the two derivatives that they state: how much these vary over
//! the ball stands for the third. **Kernels** (`kernel.rs`) have bounds for every order.

mod batch;
mod kernel;
mod lift;

use super::interval::choose;
use super::{Interval, ROUNDOFF};
pub use batch::Taylors;

/// A quantity over a ball; see the module text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taylor {
    /// The value in the centre.
    pub value: f64,
    /// The gradient there.
    pub grad: [f64; 3],
    /// Second derivatives there: xx, yy, zz, xy, xz, yz.
    pub hess: [f64; 6],
    /// How far values may be from the expansion to first and to second order.
    pub bow: [f64; 2],
    /// How far gradients may be from the one in the centre, and from their expansion.
    pub turn: [f64; 2],
    /// How far second derivatives may be from those in the centre, as a matrix.
    pub twist: f64,
    /// Encloses the values.
    pub range: Interval,
}

/// Covers the roundings of the at most sixty operations inside a bound.
const ROUND_UP: f64 = 1.0 + 64.0 * ROUNDOFF;

/// Covers products that are too small to be represented.
const TINY: f64 = 1e-300;

/// The smaller of two bounds. One that is no number bounds nothing.
#[inline(always)]
fn least(a: f64, b: f64) -> f64 {
    choose(a <= b, a, b)
}

/// Length of a vector, rounded up.
#[inline(always)]
fn length([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt() * ROUND_UP
}

/// Bound on the spectral norm of a symmetric matrix xx, yy, zz, xy, xz, yz: its Frobenius norm, or its largest row sum.
#[inline(always)]
pub fn spectral([xx, yy, zz, xy, xz, yz]: [f64; 6]) -> f64 {
    let square = xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + xz * xz + yz * yz);
    let (xy, xz, yz) = (xy.abs(), xz.abs(), yz.abs());
    let rows = [xx.abs() + xy + xz, xy + yy.abs() + yz, xz + yz + zz.abs()];
    let larger = |a: f64, b: f64| choose(a > b, a, b);
    least(square.sqrt(), larger(larger(rows[0], rows[1]), rows[2])) * ROUND_UP
}

impl Taylor {
    /// A number that is `c` everywhere.
    #[inline(always)]
    fn constant(c: f64) -> Self {
        let range = Interval::point(c);
        Taylor { value: c, grad: [0.0; 3], hess: [0.0; 6], bow: [0.0; 2], turn: [0.0; 2], twist: 0.0, range }
    }

    /// A coordinate over the ball around `mid`.
    #[inline(always)]
    fn coordinate(mid: f64, radius: f64, axis: usize) -> Self {
        let mut out = Taylor::constant(mid);
        out.grad[axis] = radius;
        out.range = Interval::around(mid, radius);
        out
    }

    /// The same on the disc or the diameter of the ball along these axes. Along others the quantity has a minimum in
    /// the middle, as sharp as any of its bends: that makes its critical points, and what they are, those that
    /// it has on the disc.
    pub fn on(&self, free: [bool; 3]) -> Self {
        let mut out = *self;
        let held = |axis: usize| !free[axis];
        for (i, [a, b]) in [[0, 1], [0, 2], [1, 2]].into_iter().enumerate() {
            out.hess[3 + i] = choose(held(a) | held(b), 0.0, out.hess[3 + i]);
        }
        let sharp = 2.0 * self.curvature() + TINY;
        for axis in 0..3 {
            out.grad[axis] = choose(held(axis), 0.0, out.grad[axis]);
            out.hess[axis] = choose(held(axis), sharp, out.hess[axis]);
        }
        out
    }

    /// A coordinate along a line through the middle, that goes so far along this axis, to either side: all that
    /// varies is the first of the ball's coordinates. Lines that a few roundings part from it count as well.
    #[inline(always)]
    fn along(mid: f64, half: f64) -> Self {
        let mut out = Taylor::constant(mid);
        out.grad[0] = half;
        out.range = Interval::around(mid, half.abs() + 4.0 * ROUNDOFF * mid.abs());
        out.charged(4.0)
    }

    /// Bound on the gradients' norm.
    #[inline(always)]
    pub fn steepness(&self) -> f64 {
        (length(self.grad) + self.turn[0]) * ROUND_UP
    }

    /// Bound on the second derivatives' norm.
    #[inline(always)]
    pub fn curvature(&self) -> f64 {
        (spectral(self.hess) + self.twist) * ROUND_UP
    }

    /// How far the quantity may be from its value in the centre.
    #[inline(always)]
    fn reach(&self) -> f64 {
        let own = (length(self.grad) + self.bow[0]) * ROUND_UP;
        let (down, up) = (self.value - self.range.lo, self.range.hi - self.value);
        least(own, choose(down > up, down, up).abs() * ROUND_UP)
    }

    /// Charges every factor with so many roundoffs of its size.
    #[inline(always)]
    fn charged(mut self, roundoffs: f64) -> Self {
        let u = roundoffs * ROUNDOFF;
        let [x, y, z] = self.grad;
        let [xx, yy, zz, xy, xz, yz] = self.hess;
        let sum = xx.abs() + yy.abs() + zz.abs() + 2.0 * (xy.abs() + xz.abs() + yz.abs());
        self.blur([u * self.value.abs(), u * (x.abs() + y.abs() + z.abs()), u * sum]);
        self
    }

    /// Makes room for factors that are off by these: the value, the gradient and the Hessian in norm.
    #[inline(always)]
    fn blur(&mut self, [value, grad, hess]: [f64; 3]) {
        self.bow[0] = (self.bow[0] + value + grad) * ROUND_UP + TINY;
        self.bow[1] = (self.bow[1] + value + grad + hess) * ROUND_UP + TINY;
        self.turn[0] = (self.turn[0] + grad) * ROUND_UP;
        self.turn[1] = (self.turn[1] + grad + hess) * ROUND_UP;
        self.twist = (self.twist + hess) * ROUND_UP;
    }

    /// The range is what both the expansion and `known` allow.
    #[inline(always)]
    fn narrowed(mut self, known: Interval) -> Self {
        let reach = (length(self.grad) + self.bow[0]) * ROUND_UP;
        let own = Interval::around(self.value, reach);
        let whole = own.lo.is_finite() & own.hi.is_finite();
        let met = own.meet(known);
        self.range = Interval { lo: choose(whole, met.lo, known.lo), hi: choose(whole, met.hi, known.hi) };
        self
    }

    #[inline(always)]
    fn plus(&self, o: &Self) -> Self {
        let mut out = *self;
        out.value += o.value;
        for i in 0..3 {
            out.grad[i] += o.grad[i];
        }
        for i in 0..6 {
            out.hess[i] += o.hess[i];
        }
        for i in 0..2 {
            out.bow[i] += o.bow[i];
            out.turn[i] += o.turn[i];
        }
        out.twist += o.twist;
        out.charged(1.0).narrowed(self.range + o.range)
    }

    #[inline(always)]
    fn negated(mut self) -> Self {
        self.value = -self.value;
        for i in 0..3 {
            self.grad[i] = -self.grad[i];
        }
        for i in 0..6 {
            self.hess[i] = -self.hess[i];
        }
        self.range = -self.range;
        self
    }

    #[inline(always)]
    fn times(&self, k: f64) -> Self {
        let (mut out, size) = (*self, k.abs());
        out.value *= k;
        for i in 0..3 {
            out.grad[i] *= k;
        }
        for i in 0..6 {
            out.hess[i] *= k;
        }
        for i in 0..2 {
            out.bow[i] *= size;
            out.turn[i] *= size;
        }
        out.twist *= size;
        out.range = self.range * k;
        // Whole powers of two change exponents alone.
        if k.to_bits() << 12 == 0 && (1.0..f64::MAX).contains(&size) { out } else { out.charged(1.0) }
    }

    #[inline(always)]
    fn shifted(mut self, c: f64) -> Self {
        self.value += c;
        let size = ROUNDOFF * self.value.abs();
        self.bow = [self.bow[0] + size, self.bow[1] + size];
        self.range = self.range + Interval { lo: c, hi: c };
        self
    }
}
