//! From a scene to maps of heights: how far its outermost surface is above a sphere, in every direction, or above a level
//! plane.
//!
//! ```text
//! pixel --chart--> ray --sounding--> height --> band of rows --> encoder --> file
//! ```
//!
//! A map may be larger than memory, so heights are measured, encoded and forgotten band by band. An EXR holds them as
//! they are, in the units of the script. A PNG holds shares of a range; where the range is not given, it is from the
//! lowest height to the highest, which are known when all are measured: then heights wait in a file without a name
//! until they are. All files of a map are on the disk before the first of them appears.

mod chart;
mod sounding;

pub use chart::{Chart, Projection};
pub use sounding::Tally;

use super::stage;
use super::topology::Sieve;
use crate::diag::Diagnostic;
use crate::exchange::image::{self, Rows, Sheet};
use crate::field::Watch;
use crate::render::Format;
use crate::scene::Scene;
use crate::world::atomic::{self, FileSet, WriteError};
use crate::world::scratch::{Kept, Scratch};
use glam::DVec3;
use sounding::Sounder;
use std::io;
use std::path::Path;
use std::sync::atomic::Ordering;

/// What heights are measured from.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Datum {
    /// A sphere.
    Globe {
        /// Its centre; rays run towards it.
        center: DVec3,
        /// Its radius, where heights are zero.
        radius: f64,
    },
    /// A level rectangle; rays run straight down.
    Plane {
        /// Its middle, where heights are zero.
        center: DVec3,
        /// How far it reaches along z, which is the height of the picture.
        depth: f64,
    },
}

/// What a map is to be like.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Mapping {
    /// Its projection and size.
    pub chart: Chart,
    /// What heights are measured from.
    pub datum: Datum,
    /// Heights that are black and white in a PNG; the lowest and the highest there are where it is `None`.
    pub range: Option<(f64, f64)>,
}

/// A map that is written.
#[derive(Clone, Debug)]
pub struct Mapped {
    /// What was found.
    pub tally: Tally,
    /// All heights lie between these two numbers, which are short, give or take the precision of casting.
    pub heights: (f64, f64),
    /// Heights that are black and white, in a PNG.
    pub range: Option<(f64, f64)>,
    /// Pixels of which the height is beyond them.
    pub beyond: u64,
    /// What is not proven about what the scene keeps of its solid.
    pub warnings: Vec<Diagnostic>,
}

/// Share of the work that it is to find out what is kept, about.
const CORRECTION: f64 = 0.5;

/// Steps of grey in a PNG, from black to white.
const STEPS: f64 = 65535.0;

/// Measures a map and writes it to the [files](Chart::files) of `path`, in the format of its ending.
///
/// # Errors
/// A diagnostic if there is nothing to be measured, a file cannot be written, or the job was stopped; then no
/// file has changed.
pub fn map_heights(
    scene: &Scene,
    mapping: &Mapping,
    path: &Path,
    watch: &Watch<'_>,
) -> Result<Mapped, Box<Diagnostic>> {
    let failed = |error: String| Box::new(Diagnostic::error(error));
    let format = Format::of(path).map_err(|e| failed(e.to_string()))?;
    for file in mapping.chart.files(path) {
        atomic::check(&file).map_err(|e| failed(e.to_string()))?;
    }
    let begun = if scene.surface.keep.is_some() { CORRECTION } else { 0.0 };
    let sieve = watch.part(0.0, begun, |watch| Sieve::of(scene, scene, watch))?;
    let what = (mapping.chart, mapping.datum);
    let mut sounder = Sounder::new(scene, sieve.as_ref(), what, watch.cancel)?;
    let written = watch.part(begun, 1.0, |watch| measure(&mut sounder, mapping, path, format, watch));
    if watch.cancel.load(Ordering::Relaxed) {
        return Err(stage::stopped());
    }
    let (files, range, beyond) = written.map_err(|e| failed(e.to_string()))?;
    let tally = sounder.tally();
    if tally.missed == mapping.chart.pixels() {
        let error = Diagnostic::error("no ray met a solid, so no file was written");
        let where_from = match mapping.datum {
            Datum::Globe { .. } => "the centre",
            Datum::Plane { .. } => "the extent and the centre",
        };
        return Err(Box::new(
            error.hint(format!("check the sign of the field (negative is inside), and {where_from}")),
        ));
    }
    files.commit().map_err(|e| failed(e.to_string()))?;
    let warnings = sieve.map_or_else(Vec::new, |sieve| sieve.warnings());
    Ok(Mapped { tally, heights: rounded(&tally, sounder.precision()), range, beyond, warnings })
}

/// Measures a map and encodes it; where its range is still unknown, heights are kept in between.
fn measure(
    sounder: &mut Sounder,
    mapping: &Mapping,
    path: &Path,
    format: Format,
    watch: &Watch<'_>,
) -> Result<Encoded, WriteError> {
    if format == Format::OpenExr || mapping.range.is_some() {
        return encode(mapping, path, format, &mut |rows| sounder.next(rows, watch));
    }
    let mut kept = keep(sounder, mapping, path, watch)?;
    let (black, white) = rounded(&sounder.tally(), sounder.precision());
    // The rounding of a sphere is not to be blown up to hills.
    let least = libm::exp10(libm::log10(sounder.precision() * 4.0 * STEPS).ceil());
    let range = Some((black, white.max(black + least)));
    encode(&Mapping { range, ..*mapping }, path, format, &mut |rows| {
        go_on(watch)?;
        kept.next(rows)
    })
}

/// An error once the job is to stop.
fn go_on(watch: &Watch<'_>) -> io::Result<()> {
    if watch.cancel.load(Ordering::Relaxed) { Err(io::Error::other("stopped")) } else { Ok(()) }
}

/// Measures all heights, and keeps them.
fn keep(
    sounder: &mut Sounder,
    mapping: &Mapping,
    path: &Path,
    watch: &Watch<'_>,
) -> Result<Kept, WriteError> {
    let mut scratch = Scratch::beside(path)?;
    let face = Sheet { width: mapping.chart.width(), height: mapping.chart.size, notes: &[] };
    for _ in 0..mapping.chart.faces() {
        face.bands(&mut |rows| sounder.next(rows, watch), |_, rows| scratch.push(rows))
            .map_err(|source| WriteError::Other { path: path.to_owned(), source })?;
    }
    scratch.finish()
}

/// The lowest and the highest height, rounded outward to about a hundred-thousandth of what is between them;
/// what is less than the precision counts as nothing.
fn rounded(tally: &Tally, precision: f64) -> (f64, f64) {
    let (lowest, highest) = (tally.lowest + precision, tally.highest - precision);
    let digits = 5.0 - libm::log10((highest - lowest).max(precision * 1e6)).floor();
    // Divided by powers of ten, numbers are the ones that are next to short decimal ones.
    let scale = libm::exp10(digits);
    // Adding zero takes the sign from a zero.
    ((lowest * scale).floor() / scale + 0.0, (highest * scale).ceil() / scale + 0.0)
}

/// Files that are written but not in place yet, the range of a PNG, and how many heights are beyond it.
type Encoded = (FileSet, Option<(f64, f64)>, u64);

/// Writes heights to the files of a map.
fn encode(mapping: &Mapping, path: &Path, format: Format, rows: Rows<'_>) -> Result<Encoded, WriteError> {
    // A PNG has a range by now.
    let range = mapping.range.filter(|_| format == Format::Png);
    let notes = notes(mapping, range);
    let sheet = Sheet { width: mapping.chart.width(), height: mapping.chart.size, notes: &notes };
    let (mut files, mut beyond) = (FileSet::default(), 0);
    for file in mapping.chart.files(path) {
        files.add(&file, |out| match range {
            None => image::write_exr(&sheet, out, rows),
            Some((black, white)) => image::write_png(&sheet, out, &mut |band| {
                rows(band)?;
                for height in band {
                    let share = (*height - black) / (white - black);
                    // By more than is rounded anyway.
                    beyond += u64::from(share * STEPS < -0.5 || share * STEPS > STEPS + 0.5);
                    *height = share;
                }
                Ok(())
            }),
        })?;
    }
    Ok((files, range, beyond))
}

/// What a file says about its heights.
fn notes(mapping: &Mapping, range: Option<(f64, f64)>) -> Vec<(&'static str, String)> {
    let projection = match mapping.chart.projection {
        Projection::Equirectangular => "equirectangular",
        Projection::Cube => "cube",
        Projection::Plane { .. } => "plane",
    };
    let datum = match mapping.datum {
        Datum::Globe { center, radius } => {
            format!("a sphere of radius {radius} around {},{},{}", center.x, center.y, center.z)
        }
        Datum::Plane { center, depth } => {
            let half = 0.5 * depth * f64::from(mapping.chart.width()) / f64::from(mapping.chart.size);
            let ends = |middle: f64, half: f64| format!("{} to {}", middle - half, middle + half);
            format!(
                "y = {}, x from {}, z from {}",
                center.y,
                ends(center.x, half),
                ends(center.z, 0.5 * depth)
            )
        }
    };
    let mut notes = vec![("Projection", projection.to_owned()), ("Heights above", datum)];
    notes.extend(range.map(|(black, white)| ("Range", format!("{black}..{white}"))));
    notes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_short_and_hold_all_heights_but_for_the_precision() {
        let of = |lowest, highest| rounded(&Tally { lowest, highest, ..Tally::default() }, 1e-12);
        assert_eq!(of(-3e-13, 0.024305598940164375), (0.0, 0.0243056));
        assert_eq!(of(1e-13, 9e-13), (0.0, 0.0));
        assert_eq!(of(2e-12, 2e-12), (0.0, 1e-11));
        assert_eq!(of(-8.40012345, 10.7012345), (-8.4002, 10.7013));
        assert_eq!(of(-123456.7, 7654321.5), (-123460.0, 7654330.0));
    }
}
