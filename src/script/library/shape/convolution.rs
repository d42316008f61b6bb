//! `convolution`: skeletons with flesh.

use super::{field, list};
use crate::script::fault::{Fault, Outcome};
use crate::script::library::grid::listed;
use crate::script::library::{Call, Library};
use crate::script::options::{Options, describe};
use crate::script::value::number;
use crate::shape::convolution::{Arc, Convolution, Density, Flaw, Primitive};
use glam::DVec3;
use rhai::Dynamic;

pub(super) fn register(lib: &mut Library<'_>) {
    let sentence = listed(
        "A skeleton with flesh that melts together without seams. Parts are arrays of their points, and may have a weight as one more entry: thicker above 1, carving below 0.",
        &[
            "points: an array of points, or of [point, weight]",
            "segments: an array of [a, b] or [a, b, weight]",
            "triangles: an array of [a, b, c] or [a, b, c, weight]",
            "arcs: an array of [a, b, c] or [a, b, c, weight], circles from a through b to c",
            "width: radius of a long thread by itself at the threshold 0.5, where the field is about a distance",
            "threshold: how dense the surface is; a lower one is farther out",
            "kernel: \"cauchy\", which is smooth (C2) and reaches everywhere, or \"compact\" (C1), which ends at about twice the width and knows points and segments only",
        ],
    );
    lib.def(
        "convolution(options)",
        &sentence,
        "convolution(#{ segments: [[[-1, 0, 0], [1, 0, 0]], [[0, 0, 0], [0, 1, 0], 0.8]], width: 0.2 })",
        convolution,
    );
}

/// What a kind of part is called, how many points it has, and how it is made.
type Kind = (&'static str, usize, fn(&[DVec3]) -> Option<Primitive>);

const KINDS: [Kind; 4] = [
    ("points", 1, |p| Some(Primitive::Point(p[0]))),
    ("segments", 2, |p| Some(Primitive::Segment([p[0], p[1]]))),
    ("triangles", 3, |p| Some(Primitive::Triangle([p[0], p[1], p[2]]))),
    ("arcs", 3, |p| Arc::through(p[0], p[1], p[2]).map(Primitive::Arc)),
];

fn convolution(c: &Call<'_>) -> Outcome<Dynamic> {
    let mut o = Options::new(c, 0)?;
    let mut parts = Vec::new();
    for (key, count, make) in KINDS {
        let Some(given) = o.get(key) else { continue };
        let wanted = "an array of parts, each an array of its points";
        let entries = list(&given).ok_or_else(|| o.mismatch(key, wanted, &given))?;
        for (i, entry) in entries.iter().enumerate() {
            parts.push(part(c, (key, count, make), i, entry)?);
        }
    }
    let width = o.number("width", 1e-9..=1e9, 0.1)?;
    let threshold = o.number("threshold", 1e-6..=1e6, 0.5)?;
    let density = match o.choice("kernel", &["cauchy", "compact"])? {
        "compact" => Density::Compact(width),
        _ => Density::Cauchy(width),
    };
    o.finish()?;
    field(c, Convolution::new(&parts, density, threshold).map_err(failed)?)
}

/// One part and its weight.
fn part(c: &Call<'_>, (key, count, make): Kind, i: usize, given: &Dynamic) -> Outcome<(Primitive, f64)> {
    let wrong = |hint: String| {
        let points = if count == 1 { "a point".to_owned() } else { format!("an array of {count} points") };
        Fault::new(format!("{key}[{i}] of `convolution` must be {points}, perhaps with a weight after"))
            .key(key)
            .hint(hint)
    };
    // A point by itself needs no array around it.
    if let (1, Some(p)) = (count, c.vec3_of(given)?) {
        return make(&[p]).map(|p| (p, 1.0)).ok_or_else(|| wrong(String::new()));
    }
    let entries = list(given).ok_or_else(|| wrong(format!("it is {}", describe(given))))?;
    let weight = match entries.len() {
        n if n == count => 1.0,
        n if n == count + 1 => number(&entries[count])
            .filter(|w| w.abs() <= 1e6)
            .ok_or_else(|| wrong(format!("its weight is {}", describe(&entries[count]))))?,
        n => return Err(wrong(format!("it is an array of {n}"))),
    };
    let points: Vec<DVec3> = super::points(c, &entries[..count], |k| {
        wrong(format!("its point {k} is {}", describe(&entries[k])))
    })?;
    let made = make(&points)
        .ok_or_else(|| wrong("the three points are on a line, which no circle goes through".to_owned()))?;
    Ok((made, weight))
}

fn failed(flaw: Flaw) -> Fault {
    let fault = Fault::new(flaw.to_string());
    match flaw {
        Flaw::Count(0) => fault.hint("give points, segments, triangles or arcs"),
        Flaw::Kernel(_) => fault.key("kernel").hint("the cauchy kernel knows them all"),
        Flaw::Count(_) | Flaw::Lost(_) => fault,
    }
}
