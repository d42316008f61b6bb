//! Texts that go back into scripts: new defaults of parameters, and cameras.

use super::lexer::{Kind, Token, tokens};
use crate::diag::Diagnostic;
use crate::scene::{Camera, Domain, Param, Projection, Value};
use glam::DVec3;
use std::ops::Range;

/// A script with a parameter's value as its default. Everything else stays as it is, byte by byte.
///
/// # Errors
/// If the script does not say the default as it is, in just one place.
pub fn with_default(text: &str, param: &Param) -> Result<String, Box<Diagnostic>> {
    let default = only(defaults(text, param), param)?;
    if !default.is_literal {
        let plain = match param.value {
            Value::Number(_) => "a plain number",
            Value::Text(_) => "a plain text",
            Value::Flag(_) => "plain true or false",
        };
        return Err(by_hand(param, &format!("its default is not {plain}")));
    }
    Ok(default.replaced(text, param))
}

/// A script of its own that has a parameter's value as its default, also in the place of what computes it: what that is made
/// of may have other defaults now.
///
/// # Errors
/// If the script does not make the parameter in just one place, and the value is not its default.
pub fn with_value(text: &str, param: &Param) -> Result<String, Box<Diagnostic>> {
    let is_same = param.value == param.default;
    match only(defaults(text, param), param) {
        Ok(default) if is_same && default.is_literal => Ok(text.to_owned()),
        Ok(default) => Ok(default.replaced(text, param)),
        Err(_) if is_same => Ok(text.to_owned()),
        Err(error) => Err(error),
    }
}

/// Where a script says a default.
struct Default {
    range: Range<usize>,
    /// Whether it is a literal of the parameter's kind.
    is_literal: bool,
}

impl Default {
    fn replaced(&self, text: &str, param: &Param) -> String {
        let Range { start, end } = self.range;
        let like = match (&param.domain, self.is_literal) {
            (_, true) => &text[start..end],
            (Domain::Number { whole: true, .. }, false) => "0",
            _ => "0.0",
        };
        format!("{}{}{}", &text[..start], literal(&param.value, like), &text[end..])
    }
}

/// The one place where a parameter is made.
fn only(mut places: Vec<Default>, param: &Param) -> Result<Default, Box<Diagnostic>> {
    match (places.pop(), places.is_empty()) {
        (Some(default), true) => Ok(default),
        (None, _) => Err(by_hand(param, "another file makes it, or its name is computed")),
        _ => Err(by_hand(param, "it is made in several places")),
    }
}

fn by_hand(param: &Param, why: &str) -> Box<Diagnostic> {
    let error = Diagnostic::error(format!("`{}` cannot be written into the script: {why}", param.name));
    Box::new(error.hint(format!("write {} there yourself", literal(&param.value, "0.0"))))
}

/// Where a script makes a parameter.
fn defaults(text: &str, param: &Param) -> Vec<Default> {
    let tokens: Vec<Token<'_>> = tokens(text).into_iter().filter(|t| t.kind != Kind::Comment).collect();
    let is_call = |w: &[Token<'_>]| {
        w[0].kind == Kind::Word
            && w[0].text == "param"
            && w[1].text == "("
            && w[2].kind == Kind::Text
            && w[2].text.trim_matches(['"', '`']) == param.name
    };
    let starts = tokens.windows(3).enumerate().filter(|(_, w)| is_call(w)).map(|(i, _)| i + 3);
    starts.filter_map(|i| argument(&tokens[i..], &param.value)).collect()
}

/// The argument after a comma.
fn argument(tokens: &[Token<'_>], like: &Value) -> Option<Default> {
    let (_, rest) = tokens.split_first().filter(|(comma, _)| comma.text == ",")?;
    let mut depth = 0;
    let is_end = |token: &Token<'_>| {
        let is_end = depth == 0 && matches!(token.text, "," | ")");
        match token.text {
            "(" | "[" | "{" | "#{" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            _ => {}
        }
        is_end
    };
    let own = &rest[..rest.iter().position(is_end)?];
    let (first, last) = (own.first()?, own.last()?);
    Some(Default { range: first.start..last.end(), is_literal: is_literal(own, like) })
}

/// Whether an argument is a literal like a value: a number with its sign, a text, or a flag.
fn is_literal(argument: &[Token<'_>], like: &Value) -> bool {
    match (argument, like) {
        ([number], Value::Number(_)) => number.kind == Kind::Number,
        ([sign, number], Value::Number(_)) => matches!(sign.text, "-" | "+") && number.kind == Kind::Number,
        // A text with expressions in it is computed.
        ([text], Value::Text(_)) => {
            text.text.starts_with('"') || text.text.starts_with('`') && !text.text.contains("${")
        }
        ([flag], Value::Flag(_)) => matches!(flag.text, "true" | "false"),
        _ => false,
    }
}

/// A value as a script says it, in the manner of a literal that is there.
fn literal(value: &Value, like: &str) -> String {
    match value {
        Value::Number(value) => number(*value, !like.contains(['.', 'e', 'E'])),
        Value::Text(text) if like.starts_with('`') && !text.contains(['`', '$']) => format!("`{text}`"),
        Value::Text(text) => format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\"")),
        Value::Flag(flag) => flag.to_string(),
    }
}

/// A number as a script says it: whole ones have a point unless they are to be integers.
fn number(value: f64, integer: bool) -> String {
    if integer && value.fract() == 0.0 { format!("{value}") } else { format!("{value:?}") }
}

/// The call that makes a camera, rounded to what matters: a ten-thousandth of its distance.
pub fn camera(camera: &Camera) -> String {
    let Camera { eye, target, up, projection } = camera;
    let unit = 1e-4 * eye.distance(*target);
    let point = |p: &DVec3| {
        let [x, y, z] = p.to_array().map(|c| rounded(c, unit));
        format!("[{x}, {y}, {z}]")
    };
    let mut options = format!("eye: {}, target: {}", point(eye), point(target));
    if *up != DVec3::Y {
        let [x, y, z] = up.to_array().map(|c| rounded(c, 1e-6));
        options += &format!(", up: [{x}, {y}, {z}]");
    }
    let call = match projection {
        Projection::Panorama => "panorama",
        Projection::CubeMap => "cube_map",
        Projection::Orthographic { height } => {
            let height = rounded(*height, 1e-4 * height);
            options += &format!(", projection: \"orthographic\", height: {height}");
            "look_at"
        }
        Projection::Perspective { fov, lens } => {
            options += &format!(", fov: {}", rounded(*fov, 1e-3));
            if let Some(lens) = lens {
                let [aperture, focus] = [lens.radius, lens.focus].map(|c| rounded(c, 1e-4 * c));
                options += &format!(", aperture: {aperture}, focus: {focus}");
            }
            "look_at"
        }
    };
    format!("{call}(#{{ {options} }})")
}

/// A number with as many digits as tell parts of a unit apart.
fn rounded(value: f64, unit: f64) -> String {
    let digits = (-libm::log10(unit.abs())).ceil().clamp(0.0, 17.0) as usize;
    let text = format!("{value:.*}", digits.max(1));
    let short = text.trim_end_matches('0');
    // -0.0 is no number to read.
    let short = if short == "-0." { "0." } else { short };
    if short.ends_with('.') { format!("{short}0") } else { short.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Domain;

    fn param(value: f64) -> Param {
        let domain = Domain::Number { least: -1.0, most: 1.0, whole: false };
        Param { name: "relief".into(), default: 0.02.into(), value: value.into(), domain }
    }

    fn text(value: &str) -> Param {
        let domain = Domain::Choice { names: vec![value.to_owned()] };
        Param { name: "style".into(), default: "a".into(), value: value.into(), domain }
    }

    #[test]
    fn a_default_is_replaced_and_nothing_else() {
        let text = "// param(\"relief\", 1, 2)\nlet r = param ( \"relief\" , -0.02 , -1.0..1.0); // é\n\"x\"";
        let new = with_default(text, &param(0.375)).unwrap();
        assert_eq!(new, text.replacen("-0.02", "0.375", 1));
        assert!(with_default(&new, &param(-1.0)).unwrap().contains(" -1.0 ,"));
        let whole = "param(\"relief\", 3, 0..9)";
        assert_eq!(with_default(whole, &param(5.0)).unwrap(), "param(\"relief\", 5, 0..9)");
        assert_eq!(with_default(whole, &param(0.5)).unwrap(), "param(\"relief\", 0.5, 0..9)");
    }

    #[test]
    fn texts_and_flags_are_written_as_they_were() {
        let choice = "param(\"style\", \"a\\\"b\", [\"a\\\"b\", \"c\"])";
        let written = with_default(choice, &text("c\\\"d")).unwrap();
        assert_eq!(written, choice.replacen("\"a\\\"b\"", "\"c\\\\\\\"d\"", 1));
        for (before, value, after) in [
            ("param(`style`, `#fff`)", "#c98f5a", "param(`style`, `#c98f5a`)"),
            ("param(\"style\", `a`, names)", "1 `", "param(\"style\", \"1 `\", names)"),
            ("param( \"style\" , /* é */ \"#fff\" )", "#000000", "param( \"style\" , /* é */ \"#000000\" )"),
        ] {
            assert_eq!(with_default(before, &text(value)).unwrap(), after);
        }
        let switch =
            Param { name: "on".into(), default: true.into(), value: false.into(), domain: Domain::Switch };
        assert_eq!(with_default("param(\"on\", true)", &switch).unwrap(), "param(\"on\", false)");
        for (script, param, why) in [
            ("param(\"style\", `${x}`, names)", text("a"), "not a plain text"),
            ("param(\"style\", \"a\" + \"b\", names)", text("a"), "not a plain text"),
            ("param(\"on\", !true)", switch.clone(), "not plain true or false"),
            ("param(\"on\", true && false)", switch, "not plain true or false"),
        ] {
            let error = with_default(script, &param).unwrap_err();
            assert!(error.message.contains(why), "{script}: {error:?}");
        }
    }

    #[test]
    fn what_cannot_be_replaced_is_said() {
        for (text, why) in [
            ("param(\"relief\", 2.0 * r, 0.0..1.0)", "not a plain number"),
            ("param(\"relief\", r, 0.0..1.0)", "not a plain number"),
            ("param(\"other\", 1.0, 0.0..1.0)", "another file"),
            ("param(\"relief\", 1.0, 0.0..1.0); param(\"relief\", 1.0, 0.0..1.0)", "several places"),
            ("param(\"relief\"", "another file"),
        ] {
            let error = with_default(text, &param(0.5)).unwrap_err();
            assert!(error.message.contains(why) && error.hints[0].contains("0.5"), "{text}: {error:?}");
        }
    }

    #[test]
    fn what_computes_a_default_gives_way_in_a_script_of_its_own() {
        for (text, value, after) in [
            ("param(\"relief\", 2.0 * f(r, [1, 2]), 0.0..1.0)", 0.5, "param(\"relief\", 0.5, 0.0..1.0)"),
            ("param(\"relief\", #{ a: r, b: 1 }.a)", 3.0, "param(\"relief\", 3.0)"),
            // What it is made of may have changed.
            ("param(\"relief\", r)", 0.0, "param(\"relief\", 0.0)"),
            ("param(\"relief\", 1.0)", 0.0, "param(\"relief\", 1.0)"),
            ("f()", 0.0, "f()"),
        ] {
            let default = Value::Number(0.0);
            assert_eq!(with_value(text, &Param { default, ..param(value) }).unwrap(), after);
        }
        let domain = Domain::Number { least: 0.0, most: 9.0, whole: true };
        assert_eq!(
            with_value("param(\"relief\", 2 * n)", &Param { domain, ..param(6.0) }).unwrap(),
            "param(\"relief\", 6)"
        );
        assert!(with_value("f()", &param(0.5)).unwrap_err().message.contains("another file"));
    }

    #[test]
    fn cameras_are_written_as_they_are_read() {
        use crate::script::{Request, compile};
        let lens = Some(crate::scene::Lens { radius: 0.01, focus: 2.5 });
        let askew = Camera { up: DVec3::new(0.1, 0.8, 0.1).normalize(), ..Camera::default() };
        for projection in [
            Projection::default(),
            Projection::Perspective { fov: 62.5, lens },
            Projection::Orthographic { height: 0.0123 },
            Projection::Panorama,
            Projection::CubeMap,
        ] {
            let text = camera(&askew.with(projection));
            let compiled = compile(&Request::text(format!("scene(#{{ surface: x, camera: {text} }})")));
            let read = compiled.scene.unwrap_or_else(|| panic!("{text}: {:?}", compiled.diagnostics)).camera;
            assert!(read.eye.distance(askew.eye) < 1e-3 && read.up.distance(askew.up) < 1e-5, "{text}");
            assert_eq!(read.projection, projection, "{text}");
        }
        assert_eq!(
            camera(&Camera::look_at(DVec3::new(0.0, 0.25, 4.0), DVec3::ZERO)),
            "look_at(#{ eye: [0.0, 0.25, 4.0], target: [0.0, 0.0, 0.0], fov: 35.0 })"
        );
    }
}
