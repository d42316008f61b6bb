//! Points that fill a cube of any dimension evenly, however many of them are taken: Kronecker's sequence.
//!
//! Each coordinate goes on by a number of its own and starts over at 1. These numbers have to be as far from fractions
//! as can be, in all dimensions together. In one that is the golden ratio; Roberts (2018, *The unreasonable
//! effectiveness of quasirandom sequences*) takes powers of `1/g` where `g^(d + 1) = g + 1`, of which the golden ratio
//! is the first case. Where the sequence starts depends on the seed.

use crate::num::{mix, uniform};

/// A point of a sequence.
pub fn point(dimensions: usize, index: u64, seed: u64) -> Vec<f64> {
    let ratio = 1.0 / root(dimensions);
    let mut step = 1.0;
    let coordinate = |axis: usize| {
        step *= ratio;
        let place = uniform(mix(seed ^ mix(axis as u64))) + index as f64 * step;
        place - place.floor()
    };
    (0..dimensions).map(coordinate).collect()
}

/// The `g > 1` with `g^(d + 1) = g + 1`: the equation itself leads there from anywhere near.
fn root(dimensions: usize) -> f64 {
    let power = 1.0 / (dimensions as f64 + 1.0);
    (0..64).fold(1.5, |g, _| libm::pow(g + 1.0, power))
}
