//! Gradient noise with twelve directions and the quintic fade (Perlin 2002; Gamito 2009, 4.2).
//!
//! Every node `c` of the integer lattice carries a direction `g_c`, one of the twelve
//! `(+-1, +-1, 0)`, `(+-1, 0, +-1)`, `(0, +-1, +-1)`, chosen by a hash of the node. In the cell of
//! `x`, with the offsets `d_c = x - c` to its eight corners, `p_c = g_c . d_c` and the fade
//! `s(t) = 6 t^5 - 15 t^4 + 10 t^3` of the fractional coordinates,
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
//! Hessian: the noise is C2. At a node it is zero and its gradient is `g_c`; over space and all
//! seeds it has mean 0 and variance 0.07292.
//!
//! **Speed.** The formulas are written once, for one lane, without branches, and a loop over
//! fixed-width blocks of lanes lets the compiler vectorise them for the widest instruction set of
//! the machine. Nothing is fused or reordered, so all instruction sets, and all groupings of points
//! into batches, give the same bits. The hash works on 32-bit lanes, twice as many to a vector.

use super::basis::Basis;
use super::lattice::{Lattice, STEP, hash, split};
use super::parameter::Settings;
use crate::num::{Bounds, Class, Jets, Level, Order, Point, at_level, simd_level, widest};

/// Gradient noise at unit frequency: one lattice cell is one unit long.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub struct Gradient;

impl Gradient {
    /// Proven by `examples/certify_noise.rs` (see [`certify`](super::certify)). The suprema
    /// themselves, as far as a search can tell, are 1.036354, 3.75, 14.465146 and 150.670246.
    pub const BOUNDS: Bounds = Bounds { range: 1.0364, lipschitz: 3.751, hessian: 14.53, third: 150.8 };
}

impl Gradient {
    /// [`Kernel::jets`] with a given instruction set, or the widest lower one that there is; for
    /// benchmarks and for the test that all give the same bits.
    pub fn jets_at(&self, lattice: &Lattice, level: Level, at: [&[f64]; 3], out: Jets<'_>) {
        let job = Job { key: lattice.key(), level, at };
        match out {
            Jets { value, grad: None, .. } => job.run::<VALUE, 1>([value]),
            Jets { value, grad: Some([x, y, z]), hess: None } => job.run::<GRADIENT, 4>([value, x, y, z]),
            Jets { value, grad: Some([x, y, z]), hess: Some([xx, yy, zz, xy, xz, yz]) } => {
                job.run::<HESSIAN, 10>([value, x, y, z, xx, yy, zz, xy, xz, yz]);
            }
        }
    }
}

/// Lanes a block: two vectors of the widest instruction set.
const BLOCK: usize = 16;

impl Basis for Gradient {
    fn new(_: &Settings) -> Self {
        Gradient
    }

    fn class(&self) -> Class {
        Class::C2
    }

    fn bounds(&self) -> Bounds {
        Gradient::BOUNDS
    }

    fn band(&self) -> f64 {
        1.25
    }

    fn jets(&self, lattice: &Lattice, at: [&[f64]; 3], out: Jets<'_>) {
        self.jets_at(lattice, simd_level(), at, out);
    }

    fn jet(&self, lattice: &Lattice, order: Order, at: [f64; 3]) -> Point {
        let key = lattice.key();
        widest(
            #[inline(always)]
            || match order {
                Order::Value => lane::<VALUE>(key, at),
                Order::Gradient => lane::<GRADIENT>(key, at),
                Order::Hessian => lane::<HESSIAN>(key, at),
            },
        )
    }
}

/// The orders as constant parameters.
const VALUE: u8 = 0;
const GRADIENT: u8 = 1;
const HESSIAN: u8 = 2;

/// A batch to evaluate.
struct Job<'a> {
    key: [u32; 2],
    level: Level,
    at: [&'a [f64]; 3],
}

impl Job<'_> {
    /// Fills the `PARTS` slices.
    #[inline(always)]
    fn run<const ORDER: u8, const PARTS: usize>(&self, mut out: [&mut [f64]; PARTS]) {
        at_level(
            self.level,
            #[inline(always)]
            || {
                let length = self.at[0].len();
                let whole = length - length % BLOCK;
                for start in (0..whole).step_by(BLOCK) {
                    self.part::<ORDER, PARTS>(start, BLOCK, &mut out);
                }
                if whole < length {
                    self.part::<ORDER, PARTS>(whole, length - whole, &mut out);
                }
            },
        );
    }

    /// One block, or the last few lanes of a batch, padded, which lanes cannot notice. Blocks pass
    /// through arrays of their own, so that the compiler knows that nothing overlaps.
    #[inline(always)]
    fn part<const ORDER: u8, const PARTS: usize>(
        &self,
        start: usize,
        count: usize,
        out: &mut [&mut [f64]; PARTS],
    ) {
        let mut from = [[0.0; BLOCK]; 3];
        for (own, at) in from.iter_mut().zip(self.at) {
            own[..count].copy_from_slice(&at[start..start + count]);
        }
        let mut to = [[0.0; BLOCK]; PARTS];
        block::<ORDER, PARTS>(self.key, &from, &mut to);
        for (slice, part) in out.iter_mut().zip(&to) {
            slice[start..start + count].copy_from_slice(&part[..count]);
        }
    }
}

/// The loops that the compiler vectorises: cells, hashes (twice as many 32-bit lanes to a vector),
/// jets.
#[inline(always)]
fn block<const ORDER: u8, const PARTS: usize>(
    key: [u32; 2],
    from: &[[f64; BLOCK]; 3],
    to: &mut [[f64; BLOCK]; PARTS],
) {
    let (mut cell, mut t) = ([[0; BLOCK]; 3], [[0.0; BLOCK]; 3]);
    for axis in 0..3 {
        for i in 0..BLOCK {
            (cell[axis][i], t[axis][i]) = split(from[axis][i]);
        }
    }
    let mut hashes = [[0; BLOCK]; 8];
    for i in 0..BLOCK {
        let h = corner_hashes(key, [cell[0][i], cell[1][i], cell[2][i]]);
        for c in 0..8 {
            hashes[c][i] = h[c];
        }
    }
    for i in 0..BLOCK {
        let h = each(|c| hashes[c][i]);
        let p = jet::<ORDER>(h, [t[0][i], t[1][i], t[2][i]]);
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

/// The jet at one point.
#[inline(always)]
fn lane<const ORDER: u8>(key: [u32; 2], at: [f64; 3]) -> Point {
    let [(ix, tx), (iy, ty), (iz, tz)] = at.map(split);
    jet::<ORDER>(corner_hashes(key, [ix, iy, iz]), [tx, ty, tz])
}

/// The jet from the hashes of the corners and the fractional coordinates.
#[inline(always)]
fn jet<const ORDER: u8>(hashes: [u32; 8], t: [f64; 3]) -> Point {
    let [x, y, z] = t.map(|t| [t, t - 1.0]);
    let corners = each(|c| corner(hashes[c], [x[c & 1], y[c >> 1 & 1], z[c >> 2]]));
    let s = t.map(|t| t * t * t * (t * (6.0 * t - 15.0) + 10.0));
    let p = blend(each(|c| corners[c].p), s);
    let mut out = Point { value: p.v, ..Point::default() };
    if ORDER >= GRADIENT {
        let g = [
            blend(each(|c| corners[c].g[0]), s),
            blend(each(|c| corners[c].g[1]), s),
            blend(each(|c| corners[c].g[2]), s),
        ];
        let s1 = t.map(|t| 30.0 * (t * (t - 1.0)) * (t * (t - 1.0)));
        out.grad = [0, 1, 2].map(|i| g[i].v + s1[i] * p.d[i]);
        if ORDER >= HESSIAN {
            let s2 = t.map(|t| 60.0 * (t * (t - 1.0)) * (2.0 * t - 1.0));
            let same = |i: usize| 2.0 * (s1[i] * g[i].d[i]) + s2[i] * p.d[i];
            let cross =
                |i: usize, j: usize, pij: f64| s1[i] * s1[j] * pij + (s1[i] * g[j].d[i] + s1[j] * g[i].d[j]);
            let [xy, xz, yz] = p.dd;
            out.hess = [same(0), same(1), same(2), cross(0, 1, xy), cross(0, 2, xz), cross(1, 2, yz)];
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

/// A corner's direction and its product with the offset.
#[derive(Clone, Copy)]
struct Corner {
    p: f64,
    g: [f64; 3],
}

/// The hashes of the eight corners of a cell.
#[inline(always)]
fn corner_hashes(key: [u32; 2], cell: [u32; 3]) -> [u32; 8] {
    let steps = |axis: usize| {
        let word = cell[axis].wrapping_mul(STEP[axis]);
        [word, word.wrapping_add(STEP[axis])]
    };
    let (x, y, z) = (steps(0), steps(1), steps(2));
    each(|c| hash(x[c & 1] ^ y[c >> 1 & 1] ^ z[c >> 2], key))
}

/// Two sign bits, and the axis without a component from the thirds of the range of the others.
#[inline(always)]
fn corner(h: u32, d: [f64; 3]) -> Corner {
    const THIRD: u32 = u32::MAX / 3;
    let (first, last) = (h << 2 <= THIRD, h << 2 > 2 * THIRD);
    let sign = |x: f64, bit: u32| f64::from_bits(x.to_bits() ^ (u64::from(h << bit & 1 << 31) << 32));
    let u = sign(if first { d[1] } else { d[0] }, 0);
    let v = sign(if last { d[1] } else { d[2] }, 1);
    let (one_u, one_v) = (sign(1.0, 0), sign(1.0, 1));
    let y = if first { one_u } else { 0.0 };
    Corner {
        p: u + v,
        g: [if first { 0.0 } else { one_u }, if last { one_v } else { y }, if last { 0.0 } else { one_v }],
    }
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
    use crate::noise::tests::Random;
    use crate::noise::{Kind, Noise};
    use crate::num::Kernel;

    const NOISE: Noise = Noise::new(Kind::Gradient(Gradient), 20);

    fn close(a: f64, b: f64, within: f64) -> bool {
        (a - b).abs() <= within
    }

    #[test]
    fn derivatives_match_differences() {
        let mut random = Random::new(1);
        for _ in 0..2000 {
            let p = random.point(50.0);
            let jet = NOISE.jet(Order::Hessian, p);
            let step = 1e-5;
            for axis in 0..3 {
                let side = |h: f64| {
                    let mut q = p;
                    q[axis] += h;
                    NOISE.jet(Order::Gradient, q)
                };
                let (low, high) = (side(-step), side(step));
                assert!(close((high.value - low.value) / (2.0 * step), jet.grad[axis], 1e-6), "{p:?}");
                for other in 0..3 {
                    let pair = [[0, 3, 4], [3, 1, 5], [4, 5, 2]][axis][other];
                    let difference = (high.grad[other] - low.grad[other]) / (2.0 * step);
                    assert!(close(difference, jet.hess[pair], 1e-4), "{p:?} {axis} {other}");
                }
            }
        }
    }

    #[test]
    fn cells_meet_with_equal_jets() {
        let mut random = Random::new(2);
        for i in 0..3000 {
            let mut p = random.point(30.0);
            p[i % 3] = p[i % 3].floor();
            let mut q = p;
            q[i % 3] -= 1e-13;
            let (a, b) = (NOISE.jet(Order::Hessian, p), NOISE.jet(Order::Hessian, q));
            assert!(close(a.value, b.value, 1e-12));
            assert!((0..3).all(|k| close(a.grad[k], b.grad[k], 1e-11)));
            assert!((0..6).all(|k| close(a.hess[k], b.hess[k], 1e-10)), "{p:?} {a:?} {b:?}");
        }
    }

    #[test]
    fn nodes_have_value_zero_and_a_direction_for_gradient() {
        let mut random = Random::new(3);
        let mut seen = std::collections::BTreeMap::new();
        for _ in 0..12_000 {
            let node = random.point(1e4).map(f64::round);
            let jet = NOISE.jet(Order::Gradient, node);
            assert_eq!(jet.value, 0.0);
            assert_eq!(jet.grad.iter().filter(|g| **g == 0.0).count(), 1);
            assert!(jet.grad.iter().all(|g| *g == 0.0 || g.abs() == 1.0));
            *seen.entry(jet.grad.map(|g| g as i32)).or_insert(0) += 1;
        }
        assert_eq!(seen.len(), 12);
        // Binomial with mean 1000 and deviation 30.
        assert!(seen.values().all(|&n| (850..1150).contains(&n)), "{seen:?}");
    }

    #[test]
    fn every_level_and_grouping_gives_the_same_bits() {
        let mut random = Random::new(4);
        let points: Vec<[f64; 3]> = (0..203)
            .map(|i| random.point([1.0, 1e3, 1e9, 1e17, 1e-9][i % 5]))
            .chain([[0.0, -0.0, -1e-300], [f64::NAN, 1.0, 2.0], [f64::INFINITY, 0.5, 0.5]])
            .collect();
        let bits = |p: &Point| {
            let mut all = vec![p.value];
            all.extend(p.grad.iter().chain(&p.hess));
            // NaNs carry no promise about their payload.
            all.into_iter().map(|x| if x.is_nan() { u64::MAX } else { x.to_bits() }).collect::<Vec<_>>()
        };
        for order in [Order::Value, Order::Gradient, Order::Hessian] {
            for level in [Level::Baseline, Level::Avx2, Level::Avx512] {
                for group in [1, 3, 16, 37, points.len()] {
                    for part in points.chunks(group) {
                        for (p, jet) in part.iter().zip(&jets_of(20, level, order, part)) {
                            assert_eq!(bits(jet), bits(&NOISE.jet(order, *p)), "{level:?} {group} {p:?}");
                        }
                    }
                }
            }
        }
    }

    fn jets_of(seed: u64, level: Level, order: Order, points: &[[f64; 3]]) -> Vec<Point> {
        let at = [0, 1, 2].map(|axis| points.iter().map(|p| p[axis]).collect::<Vec<_>>());
        let mut to: [Vec<f64>; 10] = std::array::from_fn(|_| vec![0.0; points.len()]);
        let [v, x, y, z, xx, yy, zz, xy, xz, yz] = &mut to;
        let out = Jets {
            value: v,
            grad: (order >= Order::Gradient).then_some([&mut x[..], y, z]),
            hess: (order >= Order::Hessian).then_some([&mut xx[..], yy, zz, xy, xz, yz]),
        };
        Gradient.jets_at(&Lattice::new(seed), level, [&at[0], &at[1], &at[2]], out);
        (0..points.len())
            .map(|i| Point {
                value: to[0][i],
                grad: std::array::from_fn(|k| to[1 + k][i]),
                hess: std::array::from_fn(|k| to[4 + k][i]),
            })
            .collect()
    }

    #[test]
    fn statistics_and_bounds_hold_over_a_million_samples() {
        let mut random = Random::new(5);
        let (mut sum, mut squares) = (0.0, 0.0);
        let count = 1_000_000;
        let b = Gradient::BOUNDS;
        for i in 0..count / 1000 {
            let size = [10.0, 1e4, 1e7][i % 3];
            let points: Vec<_> = (0..1000).map(|_| random.point(size)).collect();
            for jet in jets_of(i as u64, simd_level(), Order::Hessian, &points) {
                sum += jet.value;
                squares += jet.value * jet.value;
                assert!(jet.value.abs() <= b.range);
                assert!(jet.grad.iter().map(|g| g * g).sum::<f64>() <= b.lipschitz * b.lipschitz);
                // Diagonal entries are u^T H u on an axis; off-diagonal ones follow from polarisation.
                assert!(jet.hess.iter().all(|h| h.abs() <= b.hessian));
            }
        }
        let n = count as f64;
        assert!((sum / n).abs() < 1.5e-3, "mean {}", sum / n);
        assert!((squares / n - 0.07292).abs() < 4e-4, "variance {}", squares / n);
    }

    #[test]
    fn neighbouring_nodes_are_uncorrelated() {
        // Products of a component at nodes a small step apart: mean 0, deviation (2/3) / sqrt(n).
        for step in [
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [1.0, 1.0, 0.0],
            [2.0, -1.0, 1.0],
            [256.0, 0.0, 0.0],
        ] {
            let mut sum = [0.0; 9];
            for i in 0..40_i32.pow(3) {
                let p = [i % 40 - 20, i / 40 % 40 - 20, i / 1600 - 20].map(f64::from);
                let q = [0, 1, 2].map(|axis| p[axis] + step[axis]);
                let (g, h) = (NOISE.jet(Order::Gradient, p).grad, NOISE.jet(Order::Gradient, q).grad);
                (0..9).for_each(|k| sum[k] += g[k / 3] * h[k % 3]);
            }
            assert!(sum.iter().all(|s| (s / 64_000.0).abs() < 0.0135), "{step:?} {sum:?}");
        }
    }

    #[test]
    fn total_for_any_coordinate() {
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(NOISE.jet(Order::Value, [0.3, x, 0.4]).value.is_nan());
        }
        let mut random = Random::new(6);
        for _ in 0..10_000 {
            let p = random.point(1.0).map(|x| x * 10_f64.powi((random.unit() * 300.0) as i32));
            assert!(NOISE.jet(Order::Value, p).value.abs() <= Gradient::BOUNDS.range, "{p:?}");
        }
        let far = [2e9 + 0.25, -2e9 + 0.5, 1e7 + 0.75];
        let jet = NOISE.jet(Order::Gradient, far);
        let next = NOISE.jet(Order::Value, [far[0] + 1e-3, far[1], far[2]]);
        assert!(close((next.value - jet.value) / 1e-3, jet.grad[0], 0.02));
    }
}
