//! The norms in which cellular noise measures distance, each with what enclosures need to know of it.
//!
//! With `d` the offset of a point from a node, `|d|_p = (sum |d_i|^p)^(1/p)` and its gradient has the
//! components `sgn(d_i) (|d_i| / |d|)^(p-1)`. Every norm is convex, so a tangent plane lies below
//! it; [`Metric::excess`] says how far above the plane it gets within a ball.

use crate::num::ROUNDOFF;

/// A norm of three-dimensional space.
pub(super) trait Metric: Copy {
    /// Something that grows with the norm and is cheaper to compute; infinite where that is at least
    /// `limit` for certain.
    fn measure(self, d: [f64; 3], limit: f64) -> f64;

    /// What [`rough`](Metric::rough) may be off by, several times over, for vectors in grains; see
    /// `scout.rs`. None if it says nothing about the measure.
    const SLACK: Option<f32>;

    /// What a component adds to the measure, in single precision,
    fn part(self, x: f32) -> f32;

    /// and the measure of such parts.
    fn joined(self, parts: [f32; 3]) -> f32;

    /// The measure in single precision.
    #[inline(always)]
    fn rough(self, [x, y, z]: [f32; 3]) -> f32 {
        self.joined([self.part(x), self.part(y), self.part(z)])
    }

    /// At most the measure of any vector whose components have at least these sizes.
    fn floor(self, gap: [f64; 3]) -> f64;

    /// The norm from its measure.
    fn distance(self, measure: f64) -> f64;

    /// Gradient of the norm at `d`, whose norm is `size`; zero at the origin.
    fn slope(self, d: [f64; 3], size: f64) -> [f64; 3];

    /// Second derivatives of the norm: xx, yy, zz, xy, xz, yz.
    fn hessian(self, d: [f64; 3], size: f64) -> [f64; 6];

    /// Largest Euclidean length of the gradient.
    fn steepness(self) -> f64;

    /// Largest second directional derivative within `r` of `d`; infinite if there is a crease.
    fn curvature(self, d: [f64; 3], size: f64, r: f64) -> f64;

    /// How far the norm gets above its tangent plane at `d` within `r` of it.
    fn excess(self, d: [f64; 3], size: f64, r: f64) -> f64;

    /// Largest second directional derivative of the norm's square within `r` of `d`.
    #[inline]
    fn square_curvature(self, d: [f64; 3], size: f64, r: f64) -> f64 {
        // (s^2)'' = 2 s'^2 + 2 s s''
        let steep = self.steepness();
        2.0 * (steep * steep + (size + steep * r) * self.curvature(d, size, r)) * ROUND_UP
    }

    /// How far the norm's square gets above its tangent plane at `d` within `r` of it.
    #[inline]
    fn square_excess(self, d: [f64; 3], size: f64, r: f64) -> f64 {
        // (s + g.h + e)^2 - s^2 - 2 s g.h = (g.h)^2 + 2 e (s + g.h) + e^2
        let (e, g) = (self.excess(d, size, r), self.steepness() * r);
        g * g + 2.0 * e * (size + g) + e * e
    }
}

/// The length of a vector.
#[derive(Clone, Copy)]
pub(super) struct Euclidean;

/// The sum of the components' sizes.
#[derive(Clone, Copy)]
pub(super) struct Manhattan;

/// The largest component's size.
#[derive(Clone, Copy)]
pub(super) struct Chebyshev;

/// The norm with a given exponent, at least 1.
#[derive(Clone, Copy)]
pub(super) struct Minkowski(pub f64);

/// Covers the roundings of a bound, those of `libm::pow` among them.
const ROUND_UP: f64 = 1.0 + 256.0 * ROUNDOFF;

#[inline(always)]
fn larger<T: PartialOrd>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

/// `1` with the sign of `x`; zero at zero.
#[inline(always)]
fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { 1.0_f64.copysign(x) }
}

/// `k (m - g g^T)` for a diagonal matrix `m`, as six numbers.
#[inline(always)]
fn across(k: f64, m: [f64; 3], g: [f64; 3]) -> [f64; 6] {
    [
        k * (m[0] - g[0] * g[0]),
        k * (m[1] - g[1] * g[1]),
        k * (m[2] - g[2] * g[2]),
        -k * g[0] * g[1],
        -k * g[0] * g[2],
        -k * g[1] * g[2],
    ]
}

impl Metric for Euclidean {
    const SLACK: Option<f32> = Some(10.0);

    #[inline(always)]
    fn part(self, x: f32) -> f32 {
        x * x
    }
    #[inline(always)]
    fn joined(self, [x, y, z]: [f32; 3]) -> f32 {
        x + y + z
    }
    #[inline(always)]
    fn measure(self, [x, y, z]: [f64; 3], _: f64) -> f64 {
        x * x + y * y + z * z
    }
    #[inline(always)]
    fn floor(self, [x, y, z]: [f64; 3]) -> f64 {
        x * x + y * y + z * z
    }
    #[inline(always)]
    fn distance(self, measure: f64) -> f64 {
        measure.sqrt()
    }
    #[inline(always)]
    fn slope(self, d: [f64; 3], size: f64) -> [f64; 3] {
        let k = if size > 0.0 { 1.0 / size } else { 0.0 };
        [d[0] * k, d[1] * k, d[2] * k]
    }
    #[inline(always)]
    fn hessian(self, d: [f64; 3], size: f64) -> [f64; 6] {
        let k = if size > 0.0 { 1.0 / size } else { 0.0 };
        across(k, [1.0; 3], self.slope(d, size))
    }
    fn steepness(self) -> f64 {
        1.0
    }
    #[inline]
    fn curvature(self, _: [f64; 3], size: f64, r: f64) -> f64 {
        if size > r { ROUND_UP / (size - r) } else { f64::INFINITY }
    }
    /// `|d + h|^2 = |d|^2 + 2 d.h + |h|^2`, and a square root lies below its tangent.
    #[inline]
    fn excess(self, _: [f64; 3], size: f64, r: f64) -> f64 {
        0.5 * r * r / size * ROUND_UP
    }
    #[inline]
    fn square_curvature(self, _: [f64; 3], _: f64, _: f64) -> f64 {
        2.0
    }
    #[inline]
    fn square_excess(self, _: [f64; 3], _: f64, r: f64) -> f64 {
        r * r * ROUND_UP
    }
}

impl Metric for Manhattan {
    const SLACK: Option<f32> = Some(0.01);

    #[inline(always)]
    fn part(self, x: f32) -> f32 {
        x.abs()
    }
    #[inline(always)]
    fn joined(self, [x, y, z]: [f32; 3]) -> f32 {
        x + y + z
    }
    #[inline(always)]
    fn measure(self, [x, y, z]: [f64; 3], _: f64) -> f64 {
        x.abs() + y.abs() + z.abs()
    }
    #[inline(always)]
    fn floor(self, [x, y, z]: [f64; 3]) -> f64 {
        x + y + z
    }
    #[inline(always)]
    fn distance(self, measure: f64) -> f64 {
        measure
    }
    #[inline(always)]
    fn slope(self, d: [f64; 3], _: f64) -> [f64; 3] {
        [sign(d[0]), sign(d[1]), sign(d[2])]
    }
    #[inline(always)]
    fn hessian(self, _: [f64; 3], _: f64) -> [f64; 6] {
        [0.0; 6]
    }
    fn steepness(self) -> f64 {
        3.0_f64.sqrt() * ROUND_UP
    }
    #[inline]
    fn curvature(self, d: [f64; 3], _: f64, r: f64) -> f64 {
        if d.iter().all(|d| d.abs() > r) { 0.0 } else { f64::INFINITY }
    }
    /// A component bends only where it changes sign: `|d + h| <= |d| + sgn(d) h + 2 max(0, r - |d|)`.
    #[inline]
    fn excess(self, d: [f64; 3], _: f64, r: f64) -> f64 {
        d.iter().map(|d| 2.0 * larger(r - d.abs(), 0.0)).sum::<f64>() * ROUND_UP
    }
}

impl Metric for Chebyshev {
    const SLACK: Option<f32> = Some(0.01);

    #[inline(always)]
    fn part(self, x: f32) -> f32 {
        x.abs()
    }
    #[inline(always)]
    fn joined(self, [x, y, z]: [f32; 3]) -> f32 {
        larger(larger(x, y), z)
    }
    #[inline(always)]
    fn measure(self, [x, y, z]: [f64; 3], _: f64) -> f64 {
        larger(larger(x.abs(), y.abs()), z.abs())
    }
    #[inline(always)]
    fn floor(self, [x, y, z]: [f64; 3]) -> f64 {
        larger(larger(x, y), z)
    }
    #[inline(always)]
    fn distance(self, measure: f64) -> f64 {
        measure
    }
    #[inline(always)]
    fn slope(self, [x, y, z]: [f64; 3], size: f64) -> [f64; 3] {
        let on_x = x.abs() == size;
        let on_y = !on_x && y.abs() == size;
        let on = |yes: bool, d: f64| if yes { sign(d) } else { 0.0 };
        [on(on_x, x), on(on_y, y), on(!on_x && !on_y, z)]
    }
    #[inline(always)]
    fn hessian(self, _: [f64; 3], _: f64) -> [f64; 6] {
        [0.0; 6]
    }
    fn steepness(self) -> f64 {
        1.0
    }
    #[inline]
    fn curvature(self, d: [f64; 3], size: f64, r: f64) -> f64 {
        // Two components swap places where their sizes differ by less than sqrt(2) r.
        let close = d.iter().filter(|d| d.abs() >= size - 1.4143 * r * ROUND_UP).count();
        if close == 1 && size > r { 0.0 } else { f64::INFINITY }
    }
    /// Each component is at most linear plus `2 max(0, r - |d|)`, so their maximum is at most the
    /// tangent plane of the largest plus what another may gain on it.
    #[inline]
    fn excess(self, d: [f64; 3], size: f64, r: f64) -> f64 {
        let own = self.slope(d, size);
        let gains = [0, 1, 2].map(|i| {
            let turn = if own[i] != 0.0 { 0.0 } else { 1.4143 };
            d[i].abs() - size + turn * r + 2.0 * larger(r - d[i].abs(), 0.0)
        });
        // At the origin there is no tangent plane to speak of.
        let turn = if size == 0.0 { r } else { 0.0 };
        gains.into_iter().fold(turn, larger) * ROUND_UP
    }
}

impl Minkowski {
    #[inline(always)]
    fn largest([x, y, z]: [f64; 3]) -> f64 {
        larger(larger(x.abs(), y.abs()), z.abs())
    }
}

impl Metric for Minkowski {
    const SLACK: Option<f32> = None;

    #[inline(always)]
    fn part(self, x: f32) -> f32 {
        x.abs()
    }
    #[inline(always)]
    fn joined(self, [x, y, z]: [f32; 3]) -> f32 {
        larger(larger(x, y), z)
    }
    /// The norm itself. Divided by the largest component, no power overflows.
    #[inline(always)]
    fn measure(self, d: [f64; 3], limit: f64) -> f64 {
        let top = Minkowski::largest(d);
        if top >= limit {
            return f64::INFINITY;
        }
        if top == 0.0 {
            return 0.0;
        }
        let sum: f64 = d.iter().map(|d| libm::pow(d.abs() / top, self.0)).sum();
        top * libm::pow(sum, 1.0 / self.0)
    }
    #[inline(always)]
    fn floor(self, gap: [f64; 3]) -> f64 {
        Minkowski::largest(gap)
    }
    #[inline(always)]
    fn distance(self, measure: f64) -> f64 {
        measure
    }
    #[inline(always)]
    fn slope(self, d: [f64; 3], size: f64) -> [f64; 3] {
        d.map(|d| if d == 0.0 { 0.0 } else { sign(d) * libm::pow(d.abs() / size, self.0 - 1.0) })
    }
    #[inline(always)]
    fn hessian(self, d: [f64; 3], size: f64) -> [f64; 6] {
        if size == 0.0 {
            return [0.0; 6];
        }
        // Below 2 a component that vanishes has an infinite second derivative: a crease.
        let flat = d.map(|d| if d == 0.0 { 0.0 } else { libm::pow(d.abs() / size, self.0 - 2.0) });
        across((self.0 - 1.0) / size, flat, self.slope(d, size))
    }
    fn steepness(self) -> f64 {
        if self.0 < 2.0 { libm::pow(3.0, 1.0 / self.0 - 0.5) * ROUND_UP } else { 1.0 }
    }
    /// The Hessian is `(p-1)/|d| (diag(w_i^(p-2)) - g g^T)` with `w_i = |d_i| / |d| <= 1`.
    #[inline]
    fn curvature(self, d: [f64; 3], size: f64, r: f64) -> f64 {
        let (p, near) = (self.0, size - self.steepness() * r);
        if near <= 0.0 {
            return f64::INFINITY;
        }
        if p >= 2.0 {
            return (p - 1.0) / near * ROUND_UP;
        }
        let least = d.iter().fold(f64::INFINITY, |m: f64, d| if d.abs() < m { d.abs() } else { m }) - r;
        if least <= 0.0 {
            return f64::INFINITY;
        }
        (p - 1.0) * libm::pow(least, p - 2.0) / libm::pow(near, p - 1.0) * ROUND_UP
    }
    /// From 2 on, half the squared norm has second derivatives of at most `p - 1`, and the root of
    /// `|d|^2 + 2 |d| g.h + (p-1) h^2` lies below its tangent.
    #[inline]
    fn excess(self, d: [f64; 3], size: f64, r: f64) -> f64 {
        if self.0 >= 2.0 {
            0.5 * (self.0 - 1.0) * r * r / size * ROUND_UP
        } else {
            0.5 * self.curvature(d, size, r) * r * r * ROUND_UP
        }
    }
    #[inline]
    fn square_excess(self, d: [f64; 3], size: f64, r: f64) -> f64 {
        if self.0 >= 2.0 {
            return (self.0 - 1.0) * r * r * ROUND_UP;
        }
        let (e, g) = (self.excess(d, size, r), self.steepness() * r);
        g * g + 2.0 * e * (size + g) + e * e
    }
}
