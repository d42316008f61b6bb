//! What went wrong inside a native function, before it is known where.
//!
//! A fault travels through the script engine as the payload of a run-time error, so that a script
//! may catch it like any other; [`diagnose`](super::diagnose) turns it into a diagnostic.

use crate::diag::Place;
use crate::exchange;
use crate::expr::TooLarge;
use rhai::{Dynamic, EvalAltResult, Position};

/// An error of a native function: message, label and remedies.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// One sentence without a full stop.
    pub message: String,
    /// Text under the caret.
    pub label: Option<String>,
    /// Remedies.
    pub hints: Vec<String>,
    /// The key of an object map that is meant, if one is.
    pub key: Option<String>,
    /// The argument that is meant, by its number from 0, if one is.
    pub argument: Option<usize>,
    /// Where the blame lies, if that is not where the function was called.
    pub place: Option<Box<Place>>,
}

/// Result of a native function.
pub type Outcome<T> = Result<T, Fault>;

impl Fault {
    /// A fault with a message.
    pub fn new(message: impl Into<String>) -> Self {
        Fault {
            message: message.into(),
            label: None,
            hints: Vec::new(),
            key: None,
            argument: None,
            place: None,
        }
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

    /// Sets where the blame lies.
    pub fn at(mut self, place: Option<Place>) -> Self {
        self.place = place.map(Box::new);
        self
    }

    /// Says which argument is meant.
    pub fn argument(mut self, number: usize) -> Self {
        self.argument = Some(number);
        self
    }

    /// Names the key of an object map that is meant.
    pub fn key(mut self, key: &str) -> Self {
        self.key = Some(key.to_owned());
        self
    }
}

impl From<TooLarge> for Fault {
    fn from(e: TooLarge) -> Self {
        Fault::new(e.to_string()).hint(
            "a loop adds more than it needs to; noise and fractals are one node each, however many octaves",
        )
    }
}

impl From<exchange::Fault> for Fault {
    fn from(fault: exchange::Fault) -> Self {
        let exchange::Fault { file, place, what, remedy } = fault;
        Fault::new(format!("{file}{place}: {what}")).hint(remedy)
    }
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

impl From<Fault> for Box<EvalAltResult> {
    fn from(fault: Fault) -> Self {
        // The engine fills in the position of the call.
        Box::new(EvalAltResult::ErrorRuntime(Dynamic::from(fault), Position::NONE))
    }
}
