//! How far cells alone get with the components of a sphere and octaves of noise, smooth and creased.
//!
//! `cargo bench --bench flood [-- OCTAVES]`, with the most octaves that there should be; else 3.

use orogen::field::{Field, Watch};
use orogen::scene::Aabb;
use orogen::script::{Request, compile};
use orogen::topology::flood::{Limits, components};
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Octaves, whose noise is `{}`.
const NOISES: [(&str, &str); 3] =
    [("smooth", "{}"), ("ridged", "(2.0 * abs({}) - 0.5)"), ("sharp", "(0.5 - 2.0 * abs({}))")];

fn main() -> ExitCode {
    let told = std::env::args().skip(1).find(|a| !a.starts_with('-'));
    let Ok(most) = told.as_ref().map_or(Ok(3), |m| m.parse::<u32>()) else {
        eprintln!("`{}` is no number of octaves", told.unwrap_or_default());
        return ExitCode::FAILURE;
    };
    println!("noise   octaves  components  certified  undecided       cells  depth  seconds");
    for octaves in 1..=most {
        NOISES.iter().for_each(|(name, noise)| row(name, noise, octaves));
    }
    ExitCode::SUCCESS
}

fn row(name: &str, noise: &str, octaves: u32) {
    let octave = |i: u32| {
        let (amplitude, frequency) =
            (0.8 * libm::pow(2.0, -0.8 * f64::from(i)), 4.0 * libm::exp2(f64::from(i)));
        let own = format!("gradient({}).scaled({frequency:?})", i + 1);
        format!(" + {amplitude:?} * {}", noise.replace("{}", &own))
    };
    let script = format!("sphere(1.0){}", (0..octaves).map(octave).collect::<String>());
    let compiled = compile(&Request::text(&script));
    let Some(scene) = compiled.scene else {
        eprintln!("{:?}", compiled.diagnostics);
        return;
    };
    let field = Field::new(&scene.graph, scene.surface.field);
    let limits = Limits { cells: 1 << 24, ..Limits::default() };
    let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| () };
    let start = Instant::now();
    let Ok(found) = components(field.tape(), &Aabb::cube(2.0), limits, &watch) else { return };
    let seconds = start.elapsed().as_secs_f64();
    let sure = found.list.iter().filter(|c| c.certified).count();
    println!(
        "{name:8}{octaves:7} {:11} {sure:10} {:10} {:11} {:6} {seconds:8.1}",
        found.list.len(),
        found.undecided.len(),
        found.cells,
        found.depth,
    );
}
