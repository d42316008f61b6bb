//! What the signals of a noise are on average.
//!
//! Octaves that are too fine for a pixel fade to their mean, so that distant relief keeps its height.
//! The mean of a folded signal differs from noise to noise and has no closed form for most, so it is
//! taken from a sample that is the same on every machine: points in thousands of lattice cells, by
//! an additive recurrence with irrational steps, which fills the cells evenly. No bound depends on
//! it: a fractal with another mean would differ in the distance only.

use super::batches::BATCH;
use super::model::Signal;
use super::{Kind, Lattice};
use crate::num::Jets;
use std::collections::HashMap;
use std::sync::{Mutex, OnceLock, PoisonError};

/// Points of the sample.
const POINTS: usize = 8192;

/// Steps between successive points, in cells: irrational (powers of the root of `x^4 = x + 1`, whose
/// recurrence is the most even one known in three dimensions), and long enough for new cells.
const STEP: [f64; 3] = [16.819_172_513_396_164, 16.671_043_606_703_79, 16.549_700_477_901_97];

/// Kinds of noise whose means are remembered.
const REMEMBERED: usize = 256;

/// The mean of a signal of a noise. One that the sample cannot tell from zero is zero.
pub(super) fn mean(kind: &Kind, signal: Signal) -> f64 {
    static KNOWN: OnceLock<Mutex<HashMap<Kind, [f64; 3]>>> = OnceLock::new();
    let known = KNOWN.get_or_init(Mutex::default);
    let found = known.lock().unwrap_or_else(PoisonError::into_inner).get(kind).copied();
    let means = found.unwrap_or_else(|| {
        let means = sample(kind);
        let mut known = known.lock().unwrap_or_else(PoisonError::into_inner);
        if known.len() >= REMEMBERED {
            known.clear();
        }
        known.insert(*kind, means);
        means
    });
    means[signal as usize]
}

/// Means of the three signals over the sample.
fn sample(kind: &Kind) -> [f64; 3] {
    let (mut sums, mut squares) = ([0.0; 3], 0.0);
    for start in (0..POINTS).step_by(BATCH) {
        let at = STEP.map(|step| std::array::from_fn::<f64, BATCH, _>(|i| (start + i) as f64 * step));
        // Another seed for each batch: a noise of few waves is not all of itself in any one of them.
        let lattice = Lattice::new((start / BATCH) as u64);
        let mut value = [0.0; BATCH];
        kind.jets(
            &lattice,
            at.each_ref().map(|at| &at[..]),
            Jets { value: &mut value, grad: None, hess: None },
        );
        for noise in value {
            squares += noise * noise;
            for (sum, signal) in sums.iter_mut().zip(Signal::ALL) {
                let mut value = noise;
                signal.apply(&mut value);
                *sum += value;
            }
        }
    }
    let count = POINTS as f64;
    let mut means = sums.map(|sum| sum / count);
    // The deviation of the mean of a sample of a field with mean zero.
    if means[0].abs() < 4.0 * (squares / count / count).sqrt() {
        means[0] = 0.0;
    }
    means
}
