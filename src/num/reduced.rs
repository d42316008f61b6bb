//! Reduced affine forms with `K` shared symbols, after Messine's AF1 and the thesis, 5.3.
//!
//! ```text
//! x^ = mid + slope_1 e_1 + ... + slope_K e_K + rest e,   e_k and e in [-1, 1]
//! ```
//!
//! The `e_k` are shared by all quantities (along a ray, `K = 1`, `e_1` is the position; in a
//! frustum cell `K = 3`), `e` is private to each and never cancels. Beside the form an interval is
//! carried: the intersection of an affine band with a range is not affine, and either may be the
//! tighter one. Rounding errors of `mid` and the slopes are charged to `rest`.

use super::number::{Centred, centred_kernel};
use super::{Bounds, Form, Function, Interval, Kernel, Local, Number, Order, ROUNDOFF};

/// An affine form with `K` shared symbols and an interval that also holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reduced<const K: usize> {
    /// Centre.
    pub mid: f64,
    /// Coefficients of the shared symbols.
    pub slope: [f64; K],
    /// Coefficient of the private symbol, not negative.
    pub rest: f64,
    /// Encloses the values, at least as tightly as the form.
    pub range: Interval,
}

/// Covers the roundings of the handful of additions inside a bound.
const ROUND_UP: f64 = 1.0 + 16.0 * ROUNDOFF;

impl<const K: usize> Reduced<K> {
    /// `mid + sum slope_k e_k`, exact.
    #[inline(always)]
    pub fn new(mid: f64, slope: [f64; K]) -> Self {
        Reduced { mid, slope, rest: 0.0, range: Interval::ENTIRE }.tightened(Interval::ENTIRE)
    }

    /// `mid + sum slope_k e_k`, known to within `rest`.
    #[inline(always)]
    pub fn within(mid: f64, slope: [f64; K], rest: f64) -> Self {
        let form = Reduced { mid, slope, rest, range: Interval::ENTIRE };
        Reduced { range: Interval::around(mid, form.radius()), ..form }
    }

    /// The form that knows nothing but a range.
    #[inline(always)]
    fn constant_range(range: Interval) -> Self {
        Reduced { mid: range.mid(), slope: [0.0; K], rest: range.rad(), range }
    }

    #[inline(always)]
    fn spread(&self) -> f64 {
        self.slope.iter().map(|s| s.abs()).sum::<f64>()
    }

    /// Largest distance of the affine form from its centre.
    #[inline(always)]
    pub fn radius(&self) -> f64 {
        (self.spread() + self.rest) * ROUND_UP
    }

    /// Intersects with a range known otherwise; where the form has nothing to add, drops it.
    #[inline(always)]
    fn tightened(self, known: Interval) -> Self {
        let hull = Interval::around(self.mid, self.radius());
        let range = hull.meet(known);
        if self.rest < range.rad() || self.rest == 0.0 {
            Reduced { range, ..self }
        } else {
            Reduced::constant_range(range)
        }
    }

    #[inline(always)]
    fn zip(&self, o: &Self, range: Interval, f: impl Fn(f64, f64) -> f64) -> Self {
        let mid = f(self.mid, o.mid);
        let slope: [f64; K] = std::array::from_fn(|k| f(self.slope[k], o.slope[k]));
        let error = ROUNDOFF * (mid.abs() + slope.iter().map(|s| s.abs()).sum::<f64>());
        Reduced { mid, slope, rest: (self.rest + o.rest + error) * ROUND_UP, range }.tightened(range)
    }

    /// `sum w_i x_i` as centre, slopes and private part (without rounding errors).
    #[inline(always)]
    fn combine<const N: usize>(x: &[&Self; N], centre: &[f64; N], w: &[f64; N]) -> (f64, [f64; K], f64, f64) {
        let (mut mid, mut slope, mut rest, mut size) = (0.0, [0.0; K], 0.0, 0.0);
        for i in 0..N {
            let offset = x[i].mid - centre[i];
            mid += w[i] * offset;
            rest += w[i].abs() * x[i].rest;
            size += w[i].abs() * (offset.abs() + x[i].spread());
            for (s, t) in slope.iter_mut().zip(x[i].slope) {
                *s += w[i] * t;
            }
        }
        (mid, slope, rest, size)
    }

    /// Enclosure of `1/2 (x - c)^T M (x - c)`, as centre and radius, where `x_i - c_i` is the shared
    /// part of `x_i` and anything up to `loose_i`.
    #[inline(always)]
    fn quadratic<const N: usize>(x: &[&Self; N], loose: &[f64; N], m: &[[f64; N]; N]) -> (f64, f64) {
        let (mut mid, mut rad) = (0.0, 0.0);
        for k in 0..K {
            // e_k^2 lies in [0, 1]: its mean moves to the centre.
            let mut square = 0.0;
            let mut size = 0.0;
            for i in 0..N {
                for j in 0..N {
                    let term = 0.5 * m[i][j] * x[i].slope[k] * x[j].slope[k];
                    square += term;
                    size += term.abs();
                }
            }
            mid += 0.5 * square;
            rad += 0.5 * square.abs() + size * (4 * N) as f64 * ROUNDOFF;
            for l in 0..k {
                let (mut cross, mut size) = (0.0_f64, 0.0);
                for i in 0..N {
                    for j in 0..N {
                        let term = m[i][j] * x[i].slope[k] * x[j].slope[l];
                        cross += term;
                        size += term.abs();
                    }
                }
                rad += cross.abs() + size * (4 * N) as f64 * ROUNDOFF;
            }
        }
        if loose.iter().any(|l| *l != 0.0) {
            for i in 0..N {
                for j in 0..N {
                    let shared = x[i].spread() * loose[j] + loose[i] * x[j].spread();
                    rad += 0.5 * m[i][j].abs() * (shared + loose[i] * loose[j]);
                }
            }
        }
        (mid, rad * ROUND_UP)
    }

    #[inline(always)]
    fn from_form<const N: usize>(
        form: Form<N>,
        x: &[&Self; N],
        boxes: &[Interval; N],
        range: Interval,
    ) -> Self {
        let centre = boxes.map(Interval::mid);
        let (offset, slope, mut rest, size) = Self::combine(x, &centre, &form.slope);
        let mut mid = form.rest.mid() + offset;
        rest += form.rest.rad();
        if form.bend.lo != 0.0 || form.bend.hi != 0.0 {
            // The box may be centred elsewhere than the form, by rounding or because it is tighter.
            let loose = std::array::from_fn(|i| x[i].rest + (x[i].mid - centre[i]).abs());
            let (qm, qr) = Self::quadratic(x, &loose, &form.matrix);
            let q = Interval { lo: qm - qr, hi: qm + qr } * form.bend;
            mid += q.mid();
            rest += q.rad();
        }
        rest += ROUNDOFF * ((2 * N + 4) as f64 * size + 4.0 * mid.abs());
        if !(mid.is_finite() && rest.is_finite() && slope.iter().all(|s| s.is_finite())) {
            return Self::constant_range(range);
        }
        Reduced { mid, slope, rest: rest * ROUND_UP, range }.tightened(range)
    }
}

impl<const K: usize> Number for Reduced<K> {
    #[inline(always)]
    fn constant(c: f64) -> Self {
        Reduced { mid: c, slope: [0.0; K], rest: 0.0, range: Interval::point(c) }
    }
    #[inline(always)]
    fn add(&self, other: &Self) -> Self {
        self.zip(other, self.range + other.range, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(&self, other: &Self) -> Self {
        self.zip(other, self.range - other.range, |a, b| a - b)
    }
    #[inline(always)]
    fn neg(&self) -> Self {
        Reduced { mid: -self.mid, slope: self.slope.map(|s| -s), rest: self.rest, range: -self.range }
    }
    #[inline(always)]
    fn scale(&self, k: f64) -> Self {
        let (mid, slope) = (self.mid * k, self.slope.map(|s| s * k));
        let error = ROUNDOFF * (mid.abs() + slope.iter().map(|s| s.abs()).sum::<f64>()) + 1e-300;
        let rest = (self.rest * k.abs() + error) * ROUND_UP;
        Reduced { mid, slope, rest, range: self.range * k }
    }
    #[inline(always)]
    fn shift(&self, c: f64) -> Self {
        let mid = self.mid + c;
        let rest = (self.rest + ROUNDOFF * mid.abs()) * ROUND_UP;
        Reduced { mid, rest, range: self.range + Interval::point(c), ..*self }
    }
    #[inline(always)]
    fn lift<F: Function<N>, const N: usize>(f: &F, x: [&Self; N]) -> Self {
        let boxes = x.map(|x| x.range);
        let range = f.range(boxes);
        let combine = |w: &[f64; N]| {
            let (mid, slope, rest, size) = Self::combine(&x, &[0.0; N], w);
            let radius = slope.iter().map(|s| s.abs()).sum::<f64>() + rest + 16.0 * ROUNDOFF * size;
            let natural = (0..N).fold(Interval::point(0.0), |sum, i| sum + boxes[i] * w[i]);
            Interval::around(mid, radius * ROUND_UP).meet(natural)
        };
        Self::from_form(f.form(&boxes, &combine), &x, &boxes, range)
    }
    #[inline(always)]
    fn kernel<K2: Kernel + ?Sized>(k: &K2, p: [&Self; 3]) -> Self {
        centred_kernel(k, p)
    }
    #[inline(always)]
    fn somewhere(range: Interval) -> Option<Self> {
        Some(Self::constant_range(range))
    }
    fn range(&self) -> Interval {
        self.range
    }
}

impl<const K: usize> Centred for Reduced<K> {
    const ORDER: Order = Order::Gradient;

    #[inline(always)]
    fn centre(p: [&Self; 3]) -> [f64; 3] {
        p.map(|p| p.mid)
    }

    #[inline(always)]
    fn blind(b: &Bounds, p: [&Self; 3]) -> bool {
        let (d, omega) = reach(p);
        b.drown(d + omega)
    }

    /// With `x = c + d e + w`, `|w| <= omega` (spec: ray casting, 9.1), the tightest of
    ///
    /// ```text
    /// (T)   N(c) + (g . d) e +- (M2 |d|^2 / 2 + L omega)
    /// (T')  N(c) + (g . d) e +- (|g_i| w_i + M2 (|d| + omega)^2 / 2)
    /// (Z)   N(c) +- L (|d| + omega)
    /// (G)   [-A, A]
    /// (B)   N(c) + (g . d) e + bow +- |g_i| w_i          with the kernel's own bow, if it has one
    /// ```
    #[inline(always)]
    fn reach(p: [&Self; 3]) -> f64 {
        let (d, omega) = reach(p);
        (d + omega) * ROUND_UP
    }

    #[inline(always)]
    fn expand(Local { jet, bounds: b, bow, .. }: &Local, error: [f64; 3], p: [&Self; 3]) -> Self {
        let all = Interval::radius(b.range);
        let (d, omega) = reach(p);
        let w = p.map(|p| p.rest);
        if b.drown(d + omega) || !jet.value.is_finite() {
            return Self::constant_range(all);
        }
        let g = jet.grad;
        let slope: [f64; K] =
            std::array::from_fn(|k| g[0] * p[0].slope[k] + g[1] * p[1].slope[k] + g[2] * p[2].slope[k]);
        let t = 0.5 * b.hessian * d * d + b.lipschitz * omega;
        let along: f64 = (0..3).map(|i| g[i].abs() * w[i]).sum();
        let t2 = along + 0.5 * b.hessian * (d + omega) * (d + omega);
        let rounding = error[0] + 2.0 * error[1] * (d + omega) + 8.0 * ROUNDOFF * b.lipschitz * d;
        let flat = Interval::around(jet.value, (b.lipschitz * (d + omega) + error[0]) * ROUND_UP);
        let known = all.meet(flat);
        // The kernel's own bow, where it is the tightest.
        let (mut mid, mut bend) = (jet.value, t.min(t2));
        if along + bow.rad() < bend {
            mid += bow.mid();
            bend = along + bow.rad() + 2.0 * ROUNDOFF * (bow.mag() + mid.abs());
        }
        if !bend.is_finite() {
            return Self::constant_range(known);
        }
        Reduced { mid, slope, rest: (bend + rounding) * ROUND_UP, range: all }.tightened(known)
    }
}

#[inline(always)]
fn norm([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt() * ROUND_UP
}

/// `|d|` and `omega` of [`Reduced::expand`]. Corners of the parallelepiped lie within the box that
/// holds it, and within the sum of its edges' lengths.
#[inline(always)]
fn reach<const K: usize>(p: [&Reduced<K>; 3]) -> (f64, f64) {
    let edges: f64 = (0..K).map(|k| norm(p.map(|p| p.slope[k]))).sum();
    (edges.min(norm(p.map(|p| p.spread()))), norm(p.map(|p| p.rest)))
}
