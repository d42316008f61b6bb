//! Enclosures of value and gradient over a box, with a bound on the gradient's norm.
//!
//! The components of a gradient, each in its own interval, lose what the norm knows: for a noise
//! with Lipschitz bound `L` the box `[-L, L]^3` has corners of length `sqrt(3) L`. So the norm is
//! carried beside the components, by the triangle inequality and by the spectral norm of the map
//! from space to a kernel's argument, and the smaller bound wins.

use super::jet::Region;
use super::number::{Centred, centred_kernel};
use super::{Bounds, Function, Interval, Kernel, Local, Number, Order};

/// Enclosure over a box of a value, its gradient and the norm of its gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// Encloses the values.
    pub value: Interval,
    /// Encloses the gradients, by component.
    pub grad: [Interval; 3],
    /// Bounds the gradients' norm.
    pub norm: f64,
}

/// Covers the rounding of a handful of additions and multiplications of bounds.
const ROUND_UP: f64 = 1.0 + 16.0 * f64::EPSILON;

/// Sums of squares below are not as precise as others.
const TINY: f64 = 1e-280;

impl Slope {
    /// The coordinate `axis` (0, 1, 2) over the interval `x`.
    pub fn coordinate(x: Interval, axis: usize) -> Self {
        let mut grad = [Interval::point(0.0); 3];
        grad[axis] = Interval::point(1.0);
        Slope { value: x, grad, norm: 1.0 }
    }

    fn new(value: Interval, grad: [Interval; 3], norm: f64) -> Self {
        let box_norm = length(grad.map(Interval::mag));
        // A NaN bound (zero times infinity) bounds nothing.
        let norm = if norm <= box_norm { norm } else { box_norm };
        Slope { value, grad, norm: if norm.is_nan() { f64::INFINITY } else { norm } }
    }

    fn zip(&self, o: &Self, f: impl Fn(Interval, Interval) -> Interval) -> Self {
        let grad = std::array::from_fn(|i| f(self.grad[i], o.grad[i]));
        Slope::new(f(self.value, o.value), grad, (self.norm + o.norm) * ROUND_UP)
    }
}

/// Of a vector without negative coordinates, no less than its length.
pub(super) fn length([x, y, z]: [f64; 3]) -> f64 {
    root(x * x + y * y + z * z, x + y + z) * ROUND_UP
}

/// The root of something made of squares; a bound on it if these are so small that they may be lost.
fn root(squares: f64, bound: f64) -> f64 {
    if squares < TINY { bound } else { squares.sqrt() }
}

/// `a b`, where a derivative that is exactly zero silences an unbounded partial derivative.
fn silenced(partial: Interval, d: Interval) -> Interval {
    if d.lo == 0.0 && d.hi == 0.0 { Interval::point(0.0) } else { partial * d }
}

/// Gradient of a composition: the chain rule on enclosures.
fn chain<const N: usize>(partial: &[Interval; N], x: &[&Slope; N]) -> [Interval; 3] {
    std::array::from_fn(|axis| {
        (0..N).fold(Interval::point(0.0), |sum, i| {
            let term = silenced(partial[i], x[i].grad[axis]);
            if sum == Interval::point(0.0) { term } else { sum + term }
        })
    })
}

/// Bound on the spectral norm of the Jacobian whose rows are the gradients of `p`:
/// `|J|_2^2 <= |J|_1 |J|_inf`, and the Frobenius norm.
fn spectral<const N: usize>(p: &[&Slope; N]) -> f64 {
    let mag: [[f64; 3]; N] = std::array::from_fn(|i| p[i].grad.map(Interval::mag));
    let row = mag.iter().map(|row| row.iter().sum::<f64>()).fold(0.0, f64::max);
    let column = (0..3).map(|j| mag.iter().map(|row| row[j]).sum::<f64>()).fold(0.0, f64::max);
    let norms = p.iter().map(|p| p.norm);
    let frobenius = root(norms.clone().map(|norm| norm * norm).sum(), norms.sum());
    root(row * column, row.max(column)).min(frobenius) * ROUND_UP
}

impl Number for Slope {
    fn constant(c: f64) -> Self {
        Slope { value: Interval::point(c), grad: [Interval::point(0.0); 3], norm: 0.0 }
    }
    fn add(&self, other: &Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
    fn sub(&self, other: &Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
    fn neg(&self) -> Self {
        Slope { value: -self.value, grad: self.grad.map(|g| -g), norm: self.norm }
    }
    fn scale(&self, k: f64) -> Self {
        Slope::new(self.value * k, self.grad.map(|g| g * k), self.norm * k.abs() * ROUND_UP)
    }
    fn shift(&self, c: f64) -> Self {
        Slope { value: self.value + Interval::point(c), ..*self }
    }
    fn lift<F: Function<N>, const N: usize>(f: &F, x: [&Self; N]) -> Self {
        let at = x.map(|x| x.value);
        let partial = f.grad(at);
        let norm = f.steepness(&at, &x.map(|x| x.norm), spectral(&x));
        let mut grad = chain(&partial, &x);
        if let Some(sum) = f.shares() {
            let hull = |axis: usize| x.iter().map(|x| x.grad[axis]).reduce(Interval::hull);
            (0..3).for_each(|axis| {
                grad[axis] = hull(axis).map_or(grad[axis], |hull| grad[axis].meet(hull * sum))
            });
        }
        Slope::new(f.range(at), grad, norm * ROUND_UP)
    }
    fn kernel<K: Kernel + ?Sized>(k: &K, p: [&Self; 3]) -> Self {
        centred_kernel(k, p)
    }
    fn range(&self) -> Interval {
        self.value
    }
}

impl Centred for Slope {
    const ORDER: Order = Order::Hessian;
    fn centre(p: [&Self; 3]) -> [f64; 3] {
        p.map(|p| p.value.mid())
    }
    fn blind(bounds: &Bounds, p: [&Self; 3]) -> bool {
        Region::around(p.map(|p| p.value)).blind(bounds, Order::Gradient)
    }
    fn reach(p: [&Self; 3]) -> f64 {
        Region::around(p.map(|p| p.value)).radius
    }
    const BOX: bool = true;
    fn met<K: Kernel + ?Sized>(self, k: &K, p: [&Self; 3]) -> Self {
        let Some(lean) = k.lean(Self::centre(p), Self::reach(p)) else { return self };
        let lipschitz = k.bounds().lipschitz;
        let along = |axis: usize| lean.along(p.map(|p| p.grad[axis]), lipschitz);
        Slope { grad: std::array::from_fn(|axis| self.grad[axis].meet(along(axis))), ..self }
    }
    fn expand(local: &Local, error: [f64; 3], p: [&Self; 3]) -> Self {
        let region = Region::around(p.map(|p| p.value));
        let grad = region.gradient(local, error);
        let own = length(grad.map(Interval::mag)).min(local.bounds.lipschitz);
        let norm = own * spectral(&p) * ROUND_UP;
        // No component is longer than the whole: along a direction across the axes the components together say less.
        let within = |part: Interval| if norm.is_finite() { part.meet(Interval::radius(norm)) } else { part };
        Slope::new(region.value(local, error), chain(&grad, &p).map(within), norm)
    }
}
