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

#[cfg(test)]
mod tests {
    use super::*;

    /// However many axes there are, each is varied in all of its range, and no two of them go together.
    #[test]
    fn many_axes_are_varied_one_by_one() {
        const AXES: usize = 400;
        let points: Vec<Vec<f64>> = (0..24).map(|index| point(AXES, index, 7)).collect();
        let along = |axis: usize| points.iter().map(move |point| point[axis]);
        for axis in 0..AXES {
            let mut quarters = [0; 4];
            along(axis).for_each(|place| quarters[(4.0 * place) as usize] += 1);
            assert_eq!(quarters, [6; 4], "{axis}");
        }
        let square = |a: usize, b: usize| {
            let sum: f64 = along(a).zip(along(b)).map(|(x, y)| 12.0 * (x - 0.5) * (y - 0.5)).sum();
            (sum / points.len() as f64) * (sum / points.len() as f64)
        };
        let pairs = (1..AXES).flat_map(|a| (0..a).map(move |b| (a, b)));
        let mean = pairs.map(|(a, b)| square(a, b)).sum::<f64>() / (0.5 * (AXES * (AXES - 1)) as f64);
        // By chance it is one over how many there are; but of any two in turn each half of every axis has one.
        assert!(mean < 2.0 / points.len() as f64, "{mean}");
    }
}
