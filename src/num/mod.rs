//! Kinds of number, and how a function is lifted to each of them.
//!
//! A *function* ([`Function`]) states its meaning once: value, partial derivatives, range and
//! linear form. A *kernel* ([`Kernel`]), such as a noise, states its jet at a point and bounds on
//! its derivatives. Every kind of number is one [`Number`] with one rule for functions and one for
//! kernels, so that the work is functions plus numbers and never their product:
//!
//! | number | answers | rule |
//! |---|---|---|
//! | `f64` | the value at a point | evaluate |
//! | [`Dual`] | value and gradient | chain rule |
//! | [`Jet`] | value, gradient, Hessian | second-order chain rule |
//! | [`Interval`] | an enclosure over a box | `range` |
//! | [`Slope`] | an enclosure of value, gradient and its norm over a box | chain rule on intervals |
//! | [`Affine`] | an enclosure that remembers which inputs it came from | `form`, condensed |
//! | [`Reduced`] | the same with `K` shared symbols | `form` |
//! | [`Parabolas`] | a batch of enclosures along pieces of lines, quadratic in the place | `grad` and `hess` |
//! | [`Taylors`] | a batch of enclosures of value, gradient and Hessian over balls | `grad` and `hess` |
//! | [`Many`] | a batch of any of these | lane by lane, noises in SIMD |
//!
//! Numbers that stand for points know a third kind of function besides: a [`Pointwise`] one writes
//! one jet for what is a whole expression to the others, such as a sum of octaves.
//!
//! Beside the numbers stand what several modules compute with: hashes, fingerprints ([`Digest`]), B-splines
//! ([`cubic`], [`quadratic`]), the same as densities to sample ([`BSpline`]), curves through keyframes ([`interpolate`]), points
//! that fill a square evenly ([`sequence`]), the Fourier transform ([`transform`]) and the code of colours ([`srgb`]).

mod affine;
mod bspline;
mod digest;
mod dual;
mod fft;
mod function;
mod hash;
mod hull;
mod interval;
mod jet;
mod keyframes;
mod local;
mod many;
mod morton;
mod number;
pub mod oklab;
mod parabola;
mod pointwise;
mod real;
mod reduced;
pub mod sequence;
mod simd;
mod slope;
mod smoothing;
pub mod srgb;
mod taylor;
mod turn;

pub use affine::{Affine, Symbol};
pub use bspline::{CUBIC_POLE, Edge, Weights, cubic, interpolate_cubic, quadratic};
pub use digest::Digest;
pub use dual::Dual;
pub use fft::{Complex, Direction, Fft, Unfit, transform};
pub use function::{Class, Combine, Form, Function, Seam};
pub use hash::{mix, uniform};
pub use hull::shortest;
pub use interval::Interval;
pub use jet::{Jet, PAIRS};
pub use keyframes::{Curve, interpolate};
pub use local::{Bounds, Lean, Local};
pub use many::Many;
pub use morton::{morton2, morton3};
pub use number::{Centred, Growing, Jets, Kernel, Number, Order, Plain, Point};
pub(crate) use parabola::{Classifier, Joint, Part, Signs, parts_of};
pub use parabola::{Half, Mix, Parabola, Parabolas, Sign};
pub use pointwise::{Jets4, Point4, Pointwise};
pub use real::{Real, power};
pub use reduced::Reduced;
pub use simd::{Level, fetch, limit_simd, simd_level, widest};
pub use slope::Slope;
pub use smoothing::{BSpline, Quantiles, Radial};
pub use taylor::{Taylor, Taylors, spectral};
pub use turn::{TURN_ERROR, cos_turns, sin_turns};

/// Unit roundoff of `f64`: half the distance from 1 to the next number.
pub const ROUNDOFF: f64 = f64::EPSILON / 2.0;
