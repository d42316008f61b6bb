//! Whether a field is smooth enough for questions about its critical points, and who is to blame.
//!
//! Maxima, minima and saddles are told apart by second derivatives, so Morse analysis asks for a
//! field whose Hessian is continuous (C2). A field that is rougher is refused with a sentence that
//! names the first thing in it that is, and what could stand in its place.

use crate::diag::{Diagnostic, Place};
use crate::expr::{Graph, Node, NodeId};
use crate::noise::{Kind, Noise, Part};
use crate::num::{Class, Kernel};
use crate::op::Op;

/// Whether the field is C2.
///
/// # Errors
/// A diagnostic at the expression that makes it less, with a remedy.
pub fn smooth(graph: &Graph, root: NodeId) -> Result<(), Box<Diagnostic>> {
    let Some(culprit) = graph.first_below(root, Class::C2) else { return Ok(()) };
    let what = match graph.class(culprit) {
        Class::Jump => "jumps, so the field has no critical points to analyse",
        Class::C0 => "has creases (C0), so the field has no critical points to analyse",
        Class::C1 | Class::C2 => "has curvature that jumps (C1), which leaves critical points undecided",
    };
    let (name, remedy) = blame(graph.node(culprit));
    let error = Diagnostic::error(format!("{name} {what}")).hint(remedy);
    // A noise is placed by the first operation that uses it, and what the standard library made by what the script made
    // of it.
    let rough = |id: &NodeId| graph.class(*id) < Class::C2;
    let places: Vec<&Place> =
        graph.reachable(&[root]).into_iter().filter(rough).filter_map(|id| graph.place(id)).collect();
    let (made, used) = (places.first(), places.iter().find(|place| !place.is_embedded()));
    let error = error.at(used.or(made).map(|place| (*place).clone()));
    Err(Box::new(match (made, used) {
        (Some(made), Some(_)) if made.is_embedded() => {
            error.label(format!("made by line {} of {}", made.line, made.file))
        }
        _ => error,
    }))
}

/// What to call a node that is not smooth, and what to put in its place.
pub fn blame(node: &Node) -> (String, String) {
    match node {
        Node::Op(op, _) => (format!("`{}`", op.name()), instead_of(op).to_owned()),
        Node::Noise(noise, _) => noise_name(noise),
        // Never to blame: these are C2.
        Node::Const(_) | Node::Input(_) => ("this".to_owned(), String::new()),
        Node::Grid(..) => ("the grid".to_owned(), String::new()),
        Node::Flow(..) => (
            "the flow".to_owned(),
            "a flow keeps the topology of what it carries: ask the solid before it flows".to_owned(),
        ),
        Node::Shape(shape, _) => (
            format!("the shape `{}`", shape.body().name()),
            "its distance has creases; smooth_union and the like round those of other solids only".to_owned(),
        ),
        Node::Fractal(fractal, ..) => {
            let recipe = fractal.recipe();
            if recipe.noise.class() < Class::C2 {
                noise_name(&recipe.noise)
            } else if fractal.class() < Class::C2 {
                let folds = "the plain sum and the first cascade, fractal::fbm and fractal::altitude1 of a smooth noise, are C2";
                (format!("the sum of octaves `{}`", recipe.model.name()), folds.to_owned())
            } else {
                let fade = "with detail: false all octaves stay whole, and the sum is C2";
                ("octaves that fade with the distance".to_owned(), fade.to_owned())
            }
        }
    }
}

fn noise_name(noise: &Noise) -> (String, String) {
    let name = noise.kind.name();
    let smooth: Vec<&str> =
        Kind::ALL.iter().filter(|l| l.plain().class() == Class::C2).map(|l| l.name).collect();
    let remedy = format!("noises that are C2: {}", smooth.join(", "));
    match noise.part {
        Part::Value => (format!("{name} noise"), remedy),
        Part::Slope(_) => (
            format!("the slope of {name} noise"),
            "a displacement by vector_noise(noise) is as smooth as the noise itself".to_owned(),
        ),
    }
}

fn instead_of(op: &Op) -> &'static str {
    if matches!(op, Op::Min(_)) {
        "smooth_union(a, b, radius) has continuous curvature where its parts do"
    } else if matches!(op, Op::Max(_)) {
        "smooth_intersection(a, b, radius) has continuous curvature where its parts do"
    } else if matches!(op, Op::Abs(_)) {
        "sqrt(x ** 2 + 0.01 ** 2) is abs(x) with a rounded tip"
    } else if matches!(op, Op::Smoothstep(_)) {
        "smootherstep(low, high, x) is smooth also where it begins and ends"
    } else {
        "use a function with continuous second derivatives in its place"
    }
}
