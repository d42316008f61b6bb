//! `orogen render`: one picture of one script, a part of one, or the frames of an animation.

use super::animation::{self, Animation};
use super::frames::{self, Frames, Pattern};
use super::interrupt::Interrupt;
use super::options::{FileOptions, PictureOptions, ScriptOptions, statistics_path};
use super::progress::Progress;
use super::report::{Failure, Outcome, Terminal, err};
use super::snapshots::{Series, Sides};
use super::stats;
use super::work::{self, Work};
use crate::diag::Diagnostic;
use crate::render::{self, Format, Job, Part, Rect, Rough, Saved};
use crate::session::{Digests, Session};
use crate::world::{Disk, Kept, Memory};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

const PLANET: &str = include_str!("../../scripts/planet.rhai");

/// Render a picture of a script
///
/// Without SCRIPT it renders the built-in planet. The picture is written whole or not at all. Ctrl-C
/// writes what is finished (beside an earlier picture, never over it) and exits with code 1; a
/// second Ctrl-C quits at once.
///
/// With --frames it renders an animation. A frame that is there, whole and made of the same script, files,
/// parameters and options, is left alone: after Ctrl-C, a power cut or anything else, the same command goes on where it
/// ended. Several processes that are given the same command share the frames.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  orogen render                            the built-in planet, to planet.png
  orogen render rock.rhai                  to rock.png, in the size that the script says
  orogen render rock.rhai -o big.png --size 3840x2160 --samples 16
  orogen render rock.rhai --set relief=0.04 --set seed=3
  orogen render rock.rhai -o light.exr     linear light, with depth, normals and positions
  orogen render rock.rhai --exr half       light in 16 bits, to rock.exr
  orogen render rock.rhai --region 320,200,64x48
                                           a piece of it, to rock.region.png
  orogen render rock.rhai --tile 2/4       the second of four parts, to rock.2of4.png
  orogen render rock.rhai --frames 1-250   an animation, to rock.0001.png and so on
  orogen render rock.rhai --frames 0-90:10 --fps 30 -o frames/rock.###.exr
  orogen render rock.rhai --stats          and what it cost
  orogen render rock.rhai --heatmap evals  where it cost how much, to rock.evals.png
  orogen render rock.rhai --snapshots 32,8 what it looks like on its way, to rock.1.png and rock.2.png")]
pub struct Args {
    /// Script to render [default: the built-in planet]
    #[arg(value_name = "SCRIPT")]
    script: Option<PathBuf>,

    #[command(flatten)]
    picture: PictureOptions,

    #[command(flatten)]
    file: FileOptions,

    #[command(flatten)]
    scripting: ScriptOptions,

    /// Renders frames: first and last number, and step if it is not 1
    ///
    /// The script's `time` is the number over --fps, and --time more. Files are named by a pattern with a row of # for
    /// the number, NAME.####.png unless -o gives another.
    #[arg(long, value_name = "A-B[:STEP]", conflicts_with_all = ["stats", "heatmap"], allow_hyphen_values = true)]
    frames: Option<Frames>,

    /// Frames a second
    #[arg(long, value_name = "F", default_value = "25", requires = "frames", value_parser = frames::rate, allow_negative_numbers = true)]
    fps: f64,

    /// Says what the picture cost, in a table or to a file: rays, evaluations, octaves, seconds
    ///
    /// A field evaluation is one at a point or over a piece of a ray, for a ray or for a whole beam of
    /// rays. An octave is a noise at one place: octaves are counted where they are evaluated, in every
    /// lane of a batch, so that lanes that wait for others count too; what fades out with distance, or
    /// is skipped because a piece is too long for it, does not. Rays that share cubes count what they ask of
    /// them, be it known or not; octaves are then a few more or less as threads happen to ask.
    #[arg(long, value_name = "FILE.json", num_args = 0..=1, value_parser = statistics_path)]
    stats: Option<Option<PathBuf>>,

    /// Draws what every pixel cost, in place of the picture
    ///
    /// An evaluation that served a beam of rays is shared out among them. The scale leaves out the most
    /// expensive 0.5 % of the pixels, which have the colour of its end; the title says what is spent at
    /// most.
    #[arg(long, value_name = "COST", conflicts_with_all = ["tile", "region"])]
    heatmap: Option<Cost>,

    /// Refines the picture, and saves what it looks like when rough tiles of these sides are there: 128, 64 and so on to 1
    ///
    /// Files are named NAME.1.png, NAME.2.png and so on, and NAME.png is the same picture as without. Rough tiles show all
    /// there is, solid, sea and moon, and more.
    #[arg(long, value_name = "SIDE,...", conflicts_with_all = ["frames", "heatmap"])]
    snapshots: Option<Sides>,

    /// Finishes a part of the picture before the rest, from when rough tiles of the first side are there: left, top, width and
    /// height in pixels
    #[arg(long, value_name = "X,Y,WxH", requires = "snapshots", allow_hyphen_values = true)]
    focus: Option<Rect>,
}

/// What a pixel may cost.
#[derive(Clone, Copy, clap::ValueEnum)]
enum Cost {
    /// Evaluations of the field, by its rays to the eye and to the sun
    Evals,
}

impl Cost {
    /// Where its heat map goes: unless a file is named, not where the picture does.
    fn output(self, picture: &PictureOptions, script: &Path) -> Result<PathBuf, Failure> {
        let Cost::Evals = self;
        let path = picture.output(script, "evals.png")?;
        match Format::of(&path) {
            Ok(Format::Png) => Ok(path),
            _ => {
                let hint = format!("for example: -o {}", path.with_extension("png").display());
                Err(Failure::usage("a heat map is a .png", hint))
            }
        }
    }
}

/// Runs the command.
pub fn run(args: &Args, terminal: &Terminal) -> Outcome {
    let session = match &args.script {
        Some(script) if args.frames.is_some() => Session::new(script, Arc::new(Kept::<Disk>::default())),
        Some(script) => Session::new(script, Arc::new(Disk)),
        None => Session::new("planet.rhai", Arc::new(Memory([("planet.rhai".into(), PLANET.into())].into()))),
    };
    let mut options = args.picture.clone();
    if let Some(cost) = args.heatmap {
        options.output = Some(cost.output(&options, session.script())?);
    }
    let ending = args.file.ending();
    let ending = if args.frames.is_some() { format!("####.{ending}") } else { ending };
    let output = options.output(session.script(), &ending)?;
    let pattern = args.frames.map(|_| Pattern::of(&output)).transpose()?;
    let precision = args.file.precision(&output)?;
    options.output = Some(output);
    let file = args.stats.as_ref().and_then(|file| file.as_deref());
    let mut work = Work::new(session, &args.scripting, &options, file)?;
    (work.order.part, work.order.precision) = (args.file.part(), precision);
    (work.order.denoise, work.order.components) = (args.file.denoise, args.file.components);
    if let (Some(frames), Some(pattern)) = (args.frames, pattern) {
        let (params, offset, rate) = (args.scripting.params()?, args.scripting.time, args.fps);
        return animation::run(Animation { work, params, frames, rate, offset, pattern, terminal });
    }
    let is_tile = matches!(work.order.part, Part::Tile { .. });
    if is_tile && let Ok(saved) = Saved::open(&work.output) {
        work.keeps(&work.output, &saved.about, &mut Digests::new())?;
    }
    render(work, args, terminal)?;
    if args.script.is_none() {
        err("\nTry:\n  \
             orogen new rock            a script of your own, rock.rhai\n  \
             orogen watch rock.rhai     keeps its picture right while you edit\n  \
             orogen render --help       size, samples, parameters");
    }
    Ok(())
}

fn render(mut work: Work, args: &Args, terminal: &Terminal) -> Outcome {
    let start = Instant::now();
    let progress = Progress::new(terminal, &work.output.display().to_string());
    let bar = progress.clone();
    let interrupt =
        Interrupt::listen(move || bar.say("stopping; what is finished is kept (Ctrl-C again quits at once)"));
    let loaded = work.session.load(&interrupt.flag());
    let scene = progress.aside(|| work::report(&loaded, terminal)).ok_or(Failure::Reported)?;
    work.spare(&loaded)?;
    if let Some(focus) = args.focus {
        let (width, height) = work.order.size.unwrap_or((scene.film.width, scene.film.height));
        let within = Part::Region(focus).window(width, height);
        within.map_err(|e| Diagnostic::error(e.to_string()).hint(e.hint()))?;
    }
    let share = Mutex::new(0.0);
    let step = |p: render::Progress| {
        let done = p.done as f64 / p.total.max(1) as f64;
        *share.lock().unwrap_or_else(PoisonError::into_inner) = done;
        progress.set(done);
    };
    let flag = interrupt.flag();
    let series = args.snapshots.clone().map(|sides| Series::new(sides, args.focus));
    let job = Job { progress: &step, ..Job::unwatched(&flag) };
    let picture = match &series {
        Some(series) => {
            let see = |tile: &Rough| series.see(tile);
            let job = Job { rough: Some(&see), ..job };
            work.session.refine(&scene, &work.order, &job, (&series.steering, &flag))
        }
        None => work.session.render(&scene, &work.order, &job, &flag),
    };
    progress.finish();
    let picture = picture.map_err(|error| work::failure(error, &loaded, terminal))?;
    if picture.tiles == 0 {
        return Err(Failure::error("stopped before anything was finished", "no file was written"));
    }
    work::report_warnings(&loaded, &picture, terminal);
    let file = match args.heatmap {
        Some(Cost::Evals) => work.save_heatmap(&picture)?,
        None => work.save(&loaded, &scene, &picture)?,
    };
    if let Some(series) = &series {
        series.save((&work, &loaded, &scene), &picture)?;
    }
    work.save_stats(&file, &scene, &picture)?;
    err(work::summary(&file, &picture, start.elapsed().as_secs_f64()));
    if matches!(args.stats, Some(None)) {
        stats::print(&picture.stats, terminal);
    }
    if picture.finished {
        return Ok(());
    }
    let percent = 100.0 * share.into_inner().unwrap_or_else(PoisonError::into_inner);
    let message = format!("stopped at {percent:.0} %; {} holds what was finished", file.display());
    Err(Failure::error(message, "start again to get all of it"))
}
