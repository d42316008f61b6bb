//! How long it takes to find all critical points of the thesis' test surface (8.10), and to join them.
//!
//! `cargo bench --bench critical [-- OCTAVES]`, with the most octaves that there should be; else 3.
//!
//! Wall clock seconds on as many threads as there are cores: to find the critical points, and to join them. All of them
//! are found where it says complete; components are certified where the solid is besides known to end within the region,
//! which that of sparse noise does not.

use orogen::field::Watch;
use orogen::scene::Aabb;
use orogen::script::{Request, compile};
use orogen::tape::Tape;
use orogen::topology::{Complex, Search, search};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Half the side of the cube that is searched.
const REGION: f64 = 2.0;

fn main() -> ExitCode {
    let told = std::env::args().skip(1).find(|a| !a.starts_with('-'));
    let Ok(most) = told.as_ref().map_or(Ok(3), |m| m.parse::<u32>()) else {
        eprintln!("`{}` is no number of octaves", told.unwrap_or_default());
        return ExitCode::FAILURE;
    };
    println!(
        "noise        octaves   search     join        cells  minima  1-saddles  2-saddles  maxima   sum  complete  components  certified"
    );
    for noise in ["gradient(7)", "sparse(7)"] {
        for octaves in 1..=most {
            row(noise, octaves);
        }
    }
    ExitCode::SUCCESS
}

fn row(noise: &str, octaves: u32) {
    let script = format!(
        r#"import "std/fractal" as fractal;
        sphere(1.0) + 0.8 * fractal::fbm({noise}, #{{ octaves: {octaves}, hurst: 0.8 }}).scaled(4.0)"#
    );
    let compiled = compile(&Request::text(&script));
    let Some(scene) = compiled.scene else {
        eprintln!("{:?}", compiled.diagnostics);
        return;
    };
    let tape = Arc::new(Tape::new(&scene.graph, &[scene.surface.field]));
    let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| () };
    let what = Search { region: Aabb::cube(REGION), solid: true };
    let start = Instant::now();
    let Some(found) = search(&tape, &what, &watch) else { return };
    let searched = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let Some(complex) = Complex::new(&tape, &what, found, &watch) else { return };
    let joined = start.elapsed().as_secs_f64();
    let [a, b, c, d] = complex.counts();
    println!(
        "{noise:12} {octaves:7} {searched:8.3} {joined:8.3} {:12} {a:7} {b:10} {c:10} {d:7} {:5}  {:8} {:11}  {}",
        complex.stats.cells,
        complex.euler(),
        said(complex.open.is_empty() && complex.level.is_empty()),
        complex.components.len(),
        said(complex.is_certified()),
    );
}

fn said(yes: bool) -> &'static str {
    if yes { "yes" } else { "no" }
}
