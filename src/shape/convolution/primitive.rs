//! Integrals of the two kernels over points, segments, triangles and arcs, in closed form.
//!
//! Forms that depend on the distances along and across (`X` and `q = |w|^2`) have their derivatives by
//! these written out; those of triangles and arcs are Taylor polynomials. What is integrated is divided
//! by its integral over an endless line or plane through the point, so that a long thread and a wide
//! sheet have the value 1 within, as a single point has.

use super::taylor::{Scalar, Taylor};
use crate::num::{Order, PAIRS, Point};
use glam::DVec3;
use std::f64::consts::PI;

/// What is convolved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Primitive {
    /// A point.
    Point(DVec3),
    /// The points between two.
    Segment([DVec3; 2]),
    /// The points between three.
    Triangle([DVec3; 3]),
    /// A part of a circle.
    Arc(Arc),
}

/// A part of a circle: `centre + radius (cos t first + sin t second)` for `t` from 0 to `angle`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    centre: DVec3,
    first: DVec3,
    second: DVec3,
    radius: f64,
    angle: f64,
}

impl Arc {
    /// The arc from one point through another to a third; none if they lie on a line.
    pub fn through(a: DVec3, b: DVec3, c: DVec3) -> Option<Arc> {
        let (u, v) = (b - a, c - a);
        let normal = u.cross(v);
        let area = normal.length_squared();
        // What is not a number is on a line, too.
        let on_line = 1e-20 * u.length_squared() * v.length_squared();
        if area.partial_cmp(&on_line).is_none_or(|o| o.is_le()) {
            return None;
        }
        // The centre is as far from all three.
        let to_centre =
            (u.length_squared() * v.cross(normal) + v.length_squared() * normal.cross(u)) / (2.0 * area);
        let centre = a + to_centre;
        let radius = to_centre.length();
        let first = -to_centre / radius;
        let second = normal.normalize().cross(first);
        let turn = |p: DVec3| {
            let d = p - centre;
            libm::atan2(d.dot(second), d.dot(first)).rem_euclid(2.0 * PI)
        };
        Some(Arc { centre, first, second, radius, angle: turn(c) })
    }

    /// The point at `t` from 0 to 1.
    pub fn at(&self, t: f64) -> DVec3 {
        let (sin, cos) = libm::sincos(t * self.angle);
        self.centre + self.radius * (cos * self.first + sin * self.second)
    }

    /// Its length.
    pub fn length(&self) -> f64 {
        self.radius * self.angle
    }

    /// The integral of the Cauchy kernel, with `(x, y, z)` about the centre, `A = 1 + s^2 (|x|^2 + R^2)`,
    /// `C(t) = 2 s^2 R (x cos t + y sin t)`, `S(t) = 2 s^2 R (x sin t - y cos t)`,
    /// `W^2 = A^2 - 4 s^4 R^2 (x^2 + y^2) > 0`:
    ///
    /// ```text
    /// R / W^2 [ S / (A - C) + A / W (t + 2 atan(S / (A + W - C))) ]      between the ends
    /// ```
    ///
    /// which is smooth across the axis of the circle, and needs no cases for arcs of any length.
    fn cauchy<T: Scalar>(&self, s: f64, p: [T; 3]) -> T {
        let [x, y, z] = frame([self.first, self.second, self.first.cross(self.second)], self.centre, p);
        let (r, s2) = (self.radius, s * s);
        let flat = x * x + y * y;
        let a = T::of(1.0 + s2 * r * r) + (flat + z * z).times(s2);
        let w2 = a * a - flat.times(4.0 * s2 * s2 * r * r);
        let w = w2.sqrt();
        let end = |t: f64| {
            let (sin, cos) = libm::sincos(t);
            let c = (x.times(cos) + y.times(sin)).times(2.0 * s2 * r);
            let side = (x.times(sin) - y.times(cos)).times(2.0 * s2 * r);
            side / (a - c) + a / w * (T::of(t) + (side / (a + w - c)).atan().times(2.0))
        };
        (end(self.angle) - end(0.0)) / w2 * T::of(r)
    }
}

/// Coordinates along unit vectors from an origin.
fn frame<T: Scalar, const N: usize>(axes: [DVec3; N], origin: DVec3, p: [T; 3]) -> [T; N] {
    axes.map(|e| (0..3).fold(T::of(-e.dot(origin)), |sum, k| sum + p[k].times(e[k])))
}

/// The integral of the Cauchy kernel over a triangle. With `n` its normal, `d` the height above its
/// plane, `c2 = 1 + s^2 d^2`, and for each edge from `A` in the direction `t`, `e` the distance to the
/// inner side, `t1` and `t2` where the ends are along it, `g^2 = c2 + s^2 e^2`:
///
/// ```text
/// 1 / (2 s c2)  sum of  e / g [atan(s t2 / g) - atan(s t1 / g)]
/// ```
fn triangle_cauchy<T: Scalar>(corners: &[DVec3; 3], s: f64, p: [T; 3]) -> T {
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
    let [height] = frame([normal], corners[0], p);
    let c2 = T::of(1.0) + (height * height).times(s * s);
    let mut sum = T::of(0.0);
    for k in 0..3 {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        let along = (b - a).normalize_or_zero();
        let [from, inner] = frame([along, normal.cross(along)], a, p);
        let g = (c2 + (inner * inner).times(s * s)).sqrt();
        let ends = ((T::of((b - a).length()) - from).times(s) / g).atan() + (from.times(s) / g).atan();
        sum = sum + inner / g * ends;
    }
    sum / c2.times(2.0 * s)
}

/// A function of the distances along and across, with its derivatives.
#[derive(Default)]
struct Along {
    value: f64,
    /// By X and by q.
    first: [f64; 2],
    /// By XX, Xq and qq.
    second: [f64; 3],
}

impl Along {
    /// As a function of space: `grad X = u`, `grad q = 2 w`, and `q` has the Hessian `2 (I - u u^T)`.
    fn point(&self, u: DVec3, w: DVec3) -> Point {
        let ([fx, fq], [fxx, fxq, fqq]) = (self.first, self.second);
        let hess = std::array::from_fn(|k| {
            let (r, c) = PAIRS[k];
            let unit = if r == c { 1.0 } else { 0.0 };
            fxx * u[r] * u[c]
                + 2.0 * fxq * (u[r] * w[c] + u[c] * w[r])
                + 4.0 * fqq * w[r] * w[c]
                + 2.0 * fq * (unit - u[r] * u[c])
        });
        Point { value: self.value, grad: (fx * u + 2.0 * fq * w).into(), hess }
    }
}

/// Integrals of `(P + s^2 t^2)^-n` over `t` from `-X` to `l - X`, with `P = 1 + s^2 q`:
///
/// ```text
/// K_1 = [atan(s t / sqrt P)] / (s sqrt P)       K_(n+1) = [t (P + s^2 t^2)^-n] / (2 n P) + (2n - 1) / (2n P) K_n
/// ```
fn segment_cauchy(s: f64, x: f64, length: f64, q: f64) -> Along {
    let s2 = s * s;
    let plus = 1.0 + s2 * q;
    let root = plus.sqrt();
    let (t, other) = (length - x, x);
    let [a, b] = [t, other].map(|t| 1.0 / (plus + s2 * t * t));
    let k1 = (libm::atan(s * t / root) + libm::atan(s * other / root)) / (s * root);
    let k2 = (t * a + other * b + k1) / (2.0 * plus);
    let k3 = (t * a * a + other * b * b + 3.0 * k2) / (4.0 * plus);
    let k4 = (t * a * a * a + other * b * b * b + 5.0 * k3) / (6.0 * plus);
    Along {
        value: k2,
        first: [b * b - a * a, -2.0 * s2 * k3],
        second: [
            -4.0 * s2 * (t * a * a * a + other * b * b * b),
            -2.0 * s2 * (b * b * b - a * a * a),
            6.0 * s2 * s2 * k4,
        ],
    }
}

/// The integral of `(C - t^2 / R^2)^2` over the `t` from `-X` to `l - X` with `t^2 < C R^2`, where
/// `C = 1 - q / R^2`. Where the kernel ends it and its slope are zero, so that the ends of the
/// integral's range move nothing there.
fn segment_compact(radius: f64, x: f64, length: f64, q: f64) -> Along {
    let r2 = radius * radius;
    let c = 1.0 - q / r2;
    if c <= 0.0 {
        return Along::default();
    }
    let half = radius * c.sqrt();
    let (a, b) = ((-x).max(-half), (length - x).min(half));
    if b <= a {
        return Along::default();
    }
    let rest = |t: f64| if t.abs() >= half { 0.0 } else { c - t * t / r2 };
    let [ra, rb] = [a, b].map(rest);
    let (cubes, fifths) = (b * b * b - a * a * a, b * b * b * b * b - a * a * a * a * a);
    Along {
        value: c * c * (b - a) - 2.0 * c * cubes / (3.0 * r2) + fifths / (5.0 * r2 * r2),
        first: [ra * ra - rb * rb, -2.0 / r2 * (c * (b - a) - cubes / (3.0 * r2))],
        second: [4.0 / r2 * (a * ra - b * rb), -2.0 / r2 * (ra - rb), 2.0 / (r2 * r2) * (b - a)],
    }
}

/// How the density falls with the distance.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Falloff {
    /// `1 / (1 + s^2 r^2)^2`, by `s`.
    Cauchy(f64),
    /// `(1 - r^2 / R^2)^2` within `R`.
    Compact(f64),
}

impl Falloff {
    /// One over the length that the kernel falls in.
    pub fn rate(self) -> f64 {
        match self {
            Falloff::Cauchy(s) => s,
            Falloff::Compact(r) => 1.0 / r,
        }
    }

    /// The most that an integral over a primitive is, in units. A quarter of a circle is no steeper than
    /// 45 degrees to its chord, so along it there is at most `sqrt 2` times what is along the line.
    pub fn height(self, primitive: &Primitive) -> f64 {
        match primitive {
            Primitive::Arc(arc) => (arc.length() * self.unit(primitive)).min(5.7),
            _ => 1.0,
        }
    }

    /// One over the integral along an endless line, and over an endless plane, through the point.
    pub fn unit(self, primitive: &Primitive) -> f64 {
        let dimension = match primitive {
            Primitive::Point(_) => 0,
            Primitive::Segment(_) | Primitive::Arc(_) => 1,
            Primitive::Triangle(_) => 2,
        };
        match (self, dimension) {
            (_, 0) => 1.0,
            (Falloff::Cauchy(s), 1) => 2.0 * s / PI,
            (Falloff::Cauchy(s), _) => s * s / PI,
            (Falloff::Compact(r), 1) => 15.0 / (16.0 * r),
            (Falloff::Compact(r), _) => 3.0 / (PI * r * r),
        }
    }
}

impl Primitive {
    /// The integral of a kernel over the primitive. The compact one is known for points and segments.
    #[inline]
    pub(super) fn integral(&self, falloff: Falloff, order: Order, x: DVec3) -> Point {
        match (self, falloff) {
            (Primitive::Point(at), falloff) => {
                let (d, none) = (x - at, DVec3::ZERO);
                let q = d.length_squared();
                let (value, fq, fqq) = match falloff {
                    Falloff::Cauchy(s) => {
                        let k = 1.0 / (1.0 + s * s * q);
                        (k * k, -2.0 * s * s * k * k * k, 6.0 * (s * k) * (s * k) * (s * k) * (s * k))
                    }
                    Falloff::Compact(r) => {
                        let k = (1.0 - q / (r * r)).max(0.0);
                        let bend = if k > 0.0 { 2.0 / (r * r * r * r) } else { 0.0 };
                        (k * k, -2.0 / (r * r) * k, bend)
                    }
                };
                Along { value, first: [0.0, fq], second: [0.0, 0.0, fqq] }.point(none, d)
            }
            (Primitive::Segment([a, b]), falloff) => {
                let length = (b - a).length();
                let u = (b - a) / length;
                let along = u.dot(x - a);
                let w = x - a - along * u;
                match falloff {
                    Falloff::Cauchy(s) => segment_cauchy(s, along, length, w.length_squared()),
                    Falloff::Compact(r) => segment_compact(r, along, length, w.length_squared()),
                }
                .point(u, w)
            }
            (Primitive::Triangle(corners), Falloff::Cauchy(s)) => {
                by_order(order, x, |p| triangle_cauchy(corners, s, p), |p| triangle_cauchy(corners, s, p))
            }
            (Primitive::Arc(arc), Falloff::Cauchy(s)) => {
                by_order(order, x, |p| arc.cauchy(s, p), |p| arc.cauchy(s, p))
            }
            _ => Point::default(),
        }
    }
}

/// A form with or without its derivatives.
fn by_order(
    order: Order,
    x: DVec3,
    plain: impl Fn([f64; 3]) -> f64,
    taylor: impl Fn([Taylor; 3]) -> Taylor,
) -> Point {
    match order {
        Order::Value => plain(x.into()).point(),
        _ => taylor([0, 1, 2].map(|k| Taylor::coordinate(x[k], k))).point(),
    }
}
