//! What the figures say, in words.

use super::{Covariance, Radial, Ring, decibels};
use crate::field::Moments;
use serde::Serialize;

/// Stationary or not, isotropic or not, and where the power is.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    /// Why some of this is left open, if it is.
    pub doubt: Option<Doubt>,
    /// Whether the covariance along a line depends on distance alone, as far as the lines can tell;
    /// `None` in doubt.
    pub stationary: Option<bool>,
    /// Whether the spectrum has no preferred direction in the band where the power is; `None` in
    /// doubt.
    pub isotropic: Option<bool>,
    /// The wavenumber up to which it has none; `None` where it never has.
    pub isotropic_to: Option<f64>,
    /// Where the power is: of what was sampled, which says nothing of the noise if it did not vary or
    /// was not resolved.
    pub band: Band,
    /// The power law of a sum of octaves, if there is one.
    pub slope: Option<Slope>,
    /// Whether power was left beyond what the samples resolve: then it has been folded back, and
    /// the high end of the spectrum is wrong.
    pub aliased: bool,
}

/// Why samples do not tell what a field is like.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, thiserror::Error)]
#[serde(rename_all = "lowercase")]
pub enum Doubt {
    /// Averages over so few realisations are mostly chance.
    #[error("it takes at least {ENOUGH} realisations to tell")]
    Few,
    /// There is nothing to correlate.
    #[error("it is the same at all samples of the plane z = 0")]
    Constant,
    /// All power is beyond the highest wavenumber, and came back as noise of another kind.
    #[error("it varies too fast for the samples")]
    Aliased,
}

/// Where the power of a spectrum is, in cycles a unit of length.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Band {
    /// Wavenumber of the highest radial power.
    pub peak: f64,
    /// Radial power there in dB.
    pub peak_db: f64,
    /// Lower wavenumber of half the power; `None` for a low-pass noise.
    pub half_low: Option<f64>,
    /// Upper wavenumber of half the power.
    pub half_high: Option<f64>,
    /// Upper wavenumber of a hundredth of the power: the -20 dB edge.
    pub edge: Option<f64>,
}

/// `P ~ k^-beta` over a range of wavenumbers.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Slope {
    /// The exponent.
    pub beta: f64,
    /// From this wavenumber.
    pub from: f64,
    /// To this one.
    pub to: f64,
    /// Root mean square deviation from the power law in dB.
    pub residual_db: f64,
}

/// Realisations from which on chance does not decide.
const ENOUGH: usize = 20;
/// Decibels below the peak that the highest wavenumbers of a spectrum are at least, if it shows the
/// band of a field at all.
const FALL: f64 = 6.0;
/// How many times the statistical floor a score of non-stationarity may be.
const TOLERANCE: f64 = 1.5;
/// Decibels above its floor that the anisotropy of an isotropic field may be.
const MARGIN: f64 = 2.0;
/// Decibels below the peak at which the band ends in which isotropy is judged.
const DEPTH: f64 = 30.0;

impl Verdict {
    /// Of what was measured, for a field with octaves between two frequencies.
    pub fn of(covariance: &Covariance, radial: &Radial, moments: &Moments, octaves: (f64, f64)) -> Verdict {
        let band = Band::of(radial);
        let end = radial.rings.iter().rposition(|r| decibels(r.power_about_mean) >= band.peak_db - DEPTH);
        let end = end.map_or(0, |e| e + 1);
        let odd: Vec<bool> = (0..end).map(|i| is_directed(radial, i)).collect();
        // One ring out of many may be odd by chance; two neighbours are not.
        let first = odd.windows(2).position(|pair| pair == [true, true]);
        let isotropic_to = match first {
            None => radial.rings.get(end.saturating_sub(1)).map(|r| r.k),
            Some(i) => i.checked_sub(1).map(|i| radial.rings[i].k),
        };
        let top = radial.rings.last().map_or(f64::NEG_INFINITY, |r| decibels(r.power_about_mean));
        let nyquist = radial.rings.last().map_or(0.0, |r| r.k);
        // Noises have their power at half a cycle a cell, or not far from it.
        let fast = 0.5 * octaves.0 > nyquist || top > band.peak_db - FALL;
        let doubt = doubt(covariance, radial, moments, fast);
        let known = |answer: bool| doubt.is_none().then_some(answer);
        Verdict {
            doubt,
            stationary: known(covariance.score <= TOLERANCE * covariance.floor),
            isotropic: known(first.is_none()),
            isotropic_to: isotropic_to.filter(|_| doubt.is_none()),
            slope: slope(radial, octaves).filter(|_| matches!(doubt, None | Some(Doubt::Few))),
            aliased: top > band.peak_db - 40.0,
            band,
        }
    }

    /// One line for each finding.
    pub fn lines(&self, covariance: &Covariance, radial: &Radial) -> Vec<(&'static str, String)> {
        let undecided = || self.doubt.map_or("undecided".to_owned(), |why| format!("undecided: {why}"));
        let stationary = self.stationary.map_or_else(undecided, |yes| {
            let answer = if yes { "yes" } else { "no" };
            format!("{answer} (score {:.3}; {:.3} by chance)", covariance.score, covariance.floor)
        });
        let isotropic = match (self.isotropic, self.isotropic_to) {
            (None, _) => undecided(),
            (Some(true), _) => {
                format!("yes, within {MARGIN} dB of the floor of {:.1} dB", decibels(radial.floor))
            }
            (Some(false), Some(k)) => format!("up to {k:.2} cycles a unit, not above"),
            (Some(false), None) => "no".to_owned(),
        };
        let band = match self.doubt {
            None => self.band.text(),
            Some(Doubt::Few) => format!("roughly {}", self.band.text()),
            Some(_) => undecided(),
        };
        let mut lines = vec![("stationary", stationary), ("isotropic", isotropic), ("band", band)];
        if let Some(Slope { beta, from, to, residual_db }) = self.slope {
            let text = format!("P ~ k^-{beta:.2} from {from:.2} to {to:.2} ({residual_db:.1} dB rms off)");
            lines.push(("power law", text));
        }
        lines
    }
}

/// What speaks against a verdict, of a field that may be known to vary too fast.
fn doubt(covariance: &Covariance, radial: &Radial, moments: &Moments, fast: bool) -> Option<Doubt> {
    let size = moments.mean * moments.mean + moments.variance;
    // Rounding makes a variance too.
    let varies = |variance: f64| variance > 1e-20 * size && variance > 0.0;
    // Along lines, apart from what differs between realisations alone.
    let all = covariance.by_distance[0];
    let still = covariance.by_distance.iter().all(|c| (all - c).abs() <= 1e-12 * all);
    match () {
        () if !varies(moments.variance) => Some(Doubt::Constant),
        () if fast => Some(Doubt::Aliased),
        () if !varies(all) || still => Some(Doubt::Constant),
        () if radial.floor > 1.0 / ENOUGH as f64 => Some(Doubt::Few),
        () => None,
    }
}

impl Band {
    fn of(radial: &Radial) -> Band {
        let levels: Vec<f64> = radial.rings.iter().map(|r| decibels(r.power_about_mean)).collect();
        let top = (0..levels.len()).fold(0, |best, i| if levels[i] > levels[best] { i } else { best });
        let level = |i: usize| levels.get(i).copied().unwrap_or(f64::NEG_INFINITY);
        let k = |i: usize| radial.rings.get(i).map_or(0.0, |r| r.k);
        // Where a straight line between two rings passes a level.
        let pass = |below: usize, above: usize, at: f64| {
            k(below) + (k(above) - k(below)) * (at - level(below)) / (level(above) - level(below))
        };
        let peak_db = level(top);
        let half = peak_db - decibels(2.0);
        let low = (0..top).rev().find(|&i| level(i) < half).map(|i| pass(i, i + 1, half));
        let high = (top..levels.len()).find(|&i| level(i) < half).map(|i| pass(i, i - 1, half));
        let last = levels.iter().rposition(|&l| l >= peak_db - 20.0);
        let edge = last.filter(|&i| i + 1 < levels.len()).map(|i| pass(i + 1, i, peak_db - 20.0));
        Band { peak: k(top), peak_db, half_low: low, half_high: high, edge }
    }

    fn text(&self) -> String {
        let number = |k: Option<f64>| k.map_or("beyond what was resolved".to_owned(), |k| format!("{k:.2}"));
        let half = match self.half_low {
            Some(low) => format!("band-pass, half power {low:.2} to {}", number(self.half_high)),
            None => format!("low-pass, half power at {}", number(self.half_high)),
        };
        format!("{half}; peak {:.1} dB at {:.2}; -20 dB at {}", self.peak_db, self.peak, number(self.edge))
    }
}

/// Whether the densities of a ring differ by more than chance and the trend across the ring explain.
fn is_directed(radial: &Radial, i: usize) -> bool {
    let ring = &radial.rings[i];
    let level = |r: &Ring| decibels(r.power_about_mean);
    // Around a zero of the spectrum no curve through the means follows what happens within a ring.
    let near = |range: std::ops::Range<usize>| radial.rings.get(range).into_iter().flatten();
    let before = near(i.saturating_sub(3)..i).map(level).fold(f64::NEG_INFINITY, f64::max);
    let after = near(i + 1..(i + 4).min(radial.rings.len())).map(level).fold(f64::NEG_INFINITY, f64::max);
    if level(ring) < before.min(after) - 3.0 {
        return false;
    }
    // A variance estimated from few numbers scatters by its own share; opposite ones are the same.
    let chance = 1.0 + 3.0 * libm::sqrt(4.0 / ring.count.max(1) as f64);
    ring.about_trend > radial.floor * libm::pow(10.0, MARGIN / 10.0) * chance
}

/// The power law between the peaks of the second octave and the last, which lie at about half a
/// cycle a cell.
fn slope(radial: &Radial, (coarse, fine): (f64, f64)) -> Option<Slope> {
    let nyquist = radial.rings.last()?.k;
    let (from, to) = (coarse, (0.5 * fine).min(0.5 * nyquist));
    if to < 2.0 * from {
        return None;
    }
    let (beta, residual_db) = radial.slope(from, to)?;
    Some(Slope { beta, from, to, residual_db })
}
