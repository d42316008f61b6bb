//! Values as text: what `print`, `show` and the REPL say.

use super::host::Host;
use super::library::{GridValue, MeshValue, SceneValue};
use super::noises::{Domain, Kind, Source};
use super::value::{AffineVec3, Field, Region, Vec3, VectorField, type_name};
use crate::expr::{Graph, Input, Node, NodeId};
use crate::grid::{Edge, Grid};
use crate::noise::{Combination, Noise, Part, Recipe, Signal};
use crate::num::{Affine, Interval};
use crate::op::{self, Op};
use crate::shape::Mesh;
use glam::DVec3;
use rhai::{Array, Dynamic, Map};
use std::fmt::Write;

/// Length at which the text of an expression stops.
const ENOUGH: usize = 600;
/// Nesting at which it does.
const DEEP: usize = 40;

/// Any script value as text.
pub fn dynamic(host: &Host, v: &Dynamic) -> String {
    if let Some(f) = v.read_lock::<Field>() {
        return expression(&host.graph.borrow(), f.node);
    }
    if let Some(v) = v.read_lock::<VectorField>() {
        let graph = host.graph.borrow();
        let [x, y, z] = v.0.map(|node| expression(&graph, node));
        return format!("vec3({x}, {y}, {z})");
    }
    if let Some(v) = v.read_lock::<Vec3>() {
        return format!("vec3({})", v.0.map(number).join(", "));
    }
    if let Some(i) = v.read_lock::<Interval>() {
        return interval(*i);
    }
    if let Some(a) = v.read_lock::<Affine>() {
        return affine(&a);
    }
    if let Some(r) = v.read_lock::<Region>() {
        return format!("region({})", r.0.map(interval).join(" x "));
    }
    if let Some(v) = v.read_lock::<AffineVec3>() {
        return format!("vec3({})", v.0.each_ref().map(affine).join(", "));
    }
    if let Some(s) = v.read_lock::<Source>() {
        return source(&s);
    }
    if let Some(g) = v.read_lock::<GridValue>() {
        return grid(&g.0);
    }
    if let Some(m) = v.read_lock::<MeshValue>() {
        return mesh(m.mesh());
    }
    if let Some(s) = v.read_lock::<SceneValue>() {
        return scene(host, &s);
    }
    if let Some(a) = v.read_lock::<Array>() {
        return collection(&a, host);
    }
    if let Some(m) = v.read_lock::<Map>() {
        let parts = m.iter().take(40).map(|(k, v)| format!("{k}: {}", nested(host, v)));
        return format!("#{{ {} }}", parts.collect::<Vec<_>>().join(", "));
    }
    match type_name(v) {
        "Camera" | "Sun" | "Lamp" | "Material" | "Moon" | "Sea" | "Sky" | "Film" | "Air"
        | "corrected solid" | "value" => {
            format!("<{}>", type_name(v))
        }
        _ => v.to_string(),
    }
}

fn collection(a: &Array, host: &Host) -> String {
    let mut parts: Vec<String> = a.iter().take(40).map(|v| nested(host, v)).collect();
    if a.len() > 40 {
        parts.push(format!("... {} more", a.len() - 40));
    }
    format!("[{}]", parts.join(", "))
}

/// Arrays within arrays are not followed: they may be as deep as memory.
fn nested(host: &Host, v: &Dynamic) -> String {
    match type_name(v) {
        kind @ ("array" | "object map") => format!("<{kind}>"),
        "string" => format!("{:?}", v.to_string()),
        _ => dynamic(host, v),
    }
}

fn interval(i: Interval) -> String {
    format!("[{}, {}]", number(i.lo), number(i.hi))
}

/// All digits, with an exponent where there would be long runs of zeros.
fn number(v: f64) -> String {
    match v.abs() {
        a if a == 0.0 || !a.is_finite() || (1e-5..1e16).contains(&a) => v.to_string(),
        _ => format!("{v:e}"),
    }
}

fn nodes(graph: &Graph, root: NodeId) -> String {
    match graph.reachable(&[root]).len() {
        1 => "1 node".to_owned(),
        n => format!("{n} nodes"),
    }
}

fn affine(a: &Affine) -> String {
    let mut out = number(a.mid);
    for (k, (_, c)) in a.terms.iter().enumerate().take(6) {
        let sign = if *c < 0.0 { '-' } else { '+' };
        // Writing to a string cannot fail.
        let _ = write!(out, " {sign} {} e{}", number(c.abs()), k + 1);
    }
    if a.terms.len() > 6 {
        let _ = write!(out, " + {} more", a.terms.len() - 6);
    }
    format!("{out}  in {}", interval(a.range))
}

fn source(s: &Source) -> String {
    let noise = s.noise();
    let kind = match &s.kind {
        Kind::One(_) => format!("{} noise", noise.kind.name()),
        Kind::Sum(s) => {
            format!(
                "{} of {} octaves of {} noise",
                s.recipe.model.name(),
                s.recipe.octaves,
                noise.kind.name()
            )
        }
    };
    let place = match s.domain {
        Domain::Space => "",
        Domain::Sphere => " on the sphere",
        Domain::Plane => " on the plane",
    };
    let mut settings = noise_settings(noise);
    if let Kind::Sum(s) = &s.kind {
        settings += &fractal_settings(&s.recipe, s.hurst.is_some());
        if !s.detail {
            settings += ", detail false";
        }
    }
    format!("{kind}, seed {}, frequency {}{settings}{place}", given_seed(noise), noise.frequency)
}

/// The seed as the script gave it, whose whole numbers have a sign.
fn given_seed(noise: &Noise) -> i64 {
    noise.lattice.seed.cast_signed()
}

/// What a noise has besides seed and frequency, each after a comma.
fn noise_settings(noise: &Noise) -> String {
    let mut out = String::new();
    if noise.lattice.period != [0; 3] {
        let _ = write!(out, ", tiled {:?}", noise.lattice.period);
    }
    if let Part::Slope(axis) = noise.part {
        let _ = write!(out, ", slope along {}", ["x", "y", "z"][usize::from(axis.min(2))]);
    }
    out
}

/// The settings of a sum that are not as usual, each after a comma.
fn fractal_settings(recipe: &Recipe, varying: bool) -> String {
    let usual = Recipe::new(recipe.noise, recipe.model);
    let mut out = String::new();
    if recipe.first != usual.first {
        let _ = write!(out, ", first {}", recipe.first);
    }
    if recipe.lacunarity != usual.lacunarity {
        let _ = write!(out, ", lacunarity {}", recipe.lacunarity);
    }
    if varying {
        out += ", hurst a field";
    } else if recipe.hurst != usual.hurst {
        let _ = match recipe.hurst.exponents() {
            [h] => write!(out, ", hurst {h}"),
            all => write!(out, ", hurst {all:?}"),
        };
    }
    if recipe.model.combination != Combination::Sum && recipe.model.signal != Signal::Plain {
        let _ = write!(out, ", signal {}", recipe.model.signal.name());
    }
    if recipe.offset != usual.offset {
        let _ = write!(out, ", offset {}", recipe.offset);
    }
    if recipe.rotate {
        out += ", rotate true";
    }
    out
}

/// Samples along the axes that have more than one.
fn sizes(grid: &Grid) -> String {
    let size = grid.frame().size.iter().filter(|n| **n > 1).map(|n| n.to_string());
    size.collect::<Vec<_>>().join(" x ")
}

fn mesh(mesh: &Mesh) -> String {
    let (points, triangles) = (mesh.points.len(), mesh.triangles.len());
    let place = |(lo, hi): (DVec3, DVec3)| format!(" from {lo} to {hi}");
    format!("{triangles} triangles, {points} points{}", mesh.bounds().map_or(String::new(), place))
}

fn grid(grid: &Grid) -> String {
    let frame = grid.frame();
    let kind = if frame.is_heightfield() { "heightfield" } else { "volume" };
    let edge = if frame.edge == Edge::Repeat { "repeats" } else { "clamped" };
    let (low, high) = grid.samples().extremes();
    let [x, y, z] = frame.origin;
    format!(
        "{kind} of {} samples from ({x}, {y}, {z}), {edge}, values in {}",
        sizes(grid),
        interval(Interval::new(low, high))
    )
}

/// What the REPL says of a field: expression, class and variables.
pub fn summary(host: &Host, v: &Dynamic) -> String {
    let Some(f) = v.read_lock::<Field>() else { return dynamic(host, v) };
    let inputs = [(Input::X, "x"), (Input::Y, "y"), (Input::Z, "z"), (Input::Time, "time")];
    let reads = inputs.into_iter().filter(|(i, _)| host.depends_on(f.node, &[*i])).map(|(_, name)| name);
    let reads: Vec<&str> = reads.collect();
    let of = if reads.is_empty() { "constant".to_owned() } else { format!("of {}", reads.join(", ")) };
    let graph = host.graph.borrow();
    let color = if f.color.is_some() { ", coloured" } else { "" };
    let nodes = nodes(&graph, f.node);
    format!("{}\n  {}, {of}{color}, {nodes}", expression(&graph, f.node), graph.class(f.node))
}

fn scene(host: &Host, s: &SceneValue) -> String {
    let graph = host.graph.borrow();
    let nodes = nodes(&graph, s.surface.node);
    let (film, eye) = (s.film, s.camera.eye);
    format!(
        "scene: surface {} with {nodes}, camera at ({:.3}, {:.3}, {:.3}), film {} x {}",
        graph.class(s.surface.node),
        eye.x,
        eye.y,
        eye.z,
        film.width,
        film.height
    )
}

/// An expression as a script would say it, cut where it gets long.
pub fn expression(graph: &Graph, node: NodeId) -> String {
    let mut out = String::new();
    write_node(graph, node, 0, 0, &mut out);
    out
}

/// How tightly an operation binds its operands in text.
fn precedence(op: &Op) -> u8 {
    match op {
        Op::Add(_) | Op::Sub(_) => 1,
        Op::Mul(_) | Op::Div(_) => 2,
        Op::Neg(_) => 3,
        Op::Square(_) | Op::Powi(_) => 4,
        _ => 5,
    }
}

fn write_node(graph: &Graph, node: NodeId, outer: u8, depth: usize, out: &mut String) {
    if out.len() > ENOUGH || depth > DEEP {
        if !out.ends_with("...") {
            out.push_str("...");
        }
        return;
    }
    match graph.node(node) {
        Node::Const(bits) => {
            let c = f64::from_bits(*bits);
            let _ = if c < 0.0 && outer > 1 { write!(out, "({c})") } else { write!(out, "{c}") };
        }
        Node::Input(_) => out.push_str(&head(graph, node)),
        Node::Op(op, args) => write_op(graph, op, args, outer, depth, out),
        Node::Noise(_, p) | Node::Grid(_, p) | Node::Shape(_, p) | Node::Fractal(_, p, ..) => {
            let _ = write!(out, "{}(", head(graph, node));
            write_list(graph, p, depth, out);
        }
        Node::Flow(flow, p) => {
            out.push_str("flow(");
            write_node(graph, flow.field, 0, depth + 1, out);
            for part in flow.velocity {
                out.push_str(", ");
                write_node(graph, part, 0, depth + 1, out);
            }
            out.push_str(")(");
            write_list(graph, p, depth, out);
        }
    }
}

/// What a node is without what it is made of: the name of an operation, a noise with its settings.
pub fn head(graph: &Graph, node: NodeId) -> String {
    match graph.node(node) {
        Node::Const(bits) => f64::from_bits(*bits).to_string(),
        Node::Input(input) => match input {
            Input::X => "x",
            Input::Y => "y",
            Input::Z => "z",
            Input::Time => "time",
            Input::Footprint => "footprint",
        }
        .to_owned(),
        Node::Op(Op::Powi(powi), _) => format!("**{}", powi.n),
        Node::Op(op, _) => match parameter(op) {
            Some(parameter) => format!("{} {parameter}", op.name()),
            None => op.name().to_owned(),
        },
        Node::Noise(noise, _) => {
            let (seed, settings) = (given_seed(noise), noise_settings(noise));
            format!("{}({seed}, {}{settings})", noise.kind.name(), noise.frequency)
        }
        Node::Grid(grid, _) => format!("grid({})", sizes(grid)),
        Node::Shape(shape, _) => shape.body().name().to_owned(),
        Node::Flow(..) => "flow".to_owned(),
        Node::Fractal(f, _, _, hurst) => {
            let recipe = f.recipe();
            let (name, kind) = (recipe.model.name(), recipe.noise.kind.name());
            let settings = noise_settings(&recipe.noise) + fractal_settings(recipe, hurst.is_some()).as_str();
            format!("{name}({kind}, {} octaves{settings})", recipe.octaves)
        }
    }
}

fn write_op(graph: &Graph, op: &Op, args: &[NodeId], outer: u8, depth: usize, out: &mut String) {
    let own = precedence(op);
    let open = own < outer;
    if open {
        out.push('(');
    }
    match op {
        Op::Add(_) | Op::Sub(_) | Op::Mul(_) | Op::Div(_) => {
            write_node(graph, args[0], own, depth + 1, out);
            let _ = write!(out, " {} ", op.name());
            write_node(graph, args[1], own + 1, depth + 1, out);
        }
        Op::Neg(_) => {
            out.push('-');
            write_node(graph, args[0], own + 1, depth + 1, out);
        }
        Op::Square(_) | Op::Powi(_) => {
            write_node(graph, args[0], own + 1, depth + 1, out);
            let n = if let Op::Powi(powi) = op { powi.n } else { 2 };
            let _ = write!(out, "**{n}");
        }
        _ => {
            let _ = write!(out, "{}(", op.name());
            write_list(graph, args, depth, out);
            if let Some(parameter) = parameter(op) {
                out.pop();
                let _ = write!(out, ", {parameter})");
            }
        }
    }
    if open {
        out.push(')');
    }
}

/// What a call of an operation says after the arguments.
fn parameter(op: &Op) -> Option<String> {
    match op {
        Op::Norm(norm) => Some(norm.power().to_string()),
        Op::Plus(plus) => Some(plus.n.to_string()),
        Op::Ramp(ramp) => profile(ramp),
        Op::Melt(melt) if melt.width() == 1.0 => profile(&melt.ramp),
        Op::Melt(melt) => profile(&melt.ramp).map(|shape| format!("{shape}, {}", melt.width())),
        _ => None,
    }
}

/// The name of a ramp, in quotes.
fn profile(ramp: &op::Ramp) -> Option<String> {
    let named = op::Ramp::ALL.into_iter().find(|(_, shape)| shape == ramp);
    named.map(|(name, _)| format!("\"{name}\""))
}

fn write_list(graph: &Graph, args: &[NodeId], depth: usize, out: &mut String) {
    for (i, &arg) in args.iter().enumerate() {
        if i > 0 {
            out.push_str(", ");
        }
        write_node(graph, arg, 0, depth + 1, out);
    }
    out.push(')');
}
