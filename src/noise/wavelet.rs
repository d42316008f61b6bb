//! Wavelet noise (Cook and DeRose 2005; Gamito 2009, 4.6): the part of a random spline that coarser
//! splines cannot represent.
//!
//! Quadratic B-splines on the integers can all be written on the half-integers as well, by the
//! refinement `B(x) = sum_j p_j B(2x - j)` with `p = (1, 3, 3, 1)/4`. So what is left of a random
//! spline `R` after taking off its best coarser approximation,
//!
//! ```text
//! N = R - up(down(R))            down: L2 projection (32 taps),  up: the refinement
//! ```
//!
//! lives in one octave: coarser splines are nearly blind to it, and it has no finer detail than its
//! own splines have. Here it is `N(2x)`, which puts its octave near one cycle a cell.
//!
//! **Class.** Quadratic splines are C1 and no more: the Hessian jumps between cells, so the noise has
//! normals everywhere but is not open to Morse analysis.
//!
//! **Tiles.** A coefficient depends on the random numbers within 17 of it, too many to hash for every
//! point, so coefficients are computed once, in a few periodic tiles. What makes them fit together is
//! that all tiles have the *same* random numbers within 18 of their faces: there the filters see the
//! same numbers on whichever side and in whichever tile, so the tiles agree in the layers at their
//! faces, and any arrangement of them is exactly the noise of the random numbers so arranged. Which
//! tile stands where is a hash of its place and the seed, and every seed shifts the arrangement by a
//! random number of coefficients. (The price: what lies within 9 cells of the faces of blocks, which
//! are 48 cells apart, looks alike in all blocks. Octaves of a fractal are shifted differently, and
//! turned.)
//!
//! **Stationarity.** The variance alternates between even and odd coefficients (in one dimension it
//! runs from 0.044 to 0.189). Cook and DeRose even that out by adding a copy shifted by an odd number
//! of coefficients, which doubles the variance; but a copy shifted within a tile no longer meets its
//! neighbours at the faces. Instead the random shift of a seed is even or odd alike: one realisation
//! is as uneven as the plain noise, and over seeds no place is special.
//!
//! Mean 0, variance 0.098.

use super::basis::Basis;
use super::bulk::{self, GRADIENT, HESSIAN, Lanes};
use super::lattice::{Lattice, STEP, hash};
use super::parameter::Settings;
use crate::num::{
    Bounds, Class, Jets, Order, Point, ROUNDOFF, cos_turns, mix, quadratic, sin_turns, uniform,
};
use rayon::prelude::*;
use std::sync::OnceLock;

/// Wavelet noise at unit frequency: two coefficients to a unit of length along each axis.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub struct Wavelet;

impl Wavelet {
    /// Proven by `examples/certify_noise.rs` from the coefficients themselves (see
    /// [`certify`](super::certify)). The suprema, as far as a search can tell, are 2.1096, 9.0983 and
    /// 44.778.
    pub const BOUNDS: Bounds = Bounds { range: 2.12, lipschitz: 9.15, hessian: 45.0, third: f64::INFINITY };
}

/// Coefficients along an edge of a tile.
pub(super) const EDGE: usize = 96;
/// Tiles.
pub(super) const TILES: usize = 4;
/// All tiles have the same random numbers this near to their faces.
const MARGIN: usize = 18;
/// An edge with a layer of the neighbours on either side.
const PADDED: usize = EDGE + 2;

/// Coefficients to a unit of length.
pub(super) const RATE: f64 = 2.0;

impl Basis for Wavelet {
    fn new(_: &Settings) -> Self {
        Wavelet
    }

    fn class(&self) -> Class {
        Class::C1
    }

    #[inline]
    fn bounds(&self) -> Bounds {
        Wavelet::BOUNDS
    }

    /// Measured; the peak is at 0.67.
    fn band(&self) -> f64 {
        1.5
    }

    fn tiles(&self, period: [u32; 3]) -> Result<(), &'static str> {
        if period.iter().all(|p| p % (EDGE as u32 / 2) == 0) {
            Ok(())
        } else {
            Err("wavelet noise repeats after multiples of 48 cells, the size of its tiles")
        }
    }

    fn jets(&self, lattice: &Lattice, at: [&[f64]; 3], out: Jets<'_>) {
        bulk::jets(|| Blocks::new(lattice), at, out);
    }

    fn jet(&self, lattice: &Lattice, order: Order, at: [f64; 3]) -> Point {
        bulk::jet(Blocks::new(lattice), order, at)
    }

    /// Coordinates within a cell are exact. Weights are off by a few roundoffs, and so are the sums,
    /// relative to the coefficients; the weights of derivatives add up to 2 and 4 in size.
    fn rounding(&self) -> [f64; 3] {
        let value = 64.0 * ROUNDOFF * tiles().most;
        [value, 4.0 * value, 16.0 * value]
    }
}

/// The coefficients of all tiles.
pub(super) struct Tiles {
    /// By tile, z, y, x, with a layer of neighbours.
    coefficients: Vec<f32>,
    /// Largest size of a coefficient.
    most: f64,
}

/// The tiles, computed when they are first asked for.
pub(super) fn tiles() -> &'static Tiles {
    static TABLE: OnceLock<Tiles> = OnceLock::new();
    TABLE.get_or_init(Tiles::new)
}

impl Tiles {
    fn new() -> Tiles {
        let tiles: Vec<Vec<f64>> = (0..TILES).into_par_iter().map(tile).collect();
        let mut coefficients = Vec::with_capacity(TILES * PADDED * PADDED * PADDED);
        let wrap = |i: usize| (i + EDGE - 1) % EDGE;
        for tile in &tiles {
            for n in 0..PADDED * PADDED * PADDED {
                let [x, y, z] = [n % PADDED, n / PADDED % PADDED, n / PADDED / PADDED].map(wrap);
                coefficients.push(tile[(z * EDGE + y) * EDGE + x] as f32);
            }
        }
        let most = coefficients.iter().fold(0.0, |a: f32, b| if b.abs() > a { b.abs() } else { a });
        Tiles { coefficients, most: f64::from(most) }
    }

    /// The three coefficients along x before, at and after the place `i` of a tile, in the rows `j`
    /// and `k` from the one before along y and z.
    #[inline(always)]
    pub(super) fn row(&self, tile: usize, [x, y, z]: [usize; 3], j: usize, k: usize) -> [f64; 3] {
        let start = ((tile * PADDED + z + k) * PADDED + y + j) * PADDED + x;
        let row = &self.coefficients[start..start + 3];
        [f64::from(row[0]), f64::from(row[1]), f64::from(row[2])]
    }
}

/// A random number with the normal law (Box and Muller 1958) for each place and tile.
fn gaussian(tile: usize, n: usize) -> f64 {
    let [x, y, z] = [n % EDGE, n / EDGE % EDGE, n / EDGE / EDGE];
    let shared = [x, y, z].iter().any(|i| *i < MARGIN || *i >= EDGE - MARGIN);
    // The two numbers of a pair stand side by side along x; MARGIN and EDGE are even.
    let owner = if shared { 0 } else { tile + 1 };
    let pair = mix((n / 2 * (TILES + 1) + owner) as u64);
    let radius = (-2.0 * libm::log(1.0 - uniform(pair))).sqrt();
    let turn = uniform(mix(pair));
    radius * if n.is_multiple_of(2) { cos_turns(turn) } else { sin_turns(turn) }
}

/// Half of the filter that projects on coarser splines; the other half is its mirror image. These
/// are the coefficients that Cook and DeRose publish: with them the 32 taps sum to 1.
const DOWN: [f64; 16] = [
    0.655340, 0.033979, -0.243780, -0.025936, 0.103311, 0.011655, -0.044412, -0.005040, 0.019120, 0.002172,
    -0.008233, -0.000938, 0.003546, 0.000410, -0.001528, 0.000334,
];

/// Replaces a periodic line by its best coarser approximation: `r` has the line with 16 neighbours
/// before and 16 after.
fn coarse(r: &[f64; EDGE + 32], line: &mut [f64; EDGE]) {
    *line = [0.0; EDGE];
    for k in 0..EDGE / 2 {
        // Taps are symmetric about 2k - 1/2.
        let middle = 2 * k + 16;
        let down: f64 = (0..16).map(|j| DOWN[j] * (r[middle + j] + r[middle - 1 - j])).sum();
        for (i, weight) in [(EDGE - 2, 0.25), (EDGE - 1, 0.75), (EDGE, 0.75), (EDGE + 1, 0.25)] {
            line[(2 * k + i) % EDGE] += weight * down;
        }
    }
}

/// The coefficients of a tile by z, y, x.
fn tile(tile: usize) -> Vec<f64> {
    let random: Vec<f64> = (0..EDGE * EDGE * EDGE).map(|n| gaussian(tile, n)).collect();
    let mut smooth = random.clone();
    for stride in [1, EDGE, EDGE * EDGE] {
        let lines = (0..EDGE * EDGE * EDGE).filter(|n| n / stride % EDGE == 0);
        for start in lines {
            let r = std::array::from_fn(|i| smooth[start + (i + EDGE - 16) % EDGE * stride]);
            let mut line = [0.0; EDGE];
            coarse(&r, &mut line);
            for (i, x) in line.into_iter().enumerate() {
                smooth[start + i * stride] = x;
            }
        }
    }
    random.into_iter().zip(smooth).map(|(r, s)| r - s).collect()
}

/// Tiles arranged by a seed.
#[derive(Clone, Copy)]
struct Blocks {
    tiles: &'static Tiles,
    key: [u32; 2],
    /// Added to the numbers of coefficients.
    shift: [f64; 3],
    /// Blocks after which the arrangement repeats, or 0.
    period: [f64; 3],
}

/// Where a point is along an axis: the word of its block, its place in the tile, and the fraction.
#[derive(Clone, Copy, Default)]
struct Spot {
    word: u32,
    index: usize,
    t: f64,
}

impl Blocks {
    fn new(lattice: &Lattice) -> Blocks {
        let seed = mix(lattice.seed);
        let shift = [0, 1, 2].map(|axis| (mix(seed ^ axis) % EDGE as u64) as f64);
        let period = lattice.period.map(|p| f64::from(p) * RATE / EDGE as f64);
        Blocks { tiles: tiles(), key: lattice.key(), shift, period }
    }

    #[inline(always)]
    fn spot(&self, axis: usize, x: f64) -> Spot {
        let u = RATE * x;
        // Where there are no fractions the noise stands still; infinities and NaN give NaN.
        let u = if u.abs() < 2_251_799_813_685_248.0 { u } else { u * 0.0 };
        let floor = u.floor();
        let number = floor + self.shift[axis];
        let block = (number / EDGE as f64).floor();
        // Division rounds, but never across a whole number that it does not reach.
        let index = number - block * EDGE as f64;
        let wrapped = match self.period[axis] {
            0.0 => block,
            period => block - (block / period).floor() * period,
        };
        Spot { word: (wrapped as i64 as u32).wrapping_mul(STEP[axis]), index: index as usize, t: u - floor }
    }
}

impl Lanes for Blocks {
    #[inline(always)]
    fn block<const ORDER: u8, const PARTS: usize, const B: usize>(
        &mut self,
        from: &[[f64; B]; 3],
        to: &mut [[f64; B]; PARTS],
    ) {
        for i in 0..B {
            let [x, y, z] = [self.spot(0, from[0][i]), self.spot(1, from[1][i]), self.spot(2, from[2][i])];
            let tile = hash(x.word ^ y.word ^ z.word, self.key) as usize >> 16 & (TILES - 1);
            let [u, v, w] = [quadratic(x.t), quadratic(y.t), quadratic(z.t)];
            // Along x, then y, then z; the order of each derivative by axis.
            let mut sums = [0.0; 10];
            for k in 0..3 {
                let mut plane = [0.0; 6];
                for j in 0..3 {
                    let c = self.tiles.row(tile, [x.index, y.index, z.index], j, k);
                    let along = |w: &[f64; 3]| w[0] * c[0] + w[1] * c[1] + w[2] * c[2];
                    let value = along(&u.value);
                    plane[0] += v.value[j] * value;
                    if ORDER >= GRADIENT {
                        let first = along(&u.first);
                        plane[1] += v.value[j] * first;
                        plane[2] += v.first[j] * value;
                        if ORDER >= HESSIAN {
                            plane[3] += v.value[j] * along(&u.second);
                            plane[4] += v.second[j] * value;
                            plane[5] += v.first[j] * first;
                        }
                    }
                }
                sums[0] += w.value[k] * plane[0];
                if ORDER >= GRADIENT {
                    sums[1] += w.value[k] * plane[1];
                    sums[2] += w.value[k] * plane[2];
                    sums[3] += w.first[k] * plane[0];
                }
                if ORDER >= HESSIAN {
                    sums[4] += w.value[k] * plane[3];
                    sums[5] += w.value[k] * plane[4];
                    sums[6] += w.second[k] * plane[0];
                    sums[7] += w.value[k] * plane[5];
                    sums[8] += w.first[k] * plane[1];
                    sums[9] += w.first[k] * plane[2];
                }
            }
            // A point that is nowhere, whose block is any.
            let nowhere = x.t * 0.0 + y.t * 0.0 + z.t * 0.0;
            to[0][i] = sums[0] + nowhere;
            if ORDER >= GRADIENT {
                for k in 1..4 {
                    to[k][i] = RATE * sums[k] + nowhere;
                }
            }
            if ORDER >= HESSIAN {
                for k in 4..10 {
                    to[k][i] = RATE * RATE * sums[k] + nowhere;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::tests::Random;

    fn jet(seed: u64, p: [f64; 3]) -> Point {
        Wavelet.jet(&Lattice::new(seed), Order::Hessian, p)
    }

    #[test]
    fn tiles_have_mean_zero_and_vanish_when_projected() {
        for t in 0..TILES {
            let tile = tile(t);
            let n = tile.len() as f64;
            assert!((tile.iter().sum::<f64>() / n).abs() < 1e-6);
            let square = tile.iter().map(|c| c * c).sum::<f64>() / n;
            assert!((square - 0.876).abs() < 0.02, "{square}");
            // Along x, y, z in turn; published taps are good to four digits.
            let mut smooth = tile;
            for stride in [1, EDGE, EDGE * EDGE] {
                for start in (0..smooth.len()).filter(|n| n / stride % EDGE == 0).collect::<Vec<_>>() {
                    let r = std::array::from_fn(|i| smooth[start + (i + EDGE - 16) % EDGE * stride]);
                    let mut line = [0.0; EDGE];
                    coarse(&r, &mut line);
                    (0..EDGE).for_each(|i| smooth[start + i * stride] = line[i]);
                }
            }
            let left = (smooth.iter().map(|c| c * c).sum::<f64>() / n).sqrt();
            assert!(left < 2e-3, "{left}");
        }
    }

    #[test]
    fn tiles_agree_at_their_faces_and_differ_inside() {
        let tiles: Vec<_> = (0..TILES).map(tile).collect();
        let at = |t: usize, [x, y, z]: [usize; 3]| tiles[t][(z * EDGE + y) * EDGE + x];
        for n in 0..EDGE * EDGE {
            for face in [0, EDGE - 1] {
                let (a, b) = (n % EDGE, n / EDGE);
                for place in [[face, a, b], [a, face, b], [a, b, face]] {
                    assert!((1..TILES).all(|t| at(t, place) == at(0, place)), "{place:?}");
                }
            }
        }
        assert!((1..TILES).all(|t| at(t, [48, 48, 48]) != at(0, [48, 48, 48])));
    }

    #[test]
    fn blocks_meet_with_equal_gradients() {
        let mut random = Random::new(1);
        for i in 0..2000 {
            let mut p = random.point(200.0);
            // Faces of cells, every 96th of which is one of blocks.
            p[i % 3] = (2.0 * p[i % 3]).round() / 2.0;
            let mut q = p;
            q[i % 3] -= 1e-12;
            let (a, b) = (jet(3, p), jet(3, q));
            assert!((a.value - b.value).abs() < 1e-10, "{p:?}");
            assert!((0..3).all(|k| (a.grad[k] - b.grad[k]).abs() < 1e-9), "{p:?}");
        }
    }

    #[test]
    fn derivatives_match_differences() {
        let mut random = Random::new(2);
        for _ in 0..2000 {
            let p = random.point(80.0);
            // Within a cell: there the noise is a polynomial.
            if p.iter().any(|x| (2.0 * x - (2.0 * x).round()).abs() < 1e-4) {
                continue;
            }
            let (jet_p, h) = (jet(5, p), 1e-5);
            for axis in 0..3 {
                let side = |s: f64| {
                    let mut q = p;
                    q[axis] += s;
                    jet(5, q)
                };
                let (low, high) = (side(-h), side(h));
                assert!(((high.value - low.value) / (2.0 * h) - jet_p.grad[axis]).abs() < 1e-6);
                for other in 0..3 {
                    let pair = [[0, 3, 4], [3, 1, 5], [4, 5, 2]][axis][other];
                    let slope = (high.grad[other] - low.grad[other]) / (2.0 * h);
                    assert!((slope - jet_p.hess[pair]).abs() < 1e-4, "{p:?}");
                }
            }
        }
    }

    #[test]
    fn statistics_and_bounds_hold() {
        let mut random = Random::new(3);
        let (mut sum, mut squares, n) = (0.0, 0.0, 1_000_000);
        let b = Wavelet::BOUNDS;
        for seed in 0..n {
            let jet = jet(seed / 100, random.point(1e3));
            sum += jet.value;
            squares += jet.value * jet.value;
            assert!(jet.value.abs() <= b.range);
            assert!(jet.grad.iter().map(|g| g * g).sum::<f64>() <= b.lipschitz * b.lipschitz);
            assert!(jet.hess.iter().all(|h| h.abs() <= b.hessian));
        }
        let n = n as f64;
        assert!((sum / n).abs() < 2e-3, "{}", sum / n);
        assert!((squares / n - 0.098).abs() < 0.002, "{}", squares / n);
    }

    #[test]
    fn repeats_after_whole_blocks() {
        let mut random = Random::new(4);
        let lattice = Lattice { seed: 2, period: [48, 96, 0] };
        assert!(Wavelet.tiles(lattice.period).is_ok() && Wavelet.tiles([5, 0, 0]).is_err());
        for _ in 0..500 {
            let p = random.point(100.0).map(|x| (x * 1024.0).round() / 1024.0);
            let at = |p| Wavelet.jet(&lattice, Order::Gradient, p);
            assert_eq!(at(p), at([p[0] + 96.0, p[1] - 192.0, p[2]]));
        }
    }

    #[test]
    fn total_for_any_coordinate() {
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(jet(1, [0.3, x, 0.4]).value.is_nan());
        }
        for e in 0..300 {
            let p = [0.3, -0.7, 0.9].map(|x| x * 10_f64.powi(e));
            assert!(jet(1, p).value.abs() <= Wavelet::BOUNDS.range, "{p:?}");
        }
    }
}
