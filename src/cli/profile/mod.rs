//! `orogen profile`: what the lines of a script cost, and which make its field steep.

mod table;

use super::options::{ScriptOptions, Size};
use super::report::{Failure, Outcome, Terminal, err, out, plural, seconds};
use super::work::{self, Conversion};
use crate::diag::Diagnostic;
use crate::field::Watch;
use crate::session::Order;
use crate::session::profile::{Profile, profile};
use crate::world::atomic;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;
use table::Table;

/// Find out what the lines of a script cost
///
/// Measures which lines the time goes to that it takes to evaluate the solid and its colours, where the picture shows
/// them and in as much detail; says which lines force up the bound of its slope, by which rays take their steps; and
/// gives hints. An expression belongs to the line that wrote it first, and what the standard library makes of it to
/// the line that it is made for. Times differ a little from run to run.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  orogen profile rock.rhai
  orogen profile rock.rhai --top 30           more lines
  orogen profile rock.rhai --size 3840x2160   in as much detail as a larger picture shows
  orogen profile rock.rhai --set octaves=5 --json rock.json

Solid and colours have tables of their own. The bound is what is certain of the slope in boxes of 8
pixels around the surface, on average; `without` is what it would be if the line did not vary, and
`loose` how many times as steep as in samples the line may be for all that is certain.")]
pub struct Args {
    /// Script to measure
    #[arg(value_name = "SCRIPT")]
    script: PathBuf,

    /// Lines in each table; 0 for all
    #[arg(long, value_name = "N", default_value = "10", value_parser = lines, allow_hyphen_values = true)]
    top: usize,

    /// Writes all of it as JSON; - for standard output
    #[arg(long, value_name = "FILE.json", value_parser = json_path)]
    json: Option<PathBuf>,

    /// Size of the picture, such as 1920x1080 [default: what the script says, or 800x600]
    #[arg(long, value_name = "WxH")]
    size: Option<Size>,

    #[command(flatten)]
    scripting: ScriptOptions,
}

/// Parses how many lines a table has.
fn lines(text: &str) -> Result<usize, String> {
    let lines: usize =
        text.trim().parse().map_err(|_| "a whole number from 0 is needed; for example: --top 10")?;
    Ok(if lines == 0 { usize::MAX } else { lines })
}

/// Parses where a report goes. Another ending is a mistake, and may be that of a script.
fn json_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_json = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("json"));
    if is_json || text == "-" {
        Ok(path)
    } else {
        Err("it does not end in .json; for example: --json profile.json".into())
    }
}

/// Runs the command.
pub fn run(args: &Args, terminal: &Terminal) -> Outcome {
    let start = Instant::now();
    let file = args.json.as_deref().filter(|path| *path != Path::new("-"));
    if let Some(path) = file {
        atomic::check(path).map_err(|e| Diagnostic::error(e.to_string()))?;
    }
    let Conversion { loaded, scene, progress, flag } =
        Conversion::begin(&args.script, &args.scripting, &args.script, terminal)?;
    work::spare(&loaded, file)?;
    let order = Order { size: args.size.map(|size| (size.width, size.height)), ..Order::default() };
    let watch = Watch { cancel: &flag, progress: &|share| progress.set(share) };
    let made = profile(&loaded, &scene, &order, &watch);
    progress.finish();
    let made = made.map_err(|error| work::failure(error, &loaded, terminal))?;
    match file {
        Some(path) => {
            let text = json(&made)?;
            atomic::write(path, |f| writeln!(f, "{text}")).map_err(|e| Diagnostic::error(e.to_string()))?;
        }
        None if args.json.is_some() => out(json(&made)?),
        None => Table::new(&args.script, args.top, terminal).print(&made),
    }
    let script = args.script.display();
    let rays = plural(made.rays, "ray");
    err(format!(
        "{script}: {rays}, {} of the solid, {}",
        plural(made.hits, "point"),
        seconds(start.elapsed().as_secs_f64())
    ));
    Ok(())
}

fn json(profile: &Profile) -> Result<String, Failure> {
    let text = serde_json::to_string_pretty(profile);
    Ok(text.map_err(|e| Diagnostic::error(format!("cannot write the profile ({e})")))?)
}
