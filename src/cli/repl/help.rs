//! `:help`: what there is, and what names mean.

use super::{Shell, commands};
use crate::cli::report::{Outcome, Terminal, out};
use crate::diag::Diagnostic;
use crate::script;
use crate::script::help::{elsewhere, wrapped};

/// Explains a name, or lists everything.
pub fn run(shell: &Shell, name: Option<&str>) -> Outcome {
    match name {
        None => out(overview(&shell.terminal)),
        Some(command) if command.starts_with(':') => {
            let found = commands::find(command).map_err(|e| shell.say(&e))?;
            out(found.help().trim_end());
        }
        Some(name) => explain(shell, name)?,
    }
    Ok(())
}

fn explain(shell: &Shell, name: &str) -> Outcome {
    let text = shell.interpreter.borrow().help(name);
    if let Some(text) = text {
        out(text.trim_end());
        return Ok(());
    }
    // A variable explains itself by its value.
    let known = shell.interpreter.borrow().names().iter().any(|known| known == name);
    if known {
        let answer = shell.interpreter.borrow_mut().eval(name);
        return shell.show(answer);
    }
    if let Ok(command) = commands::find(&format!(":{name}")) {
        out(command.help().trim_end());
        return Ok(());
    }
    let interpreter = shell.interpreter.borrow();
    let error = Diagnostic::error(format!("nothing is called `{name}`"));
    Err(match (elsewhere(name), interpreter.nearest(name)) {
        (Some(here), _) => shell.say(&error.hint(format!("here that is {here}"))),
        (None, Some(near)) => shell.say(&error.hint(format!("did you mean `{near}`?"))),
        (None, None) => shell.say(&error.hint(":help alone lists what there is")),
    })
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
        text += &format!("\n{}\n  {}", terminal.bold(group), wrapped(&names.join(" ")).join("\n  "));
    }
    text + "\n\n:help NAME explains a name, a module, a word or a command, for example :help sphere, :help fractal,\n\
            :help hurst, :help :slice"
}
