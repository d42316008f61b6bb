//! The constants of noises made of scattered spots: a search from below, a proof from above.
//!
//! **What is maximised.** With one node of unit weight and free sign in each of the 27 cells around a
//! point `x`, the largest `k`-th derivative along a unit vector `v` is
//!
//! ```text
//! F_k(x, v) = sum over cells of max over n in the cell of g_k(x - n, v)
//! ```
//!
//! where `g_k` is the size of the derivative of one spot. A round spot's derivatives depend on the
//! distance `r` and on the cosine `c` of the angle between `d` and `v`:
//!
//! ```text
//! h_0 = h      h_1 = h' c      h_2 = b + (h'' - b) c^2      h_3 = h''' c^3 + 3 g (c - c^3)
//! b = h'/r                                                  g = (h''/r - h'/r^2)
//! ```
//!
//! and for waves under the spot, of free direction and phase, `g_k` is the largest modulus of
//! `sum_j binom(k, j) (i s)^(k-j) h_j` for `|s| <= 2 pi F`. For `k` up to 2 its square is a convex
//! function of `s^2`, and largest at an end; for 3 it is a cubic, whose peak inside is looked at too.
//!
//! **Directions.** Let `M_k` be the supremum, taken at `x` and `v`. On the great circle through `v`
//! the `k`-th derivative of that very noise is a trigonometric polynomial of degree `k`, bounded by
//! `M_k` everywhere and equal to it at `v`; at an angle `t <= pi / k` from there it is at least
//! `M_k cos(k t)` (M. Riesz 1914). So it is enough that `F_k(x, v) <= T cos(k delta)` for a net of
//! directions with mesh `delta` and all `x`. The symmetries of the cube leave directions with falling
//! non-negative components.
//!
//! **Places.** For each direction of the net the ball of offsets is cut into voxels, and `g_k` bounded
//! on each: its value at the voxel's middle distance and cosine, and bounds on its slopes
//! ([`Spots::slopes`]). For `x` in a voxel of the cell and a cell of nodes, the offsets fill a box of
//! voxels; its maximum comes from sliding maxima along the three axes (van Herk 1992; Gil and Werman
//! 1993), and the sums over 27 cells bound `F_k` for all `x` at once. Finer voxels are used where
//! coarse ones do not suffice.
//!
//! Sums of few terms are off by less than a part in 1e9, and tables are rounded up to `f32` with a
//! millionth to spare.

use super::{Claim, Subject};
use crate::noise::{gabor, scatter, sparse};
use crate::num::{Bounds, mix};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// One node of unit weight in every cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spots {
    /// Name in tables.
    name: &'static str,
    /// Whether the kernel is Lewis' rather than the quintic.
    lewis: bool,
    /// Whether nodes keep a margin of their cells.
    margin: bool,
    /// Waves to a cell under the spots; 0 for none.
    frequency: f64,
}

const PLAIN: Spots = Spots { name: "sparse", lewis: false, margin: false, frequency: 0.0 };

/// All kernels and placements, and Gabor noise at the frequencies of its net.
pub(super) const ALL: &[&dyn Subject] = &[
    &PLAIN,
    &Spots { name: "sparse, disc", margin: true, ..PLAIN },
    &Spots { name: "sparse, lewis", lewis: true, ..PLAIN },
    &Spots { name: "sparse, lewis, disc", lewis: true, margin: true, ..PLAIN },
    &Spots { name: "gabor", frequency: 2.0, ..PLAIN },
    &Spots { name: "gabor, frequency 0.5", frequency: 0.5, ..PLAIN },
    &Spots { name: "gabor, frequency 1", frequency: 1.0, ..PLAIN },
    &Spots { name: "gabor, frequency 4", frequency: 4.0, ..PLAIN },
    &Spots { name: "gabor, frequency 8", frequency: 8.0, ..PLAIN },
    &Spots { name: "gabor, disc", margin: true, frequency: 2.0, ..PLAIN },
    &Spots { name: "gabor, disc, frequency 0.5", margin: true, frequency: 0.5, ..PLAIN },
    &Spots { name: "gabor, disc, frequency 1", margin: true, frequency: 1.0, ..PLAIN },
    &Spots { name: "gabor, disc, frequency 4", margin: true, frequency: 4.0, ..PLAIN },
    &Spots { name: "gabor, disc, frequency 8", margin: true, frequency: 8.0, ..PLAIN },
];

/// A radial function with what derivatives along a vector are made of: `h`, `h'`, `h''`, `h'/r`,
/// `h'''`, `h''/r - h'/r^2`, and the slopes of the last two.
struct Radial {
    h: [f64; 4],
    over: f64,
    across: f64,
    fourth: f64,
    across_slope: f64,
}

const BINOMIAL: [[f64; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0], [1.0, 2.0, 1.0, 0.0], [1.0, 3.0, 3.0, 1.0]];

impl Spots {
    fn radial(&self, r: f64) -> Radial {
        let q = 1.0 - r;
        if self.lewis {
            let (sin, cos) = (libm::sin(PI * r), libm::cos(PI * r));
            let over = if r < 1e-9 { -0.5 * PI * PI } else { -0.5 * PI * sin / r };
            let h = [0.5 + 0.5 * cos, -0.5 * PI * sin, -0.5 * PI * PI * cos, 0.5 * PI * PI * PI * sin];
            // Third derivatives are not asked for; |(h'/r)'| <= 6.8.
            Radial { h, over, across: 6.8, fourth: 0.0, across_slope: 0.0 }
        } else {
            Radial {
                h: [
                    q * q * q * (1.0 + r * (3.0 + 6.0 * r)),
                    -30.0 * r * r * q * q,
                    -60.0 * r * q * (1.0 - 2.0 * r),
                    -60.0 + 360.0 * r * q,
                ],
                over: -30.0 * r * q * q,
                across: 30.0 * q * (3.0 * r - 1.0),
                fourth: 360.0 * (1.0 - 2.0 * r),
                across_slope: 30.0 * (4.0 - 6.0 * r),
            }
        }
    }

    /// `g_k` at distance `r` and cosine `c`.
    fn size(&self, k: usize, r: f64, c: f64) -> f64 {
        let f = self.radial(r);
        let h = [
            f.h[0],
            f.h[1] * c,
            f.over + (f.h[2] - f.over) * (c * c),
            c * (f.h[3] * (c * c) + 3.0 * f.across * (1.0 - c * c)),
        ];
        let most = TAU * self.frequency;
        let square = |s: f64| {
            let [re, im] = match k {
                0 => [h[0], 0.0],
                1 => [h[1], s * h[0]],
                2 => [h[2] - s * s * h[0], 2.0 * s * h[1]],
                _ => [h[3] - 3.0 * s * s * h[1], 3.0 * s * h[2] - s * s * s * h[0]],
            };
            re * re + im * im
        };
        let mut best = square(0.0).max(square(most));
        if k == 3 && self.frequency > 0.0 {
            let (a, b) = (3.0 * h[1] * h[1] - 2.0 * h[2] * h[0], 3.0 * h[2] * h[2] - 2.0 * h[3] * h[1]);
            // The square is h_3^2 + 3 b t + 3 a t^2 + h_0^2 t^3 for t = s^2.
            let inside = a * a - h[0] * h[0] * b;
            if inside > 0.0 && h[0] > 0.0 {
                let t = (-a - inside.sqrt()) / (h[0] * h[0]);
                best = best.max(square(t.clamp(0.0, most * most).sqrt()));
            }
        }
        best.sqrt()
    }

    /// Bounds on the slopes of `h_j` by distance, within `reach` of `r`, and by cosine there, for
    /// cosines up to `c` in size: values at `r` plus bounds on the next derivative.
    fn slopes(&self, r: f64, c: f64, reach: f64) -> [[f64; 2]; 4] {
        let f = self.radial(r);
        // Largest second, third and fourth derivatives; slopes of h'' - h'/r.
        let [second, third, fourth, mixed] =
            if self.lewis { [4.935, 15.504, 48.71, 23.0] } else { [5.7736, 60.0, 360.0, 60.0] };
        // c - c^3 is at most 0.385.
        let along = (f.fourth.abs() * c * c * c + 1.155 * f.across_slope.abs()).min(360.0);
        let (p, m) = (3.0 * f.across, 3.0 * (f.h[3] - 3.0 * f.across));
        [
            [f.h[1].abs() + 0.5 * second * reach, 0.0],
            [f.h[2].abs() * c + 0.5 * third * reach, f.h[1].abs() + second * reach],
            [
                f.h[3].abs().max(f.across.abs()) + 0.5 * fourth * reach,
                2.0 * c * ((f.h[2] - f.over).abs() + mixed * reach),
            ],
            [along + 0.5 * 720.0 * reach, p.abs().max((p + m * c * c).abs()) + 720.0 * reach],
        ]
    }

    /// Suprema of `|h_j|`.
    fn peaks(&self) -> [f64; 4] {
        if self.lewis { [1.0, 0.5 * PI, 0.5 * PI * PI, f64::INFINITY] } else { [1.0, 1.875, 5.773_51, 60.0] }
    }

    /// Upper bound of `g_k` in the voxel of side `e` at `low`.
    fn bound(&self, k: usize, v: [f64; 3], low: [f64; 3], e: f64) -> f64 {
        let (mut near, mut far) = (0.0, 0.0);
        for a in low {
            let (least, most) = (f64::max(a, -(a + e)).max(0.0), f64::max(-a, a + e));
            near += least * least;
            far += most * most;
        }
        if near >= 1.0 + 1e-12 {
            return 0.0;
        }
        let (near, far) = (near.sqrt().min(1.0), far.sqrt().min(1.0));
        let middle = low.map(|a| a + 0.5 * e);
        let (r, rho) = (dot(middle, middle).sqrt(), 0.5 * e * 3.0_f64.sqrt());
        // The angle to the middle of the voxel is at most asin(rho / r).
        let (least, most) = if k == 0 {
            (0.0, 0.0)
        } else if r <= rho {
            (-1.0, 1.0)
        } else {
            let c = (dot(middle, v) / r).clamp(-1.0, 1.0);
            let (s, sin) = ((1.0 - c * c).sqrt(), rho / r);
            let cos = (1.0 - sin * sin).sqrt();
            (if c <= -cos { -1.0 } else { c * cos - s * sin }, if c >= cos { 1.0 } else { c * cos + s * sin })
        };
        let (reach, turn) = (0.5 * (far - near), 0.5 * (most - least));
        let slopes = self.slopes(0.5 * (near + far), f64::max(-least, most), reach);
        let (mut moved, mut top) = (0.0, 0.0);
        for j in 0..=k {
            let weight = BINOMIAL[k][j] * (0..k - j).fold(1.0, |p, _| p * TAU * self.frequency);
            moved += weight * (slopes[j][0] * reach + slopes[j][1] * turn);
            top += weight * self.peaks()[j];
        }
        (self.size(k, 0.5 * (near + far), 0.5 * (least + most)) + moved).min(top)
    }

    /// Upper bound of `F_k(x, v)` over all `x`, with `n` voxels to a cell along each axis.
    fn upper(&self, k: usize, v: [f64; 3], n: usize) -> f64 {
        let e = 1.0 / n as f64;
        let side = 2 * n;
        let mut table = vec![0.0_f32; side * side * side];
        for (i, entry) in table.iter_mut().enumerate() {
            let at = [i / side / side, i / side % side, i % side];
            let bound = self.bound(k, v, at.map(|a| (a as f64 - n as f64) * e), e);
            *entry = (bound * (1.0 + 1e-6) + 1e-30) as f32;
        }
        let margin = if self.margin { (scatter::MARGIN * n as f64).round() as usize } else { 0 };
        let mut shape = [side; 3];
        for _ in 0..3 {
            table = slide(&table, shape, n, margin);
            shape = [3 * n, shape[0], shape[1]];
        }
        let window = |a: usize, b: usize, c: usize| f64::from(table[(a * 3 * n + b) * 3 * n + c]);
        let mut best = 0.0;
        for i in 0..n * n * n {
            let [a, b, c] = [i / n / n, i / n % n, i % n];
            let sum: f64 = (0..27).map(|o| window(a + o / 9 * n, b + o / 3 % 3 * n, c + o % 3 * n)).sum();
            best = f64::max(best, sum);
        }
        best
    }

    /// `g_k` of an offset.
    fn at(&self, k: usize, d: [f64; 3], v: [f64; 3]) -> f64 {
        let r = dot(d, d).sqrt();
        match r {
            _ if r > 1.0 => 0.0,
            _ if r > 0.0 => self.size(k, r, (dot(d, v) / r).clamp(-1.0, 1.0)),
            _ => self.size(k, 0.0, 1.0),
        }
    }

    /// Random search with shrinking steps for place, direction and nodes: first one look at each of
    /// `starts` places, then a climb from the best few.
    fn climb(&self, k: usize, start: u64, steps: usize) -> f64 {
        let mut state = 0;
        let mut random = || {
            state += 1;
            (mix(mix(start) ^ state) >> 11) as f64 / (1_u64 << 53) as f64
        };
        let margin = if self.margin { scatter::MARGIN } else { 0.0 };
        let mut best = (0.0, [0; 3].map(|_| random()), unit([0; 3].map(|_| random() - 0.5)), [[0.5; 3]; 27]);
        let mut step = 0.5;
        for n in 0..steps {
            let (mut x, mut v, mut nodes) = (best.1, best.2, best.3);
            if n > 0 {
                x = x.map(|x| (x + step * (random() - 0.5)).clamp(0.0, 1.0));
                v = unit(v.map(|v| v + 2.0 * step * (random() - 0.5)));
            }
            let mut sum = 0.0;
            for (c, node) in nodes.iter_mut().enumerate() {
                let corner = [c % 3, c / 3 % 3, c / 9].map(|o| o as f64 - 1.0);
                let from = [0, 1, 2].map(|i| x[i] - corner[i]);
                let value = |p: [f64; 3]| self.at(k, [0, 1, 2].map(|i| from[i] - p[i]), v);
                let mut most = value(*node);
                let mut look = |p: [f64; 3]| {
                    let p = p.map(|p| p.clamp(margin, 1.0 - margin));
                    let found = value(p);
                    if found > most {
                        (most, *node) = (found, p);
                    }
                };
                // Peaks of a spot lie ahead and behind, at the centre, at the rim and between.
                for r in [0.0, 0.211, 0.33, 0.5, 0.789, 1.0 - 1e-12] {
                    look([0, 1, 2].map(|i| from[i] + r * v[i]));
                    look([0, 1, 2].map(|i| from[i] - r * v[i]));
                }
                for _ in 0..8 {
                    look([0; 3].map(|_| random()));
                }
                let near = *node;
                let mut look = |p: [f64; 3]| {
                    let p = p.map(|p| p.clamp(margin, 1.0 - margin));
                    let found = value(p);
                    if found > most {
                        (most, *node) = (found, p);
                    }
                };
                for i in 0..8 {
                    let size = if i % 2 == 0 { step } else { 0.1 * step };
                    look(near.map(|p| p + size * (random() - 0.5)));
                }
                sum += most;
            }
            if sum > best.0 {
                best = (sum, x, v, nodes);
                step = f64::min(1.3 * step, 0.5);
            } else {
                step = f64::max(0.98 * step, 1e-7);
            }
        }
        best.0
    }

    /// The best that `climbs` of so many steps find from the best of `starts` places.
    fn hunt(&self, order: usize, starts: u64, climbs: usize, steps: usize) -> f64 {
        let look = |start: u64| (self.climb(order, start, 1), start);
        let mut first: Vec<(f64, u64)> = (0..starts).into_par_iter().map(look).collect();
        first.sort_by(|a, b| b.0.total_cmp(&a.0));
        first.truncate(climbs);
        first.into_par_iter().map(|(_, start)| self.climb(order, start, steps)).reduce(|| 0.0, f64::max)
    }

    fn bounds(&self) -> Bounds {
        if self.frequency > 0.0 {
            gabor::unit(self.margin, self.frequency)
        } else {
            sparse::UNIT[usize::from(self.lewis)][usize::from(self.margin)]
        }
    }
}

/// Sliding maxima along the last axis over the boxes of offsets between a voxel and a cell; the axes
/// move on by one, so that three calls do all.
///
/// A voxel `i` of `n` and the cell at `o` are apart by `i - n o - n + margin` to `i - n o - margin`
/// voxels; the result has an entry for each `i - n o`, from `-n` on. Maxima of windows are those of
/// the end of one block and the start of the next, blocks being as long as windows.
fn slide(table: &[f32], shape: [usize; 3], n: usize, margin: usize) -> Vec<f32> {
    let [outer, middle, inner] = shape;
    let length = n + 1 - 2 * margin;
    let padded = 3 * n + length - 1;
    let mut out = vec![0.0; outer * middle * 3 * n];
    let (mut line, mut heads, mut tails) = (vec![0.0; padded], vec![0.0; padded], vec![0.0; padded]);
    for a in 0..outer {
        for b in 0..middle {
            let from = &table[(a * middle + b) * inner..][..inner];
            line.fill(0.0);
            for (i, value) in from.iter().enumerate() {
                // The first window starts at voxel -2 n + margin, and the line at -n.
                if let Some(slot) = (i + n).checked_sub(margin).and_then(|at| line.get_mut(at)) {
                    *slot = *value;
                }
            }
            for i in 0..padded {
                let fresh = i % length == 0;
                heads[i] = if fresh { line[i] } else { f32::max(heads[i - 1], line[i]) };
            }
            for i in (0..padded).rev() {
                let fresh = i + 1 == padded || (i + 1) % length == 0;
                tails[i] = if fresh { line[i] } else { f32::max(tails[i + 1], line[i]) };
            }
            for i in 0..3 * n {
                out[(i * outer + a) * middle + b] = f32::max(tails[i], heads[i + length - 1]);
            }
        }
    }
    out
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let n = dot(v, v).sqrt();
    v.map(|v| v / n)
}

/// Tiles along an edge of a face of the cube of directions, by order: `k` times the mesh is about
/// 0.16, whose cosine costs little more than a hundredth.
const TILES: [usize; 4] = [1, 5, 9, 13];

/// Voxels to a cell, from coarse to fine; multiples of 10, so that margins are whole.
const FINENESS: [usize; 5] = [20, 40, 60, 80, 100];

impl Subject for Spots {
    fn name(&self) -> &'static str {
        self.name
    }

    fn claims(&self) -> Vec<Claim> {
        let b = self.bounds();
        let all = [("A", b.range), ("L", b.lipschitz), ("M2", b.hessian), ("M3", b.third)];
        let claims = all.into_iter().enumerate().map(|(order, (name, bound))| Claim { order, name, bound });
        claims.filter(|c| c.bound.is_finite()).collect()
    }

    fn search(&self, order: usize, starts: u64) -> f64 {
        self.hunt(order, starts, (starts / 100).clamp(4, 48) as usize, 3000)
    }

    fn prove(&self, claim: &Claim, budget: u64) -> Option<u64> {
        let k = claim.order;
        let tiles = TILES[k];
        let mesh = k as f64 * 0.5 * 2.0_f64.sqrt() / tiles as f64;
        let room = claim.bound * libm::cos(mesh) * (1.0 - 1e-9);
        let middle = |i: usize| (i as f64 + 0.5) / tiles as f64;
        let net: Vec<[f64; 3]> = (0..tiles * tiles)
            .filter(|i| i / tiles >= i % tiles)
            .map(|i| unit([1.0, middle(i / tiles), middle(i % tiles)]))
            .collect();
        let settle = |v: &[f64; 3]| {
            let mut voxels = 0;
            for n in FINENESS {
                voxels += (n * n * n) as u64;
                if voxels > budget {
                    return None;
                }
                if self.upper(k, *v, n) <= room {
                    return Some(voxels);
                }
            }
            None
        };
        net.par_iter().map(settle).try_reduce(|| 0, |a, b| Some(a + b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::tests::Random;

    fn all() -> [Spots; 5] {
        [
            PLAIN,
            Spots { margin: true, ..PLAIN },
            Spots { lewis: true, ..PLAIN },
            Spots { frequency: 2.0, ..PLAIN },
            Spots { frequency: 0.5, margin: true, ..PLAIN },
        ]
    }

    #[test]
    fn no_search_exceeds_the_constants() {
        for spots in all() {
            for claim in spots.claims() {
                let found = spots.hunt(claim.order, 200, 4, 600);
                assert!(found <= claim.bound, "{spots:?} {claim:?} {found}");
                assert!(found >= 0.8 * claim.bound, "{spots:?} {claim:?} {found}: the search lost its way");
            }
        }
    }

    #[test]
    fn known_extremes_are_reached() {
        for (k, value) in [(0, 8.0), (1, 23.65624), (2, 97.4386)] {
            let found = PLAIN.hunt(k, 1000, 8, 1500);
            assert!((found - value).abs() < 2e-3 * value, "{k} {found}");
        }
    }

    #[test]
    fn coarse_proofs_succeed_and_false_claims_fail() {
        let prove = |order, bound, budget| PLAIN.prove(&Claim { order, name: "", bound }, budget);
        assert!(prove(0, 9.0, 10_000).is_some());
        assert!(prove(1, 28.0, 10_000).is_some());
        assert!(prove(1, 23.6, 100_000).is_none());
        assert!(prove(2, 97.0, 10_000).is_none());
    }

    #[test]
    fn voxels_bound_what_is_in_them() {
        let mut random = Random::new(71);
        for spots in all() {
            for k in 0..if spots.lewis { 3 } else { 4 } {
                for _ in 0..3000 {
                    let e = [0.05, 0.0125][random.unit().round() as usize];
                    let low = random.point(1.0).map(|a| (a / e).round() * e);
                    let v = unit(random.point(1.0));
                    let bound = spots.bound(k, v, low, e);
                    for _ in 0..8 {
                        let d = low.map(|a| a + e * random.unit());
                        let value = spots.at(k, d, v);
                        assert!(value <= bound * (1.0 + 1e-9), "{spots:?} {k} {low:?} {d:?} {value} {bound}");
                    }
                }
            }
        }
    }

    #[test]
    fn tables_bound_the_sums() {
        let mut random = Random::new(72);
        for spots in all() {
            let v = unit([1.0, 0.6, 0.2]);
            let upper = spots.upper(1, v, 20);
            let margin = if spots.margin { scatter::MARGIN } else { 0.0 };
            for _ in 0..300 {
                let x = random.point(0.5).map(|x| x + 0.5);
                let sum: f64 = (0..27)
                    .map(|c| {
                        let corner = [c % 3, c / 3 % 3, c / 9].map(|o| f64::from(o) - 1.0);
                        (0..40).fold(0.0, |most, _| {
                            let p = [0; 3].map(|_| margin + (1.0 - 2.0 * margin) * random.unit());
                            f64::max(most, spots.at(1, [0, 1, 2].map(|i| x[i] - corner[i] - p[i]), v))
                        })
                    })
                    .sum();
                assert!(sum <= upper, "{spots:?} {x:?}");
            }
        }
    }
}
