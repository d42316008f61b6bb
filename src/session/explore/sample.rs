//! Points that fill a cube of any dimension evenly, however many of them are taken.
//!
//! Two axes after the other share a [sequence] of the square of their own. So of any power of two points each axis has one
//! in every part as wide, and each of these pairs in every box as large; other pairs are independent of one another,
//! however many there are.

use crate::num::sequence;

/// A point of a sequence.
pub fn point(dimensions: usize, index: u64, seed: u64) -> Vec<f64> {
    let pairs = (0..dimensions.div_ceil(2)).flat_map(|pair| sequence::point(seed, index as u32, pair as u32));
    pairs.take(dimensions).collect()
}
