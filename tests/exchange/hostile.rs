//! Damaged and hostile files: an answer or a fault, soon, and in little memory.

use crate::gltf::{bytes, glb, scene};
use crate::memory::peak;
use crate::{lump, written};
use orogen::exchange::mesh::{self, Format, Ply, Stl};
use orogen::shape::Mesh;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

/// Small files of every kind, with names.
fn files() -> Vec<(&'static str, Vec<u8>)> {
    let mesh = Mesh { triangles: lump(1).triangles[..4].to_vec(), ..lump(1) };
    let ply = |encoding| written(Format::Ply(encoding), &mesh);
    let quads = "v 0 0 0 1 1 1\nv 1 0 0 0 0 0\nv 1 1 0 1 0 0\nv .2 .1 0 1 0 1\nvn 0 0 1\nf 1//1 2//1 3//1 4//1\nf -1 -2 -3 -4\n";
    vec![
        ("a.obj", written(Format::Obj, &mesh)),
        ("quads.obj", quads.into()),
        ("little.ply", ply(Ply::Little)),
        ("big.ply", ply(Ply::Big)),
        ("text.ply", ply(Ply::Text)),
        ("other.ply", crate::meshes::PLY.into()),
        ("a.stl", written(Format::Stl(Stl::Binary), &mesh)),
        ("text.stl", written(Format::Stl(Stl::Text), &mesh)),
        ("a.glb", written(Format::Glb, &mesh)),
        ("scene.glb", glb(&scene(), &bytes())),
        ("scene.gltf", scene().to_string().into_bytes()),
    ]
}

/// Bytes of memory for each byte of a file. What takes most is an empty node of glTF, `{},`, which is
/// 72 bytes, in a vector that grows by doubling, so that it is there one and a half times.
const FACTOR: usize = 96;

/// What any reader may take besides: buffers, messages, and tables of names.
const CONSTANT: usize = 1 << 16;

/// Reads a file, and checks what comes of it.
fn survive(name: &str, bytes: &[u8]) -> bool {
    let (result, memory) = peak(|| mesh::read(name, bytes));
    assert!(memory <= FACTOR * bytes.len() + CONSTANT, "{name}: {memory} bytes for {}", bytes.len());
    match result {
        Ok(mesh) => {
            assert_eq!(mesh.check(), Ok(()), "{name}");
            assert!(mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-6), "{name}");
            assert!(mesh.colors.as_flattened().iter().all(|c| c.is_finite()), "{name}");
            true
        }
        Err(fault) => {
            let said = fault.to_string();
            assert!(said.starts_with(name) && said.contains(": ") && said.contains("; "), "{said}");
            assert!(said.len() < 600, "{said}");
            false
        }
    }
}

#[test]
fn files_may_end_anywhere() {
    for (name, bytes) in files() {
        assert_eq!(survive(name, &bytes), name != "scene.gltf", "{name}");
        let whole = (0..bytes.len()).filter(|end| survive(name, &bytes[..*end])).count();
        // Text may lack its last digits and not show it; and points without faces are no mesh.
        let most = if name.ends_with("obj") {
            60
        } else if name.contains("r.ply") || name.starts_with("text") {
            10
        } else {
            0
        };
        assert!(whole <= most, "{name}: {whole}");
    }
}

#[test]
fn bytes_may_be_anything() {
    for (name, whole) in files() {
        let mut random = StdRng::seed_from_u64(1);
        for _ in 0..4000 {
            let mut bytes = whole.clone();
            for _ in 0..random.random_range(1..4) {
                let at = random.random_range(0..bytes.len());
                bytes[at] = match random.random_range(0..4) {
                    0 => 255,
                    1 => b"0123456789-e. \n/{}[],\"\\"[random.random_range(0..23)],
                    2 => bytes[at] ^ 1 << random.random_range(0..8),
                    _ => random.random(),
                };
            }
            survive(name, &bytes);
        }
    }
}

#[test]
fn numbers_may_be_any() {
    let numbers = [
        "-1",
        "0",
        "4294967295",
        "4294967296",
        "18446744073709551615",
        "99999999999999999999999",
        "1e300",
        "NaN",
        "-inf",
        "0.5",
        "",
    ];
    for (name, whole) in files() {
        let Ok(text) = String::from_utf8(whole) else { continue };
        let digits = |c: char| c.is_ascii_digit() || c == '.' || c == '-';
        let starts = text.match_indices(digits).map(|(i, _)| i);
        for start in starts.filter(|i| *i == 0 || !text[..*i].ends_with(digits)) {
            let end = text[start..].find(|c| !digits(c)).map_or(text.len(), |n| start + n);
            for number in numbers {
                survive(name, format!("{}{number}{}", &text[..start], &text[end..]).as_bytes());
            }
        }
    }
}

#[test]
fn noise_is_no_mesh() {
    let mut random = StdRng::seed_from_u64(2);
    let starts: [(&str, &[u8]); 6] = [
        ("a.obj", b"f "),
        ("a.ply", b"ply\nformat binary_little_endian 1.0\nelement vertex 9\nproperty float x\n"),
        (
            "b.ply",
            b"ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_index\nend_header\n",
        ),
        ("a.stl", b"solid\n"),
        ("a.glb", b"glTF\x02\0\0\0"),
        ("a.gltf", b"{"),
    ];
    for (name, start) in starts {
        for _ in 0..2000 {
            let length = random.random_range(0..200);
            let noise: Vec<u8> = (0..length).map(|_| random.random()).collect();
            survive(name, &[start, &noise].concat());
        }
    }
}

#[test]
fn large_files_take_memory_in_proportion() {
    // What takes most memory for its length.
    let many = |part: &str| part.repeat(1 << 18);
    survive("points.obj", many("v 0 0 0\n").as_bytes());
    survive("fan.obj", format!("v 0 0 0\nf{}", many(" 1")).as_bytes());
    survive("faces.obj", format!("v 0 0 0\n{}", many("f 1 1 1\n")).as_bytes());
    survive(
        "concave.obj",
        format!("v 0 0 0\nv 1 0 0\nv 1 1 0\nv .1 .1 0\n{}", many("f 1 2 3 4\n")).as_bytes(),
    );
    survive(
        "a.gltf",
        format!("{{\"asset\":{{\"version\":\"2\"}},\"nodes\":[{}{{}}]}}", many("{},")).as_bytes(),
    );
    survive("b.gltf", format!("{{\"meshes\":[{}{{}}]}}", many("{\"primitives\":[]},")).as_bytes());
    survive("c.gltf", format!("{{\"scenes\":[{{\"nodes\":[{}0]}}]}}", many("0,")).as_bytes());
    survive("d.gltf", format!("{{\"extensionsRequired\":[{}\"\"]}}", many("\"\",")).as_bytes());
    survive("a.ply", format!("ply\nformat ascii 1.0\n{}", many("element a 0\n")).as_bytes());
    survive(
        "b.ply",
        format!("ply\nformat ascii 1.0\nelement vertex 1\n{}", many("property int x\n")).as_bytes(),
    );
    let header = "ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nproperty int y\nproperty int z\n\
        element face 1\nproperty list int int vertex_index\nend_header\n0 0 0\n262144";
    survive("c.ply", format!("{header}{}", many(" 0")).as_bytes());
    let facet = "vertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0\nendloop\n";
    survive("a.stl", format!("solid\n{}endsolid", facet.repeat(1 << 15)).as_bytes());
}
