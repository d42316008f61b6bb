//! What a field is like on average, by sampling: moments, quantiles and slopes over a cube.
//!
//! The points are those of an additive recurrence in three dimensions (Roberts 2018): multiples of
//! `(1/g, 1/g^2, 1/g^3)` modulo 1, with `g` the root of `g^4 = g + 1`. They fill the cube evenly, and
//! the cells of a lattice within it too, so that averages settle about as fast as `1 / n` instead of
//! `1 / sqrt(n)`, and they are the same points every time.

use crate::num::{Dual, Many, Real};
use crate::tape::{Evaluator, Tape};
use serde::Serialize;
use std::sync::Arc;

/// Samples of a field and of the norm of its gradient.
#[derive(Clone, Debug, Default)]
pub struct Survey {
    /// Values.
    pub values: Vec<f64>,
    /// Norms of the gradient.
    pub slopes: Vec<f64>,
}

/// Moments and quantiles of samples.
#[derive(Clone, Debug, Serialize)]
pub struct Moments {
    /// Number of samples.
    pub samples: usize,
    /// Mean value.
    pub mean: f64,
    /// Mean squared distance from the mean.
    pub variance: f64,
    /// Least value seen.
    pub min: f64,
    /// Largest value seen.
    pub max: f64,
    /// Values below which the shares [`Moments::SHARES`] of the samples lie.
    pub quantiles: [f64; 7],
    /// Root of the mean squared gradient.
    pub gradient_rms: f64,
    /// Largest gradient seen.
    pub steepest: f64,
}

/// Points evaluated together.
const LANES: usize = 32;

/// `1/g, 1/g^2, 1/g^3`
const STEPS: [f64; 3] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_3];

/// Samples the first output of a tape at `count` points of the cube of that side around the origin,
/// from point number `first` of the sequence on.
pub fn survey(tape: &Arc<Tape>, side: f64, first: usize, count: usize) -> Survey {
    let mut field = Evaluator::<Many<Dual, LANES>>::new(tape.clone());
    let mut found = Survey { values: Vec::with_capacity(count), slopes: Vec::with_capacity(count) };
    for start in (0..count).step_by(LANES) {
        let at = |axis: usize| {
            Many(std::array::from_fn(|lane| {
                let turns = (first + start + lane + 1) as f64 * STEPS[axis];
                Dual::coordinate(side * (turns - turns.floor() - 0.5), axis)
            }))
        };
        let Many(duals) = field.eval(&[at(0), at(1), at(2)]);
        for dual in duals.iter().take(count - start) {
            let [x, y, z] = dual.grad;
            found.values.push(dual.value);
            found.slopes.push(Real::sqrt(x * x + y * y + z * z));
        }
    }
    found
}

impl Moments {
    /// The shares of [`Moments::quantiles`].
    pub const SHARES: [f64; 7] = [0.001, 0.01, 0.1, 0.5, 0.9, 0.99, 0.999];

    /// Of samples; `None` if there are none.
    pub fn of(survey: &Survey) -> Option<Moments> {
        let Survey { values, slopes } = survey;
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n;
        let mut sorted = values.clone();
        sorted.sort_by(f64::total_cmp);
        // Between the two samples on either side of the share.
        let quantile = |share: f64| {
            let place = share * (n - 1.0);
            let low = place.floor();
            let [a, b] = [low, place.ceil()].map(|i| sorted[i as usize]);
            a + (place - low) * (b - a)
        };
        Some(Moments {
            samples: values.len(),
            mean,
            variance,
            min: *sorted.first()?,
            max: *sorted.last()?,
            quantiles: Moments::SHARES.map(quantile),
            gradient_rms: Real::sqrt(slopes.iter().map(|s| s * s).sum::<f64>() / n),
            steepest: slopes.iter().copied().fold(0.0, f64::max),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Graph;
    use crate::noise::{Kind, Noise};

    #[test]
    fn gradient_noise_has_its_published_moments() {
        let mut graph = Graph::default();
        let p = graph.point().unwrap();
        let root = graph.noise(Noise::new(Kind::ALL[0].plain(), 7), p).unwrap();
        let tape = Arc::new(Tape::new(&graph, &[root]));
        let m = Moments::of(&survey(&tape, 64.0, 0, 200_000)).unwrap();
        assert!(m.mean.abs() < 2e-3, "{m:?}");
        assert!((m.variance / 0.07292 - 1.0).abs() < 0.01, "{m:?}");
        assert!((m.gradient_rms / 1.220 - 1.0).abs() < 0.01, "{m:?}");
        assert!(m.steepest < 3.751 && m.min > -1.0364 && m.max < 1.0364);
        // Half of the absolute values lie below 0.195, 98 of 100 below 0.7.
        assert!(m.quantiles[3].abs() < 0.01 && (m.quantiles[4] - 0.36).abs() < 0.02, "{m:?}");
    }

    #[test]
    fn no_samples_have_no_moments() {
        assert!(Moments::of(&Survey::default()).is_none());
    }
}
