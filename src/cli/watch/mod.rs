//! `orogen watch`: a picture that follows its script, in a browser or as a file.

mod client;
mod files;
mod page;
mod routes;

use super::options::{PictureOptions, ScriptOptions, statistics_path};
use super::report::{Failure, Outcome, Terminal};
use super::serve::Listen;
use super::work::Work;
use crate::session::Session;
use crate::world::Disk;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// Show a script's picture while you edit it
///
/// Serves a page to this machine's browsers: the picture, rough at once and then ever better, with sliders for the
/// parameters, a camera to move, and errors with their lines. It follows every save of the script and of all that the
/// script reads, and keeps the camera and the sliders. Ctrl-C ends the watch.
///
/// With --headless there is no page: the picture is written to a file after each save. A script with an error leaves
/// the last good picture in place.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  orogen watch rock.rhai
  orogen watch rock.rhai --size 1280x720 --set relief=0.04
  orogen watch rock.rhai --headless -o /tmp/rock.png

Open the address that it prints in a browser, or let --open do that. It holds a secret of this run: whoever has it can steer the picture, and
write the parameters into the script.")]
pub struct Args {
    /// Script to watch
    #[arg(value_name = "SCRIPT")]
    script: PathBuf,

    #[command(flatten)]
    picture: PictureOptions,

    #[command(flatten)]
    scripting: ScriptOptions,

    /// Serves no page and writes the picture to a file
    #[arg(long, conflicts_with_all = ["port", "address", "open"])]
    headless: bool,

    #[command(flatten)]
    listen: Listen,

    /// Writes statistics of each full picture to a file, with --headless
    #[arg(long, value_name = "FILE.json", value_parser = statistics_path, requires = "headless")]
    stats: Option<PathBuf>,
}

/// How often files are looked at where the system may not tell of changes, such as on network
/// drives.
const POLL: Duration = Duration::from_millis(1000);

/// Runs the command.
pub fn run(args: &Args, terminal: &Terminal) -> Outcome {
    if args.picture.output.is_some() && !args.headless {
        let hint = "add --headless; the page has a button that saves the picture";
        return Err(Failure::usage("a page writes no file", hint));
    }
    let session = Session::new(&args.script, Arc::new(Disk));
    let work = Work::new(session, &args.scripting, &args.picture, args.stats.as_deref())?;
    if args.headless { files::run(work, terminal) } else { page::run(args, work, terminal) }
}
