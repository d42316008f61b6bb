//! `orogen grid`: a field sampled on a volume, for other programs.

use super::options::{self, ScriptOptions};
use super::report::{Failure, Outcome, Terminal, count, err, plural, seconds};
use super::work::{self, Conversion};
use crate::diag::Diagnostic;
use crate::exchange::{grid as file, image};
use crate::field::Watch;
use crate::grid::Samples;
use crate::session::{self, Lattice};
use crate::world::atomic::{self, FileSet, WriteError};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Sample a script's field on a volume
///
/// Writes the values of the field (negative inside) at the points of a lattice that fills the bounds of the solid. A
/// .json is a header beside a .raw with 32-bit numbers, x first, then y, then z; `load_grid` reads it again. An .exr
/// becomes one picture for each level of y, seen from above: cloud.0000.exr and so on. Inside of components that the script
/// leaves out, values have the other sign.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  orogen grid cloud.rhai -o cloud.json              64 samples along the longest edge
  orogen grid cloud.rhai -o cloud.exr --size 256    256 slices or fewer")]
pub struct Args {
    /// Script of the field
    #[arg(value_name = "SCRIPT")]
    script: PathBuf,

    /// Files to write: .json (with a .raw beside it) or .exr (slices)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,

    /// Samples along the longest edge
    #[arg(long, value_name = "N", default_value = "64", value_parser = clap::value_parser!(u32).range(2..=4096))]
    size: u32,

    #[command(flatten)]
    scripting: ScriptOptions,

    /// Threads to use [default: one per processor core]; the values do not depend on it
    #[arg(long, value_name = "N", value_parser = options::threads)]
    threads: Option<NonZeroUsize>,
}

/// What is written.
enum Form {
    Raw,
    Slices,
}

/// Runs the command.
pub fn run(args: &Args, terminal: &Terminal) -> Outcome {
    let start = Instant::now();
    let form = Form::of(&args.output)?;
    // Before anything is computed, as far as it is known what will be written.
    form.check(&args.output, 1)?;
    let Conversion { loaded, scene, progress, flag } =
        Conversion::begin(&args.script, &args.scripting, &args.output, terminal)?;
    let lattice = Lattice::over(&scene, args.size).map_err(|e| work::failure(e, &loaded, terminal))?;
    let [x, y, z] = lattice.frame().size;
    form.check(&args.output, y)?;
    work::spare(&loaded, form.files(&args.output, y).iter().map(PathBuf::as_path))?;
    let watch = Watch { cancel: &flag, progress: &|share| progress.set(share) };
    let samples = session::on_threads(args.threads, || lattice.sample(&watch));
    let sampled = samples.and_then(|s| s).map_err(|error| {
        progress.finish();
        work::failure(error, &loaded, terminal)
    })?;
    progress
        .aside(|| sampled.warnings.iter().for_each(|warning| terminal.diagnostic(warning, &loaded.sources)));
    progress.restart(&format!("files of {}", args.output.display()));
    let written = form.write(&sampled.samples, &args.output, &watch);
    progress.finish();
    let files = written?;
    if let Some(older) = form.older(&args.output, y) {
        let warning = format!("slices of a higher grid are still there, from {} on", older.display());
        terminal.diagnostic(
            &Diagnostic::warning(warning)
                .hint("programs that read numbered slices may take them as well: remove them"),
            &loaded.sources,
        );
    }
    let left_out = match sampled.left_out {
        0 => String::new(),
        n => format!(", {} inside of what is left out", count(n)),
    };
    err(format_args!(
        "{}: {x} x {y} x {z} samples in {}{left_out}, {}",
        args.output.display(),
        plural(files, "file"),
        seconds(start.elapsed().as_secs_f64())
    ));
    Ok(())
}

impl Form {
    fn of(path: &Path) -> Result<Form, Failure> {
        match path.extension().and_then(|e| e.to_str()) {
            Some("json") => Ok(Form::Raw),
            Some("exr") => Ok(Form::Slices),
            _ => {
                let message = format!("`{}` does not end in .json or .exr", path.display());
                let hint = format!("for example: -o {}", path.with_extension("json").display());
                Err(Failure::usage(message, hint))
            }
        }
    }

    /// The files of a lattice of so many levels, in the order in which they appear: a header last, so
    /// that there is none without its numbers.
    fn files(&self, path: &Path, levels: usize) -> Vec<PathBuf> {
        match self {
            Form::Raw => vec![path.with_extension("raw"), path.to_owned()],
            Form::Slices => (0..levels).map(|level| path.with_extension(format!("{level:04}.exr"))).collect(),
        }
    }

    /// The first slice above these levels, if there is one from before.
    fn older(&self, path: &Path, levels: usize) -> Option<PathBuf> {
        match self {
            Form::Raw => None,
            Form::Slices => self.files(path, levels + 1).pop().filter(|next| next.exists()),
        }
    }

    fn check(&self, path: &Path, levels: usize) -> Outcome {
        for file in self.files(path, levels) {
            atomic::check(&file).map_err(|e| Diagnostic::error(e.to_string()))?;
        }
        Ok(())
    }

    /// Writes all files, or none if it is stopped, and says how many there are.
    fn write(&self, samples: &Samples, path: &Path, watch: &Watch<'_>) -> Result<u64, Failure> {
        let failed = |e: WriteError| Diagnostic::error(e.to_string());
        let files = self.files(path, samples.frame.size[1]);
        let mut set = FileSet::default();
        for (i, path) in files.iter().enumerate() {
            if watch.cancel.load(Ordering::Relaxed) {
                return Err(Failure::error("stopped before it was finished", "no file was written"));
            }
            let fill = |out: &mut BufWriter<&mut File>| match (self, i) {
                (Form::Raw, 0) => file::write(samples, out),
                (Form::Raw, _) => out.write_all(file::header(samples).as_bytes()),
                (Form::Slices, i) => {
                    file::slice(samples, i).map_or(Ok(()), |slice| image::write(&slice, out))
                }
            };
            set.add(path, fill).map_err(failed)?;
            (watch.progress)((i + 1) as f64 / files.len() as f64);
        }
        set.commit().map_err(failed)?;
        Ok(files.len() as u64)
    }
}
