//! New defaults of parameters, in the texts of scripts.
//!
//! A default that is a literal is replaced where it stands. One that is computed, that several places give, or whose
//! parameter has a computed name is left alone: a call of `preset` at the head of the script goes before it, and from
//! then on is what is replaced. Everything else stays as it is, byte by byte.

use crate::scene::{Domain, Param, Value};
use crate::script::lexer::{Kind, Token, tokens};
use std::ops::Range;

/// Writes a parameter's value as its default into the texts of a script: its own first, those of its modules then.
/// Without any text, nothing is written.
pub fn write_default(texts: &mut [String], param: &Param) {
    let Some((text, Edit { range, new })) = edit(texts, param) else { return };
    texts[text].replace_range(range, &new);
}

/// A piece of a text, and what it is to be.
struct Edit {
    range: Range<usize>,
    new: String,
}

/// What is to be changed, in which text.
fn edit(texts: &[String], param: &Param) -> Option<(usize, Edit)> {
    let calls = |function: &'static str| {
        let of = |text: &String| calls(text, function, param);
        let all = texts.iter().map(of).enumerate();
        all.flat_map(|(i, calls)| calls.into_iter().map(move |call| (i, call)))
    };
    let replaced = |(i, call): (usize, Call)| {
        let is_there = param.value == param.default;
        let old = &texts[i][call.value.clone()];
        let new = if is_there { old.to_owned() } else { literal(&param.value, old) };
        (i, Edit { range: call.value, new })
    };
    let (mut presets, mut makers) = (calls("preset"), calls("param"));
    let there = match (presets.next(), makers.next(), makers.next()) {
        // The first holds.
        (Some(preset), ..) => Some(preset).filter(|(_, call)| call.is_head),
        (None, maker, None) => maker,
        (None, ..) => None,
    };
    if let Some(literal) = there.filter(|(_, call)| call.is_literal) {
        return Some(replaced(literal));
    }
    Some((0, preset(texts.first()?, param)))
}

/// A new preset, which runs before all else.
fn preset(text: &str, param: &Param) -> Edit {
    let like = if matches!(param.domain, Domain::Number { whole: true, .. }) { "0" } else { "0.0" };
    let call = format!("preset(\"{}\", {});", param.name, literal(&param.value, like));
    // What is said of the whole script may stay above; what is said of its first line stays with it.
    let lead = &text[..code(text).first().map_or(0, |token| token.start)];
    let start = lead.rfind("\n\n").map_or(0, |blank| blank + 2);
    Edit { range: start..start, new: format!("{call}\n") }
}

/// The tokens of a text that are not comments.
fn code(text: &str) -> Vec<Token<'_>> {
    tokens(text).into_iter().filter(|token| token.kind != Kind::Comment).collect()
}

/// How many tokens belong to the presets with which a script begins.
fn head(tokens: &[Token<'_>]) -> usize {
    let mut end = 0;
    while let [word, open, ..] = &tokens[end..]
        && (word.text, open.text) == ("preset", "(")
        && let Some(close) = close(&tokens[end + 1..])
        && tokens.get(end + close + 2).is_some_and(|token| token.text == ";")
    {
        end += close + 3;
    }
    end
}

/// Where a bracket ends with which tokens begin.
fn close(tokens: &[Token<'_>]) -> Option<usize> {
    let mut depth = 0;
    tokens.iter().position(|token| {
        depth += depth_of(token);
        depth == 0
    })
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
    /// Whether it is a literal of the parameter's kind.
    is_literal: bool,
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
        Some(Call {
            value: first.start..last.end(),
            is_literal: is_literal(value, &param.value),
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

#[cfg(test)]
mod tests {
    use super::*;

    fn param(value: f64) -> Param {
        let domain = Domain::Number { least: -1.0, most: 1.0, whole: false };
        Param { name: "relief".into(), default: 0.02.into(), value: value.into(), domain }
    }

    fn choice(value: &str) -> Param {
        let domain = Domain::Choice { names: vec![value.to_owned()] };
        Param { name: "style".into(), default: "a".into(), value: value.into(), domain }
    }

    fn switch() -> Param {
        Param { name: "on".into(), default: true.into(), value: false.into(), domain: Domain::Switch }
    }

    fn written(text: &str, param: &Param) -> String {
        let mut texts = [text.to_owned()];
        write_default(&mut texts, param);
        texts.concat()
    }

    #[test]
    fn a_default_is_replaced_and_nothing_else() {
        let text = "// param(\"relief\", 1, 2)\nlet r = param ( \"relief\" , -0.02 , -1.0..1.0); // é\n\"x\"";
        let new = written(text, &param(0.375));
        assert_eq!(new, text.replacen("-0.02", "0.375", 1));
        assert!(written(&new, &param(-1.0)).contains(" -1.0 ,"));
        let whole = "param(\"relief\", 3, 0..9)";
        assert_eq!(written(whole, &param(5.0)), "param(\"relief\", 5, 0..9)");
        assert_eq!(written(whole, &param(0.5)), "param(\"relief\", 0.5, 0..9)");
        let same = "param(\"relief\", 0.020, 0..9)";
        assert_eq!(written(same, &param(0.02)), same);
    }

    #[test]
    fn texts_and_flags_are_written_as_they_were() {
        let list = "param(\"style\", \"a\\\"b\", [\"a\\\"b\", \"c\"])";
        let after = list.replacen("\"a\\\"b\"", "\"c\\\\\\\"d\"", 1);
        assert_eq!(written(list, &choice("c\\\"d")), after);
        for (before, value, after) in [
            ("param(`style`, `#fff`)", "#c98f5a", "param(`style`, `#c98f5a`)"),
            ("param(\"style\", `a`, names)", "1 `", "param(\"style\", \"1 `\", names)"),
            ("param( \"style\" , /* é */ \"#fff\" )", "#000000", "param( \"style\" , /* é */ \"#000000\" )"),
        ] {
            assert_eq!(written(before, &choice(value)), after);
        }
        assert_eq!(written("param(\"on\", true)", &switch()), "param(\"on\", false)");
    }

    #[test]
    fn what_is_no_literal_in_one_place_gets_a_preset() {
        for (text, param, preset) in [
            ("param(\"relief\", 2.0 * r, 0.0..1.0)", param(0.5), "preset(\"relief\", 0.5);\n"),
            ("param(\"relief\", #{ a: r, b: 1 }.a, 0.0..1.0)", param(1.0), "preset(\"relief\", 1.0);\n"),
            ("param(\"other\", 1.0, 0.0..1.0)", param(0.5), "preset(\"relief\", 0.5);\n"),
            (
                "param(\"relief\", 1.0, r); param(\"relief\", 1.0, r)",
                param(0.5),
                "preset(\"relief\", 0.5);\n",
            ),
            ("param(\"relief\"", param(0.5), "preset(\"relief\", 0.5);\n"),
            ("", param(-0.0), "preset(\"relief\", -0.0);\n"),
            ("param(\"style\", `${x}`, names)", choice("a"), "preset(\"style\", \"a\");\n"),
            ("param(\"style\", \"a\" + \"b\", names)", choice("a"), "preset(\"style\", \"a\");\n"),
            ("param(\"on\", !true)", switch(), "preset(\"on\", false);\n"),
        ] {
            assert_eq!(written(text, &param), format!("{preset}{text}"));
            let again = Param { default: param.value.clone(), ..param.clone() };
            assert_eq!(written(&written(text, &param), &again), format!("{preset}{text}"));
        }
        let domain = Domain::Number { least: 0.0, most: 9.0, whole: true };
        let whole = Param { domain, ..param(6.0) };
        assert_eq!(written("f()", &whole), "preset(\"relief\", 6);\nf()");
    }

    #[test]
    fn presets_stand_at_the_head_and_are_replaced_there() {
        let text = "// All of it.\n\n// The rock.\nlet rock = f();";
        let one = written(text, &param(0.5));
        assert_eq!(one, "// All of it.\n\npreset(\"relief\", 0.5);\n// The rock.\nlet rock = f();");
        assert_eq!(written(&one, &param(0.25)), one.replace("0.5", "0.25"));
        let two = written(&one, &switch());
        assert_eq!(two, one.replace("preset(", "preset(\"on\", false);\npreset("));
        assert_eq!(written(&two, &param(0.25)), two.replace("0.5", "0.25"));
        // A preset that may not run, or not first, or that is computed does not do.
        for later in [
            "if x { preset(\"relief\", 1.0); }",
            "preset(\"relief\", f(1.0, [2]));",
            "param(\"relief\", 1.0, r);",
        ] {
            let text = format!("let a = 1; {later} param(\"relief\", 1.0, r)");
            assert_eq!(written(&text, &param(0.5)), format!("preset(\"relief\", 0.5);\n{text}"));
        }
    }

    #[test]
    fn modules_are_written_into_where_they_alone_say_it() {
        let texts = |main: &str, module: &str| [main.to_owned(), module.to_owned()];
        for (before, after) in [
            (texts("import", "param(\"relief\", 1.0, r)"), texts("import", "param(\"relief\", 0.5, r)")),
            (texts("import", "f()"), texts("preset(\"relief\", 0.5);\nimport", "f()")),
            (
                texts("preset(\"relief\", 0.1); import", "param(\"relief\", 1.0, r)"),
                texts("preset(\"relief\", 0.5); import", "param(\"relief\", 1.0, r)"),
            ),
            (
                texts("import", "if x { preset(\"relief\", 0.1) } param(\"relief\", 1.0, r)"),
                texts(
                    "preset(\"relief\", 0.5);\nimport",
                    "if x { preset(\"relief\", 0.1) } param(\"relief\", 1.0, r)",
                ),
            ),
        ] {
            let mut written = before;
            write_default(&mut written, &param(0.5));
            assert_eq!(written, after);
        }
        write_default(&mut [], &param(0.5));
    }
}
