//! What helps while a line is typed: Tab lists what can follow, with signatures; grey text behind the cursor ends
//! a word or says what a call wants; colours; and Enter starts another line as long as brackets are open.

use super::commands::COMMANDS;
use super::draw::shortened;
use super::paint;
use crate::cli::pictures;
use crate::script::{Candidate, Completion, Interpreter};
use rustyline::completion::{Completer, FilenameCompleter, Pair};
use rustyline::highlight::{CmdKind, Highlighter};
use rustyline::hint::Hinter;
use rustyline::validate::{ValidationContext, ValidationResult, Validator};
use rustyline::{CompletionType, Context, Helper};
use std::borrow::Cow;
use std::cell::{Cell, RefCell};
use std::rc::Rc;

/// Completes, hints, colours, and tells whether a line goes on.
#[derive(Helper)]
pub struct Assistant {
    interpreter: Rc<RefCell<Interpreter>>,
    files: FilenameCompleter,
    color: bool,
    /// Whether the line is done, so that nothing at the cursor matters any more.
    done: Cell<bool>,
}

/// Between a signature and what is said about it.
const GAP: &str = "   ";
/// Signatures in a list are as wide as the widest of them, but no wider than that.
const WIDE: usize = 44;
/// So many ways are named where nothing is typed yet.
const FEW: usize = 24;

impl Assistant {
    /// Help for an interpreter's names.
    pub fn new(interpreter: Rc<RefCell<Interpreter>>, color: bool) -> Assistant {
        Assistant { interpreter, files: FilenameCompleter::new(), color, done: Cell::new(false) }
    }

    /// How the text before the cursor can go on; `None` where a file is named.
    fn ways(&self, before: &str) -> Option<Completion> {
        if !before.starts_with(':') {
            return Some(self.interpreter.borrow().complete(before)).filter(|ways| !ways.in_text);
        }
        let Some((name, argument)) = before.split_once(' ') else {
            return Some(commands(before, 0));
        };
        if [":load", ":save", ":render"].iter().any(|command| command.starts_with(name)) && name.len() > 1 {
            return None;
        }
        if argument.starts_with(':') && ":help".starts_with(name) {
            return Some(commands(argument, name.len() + 1));
        }
        let offset = before.len() - argument.len();
        let ways = self.interpreter.borrow().complete(argument);
        let is_file =
            ways.in_text || argument.rsplit_once(" to ").is_some_and(|(_, file)| !file.contains(' '));
        (!is_file).then_some(Completion { start: ways.start + offset, ..ways })
    }
}

/// Commands that begin like this.
fn commands(typed: &str, start: usize) -> Completion {
    let matching = COMMANDS.iter().filter(|c| c.name.starts_with(typed));
    let candidate = |c: &super::commands::Command| Candidate {
        text: format!("{}{}", c.name, if c.argument.is_empty() { "" } else { " " }),
        signature: format!("{} {}", c.name, c.argument).trim_end().to_owned(),
        about: c.meaning.to_owned(),
    };
    Completion { start, candidates: matching.map(candidate).collect(), in_text: false }
}

/// Candidates as lines of a list that fit a terminal.
fn listed(candidates: Vec<Candidate>, columns: usize) -> Vec<Pair> {
    let width = candidates.iter().map(|c| c.signature.chars().count()).max().unwrap_or(0).min(WIDE);
    let line = |c: Candidate| {
        let text = match c.about.is_empty() {
            true => c.signature,
            false => format!("{:width$}{GAP}{}", c.signature, c.about.replace('\n', " ")),
        };
        Pair { display: shortened(&text, columns.saturating_sub(3)), replacement: c.text }
    };
    candidates.into_iter().map(line).collect()
}

impl Completer for Assistant {
    type Candidate = Pair;

    fn complete(&self, line: &str, pos: usize, ctx: &Context<'_>) -> rustyline::Result<(usize, Vec<Pair>)> {
        match self.ways(&line[..pos]) {
            None => self.files.complete(line, pos, ctx),
            Some(ways) => Ok((ways.start, listed(ways.candidates, pictures::columns()))),
        }
    }
}

/// Grey text behind the cursor.
pub struct Hint {
    shown: String,
    /// How much of it becomes part of the line where it is taken.
    taken: Option<usize>,
}

impl rustyline::hint::Hint for Hint {
    fn display(&self) -> &str {
        &self.shown
    }

    fn completion(&self) -> Option<&str> {
        self.taken.map(|length| &self.shown[..length])
    }
}

impl Hinter for Assistant {
    type Hint = Hint;

    /// The rest of the word, where there is only one way to end it; or else what the call wants.
    fn hint(&self, line: &str, pos: usize, _: &Context<'_>) -> Option<Hint> {
        if pos < line.len() {
            return None;
        }
        let ways = self.ways(line)?;
        let typed = line.get(ways.start..)?;
        let mut texts: Vec<&str> = ways.candidates.iter().map(|c| c.text.as_str()).collect();
        texts.dedup();
        match texts.as_slice() {
            [only] if !typed.is_empty() && only.len() > typed.len() => {
                let rest = only.get(typed.len()..)?.to_owned();
                return Some(Hint { taken: Some(rest.len()), shown: rest });
            }
            [only] if typed == *only && ways.candidates[0].signature.contains('(') => {
                return note(&ways.candidates[0].signature);
            }
            [_, ..] if typed.is_empty() && texts.len() <= FEW => {
                let names: Vec<&str> = ways.candidates.iter().map(|c| c.signature.as_str()).collect();
                return note(&names.join(" "));
            }
            _ => {}
        }
        let argument = if line.starts_with(':') { line.split_once(' ')?.1 } else { line };
        let interpreter = self.interpreter.borrow();
        let signatures: Vec<&str> =
            interpreter.call(argument).into_iter().map(|e| e.signature.as_str()).collect();
        (!signatures.is_empty()).then(|| note(&signatures.join("  "))).flatten()
    }
}

/// Something that is said and not taken.
fn note(text: &str) -> Option<Hint> {
    Some(Hint { shown: format!("   {}", shortened(text, pictures::columns() / 2)), taken: None })
}

impl Highlighter for Assistant {
    fn highlight<'l>(&self, line: &'l str, pos: usize) -> Cow<'l, str> {
        match self.color {
            true => Cow::Owned(paint::line(line, (!self.done.get()).then_some(pos))),
            false => Cow::Borrowed(line),
        }
    }

    fn highlight_hint<'h>(&self, hint: &'h str) -> Cow<'h, str> {
        if self.color { Cow::Owned(format!("\x1b[2m{hint}\x1b[0m")) } else { Cow::Borrowed(hint) }
    }

    fn highlight_candidate<'c>(&self, candidate: &'c str, _: CompletionType) -> Cow<'c, str> {
        match candidate.split_once(GAP).filter(|_| self.color) {
            Some((signature, about)) => {
                Cow::Owned(format!("{}{GAP}\x1b[2m{about}\x1b[0m", paint::line(signature, None)))
            }
            None => Cow::Borrowed(candidate),
        }
    }

    fn highlight_char(&self, _: &str, _: usize, kind: CmdKind) -> bool {
        self.done.set(kind == CmdKind::ForcedRefresh);
        self.color
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::script::Limits;
    use crate::world::Memory;
    use rustyline::hint::Hint as _;
    use rustyline::history::DefaultHistory;
    use std::path::PathBuf;
    use std::sync::Arc;

    fn assistant() -> Assistant {
        let world = Arc::new(Memory::default());
        let interpreter = Interpreter::new(world, PathBuf::new(), Limits::default(), None).unwrap();
        let interpreter = Rc::new(RefCell::new(interpreter));
        interpreter.borrow_mut().eval("let rock = sphere(1.0); fn twice(f) { f + f }").unwrap();
        Assistant::new(interpreter, true)
    }

    fn hint(line: &str) -> Option<(String, Option<String>)> {
        let history = DefaultHistory::new();
        let hint = assistant().hint(line, line.len(), &Context::new(&history))?;
        Some((hint.display().to_owned(), hint.completion().map(str::to_owned)))
    }

    #[test]
    fn words_are_ended_and_calls_explained() {
        assert_eq!(hint("roc"), Some(("k".into(), Some("k".into()))));
        assert_eq!(hint(":top"), Some(("ology ".into(), Some("ology ".into()))));
        let (call, taken) = hint("torus(").unwrap();
        assert!(call.starts_with("   torus(") && taken.is_none(), "{call}");
        assert!(hint(":slice torus(").unwrap().0.contains("torus("));
        assert!(hint("octave_sum(gradient(7), \"fbm\", #{ ").unwrap().0.contains("hurst lacunarity octaves"));
        assert_eq!(hint("torus").map(|h| h.1), Some(None));
        assert_eq!(hint("let a = 1;"), None);
    }

    #[test]
    fn tab_lists_signatures_and_what_they_mean() {
        let history = DefaultHistory::new();
        let list = |line: &str| assistant().complete(line, line.len(), &Context::new(&history)).unwrap();
        let (start, twice) = list("1.0 + twi");
        assert_eq!((start, twice[0].replacement.as_str()), (6, "twice"));
        assert_eq!(twice[0].display, "twice(f)   a function of yours");
        assert_eq!(list("roc").1[0].display, "rock   Field");
        let (start, commands) = list(":help :pl");
        assert_eq!((start, commands[0].replacement.as_str()), (6, ":plot "));
        assert!(list("s").1.iter().all(|c| c.display.chars().count() < pictures::columns()));
    }
}
