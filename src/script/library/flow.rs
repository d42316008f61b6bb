//! Vector fields that are slopes of others, and flows along vector fields.

use super::{Call, Library};
use crate::diag::Place;
use crate::expr::{Flow, Graph, NoGradient, NodeId};
use crate::field;
use crate::flow::{Precision, steps};
use crate::num::{Class, mix, uniform};
use crate::op::{self, Op};
use crate::script::fault::{Fault, Outcome};
use crate::script::options::Options;
use crate::script::value::{Field, Value, VectorField};
use glam::DVec3;
use rhai::{Dynamic, INT};
use std::sync::Arc;

/// Error of a flow as a share of how far it carries points, unless another is asked for: half a pixel where they are carried
/// across five hundred. Steps do not show otherwise, as the map of whatever many is as smooth as the velocity.
const TOLERANCE: f64 = 1e-3;

/// Most flows within flows: each carries through all steps of the next.
const DEEPEST: usize = 16;

pub(super) fn register(lib: &mut Library<'_>) {
    lib.def(
        "slope(f)",
        "The gradient of a field as a vector field: of a noise, of a plain sum of its octaves, and of whatever operations make of these and of the coordinates. It is C1 where the field is C2.",
        "slope(gradient(7).scaled(4.0))",
        |c| Ok(Dynamic::from(VectorField(gradient(c, c.field(0)?.node)?))),
    );
    lib.def(
        "curl(v)",
        "The curl of a vector field, which has no divergence: a flow along it keeps volumes.",
        "curl(vector_noise(gradient(7).scaled(4.0)))",
        |c| {
            let v = c.nodes(0)?;
            let [x, y, z] = [gradient(c, v[0])?, gradient(c, v[1])?, gradient(c, v[2])?];
            let sub = |a, b| c.host.op(Op::Sub(op::Sub), &[a, b]);
            Ok(Dynamic::from(VectorField([sub(z[1], y[2])?, sub(x[2], z[0])?, sub(y[0], x[1])?])))
        },
    );
    lib.def(
        "divergence(v)",
        "The divergence of a vector field: how fast a flow along it makes volumes grow.",
        "y - 0.1 * divergence(vector_noise(gradient(7)))",
        |c| {
            let v = c.nodes(0)?;
            let mut sum = c.host.constant(0.0)?;
            for (axis, part) in v.into_iter().enumerate() {
                sum = c.host.op(Op::Add(op::Add), &[sum, gradient(c, part)?[axis]])?;
            }
            Ok(Dynamic::from(Field { node: sum, color: None }))
        },
    );
    let sentence = "The solid carried along a velocity for a unit of time, with its colour; or what a field or a vector field becomes of it. Nothing comes loose, meets itself or closes: the solid keeps its topology, however strong a velocity is of which the slope is bounded, as that of noises is. A velocity may be any vector field without jumps, times a number or a field; see std/flow. Up to 16 flows may go one after the other.";
    lib.def("flow(f, v)", sentence, "sphere(1.0).flow(0.1 * vector_noise(gradient(7).scaled(4.0)))", |c| {
        flow(c, 1.0, Precision::Share(TOLERANCE.to_bits()))
    });
    lib.def(
        "flow(f, v, options)",
        "The same with options:\n\n- tolerance: mean error as a share of how far points are carried (1e-9 to 0.1; 1e-3); from it, and from the velocity around the origin, or where next to nothing moves there, within 768 of it, follow the steps\n- steps: how many steps there are instead (1 to 512); each asks for the velocity four times",
        "sphere(1.0).flow(vec3(0.4 * y, 0, 0), #{ steps: 16 })",
        |c| flow(c, 1.0, precision(c)?),
    );
    lib.def(
        "unflow(f, v)",
        "The solid carried against a velocity: what takes back flow(f, v), up to its tolerance.",
        "sphere(1.0).unflow(0.1 * vector_noise(gradient(7).scaled(4.0)))",
        |c| flow(c, -1.0, Precision::Share(TOLERANCE.to_bits())),
    );
    lib.def(
        "unflow(f, v, options)",
        "The same with the options of flow(f, v, options).",
        "sphere(1.0).unflow(vec3(0.4 * y, 0, 0), #{ steps: 16 })",
        |c| flow(c, -1.0, precision(c)?),
    );
}

/// The precision that options ask for.
fn precision(c: &Call<'_>) -> Outcome<Precision> {
    let mut o = Options::new(c, 2)?;
    let tolerance = o.number("tolerance", 1e-9..=0.1, 0.0)?;
    let steps = o.integer("steps", 1..=INT::from(steps::MOST), 0)?;
    o.finish()?;
    match (tolerance, steps) {
        (0.0, 0) => Ok(Precision::Share(TOLERANCE.to_bits())),
        (tolerance, 0) => Ok(Precision::Share(tolerance.to_bits())),
        (0.0, steps) => Ok(Precision::Steps(steps as u32)),
        _ => Err(Fault::new("a flow has a tolerance or so many steps, not both")
            .hint("the steps follow from the tolerance; leave out one of them")),
    }
}

/// The gradient of an expression.
fn gradient(c: &Call<'_>, node: NodeId) -> Outcome<[NodeId; 3]> {
    let found = c.host.graph.borrow_mut().gradient(node);
    found.map_err(|e| match e {
        NoGradient::TooLarge(e) => e.into(),
        NoGradient::Of(part) => {
            let graph = c.host.graph.borrow();
            let mut fault = Fault::new(format!(
                "{} has no slope that is known as an expression",
                field::blame(graph.node(part)).0
            ))
            .hint("noises that are C1 have one, plain sums of their octaves, and what operations make of these; at a point every field has f.gradient(p), and material::steepness(f, up, distance) goes by samples");
            fault.place = shown(graph.place(part));
            fault
        }
    })
}

/// A place to show: what the standard library did is shown where it was asked for.
fn shown(place: Option<&Place>) -> Option<Box<Place>> {
    place.filter(|place| !place.is_embedded()).cloned().map(Box::new)
}

/// Whether an expression has no value at any of many places where solids are by habit.
fn is_undefined(graph: &Graph, node: NodeId) -> bool {
    const PLACES: u64 = 64;
    let place = |i: u64| DVec3::from_array([0, 1, 2].map(|axis| 3.0 * uniform(mix(3 * i + axis)) - 1.5));
    let mut field = field::Field::new(graph, node);
    (0..PLACES).all(|i| !field.value(place(i)).is_finite())
}

/// What argument 0 becomes when it is carried along argument 1 for so long.
fn flow(c: &Call<'_>, time: f64, precision: Precision) -> Outcome<Dynamic> {
    let wanted = "a velocity: a vector field such as 0.1 * vector_noise(gradient(7).scaled(4.0))";
    let Value::Vector(given) = c.value(1).map_err(|_| c.wrong(1, wanted))? else {
        return Err(c.wrong(1, wanted));
    };
    let carried_already = |node: NodeId| c.host.graph.borrow().nesting(node);
    // A point of the flowed solid was, a unit of time ago, where it goes if time runs backwards.
    let back = c.host.constant(-time)?;
    let mut velocity = [back; 3];
    for (part, given) in velocity.iter_mut().zip(&given) {
        *part = c.host.op(Op::Mul(op::Mul), &[back, given.node(c.host)?])?;
    }
    if let Some(culprit) = velocity.iter().find_map(|&v| c.host.graph.borrow().first_below(v, Class::C0)) {
        let graph = c.host.graph.borrow();
        let (name, _) = field::blame(graph.node(culprit));
        let mut fault = Fault::new(format!("the velocity jumps: {name} is not continuous")).hint(
            "a flow needs a velocity without jumps; smoothstep(low, high, x) rises where step(edge, x) jumps",
        );
        fault.place = shown(graph.place(culprit));
        return Err(fault);
    }
    if velocity.iter().any(|&part| is_undefined(&c.host.graph.borrow(), part)) {
        return Err(Fault::new("the velocity has no value at any place that was tried near the origin")
            .hint("does it divide by zero, or take the root of what is negative?"));
    }
    let carried = |field: NodeId| -> Outcome<NodeId> {
        let nesting = velocity.into_iter().chain([field]).map(carried_already).max();
        if nesting.is_some_and(|nesting| nesting >= DEEPEST) {
            return Err(Fault::new(format!("more than {DEEPEST} flows within flows"))
                .hint("one flow along the sum of velocities carries along them all at once: f.flow(u + v)"));
        }
        let p = c.host.point()?;
        let flow = Arc::new(Flow { field, velocity, precision });
        Ok(c.host.graph.borrow_mut().flow(flow, p)?)
    };
    match c.value(0)? {
        Value::Scalar(f, color) => {
            let color = match color {
                Some([r, g, b]) => Some([carried(r)?, carried(g)?, carried(b)?]),
                None => None,
            };
            Ok(Dynamic::from(Field { node: carried(f.node(c.host)?)?, color }))
        }
        Value::Vector(v) => {
            let part = |i: usize| carried(v[i].node(c.host)?);
            Ok(Dynamic::from(VectorField([part(0)?, part(1)?, part(2)?])))
        }
    }
}
