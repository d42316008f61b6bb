//! The one interface of every kind of number, and what a kernel states.

use super::local::{Bounds, Lean, Local};
use super::pointwise::{Point4, Pointwise};
use super::{Class, Function, Interval};
use std::marker::PhantomData;

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

impl Point {
    /// The jet as a batch of one, up to an order.
    #[inline(always)]
    pub fn as_jets(&mut self, order: Order) -> Jets<'_> {
        Jets {
            value: std::slice::from_mut(&mut self.value),
            grad: (order >= Order::Gradient).then_some(self.grad.each_mut().map(std::slice::from_mut)),
            hess: (order >= Order::Hessian).then_some(self.hess.each_mut().map(std::slice::from_mut)),
        }
    }
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

/// A function of three coordinates that is known by its jet at points and by bounds on its
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
        self.jets([&at[0..1], &at[1..2], &at[2..3]], p.as_jets(order));
        p
    }

    /// Whether [`local`](Kernel::local) knows no more than the global bounds; then batches need not
    /// ask it.
    #[inline]
    fn is_uniform(&self) -> bool {
        true
    }

    /// What is known of the ball of `radius` around `at`, with the jet up to `order`. Kernels made
    /// of few scattered pieces know far more about a small ball than about all of space; kernels
    /// with creases know their bow although their second derivatives are unbounded.
    #[inline]
    fn local(&self, order: Order, at: [f64; 3], radius: f64) -> Local {
        let _ = radius;
        Local::uniform(self.jet(order, at), self.bounds())
    }

    /// Encloses the values over a box of any shape, for kernels that know more of one than its middle tells: those that come to
    /// rest far from what they are made of.
    #[inline]
    fn over(&self, x: &[Interval; 3]) -> Option<Interval> {
        let _ = x;
        None
    }

    /// What all gradients in a ball have in common, for kernels with creases: at one the gradient is any of those
    /// between both sides', for which it holds too.
    #[inline]
    fn lean(&self, at: [f64; 3], radius: f64) -> Option<Lean> {
        let _ = (at, radius);
        None
    }

    /// What is known of a batch of balls, and what the jets in their middles may be [off](Kernel::error) by.
    #[inline]
    fn locals(&self, order: Order, at: [&[f64]; 3], radius: &[f64], out: &mut [(Local, [f64; 3])]) {
        for (i, out) in out.iter_mut().enumerate() {
            let c = at.map(|at| at[i]);
            let size = c[0].abs().max(c[1].abs()).max(c[2].abs());
            *out = (self.local(order, c, radius[i]), self.error(size));
        }
    }

    /// Absolute error of a value and of a gradient component computed at a point of magnitude
    /// `size` (largest coordinate): arithmetic, and the rounding of scaled arguments. It grows with the
    /// size like `a + b size`.
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

/// The rounding of a kernel's jets, which grows with the size of the point like `a + b size`.
#[derive(Clone, Copy, Debug)]
pub struct Growing {
    start: [f64; 3],
    growth: [f64; 3],
}

/// Covers the rounding of what is computed from an error here.
const UP: f64 = 1.0 + 64.0 * super::ROUNDOFF;

impl Growing {
    /// Of a kernel.
    pub fn new<K: Kernel + ?Sized>(k: &K) -> Self {
        let (start, one) = (k.error(0.0), k.error(1.0));
        // What is unbounded at the origin is so everywhere.
        let grows = |i: usize| if start[i].is_finite() { (one[i] - start[i]) * UP } else { 0.0 };
        Growing { start, growth: [grows(0), grows(1), grows(2)] }
    }

    /// At points of so large coordinates.
    #[inline(always)]
    pub fn at(&self, size: f64) -> [f64; 3] {
        [self.of(0, size), self.of(1, size), self.of(2, size)]
    }

    /// That of the value (0), first (1) or second derivatives (2) there.
    #[inline(always)]
    pub fn of(&self, order: usize, size: f64) -> f64 {
        (self.start[order] + self.growth[order] * size) * UP
    }
}

/// Proof that a `T` is nothing in memory but so many plain numbers side by side, so that machine code may
/// work on them; only this layer can give it.
#[derive(Debug)]
pub struct Plain<T> {
    count: usize,
    of: PhantomData<T>,
}

impl<T> Plain<T> {
    /// How many numbers.
    pub fn count(&self) -> usize {
        self.count
    }

    /// What holds so many of these and nothing else is plain, too. Whether it does is the caller's word.
    pub(super) fn times<U>(&self, count: usize) -> Plain<U> {
        Plain { count: count * self.count, of: PhantomData }
    }
}

/// A kind of number. `add` to `shift` are exact up to rounding in every kind; everything else goes
/// through `lift` and `kernel`.
pub trait Number: Clone + Send + Sync + 'static {
    /// Whether the number stands for a point rather than for a set of them.
    const EXACT: bool = false;

    /// Whether it is made of plain numbers alone.
    fn plain() -> Option<Plain<Self>> {
        None
    }

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

    /// Writes `self + other` to `out`. Like the others of this kind, the same bits as by value; batches,
    /// which are large, are written in place.
    #[inline(always)]
    fn add_to(&self, other: &Self, out: &mut Self) {
        *out = self.add(other);
    }

    /// Writes `self - other` to `out`.
    #[inline(always)]
    fn sub_to(&self, other: &Self, out: &mut Self) {
        *out = self.sub(other);
    }

    /// Writes the image of `x` under `f` to `out`.
    #[inline(always)]
    fn lift_to<F: Function<N>, const N: usize>(f: &F, x: [&Self; N], out: &mut Self) {
        *out = Self::lift(f, x);
    }

    /// Adds `k * other`.
    #[inline(always)]
    fn add_scaled(&mut self, other: &Self, k: f64) {
        *self = self.add(&other.scale(k));
    }

    /// Writes `k * self` to `out`.
    #[inline(always)]
    fn scale_to(&self, k: f64, out: &mut Self) {
        *out = self.scale(k);
    }

    /// Writes `self + c` to `out`.
    #[inline(always)]
    fn shift_to(&self, c: f64, out: &mut Self) {
        *out = self.shift(c);
    }

    /// Writes `f` of `x` to `out`.
    #[inline(always)]
    fn apply_to<F: Function<N>, const N: usize>(f: &F, x: [&Self; N], out: &mut Self) {
        f.apply_to(x, out);
    }

    /// The image of a point under a kernel.
    fn kernel<K: Kernel + ?Sized>(k: &K, p: [&Self; 3]) -> Self;

    /// Writes the image of a point under a kernel to `out`.
    #[inline(always)]
    fn kernel_to<K: Kernel + ?Sized>(k: &K, p: [&Self; 3], out: &mut Self) {
        *out = Self::kernel(k, p);
    }

    /// The image under a function that is known at points only, of a point and, if it takes one, a
    /// further number. Kinds that stand for sets of points cannot say.
    #[inline(always)]
    fn pointwise<K: Pointwise>(k: &K, p: [&Self; 3], with: Option<&Self>) -> Option<Self> {
        let _ = (k, p, with);
        None
    }

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

    /// The point at which the kernel is evaluated.
    fn centre(p: [&Self; 3]) -> [f64; 3];

    /// Whether the bounds alone decide: `p` is spread so wide that `expand` ignores the jet, which
    /// then need not be computed. So it is for the fine octaves of a fractal over a large box.
    #[inline(always)]
    fn blind(bounds: &Bounds, p: [&Self; 3]) -> bool {
        let _ = (bounds, p);
        false
    }

    /// Radius of a ball around the centre that holds the number; 0 for exact ones.
    #[inline(always)]
    fn reach(p: [&Self; 3]) -> f64 {
        let _ = p;
        0.0
    }

    /// What is known of the ball around the centre says this about `p`. Exact numbers do not read
    /// the error.
    fn expand(local: &Local, error: [f64; 3], p: [&Self; 3]) -> Self;

    /// Whether numbers are of boxes of places, of which a kernel may know more by [`Kernel::over`] or [`Kernel::lean`].
    const BOX: bool = false;

    /// The same number with what else the kernel knows over the box `p`.
    #[inline(always)]
    fn met<K: Kernel + ?Sized>(self, k: &K, p: [&Self; 3]) -> Self {
        let _ = (k, p);
        self
    }

    /// The chain rule, for exact numbers: a jet at `p` and a further argument as a number.
    #[inline(always)]
    fn compose(jet: &Point4, p: [&Self; 3], with: Option<&Self>) -> Option<Self> {
        let _ = (jet, p, with);
        None
    }
}

/// The rule of a centred number for functions that are known at points only.
#[inline]
pub(super) fn centred_pointwise<T: Centred, K: Pointwise>(k: &K, p: [&T; 3], with: Option<&T>) -> Option<T> {
    if !T::EXACT {
        return None;
    }
    let jet = k.jet(T::ORDER, T::centre(p), with.map(|s| T::centre([s; 3])[0]));
    T::compose(&jet, p, with)
}

/// The kernel rule of a centred number.
#[inline]
pub fn centred_kernel<T: Centred, K: Kernel + ?Sized>(k: &K, p: [&T; 3]) -> T {
    around_centre(k, p).met(k, p)
}

/// The same, from what the kernel says of the ball around the centre.
#[inline]
fn around_centre<T: Centred, K: Kernel + ?Sized>(k: &K, p: [&T; 3]) -> T {
    let bounds = k.bounds();
    if T::blind(&bounds, p) {
        return T::expand(&Local::uniform(Point::default(), bounds), [0.0; 3], p);
    }
    let at = T::centre(p);
    if T::EXACT || k.is_uniform() {
        let local = Local::uniform(k.jet(T::ORDER, at), bounds);
        T::expand(&local, error::<T, K>(k, at), p)
    } else {
        let (local, error) = one_local(k, T::ORDER, at, T::reach(p));
        T::expand(&local, error, p)
    }
}

/// What is known of one ball.
#[inline]
fn one_local<K: Kernel + ?Sized>(k: &K, order: Order, at: [f64; 3], radius: f64) -> (Local, [f64; 3]) {
    let mut out = [Local::UNKNOWN];
    k.locals(order, [&at[..1], &at[1..2], &at[2..]], &[radius], &mut out);
    let [known] = out;
    known
}

/// The rounding of a jet at `at`, where a number needs it.
#[inline(always)]
pub(super) fn error<T: Number, K: Kernel + ?Sized>(k: &K, at: [f64; 3]) -> [f64; 3] {
    if T::EXACT { [0.0; 3] } else { k.error(at[0].abs().max(at[1].abs()).max(at[2].abs())) }
}

impl Number for f64 {
    const EXACT: bool = true;
    fn plain() -> Option<Plain<Self>> {
        Some(Plain { count: 1, of: PhantomData })
    }
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
    #[inline]
    fn pointwise<K: Pointwise>(k: &K, p: [&Self; 3], with: Option<&Self>) -> Option<Self> {
        centred_pointwise(k, p, with)
    }
    fn range(&self) -> Interval {
        Interval::point(*self)
    }
}

impl Centred for f64 {
    const ORDER: Order = Order::Value;
    #[inline(always)]
    fn centre(p: [&Self; 3]) -> [f64; 3] {
        p.map(|p| *p)
    }
    #[inline(always)]
    fn expand(local: &Local, _: [f64; 3], _: [&Self; 3]) -> Self {
        local.jet.value
    }
    #[inline(always)]
    fn compose(jet: &Point4, _: [&Self; 3], _: Option<&Self>) -> Option<Self> {
        Some(jet.value)
    }
}
