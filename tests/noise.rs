//! `orogen noise`, driven as a user drives it.

mod support;

use support::{Bench, has, stderr, stdout};

/// So little that it takes no time; enough for every figure.
const SMALL: &str = "--seeds 4 --cells 8 --samples 4 --size 240";

#[test]
fn a_noise_comes_with_figures_numbers_and_verdicts() {
    let bench = Bench::new(&[]);
    let run = bench.run(&format!("noise gradient {SMALL} -o out")).success();
    has(&stdout(&run), &["mean", "variance", "stationary", "isotropic", "band-pass", "4 realisations"]);
    has(&stderr(&run), &["out/sample.png", "out/analysis.json", "out/sphere.png"]);
    for name in ["sample", "autocovariance", "spectrum", "radial", "anisotropy", "sphere"] {
        let (width, height, mean) = bench.picture(&format!("out/{name}.png"));
        assert!(width == 240 && (150..=240).contains(&height), "{name}: {width}x{height}");
        assert!(mean[0] > 5.0 && mean[0] < 250.0, "{name}: {mean:?}");
    }
    let numbers: serde_json::Value = serde_json::from_slice(&bench.read("out/analysis.json")).unwrap();
    assert_eq!(numbers["noise"], "gradient");
    assert_eq!(numbers["realisations"], 4);
    assert_eq!(numbers["periodic"], true);
    assert!(
        (numbers["moments"]["variance"].as_f64().unwrap() - 0.073).abs() < 0.01,
        "{}",
        numbers["moments"]
    );
    assert!(numbers["radial"]["rings"].as_array().unwrap().len() == 8);
    assert!(numbers["covariance"]["matrix"].as_array().unwrap().len() == 128 * 128);
}

#[test]
fn the_results_do_not_depend_on_threads() {
    let bench = Bench::new(&[]);
    for threads in [1, 2] {
        bench.run(&format!("noise fbm --octaves 2 {SMALL} --threads {threads} -o {threads}")).success();
    }
    for name in ["sample.png", "spectrum.png", "radial.png", "sphere.png", "analysis.json"] {
        assert!(bench.read(&format!("1/{name}")) == bench.read(&format!("2/{name}")), "{name}");
    }
}

#[test]
fn every_noise_and_every_sum_can_be_analysed() {
    let bench = Bench::new(&[]);
    let kinds = orogen::noise::Kind::ALL.iter().map(|k| k.name).collect::<Vec<_>>();
    for kind in kinds.into_iter().chain(["fbm", "ridged", "altitude1", "altitude2"]) {
        bench.run(&format!("noise {kind} {SMALL} --only analysis -o out")).success();
    }
}

#[test]
fn expressions_and_scripts_are_analysed() {
    let bench = Bench::new(&[
        ("wavy.rhai", "let k = param(\"k\", 1.0, 0.5..4.0); gradient(3).scaled(k)"),
        ("warped.rhai", "let s = param(\"seed\", 7, 0..1000); gradient(s).at(p + 0.1 * sin(vec3(y, z, x)))"),
        ("fixed.rhai", "gradient(7) + 1.0"),
        ("text.rhai", "\"hello\""),
        ("broken.rhai", "gradient(7"),
    ]);
    let run = |kind: &str| format!("noise {kind} {SMALL} --only analysis --only radial -o out");
    bench.run(&run("gradient(7).scaled(2.0)")).success();
    bench.run(&run("wavy.rhai --set k=2")).success();
    // The same noise by two ways.
    let numbers = bench.read("out/analysis.json");
    bench.run(&run("gradient(3).scaled(2.0)")).success();
    let tail = |bytes: &[u8]| String::from_utf8_lossy(bytes).split_once("\"plan\"").unwrap().1.to_owned();
    assert_eq!(tail(&numbers), tail(&bench.read("out/analysis.json")));
    has(&stdout(&bench.run(&run("warped.rhai")).success()), &["tapered"]);
    has(&stderr(&bench.run(&run("fixed.rhai")).code(1)), &["whatever the seed", "param(\"seed\""]);
    has(&stderr(&bench.run(&run("text.rhai")).code(1)), &["not a noise", "gradient(7)"]);
    has(&stderr(&bench.run(&run("broken.rhai")).code(1)), &["broken.rhai"]);
    has(&stderr(&bench.run(&run("wavy.rhai --set l=2")).code(1)), &["`l`"]);
    has(&stderr(&bench.run(&run("gradient(7.5)")).code(1)), &["whole number"]);
}

#[test]
fn only_what_is_asked_for_is_written() {
    let bench = Bench::new(&[]);
    bench.run(&format!("noise gradient {SMALL} --only sphere --amplitude 0 -o out")).success();
    let names = || {
        let entries = std::fs::read_dir(bench.path("out")).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    };
    assert_eq!(names(), ["sphere.png"]);
    bench.run(&format!("noise gradient {SMALL} --only spectrum --only radial --solid -o out")).success();
    assert_eq!(names(), ["radial.png", "spectrum.png", "sphere.png"]);
}

#[test]
fn a_folder_that_cannot_be_is_refused_before_anything_is_computed() {
    let bench = Bench::new(&[("file", "")]);
    has(&stderr(&bench.run("noise gradient -o no/such").code(1)), &["no/such", "mkdir -p"]);
    has(&stderr(&bench.run("noise gradient -o file").code(1)), &["file is a file", "needs a folder", "-o"]);
}

/// Many octaves with few samples: what the samples cannot show is said.
#[test]
fn detail_that_is_not_resolved_is_a_warning() {
    let bench = Bench::new(&[]);
    // Enough realisations that their number is not the first thing to be warned of.
    let few = "--seeds 20 --cells 8 --samples 4 --size 240";
    let run = bench.run(&format!("noise fbm --octaves 4 --hurst 0.5 {few} --only radial -o out")).success();
    has(&stderr(&run), &["do not resolve", "--samples 8"]);
}
