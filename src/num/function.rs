//! What an operation states about itself, once, for every kind of number.
//!
//! Affine arithmetic needs from a function `f` over a box `X` with centre `c` a *form*:
//!
//! ```text
//! f(x)  is in  rest + slope . (x - c) + 1/2 bend (x - c)^T M (x - c)     for every x in X
//! ```
//!
//! The quadratic part keeps what correlated arguments know of each other: `x y` along a ray has
//! the term `x1 y1 e^2` with `e^2` in [0, 1], not in [-1, 1]. Three constructors cover most
//! operations: [`Form::taylor`] (smooth, one argument), [`Form::chord`] (convex or concave on the
//! box; the Chebyshev form of affine arithmetic) and [`Form::mean_value`] (any continuous one).

use super::{Interval, Local, Number, ROUNDOFF, Real};

/// Continuity class of a function. A composition takes the least of its parts.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Hash)]
pub enum Class {
    /// Jumps: has no surface normal and no Lipschitz bound where it does.
    Jump,
    /// Continuous with creases: a normal almost everywhere.
    C0,
    /// Continuous normals.
    C1,
    /// Continuous Hessian: open to Morse analysis.
    C2,
}

impl Class {
    /// That of the slope of what is of this class.
    pub fn of_slope(self) -> Class {
        match self {
            Class::C2 => Class::C1,
            Class::C1 => Class::C0,
            Class::C0 | Class::Jump => Class::Jump,
        }
    }
}

impl std::fmt::Display for Class {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Class::Jump => "discontinuous",
            Class::C0 => "C0",
            Class::C1 => "C1",
            Class::C2 => "C2",
        })
    }
}

/// Range of `weights . x` over the arguments, with whatever correlation the number type knows.
pub type Combine<'a, const N: usize> = &'a dyn Fn(&[f64; N]) -> Interval;

/// Linear (and quadratic) enclosure over a box; see the module text.
#[derive(Clone, Copy, Debug)]
pub struct Form<const N: usize> {
    /// Slope in each argument.
    pub slope: [f64; N],
    /// What is left, as an interval.
    pub rest: Interval,
    /// Factor of the quadratic part.
    pub bend: Interval,
    /// Symmetric matrix of the quadratic part; unused where `bend` is zero.
    pub matrix: [[f64; N]; N],
}

/// What is known of a function `y + g(x - y)` of two numbers that is the smaller one where they are far apart: it bends
/// along their difference alone, which may be known better than they are.
#[derive(Clone, Copy, Debug)]
pub struct Seam {
    /// The difference from which on the smaller one is all that counts.
    pub reach: f64,
    /// Second derivative of `g`.
    pub bend: Interval,
    /// By how much the value, and its partial derivatives, may be off that are computed with plain numbers; no numbers
    /// where that is not known.
    pub blur: [f64; 2],
}

/// A function of `N` numbers: the meaning of an operation.
///
/// Derivatives of creased functions are those of the side that is active (any of them on the
/// crease); over intervals they enclose both sides.
pub trait Function<const N: usize> {
    /// Continuity class.
    fn class(&self) -> Class {
        Class::C2
    }

    /// The value.
    fn value<R: Real>(&self, x: [R; N]) -> R;

    /// Partial derivatives.
    fn grad<R: Real>(&self, x: [R; N]) -> [R; N];

    /// Second partial derivatives; symmetric.
    fn hess<R: Real>(&self, x: [R; N]) -> [[R; N]; N];

    /// Enclosure of the values over a box.
    #[inline(always)]
    fn range(&self, x: [Interval; N]) -> Interval {
        self.value(x)
    }

    /// Bound on the gradient's norm of the function of `N` fields over a box, from bounds on the
    /// norms of their gradients and on the spectral norm of their Jacobian. The default is the
    /// triangle inequality.
    fn steepness(&self, x: &[Interval; N], norms: &[f64; N], jacobian: f64) -> f64 {
        let _ = jacobian;
        let partial = self.grad(*x);
        (0..N).map(|i| if norms[i] == 0.0 { 0.0 } else { partial[i].mag() * norms[i] }).sum()
    }

    /// Whether the function has a value everywhere in a box.
    fn is_defined(&self, x: &[Interval; N]) -> bool {
        let _ = x;
        true
    }

    /// Whether it is known to have no value anywhere in a box.
    fn is_undefined(&self, x: &[Interval; N]) -> bool {
        let _ = x;
        false
    }

    /// One interval `k` for which `d^T H d` is in `k d . d` for every `d` and everywhere in a box, for
    /// functions of which the entries of the Hessian `H` would cost more and say little more.
    #[inline(always)]
    fn curvature(&self, x: &[Interval; N]) -> Option<Interval> {
        let _ = x;
        None
    }

    /// What is known of the ball of some radius around a point, and by how much each order of the jet there may be
    /// off, for functions of three numbers that say more of a ball than ranges over a box would, or sooner.
    #[inline(always)]
    fn around(&self, at: [f64; N], radius: f64) -> Option<(Local, [f64; 3])> {
        let _ = (at, radius);
        None
    }

    /// By how many roundoffs of its size a value or a partial derivative may be off that is computed with
    /// plain numbers; none where nothing so simple is true, as where sums may cancel.
    #[inline(always)]
    fn roundoffs(&self) -> Option<f64> {
        None
    }

    /// What is known of a smooth corner between two numbers, for functions of two that are one, where their difference is in a
    /// range.
    #[inline(always)]
    fn seam(&self, x: &[f64; N], apart: Interval) -> Option<Seam> {
        let _ = (x, apart);
        None
    }

    /// Whether the second partial derivatives are the same everywhere.
    #[inline(always)]
    fn is_quadratic(&self) -> bool {
        false
    }

    /// Whether the signs of arguments, of each alone, make no difference to the value.
    fn is_even(&self) -> bool {
        false
    }

    /// Whether nothing is worth knowing of the values over a box but their range.
    fn is_vague(&self) -> bool {
        false
    }

    /// Whether the value is always that of one of two arguments, as a minimum's is, and always that of the same one when both
    /// have moved by the same; continuous functions only.
    fn selects(&self) -> bool {
        false
    }

    /// All of a range that has values, for functions of one number that are convex there, or concave, and whose second
    /// derivative need not be bounded: the slopes of chords from a point of it are between those of the chords to its ends.
    #[inline(always)]
    fn bows(&self, x: Interval) -> Option<Interval> {
        let _ = x;
        None
    }

    /// The range of the sum of the partial derivatives, where none of these is ever negative: then the gradient of the
    /// function of fields is so many times a mean of theirs, which keeps signs that they share.
    fn shares(&self) -> Option<Interval> {
        None
    }

    /// The function of any kind of number. Sums and the like, which every number knows natively,
    /// say so here.
    #[inline(always)]
    fn apply<T: Number>(&self, x: [&T; N]) -> T
    where
        Self: Sized,
    {
        T::lift(self, x)
    }

    /// The same, written to `out`.
    #[inline(always)]
    fn apply_to<T: Number>(&self, x: [&T; N], out: &mut T)
    where
        Self: Sized,
    {
        T::lift_to(self, x, out);
    }

    /// Linear form over a box.
    fn form(&self, x: &[Interval; N], combine: Combine<'_, N>) -> Form<N> {
        let _ = combine;
        if self.is_quadratic() { Form::quadratic(self, x) } else { Form::mean_value(self, x) }
    }
}

impl<const N: usize> Form<N> {
    /// A form without quadratic part.
    #[inline(always)]
    pub fn linear(slope: [f64; N], rest: Interval) -> Self {
        Form { slope, rest, bend: Interval::point(0.0), matrix: [[0.0; N]; N] }
    }

    /// No slope: the range alone.
    #[inline(always)]
    pub fn constant(range: Interval) -> Self {
        Form::linear([0.0; N], range)
    }

    /// Form of a function whose second derivatives are the same everywhere: exact, up to the rounding of
    /// its slopes.
    #[inline(always)]
    pub fn quadratic<F: Function<N> + ?Sized>(f: &F, x: &[Interval; N]) -> Self {
        let c = x.map(Interval::mid);
        let slope = f.grad(c);
        let error: f64 = (0..N).map(|i| 8.0 * ROUNDOFF * slope[i].abs() * x[i].rad()).sum();
        let rest = f.range(c.map(Interval::point)) + Interval::radius(error);
        Form { slope, rest, bend: Interval::point(1.0), matrix: f.hess(c) }
    }

    /// Mean value form: `f(c) + G . (x - c)` with the gradient's range `G` split into its centre
    /// (the slope) and its spread. Needs only continuity and derivatives almost everywhere.
    pub fn mean_value<F: Function<N> + ?Sized>(f: &F, x: &[Interval; N]) -> Self {
        let grad = f.grad(*x);
        if !grad.iter().all(|g| g.is_finite()) || !x.iter().all(|x| x.is_finite()) {
            return Form::constant(f.range(*x));
        }
        let slope = grad.map(Interval::mid);
        let mut rest = f.range(x.map(|x| Interval::point(x.mid())));
        for i in 0..N {
            let spread = grad[i] - Interval::point(slope[i]);
            rest = rest + spread * (x[i] - Interval::point(x[i].mid()));
        }
        Form::linear(slope, rest)
    }
}

impl Form<1> {
    /// Second-order Taylor form. For a function whose second derivative hardly varies it is as
    /// tight as the Chebyshev form, since `(x - c)^2` is known not to be negative.
    #[inline]
    pub fn taylor<F: Function<1> + ?Sized>(f: &F, x: Interval) -> Self {
        let bend = f.hess([x])[0][0];
        if !bend.is_finite() || !x.is_finite() {
            return Form::mean_value(f, &[x]);
        }
        let c = Interval::point(x.mid());
        let grad = f.grad([c])[0];
        let slope = grad.mid();
        let rest = f.range([c]) + (grad - Interval::point(slope)) * (x - c);
        Form { slope: [slope], rest, bend, matrix: [[1.0]] }
    }

    /// Chebyshev form of a function that is convex on `x`, or concave on `x`: the slope of the
    /// chord. `tangent` maps that slope to the place where the function has it; an inexact place
    /// costs tightness, never containment, since the tangent there bounds the function from one side.
    #[inline]
    pub fn chord<F: Function<1> + ?Sized>(f: &F, x: Interval, tangent: impl Fn(f64) -> f64) -> Self {
        let at = |p: f64| f.range([Interval::point(p)]);
        let (fa, fb) = (at(x.lo), at(x.hi));
        let slope = (fb.mid() - fa.mid()) / x.width();
        if !slope.is_finite() {
            return Form::constant(f.range([x]));
        }
        let c = Interval::point(x.mid());
        let line = |p: Interval| (p - c) * slope;
        let ends = (fa - line(Interval::point(x.lo))).hull(fb - line(Interval::point(x.hi)));
        let t = Interval::point(tangent(slope).clamp(x.lo, x.hi));
        let tilt = f.grad([t])[0] - Interval::point(slope);
        if !tilt.is_finite() {
            return Form::constant(f.range([x]));
        }
        let touch = f.range([t]) - line(t) + tilt * (x - t);
        Form::linear([slope], ends.hull(touch))
    }
}
