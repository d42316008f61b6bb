//! The script host as a library: the REPL's interpreter, cancellation, and hostile input.

use orogen::script::{Interpreter, Limits, PRELUDE, Request, STD, compile, reference};
use orogen::world::World;
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// Files in memory, some of which are no texts.
#[derive(Default)]
struct Files(BTreeMap<PathBuf, Vec<u8>>);

impl World for Files {
    fn bytes(&self, path: &Path) -> io::Result<Arc<[u8]>> {
        self.0.get(path).map(|bytes| Arc::from(&bytes[..])).ok_or_else(|| io::ErrorKind::NotFound.into())
    }
}

/// A heightfield of 3 x 2 pixels.
fn hills() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 3, 2);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header().unwrap().write_image_data(&[0, 51, 102, 153, 204, 255]).unwrap();
    bytes
}

fn interpreter() -> Interpreter {
    let mut world = Files::default();
    let mut add = |name: &str, bytes: &[u8]| world.0.insert(PathBuf::from(name), bytes.to_owned());
    add("ball.rhai", b"fn ball(r) { sphere(r) }\nlet size = 2.0;\nball(size)\n");
    add("nut.vm", include_bytes!("../scripts/nut.vm"));
    add("hills.png", &hills());
    add("cloud.json", b"{ \"type\": \"float32\", \"size\": [2, 2, 2], \"origin\": [1, 2, 3] }");
    add("cloud.raw", (0..8).flat_map(|i| (i as f32).to_le_bytes()).collect::<Vec<u8>>().as_slice());
    add("knot.obj", include_bytes!("../scripts/knot.obj"));
    add("leaf.svg", include_bytes!("../scripts/leaf.svg"));
    Interpreter::new(Arc::new(world), PathBuf::new(), Limits::default(), None).unwrap()
}

fn value(interpreter: &mut Interpreter, input: &str) -> String {
    match interpreter.eval(input) {
        Ok(text) => text.unwrap_or_default(),
        Err(d) => panic!("{input}: {d}"),
    }
}

#[test]
fn modules_are_looked_through_for_what_is_hardly_meant() {
    let mut world = Files::default();
    world.0.insert("bowl.rhai".into(), b"fn bowl() {\n    y - -x ** 2\n}\n".to_vec());
    let mut request = Request::text("import \"bowl\" as b;\nb::bowl() + -y ** 2");
    request.world = Arc::new(world);
    let places = compile(&request).diagnostics.into_iter().map(|d| d.place.expect("a place"));
    let found: Vec<_> = places.map(|place| (place.file.to_string(), place.line, place.column)).collect();
    assert_eq!(found, [("bowl.rhai".into(), 2, 9), ("script".into(), 2, 13)]);
    // None of the standard library is warned of.
    for (name, _) in STD {
        let text = format!("import \"std/{name}\" as m;\nsphere(1.0)");
        assert_eq!(compile(&Request::text(&text)).diagnostics, [], "{name}");
    }
}

#[test]
fn the_interpreter_remembers_variables_functions_and_imports() {
    let mut i = interpreter();
    assert_eq!(value(&mut i, "let r = 2.0;"), "");
    assert_eq!(value(&mut i, "fn twice(f) { f * 2.0 }"), "");
    assert_eq!(value(&mut i, "import \"std/fractal\" as fractal;"), "");
    assert_eq!(value(&mut i, "twice(x + r)"), "2 * (x + 2)\n  C2, of x, 4 nodes");
    assert!(value(&mut i, "fractal::fbm(gradient(1))").starts_with("fbm of 8 octaves of gradient noise"));
    assert_eq!(value(&mut i, "sphere(r).at([3, 0, 0])"), "1.0");
    assert!(i.scene().is_some());
}

#[test]
fn numbers_of_every_kind_work_in_every_function() {
    let mut i = interpreter();
    assert_eq!(value(&mut i, "let a = affine(1, 2); enclosure(a - a).width < 1e-14"), "true");
    assert!(value(&mut i, "sqrt(interval(4, 9))").starts_with("[1.99999"));
    assert!(value(&mut i, "sphere(1.0).range(region(1.0))").starts_with("[-1"));
    assert_eq!(value(&mut i, "min(vec3(1, 5, 3), 2)"), "vec3(1, 2, 2)");
    assert_eq!(value(&mut i, "sphere(1.0).gradient([2, 0, 0])"), "vec3(1, 0, 0)");
    assert_eq!(value(&mut i, "(x * y).hessian([1, 1, 1])"), "[vec3(0, 1, 0), vec3(1, 0, 0), vec3(0, 0, 0)]");
    assert_eq!(value(&mut i, "cross([1, 0, 0], [0, 1, 0])"), "vec3(0, 0, 1)");
    assert_eq!(value(&mut i, "length([3, 4, 0]) + dot([1, 2, 3], [1, 1, 1])"), "11.0");
    assert_eq!(value(&mut i, "smoothstep(0, 2, 1.0)"), "0.5");
    assert_eq!(value(&mut i, "(x ** 2 + pow(y, 3) - x % 2.0).show()"), "x**2 + y**3 - modulo(x, 2)");
    assert_eq!(value(&mut i, "0.5..1"), "[0.5, 1]");
    assert!(value(&mut i, "sphere(1.0).at(vec3(1.0..2.0, 0.0, 0.0))").starts_with("[-"));
    assert!(value(&mut i, "sphere(1.0).lipschitz(region(2.0)) >= 1.0") == "true");
}

#[test]
fn functions_see_coordinates_wherever_they_are() {
    let mut i = interpreter();
    for (input, shown) in [
        ("let ring = |r| length(p) - r * TAU / PI; ring.call(0.5).at([3, 0, 4])", "4.0"),
        ("fn maker(a) { |b| x * a + y * b } maker(2.0).call(3.0).at([1, 1, 0])", "5.0"),
        ("let x = 7.0; let own = |y| x + y; own.call(1.0)", "8.0"),
        ("let a = [PI]; a.push(x); a[0] = 1.0; a[1] = 2.0; a", "[1.0, 2.0]"),
        ("fn changed() { let a = []; a += z; a[0] = 3.0; a[0] } changed()", "3.0"),
        ("let v = p; v = v * 2.0; v.at([1, 2, 3]).y", "4.0"),
        ("[1.0, 2.0].map(|k| (k * z).at([0, 0, 2]))", "[2.0, 4.0]"),
    ] {
        assert_eq!(value(&mut i, input), shown, "{input}");
    }
    let mut other = interpreter();
    for refused in ["x = 1.0;", "y += 1.0;", "let set = |q| { z = q; z }; set.call(1.0)", "PI += 1.0;"] {
        assert!(other.eval(refused).is_err(), "{refused}");
        assert_eq!(value(&mut other, "p.at([1, 2, 3]).z + PI - PI"), "3.0");
    }
}

#[test]
fn places_stay_right_over_many_inputs() {
    let mut i = interpreter();
    value(&mut i, "let a = 1;");
    value(&mut i, "fn broken() {\n    spere(1.0)\n}");
    let d = i.eval("let b = broken();").unwrap_err();
    let place = d.place.clone().unwrap();
    assert_eq!((place.line, place.column), (3, 5));
    assert_eq!(d.trace[0].1.line, 5);
    assert!(i.sources().contains_key("input"));
    assert_eq!(value(&mut i, "a + 1"), "2");
}

#[test]
fn comparisons_of_fields_are_refused_in_any_order() {
    let mut i = interpreter();
    for op in ["==", "!=", "<", "<=", ">", ">="] {
        for (a, b) in
            [("x", "1.0"), ("1", "x"), ("x", "y"), ("p", "x"), ("gradient(1)", "0.5"), ("x", "\"a\"")]
        {
            let outcome = i.eval(&format!("{a} {op} {b}"));
            assert!(outcome.is_err(), "{a} {op} {b} gives {outcome:?}");
        }
    }
    assert_eq!(
        value(&mut i, "[1 == 1, 1 == 1.0, \"a\" == \"a\", [1] == [1], () == (), 1 == \"a\"]"),
        "[true, true, true, true, true, false]"
    );
    assert_eq!(value(&mut i, "vec3(1, 2, 3) == vec3(1, 2, 3)"), "true");
    assert_eq!(value(&mut i, "[3, 1, 2].contains(2) && [3, 1, 2].index_of(2) == 2"), "true");
    assert_eq!(value(&mut i, "let a = [3, 1, 2]; a.sort(); a"), "[1, 2, 3]");
}

#[test]
fn incomplete_inputs_wait() {
    let i = interpreter();
    for open in ["fn f() {", "sphere(1.0", "`text", "/* comment", "x +", "scene(#{"] {
        assert!(i.is_incomplete(open), "{open}");
    }
    for closed in ["x", "\"open", "f(1)", ")", "", "x + 1;"] {
        assert!(!i.is_incomplete(closed), "{closed}");
    }
}

#[test]
fn names_and_help_come_from_the_declarations() {
    let mut i = interpreter();
    value(&mut i, "let mine = 1;");
    let names = i.names();
    for name in ["sphere", "smooth_union", "fractal::ridged", "smoothstep", "orbit", "x", "mine", "let"] {
        assert!(names.iter().any(|n| n == name), "{name}");
    }
    assert!(i.help("smoothstep").unwrap().contains("smoothstep(low, high, x)"));
    assert!(i.help("ridged").unwrap().contains("fractal::ridged(noise, options)"));
    assert!(i.help("nothing_at_all").is_none());
}

#[test]
fn files_load_as_if_typed() {
    let mut i = interpreter();
    assert!(i.load(Path::new("ball.rhai")).unwrap().unwrap().starts_with("length(x, y, z) - 2"));
    assert_eq!(value(&mut i, "size"), "2.0");
    assert!(i.load(Path::new("none.rhai")).is_err());
}

#[test]
fn pictures_and_volumes_become_grids() {
    let mut i = interpreter();
    let mut at =
        |grid: &str, p: &str| -> f64 { value(&mut i, &format!("{grid}.field().at({p})")).parse().unwrap() };
    let mut close = |grid: &str, p: &str, wanted: f64| {
        let found = at(grid, p);
        assert!((found - wanted).abs() < 1e-12, "{grid} at {p}: {found}");
    };
    // Seen from above: x to the right, z down; square pixels, the outermost on the edge.
    let hills = "load_heightfield(\"hills.png\")";
    for (p, wanted) in [("-1, 7, -0.5", 0.0), ("0, 0, -0.5", 0.2), ("1, 0, -0.5", 0.4), ("1, 0, 0.5", 1.0)] {
        close(hills, &format!("[{p}]"), wanted);
    }
    let placed =
        "load_heightfield(\"hills.png\", #{ extent: 6.0, height: -5.0, center: [10, 3, 0], repeat: true })";
    for (p, wanted) in
        [("7, 0, -2", 0.0), ("9, 0, -2", -1.0), ("11, 0, 0", -5.0), ("13, 0, -2", 0.0), ("7, 0, 2", 0.0)]
    {
        close(placed, &format!("[{p}]"), wanted);
    }
    let cloud = "load_grid(\"cloud.json\")";
    for (p, wanted) in
        [("1, 2, 3", 0.0), ("2, 2, 3", 1.0), ("1, 3, 3", 2.0), ("1, 2, 4", 4.0), ("2, 3, 4", 7.0)]
    {
        close(cloud, &format!("[{p}]"), wanted);
    }
    // Grown about its middle, unless that is told to be elsewhere.
    close("load_grid(\"cloud.json\", #{ extent: 3.0 })", "[3, 4, 5]", 7.0);
    close("load_grid(\"cloud.json\", #{ extent: 3.0, center: [0, 0, 0] })", "[1.5, 1.5, -1.5]", 3.0);
}

#[test]
fn textures_lie_around_solids() {
    let mut i = interpreter();
    value(&mut i, "import \"std/texture\" as texture;");
    value(&mut i, "let image = texture::load(\"hills.png\");");
    let mut close = |texture: &str, [x, y, z]: [f64; 3], wanted: f64| {
        let code = format!("texture::{texture}.y.at([{x:?}, {y:?}, {z:?}])");
        let found: f64 = value(&mut i, &code).parse().unwrap();
        assert!((found - wanted).abs() < 1e-9, "{texture} at {x}, {y}, {z}: {found} for {wanted}");
    };
    // Three pixels by two, over a width of 1 about the origin, of these shares of white; what a screen makes of them.
    let shown = |share: f64| libm::pow((share + 0.055) / 1.055, 2.4);
    let (third, sixth) = (1.0 / 3.0, 1.0 / 6.0);
    close("flat(image, 2.0)", [2.0 * third, 9.0, third], 1.0);
    close("flat(image, 2.0)", [0.0, -9.0, -third], shown(0.2));
    close("flat(image, 2.0)", [2.0 * third + 2.0, 0.0, third], 1.0);
    // Around, from behind: three pixels again, and half as many rows, from pole to pole.
    for (down, shares) in [(-0.25, [0.6, 0.8, 1.0]), (0.25, [0.0, 0.2, 0.4])] {
        for (turn, share) in [-third, 0.0, third].into_iter().zip(shares) {
            let (sine, cosine) = libm::sincos(std::f64::consts::TAU * turn);
            let (up, across) = libm::sincos(std::f64::consts::PI * down);
            for radius in [0.2, 3.0] {
                close(
                    "spherical(image)",
                    [radius * across * sine, radius * up, radius * across * cosine],
                    shown(share),
                );
            }
            // No row follows the last.
            close("spherical(image)", [1e-9 * sine, 4.0 * down, 1e-9 * cosine], shown(share));
        }
    }
    // As each side faces it, from left to right as seen from outside, and half of either where it faces two.
    close("triplanar(image, 1.0, x)", [5.0, -sixth, -third], 1.0);
    close("triplanar(image, 1.0, -x)", [-5.0, -sixth, third], 1.0);
    close("triplanar(image, 1.0, z)", [third, -sixth, 5.0], 1.0);
    close("triplanar(image, 1.0, -z)", [-third, -sixth, -5.0], 1.0);
    close("triplanar(image, 1.0, -y)", [-third, -5.0, -sixth], shown(0.4));
    close("triplanar(image, 1.0, y + z)", [third, sixth, sixth], 0.5 * (shown(0.4) + 1.0));
}

#[test]
fn colours_know_slopes_and_curvature() {
    let mut i = interpreter();
    value(&mut i, "import \"std/material\" as material;");
    let mut close = |code: &str, wanted: f64| {
        let found: f64 = value(&mut i, &format!("material::{code}")).parse().unwrap();
        assert!((found - wanted).abs() < 1e-3, "{code}: {found} for {wanted}");
    };
    close("steepness(sphere(1.0)).at([0.6, 0.0, 0.8])", 0.0);
    close("steepness(x).at([0.0, 1.0, 0.0])", 1.0);
    for (y, wanted) in [(1.0, 0.0), (0.0, 1.0), (-1.0, 2.0)] {
        let x = 1.0 - y * y;
        close(&format!("steepness(sphere(1.0), vec3(0, 1, 0)).at([{x:?}, {y:?}, 0.0])"), wanted);
    }
    close("curvature(sphere(2.0), 0.02).at([0.0, 2.0, 0.0])", 1.0);
    close("curvature(sphere(2.0), 0.02).at([1.0, 0.0, 0.0])", 2.0);
    close("curvature(-sphere(2.0), 0.02).at([0.0, 0.0, 2.0])", -1.0);
    close("curvature(y, 0.1).at([0.3, 0.0, 2.0])", 0.0);
}

#[test]
fn every_entry_of_the_reference_is_documented_and_its_example_runs() {
    let mut i = interpreter();
    for (module, _) in STD.iter().filter(|(module, _)| !PRELUDE.contains(module)) {
        value(&mut i, &format!("import \"std/{module}\" as {module};"));
    }
    value(&mut i, "let ground = sphere(1.0);");
    for entry in reference() {
        assert!(!entry.doc.is_empty(), "{} has no documentation", entry.name);
        assert!(!entry.example.is_empty(), "{} has no example", entry.name);
        value(&mut i, &entry.example);
    }
}

/// Equal expressions have one fingerprint, whatever else was made before them; others have others.
#[test]
fn expressions_are_known_by_their_fingerprints() {
    let print = |script: &str| {
        let scene = compile(&Request::text(script)).scene.unwrap_or_else(|| panic!("{script}"));
        scene.graph.fingerprint(scene.surface.field)
    };
    let scripts = [
        "x - y",
        "y - x",
        "min(x, y)",
        "max(x, y)",
        "(x + y) * z",
        "x + y * z",
        "x * time",
        "sphere(1.0)",
        "sphere(1.5)",
        "gradient(7) + 0.5",
        "gradient(8) + 0.5",
        "sparse(7) + 0.5",
        "gradient(7).scaled(2.0) + 0.5",
        "gradient(7).tiled(4) + 0.5",
        "sphere(1.0).flow(vec3(0.1 * y, 0, 0))",
        "sphere(1.0).flow(vec3(0.2 * y, 0, 0))",
        "sphere(1.0).flow(vec3(0.1 * y, 0, 0), #{ steps: 3 })",
        "sphere(1.5).flow(vec3(0.1 * y, 0, 0))",
        "curve([[0, 0, 0], [1, 0, 0]], #{ kind: \"bspline\", degree: 1 })",
        "curve([[0, 0, 0], [1, 0, 0]], #{ kind: \"bspline\", degree: 2 })",
        "curve([[0, 0, 0], [1, 0, 1]])",
        "spectral(7, #{ size: 8 }).field()",
        "spectral(8, #{ size: 8 }).field()",
        "spectral(7, #{ size: 8, extent: 3.0 }).field()",
    ];
    let prints = scripts.map(print);
    for (i, script) in scripts.iter().enumerate() {
        let earlier = format!("let other = z * 3.0 - torus(1.0, 0.3).flow(vec3(0, y, 0));\n{script}");
        assert_eq!(print(&earlier), prints[i], "{script}");
        let same = (0..i).find(|&other| prints[other] == prints[i]);
        assert_eq!(same.map(|other| scripts[other]), None, "{script}");
    }
}

#[test]
fn a_run_stops_when_asked() {
    let mut request = Request::text("let n = 0; loop { n += 1; }");
    request.cancel = Some(Arc::new(AtomicBool::new(true)));
    assert_eq!(compile(&request).diagnostics[0].message, "the script was stopped");
}

#[test]
fn nesting_of_any_depth_is_an_error_and_no_crash() {
    for (open, close) in
        [("(", ")"), ("[", "]"), ("#{a:", "}"), ("-", ""), ("{", "}"), ("if true {", "}"), ("abs(", ")")]
    {
        for depth in [40, 2000, 50_000] {
            let text = format!("{}x{}", open.repeat(depth), close.repeat(depth));
            let _ = compile(&Request::text(text));
        }
    }
    let deep = "let a = []; for i in 0..100000 { a = [a]; } x";
    let _ = compile(&Request::text(deep));
    let chain = "let f = x; for i in 0..200000 { f = sin(f); } print(f); f.at([1, 2, 3]); f";
    assert!(compile(&Request::text(chain)).scene.is_some());
}

const WORDS: &[&str] = &[
    "let",
    "a",
    "b",
    "=",
    ";",
    "x",
    "y",
    "p",
    "time",
    "(",
    ")",
    "{",
    "}",
    "[",
    "]",
    "#{",
    ":",
    ",",
    ".",
    "..",
    "::",
    "+",
    "-",
    "*",
    "/",
    "%",
    "**",
    "==",
    "<",
    "!",
    "&&",
    "||",
    "|",
    "1",
    "2.5",
    "0",
    "1e308",
    "-1",
    "9223372036854775807",
    "\"t\"",
    "'c'",
    "`s`",
    "true",
    "()",
    "fn",
    "f",
    "if",
    "else",
    "while",
    "loop",
    "for",
    "in",
    "return",
    "import",
    "as",
    "break",
    "continue",
    "throw",
    "try",
    "catch",
    "switch",
    "=>",
    "sphere",
    "box",
    "union",
    "min",
    "sin",
    "sqrt",
    "pow",
    "clamp",
    "mix",
    "smoothstep",
    "gradient",
    "octave_sum",
    "scaled",
    "on_sphere",
    "at",
    "range",
    "region",
    "interval",
    "affine",
    "vec3",
    "length",
    "dot",
    "cross",
    "rgb",
    "colored",
    "param",
    "orbit",
    "look_at",
    "scene",
    "sun",
    "film",
    "surface",
    "camera",
    "octaves",
    "\"std/fractal\"",
    "\"ridged\"",
    "print",
    "show",
    "translated",
    "rotated",
    "mirrored",
    "hessian",
    "lipschitz",
    "+=",
    "\n",
    "//",
    "/*",
    "\"",
    "é",
    "metres",
    "to_int",
    "this",
    "type_of",
    "call",
    "Fn",
];

fn hostile(text: String) {
    let mut request = Request::text(text.clone());
    request.limits = Limits {
        operations: 20_000,
        nodes: 5_000,
        time: Duration::from_millis(500),
        elements: 2_000,
        text: 10_000,
        ..Limits::default()
    };
    let start = Instant::now();
    let compiled = compile(&request);
    assert!(start.elapsed() < Duration::from_secs(5), "took too long:\n{text}");
    for d in &compiled.diagnostics {
        assert!(!d.message.contains("bug of the program"), "panicked:\n{text}");
        let shown = orogen::diag::render(d, &compiled.sources, false);
        assert!(!shown.contains("::value::") && !shown.contains("orogen::"), "{shown}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn token_soup_is_survived(words in prop::collection::vec(prop::sample::select(WORDS), 0..40)) {
        hostile(words.join(" "));
    }

    #[test]
    fn any_text_is_survived(text in "\\PC{0,60}") {
        hostile(text);
    }

    #[test]
    fn damaged_scripts_are_survived(
        at in 0usize..1200,
        cut in 0usize..40,
        word in prop::sample::select(WORDS),
    ) {
        let text = include_str!("suite/planet.rhai");
        let floor = |mut i: usize| { i = i.min(text.len()); while !text.is_char_boundary(i) { i -= 1; } i };
        let (start, end) = (floor(at), floor(at + cut));
        hostile(format!("{}{word}{}", &text[..start], &text[end..]));
    }

    #[test]
    fn calls_with_any_arguments_are_survived(
        pick in any::<prop::sample::Index>(),
        args in prop::collection::vec(prop::sample::select(&[
            "x", "p", "1", "-1", "0", "0.5", "1e308", "-1e308", "1.0/0.0", "0.0/0.0", "\"#fff\"", "[]", "[1,2,3]", "#{}",
            "vec3(1,2,3)", "gradient(1)", "interval(-1,1)", "affine(0,1)", "region(1)", "()", "true", "0.0..1.0", "1..3",
            "sphere(1)", "9223372036854775807", "vec3(0,0,0)", "'c'", "|a| a", "[[1],[2]]",
        ][..]), 0..4),
    ) {
        let names: Vec<String> = reference().into_iter().map(|e| e.name).filter(|n| n.chars().all(|c| c.is_alphanumeric() || c == '_')).collect();
        hostile(format!("{}({})", names[pick.index(names.len())], args.join(", ")));
    }
}

#[test]
fn calls_within_calls_are_limited_whatever_is_asked_for() {
    let mut request = Request::text("fn f(n) { f(n + 1) } f(0)");
    request.limits.calls = usize::MAX;
    let compiled = compile(&request);
    assert!(compiled.scene.is_none() && compiled.diagnostics.len() == 1, "{:?}", compiled.diagnostics);
}
