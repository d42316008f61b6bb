//! `:save`: the session as a script, whether that runs, and whether it comes to the same.

use super::{Shell, real};
use crate::cli::report::{Outcome, out};
use crate::diag::Diagnostic;
use crate::session::Session;
use crate::world::{Disk, atomic};
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

/// Writes the script, and runs it for a test. A file that the session knows nothing of is kept under another name.
pub fn run(shell: &mut Shell, path: &Path) -> Outcome {
    if path.extension().is_none_or(|ending| ending != "rhai") {
        let error = Diagnostic::error(format!("`{}` does not end in .rhai", path.display()));
        return Err(
            shell.say(&error.hint(format!("for example: :save {}", path.with_extension("rhai").display())))
        );
    }
    let script = shell.interpreter.borrow().script().ok_or_else(|| {
        shell
            .say(&Diagnostic::error("there is nothing to save yet").hint("for example: let f = sphere(1.0);"))
    })?;
    let is_own = shell.own.contains(&real(path));
    let before = if is_own { Ok(None) } else { atomic::back_up(path) };
    let written = before.and_then(|kept| {
        atomic::write(path, |f| f.write_all(script.as_bytes()))?;
        Ok(kept)
    });
    let before = written.map_err(|e| shell.say(&Diagnostic::error(e.to_string())))?;
    shell.own.insert(real(path));
    let before = before.map(|kept| format!("; what was there before is in {} now", kept.display()));
    out(format_args!("{}: {} lines{}", path.display(), script.lines().count(), before.unwrap_or_default()));
    let loaded = Session::new(path, Arc::new(Disk)).load(&shell.interrupt.flag());
    for diagnostic in &loaded.diagnostics {
        shell.terminal.diagnostic(diagnostic, &loaded.sources);
    }
    // A file that is wrong is of more use than none, as long as that is said.
    let strays = shell.interpreter.borrow_mut().strays(&script);
    strays.map_or(Ok(()), |error| Err(shell.say(&error)))
}
