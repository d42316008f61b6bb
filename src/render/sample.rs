//! Samples: where they lie in their pixels and in time, and the numbers that look random but are not.
//!
//! Every such number is a hash of the pixel, the sample, a purpose and the seed. So a picture does
//! not depend on the order in which its pixels are made.

use crate::num::{mix, uniform as from_bits};

/// What a number is for; numbers for different purposes are independent.
#[derive(Clone, Copy, Debug)]
pub(super) enum Purpose {
    /// Place in the pixel.
    Place,
    /// Place within a step through the air.
    Air { step: u32 },
    /// Point of a light's disc.
    Light { step: u32, number: u32 },
    /// Direction in which a path goes on.
    Onward { step: u32 },
    /// Moment.
    Moment { round: u32 },
    /// Rounding to eight bits, by channel.
    Dither(u8),
}

impl Purpose {
    /// A number that no other purpose has; two of them are used up.
    fn code(self) -> u64 {
        let one = |kind: u64, step: u32, number: u32| kind | u64::from(step) << 8 | u64::from(number) << 16;
        2 * match self {
            Purpose::Place => 0,
            Purpose::Dither(channel) => one(1, 0, channel.into()),
            Purpose::Air { step } => one(2, step, 0),
            Purpose::Light { step, number } => one(3, step, number),
            Purpose::Onward { step } => one(4, step, 0),
            Purpose::Moment { round } => one(5, 0, round),
        }
    }
}

/// Bits that a pixel's sample has for a purpose, or for the second number of it.
fn bits(pixel: u64, sample: u32, purpose: Purpose, second: bool, seed: u64) -> u64 {
    let key = u64::from(sample) << 40 ^ (purpose.code() | u64::from(second));
    mix(mix(mix(seed) ^ pixel) ^ key)
}

/// A number in [0, 1) of a pixel as a whole.
pub(super) fn uniform(pixel: u64, purpose: Purpose) -> f64 {
    from_bits(bits(pixel, 0, purpose, false, 0))
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

    /// The same at its place.
    pub fn placed(mut self, strata: &Strata) -> Sample {
        let [x, y] = strata.place(&self);
        self.place = [self.place[0] + x, self.place[1] + y];
        self
    }

    /// A number in [0, 1).
    pub fn number(&self, purpose: Purpose) -> f64 {
        from_bits(bits(self.pixel, self.index, purpose, false, self.seed))
    }

    /// Two numbers in [0, 1).
    pub fn pair(&self, purpose: Purpose) -> [f64; 2] {
        [false, true].map(|second| from_bits(bits(self.pixel, self.index, purpose, second, self.seed)))
    }

    /// The moment that it is taken at, out of so many. All moments have their turn, before any has its second one; in which
    /// order is another matter in each pixel, so that no pattern shows.
    pub fn moment(&self, count: usize) -> usize {
        let (round, turn) = (self.index as usize / count, self.index as usize % count);
        permuted(turn, count, bits(self.pixel, 0, Purpose::Moment { round: round as u32 }, false, self.seed))
    }
}

/// Where `i` comes to in a permutation of the numbers below `count`. Steps that shuffle the numbers below a power of two are
/// repeated until they lead below `count` again, which keeps them one to one (Kensler 2013).
fn permuted(i: usize, count: usize, key: u64) -> usize {
    let mask = count.next_power_of_two() as u64 - 1;
    let bits = mask.count_ones().max(1);
    let mut i = i as u64;
    loop {
        for round in 0..3 {
            // Each is one to one below the power of two: adding, multiplying by what is odd, and mixing high bits into low ones.
            i = i.wrapping_add(key >> (16 * round)) & mask;
            i = i.wrapping_mul(key >> (8 * round) | 1) & mask;
            i ^= i >> bits.div_ceil(2);
        }
        if (i as usize) < count {
            return i as usize;
        }
    }
}

/// Cuts a pixel into as many parts of equal area as there are samples, each nearly square.
///
/// The parts lie in about `sqrt(n)` rows. A row of `k` parts is `k / n` high, so that a number of
/// samples that is no square leaves no part of the pixel under-represented.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strata {
    samples: u32,
    rows: u32,
}

impl Strata {
    pub(super) fn new(samples: u32) -> Self {
        let samples = samples.max(1);
        Strata { samples, rows: (samples.isqrt()).max(1) }
    }

    /// Left, top, width and height of a part, in pixels.
    fn part(self, sample: u32) -> [f64; 4] {
        // Row r holds the samples from r n / rows on.
        let (n, rows) = (u64::from(self.samples), u64::from(self.rows));
        let start = |row: u64| (row * n).div_ceil(rows);
        let row = u64::from(sample) * rows / n;
        let (first, end) = (start(row), start(row + 1));
        let width = 1.0 / (end - first) as f64;
        let left = (u64::from(sample) - first) as f64 * width;
        [left, first as f64 / n as f64, width, (end - first) as f64 / n as f64]
    }

    /// Where a sample lies, in pixels from the middle of its own. A lone sample is there: jitter would only fray its edges.
    fn place(self, sample: &Sample) -> [f64; 2] {
        if self.samples == 1 {
            return [0.0, 0.0];
        }
        let [left, top, width, height] = self.part(sample.index);
        let [x, y] = sample.pair(Purpose::Place);
        [left + width * x - 0.5, top + height * y - 0.5]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_moment_has_its_turn_in_every_pixel() {
        for count in [1, 2, 3, 7, 16, 100] {
            let order = |x: u32, round: u32| -> Vec<usize> {
                let index = |i: u32| round * count as u32 + i;
                (0..count as u32).map(|i| Sample::new([x, 3], index(i), 1, 0).moment(count)).collect()
            };
            for x in 0..20 {
                let mut turns = order(x, x % 3);
                turns.sort();
                assert!(turns.iter().copied().eq(0..count), "{count}");
            }
            assert!(count < 7 || order(0, 0) != order(1, 0) && order(0, 0) != order(0, 1));
        }
    }

    #[test]
    fn strata_tile_the_pixel() {
        for n in 1..=70 {
            let strata = Strata::new(n);
            let mut area = 0.0;
            for s in 0..n {
                let [left, top, width, height] = strata.part(s);
                area += width * height;
                assert!((width * height * f64::from(n) - 1.0).abs() < 1e-12, "{n}: equal areas");
                assert!(left >= 0.0 && left + width < 1.0 + 1e-12);
                assert!(top >= 0.0 && top + height < 1.0 + 1e-12);
                assert!(width < 4.5 * height && height < 4.5 * width, "{n}: {width} x {height}");
                let [x, y] = strata.place(&Sample::new([7, 0], s, 1, 0)).map(|c| c + 0.5);
                if n > 1 {
                    assert!((left..left + width).contains(&x) && (top..top + height).contains(&y));
                }
            }
            assert!((area - 1.0).abs() < 1e-12);
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
