//! What was typed and loaded so far, as a script that comes to the same.
//!
//! A session may do what a script may not: ask without using the answer, define a function again, load a file
//! again, and look at a solid before going on. So what it asked is ended with a semicolon, of functions and
//! loaded files the last version counts, and the solid that was there last becomes the value of the script.

use crate::script::lexer::{Kind, code, definitions};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A solid or scene that an input leaves behind.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Solid {
    /// It is the value of the input.
    Value,
    /// A variable was given it.
    Named(String),
}

/// The name of the last solid, where the session went on after it.
const SOLID: &str = "last_solid";

/// An input that had no error.
#[derive(Clone, Debug)]
struct Input {
    /// The file that it was loaded from, if it was.
    file: Option<PathBuf>,
    text: String,
    /// The solid that it left behind, if it did.
    solid: Option<Solid>,
}

/// Inputs in their order.
#[derive(Clone, Debug, Default)]
pub struct Record(Vec<Input>);

impl Record {
    /// Adds an input. A file that is loaded again takes the place of what it was.
    pub fn add(&mut self, file: Option<&Path>, text: &str, solid: Option<Solid>) {
        let file = file.map(Path::to_path_buf);
        if file.is_some() {
            self.0.retain(|input| input.file != file);
        }
        self.0.push(Input { file, text: text.to_owned(), solid });
    }

    /// Whether there is nothing.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The variable that was given the last solid, unless that was the value of an input.
    pub fn variable(&self) -> Option<&str> {
        match self.0.iter().rev().find_map(|input| input.solid.as_ref())? {
            Solid::Named(name) => Some(name),
            Solid::Value => None,
        }
    }

    /// Functions that the script has other than the session had them: their names occur before the input that defines
    /// them last.
    pub fn redefined(&self) -> Vec<String> {
        let (mut used, mut found) = (BTreeSet::new(), BTreeSet::new());
        for input in &self.0 {
            found.extend(
                definitions(&input.text).into_iter().map(|f| f.name).filter(|name| used.contains(name)),
            );
            used.extend(code(&input.text).iter().filter(|t| t.kind == Kind::Word).map(|t| t.text.to_owned()));
        }
        found.into_iter().collect()
    }

    /// The script. The variable that was given the last solid may still have it, or be something else by now.
    pub fn script(&self, still: bool) -> String {
        let mut out = String::from("// A session of orogen repl.\n");
        let shown = self.0.iter().rposition(|input| input.solid.is_some());
        let mut last = None;
        for (i, input) in self.0.iter().enumerate() {
            let later = self.0[i + 1..].iter().flat_map(|later| definitions(&later.text));
            let later: Vec<(String, usize)> = later.map(|f| (f.name, f.parameters.len())).collect();
            let text = without(&input.text, &later);
            if text.trim().is_empty() {
                continue;
            }
            if let Some(file) = &input.file {
                // Writing to a text cannot fail.
                let _ = write!(out, "\n// From {}.", file.display());
            }
            let solid = input.solid.as_ref().filter(|_| shown == Some(i));
            let text = match solid {
                Some(Solid::Value) if i + 1 == self.0.len() => text,
                Some(Solid::Value) => {
                    last = Some(SOLID);
                    named(&text)
                }
                Some(Solid::Named(name)) if still => {
                    last = Some(name);
                    ended(&text)
                }
                Some(Solid::Named(name)) => {
                    last = Some(SOLID);
                    format!("{}\nlet {SOLID} = {name};", ended(&text).trim_end())
                }
                None => ended(&text),
            };
            let _ = write!(out, "\n{}\n", text.trim());
        }
        if let Some(last) = last {
            let _ = write!(out, "\n{last}\n");
        }
        out
    }
}

/// A statement that ends; a definition of a function does so by itself.
fn ended(text: &str) -> String {
    let last = code(text).last().map(|t| (t.text, t.end()));
    let defined = definitions(text).last().map(|f| f.end);
    match last {
        None | Some((";", _)) => text.to_owned(),
        Some((_, end)) if defined == Some(end) => text.to_owned(),
        Some((_, end)) => format!("{};{}", &text[..end], &text[end..]),
    }
}

/// Words that begin statements which a block ends, and those that go on after a block.
const BLOCKS: [&str; 9] = ["if", "for", "while", "loop", "do", "switch", "try", "fn", "{"];
const ONWARDS: [&str; 4] = ["else", "catch", "while", "until"];

/// The value of a text under a name: what follows its last statement that ends.
fn named(text: &str) -> String {
    let tokens = code(text);
    let mut depth = 0i32;
    let mut first = 0;
    for (i, token) in tokens.iter().enumerate() {
        let next = tokens.get(i + 1).map(|t| t.text);
        match token.text {
            "(" | "{" | "[" => depth += 1,
            ")" | "}" | "]" => depth -= 1,
            _ => {}
        }
        let ends = match token.text {
            ";" => true,
            "}" => BLOCKS.contains(&tokens[first].text) && next.is_some_and(|next| !ONWARDS.contains(&next)),
            _ => false,
        };
        if depth == 0 && ends {
            first = i + 1;
        }
    }
    let mut start = tokens.get(first).map_or(text.len(), |t| t.start);
    // A definition of a function needs no semicolon after it.
    if let Some(last) = definitions(text).into_iter().rfind(|f| f.start >= start) {
        start = tokens.iter().find(|t| t.start >= last.end).map_or(text.len(), |t| t.start);
    }
    ended(&format!("{}let {SOLID} = {}", &text[..start], &text[start..]))
}

/// A text without functions that are defined again later.
fn without(text: &str, later: &[(String, usize)]) -> String {
    let mut out = text.to_owned();
    for f in definitions(text).into_iter().rev() {
        if later.iter().any(|(name, arity)| *name == f.name && *arity == f.parameters.len()) {
            out.replace_range(f.start..f.end, "");
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn script(inputs: &[(&str, bool)]) -> String {
        let mut record = Record::default();
        inputs.iter().for_each(|(text, solid)| record.add(None, text, solid.then_some(Solid::Value)));
        body(&record, true)
    }

    fn body(record: &Record, still: bool) -> String {
        let (_, body) =
            record.script(still).split_once("\n\n").map(|(a, b)| (a.to_owned(), b.to_owned())).unwrap();
        body.replace("\n\n", "\n")
    }

    #[test]
    fn questions_end_and_the_last_solid_is_the_value() {
        assert_eq!(script(&[("let f = 2", false), ("f + 1 // two", false)]), "let f = 2;\nf + 1; // two\n");
        assert_eq!(script(&[("let r = 2;", false), ("sphere(r)", true)]), "let r = 2;\nsphere(r)\n");
        let went_on = script(&[("let r = 2; sphere(r)", true), ("r = 3", false)]);
        assert_eq!(went_on, "let r = 2; let last_solid = sphere(r);\nr = 3;\nlast_solid\n");
        let after_a_block = script(&[("let g = 1; if true { g = 2 } sphere(g)", true), ("g", false)]);
        assert_eq!(
            after_a_block,
            "let g = 1; if true { g = 2 } let last_solid = sphere(g);\ng;\nlast_solid\n"
        );
        let chosen =
            script(&[("for i in [1, 2] { i }\nif a { sphere(1) } else { sphere(2) }", true), ("1", false)]);
        assert_eq!(
            chosen,
            "for i in [1, 2] { i }\nlet last_solid = if a { sphere(1) } else { sphere(2) };\n1;\nlast_solid\n"
        );
        let defined = script(&[("fn f(r) { sphere(r) } f(1.0)", true), ("1", false)]);
        assert_eq!(defined, "fn f(r) { sphere(r) } let last_solid = f(1.0);\n1;\nlast_solid\n");
    }

    #[test]
    fn the_last_function_of_a_name_counts() {
        let text = script(&[
            ("fn f(a) { a }\nfn f(a, b) { b }", false),
            ("private fn f(c) { -c }", false),
            ("f(1)", false),
        ]);
        assert!(
            !text.contains("{ a }") && text.contains("{ b }") && text.contains("private fn f(c) { -c }"),
            "{text}"
        );
        assert!(text.ends_with("private fn f(c) { -c }\nf(1);\n"), "{text}");
        let again = script(&[("private fn f(c) { c }; 1", false), ("fn f(d) { d }", false)]);
        assert!(!again.contains("private"), "{again}");
    }

    #[test]
    fn a_variable_with_the_last_solid_is_the_value() {
        let mut record = Record::default();
        record.add(None, "let f = sphere(1.0)", Some(Solid::Named("f".to_owned())));
        record.add(None, "f.at([2, 0, 0])", None);
        assert_eq!(record.variable(), Some("f"));
        assert_eq!(body(&record, true), "let f = sphere(1.0);\nf.at([2, 0, 0]);\nf\n");
        let kept = "let f = sphere(1.0);\nlet last_solid = f;\nf.at([2, 0, 0]);\nlast_solid\n";
        assert_eq!(body(&record, false), kept);
        record.add(None, "f", Some(Solid::Value));
        assert_eq!(record.variable(), None);
    }

    #[test]
    fn functions_are_redefined_where_their_names_came_before() {
        let mut record = Record::default();
        for text in ["fn f(a) { a }", "fn g(a) { f(a) } let h = 1;", "fn f(b) { -b } fn k() { 1 } k()"] {
            record.add(None, text, None);
        }
        assert_eq!(record.redefined(), ["f"]);
        record.add(None, "fn sphere(r) { r } fn g(a) { a }", None);
        assert_eq!(record.redefined(), ["f", "g"]);
    }

    #[test]
    fn a_file_that_was_loaded_again_is_there_once() {
        let mut record = Record::default();
        record.add(Some(Path::new("a.rhai")), "let a = 1;", None);
        record.add(Some(Path::new("a.rhai")), "let a = 2;", None);
        let script = record.script(true);
        assert!(!script.contains("a = 1") && script.contains("// From a.rhai.\nlet a = 2;"), "{script}");
    }
}
