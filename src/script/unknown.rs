//! What may be meant by names that nothing has: variables, functions and modules.

use super::diagnose::Explainer;
use super::engine::INPUTS;
use super::lexer;
use super::marks::plain;
use super::synonyms;
use super::wording::type_text;
use crate::diag::{self, Diagnostic};

impl Explainer<'_> {
    pub(super) fn unknown_variable(&self, name: &str, file: &str, is_called: bool) -> Diagnostic {
        let sources = self.sources();
        let declared = sources.get(file).map(|text| lexer::declared(text)).unwrap_or_default();
        let inputs = INPUTS.iter().map(|(name, _)| *name).chain(["p", "PI", "TAU"]);
        let d = Diagnostic::error(format!("there is no variable `{name}`")).label("not known here");
        if sources.get(file).is_some_and(|text| lexer::modules(text).contains(&name)) {
            return d.hint(format!("`{name}` is a module: what is in it follows two colons, {name}::..."));
        }
        if declared.contains(&name) && !is_called {
            return d.hint(format!("what makes `{name}` comes later, is in braces, or failed"));
        }
        if declared.contains(&name) {
            return d.hint(format!(
                "functions see only their parameters and x, y, z, p, time: pass `{name}` as an argument"
            ));
        }
        if let Some((module, last)) = name.rsplit_once("::") {
            return d
                .hint(format!("what others see of `{module}` is what it exports: export let {last} = ..."));
        }
        let signatures = self.signatures(name);
        if !signatures.is_empty() {
            return d.hint(format!("`{name}` is a function: {}", signatures.join(" or ")));
        }
        match diag::nearest(name, declared.into_iter().chain(inputs)) {
            Some(near) => d.hint(format!("did you mean `{near}`?")),
            None => d,
        }
    }

    pub(super) fn unknown_module(&self, name: &str, file: &str) -> Diagnostic {
        let d = Diagnostic::error(format!("there is no module `{name}` here"));
        let std = || super::modules::STD.iter().map(|(name, _)| *name);
        let is_variable = self.sources().get(file).is_some_and(|text| lexer::variables(text).contains(&name));
        match std().find(|n| *n == name).or_else(|| diag::nearest(name, std()).filter(|_| !is_variable)) {
            Some(near) => d.hint(format!("import \"std/{near}\" as {near};")),
            None if is_variable => {
                d.hint(format!("`{name}` is a variable: its methods follow a dot, {name}. ..."))
            }
            None => d.hint(format!("import \"...\" as {name}; at the top makes one")),
        }
    }

    fn native<'s>(&'s self, name: &'s str) -> impl Iterator<Item = &'s super::library::Entry> {
        self.setup.entries.iter().filter(move |e| e.name == name)
    }

    /// How a function is called, whoever defines it.
    fn signatures(&self, name: &str) -> Vec<String> {
        let native = self.native(name).map(|e| e.signature.clone());
        let prelude = super::std_entries().into_iter().filter(|e| e.name == name).map(|e| e.signature);
        native.chain(prelude).collect()
    }

    pub(super) fn unknown_function(&self, signature: &str, file: &str) -> Diagnostic {
        let signature = plain(signature);
        let (full, types) = signature.split_once(" (").unwrap_or((&signature, ")"));
        let given = type_text(types.trim_end_matches(')'));
        let name = full.rsplit("::").next().unwrap_or(full).trim();
        if super::library::is_operator(name) {
            let d = Diagnostic::error(format!("`{name}` has no meaning for ({given})"));
            return match synonyms::operator(name, &given) {
                Some(here) => d.hint(here),
                None => d,
            };
        }
        let sources = self.sources();
        let own = sources.get(file).map(|text| lexer::functions(text)).unwrap_or_default();
        let imported = self.setup.loaded.functions();
        let qualified = full.contains("::");
        let mut known = self.signatures(name);
        if qualified {
            known.clear();
        }
        let others = own.iter().chain(qualified.then_some(&imported).into_iter().flatten());
        known.extend(others.clone().filter(|f| f.name == name).map(|f| f.signature.clone()));
        if let Some(own) = own
            .iter()
            .find(|f| f.name == name && lexer::parameters(&f.signature) == lexer::parameters(&given))
            && !qualified
        {
            // What is written in the language takes anything, so it was not called like that.
            return Diagnostic::error(format!("`{name}` is a function, and no method"))
                .label(format!("write {}", own.signature))
                .hint("in a method what stands before the dot is `this`, and no parameter");
        }
        if !known.is_empty() {
            return Diagnostic::error(format!("`{full}` cannot be called with ({given})"))
                .label(format!("expected {}", known.join(" or ")));
        }
        if full.starts_with("anon$") {
            return Diagnostic::error(format!("the function cannot be called with ({given})"));
        }
        let d = Diagnostic::error(format!("there is no function `{full}`"))
            .label(format!("called with ({given})"));
        let everywhere = super::std_entries();
        if !qualified && sources.get(file).is_some_and(|text| lexer::variables(text).contains(&name)) {
            return d.hint(format!("`{name}` is a variable; a function in it is called by {name}.call(...)"));
        }
        if let Some(here) = synonyms::function(full) {
            return d.hint(format!("here that is {here}"));
        }
        let elsewhere = everywhere.iter().find(|e| e.name.rsplit("::").next() == Some(name));
        if let Some(e) = elsewhere.filter(|_| !qualified) {
            let module = e.name.split("::").next().unwrap_or("");
            return d.hint(format!("import \"std/{module}\" as {module}; then call {}", e.signature));
        }
        let is_word = |name: &&str| name.starts_with(char::is_alphabetic);
        let names = self.setup.entries.iter().chain(&everywhere).map(|e| e.name.as_str());
        let names = names.filter(|name| !qualified && is_word(name));
        let near = diag::nearest(name, others.map(|f| f.name.as_str()).chain(names));
        match near {
            Some(near) => {
                let path = full.strip_suffix(name).unwrap_or("");
                d.hint(format!("did you mean `{path}{near}`?"))
            }
            None => d,
        }
    }
}
