//! `orogen explore`: many pictures of a script, each with other parameters, on a page or in files.

mod files;
mod page;
mod routes;
mod still;
mod told;

use super::options::{ScriptOptions, Size};
use super::progress::Progress;
use super::report::{Failure, Outcome, Terminal};
use super::serve::Listen;
use super::work;
use crate::session::Session;
use crate::session::explore::{self, Gallery, MOST, Space, Subject};
use crate::world::Disk;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Find out what the parameters of a script can do
///
/// Serves a page to this machine's browsers: small pictures of the script, each with other parameters, taken evenly from
/// their ranges. Star those that you like; then narrow, for more from around them, or breed, for children that have each
/// value from one of two favourites, some of them a little changed. On request children differ in expressions of the
/// script as well: in a number, an operation, or a subtree that is exchanged for another one of the same kind, also one of
/// the other parent. Every picture can be seen large, and saved as a script with its values as the defaults. The same seed
/// and the same choices give the same pictures. Ctrl-C ends it.
///
/// With --headless there is no page: the first pictures are written into a folder, with a page that shows them and their
/// values as JSON.
#[derive(clap::Args, Clone)]
#[command(after_help = "Examples:
  orogen explore castle.rhai
  orogen explore castle.rhai --set evening=12   one parameter stays as it is
  orogen explore castle.rhai --seed 2           other pictures
  orogen explore castle.rhai --headless -o castles --count 100

Parameters are what the script makes with param(name, default, range), and colours, names and switches
likewise. Those whose range spans a thousandfold or more are taken evenly from its logarithms.")]
pub struct Args {
    /// Script to explore
    #[arg(value_name = "SCRIPT")]
    script: PathBuf,

    /// Pictures in a generation
    #[arg(long, value_name = "N", default_value = "24", value_parser = pictures)]
    count: usize,

    /// Another seed gives other pictures
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,

    /// Width and height of the small pictures in pixels [default: 240 wide, shaped as the script's picture]
    #[arg(long, value_name = "WxH", value_parser = small)]
    size: Option<Size>,

    #[command(flatten)]
    scripting: ScriptOptions,

    /// Serves no page and writes the pictures to files
    #[arg(long, conflicts_with_all = ["port", "address", "open"], requires = "output")]
    headless: bool,

    /// Folder for the files of --headless; made if it does not exist
    #[arg(short, long, value_name = "FOLDER", requires = "headless")]
    output: Option<PathBuf>,

    #[command(flatten)]
    listen: Listen,
}

/// Width of a small picture, unless another is asked for.
const WIDTH: u32 = 240;

/// Largest side of a small picture: hundreds of them are in memory.
const LARGEST: u32 = 1024;

/// Parses how many pictures a generation has.
fn pictures(text: &str) -> Result<usize, String> {
    let count = text.trim().parse().ok().filter(|n| (1..=MOST).contains(n));
    count.ok_or(format!("a number from 1 to {MOST} is needed; for example: --count 24"))
}

/// Parses the size of small pictures.
fn small(text: &str) -> Result<Size, String> {
    let size: Size = text.parse()?;
    if size.width.max(size.height) > LARGEST {
        return Err(format!("each side must be at most {LARGEST} pixels; for example: --size 240x180"));
    }
    Ok(size)
}

/// Runs the command.
pub fn run(args: &Args, terminal: &Terminal) -> Outcome {
    match &args.output {
        Some(folder) => files::run(args, folder, terminal),
        None => page::run(args, terminal),
    }
}

/// What there is to begin with.
struct Beginning {
    subject: Subject,
    gallery: Gallery,
    /// Width and height of small pictures.
    size: (u32, u32),
}

/// Reads the script, and takes the first generation from its space.
fn begin(
    args: &Args,
    terminal: &Terminal,
    progress: Option<&Progress>,
    cancel: &Arc<AtomicBool>,
) -> Result<Beginning, Failure> {
    let mut session = Session::new(&args.script, Arc::new(Disk));
    explore::freeze(&mut session);
    session.set(args.scripting.params()?, args.scripting.time);
    let loaded = session.load(cancel);
    let say = || work::report(&loaded, terminal);
    let scene = progress.map_or_else(say, |p| p.aside(say)).ok_or(Failure::Reported)?;
    let subject = Subject::new(session, loaded.clone(), scene);
    let space = Space::new(subject.params(), &subject.fixed());
    if space.axes.is_empty() {
        return Err(nothing_to_vary(&args.script, &subject));
    }
    let (width, height) = args.size.map_or_else(|| subject.size(WIDTH), |size| (size.width, size.height));
    let gallery = Gallery::new(space, args.count, args.seed);
    Ok(Beginning { subject, gallery, size: (width, height.min(LARGEST)) })
}

/// Why there is nothing to explore.
fn nothing_to_vary(script: &Path, subject: &Subject) -> Failure {
    let script = script.display();
    if subject.params().is_empty() {
        let hint = "make one with param(name, default, range), such as `let relief = param(\"relief\", 0.02, 0.0..0.1);`";
        Failure::error(format!("{script} has no parameters to explore"), hint)
    } else if subject.fixed().is_empty() {
        let hint = "each has only one value; give them wider ranges, or more names";
        Failure::error(format!("the parameters of {script} cannot vary"), hint)
    } else {
        Failure::error(format!("--set leaves no parameter of {script} to vary"), "leave one of them out")
    }
}
