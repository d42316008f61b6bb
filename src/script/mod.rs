//! Scripts: text in, [`Scene`] and diagnostics out.
//!
//! A script runs once and builds an expression; its value is a scene, or a field, which gets a
//! default scene. [`compile`] runs one from a file or a text; [`Interpreter`] runs one line after
//! another for a REPL.
//!
//! How it is built:
//! - [`value`] holds what scripts compute with, [`apply`] the one rule by which every operation of
//!   [`op`](crate::op) works on any mix of them;
//! - [`library`] declares the native functions, with their documentation; what can be said in the
//!   language itself is in the standard library, `stdlib/*.rhai`;
//! - [`engine`] decides what a script may use and how much of it, [`modules`] what it may import;
//! - [`diagnose`] turns every error into a diagnostic.
//!
//! A script is not trusted: it has no clock, no randomness, no files but the imports of its own
//! folder, and bounded time and memory. Native functions return errors and never panic.

mod apply;
mod arguments;
mod complete;
mod definitions;
mod diagnose;
mod engine;
mod fault;
pub mod genes;
pub mod help;
mod host;
mod lexer;
mod library;
mod marks;
mod modules;
mod noises;
mod options;
mod realise;
mod repl;
pub mod rewrite;
mod show;
mod signs;
mod slips;
mod synonyms;
mod syntax;
mod tree;
mod unknown;
mod value;
mod wording;

pub use complete::{Candidate, Completion};
pub use definitions::definitions;
pub use engine::Limits;
pub use library::Entry;
pub use modules::{PRELUDE, STD};
pub use realise::{Draw, Realised, realise};
pub use repl::{Interpreter, Line};
pub use syntax::{Role, roles};
pub use tree::tree;

use crate::diag::{Diagnostic, Sources};
use crate::expr::{Input, Node, NodeId};
use crate::num::Class;
use crate::op::Op;
use crate::scene::{self, Keep, Material, Moon, Scene, Sea, Sky, Surface};
use crate::world::World;
use diagnose::Explainer;
use engine::Setup;
use host::Host;
use library::{Corrected, MoonValue, SceneValue};
use rhai::{Dynamic, EvalAltResult};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;
use value::Field;

/// What to run.
#[derive(Clone)]
pub enum Script {
    /// A file, which the world reads.
    File(PathBuf),
    /// A text, with the name that messages give it; imports are looked for in the working folder.
    Text {
        /// Name for messages.
        name: String,
        /// The script.
        text: String,
    },
}

/// A script with everything that its run depends on.
#[derive(Clone)]
pub struct Request {
    /// What to run.
    pub script: Script,
    /// Parameters that the user sets.
    pub params: BTreeMap<String, scene::Value>,
    /// Whether it is an error if the script does not ask for one of them: whether it does may depend on the others.
    pub strict: bool,
    /// Animation time in seconds.
    pub time: f64,
    /// Where files come from.
    pub world: Arc<dyn World + Send + Sync>,
    /// How much the script may use.
    pub limits: Limits,
    /// Stops the run when set.
    pub cancel: Option<Arc<AtomicBool>>,
}

impl Request {
    /// A request with nothing set.
    pub fn new(script: Script, world: Arc<dyn World + Send + Sync>) -> Self {
        Request {
            script,
            params: BTreeMap::new(),
            strict: true,
            time: 0.0,
            world,
            limits: Limits::default(),
            cancel: None,
        }
    }

    /// A text without imports of its own.
    pub fn text(text: impl Into<String>) -> Self {
        let script = Script::Text { name: "script".to_owned(), text: text.into() };
        Request::new(script, Arc::new(crate::world::Memory::default()))
    }
}

/// What a run gave.
#[derive(Debug, Default)]
pub struct Compiled {
    /// The scene, unless there was an error.
    pub scene: Option<Scene>,
    /// Errors and warnings.
    pub diagnostics: Vec<Diagnostic>,
    /// Texts that the diagnostics refer to.
    pub sources: Sources,
    /// The script and every import that was looked for, found or not: what to watch.
    pub files: Vec<PathBuf>,
    /// What `print` and `debug` said.
    pub output: Vec<String>,
}

/// Room for nested calls, whatever the caller's thread has.
const STACK: usize = 64 << 20;

/// Runs a script.
pub fn compile(request: &Request) -> Compiled {
    let ran = execute(request, |setup, name, text, diagnostics| {
        scene_of(setup, &request.limits, name, text, diagnostics)
    });
    let Ran { value: scene, diagnostics, sources, files, output } = ran;
    Compiled { scene, diagnostics, sources, files, output }
}

/// A run of a script, and what was made of its value.
struct Ran<T> {
    value: Option<T>,
    diagnostics: Vec<Diagnostic>,
    sources: Sources,
    files: Vec<PathBuf>,
    output: Vec<String>,
}

impl<T> Ran<T> {
    fn failed(d: Diagnostic) -> Self {
        let (sources, files, output) = Default::default();
        Ran { value: None, diagnostics: vec![d], sources, files, output }
    }
}

/// What is made of a script: from its engine, its name and its text, with a list for complaints.
trait Make<T>: FnOnce(&mut Setup, &str, &str, &mut Vec<Diagnostic>) -> Option<T> + Send {}
impl<T, F: FnOnce(&mut Setup, &str, &str, &mut Vec<Diagnostic>) -> Option<T> + Send> Make<T> for F {}

/// Reads a script and makes something of it, on a thread with room for nested calls.
fn execute<T: Send>(request: &Request, make: impl Make<T>) -> Ran<T> {
    std::thread::scope(|scope| {
        let work = || run(request, make);
        match std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, work) {
            Ok(thread) => thread.join().unwrap_or_else(|_| {
                Ran::failed(Diagnostic::error("the script host failed; this is a bug of the program"))
            }),
            Err(e) => Ran::failed(Diagnostic::error(format!("no thread can be started for the script: {e}"))),
        }
    })
}

fn run<T>(request: &Request, make: impl Make<T>) -> Ran<T> {
    let mut host = Host::new(&request.limits, request.params.clone(), request.time);
    host.strict = request.strict;
    host.store = request.world.store();
    host.deadline.set(Instant::now().checked_add(request.limits.time));
    let (name, root) = match &request.script {
        Script::File(path) => {
            (path.to_string_lossy().into_owned(), path.parent().map(Path::to_owned).unwrap_or_default())
        }
        Script::Text { name, .. } => (name.clone(), PathBuf::new()),
    };
    let world = request.world.clone();
    let resolver = |loaded| modules::Resolver { world, loaded };
    let mut setup = match engine::setup(host, resolver, &request.limits, request.cancel.clone()) {
        Ok(setup) => setup,
        Err(d) => return Ran::failed(*d),
    };
    setup.loaded.root.replace(root);
    let mut diagnostics = Vec::new();
    let value = match read(request, &setup, &name) {
        Ok(text) => make(&mut setup, &name, &text, &mut diagnostics),
        Err(d) => {
            diagnostics.push(*d);
            None
        }
    };
    let (sources, files) = (setup.loaded.sources.take(), setup.loaded.files.take());
    Ran { value, diagnostics, sources, files, output: setup.host.output.take() }
}

fn read(request: &Request, setup: &Setup, name: &str) -> Result<Arc<str>, Box<Diagnostic>> {
    let text = match &request.script {
        Script::Text { text, .. } => Arc::from(text.as_str()),
        Script::File(path) => {
            setup.loaded.touched(path);
            let unreadable = |e| Box::new(Diagnostic::error(modules::unreadable(name, &e).message));
            request.world.read(path).map_err(unreadable)?
        }
    };
    setup.loaded.source(name, &text);
    Ok(text)
}

fn scene_of(
    setup: &Setup,
    limits: &Limits,
    name: &str,
    text: &str,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Scene> {
    let explainer = Explainer { setup, limits, main: name };
    let value = evaluate(setup, name, text);
    // Of the script, and of what it has imported.
    diagnostics
        .extend(setup.loaded.sources.borrow().iter().flat_map(|(name, text)| signs::warnings(name, text)));
    let value = match value {
        Ok(value) => value,
        Err(e) => {
            diagnostics.push(explainer.explain(&e));
            return None;
        }
    };
    diagnostics.extend(library::unused(&setup.host));
    diagnostics.extend(setup.host.odd.take());
    let scene = match scene_value(setup, &value) {
        Ok(scene) => scene,
        Err(mut d) => {
            if value.is_unit()
                && let Some(hint) = slips::no_value(text)
            {
                d.hints = vec![hint];
            }
            diagnostics.push(*d);
            return None;
        }
    };
    match finish(&setup.host, &scene) {
        Ok(scene) => {
            diagnostics.extend(warnings(&scene));
            let failed = diagnostics.iter().any(|d| d.severity == crate::diag::Severity::Error);
            (!failed).then_some(scene)
        }
        Err(fault) => {
            let mut d = Diagnostic::error(fault.message);
            d.hints = fault.hints;
            diagnostics.push(d);
            None
        }
    }
}

fn evaluate(setup: &Setup, name: &str, text: &str) -> Result<Dynamic, Box<EvalAltResult>> {
    slips::refuse_open_comment(name, text)?;
    let mut ast = setup.engine.compile(text).map_err(Box::<EvalAltResult>::from)?;
    ast.set_source(name);
    setup.engine.eval_ast::<Dynamic>(&ast)
}

/// The scene that a script's value means.
fn scene_value(setup: &Setup, value: &Dynamic) -> Result<SceneValue, Box<Diagnostic>> {
    if let Some(scene) = value.read_lock::<SceneValue>() {
        return Ok(scene.clone());
    }
    if let Some(Corrected { field, keep }) = value.read_lock::<Corrected>().map(|c| *c) {
        return Ok(SceneValue { keep: Some(keep), ..SceneValue::new(field) });
    }
    let field = match value::Value::of(&setup.host, value) {
        Ok(Some(value::Value::Scalar(value::Scalar::Field(node), color))) => Some(Field { node, color }),
        Err(fault) => {
            let d = Diagnostic::error(fault.message);
            return Err(Box::new(fault.hints.into_iter().fold(d, Diagnostic::hint)));
        }
        _ => None,
    };
    field.map(SceneValue::new).ok_or_else(|| Box::new(no_scene(value)))
}

fn no_scene(value: &Dynamic) -> Diagnostic {
    let d = Diagnostic::error(format!(
        "the script's value is {}, not a scene or a field",
        options::describe(value)
    ));
    d.hint("end the script with scene(#{ surface: ... }) or a field")
}

/// The scene with its time fixed and its graph complete.
fn finish(host: &Host, value: &SceneValue) -> fault::Outcome<Scene> {
    let time = host.constant(host.time)?;
    let still = |node: NodeId| host.substitute(node, &[(Input::Time, time)]);
    let solid = |of: &Field, material: &Option<Material>, keep: Option<Keep>| {
        let color = match of.color {
            Some([r, g, b]) => Some([still(r)?, still(g)?, still(b)?]),
            None => None,
        };
        let material = material.map(|m| m.changed(still)).transpose()?;
        Ok::<_, fault::Fault>(Surface { field: still(of.node)?, color, material, keep })
    };
    let moon = match &value.moon {
        Some(MoonValue { surface, material, bounds, position, radius }) => {
            let surface = solid(surface, material, None)?;
            Some(Moon { surface, bounds: *bounds, position: *position, radius: *radius })
        }
        None => None,
    };
    let sea = match value.sea {
        Some(sea) => Some(Sea { field: still(sea.field)?, material: sea.material.changed(still)?, ..sea }),
        None => None,
    };
    let surface = solid(&value.surface, &value.material, value.keep)?;
    Ok(Scene {
        graph: Arc::new(host.graph.borrow().clone()),
        surface,
        camera: value.camera,
        sun: value.sun,
        lights: value.lights.clone(),
        sky: value.sky,
        moon,
        sea,
        film: value.film,
        bounds: value.bounds,
        params: host.params.borrow().clone(),
    })
}

/// What may be had in place of something that jumps.
fn without_jump(node: &Node) -> &'static str {
    match node {
        Node::Op(Op::Modulo(_) | Op::Fract(_), _) => {
            "0.5 * period * zigzag(2.0 * x / period) is how far x is from the nearest multiple of a period, without a jump"
        }
        Node::Op(Op::Atan2(_), _) => {
            "an angle jumps by a whole turn behind its centre; nothing is wrong where the field is the same on both sides of that, but rays there are not certain"
        }
        _ => "smoothstep(low, high, x) is a step without a jump",
    }
}

/// What is allowed, but hardly meant.
fn warnings(scene: &Scene) -> Vec<Diagnostic> {
    let (graph, field) = (&scene.graph, scene.surface.field);
    let used = graph.reachable(&[field]);
    let spatial = |id: &NodeId| matches!(graph.node(*id), Node::Input(Input::X | Input::Y | Input::Z));
    let mut found = Vec::new();
    if !used.iter().any(spatial) {
        found.push(
            Diagnostic::warning("the surface is the same at every point, so there is nothing to see")
                .hint("a solid is a field of x, y, z, such as length(p) - 1.0"),
        );
    }
    let jumps = |id: &&NodeId| graph.class(**id) == Class::Jump;
    if let Some(first) = used.iter().find(jumps) {
        found.push(
            Diagnostic::warning("the surface jumps, so rays may not find it and bounds may not hold")
                .at(graph.place(*first).cloned())
                .label("discontinuous")
                .hint(without_jump(graph.node(*first))),
        );
    }
    if scene.film.occlusion > 0.0 && scene.film.bounces > 0 {
        found.push(
            Diagnostic::warning("`occlusion` of `film` has no effect where light bounces")
                .hint("paths find out by themselves what hides the sky; leave `occlusion` out"),
        );
    }
    let Sky { zenith, nadir, .. } = Sky::default();
    if scene.sky.air.is_some() && [scene.sky.zenith, scene.sky.nadir] != [zenith, nadir] {
        found.push(
            Diagnostic::warning("`zenith` and `nadir` of `sky` have no effect where there is air")
                .hint("the air gives light of its own; leave them out"),
        );
    }
    if scene.film.irradiance_spacing > 0 && scene.film.bounces == 0 {
        found.push(
            Diagnostic::warning("`irradiance` of `film` has no effect where no light bounces")
                .hint("allow a bounce, with `bounces: 1`, or leave `irradiance` out"),
        );
    }
    found
}

/// Every function that scripts can call, native or of the standard library, with documentation.
pub fn reference() -> Vec<Entry> {
    let host = Host::new(&Limits::default(), BTreeMap::new(), 0.0);
    let world = Arc::new(crate::world::Memory::default());
    let resolver = |loaded| modules::Resolver { world, loaded };
    let native =
        engine::setup(host, resolver, &Limits::default(), None).map(|s| s.entries).unwrap_or_default();
    native.into_iter().chain(std_entries()).collect()
}

/// The documented functions of the standard library; those that need an import carry its name.
fn std_entries() -> Vec<Entry> {
    let mut entries = Vec::new();
    for (module, text) in modules::STD {
        let name = if modules::PRELUDE.contains(module) { "" } else { module };
        entries.extend(entries_of(name, lexer::functions(text), &format!("std/{module}")));
    }
    entries
}

/// Functions of a module under the name that it was imported by, which is empty where there is none, and a heading.
fn entries_of(module: &str, functions: Vec<lexer::Documented>, group: &str) -> Vec<Entry> {
    let prefix = if module.is_empty() { String::new() } else { format!("{module}::") };
    let entry = |f: lexer::Documented| Entry {
        name: format!("{prefix}{}", f.name),
        signature: format!("{prefix}{}", f.signature),
        doc: f.doc,
        example: f.example,
        group: group.to_owned(),
    };
    functions.into_iter().map(entry).collect()
}
