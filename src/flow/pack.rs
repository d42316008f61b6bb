//! Numbers of balls that are followed side by side: arithmetic is lane by lane, so that it becomes that of vectors.

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

/// Balls side by side.
pub(super) const BALLS: usize = 8;

/// A number of each ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pack(pub [f64; BALLS]);

impl Pack {
    pub const ZERO: Pack = Pack([0.0; BALLS]);
    pub const ONE: Pack = Pack([1.0; BALLS]);

    #[inline(always)]
    pub fn from_fn(f: impl Fn(usize) -> f64) -> Pack {
        let mut out = [0.0; BALLS];
        for i in 0..BALLS {
            out[i] = f(i);
        }
        Pack(out)
    }

    #[inline(always)]
    fn zip(self, other: Pack, f: impl Fn(f64, f64) -> f64) -> Pack {
        Pack::from_fn(
            #[inline(always)]
            |i| f(self.0[i], other.0[i]),
        )
    }

    #[inline(always)]
    pub fn sqrt(self) -> Pack {
        Pack::from_fn(
            #[inline(always)]
            |i| self.0[i].sqrt(),
        )
    }

    #[inline(always)]
    pub fn abs(self) -> Pack {
        Pack::from_fn(
            #[inline(always)]
            |i| self.0[i].abs(),
        )
    }

    /// One over each.
    #[inline(always)]
    pub fn inverse(self) -> Pack {
        Pack::from_fn(
            #[inline(always)]
            |i| 1.0 / self.0[i],
        )
    }

    #[inline(always)]
    pub fn larger(self, other: Pack) -> Pack {
        self.zip(
            other,
            #[inline(always)]
            |a, b| if a >= b { a } else { b },
        )
    }

    /// The smaller of two bounds. One that is no number, as what is unbounded times zero, bounds nothing.
    #[inline(always)]
    pub fn least(self, other: Pack) -> Pack {
        self.zip(
            other,
            #[inline(always)]
            |a, b| if a <= b || b.is_nan() { a } else { b },
        )
    }

    /// The smaller of two bounds, and infinity where that is the other one.
    #[inline(always)]
    pub fn least_or_loose(self, other: Pack) -> (Pack, Pack) {
        let loose = self.zip(
            other,
            #[inline(always)]
            |a, b| if a <= b { 0.0 } else { f64::INFINITY },
        );
        (self.least(other), loose)
    }

    /// `self / divisor` where both are above zero, else zero.
    #[inline(always)]
    pub fn positive_quotient(self, divisor: Pack) -> Pack {
        self.zip(
            divisor,
            #[inline(always)]
            |a, b| if a > 0.0 && b > 0.0 { a / b } else { 0.0 },
        )
    }
}

impl Default for Pack {
    #[inline(always)]
    fn default() -> Pack {
        Pack::ZERO
    }
}

/// Implements the operators.
macro_rules! operators {
    ($($op:ident $name:ident),*) => {$(
        impl $op for Pack {
            type Output = Pack;
            #[inline(always)]
            fn $name(self, other: Pack) -> Pack {
                self.zip(
                    other,
                    #[inline(always)]
                    |a, b| a.$name(b),
                )
            }
        }
    )*};
}
operators!(Add add, Sub sub, Mul mul);

impl AddAssign for Pack {
    #[inline(always)]
    fn add_assign(&mut self, other: Pack) {
        *self = *self + other;
    }
}

impl Mul<Pack> for f64 {
    type Output = Pack;
    #[inline(always)]
    fn mul(self, other: Pack) -> Pack {
        Pack::from_fn(
            #[inline(always)]
            |i| self * other.0[i],
        )
    }
}

impl Neg for Pack {
    type Output = Pack;
    #[inline(always)]
    fn neg(self) -> Pack {
        -1.0 * self
    }
}
