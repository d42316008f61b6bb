//! Export, then import.

use crate::{lump, surface, written};
use orogen::exchange::mesh::{self, Format, Ply, Stl};
use orogen::shape::Mesh;

/// Each format, a name for its files, and whether it holds all that 64 bits do.
const FORMATS: &[(Format, &str, bool)] = &[
    (Format::Glb, "a.glb", false),
    (Format::Obj, "a.obj", true),
    (Format::Ply(Ply::Little), "a.ply", true),
    (Format::Ply(Ply::Big), "a.ply", true),
    (Format::Ply(Ply::Text), "a.ply", true),
    (Format::Stl(Stl::Binary), "a.stl", false),
    (Format::Stl(Stl::Text), "a.STL", true),
];

#[test]
fn the_surface_comes_back_bit_for_bit() {
    for (format, name, exact) in FORMATS {
        let mut mesh = lump(5);
        if *exact {
            mesh.points.iter_mut().for_each(|p| *p = *p / 3.0 * 1e-7);
        }
        let back = mesh::read(name, &written(*format, &mesh)).unwrap();
        assert_eq!(surface(&back), surface(&mesh), "{format:?}");
        assert_eq!(back.check(), Ok(()));
    }
}

#[test]
fn indices_normals_and_colours_come_back_where_there_is_room_for_them() {
    let mesh = lump(3);
    for (format, name, _) in FORMATS.iter().filter(|(format, ..)| !matches!(format, Format::Stl(_))) {
        let bare = Mesh { normals: vec![], colors: vec![], ..mesh.clone() };
        assert_eq!(mesh::read(name, &written(*format, &bare)).unwrap(), bare, "{format:?}");
        let back = mesh::read(name, &written(*format, &mesh)).unwrap();
        assert_eq!((&back.points, &back.triangles), (&mesh.points, &mesh.triangles), "{format:?}");
        assert_eq!(back.normals, mesh.normals, "{format:?}");
        let colors = back.colors.as_flattened().iter().zip(mesh.colors.as_flattened());
        assert_eq!(back.colors.len(), mesh.colors.len());
        // Half a step of eight bits where the code of colours is least steep; else rounding.
        let most = if matches!(format, Format::Ply(_)) { 0.5 / 255.0 * 2.3 } else { 1e-7 };
        colors.for_each(|(a, b)| assert!((a - b).abs() < most, "{format:?}: {a} {b}"));
    }
}
