//! Second-order jets: value, gradient and Hessian, over points or over boxes.
//!
//! With scalars `f64` a jet is exact up to rounding; with [`Interval`] scalars it encloses the
//! value, gradient and Hessian over a box.

use super::number::{Centred, centred_kernel, centred_pointwise};
use super::{Bounds, Function, Interval, Kernel, Local, Number, Order, Point4, Pointwise, Real};

/// A value, its gradient, and its second derivatives in the order xx, yy, zz, xy, xz, yz.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet<R = f64> {
    /// Value.
    pub value: R,
    /// Gradient.
    pub grad: [R; 3],
    /// Second derivatives.
    pub hess: [R; 6],
}

/// Row and column of the six second derivatives.
pub const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

impl<R: Real> Jet<R> {
    /// The coordinate `axis` (0, 1, 2) at `x`.
    pub fn coordinate(x: R, axis: usize) -> Self {
        let mut jet = Jet::still(x);
        jet.grad[axis] = R::of(1.0);
        jet
    }

    fn still(value: R) -> Self {
        Jet { value, grad: [R::of(0.0); 3], hess: [R::of(0.0); 6] }
    }

    fn zip(&self, o: &Self, f: impl Fn(R, R) -> R) -> Self {
        Jet {
            value: f(self.value, o.value),
            grad: std::array::from_fn(|i| f(self.grad[i], o.grad[i])),
            hess: std::array::from_fn(|i| f(self.hess[i], o.hess[i])),
        }
    }

    fn map(&self, f: impl Fn(R) -> R) -> Self {
        Jet { value: f(self.value), grad: self.grad.map(&f), hess: self.hess.map(&f) }
    }

    /// Second-order chain rule: `grad = sum f_i grad_i`, `H = sum f_i H_i + sum f_ij grad_i grad_j^T`.
    fn chain<const N: usize>(
        value: R,
        f: [R; N],
        ff: [[R; N]; N],
        x: [&Self; N],
        silent: impl Fn(R) -> bool,
    ) -> Self {
        // A derivative that is exactly zero silences even an unbounded partial derivative.
        let times = |a: R, b: R| if silent(b) { R::of(0.0) } else { a * b };
        let grad =
            std::array::from_fn(|axis| (0..N).fold(R::of(0.0), |sum, i| sum + times(f[i], x[i].grad[axis])));
        let hess = std::array::from_fn(|pair| {
            let (r, c) = PAIRS[pair];
            let mut sum = R::of(0.0);
            for i in 0..N {
                sum = sum + times(f[i], x[i].hess[pair]);
                for j in 0..N {
                    sum = sum + times(times(ff[i][j], x[i].grad[r]), x[j].grad[c]);
                }
            }
            sum
        });
        Jet { value, grad, hess }
    }
}

/// What differs between jets over points and over boxes: the range of a function and the zero test.
trait JetScalar: Real + Send + Sync + 'static {
    fn image<F: Function<N>, const N: usize>(f: &F, x: [Self; N]) -> Self;
    const EXACT: bool;
    fn is_zero(self) -> bool;
    fn range(self) -> Interval;
}

impl JetScalar for f64 {
    const EXACT: bool = true;
    fn image<F: Function<N>, const N: usize>(f: &F, x: [f64; N]) -> f64 {
        f.value(x)
    }
    fn is_zero(self) -> bool {
        self == 0.0
    }
    fn range(self) -> Interval {
        Interval::point(self)
    }
}

impl JetScalar for Interval {
    const EXACT: bool = false;
    fn image<F: Function<N>, const N: usize>(f: &F, x: [Interval; N]) -> Interval {
        f.range(x)
    }
    fn is_zero(self) -> bool {
        self.lo == 0.0 && self.hi == 0.0
    }
    fn range(self) -> Interval {
        self
    }
}

#[allow(private_bounds)] // the two scalars are listed above; nobody else adds one
impl<R: JetScalar> Number for Jet<R>
where
    Jet<R>: Centred,
{
    const EXACT: bool = R::EXACT;
    fn constant(c: f64) -> Self {
        Jet::still(R::of(c))
    }
    fn add(&self, other: &Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
    fn sub(&self, other: &Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
    fn neg(&self) -> Self {
        self.map(|a| -a)
    }
    fn scale(&self, k: f64) -> Self {
        self.map(|a| a * R::of(k))
    }
    fn shift(&self, c: f64) -> Self {
        Jet { value: self.value + R::of(c), ..*self }
    }
    fn lift<F: Function<N>, const N: usize>(f: &F, x: [&Self; N]) -> Self {
        let at = x.map(|x| x.value);
        Jet::chain(R::image(f, at), f.grad(at), f.hess(at), x, R::is_zero)
    }
    fn kernel<K: Kernel + ?Sized>(k: &K, p: [&Self; 3]) -> Self {
        centred_kernel(k, p)
    }
    fn pointwise<K: Pointwise>(k: &K, p: [&Self; 3], with: Option<&Self>) -> Option<Self> {
        centred_pointwise(k, p, with)
    }
    fn range(&self) -> Interval {
        self.value.range()
    }
}

/// The symmetric matrix of six second derivatives.
pub(super) fn matrix<R: Copy>(h: [R; 6]) -> [[R; 3]; 3] {
    [[h[0], h[3], h[4]], [h[3], h[1], h[5]], [h[4], h[5], h[2]]]
}

impl Centred for Jet<f64> {
    const ORDER: Order = Order::Hessian;
    fn centre(p: [&Self; 3]) -> [f64; 3] {
        p.map(|p| p.value)
    }
    fn expand(Local { jet, .. }: &Local, _: [f64; 3], p: [&Self; 3]) -> Self {
        Jet::chain(jet.value, jet.grad, matrix(jet.hess), p, |d| d == 0.0)
    }
    fn compose(jet: &Point4, p: [&Self; 3], with: Option<&Self>) -> Option<Self> {
        let ([a, b, c, d], zero) = (jet.grad, |d| d == 0.0);
        Some(match with {
            None => Jet::chain(jet.value, [a, b, c], jet.matrix(), p, zero),
            Some(s) => Jet::chain(jet.value, [a, b, c, d], jet.matrix(), [p[0], p[1], p[2], s], zero),
        })
    }
}

impl Centred for Jet<Interval> {
    const ORDER: Order = Order::Hessian;
    fn centre(p: [&Self; 3]) -> [f64; 3] {
        p.map(|p| p.value.mid())
    }
    fn blind(bounds: &Bounds, p: [&Self; 3]) -> bool {
        Region::around(p.map(|p| p.value)).blind(bounds, Order::Hessian)
    }
    fn reach(p: [&Self; 3]) -> f64 {
        Region::around(p.map(|p| p.value)).radius
    }
    fn expand(local: &Local, error: [f64; 3], p: [&Self; 3]) -> Self {
        let region = Region::around(p.map(|p| p.value));
        let value = region.value(local, error);
        let grad = region.gradient(local, error);
        let hess = matrix(region.hessian(local, error));
        Jet::chain(value, grad, hess, p, JetScalar::is_zero)
    }
}

/// A box around the point at which a kernel was evaluated, and what the jet there says about it.
///
/// Taylor's theorem with the kernel's global bounds, `r` the distance of the corners:
/// value in `[-A, A]`, `N(c) +- L r` and `N(c) + g.h +- M2 r^2 / 2` (or the kernel's own bow instead
/// of the last term); gradient in `[-L, L]`,
/// `g +- M2 r` and `g + H h +- M3 r^2 / 2`; Hessian in `[-M2, M2]` and `H +- M3 r`.
pub(super) struct Region {
    /// Offsets from the centre, by axis.
    offset: [Interval; 3],
    /// Largest distance from the centre.
    pub(super) radius: f64,
}

impl Region {
    pub(super) fn around(p: [Interval; 3]) -> Self {
        let offset = p.map(|p| p - Interval::point(p.mid()));
        let [x, y, z] = offset.map(|o| o.mag());
        let radius = (x * x + y * y + z * z).sqrt() * (1.0 + 8.0 * super::ROUNDOFF);
        Region { offset, radius }
    }

    /// Whether nothing up to `order` depends on the jet.
    #[inline]
    pub(super) fn blind(&self, b: &Bounds, order: Order) -> bool {
        b.drown(self.radius)
            && (order < Order::Gradient || b.hessian * self.radius >= 2.0 * b.lipschitz)
            && (order < Order::Hessian || b.third * self.radius >= 2.0 * b.hessian)
    }

    pub(super) fn value(&self, local: &Local, error: [f64; 3]) -> Interval {
        let Local { jet, bounds: b, .. } = local;
        let all = Interval::radius(b.range);
        if b.drown(self.radius) || !jet.value.is_finite() {
            return all;
        }
        let v = Interval::around(jet.value, error[0]);
        let flat = v + Interval::radius(b.lipschitz * self.radius);
        let mut tilt = v + local.bend(self.radius);
        for i in 0..3 {
            tilt = tilt + Interval::around(jet.grad[i], error[1]) * self.offset[i];
        }
        all.meet(flat).meet(tilt)
    }

    pub(super) fn gradient(&self, Local { jet, bounds: b, .. }: &Local, error: [f64; 3]) -> [Interval; 3] {
        let all = Interval::radius(b.lipschitz);
        if b.hessian * self.radius >= 2.0 * b.lipschitz || !jet.value.is_finite() {
            return [all; 3];
        }
        let h = matrix(jet.hess);
        std::array::from_fn(|i| {
            let g = Interval::around(jet.grad[i], error[1]);
            let flat = g + Interval::radius(b.hessian * self.radius);
            if !b.third.is_finite() {
                return all.meet(flat);
            }
            let mut tilt = g + Interval::radius(0.5 * b.third * self.radius * self.radius);
            for j in 0..3 {
                tilt = tilt + Interval::around(h[i][j], error[2]) * self.offset[j];
            }
            all.meet(flat).meet(tilt)
        })
    }

    fn hessian(&self, Local { jet, bounds: b, .. }: &Local, error: [f64; 3]) -> [Interval; 6] {
        let all = Interval::radius(b.hessian);
        if b.third * self.radius >= 2.0 * b.hessian || !b.third.is_finite() || !jet.value.is_finite() {
            return [all; 6];
        }
        jet.hess.map(|h| all.meet(Interval::around(h, error[2]) + Interval::radius(b.third * self.radius)))
    }
}

impl Centred for Interval {
    const ORDER: Order = Order::Gradient;
    fn centre(p: [&Self; 3]) -> [f64; 3] {
        p.map(|p| p.mid())
    }
    const BOX: bool = true;
    fn met<K: Kernel + ?Sized>(self, k: &K, p: [&Self; 3]) -> Self {
        k.over(&p.map(|p| *p)).map_or(self, |known| self.meet(known))
    }
    fn blind(bounds: &Bounds, p: [&Self; 3]) -> bool {
        Region::around(p.map(|p| *p)).blind(bounds, Order::Value)
    }
    fn reach(p: [&Self; 3]) -> f64 {
        Region::around(p.map(|p| *p)).radius
    }
    fn expand(local: &Local, error: [f64; 3], p: [&Self; 3]) -> Self {
        Region::around(p.map(|p| *p)).value(local, error)
    }
}

impl Number for Interval {
    fn constant(c: f64) -> Self {
        Interval::point(c)
    }
    fn add(&self, other: &Self) -> Self {
        *self + *other
    }
    fn sub(&self, other: &Self) -> Self {
        *self - *other
    }
    fn neg(&self) -> Self {
        -*self
    }
    fn scale(&self, k: f64) -> Self {
        *self * k
    }
    fn shift(&self, c: f64) -> Self {
        *self + Interval::point(c)
    }
    fn lift<F: Function<N>, const N: usize>(f: &F, x: [&Self; N]) -> Self {
        f.range(x.map(|x| *x))
    }
    fn kernel<K: Kernel + ?Sized>(k: &K, p: [&Self; 3]) -> Self {
        centred_kernel(k, p)
    }
    fn somewhere(range: Interval) -> Option<Self> {
        Some(range)
    }
    fn range(&self) -> Interval {
        *self
    }
}
