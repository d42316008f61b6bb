//! Trilinear interpolation of what sits on the corners of a cell, in faded coordinates: the common
//! part of gradient noise, value noise and value-gradient noise.
//!
//! In the cell of `x`, let `p_c` be what the node at corner `c` makes of the offset `d_c = x - c`: its
//! value, or `g_c . d_c`, or both added. With the fade `s(t) = 6 t^5 - 15 t^4 + 10 t^3` of the
//! fractional coordinates,
//!
//! ```text
//! N(x) = P(s(t))        P = trilinear interpolation of the p_c
//! ```
//!
//! With `G` the trilinear interpolation of the `g_c`, and subscripts of `P` and `G` for partial
//! derivatives with respect to the faded coordinates (which are mere differences), the product
//! rule gives
//!
//! ```text
//! N_i  = G^i + s'_i P_i
//! N_ii = 2 s'_i G^i_i + s''_i P_i
//! N_ij = s'_i s'_j P_ij + s'_i G^j_i + s'_j G^i_j
//! ```
//!
//! `s'` and `s''` vanish at both ends, so neighbouring cells meet with equal value, gradient and
//! Hessian: the noise is C2.

use super::bulk::{GRADIENT, HESSIAN, Lanes};
use super::lattice::{Cells, Lattice, hash};
use super::node::{self, Corner, Node};
use crate::num::{Bounds, Point, ROUNDOFF};
use std::marker::PhantomData;

/// Absolute errors of value, gradient and Hessian from arithmetic alone, in terms of the bounds.
///
/// The fade is worst near 1: there `6 t - 15` is off by 21 roundoffs (of 1), its product with `t` by 30
/// and the sum with 10 by 31, to which the products with `t^3` add 3. So each faded coordinate is off by
/// 34 roundoffs at most. All three together move the value by that times the sum of `|P_i|`, which
/// near the corner at 1 are the differences to three neighbours: up to 2 for values, 3 for values with
/// one of twelve directions; away from that corner the fade is better and the differences are
/// averaged. That is 204 and 306 roundoffs, and 30 more for interpolation, against 256 times the bound
/// on the value. A gradient has two coordinates' worth of it, of differences twice as large, times 15/8;
/// a Hessian again twice the differences, times 225/64.
#[inline(always)]
pub(super) fn rounding(b: &Bounds) -> [f64; 3] {
    [256.0 * ROUNDOFF * b.range, 512.0 * ROUNDOFF * b.lipschitz, 2048.0 * ROUNDOFF * b.hessian]
}

/// The noise whose nodes are `N`.
#[derive(Clone, Copy)]
pub(super) struct Blended<const W: usize, N> {
    cells: Cells,
    node: PhantomData<N>,
}

impl<const W: usize, N: Node<W>> Blended<W, N> {
    #[inline(always)]
    pub(super) fn new(lattice: &Lattice) -> Self {
        Blended { cells: Cells::new(lattice), node: PhantomData }
    }
}

impl<const W: usize, N: Node<W>> Lanes for Blended<W, N> {
    const HALVES: bool = N::SLOPED;

    /// The loops that the compiler vectorises: cells, hashes and nodes (twice as many 32-bit lanes
    /// to a vector), jets.
    #[inline(always)]
    fn block<const ORDER: u8, const PARTS: usize, const B: usize>(
        &mut self,
        from: &[[f64; B]; 3],
        to: &mut [[f64; B]; PARTS],
    ) {
        let [x, y, z] = self.cells.rows(from);
        let mut hashes = [[0; B]; 8];
        for i in 0..B {
            let (x, y, z) = ([x.here[i], x.after[i]], [y.here[i], y.after[i]], [z.here[i], z.after[i]]);
            let h = each(|c| hash(x[c & 1] ^ y[c >> 1 & 1] ^ z[c >> 2], self.cells.key));
            for c in 0..8 {
                hashes[c][i] = h[c];
            }
        }
        let words = each(|c| node::words::<W, N, B>(&hashes[c]));
        for i in 0..B {
            let nodes = each(|c| {
                let mut node = [0; W];
                for (own, word) in node.iter_mut().zip(&words[c]) {
                    *own = word[i];
                }
                node
            });
            let p = jet::<ORDER, W, N>(nodes, [x.t[i], y.t[i], z.t[i]]);
            to[0][i] = p.value;
            if ORDER >= GRADIENT {
                for k in 0..3 {
                    to[1 + k][i] = p.grad[k];
                }
            }
            if ORDER >= HESSIAN {
                for k in 0..6 {
                    to[4 + k][i] = p.hess[k];
                }
            }
        }
    }
}

/// The jet from the nodes at the corners and the fractional coordinates.
#[inline(always)]
fn jet<const ORDER: u8, const W: usize, N: Node<W>>(nodes: [[u32; W]; 8], t: [f64; 3]) -> Point {
    let [x, y, z] = t.map(|t| [t, t - 1.0]);
    let corners: [Corner; 8] = each(|c| N::corner(nodes[c], [x[c & 1], y[c >> 1 & 1], z[c >> 2]]));
    let s = t.map(|t| t * t * t * (t * (6.0 * t - 15.0) + 10.0));
    let p = blend(each(|c| corners[c].p), s);
    let mut out = Point { value: p.v, ..Point::default() };
    if ORDER >= GRADIENT {
        let s1 = t.map(|t| 30.0 * (t * (t - 1.0)) * (t * (t - 1.0)));
        let s2 = t.map(|t| 60.0 * (t * (t - 1.0)) * (2.0 * t - 1.0));
        let [xy, xz, yz] = p.dd;
        if N::SLOPED {
            let g = [
                blend(each(|c| corners[c].g[0]), s),
                blend(each(|c| corners[c].g[1]), s),
                blend(each(|c| corners[c].g[2]), s),
            ];
            out.grad = [0, 1, 2].map(|i| g[i].v + s1[i] * p.d[i]);
            if ORDER >= HESSIAN {
                let same = |i: usize| 2.0 * (s1[i] * g[i].d[i]) + s2[i] * p.d[i];
                let cross = |i: usize, j: usize, pij: f64| {
                    s1[i] * s1[j] * pij + (s1[i] * g[j].d[i] + s1[j] * g[i].d[j])
                };
                out.hess = [same(0), same(1), same(2), cross(0, 1, xy), cross(0, 2, xz), cross(1, 2, yz)];
            }
        } else {
            out.grad = [0, 1, 2].map(|i| s1[i] * p.d[i]);
            if ORDER >= HESSIAN {
                let cross = |i: usize, j: usize, pij: f64| s1[i] * s1[j] * pij;
                let same = |i: usize| s2[i] * p.d[i];
                out.hess = [same(0), same(1), same(2), cross(0, 1, xy), cross(0, 2, xz), cross(1, 2, yz)];
            }
        }
    }
    out
}

/// An array over corners: bits 0, 1, 2 of the index step along x, y, z. Spelled out, because a loop
/// with a large body is not unrolled in time to be vectorised over lanes.
#[inline(always)]
fn each<T>(f: impl Fn(usize) -> T) -> [T; 8] {
    [f(0), f(1), f(2), f(3), f(4), f(5), f(6), f(7)]
}

/// Trilinear interpolation and its partial derivatives: x, y, z and xy, xz, yz.
struct Blend {
    v: f64,
    d: [f64; 3],
    dd: [f64; 3],
}

#[inline(always)]
fn blend(c: [f64; 8], s: [f64; 3]) -> Blend {
    let dx = [c[1] - c[0], c[3] - c[2], c[5] - c[4], c[7] - c[6]];
    let vx = [c[0] + s[0] * dx[0], c[2] + s[0] * dx[1], c[4] + s[0] * dx[2], c[6] + s[0] * dx[3]];
    let dy = [vx[1] - vx[0], vx[3] - vx[2]];
    let vy = [vx[0] + s[1] * dy[0], vx[2] + s[1] * dy[1]];
    let dxy = [dx[1] - dx[0], dx[3] - dx[2]];
    let dx = [dx[0] + s[1] * dxy[0], dx[2] + s[1] * dxy[1]];
    let (dz, dxz, dyz) = (vy[1] - vy[0], dx[1] - dx[0], dy[1] - dy[0]);
    let lerp = |a: f64, slope: f64| a + s[2] * slope;
    Blend {
        v: lerp(vy[0], dz),
        d: [lerp(dx[0], dxz), lerp(dy[0], dyz), dz],
        dd: [lerp(dxy[0], dxy[1] - dxy[0]), dxz, dyz],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::lattice::STEP;
    use crate::noise::node::{Level, LevelAnd, OnEdges, OnSphere};
    use crate::noise::tests::{Random, Two, compare};
    use crate::noise::{Directions, Gradient, Kind, Noise, Value, ValueGradient};

    /// The sum over corners of weight times what the corner carries, in twice the precision: another
    /// formula than the interpolation.
    fn reference<const W: usize, N: Node<W>>(seed: u64, at: [f64; 3]) -> [Two; 10] {
        let cells = Cells::new(&Lattice::new(seed));
        let floor = at.map(f64::floor);
        let c = |x: f64| Two(x, 0.0);
        let mut out = [c(0.0); 10];
        for corner in 0..8 {
            let bit = [corner & 1, corner >> 1 & 1, corner >> 2];
            let row = |a: usize| ((floor[a] as i64 + bit[a]) as u32).wrapping_mul(STEP[a]);
            let node = N::corner(N::words(hash(row(0) ^ row(1) ^ row(2), cells.key)), [0.0; 3]);
            let t = [0, 1, 2].map(|a| at[a] - floor[a]);
            // Weight and derivatives along each axis.
            let w = [0, 1, 2].map(|a| {
                let (t, t1) = (c(t[a]), Two::sum(t[a], -1.0));
                let s = t * t * t * (t * (c(6.0) * t + c(-15.0)) + c(10.0));
                let s1 = c(30.0) * t * t * t1 * t1;
                let s2 = c(60.0) * t * t1 * (t + t1);
                let minus = c(-1.0);
                if bit[a] == 1 { [s, s1, s2] } else { [c(1.0) + s * minus, s1 * minus, s2 * minus] }
            });
            let d = [0, 1, 2].map(|a| Two::sum(t[a], -(bit[a] as f64)));
            let g = node.g.map(c);
            let p = c(node.p) + g[0] * d[0] + g[1] * d[1] + g[2] * d[2];
            let weight = |order: [usize; 3]| w[0][order[0]] * w[1][order[1]] * w[2][order[2]];
            let one = |i: usize| weight([0, 1, 2].map(|a| usize::from(a == i)));
            out[0] = out[0] + p * weight([0; 3]);
            for i in 0..3 {
                out[1 + i] = out[1 + i] + weight([0; 3]) * g[i] + p * one(i);
            }
            for (k, [i, j]) in [[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]].into_iter().enumerate() {
                let two = weight([0, 1, 2].map(|a| usize::from(a == i) + usize::from(a == j)));
                out[4 + k] = out[4 + k] + p * two + g[i] * one(j) + g[j] * one(i);
            }
        }
        out
    }

    #[test]
    fn rounding_is_bounded() {
        let mut random = Random::new(1);
        for _ in 0..3000 {
            let p = random.point(20.0).map(|x| (x * 1e9).round() / 1_073_741_824.0);
            // Near the far ends of cells, where the fade is worst.
            let near = p.map(|x| x.floor() + 1.0 - (random.unit() * 1e7).round() / 1_073_741_824.0);
            for p in [p, near] {
                let check = |kind, exact| compare(&Noise::new(kind, 5), p, exact);
                check(Kind::Gradient(Gradient::EDGES), reference::<1, OnEdges>(5, p));
                check(Kind::Gradient(Gradient::SPHERE), reference::<3, OnSphere>(5, p));
                check(Kind::Value(Value), reference::<1, Level>(5, p));
                let both = |directions| Kind::ValueGradient(ValueGradient { directions });
                check(both(Directions::Edges), reference::<2, LevelAnd<OnEdges>>(5, p));
                check(both(Directions::Sphere), reference::<4, LevelAnd<OnSphere>>(5, p));
            }
        }
    }
}
