//! Diagnostics are values: what went wrong, where, and what to do about it.
//!
//! Library code returns them and never prints; [`render`] turns one into text with the source line
//! and a caret, in colour for a terminal or plain for a pipe.

mod render;

pub use render::render;

use std::collections::BTreeMap;
use std::sync::Arc;

/// A place in a script: one-based line and column, and how many characters are meant.
#[derive(Clone, PartialEq, Eq, Hash, Debug, PartialOrd, Ord)]
pub struct Place {
    /// File as the user would name it, `std/...` for the standard library.
    pub file: Arc<str>,
    /// Line, from 1; 0 where only the file is known.
    pub line: u32,
    /// Column in characters, from 1; 0 where only the line is known.
    pub column: u32,
    /// Characters from `column` on; at least 1.
    pub width: u32,
}

impl Place {
    /// Whether it is in the standard library.
    pub fn is_embedded(&self) -> bool {
        self.file.starts_with("std/")
    }
}

/// How bad it is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Severity {
    /// Nothing was made.
    Error,
    /// Something was made that may not be what was meant.
    Warning,
}

/// One message with its place and remedies.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// What happened, as one sentence without a full stop.
    pub message: String,
    /// Where, if that is known.
    pub place: Option<Place>,
    /// Text under the caret.
    pub label: Option<String>,
    /// What to do about it.
    pub hints: Vec<String>,
    /// The calls and imports that led there, innermost first, each with where it happened.
    pub trace: Vec<(String, Place)>,
}

impl Diagnostic {
    /// An error.
    pub fn error(message: impl Into<String>) -> Self {
        Diagnostic {
            severity: Severity::Error,
            message: message.into(),
            place: None,
            label: None,
            hints: Vec::new(),
            trace: Vec::new(),
        }
    }

    /// A warning.
    pub fn warning(message: impl Into<String>) -> Self {
        Diagnostic { severity: Severity::Warning, ..Diagnostic::error(message) }
    }

    /// Sets the place.
    pub fn at(mut self, place: impl Into<Option<Place>>) -> Self {
        self.place = place.into();
        self
    }

    /// Sets the text under the caret.
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = Some(label.into());
        self
    }

    /// Adds a remedy.
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hints.push(hint.into());
        self
    }
}

impl std::fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(place) = &self.place {
            write!(f, "{}:{}:{}: ", place.file, place.line, place.column)?;
        }
        f.write_str(&self.message)
    }
}

impl std::error::Error for Diagnostic {}

/// Texts of the files that places refer to.
pub type Sources = BTreeMap<Arc<str>, Arc<str>>;

/// The name among `known` that is nearest to `given`, if one is near enough to be a slip of the
/// hand rather than something else.
pub fn nearest<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = given.to_lowercase();
    let letters = |text: &str| text.chars().count();
    // A third of the letters, rounded to the nearest.
    let slips = |name: &str| ((letters(name).max(letters(&lower)) + 1) / 3).max(1);
    known
        .into_iter()
        .map(|name| (strsim::damerau_levenshtein(&lower, &name.to_lowercase()), name))
        .filter(|(distance, name)| *distance <= slips(name))
        .min()
        .map(|(_, name)| name)
}
