//! What a noise is as a random field: its moments, its covariance, its spectrum, and what follows.
//!
//! A random field is *stationary* if its statistics are the same at every point, and *isotropic* if
//! they are the same in every direction. Neither can be seen in one picture, but both can in averages
//! over many realisations (an [`Ensemble`]; a hundred by default):
//!
//! - The **autocovariance** `C(x, x') = E[(f(x) - E f(x)) (f(x') - E f(x'))]` along a line ([`covariance`])
//!   depends on `x - x'` alone if the field is stationary. As a matrix it then has constant diagonals.
//! - The **power spectral density** `G(k) = E |F(k)|^2 / area` says how the variance is spread over
//!   wavenumbers ([`spectrum`]). It is given in decibels, `10 log10 G`, of white noise of unit density.
//! - Averages of `G` over rings `|k| = const`, and the variance of `G` within a ring relative to its
//!   mean squared, are the **radial power** and the **anisotropy** ([`radial`]); peak, band, slope and
//!   the [`verdict`]s are read off them (Lagae et al. 2010; Gamito 2009, 4.2).
//!
//! The plane that is looked at is `z = 0`. The spectrum of a plane of a solid field is not a plane of
//! the solid's spectrum: it sums up all wavenumbers across the plane, and zeros fill up. With
//! [`Plan::solid`] the field is integrated across the plane first, which by the projection-slice
//! theorem gives the plane `k_z = 0` of the spectrum in space.
//!
//! Everything is computed on all threads, and comes out the same bit for bit on any number of them:
//! sums over realisations are taken in their order.

pub mod covariance;
mod figures;
pub mod plot;
pub mod radial;
mod run;
pub mod spectrum;
mod sphere;
#[cfg(test)]
mod tests;
pub mod verdict;

pub use covariance::Covariance;
pub use figures::Plate;
pub use radial::{Radial, Ring};
pub use run::analyse;
pub use spectrum::Spectrum;
pub use sphere::Sphere;
pub use verdict::{Doubt, Verdict};

use crate::field::Moments;
#[cfg(doc)]
use crate::scene::Ensemble;
use serde::Serialize;
use std::sync::atomic::AtomicBool;

/// How much is looked at, and how closely.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// Side of the square (or cube) in units of length: a power of two.
    pub side: u32,
    /// Samples to a unit of length: a power of two.
    pub samples: u32,
    /// Whether the spectrum is that in space, not that of a plane.
    pub solid: bool,
}

impl Default for Plan {
    fn default() -> Self {
        Plan { side: 32, samples: 16, solid: false }
    }
}

impl Plan {
    /// Most samples that a realisation may have.
    pub const MAX_SAMPLES: u64 = 1 << 26;

    /// Samples along an edge.
    pub fn edge(&self) -> usize {
        (self.side * self.samples) as usize
    }

    /// Whether such an analysis can be made.
    ///
    /// # Errors
    /// [`Refusal::Power`] or [`Refusal::Large`].
    pub fn validate(&self) -> Result<(), Refusal> {
        for (what, value) in [("cells", self.side), ("samples", self.samples)] {
            if !value.is_power_of_two() || !(2..=4096).contains(&value) {
                return Err(Refusal::Power { what, value });
            }
        }
        let (edge, layers) = (u64::from(self.side) * u64::from(self.samples), if self.solid { 3 } else { 2 });
        let count = (0..layers).try_fold(1_u64, |n, _| n.checked_mul(edge));
        match count.filter(|&n| n <= Plan::MAX_SAMPLES) {
            Some(_) => Ok(()),
            None => Err(Refusal::Large { edge, layers }),
        }
    }
}

/// Why there is no analysis.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
pub enum Refusal {
    /// The transform works on powers of two.
    #[error("the number of {what} is {value}, but must be a power of two from 2 to 4096")]
    Power {
        /// Which number.
        what: &'static str,
        /// What it is.
        value: u32,
    },
    /// Too many samples.
    #[error("{edge}^{layers} samples a realisation are more than memory should be asked for")]
    Large {
        /// Samples along an edge.
        edge: u64,
        /// Dimensions.
        layers: u32,
    },
    /// There is nothing to average over.
    #[error("an analysis needs at least two realisations")]
    Few,
    /// The field has no value somewhere.
    #[error("realisation {0} is infinite or not a number at some of its points")]
    Undefined(usize),
    /// Somebody raised the flag.
    #[error("stopped")]
    Cancelled,
}

/// Who watches an analysis, and can stop it.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    /// Set it to stop soon.
    pub cancel: &'a AtomicBool,
    /// Told the share that is done, from any thread.
    pub progress: &'a (dyn Fn(f64) + Sync),
}

impl std::fmt::Debug for Watch<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Watch").field("cancel", self.cancel).finish_non_exhaustive()
    }
}

impl<'a> Watch<'a> {
    /// Nobody watches.
    pub fn unwatched(cancel: &'a AtomicBool) -> Self {
        Watch { cancel, progress: &|_| () }
    }
}

/// Everything that was found.
#[derive(Clone, Debug, Serialize)]
pub struct Analysis {
    /// What was looked at.
    pub plan: Plan,
    /// Number of realisations.
    pub realisations: usize,
    /// Whether the field was made to repeat; otherwise its edges were tapered.
    pub periodic: bool,
    /// Moments over space and realisations.
    pub moments: Moments,
    /// Standard error of the mean, from how the realisations differ.
    pub mean_error: f64,
    /// Standard error of the variance.
    pub variance_error: f64,
    /// Along a line.
    pub covariance: Covariance,
    /// Over a plane; only the numbers of its picture, which are many, are left out of the JSON.
    #[serde(skip)]
    pub spectrum: Spectrum,
    /// Over rings.
    pub radial: Radial,
    /// What it all says.
    pub verdict: Verdict,
    /// The plane of the first realisation, row by row from the least y on.
    #[serde(skip)]
    pub sample: Vec<f64>,
}

/// `10 log10`, with a floor far below what is ever of interest.
pub fn decibels(power: f64) -> f64 {
    10.0 * libm::log10(power.max(1e-30))
}
