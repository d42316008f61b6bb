//! Parameters: numbers, colours, names and switches that the user of a script sets.

use super::{Call, Library, interval_of};
use crate::diag::{self, Diagnostic};
use crate::num::srgb;
use crate::scene::{Domain, Param, Unfit, Value};
use crate::script::fault::{Fault, Outcome};
use crate::script::host::{Host, Preset};
use crate::script::value::number;
use rhai::{Array, Dynamic};

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
    lib.def(
        "preset(name, value)",
        "Another default for a parameter that is made later: in a module that is imported then, or from other values. Of several the first holds, and what the user sets goes before all.",
        "preset(\"craters\", 12); let craters = param(\"craters\", 5, 0..20);",
        preset,
    );
}

/// A default that is there before its parameter.
fn preset(c: &Call<'_>) -> Outcome<Dynamic> {
    let name = name_of(c)?;
    let value = match (c.args[1].as_bool(), number(&c.args[1])) {
        (Ok(flag), _) => Value::Flag(flag),
        (_, Some(number)) => Value::Number(number),
        _ => Value::Text(c.text(1).map_err(|_| c.wrong(1, "a number, a text, true or false"))?),
    };
    if c.host.params.borrow().iter().any(|p| p.name == name) {
        return Err(Fault::new(format!("the parameter `{name}` is there already"))
            .hint("preset it before it is made: above the import or the call that makes it"));
    }
    let preset = Preset { value, place: c.place.clone() };
    c.host.presets.borrow_mut().entry(name).or_insert(preset);
    Ok(Dynamic::UNIT)
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
    let name = name_of(c)?;
    let admit = |value: &Value| {
        domain
            .admit(value)
            .map_err(|unfit| allowed(Fault::new(format!("`{name}` is {unfit}")), &domain, unfit))
    };
    let default = match c.host.presets.borrow().get(&name) {
        None => default,
        Some(preset) => admit(&preset.value).map_err(|fault| fault.at(preset.place.clone()))?,
    };
    let value = c.host.set.get(&name).map(admit).transpose()?.unwrap_or_else(|| default.clone());
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

/// The name of a parameter.
fn name_of(c: &Call<'_>) -> Outcome<String> {
    let name = c.text(0)?;
    if name.is_empty() || !name.chars().all(|ch| ch.is_alphanumeric() || ch == '_') {
        return Err(Fault::new(format!("`{name}` is no name for a parameter"))
            .hint("it is made of letters, digits and underscores, so that --set can say it"));
    }
    Ok(name)
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

/// Complaints of names set by the user, and of presets, that the script never asked for.
pub fn unused(host: &Host) -> Vec<Diagnostic> {
    let (params, presets) = (host.params.borrow(), host.presets.borrow());
    let known = || params.iter().map(|p| p.name.as_str());
    let is_unknown = |name: &str| !known().any(|k| k == name);
    let remedy = |d: Diagnostic, name: &str| match diag::nearest(name, known()) {
        Some(near) => d.hint(format!("did you mean `{near}`?")),
        None if params.is_empty() => {
            d.hint("it has none at all; they are made with param(name, default, range)")
        }
        None => d.hint(format!("its parameters are {}", known().collect::<Vec<_>>().join(", "))),
    };
    let message = |name: &str| format!("the script has no parameter `{name}`");
    let set = host.set.keys().filter(|name| host.strict && is_unknown(name));
    let errors = set.map(|name| remedy(Diagnostic::error(message(name)), name));
    let preset = presets.iter().filter(|(name, _)| is_unknown(name));
    let warnings = preset
        .map(|(name, preset)| remedy(Diagnostic::warning(message(name)).at(preset.place.clone()), name));
    errors.chain(warnings).collect()
}
