//! Whether a saved script comes to what the session came to.
//!
//! A session calls the function that there is at the time; a script knows only the last of a name, from its first line
//! on. Where a name was used before a function of that name was defined, the script is run, and its variables and its
//! solid are compared with those of the session. It runs on the graph of the session, where equal expressions are the
//! same node.

use super::Interpreter;
use crate::diag::Diagnostic;
use crate::script::host::Host;
use crate::script::library::SceneValue;
use crate::script::value::{Field, VectorField};
use crate::script::{scene_value, show};
use rhai::{Array, Dynamic, FnPtr, Map, Scope};
use std::time::Instant;

/// Nesting of values that is compared.
const DEEP: usize = 100;

impl Interpreter {
    /// What is different after [`script`](Self::script), as an error that names the functions which make it so; `None`
    /// if nothing is, or if the script does not run at all.
    pub fn strays(&mut self, script: &str) -> Option<Box<Diagnostic>> {
        let functions = self.record.redefined();
        if functions.is_empty() {
            return None;
        }
        let (scope, solid) = self.replay(script)?;
        let host = &self.setup.host;
        let mut changed: Vec<&str> = self.scope.iter_raw().map(|(name, ..)| name).collect();
        changed.sort_unstable();
        changed.dedup();
        changed.retain(|name| match (self.scope.get(name), scope.get(name)) {
            (Some(ours), Some(theirs)) => !same(host, ours, theirs, DEEP),
            (ours, theirs) => ours.is_some() != theirs.is_some(),
        });
        let what = match changed.as_slice() {
            [] if solid == self.scene => return None,
            [] => "its solid is another".to_owned(),
            names => format!("{} differs", quoted(names.iter().copied())),
        };
        let names = quoted(functions.iter().map(String::as_str));
        let error =
            Diagnostic::error(format!("the script does not come to the same as this session: {what}"));
        let why = "was used before it was defined again, and a script knows only the last definition";
        let remedy = "define the old one again and give the new one another name, or enter again what used the \
                      old one; then save";
        let error = error.hint(format!("{names} {why}")).hint(remedy);
        Some(Box::new(error))
    }

    /// Runs a script beside the session. Gives its variables and its solid.
    fn replay(&self, script: &str) -> Option<(Scope<'static>, Option<SceneValue>)> {
        let host = &self.setup.host;
        let (params, presets, output) = (host.params.take(), host.presets.take(), host.output.take());
        host.deadline.set(Instant::now().checked_add(self.limits.time));
        let mut scope = Scope::new();
        let ast = self.setup.engine.compile(script).ok();
        let value =
            ast.and_then(|ast| self.setup.engine.eval_ast_with_scope::<Dynamic>(&mut scope, &ast).ok());
        let solid = value.map(|value| scene_value(&self.setup, &value).ok());
        host.params.replace(params);
        host.presets.replace(presets);
        host.output.replace(output);
        solid.map(|solid| (scope, solid))
    }
}

/// Names in a row.
fn quoted<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

/// Whether two values of one graph are the same; functions without a name always are.
fn same(host: &Host, a: &Dynamic, b: &Dynamic, depth: usize) -> bool {
    let Some(depth) = depth.checked_sub(1) else { return true };
    if let (Some(a), Some(b)) = (a.read_lock::<Array>(), b.read_lock::<Array>()) {
        return a.len() == b.len() && a.iter().zip(b.iter()).all(|(a, b)| same(host, a, b, depth));
    }
    if let (Some(a), Some(b)) = (a.read_lock::<Map>(), b.read_lock::<Map>()) {
        let pairs = || a.iter().zip(b.iter());
        return a.len() == b.len() && pairs().all(|((k, a), (l, b))| k == l && same(host, a, b, depth));
    }
    if let (Some(a), Some(b)) = (a.read_lock::<Field>(), b.read_lock::<Field>()) {
        return *a == *b;
    }
    if let (Some(a), Some(b)) = (a.read_lock::<VectorField>(), b.read_lock::<VectorField>()) {
        return *a == *b;
    }
    if let (Some(a), Some(b)) = (a.read_lock::<SceneValue>(), b.read_lock::<SceneValue>()) {
        return *a == *b;
    }
    if a.read_lock::<FnPtr>().is_some() && b.read_lock::<FnPtr>().is_some() {
        return true;
    }
    show::dynamic(host, a) == show::dynamic(host, b)
}
