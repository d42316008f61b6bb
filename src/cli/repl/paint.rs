//! Colours of what is typed, and of expressions in answers.

use crate::script::{Role, roles};
use std::fmt::Write;

/// The colour of a piece of script, as terminals number them; `None` for the usual one.
fn color(role: Role) -> Option<&'static str> {
    Some(match role {
        Role::Keyword => "35",
        Role::Function => "34",
        Role::Input => "36",
        Role::Number => "33",
        Role::Text => "32",
        Role::Comment => "2",
        Role::Name | Role::Symbol => return None,
    })
}

/// A line as it is typed, with the brackets emphasised that belong together at the cursor.
pub fn line(text: &str, cursor: Option<usize>) -> String {
    let command =
        text.strip_prefix(':').map_or(0, |rest| 1 + rest.find(char::is_whitespace).unwrap_or(rest.len()));
    let (name, script) = text.split_at(command);
    let mut out = if name.is_empty() { String::new() } else { format!("\x1b[1m{name}\x1b[0m") };
    let pieces = roles(script);
    let pair = cursor.and_then(|cursor| brackets_at(script, cursor.checked_sub(command)?));
    let mut end = 0;
    for (range, role) in pieces {
        out += &script[end..range.start];
        end = range.end;
        let piece = &script[range.clone()];
        let emphasised = pair.is_some_and(|(a, b)| range.start == a || range.start == b);
        // Writing to a text cannot fail.
        let _ = match color(role) {
            _ if emphasised => write!(out, "\x1b[1;4m{piece}\x1b[0m"),
            Some(color) => write!(out, "\x1b[{color}m{piece}\x1b[0m"),
            None => write!(out, "{piece}"),
        };
    }
    out + &script[end..]
}

/// A bracket at the cursor, or just before it, and the one that it belongs to.
fn brackets_at(text: &str, cursor: usize) -> Option<(usize, usize)> {
    let (mut open, mut pairs) = (Vec::new(), Vec::new());
    for (range, role) in roles(text) {
        match &text[range.clone()] {
            "(" | "[" | "{" if role == Role::Symbol => open.push(range.start),
            ")" | "]" | "}" if role == Role::Symbol => {
                pairs.extend(open.pop().map(|start| (start, range.start)))
            }
            _ => {}
        }
    }
    let at = |place: usize| pairs.iter().copied().find(|(a, b)| *a == place || *b == place);
    at(cursor).or_else(|| at(cursor.checked_sub(1)?))
}

/// An answer: its first line is an expression or a value, what is indented below stands back.
pub fn answer(text: &str) -> String {
    let paint = |text: &str| match text.strip_prefix("  ") {
        Some(_) => format!("\x1b[2m{text}\x1b[0m"),
        None => line(text, None),
    };
    text.lines().map(paint).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is left without colours.
    fn plain(text: &str) -> String {
        let mut out = String::new();
        for (i, piece) in text.split("\x1b[").enumerate() {
            out += if i == 0 { piece } else { piece.split_once('m').unwrap().1 };
        }
        out
    }

    #[test]
    fn colours_change_no_text() {
        for text in ["let f = sphere(1.0); // é", ":plot  f(x) along x=0..1 ", ":", "", "\"open", "a\n  b"] {
            for cursor in 0..=text.len() {
                assert_eq!(plain(&line(text, Some(cursor))), text);
            }
        }
        assert!(line("let a = 1", None).starts_with("\x1b[35mlet\x1b[0m a"));
        assert!(line(":help sphere", None).starts_with("\x1b[1m:help\x1b[0m sphere"));
    }

    #[test]
    fn brackets_find_their_partner() {
        assert_eq!(brackets_at("f(g[0], 1)", 1), Some((1, 9)));
        assert_eq!(brackets_at("f(g[0], 1)", 10), Some((1, 9)));
        assert_eq!(brackets_at("f(g[0], 1)", 4), Some((3, 5)));
        assert_eq!(brackets_at("f(\")\"", 1), None);
        assert_eq!(
            line("f(1)", Some(4)),
            "\x1b[34mf\x1b[0m\x1b[1;4m(\x1b[0m\x1b[33m1\x1b[0m\x1b[1;4m)\x1b[0m"
        );
    }

    #[test]
    fn what_is_said_about_an_answer_stands_back() {
        assert_eq!(answer("x\n  C2, of x"), "\x1b[36mx\x1b[0m\n\x1b[2m  C2, of x\x1b[0m");
    }
}
