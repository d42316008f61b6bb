//! New defaults of parameters, in the texts of scripts.
//!
//! A default that is a literal is replaced where it stands. One that is computed, that several places give, or whose
//! parameter has a computed name is left alone: a call of `preset` at the head of the script goes before it, and from
//! then on is what is replaced. Everything else stays as it is, byte by byte.

use crate::scene::{Domain, Param, Value};
use crate::script::lexer::{Kind, Token, closing, code, tokens};
use std::ops::Range;

/// Writes a parameter's value as its default into the texts of a script: its own first, those of its modules then, and
/// those that it also has but that stay as they are. Without any text, nothing is written.
pub fn write_default(texts: &mut [String], fixed: &[&str], param: &Param) {
    let Some((text, Edit { range, new })) = edit(texts, fixed, param) else { return };
    texts[text].replace_range(range, &new);
}

/// A piece of a text, and what it is to be.
struct Edit {
    range: Range<usize>,
    new: String,
}

/// What is to be changed, in which text.
fn edit(texts: &[String], fixed: &[&str], param: &Param) -> Option<(usize, Edit)> {
    let all: Vec<&str> = texts.iter().map(String::as_str).chain(fixed.iter().copied()).collect();
    let calls = |function: &'static str| {
        let calls = |text: &&str| calls(text, function, param);
        let all: Vec<_> = all.iter().map(calls).enumerate().collect();
        all.into_iter().flat_map(|(i, calls)| calls.into_iter().map(move |call| (i, call)))
    };
    let (mut presets, mut makers) = (calls("preset"), calls("param"));
    let there = match (presets.next(), makers.next(), makers.next()) {
        // The first holds, if nothing else runs before it.
        (Some(preset), ..) => Some(preset).filter(|(text, call)| *text == 0 && call.is_head),
        (None, maker, None) => maker,
        (None, ..) => None,
    };
    // Another value than the one there is would show that this is not the place that it comes from.
    let is_place = |(text, call): &(usize, Call)| *text < texts.len() && call.is_default;
    if let Some((text, Call { value, .. })) = there.filter(is_place) {
        let old = &texts[text][value.clone()];
        let is_there = param.value == param.default;
        let new = if is_there { old.to_owned() } else { literal(&param.value, &param.domain, old) };
        return Some((text, Edit { range: value, new }));
    }
    Some((0, preset(texts.first()?, param)))
}

/// A new preset, which runs before all else.
fn preset(text: &str, param: &Param) -> Edit {
    // What is said of the whole script may stay above; what is said of its first line stays with it.
    let (mut start, mut end) = (0, 0);
    for token in tokens(text) {
        if text[end..token.start].matches('\n').count() > 1 {
            start = token.start;
        }
        if token.kind != Kind::Comment {
            break;
        }
        end = token.end();
    }
    let value = literal(&param.value, &param.domain, "");
    Edit { range: start..start, new: format!("preset(\"{}\", {value});\n", param.name) }
}

/// How many tokens belong to the presets with which a script begins.
fn head(tokens: &[Token<'_>]) -> usize {
    let mut end = 0;
    while let [word, open, ..] = &tokens[end..]
        && (word.text, open.text) == ("preset", "(")
        && let Some(close) = closing(tokens, end + 1)
        && tokens.get(close + 1).is_some_and(|token| token.text == ";")
    {
        end = close + 2;
    }
    end
}

/// How much deeper a token leads into brackets.
fn depth_of(token: &Token<'_>) -> i32 {
    match token.text {
        "(" | "[" | "{" | "#{" => 1,
        ")" | "]" | "}" => -1,
        _ => 0,
    }
}

/// Where a script says a value of a parameter.
struct Call {
    /// The value, in bytes.
    value: Range<usize>,
    /// Whether it is a literal, and what the parameter has as its default.
    is_default: bool,
    /// Whether it is a preset with which the script begins.
    is_head: bool,
}

/// The calls of a function for a parameter.
fn calls(text: &str, function: &str, param: &Param) -> Vec<Call> {
    let tokens = code(text);
    let head = head(&tokens);
    let is_call = |w: &[Token<'_>]| {
        (w[0].kind, w[0].text, w[1].text) == (Kind::Word, function, "(")
            && w[2].kind == Kind::Text
            && w[2].text.trim_matches(['"', '`']) == param.name
            && w[3].text == ","
    };
    let starts = tokens.windows(4).enumerate().filter(|(_, w)| is_call(w)).map(|(i, _)| i);
    let call = |start: usize| {
        let value = argument(&tokens[start + 4..])?;
        let (first, last) = (value.first()?, value.last()?);
        let range = first.start..last.end();
        let admitted = value_of(value).and_then(|value| param.domain.admit(&value).ok());
        let as_written = literal(&param.default, &param.domain, &text[range.clone()]);
        Some(Call {
            is_default: admitted.as_ref() == Some(&param.default) || text[range.clone()] == as_written,
            value: range,
            is_head: start < head,
        })
    };
    starts.filter_map(call).collect()
}

/// The argument with which tokens begin.
fn argument<'a, 'b>(tokens: &'a [Token<'b>]) -> Option<&'a [Token<'b>]> {
    let mut depth = 0;
    let end = tokens.iter().position(|token| {
        let is_end = depth == 0 && matches!(token.text, "," | ")");
        depth += depth_of(token);
        is_end
    });
    Some(&tokens[..end?])
}

/// The value of a literal: of a number with its sign, a text without escapes, or a flag. Others are computed.
fn value_of(argument: &[Token<'_>]) -> Option<Value> {
    let number = |token: &Token<'_>| {
        let digits = (token.kind == Kind::Number).then(|| token.text.replace('_', ""))?;
        digits.parse::<f64>().ok()
    };
    match argument {
        [sign, digits] if sign.text == "-" => Some(Value::Number(-number(digits)?)),
        [sign, digits] if sign.text == "+" => number(digits).map(Value::Number),
        [text] if text.kind == Kind::Text => {
            let inner = text.text.strip_prefix('"').and_then(|rest| rest.strip_suffix('"'));
            let raw = || text.text.strip_prefix('`')?.strip_suffix('`').filter(|raw| !raw.contains("${"));
            let plain = inner.filter(|inner| !inner.contains(['\\', '\n'])).or_else(raw)?;
            Some(Value::Text(plain.to_owned()))
        }
        [other] => number(other).map(Value::Number).or_else(|| other.text.parse().ok().map(Value::Flag)),
        _ => None,
    }
}

/// A value as a script says it, in the manner of a literal that is there, if any is.
fn literal(value: &Value, domain: &Domain, like: &str) -> String {
    match (value, domain) {
        (Value::Number(value), Domain::Number { whole: true, .. }) => format!("{value}"),
        (Value::Number(value), _) => format!("{value:?}"),
        (Value::Text(text), _) if like.starts_with('`') && !text.contains(['`', '$']) => format!("`{text}`"),
        (Value::Text(text), _) => format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\"")),
        (Value::Flag(flag), _) => flag.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn param(value: f64) -> Param {
        let domain = Domain::Number { least: -1.0, most: 1.0, whole: false };
        Param { name: "relief".into(), default: 0.02.into(), value: value.into(), domain }
    }

    fn from(default: f64, value: f64) -> Param {
        Param { default: default.into(), ..param(value) }
    }

    fn whole(default: f64, value: f64) -> Param {
        let domain = Domain::Number { least: 0.0, most: 99.0, whole: true };
        Param { domain, ..from(default, value) }
    }

    fn choice(default: &str, value: &str) -> Param {
        let domain = Domain::Choice { names: vec![default.to_owned(), value.to_owned()] };
        Param { name: "style".into(), default: default.into(), value: value.into(), domain }
    }

    fn switch() -> Param {
        Param { name: "on".into(), default: true.into(), value: false.into(), domain: Domain::Switch }
    }

    fn written(text: &str, param: &Param) -> String {
        let mut texts = [text.to_owned()];
        write_default(&mut texts, &[], param);
        texts.concat()
    }

    #[test]
    fn a_default_is_replaced_and_nothing_else() {
        let text = "// param(\"relief\", 1, 2)\nlet r = param ( \"relief\" , -0.02 , -1.0..1.0); // é\n\"x\"";
        let new = written(text, &from(-0.02, 0.375));
        assert_eq!(new, text.replacen("-0.02", "0.375", 1));
        assert!(written(&new, &from(0.375, -1.0)).contains(" -1.0 ,"));
        let same = "param(\"relief\", 0.020, 0..9)";
        assert_eq!(written(same, &param(0.02)), same);
        assert_eq!(written("param(\"relief\", 3, 0..9)", &whole(3.0, 5.0)), "param(\"relief\", 5, 0..9)");
        // What is no decimal number counts as computed.
        let hexadecimal = "param(\"relief\", 0x1E, 0..99)";
        assert_eq!(
            written(hexadecimal, &whole(30.0, 66.0)),
            format!("preset(\"relief\", 66);\n{hexadecimal}")
        );
    }

    #[test]
    fn texts_and_flags_are_written_as_they_were() {
        let list = "param(\"style\", \"a\\\"b\", [\"a\\\"b\", \"c\"])";
        let after = list.replacen("\"a\\\"b\"", "\"c\\\\\\\"d\"", 1);
        assert_eq!(written(list, &choice("a\"b", "c\\\"d")), after);
        for (before, value, after) in [
            ("param(`style`, `a`, [])", "#c98f5a", "param(`style`, `#c98f5a`, [])"),
            ("param(\"style\", `a`, names)", "1 `", "param(\"style\", \"1 `\", names)"),
            (
                "param( \"style\" , /* é */ \"a\" , n)",
                "#000000",
                "param( \"style\" , /* é */ \"#000000\" , n)",
            ),
        ] {
            assert_eq!(written(before, &choice("a", value)), after);
        }
        let color = Param { domain: Domain::Color, ..choice("#ffffff", "#c98f5a") };
        assert_eq!(written("param(\"style\", \"#FFF\")", &color), "param(\"style\", \"#c98f5a\")");
        assert_eq!(written("param(\"on\", true)", &switch()), "param(\"on\", false)");
    }

    #[test]
    fn what_is_no_literal_in_one_place_gets_a_preset() {
        for (text, param, preset) in [
            ("param(\"relief\", 2.0 * r, 0.0..1.0)", param(0.5), "preset(\"relief\", 0.5);\n"),
            ("param(\"relief\", #{ a: r, b: 1 }.a, 0.0..1.0)", param(1.0), "preset(\"relief\", 1.0);\n"),
            ("param(\"other\", 1.0, 0.0..1.0)", param(0.5), "preset(\"relief\", 0.5);\n"),
            (
                "param(\"relief\", 0.02, r); param(\"relief\", 0.02, r)",
                param(0.5),
                "preset(\"relief\", 0.5);\n",
            ),
            // Something else has said another default.
            ("param(\"relief\", 1.0, r)", param(0.5), "preset(\"relief\", 0.5);\n"),
            ("param(\"relief\"", param(0.5), "preset(\"relief\", 0.5);\n"),
            ("", param(-0.0), "preset(\"relief\", -0.0);\n"),
            ("param(\"style\", `${x}`, names)", choice("b", "a"), "preset(\"style\", \"a\");\n"),
            ("param(\"style\", \"a\" + \"b\", names)", choice("b", "a"), "preset(\"style\", \"a\");\n"),
            ("param(\"on\", !true)", switch(), "preset(\"on\", false);\n"),
        ] {
            assert_eq!(written(text, &param), format!("{preset}{text}"));
            let again = Param { default: param.value.clone(), ..param.clone() };
            assert_eq!(written(&written(text, &param), &again), format!("{preset}{text}"));
        }
        assert_eq!(written("f()", &whole(3.0, 6.0)), "preset(\"relief\", 6);\nf()");
    }

    #[test]
    fn presets_stand_at_the_head_and_are_replaced_there() {
        let text = "// All of it.\n\n// The rock.\nlet rock = f();";
        let one = written(text, &param(0.5));
        assert_eq!(one, "// All of it.\n\npreset(\"relief\", 0.5);\n// The rock.\nlet rock = f();");
        assert_eq!(written(&one, &from(0.5, 0.25)), one.replace("0.5", "0.25"));
        let block = "/* A rock.\n\n   By me. */\nlet k = 1;";
        assert_eq!(written(block, &param(0.5)), format!("preset(\"relief\", 0.5);\n{block}"));
        let apart = "/* A rock. */\r\n\r\nlet k = 1;";
        assert_eq!(written(apart, &param(0.5)), apart.replace("let", "preset(\"relief\", 0.5);\nlet"));
        let two = written(&one, &switch());
        assert_eq!(two, one.replace("preset(", "preset(\"on\", false);\npreset("));
        assert_eq!(written(&two, &from(0.5, 0.25)), two.replace("0.5", "0.25"));
        // A preset that may not run, or not first, or that is computed does not do.
        for later in [
            "if x { preset(\"relief\", 0.02); }",
            "preset(\"relief\", f(1.0, [2]));",
            "param(\"relief\", 0.02, r);",
        ] {
            let text = format!("let a = 1; {later} param(\"relief\", 0.02, r)");
            assert_eq!(written(&text, &param(0.5)), format!("preset(\"relief\", 0.5);\n{text}"));
        }
    }

    #[test]
    fn modules_are_written_into_where_they_alone_say_it() {
        let texts = |main: &str, module: &str| [main.to_owned(), module.to_owned()];
        for (before, after) in [
            (texts("import", "param(\"relief\", 0.02, r)"), texts("import", "param(\"relief\", 0.5, r)")),
            (texts("import", "f()"), texts("preset(\"relief\", 0.5);\nimport", "f()")),
            (
                texts("preset(\"relief\", 0.02); import", "param(\"relief\", 0.02, r)"),
                texts("preset(\"relief\", 0.5); import", "param(\"relief\", 0.02, r)"),
            ),
            (
                texts("import", "if x { preset(\"relief\", 0.02) } param(\"relief\", 0.02, r)"),
                texts(
                    "preset(\"relief\", 0.5);\nimport",
                    "if x { preset(\"relief\", 0.02) } param(\"relief\", 0.02, r)",
                ),
            ),
        ] {
            let mut written = before;
            write_default(&mut written, &[], &param(0.5));
            assert_eq!(written, after);
        }
        write_default(&mut [], &[], &param(0.5));
        // What another one says that stays as it is says it, too.
        let main = "param(\"relief\", 0.02, r)";
        let mut texts = [main.to_owned()];
        write_default(&mut texts, &[main], &param(0.5));
        assert_eq!(texts.concat(), format!("preset(\"relief\", 0.5);\n{main}"));
    }
}
