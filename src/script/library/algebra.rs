//! Operators, and the functions of the list of operations.

use super::{Call, Library};
use crate::op::{self, Op};
use crate::script::apply::{apply, component, scalar};
use crate::script::fault::{Fault, Outcome};
use crate::script::noises::NEVER_ZERO;
use crate::script::options::with_article;
use crate::script::value::{Field, Scalar, Value, Vec3, number};
use rhai::{Dynamic, ImmutableString};
use std::any::TypeId;
use std::cmp::Ordering;

pub(super) fn register(lib: &mut Library<'_>) {
    for &op in Op::ALL {
        match op {
            // Their arguments differ from those of the operation itself; see below.
            Op::Powi(_) | Op::Powf(_) | Op::Smoothstep(_) | Op::Smootherstep(_) => {}
            Op::Length(_) | Op::Dot(_) => {}
            Op::Norm(_) | Op::Ramp(_) | Op::Melt(_) | Op::Plus(_) => {}
            Op::Neg(_) => operation(lib, op, "-", "-a"),
            _ => operation(lib, op, op.name(), &signature(&op)),
        }
    }
    lib.bind("+", 1, |c| Ok(c.args[0].clone()));
    lib.bind("%", 2, |c| apply_all(c, Op::Modulo(op::Modulo)));
    lib.document(
        "%",
        "a % b",
        "Remainder; for fields that of `modulo`, with the sign of the period.",
        "y - 0.5 * (x % 0.8)",
    );
    // Adding a text to a field would otherwise make a text, as it does for every other value.
    lib.bind_typed("+", [TypeId::of::<Field>(), TypeId::of::<ImmutableString>()], |c| Err(mismatch(c, 1)));
    powers(lib);
    corners(lib);
    vectors(lib);
    comparisons(lib);
    for op in [Op::Smoothstep(op::Smoothstep), Op::Smootherstep(op::Smootherstep)] {
        let signature = format!("{}(low, high, x)", op.name());
        lib.def(&signature, doc(op), op.example(), move |c| {
            let [low, high, x] = [c.value(0)?, c.value(1)?, c.value(2)?];
            let sub = |a, b| apply(c.host, Op::Sub(op::Sub), &[a, b]);
            let t = apply(c.host, Op::Div(op::Div), &[sub(x, low.clone())?, sub(high, low)?])?;
            apply(c.host, op, &[t])?.into_dynamic(c.host)
        });
    }
}

/// `melt(x, y, shape, width)`: an operation of its own where the width is a number.
fn melted(c: &Call<'_>) -> Outcome<Dynamic> {
    let (shape, width) = (ramp(c, 2)?, c.value(3)?);
    let (x, y) = (c.value(0)?, c.value(1)?);
    let Value::Scalar(Scalar::Number(number), _) = width else {
        let in_widths = |v: Value| apply(c.host, Op::Div(op::Div), &[v, width.clone()]);
        let unit = Op::Melt(op::Melt::new(shape, 1.0));
        let melted = apply(c.host, unit, &[in_widths(x)?, in_widths(y)?])?;
        return apply(c.host, Op::Mul(op::Mul), &[width, melted])?.into_dynamic(c.host);
    };
    if !(number.is_normal() && number > 0.0 && (1.0 / number).is_normal()) {
        return Err(c.wrong(3, "a width above zero"));
    }
    apply(c.host, Op::Melt(op::Melt::new(shape, number)), &[x, y])?.into_dynamic(c.host)
}

fn doc(op: Op) -> &'static str {
    op.doc()
}

fn operation(lib: &mut Library<'_>, op: Op, name: &str, signature: &str) {
    lib.bind(name, op.arity(), move |c| apply_all(c, op));
    lib.document(name, signature, op.doc(), op.example());
}

/// The signature at the start of an operation's documentation, or one with general names.
fn signature(op: &Op) -> String {
    let (name, doc) = (op.name(), op.doc());
    if super::is_operator(name) {
        return format!("a {name} b");
    }
    match doc.strip_prefix(name).and_then(|rest| rest.strip_prefix('(')).and_then(|rest| rest.split_once(')'))
    {
        Some((params, _)) => format!("{name}({params})"),
        None => format!("{name}({})", ["x", "a, b", "a, b, c"][op.arity().clamp(1, 3) - 1]),
    }
}

fn apply_all(c: &Call<'_>, op: Op) -> Outcome<Dynamic> {
    let mut values = Vec::with_capacity(c.args.len());
    for i in 0..c.args.len() {
        values.push(Value::of(c.host, &c.args[i])?.ok_or_else(|| mismatch(c, i))?);
    }
    apply(c.host, op, &values)?.into_dynamic(c.host)
}

/// Says which argument arithmetic does not know, and what was given in all.
fn mismatch(c: &Call<'_>, i: usize) -> Fault {
    let given: Vec<&str> = c.args.iter().map(crate::script::value::type_name).collect();
    let fault = c.wrong(i, "numbers, fields and vectors");
    if c.args.len() > 1 { fault.label(format!("given ({})", given.join(", "))) } else { fault }
}

fn powers(lib: &mut Library<'_>) {
    let sentence = "Power. Whole exponents take any base; others need one that is not negative.";
    lib.bind("**", 2, |c| power(c)?.into_dynamic(c.host));
    lib.document("**", "a ** b", sentence, "y + 0.8 - x ** 2");
    lib.def("pow(a, b)", sentence, Op::Powf(op::Powf).example(), |c| power(c)?.into_dynamic(c.host));
    lib.def(
        "powi(a, n)",
        "Whole power of a number of either sign.",
        Op::Powi(op::Powi { n: 3 }).example(),
        |c| {
            c.integer(1)?;
            power(c)?.into_dynamic(c.host)
        },
    );
}

fn power(c: &Call<'_>) -> Outcome<Value> {
    let base = c.value(0)?;
    let whole = number(&c.args[1]).filter(|n| n.fract() == 0.0 && n.abs() <= f64::from(i32::MAX));
    match whole.map(|n| n as i32) {
        Some(1) => Ok(base),
        Some(2) => apply(c.host, Op::Square(op::Square), &[base]),
        Some(n) => apply(c.host, Op::Powi(op::Powi { n }), &[base]),
        None => apply(c.host, Op::Powf(op::Powf), &[base, c.value(1)?]),
    }
}

/// Operations that have a parameter besides their arguments.
fn corners(lib: &mut Library<'_>) {
    lib.def(
        "norm(x, y, power)",
        doc(Op::Norm(op::Norm::new(2.0))),
        Op::Norm(op::Norm::new(2.0)).example(),
        |c| {
            let power = c.number(2)?;
            if !(1.0..=op::Norm::LARGEST).contains(&power) {
                return Err(c.wrong(2, "a power from 1 to 64"));
            }
            let (x, y) = (c.value(0)?, c.value(1)?);
            let norm = match power {
                // A length costs less.
                2.0 => Op::Length(op::Length),
                _ => Op::Norm(op::Norm::new(power)),
            };
            let zero = Value::Scalar(Scalar::Number(0.0), None);
            apply(c.host, norm, &[x, y, zero][..norm.arity()])?.into_dynamic(c.host)
        },
    );
    lib.def("ramp(x, shape)", doc(Op::Ramp(op::Ramp::Cubic)), Op::Ramp(op::Ramp::Cubic).example(), |c| {
        apply(c.host, Op::Ramp(ramp(c, 1)?), &[c.value(0)?])?.into_dynamic(c.host)
    });
    let melt = Op::Melt(op::Melt::new(op::Ramp::Cubic, 1.0));
    lib.def("melt(x, y, shape)", doc(melt), melt.example(), move |c| {
        let melt = Op::Melt(op::Melt::new(ramp(c, 2)?, 1.0));
        apply(c.host, melt, &[c.value(0)?, c.value(1)?])?.into_dynamic(c.host)
    });
    let sentence = "The same where they differ by less than a width, which may be a field.";
    lib.def("melt(x, y, shape, width)", sentence, "melt(y - x, y + x, \"cubic\", 0.3)", melted);
    lib.def("plus(x, n)", doc(Op::Plus(op::Plus { n: 2 })), Op::Plus(op::Plus { n: 2 }).example(), |c| {
        let n = i32::try_from(c.integer(1)?).ok().filter(|n| (2..=64).contains(n));
        let n = n.ok_or_else(|| c.wrong(1, "a whole number from 2 to 64"))?;
        apply(c.host, Op::Plus(op::Plus { n }), &[c.value(0)?])?.into_dynamic(c.host)
    });
}

/// The ramp that argument `i` names.
fn ramp(c: &Call<'_>, i: usize) -> Outcome<op::Ramp> {
    let given = c.text(i)?;
    let names = op::Ramp::ALL.map(|(name, _)| name);
    let found = op::Ramp::ALL.into_iter().find(|(name, _)| *name == given);
    found.map(|(_, ramp)| ramp).ok_or_else(|| {
        let fault = Fault::new(format!("there is no ramp \"{given}\""));
        match crate::diag::nearest(&given, names) {
            Some(near) => fault.hint(format!("did you mean \"{near}\"?")),
            None => fault.hint(format!("there are {}", names.join(", "))),
        }
    })
}

/// Operations whose arguments are whole vectors.
fn vectors(lib: &mut Library<'_>) {
    lib.def("length(v)", doc(Op::Length(op::Length)), Op::Length(op::Length).example(), |c| {
        length(c, &c.value(0)?)?.into_dynamic(c.host)
    });
    let sentence =
        "The vector times itself: its squared length. Unlike dot(v, v) its bounds are never negative.";
    lib.def("length_squared(v)", sentence, "length_squared(p) - 1.0", |c| {
        let v = c.value(0)?;
        if matches!(v, Value::Scalar(..)) {
            return Err(c.wrong(0, "a vector").hint("a number times itself is square(x)"));
        }
        let part = |i: usize| scalar(c.host, Op::Square(op::Square), &[component(&v, i)]);
        let sum = scalar(c.host, Op::Add(op::Add), &[part(0)?, part(1)?])?;
        let sum = scalar(c.host, Op::Add(op::Add), &[sum, part(2)?])?;
        Value::Scalar(sum, None).into_dynamic(c.host)
    });
    lib.def("dot(a, b)", doc(Op::Dot(op::Dot)), Op::Dot(op::Dot).example(), |c| {
        let (a, b) = (c.value(0)?, c.value(1)?);
        let parts: Vec<Scalar> =
            (0..3).map(|i| component(&a, i)).chain((0..3).map(|i| component(&b, i))).collect();
        both_vectors(c, &a, &b)?;
        Value::Scalar(scalar(c.host, Op::Dot(op::Dot), &parts)?, None).into_dynamic(c.host)
    });
    lib.def("cross(a, b)", "Cross product of two vectors.", "length(cross(p, vec3(0, 1, 0))) - 0.6", |c| {
        let (a, b) = (c.value(0)?, c.value(1)?);
        both_vectors(c, &a, &b)?;
        let part = |i: usize, j: usize| {
            let product = |x: &Value, i, y: &Value, j| {
                scalar(c.host, Op::Mul(op::Mul), &[component(x, i), component(y, j)])
            };
            scalar(c.host, Op::Sub(op::Sub), &[product(&a, i, &b, j)?, product(&a, j, &b, i)?])
        };
        Value::Vector([part(1, 2)?, part(2, 0)?, part(0, 1)?]).into_dynamic(c.host)
    });
    lib.def(
        "normalize(v)",
        "The vector of length 1 with the same direction; the zero vector, which has none, stays as it is.",
        "sphere(1.0) - 0.3 * normalize(p).y",
        |c| {
            let v = c.value(0)?;
            let tiny = Value::Scalar(Scalar::Number(NEVER_ZERO), None);
            let r = apply(c.host, Op::Add(op::Add), &[length(c, &v)?, tiny])?;
            apply(c.host, Op::Div(op::Div), &[v, r])?.into_dynamic(c.host)
        },
    );
}

fn length(c: &Call<'_>, v: &Value) -> Outcome<Value> {
    match v {
        Value::Vector(parts) => Ok(Value::Scalar(scalar(c.host, Op::Length(op::Length), parts)?, None)),
        Value::Scalar(..) => Err(c.wrong(0, "a vector").hint("the size of a number is abs(x)")),
    }
}

fn both_vectors(c: &Call<'_>, a: &Value, b: &Value) -> Outcome<()> {
    for (i, v) in [a, b].into_iter().enumerate() {
        if matches!(v, Value::Scalar(..)) {
            return Err(c.wrong(i, "a vector"));
        }
    }
    Ok(())
}

/// Comparison means nothing for expressions; say so rather than answer `false`.
fn comparisons(lib: &mut Library<'_>) {
    for name in ["==", "!=", "<", "<=", ">", ">="] {
        lib.bind(name, 2, move |c| compare(c, name));
    }
}

fn compare(c: &Call<'_>, name: &str) -> Outcome<Dynamic> {
    let given = [&c.args[0], &c.args[1]];
    let kinds = given.map(crate::script::value::type_name);
    if let Some(kind) = kinds.iter().find(|k| matches!(**k, "Field" | "VectorField" | "Noise")) {
        let fault = Fault::new(format!("a {kind} cannot be compared with `{name}`"));
        let is_still =
            |v: &&Dynamic| v.read_lock::<Field>().is_some_and(|f| c.host.places(f.node).is_empty());
        if given.iter().any(is_still) {
            return Err(fault.hint("the number that a function of time is in this picture: to_float(time)"));
        }
        return Err(fault
            .label("has no value until the picture is drawn")
            .hint("an expression has a different value at every point, so no comparison holds for all of them")
            .hint("to choose between expressions write min, max, step(edge, x) or mix(a, b, t); to compare at one point write f.at(p)"));
    }
    if let Some(kind) = kinds.iter().find(|k| matches!(**k, "Interval" | "Affine" | "Region" | "AffineVec3"))
    {
        return Err(Fault::new(format!("{} cannot be compared with `{name}`", with_article(kind)))
            .hint("compare its ends: i.low, i.high"));
    }
    // The engine's own functions on arrays compare elements through here.
    let order = order(given[0], given[1]);
    match (name, order) {
        ("==", order) => Ok((order == Some(Ordering::Equal)).into()),
        ("!=", order) => Ok((order != Some(Ordering::Equal)).into()),
        ("<", Some(order)) => Ok(order.is_lt().into()),
        ("<=", Some(order)) => Ok(order.is_le().into()),
        (">", Some(order)) => Ok(order.is_gt().into()),
        (">=", Some(order)) => Ok(order.is_ge().into()),
        _ => {
            Err(Fault::new(format!("`{name}` compares numbers or texts, not {} and {}", kinds[0], kinds[1])))
        }
    }
}

/// How two plain values compare, where they do.
fn order(a: &Dynamic, b: &Dynamic) -> Option<Ordering> {
    if let (Ok(a), Ok(b)) = (a.as_int(), b.as_int()) {
        return Some(a.cmp(&b));
    }
    if let (Some(a), Some(b)) = (number(a), number(b)) {
        return a.partial_cmp(&b);
    }
    if let (Ok(a), Ok(b)) = (a.as_immutable_string_ref(), b.as_immutable_string_ref()) {
        return Some(a.as_str().cmp(b.as_str()));
    }
    if let (Ok(a), Ok(b)) = (a.as_bool(), b.as_bool()) {
        return Some(a.cmp(&b));
    }
    if let (Ok(a), Ok(b)) = (a.as_char(), b.as_char()) {
        return Some(a.cmp(&b));
    }
    let vectors = [a, b].map(|v| v.read_lock::<Vec3>().map(|v| *v));
    let same = matches!(vectors, [Some(a), Some(b)] if a == b) || (a.is_unit() && b.is_unit());
    same.then_some(Ordering::Equal)
}
