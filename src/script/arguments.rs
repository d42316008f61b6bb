//! What the functions of the standard library take: checked where they are called, so that a message is about the call and
//! not about what became of a wrong argument inside.
//!
//! Parameters of the library are named for what they are, and so their names say what suits them: a `radius` is a number
//! from 0, or a field; `solids` are an array of fields. Where a name means something else in one module, the list says so
//! for that module. What a function asks of its arguments beyond that, it says itself.
//!
//! The check is a call in the second definition that a function has for others (see [`marks`](super::marks)): what the library
//! itself calls is not checked again.

use super::fault::{Fault, Outcome};
use super::lexer::Definition;
use super::library::{GridValue, MeshValue, advice};
use super::marks::{NATIVE, marked};
use super::noises::Source;
use super::options::describe;
use super::value::{AffineVec3, Field, Region, Vec3, VectorField, number};
use crate::num::{Affine, Interval};
use rhai::{Array, Dynamic, Engine, NativeCallContext};
use std::any::TypeId;

/// What suits a parameter.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Kind {
    /// A number.
    Number,
    /// A number or a field.
    Scalar,
    /// The same; a number is 0 or more.
    Size,
    /// The same; a number is above 0.
    Positive,
    /// A field; a number is one that is the same everywhere.
    Solid,
    /// An array of these with one at least.
    Solids,
    /// Three numbers or fields.
    Vector,
    /// The same, or one for all three.
    Each,
    /// The same of sizes.
    Sizes,
    /// An array of vectors.
    Points,
    Noise,
    Text,
    Options,
    Array,
    Region,
    Color,
    /// What `texture::load` makes of a file.
    Texture,
}

/// Names of parameters by the module that they are of, or of any other: the first that fits counts. Those that are not here
/// may be anything, or are checked by the function.
const KINDS: &[(&str, &str, Kind)] = &[
    ("algebraic", "b", Kind::Vector),
    ("algebraic", "c level", Kind::Scalar),
    ("arrange", "profile", Kind::Solid),
    ("arrange", "rise", Kind::Scalar),
    ("arrange", "step cell counts", Kind::Each),
    ("blend", "height exponent", Kind::Scalar),
    ("blend", "first second steps", Kind::Positive),
    ("blobs", "name", Kind::Text),
    ("blobs", "squared", Kind::Scalar),
    ("color", "a b", Kind::Color),
    ("convolution", "a b at", Kind::Vector),
    ("convolution", "densities", Kind::Solids),
    ("convolution", "corners", Kind::Points),
    ("csg", "distance", Kind::Scalar),
    ("deform", "bottom top factor", Kind::Scalar),
    ("deform", "spacing", Kind::Positive),
    ("deform", "box", Kind::Region),
    ("displace", "height", Kind::Scalar),
    ("displace", "at nearest", Kind::Vector),
    ("displace", "seed", Kind::Solid),
    ("flow", "radius", Kind::Positive),
    ("flow", "v", Kind::Vector),
    ("fractal", "seed", Kind::Number),
    ("material", "distance", Kind::Positive),
    ("planet", "low high", Kind::Number),
    ("options", "name", Kind::Text),
    ("options", "defaults", Kind::Options),
    ("pattern", "size length height spacing", Kind::Positive),
    ("shapes", "a b", Kind::Vector),
    ("shapes", "size radii", Kind::Sizes),
    ("terrain", "heights", Kind::Scalar),
    ("texture", "image", Kind::Texture),
    ("", "radius ring tube thickness length width outer inner straight bottom top rounding", Kind::Size),
    ("", "reach depth height size sharpness duration", Kind::Size),
    ("", "exponent alpha soft n meridian parallel", Kind::Number),
    ("", "degrees from to low high u v value scale offset share amount at begin t", Kind::Scalar),
    ("", "squared seed threshold wet roughness", Kind::Scalar),
    ("", "a b f solid ground", Kind::Solid),
    ("", "solids", Kind::Solids),
    ("", "normal axis up center by", Kind::Vector),
    ("", "points", Kind::Points),
    ("", "corners stops list handles rows", Kind::Array),
    ("", "noise", Kind::Noise),
    ("", "options given", Kind::Options),
    ("", "file", Kind::Text),
];

impl Kind {
    fn of(module: &str, parameter: &str) -> Option<Kind> {
        let is_it = |(of, names, _): &&(&str, &str, Kind)| {
            (of.is_empty() || *of == module) && names.split(' ').any(|name| name == parameter)
        };
        KINDS.iter().find(is_it).map(|(_, _, kind)| *kind)
    }

    /// What is wrong with a value, as what it must be; nothing if it suits.
    fn wants(self, v: &Dynamic) -> Option<&'static str> {
        match self {
            Kind::Scalar => (!is_scalar(v)).then_some("a number or a field"),
            Kind::Number => (!number(v).is_some_and(f64::is_finite)).then_some("a number"),
            Kind::Size => sized(v, "a number or a field", "0 or more", |size| size >= 0.0),
            Kind::Positive => sized(v, "a number or a field", "above 0", |size| size > 0.0),
            Kind::Solid => (!is_scalar(v)).then_some("a field, such as sphere(1.0)"),
            Kind::Solids => {
                let are_solids = all(v, is_scalar).is_some_and(|count| count > 0);
                (!are_solids).then_some("an array of fields, such as [sphere(1.0), box(1.5)]")
            }
            Kind::Vector => (!is_vector(v)).then_some("a vector such as [0, 1, 0]"),
            Kind::Each => {
                (!is_vector(v) && !is_scalar(v)).then_some("a number, or a vector such as [1, 2, 1]")
            }
            Kind::Sizes => {
                let wanted = "a number, or a vector such as [1, 2, 1]";
                match parts(v) {
                    Some(parts) => parts.iter().find_map(|part| {
                        sized(part, wanted, "0 or more along every axis", |size| size >= 0.0)
                    }),
                    None if v.is::<VectorField>() => None,
                    None => sized(v, wanted, "0 or more", |size| size >= 0.0),
                }
            }
            Kind::Points => all(v, is_vector).is_none().then_some("an array of points such as [0, 1, 0]"),
            Kind::Noise => (!v.is::<Source>()).then_some("a noise such as gradient(7)"),
            Kind::Text => (!v.is_string()).then_some("a text"),
            Kind::Options => (!v.is_map()).then_some("an object map, #{ ... }"),
            Kind::Array => (!v.is_array()).then_some("an array"),
            Kind::Region => (!v.is::<Region>()).then_some("a box such as region(2.0)"),
            Kind::Color => {
                let is_color = is_scalar(v) || is_vector(v) || v.is_string();
                (!is_color).then_some("a colour such as rgb(\"#ff8000\")")
            }
            Kind::Texture => (!v.is_map()).then_some("a texture: texture::load(\"hills.png\")"),
        }
    }
}

/// Whether a value is a field, or a number that is finite.
fn is_scalar(v: &Dynamic) -> bool {
    number(v).map_or_else(|| is_field(v), f64::is_finite)
}

fn is_field(v: &Dynamic) -> bool {
    let is_made = v.is::<Source>() || v.is::<GridValue>() || v.is::<MeshValue>();
    // What takes no field of its own is arithmetic for enclosures as well.
    v.is::<Field>() || is_made || v.is::<Interval>() || v.is::<Affine>()
}

fn is_vector(v: &Dynamic) -> bool {
    let is_enclosure = v.is::<Region>() || v.is::<AffineVec3>();
    v.is::<VectorField>() || is_enclosure || parts(v).is_some_and(|parts| parts.iter().all(is_scalar))
}

/// Whether a value is a number that is none, or a vector with one.
fn is_infinite(v: &Dynamic) -> bool {
    let is_none = |v: &Dynamic| number(v).is_some_and(|value| !value.is_finite());
    is_none(v) || parts(v).is_some_and(|parts| parts.iter().any(is_none))
}

/// The three parts of a vector that is not made of fields alone.
fn parts(v: &Dynamic) -> Option<[Dynamic; 3]> {
    if let Some(v) = v.read_lock::<Vec3>() {
        return Some(v.0.map(Dynamic::from_float));
    }
    let array = v.read_lock::<Array>()?;
    let [a, b, c] = array.as_slice() else { return None };
    Some([a, b, c].map(Dynamic::clone))
}

/// How many elements an array has, if all are of a kind.
fn all(v: &Dynamic, is_one: impl Fn(&Dynamic) -> bool) -> Option<usize> {
    v.read_lock::<Array>().filter(|array| array.iter().all(is_one)).map(|array| array.len())
}

/// What is wrong with a number or a field: what it is, or how large.
fn sized(
    v: &Dynamic,
    wanted: &'static str,
    size: &'static str,
    is_large: impl Fn(f64) -> bool,
) -> Option<&'static str> {
    match number(v) {
        Some(value) if value.is_finite() => (!is_large(value)).then_some(size),
        _ => (!is_field(v)).then_some(wanted),
    }
}

/// The name of the check, which no script has.
fn check_name() -> Option<String> {
    marked("suits", NATIVE)
}

/// A call that checks what a function of a module of the library is given; nothing if all suits it.
pub fn check(module: &str, function: &Definition) -> String {
    let kinds = function.parameters.iter().map(|name| Kind::of(module, name));
    let Some(check) = check_name().filter(|_| kinds.clone().any(|kind| kind.is_some())) else {
        return String::new();
    };
    let parameters = function.parameters.join(", ");
    format!("{check}(\"{module}\", \"{}\", \"{parameters}\", {parameters}); ", function.name)
}

/// Parameters of a function at most.
const MOST: usize = 8;

/// Lets modules of the library call the check.
pub fn register(engine: &mut Engine) {
    let Some(name) = check_name() else { return };
    for count in 1..=MOST {
        let types = vec![TypeId::of::<Dynamic>(); 3 + count];
        engine.register_raw_fn(
            &name,
            types,
            |_: NativeCallContext<'_>, args: &mut [&mut Dynamic]| -> Result<(), Box<rhai::EvalAltResult>> {
                let [module, function, names] = [0, 1, 2].map(|i| args[i].to_string());
                Ok(suit(&module, &function, &names, &args[3..])?)
            },
        );
    }
}

/// Whether arguments suit the parameters of a function.
fn suit(module: &str, function: &str, names: &str, given: &[&mut Dynamic]) -> Outcome<()> {
    for (i, (name, given)) in names.split(", ").zip(given).enumerate() {
        let Some(wanted) = Kind::of(module, name).and_then(|kind| kind.wants(given)) else { continue };
        let wanted = if is_infinite(given) { "finite" } else { wanted };
        let message = format!("`{name}` of `{function}` must be {wanted}, not {}", shown(given));
        let fault = Fault::new(message).label(format!("{wanted} expected")).argument(i);
        return Err(match advice(given, wanted) {
            Some(advice) => fault.hint(advice),
            None => fault,
        });
    }
    Ok(())
}

/// A value in a message: vectors of numbers by these.
fn shown(v: &Dynamic) -> String {
    let numbers = parts(v).and_then(|parts| {
        let [a, b, c] = parts.each_ref().map(number);
        Some([a?, b?, c?])
    });
    match (numbers, number(v)) {
        (Some([a, b, c]), _) => format!("[{a}, {b}, {c}]"),
        (_, Some(value)) => value.to_string(),
        _ => describe(v),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::script::lexer::definitions;
    use crate::script::modules::STD;

    /// Names that say nothing of their own accord, and are checked where they are used.
    const FREE: [&str; 3] = ["sides", "count", "profile"];

    #[test]
    fn every_parameter_of_the_library_is_of_a_kind() {
        for (module, text) in STD {
            for function in definitions(text).iter().filter(|function| !function.is_private) {
                assert!(function.parameters.len() <= MOST);
                for name in function.parameters.iter().filter(|name| !FREE.contains(&name.as_str())) {
                    assert!(Kind::of(module, name).is_some(), "{module}::{}: {name}", function.name);
                }
            }
        }
    }

    #[test]
    fn every_kind_of_parameter_is_one_of_the_library() {
        for (module, names, _) in KINDS {
            for name in names.split(' ') {
                let has =
                    |text: &str| definitions(text).iter().any(|f| f.parameters.iter().any(|p| p == name));
                let mut modules = STD.iter().filter(|(own, _)| module.is_empty() || own == module);
                assert!(modules.any(|(_, text)| has(text)), "{module}: {name}");
            }
        }
    }
}
