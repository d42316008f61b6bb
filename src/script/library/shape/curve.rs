//! `curve`: points with a radius.

use super::{field, list, numbers, points};
use crate::script::fault::{Fault, Outcome};
use crate::script::library::grid::{listed, with_options};
use crate::script::library::{Call, Library};
use crate::script::options::{Options, describe};
use crate::script::value::number;
use crate::shape::curve::{Curve, Degree, Flaw, Kind};
use rhai::Dynamic;

pub(super) fn register(lib: &mut Library<'_>) {
    let sentence = listed(
        "A tube along a curve through or near points (an array of vectors): the distance from it, negative inside.",
        &[
            "kind: \"polyline\" (straight from point to point), \"bezier\" (pieces of degree + 1 points, of which each begins at the last point of the one before), \"bspline\" (smooth, and the points pull), \"catmull_rom\" (smooth, through all points)",
            "degree: 1, 2 or 3, of bezier and bspline",
            "radius: one number, or an array of numbers that are spread evenly along the points; 0.1 unless given",
            "closed: whether it goes on from the last point to the first",
        ],
    );
    with_options(
        lib,
        "curve",
        "points",
        &sentence,
        "curve([[-1, 0, 0], [0, 1, 0], [1, 0, 0]], #{ kind: \"bspline\", radius: [0.3, 0.05] })",
        curve,
    );
}

fn curve(c: &Call<'_>) -> Outcome<Dynamic> {
    let entries = list(&c.args[0]).ok_or_else(|| c.wrong(0, "an array of points"))?;
    let mut o = Options::new(c, 1)?;
    let kind = o.choice("kind", &["catmull_rom", "polyline", "bezier", "bspline"])?;
    let degree = match o.integer("degree", 1..=3, 3)? {
        1 => Degree::One,
        2 => Degree::Two,
        _ => Degree::Three,
    };
    let radii = match o.get("radius") {
        None => vec![0.1],
        Some(given) => {
            let found = match list(&given) {
                Some(list) => numbers(&list),
                None => number(&given).map(|r| vec![r]),
            };
            let radii = found.filter(|radii| !radii.is_empty());
            radii.ok_or_else(|| o.mismatch("radius", "a number or an array of numbers", &given))?
        }
    };
    let closed = o.flag("closed", false)?;
    o.finish()?;
    let points = points(c, &entries, |i| {
        let given = describe(&entries[i]);
        Fault::new(format!("point {i} of `curve` must be a vector such as [0, 1, 0], not {given}"))
    })?;
    let kind = match kind {
        "polyline" => Kind::Polyline,
        "bezier" => Kind::Bezier(degree),
        "bspline" => Kind::Bspline(degree),
        _ => Kind::CatmullRom,
    };
    field(c, Curve::new(&points, &radii, kind, closed).map_err(failed)?)
}

fn failed(flaw: Flaw) -> Fault {
    let fault = Fault::new(flaw.to_string());
    match flaw {
        Flaw::Radius { .. } | Flaw::NoRadius => fault.key("radius"),
        Flaw::Rest { .. } => {
            fault.hint("kind: \"bspline\" and kind: \"catmull_rom\" take any number of points")
        }
        Flaw::Count { .. } | Flaw::Point(_) => fault,
    }
}
