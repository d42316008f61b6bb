//! The native functions of scripts, each declared once: signature, documentation, example, meaning.
//!
//! From the declarations come the registration in the engine, the REPL's help and completion, the
//! signatures in error messages, and the reference. Arguments arrive untyped and are converted by
//! [`Call`], whose errors name types as scripts do.

mod air;
mod algebra;
mod camera;
mod color;
mod components;
mod fields;
mod files;
mod film;
mod flow;
mod grid;
mod grid_files;
mod grid_store;
mod keyframes;
mod light;
mod material;
mod mesh;
mod noise;
mod numbers;
mod parameters;
mod polynomial;
mod scene;
mod shape;
mod surroundings;
mod vectors;
mod walk;

pub use components::Corrected;
pub use grid::GridValue;
pub use mesh::MeshValue;
pub use parameters::unused;
pub use scene::SceneValue;
pub use surroundings::{MoonValue, SeaValue};

use super::fault::{Fault, Outcome};
use super::host::Host;
use super::marks::{Function, NATIVE, marked};
use super::modules::Resolver;
use super::noises::Source;
use super::options::describe;
use super::value::{Field, Scalar, Value, number};
use crate::diag::Place;
use crate::num::Interval;
use glam::DVec3;
use rhai::{Dynamic, Engine, INT, NativeCallContext};
use std::any::TypeId;
use std::collections::HashSet;
use std::rc::Rc;
use std::sync::Arc;
use std::time::Instant;

/// A line of the reference.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Entry {
    /// Name in scripts, with its module: `fractal::ridged`.
    pub name: String,
    /// How it is called.
    pub signature: String,
    /// One or more sentences.
    pub doc: String,
    /// A line of script that uses it; may be empty.
    pub example: String,
    /// Heading under which it belongs.
    pub group: String,
}

/// Collects native functions.
pub struct Library<'a> {
    engine: &'a mut Engine,
    host: Rc<Host>,
    folder: &'a Resolver,
    entries: Vec<Entry>,
    group: &'static str,
    /// Functions of arguments of any type, and names that have others as well.
    bound: Vec<Function>,
    typed: HashSet<String>,
}

/// Names that the engine itself has for some types, which others would not find by a mark.
const OVERLOADED: [&str; 5] = ["abs", "max", "min", "range", "sign"];

/// Declares the functions under one heading.
type Group = fn(&mut Library<'_>);

/// Registers everything and returns what there is; files are read in `folder`.
pub fn register(engine: &mut Engine, host: &Rc<Host>, folder: &Resolver) -> Vec<Entry> {
    let (entries, bound) = (Vec::new(), Vec::new());
    let mut library =
        Library { engine, host: host.clone(), folder, entries, group: "", bound, typed: HashSet::new() };
    let groups: [(&'static str, Group); 24] = [
        ("Operations", algebra::register),
        ("Numbers", numbers::register),
        ("Parameters", parameters::register),
        ("Vectors", vectors::register),
        ("Fields", fields::register),
        ("Polynomials", polynomial::register),
        ("Noise", noise::register),
        ("Flows", flow::register),
        ("Grids", grid::register),
        ("Meshes", mesh::register),
        ("Shapes made of data", shape::register),
        ("Files", files::register),
        ("Files", grid_files::register),
        ("Colour", color::register),
        ("Components", components::register),
        ("Cameras", camera::register),
        ("Cameras", walk::register),
        ("Cameras", keyframes::register),
        ("Light and materials", light::register),
        ("Light and materials", material::register),
        ("Scenes", film::register),
        ("Scenes", surroundings::register),
        ("Scenes", scene::register),
        ("Scenes", air::register),
    ];
    for (name, group) in groups {
        library.group = name;
        group(&mut library);
    }
    let Library { entries, bound, typed, .. } = library;
    let is_marked = |(name, _): &Function| !typed.contains(name) && !OVERLOADED.contains(&name.as_str());
    folder.loaded.learn_native(bound.into_iter().filter(is_marked));
    entries
}

impl Library<'_> {
    /// Declares a function. Its name and number of arguments are read off the signature,
    /// `name(first, second) -> result`.
    pub fn def(
        &mut self,
        signature: &str,
        doc: &str,
        example: &str,
        f: impl Fn(&Call<'_>) -> Outcome<Dynamic> + 'static,
    ) {
        let (name, rest) = signature.split_once('(').unwrap_or((signature, ")"));
        let params = rest.split_once(')').map_or("", |(params, _)| params);
        let arity = if params.trim().is_empty() { 0 } else { params.split(',').count() };
        self.bind(name, arity, f);
        self.document(name, signature, doc, example);
    }

    /// Adds to the reference only.
    pub fn document(&mut self, name: &str, signature: &str, doc: &str, example: &str) {
        self.entries.push(Entry {
            name: name.to_owned(),
            signature: signature.to_owned(),
            doc: doc.to_owned(),
            example: example.to_owned(),
            group: self.group.to_owned(),
        });
    }

    /// Binds a name with a number of arguments of any type.
    pub fn bind(&mut self, name: &str, arity: usize, f: impl Fn(&Call<'_>) -> Outcome<Dynamic> + 'static) {
        let (any, f) = (vec![TypeId::of::<Dynamic>(); arity], Rc::new(f));
        if let Some(marked) = marked(name, NATIVE) {
            let f = f.clone();
            self.register(&marked, name, &any, move |call| f(call));
            self.bound.push((name.to_owned(), arity));
        }
        self.register(name, name, &any, move |call| f(call));
    }

    /// Binds a name with arguments of given types, which goes before arguments of any type.
    pub fn bind_typed(
        &mut self,
        name: &str,
        types: impl AsRef<[TypeId]>,
        f: impl Fn(&Call<'_>) -> Outcome<Dynamic> + 'static,
    ) {
        self.typed.insert(name.to_owned());
        self.register(name, name, types, f);
    }

    /// Binds a name, and says what it is called in messages.
    fn register(
        &mut self,
        name: &str,
        shown: &str,
        types: impl AsRef<[TypeId]>,
        f: impl Fn(&Call<'_>) -> Outcome<Dynamic> + 'static,
    ) {
        let host = self.host.clone();
        let shown = shown.to_owned();
        self.engine.register_raw_fn(
            name,
            types,
            move |ctx: NativeCallContext<'_>, args: &mut [&mut Dynamic]| {
                let args: Vec<Dynamic> = args.iter().map(|a| a.flatten_clone()).collect();
                let call = Call { host: &host, name: &shown, place: place_of(&ctx), args: &args };
                let (start, before) = (Instant::now(), host.graph.borrow().len());
                let mut result = host.unless_stopped(&shown, start, f(&call))?;
                call.remember(&mut result, before);
                Ok(result)
            },
        );
    }

    /// Gives a type a name in the engine's own messages.
    pub fn name_type<T: Clone + 'static>(&mut self, name: &str) {
        self.engine.register_type_with_name::<T>(name);
    }

    /// A property of a type, `value.name`.
    pub fn property<T: Clone + 'static>(
        &mut self,
        name: &'static str,
        f: impl Fn(&Host, &T) -> Outcome<Dynamic> + 'static,
    ) {
        let host = self.host.clone();
        self.engine
            .register_get(name, move |v: &mut T| f(&host, v).map_err(Box::<rhai::EvalAltResult>::from));
    }
}

fn place_of(ctx: &NativeCallContext<'_>) -> Option<Place> {
    let position = ctx.call_position();
    Some(Place {
        file: Arc::from(ctx.call_source().unwrap_or("")),
        line: position.line()? as u32,
        column: position.position().unwrap_or(1) as u32,
        width: 1,
    })
}

/// A call of a native function.
pub struct Call<'a> {
    /// What functions share.
    pub host: &'a Host,
    /// The function's name.
    pub name: &'a str,
    /// Where it is called, if that is in a script.
    pub place: Option<Place>,
    /// Its arguments.
    pub args: &'a [Dynamic],
}

impl Call<'_> {
    /// Argument `i` is of a wrong type.
    pub fn wrong(&self, i: usize, wanted: &str) -> Fault {
        let given = describe(&self.args[i]);
        let which = match self.args.len() {
            1 => "the argument".to_owned(),
            _ => format!("argument {}", i + 1),
        };
        let fault = Fault::new(if is_operator(self.name) {
            format!("`{}` takes {wanted}, not {given}", self.name)
        } else {
            format!("{which} of `{}` must be {wanted}, not {given}", self.name)
        });
        match advice(&self.args[i], wanted) {
            Some(advice) => fault.hint(advice),
            None => fault,
        }
    }

    /// Argument `i` for arithmetic of any kind.
    pub fn value(&self, i: usize) -> Outcome<Value> {
        let wanted = "a number, a field or a vector";
        Value::of(self.host, &self.args[i])?.ok_or_else(|| self.wrong(i, wanted))
    }

    /// A finite number; a function of time alone is what it is at the time of the run.
    pub fn number(&self, i: usize) -> Outcome<f64> {
        let given = &self.args[i];
        let now = match given.read_lock::<Field>() {
            Some(field) => self.host.now(field.node)?,
            None => number(given),
        };
        let v = now.ok_or_else(|| self.wrong(i, "a number"))?;
        if v.is_finite() { Ok(v) } else { Err(self.wrong(i, "a finite number")) }
    }

    /// A whole number.
    pub fn integer(&self, i: usize) -> Outcome<INT> {
        self.args[i].as_int().map_err(|_| self.wrong(i, "a whole number"))
    }

    /// A text.
    pub fn text(&self, i: usize) -> Outcome<String> {
        self.args[i].clone().into_string().map_err(|_| self.wrong(i, "a text"))
    }

    /// A field; numbers and noises become one.
    pub fn field(&self, i: usize) -> Outcome<Field> {
        self.field_of(&self.args[i])?.ok_or_else(|| self.wrong(i, "a field"))
    }

    /// The field that a value is, if it is one.
    pub fn field_of(&self, v: &Dynamic) -> Outcome<Option<Field>> {
        match Value::of(self.host, v)? {
            Some(Value::Scalar(s, color)) if s.interval().is_none() || s.number().is_some() => {
                Ok(Some(Field { node: s.node(self.host)?, color }))
            }
            _ => Ok(None),
        }
    }

    /// A vector of expressions.
    pub fn nodes(&self, i: usize) -> Outcome<[crate::expr::NodeId; 3]> {
        match self.value(i)? {
            Value::Vector([a, b, c]) => Ok([a.node(self.host)?, b.node(self.host)?, c.node(self.host)?]),
            Value::Scalar(..) => Err(self.wrong(i, "a vector")),
        }
    }

    /// A vector of numbers, or of functions of time alone, which are what they are at the time of the run.
    pub fn vec3(&self, i: usize) -> Outcome<DVec3> {
        let wanted = "a vector of numbers such as vec3(0, 1, 0) or [0, 1, 0]";
        self.vec3_of(&self.args[i])?.ok_or_else(|| self.wrong(i, wanted))
    }

    /// The vector of numbers that a value is, if it is one.
    pub fn vec3_of(&self, v: &Dynamic) -> Outcome<Option<DVec3>> {
        Ok(match Value::of(self.host, v)? {
            Some(Value::Vector([a, b, c])) => match (self.now(&a)?, self.now(&b)?, self.now(&c)?) {
                (Some(a), Some(b), Some(c)) => Some(DVec3::new(a, b, c)),
                _ => None,
            },
            _ => None,
        })
    }

    /// The number that a part of a vector is.
    fn now(&self, part: &Scalar) -> Outcome<Option<f64>> {
        match part {
            Scalar::Field(node) => self.host.now(*node),
            _ => Ok(part.number()),
        }
    }

    /// A noise.
    pub fn source(&self, i: usize) -> Outcome<Source> {
        let found = self.args[i].read_lock::<Source>().map(|s| s.clone());
        found.ok_or_else(|| self.wrong(i, "a noise such as gradient(7)"))
    }

    /// Records where the result was made, and whatever was made for it since there were so many nodes.
    fn remember(&self, result: &mut Dynamic, before: usize) {
        let Some(place) = &self.place else { return };
        self.host.set_places(before, place);
        if let Some(mut source) = result.write_lock::<Source>() {
            source.set_place(place);
        } else if let Some(field) = result.read_lock::<Field>() {
            let colors = field.color.into_iter().flatten();
            colors.chain([field.node]).for_each(|node| self.host.set_place(node, place));
        } else if let Some(v) = result.read_lock::<super::value::VectorField>() {
            v.0.iter().for_each(|&node| self.host.set_place(node, place));
        }
    }
}

/// The interval that a value is: an interval, an integer range, or a number.
pub fn interval_of(v: &Dynamic) -> Option<Interval> {
    let ends = if let Some(i) = v.read_lock::<Interval>() {
        return Some(*i);
    } else if let Some(r) = v.read_lock::<std::ops::Range<INT>>() {
        (r.start as f64, r.end as f64)
    } else if let Some(r) = v.read_lock::<std::ops::RangeInclusive<INT>>() {
        (*r.start() as f64, *r.end() as f64)
    } else {
        let c = number(v)?;
        (c, c)
    };
    (ends.0 <= ends.1).then(|| Interval::new(ends.0, ends.1))
}

/// What to do about a value where something else is wanted.
pub fn advice(given: &Dynamic, wanted: &str) -> Option<&'static str> {
    let is_pair = given.read_lock::<rhai::Array>().is_some_and(|array| array.len() == 2);
    match () {
        () if given.is::<Corrected>() => {
            Some("correct last: colour, move and combine before, and end with largest_component(f)")
        }
        () if given.is_char() => Some("a text is in double quotes: \"A\""),
        () if is_pair && wanted.contains("vector") => Some("a vector has three parts: [1, 2, 0]"),
        () => None,
    }
}

/// Whether a name is an operator.
pub fn is_operator(name: &str) -> bool {
    !name.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::script::engine::{self, Limits};
    use crate::script::marks::plain;
    use crate::world::Memory;
    use std::collections::BTreeMap;

    /// Also where the engine has functions of its own for some types.
    #[test]
    fn marked_calls_are_of_the_same_functions() {
        let host = Host::new(&Limits::default(), BTreeMap::new(), 0.0);
        let resolver = |loaded| Resolver { world: Arc::new(Memory::default()), loaded };
        let setup = engine::setup(host, resolver, &Limits::default(), None).map_err(|_| "broken").unwrap();
        let said = |call: String| match setup.engine.eval::<Dynamic>(&call) {
            Ok(value) => format!("{} {value:?}", value.type_name()),
            Err(error) => plain(&error.to_string()),
        };
        let is_marked = |name: &str| name != "field" && !OVERLOADED.contains(&name);
        let (mut count, mut other) = (0, Vec::new());
        for Entry { name, signature, .. } in setup.entries.iter().filter(|entry| is_marked(&entry.name)) {
            let Some(marked) = marked(name, NATIVE) else { continue };
            let arity = crate::script::lexer::parameters(signature.split(')').next().unwrap_or_default());
            for argument in ["1", "-2.5", "\"a\"", "[1, 2]", "#{}"] {
                let call = |name: &str| said(format!("{name}({})", vec![argument; arity].join(", ")));
                let (plainly, by_mark) = (call(name), call(&marked));
                other
                    .extend((plainly != by_mark).then(|| format!("{name} {argument}: {plainly}, {by_mark}")));
                count += 1;
            }
        }
        assert!(other.is_empty() && count > 500, "{count}, {other:#?}");
    }
}
