//! `orogen new`: a script to start from.

use super::report::{Failure, Outcome, err, quoted};
use crate::diag::Diagnostic;
use crate::world::atomic::{self, WriteError};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

const STARTER: &str = include_str!("starter.rhai");

/// Create a commented script to start from
#[derive(clap::Args)]
#[command(after_help = "Examples:
  orogen new rock               creates rock.rhai here
  orogen new scenes/moon.rhai   creates moon.rhai in the folder scenes")]
pub struct Args {
    /// Name of the script; may have a folder in front and .rhai behind
    #[arg(value_name = "NAME")]
    name: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let path = script_path(&args.name)?;
    let shown = path.display();
    if path.symlink_metadata().is_ok() {
        return Err(refusal(&path, &ErrorKind::AlreadyExists.into()));
    }
    atomic::write(&path, |file| file.write_all(STARTER.as_bytes())).map_err(|error| match error {
        WriteError::NoFolder(_) => refusal(&path, &ErrorKind::NotFound.into()),
        WriteError::Folder { source, .. } | WriteError::Other { source, .. } => refusal(&path, &source),
        other => Diagnostic::error(other.to_string()).into(),
    })?;
    let typed = quoted(&path);
    err(format_args!(
        "created {shown}\n\n\
         Try:\n  \
         orogen watch {typed}     makes a picture, and again at each save while you edit\n  \
         orogen render {typed}    makes the final picture\n  \
         orogen repl {typed}      asks questions about its fields"
    ));
    Ok(())
}

/// The file that a name stands for.
fn script_path(name: &Path) -> Result<PathBuf, Failure> {
    let shown = name.display();
    let stem = match name.extension() {
        None => name.file_name(),
        Some(e) if e == "rhai" => name.file_stem(),
        Some(_) => {
            let hint = format!("leave it out: orogen new {}", quoted(&name.with_extension("")));
            return Err(Failure::usage(format!("`{shown}` has an ending other than .rhai"), hint));
        }
    };
    let stem = stem.and_then(|s| s.to_str()).unwrap_or_default();
    let plain = |c: char| c.is_alphanumeric() || "-_ ".contains(c);
    let trailing_slash = name.as_os_str().to_string_lossy().ends_with(std::path::is_separator);
    if stem.trim().is_empty() || stem.starts_with('-') || !stem.chars().all(plain) || trailing_slash {
        let hint = "a name has letters, digits, - and _, for example: orogen new rock";
        return Err(Failure::usage(format!("`{shown}` is no name for a script"), hint));
    }
    Ok(name.with_extension("rhai"))
}

fn refusal(path: &Path, error: &std::io::Error) -> Failure {
    let shown = path.display();
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new(".")).display();
    match error.kind() {
        ErrorKind::AlreadyExists => Failure::error(
            format!("{shown} is there already, and stays as it is"),
            format!("choose another name, or see what it makes: orogen render {}", quoted(path)),
        ),
        ErrorKind::NotFound => Failure::error(
            format!("the folder {folder} does not exist"),
            format!("create it: mkdir -p {folder}"),
        ),
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            Failure::error(format!("cannot write into the folder {folder}"), "choose a folder that is yours")
        }
        _ => Failure::error(format!("cannot create {shown} ({error})"), "choose another place for it"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_files() {
        let path = |name: &str| script_path(Path::new(name)).map_err(|_| "refused");
        assert_eq!(path("rock"), Ok("rock.rhai".into()));
        assert_eq!(path("a/rock.rhai"), Ok("a/rock.rhai".into()));
        for bad in ["", ".", "..", "a/", "rock.png", ".rhai", "a*b", "-x", " "] {
            assert_eq!(path(bad), Err("refused"), "{bad}");
        }
    }
}
