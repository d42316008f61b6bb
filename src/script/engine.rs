//! The script engine: which of its parts a script may use, and how much of everything.

use super::arguments;
use super::fault::Fault;
use super::host::Host;
use super::lexer;
use super::library::{self, Entry};
use super::modules::{self, Loaded, Resolver};
use super::value::{Field, VectorField};
use crate::diag::Diagnostic;
use crate::expr::Input;
use rhai::packages::{
    ArithmeticPackage, BasicArrayPackage, BasicFnPackage, BasicIteratorPackage, BasicMapPackage,
    BasicStringPackage, LogicPackage, MoreStringPackage, Package,
};
use rhai::{Dynamic, Engine, OptimizationLevel};
use std::any::TypeId;
use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How much a script may use.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Limits {
    /// Steps of the script.
    pub operations: u64,
    /// Calls within calls, [`Limits::MOST_CALLS`] at most.
    pub calls: usize,
    /// Nodes of the expression graph.
    pub nodes: usize,
    /// Running time.
    pub time: Duration,
    /// Characters of a text.
    pub text: usize,
    /// Elements of an array or object map, with everything in them.
    pub elements: usize,
    /// Variables at once.
    pub variables: usize,
    /// Imports.
    pub modules: usize,
    /// Samples of all grids.
    pub samples: usize,
}

impl Limits {
    /// As many calls within calls as there is certainly room for.
    pub const MOST_CALLS: usize = 1000;
}

impl Default for Limits {
    fn default() -> Self {
        Limits {
            operations: 20_000_000,
            calls: 64,
            nodes: 1 << 20,
            time: Duration::from_secs(20),
            text: 1 << 20,
            elements: 100_000,
            variables: 10_000,
            modules: 200,
            samples: crate::grid::MOST_SAMPLES,
        }
    }
}

/// Why a run was stopped from outside.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Stop {
    /// The user wants something else.
    Cancelled,
    /// It took too long.
    TimedOut,
    /// The time was up while a function of ours was at work.
    Overran(Rc<str>),
}

/// An engine with everything that scripts may use.
pub struct Setup {
    /// The engine.
    pub engine: Engine,
    /// What native functions share.
    pub host: Rc<Host>,
    /// What was read.
    pub loaded: Rc<Loaded>,
    /// Native functions.
    pub entries: Vec<Entry>,
}

/// Names that are fields everywhere.
pub const INPUTS: [(&str, Input); 4] =
    [("x", Input::X), ("y", Input::Y), ("z", Input::Z), ("time", Input::Time)];

/// Keywords of the language, for completion.
pub const KEYWORDS: &[&str] = &[
    "let", "const", "if", "else", "switch", "while", "loop", "do", "until", "for", "in", "fn", "private",
    "return", "break", "continue", "import", "export", "as", "true", "false", "throw", "try", "catch",
    "this", "global", "type_of", "print", "debug",
];

/// Builds an engine.
///
/// # Errors
/// When the embedded standard library is broken or does not fit into the limits.
pub fn setup(
    mut host: Host,
    resolver: impl FnOnce(Rc<Loaded>) -> Resolver,
    limits: &Limits,
    cancel: Option<Arc<AtomicBool>>,
) -> Result<Setup, Box<Diagnostic>> {
    host.cancel = cancel;
    let (host, loaded) = (Rc::new(host), Rc::<Loaded>::default());
    let mut engine = Engine::new_raw();
    // No clock, no sleeping, no `exit`, and mathematics from the list of operations only.
    engine.register_global_module(ArithmeticPackage::new().as_shared_module());
    engine.register_global_module(LogicPackage::new().as_shared_module());
    engine.register_global_module(BasicStringPackage::new().as_shared_module());
    engine.register_global_module(MoreStringPackage::new().as_shared_module());
    engine.register_global_module(BasicArrayPackage::new().as_shared_module());
    engine.register_global_module(BasicMapPackage::new().as_shared_module());
    engine.register_global_module(BasicIteratorPackage::new().as_shared_module());
    engine.register_global_module(BasicFnPackage::new().as_shared_module());
    engine.disable_symbol("eval");
    // The optimizer would compute `x == 1.0` with the engine's own `==`, which is false, before ours
    // can refuse it. Scripts run once, so there is nothing to gain.
    engine.set_optimization_level(OptimizationLevel::None);
    bound(&mut engine, limits);
    watch(&mut engine, &host);
    listen(&mut engine, &host);
    tell_of_faults(&mut engine);
    let folder = resolver(loaded.clone());
    engine.set_module_resolver(folder.clone());
    let entries = library::register(&mut engine, &host, &folder);
    arguments::register(&mut engine);
    let broken = |e: String| Box::new(Diagnostic::error(format!("the standard library does not load: {e}")));
    let globals = globals(&host).map_err(|f| broken(f.to_string()))?;
    resolve(&mut engine, globals);
    for (name, text) in modules::STD.iter().filter(|(name, _)| modules::PRELUDE.contains(name)) {
        let file = format!("std/{name}.rhai");
        loaded.source(&file, &Arc::from(*text));
        let module = loaded.build_prelude(&engine, &file, text).map_err(|e| broken(e.to_string()))?;
        engine.register_global_module(module.into());
        lexer::functions(text).iter().for_each(|function| as_method(&mut engine, function));
    }
    Ok(Setup { engine, host, loaded, entries })
}

/// Lets a function of the language be called as a method, `sphere(1.0).shell(0.1)`, as native ones can be: the engine looks for
/// one of its own with a parameter less, and else for a native one.
fn as_method(engine: &mut Engine, function: &lexer::Documented) {
    let name = function.name.clone();
    let parameters = lexer::parameters(&function.signature);
    if parameters == 0 {
        return;
    }
    engine.register_raw_fn(
        &function.name,
        vec![TypeId::of::<Dynamic>(); parameters],
        move |context, args| {
            // The first may be a variable, which stays as it is.
            let mut args: Vec<Dynamic> = args.iter().map(|arg| Dynamic::clone(arg)).collect();
            context.call_fn_raw(&name, false, false, &mut args.iter_mut().collect::<Vec<_>>())
        },
    );
}

/// Functions, imported modules and functions without a name see globals, though they see none of the variables around
/// them, or take them along. A variable or parameter of the same name still comes first.
#[allow(deprecated)] // it is not, but may change with versions of the engine; there is no other way
fn resolve(engine: &mut Engine, globals: HashMap<&'static str, Dynamic>) {
    engine.on_var(move |name, place, context| {
        let is_local = place > 0 || context.scope().contains(name);
        Ok(if is_local { None } else { globals.get(name).cloned() })
    });
}

/// Lets scripts that catch an error print it, or ask for its `message`.
fn tell_of_faults(engine: &mut Engine) {
    let message = |fault: &mut Fault| fault.message.clone();
    engine.register_type_with_name::<Fault>("Error").register_get("message", message);
    for name in ["to_string", "to_debug", "print", "debug"] {
        engine.register_fn(name, message);
    }
}

/// `x y z p time` and a few numbers.
fn globals(host: &Host) -> Result<HashMap<&'static str, Dynamic>, super::fault::Fault> {
    let mut globals: HashMap<&'static str, Dynamic> = HashMap::new();
    for (name, input) in INPUTS {
        globals.insert(name, Dynamic::from(Field { node: host.input(input)?, color: None }));
    }
    globals.insert("p", Dynamic::from(VectorField(host.point()?)));
    globals.insert("PI", Dynamic::from(std::f64::consts::PI));
    globals.insert("TAU", Dynamic::from(std::f64::consts::TAU));
    // What the engine is given of a name is a constant for ever. What it takes out of a shared value is a copy, which
    // may be changed, as an element of an array for example; the shared value may not.
    Ok(globals.into_iter().map(|(name, value)| (name, value.into_read_only().into_shared())).collect())
}

fn bound(engine: &mut Engine, limits: &Limits) {
    engine
        .set_max_operations(limits.operations)
        .set_max_call_levels(limits.calls.min(Limits::MOST_CALLS))
        .set_max_expr_depths(64, 48)
        .set_max_string_size(limits.text)
        .set_max_array_size(limits.elements)
        .set_max_map_size(limits.elements)
        .set_max_variables(limits.variables)
        .set_max_functions(limits.variables)
        .set_max_modules(limits.modules);
    engine.set_fail_on_invalid_map_property(true);
}

fn watch(engine: &mut Engine, host: &Rc<Host>) {
    let host = host.clone();
    engine.on_progress(move |steps| {
        if host.cancel.as_ref().is_some_and(|c| c.load(Ordering::Relaxed)) {
            return Some(Dynamic::from(Stop::Cancelled));
        }
        // A step may build a large expression, so look at the clock often, but not every time.
        let late = || host.deadline.get().is_some_and(|deadline| Instant::now() > deadline);
        (steps % 16 == 0 && late()).then(|| Dynamic::from(Stop::TimedOut))
    });
}

fn listen(engine: &mut Engine, host: &Rc<Host>) {
    /// Lines kept of what a script says.
    const LINES: usize = 10_000;
    let say = |host: &Host, text: &str| {
        let mut output = host.output.borrow_mut();
        match output.len() {
            ..LINES => output.push(text.to_owned()),
            LINES => output.push(format!("(what is said after {LINES} lines is left out)")),
            _ => {}
        }
    };
    let (first, second) = (host.clone(), host.clone());
    engine.on_print(move |text| say(&first, text));
    engine.on_debug(move |text, _, position| {
        say(&second, &position.line().map_or(text.to_owned(), |line| format!("line {line}: {text}")));
    });
}
