//! Autocovariance along a line, and how far it is from depending on distance alone.
//!
//! The line is the x axis, 8 units long with 16 samples to a unit, and it is looked at in every
//! realisation at up to [`LINES`] places, several whole cells apart along y: to a field on a lattice they
//! are all alike, and more lines make a clearer picture.

use serde::Serialize;

/// Units of length along the line.
pub const SPAN: usize = 8;
/// Samples to a unit.
pub const SAMPLES: usize = 16;
/// Samples on the line.
pub const POINTS: usize = SPAN * SAMPLES;
/// Lines in a realisation, at most.
pub const LINES: usize = 8;

/// Autocovariance of a random field at pairs of points on a line.
#[derive(Clone, Debug, Serialize)]
pub struct Covariance {
    /// Distance of two samples.
    pub step: f64,
    /// Number of lines averaged over.
    pub lines: usize,
    /// `C(x_i, x_j)`, row by row.
    pub matrix: Vec<f64>,
    /// The mean along each diagonal: the autocovariance at a distance of 0, 1, 2 ... steps.
    pub by_distance: Vec<f64>,
    /// Least and largest variance of any point: the range of the main diagonal.
    pub variance_range: (f64, f64),
    /// How far the matrix is from having constant diagonals; see [`Covariance::of`].
    pub score: f64,
    /// What that is for a stationary field, because there are only so many lines.
    pub floor: f64,
}

impl Covariance {
    /// Of lines of [`POINTS`] samples, one after the other.
    ///
    /// The score is `sqrt(mean over diagonals of the variance along the diagonal) / C(0)`. Diagonals
    /// count up to a quarter of the span: farther out covariances have mostly died, and what is left
    /// is the error of the estimate. For a stationary Gaussian field that error has the variance
    /// `(C(0)^2 + C(d)^2) / lines` at each entry, which gives the floor.
    pub fn of(samples: &[f64]) -> Covariance {
        let lines = samples.len() / POINTS;
        let scale = 1.0 / lines.max(1) as f64;
        let line = |l: usize| &samples[l * POINTS..(l + 1) * POINTS];
        let mut mean = [0.0; POINTS];
        for l in 0..lines {
            mean.iter_mut().zip(line(l)).for_each(|(m, v)| *m += v * scale);
        }
        let mut matrix = vec![0.0; POINTS * POINTS];
        for l in 0..lines {
            let centred: [f64; POINTS] = std::array::from_fn(|i| line(l)[i] - mean[i]);
            for (row, a) in matrix.chunks_exact_mut(POINTS).zip(centred) {
                row.iter_mut().zip(centred).for_each(|(c, b)| *c += a * b * scale);
            }
        }
        let diagonal = |d: usize| (0..POINTS - d).map(|i| matrix[i * POINTS + i + d]).collect::<Vec<f64>>();
        let mean_of = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
        let by_distance: Vec<f64> = (0..POINTS).map(|d| mean_of(&diagonal(d))).collect();
        let power = by_distance[0];
        let (mut spread, mut chance) = (0.0, 0.0);
        for d in 0..POINTS / 4 {
            let along: Vec<f64> =
                diagonal(d).iter().map(|c| (c - by_distance[d]) * (c - by_distance[d])).collect();
            spread += mean_of(&along);
            chance += (power * power + by_distance[d] * by_distance[d]) * scale;
        }
        let relative = |sum: f64| libm::sqrt(sum / (POINTS / 4) as f64) / power.max(f64::MIN_POSITIVE);
        let variances = diagonal(0);
        Covariance {
            step: 1.0 / SAMPLES as f64,
            lines,
            variance_range: variances.iter().fold((f64::INFINITY, 0.0), |(a, b), v| (v.min(a), v.max(b))),
            score: relative(spread),
            floor: relative(chance),
            by_distance,
            matrix,
        }
    }

    /// The covariance of the samples `i` and `j`.
    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.matrix[i * POINTS + j]
    }

    /// The autocovariance at a distance in samples, over the variance.
    pub fn correlation(&self, distance: usize) -> f64 {
        self.by_distance[distance] / self.by_distance[0].max(f64::MIN_POSITIVE)
    }
}
