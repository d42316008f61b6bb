//! Noises of scripts as random fields: a script whose value is a noise comes to an [`Ensemble`].
//!
//! A `Noise` is realised by reseeding it. A `Field` is one function and has no seed of its own, but
//! if its script asks for a parameter called `seed`, the script is run once for each realisation with
//! that parameter set: so anything that can be written can be analysed, warps and mixtures too.

use super::diagnose::Explainer;
use super::engine::Setup;
use super::fault::{Fault, Outcome};
use super::noises::{Kind, Source};
use super::value::{Scalar, Value};
use super::{Request, evaluate, execute, library, options};
use crate::diag::{Diagnostic, Sources};
use crate::expr::{Graph, NodeId};
use crate::noise::Noise;
use crate::scene::{Ensemble, Member, period};
use rhai::Dynamic;
use std::sync::Arc;

/// Which realisations of a noise are wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Draw {
    /// How many.
    pub count: usize,
    /// The seed of the first, if not the script's own; the others follow it.
    pub seed: Option<i64>,
    /// The length after which they should repeat, if they can.
    pub side: f64,
}

/// What a script came to.
#[derive(Clone, Debug)]
pub struct Realised {
    /// The random field, unless there was an error.
    pub ensemble: Option<Ensemble>,
    /// Errors and warnings.
    pub diagnostics: Vec<Diagnostic>,
    /// Texts that the diagnostics refer to.
    pub sources: Sources,
    /// What `print` and `debug` said.
    pub output: Vec<String>,
}

/// Name of the parameter that stands for the seed in scripts whose value is a field.
const SEED: &str = "seed";

/// The value of a run: a random field, or one field out of one.
enum Drawn {
    All(Ensemble),
    One {
        field: Member,
        /// The value of the parameter `seed`, if there is one.
        seed: Option<f64>,
    },
}

/// Runs a script whose value is a noise.
pub fn realise(request: &Request, draw: &Draw) -> Realised {
    let mut request = request.clone();
    let mut first = execute(&request, |setup, name, text, diagnostics| {
        let drawn = drawn(setup, &request, name, text, draw, diagnostics);
        diagnostics.extend(library::unused(&setup.host));
        drawn
    });
    let ensemble = match first.value.take() {
        None => None,
        Some(Drawn::All(ensemble)) => Some(ensemble),
        Some(Drawn::One { seed: None, .. }) => {
            first.diagnostics.push(
                Diagnostic::error("the value is a field, which is the same whatever the seed")
                    .hint("end the script with a noise, such as gradient(7).scaled(2.0)")
                    .hint(
                        "or let the field depend on a parameter: let seed = param(\"seed\", 7, 0..1000000);",
                    ),
            );
            None
        }
        Some(Drawn::One { field, seed: Some(own) }) => {
            let start = draw.seed.map_or(own, |seed| seed as f64);
            let mut members = Vec::new();
            for i in 0..draw.count {
                request.params.insert(SEED.to_owned(), (start + i as f64).into());
                let ran = execute(&request, |setup, name, text, diagnostics| {
                    drawn(setup, &request, name, text, draw, diagnostics)
                });
                match ran.value {
                    Some(Drawn::One { field, .. }) => members.push(field),
                    _ => {
                        (first.diagnostics, first.sources) = (ran.diagnostics, ran.sources);
                        break;
                    }
                }
            }
            let plain = members.first().cloned().unwrap_or(field);
            (members.len() == draw.count).then_some(Ensemble {
                members,
                plain,
                period: None,
                cell: 1.0,
                octaves: (1.0, 1.0),
            })
        }
    };
    let failed = first.diagnostics.iter().any(|d| d.severity == crate::diag::Severity::Error);
    Realised {
        ensemble: ensemble.filter(|_| !failed),
        diagnostics: first.diagnostics,
        sources: first.sources,
        output: first.output,
    }
}

fn drawn(
    setup: &Setup,
    request: &Request,
    name: &str,
    text: &str,
    draw: &Draw,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Drawn> {
    let value = evaluate(setup, name, text).map_err(|e| {
        let explainer = Explainer { setup, limits: &request.limits, main: name };
        diagnostics.push(explainer.explain(&e));
    });
    let found = of_value(setup, &value.ok()?, draw).map_err(|fault| {
        let mut d = Diagnostic::error(fault.message);
        d.hints = fault.hints;
        diagnostics.push(d);
    });
    found.ok()
}

fn of_value(setup: &Setup, value: &Dynamic, draw: &Draw) -> Outcome<Drawn> {
    let host = &setup.host;
    if let Some(source) = value.read_lock::<Source>() {
        return ensemble(setup, &source, draw).map(Drawn::All);
    }
    match Value::of(host, value)? {
        Some(Value::Scalar(Scalar::Field(node), _)) => {
            let params = host.params.borrow();
            let seed = params.iter().find(|p| p.name == SEED).and_then(|p| p.value.number());
            Ok(Drawn::One { field: member(&Arc::new(host.graph.borrow().clone()), node), seed })
        }
        _ => Err(Fault::new(format!("the value is {}, not a noise", options::describe(value)))
            .hint("end with a noise, such as gradient(7).scaled(2.0), or with a field that depends on param(\"seed\", 7, 0..1000000)")),
    }
}

fn ensemble(setup: &Setup, source: &Source, draw: &Draw) -> Outcome<Ensemble> {
    let host = &setup.host;
    let noise: Noise = *source.noise();
    let first = draw.seed.map_or(noise.lattice.seed, i64::cast_unsigned);
    let reseeded = |i: usize| source.clone().seeded(first.wrapping_add(i as u64));
    // A noise that cannot repeat is analysed as it is.
    let period = period(noise.frequency, draw.side);
    let tiles = period.is_some_and(|p| source.clone().tiled([p; 3]).is_ok());
    let mut roots = Vec::new();
    for i in 0..draw.count {
        let one = match period.filter(|_| tiles) {
            Some(p) => reseeded(i).tiled([p; 3])?,
            None => reseeded(i),
        };
        roots.push(one.lower(host)?);
    }
    let plain = reseeded(0).lower(host)?;
    let graph = Arc::new(host.graph.borrow().clone());
    let octaves = match &source.kind {
        Kind::One(_) => (noise.frequency, noise.frequency),
        Kind::Sum(sum) => {
            let (first, count) = (sum.recipe.first, sum.recipe.octaves as i32);
            (sum.recipe.frequency(first), sum.recipe.frequency(first + count - 1))
        }
    };
    Ok(Ensemble {
        members: roots.into_iter().map(|root| member(&graph, root)).collect(),
        plain: member(&graph, plain),
        period: tiles.then_some(draw.side),
        cell: 1.0 / noise.frequency,
        octaves,
    })
}

fn member(graph: &Arc<Graph>, root: NodeId) -> Member {
    Member { graph: graph.clone(), root }
}
