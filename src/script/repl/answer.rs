//! Answers: arrays and object maps with what is in them, everything else as [`show`] says it.

use crate::script::host::Host;
use crate::script::show;
use rhai::{Array, Dynamic, Map};

/// Nesting that is followed.
const DEEP: usize = 6;
/// Elements of an array or object map that are said.
const MOST: usize = 40;
/// Length from which on no more elements are said.
const ENOUGH: usize = 2000;

/// A value as the REPL says it.
pub fn answer(host: &Host, value: &Dynamic) -> String {
    if !value.is_array() && !value.is_map() {
        return show::summary(host, value);
    }
    let mut out = String::new();
    write(host, value, 0, &mut out);
    out
}

/// Writes a value that is within so many others.
fn write(host: &Host, value: &Dynamic, depth: usize, out: &mut String) {
    if let Some(array) = value.read_lock::<Array>() {
        let elements = array.iter().map(|v| (String::new(), v));
        write_all(host, ("[", "]"), elements, depth, out);
    } else if let Some(map) = value.read_lock::<Map>() {
        let brackets = if map.is_empty() { ("#{", "}") } else { ("#{ ", " }") };
        write_all(host, brackets, map.iter().map(|(k, v)| (format!("{}: ", key(k)), v)), depth, out);
    } else if value.is_string() {
        *out += &format!("{:?}", value.to_string());
    } else {
        *out += &show::dynamic(host, value);
    }
}

/// Writes what an array or object map holds, each with its name, as far as there is room.
fn write_all<'a>(
    host: &Host,
    (open, close): (&str, &str),
    elements: impl ExactSizeIterator<Item = (String, &'a Dynamic)>,
    depth: usize,
    out: &mut String,
) {
    *out += open;
    let count = elements.len();
    for (i, (name, value)) in elements.enumerate() {
        if i > 0 {
            *out += ", ";
        }
        if depth >= DEEP {
            *out += "...";
            break;
        }
        if i >= MOST || out.len() > ENOUGH {
            *out += &format!("... {} more", count - i);
            break;
        }
        *out += &name;
        write(host, value, depth + 1, out);
    }
    *out += close;
}

/// A key as a script writes it.
fn key(name: &str) -> String {
    let is_word = name.starts_with(|c: char| c.is_alphabetic() || c == '_')
        && name.chars().all(|c| c.is_alphanumeric() || c == '_');
    if is_word { name.to_owned() } else { format!("{name:?}") }
}
