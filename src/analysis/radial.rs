//! Averages of a spectrum over rings: radial power and anisotropy.
//!
//! A ring holds the wavenumbers `k <= |k| < k + dk`, with `dk` two steps of the spectrum (1/16 for a
//! side of 32). With `<>` for the mean over a ring,
//!
//! ```text
//! P = <G>          A = <(G - P)^2> / P^2
//! ```
//!
//! **Floor.** Each `G` is an average over `N` realisations of a power that scatters like its own mean
//! (it is exponentially distributed for a Gaussian field), so even a perfectly isotropic field shows
//! `A = 1/N`: -20 dB for a hundred realisations.
//!
//! **What is not anisotropy.** `G` also varies across the width of a ring, most of all where it has a
//! zero, and there `A` rises towards 0 dB without any preference of direction. The curve shows `A`
//! as it is defined; what is judged is [`Ring::about_trend`], in which `G` is first divided by a
//! curve through the ring means.

use super::{Spectrum, decibels};
use serde::Serialize;

/// The wavenumbers of a ring.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Ring {
    /// Their mean absolute value.
    pub k: f64,
    /// How many.
    pub count: usize,
    /// Mean density, `P`; that of the mean of the field is part of the first ring.
    pub power: f64,
    /// The same without it.
    pub power_about_mean: f64,
    /// `A`, without the mean of the field.
    pub anisotropy: f64,
    /// The same about the trend across the ring.
    pub about_trend: f64,
}

/// Rings up to the highest wavenumber that the samples resolve.
#[derive(Clone, Debug, Serialize)]
pub struct Radial {
    /// From the middle outwards.
    pub rings: Vec<Ring>,
    /// What `A` is for an isotropic field: one over the number of realisations.
    pub floor: f64,
}

impl Radial {
    /// Of a spectrum that averages `realisations`.
    pub fn of(spectrum: &Spectrum, realisations: usize) -> Radial {
        let rings = spectrum.edge / 4;
        let mut bins: Vec<Vec<(f64, f64)>> = vec![Vec::new(); rings];
        let centre = (spectrum.edge / 2) as f64;
        for (i, &density) in spectrum.density.iter().enumerate() {
            let (x, y) = ((i % spectrum.edge) as f64 - centre, (i / spectrum.edge) as f64 - centre);
            let radius = libm::sqrt(x * x + y * y);
            if let Some(bin) = bins.get_mut((radius / 2.0) as usize) {
                // Without the mean of the field, which is not of the continuous spectrum.
                let density = if radius == 0.0 { density - spectrum.mean_power } else { density };
                bin.push((radius * spectrum.step, density));
            }
        }
        let mut rings: Vec<Ring> = bins.iter().map(|bin| ring(bin)).collect();
        let trend = Trend::new(&rings);
        for (ring, bin) in rings.iter_mut().zip(&bins) {
            let about: Vec<(f64, f64)> =
                bin.iter().map(|&(k, g)| (k, g / trend.at(k).max(f64::MIN_POSITIVE))).collect();
            ring.about_trend = self::ring(&about).anisotropy;
        }
        if let Some(first) = rings.first_mut() {
            first.power += spectrum.mean_power / first.count.max(1) as f64;
        }
        Radial { rings, floor: 1.0 / realisations.max(1) as f64 }
    }

    /// Radial power about the mean, at any wavenumber, in decibels.
    pub fn level(&self, k: f64) -> f64 {
        decibels(Trend::new(&self.rings).at(k))
    }

    /// The exponent `beta` of `P ~ k^-beta` from one wavenumber to another, by least squares through
    /// logarithms, each octave counting the same; and the root mean square of what is left, in dB.
    pub fn slope(&self, from: f64, to: f64) -> Option<(f64, f64)> {
        let points: Vec<(f64, f64)> = self
            .rings
            .iter()
            .filter(|r| (from..=to).contains(&r.k) && r.power_about_mean > 0.0)
            .map(|r| (libm::log10(r.k), decibels(r.power_about_mean)))
            .collect();
        if points.len() < 4 {
            return None;
        }
        // Rings are evenly spaced in k, so an octave higher up has twice as many.
        let weight = |x: f64| libm::pow(10.0, -x);
        let total: f64 = points.iter().map(|p| weight(p.0)).sum();
        let mean =
            |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(|p| weight(p.0) * f(p)).sum::<f64>() / total;
        let (mx, my) = (mean(&|p| p.0), mean(&|p| p.1));
        let rise = mean(&|p| (p.0 - mx) * (p.1 - my)) / mean(&|p| (p.0 - mx) * (p.0 - mx));
        let rest = mean(&|p| {
            let r = p.1 - my - rise * (p.0 - mx);
            r * r
        });
        Some((-rise / 10.0, libm::sqrt(rest)))
    }
}

/// Mean and relative variance of the densities of a ring.
fn ring(bin: &[(f64, f64)]) -> Ring {
    let n = bin.len().max(1) as f64;
    let k = bin.iter().map(|b| b.0).sum::<f64>() / n;
    let power = bin.iter().map(|b| b.1).sum::<f64>() / n;
    // Zero frequency has no direction, so it says nothing of anisotropy.
    let others: Vec<f64> = bin.iter().filter(|b| b.0 > 0.0).map(|b| b.1).collect();
    let m = others.len().max(1) as f64;
    let mean = others.iter().sum::<f64>() / m;
    let variance = others.iter().map(|g| (g - mean) * (g - mean)).sum::<f64>() / m;
    let anisotropy = variance / (mean * mean).max(f64::MIN_POSITIVE);
    Ring { k, count: bin.len(), power, power_about_mean: power, anisotropy, about_trend: 0.0 }
}

/// A curve through the means of the rings, straight between them in decibels.
struct Trend {
    points: Vec<(f64, f64)>,
}

impl Trend {
    fn new(rings: &[Ring]) -> Trend {
        Trend { points: rings.iter().map(|r| (r.k, decibels(r.power_about_mean))).collect() }
    }

    fn at(&self, k: f64) -> f64 {
        let next = self.points.partition_point(|p| p.0 < k).clamp(1, self.points.len().max(2) - 1);
        let level = match (self.points.get(next - 1), self.points.get(next)) {
            (Some(a), Some(b)) if b.0 > a.0 => a.1 + (b.1 - a.1) * (k - a.0) / (b.0 - a.0),
            (Some(a), _) => a.1,
            _ => 0.0,
        };
        libm::pow(10.0, level / 10.0)
    }
}
