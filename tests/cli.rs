//! The program driven as a user drives it: every command, and everything that can go wrong.

mod support;

use std::fs;
use support::{BALL, Bench, SLOW, has, stderr, stdout};

// ---- help and usage -----------------------------------------------------------------------------

#[test]
fn alone_it_shows_help() {
    let bench = Bench::new(&[]);
    let help = stdout(&bench.run("").success());
    has(&help, &["Usage: orogen", "render", "watch", "check", "repl", "new", "Examples:", "Exit codes:"]);
    assert!(stdout(&bench.run("--version").success()).starts_with("orogen "));
}

#[test]
fn every_command_has_help_with_examples() {
    let bench = Bench::new(&[]);
    for command in [
        "render",
        "merge",
        "video",
        "watch",
        "check",
        "repl",
        "new",
        "noise",
        "doc",
        "mesh",
        "grid",
        "heights",
        "definitions",
        "topology",
        "profile",
        "explore",
    ] {
        let help = stdout(&bench.run(&format!("{command} --help")).success());
        has(&help, &["Usage: orogen", "Examples:", &format!("orogen {command}")]);
        assert!(help.lines().all(|line| line.chars().count() <= 100), "{help}");
    }
}

#[test]
fn usage_errors_exit_with_2_and_show_how() {
    let bench = Bench::new(&[("a.rhai", BALL)]);
    has(&stdout(&bench.run("help mesh").success()), &["Usage: orogen mesh"]);
    for (arguments, pieces) in [
        ("paint a.rhai", &["paint", "--help"][..]),
        ("rendr a.rhai", &["render"]),
        ("check", &["SCRIPT"]),
        ("watch", &["SCRIPT"]),
        ("new", &["NAME"]),
        ("render a.rhai --size 640", &["--size", "1920x1080"]),
        ("render a.rhai --size 0x10", &["--size", "from 1 to"]),
        ("render a.rhai --samples 0", &["--samples"]),
        ("render a.rhai --threads 0", &["--threads"]),
        ("render a.rhai --threads many", &["--threads 4"]),
        ("render a.rhai --threads 1000000", &["from 1 to 1024"]),
        ("render a.rhai --caster magic", &["--caster", "auto", "speculative", "segment", "standard"]),
        ("render a.rhai --set relief", &["--set", "--set relief=0.04"]),
        ("render a.rhai --set relief=", &["--set", "no value"]),
        ("render a.rhai --set a=1 --set a=2", &["`a` twice"]),
        ("render a.rhai --time soon", &["--time", "1.5"]),
        ("render a.rhai -o a.gif", &["a.gif", ".png or .exr", "-o a.png"]),
        ("render a.rhai -o folder/", &[".png or .exr"]),
        ("render a.rhai b.rhai", &["b.rhai"]),
        ("render a.rhai --color green", &["green", "auto"]),
        ("new a.png", &["orogen new a"]),
        ("mesh a.rhai", &["--output"]),
        ("mesh a.rhai -o a.dae", &[".glb, .obj, .ply, .stl", "-o rock.glb"]),
        ("mesh a.rhai -o a.glb --resolution 1", &["--resolution"]),
        ("mesh a.rhai -o a.glb --tolerance 0", &["--tolerance 0.001"]),
        ("grid a.rhai -o a.vdb", &[".json or .exr", "-o a.json"]),
        ("grid a.rhai -o a.json --size 1", &["--size"]),
        ("heights a.rhai", &["--output"]),
        ("heights a.rhai -o a.tif", &["a.tif", ".png or .exr", "-o a.png"]),
        ("heights a.rhai -o a.png --size 0", &["--size"]),
        ("heights a.rhai -o a.png --size 40000", &["--size", "32768"]),
        ("heights a.rhai -o a.png --projection mercator", &["mercator", "equirectangular", "cube"]),
        ("heights a.rhai -o a.png --range 1", &["--range", "-0.01..0.02"]),
        ("heights a.rhai -o a.png --range 2..1", &["--range", "-0.01..0.02"]),
        ("heights a.rhai -o a.png --range nan..1", &["--range", "-0.01..0.02"]),
        ("heights a.rhai -o a.exr --range 0..1", &["--range", ".png"]),
        ("heights a.rhai -o a.png --center 1,2", &["--center", "0,1.5,0"]),
        ("heights a.rhai -o a.png --center 1,2,1e300", &["--center", "0,1.5,0"]),
        ("heights a.rhai -o a.png --radius -1", &["--radius"]),
        ("topology a.rhai --top -1", &["--top 10"]),
        ("profile", &["SCRIPT"]),
        ("profile a.rhai --top -1", &["--top 10"]),
        ("profile a.rhai --json a.txt", &[".json", "--json profile.json"]),
        ("profile a.rhai --size 640", &["--size", "1920x1080"]),
        ("explore", &["SCRIPT"]),
        ("explore a.rhai --count 0", &["--count", "from 1 to 1000"]),
        ("explore a.rhai --size 9999x9999", &["--size", "240x180"]),
        ("explore a.rhai --headless", &["--output"]),
        ("explore a.rhai -o out", &["--headless"]),
        ("explore a.rhai --headless -o out --port 80", &["--port"]),
        ("topology a.rhai --show kept", &["--output"]),
        ("definitions -o a.txt", &[".d.rhai"]),
        ("noise", &["KIND"]),
        ("noise gradient", &["--output"]),
        ("noise gradiant -o out", &["no noise called `gradiant`", "did you mean `gradient`", "fbm"]),
        ("noise fbm --of gradeint -o out", &["did you mean `gradient`"]),
        ("noise gradient --octaves 3 -o out", &["--octaves", "sums of octaves", "fbm"]),
        ("noise gradient --cells 30 -o out", &["cells is 30", "power of two"]),
        ("noise gradient --seeds 1 -o out", &["--seeds"]),
        ("noise gradient --only spektrum -o out", &["spektrum", "spectrum"]),
        ("noise gradient --set kernel -o out", &["sparse --set kernel=quintic"]),
        ("noise gradient --set kernel=quintic -o out", &["gradient has no option `kernel`", "directions"]),
        ("noise gradient --set direction=edges -o out", &["did you mean `directions`?"]),
        ("noise wavelet --set a=1 -o out", &["it has none"]),
        ("noise sparse --set nodes=99 -o out", &["nodes=99", "1 to 8"]),
        ("noise sparse --set kernel=cubic -o out", &["kernel=cubic", "quintic"]),
        ("noise gradient --set a=1 --set a=2 -o out", &["`a` twice"]),
        ("noise fbm --set octaves=3 --octaves 4 -o out", &["`octaves` is given twice"]),
        ("noise fbm --set signal=plain -o out", &["fbm has no option `signal`"]),
        ("noise fbm --set hurst=9 -o out", &["hurst=9", "0 to 2"]),
        ("noise fbm --hurst nan -o out", &["--hurst", "from 0 to 2"]),
        ("noise fbm --hurst -3 -o out", &["--hurst", "from 0 to 2"]),
        ("noise fbm --lacunarity 1 -o out", &["--lacunarity", "to 16"]),
        ("noise fbm --octaves 0 -o out", &["--octaves", "1..=32"]),
        ("noise fbm --octaves -1 -o out", &["--octaves", "1..=32"]),
        ("noise fbm --of fbm -o out", &["`fbm` is a sum of octaves itself", "gradient", "simplex"]),
        ("noise ./a -o out", &["./a", "ends in .rhai", "did you mean ./a.rhai?"]),
        ("doc --text sphere", &["cannot be used with"]),
        ("doc zzzzzz", &["nothing is called `zzzzzz`"]),
        ("doc ridgd", &["did you mean `fractal::ridged`?"]),
    ] {
        let message = stderr(&bench.run(arguments).code(2));
        has(&message, pieces);
    }
    assert_eq!(bench.names(), ["a.rhai"]);
}

// ---- topology -----------------------------------------------------------------------------------

#[test]
fn topology_reports_what_is_proven() {
    let bench = Bench::new(&[
        ("ball.rhai", BALL),
        ("hollow.rhai", "max(sphere(1.0), -sphere(0.5))"),
        ("cut.rhai", "scene(#{ surface: sphere(1.0), bounds: 0.9 })"),
        ("thin.rhai", "scene(#{ surface: sphere(1.0), bounds: [[-2, -2, -2], [2, 2, -1.99999]] })"),
        ("contact.rhai", "min(sphere(1.0), sphere(0.5).translate([1.5, 0, 0]))"),
        ("empty.rhai", "sphere(1.0) + 5.0"),
    ]);
    let report = |arguments: &str| {
        let text = stdout(&bench.run(&format!("topology {arguments} --fresh --json -")).success());
        // A key that is there twice is an error for a strict reader.
        let keys = text.lines().filter(|line| line.starts_with("      \"bounds\":")).count();
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(keys, value["components"].as_array().unwrap().len(), "{text}");
        value
    };
    let ball = report("ball.rhai");
    assert_eq!((&ball["certified"], &ball["components"][0]["genus"]), (&true.into(), &0.into()));
    let [lo, hi] = [0, 1].map(|i| ball["components"][0]["volume"][i].as_f64().unwrap());
    assert!(lo < 4.18879 && 4.18879 < hi && hi < 1.01 * lo, "{lo} {hi}");
    assert_eq!((&ball["components"][0]["voids"], &ball["voids"]), (&0.into(), &serde_json::Value::Null));
    let hollow = report("hollow.rhai --voids");
    let void = &hollow["voids"]["list"][0];
    assert_eq!((&hollow["voids"]["certified"], &void["component"]), (&true.into(), &0.into()));
    assert!(void["volume"][1].as_f64().is_some_and(|volume| volume > 0.52), "{void}");
    has(&stdout(&bench.run("topology hollow.rhai --voids").success()), &["1 component, 1 void, certified"]);
    let cut = report("cut.rhai");
    assert_eq!((&cut["certified"], &cut["certified_within_bounds"]), (&false.into(), &true.into()));
    assert_eq!(cut["undecided"]["cut"], 1);
    let empty = report("empty.rhai");
    assert_eq!((&empty["certified"], empty["components"].as_array().unwrap().len()), (&true.into(), 0));
    assert_eq!(report("thin.rhai")["components"].as_array().unwrap().len(), 0);
    let contact = report("contact.rhai");
    assert_eq!((&contact["certified"], contact["undecided"]["cut"].as_u64()), (&false.into(), Some(0)));
    assert!(contact["undecided"]["places_total"].as_u64().is_some_and(|n| n > 0 && n < 10));
    let table = bench.run("topology cut.rhai").success();
    has(&stdout(&table), &["by volume", "certified within the bounds only"]);
    has(&stderr(&table), &["may go on beyond the bounds"]);
}

/// What was found is found on disk by the next process, until the solid is another one; whatever looks at it, and
/// from wherever.
#[test]
fn topology_is_found_once() {
    let solid =
        |radius: f64, rest: &str| format!("export let solid = {};", rest.replace('R', &radius.to_string()));
    for rest in
        ["min(sphere(R), sphere(0.3).translate([1.2, 0, 0]))", "sphere(R) + 0.6 * gradient(1).scaled(2.0)"]
    {
        let bench = Bench::new(&[
            ("solid.rhai", &*solid(0.9, rest)),
            (
                "turn.rhai",
                "import \"solid\" as a; scene(#{ surface: largest_component(a::solid), \
                 camera: orbit(#{ azimuth: 100.0 * time }) })",
            ),
            ("a.rhai", "import \"solid\" as a; a::solid"),
            ("red.rhai", "import \"solid\" as a; a::solid.colored([1, 0, 0])"),
        ]);
        let report = |arguments: &str| {
            let text = stdout(&bench.run(&format!("topology {arguments} --json -")).success());
            let mut report: serde_json::Value = serde_json::from_str(&text).unwrap();
            let known = report["remembered"].as_bool().unwrap();
            report["seconds"].take();
            report["remembered"].take();
            (report, known)
        };
        let (first, known) = report("a.rhai");
        assert!(!known && first["components"].as_array().is_some_and(|list| !list.is_empty()));
        assert_eq!(report("a.rhai"), (first.clone(), true), "{rest}");
        assert_eq!(report("red.rhai"), (first.clone(), true), "{rest}");
        assert_eq!(report("a.rhai --fresh"), (first.clone(), false), "{rest}");
        let files = || fs::read_dir(bench.cache.path().join("topology")).unwrap().count();
        // Voids are found beside it.
        let (hollow, known) = report("a.rhai --voids");
        assert!(!known);
        assert_eq!(report("a.rhai --voids"), (hollow, true), "{rest}");
        // Frames of an animation need no more than that once.
        bench.run("render turn.rhai -o f-#.png --frames 1-2 --size 32x24 --samples 1").success();
        let before = files();
        bench.run("render turn.rhai -o g-#.png --frames 3-5 --size 32x24 --samples 1").success();
        assert_eq!(files(), before, "{rest}");
        // A file that is damaged is as if it were not there.
        for entry in fs::read_dir(bench.cache.path().join("topology")).unwrap() {
            let path = entry.unwrap().path();
            let mut bytes = fs::read(&path).unwrap();
            *bytes.last_mut().unwrap() ^= 1;
            fs::write(path, bytes).unwrap();
        }
        assert_eq!(report("a.rhai"), (first.clone(), false), "{rest}");
        assert_eq!(report("a.rhai"), (first.clone(), true), "{rest}");
        bench.write("solid.rhai", solid(0.91, rest));
        let (other, known) = report("a.rhai");
        assert!(!known && other["components"] != first["components"], "{rest}");
    }
}

/// Grids that take long are made once, and pictures of them are the same to the byte.
#[test]
fn grids_are_found_where_they_were_kept() {
    let bench = Bench::new(&[(
        "land.rhai",
        "let drops = param(\"drops\", 1.0, 0.1..4.0);
        let land = eroded(spectral(7, #{ size: 256, deviation: 0.1 }), #{ rain: drops });
        scene(#{ surface: (y - land).colored(param(\"colour\", \"#886644\")), bounds: 1.0 })",
    )]);
    let picture = |name: &str, more: &str, cache: Option<&str>| {
        let mut command =
            bench.command(&format!("render land.rhai -o {name} --size 32x24 --samples 1 {more}"));
        cache.map(|cache| command.env("OROGEN_CACHE", cache));
        command.assert().success();
        bench.read(name)
    };
    let kept = || {
        let entries = fs::read_dir(bench.cache.path().join("grids")).map(Iterator::collect::<Vec<_>>);
        let mut paths: Vec<_> = entries.unwrap_or_default().into_iter().map(|e| e.unwrap().path()).collect();
        paths.sort();
        paths
    };
    let without = picture("a.png", "", Some("off"));
    assert!(kept().is_empty());
    assert!(picture("b.png", "", None) == without);
    let before = kept();
    assert!(!before.is_empty());
    assert!(picture("c.png", "", None) == without);
    assert!(picture("d.png", "--set colour=#ff0000", None) != without);
    // How long the hills take is near what is worth keeping.
    assert!(kept().len() <= before.len() + 1, "another colour is no other land");
    assert!(picture("e.png", "--set drops=0.9", None) != without);
    assert!(kept().len() > before.len());
    for path in kept() {
        let mut bytes = fs::read(&path).unwrap();
        *bytes.last_mut().unwrap() ^= 1;
        fs::write(path, bytes).unwrap();
    }
    assert!(picture("f.png", "", None) == without, "a file that is damaged is as if it were not there");
}

/// A flow keeps what is connected where that is proven, and what is in sight nowhere.
#[test]
fn what_is_said_of_flowed_solids_is_kept_by_the_flow() {
    let bench = Bench::new(&[
        ("bent.rhai", "box([2.0, 0.4, 0.4]).flow(vec3(0.0, 0.3 * x, 0.0))"),
        ("torn.rhai", "box(1.0).flow(vec3(3.0 * y * y, 0.0, 0.0), #{ steps: 1 })"),
    ]);
    for (name, is_kept) in [("bent", true), ("torn", false)] {
        let text = stdout(&bench.run(&format!("topology {name}.rhai --voids --json -")).success());
        let report: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!((&report["kept_by_flow"], &report["star"]), (&is_kept.into(), &serde_json::Value::Null));
        for part in [&report, &report["voids"], &report["components"][0]] {
            assert_eq!(part["certified"], is_kept, "{text}");
        }
        assert_eq!(report["components"][0]["genus"].is_null(), !is_kept, "{text}");
        let table = stdout(&bench.run(&format!("topology {name}.rhai")).success());
        assert_eq!((table.contains("a ball"), table.contains("in sight")), (is_kept, false), "{table}");
    }
}

#[test]
fn rough_solids_have_no_network() {
    let bench = Bench::new(&[("rough.rhai", "abs(x) + sphere(1.0)")]);
    for options in ["--complex a.glb", "-o a.png --show network"] {
        let message = stderr(&bench.run(&format!("topology rough.rhai {options}")).code(1));
        has(&message, &["`abs` has creases (C0)", "rough.rhai:1"]);
    }
    assert_eq!(bench.names(), ["rough.rhai"]);
    let report = stdout(&bench.run("topology rough.rhai --json -").success());
    has(&report, &["\"what\": \"`abs` has creases", "\"star\": [\n", "\"genus\": 0"]);
}

#[test]
fn topology_with_a_feature_refuses_before_it_works() {
    let bench = Bench::new(&[("near.rhai", "component_of(sphere(1.0), [0, 0, 0], #{ feature: 0.2 })")]);
    for (options, piece) in [
        ("", "finds out no more than a picture needs"),
        ("-o n.png --show components", "finds out no more than a picture needs"),
        ("-o n.png --fresh", "leave out --fresh"),
        ("-o n.png --top 3", "leave out --fresh and --top"),
    ] {
        has(&stderr(&bench.run(&format!("topology near.rhai {options}")).code(2)), &[piece]);
    }
    bench.run("topology near.rhai -o n.png --size 24x18 --samples 1").success();
    assert_eq!(bench.names(), ["n.png", "near.rhai"]);
    has(&stdout(&bench.run("topology --help").success()), &["without it none is made"]);
}

#[test]
fn what_is_corrected_is_corrected_last() {
    let bench = Bench::new(&[("a.rhai", "largest_component(sphere(1.0)) + 1.0")]);
    has(&stderr(&bench.run("check a.rhai").code(1)), &["not a corrected solid", "correct last"]);
}

// ---- render -------------------------------------------------------------------------------------

#[test]
fn render_writes_a_picture_named_after_the_script() {
    let bench = Bench::new(&[("scripts/ball.rhai", BALL)]);
    let run = bench.run("render scripts/ball.rhai --size 40x30").success();
    has(&stderr(&run), &["ball.png", "40x30", "rays"]);
    assert_eq!(stderr(&run).lines().count(), 1, "{}", stderr(&run));
    assert_eq!(stdout(&run), "");
    assert_eq!(bench.names(), ["ball.png", "scripts"]);
    let (width, height, mean) = bench.picture("ball.png");
    assert_eq!((width, height), (40, 30));
    assert!(mean[0] > 5.0, "a lit ball should be seen: {mean:?}");
}

#[test]
fn without_a_script_it_renders_the_planet_and_says_what_to_try() {
    let bench = Bench::new(&[]);
    let said = stderr(&bench.run("render --size 32x24 --samples 1").success());
    has(&said, &["planet.png", "orogen new", "orogen watch"]);
    assert_eq!(bench.names(), ["planet.png"]);
}

#[test]
fn the_picture_does_not_depend_on_threads() {
    let bench = Bench::new(&[("a.rhai", SLOW)]);
    bench.run("render a.rhai -o one.png --size 70x50 --threads 1").success();
    bench.run("render a.rhai -o two.png --size 70x50 --threads 2").success();
    assert!(bench.read("one.png") == bench.read("two.png"));
}

#[test]
fn meshes_go_out_and_come_in() {
    let again = "load_mesh(\"a.ply\")";
    let bench = Bench::new(&[("a.rhai", BALL), ("again.rhai", again), ("none.rhai", "1.0 + x * x")]);
    for format in ["glb", "obj", "ply", "stl"] {
        let said = stderr(&bench.run(&format!("mesh a.rhai -o a.{format} --resolution 24")).success());
        has(&said, &[&format!("a.{format}: "), "triangles", "1 part", "closed", "proven to show all parts"]);
    }
    let said = stderr(&bench.run("mesh a.rhai -o less.stl --tolerance 0.01").success());
    has(&said, &["less.stl", "closed", "of the surface"]);
    let said = stderr(&bench.run("mesh again.rhai -o again.stl --resolution 24").success());
    has(&said, &["1 part", "0 handles", "closed"]);
    has(
        &stderr(&bench.run("mesh none.rhai -o none.stl").code(1)),
        &["there is no solid", "negative is inside"],
    );
    assert!(!bench.path("none.stl").exists());
    // Where the bounds are found but not proven, part of the solid may be missing.
    assert!(!said.contains("Warning"), "{said}");
    bench.write("plane.rhai", "y");
    let said = stderr(&bench.run("mesh plane.rhai -o plane.stl --resolution 8").success());
    has(&said, &["the solid may go on beyond the mesh", "bounds: 2.0"]);
    bench.write("plane.rhai", "scene(#{ surface: y, bounds: 2.0 })");
    let said = stderr(&bench.run("mesh plane.rhai -o plane.stl --resolution 8").success());
    assert!(!said.contains("Warning"), "{said}");
}

#[test]
fn fields_become_volumes_and_volumes_fields() {
    let bench = Bench::new(&[("a.rhai", BALL), ("again.rhai", "load_grid(\"a.json\")")]);
    has(
        &stderr(&bench.run("grid a.rhai -o a.json --size 16").success()),
        &["16 x 16 x 16 samples in 2 files"],
    );
    has(&stdout(&bench.run("check again.rhai").success()), &["C2"]);
    has(&stderr(&bench.run("grid a.rhai -o s.exr --size 4").success()), &["in 4 files"]);
    assert!(bench.path("s.0003.exr").exists());
}

#[test]
fn files_hold_what_the_script_keeps() {
    let two = "let f = min(sphere(1.0), sphere(0.3).translated([1.6, 0, 0]));";
    let bench = Bench::new(&[
        ("a.rhai", &format!("{two} largest_component(f)")),
        ("off.rhai", &format!("{two} component_of(f, [0, 3, 0])")),
        (
            "neck.rhai",
            "let ball = |x| sphere(0.5).translated([x, 0, 0]);
             let neck = max(abs(x) - 1.0, length(vec3(0, y + 0.013, z + 0.017)) - 0.02);
             largest_component(min(min(ball.call(-1), ball.call(1)), neck))",
        ),
    ]);
    let said = stderr(&bench.run("mesh a.rhai -o a.stl --resolution 32").success());
    has(&said, &["1 part, 0 handles, closed, 1 part left out"]);
    let said = stderr(&bench.run("grid a.rhai -o a.json --size 32").success());
    has(&said, &["samples in 2 files", "inside of what is left out"]);
    has(&stderr(&bench.run("heights a.rhai -o a.png --size 16").success()), &["heights within 0..0,"]);
    let said = stderr(&bench.run("mesh neck.rhai -o neck.stl --resolution 20").success());
    has(&said, &["a part of the mesh floats beside the rest", "larger --resolution"]);
    for command in ["mesh off.rhai -o b.stl", "grid off.rhai -o b.json", "heights off.rhai -o b.png"] {
        has(&stderr(&bench.run(command).code(1)), &["is not certain to be inside", "off.rhai"]);
    }
    assert!(["b.stl", "b.json", "b.raw", "b.png"].iter().all(|name| !bench.path(name).exists()));
}

#[test]
fn grids_say_what_they_cannot_write_before_they_begin() {
    let bench =
        Bench::new(&[("a.rhai", "loop { }"), ("b.rhai", BALL), ("c.raw/x", ""), ("d.0000.exr/x", "")]);
    for (arguments, pieces) in [
        ("grid a.rhai -o gone/a.json", &["gone", "does not exist"][..]),
        ("grid a.rhai -o c.json", &["c.raw", "not a file"]),
        ("grid a.rhai -o d.exr", &["d.0000.exr", "not a file"]),
        ("grid b.rhai -o b.json --size 4096", &["4096 x 4096 x 4096 samples", "smaller --size"]),
    ] {
        has(&stderr(&bench.run(arguments).code(1)), pieces);
    }
    bench.write("root.rhai", "max(sphere(1.0), sqrt(x) - 0.3)");
    has(
        &stderr(&bench.run("grid root.rhai -o root.json --size 8").code(1)),
        &["a place has no value", "guard"],
    );
    bench.write("e.0003.exr/x", "");
    has(&stderr(&bench.run("grid b.rhai -o e.exr --size 4").code(1)), &["e.0003.exr", "not a file"]);
    assert!(!bench.path("e.0000.exr").exists() && !bench.path("c.json").exists());
    // What is left of a higher volume would be taken for a part of this one.
    assert!(!stderr(&bench.run("grid b.rhai -o f.exr --size 6").success()).contains("Warning"));
    has(
        &stderr(&bench.run("grid b.rhai -o f.exr --size 4").success()),
        &["slices of a higher grid", "f.0004.exr"],
    );
}

#[cfg(unix)]
#[test]
fn a_grid_that_is_stopped_leaves_nothing() {
    let bench = Bench::new(&[("a.rhai", SLOW), ("a.0000.exr", "earlier")]);
    let run = bench.start("grid a.rhai -o a.exr --size 400");
    // The first slices are on the disk.
    run.wait_until("slices", || bench.names().iter().filter(|name| name.starts_with(".orogen-")).count() > 3);
    run.interrupt();
    let (code, said) = run.end();
    assert_eq!(code, Some(1), "{said}");
    has(&said, &["stopping", "stopped", "no file was written"]);
    assert_eq!(
        (bench.read("a.0000.exr"), bench.names()),
        (b"earlier".into(), names(&["a.0000.exr", "a.rhai"]))
    );
}

// ---- heights ------------------------------------------------------------------------------------

#[test]
fn heights_are_maps() {
    let bench = Bench::new(&[("a.rhai", "sphere(param(\"size\", 1.0, 0.1..4.0) + 0.1 * time) - 0.2 * x")]);
    let said = stderr(&bench.run("heights a.rhai -o a.png --size 20").success());
    has(&said, &["a.png: 40x20", "800 rays", "heights within", "from black to white"]);
    assert!(!said.contains("uncertified") && !said.contains("Warning"), "{said}");
    assert_eq!(bench.picture("a.png").0, 40);
    let said = stderr(&bench.run("heights a.rhai -o a.png --size 20 --range -0.1..0.1").success());
    has(&said, &["-0.1..0.1 from black to white", "pixels beyond"]);
    let cube = "heights a.rhai -o b.png --size 9 --projection cube --set size=2 --time 1 --radius 2.1";
    has(&stderr(&bench.run(cube).success()), &["b.png: 6 files of 9x9"]);
    assert_eq!(bench.picture("b.ny.png").0, 9);
    has(
        &stderr(&bench.run("heights a.rhai -o c.exr --size 20").success()),
        &["c.exr: 40x20", "heights within"],
    );
    let faces = ["px", "nx", "py", "ny", "pz", "nz"].map(|face| format!("b.{face}.png"));
    let mut all: Vec<&str> = faces.iter().map(String::as_str).chain(["a.png", "a.rhai", "c.exr"]).collect();
    all.sort();
    assert_eq!(bench.names(), all);
}

#[test]
fn heights_of_land() {
    let land = "y - 0.1 * sin(4.0 * x)";
    let bench = Bench::new(&[("a.rhai", land), ("b.rhai", "rounded_box([4, 0.5, 2], 0.1)")]);
    let said =
        stderr(&bench.run("heights a.rhai -o a.png --projection plane --extent 3x2 --size 20").success());
    has(&said, &["a.png: 30x20", "heights within -0.099", "..0.099"]);
    assert_eq!(bench.picture("a.png").0, 30);
    // Farther than anything is looked for unless asked, and wherever the solid is.
    let said =
        stderr(&bench.run("heights a.rhai -o a.png --projection plane --extent 60 --size 16").success());
    has(&said, &["a.png: 16x16"]);
    assert!(!said.contains("Warning"), "{said}");
    bench.write("d.rhai", "box([4, 1, 2]).translated([10, 0.5, 0])");
    let said =
        stderr(&bench.run("heights d.rhai -o d.png --projection plane --extent 3x1 --size 16").success());
    has(&said, &["d.png: 48x16", "heights within 1..1"]);
    // As far as the solid goes, above y = 0.
    let said = stderr(&bench.run("heights b.rhai -o b.exr --projection plane --size 20").success());
    has(&said, &["b.exr: 39x20", "..0.25"]);
    bench.run("heights a.rhai -o c.exr --projection plane --extent 3x2 --size 20").success();
    bench.write("c.rhai", "y - load_heightfield(\"c.exr\", #{ extent: 3.0 })");
    bench.run("check c.rhai").success();
    for (arguments, pieces) in [
        ("--radius 2 --projection plane", &["a plane has no --radius", "--center"][..]),
        ("--extent 2", &["--projection plane"]),
        ("--projection plane --extent 0", &["above 0", "4x3"]),
        ("--projection plane --extent 1e9x1 --size 9", &["pixels wide", "--size"]),
    ] {
        has(&stderr(&bench.run(&format!("heights a.rhai -o n.png {arguments}")).code(2)), pieces);
    }
}

#[test]
fn heights_say_what_is_odd() {
    let bench =
        Bench::new(&[("a.rhai", BALL), ("cut.rhai", "scene(#{ surface: sphere(1.0), bounds: 0.9 })")]);
    let said = stderr(&bench.run("heights a.rhai -o a.png --size 20 --center 3,0,-2").success());
    has(&said, &["Warning", "there is no solid in", "of 800 pixels; they are black", "--center"]);
    let said = stderr(&bench.run("heights a.rhai -o a.exr --size 20 --center 3,0,-2").success());
    has(&said, &["they are NaN"]);
    has(
        &stderr(&bench.run("heights cut.rhai -o a.png --size 20").success()),
        &["Warning", "beyond the bounds", "widen the bounds"],
    );
    bench.write("none.rhai", "sphere(1.0) + 9.0");
    has(
        &stderr(&bench.run("heights none.rhai -o n.png").code(1)),
        &["no ray met a solid", "negative is inside"],
    );
    has(&stderr(&bench.run("heights a.rhai -o a.png --set size=1").code(1)), &["size"]);
    has(&stderr(&bench.run("heights gone.rhai -o n.png").code(1)), &["gone.rhai"]);
    assert!(!bench.path("n.png").exists());
}

#[test]
fn heights_that_cannot_be_written_are_not_measured() {
    let bench = Bench::new(&[("a.rhai", "loop { }"), ("file", ""), ("b.nz.png/x", "")]);
    for (arguments, pieces) in [
        ("-o gone/a.png", &["gone", "does not exist"][..]),
        ("-o file/a.exr", &["file", "not a folder"]),
        ("-o b.png --projection cube", &["b.nz.png", "not a file"]),
    ] {
        has(&stderr(&bench.run(&format!("heights a.rhai {arguments}")).code(1)), pieces);
    }
}

#[cfg(unix)]
#[test]
fn heights_that_are_stopped_leave_nothing() {
    let bench = Bench::new(&[("a.rhai", SLOW), ("a.px.png", "earlier")]);
    for options in ["", "--range 0..1"] {
        let run = bench.start(&format!("heights a.rhai -o a.png --projection cube --size 8192 {options}"));
        run.wait_for("% after", 1);
        run.interrupt();
        let (code, said) = run.end();
        assert_eq!(code, Some(1), "{said}");
        has(&said, &["stopping", "stopped", "no file was written"]);
        assert_eq!(
            (bench.read("a.px.png"), bench.names()),
            (b"earlier".into(), names(&["a.px.png", "a.rhai"]))
        );
    }
}

/// The names of files, and of the log of a run in the background.
#[cfg(unix)]
fn names(files: &[&str]) -> Vec<String> {
    files.iter().chain(&["log"]).map(|name| (*name).to_owned()).collect()
}

// ---- other files --------------------------------------------------------------------------------

#[test]
fn editors_get_definitions() {
    let bench = Bench::new(&[]);
    has(&stderr(&bench.run("definitions").success()), &["orogen.d.rhai", "functions"]);
    let text = String::from_utf8(bench.read("orogen.d.rhai")).unwrap();
    has(&text, &["module static;", "fn sphere(radius: ?) -> ?;", "module fractal {"]);
}

#[test]
fn every_caster_renders() {
    let bench = Bench::new(&[("a.rhai", BALL), ("flowed.rhai", "sphere(1.0).flow(vec3(0.3 * y, 0, 0))")]);
    for (_, caster) in orogen::cast::Kind::ALL {
        let script = if caster == "bent" { "flowed.rhai" } else { "a.rhai" };
        bench.run(&format!("render {script} --size 20x20 --caster {caster} -o {caster}.png")).success();
        assert_eq!(bench.picture(&format!("{caster}.png")).0, 20);
    }
    bench.run("render a.rhai --size 20x20 --caster bent -o no.png").failure();
}

#[test]
fn exr_holds_a_picture() {
    let bench = Bench::new(&[("a.rhai", BALL)]);
    bench.run("render a.rhai --size 20x10 -o a.exr").success();
    assert_eq!(&bench.read("a.exr")[..4], [0x76, 0x2f, 0x31, 0x01]);
}

#[test]
fn statistics_are_json() {
    let bench = Bench::new(&[("a.rhai", "sphere(param(\"size\", 1.0, 0.5..2.0))")]);
    bench.run("render a.rhai --size 20x10 --samples 1 --set size=0.75 --stats a.json").success();
    let stats: serde_json::Value = serde_json::from_slice(&bench.read("a.json")).unwrap();
    assert_eq!((&stats["width"], &stats["height"], &stats["samples"]), (&20.into(), &10.into(), &1.into()));
    assert_eq!(stats["file"], "a.png");
    assert_eq!(stats["complete"], true);
    assert_eq!(stats["params"]["size"], 0.75);
    assert!(stats["seconds"].as_f64().unwrap() > 0.0, "{stats}");
    assert!(stats["cast"]["rays"].as_u64().unwrap() > 0, "{stats}");
    assert_eq!(stats["render"]["octaves"]["primary"], 0, "a sphere has no noise: {stats}");
}

#[test]
fn statistics_can_be_read() {
    let bench = Bench::new(&[("a.rhai", "sphere(1.0) - 0.1 * gradient(7).scaled(3.0)")]);
    let run = bench.run("render a.rhai --size 20x10 --samples 1 --stats").success();
    let said = stdout(&run);
    let rows = ["rays ", "field evaluations", "  per ray", "octaves of noise", "certified", "rays to lights"];
    has(&said, &rows);
    has(&stderr(&run), &["a.png"]);
    let said = stderr(&bench.run("render --stats a.rhai").code(2));
    has(&said, &["a.rhai", "does not end in .json", "at the end"]);
}

#[test]
fn heat_maps_show_what_pixels_cost() {
    let bench = Bench::new(&[("a.rhai", BALL)]);
    bench.run("render a.rhai --size 40x30 --samples 1 --heatmap evals").success();
    // Larger than the picture by title and scale, and beside where that would go.
    assert!(bench.picture("a.evals.png").0 > 40);
    assert_eq!(bench.names(), ["a.evals.png", "a.rhai"]);
    bench.run("render a.rhai --size 40x30 --samples 1 --heatmap evals -o b.png").success();
    assert_eq!(bench.read("a.evals.png"), bench.read("b.png"));
    has(
        &stderr(&bench.run("render a.rhai --heatmap evals -o a.exr").code(2)),
        &["a heat map is a .png", "-o a.png"],
    );
    has(&stderr(&bench.run("render a.rhai --heatmap heat").code(2)), &["heat", "evals"]);
}

#[test]
fn parameters_and_time_change_the_picture() {
    let script = "sphere(param(\"size\", 1.0, 0.1..2.0) + 0.1 * time)";
    let bench = Bench::new(&[("a.rhai", script)]);
    for (file, options) in [("a", ""), ("b", "--set size=0.5"), ("c", "--time -3")] {
        bench.run(&format!("render a.rhai --size 20x20 -o {file}.png {options}")).success();
    }
    let light = |name| bench.picture(name).2[0];
    assert!(light("b.png") < light("c.png") && light("c.png") < light("a.png"));
}

#[test]
fn unknown_parameters_name_the_nearest() {
    let script = "sphere(param(\"size\", 1.0, 0.1..2.0) + param(\"relief\", 0.0, 0.0..1.0))";
    let bench = Bench::new(&[("a.rhai", script), ("b.rhai", BALL)]);
    has(&stderr(&bench.run("render a.rhai --set relif=1").code(1)), &["relif", "relief"]);
    has(&stderr(&bench.run("render a.rhai --set wetness=1").code(1)), &["wetness", "size", "relief"]);
    has(&stderr(&bench.run("render a.rhai --set size=9").code(1)), &["size", "0.1", "2"]);
    has(&stderr(&bench.run("render a.rhai --set size=high").code(1)), &["size", "not a number", "0.1 to 2"]);
    has(&stderr(&bench.run("check b.rhai --set size=1").code(1)), &["size"]);
    assert_eq!(bench.names(), ["a.rhai", "b.rhai"]);
}

#[test]
fn colours_names_and_switches_are_set_and_checked() {
    let script =
        "let c = param(\"tint\", \"#c98f5a\"); let n = param(\"style\", \"plain\", [\"plain\", \"7\"]);
        sphere(if param(\"large\", true) { 1.0 } else { 0.5 }).colored(c)";
    let bench = Bench::new(&[("a.rhai", script)]);
    has(
        &stdout(&bench.run("check a.rhai").success()),
        &[
            "tint  = #c98f5a (a colour #rrggbb)",
            "style = plain (one of plain, 7)",
            "large = true (true or false)",
        ],
    );
    has(
        &stdout(&bench.run("check a.rhai --set tint=#000 --set style=7 --set large=off").success()),
        &["#000000 (a colour #rrggbb, #c98f5a unless set)", "style = 7 (", "large = false ("],
    );
    has(&stderr(&bench.run("check a.rhai --set style=plane").code(1)), &["one of plain, 7", "`plain`"]);
    bench.run("render a.rhai --size 20x10 --samples 1 --set large=off --stats a.json").success();
    let stats: serde_json::Value = serde_json::from_slice(&bench.read("a.json")).unwrap();
    assert_eq!(stats["params"], serde_json::json!({ "tint": "#c98f5a", "style": "plain", "large": false }));
}

#[test]
fn an_empty_scene_is_a_picture_with_a_warning() {
    let bench = Bench::new(&[("a.rhai", "sphere(1.0) + 100.0")]);
    has(&stderr(&bench.run("render a.rhai --size 20x20").success()), &["Warning", "no solid"]);
    assert_eq!(bench.picture("a.png").0, 20);
}

// ---- what can go wrong --------------------------------------------------------------------------

/// Scripts that cannot be rendered, and what the message must say.
const BAD_SCRIPTS: &[(&str, &str, &[&str])] = &[
    ("syntax", "let f = sphere(1.0;\nf", &["bad.rhai:1", "let f = sphere(1.0;"]),
    ("unknown function", "sphre(1.0)", &["sphre", "sphere", "bad.rhai:1"]),
    ("not a solid", "1 + 1", &["not a scene or a field"]),
    ("nothing", "", &["not a scene or a field"]),
    ("endless loop", "loop { }", &["bad.rhai"]),
    ("endless recursion", "fn f(n) { f(n + 1) } f(0)", &["bad.rhai"]),
    ("memory hog", "let a = [1]; loop { a += a; }", &["bad.rhai"]),
    ("missing import", "import \"gone\" as g; sphere(1.0)", &["gone", "bad.rhai:1"]),
    ("import of a folder", "import \"folder\" as g; sphere(1.0)", &["folder"]),
    ("import not in UTF-8", "import \"latin\" as g; sphere(1.0)", &["latin", "UTF-8"]),
    ("import cycle", "import \"cycle\" as g; sphere(1.0)", &["cycle"]),
    ("error in an import", "import \"broken\" as g; sphere(1.0)", &["broken.rhai:2"]),
    ("not a number everywhere", "sqrt(-1.0 - x * x)", &["bad.rhai:1"]),
    ("no pixels", "scene(#{ surface: sphere(1.0), film: film(#{ width: 0, height: 10 }) })", &["width"]),
];

#[test]
fn bad_scripts_exit_with_1_and_keep_the_earlier_picture() {
    let bench = Bench::new(&[
        ("folder.rhai/x", ""),
        ("cycle.rhai", "import \"bad\" as b;"),
        ("broken.rhai", "// fine\nlet ;"),
        ("bad.png", "earlier"),
    ]);
    bench.write("latin.rhai", b"let gr\xfc\xdfe = 1;");
    let before = bench.names();
    for (what, script, pieces) in BAD_SCRIPTS {
        bench.write("bad.rhai", script);
        let run = bench.run("render bad.rhai --size 20x20");
        let said = stderr(&run);
        assert_eq!(run.get_output().status.code(), Some(1), "{what}: {said}");
        has(&said, pieces);
        has(&said, &["Error"]);
        assert!(!said.contains("panicked") && !said.contains("bug in orogen"), "{what}: {said}");
        assert_eq!(bench.read("bad.png"), b"earlier", "{what}");
    }
    std::fs::remove_file(bench.path("bad.rhai")).unwrap();
    assert_eq!(bench.names(), before);
}

#[test]
fn scripts_that_cannot_be_read() {
    let bench = Bench::new(&[("folder.rhai/x", ""), ("sphere.rhai", BALL)]);
    bench.write("latin.rhai", b"// gr\xfc\xdfe\nsphere(1.0)");
    for command in ["render", "check"] {
        let said = |script: &str| stderr(&bench.run(&format!("{command} {script}")).code(1));
        has(&said("gone.rhai"), &["gone.rhai", "Help"]);
        has(&said("sphere"), &["sphere.rhai"]);
        has(&said("folder.rhai"), &["folder.rhai", "folder"]);
        has(&said("latin.rhai"), &["latin.rhai", "UTF-8"]);
    }
}

#[test]
fn places_that_cannot_be_written_are_found_before_rendering() {
    let bench = Bench::new(&[("a.rhai", SLOW), ("file", ""), ("folder.png/x", "")]);
    // Sizes at which rendering would outlast the test.
    let said = |to: &str| {
        let arguments = format!("render a.rhai --size 4000x4000 --samples 64 {to}");
        stderr(&bench.command(&arguments).timeout(std::time::Duration::from_secs(20)).assert().code(1))
    };
    has(&said("-o gone/a.png"), &["gone", "does not exist"]);
    has(&said("-o file/a.png"), &["file", "not a folder"]);
    has(&said("-o folder.png"), &["folder.png"]);
    has(&said("--stats gone/a.json"), &["gone", "does not exist"]);
    if cfg!(target_os = "linux") {
        has(&said("-o /proc/a.png"), &["/proc"]);
        std::os::unix::fs::symlink("/dev/full", bench.path("full.png")).unwrap();
        has(&said("-o full.png"), &["full.png"]);
    }
}

#[test]
fn what_the_script_reads_is_not_overwritten() {
    let height = "y - load_heightfield(\"hills.png\", #{ extent: 2.0, height: 0.2 })";
    let mut picture = std::io::Cursor::new(Vec::new());
    image::GrayImage::from_fn(4, 4, |x, y| image::Luma([(20 * x + 9 * y) as u8]))
        .write_to(&mut picture, image::ImageFormat::Png)
        .unwrap();
    let cloud = "{ \"type\": \"float32\", \"size\": [2, 2, 2], \"step\": 1.0 }";
    let bench = Bench::new(&[
        ("hills.rhai", height),
        ("knot.rhai", "load_mesh(\"knot.obj\").field()"),
        ("cloud.rhai", "load_grid(\"cloud.json\") - 0.5"),
        ("cloud.json", cloud),
    ]);
    bench.write("hills.png", picture.into_inner());
    bench.write("knot.obj", include_bytes!("../scripts/knot.obj"));
    bench.write("cloud.raw", [0_u8; 32]);
    let before = ["hills.png", "knot.obj", "cloud.json", "cloud.raw"].map(|name| bench.read(name));
    for (command, file) in [
        ("render hills.rhai --size 8x6", "hills.png"),
        ("heights hills.rhai --projection plane --size 8 -o hills.png", "hills.png"),
        ("mesh knot.rhai -o ./knot.obj", "knot.obj"),
        ("grid cloud.rhai --size 4 -o cloud.json", "cloud.raw"),
        ("profile cloud.rhai --json cloud.json", "cloud.json"),
    ] {
        has(
            &stderr(&bench.run(command).code(1)),
            &["the script reads", file, "would be lost", "another name"],
        );
    }
    // Nor by a snapshot, whose name comes of another one.
    bench.write("steps.rhai", height.replace("hills.png", "a.1.png"));
    bench.write("a.1.png", &before[0]);
    let said = stderr(&bench.run("render steps.rhai --size 8x6 -o a.png --snapshots 4").code(1));
    has(&said, &["the script reads a.1.png", "would be lost"]);
    assert_eq!(bench.read("a.1.png"), before[0]);
    assert_eq!(["hills.png", "knot.obj", "cloud.json", "cloud.raw"].map(|name| bench.read(name)), before);
}

#[cfg(target_os = "linux")]
#[test]
fn what_cannot_be_said_is_an_error() {
    let bench = Bench::new(&[("a.rhai", BALL)]);
    let full = || std::fs::File::options().write(true).open("/dev/full").unwrap();
    for command in ["check a.rhai", "doc sphere", "topology a.rhai --json -"] {
        let told = bench.plain_command(command).stdout(full()).output().unwrap();
        assert_eq!(told.status.code(), Some(1), "{command}");
        has(&String::from_utf8_lossy(&told.stderr), &["cannot write to standard output", "No space left"]);
    }
    // Nobody has to read on.
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    assert!(bench.plain_command("doc sphere").stdout(writer).status().unwrap().success());
}

/// A disk of 16 KiB, in a mount namespace of its own so that it goes away with the program.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_keeps_the_earlier_picture() {
    let bench = Bench::new(&[("a.rhai", BALL), ("disk/x", "")]);
    let script = "mount -t tmpfs -o size=16k none disk && echo earlier >disk/a.png && ready=1; \
                  [ \"$ready\" ] || exit 77; \
                  \"$0\" render a.rhai --size 300x300 -o disk/a.png; code=$?; cat disk/a.png; ls -A disk; exit $code";
    let unshare = std::process::Command::new("unshare")
        .args(["-m", "sh", "-c", script, env!("CARGO_BIN_EXE_orogen")])
        .current_dir(bench.path(""))
        .output();
    let Ok(output) = unshare else { return };
    if matches!(output.status.code(), Some(77) | None)
        || String::from_utf8_lossy(&output.stderr).contains("unshare")
    {
        return; // not allowed here
    }
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    has(&said, &["disk is full", "a.png"]);
    assert_eq!(String::from_utf8(output.stdout).unwrap(), "earlier\na.png\n");
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_what_was_rendered() {
    let bench = Bench::new(&[("a.rhai", SLOW)]);
    let run = bench.start("render a.rhai --size 2000x2000 --samples 9 --stats a.json");
    // Said once some of the picture is there, after the first seconds.
    run.wait_for("% after", 1);
    run.interrupt();
    let (code, said) = run.end();
    assert_eq!(code, Some(1), "{said}");
    has(&said, &["a.png", "%"]);
    assert_eq!(bench.picture("a.png").0, 2000);
    let stats: serde_json::Value = serde_json::from_slice(&bench.read("a.json")).unwrap();
    assert_eq!(stats["complete"], false);
}

#[cfg(unix)]
#[test]
fn a_second_ctrl_c_quits_at_once() {
    let script = format!("print(\"it runs\"); {SLOW}");
    let bench = Bench::new(&[("a.rhai", &script), ("a.png", "earlier")]);
    let run = bench.start("render a.rhai --size 2000x2000 --samples 64");
    run.wait_for("it runs", 1);
    run.interrupt();
    run.interrupt();
    let (code, said) = run.end();
    assert_eq!(code, Some(1), "{said}");
}

#[test]
fn a_reader_that_leaves_early_is_no_error() {
    let bench = Bench::new(&[("a.rhai", BALL)]);
    let script = "{ \"$0\" --help; \"$0\" check a.rhai; \"$0\" render a.rhai --size 9x9; } 2>&1 | true";
    let run = std::process::Command::new("sh")
        .args(["-c", script, env!("CARGO_BIN_EXE_orogen")])
        .current_dir(bench.path(""))
        .output()
        .unwrap();
    assert!(run.status.success() && run.stderr.is_empty());
    assert_eq!(bench.picture("a.png").0, 9);
}

#[test]
fn colours_only_where_they_are_wanted() {
    let bench = Bench::new(&[("a.rhai", "sphre(1.0)")]);
    let said = |options: &str| stderr(&bench.run(&format!("check a.rhai {options}")).code(1));
    assert!(!said("").contains('\x1b'));
    assert!(!said("--color never").contains('\x1b'));
    assert!(said("--color always").contains('\x1b'));
    let usage = stderr(&bench.run("check --color always").code(2));
    assert!(usage.contains('\x1b'));
}

// ---- check, new ---------------------------------------------------------------------------------

#[test]
fn check_says_what_a_script_describes() {
    let script = "sphere(param(\"size\", 1.0, 0.5..2.0)) - 0.1 * gradient(7).scaled(3.0)";
    let bench = Bench::new(&[("a.rhai", script)]);
    let said = stdout(&bench.run("check a.rhai --set size=1.5").success());
    has(&said, &["size", "1.5", "0.5", "2", "C2", "nodes", "bounds"]);
    assert_eq!(bench.names(), ["a.rhai"]);
}

#[test]
fn check_says_what_is_wrong_with_a_solid() {
    let bench = Bench::new(&[]);
    let checked = |text: &str, code: i32| {
        bench.write("a.rhai", text);
        let run = bench.run("check a.rhai").code(code);
        (stdout(&run), stderr(&run))
    };
    let (described, said) = checked("length(p) + 0.1", 0);
    has(&described, &["none: there is no solid"]);
    has(
        &said,
        &[
            "Warning: there is no solid: the field is positive everywhere",
            "a.rhai:1:11",
            "negative is inside",
        ],
    );
    let (described, said) = checked("scene(#{ surface: sphere(1.0), bounds: [[3, 3, 3], [4, 4, 4]] })", 0);
    has(&described, &["(3.0000, 3.0000, 3.0000) to", "there is nothing within"]);
    has(&said, &["Warning: there is no solid within the bounds"]);
    let (described, said) = checked("sphere(1.0) + 0.2 * sqrt(x)", 0);
    has(&described, &["found from the field"]);
    has(&said, &["Warning: the field is undefined (NaN or infinite) in about"]);
    let (described, said) = checked("sqrt(-1.0 - x * x)", 1);
    assert_eq!(described, "");
    has(&said, &["Error: the field is undefined (NaN or infinite) at every point", "square root"]);
    // Samples alone may miss what there is.
    let bowl = "max(y - sqrt(0.09 - x * x - z * z), -y).translated([0.5, 0.1, 0.5])";
    let (described, said) = checked(&format!("scene(#{{ surface: {bowl}, bounds: 9.0 }})"), 0);
    has(&described, &["given by the script"]);
    has(&said, &["Warning: the field is undefined (NaN or infinite) at every point that was tried"]);
    // However small, five digits of it.
    let (described, said) = checked("sphere(0.001) / 1000.0", 0);
    has(&described, &["(-0.0010106, "]);
    assert_eq!(said, "");
}

#[test]
fn what_scripts_print_is_seen() {
    let bench = Bench::new(&[("a.rhai", "print(\"hello\"); sphere(1.0)")]);
    assert!(stdout(&bench.run("check a.rhai").success()).contains("hello"));
    assert!(stdout(&bench.run("render a.rhai --size 9x9").success()).contains("hello"));
}

#[test]
fn new_then_check_then_render() {
    let bench = Bench::new(&[("sub/x", "")]);
    for name in ["rock", "sub/rock", "other.rhai", "two_words"] {
        let said = stderr(&bench.run(&format!("new {name}")).success());
        has(&said, &["created", ".rhai", "orogen watch", "orogen render"]);
    }
    assert_eq!(bench.names(), ["other.rhai", "rock.rhai", "sub", "two_words.rhai"]);
    bench.run("check rock.rhai").success();
    let run = bench.run("render rock.rhai --size 40x30 --samples 1").success();
    assert!(!stderr(&run).contains("Warning"));
    assert!(bench.picture("rock.png").2[0] > 5.0);
}

#[test]
fn new_never_overwrites() {
    let bench = Bench::new(&[("rock.rhai", "mine"), ("file", "")]);
    has(&stderr(&bench.run("new rock").code(1)), &["rock.rhai", "already"]);
    has(&stderr(&bench.run("new rock.rhai").code(1)), &["already"]);
    has(&stderr(&bench.run("new gone/rock").code(1)), &["gone", "mkdir"]);
    bench.run("new file/rock").code(1);
    assert_eq!(bench.read("rock.rhai"), b"mine");
}

// ---- noise --------------------------------------------------------------------------------------

/// Small enough for a test.
const SMALL: &str = "--seeds 4 --cells 8 --samples 4 --size 240";

#[test]
fn noise_says_what_it_writes_and_makes_its_folder() {
    let bench = Bench::new(&[]);
    let run = bench.run(&format!("noise gradient --seed -3 {SMALL} -o out")).success();
    for file in ["sample", "sphere", "autocovariance", "spectrum", "radial", "anisotropy"] {
        has(&stderr(&run), &[&format!("out/{file}.png after ")]);
        assert_eq!(bench.picture(&format!("out/{file}.png")).0, 240);
    }
    has(&stderr(&run), &["out: 7 files in"]);
    has(&stdout(&run), &["mean", "undecided: it takes at least 20 realisations"]);
    let numbers: serde_json::Value = serde_json::from_slice(&bench.read("out/analysis.json")).unwrap();
    assert_eq!(
        (&numbers["verdict"]["doubt"], &numbers["verdict"]["isotropic"]),
        (&"few".into(), &serde_json::Value::Null)
    );
    let run = bench.run(&format!("noise gabor --only sphere {SMALL} -o ball")).success();
    has(&stdout(&run), &["mean", "variance", "seen"]);
    has(&stderr(&run), &["ball/sphere.png", "1 file in"]);
    assert!(bench.picture("ball/sphere.png").2[0] > 20.0);
}

#[test]
fn noise_is_undecided_where_samples_tell_nothing() {
    let seeded = |field: &str| format!("let s = param(\"seed\", 1, 0..100000); {field}");
    let bench =
        Bench::new(&[("flat.rhai", &seeded("0.0 * x + 2.0")), ("level.rhai", &seeded("0.0 * x + 0.1 * s"))]);
    let run = |what: &str| bench.run(&format!("noise {what} --only radial {SMALL} -o out")).success();
    let aliased = run("gradient(7).scaled(1e9)");
    has(
        &stdout(&aliased),
        &["stationary  undecided", "isotropic   undecided", "band        undecided: it varies too fast"],
    );
    has(&stderr(&aliased), &["Warning", "finer than the samples"]);
    for flat in ["flat.rhai", "level.rhai"] {
        let flat = run(flat);
        has(&stdout(&flat), &["band        undecided: it is the same at all samples"]);
        has(&stderr(&flat), &["Warning", "does not vary"]);
    }
}

#[test]
fn noise_that_fails_leaves_no_folder() {
    let root = "let s = param(\"seed\", 1, 0..100000); sqrt(gradient(s) + 0.0 * x)";
    let bench =
        Bench::new(&[("file", ""), ("root.rhai", root), ("solid.rhai", "scene(#{ surface: sphere(1.0) })")]);
    let fails = |arguments: &str, pieces: &[&str]| {
        has(&stderr(&bench.run(&format!("noise {arguments}")).code(1)), pieces);
    };
    fails("2.0 -o out", &["not a noise"]);
    fails("root.rhai -o out", &["infinite or not a number"]);
    fails("gone.rhai -o out", &["there is no script gone.rhai"]);
    fails("solid.rhai -o out", &["not a noise", "param(\"seed\""]);
    fails("gradient -o file", &["file is a file", "folder"]);
    fails("gradient -o file/out", &["folder file/out", "file is a file"]);
    fails("gradient -o gone/out", &["folder gone/out", "mkdir -p gone"]);
    assert_eq!(bench.names(), ["file", "root.rhai", "solid.rhai"]);
}

#[cfg(unix)]
#[test]
fn noise_that_is_stopped_says_what_it_wrote() {
    let bench = Bench::new(&[]);
    let run = bench.start("noise weierstrass --only sphere --size 4096 -o out");
    std::thread::sleep(std::time::Duration::from_millis(700));
    run.interrupt();
    let (code, said) = run.end();
    assert_eq!(code, Some(1), "{said}");
    has(&said, &["no file was written"]);
    assert_eq!(bench.names(), ["log"]);
}

// ---- the reference ------------------------------------------------------------------------------

#[test]
fn the_reference_is_that_of_this_version_and_has_its_pictures() {
    let bench = Bench::new(&[]);
    bench.run("doc --text -o .").success();
    let text = String::from_utf8(bench.read("reference.md")).unwrap();
    let docs = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let kept = std::fs::read_to_string(docs.join("reference.md")).unwrap();
    assert!(text == kept, "docs/reference.md is not what `orogen doc` writes");
    for link in text.split("](reference/").skip(1) {
        let picture = docs.join("reference").join(link.split(')').next().unwrap());
        assert!(picture.exists(), "{} is missing: run `orogen doc`", picture.display());
    }
}

#[test]
fn the_reference_says_what_it_cannot_write() {
    let bench = Bench::new(&[]);
    has(&stderr(&bench.run("doc --only celular").code(2)), &["celular", "did you mean `cellular`?"]);
    has(&stderr(&bench.run("doc --text -o none").code(1)), &["none"]);
    has(&stderr(&bench.run("doc --only rigded").code(2)), &["did you mean `fractal::ridged`?"]);
}

#[test]
fn doc_explains_a_name_on_the_terminal() {
    let bench = Bench::new(&[]);
    let said = |name: &str| stdout(&bench.run(&format!("doc {name}")).success());
    has(&said("x"), &["the first coordinate of the point"]);
    has(&said("fbm"), &["fractal::fbm(noise, options)"]);
    has(&said("cellular"), &["cellular(seed, options)", "\n    - norm: "]);
    has(&said("warp"), &["warp::by_noise("]);
    assert!(bench.names().is_empty());
    bench.write("docs/x", "");
    bench.run("doc --only fbm").success();
    assert!(bench.path("docs/reference/fractal-fbm-2.png").exists());
}

/// What is the same everywhere in a material is in a .glb.
#[test]
fn meshes_shine_as_they_do_in_pictures() {
    let script = "scene(#{ surface: sphere(1.0), material: material(#{ metal: 1.0, roughness: 0.25, coat: 0.5 + 0.1 * x }) })";
    let bench = Bench::new(&[("a.rhai", script)]);
    bench.run("mesh a.rhai -o a.glb --resolution 8").success();
    let file = bench.read("a.glb");
    let text = String::from_utf8_lossy(&file);
    has(&text, &["\"metallicFactor\":1.0", "\"roughnessFactor\":0.25"]);
    assert!(!text.contains("clearcoat"), "{text}");
}

#[test]
fn meshes_stand_up_where_that_is_asked_for() {
    let bench = Bench::new(&[("pin.rhai", "cylinder(0.5, 4.0).translated([0, 2, 0.25])")]);
    let extent = |up: &str| {
        bench.run(&format!("mesh pin.rhai --resolution 16 -o a.obj {up}")).success();
        let text = String::from_utf8(bench.read("a.obj")).unwrap();
        let points = text.lines().filter_map(|line| line.strip_prefix("v "));
        let points: Vec<Vec<f64>> =
            points.map(|p| p.split(' ').take(3).map(|x| x.parse().unwrap()).collect()).collect();
        let ends = |axis: usize| {
            let all = points.iter().map(|p| p[axis]);
            [all.clone().fold(f64::INFINITY, f64::min), all.fold(f64::NEG_INFINITY, f64::max)]
        };
        [ends(0), ends(1), ends(2)]
    };
    let [x, y, z] = extent("");
    assert!((y[0].abs() < 0.01) && (y[1] - 4.0).abs() < 0.01, "{y:?}");
    // A quarter turn, and no mirror image.
    assert_eq!(extent("--up z"), [x, [-z[1], -z[0]], y]);
    has(&stderr(&bench.run("mesh pin.rhai -o a.glb --up z").code(2)), &["y is up in every .glb", "--up"]);
}
