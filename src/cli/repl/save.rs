//! `:save`: the session as a script, whether that runs, and whether it comes to the same.

use super::Shell;
use crate::cli::report::{Failure, Outcome, out};
use crate::diag::Diagnostic;
use crate::session::Session;
use crate::world::{Disk, atomic};
use std::io::Write;
use std::path::{Path, PathBuf};
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
    let before = kept(shell, path)?;
    let written = atomic::write(path, |f| f.write_all(script.as_bytes()));
    written.map_err(|e| shell.say(&Diagnostic::error(e.to_string())))?;
    shell.own.insert(path.to_path_buf());
    let before = before.map(|kept| format!("; what was there before is {} now", kept.display()));
    out(format_args!("{}: {} lines{}", path.display(), script.lines().count(), before.unwrap_or_default()));
    let loaded = Session::new(path, Arc::new(Disk)).load(&shell.interrupt.flag());
    for diagnostic in &loaded.diagnostics {
        shell.terminal.diagnostic(diagnostic, &loaded.sources);
    }
    // A file that is wrong is of more use than none, as long as that is said.
    let strays = shell.interpreter.borrow_mut().strays(&script);
    strays.map_or(Ok(()), |error| Err(shell.say(&error)))
}

/// Moves a file out of the way that the session has neither loaded nor saved; its new name.
fn kept(shell: &Shell, path: &Path) -> Result<Option<PathBuf>, Failure> {
    if shell.own.contains(path) || !path.is_file() {
        return Ok(None);
    }
    let mut name = path.as_os_str().to_owned();
    name.push("~");
    let kept = PathBuf::from(name);
    let moved = std::fs::rename(path, &kept);
    moved.map_err(|e| {
        let message = format!("cannot rename {} to {} ({e})", path.display(), kept.display());
        shell.say(&Diagnostic::error(message).hint("save it under another name"))
    })?;
    Ok(Some(kept))
}
