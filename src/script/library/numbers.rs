//! Intervals, affine forms, units and conversions.

use super::{Call, Library};
use crate::num::{Affine, Interval, Number};
use crate::script::fault::{Fault, Outcome};
use crate::script::value::{Scalar, Value, number};
use rhai::Dynamic;

/// Radius of the Earth in metres, which is the unit of length of a planet.
const EARTH: f64 = 6371e3;

pub(super) fn register(lib: &mut Library<'_>) {
    lib.name_type::<Interval>("Interval");
    lib.name_type::<Affine>("Affine");
    ranges(lib);
    units(lib);
    lib.property::<Interval>("low", |_, i| Ok(i.lo.into()));
    lib.property::<Interval>("high", |_, i| Ok(i.hi.into()));
    lib.property::<Interval>("mid", |_, i| Ok(i.mid().into()));
    lib.property::<Interval>("width", |_, i| Ok(i.width().into()));
    lib.property::<Affine>("low", |_, a| Ok(a.range.lo.into()));
    lib.property::<Affine>("high", |_, a| Ok(a.range.hi.into()));
    lib.property::<Affine>("mid", |_, a| Ok(a.mid.into()));
    lib.property::<Affine>("width", |_, a| Ok(a.range.width().into()));
    for name in ["to_string", "to_debug", "print", "debug"] {
        lib.bind(name, 1, |c| Ok(crate::script::show::dynamic(c.host, &c.args[0]).into()));
    }
}

fn ranges(lib: &mut Library<'_>) {
    for name in ["..", "..="] {
        lib.bind(name, 2, range);
    }
    lib.document(
        "..",
        "low..high",
        "The numbers from low to high, both included, as an interval.",
        "0.0..0.1",
    );
    let sentence =
        "The numbers from low to high, as an outward rounded interval: its arithmetic encloses every result.";
    lib.def("interval(low, high)", sentence, "sqrt(interval(1, 4))", range);
    lib.def("affine(low, high)", "The numbers from low to high as an affine form, which remembers what it came from: a - a is zero but for rounding.", "let a = affine(1, 2); a - a", |c| {
        Ok(Dynamic::from(Affine::over(ends(c)?)))
    });
    lib.def(
        "enclosure(a)",
        "The interval that encloses an affine form or interval.",
        "enclosure(affine(1, 2) ** 2)",
        |c| match c.value(0)? {
            Value::Scalar(Scalar::Affine(a), _) => Ok(Dynamic::from(a.range())),
            Value::Scalar(s, _) => {
                s.interval().map(Dynamic::from).ok_or_else(|| c.wrong(0, "an affine form or an interval"))
            }
            Value::Vector(_) => Err(c.wrong(0, "an affine form or an interval")),
        },
    );
}

fn ends(c: &Call<'_>) -> Outcome<Interval> {
    let (low, high) = (number(&c.args[0]), number(&c.args[1]));
    let (Some(low), Some(high)) = (low, high) else {
        return Err(c.wrong(usize::from(low.is_some()), "a number"));
    };
    if low <= high {
        return Ok(Interval::new(low, high));
    }
    Err(Fault::new(format!("the range from {low} to {high} is empty")).hint("write the smaller end first"))
}

fn range(c: &Call<'_>) -> Outcome<Dynamic> {
    ends(c).map(Dynamic::from)
}

fn units(lib: &mut Library<'_>) {
    lib.def(
        "metres(m)",
        "A length in metres on a planet of radius 1, as large as the Earth.",
        "metres(8848)",
        |c| Ok((c.number(0)? / EARTH).into()),
    );
    lib.def(
        "radians(degrees)",
        "An angle in radians, as the trigonometric functions take it.",
        "sin(radians(30))",
        |c| Ok(c.number(0)?.to_radians().into()),
    );
    lib.def("degrees(radians)", "An angle in degrees, as options take it.", "degrees(atan2(1, 1))", |c| {
        Ok(c.number(0)?.to_degrees().into())
    });
    lib.def("to_float(a)", "A whole number as one with a fraction; a function of time alone as the number that it is in this picture.", "to_float(1) / 2", |c| {
        Ok(c.number(0)?.into())
    });
    lib.def("to_int(a)", "A number without its fraction.", "to_int(2.7)", |c| {
        let whole = c.number(0)?.trunc();
        if whole.abs() < 9e18 {
            Ok((whole as i64).into())
        } else {
            Err(c.wrong(0, "a number of less than 19 digits"))
        }
    });
    lib.def("round(a)", "The nearest whole number, away from zero in the middle.", "round(2.5)", |c| {
        Ok(c.number(0)?.round().into())
    });
    lib.def("is_nan(a)", "Whether a number is none.", "is_nan(0.0 / 0.0)", |c| {
        Ok(number(&c.args[0]).ok_or_else(|| c.wrong(0, "a number"))?.is_nan().into())
    });
}
