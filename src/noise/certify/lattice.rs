//! Noises on the integer lattice: weights are products of three fades, and the eight corners of a
//! cell reach its points.

use super::node::{Content, Shape, Term, at_vertices};
use crate::num::Real;

/// The corners of the unit cube.
#[derive(Clone, Copy)]
pub(super) struct Cube;

/// `w^(j + shift) u^j / j!` for `j <= K` at the two nodes of an axis, `t` being the fractional
/// coordinate: the Taylor coefficients of a weight, or of its derivative.
#[inline(always)]
fn axis<const K: usize, R: Real>(t: R, u: R, shift: usize) -> [[R; 6]; 2] {
    let c = R::of;
    let (q, one) = (t * (c(1.0) - t), c(1.0));
    // The fade and its derivatives; those of the other node's weight have the other sign.
    let s = [
        t.square() * t * (t * (c(6.0) * t - c(15.0)) + c(10.0)),
        c(30.0) * q.square(),
        c(60.0) * q * (one - c(2.0) * t),
        c(60.0) - c(360.0) * q,
        c(720.0) * t - c(360.0),
        c(720.0),
    ];
    let factorial = [1.0, 1.0, 2.0, 6.0, 24.0, 120.0];
    let mut far = [c(0.0); 6];
    let mut power = one;
    for j in 0..=K {
        far[j] = s[j + shift] * power * c(1.0 / factorial[j]);
        power = power * u;
    }
    let mut near = far.map(|x| -x);
    if shift == 0 {
        near[0] = one - s[0];
    }
    [near, far]
}

/// Coefficient `n` of the product of two polynomials.
#[inline(always)]
fn convolved<R: Real>(a: &[R; 6], b: &[R; 6], n: usize) -> R {
    (1..=n).fold(a[0] * b[n], |sum, i| sum + a[i] * b[n - i])
}

/// Coefficients `K` and `K - 1` of a product of three polynomials, times `K!`: the `K`-th derivative,
/// and `K` times the one below.
#[inline(always)]
fn derivatives<const K: usize, R: Real>(a: &[R; 6], b: &[R; 6], c: &[R; 6]) -> [R; 2] {
    let mut ab = [R::of(0.0); 6];
    for (n, ab) in ab.iter_mut().enumerate().take(K + 1) {
        *ab = convolved(a, b, n);
    }
    let factorial = R::of((1..=K).product::<usize>() as f64);
    let low = if K == 0 { R::of(0.0) } else { factorial * convolved(&ab, c, K - 1) };
    [factorial * convolved(&ab, c, K), low]
}

impl Shape for Cube {
    const SIDE: f64 = 1.0;
    const SMOOTH: bool = true;

    #[inline(always)]
    fn sum<const K: usize, R: Real>(&self, content: Content, x: [R; 3], u: [R; 3]) -> R {
        let [a, b, c] = [0, 1, 2].map(|i| axis::<K, R>(x[i], u[i], 0));
        let mut sum = R::of(0.0);
        for corner in 0..8 {
            let node = [corner & 1, corner >> 1 & 1, corner >> 2];
            let [high, low] = derivatives::<K, R>(&a[node[0]], &b[node[1]], &c[node[2]]);
            let v = [0, 1, 2].map(|n| high * (x[n] - R::of(node[n] as f64)) + low * u[n]);
            sum = sum + content.most(high, v);
        }
        sum
    }

    #[inline(always)]
    fn model<const K: usize>(&self, content: Content, x: [f64; 3], u: [f64; 3], half: [f64; 3]) -> f64 {
        let w = [0, 1, 2].map(|i| axis::<K, f64>(x[i], u[i], 0));
        let d = [0, 1, 2].map(|i| axis::<K, f64>(x[i], u[i], 1));
        let mut sums = [0.0; 8];
        for corner in 0..8 {
            let node = [corner & 1, corner >> 1 & 1, corner >> 2];
            let offset = [0, 1, 2].map(|n| x[n] - node[n] as f64);
            let [a, b, c] = [0, 1, 2].map(|n| &w[n][node[n]]);
            let [high, low] = derivatives::<K, f64>(a, b, c);
            let at = Term { w: high, v: [0, 1, 2].map(|n| high * offset[n] + low * u[n]) };
            let slopes = [0, 1, 2].map(|i| {
                let own = &d[i][node[i]];
                let [p, q, r] = [[own, b, c], [a, own, c], [a, b, own]][i];
                let [h, l] = derivatives::<K, f64>(p, q, r);
                let mut v = [0, 1, 2].map(|n| h * offset[n] + l * u[n]);
                v[i] += high;
                Term { w: h * half[i], v: v.map(|v| v * half[i]) }
            });
            at_vertices(content, at, slopes, &mut sums);
        }
        sums.into_iter().fold(0.0, f64::max)
    }
}
