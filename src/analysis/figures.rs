//! The figures of an analysis: which there are, and how each is drawn.

use super::plot::{Axis, Curves, Figure, Line, Map, PlotError};
use super::{Analysis, Ring, covariance, decibels};

/// A figure of an analysis.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Plate {
    /// The noise on a plane.
    Sample,
    /// Autocovariance matrix along a line.
    Autocovariance,
    /// Power spectral density over the plane of wavenumbers.
    Spectrum,
    /// Radial power.
    Radial,
    /// Anisotropy.
    Anisotropy,
}

impl Plate {
    /// Every figure, in the order in which they are best looked at.
    pub const ALL: [Plate; 5] =
        [Plate::Sample, Plate::Autocovariance, Plate::Spectrum, Plate::Radial, Plate::Anisotropy];

    /// Its name, which is that of its file too.
    pub fn name(self) -> &'static str {
        match self {
            Plate::Sample => "sample",
            Plate::Autocovariance => "autocovariance",
            Plate::Spectrum => "spectrum",
            Plate::Radial => "radial",
            Plate::Anisotropy => "anisotropy",
        }
    }

    /// Draws the figure, `width` pixels wide, under the name of the noise.
    ///
    /// # Errors
    /// [`PlotError`]
    pub fn draw(self, found: &Analysis, noise: &str, width: u32) -> Result<Figure, PlotError> {
        match self {
            Plate::Sample => sample(found, noise).draw(width),
            Plate::Autocovariance => autocovariance(found, noise).draw(width),
            Plate::Spectrum => spectrum(found, noise, &levels(found)).draw(width),
            Plate::Radial => radial(found, noise).draw(width),
            Plate::Anisotropy => anisotropy(found, noise).draw(width),
        }
    }
}

/// Decibels from black to white in pictures of spectra: twice what is seen of a noise, so that the
/// copies of its spectrum that a lattice makes are seen as well.
const SHADES: f64 = 80.0;

fn sample<'a>(found: &'a Analysis, noise: &str) -> Map<'a> {
    let m = &found.moments;
    // One value in a thousand is allowed to be all black, and one all white.
    let (low, high) = (m.quantiles[0], m.quantiles[6]);
    Map {
        title: format!("{noise}: the plane z = 0"),
        labels: ["x", "y"],
        range: (0.0, f64::from(found.plan.side)),
        edge: found.plan.edge(),
        data: &found.sample,
        shades: widened(low, high),
        bar: "value",
    }
}

fn autocovariance<'a>(found: &'a Analysis, noise: &str) -> Map<'a> {
    let matrix = &found.covariance.matrix;
    let (low, high) =
        matrix.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (v.min(a), v.max(b)));
    Map {
        title: format!("{noise}: autocovariance along a line"),
        labels: ["x", "x′"],
        range: (0.0, covariance::SPAN as f64),
        edge: covariance::POINTS,
        data: matrix,
        shades: widened(low, high),
        bar: "C(x, x′)",
    }
}

/// The spectrum in decibels.
fn levels(found: &Analysis) -> Vec<f64> {
    found.spectrum.density.iter().map(|&g| decibels(g)).collect()
}

fn spectrum<'a>(found: &Analysis, noise: &str, levels: &'a [f64]) -> Map<'a> {
    let top = libm::ceil(found.verdict.band.peak_db / 10.0) * 10.0;
    let spectrum = &found.spectrum;
    Map {
        title: format!("{noise}: power spectral density{}", place(found)),
        labels: ["kx (1 / unit)", "ky (1 / unit)"],
        range: (-spectrum.nyquist(), spectrum.nyquist()),
        edge: spectrum.edge,
        data: levels,
        shades: (top - SHADES, top),
        bar: "dB",
    }
}

/// Where the spectrum was taken.
fn place(found: &Analysis) -> &'static str {
    if found.plan.solid { ", kz = 0" } else { "" }
}

fn radial(found: &Analysis, noise: &str) -> Curves {
    let rings = &found.radial.rings;
    let points = curve(rings, |r| decibels(r.power));
    let top = points.iter().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max);
    let bottom = points.iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
    let ten = |v: f64| libm::floor(v / 10.0) * 10.0;
    let mut lines = vec![Line { label: String::new(), points, guide: false }];
    if let Some(slope) = found.verdict.slope {
        // Through the middle of the range, in decibels.
        let (a, b) = (slope.from, slope.to);
        let middle = libm::sqrt(a * b);
        let level = |k: f64| found.radial.level(middle) - 10.0 * slope.beta * libm::log10(k / middle);
        let ends = [0.5 * a, 2.0 * b].map(|k| (k, level(k)));
        lines[0].label = "radial power".to_owned();
        lines.push(Line { label: format!("k^-{:.2}", slope.beta), points: ends.to_vec(), guide: true });
    }
    Curves {
        title: format!("{noise}: radial power{}", place(found)),
        x: wavenumbers(found),
        y: Axis {
            label: "P (dB)".to_owned(),
            range: (ten(bottom).max(ten(top) - 130.0), ten(top + 2.0) + 10.0),
            logarithmic: false,
        },
        lines,
    }
}

fn anisotropy(found: &Analysis, noise: &str) -> Curves {
    let points = curve(&found.radial.rings, |r| decibels(r.anisotropy));
    let floor = decibels(found.radial.floor);
    let x = wavenumbers(found);
    let across = vec![(x.range.0, floor), (x.range.1, floor)];
    let top = points.iter().map(|p| p.1).fold(0.0, f64::max);
    let legend = format!("{:.0} dB: isotropic, {} realisations", floor, found.realisations);
    Curves {
        title: format!("{noise}: anisotropy{}", place(found)),
        x,
        y: Axis {
            label: "A (dB)".to_owned(),
            range: (libm::floor(floor / 10.0 - 0.5) * 10.0, libm::ceil(top / 5.0 + 0.2) * 5.0),
            logarithmic: false,
        },
        lines: vec![
            Line { label: String::new(), points, guide: false },
            Line { label: legend, points: across, guide: true },
        ],
    }
}

fn curve(rings: &[Ring], of: impl Fn(&Ring) -> f64) -> Vec<(f64, f64)> {
    rings.iter().filter(|r| r.count > 0).map(|r| (r.k, of(r))).collect()
}

/// Sums of octaves span factors, single noises do not.
fn wavenumbers(found: &Analysis) -> Axis {
    let logarithmic = found.verdict.slope.is_some();
    let rings = &found.radial.rings;
    let first = rings.first().map_or(0.1, |r| r.k);
    Axis {
        label: "k (1 / unit)".to_owned(),
        range: (if logarithmic { first } else { 0.0 }, found.spectrum.nyquist()),
        logarithmic,
    }
}

/// A range that is not empty.
fn widened(low: f64, high: f64) -> (f64, f64) {
    if high > low { (low, high) } else { (low - 0.5, low + 0.5) }
}
