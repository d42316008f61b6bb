//! `orogen repl`: questions and answers.
//!
//! On a terminal lines are edited, completed, coloured and remembered, and pictures are shown where the terminal
//! can. On a pipe there is no prompt, answers go to standard output, pictures to files, and the first line that
//! fails ends the program with code 1.

mod assist;
mod commands;
mod cost;
mod draw;
mod edit;
mod help;
mod paint;
mod plot;
mod render;
mod request;
mod save;
mod slice;
mod topology;
mod zeros;

use super::check::parameters;
use super::interrupt::Interrupt;
use super::pictures::{Screen, Way};
use super::progress::Progress;
use super::report::{Failure, Outcome, Terminal, out};
use crate::diag::Diagnostic;
use crate::field::Watch;
use crate::scene::Scene;
use crate::script::{self, Interpreter, Limits};
use crate::world::Disk;
use commands::Action;
use edit::{Input, Lines};
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::io::{BufRead, IsTerminal};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

/// Ask questions about fields, line by line
///
/// Expressions are answered with their values: fields at points, ranges over boxes, intervals and
/// affine forms. What SCRIPT defines is at hand. Tab completes, with signatures; Ctrl-R searches what was
/// typed before; Enter goes on in another line while a bracket is open, Alt-Enter always; Ctrl-C clears the
/// line or stops an evaluation; Ctrl-D leaves. On a pipe, pictures go to files, and the first line that fails
/// ends it with exit code 1.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  orogen repl
  orogen repl rock.rhai
  echo 'sphere(1.0).at([3, 0, 0])' | orogen repl

In the REPL:
  > let f = sphere(1.0) + 0.1 * gradient(7);
  > f.at([1, 0, 0])                          value at a point
  > f.range(region([0, 0, 0], [1, 1, 1]))    enclosure over a box
  > interval(1, 2) * interval(-1, 1)         interval arithmetic
  > :slice f z=0                             a plane through it, as a picture
  > :plot f along [-2, 0, 0]..[2, 0, 0]      its values along a ray, as a curve
  > :tree f                                  its expression graph
  > :save rock.rhai                          all that, as a script
  > :help                                    commands and names")]
pub struct Args {
    /// Script to load first
    #[arg(value_name = "SCRIPT")]
    script: Option<PathBuf>,

    /// How pictures are shown: kitty, iterm, sixel, blocks (of characters) or none
    /// [default: what the terminal can; none on a pipe]
    #[arg(long, value_name = "HOW", hide_possible_values = true)]
    pictures: Option<Way>,
}

/// Runs the command.
pub fn run(args: &Args, terminal: &Terminal) -> Outcome {
    let live = std::io::stdin().is_terminal();
    let interrupt = if live { Interrupt::patient() } else { Interrupt::listen(|| {}) };
    let root = args.script.as_deref().and_then(Path::parent).map(Path::to_path_buf).unwrap_or_default();
    let interpreter = Interpreter::new(Arc::new(Disk), root, Limits::default(), Some(interrupt.flag()));
    let interpreter = Rc::new(RefCell::new(interpreter.map_err(Failure::Error)?));
    let screen = Screen::new(args.pictures, terminal);
    let (script, own) = (None, BTreeSet::new());
    let mut shell = Shell { interpreter, interrupt, terminal: *terminal, screen, live, script, own };
    if let Some(script) = &args.script
        && shell.load(script).is_err()
        && !live
    {
        return Err(Failure::Reported);
    }
    if live { shell.talk() } else { shell.answer() }
}

/// Whether to go on, or the failure that was reported.
type Step = Result<bool, Failure>;

/// A path without links and detours, if there is something.
fn real(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_path_buf())
}

struct Shell {
    interpreter: Rc<RefCell<Interpreter>>,
    interrupt: Interrupt,
    terminal: Terminal,
    /// Where pictures are shown.
    screen: Screen,
    /// Whether somebody types.
    live: bool,
    /// The script that was loaded last, after which pictures are named.
    script: Option<PathBuf>,
    /// Scripts that were loaded, or saved.
    own: BTreeSet<PathBuf>,
}

impl Shell {
    /// On a terminal.
    fn talk(&mut self) -> Outcome {
        let unusable = |e: rustyline::error::ReadlineError| {
            Failure::error(
                format!("cannot read from the terminal ({e})"),
                "try it on a pipe: echo '1 + 1' | orogen repl",
            )
        };
        let mut lines = Lines::new(self.interpreter.clone(), self.terminal.color).map_err(unusable)?;
        let version = env!("CARGO_PKG_VERSION");
        out(self.terminal.dim(format_args!("orogen {version}. :help says what there is, Ctrl-D leaves.")));
        loop {
            match lines.next().map_err(unusable)? {
                Input::Line(line) => {
                    // What went wrong was said; the next line may be better.
                    if let Ok(false) = self.step(&line) {
                        return Ok(());
                    }
                }
                Input::Cleared => {}
                Input::End => return Ok(()),
            }
        }
    }

    /// On a pipe.
    fn answer(&mut self) -> Outcome {
        let mut pending = String::new();
        for line in std::io::stdin().lock().lines() {
            let line =
                line.map_err(|e| Failure::error(format!("cannot read the input ({e})"), "it must be UTF-8"))?;
            pending += &line;
            let command = pending.trim_start().starts_with(':');
            if !command && self.interpreter.borrow().is_incomplete(&pending) {
                pending.push('\n');
                continue;
            }
            if !self.step(&std::mem::take(&mut pending))? {
                return Ok(());
            }
        }
        self.step(&pending).map(drop)
    }

    /// Answers one input.
    fn step(&mut self, line: &str) -> Step {
        self.interrupt.reset();
        match commands::parse(line) {
            Some(Ok((action, argument))) => self.act(action, argument),
            Some(Err(error)) => Err(self.say(&error)),
            None if line.trim().is_empty() => Ok(true),
            None => {
                let answer = self.interpreter.borrow_mut().eval(line);
                self.show(answer).map(|()| true)
            }
        }
    }

    fn act(&mut self, action: Action, argument: Option<&str>) -> Step {
        let text = argument.unwrap_or_default();
        match action {
            Action::Quit => return Ok(false),
            Action::Help => help::run(self, argument)?,
            Action::Params => {
                let scene = self.interpreter.borrow().scene();
                let list = scene.and_then(|scene| parameters(&scene, ""));
                out(list.unwrap_or_else(|| "no parameters".into()));
            }
            Action::Load => self.load(Path::new(text))?,
            Action::Save => save::run(self, Path::new(text))?,
            Action::Render => render::run(self, argument)?,
            Action::Plot => plot::run(self, text)?,
            Action::Slice => slice::run(self, text)?,
            Action::Tree => {
                let scene = self.solid(argument)?;
                out(script::tree(&scene.graph, scene.surface.field).trim_end());
            }
            Action::Cost => cost::run(self, argument)?,
            Action::Topology => topology::run(self, argument)?,
        }
        Ok(true)
    }

    fn load(&mut self, script: &Path) -> Outcome {
        let answer = self.interpreter.borrow_mut().load(script);
        // On a pipe only questions are answered.
        self.show(if self.live { answer } else { answer.map(|_| None) })?;
        self.script = Some(script.to_path_buf());
        self.own.insert(real(script));
        Ok(())
    }

    /// Shows an answer and what was printed on the way to it.
    fn show(&self, answer: Result<Option<String>, Box<Diagnostic>>) -> Outcome {
        self.interpreter.borrow_mut().output().iter().for_each(out);
        let doubts = self.interpreter.borrow_mut().doubts();
        let sources = self.interpreter.borrow().sources();
        doubts.iter().for_each(|doubt| self.terminal.diagnostic(doubt, &sources));
        match answer {
            Ok(Some(answer)) if self.terminal.color && std::io::stdout().is_terminal() => {
                out(paint::answer(answer.trim_end()));
            }
            Ok(Some(answer)) => out(answer.trim_end()),
            Ok(None) => {}
            Err(error) => return Err(self.say(&error)),
        }
        Ok(())
    }

    /// The scene that an expression means, or the last one.
    fn solid(&self, expression: Option<&str>) -> Result<Scene, Failure> {
        let scene = self.interpreter.borrow_mut().solid(expression);
        self.interpreter.borrow_mut().output().iter().for_each(out);
        scene.map_err(|e| self.say(&e))
    }

    /// Does a long job, with a bar, until Ctrl-C.
    fn watched<T>(
        &self,
        name: &str,
        work: impl FnOnce(&Watch<'_>) -> Result<T, Box<Diagnostic>>,
    ) -> Result<T, Box<Diagnostic>> {
        let progress = Progress::new(&self.terminal, name);
        let flag = self.interrupt.flag();
        let done = work(&Watch { cancel: &flag, progress: &|share| progress.set(share) });
        progress.finish();
        done
    }

    /// Says what went wrong.
    fn say(&self, diagnostic: &Diagnostic) -> Failure {
        self.terminal.diagnostic(diagnostic, &self.interpreter.borrow().sources());
        Failure::Reported
    }
}
