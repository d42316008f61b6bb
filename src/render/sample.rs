//! Samples: where they lie in their pixels and in time, and the numbers that look random but are not.
//!
//! Every such number is a hash of the pixel, the sample, a purpose and the seed. So a picture does
//! not depend on the order in which its pixels are made.

use super::{Filter, View};
use crate::num::{mix, morton2, sequence, uniform};
use glam::DVec3;

/// What a number is for; numbers for different purposes are independent.
#[derive(Clone, Copy, Debug)]
pub(super) enum Purpose {
    /// Place in the pixel.
    Place,
    /// Place on the lens.
    Lens,
    /// Place within a step through the air.
    Air { step: u32 },
    /// Point of a light's disc.
    Light { step: u32, number: u32 },
    /// Direction in which a path goes on.
    Onward { step: u32 },
    /// Direction in which lights are mirrored.
    Glint { step: u32 },
}

impl Purpose {
    /// A number that no other purpose has.
    fn code(self) -> u32 {
        let one = |kind: u32, step: u32, number: u32| kind | step << 3 | number << 10;
        match self {
            Purpose::Place => 0,
            Purpose::Lens => one(4, 0, 0),
            Purpose::Air { step } => one(1, step, 0),
            Purpose::Light { step, number } => one(2, step, number),
            Purpose::Onward { step } => one(3, step, 0),
            Purpose::Glint { step } => one(5, step, 0),
        }
    }
}

/// A number in [0, 1) for rounding a channel of a pixel.
pub(super) fn dither(pixel: u64, channel: u64) -> f64 {
    uniform(mix(mix(pixel) ^ channel))
}

/// A sample of a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// Number of the pixel in its tile.
    pub in_tile: usize,
    /// Where it lies in the picture, in pixels.
    pub place: [f64; 2],
    pixel: u64,
    index: u32,
    seed: u64,
}

impl Sample {
    /// A sample in the middle of the pixel in a column and a row of the picture.
    pub fn new([x, y]: [u32; 2], index: u32, seed: u64, in_tile: usize) -> Sample {
        let place = [f64::from(x) + 0.5, f64::from(y) + 0.5];
        Sample { in_tile, place, pixel: u64::from(y) << 32 | u64::from(x), index, seed }
    }

    /// The same at its place, as a filter has it.
    pub fn placed(mut self, filter: &Filter) -> Sample {
        let [x, y] = filter.place(self.pair(Purpose::Place));
        self.place = [self.place[0] + x, self.place[1] + y];
        self
    }

    /// Where it lies on a curve through the picture on which neighbours are near to one another: Morton's, in sixteenths
    /// of pixels.
    pub fn along_curve(&self) -> u64 {
        // Filters reach beyond the first pixel.
        morton2(self.place.map(|x| (16.0 * x + 1024.0) as u32))
    }

    /// Origin and direction of its line of sight.
    pub fn line(&self, view: &View) -> (DVec3, DVec3) {
        view.ray(self.place[0], self.place[1], self.pair(Purpose::Lens))
    }

    /// A number in [0, 1); those of all samples are spread evenly.
    pub fn number(&self, purpose: Purpose) -> f64 {
        sequence::point(self.key(), self.index, 2 * purpose.code() + 1)[0]
    }

    /// A point of the unit square; those of all samples are spread evenly.
    pub fn pair(&self, purpose: Purpose) -> [f64; 2] {
        sequence::point(self.key(), self.index, 2 * purpose.code())
    }

    /// What the numbers of its pixel come from.
    fn key(&self) -> u64 {
        mix(mix(self.seed) ^ self.pixel)
    }

    /// The moment that it is taken at, of those that an [order](sequence::order) lists. All moments have their turn, before any
    /// has its second one, and however few samples of a pixel are taken, they are spread over all the time; which comes first
    /// is another matter in each pixel, so that no pattern shows.
    pub fn moment(&self, order: &[usize]) -> usize {
        let (round, turn) = (self.index as usize / order.len(), self.index as usize % order.len());
        let first = mix(self.key() ^ round as u64) as usize % order.len();
        (first + order[turn]) % order.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Film;

    #[test]
    fn the_curve_is_one_to_one_and_keeps_neighbours_together() {
        let at = |x: u32, y: u32| Sample::new([x, y], 0, 0, 0).along_curve();
        let mut seen: Vec<u64> = (0..64).flat_map(|y| (0..64).map(move |x| at(x, y))).collect();
        let (low, high) = (seen.iter().min().unwrap().to_owned(), seen.iter().max().unwrap().to_owned());
        seen.sort();
        seen.dedup();
        // Sixteen by sixteen places in each pixel.
        assert!(seen.len() == 64 * 64 && high - low < 64 * 64 * 256);
        assert_eq!(at(1, 0) - at(0, 0), 256);
        assert_eq!(at(0, 1) - at(0, 0), 512);
        assert!(at(Film::MAX_SIDE - 1, 0) > at(0, 0));
    }

    #[test]
    fn every_moment_has_its_turn_in_every_pixel() {
        for count in [1, 2, 3, 4, 6, 7, 16, 56, 100] {
            let listed = sequence::order(count);
            let order = |x: u32, round: u32| -> Vec<usize> {
                let index = |i: u32| round * count as u32 + i;
                (0..count as u32).map(|i| Sample::new([x, 3], index(i), 1, 0).moment(&listed)).collect()
            };
            for x in 0..20 {
                let mut turns = order(x, x % 3);
                turns.sort();
                assert!(turns.iter().copied().eq(0..count), "{count}");
            }
            let orders: std::collections::BTreeSet<_> = (0..20).map(|x| order(x, x % 3)).collect();
            assert!(orders.len() > count.min(20) / 2, "{count}");
            for few in 2..count.min(20) {
                let mut turns = order(4, 1)[..few].to_vec();
                turns.sort();
                turns.push(turns[0] + count);
                let gap = turns.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap();
                assert!((gap as f64) < 1.0 + 1.65 * count as f64 / few as f64, "{count} {few}: {turns:?}");
            }
        }
    }

    #[test]
    fn numbers_are_uniform_and_independent() {
        let count = 40_000;
        let (mut sum, mut product) = (0.0, 0.0);
        for pixel in 0..count {
            let [x, y] = Sample::new([pixel as u32, 0], 3, 0, 0).pair(Purpose::Place);
            assert!((0.0..1.0).contains(&x));
            sum += x;
            product += (x - 0.5) * (y - 0.5);
        }
        assert!((sum / count as f64 - 0.5).abs() < 5e-3);
        assert!((product / count as f64).abs() < 2e-3);
    }
}
