//! Points that fill the unit square evenly, however many of them are taken: the scrambled sequence of
//! Sobol.
//!
//! Numbers at random leave gaps and make clusters: the error of a mean of `n` of them falls as
//! `n^(-1/2)`. The first two dimensions of Sobol's sequence are a *(0, 2)-sequence*: of every `2^k`
//! points from a multiple of `2^k` on, each box with sides `2^-i` and `2^-j`, `i + j = k`, has exactly
//! one. So any number of samples is spread well, and more may follow.
//!
//! Owen's scrambling makes a random sequence of it that keeps this property: seen as a binary tree of
//! halves of halves, every node swaps its children or not, by chance. Each point is then uniform, so a
//! mean is unbiased, and its error falls as `n^(-3/2)` for smooth functions, and as `n^(-3/4)` for edges
//! (Owen 1997, *Scrambled net variance for integrals of smooth functions*). The tree that belongs to the
//! position in the sequence is scrambled likewise, which shuffles the points, so that pairs of dimensions
//! that are used for different things are independent of one another (Burley 2020, *Practical hash-based
//! Owen scrambling*).
//!
//! Scrambling is a hash of a number with its bits reversed in which every bit depends on lower bits only:
//! all of its steps are sums, and products with odd numbers, or exclusive-ors with products with even
//! ones. Its constants are Vegdahl's (2021, *Building a better LK hash*); a test measures how near to
//! chance it comes.

use crate::num::mix;

/// Numbers as fractions of 2^32.
const UNIT: f64 = 1.0 / (1_u64 << 32) as f64;

/// A point of the unit square: element `index` of the sequence that belongs to a pixel and a pair of
/// dimensions. Both coordinates are in `[0, 1)`, multiples of 2^-32.
///
/// `pixel` is a hash of the pixel, the frame and the seed. Different pairs are for different purposes,
/// such as the place in the pixel or the place on the sun: their sequences are independent.
#[inline]
pub fn point(pixel: u64, index: u32, pair: u32) -> [f64; 2] {
    let seeds = mix(mix(pixel) ^ u64::from(pair));
    let shuffled = scramble(index.reverse_bits(), mix(seeds) as u32).reverse_bits();
    let across = scramble(shuffled, seeds as u32);
    let down = scramble(pascal(shuffled), (seeds >> 32) as u32);
    [across, down].map(|reversed| f64::from(reversed.reverse_bits()) * UNIT)
}

/// The second dimension of Sobol's sequence, with its bits reversed.
///
/// Bit `r` of the fraction is the sum, modulo 2, of all bits `c` of the index for which the binomial
/// coefficient `c` over `r` is odd: those of which `r` has no bit that `c` has not (Lucas). So the matrix
/// is a power of that of two bits, by Kronecker's product, and takes one step for each of the five
/// bits that number the bits.
#[inline]
fn pascal(index: u32) -> u32 {
    const STEPS: [(u32, u32); 5] =
        [(1, 0x5555_5555), (2, 0x3333_3333), (4, 0x0F0F_0F0F), (8, 0x00FF_00FF), (16, 0x0000_FFFF)];
    STEPS.iter().fold(index, |bits, (shift, lower)| bits ^ ((bits >> shift) & lower))
}

/// Owen's scrambling of a number with reversed bits.
#[inline]
fn scramble(x: u32, seed: u32) -> u32 {
    let x = x ^ x.wrapping_mul(0x3d20_adea);
    let x = x.wrapping_add(seed);
    let x = x.wrapping_mul((seed >> 16) | 1);
    let x = x ^ x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// The numbers below `count` in an order in which any first few are spread evenly: that of the multiples of the golden
/// section, by where they come to in the unit interval.
pub fn order(count: usize) -> Vec<usize> {
    let place = |i: usize| (i as f64 * GOLDEN).fract();
    let mut sorted: Vec<usize> = (0..count).collect();
    sorted.sort_by(|a, b| place(*a).total_cmp(&place(*b)));
    let mut order = vec![0; count];
    sorted.into_iter().enumerate().for_each(|(rank, i)| order[i] = rank);
    order
}

/// The golden section: of all numbers the farthest from fractions, so that its multiples, less their whole parts, fill the
/// unit interval evenly.
const GOLDEN: f64 = 0.618_033_988_75;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::uniform;

    #[test]
    fn sobols_matrix_is_pascals_triangle() {
        let mut row = vec![1_u32];
        for c in 0..32 {
            let column = pascal(1 << c);
            for r in 0..32 {
                let odd = row.get(r).is_some_and(|binomial| binomial % 2 == 1);
                assert_eq!(column >> r & 1 == 1, odd, "{c} over {r}");
            }
            row = (0..=row.len())
                .map(|k| (row.get(k).unwrap_or(&0) + if k > 0 { row[k - 1] } else { 0 }) % 2)
                .collect();
        }
    }

    #[test]
    fn every_aligned_block_is_a_net() {
        for k in 0..=10_u32 {
            for (pixel, block) in (0..12).flat_map(|pixel| [(pixel, 0), (pixel, 1), (pixel, 5)]) {
                let from = block << k;
                let points: Vec<_> = (from..from + (1 << k)).map(|i| point(pixel, i, 3)).collect();
                for columns in 0..=k {
                    let mut taken = vec![false; 1 << k];
                    for [x, y] in &points {
                        let column = (x * f64::from(1 << columns)) as usize;
                        let row = (y * f64::from(1 << (k - columns))) as usize;
                        let cell = &mut taken[(row << columns) + column];
                        assert!(!*cell, "2^{k} points, 2^{columns} columns: two in one cell");
                        *cell = true;
                    }
                }
            }
        }
    }

    #[test]
    fn each_point_is_uniform() {
        const CELLS: usize = 16;
        for index in [0, 1, 7, 100] {
            let (count, mut tally) = (64_000_u64, [0.0; CELLS * CELLS]);
            for pixel in 0..count {
                let [x, y] = point(pixel, index, 0);
                assert!((0.0..1.0).contains(&x) && (0.0..1.0).contains(&y));
                tally[(x * CELLS as f64) as usize * CELLS + (y * CELLS as f64) as usize] += 1.0;
            }
            let expected = count as f64 / tally.len() as f64;
            let chi: f64 = tally.iter().map(|n| (n - expected) * (n - expected) / expected).sum();
            // 255 degrees of freedom: five deviations of sqrt(2 * 255) are 113.
            assert!((chi - 255.0).abs() < 113.0, "{index}: {chi}");
        }
    }

    #[test]
    fn scrambling_is_a_fair_tree() {
        // Whether a node of the tree swaps its children must depend on the seed and on which node it is.
        let trials = 4000_u64;
        for depth in [1, 2, 5, 10, 20, 31] {
            for above in 0..depth {
                let (mut swaps, mut differ) = (0_u32, 0_u32);
                for i in 0..trials {
                    let [x, seed] = [mix(2 * i) as u32, mix(2 * i + 1) as u32];
                    let swapped = |x: u32| (scramble(x, seed) ^ x) >> depth & 1;
                    swaps += swapped(x);
                    differ += swapped(x) ^ swapped(x ^ (1 << above));
                    let lower = (1 << depth) - 1;
                    assert_eq!(scramble(x, seed) & lower, scramble(x & lower, seed) & lower);
                }
                for share in [swaps, differ].map(|n| f64::from(n) / trials as f64) {
                    assert!((share - 0.5).abs() < 0.03, "bit {depth}, with {above} changed: {share}");
                }
            }
        }
    }

    /// Correlation of two lists of numbers that are uniform in [0, 1).
    fn correlation(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for (a, b) in pairs {
            sum += (a - 0.5) * (b - 0.5);
            count += 1.0;
        }
        12.0 * sum / count
    }

    #[test]
    fn pixels_and_pairs_of_dimensions_are_independent() {
        let index = |i: u64| (i % 64) as u32;
        let count = 40_000;
        let between = |f: &dyn Fn(u64) -> (f64, f64)| correlation((0..count).map(f));
        let found = [
            between(&|i| (point(i / 64, index(i), 0)[0], point(i / 64 + 1, index(i), 0)[0])),
            between(&|i| (point(i / 64, index(i), 0)[1], point(i / 64 + 1, index(i), 0)[1])),
            between(&|i| (point(i / 64, index(i), 0)[0], point(i / 64, index(i), 1)[0])),
            between(&|i| (point(i / 64, index(i), 0)[1], point(i / 64, index(i), 1)[1])),
            between(&|i| (point(i / 64, index(i), 0)[0], point(i / 64, index(i), 7)[1])),
            between(&|i| (point(i / 64, index(i), 2)[0], point(i / 64, index(i), 2)[1])),
        ];
        for r in found {
            assert!(r.abs() < 4.0 / (count as f64).sqrt(), "{found:?}");
        }
    }

    /// Exponent of the fall of the variance of a mean from 16 to 1024 samples, over many pixels.
    fn exponent(points: impl Fn(u64, u32) -> [f64; 2], f: impl Fn([f64; 2]) -> f64, exact: f64) -> f64 {
        let pixels = 400;
        let variance = |samples: u32| {
            let square = |pixel| {
                let mean = (0..samples).map(|i| f(points(pixel, i))).sum::<f64>() / f64::from(samples);
                (mean - exact) * (mean - exact)
            };
            (0..pixels).map(square).sum::<f64>() / pixels as f64
        };
        libm::log2(variance(1024) / variance(16)) / 6.0
    }

    #[test]
    fn errors_fall_faster_than_by_chance() {
        let smooth = |[x, y]: [f64; 2]| libm::exp(x + 0.5 * y);
        let smooth_mean = (libm::exp(1.0) - 1.0) * (libm::exp(0.5) - 1.0) / 0.5;
        // A half plane whose edge passes through (0, 0.2) and (1, 0.9).
        let edge = |[x, y]: [f64; 2]| f64::from(u8::from(y > 0.2 + 0.7 * x));
        let chance = |pixel: u64, i: u32| {
            let hash = mix(mix(pixel) ^ u64::from(i));
            [uniform(hash), uniform(mix(hash))]
        };
        let sobol = |pixel: u64, i: u32| point(mix(pixel), i, 0);
        let by_chance = [exponent(chance, smooth, smooth_mean), exponent(chance, edge, 0.45)];
        let by_sobol = [exponent(sobol, smooth, smooth_mean), exponent(sobol, edge, 0.45)];
        assert!(by_chance.iter().all(|e| (e + 1.0).abs() < 0.1), "{by_chance:?}");
        assert!(by_sobol[0] < -2.5 && by_sobol[1] < -1.35, "{by_sobol:?}");
    }
}
