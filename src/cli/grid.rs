//! `orogen grid`: a field sampled on a volume, for other programs.

use super::interrupt::Interrupt;
use super::options::{self, ScriptOptions};
use super::progress::Progress;
use super::report::{Failure, Outcome, Terminal, err, plural, seconds};
use super::work;
use crate::diag::Diagnostic;
use crate::exchange::{grid as file, image};
use crate::field::Field;
use crate::grid::{Edge, Frame, Samples};
use crate::scene::{Aabb, Scene};
use crate::session::{self, Session};
use crate::world::{Disk, atomic};
use std::io::Write;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Sample a script's field on a volume
///
/// Writes the values of the field (negative inside) at the points of a lattice that fills the bounds of the solid. A
/// .json is a header beside a .raw with 32-bit numbers, x first, then y, then z; `load_grid` reads it again. An .exr
/// becomes one picture for each level of y, seen from above: cloud.0000.exr and so on.
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
    let form = form(&args.output)?;
    atomic::check(&args.output).map_err(|e| Diagnostic::error(e.to_string()))?;
    let mut session = Session::new(&args.script, Arc::new(Disk));
    session.set(args.scripting.params()?, args.scripting.time);
    let progress = Progress::new(terminal, &args.output.display().to_string());
    let interrupt = Interrupt::listen(|| {});
    let flag = interrupt.flag();
    let loaded = session.load(&flag);
    let scene = progress.aside(|| work::report(&loaded, terminal)).ok_or(Failure::Reported)?;
    let cancel = || flag.load(Ordering::Relaxed);
    let samples = session::on_threads(args.threads, || sample(&scene, args.size, &cancel));
    progress.finish();
    let samples = samples.map_err(Failure::Error)??;
    let files = match form {
        Form::Raw => write_raw(&samples, &args.output)?,
        Form::Slices => write_slices(&samples, &args.output)?,
    };
    let [x, y, z] = samples.frame.size;
    let elapsed = seconds(start.elapsed().as_secs_f64());
    err(format_args!(
        "{}: {x} x {y} x {z} samples in {}, {elapsed}",
        args.output.display(),
        plural(files, "file")
    ));
    Ok(())
}

fn form(path: &Path) -> Result<Form, Failure> {
    match path.extension().and_then(|e| e.to_str()) {
        Some("json") => Ok(Form::Raw),
        Some("exr") => Ok(Form::Slices),
        _ => {
            let message = format!("`{}` does not end in .json or .exr", path.display());
            Err(Failure::usage(message, format!("for example: -o {}", path.with_extension("json").display())))
        }
    }
}

/// The field at the points of a lattice of cubes over the bounds of a scene.
fn sample(scene: &Scene, size: u32, cancel: &(dyn Fn() -> bool + Sync)) -> Result<Samples, Failure> {
    let mut field = Field::new(&scene.graph, scene.surface.field);
    let Aabb { min, max } = scene.bounds.unwrap_or_else(|| session::bounds(scene, &mut field));
    let step = (max - min).max_element() / f64::from(size - 1);
    // The last sample along the longest edge is its end, whatever rounding says.
    let count = ((max - min) / step - 1e-9).ceil().to_array().map(|n| n as usize + 1);
    let frame = Frame { size: count, origin: min.to_array(), spacing: [step; 3], edge: Edge::Clamp };
    Samples::of(frame, move |at| field.value(at.into()), cancel)
        .map_err(|failure| Failure::error(failure.to_string(), "choose a smaller --size"))
}

fn write_raw(samples: &Samples, header: &Path) -> Result<u64, Failure> {
    let data = PathBuf::from(file::data_name(&header.to_string_lossy()));
    let failed = |e: atomic::WriteError| Diagnostic::error(e.to_string());
    // The header last, so that there is none without its numbers.
    atomic::write(&data, |out| file::write(samples, out)).map_err(failed)?;
    atomic::write(header, |out| out.write_all(file::header(&samples.frame).as_bytes())).map_err(failed)?;
    Ok(2)
}

fn write_slices(samples: &Samples, path: &Path) -> Result<u64, Failure> {
    let slices = (0..).map_while(|level| file::slice(samples, level));
    let mut count = 0;
    for slice in slices {
        let path = path.with_extension(format!("{count:04}.exr"));
        atomic::write(&path, |out| image::write(&slice, out))
            .map_err(|e| Diagnostic::error(e.to_string()))?;
        count += 1;
    }
    Ok(count)
}
