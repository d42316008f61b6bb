//! What editors need to complete and to check scripts: the functions as a Rhai definition file.
//!
//! The language server of Rhai reads files that end in `.d.rhai`. In ours, one static module declares
//! the variables in scope and every function that needs no import; a module within it declares those of
//! each `std/...` module, by the name under which scripts import it. Types are left open (`?`), since
//! functions take numbers, vectors and fields alike.

use super::library::{Entry, is_operator};
use std::fmt::Write;

/// Variables that are in scope, and what they are.
const VARIABLES: &[(&str, &str, &str)] = &[
    ("x", "Field", "First coordinate."),
    ("y", "Field", "Second coordinate (up)."),
    ("z", "Field", "Third coordinate."),
    ("p", "VectorField", "The point, `vec3(x, y, z)`."),
    ("time", "Field", "Animation time in seconds."),
];

/// The definition file of these functions.
pub fn definitions(entries: &[Entry]) -> String {
    let mut out = String::from("module static;\n");
    for (name, kind, doc) in VARIABLES {
        let _ = write!(out, "\n/// {doc}\nlet {name}: {kind};\n");
    }
    let module = |entry: &Entry| entry.name.split_once("::").map_or("", |(module, _)| module).to_owned();
    let mut modules: Vec<String> = entries.iter().map(module).collect();
    modules.sort_unstable();
    modules.dedup();
    for name in modules {
        let inner: String = entries.iter().filter(|e| module(e) == name).filter_map(definition).collect();
        if name.is_empty() {
            out += &inner;
        } else {
            let indented =
                inner.lines().map(|l| if l.is_empty() { "\n".into() } else { format!("    {l}\n") });
            let _ = write!(out, "\nmodule {name} {{{}}}\n", indented.collect::<String>());
        }
    }
    out
}

/// The declaration of a function under its documentation; operators are the language's own.
fn definition(entry: &Entry) -> Option<String> {
    let name = entry.name.rsplit("::").next()?;
    if is_operator(name) || !entry.signature.contains('(') {
        return None;
    }
    let (_, params) = entry.signature.split_once('(')?;
    let params = params.split_once(')')?.0.split(',').map(str::trim).filter(|p| !p.is_empty());
    let params: Vec<String> = params.map(|p| format!("{p}: ?")).collect();
    let mut out = String::from("\n");
    let doc = entry.doc.trim().lines().chain((!entry.example.is_empty()).then_some("\n```rhai"));
    for line in doc.flat_map(str::lines).chain(entry.example.lines()) {
        let _ = writeln!(out, "{}", format!("/// {line}").trim_end());
    }
    if !entry.example.is_empty() {
        out += "/// ```\n";
    }
    let _ = writeln!(out, "fn {name}({}) -> ?;", params.join(", "));
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_function_is_declared_once_in_its_module() {
        let entries = crate::script::reference();
        let text = definitions(&entries);
        assert!(text.starts_with("module static;\n") && text.contains("\nlet p: VectorField;\n"));
        let functions = entries.iter().filter(|e| !is_operator(e.name.rsplit("::").next().unwrap()));
        let functions = functions.filter(|e| e.signature.contains('('));
        assert_eq!(text.lines().filter(|l| l.trim_start().starts_with("fn ")).count(), functions.count());
        let (top, rest) = text.split_once("\nmodule ").unwrap();
        assert!(top.contains("\nfn sphere(radius: ?) -> ?;\n"));
        assert!(rest.contains("\n    fn ridged(") && rest.matches('{').count() == rest.matches('}').count());
        let others = text.lines().map(str::trim_start).filter(|l| !l.is_empty() && !l.starts_with("///"));
        for line in others {
            let is_known = ["fn ", "let ", "module ", "}"].iter().any(|start| line.starts_with(start));
            assert!(is_known, "{line}");
        }
    }
}
