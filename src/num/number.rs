//! The one interface of every kind of number, and what a kernel states.

use super::{Class, Function, Interval};

/// How much of a kernel's jet a number needs.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Order {
    /// The value.
    Value,
    /// Value and gradient.
    Gradient,
    /// Value, gradient and Hessian.
    Hessian,
}

/// The jet of a kernel at one point; parts beyond the order asked for are zero.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Point {
    /// Value.
    pub value: f64,
    /// Gradient.
    pub grad: [f64; 3],
    /// Second derivatives: xx, yy, zz, xy, xz, yz.
    pub hess: [f64; 6],
}

/// Where a kernel writes a batch of jets: structures of arrays, one entry a lane.
#[derive(Debug)]
pub struct Jets<'a> {
    /// Values.
    pub value: &'a mut [f64],
    /// Gradients by axis, if wanted.
    pub grad: Option<[&'a mut [f64]; 3]>,
    /// Second derivatives xx, yy, zz, xy, xz, yz, if wanted (only together with gradients).
    pub hess: Option<[&'a mut [f64]; 6]>,
}

/// Bounds on a kernel over all of space, rounded up: suprema of the absolute value, of the
/// gradient's norm, and of the second and third directional derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// `|N| <= range`.
    pub range: f64,
    /// `|grad N| <= lipschitz`.
    pub lipschitz: f64,
    /// `|u^T H u| <= hessian` for unit `u`.
    pub hessian: f64,
    /// Lipschitz constant of the Hessian (spectral norm); infinite unless the kernel is C2.
    pub third: f64,
}

impl Bounds {
    /// Bounds of `N(k x)`.
    #[inline]
    pub fn at_frequency(self, k: f64) -> Bounds {
        let k = k.abs();
        Bounds {
            range: self.range,
            lipschitz: self.lipschitz * k,
            hessian: self.hessian * k * k,
            third: self.third * k * k * k,
        }
    }
}

/// A function of three coordinates that is known by its jet at points and by global bounds on its
/// derivatives, as noises are. From these, one point evaluation bounds it over any box.
pub trait Kernel: Sync {
    /// Continuity class.
    fn class(&self) -> Class;

    /// Global bounds.
    fn bounds(&self) -> Bounds;

    /// Jets at a batch of points, `at[axis][lane]`; how much of the jet is computed follows from
    /// which parts `out` has. Every slice has the same length. Lanes do not influence one another,
    /// so any grouping of points into batches gives the same bits.
    fn jets(&self, at: [&[f64]; 3], out: Jets<'_>);

    /// The jet at one point.
    fn jet(&self, order: Order, at: [f64; 3]) -> Point {
        let mut p = Point::default();
        let [xx, yy, zz, xy, xz, yz] = &mut p.hess;
        let [x, y, z] = &mut p.grad;
        let grad = [x, y, z].map(std::slice::from_mut);
        let hess = [xx, yy, zz, xy, xz, yz].map(std::slice::from_mut);
        let out = Jets {
            value: std::slice::from_mut(&mut p.value),
            grad: (order >= Order::Gradient).then_some(grad),
            hess: (order >= Order::Hessian).then_some(hess),
        };
        self.jets([&at[0..1], &at[1..2], &at[2..3]], out);
        p
    }

    /// Absolute error of a value and of a gradient component computed at a point of magnitude
    /// `size` (largest coordinate): arithmetic, and the rounding of scaled arguments.
    #[inline]
    fn error(&self, size: f64) -> [f64; 3] {
        // A quintic fade is off by up to 24 roundoffs near 1, on each of three axes alike, across a
        // difference of corners of up to about 1: 72 roundoffs and those of the blend, budgeted as
        // 128. Gradients and Hessians have 256 and 1024 times their larger bounds. Scaled arguments
        // are off by 3 roundoffs of their size.
        let b = self.bounds();
        let u = super::ROUNDOFF;
        let shift = 3.0 * u * size;
        [
            128.0 * u * b.range + b.lipschitz * shift,
            256.0 * u * b.lipschitz + b.hessian * shift,
            1024.0 * u * b.hessian + b.third * shift,
        ]
    }
}

/// A kind of number. `add` to `shift` are exact up to rounding in every kind; everything else goes
/// through `lift` and `kernel`.
pub trait Number: Clone + Send + Sync + 'static {
    /// The number that equals `c`.
    fn constant(c: f64) -> Self;

    /// `self + other`.
    fn add(&self, other: &Self) -> Self;

    /// `self - other`.
    fn sub(&self, other: &Self) -> Self;

    /// `-self`.
    fn neg(&self) -> Self;

    /// `k * self`.
    fn scale(&self, k: f64) -> Self;

    /// `self + c`.
    fn shift(&self, c: f64) -> Self;

    /// The image of `x` under `f`.
    fn lift<F: Function<N>, const N: usize>(f: &F, x: [&Self; N]) -> Self;

    /// The image of a point under a kernel.
    fn kernel<K: Kernel + ?Sized>(k: &K, p: [&Self; 3]) -> Self;

    /// The number of which nothing but its range is known, for kinds that can say so; a value is
    /// somewhere, and a derivative is not known from a range.
    fn somewhere(range: Interval) -> Option<Self> {
        let _ = range;
        None
    }

    /// `yes` where the range of `by` passes the test, else `no`; a batch decides lane by lane.
    #[inline]
    fn choose(by: &Self, test: impl Fn(Interval) -> bool, yes: &Self, no: &Self) -> Self {
        if test(by.range()) { yes.clone() } else { no.clone() }
    }

    /// Where the number is known to lie: a point for numbers that hold values, the range for
    /// enclosures, the hull of the lanes for batches.
    fn range(&self) -> Interval;
}

/// A number whose kernel rule reads one jet at one point. [`Many`](super::Many) uses the three
/// steps to gather a batch of centres and evaluate the kernel for all of them in one go.
pub trait Centred: Number {
    /// How much of the jet `expand` reads.
    const ORDER: Order;

    /// Whether the number stands for its rounded self, so that `expand` does not read the error.
    const EXACT: bool = false;

    /// The point at which the kernel is evaluated.
    fn centre(p: [&Self; 3]) -> [f64; 3];

    /// Whether the bounds alone decide: `p` is spread so wide that `expand` ignores the jet, which
    /// then need not be computed. So it is for the fine octaves of a fractal over a large box.
    #[inline(always)]
    fn blind(bounds: &Bounds, p: [&Self; 3]) -> bool {
        let _ = (bounds, p);
        false
    }

    /// What a jet at the centre says about `p`.
    fn expand(bounds: &Bounds, jet: &Point, error: [f64; 3], p: [&Self; 3]) -> Self;
}

/// The kernel rule of a centred number.
#[inline]
pub fn centred_kernel<T: Centred, K: Kernel + ?Sized>(k: &K, p: [&T; 3]) -> T {
    let bounds = k.bounds();
    if T::blind(&bounds, p) {
        return T::expand(&bounds, &Point::default(), [0.0; 3], p);
    }
    let at = T::centre(p);
    let jet = k.jet(T::ORDER, at);
    let size = at[0].abs().max(at[1].abs()).max(at[2].abs());
    let error = if T::EXACT { [0.0; 3] } else { k.error(size) };
    T::expand(&bounds, &jet, error, p)
}

impl Number for f64 {
    #[inline(always)]
    fn constant(c: f64) -> Self {
        c
    }
    #[inline(always)]
    fn add(&self, other: &Self) -> Self {
        self + other
    }
    #[inline(always)]
    fn sub(&self, other: &Self) -> Self {
        self - other
    }
    #[inline(always)]
    fn neg(&self) -> Self {
        -self
    }
    #[inline(always)]
    fn scale(&self, k: f64) -> Self {
        self * k
    }
    #[inline(always)]
    fn shift(&self, c: f64) -> Self {
        self + c
    }
    #[inline(always)]
    fn lift<F: Function<N>, const N: usize>(f: &F, x: [&Self; N]) -> Self {
        f.value(x.map(|x| *x))
    }
    #[inline]
    fn kernel<K: Kernel + ?Sized>(k: &K, p: [&Self; 3]) -> Self {
        k.jet(Order::Value, p.map(|p| *p)).value
    }
    fn range(&self) -> Interval {
        Interval::point(*self)
    }
}

impl Centred for f64 {
    const ORDER: Order = Order::Value;
    const EXACT: bool = true;
    #[inline(always)]
    fn centre(p: [&Self; 3]) -> [f64; 3] {
        p.map(|p| *p)
    }
    #[inline(always)]
    fn expand(_: &Bounds, jet: &Point, _: [f64; 3], _: [&Self; 3]) -> Self {
        jet.value
    }
}
