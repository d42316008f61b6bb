//! First-order duals: a value with its gradient.

use super::number::{Centred, centred_kernel, centred_pointwise};
use super::{Function, Interval, Kernel, Local, Number, Order, Point4, Pointwise};

/// A value and its gradient in x, y, z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual {
    /// Value.
    pub value: f64,
    /// Gradient.
    pub grad: [f64; 3],
}

impl Dual {
    /// The coordinate `axis` (0, 1, 2) at `x`.
    pub fn coordinate(x: f64, axis: usize) -> Self {
        let mut grad = [0.0; 3];
        grad[axis] = 1.0;
        Dual { value: x, grad }
    }

    #[inline(always)]
    fn zip(self, other: Dual, f: impl Fn(f64, f64) -> f64) -> Dual {
        Dual {
            value: f(self.value, other.value),
            grad: std::array::from_fn(|i| f(self.grad[i], other.grad[i])),
        }
    }
}

impl Number for Dual {
    const EXACT: bool = true;
    #[inline(always)]
    fn constant(c: f64) -> Self {
        Dual { value: c, grad: [0.0; 3] }
    }
    #[inline(always)]
    fn add(&self, other: &Self) -> Self {
        self.zip(*other, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(&self, other: &Self) -> Self {
        self.zip(*other, |a, b| a - b)
    }
    #[inline(always)]
    fn neg(&self) -> Self {
        Dual { value: -self.value, grad: self.grad.map(|g| -g) }
    }
    #[inline(always)]
    fn scale(&self, k: f64) -> Self {
        Dual { value: self.value * k, grad: self.grad.map(|g| g * k) }
    }
    #[inline(always)]
    fn shift(&self, c: f64) -> Self {
        Dual { value: self.value + c, ..*self }
    }
    #[inline(always)]
    fn lift<F: Function<N>, const N: usize>(f: &F, x: [&Self; N]) -> Self {
        let at = x.map(|x| x.value);
        let partial = f.grad(at);
        let grad = std::array::from_fn(|axis| chain(&partial, |i| x[i].grad[axis]));
        Dual { value: f.value(at), grad }
    }
    #[inline]
    fn kernel<K: Kernel + ?Sized>(k: &K, p: [&Self; 3]) -> Self {
        centred_kernel(k, p)
    }
    #[inline]
    fn pointwise<K: Pointwise>(k: &K, p: [&Self; 3], with: Option<&Self>) -> Option<Self> {
        centred_pointwise(k, p, with)
    }
    fn range(&self) -> Interval {
        Interval::point(self.value)
    }
}

/// `sum_i partial_i d_i`, where a zero derivative silences an infinite partial (a constant stays
/// constant even at the tip of a square root).
#[inline(always)]
pub(super) fn chain<const N: usize>(partial: &[f64; N], d: impl Fn(usize) -> f64) -> f64 {
    let mut sum = 0.0;
    for i in 0..N {
        let d = d(i);
        sum += if d == 0.0 { 0.0 } else { partial[i] * d };
    }
    sum
}

impl Centred for Dual {
    const ORDER: Order = Order::Gradient;
    #[inline(always)]
    fn centre(p: [&Self; 3]) -> [f64; 3] {
        p.map(|p| p.value)
    }
    #[inline(always)]
    fn expand(Local { jet, .. }: &Local, _: [f64; 3], p: [&Self; 3]) -> Self {
        let grad = std::array::from_fn(|axis| chain(&jet.grad, |i| p[i].grad[axis]));
        Dual { value: jet.value, grad }
    }
    #[inline(always)]
    fn compose(jet: &Point4, p: [&Self; 3], with: Option<&Self>) -> Option<Self> {
        let [a, b, c, d] = jet.grad;
        let grad = std::array::from_fn(|axis| {
            let space = chain(&[a, b, c], |i| p[i].grad[axis]);
            with.map_or(space, |s| space + chain(&[d], |_| s.grad[axis]))
        });
        Some(Dual { value: jet.value, grad })
    }
}
