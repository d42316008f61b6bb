//! Where samples lie in a pixel, and the numbers that look random but are not.
//!
//! Every such number is a hash of the pixel, the sample, a purpose and the seed. So a picture does
//! not depend on the order in which its pixels are made.

/// What a number is for; numbers for different purposes are independent.
#[derive(Clone, Copy, Debug)]
pub(super) enum Purpose {
    /// Place in the pixel, across.
    X,
    /// Place in the pixel, down.
    Y,
    /// Place within a step through the air.
    Air,
    /// Place on the lens, by axis of the unit square.
    Lens(u8),
    /// Rounding to eight bits, by channel.
    Dither(u8),
}

/// A number in [0, 1).
pub(super) fn uniform(pixel: u64, sample: u32, purpose: Purpose, seed: u64) -> f64 {
    let purpose = match purpose {
        Purpose::X => 0,
        Purpose::Y => 1,
        Purpose::Air => 2,
        Purpose::Dither(channel) => 3 + u64::from(channel),
        Purpose::Lens(axis) => 16 + u64::from(axis),
    };
    let bits = mix(mix(mix(seed ^ 0x9E37_79B9_7F4A_7C15) ^ pixel) ^ (u64::from(sample) << 8 | purpose));
    (bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

/// A place in the unit square that stands for one on the lens.
pub(super) fn on_lens(pixel: u64, sample: u32, seed: u64) -> [f64; 2] {
    [0, 1].map(|axis| uniform(pixel, sample, Purpose::Lens(axis), seed))
}

/// The finaliser of SplitMix64 (Steele, Lea and Flood, 2014): every input bit turns over half of
/// the output bits.
fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
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

    /// Where in the pixel a sample lies, from (0, 0) at its top left to (1, 1). A lone sample is in
    /// the middle: jitter would only fray its edges.
    pub(super) fn place(self, pixel: u64, sample: u32, seed: u64) -> [f64; 2] {
        if self.samples == 1 {
            return [0.5, 0.5];
        }
        let [left, top, width, height] = self.part(sample);
        let x = uniform(pixel, sample, Purpose::X, seed);
        let y = uniform(pixel, sample, Purpose::Y, seed);
        [left + width * x, top + height * y]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
                let [x, y] = strata.place(7, s, 1);
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
            let x = uniform(pixel, 3, Purpose::X, 0);
            let y = uniform(pixel, 3, Purpose::Y, 0);
            assert!((0.0..1.0).contains(&x));
            sum += x;
            product += (x - 0.5) * (y - 0.5);
        }
        assert!((sum / count as f64 - 0.5).abs() < 5e-3);
        assert!((product / count as f64).abs() < 2e-3);
    }
}
