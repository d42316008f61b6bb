//! Texts that go back into scripts: new defaults of parameters, and cameras.

use super::lexer::{Kind, Token, tokens};
use crate::diag::Diagnostic;
use crate::scene::{Camera, Param, Projection, Value};
use glam::DVec3;
use std::ops::Range;

/// A script with a parameter's value as its default. Everything else stays as it is, byte by byte.
///
/// # Errors
/// If the script does not say the default as it is, in just one place.
pub fn with_default(text: &str, param: &Param) -> Result<String, Box<Diagnostic>> {
    let calls = defaults(text, param);
    match calls.as_slice() {
        [Some(range)] => {
            let value = literal(&param.value, &text[range.clone()]);
            Ok(format!("{}{value}{}", &text[..range.start], &text[range.end..]))
        }
        [None] => {
            let plain = match param.value {
                Value::Number(_) => "a plain number",
                Value::Text(_) => "a plain text",
                Value::Flag(_) => "plain true or false",
            };
            Err(by_hand(param, &format!("its default is not {plain}")))
        }
        [] => Err(by_hand(param, "another file makes it, or its name is computed")),
        _ => Err(by_hand(param, "it is made in several places")),
    }
}

fn by_hand(param: &Param, why: &str) -> Box<Diagnostic> {
    let error = Diagnostic::error(format!("`{}` cannot be written into the script: {why}", param.name));
    Box::new(error.hint(format!("write {} there yourself", literal(&param.value, "0.0"))))
}

/// Where a script makes a parameter: the bytes of each default that is a literal of its kind.
fn defaults(text: &str, param: &Param) -> Vec<Option<Range<usize>>> {
    let tokens: Vec<Token<'_>> = tokens(text).into_iter().filter(|t| t.kind != Kind::Comment).collect();
    let is_call = |w: &[Token<'_>]| {
        w[0].kind == Kind::Word
            && w[0].text == "param"
            && w[1].text == "("
            && w[2].kind == Kind::Text
            && w[2].text.trim_matches(['"', '`']) == param.name
    };
    let starts = tokens.windows(3).enumerate().filter(|(_, w)| is_call(w)).map(|(i, _)| i + 3);
    starts.map(|i| argument(&tokens[i..], &param.value)).collect()
}

/// The literal after a comma that is a whole argument, if it is one like a value: a number with its sign, a text, or
/// a flag.
fn argument(tokens: &[Token<'_>], like: &Value) -> Option<Range<usize>> {
    let mut rest = tokens.iter();
    rest.next().filter(|t| t.text == ",")?;
    let first = rest.next()?;
    let last = match like {
        Value::Number(_) if matches!(first.text, "-" | "+") => rest.next()?,
        _ => first,
    };
    let fits = match like {
        Value::Number(_) => last.kind == Kind::Number,
        // A text with expressions in it is computed.
        Value::Text(_) => {
            last.text.starts_with('"') || last.text.starts_with('`') && !last.text.contains("${")
        }
        Value::Flag(_) => matches!(last.text, "true" | "false"),
    };
    let is_whole = rest.next().is_some_and(|t| matches!(t.text, "," | ")"));
    (fits && is_whole).then(|| first.start..last.end())
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
            ("param(\"relief\"", "not a plain number"),
        ] {
            let error = with_default(text, &param(0.5)).unwrap_err();
            assert!(error.message.contains(why) && error.hints[0].contains("0.5"), "{text}: {error:?}");
        }
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
