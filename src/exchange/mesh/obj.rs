//! Wavefront OBJ: lines of text that begin with a word.
//!
//! ```text
//! v x y z [r g b]        a point, and its colour as most programs write it
//! vn x y z               a normal
//! f 1//1 2//2 -1//-1     a polygon: point/texture/normal of each corner, counted from 1, or back from -1
//! ```
//!
//! Everything else (textures, materials, groups, curves) is passed over. The format is small and its
//! errors are to be told by line, so it is read here, by hand. Numbers are written with as many digits as
//! it takes to get the same ones back.

use super::{linear, number_of_points, polygon, units};
use crate::exchange::fault::{Fault, Place};
use crate::exchange::text::{Lines, next_three, number, shown, words};
use crate::num::srgb;
use crate::shape::Mesh;
use glam::DVec3;
use std::io::{self, Write};

/// A point that no face has given a normal.
const NONE: u32 = u32::MAX;

/// What was read so far.
#[derive(Default)]
struct Found {
    mesh: Mesh,
    normals: Vec<DVec3>,
    /// Which normal each point has.
    normal_of: Vec<u32>,
    /// Whether a point has several.
    creased: bool,
    /// Points of the present face.
    face: Vec<u32>,
}

pub(super) fn read(bytes: &[u8]) -> Result<Mesh, Fault> {
    let mut found = Found::default();
    for (line, text) in Lines::of(bytes) {
        let mut words = words(text);
        match words.next() {
            Some(b"v") => found.point(&mut words, line)?,
            Some(b"vn") => found.normals.push(next_three(&mut words, line)?.into()),
            Some(b"f") => found.face(words, line)?,
            _ => {}
        }
    }
    Ok(found.mesh())
}

impl Found {
    fn point<'a>(&mut self, words: &mut impl Iterator<Item = &'a [u8]>, line: usize) -> Result<(), Fault> {
        number_of_points(self.mesh.points.len() + 1, || Place::Line(line))?;
        self.mesh.points.push(next_three(words, line)?.into());
        self.normal_of.push(NONE);
        // Three more numbers are a colour; one is a weight, which only curves have a use for.
        let more: Vec<&[u8]> = words.take_while(|word| !word.starts_with(b"#")).collect();
        if let [.., r, g, b] = more[..] {
            let color = next_three(&mut [r, g, b].into_iter(), line)?;
            let color =
                linear(color).ok_or_else(|| Fault::new(Place::Line(line), "a colour is too bright"))?;
            self.mesh.colors.push(color);
        }
        Ok(())
    }

    fn face<'a>(&mut self, words: impl Iterator<Item = &'a [u8]>, line: usize) -> Result<(), Fault> {
        let fault = |what: String| Fault::new(Place::Line(line), what);
        self.face.clear();
        for word in words.take_while(|word| !word.starts_with(b"#")) {
            let mut parts = word.split(|b| *b == b'/');
            let point = parts.next().unwrap_or_default();
            let point = index(point, self.mesh.points.len(), "points").map_err(fault)?;
            if let Some(normal) = parts.nth(1).filter(|part| !part.is_empty()) {
                let normal = index(normal, self.normals.len(), "normals").map_err(fault)?;
                let known = &mut self.normal_of[point as usize];
                match *known {
                    NONE => *known = normal,
                    known => self.creased |= self.normals[known as usize] != self.normals[normal as usize],
                }
            }
            self.face.push(point);
        }
        polygon::add(&self.face, &mut self.mesh).map_err(|fault| Fault { place: Place::Line(line), ..fault })
    }

    fn mesh(self) -> Mesh {
        let mut mesh = self.mesh;
        let all = !self.creased && self.normal_of.iter().all(|n| *n != NONE);
        if all {
            mesh.normals = units(self.normal_of.iter().map(|n| self.normals[*n as usize]).collect());
        }
        if mesh.colors.len() != mesh.points.len() {
            mesh.colors.clear();
        }
        mesh
    }
}

/// The thing that a word of a face means, counted from zero, of `count` things so far.
fn index(word: &[u8], count: usize, things: &str) -> Result<u32, String> {
    // Whole numbers of any size that could be right are exact as `f64`.
    let given = number(word).filter(|x| x.fract() == 0.0);
    let given = given.ok_or_else(|| format!("{} is not the number of one of the {things}", shown(word)))?;
    let counted = if given < 0.0 { given + count as f64 } else { given - 1.0 };
    if (0.0..count as f64).contains(&counted) {
        Ok(counted as u32)
    } else {
        Err(format!("a face has number {given} of the {things}, and there are {count} above it"))
    }
}

pub(super) fn write(mesh: &Mesh, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "# orogen")?;
    for (i, p) in mesh.points.iter().enumerate() {
        write!(out, "v {:?} {:?} {:?}", p.x, p.y, p.z)?;
        if let Some(color) = mesh.colors.get(i) {
            let [r, g, b] = color.map(|c| srgb::encode(f64::from(c)));
            write!(out, " {r:?} {g:?} {b:?}")?;
        }
        writeln!(out)?;
    }
    for n in &mesh.normals {
        writeln!(out, "vn {:?} {:?} {:?}", n.x, n.y, n.z)?;
    }
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|i| u64::from(i) + 1);
        if mesh.normals.is_empty() {
            writeln!(out, "f {a} {b} {c}")?;
        } else {
            writeln!(out, "f {a}//{a} {b}//{b} {c}//{c}")?;
        }
    }
    Ok(())
}
