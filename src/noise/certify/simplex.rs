//! Simplex noise: weights `C max(1/2 - |d|^2, 0)^4` on the corners and centres of cubes.
//!
//! Of the eight nodes whose balls reach into the cube `0 <= x, y, z <= 1/2`, four at most reach any
//! point. Along a line `d + tau u` the weight is the fourth power of
//!
//! ```text
//! q(tau) = q + b tau - tau^2       q = 1/2 - |d|^2,  b = -2 d.u
//! ```
//!
//! and so a polynomial as long as `q > 0`. At the rim of its ball the weight and three derivatives
//! vanish; the fourth jumps. So `F_3` is continuous with slopes up to `M_4`, but second-order bounds
//! of it hold only in boxes that no rim crosses, and `F_4` has to be bounded over whole boxes.

use super::node::{Content, Shape, Term, at_vertices};
use crate::num::Real;

/// Balls around the corners and centres of unit cubes.
#[derive(Clone, Copy)]
pub(super) struct Balls {
    /// The factor `C`.
    pub scale: f64,
}

/// The nodes that reach into the cube.
const NODES: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.5, 0.5, 0.5],
    [0.5, 0.5, -0.5],
    [0.5, -0.5, 0.5],
    [-0.5, 0.5, 0.5],
];

/// `1/2 - |d|^2`
#[inline(always)]
fn rest<R: Real>(d: [R; 3]) -> R {
    R::of(0.5) - (d[0].square() + d[1].square() + d[2].square())
}

#[inline(always)]
fn dot<R: Real>(a: [R; 3], b: [R; 3]) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Coefficients of `(q + b tau - tau^2)^4` up to the fifth. Those with a term free of `q` do not
/// vanish with `q`: over an interval that reaches below zero, they may or may not be there.
#[inline(always)]
fn fourth_power<R: Real>(q: R, b: R) -> [R; 6] {
    let (c, zero) = (R::of, R::of(0.0));
    let inside = q.max(zero);
    let (q2, b2) = (inside.square(), b.square());
    let there = |x: R| q.if_less(zero, zero, x);
    [
        q2.square(),
        c(4.0) * q2 * inside * b,
        q2 * (c(6.0) * b2 - c(4.0) * inside),
        inside * b * (c(4.0) * b2 - c(12.0) * inside),
        there(c(6.0) * q2 - c(12.0) * inside * b2 + b2.square()),
        there(b * (c(12.0) * inside - c(4.0) * b2)),
    ]
}

/// Coefficients of `(q + b tau - tau^2)^3` up to the third, for `q > 0`.
#[inline(always)]
fn cube(q: f64, b: f64) -> [f64; 4] {
    [q * q * q, 3.0 * q * q * b, 3.0 * q * (b * b - q), b * (b * b - 6.0 * q)]
}

impl Balls {
    /// `K!` times coefficients `K` and `K - 1`, scaled.
    #[inline(always)]
    fn derivatives<const K: usize, R: Real>(&self, at: impl Fn(usize) -> R) -> [R; 2] {
        let factor = R::of(self.scale * (1..=K).product::<usize>() as f64);
        [factor * at(K), if K == 0 { R::of(0.0) } else { factor * at(K - 1) }]
    }
}

impl Shape for Balls {
    const SIDE: f64 = 0.5;
    const SMOOTH: bool = false;

    #[inline(always)]
    fn sum<const K: usize, R: Real>(&self, content: Content, x: [R; 3], u: [R; 3]) -> R {
        let mut sum = R::of(0.0);
        for node in NODES {
            let d = [0, 1, 2].map(|i| x[i] - R::of(node[i]));
            let power = fourth_power(rest(d), R::of(-2.0) * dot(d, u));
            let [high, low] = self.derivatives::<K, R>(|n| power[n]);
            sum = sum + content.most(high, [0, 1, 2].map(|n| high * d[n] + low * u[n]));
        }
        sum
    }

    #[inline(always)]
    fn model<const K: usize>(&self, content: Content, x: [f64; 3], u: [f64; 3], half: [f64; 3]) -> f64 {
        let mut sums = [0.0; 8];
        for node in NODES {
            let d = [0, 1, 2].map(|i| x[i] - node[i]);
            let (q, b) = (rest(d), -2.0 * dot(d, u));
            if q <= 0.0 {
                continue;
            }
            let (power, cube) = (fourth_power(q, b), cube(q, b));
            let [high, low] = self.derivatives::<K, f64>(|n| power[n]);
            let at = Term { w: high, v: [0, 1, 2].map(|n| high * d[n] + low * u[n]) };
            let slopes = [0, 1, 2].map(|i| {
                // The slope of q(tau) is -2 (d_i + u_i tau), and that of its power 4 q(tau)^3 times it.
                let slope =
                    |n: usize| -8.0 * (d[i] * cube[n] + if n == 0 { 0.0 } else { u[i] * cube[n - 1] });
                let [h, l] = self.derivatives::<K, f64>(slope);
                let mut v = [0, 1, 2].map(|n| h * d[n] + l * u[n]);
                v[i] += high;
                Term { w: h * half[i], v: v.map(|v| v * half[i]) }
            });
            at_vertices(content, at, slopes, &mut sums);
        }
        sums.into_iter().fold(0.0, f64::max)
    }

    fn bends(&self, x: [f64; 3], rho: f64) -> bool {
        NODES.iter().all(|node| {
            let d = [0, 1, 2].map(|i| x[i] - node[i]);
            let reach = 2.0 * dot(d, d).sqrt() * rho + rho * rho;
            rest(d).abs() > reach * (1.0 + 1e-9)
        })
    }
}
