//! Power spectral density over a plane of wavenumbers.
//!
//! `n x n` samples of a realisation, a distance `h` apart, have the discrete transform `F`, and with
//! `A = (n h)^2` the density at the wavenumbers `k = i / (n h)` is
//!
//! ```text
//! G(k) = E |h^2 F(k)|^2 / A           white noise of unit density has G = 1, which is 0 dB
//! ```
//!
//! (in space `h^3` and the volume). Two realisations are transformed at once, as real and imaginary
//! part `Z`: the sum of their powers is `(|Z(k)|^2 + |Z(-k)|^2) / 2`, since what mixes them cancels.
//!
//! **Edges.** A field that repeats after the side of the square has no edges. Any other one is
//! multiplied by a Hann window along each axis, `1 - cos(2 pi x / side)` up to scale, whose mean
//! square is divided out: otherwise the jump from one edge to the other would put a cross into the
//! picture that is no property of the field. The mean is taken off before and its power put back at
//! zero after, so that a window does not smear it.

use crate::num::{Complex, Direction, Unfit, transform};
use std::f64::consts::TAU;

/// A power spectral density, zero frequency in the middle.
#[derive(Clone, Debug)]
pub struct Spectrum {
    /// Wavenumbers along an edge, a power of two.
    pub edge: usize,
    /// Distance of two wavenumbers.
    pub step: f64,
    /// Densities, row by row from the most negative `k_y` on.
    pub density: Vec<f64>,
    /// Power density at zero that comes from the mean of the field.
    pub mean_power: f64,
}

impl Spectrum {
    /// The wavenumber of a place along an edge.
    pub fn wavenumber(&self, place: usize) -> f64 {
        (place as f64 - (self.edge / 2) as f64) * self.step
    }

    /// The highest wavenumber that the samples resolve.
    pub fn nyquist(&self) -> f64 {
        self.step * (self.edge / 2) as f64
    }
}

/// The weights of a Hann window, of mean square 1; all 1 for a field without edges.
pub(super) fn window(edge: usize, periodic: bool) -> Vec<f64> {
    if periodic {
        return vec![1.0; edge];
    }
    let scale = libm::sqrt(2.0 / 3.0);
    (0..edge).map(|i| scale * (1.0 - libm::cos(TAU * (i as f64 + 0.5) / edge as f64))).collect()
}

/// `|Z(k)|^2 + |Z(-k)|^2` over 2, zero frequency in the middle, of two realisations.
pub(super) fn power(first: &[f64], second: Option<&[f64]>, edge: usize) -> Result<Vec<f64>, Unfit> {
    let other = |i: usize| second.map_or(0.0, |s| s[i]);
    let mut z: Vec<Complex> = first.iter().enumerate().map(|(i, &re)| Complex { re, im: other(i) }).collect();
    transform(&mut z, [edge, edge, 1], Direction::Forward)?;
    let mask = edge - 1;
    let shifted = |i: usize| (i + edge / 2) & mask;
    let mut out = vec![0.0; edge * edge];
    for y in 0..edge {
        for x in 0..edge {
            let mirrored = ((edge - y) & mask) * edge + ((edge - x) & mask);
            let sum = z[y * edge + x].norm_squared() + z[mirrored].norm_squared();
            out[shifted(y) * edge + shifted(x)] = 0.5 * sum;
        }
    }
    Ok(out)
}
