//! One line after another: what a REPL needs of scripts.

mod answer;
mod ask;
mod named;
mod record;
mod replay;
mod snapshot;

pub use ask::Line;

use super::complete::{Candidate, Completion, Known};
use super::diagnose::Explainer;
use super::engine::{self, INPUTS, KEYWORDS, Limits, Setup};
use super::host::Host;
use super::library::Entry;
use super::value::type_name;
use super::{SceneValue, finish, help, lexer, modules, scene_value, signs, slips};
use crate::diag::{Diagnostic, Sources};
use crate::scene::Scene;
use crate::world::World;
use record::{Record, Solid};
use rhai::{AST, Dynamic, EvalAltResult, Scope};
use snapshot::Snapshot;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Name of what is typed, in messages.
const INPUT: &str = "input";

/// What becomes of what an input does to variables and functions.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Effects {
    /// It stays.
    Kept,
    /// It is undone, as after a question.
    None,
}

/// A script that grows line by line. Variables, functions and imports stay.
pub struct Interpreter {
    setup: Setup,
    limits: Limits,
    world: Arc<dyn World + Send + Sync>,
    scope: Scope<'static>,
    /// Functions so far.
    functions: AST,
    /// Import statements so far; they run again before every input.
    imports: Vec<AST>,
    /// Everything typed, so that places in functions of earlier inputs stay right.
    text: String,
    /// What was typed and loaded without an error, to be saved.
    record: Record,
    /// Names of imported modules of the standard library, with those modules.
    aliases: Vec<(String, String)>,
    /// Those of the user's own modules, with their functions.
    own: Vec<(String, Vec<Entry>)>,
    scene: Option<SceneValue>,
    entries: Vec<Entry>,
}

impl Interpreter {
    /// An interpreter whose imports are found in `root`.
    ///
    /// # Errors
    /// When the embedded standard library is broken or does not fit into the limits.
    pub fn new(
        world: Arc<dyn World + Send + Sync>,
        root: PathBuf,
        limits: Limits,
        cancel: Option<Arc<AtomicBool>>,
    ) -> Result<Self, Box<Diagnostic>> {
        let mut host = Host::new(&limits, BTreeMap::new(), 0.0);
        host.store = world.store();
        let files = world.clone();
        let setup =
            engine::setup(host, |loaded| modules::Resolver { world: files, loaded }, &limits, cancel)?;
        setup.loaded.root.replace(root);
        let entries = setup.entries.iter().cloned().chain(super::std_entries()).collect();
        let (scope, functions, text) = (Scope::new(), AST::empty(), String::new());
        Ok(Interpreter {
            setup,
            limits,
            world,
            scope,
            functions,
            imports: Vec::new(),
            text,
            record: Record::default(),
            aliases: Vec::new(),
            own: Vec::new(),
            scene: None,
            entries,
        })
    }

    /// Runs an input and describes its value, if it has one.
    ///
    /// # Errors
    /// Whatever is wrong with the input; what it did before that is undone.
    pub fn eval(&mut self, input: &str) -> Result<Option<String>, Box<Diagnostic>> {
        let value = self.evaluate(input, Effects::Kept)?;
        Ok(self.answer(None, input, &value))
    }

    /// The value of an input.
    fn evaluate(&mut self, input: &str, effects: Effects) -> Result<Dynamic, Box<Diagnostic>> {
        // Each input stands below the earlier ones, as lines of one text.
        let lines = self.text.lines().count();
        let padded = "\n".repeat(lines) + input;
        if !self.text.is_empty() && !self.text.ends_with('\n') {
            self.text.push('\n');
        }
        self.text.push_str(input);
        let text: Arc<str> = Arc::from(self.text.as_str());
        self.setup.loaded.source(INPUT, &text);
        self.execute(INPUT, &padded, effects)
    }

    /// Runs a file as if it had been typed in its folder: imports are looked for there from now on if it has some of its
    /// own, unless those before it came from elsewhere.
    ///
    /// # Errors
    /// When it cannot be read, and as for [`eval`](Self::eval).
    pub fn load(&mut self, path: &Path) -> Result<Option<String>, Box<Diagnostic>> {
        let name = path.to_string_lossy().into_owned();
        self.setup.loaded.touched(path);
        let text = self
            .world
            .read(path)
            .map_err(|e| Box::new(Diagnostic::error(modules::unreadable(&name, &e).message)))?;
        self.setup.loaded.source(&name, &text);
        self.setup.loaded.clear();
        let before = self.setup.loaded.root.borrow().clone();
        if self.own.is_empty() {
            self.setup.loaded.root.replace(path.parent().map(Path::to_owned).unwrap_or_default());
        }
        let value = self.execute(&name, &text, Effects::Kept);
        if self.own.is_empty() {
            self.setup.loaded.root.replace(before);
        }
        Ok(self.answer(Some(path), &text, &value?))
    }

    /// Keeps an input that went well, and describes its value.
    fn answer(&mut self, file: Option<&Path>, input: &str, value: &Dynamic) -> Option<String> {
        let (solid, scene) = self.left_by(input, value).unzip();
        self.record.add(file, input, solid);
        self.scene = scene.or(self.scene.take());
        (!value.is_unit()).then(|| answer::answer(&self.setup.host, value))
    }

    /// The solid that an input leaves behind: its value, or else what it gave to a variable last.
    fn left_by(&self, input: &str, value: &Dynamic) -> Option<(Solid, SceneValue)> {
        if let Ok(scene) = scene_value(&self.setup, value) {
            return Some((Solid::Value, scene));
        }
        named::named(input)
            .into_iter()
            .rev()
            .find_map(|name| Some((Solid::Named(name.to_owned()), self.has(name)?)))
    }

    /// The solid that a variable has.
    fn has(&self, name: &str) -> Option<SceneValue> {
        scene_value(&self.setup, self.scope.get(name)?).ok()
    }

    /// Runs a text. Where it fails, and where no effects are wanted, everything is as before after it.
    fn execute(&mut self, name: &str, text: &str, effects: Effects) -> Result<Dynamic, Box<Diagnostic>> {
        self.setup.host.deadline.set(Instant::now().checked_add(self.limits.time));
        let before = Snapshot::of(&self.scope, &self.setup.host);
        signs::warnings(name, text).into_iter().for_each(|doubt| self.setup.host.doubt(doubt));
        let result = self.run(name, text, effects);
        if result.is_err() || effects == Effects::None {
            before.restore(&mut self.scope, &self.setup.host);
        }
        result.map_err(|e| {
            let explainer = Explainer { setup: &self.setup, limits: &self.limits, main: name };
            Box::new(explainer.explain(&e))
        })
    }

    fn run(&mut self, name: &str, text: &str, effects: Effects) -> Result<Dynamic, Box<EvalAltResult>> {
        let compile = |text: &str| {
            let mut ast = self
                .setup
                .engine
                .compile_with_scope(&self.scope, text)
                .map_err(Box::<EvalAltResult>::from)?;
            ast.set_source(name);
            Ok::<AST, Box<EvalAltResult>>(ast)
        };
        slips::refuse_open_comment(name, text)?;
        let ast = compile(text)?;
        let statements = import_statements(text);
        let imports =
            statements.iter().map(|import| compile(&import.statement)).collect::<Result<Vec<_>, _>>()?;
        // Imports end with the run that makes them, so they run again.
        let mut whole = self.functions.clone();
        for import in &self.imports {
            whole = whole.merge(import);
        }
        let mut whole = whole.merge(&ast);
        whole.set_source(name);
        let result = self.setup.engine.eval_ast_with_scope::<Dynamic>(&mut self.scope, &whole);
        if result.is_ok() && effects == Effects::Kept {
            self.functions = self.functions.merge(&ast.clone_functions_only());
            self.imports.extend(imports);
            statements.into_iter().for_each(|import| self.name_module(import));
        }
        result
    }

    /// Notes by which name a module is known from now on.
    fn name_module(&mut self, Import { alias, path, .. }: Import) {
        self.aliases.retain(|(known, _)| *known != alias);
        self.own.retain(|(known, _)| *known != alias);
        match path.strip_prefix("std/") {
            Some(module) => self.aliases.push((alias, module.to_owned())),
            None => {
                let functions = self.setup.loaded.functions_of(&path);
                let entries = super::entries_of(&alias, functions, &path);
                self.own.push((alias, entries));
            }
        }
    }

    /// Whether an input goes on: a bracket, text or comment is open.
    pub fn is_incomplete(&self, input: &str) -> bool {
        lexer::is_open(input)
    }

    /// Names that mean something: functions, variables, inputs, modules, keywords.
    pub fn names(&self) -> Vec<String> {
        let is_word = |name: &str| name.starts_with(|c: char| c.is_alphabetic());
        let mut names: Vec<String> =
            self.entries.iter().map(|e| e.name.clone()).filter(|n| is_word(n)).collect();
        names.extend(self.own_names().into_iter().map(|c| c.text));
        names.extend(modules::STD.iter().map(|(name, _)| format!("std/{name}")));
        names.sort();
        names.dedup();
        names
    }

    /// What is no function of the reference: what the user has named, inputs, keywords.
    fn own_names(&self) -> Vec<Candidate> {
        let candidate = |text: &str, signature: String, about: String| Candidate {
            text: text.to_owned(),
            signature,
            about,
        };
        let named = self.scope.iter();
        let mut names: Vec<Candidate> = named
            .map(|(name, _, value)| candidate(name, name.to_owned(), type_name(&value).to_owned()))
            .collect();
        names.extend(self.functions.iter_functions().map(|f| {
            candidate(
                f.name,
                format!("{}({})", f.name, f.params.join(", ")),
                "a function of yours".to_owned(),
            )
        }));
        let inputs = INPUTS.iter().map(|(name, _)| *name).chain(["p", "PI", "TAU"]);
        names.extend(inputs.map(|name| {
            let about =
                help::input(name).and_then(|text| text.trim_end().split_once(": ")).map_or("", |t| t.1);
            candidate(name, name.to_owned(), about.to_owned())
        }));
        names.extend(KEYWORDS.iter().map(|k| candidate(k, (*k).to_owned(), String::new())));
        names
    }

    /// How a text that ends at the cursor can go on.
    pub fn complete(&self, text: &str) -> Completion {
        self.known(self.own_names()).complete(text)
    }

    /// What the call wants that a text ends in: its signatures, and what it does.
    pub fn call(&self, text: &str) -> Vec<&Entry> {
        self.known(Vec::new()).signatures(text)
    }

    fn known(&self, others: Vec<Candidate>) -> Known<'_> {
        Known { entries: &self.entries, others, aliases: &self.aliases, own: &self.own }
    }

    /// Everything that went well so far, as a script; `None` if there is nothing.
    pub fn script(&self) -> Option<String> {
        let still = self.record.variable().is_some_and(|name| self.has(name) == self.scene);
        (!self.record.is_empty()).then(|| self.record.script(still))
    }

    /// What a name means: signatures, a sentence, an example; or what there is in a module, under a
    /// heading or about a word.
    pub fn help(&self, name: &str) -> Option<String> {
        let own = self.own.iter().find_map(|(_, entries)| help::explain(entries, name));
        let known = own.or_else(|| help::explain(&self.entries, name));
        let known = known.or_else(|| help::input(name).map(str::to_owned));
        // What the user has named goes before words of the documentation.
        let own = self.scope.contains(name) || self.functions.iter_functions().any(|f| f.name == name);
        known.or_else(|| if own { None } else { help::topic(&self.entries, name) })
    }

    /// The name that is meant by one that is nothing's.
    pub fn nearest(&self, name: &str) -> Option<String> {
        help::nearest(&self.entries, &self.names(), name).map(str::to_owned)
    }

    /// The last scene or field that was answered or given to a variable, as a scene.
    pub fn scene(&self) -> Option<Scene> {
        finish(&self.setup.host, self.scene.as_ref()?).ok()
    }

    /// Texts that diagnostics refer to.
    pub fn sources(&self) -> Sources {
        self.setup.loaded.sources.borrow().clone()
    }

    /// Files that were looked for so far.
    pub fn files(&self) -> Vec<PathBuf> {
        self.setup.loaded.files.borrow().clone()
    }

    /// Takes what was made since the last call, but is hardly meant.
    pub fn doubts(&mut self) -> Vec<Diagnostic> {
        self.setup.host.odd.take()
    }

    /// Takes what `print` and `debug` have said since the last call.
    pub fn output(&mut self) -> Vec<String> {
        self.setup.host.output.take()
    }
}

/// An import.
struct Import {
    /// Padded to its line.
    statement: String,
    /// The name that it gives,
    alias: String,
    /// and to what.
    path: String,
}

/// The import statements at the top level of a text.
fn import_statements(text: &str) -> Vec<Import> {
    let all = lexer::code(text);
    let mut depth = 0;
    let mut found = Vec::new();
    for (i, token) in all.iter().enumerate() {
        match token.text {
            "(" | "{" | "[" => depth += 1,
            ")" | "}" | "]" => depth -= 1,
            "import" if depth == 0 => {
                let words: Vec<&str> = all[i..].iter().take(4).map(|t| t.text).collect();
                if let [_, path, "as", alias] = words[..] {
                    let statement =
                        format!("{}import {path} as {alias};", "\n".repeat(token.line as usize - 1));
                    let path = path.trim_matches('"').to_owned();
                    found.push(Import { statement, alias: alias.to_owned(), path });
                }
            }
            _ => {}
        }
    }
    found
}
