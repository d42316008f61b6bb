//! Why a file was not read.

use std::borrow::Cow;
use std::fmt;

/// Where in a file.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Place {
    /// The file as a whole.
    Whole,
    /// A line, counted from one.
    Line(usize),
    /// A byte, counted from zero.
    Byte(usize),
    /// A value of a JSON text, such as `meshes[0].primitives[2]`.
    Value(String),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Whole => Ok(()),
            Place::Line(line) => write!(f, ", line {line}"),
            Place::Byte(byte) => write!(f, ", byte {byte}"),
            Place::Value(path) => write!(f, ", {path}"),
        }
    }
}

/// What is wrong with a file, where, and what to do about it.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("{file}{place}: {what}; {remedy}")]
pub struct Fault {
    /// The file, as its reader was told.
    pub file: String,
    /// Where in it.
    pub place: Place,
    /// What is wrong there.
    pub what: String,
    /// What to do.
    pub remedy: Cow<'static, str>,
}

impl Fault {
    /// A fault of a damaged file, the name of which is still to be filled in.
    pub(super) fn new(place: Place, what: impl Into<String>) -> Fault {
        let remedy = "the file is damaged: get it again, or write it again with the program that made it";
        Fault { file: String::new(), place, what: what.into(), remedy: remedy.into() }
    }

    /// With another remedy.
    pub(super) fn remedy(self, remedy: impl Into<Cow<'static, str>>) -> Fault {
        Fault { remedy: remedy.into(), ..self }
    }

    /// With the name of the file.
    pub(super) fn of(self, file: &str) -> Fault {
        Fault { file: file.to_owned(), ..self }
    }
}

/// The lower-case ending of a file's name, without the dot; empty if there is none.
pub(super) fn ending(name: &str) -> String {
    let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
    file.rsplit_once('.').map_or(String::new(), |(_, ending)| ending.to_ascii_lowercase())
}
