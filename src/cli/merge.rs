//! `orogen merge`: parts of a picture to the whole.

use super::options::picture_path;
use super::report::{Failure, Outcome, err, plural};
use super::work::is_same;
use crate::diag::Diagnostic;
use crate::render::{self, Saved};
use std::path::PathBuf;

/// Put parts of a picture together
///
/// Parts are what `orogen render` makes with --tile or --region, on this machine or on others, .png or .exr. The result
/// is, byte for byte, the picture that is rendered whole. Parts must be of the same picture: its size, script, files,
/// parameters and options are compared; and they must have no pixel in common and leave none out.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  orogen render rock.rhai --tile 1/2       on one machine, to rock.1of2.png
  orogen render rock.rhai --tile 2/2       on another, to rock.2of2.png
  orogen merge rock.?of2.png -o rock.png   and together

  for n in $(seq -w 0001 0250); do         the frames of an animation in two parts each
    orogen merge rock.$n.?of2.exr -o rock.$n.exr
  done")]
pub struct Args {
    /// Parts, in any order
    #[arg(value_name = "PART", required = true)]
    parts: Vec<PathBuf>,

    /// Picture to write, with the ending of its parts
    #[arg(short, long, value_name = "WHOLE")]
    output: PathBuf,
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let output = picture_path(args.output.clone())?;
    let error = |message: String| Diagnostic::error(message);
    render::can_save(&output).map_err(|e| error(e.to_string()))?;
    if args.parts.iter().any(|part| is_same(part, &output)) {
        let message = format!("{} is one of the parts, and would be lost", output.display());
        return Err(Failure::usage(message, "choose another name for the whole with -o"));
    }
    let parts: Result<Vec<Saved>, _> = args.parts.iter().map(|part| Saved::open(part)).collect();
    let parts = parts.map_err(|e| error(e.to_string()))?;
    let whole = render::merge(&parts, &output).map_err(|e| error(e.to_string()))?;
    let (width, height) = (whole.about.width, whole.about.height);
    whole.write().map_err(|e| error(e.to_string()))?;
    err(format!("{}: {width}x{height}, {}", output.display(), plural(parts.len() as u64, "part")));
    Ok(())
}
