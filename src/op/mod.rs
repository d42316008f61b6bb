//! Every operation of the expression language, each stated once.
//!
//! An operation is a type that implements [`Function`]: its value, derivatives, range and linear
//! form. The list at the end of this file gives it a script name, a sentence of documentation and an example,
//! and generates from that the enum [`Op`], its dispatch to every kind of number, and the tour that
//! the law tests and the reference page take. To add an operation, write the type in the file of
//! its family and add one line to the list.

mod arithmetic;
mod corner;
mod exponential;
mod order;
mod trigonometric;
mod vector;

pub use arithmetic::*;
pub use corner::*;
pub use exponential::*;
pub use order::*;
pub use trigonometric::*;
pub use vector::*;

use crate::num::{Class, Function, Interval, Number, Real};

/// Takes the tour over all operations; see [`Op::visit_all`].
pub trait Visitor {
    /// One operation: its script name, documentation, and meaning.
    fn visit<F: Function<N>, const N: usize>(&mut self, name: &str, doc: &str, f: &F);
}

macro_rules! ops {
    ($($op:ident($arity:literal) = $sample:expr, $name:literal, $doc:literal, $example:literal;)*) => {
        /// An operation with its parameters.
        #[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
        pub enum Op {
            $(#[doc = $doc] $op($op),)*
        }

        impl Op {
            /// Every operation, with sample parameters where it has some.
            pub const ALL: &'static [Op] = &[$(Op::$op($sample)),*];

            /// Name in scripts.
            pub fn name(&self) -> &'static str {
                match self { $(Op::$op(_) => $name,)* }
            }

            /// One sentence of documentation.
            pub fn doc(&self) -> &'static str {
                match self { $(Op::$op(_) => $doc,)* }
            }

            /// A line of script that uses it.
            pub fn example(&self) -> &'static str {
                match self { $(Op::$op(_) => $example,)* }
            }

            /// Number of arguments.
            pub fn arity(&self) -> usize {
                match self { $(Op::$op(_) => $arity,)* }
            }

            /// Continuity class of the operation alone.
            pub fn class(&self) -> Class {
                match self { $(Op::$op(f) => Function::<$arity>::class(f),)* }
            }

            /// Whether the signs of arguments make no difference to the value.
            pub fn is_even(&self) -> bool {
                match self { $(Op::$op(f) => Function::<$arity>::is_even(f),)* }
            }

            /// Whether the operation has a value everywhere in the box `arg(0)`, `arg(1)`, ...
            pub fn is_defined(&self, arg: impl Fn(usize) -> Interval) -> bool {
                match self {
                    $(Op::$op(f) => Function::<$arity>::is_defined(f, &std::array::from_fn(&arg)),)*
                }
            }

            /// Whether it is known to have no value anywhere in that box.
            pub fn is_undefined(&self, arg: impl Fn(usize) -> Interval) -> bool {
                match self {
                    $(Op::$op(f) => Function::<$arity>::is_undefined(f, &std::array::from_fn(&arg)),)*
                }
            }

            /// The value of the operation at scalars `arg(0)`, `arg(1)`, ...
            pub fn value<R: Real>(&self, arg: impl Fn(usize) -> R) -> R {
                match self {
                    $(Op::$op(f) => Function::<$arity>::value(f, std::array::from_fn(&arg)),)*
                }
            }

            /// The partial derivatives of the operation at scalars `arg(0)`, `arg(1)`, ...; as many as it has arguments.
            pub fn grad<R: Real>(&self, arg: impl Fn(usize) -> R) -> Vec<R> {
                match self {
                    $(Op::$op(f) => Function::<$arity>::grad(f, std::array::from_fn(&arg)).to_vec(),)*
                }
            }

            /// Applies the operation to numbers `arg(0)`, `arg(1)`, ...
            #[inline]
            pub fn apply<'a, T: Number>(&self, arg: impl Fn(usize) -> &'a T) -> T {
                match self {
                    $(Op::$op(f) => Function::<$arity>::apply(f, std::array::from_fn(&arg)),)*
                }
            }

            /// Applies the operation and writes the result to `out`, with the same bits.
            #[inline]
            pub fn apply_to<'a, T: Number>(&self, arg: impl Fn(usize) -> &'a T, out: &mut T) {
                match self {
                    $(Op::$op(f) => T::apply_to::<_, $arity>(f, std::array::from_fn(&arg), out),)*
                }
            }

            /// Shows every operation to `visitor`.
            pub fn visit_all(visitor: &mut impl Visitor) {
                $(visitor.visit::<$op, $arity>($name, $doc, &$sample);)*
            }
        }
    };
}

ops! {
    Add(2) = Add, "+", "Sum.", "sphere(1.0) + 0.04 * sin(24.0 * y)";
    Sub(2) = Sub, "-", "Difference.", "box(1.4) - 0.2";
    Mul(2) = Mul, "*", "Product.", "max(sphere(1.0), x * y)";
    Div(2) = Div, "/", "Quotient.", "max(sphere(1.0), y - x / 2.0)";
    Neg(1) = Neg, "neg", "The same with the other sign.", "max(sphere(1.0), -box([1, 3, 1]))";
    Square(1) = Square, "square", "The number times itself.", "y + 0.8 - square(x)";
    Sqrt(1) = Sqrt, "sqrt", "Square root; undefined below zero.", "y - sqrt(x)";
    Powi(1) = Powi { n: 3 }, "powi", "Integer power.", "y - powi(x, 3)";
    Powf(2) = Powf, "pow", "Real power of a number that is not negative.", "y + 0.8 - pow(abs(x), 1.5)";
    Exp(1) = Exp, "exp", "e to the power of a number.", "y + 1.0 - exp(x)";
    Ln(1) = Ln, "ln", "Natural logarithm; undefined below zero.", "y - ln(x + 1.0)";
    Sin(1) = Sin, "sin", "Sine of an angle in radians.", "y - 0.4 * sin(4.0 * x)";
    Cos(1) = Cos, "cos", "Cosine of an angle in radians.", "y - 0.4 * cos(4.0 * x)";
    Tan(1) = Tan, "tan", "Tangent of an angle in radians.", "y - 0.4 * tan(x)";
    Asin(1) = Asin, "asin", "Arc sine in radians; undefined outside [-1, 1].", "y - 0.5 * asin(x)";
    Acos(1) = Acos, "acos", "Arc cosine in radians; undefined outside [-1, 1].", "y + 0.8 - 0.5 * acos(x)";
    Atan(1) = Atan, "atan", "Arc tangent in radians.", "y - 0.5 * atan(4.0 * x)";
    Atan2(2) = Atan2, "atan2", "atan2(y, x): angle of the point (x, y) in radians, from -pi to pi.", "y - 0.3 * atan2(z, x)";
    Abs(1) = Abs, "abs", "Absolute value.", "y + 0.5 - abs(x)";
    Min(2) = Min, "min", "The smaller of two; the union of two solids.", "min(sphere(0.8), box([2.4, 0.5, 0.5]))";
    Max(2) = Max, "max", "The larger of two; the intersection of two solids.", "max(sphere(1.0), box(1.5))";
    Clamp(3) = Clamp, "clamp", "clamp(x, low, high): x, or the bound that it passes.", "y - clamp(x, -0.5, 0.5)";
    Sign(1) = Sign, "sign", "-1, 0 or 1.", "y - 0.5 * sign(x)";
    Step(2) = Step, "step", "step(edge, x): 0 below the edge, else 1.", "y - 0.8 * step(0.3, x)";
    Floor(1) = Floor, "floor", "Largest integer not above.", "y - 0.4 * floor(2.5 * x)";
    Fract(1) = Fract, "fract", "What is left above the floor, from 0 to 1.", "y - 0.5 * fract(2.0 * x)";
    Modulo(2) = Modulo, "modulo", "modulo(x, period): x minus whole periods, with the sign of the period.", "y - modulo(x, 0.6)";
    Smoothstep(1) = Smoothstep, "smoothstep", "smoothstep(low, high, x): rises smoothly from 0 at low to 1 at high.", "y - smoothstep(-0.8, 0.8, x)";
    Smootherstep(1) = Smootherstep, "smootherstep", "smootherstep(low, high, x): rises from 0 at low to 1 at high, smooth also where it begins and ends; C2, where smoothstep is C1.", "y - smootherstep(-0.8, 0.8, x)";
    Mix(3) = Mix, "mix", "mix(a, b, t): a at t = 0, b at t = 1, linear between and beyond.", "mix(box(1.4), sphere(1.0), 0.5)";
    Norm(2) = Norm::new(2.5), "norm", "norm(x, y, power): the p-norm (|x|^p + |y|^p)^(1/p) for a power p from 1 to 64, whose unit circle is a diamond for 1, round for 2 and nearly a square for 64; C2 from a power of 2 on.", "norm(x, y, 4) - 1.0";
    Ramp(1) = Ramp::Quartic, "ramp", "ramp(x, shape): max(x, 0) with a rounded corner between -1 and 1; shape is \"quadratic\" (C1), \"cubic\" or \"quartic\" (C2), or \"exponential\", which is ln(1 + e^x) (C2).", "y - ramp(2.0 * x, \"cubic\")";
    Melt(2) = Melt::new(Ramp::Cubic, 0.7), "melt", "melt(x, y, shape): the smaller of two with a rounded corner where they differ by less than 1, x - ramp(x - y, shape); of the class of the ramp.", "melt(y - x, y + x, \"cubic\")";
    Plus(1) = Plus { n: 3 }, "plus", "plus(x, n): max(x, 0)^n, a power n from 2 to 64 that ends smoothly at zero; C1 for 2, C2 from 3 on.", "y + 0.5 - plus(1.0 - length(p), 2)";
    Zigzag(1) = Zigzag, "zigzag", "zigzag(x): distance to the nearest even whole number, a wave of straight lines between 0 and 1; C0.", "y - 0.4 * zigzag(4.0 * x)";
    Length(3) = Length, "length", "Length of a vector.", "length(vec3(x, 2.0 * y, z)) - 1.0";
    Corner(2) = Corner, "corner", "corner(a, b): distance from the edge where two solids meet at a right angle, given the distances from both; what both share.", "corner(y - 0.3, length(vec3(x, 0, z)) - 0.9)";
    Dot(6) = Dot, "dot", "Dot product of two vectors.", "max(sphere(1.0), dot(p, vec3(1, 1, 0)))";
}
