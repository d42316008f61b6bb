//! Arithmetic that is hardly meant: powers of what has a minus before it, and quotients of whole numbers.
//!
//! In scripts a minus before an operand binds tighter than all operators between two: `-x ** 2` is `(-x) ** 2`, which is
//! `x ** 2`. Where mathematics is written, and in most languages that have a power, it is `-(x ** 2)`. So this is warned of,
//! unless an odd exponent makes both the same.
//!
//! The quotient of two whole numbers is whole, too: `1 / 2` is 0.

use super::engine::KEYWORDS;
use super::lexer::{self, Kind, Token};
use crate::diag::{Diagnostic, Place};
use std::sync::Arc;

/// A warning for each such power or quotient in a text that goes by a name.
pub fn warnings(name: &str, text: &str) -> Vec<Diagnostic> {
    let (tokens, file) = (lexer::code(text), Arc::from(name));
    let quotients = (0..tokens.len()).filter_map(|at| quotient(&tokens, at, &file));
    powers(text, &tokens, &file).into_iter().chain(quotients).collect()
}

/// That the quotient at a token, of two whole numbers that are written out, is cut off.
fn quotient(tokens: &[Token<'_>], at: usize, file: &Arc<str>) -> Option<Diagnostic> {
    let [first, sign, second] = tokens.get(at..at + 3)?.try_into().ok()?;
    let whole = |token: &Token<'_>| token.text.parse::<i64>().ok().filter(|_| token.kind == Kind::Number);
    let (a, b) = (whole(&first)?, whole(&second)?);
    // In a product it may not be what is divided, and in a power or a call not what divides.
    let is = |at: Option<usize>, texts: &[&str]| {
        at.and_then(|at| tokens.get(at)).is_some_and(|token| texts.contains(&token.text))
    };
    let is_part = is(at.checked_sub(1), &["*", "/", "%", "."]) || is(Some(at + 3), &["."]);
    let is_raised = is(Some(at + 3), &["*"]) && is(Some(at + 4), &["*"]);
    if sign.text != "/" || is_part || is_raised || b == 0 || a % b == 0 {
        return None;
    }
    let is_near = first.line == second.line && second.column > first.column;
    let width = if is_near { second.column - first.column + second.text.len() as u32 } else { 1 };
    let place = Place { file: file.clone(), line: first.line, column: first.column, width };
    let message = format!("{a} / {b} is {}: the quotient of whole numbers is whole", a / b);
    Some(
        Diagnostic::warning(message)
            .at(place)
            .hint(format!("write {a}.0 / {b} for a fraction, or {} if that is meant", a / b)),
    )
}

fn powers(text: &str, tokens: &[Token<'_>], file: &Arc<str>) -> Vec<Diagnostic> {
    let warn = |at: usize| {
        let minus = sign(tokens, at)?;
        let Token { line, column, start, .. } = tokens[minus];
        let width = text[start..tokens[at].start].trim_end().chars().count() as u32;
        let place = Place { file: file.clone(), line, column, width };
        Some(
            Diagnostic::warning("the minus belongs to what is raised: -a ** b is (-a) ** b")
                .at(place)
                .hint("write -(a ** b) for the power with a minus, or (-a) ** b if that is meant"),
        )
    };
    (1..tokens.len()).filter_map(warn).collect()
}

/// The minus before what the power at a token raises, if there is one that makes a difference.
fn sign(tokens: &[Token<'_>], at: usize) -> Option<usize> {
    let [first, second, exponent] = tokens.get(at..at + 3)?.try_into().ok()?;
    if !(first.text == "*" && second.text == "*" && first.end() == second.start) {
        return None;
    }
    let is_odd = exponent.kind == Kind::Number && exponent.text.parse::<f64>().is_ok_and(|n| n % 2.0 == 1.0);
    let minus = operand(tokens, at.checked_sub(1)?)?.checked_sub(1)?;
    let is_between = minus.checked_sub(1).is_some_and(|before| ends_operand(&tokens[before]));
    (tokens[minus].text == "-" && !is_between && !is_odd).then_some(minus)
}

/// Where the operand begins that ends at a token: a name, a number or brackets, with what they are called, indexed and found
/// by.
fn operand(tokens: &[Token<'_>], mut end: usize) -> Option<usize> {
    loop {
        let mut begin = end;
        if [")", "]"].contains(&tokens[end].text) {
            begin = opening(tokens, end)?;
            let before = begin.checked_sub(1).filter(|before| ends_operand(&tokens[*before]));
            if let Some(before) = before {
                end = before;
                continue;
            }
        }
        let is = |back: usize, text: &str| begin.checked_sub(back).is_some_and(|i| tokens[i].text == text);
        let joint = if is(1, ".") {
            2
        } else if is(1, ":") && is(2, ":") {
            3
        } else {
            return Some(begin);
        };
        end = begin.checked_sub(joint)?;
    }
}

/// The bracket that one closes.
fn opening(tokens: &[Token<'_>], end: usize) -> Option<usize> {
    let mut depth = 0;
    for i in (0..=end).rev().filter(|i| tokens[*i].kind == Kind::Symbol) {
        match tokens[i].text {
            ")" | "]" | "}" => depth += 1,
            "(" | "[" | "{" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return Some(i);
        }
    }
    None
}

/// Whether an operator after a token has an operand before it.
fn ends_operand(token: &Token<'_>) -> bool {
    match token.kind {
        Kind::Number | Kind::Text => true,
        Kind::Word => !KEYWORDS.contains(&token.text),
        // What is in braces may be a value, or a block after which a statement begins.
        Kind::Symbol => [")", "]", "}"].contains(&token.text),
        Kind::Comment => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(text: &str) -> Vec<(u32, u32)> {
        let place = |d: Diagnostic| d.place.expect("a place");
        warnings("a.rhai", text).into_iter().map(place).map(|place| (place.column, place.width)).collect()
    }

    #[test]
    fn powers_of_negatives_are_found() {
        assert_eq!(columns("-x ** 2"), [(1, 2)]);
        assert_eq!(columns("exp(-((a - 1.0) / 0.25) ** 2)"), [(5, 19)]);
        assert_eq!(columns("return -length(p) ** n;"), [(8, 10)]);
        assert_eq!(columns("y * -m::f(x)[2].z ** 2.5"), [(5, 13)]);
        assert_eq!(columns("[1, - 2.0 ** 2, { -x ** y }]"), [(5, 5), (19, 2)]);
    }

    #[test]
    fn quotients_that_are_cut_off_are_found() {
        assert_eq!(columns("sphere(1 / 2)"), [(8, 5)]);
        assert_eq!(columns("x - 7/ 3 + 2.0"), [(5, 4)]);
        for text in [
            "1.0 / 2",
            "1 / 2.0",
            "6 / 3",
            "1 / 0",
            "a * 1 / 2",
            "x / 1 / 2",
            "1 / 2 ** 0.5",
            "1 / n",
            "v.1 / 2",
        ] {
            assert_eq!(columns(text), [], "{text}");
        }
    }

    #[test]
    fn others_are_not() {
        for text in [
            "y - x ** 2",
            "(-x) ** 2",
            "-(x ** 2)",
            "2 ** -x",
            "-x ** 3",
            "-x ** 3.0",
            "let a = if b { 1 } else { 2 } - a ** 2",
            "f(x) - g(x) ** 2",
            "-x * 2",
            "a[0] -x ** 2",
        ] {
            assert_eq!(columns(text), [], "{text}");
        }
        for text in ["** 2", ") ** 2", "-", "*", "- ** 2", ". ** 2", ":: ** 2"] {
            columns(text);
        }
    }
}
