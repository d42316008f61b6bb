//! Voids of solids whose voids are known, or counted on a lattice.

use orogen::field::{Field, Watch};
use orogen::num::Many;
use orogen::scene::Scene;
use orogen::script::{Request, compile};
use orogen::session::topology::{Analysis, Purpose, Voids, analyse};
use orogen::tape::Evaluator;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rayon::prelude::*;
use std::sync::atomic::AtomicBool;

fn scene(script: &str) -> Scene {
    let compiled = compile(&Request::text(script));
    compiled.scene.unwrap_or_else(|| panic!("{script}: {:?}", compiled.diagnostics))
}

fn analysed(script: &str) -> (Analysis, Voids) {
    let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| () };
    let purpose = Purpose { fresh: true, volumes: true, voids: true };
    let mut analysis = analyse(&scene(script), purpose, &watch).unwrap_or_else(|e| panic!("{}", e.message));
    let voids = analysis.voids.take().expect("they were asked for");
    (analysis, voids)
}

/// Of solids that have as many voids, and as many in each part; those of smooth ones have handles as well.
fn known(script: &str, voids: &[usize], handles: Option<&[i64]>) -> Voids {
    let (analysis, found) = analysed(script);
    assert!(found.certified && analysis.is_certified(), "{script}: {found:?}");
    let of = |part: usize| found.list.iter().filter(|void| void.part == Some(part)).count();
    assert_eq!((0..analysis.parts.len()).map(of).collect::<Vec<_>>(), voids, "{script}: {found:?}");
    let critical: Vec<_> = analysis.parts.iter().filter_map(|part| part.critical.as_ref()).collect();
    assert_eq!(critical.len(), handles.map_or(0, <[i64]>::len), "{script}");
    for (i, (component, genus)) in critical.into_iter().zip(handles.into_iter().flatten()).enumerate() {
        assert_eq!((component.voids, component.genus), (Some(voids[i]), Some(*genus)), "{script}: {i}");
    }
    found
}

/// A little noise, which parts critical points that coincide.
const UNEVEN: &str = "0.02 * gradient(3).scaled(2.0)";

#[test]
fn smooth_shells() {
    let shells = [
        (format!("sphere(1.0) + {UNEVEN}"), vec![0], vec![0]),
        (format!("(dot(p, p) - 1.0) * (dot(p, p) - 0.36) + {UNEVEN}"), vec![1], vec![0]),
        // A ball in the void of a shell is around nothing.
        (
            format!("(dot(p, p) - 1.0) * (dot(p, p) - 0.49) * (dot(p, p) - 0.04) + 0.1 * {UNEVEN}"),
            vec![1, 0],
            vec![0, 0],
        ),
    ];
    for (script, voids, handles) in shells {
        known(&script, &voids, Some(&handles));
    }
}

#[test]
fn shells_with_creases() {
    let ring = "let q = square(sqrt(square(x) + square(z) + 1e-3) - 1.0) + square(y); \
                scene(#{ surface: (q - 0.16) * (q - 0.04), bounds: 2.0 })";
    known(ring, &[1], None);
    let hollow = known("max(sphere(1.0), -sphere(0.6))", &[1], None);
    let volume = 4.0 / 3.0 * std::f64::consts::PI * 0.216;
    assert!(hollow.list[0].volume.contains(volume) && hollow.list[0].volume.width() < 0.01, "{hollow:?}");
    // One shell in another, and a smaller one beside them.
    let script = "let shell = max(sphere(1.0), -sphere(0.8)); \
                  min(min(shell, shell.scale(0.5)), shell.scale(0.7).translate([2.5, 0, 0]))";
    let found = known(script, &[1, 1, 1], None);
    assert!(found.list[0].bounds.max.x > 0.8, "{found:?}");
    // A hole from outside leaves nothing closed off, a narrow one neither.
    let drilled = |radius: f64| {
        format!("max(max(sphere(1.0), -sphere(0.6)), min({radius:?} - length(vec3(x, y, 0)), z))")
    };
    known(&drilled(0.2), &[0], None);
    known(&drilled(0.002), &[0], None);
    known(&drilled(-1.0), &[1], None);
}

/// What the faces of the region cut is not said to be closed off, and nothing is proven.
#[test]
fn a_region_that_cuts_the_solid_proves_nothing() {
    for (script, count) in [
        ("scene(#{ surface: max(sphere(1.0), -sphere(0.6)), bounds: 0.8 })", 1),
        ("scene(#{ surface: max(sphere(1.0), -sphere(0.6)), bounds: 0.5 })", 0),
        // Nothing but cells that cannot be decided.
        (
            "scene(#{ surface: max(sphere(1.0), -sphere(0.6)), bounds: [[0.999999999, -1, -1], [3, 1, 1]] })",
            0,
        ),
    ] {
        let (_, found) = analysed(script);
        assert!(!found.certified, "{script}");
        assert_eq!(found.list.len(), count, "{script}: {found:?}");
    }
}

/// A lattice shows as many voids as critical points do, if it is fine enough for the walls and for the voids.
#[test]
fn hypertextures_have_as_many_as_on_a_lattice() {
    let decided: Vec<[usize; 2]> = (0..10).into_par_iter().filter_map(lattice_shows).collect();
    let holed = decided.iter().filter(|counts| counts[1] > 0).count();
    assert!(decided.len() >= 7 && holed >= 3, "{decided:?}");
}

/// Components and voids of a solid, if a lattice shows as many.
fn lattice_shows(seed: u64) -> Option<[usize; 2]> {
    let mut rng = StdRng::seed_from_u64(seed);
    let (amplitude, frequency) = (rng.random_range(0.7..1.1), rng.random_range(2.0..3.0));
    let script = format!("sphere(1.0) + {amplitude} * gradient({seed}).scaled({frequency})");
    let (analysis, voids) = analysed(&script);
    assert!(voids.certified, "{script}");
    let parts: Vec<_> = analysis.parts.iter().filter_map(|part| part.critical.as_ref()).collect();
    assert_eq!(parts.iter().filter_map(|c| c.voids).sum::<usize>(), voids.list.len(), "{script}");
    assert!(parts.iter().all(|c| c.genus.is_some_and(|genus| genus >= 0)), "{script}: {parts:?}");
    let counts = [parts.len(), voids.list.len()];
    [96, 192, 320].into_iter().any(|n| counted(&scene(&script), n) == counts).then_some(counts)
}

/// Parts and voids of a solid on a lattice: what is joined by faces, and what is not solid by faces, edges or corners.
fn counted(scene: &Scene, n: usize) -> [usize; 2] {
    let tape = Field::new(&scene.graph, scene.surface.field).tape().clone();
    let mut field = Evaluator::<Many<f64, 32>>::new(tape);
    let place =
        |i: usize| [i % n, i / n % n, i / n / n].map(|k| 2.4 * (2.0 * (k as f64 + 0.5) / n as f64 - 1.0));
    let axis = |axis: usize| (0..n * n * n).map(|i| place(i)[axis]).collect::<Vec<f64>>();
    let mut values = vec![0.0; n * n * n];
    field.eval_all([&axis(0), &axis(1), &axis(2)], &mut values);
    let solid: Vec<bool> = values.into_iter().map(|value| value < 0.0).collect();
    let faces: Vec<[i64; 3]> = touching(1);
    let all: Vec<[i64; 3]> = touching(3);
    // One of the parts that are not solid is outside.
    [regions(&solid, true, n, &faces), regions(&solid, false, n, &all) - 1]
}

/// Steps to neighbours that differ along so many axes at most.
fn touching(axes: i64) -> Vec<[i64; 3]> {
    let steps = (0..27).map(|k| [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1]);
    steps.filter(|step: &[i64; 3]| (1..=axes).contains(&step.iter().map(|s| s.abs()).sum())).collect()
}

/// How many regions samples of one kind make up.
fn regions(solid: &[bool], kind: bool, n: usize, steps: &[[i64; 3]]) -> usize {
    let (mut seen, mut count) = (vec![false; solid.len()], 0);
    for start in 0..solid.len() {
        if seen[start] || solid[start] != kind {
            continue;
        }
        count += 1;
        let mut open = vec![start];
        seen[start] = true;
        while let Some(i) = open.pop() {
            let at = [i % n, i / n % n, i / n / n].map(|k| k as i64);
            for step in steps {
                let next: [i64; 3] = std::array::from_fn(|axis| at[axis] + step[axis]);
                if next.iter().any(|&k| !(0..n as i64).contains(&k)) {
                    continue;
                }
                let j = (next[2] as usize * n + next[1] as usize) * n + next[0] as usize;
                if !seen[j] && solid[j] == kind {
                    seen[j] = true;
                    open.push(j);
                }
            }
        }
    }
    count
}
