//! PLY, the Stanford polygon format: a header of lines that declares what follows, and then numbers.
//!
//! ```text
//! ply
//! format binary_little_endian 1.0        (or binary_big_endian, or ascii)
//! element vertex 8
//! property double x                      (y, z; nx, ny, nz; red, green, blue)
//! element face 12
//! property list uchar int vertex_indices
//! end_header
//! ```
//!
//! Any other elements and properties are passed over. The format is read by hand, since its header is a
//! small language of its own, every count in which is compared with the bytes that follow before there
//! is room made for anything, and every fault is to be told by line or byte.

mod header;
mod values;

pub use header::Encoding;

use super::{linear, number_of_points, polygon, units};
use crate::exchange::fault::{Fault, Place};
use crate::num::srgb;
use crate::shape::Mesh;
use glam::DVec3;
use header::{Element, Header, Kind};
use std::io::{self, Write};
use values::Values;

/// What is read of points, in this order.
const WANTED: [&[u8]; 9] = [b"x", b"y", b"z", b"nx", b"ny", b"nz", b"red", b"green", b"blue"];

pub(super) fn read(bytes: &[u8]) -> Result<Mesh, Fault> {
    let header = Header::of(bytes)?;
    let mut values = Values::of(bytes, &header);
    let mut mesh = Mesh::default();
    for element in &header.elements {
        match element.name.as_slice() {
            b"vertex" => points(element, &mut values, &mut mesh)?,
            b"face" => faces(element, &mut values, &mut mesh)?,
            _ => {
                for _ in 0..values.count(element)? {
                    element.properties.iter().try_for_each(|property| values.skip(property))?;
                }
            }
        }
    }
    mesh.normals = units(mesh.normals);
    Ok(mesh)
}

/// What is read of each point.
struct Columns {
    /// For each property its number among what is wanted.
    slots: Vec<Option<usize>>,
    /// Whether there are normals.
    normals: bool,
    /// The numbers of a white point, if there are colours.
    white: Option<f64>,
}

impl Columns {
    fn of(element: &Element) -> Option<Columns> {
        let slot = |name: &[u8]| WANTED.iter().position(|wanted| *wanted == name);
        let slots: Vec<Option<usize>> =
            element.properties.iter().map(|p| slot(&p.name).filter(|_| p.length.is_none())).collect();
        let has = |slot: usize| slots.contains(&Some(slot));
        let red = element.properties.iter().zip(&slots).find(|(_, slot)| **slot == Some(6));
        let white = red.filter(|_| has(7) && has(8)).map(|(red, _)| match red.kind {
            Kind::F32 | Kind::F64 => 1.0,
            Kind::U16 => 65535.0,
            _ => 255.0,
        });
        let normals = has(3) && has(4) && has(5);
        (has(0) && has(1) && has(2)).then_some(Columns { slots, normals, white })
    }

    /// The numbers of a point.
    fn row(&self, element: &Element, values: &mut Values<'_>) -> Result<[f64; 9], Fault> {
        let place = values.place();
        let mut row = [0.0; 9];
        for (property, slot) in element.properties.iter().zip(&self.slots) {
            match slot {
                Some(slot) => row[*slot] = values.number(property.kind)?,
                None => values.skip(property)?,
            }
        }
        match row.iter().all(|x| x.is_finite()) {
            true => Ok(row),
            false => Err(Fault::new(place, "a number of a point is not finite")),
        }
    }
}

fn points(element: &Element, values: &mut Values<'_>, mesh: &mut Mesh) -> Result<(), Fault> {
    let wrong = |what: &str| Fault::new(Place::Line(element.line), what);
    if !mesh.points.is_empty() {
        return Err(wrong("points are declared twice"));
    }
    let columns = Columns::of(element).ok_or_else(|| wrong("points have no x, y and z"))?;
    let count = values.count(element)?;
    number_of_points(count, || Place::Line(element.line))?;
    mesh.points.reserve_exact(count);
    for _ in 0..count {
        let place = values.place();
        let [x, y, z, nx, ny, nz, r, g, b] = columns.row(element, values)?;
        mesh.points.push(DVec3::new(x, y, z));
        if columns.normals {
            mesh.normals.push(DVec3::new(nx, ny, nz));
        }
        if let Some(white) = columns.white {
            let color = linear([r, g, b].map(|c| c / white));
            mesh.colors.push(color.ok_or_else(|| Fault::new(place, "a colour is too bright"))?);
        }
    }
    Ok(())
}

fn faces(element: &Element, values: &mut Values<'_>, mesh: &mut Mesh) -> Result<(), Fault> {
    let mut face = Vec::new();
    let count = mesh.points.len();
    for _ in 0..values.count(element)? {
        let place = values.place();
        for property in &element.properties {
            let (Some(length), b"vertex_indices" | b"vertex_index") = (property.length, &property.name[..])
            else {
                values.skip(property)?;
                continue;
            };
            face.clear();
            for _ in 0..values.length(length, property.kind)? {
                let index = values.number(property.kind)?;
                if index.fract() != 0.0 || !(0.0..count as f64).contains(&index) {
                    let what = format!("a face has point {index}, and there are {count} before it");
                    return Err(Fault::new(place, what));
                }
                face.push(index as u32);
            }
            polygon::add(&face, mesh).map_err(|fault| Fault { place: place.clone(), ..fault })?;
        }
    }
    Ok(())
}

pub(super) fn write(mesh: &Mesh, encoding: Encoding, out: &mut dyn Write) -> io::Result<()> {
    if mesh.points.len() > i32::MAX as usize {
        return Err(super::unfit("PLY files hold 2147483647 points at most"));
    }
    declare(mesh, encoding, out)?;
    let mut row = Row { encoding, bytes: Vec::with_capacity(128) };
    for (i, p) in mesh.points.iter().enumerate() {
        row.doubles(p.to_array());
        if let Some(n) = mesh.normals.get(i) {
            row.singles(n.as_vec3().to_array());
        }
        if let Some(color) = mesh.colors.get(i) {
            row.octets(&color.map(octet));
        }
        row.end(out)?;
    }
    for triangle in &mesh.triangles {
        row.octets(&[3]);
        row.indices(*triangle);
        row.end(out)?;
    }
    Ok(())
}

fn declare(mesh: &Mesh, encoding: Encoding, out: &mut dyn Write) -> io::Result<()> {
    let format = match encoding {
        Encoding::Little => "binary_little_endian",
        Encoding::Big => "binary_big_endian",
        Encoding::Text => "ascii",
    };
    writeln!(out, "ply\nformat {format} 1.0\ncomment orogen\nelement vertex {}", mesh.points.len())?;
    writeln!(out, "property double x\nproperty double y\nproperty double z")?;
    if !mesh.normals.is_empty() {
        writeln!(out, "property float nx\nproperty float ny\nproperty float nz")?;
    }
    if !mesh.colors.is_empty() {
        writeln!(out, "property uchar red\nproperty uchar green\nproperty uchar blue")?;
    }
    writeln!(out, "element face {}", mesh.triangles.len())?;
    writeln!(out, "property list uchar int vertex_indices\nend_header")
}

/// A part of a colour in eight bits, as screens show it.
fn octet(linear: f32) -> u8 {
    (255.0 * srgb::encode(f64::from(linear).clamp(0.0, 1.0))).round() as u8
}

/// What is said of one point or face.
struct Row {
    encoding: Encoding,
    bytes: Vec<u8>,
}

/// Declares how numbers of a kind are put into a row.
macro_rules! numbers {
    ($name:ident, $kind:ty) => {
        fn $name(&mut self, numbers: [$kind; 3]) {
            for x in numbers {
                match self.encoding {
                    Encoding::Little => self.bytes.extend(x.to_le_bytes()),
                    Encoding::Big => self.bytes.extend(x.to_be_bytes()),
                    Encoding::Text => self.word(format_args!("{x:?}")),
                }
            }
        }
    };
}

impl Row {
    numbers!(doubles, f64);
    numbers!(singles, f32);
    numbers!(indices, u32);

    fn octets(&mut self, octets: &[u8]) {
        match self.encoding {
            Encoding::Text => octets.iter().for_each(|x| self.word(format_args!("{x}"))),
            _ => self.bytes.extend(octets),
        }
    }

    fn word(&mut self, word: std::fmt::Arguments<'_>) {
        if !self.bytes.is_empty() {
            self.bytes.push(b' ');
        }
        // There is always room in a vector.
        let _ = self.bytes.write_fmt(word);
    }

    fn end(&mut self, out: &mut dyn Write) -> io::Result<()> {
        if self.encoding == Encoding::Text {
            self.bytes.push(b'\n');
        }
        out.write_all(&self.bytes)?;
        self.bytes.clear();
        Ok(())
    }
}
