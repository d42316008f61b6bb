//! What the program says: messages on standard error, results on standard output.
//!
//! Writing never fails loudly. Whoever reads a pipe may leave early (`orogen check | head -1`), and
//! that is no error of ours.

use crate::diag::{self, Diagnostic, Sources};
use clap::ValueEnum;
use std::ffi::OsString;
use std::fmt::Display;
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// What a command returns.
pub type Outcome = Result<(), Failure>;

/// Why a command failed.
#[derive(Debug)]
pub enum Failure {
    /// The message is out already.
    Reported,
    /// Something went wrong: exit code 1.
    Error(Box<Diagnostic>),
    /// The command line asks for something that makes no sense: exit code 2.
    Usage(Box<Diagnostic>),
}

impl Failure {
    /// An error that is not in a script, with what to do about it.
    pub fn error(message: impl Into<String>, hint: impl Into<String>) -> Failure {
        Failure::Error(Box::new(Diagnostic::error(message).hint(hint)))
    }

    /// An error in the command line, with what to write instead.
    pub fn usage(message: impl Into<String>, hint: impl Into<String>) -> Failure {
        Failure::Usage(Box::new(Diagnostic::error(message).hint(hint)))
    }
}

impl From<Diagnostic> for Failure {
    fn from(diagnostic: Diagnostic) -> Failure {
        Failure::Error(Box::new(diagnostic))
    }
}

/// When messages have colours.
#[derive(Clone, Copy, PartialEq, Eq, Debug, ValueEnum)]
pub enum Color {
    /// On a terminal, unless `NO_COLOR` is set.
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

impl Color {
    /// The choice in arguments that are not parsed yet, since parsing may already have to complain.
    pub fn of_arguments(arguments: &[OsString]) -> Color {
        let mut chosen = Color::Auto;
        for (i, argument) in arguments.iter().enumerate() {
            let value = match argument.to_str() {
                Some("--") => break,
                Some("--color") => arguments.get(i + 1).and_then(|next| next.to_str()),
                Some(other) => other.strip_prefix("--color="),
                None => None,
            };
            chosen = value.and_then(|v| Color::from_str(v, false).ok()).unwrap_or(chosen);
        }
        chosen
    }

    /// The same for the parser of the command line.
    pub fn for_clap(self) -> clap::ColorChoice {
        match self {
            Color::Auto => clap::ColorChoice::Auto,
            Color::Always => clap::ColorChoice::Always,
            Color::Never => clap::ColorChoice::Never,
        }
    }
}

/// How to talk to whoever is there.
#[derive(Clone, Copy, Debug)]
pub struct Terminal {
    /// Whether messages have colours.
    pub color: bool,
    /// Whether somebody watches standard error, so that progress may move.
    pub live: bool,
}

impl Terminal {
    /// Finds out who is there.
    pub fn new(color: Color) -> Terminal {
        let live = std::io::stderr().is_terminal();
        let wanted = std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty())
            && std::env::var_os("TERM").is_none_or(|v| v != "dumb");
        let color = match color {
            Color::Auto => live && wanted,
            Color::Always => true,
            Color::Never => false,
        };
        Terminal { color, live }
    }

    /// A diagnostic with the piece of script that it is about.
    pub fn diagnostic(&self, diagnostic: &Diagnostic, sources: &Sources) {
        err(diag::render(diagnostic, sources, self.color).trim_end());
    }

    /// Text in bold, where there are colours.
    pub fn bold(&self, text: impl Display) -> String {
        self.styled("1", text)
    }

    /// Text that stands back, where there are colours.
    pub fn dim(&self, text: impl Display) -> String {
        self.styled("2", text)
    }

    fn styled(&self, code: &str, text: impl Display) -> String {
        if self.color { format!("\x1b[{code}m{text}\x1b[0m") } else { text.to_string() }
    }
}

/// Why something could not be written to standard output.
static LOST: Mutex<Option<io::Error>> = Mutex::new(None);

/// Writes a line to standard output. If that fails, [`lost`] tells.
pub fn out(line: impl Display) {
    let mut output = io::stdout();
    if let Err(error) = writeln!(output, "{line}").and_then(|()| output.flush()) {
        LOST.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }
}

/// That something could not be written to standard output, unless that is because nobody reads on.
pub fn lost() -> Outcome {
    match LOST.lock().unwrap_or_else(PoisonError::into_inner).take() {
        Some(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            let message = format!("cannot write to standard output ({error})");
            Err(Failure::error(message, "make room, or write to another place"))
        }
        _ => Ok(()),
    }
}

/// Writes a line to standard error, in one piece.
pub fn err(line: impl Display) {
    let _ = std::io::stderr().write_all(format!("{line}\n").as_bytes());
}

/// A number of seconds as people say it.
pub fn seconds(s: f64) -> String {
    match s {
        s if s < 0.0995 => format!("{:.0} ms", s * 1000.0),
        s if s < 99.5 => format!("{s:.1} s"),
        s if s < 3600.0 => format!("{:.0} min {:02.0} s", (s / 60.0).floor(), (s % 60.0).floor()),
        s => format!("{:.0} h {:02.0} min", (s / 3600.0).floor(), (s % 3600.0 / 60.0).floor()),
    }
}

/// A count with its thousands apart.
pub fn count(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// `1 ray`, `2 rays`.
pub fn plural(n: u64, noun: &str) -> String {
    format!("{} {noun}{}", count(n), if n == 1 { "" } else { "s" })
}

/// A path as it can be typed into a shell.
pub fn quoted(path: &Path) -> String {
    word(&path.display().to_string())
}

/// A text as it can be typed into a shell.
pub fn word(text: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "./_-+,#\\:%=".contains(c);
    if text.chars().all(plain) && !text.starts_with('#') { text.to_owned() } else { in_quotes(text) }
}

/// A text in quotes, as any shell takes it for what it is.
pub fn in_quotes(text: &str) -> String {
    format!("'{}'", text.replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_read_well() {
        assert_eq!(seconds(0.0123), "12 ms");
        assert_eq!(seconds(1.26), "1.3 s");
        assert_eq!(seconds(125.9), "2 min 05 s");
        assert_eq!(seconds(7260.0), "2 h 01 min");
        assert_eq!(count(1), "1");
        assert_eq!(count(1234567), "1 234 567");
        assert_eq!((plural(1, "ray").as_str(), plural(2000, "ray").as_str()), ("1 ray", "2 000 rays"));
    }

    #[test]
    fn paths_can_be_typed() {
        for (path, typed) in
            [("a/rock-1.rhai", "a/rock-1.rhai"), ("a b", "'a b'"), ("it's", "'it'\\''s'"), ("$x", "'$x'")]
        {
            assert_eq!(quoted(Path::new(path)), typed);
        }
    }

    #[test]
    fn colour_is_known_before_parsing() {
        let of = |a: &[&str]| Color::of_arguments(&a.iter().map(OsString::from).collect::<Vec<_>>());
        assert_eq!(of(&["orogen", "x"]), Color::Auto);
        assert_eq!(of(&["orogen", "--color", "never"]), Color::Never);
        assert_eq!(of(&["orogen", "x", "--color=always", "--", "--color=never"]), Color::Always);
    }
}
