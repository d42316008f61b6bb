//! Circular functions and their inverses, in radians.

use crate::num::{Class, Combine, Form, Function, Interval, Real};

/// Implements an operation of one argument from its value and two derivatives, with a Taylor form.
macro_rules! smooth {
    ($(#[$doc:meta])* $op:ident on $domain:expr, $x:ident => $value:expr, $first:expr, $second:expr) => {
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
        pub struct $op;

        impl Function<1> for $op {
            fn is_defined(&self, [x]: &[Interval; 1]) -> bool {
                $domain.encloses(*x)
            }
            fn is_undefined(&self, [x]: &[Interval; 1]) -> bool {
                x.hi < $domain.lo || x.lo > $domain.hi
            }
            #[inline(always)]
            fn value<R: Real>(&self, [$x]: [R; 1]) -> R {
                $value
            }
            #[inline(always)]
            fn grad<R: Real>(&self, [$x]: [R; 1]) -> [R; 1] {
                [$first]
            }
            #[inline(always)]
            fn hess<R: Real>(&self, [$x]: [R; 1]) -> [[R; 1]; 1] {
                [[$second]]
            }
            fn form(&self, x: &[Interval; 1], _: Combine<'_, 1>) -> Form<1> {
                Form::taylor(self, x[0])
            }
        }
    };
}

smooth!(
    /// Sine.
    Sin on Interval::ENTIRE, x => x.sin(), x.cos(), -x.sin()
);
smooth!(
    /// Cosine.
    Cos on Interval::ENTIRE, x => x.cos(), -x.sin(), -x.cos()
);
smooth!(
    /// Tangent.
    Tan on Interval::ENTIRE, x => x.tan(), R::of(1.0) + x.tan().square(), R::of(2.0) * x.tan() * (R::of(1.0) + x.tan().square())
);
smooth!(
    /// Arc sine; NaN outside [-1, 1].
    Asin on Interval { lo: -1.0, hi: 1.0 }, x => x.asin(),
    R::of(1.0) / (R::of(1.0) - x.square()).sqrt(),
    x / ((R::of(1.0) - x.square()) * (R::of(1.0) - x.square()).sqrt())
);
smooth!(
    /// Arc cosine; NaN outside [-1, 1].
    Acos on Interval { lo: -1.0, hi: 1.0 }, x => x.acos(),
    -(R::of(1.0) / (R::of(1.0) - x.square()).sqrt()),
    -(x / ((R::of(1.0) - x.square()) * (R::of(1.0) - x.square()).sqrt()))
);
smooth!(
    /// Arc tangent.
    Atan on Interval::ENTIRE, x => x.atan(),
    R::of(1.0) / (R::of(1.0) + x.square()),
    R::of(-2.0) * x / (R::of(1.0) + x.square()).square()
);

/// `atan2(y, x)`, the angle of the point `(x, y)`; jumps across the negative x axis.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Atan2;

impl Atan2 {
    /// Zero, or everything where the box meets the cut: the half line `y = 0, x <= 0`.
    #[inline(always)]
    fn cut<R: Real>(y: R, x: R) -> R {
        x.if_less(R::of(f64::MIN_POSITIVE), y.slope_of_jump(), R::of(0.0))
    }
}

impl Function<2> for Atan2 {
    fn class(&self) -> Class {
        Class::Jump
    }
    #[inline(always)]
    fn value<R: Real>(&self, [y, x]: [R; 2]) -> R {
        y.atan2(x)
    }
    #[inline(always)]
    fn grad<R: Real>(&self, [y, x]: [R; 2]) -> [R; 2] {
        let r = R::of(1.0) / (x.square() + y.square());
        let cut = Self::cut(y, x);
        [x * r + cut, cut - y * r]
    }
    #[inline(always)]
    fn hess<R: Real>(&self, [y, x]: [R; 2]) -> [[R; 2]; 2] {
        let r = R::of(1.0) / (x.square() + y.square());
        let (yy, yx) = (R::of(-2.0) * x * y * r.square(), (y.square() - x.square()) * r.square());
        let cut = Self::cut(y, x);
        [[yy + cut, yx + cut], [yx + cut, cut - yy]]
    }
}
