//! `tetrahedra`: polynomials over cells.

use super::{field, list, numbers, points};
use crate::script::fault::{Fault, Outcome};
use crate::script::library::grid::listed;
use crate::script::library::{Call, Library};
use crate::script::options::{Options, describe};
use crate::shape::tetrahedra::{Flaw, HIGHEST, Tetrahedra};
use rhai::{Dynamic, INT};

pub(super) fn register(lib: &mut Library<'_>) {
    let sentence = listed(
        "A piecewise algebraic surface: over each of the tetrahedra (arrays of four numbers of points) that fill a convex region a polynomial in Bernstein form. Where two meet they must agree. Outside, the field is that of the nearest point of the region and the distance from there: give positive values on the boundary and the surface is closed.",
        &[
            "degree: 1 to 6",
            "coefficients: for each cell an array; first those with the highest power of its first corner, among these first those with the highest power of its second, and so on: 4, 10, 20, 35, 56 or 84",
        ],
    );
    lib.def(
        "tetrahedra(points, cells, options)",
        &sentence,
        "tetrahedra([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2, 3]], #{ degree: 1, coefficients: [[-1, 1, 1, 1]] })",
        tetrahedra,
    );
}

fn tetrahedra(c: &Call<'_>) -> Outcome<Dynamic> {
    let corners = list(&c.args[0]).ok_or_else(|| c.wrong(0, "an array of points"))?;
    let cells =
        list(&c.args[1]).ok_or_else(|| c.wrong(1, "an array of cells, each an array of four numbers"))?;
    let mut o = Options::new(c, 2)?;
    let degree = o.integer("degree", 1..=HIGHEST as INT, 1)? as usize;
    let given = o.get("coefficients").ok_or_else(|| o.missing("coefficients"))?;
    let wanted = "an array of arrays of numbers, one for each cell";
    let rows = list(&given).filter(|rows| rows.len() == cells.len());
    let rows = rows.and_then(|rows| rows.iter().map(|row| numbers(&list(row)?)).collect::<Option<Vec<_>>>());
    let coefficients = rows.ok_or_else(|| o.mismatch("coefficients", wanted, &given))?;
    o.finish()?;
    let points = points(c, &corners, |i| {
        let given = describe(&corners[i]);
        Fault::new(format!("point {i} of `tetrahedra` must be a vector such as [0, 1, 0], not {given}"))
    })?;
    let cell = |(i, v): (usize, &Dynamic)| {
        let whole = |v: &Dynamic| v.as_int().ok().and_then(|i| usize::try_from(i).ok());
        let four: Option<Vec<usize>> = list(v).and_then(|list| list.iter().map(whole).collect());
        four.and_then(|four| <[usize; 4]>::try_from(four).ok()).ok_or_else(|| {
            let given = describe(v);
            Fault::new(format!(
                "cell {i} of `tetrahedra` must be an array of four numbers of points, not {given}"
            ))
        })
    };
    let cells = cells.iter().enumerate().map(cell).collect::<Outcome<Vec<_>>>()?;
    field(c, Tetrahedra::new(&points, &cells, degree, &coefficients).map_err(failed)?)
}

fn failed(flaw: Flaw) -> Fault {
    let fault = Fault::new(flaw.to_string());
    match flaw {
        Flaw::Degree(_) => fault.key("degree"),
        Flaw::Coefficients { .. } | Flaw::Lost { .. } | Flaw::Jump(..) => fault.key("coefficients"),
        Flaw::Dent { .. } => fault.hint("fill the dent with further cells, where the field may be positive"),
        Flaw::Flat(_) => fault.hint("its four corners are in a plane, or nearly so"),
        Flaw::Count(_) | Flaw::Corner(_) | Flaw::Point(_) | Flaw::Overlap(..) => fault,
    }
}
