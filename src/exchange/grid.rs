//! Volumes and heightfields: raw numbers, with a header beside them.
//!
//! ```text
//! cloud.json     { "type": "float32", "endian": "little", "order": "xyz", "size": [64, 32, 64],
//!                  "origin": [-1, -0.5, -1], "spacing": [0.03125, 0.03125, 0.03125], "edge": "clamp" }
//! cloud.raw      numbers of four bytes, the least first, along x first, then y, then z
//! ```
//!
//! The header says what programs that read raw data ask for. It may leave out the place (samples are
//! then one apart from the origin on) and the edge, and may say more than that; what it says of the
//! size is compared with the length of the data before anything else, and a digest, which those have that are written
//! here, with the numbers: two files are not replaced at one stroke. Programs that read pictures
//! are better served with [slices](slice()).

use super::fault::{Fault, Place};
use super::image::Image;
use crate::grid::{Edge, Failure, Frame, Samples};
use crate::num::Digest;
use serde::{Deserialize, Serialize};
use std::io::{self, Write};

/// What is in the header.
#[derive(Serialize, Deserialize)]
struct Header {
    #[serde(rename = "type")]
    kind: String,
    #[serde(default = "little")]
    endian: String,
    #[serde(default = "xyz")]
    order: String,
    size: [usize; 3],
    #[serde(default)]
    origin: [f64; 3],
    #[serde(default = "ones")]
    spacing: [f64; 3],
    #[serde(default = "clamp")]
    edge: String,
    /// Of the numbers, so that no others are taken for them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    digest: Option<String>,
}

const FLOAT32: &str = "float32";

fn little() -> String {
    "little".to_owned()
}

fn xyz() -> String {
    "xyz".to_owned()
}

fn ones() -> [f64; 3] {
    [1.0; 3]
}

fn clamp() -> String {
    "clamp".to_owned()
}

/// The name of the file with the numbers, which is that of the header with another ending.
pub fn data_name(header: &str) -> String {
    format!("{}.raw", header.strip_suffix(".json").unwrap_or(header))
}

/// The header of a grid.
pub fn header(samples: &Samples) -> String {
    let Frame { size, origin, spacing, edge } = samples.frame;
    let edge = if edge == Edge::Repeat { "repeat".to_owned() } else { clamp() };
    let digest = Some(digest(samples.values.iter().map(|value| *value as f32)));
    let (kind, endian, order) = (FLOAT32.to_owned(), little(), xyz());
    let header = Header { kind, endian, order, size, origin, spacing, edge, digest };
    // Texts and finite numbers can always be written.
    serde_json::to_string_pretty(&header).unwrap_or_default() + "\n"
}

/// The digest of numbers.
fn digest(numbers: impl Iterator<Item = f32>) -> String {
    let mut digest = Digest::default();
    numbers.for_each(|number| digest.whole(u64::from(number.to_bits())));
    digest.to_string()
}

/// Writes the numbers of a grid, rounded to 32 bits.
///
/// # Errors
/// When `out` fails, or a number is beyond 32 bits, which is [`io::ErrorKind::InvalidInput`].
pub fn write(samples: &Samples, out: &mut dyn Write) -> io::Result<()> {
    for value in &samples.values {
        let single = *value as f32;
        if !single.is_finite() {
            let what = match value.is_nan() {
                true => "a place has no value; guard square roots and divisions".to_owned(),
                false => format!("{value} does not fit into 32 bits; scale the field down"),
            };
            return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
        }
        out.write_all(&single.to_le_bytes())?;
    }
    Ok(())
}

/// The grid of a header and the numbers that belong to it; `name` is that of the header.
///
/// # Errors
/// When the header is damaged or asks for what is not read, when the numbers are not as many as it says or not those
/// that it was written with, and when one of them is not finite.
pub fn read(name: &str, header: &[u8], data: &[u8]) -> Result<Samples, Fault> {
    let (frame, known) = frame(header).map_err(|fault| fault.of(name))?;
    let data_name = data_name(name);
    let wanted = 4 * frame.count();
    if data.len() != wanted {
        let [x, y, z] = frame.size;
        let what = format!("{x} x {y} x {z} numbers take {wanted} bytes, and the file has {}", data.len());
        let remedy = format!("correct `size` in {name}, or write both files again");
        return Err(Fault::new(Place::Whole, what).remedy(remedy).of(&data_name));
    }
    let single = |bytes: &[u8]| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    if known.is_some_and(|known| known != digest(data.chunks_exact(4).map(single))) {
        let what = format!("these are not the numbers that {name} was written with");
        let remedy = format!("write both files again; if the numbers are right, take `digest` out of {name}");
        return Err(Fault::new(Place::Whole, what).remedy(remedy).of(&data_name));
    }
    let values: Vec<f64> = data.chunks_exact(4).map(|bytes| f64::from(single(bytes))).collect();
    match values.iter().position(|v| !v.is_finite()) {
        None => Ok(Samples { frame, values }),
        Some(i) => {
            let what = format!("number {i} is {}, which is not finite", values[i]);
            Err(Fault::new(Place::Byte(4 * i), what).of(&data_name))
        }
    }
}

/// Where the samples lie, by a header, and their digest if it has one.
fn frame(text: &[u8]) -> Result<(Frame, Option<String>), Fault> {
    let at = |path: &str, what: String| Fault::new(Place::Value(path.to_owned()), what);
    let header: Header = serde_json::from_slice(text).map_err(|e| {
        at("its JSON text", e.to_string())
            .remedy("a header is such as { \"type\": \"float32\", \"size\": [64, 64, 64] }")
    })?;
    for (path, given, known) in [
        ("type", &header.kind, FLOAT32),
        ("endian", &header.endian, "little"),
        ("order", &header.order, "xyz"),
    ] {
        if given != known {
            return Err(at(path, format!("{given:?} is not read")).remedy(format!("convert it to {known:?}")));
        }
    }
    let edge = match header.edge.as_str() {
        "clamp" => Edge::Clamp,
        "repeat" => Edge::Repeat,
        other => {
            let fault = at("edge", format!("{other:?} is no kind of edge"));
            return Err(fault.remedy("an edge is \"clamp\" or \"repeat\""));
        }
    };
    let Header { size, origin, spacing, digest, .. } = header;
    let frame = Frame { size, origin, spacing, edge }.checked().map_err(|failure| {
        let path = match failure {
            Failure::Spacing(_) => "spacing",
            Failure::Place(_) => "origin",
            _ => "size",
        };
        at(path, failure.to_string()).remedy("correct the header")
    })?;
    Ok((frame, digest))
}

/// The samples of a volume at number `level` along y as a picture that is seen from above: x to the
/// right, z down. The only slice of a heightfield is the heightfield.
///
/// None if there are not so many samples.
pub fn slice(samples: &Samples, level: usize) -> Option<Image> {
    let [width, levels, height] = samples.frame.size;
    let rows = samples.values.chunks_exact(width.max(1)).skip(level).step_by(levels.max(1));
    let values: Vec<f64> = rows.flatten().copied().collect();
    (level < levels && values.len() == width * height).then_some(Image { width, height, values })
}
