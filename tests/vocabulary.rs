//! The laws over the vocabulary of the language: for every example of the standard library that is a
//! field, what is said of a box holds for the points in it, slopes are those of the values, and nowhere
//! is there no value.

use glam::DVec3;
use orogen::field::Field;
use orogen::num::Interval;
use orogen::script::{Compiled, Entry, Request, compile, reference};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use std::collections::BTreeSet;

/// Modules whose examples are solids.
const MODULES: [&str; 11] = [
    "algebraic",
    "arrange",
    "blend",
    "blobs",
    "convolution",
    "csg",
    "deform",
    "displace",
    "morph",
    "shapes",
    "warp",
];

/// Functions of these modules whose examples are no fields.
const NO_FIELDS: [&str; 2] = ["warp::fold_by_noise", "warp::fold_by_flow"];

fn entries() -> Vec<Entry> {
    let is_solid = |e: &Entry| e.group.strip_prefix("std/").is_some_and(|m| MODULES.contains(&m));
    reference().into_iter().filter(|e| is_solid(e) && !NO_FIELDS.contains(&e.name.as_str())).collect()
}

fn compiled(text: &str) -> Compiled {
    let modules: BTreeSet<&str> = MODULES.into_iter().chain(["fractal"]).collect();
    let imports: String = modules
        .iter()
        .filter(|m| text.contains(&format!("{m}::")))
        .map(|m| format!("import \"std/{m}\" as {m};\n"))
        .collect();
    compile(&Request::text(format!("{imports}{text}")))
}

fn field(text: &str) -> Field {
    let compiled = compiled(text);
    let scene = compiled.scene.unwrap_or_else(|| panic!("{text}: {:?}", compiled.diagnostics));
    Field::new(&scene.graph, scene.surface.field)
}

fn somewhere(rng: &mut StdRng) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| rng.random_range(-2.0..2.0)))
}

/// Points where something may be wrong: the origin, axes and planes through it, half integers; and their
/// close neighbours.
fn special(rng: &mut StdRng) -> DVec3 {
    let near = if rng.random() { 0.0 } else { 1e-9 };
    DVec3::from_array(std::array::from_fn(|_| {
        0.5 * f64::from(rng.random_range(-2..=2)) + near * rng.random_range(-1.0..1.0)
    }))
}

/// A point of the surface on the way between two points, if there is one.
fn on_surface(f: &mut Field, mut a: DVec3, mut b: DVec3) -> Option<DVec3> {
    let is_inside = f.value(a) < 0.0;
    if is_inside == (f.value(b) < 0.0) {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (a + b);
        if (f.value(middle) < 0.0) == is_inside { a = middle } else { b = middle }
    }
    Some(a)
}

#[test]
fn boxes_hold_what_is_in_them() {
    let mut finite = 0;
    for entry in entries() {
        let mut f = field(&entry.example);
        let mut rng = StdRng::seed_from_u64(1);
        let mut bounded = 0;
        for i in 0..200 {
            let radius = libm::exp10(rng.random_range(-4.0..0.0));
            let centre = if i % 4 == 0 { special(&mut rng) } else { somewhere(&mut rng) };
            let region = centre.to_array().map(|c| Interval::around(c, radius));
            let (range, slope) = (f.range(&region), f.slope(&region));
            bounded += u32::from(slope.norm.is_finite() && range.is_finite());
            for _ in 0..20 {
                let at = region.map(|x| rng.random_range(x.lo..=x.hi));
                let (value, gradient) = f.gradient(at.into());
                // The value is rounded: its enclosure at the point says by how much.
                let exact = f.range(&at.map(Interval::point));
                assert!(
                    range.lo <= exact.hi && exact.lo <= range.hi,
                    "{}: {value} at {at:?} outside {range:?}",
                    entry.name
                );
                assert!(
                    gradient.length() <= slope.norm * (1.0 + 1e-9) + 1e-9,
                    "{}: slope {} at {at:?} above {}",
                    entry.name,
                    gradient.length(),
                    slope.norm
                );
            }
        }
        assert!(bounded >= 190, "{}: only {bounded} of 200 boxes have bounds", entry.name);
        finite += bounded;
    }
    assert!(finite > 15_000, "{finite}");
}

#[test]
fn there_is_a_value_and_a_slope_everywhere() {
    for entry in entries() {
        let mut f = field(&entry.example);
        let mut rng = StdRng::seed_from_u64(2);
        let mut points: Vec<DVec3> = (0..400).map(|_| special(&mut rng)).collect();
        points.push(DVec3::ZERO);
        let mut found = 0;
        for _ in 0..1000 {
            let (a, b) = (somewhere(&mut rng), 0.4 * somewhere(&mut rng));
            let surface = on_surface(&mut f, a, b);
            found += u32::from(surface.is_some());
            points.extend(surface);
            points.push(a);
        }
        assert!(found > 0, "{} has no surface", entry.name);
        for at in points {
            let (value, gradient) = f.gradient(at);
            assert!(value.is_finite(), "{}: {value} at {at:?}", entry.name);
            assert!(gradient.is_finite(), "{}: slope {gradient:?} at {at:?}", entry.name);
        }
    }
}

#[test]
fn slopes_match_differences() {
    for entry in entries() {
        let mut f = field(&entry.example);
        let mut rng = StdRng::seed_from_u64(3);
        let mut right = 0;
        for _ in 0..200 {
            let (at, h) = (somewhere(&mut rng), 1e-6);
            let (_, gradient) = f.gradient(at);
            let difference =
                DVec3::AXES.map(|axis| (f.value(at + h * axis) - f.value(at - h * axis)) / (2.0 * h));
            let error = (gradient - DVec3::from_array(difference)).length();
            right += u32::from(error <= 1e-5 * (1.0 + gradient.length()));
        }
        // A crease may lie between.
        assert!(right >= 195, "{}: only {right} of 200 slopes are right", entry.name);
    }
}

/// Text of a random polynomial, and what it is at a point.
fn polynomial(rng: &mut StdRng, depth: u32) -> (String, Box<dyn Fn(DVec3) -> f64>) {
    let pick = rng.random_range(0..if depth == 0 { 2 } else { 5 });
    if pick == 0 {
        let c = f64::from(rng.random_range(0..40)) * 0.25;
        return (format!("{c}"), Box::new(move |_| c));
    }
    if pick == 1 {
        let axis = rng.random_range(0..3);
        return (["x", "y", "z"][axis].to_owned(), Box::new(move |p| p[axis]));
    }
    let (a, f) = polynomial(rng, depth - 1);
    let (b, g) = polynomial(rng, depth - 1);
    match pick {
        2 => (format!("({a} + {b})"), Box::new(move |p| f(p) + g(p))),
        3 if rng.random() => (format!("({a} - {b})"), Box::new(move |p| f(p) - g(p))),
        3 => (format!("({a})({b})"), Box::new(move |p| f(p) * g(p))),
        _ => {
            let n = rng.random_range(0..4);
            (format!("({a})^{n}"), Box::new(move |p| libm::pow(f(p), f64::from(n))))
        }
    }
}

#[test]
#[allow(clippy::disallowed_methods)] // the difference is below the tolerance
fn polynomials_are_what_their_texts_say() {
    let mut rng = StdRng::seed_from_u64(4);
    for _ in 0..150 {
        let (text, truth) = polynomial(&mut rng, 4);
        let mut f = field(&format!("polynomial(\"{text}\")"));
        for _ in 0..10 {
            let at = 0.5 * somewhere(&mut rng);
            let (got, want) = (f.value(at), truth(at));
            // Sums in another order: off by roundings of what cancels, which is no larger than 1e9 here.
            assert!(
                (got - want).abs() <= 1e-9 * (1.0 + want.abs()) || want.abs() > 1e9,
                "{text}: {got} not {want}"
            );
        }
    }
}

#[test]
fn horner_takes_few_operations() {
    let size = |text: &str| {
        let scene = compiled(text).scene.expect("a polynomial");
        orogen::tape::Tape::new(&scene.graph, &[scene.surface.field]).len()
    };
    // x (x (x (x + 1) + 1) + 1) + 1
    assert!(size("polynomial(\"x^4 + x^3 + x^2 + x + 1\")") <= 8);
    let mitchell = "polynomial([[4, 4, 0, 0], [4, 0, 4, 0], [8, 0, 2, 2], [4, 0, 0, 4], [17, 2, 2, 0], [17, 2, 0, 2], [-20, 2, 0, 0], [-20, 0, 2, 0], [-20, 0, 0, 2], [17, 0, 0, 0]])";
    assert!(size(mitchell) <= 24, "{}", size(mitchell));
}
