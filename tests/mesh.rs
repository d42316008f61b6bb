//! Meshes of solids whose shape and topology are known.

use glam::DVec3;
use orogen::exchange::mesh::{self as file, Format, Stl};
use orogen::field::Field;
use orogen::field::Watch;
use orogen::mesh::{self, Fineness, Meshed, rounded};
use orogen::num::Many;
use orogen::scene::Aabb;
use orogen::script::{Request, compile};
use orogen::session::topology::LeftOut;
use orogen::session::{Solidified, polygonise};
use orogen::shape::{Census, Mesh, Parts};
use orogen::tape::{Evaluator, Tape};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

fn watched<T>(job: impl FnOnce(&Watch<'_>) -> T) -> T {
    job(&Watch { cancel: &AtomicBool::new(false), progress: &|_| () })
}

fn meshed(script: &str, resolution: Option<u32>, tolerance: Option<f64>) -> Meshed {
    solidified(script, resolution, tolerance).meshed
}

/// A mesh of what a box holds.
fn meshed_in(script: &str, region: &Aabb, resolution: u32) -> Meshed {
    let compiled = compile(&Request::text(script));
    let scene = compiled.scene.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics));
    let tape = Arc::new(Tape::new(&scene.graph, &[scene.surface.field]));
    let solid = mesh::Solid { tape, color: None, region: *region };
    let fineness = Fineness { resolution: Some(resolution), tolerance: None };
    watched(|watch| mesh::polygonise(&solid, &fineness, watch)).expect("a mesh")
}

fn solidified(script: &str, resolution: Option<u32>, tolerance: Option<f64>) -> Solidified {
    let compiled = compile(&Request::text(script));
    let scene = compiled.scene.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics));
    watched(|watch| polygonise(&scene, &Fineness { resolution, tolerance }, watch)).expect("a mesh")
}

/// The volume that a closed mesh encloses; negative if it is inside out.
fn volume(m: &Meshed) -> f64 {
    let six = |t| {
        let [a, b, c] = m.mesh.corners(t);
        a.dot(b.cross(c))
    };
    (0..m.mesh.triangles.len()).map(six).sum::<f64>() / 6.0
}

fn check(script: &str, m: &Meshed) -> Census {
    check_files(script, &m.mesh);
    let census = Census::of(&m.mesh);
    assert!(volume(m) > 0.0, "{script}: inside out");
    census
}

/// A mesh is a closed manifold, and stays one in every file though readers take equal points for one.
fn check_files(script: &str, mesh: &Mesh) {
    assert_eq!(mesh.check(), Ok(()));
    assert_eq!(mesh.normals.len(), mesh.points.len());
    for mesh in [mesh, &rounded(mesh)] {
        let census = Census::of(mesh);
        assert!(census.is_closed_manifold(), "{script}: {} flawed points", census.flawed_points);
        let places: BTreeSet<[u64; 3]> =
            mesh.points.iter().map(|p| (*p + 0.0).to_array().map(f64::to_bits)).collect();
        assert_eq!(places.len(), mesh.points.len(), "{script}: equal points");
    }
}

/// Triangles of which no corner is so far from the opposite side as that share of the cells.
fn slivers(m: &Meshed, share: f64) -> usize {
    let height = |t| {
        let [a, b, c] = m.mesh.corners(t);
        let longest = (b - a).length().max((c - b).length()).max((a - c).length());
        (b - a).cross(c - a).length() / longest
    };
    (0..m.mesh.triangles.len()).filter(|t| height(*t) <= share * m.cell).count()
}

#[test]
fn known_topology() {
    // Script, parts, Euler characteristic.
    let known = [
        ("sphere(1.0)", 1, 2),
        ("torus(1.0, 0.4)", 1, 0),
        ("box([2, 1, 1])", 1, 2),
        ("union(sphere(1.0), sphere(0.5).translated([2, 0, 0]))", 2, 4),
        ("shell(sphere(1.0), 0.3)", 2, 4),
        ("difference(box(2.0), cylinder(0.5, 3.0))", 1, 0),
        ("union(torus(1.0, 0.2), torus(1.0, 0.2).rotate([1, 0, 0], 90))", 1, -4),
        ("capsule([-1, 0, 0], [1, 1, 0], 0.25)", 1, 2),
    ];
    for (script, parts, euler) in known {
        for (resolution, tolerance) in
            [(Some(24), None), (Some(57), None), (Some(64), Some(0.01)), (None, Some(0.004))]
        {
            let m = meshed(script, resolution, tolerance);
            let census = check(script, &m);
            assert_eq!(
                (census.parts, census.euler_characteristic()),
                (parts, euler),
                "{script} {resolution:?} {tolerance:?}"
            );
        }
    }
}

/// Where triangles are merged none is turned over: all face the way that the field rises.
#[test]
fn merged_triangles_face_outwards() {
    for (script, tolerance) in [
        ("difference(box(2.0), cylinder(0.5, 4.0))", 0.001),
        ("sphere(1.0) + 0.25 * gradient(7).scaled(2.5)", 0.01),
    ] {
        let m = meshed(script, None, Some(tolerance));
        check(script, &m);
        let compiled = compile(&Request::text(script)).scene.expect("a scene");
        let mut field = Field::new(&compiled.graph, compiled.surface.field);
        let is_turned = |t: &usize| {
            let [a, b, c] = m.mesh.corners(*t);
            let area = (b - a).cross(c - a);
            // Beside the middle of a large enough triangle the field tells which side is which.
            let (middle, off) = ((a + b + c) / 3.0, 0.3 * area.length().sqrt() * area.normalize_or_zero());
            area.length() > 0.02 * m.cell * m.cell && field.value(middle + off) < field.value(middle - off)
        };
        let turned = (0..m.mesh.triangles.len()).filter(is_turned).count();
        assert_eq!(turned, 0, "{script}");
    }
}

/// Directions have no value at the centre of a planet, which may be a corner of the lattice.
#[test]
fn planets_have_no_void_at_their_centres() {
    for resolution in [32, 48, 64] {
        let script = "sphere(1.0) - 0.1 * gradient(7).scaled(4.0).on_sphere()";
        let m = meshed(script, Some(resolution), None);
        assert_eq!(check(script, &m).parts, 1, "{resolution}");
    }
    // What has no value in a half of space ends there all the same.
    let half = meshed("sphere(1.0) + 1e-9 * sqrt(y)", Some(32), None);
    let lowest = half.mesh.points.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    assert!(lowest.abs() < 0.1, "{lowest}");
}

/// The Euler characteristic of the surface of a solid, counted without a mesh: twice that of the closed cubes
/// around those points of a lattice that are inside.
fn counted(script: &str, half: f64, n: usize) -> i64 {
    let scene = compile(&Request::text(script)).scene.expect("a scene");
    let tape = Arc::new(Tape::new(&scene.graph, &[scene.surface.field]));
    let place = |i: usize| half * (2.0 * (i as f64 + 0.5) / n as f64 - 1.0);
    let plane = |field: &mut Evaluator<Many<f64, 32>>, k: usize| {
        let axis = |of: fn(usize, usize) -> usize| (0..n * n).map(|i| place(of(i, n))).collect::<Vec<f64>>();
        let mut values = vec![0.0; n * n];
        field.eval_all([&axis(|i, n| i % n), &axis(|i, n| i / n), &vec![place(k); n * n]], &mut values);
        values.into_iter().map(|value| value < 0.0).collect::<Vec<bool>>()
    };
    let planes = (0..n).into_par_iter().map_init(|| Evaluator::new(tape.clone()), plane);
    let inside = planes.collect::<Vec<_>>().concat();
    // Corners, edges, faces and cubes of the lattice are at half steps; each is there if a cube beside it is.
    let cubes = |i: usize| [i.checked_sub(1).map(|i| i / 2), Some(i / 2).filter(|i| *i < n)];
    let sides: Vec<_> = (0..=2 * n).map(cubes).collect();
    let beside = |i: usize| sides[i].iter().flatten();
    let is_there = |[x, y, z]: [usize; 3]| {
        beside(z).any(|k| beside(y).any(|j| beside(x).any(|i| inside[(k * n + j) * n + i])))
    };
    let size = 2 * n + 1;
    let mut sum = 0;
    for i in 0..size * size * size {
        let at = [i % size, i / size % size, i / size / size];
        if is_there(at) {
            sum += if at.iter().sum::<usize>() % 2 == 0 { 1 } else { -1 };
        }
    }
    2 * sum
}

#[test]
fn topology_is_that_of_a_count_of_cubes() {
    let tangle = "polynomial(\"x^4 - 5 x^2 + y^4 - 5 y^2 + z^4 - 5 z^2 + 11.8\")";
    let clebsch = "import \"std/algebraic\" as algebraic; algebraic::clebsch(2.0)";
    let mitchell = "import \"std/algebraic\" as algebraic; algebraic::mitchell()";
    // Seeds whose necks and crumbs are wider than cells.
    let noisy = |seed| format!("sphere(1.0) + 0.8 * gradient({seed}).scaled(2.0)");
    let known =
        [(tangle.to_owned(), 3.0, Some(-8)), (clebsch.into(), 2.2, None), (mitchell.into(), 2.2, None)];
    let random = [2, 4, 7, 8, 11, 12].map(|seed| (noisy(seed), 2.0, None));
    for (script, half, euler) in known.into_iter().chain(random) {
        let expected = counted(&script, half, 224);
        assert_eq!(
            check(&script, &meshed(&script, Some(128), None)).euler_characteristic(),
            expected,
            "{script}"
        );
        assert!(euler.is_none_or(|euler| euler == expected), "{script}: {expected}");
    }
}

#[test]
fn random_solids_are_closed_manifolds() {
    for seed in 0..4 {
        for (resolution, tolerance) in [(20, None), (31, None), (32, Some(0.05)), (40, Some(0.01))] {
            let script = format!("sphere(1.0) + 0.5 * gradient({seed}).scaled(3.0)");
            check(&script, &meshed(&script, Some(resolution), tolerance));
            let script = format!("max(sphere(1.0), 0.2 - abs(sparse({seed}).scaled(4.0)))");
            check(&script, &meshed(&script, Some(resolution), tolerance));
            let script = format!("max(box(1.5), 0.3 - cellular({seed}).scaled(3.0))");
            check(&script, &meshed(&script, Some(resolution), tolerance));
        }
    }
}

#[test]
fn the_mesh_lies_on_the_surface() {
    let script = "sphere(1.0) + 0.2 * gradient(3).scaled(2.0)";
    let scene = compile(&Request::text(script)).scene.expect("a scene");
    let mut field = Field::new(&scene.graph, scene.surface.field);
    for tolerance in [0.02, 0.005, 0.001] {
        let m = meshed(script, None, Some(tolerance));
        check(script, &m);
        assert!(m.deviation.most <= tolerance, "{:?} > {tolerance}", m.deviation);
        // Denser samples than were looked at: the middles of edges.
        for t in 0..m.mesh.triangles.len() {
            let [a, b, _] = m.mesh.corners(t);
            let (value, gradient) = field.gradient(0.5 * (a + b));
            assert!(value.abs() / gradient.length() <= 1.5 * tolerance, "{value} at an edge of triangle {t}");
        }
        for (p, n) in m.mesh.points.iter().zip(&m.mesh.normals) {
            assert!(n.dot(field.gradient(*p).1.normalize()) > 0.8);
        }
    }
    let sphere = meshed("sphere(1.0)", Some(100), None);
    assert!((volume(&sphere) / (4.0 / 3.0 * std::f64::consts::PI) - 1.0).abs() < 1e-3, "{}", volume(&sphere));
}

#[test]
fn meshes_are_no_farther_from_the_surface_than_is_said() {
    // To first order the distances from these are thirds and fifths of what they are, not numbers, and nothing.
    let spheres =
        ["powi(sphere(1.0), 3)", "powi(sphere(1.0), 5)", "1e-200 * sphere(1.0)", "1e160 * sphere(1.0)"];
    for (script, tolerance) in spheres.into_iter().flat_map(|s| [(s, None), (s, Some(0.1))]) {
        let m = meshed(script, Some(24), tolerance);
        let farthest = m.mesh.points.iter().map(|p| (p.length() - 1.0).abs()).fold(0.0, f64::max);
        assert!(m.deviation.unknown == 0, "{script}: {:?}", m.deviation);
        assert!(farthest <= 1.02 * m.deviation.most && m.deviation.most < 0.2, "{script}: {:?}", m.deviation);
    }
    let jumping = meshed("sign(sphere(1.0))", Some(24), None).deviation;
    assert!(jumping.unknown == jumping.samples && jumping.samples > 0, "{jumping:?}");
}

#[test]
fn sharp_edges_are_kept() {
    let script = "box([2, 1, 0.5]).rotate([1, 2, 3], 40)";
    let missing = |resolution, tolerance| 1.0 - volume(&meshed(script, Some(resolution), tolerance));
    let (coarse, fine) = (missing(32, None), missing(128, None));
    assert!(coarse.abs() < 5e-3 && fine.abs() < 5e-4, "{coarse} {fine}");
    let flat = meshed(script, Some(128), Some(1e-3));
    check("box", &flat);
    assert!((volume(&flat) - 1.0).abs() < 5e-4, "{}", volume(&flat));
    let triangles = meshed(script, Some(128), None).mesh.triangles.len();
    assert!(flat.mesh.triangles.len() < triangles / 10, "{} of {triangles}", flat.mesh.triangles.len());
}

#[test]
fn triangles_have_an_area() {
    let prism = "polygon([[-0.7, -0.5], [0.7, -0.5], [0, 0.8]])";
    let extruded = format!("import \"std/arrange\" as arrange; arrange::extrude({prism}, 0.6)");
    let solids = [
        extruded.as_str(),
        &format!("max({prism}, abs(z) - 0.3)"),
        "pyramid(4, 0.8, 1.0)",
        "box([2, 1, 1]).rotated([1, 2, 3], 33)",
        "tetrahedron(0.4)",
    ];
    for script in solids {
        // With an odd number of cells no plane between them is one of symmetry: in such a plane all four vertices around an edge
        // of the lattice may lie on one edge of the solid.
        for (resolution, tolerance) in [(None, None), (Some(47), None), (Some(64), Some(0.002))] {
            let m = meshed(script, resolution, tolerance);
            check(script, &m);
            let mut file = Vec::new();
            file::write(Format::Stl(Stl::Binary), &rounded(&m.mesh), &mut file).expect("a file");
            let read = file::read("a.stl", &file).expect("a mesh");
            assert!(Census::of(&read).is_closed_manifold(), "{script} {resolution:?}: holes in the file");
            // Merging may leave a triangle along an edge of the solid that nothing else could take the place of.
            let few = if tolerance.is_none() { m.mesh.triangles.len() / 10_000 } else { 100 };
            assert!(slivers(&m, 1e-6) <= few, "{script} {resolution:?}: {} of {few}", slivers(&m, 1e-6));
        }
    }
}

/// The field of what is drawn out is as exact on its surface as elsewhere, but has no gradient just there.
#[test]
fn normals_are_found_where_the_gradient_is_none() {
    let prism = "polygon([[-0.7, -0.5], [0.7, -0.5], [0, 0.8]])";
    // In the same cells.
    let region = Aabb { min: DVec3::new(-0.75, -0.55, -0.35), max: DVec3::new(0.75, 0.85, 0.35) };
    let of = |field: &str| meshed_in(&format!("let f = {prism}; max({field}, abs(z) - 0.3)"), &region, 48);
    let plain = of("f");
    for outside in ["length(vec3(max(f, 0), 0, 0))", "max(f, 0)"] {
        let m = of(&format!("{outside} + min(f, 0)"));
        assert!(m.deviation.most <= plain.deviation.most + 1e-6 * m.cell, "{outside}: {:?}", m.deviation);
        let turned = m.mesh.normals.iter().zip(&plain.mesh.normals).filter(|(a, b)| a.distance(**b) > 1e-6);
        assert_eq!((turned.count(), m.mesh.normals.len()), (0, plain.mesh.normals.len()), "{outside}");
    }
}

/// Tips that hang together with a body by a diagonal only are cut off, and what does not is not.
#[test]
fn tips_are_no_crumbs() {
    for script in ["tetrahedron(0.4)", "tetrahedron(0.4).rotated([1, 0, 0], 90)"] {
        for resolution in [None, Some(64), Some(100)] {
            assert_eq!(check(script, &meshed(script, resolution, None)).parts, 1, "{script} {resolution:?}");
        }
    }
}

/// A ball about as large as a cell holds one corner of the lattice, as a tip does, and a narrow gap parts it from the body.
#[test]
fn specks_stay() {
    let is_speck = |i: i32| {
        let cell = 1.0 / 32.0;
        let at = 0.5 + (0.55 / 3.0_f64.sqrt() + 0.2 + 0.01 * f64::from(i)) * cell;
        let ball = format!("sphere({}).translated([{at}, {at}, {at}])", 0.55 * cell);
        let m = meshed(&format!("union(box(1.0), {ball})"), Some(32), None);
        let volumes = Parts::of(&m.mesh).volumes(&m.mesh);
        volumes.len() == 2 && volumes[1] < m.cell * m.cell * m.cell
    };
    let specks = (0..40).filter(|i| is_speck(*i)).count();
    assert!(specks > 10, "{specks}");
}

#[test]
fn merging_saves_triangles() {
    let script = "sphere(1.0)";
    let (fine, coarse) = (meshed(script, Some(128), None), meshed(script, Some(128), Some(0.01)));
    assert!(10 * coarse.mesh.triangles.len() < fine.mesh.triangles.len(), "{}", coarse.mesh.triangles.len());
}

#[test]
fn what_may_be_missed_is_said() {
    assert_eq!(meshed("sphere(1.0)", Some(32), None).doubtful, 0);
    assert_eq!(meshed("box([2, 1, 1]).rotate([1, 2, 3], 40)", Some(32), None).doubtful, 0);
    // Smaller than a cell, and no corner in it.
    let crumb = "union(sphere(1.0), sphere(0.003).translated([1.2345, 0.123, 0.321]))";
    let m = meshed(crumb, Some(32), None);
    let doubt = m.doubt.expect("a doubt");
    assert_eq!(Census::of(&m.mesh).parts, 1);
    assert!((doubt - DVec3::new(1.2345, 0.123, 0.321)).length() < 2.0 * m.cell, "{doubt}");
    // A sheet between two layers of corners.
    let m = meshed_in("max(box(2.0), abs(y - 0.0123) - 0.005)", &Aabb::cube(1.2), 32);
    assert!(m.doubtful > 10 && 10 * m.hidden > m.shown + m.hidden, "{} of {}", m.hidden, m.shown);
    // A corner that is told by its distance, and gradients around it.
    let square = "max(polygon([[-1, -1], [1, -1], [1, 1], [-1, 1]]), abs(z) - 0.3)";
    assert_eq!(meshed(square, Some(32), None).doubtful, 0);
    // The same, of two that overlap, of which no more than distances is known: what cannot be proven is there all the same.
    let halves = "[[-1, -1], [0.2, -1], [0.2, 1], [-1, 1]], [[-0.2, -1], [1, -1], [1, 1], [-0.2, 1]]";
    let m = meshed(&format!("max(polygon([{halves}]), abs(z) - 0.3)"), Some(32), None);
    assert!(m.doubtful > 10 && m.hidden == 0, "{} of {}", m.hidden, m.shown);
}

#[test]
fn what_has_no_end_is_cut_off() {
    let m = meshed("y + 0.1 * gradient(1)", Some(40), None);
    assert_eq!(check("plain", &m).euler_characteristic(), 2);
}

#[test]
fn the_same_on_any_number_of_threads() {
    let script = "sphere(1.0) + 0.3 * gradient(5).scaled(4.0)";
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| meshed(script, Some(48), Some(0.01)).mesh)
    };
    let (one, four) = (on(1), on(4));
    assert_eq!(one, four);
    assert!(
        one.points
            .iter()
            .zip(&four.points)
            .all(|(a, b)| a.to_array().map(f64::to_bits) == b.to_array().map(f64::to_bits))
    );
}

#[test]
fn jobs_stop() {
    let scene = compile(&Request::text("sphere(1.0)")).scene.expect("a scene");
    let watch = Watch { cancel: &AtomicBool::new(true), progress: &|_| () };
    let fineness = Fineness { resolution: Some(64), tolerance: None };
    assert!(polygonise(&scene, &fineness, &watch).is_err());
}

/// What a mesh leaves out is what the scene does not keep, and nothing of the rest moves.
#[test]
fn meshes_hold_what_is_kept() {
    let rock = "sphere(1.0) + 0.8 * gradient(7).scaled(4.0)";
    let whole = meshed(rock, Some(96), None).mesh;
    let made = solidified(&format!("largest_component({rock})"), Some(96), None);
    let (parts, kept) = (Parts::of(&whole), Parts::of(&made.meshed.mesh));
    assert!(made.left_out.parts > 40 && made.left_out.joined == 0, "{:?}", made.left_out);
    assert_eq!(kept.count() + made.left_out.parts, parts.count());
    let bodies = kept.volumes(&made.meshed.mesh).iter().filter(|volume| **volume > 0.0).count();
    assert!(bodies > 1 && bodies == 1 + made.left_out.parted, "{:?}", made.left_out);
    let fine = solidified(&format!("largest_component({rock})"), Some(256), None);
    assert_eq!(fine.left_out, LeftOut { parts: 49, parted: 1, ..LeftOut::default() });
    assert!(made.warnings.is_empty(), "{:?}", made.warnings);
    let volumes = parts.volumes(&whole);
    let largest = volumes.iter().copied().fold(0.0, f64::max);
    let main = kept.volumes(&made.meshed.mesh).into_iter().fold(0.0, f64::max);
    assert_eq!(main, largest);
    let points = |mesh: &orogen::shape::Mesh| -> std::collections::BTreeSet<[u64; 3]> {
        mesh.points.iter().map(|p| p.to_array().map(f64::to_bits)).collect()
    };
    assert!(points(&made.meshed.mesh).is_subset(&points(&whole)));
}

#[test]
fn meshes_say_what_they_are_too_coarse_for() {
    let left_out = |script: &str, resolution: u32| solidified(script, Some(resolution), None).left_out;
    let none = LeftOut::default();
    // A large ball with a small one beside it: either is kept.
    let two = "min(sphere(1.0), sphere(0.3).translated([1.6, 0, 0]))";
    for (keep, volume) in [("largest_component(f)", 4.18), ("component_of(f, [1.6, 0, 0])", 0.113)] {
        let made = solidified(&format!("let f = {two}; {keep}"), Some(64), None);
        assert_eq!(made.left_out, LeftOut { parts: 1, ..none }, "{keep}");
        let found = Parts::of(&made.meshed.mesh).volumes(&made.meshed.mesh);
        assert!(found.len() == 1 && (found[0] / volume - 1.0).abs() < 0.02, "{keep} {found:?}");
    }
    // One within the other: its void stays.
    let shell = "let f = min(abs(sphere(1.0)) - 0.1, sphere(0.3)); largest_component(f)";
    let made = solidified(shell, Some(64), None);
    assert_eq!(made.left_out, LeftOut { parts: 1, ..none });
    assert_eq!(Parts::of(&made.meshed.mesh).count(), 2);
    // A thin neck.
    let neck =
        "largest_component(min(min(sphere(0.5).translated([-1, 0, 0]), sphere(0.5).translated([1, 0, 0])),
                                      max(abs(x) - 1.0, length(vec3(0, y + 0.013, z + 0.017)) - 0.02)))";
    assert_eq!(left_out(neck, 20), LeftOut { parted: 1, ..none });
    assert_eq!(left_out(neck, 160), none);
    // A crumb that is joined with something a thousand times as large.
    let crumb =
        "largest_component(min(sphere(1.0), max(sphere(0.06).translated([1.0, 0, 0]), 1.01 - sphere(0.0))))";
    assert_eq!(left_out(crumb, 80), LeftOut { joined: 1, ..none });
    // A thin gap.
    let gap =
        "largest_component(min(sphere(1.0), max(sphere(0.5).translated([1.0, 0, 0]), 1.03 - sphere(0.0))))";
    assert_eq!(left_out(gap, 22), LeftOut { joined: 1, ..none });
    assert_eq!(left_out(gap, 200), LeftOut { parts: 1, ..none });
}

#[test]
fn what_is_no_box_has_no_mesh() {
    let scene = compile(&Request::text("sphere(1.0)")).scene.expect("a scene");
    let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| () };
    let (small, large) = (DVec3::splat(-1.5), DVec3::splat(1.5));
    for (min, max) in [(large, small), (small, small), (DVec3::NAN, large), (small, DVec3::INFINITY)] {
        let bounds = Some(Aabb { min, max });
        let scene = orogen::scene::Scene { bounds, ..scene.clone() };
        let fineness = Fineness { resolution: Some(8), tolerance: None };
        let error = polygonise(&scene, &fineness, &watch).expect_err("no mesh");
        assert!(error.message.contains("bounds"), "{error}");
        let error =
            orogen::session::topology::analyse(&scene, Default::default(), &watch).expect_err("no parts");
        assert!(error.message.contains("bounds"), "{error}");
        let search = orogen::topology::Search { region: Aabb { min, max }, solid: true };
        let tape = Field::new(&scene.graph, scene.surface.field).tape().clone();
        assert!(orogen::topology::search(&tape, &search, &watch).is_some());
    }
}

/// The share of the surface that is in triangles whose corners differ in colour.
fn mixed(mesh: &Mesh) -> f64 {
    let areas = |t: usize| {
        let [a, b, c] = mesh.corners(t);
        let [p, q, r] = mesh.triangles[t].map(|i| mesh.colors[i as usize][0]);
        let is_mixed = (p - q).abs().max((q - r).abs()) > 0.1;
        let area = (b - a).cross(c - a).length();
        [area, if is_mixed { area } else { 0.0 }]
    };
    let sums = (0..mesh.triangles.len()).map(areas).fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]);
    sums[1] / sums[0]
}

#[test]
fn triangles_of_one_colour_are_merged() {
    let board = "let c = modulo(floor(3.1 * x) + floor(3.1 * y) + floor(3.1 * z), 2.0); box(1.9).colored(c)";
    for resolution in [40, 64] {
        let fine = meshed(board, Some(resolution), None);
        let merged = meshed(board, Some(resolution), Some(0.005));
        check_files(board, &merged.mesh);
        let [before, after] = [&fine, &merged].map(|m| mixed(&m.mesh));
        assert!(after < 1.3 * before, "{after} of the surface is of mixed colours, {before} before");
        let [all, left] = [&fine, &merged].map(|m| m.mesh.triangles.len());
        assert!(3 * left < 2 * all, "{left} of {all} triangles are left");
        assert_eq!(merged.colorless, 0);
    }
    let odd = meshed("sphere(1.0).colored(sqrt(x))", Some(16), None);
    assert!(odd.colorless > 0 && odd.mesh.colors.iter().all(|c| c[0].is_finite()));
}
