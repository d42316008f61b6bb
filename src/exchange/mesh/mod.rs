//! Polygon meshes, one file a format.
//!
//! | ending | points | normals | colours | notes |
//! |---|---|---|---|---|
//! | `.glb` | 32 bits | yes | linear, 0 to 1 | glTF 2.0; `.gltf` with its data inside is read too |
//! | `.obj` | exact | yes | sRGB | text |
//! | `.ply` | exact | 32 bits | sRGB, 8 bits | binary or text |
//! | `.stl` | 32 bits | no | no | binary or text (exact); loose triangles, whose equal corners are one point |
//!
//! *Exact* is what comes back as it was, bit for bit; so do points that 32 bits hold from any format. Points that are
//! near each other may be equal once they are rounded, and a reader that takes equal points for one then finds holes
//! in a closed mesh; one that is [rounded](crate::mesh::rounded) before has none.
//! Colours are linear here; formats that do not say what their colours mean hold those of screens.
//!
//! A [`Mesh`] has one normal and one colour a point. Where a file leaves some points without a normal,
//! or gives several to one, the normals are left out. Coordinates are taken as they are: what is up in
//! a file that has z upward is along z here too.
//!
//! ```
//! use orogen::exchange::mesh::{self, Format};
//!
//! let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
//! let corner = mesh::read("corner.obj", text)?;
//! let mut file = Vec::new();
//! mesh::write(Format::of("corner.glb")?, &corner, &mut file)?;
//! assert_eq!(mesh::read("corner.glb", &file)?, corner);
//!
//! let fault = mesh::read("corner.obj", b"v 0 0 0\nf 1 2 3\n").unwrap_err();
//! assert!(fault.to_string().starts_with("corner.obj, line 2: a face has number 2 of the points"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod gltf;
mod obj;
mod ply;
mod polygon;
mod stl;

pub use gltf::{Network, write_network};
pub use ply::Encoding as Ply;
pub use stl::Encoding as Stl;

use super::fault::{Fault, Place, ending};
use crate::num::srgb;
use crate::shape::Mesh;
use glam::DVec3;
use std::io::{self, Write};

/// What a mesh can be written as.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Format {
    /// Binary glTF 2.0.
    Glb,
    /// Wavefront OBJ.
    Obj,
    /// PLY.
    Ply(Ply),
    /// Stereolithography.
    Stl(Stl),
}

/// Readers by ending.
type Reader = fn(&[u8]) -> Result<Mesh, Fault>;
const READERS: &[(&str, Reader)] =
    &[("glb", gltf::read), ("gltf", gltf::read), ("obj", obj::read), ("ply", ply::read), ("stl", stl::read)];

/// What is written by ending.
const FORMATS: &[(&str, Format)] = &[
    ("glb", Format::Glb),
    ("obj", Format::Obj),
    ("ply", Format::Ply(Ply::Little)),
    ("stl", Format::Stl(Stl::Binary)),
];

impl Format {
    /// The format that a file's name asks for by its ending; the binary one where there are two.
    ///
    /// # Errors
    /// For any other ending.
    pub fn of(name: &str) -> Result<Format, Fault> {
        by_ending(name, FORMATS, "written to")
    }

    /// Whether points are rounded to 32 bits.
    pub fn is_single(self) -> bool {
        matches!(self, Format::Glb | Format::Stl(Stl::Binary))
    }
}

/// Reads a mesh in the format that the ending of the file's name says.
///
/// # Errors
/// When the ending is none of ours, when the file is not what it says or is damaged, when it needs
/// something that is not in it, and when it holds no triangle.
pub fn read(name: &str, bytes: &[u8]) -> Result<Mesh, Fault> {
    let reader = by_ending(name, READERS, "read from")?;
    let mesh = reader(bytes).map_err(|fault| fault.of(name))?;
    if mesh.triangles.is_empty() {
        let fault = Fault::new(Place::Whole, "the file holds no triangles");
        return Err(fault.remedy("save the surface as polygons, not as points, lines or curves").of(name));
    }
    Ok(mesh)
}

/// How a mesh reflects light, everywhere alike, and shines; each a share from 0 to 1 but for light. Matt unless it says so.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Gloss {
    /// Share that is metal, of the mesh's colours.
    pub metal: f64,
    /// Share that a clear coat covers.
    pub coat: f64,
    /// How blurred reflections of metal and of the coat are.
    pub roughness: f64,
    /// Light that it gives off, linear.
    pub light: [f64; 3],
}

/// Writes a mesh that is matt.
///
/// # Errors
/// As for [`write_glossy`].
pub fn write(format: Format, mesh: &Mesh, out: &mut dyn Write) -> io::Result<()> {
    write_glossy(format, mesh, &Gloss::default(), out)
}

/// Writes a mesh; how it reflects light goes into glTF alone.
///
/// # Errors
/// When `out` fails, or the format cannot hold the mesh, which is [`io::ErrorKind::InvalidInput`].
pub fn write_glossy(format: Format, mesh: &Mesh, gloss: &Gloss, out: &mut dyn Write) -> io::Result<()> {
    mesh.check().map_err(|flaw| unfit(flaw.to_string()))?;
    let finite = mesh.normals.iter().all(|n| n.is_finite())
        && mesh.colors.as_flattened().iter().all(|c| c.is_finite());
    if !finite {
        return Err(unfit("a normal or colour is not finite"));
    }
    match format {
        Format::Glb => gltf::write(mesh, gloss, out),
        Format::Obj => obj::write(mesh, out),
        Format::Ply(encoding) => ply::write(mesh, encoding, out),
        Format::Stl(encoding) => stl::write(mesh, encoding, out),
    }
}

fn by_ending<T: Copy>(name: &str, table: &[(&str, T)], done: &str) -> Result<T, Fault> {
    let wanted = ending(name);
    table.iter().find(|(ending, _)| *ending == wanted).map(|(_, found)| *found).ok_or_else(|| {
        let endings: Vec<_> = table.iter().map(|(ending, _)| format!(".{ending}")).collect();
        Fault::new(Place::Whole, "the ending of the name is that of no known mesh format")
            .remedy(format!("meshes are {done} files that end with {}", endings.join(", ")))
            .of(name)
    })
}

/// A mesh that a format cannot hold.
fn unfit(what: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, what.into())
}

/// Refuses points that are infinite in 32 bits.
fn fits_single(mesh: &Mesh, format: &str) -> io::Result<()> {
    match mesh.points.iter().find(|p| !p.as_vec3().is_finite()) {
        None => Ok(()),
        Some(p) => Err(unfit(format!(
            "{format} holds coordinates in 32 bits, and {p} is beyond them; scale the mesh down, or write .ply or .obj"
        ))),
    }
}

/// The normals of all points with unit length, or none if one has no direction.
fn units(mut normals: Vec<DVec3>) -> Vec<DVec3> {
    for n in &mut normals {
        // What is a unit vector but for rounding to 32 bits stays as it is.
        if (n.length_squared() - 1.0).abs() < 1e-6 {
            continue;
        }
        // Numbers so small or large that their squares are none have a direction all the same.
        match (*n / n.abs().max_element()).try_normalize() {
            Some(unit) => *n = unit,
            None => return Vec::new(),
        }
    }
    normals
}

/// The linear colour that screens show for these numbers, unless they are beyond all measure.
fn linear(shown: [f64; 3]) -> Option<[f32; 3]> {
    let linear = shown.map(|c| srgb::decode(c) as f32);
    linear.iter().all(|c| c.is_finite()).then_some(linear)
}

/// A file of more points than there are numbers for them.
fn number_of_points(mesh_points: usize, place: impl FnOnce() -> Place) -> Result<u32, Fault> {
    u32::try_from(mesh_points).map_err(|_| {
        Fault::new(place(), "there are more than 4294967295 points")
            .remedy("split the mesh into several files")
    })
}
