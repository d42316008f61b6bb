//! STL: loose triangles, binary or as text.
//!
//! ```text
//! binary: 80 bytes of anything, u32 number of triangles,
//!         then for each: f32 normal[3], f32 corner[3][3], u16 anything      (50 bytes, little-endian)
//! text:   solid NAME
//!           facet normal x y z
//!             outer loop
//!               vertex x y z      (three)
//!             endloop
//!           endfacet
//!         endsolid NAME
//! ```
//!
//! A binary file may begin with the word "solid" too, so it is known by its length. Equal corners
//! become one point, in the order in which they come. The normals of triangles say what their corners
//! say already, and are not read.

use super::{fits_single, number_of_points};
use crate::exchange::fault::{Fault, Place};
use crate::exchange::text::{Lines, next_three, shown, words};
use crate::shape::Mesh;
use glam::DVec3;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::io::{self, Write};

/// How triangles are written.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Encoding {
    /// 50 bytes a triangle.
    Binary,
    /// Exact, and five times as long.
    Text,
}

const HEADER: usize = 84;
const TRIANGLE: usize = 50;

pub(super) fn read(bytes: &[u8]) -> Result<Mesh, Fault> {
    let claimed = bytes.get(80..HEADER).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    let length = claimed.map(|count| HEADER as u64 + TRIANGLE as u64 * u64::from(count));
    if length == Some(bytes.len() as u64) {
        return binary(&bytes[HEADER..]);
    }
    if bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) {
        return text(bytes);
    }
    Err(match (claimed, length) {
        (Some(count), Some(length)) => Fault::new(
            Place::Byte(80),
            format!(
                "{count} triangles are announced, which take {length} bytes, and the file has {}",
                bytes.len()
            ),
        ),
        _ => Fault::new(
            Place::Whole,
            "the file is neither a binary STL file, which has 84 bytes or more, nor text",
        ),
    })
}

fn binary(triangles: &[u8]) -> Result<Mesh, Fault> {
    let mut merger = Merger::default();
    for (i, triangle) in triangles.chunks_exact(TRIANGLE).enumerate() {
        let place = HEADER + TRIANGLE * i + 12;
        let mut numbers =
            triangle[12..48].chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        let mut corner = || {
            let [x, y, z] = std::array::from_fn(|_| f64::from(numbers.next().unwrap_or(f32::NAN)));
            merger.point(DVec3::new(x, y, z), || Place::Byte(place))
        };
        let triangle = [corner()?, corner()?, corner()?];
        merger.mesh.triangles.push(triangle);
    }
    Ok(merger.mesh)
}

fn text(bytes: &[u8]) -> Result<Mesh, Fault> {
    let mut merger = Merger::default();
    let (mut corners, mut open, mut last) = (Vec::new(), true, 1);
    for (line, text) in Lines::of(bytes) {
        last = line;
        let mut words = words(text);
        let Some(word) = words.next() else { continue };
        let fault = |what: String| Fault::new(Place::Line(line), what);
        match word.to_ascii_lowercase().as_slice() {
            b"solid" => open = true,
            b"endsolid" => open = false,
            b"vertex" => {
                let at = DVec3::from(next_three(&mut words, line)?);
                corners.push(merger.point(at, || Place::Line(line))?);
            }
            b"endloop" => {
                let triangle = <[u32; 3]>::try_from(corners.as_slice());
                let wrong = |_| fault(format!("a facet has {} corners, not three", corners.len()));
                merger.mesh.triangles.push(triangle.map_err(wrong)?);
                corners.clear();
            }
            b"facet" | b"outer" if !corners.is_empty() => return Err(fault("a facet has no end".into())),
            b"facet" | b"outer" => {}
            b"endfacet" => {}
            _ => return Err(fault(format!("{} is no word of an STL file", shown(word)))),
        }
    }
    if open {
        return Err(Fault::new(Place::Line(last), "the file ends before `endsolid`"));
    }
    Ok(merger.mesh)
}

/// Makes equal corners one point.
#[derive(Default)]
struct Merger {
    mesh: Mesh,
    known: HashMap<[u64; 3], u32>,
}

impl Merger {
    /// The number of a point.
    fn point(&mut self, p: DVec3, place: impl FnOnce() -> Place) -> Result<u32, Fault> {
        if !p.is_finite() {
            return Err(Fault::new(place(), "a corner is not finite"));
        }
        // Minus zero is zero.
        let key = (p + 0.0).to_array().map(f64::to_bits);
        match self.known.entry(key) {
            Entry::Occupied(known) => Ok(*known.get()),
            Entry::Vacant(free) => {
                let number = number_of_points(self.mesh.points.len(), place)?;
                self.mesh.points.push(p);
                Ok(*free.insert(number))
            }
        }
    }
}

pub(super) fn write(mesh: &Mesh, encoding: Encoding, out: &mut dyn Write) -> io::Result<()> {
    match encoding {
        Encoding::Binary => write_binary(mesh, out),
        Encoding::Text => write_text(mesh, out),
    }
}

fn write_binary(mesh: &Mesh, out: &mut dyn Write) -> io::Result<()> {
    fits_single(mesh, "STL")?;
    let count = u32::try_from(mesh.triangles.len())
        .map_err(|_| super::unfit("STL holds 4294967295 triangles at most; write .ply or .obj"))?;
    // Not "solid": that is how text begins.
    let mut header = [0; HEADER];
    header[..6].copy_from_slice(b"orogen");
    header[80..].copy_from_slice(&count.to_le_bytes());
    out.write_all(&header)?;
    for i in 0..mesh.triangles.len() {
        let corners = mesh.corners(i);
        let mut bytes = [0; TRIANGLE];
        let vectors = [normal(corners), corners[0], corners[1], corners[2]];
        let numbers = vectors.iter().flat_map(|v| v.as_vec3().to_array());
        for (bytes, number) in bytes.chunks_exact_mut(4).zip(numbers) {
            bytes.copy_from_slice(&number.to_le_bytes());
        }
        out.write_all(&bytes)?;
    }
    Ok(())
}

fn write_text(mesh: &Mesh, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "solid orogen")?;
    for i in 0..mesh.triangles.len() {
        let corners = mesh.corners(i);
        let n = normal(corners);
        writeln!(out, "facet normal {:?} {:?} {:?}\nouter loop", n.x, n.y, n.z)?;
        for p in corners {
            writeln!(out, "vertex {:?} {:?} {:?}", p.x, p.y, p.z)?;
        }
        writeln!(out, "endloop\nendfacet")?;
    }
    writeln!(out, "endsolid orogen")
}

/// The unit normal of a triangle; zero if it has none.
fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}
