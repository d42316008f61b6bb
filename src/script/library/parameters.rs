//! Parameters: numbers, colours, names and switches that the user of a script sets.

use super::{Call, Library, interval_of};
use crate::diag;
use crate::num::srgb;
use crate::scene::{Domain, Param, Unfit, Value};
use crate::script::fault::{Fault, Outcome};
use crate::script::value::number;
use rhai::{Array, Dynamic};
use std::collections::BTreeMap;

pub(super) fn register(lib: &mut Library<'_>) {
    lib.def(
        "param(name, default, range)",
        "A number that the user turns: a slider in the preview, `--set name=value` on the command line. It is whole if its default is.",
        "let relief = param(\"relief\", 0.02, 0.0..0.1);",
        |c| if c.args[2].is_array() || c.args[1].is_string() { choice(c) } else { numeric(c) },
    );
    lib.document(
        "param",
        "param(name, default, names)",
        "One of some names, a text: a list in the preview, `--set name=ridged` on the command line.",
        "let style = param(\"style\", \"ridged\", [\"ridged\", \"billow\", \"plain\"]);",
    );
    lib.def(
        "param(name, color)",
        "A colour that the user picks, a text `#rrggbb`: `--set name=#c98f5a` on the command line.",
        "let tint = param(\"tint\", \"#c98f5a\");",
        lone,
    );
    lib.document(
        "param",
        "param(name, on)",
        "A switch, true or false: `--set name=on` or `--set name=off` on the command line.",
        "let moons = param(\"moons\", true);",
    );
}

/// A number with a range.
fn numeric(c: &Call<'_>) -> Outcome<Dynamic> {
    let default = c.number(1)?;
    let range = interval_of(&c.args[2]).filter(|r| r.is_finite());
    let range = range.ok_or_else(|| c.wrong(2, "a range such as 0.0..0.1"))?;
    let whole = c.args[1].is_int();
    let (least, most) = if whole { (range.lo.ceil(), range.hi.floor()) } else { (range.lo, range.hi) };
    let domain = Domain::Number { least, most, whole };
    if !range.contains(default) {
        return Err(Fault::new(format!("the default of `{}` lies outside its range: {default}", c.text(0)?))
            .label(format!("{domain} allowed")));
    }
    parameter(c, default.into(), domain)
}

/// A name with those that there are.
fn choice(c: &Call<'_>) -> Outcome<Dynamic> {
    let (name, default) = (c.text(0)?, c.text(1)?);
    let list = c.args[2].read_lock::<Array>().map(|list| list.clone());
    let texts = list.and_then(|list| list.into_iter().map(|v| v.into_string().ok()).collect());
    let names: Vec<String> = texts.ok_or_else(|| c.wrong(2, "names such as [\"ridged\", \"plain\"]"))?;
    for (i, one) in names.iter().enumerate() {
        if one.is_empty() || one.trim() != one || one.contains(char::is_control) {
            return Err(Fault::new(format!("{one:?} is no name to choose"))
                .hint("it is a line of text without blanks around it, so that --set can say it"));
        }
        if names[..i].contains(one) {
            return Err(Fault::new(format!("`{name}` has {one:?} twice")));
        }
    }
    let domain = Domain::Choice { names };
    match domain.admit(&Value::Text(default.clone())) {
        Ok(default) => parameter(c, default, domain),
        Err(unfit) => {
            let fault = Fault::new(format!("the default of `{name}` is none of its names: {default:?}"));
            Err(allowed(fault, &domain, unfit))
        }
    }
}

/// A default that says by itself what is allowed: a colour, or a switch.
fn lone(c: &Call<'_>) -> Outcome<Dynamic> {
    if let Ok(flag) = c.args[1].as_bool() {
        return parameter(c, flag.into(), Domain::Switch);
    }
    let name = c.text(0)?;
    if number(&c.args[1]).is_some() {
        return Err(Fault::new(format!("the number `{name}` has no range"))
            .hint(format!("say from where to where it goes: param({name:?}, 0.5, 0.0..1.0)")));
    }
    let wanted = "a colour such as \"#ff8800\", true or false";
    let text = c.text(1).map_err(|_| c.wrong(1, wanted))?;
    let color = srgb::from_hex(&text).map(srgb::to_hex).ok_or_else(|| {
        Fault::new(format!("{text:?} is not a colour"))
            .hint("write \"#rrggbb\" with hexadecimal digits, such as \"#ff8800\"")
            .hint(format!("for another text, list all that there are: param({name:?}, {text:?}, [{text:?}])"))
    })?;
    parameter(c, Value::Text(color), Domain::Color)
}

/// Adds a parameter. Gives the value that the user set, or its default.
fn parameter(c: &Call<'_>, default: Value, domain: Domain) -> Outcome<Dynamic> {
    let name = c.text(0)?;
    if name.is_empty() || !name.chars().all(|ch| ch.is_alphanumeric() || ch == '_') {
        return Err(Fault::new(format!("`{name}` is no name for a parameter"))
            .hint("it is made of letters, digits and underscores, so that --set can say it"));
    }
    let value = match c.host.set.get(&name) {
        None => default.clone(),
        Some(set) => domain
            .admit(set)
            .map_err(|unfit| allowed(Fault::new(format!("`{name}` is {unfit}")), &domain, unfit))?,
    };
    let result = dynamic(&value, &domain);
    let param = Param { name, default, value, domain };
    let mut params = c.host.params.borrow_mut();
    match params.iter().find(|p| p.name == param.name) {
        Some(same) if *same == param => {}
        Some(_) => {
            return Err(Fault::new(format!("there is another parameter `{}`", param.name))
                .hint("one name is one slider: give the same default and range, or another name"));
        }
        None => params.push(param),
    }
    Ok(result)
}

/// A fault with what would be right instead.
fn allowed(fault: Fault, domain: &Domain, unfit: Unfit) -> Fault {
    let fault = fault.label(format!("{domain} allowed"));
    match unfit.nearest {
        Some(name) => fault.hint(format!("did you mean `{name}`?")),
        None => fault,
    }
}

/// A value as scripts have it.
fn dynamic(value: &Value, domain: &Domain) -> Dynamic {
    match (value, domain) {
        (Value::Number(number), Domain::Number { whole: true, .. }) => Dynamic::from_int(*number as i64),
        (Value::Number(number), _) => Dynamic::from_float(*number),
        (Value::Flag(flag), _) => Dynamic::from_bool(*flag),
        (Value::Text(text), _) => text.clone().into(),
    }
}

/// The names set by the user that the script never asked for.
pub fn unused(set: &BTreeMap<String, Value>, params: &[Param]) -> Vec<diag::Diagnostic> {
    let known = || params.iter().map(|p| p.name.as_str());
    set.keys()
        .filter(|name| !known().any(|k| k == *name))
        .map(|name| {
            let d = diag::Diagnostic::error(format!("the script has no parameter `{name}`"));
            match diag::nearest(name, known()) {
                Some(near) => d.hint(format!("did you mean `{near}`?")),
                None if params.is_empty() => {
                    d.hint("it has none at all; they are made with param(name, default, range)")
                }
                None => d.hint(format!("its parameters are {}", known().collect::<Vec<_>>().join(", "))),
            }
        })
        .collect()
}
