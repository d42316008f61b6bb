//! What a script costs: `orogen profile`, and what is at a pixel, for whoever points at it.

mod support;

use orogen::diag::Diagnostic;
use orogen::field::Watch;
use orogen::session::picking::Picker;
use orogen::session::profile::{Profile, profile};
use orogen::session::{Loaded, Order, Session};
use orogen::world::{Disk, Memory};
use serde_json::Value;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};
use support::{Bench, has, stderr, stdout};

/// Three lines of different cost, and a colour.
const ROCK: &str = "import \"std/fractal\" as fractal;
let fine = fractal::fbm(gradient(7), #{ octaves: 6, lacunarity: 2.0 }).scaled(3.0);
let coarse = 0.1 * gradient(3).scaled(2.0);
let ball = sphere(1.0);
(ball - coarse - 0.05 * fine).colored(fine)";

fn load(text: &str) -> Arc<Loaded> {
    let world = Memory([("a.rhai".into(), text.to_owned())].into());
    Session::new("a.rhai", Arc::new(world)).load(&Arc::default())
}

fn measure(text: &str, cancelled: bool) -> Result<Profile, Box<Diagnostic>> {
    let loaded = load(text);
    let scene = loaded.scene.clone().unwrap_or_else(|| panic!("{:?}", loaded.diagnostics));
    let watch = Watch { cancel: &AtomicBool::new(cancelled), progress: &|_| () };
    let order = Order { size: Some((200, 150)), ..Order::default() };
    profile(&loaded, &scene, &order, &watch)
}

/// The findings of hints about a line.
fn findings(profile: &Profile, line: u32) -> String {
    let own = profile.hints.iter().filter(|hint| hint.line.line == line);
    own.map(|hint| format!("{} / {}\n", hint.finding, hint.remedy)).collect()
}

// ---- what is measured ---------------------------------------------------------------------------

#[test]
fn shares_sum_to_one_and_none_is_negative() {
    let made = measure(ROCK, false).unwrap();
    let shading = made.shading.as_ref().unwrap();
    for cost in [&made.solid, shading] {
        assert!(cost.nanoseconds > 0.0 && cost.lines.iter().all(|line| line.share >= 0.0));
        assert!(cost.lines.is_sorted_by(|a, b| a.share >= b.share));
        let sum: f64 = cost.lines.iter().map(|line| line.share).sum();
        let nanoseconds: f64 = cost.lines.iter().map(|line| line.nanoseconds).sum();
        assert!((sum - 1.0).abs() < 1e-9 && (nanoseconds / cost.nanoseconds - 1.0).abs() < 1e-9, "{cost:?}");
    }
    let sum: f64 = made.bound.lines.iter().map(|line| line.share).sum();
    assert!((sum - 1.0).abs() < 1e-9 && made.bound.lines.iter().all(|line| line.share > 0.0));
    assert!(made.bound.mean >= made.bound.steepest && made.bound.most >= made.bound.mean);
    assert!(made.hits > 0 && made.rays > made.hits && made.evaluations > 0.0);
}

#[test]
fn time_belongs_to_the_line_that_asks_for_it() {
    let made = measure(ROCK, false).unwrap();
    let first = &made.solid.lines[0];
    assert_eq!((first.line.file.as_str(), first.line.line), ("a.rhai", 2), "{:?}", made.solid);
    assert!(first.line.text.starts_with("let fine = fractal::fbm"));
    assert!(first.share > 0.5 && first.what[0] == "fbm of 6 octaves of gradient noise", "{first:?}");
}

#[test]
fn without_the_steepest_line_the_bound_is_lower() {
    let made = measure("let bumps = 0.1 * sin(50.0 * x);\nsphere(1.0) + bumps", false).unwrap();
    let first = &made.bound.lines[0];
    assert_eq!(first.line.line, 1, "{:?}", made.bound);
    let without = first.without.unwrap();
    assert!((without - 1.0).abs() < 0.2 && made.bound.mean > 2.0, "{:?}", made.bound);
    assert!(first.looseness >= 1.0 - 1e-9);
}

#[test]
fn a_job_that_is_stopped_makes_no_profile() {
    assert!(measure(ROCK, true).unwrap_err().message.contains("stopped"));
}

#[test]
fn nothing_to_be_seen_costs_nothing() {
    let error = measure("sphere(1.0) + 9.0", false).unwrap_err();
    assert!(error.message.contains("no ray met the solid") && !error.hints.is_empty(), "{error:?}");
}

// ---- hints --------------------------------------------------------------------------------------

#[test]
fn octaves_that_no_pixel_shows_are_named() {
    let text = |options: &str| {
        format!(
            "import \"std/fractal\" as fractal;
             let n = fractal::fbm(gradient(7), #{{ octaves: 16, lacunarity: 2.0, hurst: 1.0{options} }}).scaled(4.0);
             sphere(1.0) - 0.1 * n"
        )
    };
    let wasteful = measure(&text(", detail: false"), false).unwrap();
    has(&findings(&wasteful, 2), &["of 16 octaves", "coarser than a pixel", "detail: false"]);
    let thrifty = measure(&text(""), false).unwrap();
    assert!(!findings(&thrifty, 2).contains("coarser"), "{:?}", thrifty.hints);
}

#[test]
fn what_may_have_no_value_is_named() {
    let made = measure("sphere(1.0) + 0.01 * sqrt(x)", false).unwrap();
    has(&findings(&made, 1), &["`sqrt` is not known to have a value", "max(x, 0.0)", "no bound"]);
    assert!(made.bound.unbounded > 0.0 && made.bound.unbounded < 1.0, "{:?}", made.bound);
}

#[test]
fn bounds_that_are_far_above_all_slopes_are_named() {
    let text = "import \"std/fractal\" as fractal;
let octaves = fractal::fbm(gradient(7), #{ octaves: 10, lacunarity: 2.0, hurst: 1.0 });
sphere(1.0) - 0.1 * octaves.scaled(4.0)";
    has(&findings(&measure(text, false).unwrap(), 2), &["times its steepest sample"]);
    assert_eq!(measure("sphere(1.0)", false).unwrap().hints, []);
}

#[test]
fn colors_that_take_longer_than_the_solid_are_named() {
    let text = "import \"std/fractal\" as fractal;
let paint = fractal::fbm(sparse(7), #{ octaves: 8 }).scaled(3.0);
sphere(1.0).colored(paint)";
    has(&findings(&measure(text, false).unwrap(), 2), &["colours and material take", "rays to the eye"]);
}

#[test]
fn creases_are_named_only_where_a_trial_without_them_is_less_work() {
    let folded = "import \"std/fractal\" as fractal;
let billows = fractal::turbulence(gradient(7), #{ octaves: 6 });
sphere(1.0) - 0.1 * billows.scaled(3.0)";
    // Smooth octaves, and solids that meet in few places: a smooth union would be computed everywhere.
    let joined = "import \"std/fractal\" as fractal;
let octaves = fractal::fbm(gradient(7), #{ octaves: 6 }).scaled(3.0);
let ball = sphere(0.5) - 0.05 * octaves;
min(ball.translated([-0.6, 0, 0]), ball.translated([0.6, 0, 0]))";
    for text in [folded, joined] {
        let made = measure(text, false).unwrap();
        assert!(!made.hints.iter().any(|hint| hint.finding.contains("trial")), "{:?}", made.hints);
    }
}

#[test]
fn what_is_computed_twice_is_named() {
    let text = |angle: &str| {
        format!(
            "let rock = gradient(7);
let relief = rock.scaled(3.0);
let turned = rock.scaled(3.0).rotated([0, 1, 0], {angle}).rotated([0, 1, 0], -30.0);
sphere(1.0) - 0.1 * relief - 0.1 * turned * turned"
        )
    };
    let made = measure(&text("30.0"), false).unwrap();
    has(&findings(&made, 3), &["`gradient noise` has the same values as that of line 1", "let n ="]);
    let made = measure(&text("29.0"), false).unwrap();
    assert!(!made.hints.iter().any(|hint| hint.finding.contains("same values")), "{:?}", made.hints);
}

// ---- the program --------------------------------------------------------------------------------

#[test]
fn the_table_shows_lines_with_their_shares() {
    let bench = Bench::new(&[("a.rhai", ROCK)]);
    let done = bench.run("profile a.rhai").success();
    let said = stdout(&done);
    has(
        &said,
        &["solid", "ns an evaluation", "colours, material", "bound of the slope", "let fine = fractal", "#"],
    );
    assert!(!said.contains('\x1b'));
    has(&stderr(&done), &["a.rhai:", "rays"]);
    let short = stdout(&bench.run("profile a.rhai --top 1 --color always").success());
    has(&short, &["more, see --top", "\x1b["]);
    // Bounds do not depend on how busy the machine is, as do shares of times and what is said of them.
    let bounds = |said: &str| {
        said.lines()
            .skip_while(|line| !line.contains("bound of the slope"))
            .skip(1)
            .take(3)
            .map(String::from)
            .collect::<Vec<_>>()
    };
    assert!(bounds(&said).iter().all(|line| line.contains("loose")), "{said}");
    assert!(bounds(&short)[0].contains("loose") && bounds(&short)[1].contains("in 2 more"), "{short}");
    assert_eq!(bench.names(), ["a.rhai"]);
}

#[test]
fn the_same_as_json() {
    let bench = Bench::new(&[("a.rhai", ROCK)]);
    let said: Value = serde_json::from_str(&stdout(&bench.run("profile a.rhai --json -").success())).unwrap();
    bench.run("profile a.rhai --json b.json --size 100x100").success();
    let saved: Value = serde_json::from_slice(&bench.read("b.json")).unwrap();
    for made in [said, saved] {
        let line = &made["solid"]["lines"][0];
        assert_eq!((line["file"].as_str(), line["line"].as_u64()), (Some("a.rhai"), Some(2)));
        assert!(line["share"].as_f64().unwrap() > 0.3 && made["bound"]["mean"].as_f64().unwrap() > 1.0);
    }
}

#[test]
fn wrong_scripts_are_explained() {
    let bench = Bench::new(&[("a.rhai", "sphere(1.0) +"), ("b.rhai", "sphere(1.0) + 9.0")]);
    for (arguments, pieces) in [
        ("profile nothing.rhai", &["nothing.rhai"][..]),
        ("profile a.rhai", &["a.rhai"]),
        ("profile b.rhai", &["no ray met the solid", "check the camera"]),
        ("profile b.rhai --set c=1", &["c"]),
    ] {
        let done = bench.run(arguments).code(1);
        has(&stderr(&done), pieces);
        assert_eq!(stdout(&done), "");
    }
}

// ---- picking ------------------------------------------------------------------------------------

#[test]
fn a_planet_answers_a_pointer_at_once() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/planet.rhai");
    let loaded = Session::new(&script, Arc::new(Disk)).load(&Arc::default());
    let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| () };
    let scene = loaded.scene.clone().unwrap();
    let mut picker = Picker::new(&loaded, &scene, &Order::default(), &watch).unwrap();
    let mut taken = Vec::new();
    for i in 0..101 {
        let start = Instant::now();
        let picked = picker.pick(250.0 + 3.0 * f64::from(i), 300.5);
        taken.push(start.elapsed());
        let hit = picked.hit.unwrap();
        assert!(picked.certified && hit.dominant.unwrap().line.text.len() > 3);
        assert!(hit.value.unwrap().abs() < hit.footprint && hit.color.is_some());
    }
    taken.sort();
    assert!(taken[taken.len() / 2] < Duration::from_millis(20), "{taken:?}");
}
