//! Fields: moving them about, and asking them for values, derivatives and bounds.

use super::{Call, Library};
use crate::expr::{Input, NodeId};
use crate::num::{Affine, Dual, Interval, Jet, Slope};
use crate::op::{self, Op};
use crate::script::fault::{Fault, Outcome};
use crate::script::host::Host;
use crate::script::noises::{Source, on_sphere, stretched};
use crate::script::value::{Field, Region, Scalar, Value, Vec3, VectorField};
use glam::{DMat3, DVec3, EulerRot};
use rhai::{Array, Dynamic};

pub(super) fn register(lib: &mut Library<'_>) {
    lib.name_type::<Field>("Field");
    queries(lib);
    moves(lib);
    lib.def("show(f)", "The expression of a field as text.", "show(sphere(1.0))", |c| {
        Ok(crate::script::show::dynamic(c.host, &c.args[0]).into())
    });
    lib.def(
        "smooth(f)",
        "The field itself, if it is C2, so that its maxima, minima and saddles can be told apart; else an error that names what is not smooth, and what to put in its place.",
        "smooth(sphere(1.0) + 0.1 * gradient(7))",
        smooth,
    );
    lib.def("class_of(f)", "Continuity of a field: \"discontinuous\", \"C0\" (creases), \"C1\" or \"C2\" (smooth normals and curvature).", "class_of(abs(x))", |c| {
        let f = c.field(0)?;
        Ok(c.host.graph.borrow().class(f.node).to_string().into())
    });
}

fn smooth(c: &Call<'_>) -> Outcome<Dynamic> {
    let f = c.field(0)?;
    let rough = crate::field::smooth(&c.host.graph.borrow(), f.node).err();
    let Some(d) = rough else { return Ok(Dynamic::from(f)) };
    // What the standard library did is shown where it was asked for.
    let mut fault = Fault::from(d);
    fault.place = fault.place.filter(|place| !place.is_embedded());
    Err(fault)
}

fn queries(lib: &mut Library<'_>) {
    let sentence =
        "The value at a point; over a region an enclosure; at a vector of fields the composed field.";
    lib.def("at(f, p)", sentence, "sphere(1.0).at([2, 0, 0])", at);
    lib.def(
        "gradient(f, p)",
        "The gradient of a field at a point.",
        "sphere(1.0).gradient([2, 0, 0])",
        |c| {
            let (node, p) = (c.field(0)?.node, c.vec3(1)?);
            let at = std::array::from_fn(|axis| Dual::coordinate(p[axis], axis));
            Ok(Dynamic::from(Vec3(c.host.eval(node, &at)?.grad)))
        },
    );
    lib.def(
        "hessian(f, p)",
        "The second derivatives of a field at a point: three rows.",
        "(x ** 2).hessian([2, 0, 0])",
        |c| {
            let (node, p) = (c.field(0)?.node, c.vec3(1)?);
            let at = std::array::from_fn(|axis| Jet::coordinate(p[axis], axis));
            let [xx, yy, zz, xy, xz, yz] = c.host.eval::<Jet>(node, &at)?.hess;
            let rows = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
            Ok(rows.into_iter().map(|row| Dynamic::from(Vec3(row))).collect::<Array>().into())
        },
    );
    lib.def(
        "range(f, box)",
        "An interval that contains every value of a field in a box.",
        "sphere(1.0).range(region(2.0))",
        |c| Ok(Dynamic::from(c.host.eval::<Interval>(c.field(0)?.node, &region(c, 1)?)?)),
    );
    lib.def(
        "lipschitz(f, box)",
        "A bound on the slope of a field in a box.",
        "sphere(1.0).lipschitz(region(2.0))",
        |c| {
            let region = region(c, 1)?;
            let at = std::array::from_fn(|axis| Slope::coordinate(region[axis], axis));
            Ok(c.host.eval::<Slope>(c.field(0)?.node, &at)?.norm.into())
        },
    );
}

/// A box: a region, or half the size of a cube.
fn region(c: &Call<'_>, i: usize) -> Outcome<[Interval; 3]> {
    let wrong = || c.wrong(i, "a box such as region([-1, -1, -1], [1, 1, 1])");
    if let Some(half) = crate::script::value::number(&c.args[i]).filter(|half| *half >= 0.0) {
        return Ok([Interval::radius(half); 3]);
    }
    match c.value(i).map_err(|_| wrong())? {
        Value::Vector([a, b, c]) => match (a.interval(), b.interval(), c.interval()) {
            (Some(a), Some(b), Some(c)) => Ok([a, b, c]),
            _ => Err(wrong()),
        },
        Value::Scalar(..) => Err(wrong()),
    }
}

fn at(c: &Call<'_>) -> Outcome<Dynamic> {
    if let Some(source) = c.args[0].read_lock::<Source>() {
        let mut source = source.clone();
        if source.at.is_none() && matches!(&c.value(1)?, Value::Vector(v) if v.iter().any(|s| s.rank() == 3))
        {
            source.at = Some(c.nodes(1)?);
            return Ok(Dynamic::from(source));
        }
    }
    let Value::Vector(p) = c.value(1)? else { return Err(c.wrong(1, "a point such as [1, 0, 0]")) };
    match c.value(0)? {
        Value::Scalar(f, color) => {
            let value = scalar_at(c, f.node(c.host)?, &p)?;
            let color = match (&value, color) {
                (Scalar::Field(_), Some(color)) => Some(substitute_all(c.host, color, &with_point(c, &p)?)?),
                _ => None,
            };
            Value::Scalar(value, color).into_dynamic(c.host)
        }
        Value::Vector(f) => {
            let part = |i: usize| scalar_at(c, f[i].node(c.host)?, &p);
            Value::Vector([part(0)?, part(1)?, part(2)?]).into_dynamic(c.host)
        }
    }
}

fn scalar_at(c: &Call<'_>, f: NodeId, p: &[Scalar; 3]) -> Outcome<Scalar> {
    match p.iter().map(Scalar::rank).max() {
        Some(3) => Ok(Scalar::Field(c.host.substitute(f, &with_point(c, p)?)?)),
        Some(2) => match p.each_ref().map(Scalar::affine) {
            [Some(x), Some(y), Some(z)] => Ok(Scalar::Affine(c.host.eval::<Affine>(f, &[x, y, z])?)),
            _ => Err(c.wrong(1, "a point")),
        },
        Some(1) => match p.each_ref().map(Scalar::interval) {
            [Some(x), Some(y), Some(z)] => Ok(Scalar::Interval(c.host.eval(f, &[x, y, z])?)),
            _ => Err(c.wrong(1, "a point")),
        },
        _ => match p.each_ref().map(Scalar::number) {
            [Some(x), Some(y), Some(z)] => Ok(Scalar::Number(c.host.eval(f, &[x, y, z])?)),
            _ => Err(c.wrong(1, "a point")),
        },
    }
}

fn with_point(c: &Call<'_>, p: &[Scalar; 3]) -> Outcome<Vec<(Input, NodeId)>> {
    let [x, y, z] = p.each_ref().map(|s| s.node(c.host));
    let p = [x?, y?, z?];
    Ok(with(p, stretched(c.host, p)?))
}

/// The inputs of an expression that is asked at another point, where a pixel is of another size.
fn with([x, y, z]: [NodeId; 3], footprint: NodeId) -> Vec<(Input, NodeId)> {
    vec![(Input::X, x), (Input::Y, y), (Input::Z, z), (Input::Footprint, footprint)]
}

fn substitute_all(host: &Host, nodes: [NodeId; 3], with: &[(Input, NodeId)]) -> Outcome<[NodeId; 3]> {
    let one = |node| host.substitute(node, with);
    Ok([one(nodes[0])?, one(nodes[1])?, one(nodes[2])?])
}

/// Moves a solid with its colour, or a vector field's argument, by replacing the point.
fn moved(c: &Call<'_>, with: &[(Input, NodeId)]) -> Outcome<Dynamic> {
    if let Some(v) = c.args[0].read_lock::<VectorField>() {
        return Ok(Dynamic::from(VectorField(substitute_all(c.host, v.0, with)?)));
    }
    let f = c.field(0)?;
    let color = f.color.map(|color| substitute_all(c.host, color, with)).transpose()?;
    Ok(Dynamic::from(Field { node: c.host.substitute(f.node, with)?, color }))
}

/// The point under a linear map and a shift: `m (p - shift)`.
fn affine_point(host: &Host, m: DMat3, shift: DVec3) -> Outcome<Vec<(Input, NodeId)>> {
    let p = host.point()?;
    let mut from = Vec::new();
    for (axis, coordinate) in p.into_iter().enumerate() {
        let shift = host.constant(shift[axis])?;
        from.push(host.op(Op::Sub(op::Sub), &[coordinate, shift])?);
    }
    let row = |i: usize| {
        let mut sum = host.constant(0.0)?;
        for (axis, &coordinate) in from.iter().enumerate() {
            let k = host.constant(m.col(axis)[i])?;
            let term = host.op(Op::Mul(op::Mul), &[k, coordinate])?;
            sum = host.op(Op::Add(op::Add), &[sum, term])?;
        }
        Ok::<NodeId, Fault>(sum)
    };
    Ok(vec![(Input::X, row(0)?), (Input::Y, row(1)?), (Input::Z, row(2)?)])
}

/// The point turned back around a unit axis by an angle in degrees that is itself an expression:
/// what lies along the axis stays, what lies across turns.
fn turned_point(host: &Host, axis: DVec3, degrees: NodeId) -> Outcome<Vec<(Input, NodeId)>> {
    let radians = host.op(Op::Mul(op::Mul), &[degrees, host.constant(1f64.to_radians())?])?;
    let (cos, sin) = (host.op(Op::Cos(op::Cos), &[radians])?, host.op(Op::Sin(op::Sin), &[radians])?);
    let along = DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
    let aside = DMat3::from_cols(DVec3::X.cross(axis), DVec3::Y.cross(axis), DVec3::Z.cross(axis));
    let mut point = affine_point(host, along, DVec3::ZERO)?;
    for (factor, part) in [(cos, DMat3::IDENTITY - along), (sin, aside)] {
        for (sum, (_, term)) in point.iter_mut().zip(affine_point(host, part, DVec3::ZERO)?) {
            let term = host.op(Op::Mul(op::Mul), &[factor, term])?;
            sum.1 = host.op(Op::Add(op::Add), &[sum.1, term])?;
        }
    }
    Ok(point)
}

fn moves(lib: &mut Library<'_>) {
    for name in ["translated", "translate"] {
        lib.def(
            &format!("{name}(f, by)"),
            "The solid moved by a vector.",
            "sphere(1.0).translated([0, 2, 0])",
            |c| {
                let by = c.nodes(1)?;
                let p = c.host.point()?;
                let shifted = |i: usize| c.host.op(Op::Sub(op::Sub), &[p[i], by[i]]);
                moved(c, &[(Input::X, shifted(0)?), (Input::Y, shifted(1)?), (Input::Z, shifted(2)?)])
            },
        );
    }
    for name in ["rotated", "rotate"] {
        let sentence = "The solid turned around an axis through the origin, by degrees counterclockwise as seen from the axis' tip. They may be a field, such as 90.0 * time.";
        lib.def(
            &format!("{name}(f, axis, degrees)"),
            sentence,
            "torus(1.0, 0.2).rotated([1, 0, 0], 90)",
            |c| {
                let axis = c.vec3(1)?.try_normalize();
                let axis = axis.ok_or_else(|| Fault::new("the axis has no direction: its length is zero"))?;
                if c.args[2].is::<Field>() {
                    return moved(c, &turned_point(c.host, axis, c.field(2)?.node)?);
                }
                let turn = DMat3::from_axis_angle(axis, c.number(2)?.to_radians());
                moved(c, &affine_point(c.host, clean(turn.transpose()), DVec3::ZERO)?)
            },
        );
        let sentence = "The solid turned by degrees around x, then y, then z.";
        lib.def(&format!("{name}(f, angles)"), sentence, "torus(1.0, 0.2).rotated([90, 0, 0])", |c| {
            let a = c.vec3(1)? * (std::f64::consts::PI / 180.0);
            let turn = DMat3::from_euler(EulerRot::ZYX, a.z, a.y, a.x);
            moved(c, &affine_point(c.host, clean(turn.transpose()), DVec3::ZERO)?)
        });
    }
    for name in ["scaled", "scale"] {
        let sentence = "A solid grown by a factor, its distances too; of a noise the frequency, so that its features shrink. A vector has a factor for each axis, and below zero gives the mirror image: scaled([-1, 1, 1]). Distances are then no more than they were said to be. What is computed from a noise, such as `-n` or `abs(n)`, is a field like any other: scale the noise before.";
        lib.def(&format!("{name}(f, factor)"), sentence, "gradient(7).scaled(4.0)", scaled);
    }
    lib.def(
        "mirrored(f, normal)",
        "The half of a solid on the side of the normal, and its mirror image. The mirror image of all of it, alone, is scaled([-1, 1, 1]).",
        "sphere(1.0).translated([1, 0, 0]).mirrored([1, 0, 0])",
        |c| {
            let n = c.vec3(1)?.try_normalize();
            let n = n.ok_or_else(|| Fault::new("the normal has no direction: its length is zero"))?;
            mirrored(c, n)
        },
    );
    lib.def(
        "is_even(f, axis)",
        "Whether a solid is seen to be its own mirror image along an axis, \"x\", \"y\" or \"z\", colour and all. That is seen by how the solid is written: one of which it is not seen may be even all the same.",
        "is_even(box(1.0), \"x\")",
        |c| {
            let axis = match c.text(1)?.as_str() {
                "x" => Input::X,
                "y" => Input::Y,
                "z" => Input::Z,
                _ => return Err(c.wrong(1, "\"x\", \"y\" or \"z\"")),
            };
            let Field { node, color } = c.field(0)?;
            let graph = c.host.graph.borrow();
            Ok([node].into_iter().chain(color.into_iter().flatten()).all(|node| graph.is_even(node, axis)).into())
        },
    );
    lib.def(
        "on_sphere(f)",
        "The same on the sphere: evaluated at p / |p|, and at the origin there.",
        "gradient(7).scaled(4.0).on_sphere()",
        |c| {
            if let Some(mut source) = c.source(0).ok().filter(Source::is_at_the_point) {
                source.domain = crate::script::noises::Domain::Sphere;
                return Ok(Dynamic::from(source));
            }
            let (p, footprint) = on_sphere(c.host, c.host.point()?, c.host.input(Input::Footprint)?)?;
            moved(c, &with(p, footprint))
        },
    );
    lib.def(
        "on_plane(f)",
        "The same on the ground plane: evaluated at (x, 0, z).",
        "gradient(7).on_plane()",
        |c| {
            if let Some(mut source) = c.source(0).ok().filter(Source::is_at_the_point) {
                source.domain = crate::script::noises::Domain::Plane;
                return Ok(Dynamic::from(source));
            }
            moved(c, &[(Input::Y, c.host.constant(0.0)?)])
        },
    );
}

/// A rotation without the dust that sines leave in place of zeros and ones, so that quarter turns
/// cost nothing.
fn clean(m: DMat3) -> DMat3 {
    let tidy = |v: f64| if (v - v.round()).abs() < 1e-15 { v.round() } else { v };
    DMat3::from_cols_array(&m.to_cols_array().map(tidy))
}

fn scaled(c: &Call<'_>) -> Outcome<Dynamic> {
    if let Some(factors) = c.vec3_of(&c.args[1])? {
        return stretched_by(c, factors);
    }
    let k = c.number(1)?;
    if let Ok(source) = c.source(0) {
        return source.scaled(k).map(Dynamic::from);
    }
    if k <= 0.0 {
        return Err(c.wrong(1, "a positive number"));
    }
    // k f(p / k) keeps distances; a pixel is smaller in the coordinates before.
    let factor = c.host.constant(k)?;
    let mut with = Vec::new();
    for input in [Input::X, Input::Y, Input::Z, Input::Footprint] {
        let inner = c.host.input(input)?;
        with.push((input, c.host.op(Op::Div(op::Div), &[inner, factor])?));
    }
    let inner = moved(c, &with)?;
    if let Some(f) = inner.read_lock::<Field>() {
        let node = c.host.op(Op::Mul(op::Mul), &[factor, f.node])?;
        return Ok(Dynamic::from(Field { node, color: f.color }));
    }
    Ok(inner)
}

/// A factor along each axis: the field at `p / k`, times the least of them, so that it is no steeper than before; of a noise
/// that at `p k`.
fn stretched_by(c: &Call<'_>, factors: DVec3) -> Outcome<Dynamic> {
    let host = c.host;
    let least = factors.abs().min_element();
    if !(least > 0.0 && factors.is_finite()) {
        return Err(c.wrong(1, "a vector of factors other than zero"));
    }
    let source = c.source(0).ok().filter(|source| source.at.is_none());
    let is_noise = c.source(0).is_ok();
    let mut p = host.point()?;
    for (coordinate, factor) in p.iter_mut().zip(factors.to_array()) {
        let factor = host.constant(if is_noise { factor } else { 1.0 / factor })?;
        *coordinate = host.op(Op::Mul(op::Mul), &[*coordinate, factor])?;
    }
    if let Some(mut source) = source {
        source.at = Some(p);
        return Ok(Dynamic::from(source));
    }
    let inner = moved(c, &with(p, stretched(host, p)?))?;
    if let Some(f) = inner.read_lock::<Field>().filter(|_| !is_noise) {
        let node = host.op(Op::Mul(op::Mul), &[host.constant(least)?, f.node])?;
        return Ok(Dynamic::from(Field { node, color: f.color }));
    }
    Ok(inner)
}

/// Reflects points behind the plane: p + 2 max(-p.n, 0) n.
fn mirrored(c: &Call<'_>, n: DVec3) -> Outcome<Dynamic> {
    let host = c.host;
    let p = host.point()?;
    let constants = [host.constant(n.x)?, host.constant(n.y)?, host.constant(n.z)?];
    let [a, b, d] = constants;
    let height = host.op(Op::Dot(op::Dot), &[p[0], p[1], p[2], a, b, d])?;
    let behind = host.op(Op::Neg(op::Neg), &[height])?;
    let zero = host.constant(0.0)?;
    let depth = host.op(Op::Max(op::Max), &[behind, zero])?;
    let mut with = Vec::new();
    for (axis, input) in [Input::X, Input::Y, Input::Z].into_iter().enumerate() {
        let twice = host.constant(2.0 * n[axis])?;
        let shift = host.op(Op::Mul(op::Mul), &[twice, depth])?;
        with.push((input, host.op(Op::Add(op::Add), &[p[axis], shift])?));
    }
    moved(c, &with)
}

/// The box that a value is, for scenes.
pub(super) fn region_of(v: &Dynamic) -> Option<Region> {
    v.read_lock::<Region>().map(|r| *r)
}
