//! Random numbers of a place: a hash of the seed and of what the number belongs to.

use crate::num::{mix, uniform};

/// A hash of a seed and some numbers that name a thing.
#[inline]
pub(super) fn key<const N: usize>(seed: u64, name: [i64; N]) -> u64 {
    name.iter().fold(mix(seed), |hash, part| mix(hash ^ *part as u64))
}

/// Two independent numbers of the normal distribution with zero mean and unit variance, of a hash
/// (Box and Muller 1958).
#[inline]
pub(super) fn normals(hash: u64) -> [f64; 2] {
    // One less the number lies in (0, 1], where there is a logarithm.
    let radius = (-2.0 * libm::log(1.0 - uniform(hash))).sqrt();
    let (sin, cos) = libm::sincos(std::f64::consts::TAU * uniform(mix(hash)));
    [radius * cos, radius * sin]
}

/// A number of the Poisson distribution, of a hash: how many things there are where `mean` are to be
/// expected. By inversion, which takes as many steps as the number is large.
pub(super) fn poisson(hash: u64, mean: f64) -> u32 {
    let mut left = uniform(hash);
    let mut share = libm::exp(-mean);
    let mut count = 0;
    while left >= share && count < 1000 {
        left -= share;
        count += 1;
        share *= mean / f64::from(count);
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_those_of_the_distributions() {
        let count = 200_000;
        let numbers: Vec<f64> = (0..count).flat_map(|i| normals(key(7, [i, 3]))).collect();
        let mean = |f: &dyn Fn(f64) -> f64| numbers.iter().map(|n| f(*n)).sum::<f64>() / numbers.len() as f64;
        assert!(mean(&|n| n).abs() < 0.01);
        assert!((mean(&|n| n * n) - 1.0).abs() < 0.01);
        assert!((mean(&|n| n * n * n * n) - 3.0).abs() < 0.06);
        let pairs = (0..count).map(|i| normals(key(7, [i, 3]))).map(|[a, b]| a * b).sum::<f64>();
        assert!((pairs / count as f64).abs() < 0.01);
        let counts: Vec<f64> = (0..count).map(|i| f64::from(poisson(key(9, [i]), 2.5))).collect();
        let mean = counts.iter().sum::<f64>() / count as f64;
        let variance = counts.iter().map(|c| (c - mean) * (c - mean)).sum::<f64>() / count as f64;
        assert!((mean - 2.5).abs() < 0.02 && (variance - 2.5).abs() < 0.05);
    }
}
