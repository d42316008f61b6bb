//! `orogen topology`: what a solid is connected with.

mod local;
pub mod report;

use super::interrupt::Flag;
use super::options::{self, PictureOptions, ScriptOptions};
use super::progress::Progress;
use super::report::{Failure, Outcome, Terminal, err, out, plural, seconds};
use super::work::{self, Conversion};
use crate::diag::{Diagnostic, Severity};
use crate::exchange::mesh::{Network, write_network};
use crate::field::{self, Watch};
use crate::render::{self, Job, Metadata, Picture};
use crate::scene::{Keep, Measure, Scene};
use crate::session::topology::{
    ARCS, Analysis, COLORS, Origin, Purpose, Show, analyse, doubts, kept, picture, rivalled, unproven,
};
use crate::session::{self, Loaded, Order};
use crate::tape::Tape;
use crate::topology::{Complex, separatrices};
use crate::world::atomic;
use report::Report;
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// Find out what a script's solid is connected with
///
/// Finds every critical point inside of the solid (minima, saddles and maxima of its field), joins the minima along
/// the separatrices of 1-saddles, and reports the components: how many critical points each has, its Euler
/// characteristic, its genus where that follows, and an interval that holds its volume. All of it is proven, or the
/// report says what is not. Of a field that is not C2, or whose critical points do not decide, the components are
/// found without them, and there are no counts. What was found is kept on disk, until the solid changes.
#[derive(clap::Args)]
#[command(mut_arg("output", |output| output.help("Picture to write, .png or .exr; without it none is made")))]
#[command(after_help = "Examples:
  orogen topology rock.rhai                            the report
  orogen topology rock.rhai --voids                    with voids, and the genus of all components
  orogen topology rock.rhai --json rock.json           for programs; - for standard output
  orogen topology rock.rhai --complex rock.glb         the network as lines, or as .json
  orogen topology rock.rhai -o parts.png               a picture, each component in a colour
  orogen topology rock.rhai -o rock.png --show network critical points and separatrices over the solid
  orogen topology rock.rhai -o rock.png --show triptych

In networks minima are yellow, 1-saddles blue; lines that join components are pale yellow, lines that only close
rings blue. What was found is kept on disk; `orogen --help` says where.")]
pub struct Args {
    /// Script of the solid
    #[arg(value_name = "SCRIPT")]
    script: PathBuf,

    /// Writes the report as JSON; - for standard output
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,

    /// Writes critical points and separatrices: .json with all that is known, or .glb with lines and points
    #[arg(long, value_name = "FILE")]
    complex: Option<PathBuf>,

    /// What the picture shows: components, specks (red), kept, network, or triptych (plain, specks, kept)
    /// [default: components; with component_of and `feature`, specks]
    #[arg(long, value_name = "WHAT", hide_possible_values = true)]
    #[arg(requires = "output")]
    show: Option<What>,

    /// Components in the table [default: 10]
    #[arg(long, value_name = "N", value_parser = lines, allow_hyphen_values = true)]
    top: Option<usize>,

    /// Finds all anew, even what is on disk
    #[arg(long)]
    fresh: bool,

    /// Finds voids, too, which are closed off from outside, and with them the genus of every component; takes
    /// several times as long
    #[arg(long)]
    voids: bool,

    #[command(flatten)]
    picture: PictureOptions,

    #[command(flatten)]
    scripting: ScriptOptions,
}

/// Components in the table.
const TOP: usize = 10;

/// Parses how many components a table has.
fn lines(text: &str) -> Result<usize, String> {
    text.trim().parse().map_err(|_| "a whole number from 0 is needed; for example: --top 10".into())
}

/// What a picture shows, by its name.
#[derive(Clone, Copy, clap::ValueEnum)]
enum What {
    Components,
    Specks,
    Kept,
    Network,
    Triptych,
}

impl What {
    fn show(self) -> Show {
        match self {
            What::Components => Show::Components,
            What::Specks => Show::Specks,
            What::Kept => Show::Kept,
            What::Network => Show::Network,
            What::Triptych => Show::Triptych,
        }
    }
}

/// The solid before it flowed: a flow keeps what is connected, and of what was before more can be known.
fn unflowed(scene: &Scene, loaded: &Loaded, terminal: &Terminal) -> Option<Origin> {
    let origin = Origin::of(scene)?;
    err(origin.note());
    origin.doubts.iter().for_each(|d| terminal.diagnostic(d, &loaded.sources));
    Some(origin)
}

/// Runs the command.
pub fn run(args: &Args, terminal: &Terminal) -> Outcome {
    let start = Instant::now();
    check(args)?;
    let Conversion { loaded, scene, progress, flag } =
        Conversion::begin(&args.script, &args.scripting, &args.script, terminal)?;
    let files = [&args.picture.output, &args.json, &args.complex];
    work::spare(&loaded, files.into_iter().flatten().map(PathBuf::as_path))?;
    let origin = unflowed(&scene, &loaded, terminal);
    let asked = scene.surface.keep;
    let scene = origin.as_ref().map_or(&*scene, |origin| &origin.scene);
    if let (Some(keep), Some(asked)) = (scene.surface.keep, asked) {
        let inside = session::topology::check_point(scene, &keep, &asked);
        inside.map_err(|error| work::failure(error, &loaded, terminal))?;
    }
    if let Some(Keep::Near { core, feature }) = scene.surface.keep {
        local::check(args)?;
        let made = local::show(args, scene, (core, feature), (&progress, &flag));
        progress.finish();
        let stats = made.map_err(|error| work::failure(error, &loaded, terminal))?;
        tell(args, &stats, || local::print(&stats))?;
        doubts(&stats).iter().for_each(|d| terminal.diagnostic(d, &loaded.sources));
        return Ok(());
    }
    if args.complex.is_some() || matches!(args.show, Some(What::Network)) {
        // Else it would turn out at the end that there are no critical points to show.
        let smooth = field::smooth(&scene.graph, scene.surface.field);
        smooth.map_err(|error| work::failure(error, &loaded, terminal))?;
    }
    let watch = Watch { cancel: &flag, progress: &|share| progress.set(share) };
    let purpose = Purpose { fresh: args.fresh, volumes: true, voids: args.voids };
    let found = session::on_threads(args.picture.threads, || analyse(scene, purpose, &watch));
    progress.finish();
    let analysis = found.and_then(|a| a).map_err(|error| work::failure(error, &loaded, terminal))?;
    let elapsed = start.elapsed().as_secs_f64();
    let keep = scene.surface.keep.unwrap_or(Keep::Most(Measure::Minima));
    let kept = kept(&analysis, &keep).map_err(|error| work::failure(error, &loaded, terminal))?;
    let report = Report::new(&analysis, &kept, origin.as_ref(), elapsed);
    tell(args, &report, || {
        report.print(args.top.unwrap_or(TOP), &format!("--top {}", analysis.parts.len()))
    })?;
    if args.json.is_none() {
        let source = if analysis.remembered { ", from disk" } else { "" };
        let cells = plural(report.cells(), "cell");
        err(format!("{}: {}, {cells}{source}", args.script.display(), seconds(elapsed)));
    }
    if let Some(rough) = &analysis.rough {
        let warning = Diagnostic { severity: Severity::Warning, ..(**rough).clone() };
        terminal.diagnostic(&warning, &loaded.sources);
    }
    if let Some((path, complex)) = args.complex.as_ref().zip(analysis.complex.as_ref()) {
        export(path, &analysis.tape, complex)?;
    }
    if args.picture.output.is_some() {
        let progress = Progress::new(terminal, "picture");
        let made = paint(args, scene, &analysis, &keep, (&progress, &flag));
        progress.finish();
        made.map_err(|error| work::failure(error, &loaded, terminal))?;
    }
    let doubtful = unproven(&analysis, &kept).or_else(|| rivalled(&analysis, &keep));
    let doubtful = doubtful.filter(|_| scene.surface.keep.is_some());
    report.doubts().iter().chain(&doubtful).for_each(|d| terminal.diagnostic(d, &loaded.sources));
    Ok(())
}

/// That everything can be written.
fn check(args: &Args) -> Result<(), Failure> {
    if let Some(path) = &args.complex
        && !["json", "glb"].iter().any(|e| path.extension().is_some_and(|x| x.eq_ignore_ascii_case(e)))
    {
        let hint = format!("for example: --complex {}", path.with_extension("glb").display());
        return Err(Failure::usage(format!("`{}` does not end in .json or .glb", path.display()), hint));
    }
    let picture = args.picture.output.clone().map(options::picture_path).transpose()?;
    let json = args.json.clone().filter(|path| path != Path::new("-"));
    if let Some(path) =
        json.as_ref().filter(|p| !p.extension().is_some_and(|e| e.eq_ignore_ascii_case("json")))
    {
        let hint = format!("for example: --json {}", path.with_extension("json").display());
        return Err(Failure::usage(format!("`{}` does not end in .json", path.display()), hint));
    }
    if json.as_ref().zip(args.complex.as_ref()).is_some_and(|(json, complex)| work::is_same(json, complex)) {
        let hint = "for example: --json report.json --complex complex.json";
        return Err(Failure::usage("report and complex would be the same file", hint));
    }
    for path in [picture, json, args.complex.clone()].into_iter().flatten() {
        atomic::check(&path).map_err(|e| Diagnostic::error(e.to_string()))?;
    }
    Ok(())
}

fn write(
    path: &Path,
    fill: impl FnOnce(&mut std::io::BufWriter<&mut std::fs::File>) -> std::io::Result<()>,
) -> Result<(), Failure> {
    Ok(atomic::write(path, fill).map_err(|e| Diagnostic::error(e.to_string()))?)
}

/// Writes a report where the user wants it: as JSON, or as a table.
fn tell(args: &Args, report: &impl Serialize, print: impl FnOnce()) -> Result<(), Failure> {
    match args.json.as_deref() {
        Some(path) if path == Path::new("-") => out(json(report)?),
        Some(path) => {
            let text = json(report)?;
            write(path, |f| writeln!(f, "{text}"))?;
        }
        None => print(),
    }
    Ok(())
}

fn json(value: &impl Serialize) -> Result<String, Failure> {
    let text = serde_json::to_string_pretty(value);
    Ok(text.map_err(|e| Diagnostic::error(format!("cannot write the report ({e})")))?)
}

/// Writes the complex.
fn export(path: &Path, tape: &Arc<Tape>, complex: &Complex) -> Result<(), Failure> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json")) {
        return write(path, |f| Ok(serde_json::to_writer(f, complex)?));
    }
    let lines = separatrices(tape, complex).into_iter().zip(&complex.arcs);
    let network = Network {
        lines: lines.map(|(line, arc)| (line, ARCS[usize::from(!arc.joins)])).collect(),
        dots: complex.points.iter().map(|p| (p.position, COLORS[p.kind as usize])).collect(),
    };
    write(path, |f| write_network(&network, f))
}

/// Makes the picture.
fn paint(
    args: &Args,
    scene: &Scene,
    analysis: &Analysis,
    keep: &Keep,
    (progress, flag): (&Progress, &Flag),
) -> Result<(), Box<Diagnostic>> {
    save(args, (progress, flag), |order, job| {
        picture(scene, order, analysis, (args.show.unwrap_or(What::Components).show(), keep), job)
    })
}

/// Makes and saves the picture that was asked for.
fn save(
    args: &Args,
    (progress, flag): (&Progress, &Flag),
    make: impl FnOnce(&Order, &Job<'_>) -> Result<Picture, Box<Diagnostic>>,
) -> Result<(), Box<Diagnostic>> {
    let Some(path) = &args.picture.output else { return Ok(()) };
    let PictureOptions { size, samples, caster, threads, .. } = &args.picture;
    let size = size.map(|size| (size.width, size.height));
    let order = Order { size, samples: *samples, caster: *caster, threads: *threads, ..Order::default() };
    let told = |p: render::Progress| progress.set(p.done as f64 / p.total as f64);
    let made = make(&order, &Job { progress: &told, ..Job::unwatched(flag) })?;
    if !made.finished {
        return Err(session::stopped());
    }
    render::save(path, &made, &Metadata::default()).map_err(|e| Box::new(Diagnostic::error(e.to_string())))
}
