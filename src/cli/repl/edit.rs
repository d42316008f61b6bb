//! Line editing: the keys, and the lines of earlier sessions.

use super::assist::Assistant;
use crate::script::Interpreter;
use rustyline::error::ReadlineError;
use rustyline::history::DefaultHistory;
use rustyline::{Cmd, CompletionType, Config, Editor, EventHandler, KeyCode, KeyEvent, Modifiers};
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
        let config = Config::builder()
            .max_history_size(2000)?
            .history_ignore_space(true)
            .auto_add_history(true)
            .completion_type(CompletionType::List)
            .completion_show_all_if_ambiguous(true);
        let mut editor = Editor::with_config(config.build())?;
        editor.set_helper(Some(Assistant::new(interpreter, color)));
        // Another line, though nothing is open.
        let newline = KeyEvent(KeyCode::Enter, Modifiers::ALT);
        editor.bind_sequence(newline, EventHandler::Simple(Cmd::Newline));
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
