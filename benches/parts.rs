//! What scenes of many parts cost: a field of goblets, of which the camera sees the eighty in the middle
//! however many there are; and a tenth of them with as many parts that nobody sees, and with twice as many.
//!
//! `cargo bench --bench parts [-- MOST]`, with the most goblets that there should be; else 10,000.
//!
//! CPU seconds of one thread, and seconds of scripts. A picture has 320 x 240 pixels, one sample each, and
//! shadows.

#[allow(dead_code)] // this bench has a view of its own
mod view;

use orogen::render::{Job, Picture};
use orogen::scene::Scene;
use orogen::script::{Request, compile};
use orogen::session::{Order, on_threads, render};
use std::num::NonZeroUsize;
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// The goblets of `scripts/parts.rhai` from above.
const SCRIPT: &str = r#"
fn goblet(at) {
    let stem = cylinder(0.3, 2.0).translated([0, 1, 0]);
    let bowl = difference(sphere(0.62), sphere(0.5).translated([0, 0.25, 0]));
    union(stem, bowl.translated([0, 2, 0])).translated(at)
}
fn seed(i) {
    let radius = 1.1 * sqrt(i + 0.5);
    [radius * cos(137.50776405 * i), 0, radius * sin(137.50776405 * i)]
}
let field = plane([0, 1, 0], 0);
for i in 0..PARTS {
    let at = seed(i);
    let x = at[0];
    let z = at[2];
    field = union(field, goblet(at));
    for k in 0..TIMES { HIDDEN }
}
scene(#{
    surface: field,
    camera:  orbit(#{ distance: 25.0, azimuth: 25.0, elevation: 70.0, fov: 45.0 }),
    bounds:  120.0,
})
"#;

/// Parts that nobody sees, one a goblet, and where they are, as often as there are.
const HIDDEN: [(&str, &str); 3] = [
    ("under the ground", "field = union(field, goblet([x + 0.1 * k, -8 - k, z]));"),
    ("out of view", "field = union(field, goblet([x + 80 + 0.3 * k, 0, z]));"),
    ("inside the stems", "field = union(field, sphere(0.2).translated([x, 0.7 + 0.05 * k, z]));"),
];

fn main() -> ExitCode {
    let told = std::env::args().skip(1).find(|a| !a.starts_with('-'));
    let most = match told.as_ref().map_or(Ok(10_000), |m| m.parse()) {
        Ok(most @ 10..=20_000) => most,
        _ => {
            eprintln!("`{}` is no number from 10 to 20000", told.unwrap_or_default());
            return ExitCode::FAILURE;
        }
    };
    println!(
        "| goblets | nodes | script, s | picture, s | us/ray | tapes pruned | their mean | whole tape |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for parts in [10, 100, 1000, 10_000].into_iter().filter(|&p| p <= most) {
        measure(&parts.to_string(), parts, ("", 0));
    }
    let parts = most / 10;
    println!(
        "\n| hidden beside {parts} | nodes | script, s | picture, s | us/ray | tapes pruned | their mean | whole tape |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    measure("none", parts, ("", 0));
    for (name, hidden) in HIDDEN {
        for times in [1, 2] {
            measure(&format!("{name}, {times} each"), parts, (hidden, times));
        }
    }
    ExitCode::SUCCESS
}

fn measure(name: &str, parts: usize, (hidden, times): (&str, usize)) {
    let text = SCRIPT.replace("PARTS", &parts.to_string()).replace("HIDDEN", hidden);
    let text = text.replace("TIMES", &times.to_string());
    // Scripts run on a thread of their own.
    let watch = Instant::now();
    let compiled = compile(&Request::text(&text));
    let script = watch.elapsed().as_secs_f64();
    let Some(scene) = compiled.scene else {
        eprintln!("{:?}", compiled.diagnostics);
        return;
    };
    let (picture, seconds) = picture(&scene);
    let (stats, prunings) = (&picture.stats, picture.stats.prunings);
    let rays = stats.primary.rays + stats.shadow.rays;
    println!(
        "| {name} | {} | {script:.3} | {seconds:.2} | {:.1} | {} | {} | {} |",
        scene.graph.len(),
        1e6 * seconds / rays as f64,
        prunings.tapes,
        prunings.instructions / prunings.tapes.max(1),
        prunings.whole
    );
}

/// A picture, and the time that the thread took that made it.
fn picture(scene: &Scene) -> (Picture, f64) {
    let order = Order { size: Some((320, 240)), samples: Some(1), ..Order::default() };
    on_threads(NonZeroUsize::new(1), || {
        let watch = view::Stopwatch::start();
        let picture = render(scene, &order, &Job::unwatched(&AtomicBool::new(false)));
        (picture.expect("a scene that can be drawn"), watch.seconds())
    })
    .expect("a thread")
}
