//! `orogen watch` with real files, saved as editors save them, and real pictures.

#![cfg(unix)] // Ctrl-C is sent as a signal

mod support;

use std::fs;
use support::{Bench, Running, SLOW, has, summary};

const OPTIONS: &str = "watch a.rhai --headless --size 48x48 --samples 1";

/// A ball of some size.
fn ball(radius: f64) -> String {
    format!("sphere({radius:?})")
}

/// How bright a picture is, once it can be read; it is always whole, so reading never fails later.
fn light(bench: &Bench) -> Option<f64> {
    let path = bench.path("a.png");
    path.exists().then(|| summary(&path).expect("a picture is whole at all times").2[0])
}

/// Starts watching and waits for the first picture.
fn watching(bench: &Bench, options: &str) -> (Running, f64) {
    let run = bench.start(options);
    run.wait_for("a.png: ", 1);
    let first = light(bench).unwrap();
    (run, first)
}

#[track_caller]
fn wait_for_brighter(run: &Running, bench: &Bench, than: f64) -> f64 {
    run.wait_until("a brighter picture", || light(bench).is_some_and(|now| now > than));
    light(bench).unwrap()
}

#[track_caller]
fn leaves_cleanly(run: Running) -> String {
    run.interrupt();
    let (code, said) = run.end();
    assert_eq!(code, Some(0), "{said}");
    said
}

#[test]
fn a_save_changes_the_picture_however_it_is_saved() {
    let bench = Bench::new(&[("a.rhai", &ball(0.5))]);
    let (run, first) = watching(&bench, OPTIONS);
    bench.write("a.rhai", ball(0.7));
    let second = wait_for_brighter(&run, &bench, first);
    // Many editors write a new file and rename it over the old one,
    bench.write(".a.rhai.swp", ball(0.85));
    fs::rename(bench.path(".a.rhai.swp"), bench.path("a.rhai")).unwrap();
    let third = wait_for_brighter(&run, &bench, second);
    // or move the old one away first.
    fs::rename(bench.path("a.rhai"), bench.path("a.rhai~")).unwrap();
    bench.write("a.rhai", ball(1.0));
    wait_for_brighter(&run, &bench, third);
    leaves_cleanly(run);
}

#[test]
fn imports_are_watched_too() {
    let script = "import \"parts/size\" as size; sphere(size::radius())";
    let bench = Bench::new(&[("a.rhai", script), ("parts/size.rhai", "fn radius() { 0.5 }")]);
    let (run, first) = watching(&bench, OPTIONS);
    bench.write("parts/size.rhai", "fn radius() { 0.8 }");
    let second = wait_for_brighter(&run, &bench, first);
    bench.write("parts/new", "fn radius() { 1.0 }");
    fs::rename(bench.path("parts/new"), bench.path("parts/size.rhai")).unwrap();
    wait_for_brighter(&run, &bench, second);
    leaves_cleanly(run);
}

#[test]
fn an_error_keeps_the_last_good_picture() {
    let bench = Bench::new(&[("a.rhai", &ball(0.5))]);
    let (run, first) = watching(&bench, OPTIONS);
    let good = bench.read("a.png");
    bench.write("a.rhai", "sphre(1.0)");
    run.wait_for("the last good picture stays", 1);
    assert!(bench.read("a.png") == good);
    has(&run.log(), &["sphre", "did you mean"]);
    fs::remove_file(bench.path("a.rhai")).unwrap();
    run.wait_for("the last good picture stays", 2);
    bench.write("a.rhai", ball(0.8));
    wait_for_brighter(&run, &bench, first);
    leaves_cleanly(run);
}

#[test]
fn a_script_that_appears_later_is_rendered() {
    let bench = Bench::new(&[]);
    let run = bench.start(OPTIONS);
    run.wait_for("waiting for a save", 1);
    bench.write("a.rhai", ball(1.0));
    run.wait_for("a.png: ", 1);
    leaves_cleanly(run);
}

#[test]
fn a_save_while_rendering_starts_over() {
    let bench = Bench::new(&[("a.rhai", SLOW)]);
    // The quick picture comes soon; the full one would outlast the test.
    let run = bench.start("watch a.rhai --headless --size 640x640 --samples 1024");
    run.wait_for("(preview)", 1);
    assert_eq!(bench.picture("a.png").0, 640);
    bench.write("a.rhai", "scene(#{ surface: sphere(0.1) }) // quick");
    run.wait_for("(preview)", 2);
    bench.write("a.rhai", SLOW);
    run.wait_for("(preview)", 3);
    // Ctrl-C does not wait for the end either.
    let said = leaves_cleanly(run);
    assert_eq!(
        said.lines().filter(|line| line.starts_with("a.png") && !line.contains("(preview)")).count(),
        0
    );
}

#[test]
fn a_save_without_a_change_renders_nothing() {
    let bench = Bench::new(&[("a.rhai", &ball(0.5))]);
    let (run, first) = watching(&bench, OPTIONS);
    bench.write("a.rhai", ball(0.5));
    std::thread::sleep(std::time::Duration::from_millis(300));
    assert_eq!(run.log().matches("a.png: ").count(), 1);
    bench.write("a.rhai", ball(0.9));
    wait_for_brighter(&run, &bench, first);
    leaves_cleanly(run);
}
