//! Files as other programs write them, format by format.

use crate::{fault, surface};
use glam::DVec3;
use orogen::exchange::mesh;

#[test]
fn the_ending_says_the_format() {
    assert_eq!(
        fault("a/b.c/rock.fbx", b""),
        "a/b.c/rock.fbx: the ending of the name is that of no known mesh format; meshes are read from files that end with .glb, .gltf, .obj, .ply, .stl"
    );
    assert!(mesh::Format::of("rock").unwrap_err().to_string().contains("written to"));
}

#[test]
fn obj_takes_polygons_from_either_end() {
    let text =
        b"# a house\nmtllib \xff\xfe.mtl\nv 0 0 0\nv 2 0 0 1.0\nv 2 0 2\\\n\nv 1 0 1\nv 0 0 2\nvt 0 0\n\
        f -5/1 2/1/ 3 -2 5\r\nf 1 2 3 # the last\n";
    let mesh = mesh::read("house.obj", text).unwrap();
    assert_eq!(mesh.points.len(), 5);
    assert_eq!(mesh.triangles.len(), 4);
    let area: f64 = surface(&mesh).iter().map(|[a, b, c]| (b - a).cross(c - a).y).sum();
    assert_eq!(area, -2.0 * (3.0 + 2.0));
}

#[test]
fn obj_normals_are_kept_if_each_point_has_one() {
    let points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 3\nvn 0 0 3\nvn 0 1 0\n";
    let read = |faces: &str| mesh::read("a.obj", format!("{points}{faces}").as_bytes()).unwrap();
    assert_eq!(read("f 1//1 2//1 3//2\nf 1//2 2//1 4//1").normals, [DVec3::Z; 4]);
    assert_eq!(read("f 1//1 2//1 3//2\nf 1//3 2//1 4//1").normals, []);
    assert_eq!(read("f 1//1 2//1 3//2").normals, []);
}

#[test]
fn obj_colours_are_those_of_screens() {
    let text = b"v 0 0 0 1 1 1\nv 1 0 0 0 0 0\nv 0 1 0 0.5 0.5 0.5\nf 1 2 3\n";
    let colors = mesh::read("a.obj", text).unwrap().colors;
    assert_eq!(colors[..2], [[1.0; 3], [0.0; 3]]);
    assert!((colors[2][0] - 0.214_041_14).abs() < 1e-7);
}

#[test]
fn obj_faults_say_the_line() {
    let said = |text: &str| fault("a.obj", text.as_bytes());
    assert!(said("v 0 0 0\nv 1 0\n").starts_with("a.obj, line 2: a number is missing; "));
    assert!(said("v 0 0 zero").starts_with("a.obj, line 1: \"zero\" is no finite number; "));
    assert!(said("v 0 0 NaN").contains("\"NaN\" is no finite number"));
    assert!(said("v 0 0 1e999").contains("\"1e999\" is no finite number"));
    let points = "v 0 0 0\nv 1 0 0\\\n \nv 0 1 0\n";
    assert!(
        said(&format!("{points}f 1 2 4")).starts_with("a.obj, line 5: a face has number 4 of the points")
    );
    for wrong in ["0", "-4", "4294967297", "99999999999999999999999", "1.5", "/1", "x"] {
        assert!(said(&format!("{points}f 1 2 {wrong}")).starts_with("a.obj, line 5: "), "{wrong}");
    }
    assert!(said(&format!("{points}f 1 2")).contains("three corners or more, not 2"));
    assert!(said(&format!("{points}f 1//1 2 3")).contains("number 1 of the normals, and there are 0"));
    assert!(
        said("v 0 0 0\n").starts_with("a.obj: the file holds no triangles; save the surface as polygons")
    );
}

#[test]
fn stl_corners_are_merged() {
    let text = "solid\n facet normal 0 0 0\n outer loop\n vertex 0 0 0\n VERTEX 1 0 0\n vertex 0 1 0\n endloop\n endfacet
        facet normal 0 nan 0\n outer loop\n vertex 1 0 0\n vertex -0 0 0\n vertex 0 0 1\n endloop\n endfacet\nendsolid";
    let mesh = mesh::read("a.stl", text.as_bytes()).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [1, 0, 3]]);
    assert_eq!(mesh.points, [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z]);
}

#[test]
fn stl_faults_say_the_line_or_byte() {
    let mut binary = vec![0; 84 + 100];
    binary[..5].copy_from_slice(b"solid");
    binary[80] = 2;
    assert_eq!(mesh::read("a.stl", &binary).unwrap().triangles, [[0; 3]; 2]);
    binary[84 + 50 + 12..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(fault("a.stl", &binary).starts_with("a.stl, byte 146: a corner is not finite; "));
    binary[..5].fill(0);
    binary[80..84].fill(255);
    assert!(
        fault("a.stl", &binary).contains("4294967295 triangles are announced, which take 214748364834 bytes")
    );
    let said = |text: &str| fault("a.stl", text.as_bytes());
    assert!(said("hello").contains("84 bytes or more"));
    assert!(said("solid\nfacet\nouter loop\nvertex 1 2\n").starts_with("a.stl, line 4: a number is missing"));
    assert!(
        said("solid\nvertex 1 2 3\nendloop\nendsolid").starts_with("a.stl, line 3: a facet has 1 corners")
    );
    assert!(said("solid\nvertex 1 2 3\nfacet\nendsolid").starts_with("a.stl, line 3: a facet has no end"));
    assert!(said("solid\nhello\nendsolid").starts_with("a.stl, line 2: \"hello\" is no word"));
    assert!(said("solid a\nfacet\n").starts_with("a.stl, line 2: the file ends before `endsolid`"));
}

/// A tetrahedron with what other programs add.
pub const PLY: &str = "ply\r\nformat ascii 1.0\r\ncomment C:\\made by hand\\\r\nelement camera 1\r\nproperty list uchar float view\r\n\
    property float quality\r\nelement vertex 4\r\nproperty float confidence\r\nproperty float z\r\nproperty float x\r\n\
    property float y\r\nproperty ushort red\r\nproperty ushort green\r\nproperty ushort blue\r\nelement nothing 4000000000\r\n\
    element face 3\r\nproperty uchar flags\r\nproperty list uchar uint vertex_index\r\nend_header\r\n\
    3 0.5 0.5 0.5 nan\r\nnan 3 1 2 0 0 65535\r\n0 0.1 0 0 0 0 0 0 0 1 0 0 0 0 0 0 0 1 0 0 0\r\n9 3 0 1 2\r\n9 4 0 1 2 3\r\n9 3 3 2 1";

#[test]
fn ply_passes_over_what_it_does_not_know() {
    let mesh = mesh::read("a.ply", PLY.as_bytes()).unwrap();
    assert_eq!(mesh.points[0], DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(mesh.points[1].z, f64::from(0.1_f32));
    assert_eq!(mesh.colors[0], [0.0, 0.0, 1.0]);
    assert_eq!(mesh.triangles.len(), 4);
}

#[test]
fn ply_faults_say_the_line_or_byte() {
    let with = |from: &str, to: &str| {
        assert!(PLY.contains(from), "{from}");
        fault("a.ply", PLY.replacen(from, to, 1).as_bytes())
    };
    assert!(with("ply", "play").starts_with("a.ply, line 1: a PLY file begins"));
    assert!(with("ascii", "utf8").starts_with("a.ply, line 2: the format \"utf8\" is not known"));
    assert!(with("format", "comment").contains("declares no format"));
    assert!(with("end_header", "comment").contains("line 20: "));
    assert!(
        with("element vertex 4", "element vertex 4000000000").contains("line 7: 4000000000 of \"vertex\"")
    );
    assert!(
        with("element vertex 4", "element vertex -4").starts_with("a.ply, line 7: an element has no number")
    );
    assert!(
        with("element vertex 4", "element points 4").contains("line 23: a face has point 0, and there are 0")
    );
    assert!(with("float x", "double w").starts_with("a.ply, line 7: points have no x, y and z"));
    assert!(with("float x", "quad x").starts_with("a.ply, line 10: \"quad\" is no kind of number"));
    assert!(with("list uchar float", "list uchar").starts_with("a.ply, line 5: a property has a kind"));
    assert!(with("element camera 1\r\n", "").contains("a property is declared before any element"));
    assert!(
        with("nan 3 1 2", "nan 3 nan 2").starts_with("a.ply, line 21: a number of a point is not finite")
    );
    assert!(with("nan 3 1 2", "nan 3 one 2").starts_with("a.ply, line 21: \"one\" is no number"));
    assert!(
        with("9 4 0 1 2 3", "9 4 0 1 2 4").starts_with("a.ply, line 24: a face has point 4, and there are 4")
    );
    assert!(with("9 4 0 1 2 3", "9 4 0 1 2 0.5").starts_with("a.ply, line 24: a face has point 0.5"));
    assert!(with("9 4 0 1 2 3", "9 400000000 0 1 2 3").contains("a list of 400000000 is announced"));
    assert!(with("9 4 0 1 2 3", "9 2 0 1").contains("line 24: a face needs three corners or more, not 2"));
    assert!(
        with("9 3 3 2 1", "9 3 3 2")
            .contains("line 25: a list of 3 is announced, and the file has room for 2")
    );
    assert!(with("9 3 3 2 1", "9").contains("line 25: the file ends in the middle"));
}
