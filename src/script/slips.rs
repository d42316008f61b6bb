//! Slips of the pen: what brackets, quotation marks and comments of a text say about why it could not be read. The engine
//! notices where it can go on no further, which may be far from where something is missing.

use super::engine::KEYWORDS;
use super::fault::Fault;
use super::lexer::{self, Kind, Token};
use crate::diag::{self, Place};
use std::sync::Arc;

/// A slip: the token that it is at, what is wrong, and what may help.
pub(super) struct Slip<'a> {
    pub at: Token<'a>,
    pub message: String,
    pub label: String,
    pub hint: Option<String>,
}

impl<'a> Slip<'a> {
    fn new(at: Token<'a>, message: impl Into<String>, label: impl Into<String>) -> Self {
        Slip { at, message: message.into(), label: label.into(), hint: None }
    }

    fn hint(self, hint: impl Into<String>) -> Self {
        Slip { hint: Some(hint.into()), ..self }
    }

    /// The slip as a fault in a file.
    pub fn fault(self, file: &str) -> Fault {
        let width = first_line(self.at.text).chars().count().max(1) as u32;
        let place = Place { file: Arc::from(file), line: self.at.line, column: self.at.column, width };
        let fault = Fault::new(self.message).label(self.label).at(Some(place));
        self.hint.into_iter().fold(fault, Fault::hint)
    }
}

/// Refuses a comment without an end, which hides all that follows.
///
/// # Errors
/// Where there is one.
pub(super) fn refuse_open_comment(file: &str, text: &str) -> Result<(), Fault> {
    let last = lexer::tokens(text).pop().filter(|t| t.kind == Kind::Comment && !t.closed);
    let slip = |at| Slip::new(at, "the comment is never closed", "opened here").hint("it ends with `*/`");
    last.map_or(Ok(()), |at| Err(slip(at).fault(file)))
}

/// What was meant in a text that could not be read, if that is plain to see. `place` is where the engine stopped, for want of
/// a semicolon if so.
pub(super) fn slip(text: &str, place: Option<(u32, u32)>, wants_semicolon: bool) -> Option<Slip<'_>> {
    let ended = || place.filter(|_| wants_semicolon).and_then(|(line, column)| unended(text, line, column));
    bracket(text).or_else(ended)
}

/// What to write below a text that has no value since its last statement gives a name to one.
pub(super) fn no_value(text: &str) -> Option<String> {
    let tokens = lexer::code(text);
    let body = match &tokens[..] {
        [body @ .., last] if last.text == ";" => body,
        all => all,
    };
    let depth = |i: usize| lexer::open_brackets(&body[..i]).len();
    let last = (0..body.len()).rev().find(|&i| matches!(body[i].text, "let" | "const") && depth(i) == 0)?;
    let is_last = !(last..body.len()).any(|i| body[i].text == ";" && depth(i) == 0);
    let name = body.get(last + 1).filter(|_| is_last)?.text;
    Some(format!("the last statement only gives `{name}` its value: write {name} below it"))
}

/// The first bracket that does not fit the others, in a text that could not be read.
fn bracket(text: &str) -> Option<Slip<'_>> {
    let tokens = lexer::code(text);
    // Where all brackets fit, something else is wrong with what is in them.
    let are_closed = lexer::unclosed(text).is_none();
    let is_closed = |open: &Token<'_>| {
        let number = tokens.iter().position(|t| t.start == open.start);
        let close = number.and_then(|number| lexer::closing(&tokens, number));
        close.is_some_and(|close| tokens[close].text == closes(open.text))
    };
    let mut open: Vec<Token<'_>> = Vec::new();
    for (i, &token) in tokens.iter().enumerate() {
        let missing = |last: &Token<'_>, before: &str| {
            let close = closes(last.text);
            let hint = format!("it closes the `{}` in line {}, column {}", last.text, last.line, last.column);
            Slip::new(token, format!("`{close}` is missing before {before}"), format!("`{close}` expected"))
                .hint(hint)
        };
        match (token.text, open.last()) {
            ("(" | "[" | "{", _) => open.push(token),
            (")" | "]" | "}", None) => {
                let message = format!("there is no `{}` for this `{}`", opens(token.text), token.text);
                return Some(Slip::new(token, message, "nothing is open here"));
            }
            (")" | "]" | "}", Some(last)) if closes(last.text) == token.text => drop(open.pop()),
            (")" | "]" | "}", Some(last)) => return Some(missing(last, &format!("this `{}`", token.text))),
            (";", Some(last)) if last.text != "{" && !is_closed(last) => {
                return Some(missing(last, "the end of the statement"));
            }
            ("fn", Some(last)) if !are_closed && is_definition(&tokens[i..]) => {
                return Some(missing(last, "the next function"));
            }
            _ => {}
        }
    }
    None
}

/// What opens what a bracket closes.
fn opens(close: &str) -> &'static str {
    match close {
        ")" => "(",
        "]" => "[",
        _ => "{",
    }
}

/// What closes a bracket.
fn closes(open: &str) -> &'static str {
    match open {
        "(" => ")",
        "[" => "]",
        _ => "}",
    }
}

fn is_definition(tokens: &[Token<'_>]) -> bool {
    matches!(tokens, [_, name, open, ..] if name.kind == Kind::Word && open.text == "(")
}

/// What was meant where the engine expected a semicolon: the statement before `line` and `column` goes on.
fn unended(text: &str, line: u32, column: u32) -> Option<Slip<'_>> {
    let tokens = lexer::code(text);
    let here = tokens.iter().position(|t| (t.line, t.column) == (line, column))?;
    let (before, at) = (*tokens.get(here.checked_sub(1)?)?, tokens[here]);
    let open = lexer::open_brackets(&tokens[..here]).last().copied();
    let is_value = |open: usize| is_map(&tokens[..=open]) || open + 2 == here && is_bare(&tokens[..=open]);
    if let Some(open) = open.filter(|&open| at.text == ":" && is_value(open)) {
        let message = "an object map begins with `#{`, not with `{`";
        return Some(Slip::new(tokens[open], message, "`#{` expected"));
    }
    if at.text == "{" && before.kind == Kind::Word && at.line == before.line {
        let hint = format!("options are written {}(#{{ ... }})", before.text);
        return Some(Slip::new(at, "`(` is missing", "`(#{` expected").hint(hint));
    }
    let is_new = here >= 2 && matches!(tokens[here - 2].text, "let" | "const");
    let next = tokens.get(here + 1).filter(|next| next.kind == Kind::Word);
    if at.text == ":" && before.kind == Kind::Word && at.line == before.line && (is_new || next.is_some()) {
        let hint = match next {
            Some(next) if !is_new => {
                format!("what is in a module follows two colons: {}::{}", before.text, next.text)
            }
            _ => "variables have no types: let size = 1.0;".to_owned(),
        };
        return Some(Slip::new(at, "a colon has no meaning here", "after a name").hint(hint));
    }
    if at.text == "=" && tokens.get(here + 1).is_some_and(|t| t.text == "=" && t.start == at.end()) {
        let hint = format!("`=` gives a value, `==` compares two: let {} = ...", before.text);
        return Some(Slip::new(at, "`==` has no meaning here", "`=` expected").hint(hint));
    }
    let is_operand = |t: &Token<'_>| matches!(t.kind, Kind::Word | Kind::Number | Kind::Text);
    let is_known = lexer::declared(text).contains(&before.text);
    if begins(&tokens[..here])
        && before.kind == Kind::Word
        && is_operand(&at)
        && at.line == before.line
        && !is_known
        && let Some(meant) = keyword(before.text)
    {
        let message = format!("there is no statement `{}`", before.text);
        return Some(Slip::new(before, message, "not known here").hint(format!("did you mean `{meant}`?")));
    }
    if at.line == before.line && (is_operand(&at) || at.text == "(") {
        let message = format!("an operator is missing before `{}`", first_line(at.text));
        let hint = "factors have `*` between them: 2.0 * x; a statement ends with `;`";
        return Some(Slip::new(at, message, "operator or `;` expected").hint(hint));
    }
    if at.line > before.line {
        let hint = "statements end in a semicolon";
        let message = "`;` is missing at the end of this statement";
        return Some(Slip::new(before, message, "`;` expected after this").hint(hint));
    }
    None
}

/// Whether the last of some tokens begins a statement, as far as those before it tell.
fn begins(tokens: &[Token<'_>]) -> bool {
    let [.., before, last] = tokens else { return true };
    let ends = before.kind != Kind::Symbol || matches!(before.text, ")" | "]");
    matches!(before.text, ";" | "{" | "}") || before.line < last.line && ends
}

/// Whether the last of some tokens, a brace, begins what a function gives back.
fn is_bare(tokens: &[Token<'_>]) -> bool {
    matches!(tokens, [.., before, brace] if brace.text == "{" && matches!(before.text, ")" | "|" | "return"))
}

/// Whether the last of some tokens, a brace, stands where a value does.
fn is_map(tokens: &[Token<'_>]) -> bool {
    matches!(tokens, [.., before, brace] if brace.text == "{" && matches!(before.text, "(" | "," | ":" | "=" | "["))
}

/// The keyword that a word may stand for.
fn keyword(word: &str) -> Option<&'static str> {
    /// Shorter words are as likely to be names.
    const LETTERS: usize = 3;
    match word {
        "def" | "val" | "mut" | "auto" | "local" => Some("let"),
        "function" | "func" | "fun" => Some("fn"),
        "include" | "require" | "using" => Some("import"),
        "elif" | "elsif" | "elseif" => Some("else if"),
        _ if word.chars().count() < LETTERS => None,
        _ => diag::nearest(word, KEYWORDS.iter().copied()),
    }
}

fn first_line(text: &str) -> &str {
    text.lines().next().unwrap_or("")
}
