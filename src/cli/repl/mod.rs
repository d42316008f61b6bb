//! `orogen repl`: questions and answers.
//!
//! On a terminal lines are edited, completed and remembered. On a pipe there is no prompt, answers
//! go to standard output, and the first line that fails ends the program with code 1.

mod commands;
mod edit;

use super::check::parameters;
use super::interrupt::Interrupt;
use super::progress::Progress;
use super::report::{Failure, Outcome, Terminal, err, out};
use super::work;
use crate::diag::Diagnostic;
use crate::render::{self, Job, Metadata};
use crate::script::{self, Interpreter, Limits};
use crate::session::{self, Order};
use crate::world::Disk;
use commands::Action;
use edit::{Input, Lines};
use std::cell::RefCell;
use std::io::{BufRead, IsTerminal};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;
use std::time::Instant;

/// Ask questions about fields, line by line
///
/// Expressions are answered with their values: fields at points, ranges over boxes, intervals and
/// affine forms. What SCRIPT defines is at hand. Tab completes; Ctrl-C clears the line or stops an
/// evaluation; Ctrl-D leaves. On a pipe, the first line that fails ends it with exit code 1.
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
  > :help                                    commands and names")]
pub struct Args {
    /// Script to load first
    #[arg(value_name = "SCRIPT")]
    script: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &Args, terminal: &Terminal) -> Outcome {
    let interrupt = Interrupt::listen(|| {});
    let root = args.script.as_deref().and_then(Path::parent).map(Path::to_path_buf).unwrap_or_default();
    let interpreter = Interpreter::new(Arc::new(Disk), root, Limits::default(), Some(interrupt.flag()));
    let interpreter = Rc::new(RefCell::new(interpreter.map_err(Failure::Error)?));
    let live = std::io::stdin().is_terminal();
    let mut shell = Shell { interpreter, interrupt, terminal: *terminal, live, script: None };
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

struct Shell {
    interpreter: Rc<RefCell<Interpreter>>,
    interrupt: Interrupt,
    terminal: Terminal,
    /// Whether somebody types.
    live: bool,
    /// The script that was loaded last, after which pictures are named.
    script: Option<PathBuf>,
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
        match (action, argument) {
            (Action::Quit, _) => return Ok(false),
            (Action::Help, None) => {
                out(overview(&self.terminal));
            }
            (Action::Help, Some(name)) => self.help(name)?,
            (Action::Params, _) => {
                let scene = self.interpreter.borrow().scene();
                let list = scene.and_then(|scene| parameters(&scene, ""));
                out(list.unwrap_or_else(|| "no parameters".into()));
            }
            (Action::Load, file) => self.load(Path::new(file.unwrap_or_default()))?,
            (Action::Render, file) => self.render(file)?,
        }
        Ok(true)
    }

    fn load(&mut self, script: &Path) -> Outcome {
        let answer = self.interpreter.borrow_mut().load(script);
        // On a pipe only questions are answered.
        self.show(if self.live { answer } else { answer.map(|_| None) })?;
        self.script = Some(script.to_path_buf());
        Ok(())
    }

    /// Shows an answer and what was printed on the way to it.
    fn show(&self, answer: Result<Option<String>, Box<Diagnostic>>) -> Outcome {
        self.interpreter.borrow_mut().output().iter().for_each(out);
        match answer {
            Ok(Some(answer)) => out(answer.trim_end()),
            Ok(None) => {}
            Err(error) => return Err(self.say(&error)),
        }
        Ok(())
    }

    fn render(&self, file: Option<&str>) -> Outcome {
        let stem = self.script.as_deref().and_then(Path::file_stem).unwrap_or("repl".as_ref());
        let path = file.map_or_else(|| Path::new(stem).with_extension("png"), PathBuf::from);
        let scene = self.interpreter.borrow().scene().ok_or_else(|| {
            self.say(&Diagnostic::error("there is nothing to render yet").hint("for example: sphere(1.0)"))
        })?;
        render::can_save(&path).map_err(|e| self.say(&Diagnostic::error(e.to_string())))?;
        let start = Instant::now();
        let progress = Progress::new(&self.terminal, &path.display().to_string());
        let step = |p: render::Progress| progress.set(p.done as f64 / p.total.max(1) as f64);
        let flag = self.interrupt.flag();
        let job = Job { progress: &step, ..Job::unwatched(&flag) };
        let picture = session::render(&scene, &Order::default(), &job);
        progress.finish();
        let picture = picture.map_err(|error| self.say(&error))?;
        if !picture.finished {
            return Err(self.say(&Diagnostic::error("stopped; no file was written")));
        }
        for warning in &picture.warnings {
            self.say(warning);
        }
        render::save(&path, &picture, &Metadata::default())
            .map_err(|e| self.say(&Diagnostic::error(e.to_string())))?;
        err(work::summary(&path, &picture, start.elapsed().as_secs_f64()));
        Ok(())
    }

    fn help(&self, name: &str) -> Outcome {
        let text = self.interpreter.borrow().help(name);
        if let Some(text) = text {
            out(text.trim_end());
            return Ok(());
        }
        // A variable explains itself by its value.
        let known = self.interpreter.borrow().names().iter().any(|known| known == name);
        if known {
            let answer = self.interpreter.borrow_mut().eval(name);
            return self.show(answer);
        }
        let interpreter = self.interpreter.borrow();
        let error = Diagnostic::error(format!("nothing is called `{name}`"));
        Err(match interpreter.nearest(name) {
            Some(near) => self.say(&error.hint(format!("did you mean `{near}`?"))),
            None => self.say(&error.hint(":help alone lists what there is")),
        })
    }

    /// Says what went wrong.
    fn say(&self, diagnostic: &Diagnostic) -> Failure {
        self.terminal.diagnostic(diagnostic, &self.interpreter.borrow().sources());
        Failure::Reported
    }
}

/// Commands, and the names of all functions by group.
fn overview(terminal: &Terminal) -> String {
    let mut groups: Vec<(String, Vec<String>)> = Vec::new();
    for entry in script::reference() {
        match groups.iter_mut().find(|(group, _)| *group == entry.group) {
            Some((_, names)) => names.push(entry.name),
            None => groups.push((entry.group, vec![entry.name])),
        }
    }
    let mut text = format!("{}\n{}", terminal.bold("Commands"), commands::help());
    for (group, mut names) in groups {
        names.dedup();
        text += &format!("\n{}\n{}", terminal.bold(group), wrapped(&names));
    }
    text + "\n\n:help NAME explains a name, a module or a word, for example :help sphere, :help fractal, :help hurst"
}

/// Words in lines of a screen's width.
fn wrapped(words: &[String]) -> String {
    let mut lines = vec![String::from(" ")];
    for word in words {
        if lines.last().is_some_and(|line| line.len() + word.len() > 78) {
            lines.push(" ".into());
        }
        if let Some(line) = lines.last_mut() {
            *line += &format!(" {word}");
        }
    }
    lines.join("\n")
}
