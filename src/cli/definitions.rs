//! `orogen definitions`: what editors need to complete and check scripts.

use super::report::{Failure, Outcome, err, plural};
use crate::diag::Diagnostic;
use crate::script;
use crate::world::atomic;
use std::io::Write;
use std::path::PathBuf;

/// Write a definition file for editors
///
/// Editors with the Rhai language server complete functions of orogen, show what they do and find mistakes while one
/// types, if this file is in the folder of the scripts. It belongs to this version of orogen; write it again after
/// an update.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  orogen definitions                     orogen.d.rhai, here
  orogen definitions -o scripts/orogen.d.rhai")]
pub struct Args {
    /// File to write, which must end in .d.rhai
    #[arg(short, long, value_name = "FILE", default_value = "orogen.d.rhai")]
    output: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let path = &args.output;
    if !path.to_string_lossy().ends_with(".d.rhai") {
        let message =
            format!("`{}` does not end in .d.rhai, so that no editor would look at it", path.display());
        return Err(Failure::usage(message, "for example: -o orogen.d.rhai"));
    }
    let entries = script::reference();
    let text = script::definitions(&entries);
    atomic::write(path, |out| out.write_all(text.as_bytes()))
        .map_err(|e| Diagnostic::error(e.to_string()))?;
    err(format_args!("{}: {}", path.display(), plural(entries.len() as u64, "function")));
    Ok(())
}
