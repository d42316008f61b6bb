//! Line editing: what Tab, Enter and the grey text behind the cursor do.

use super::commands::COMMANDS;
use crate::script::Interpreter;
use rustyline::completion::{Completer, FilenameCompleter, Pair};
use rustyline::error::ReadlineError;
use rustyline::highlight::Highlighter;
use rustyline::hint::Hinter;
use rustyline::history::DefaultHistory;
use rustyline::validate::{ValidationContext, ValidationResult, Validator};
use rustyline::{Config, Context, Editor, Helper};
use std::borrow::Cow;
use std::cell::RefCell;
use std::fs;
use std::path::PathBuf;
use std::rc::Rc;

/// The line editor of the REPL.
pub struct Lines {
    editor: Editor<Assistant, DefaultHistory>,
    history: Option<PathBuf>,
}

/// What the user did.
pub enum Input {
    /// Entered a line, or several that belong together.
    Line(String),
    /// Gave up a line.
    Cleared,
    /// Left.
    End,
}

impl Lines {
    /// An editor that knows the names of an interpreter, and the lines of earlier sessions.
    pub fn new(interpreter: Rc<RefCell<Interpreter>>, color: bool) -> rustyline::Result<Lines> {
        let config =
            Config::builder().max_history_size(2000)?.history_ignore_space(true).auto_add_history(true);
        let mut editor = Editor::with_config(config.build())?;
        editor.set_helper(Some(Assistant { interpreter, files: FilenameCompleter::new(), color }));
        let history = history_file();
        if let Some(file) = &history {
            // There is none the first time; and none is no reason not to start.
            let _ = editor.load_history(file);
        }
        Ok(Lines { editor, history })
    }

    /// The next input.
    ///
    /// # Errors
    /// When the terminal cannot be read.
    pub fn next(&mut self) -> rustyline::Result<Input> {
        match self.editor.readline("> ") {
            Ok(line) => {
                self.remember();
                Ok(Input::Line(line))
            }
            Err(ReadlineError::Interrupted) => Ok(Input::Cleared),
            Err(ReadlineError::Eof) => Ok(Input::End),
            Err(error) => Err(error),
        }
    }

    /// Saves the history after every line, so that nothing is lost; without one, life goes on.
    fn remember(&mut self) {
        if let Some(file) = &self.history {
            let _ = file.parent().map(fs::create_dir_all);
            let _ = self.editor.append_history(file);
        }
    }
}

/// Where lines are kept: the user's folder for data, by the rules of XDG.
fn history_file() -> Option<PathBuf> {
    let absolute = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let data = absolute("XDG_DATA_HOME")
        .or_else(|| absolute("HOME").map(|home| home.join(".local/share")))
        .or_else(|| absolute("APPDATA"))?;
    Some(data.join("orogen").join("history"))
}

/// Completes, hints and tells whether a line goes on.
#[derive(Helper)]
struct Assistant {
    interpreter: Rc<RefCell<Interpreter>>,
    files: FilenameCompleter,
    color: bool,
}

impl Assistant {
    /// The names that start like the word before the cursor, and where that word starts.
    fn candidates(&self, line: &str, pos: usize) -> (usize, Vec<String>) {
        let before = &line[..pos];
        if before.starts_with(':') && !before.contains(' ') {
            let names = COMMANDS.iter().map(|c| c.0.to_owned());
            return (0, names.filter(|name| name.starts_with(before)).collect());
        }
        let start = before
            .rfind(|c: char| !c.is_alphanumeric() && c != '_')
            .map_or(0, |i| i + before[i..].chars().next().map_or(0, char::len_utf8));
        let word = &before[start..];
        if word.is_empty() {
            return (start, Vec::new());
        }
        let names = self.interpreter.borrow().names();
        (start, names.into_iter().filter(|name| name.starts_with(word)).collect())
    }
}

impl Completer for Assistant {
    type Candidate = Pair;

    fn complete(&self, line: &str, pos: usize, ctx: &Context<'_>) -> rustyline::Result<(usize, Vec<Pair>)> {
        if line.starts_with(":load ") || line.starts_with(":render ") {
            return self.files.complete(line, pos, ctx);
        }
        let (start, names) = self.candidates(line, pos);
        let pair = |name: String| Pair { display: name.clone(), replacement: name };
        Ok((start, names.into_iter().map(pair).collect()))
    }
}

impl Hinter for Assistant {
    type Hint = String;

    /// The rest of the word, where there is only one way to end it.
    fn hint(&self, line: &str, pos: usize, _: &Context<'_>) -> Option<String> {
        if pos < line.len() {
            return None;
        }
        let (start, names) = self.candidates(line, pos);
        match names.as_slice() {
            [only] => only.get(pos - start..).filter(|rest| !rest.is_empty()).map(str::to_owned),
            _ => None,
        }
    }
}

impl Highlighter for Assistant {
    fn highlight_hint<'h>(&self, hint: &'h str) -> Cow<'h, str> {
        if self.color { Cow::Owned(format!("\x1b[2m{hint}\x1b[0m")) } else { Cow::Borrowed(hint) }
    }
}

impl Validator for Assistant {
    /// Enter starts another line as long as brackets are open.
    fn validate(&self, context: &mut ValidationContext<'_>) -> rustyline::Result<ValidationResult> {
        let line = context.input();
        let goes_on = !line.starts_with(':') && self.interpreter.borrow().is_incomplete(line);
        Ok(if goes_on { ValidationResult::Incomplete } else { ValidationResult::Valid(None) })
    }
}
