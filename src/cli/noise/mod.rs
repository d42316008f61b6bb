//! `orogen noise`: what a noise or a fractal is like, in figures and numbers.

mod kind;
mod settings;

use super::folder::Folder;
use super::interrupt::Interrupt;
use super::options::threads;
use super::progress::Progress;
use super::report::{Failure, Outcome, Terminal, err, out, plural, seconds};
use crate::analysis::{self, Analysis, Doubt, Plan, Plate, Refusal, Sphere, Watch};
use crate::diag::Diagnostic;
use crate::field::{Moments, survey};
use crate::scene::Ensemble;
use crate::script::{Draw, Request, realise};
use crate::session;
use crate::tape::Tape;
use clap::builder::PossibleValuesParser;
use kind::KindOptions;
use serde::Serialize;
use std::io::Write;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

/// Analyse a noise: pictures, autocovariance, spectrum, and what follows from them
///
/// KIND is the name of a noise (gradient), the name of a sum of octaves (fbm, ridged, ...), an
/// expression (`gradient(7).scaled(2.0)`), or a script that ends with a noise, or with a field that
/// depends on param("seed", ...). Averages are taken over many seeds. Writes into DIR:
///
///   sample.png          the noise on a plane
///   sphere.png          a sphere that it makes rough
///   autocovariance.png  covariance of points on a line; stripes: the noise is stationary
///   spectrum.png        power spectral density; round: the noise is isotropic
///   radial.png          power by wavenumber
///   anisotropy.png      how much the power differs between directions
///   analysis.json       all numbers
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    after_help = "Examples:
  orogen noise gradient -o gradient
  orogen noise fbm --of gradient --octaves 5 --hurst 0.8 --cells 16 --samples 64 -o fbm
  orogen noise sparse --set kernel=quintic --set nodes=2 -o sparse
  orogen noise 'gradient(7).scaled(2.0)' --seeds 30 -o twice
  orogen noise marble.rhai --set veins=3 --only sample --only spectrum -o marble"
)]
pub struct Args {
    /// Noise to analyse: a name, an expression or a script
    #[arg(value_name = "KIND")]
    kind: String,

    #[command(flatten)]
    options: KindOptions,

    /// Folder to write into; made if it does not exist
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,

    /// Writes only this figure; may be given several times
    #[arg(long, value_name = "FIGURE", value_parser = PossibleValuesParser::new(figures()), hide_possible_values = true)]
    #[arg(help = format!("Writes only this figure; may be given several times: {}", figures().join(", ")))]
    only: Vec<String>,

    /// Realisations to average over, each with a seed of its own
    #[arg(long, value_name = "N", default_value = "100", value_parser = clap::value_parser!(u32).range(2..=100_000))]
    seeds: u32,

    /// Side of the plane in units of length, which are cells of a noise that is not scaled; a power of
    /// two
    #[arg(long, value_name = "N", default_value = "32")]
    cells: u32,

    /// Samples to a unit of length; a power of two
    #[arg(long, value_name = "N", default_value = "16")]
    samples: u32,

    /// Spectrum of the noise in space instead of that of a plane in it; takes CELLS x SAMPLES layers
    #[arg(long)]
    solid: bool,

    /// Width of the figures in pixels
    #[arg(long, value_name = "PIXELS", default_value = "560", value_parser = clap::value_parser!(u32).range(240..=4096))]
    size: u32,

    /// How far the noise moves the surface of the sphere, in radii for each unit of its value
    /// [default: what makes the sphere moderately rough]
    #[arg(long, value_name = "A", value_parser = super::options::finite, allow_hyphen_values = true)]
    amplitude: Option<f64>,

    /// Threads to use [default: one per processor core]; the results do not depend on it
    #[arg(long, value_name = "N", value_parser = threads)]
    threads: Option<NonZeroUsize>,
}

/// Names for `--only`.
fn figures() -> Vec<&'static str> {
    Plate::ALL.iter().map(|p| p.name()).chain([SPHERE, NUMBERS]).collect()
}

/// The sphere's picture, which is no plate of an analysis.
const SPHERE: &str = "sphere";
/// The file of numbers.
const NUMBERS: &str = "analysis";

/// Runs the command.
pub fn run(args: &Args, terminal: &Terminal) -> Outcome {
    let plan = Plan { side: args.cells, samples: args.samples, solid: args.solid };
    plan.validate().map_err(|e| Failure::usage(e.to_string(), "for example: --cells 32 --samples 16"))?;
    let noise = args.options.find(&args.kind)?;
    let folder = Folder::new(&args.output)?;
    let start = Instant::now();
    let progress = Progress::new(terminal, &noise.title);
    let bar = progress.clone();
    let interrupt = Interrupt::listen(move || {
        bar.say("stopping; figures that are written stay (Ctrl-C again quits at once)");
    });
    let request = Request { cancel: Some(interrupt.flag()), ..noise.request };
    let draw = Draw { count: args.seeds as usize, seed: args.options.seed, side: f64::from(args.cells) };
    let drawn = realise(&request, &draw);
    drawn.output.iter().for_each(out);
    progress.aside(|| drawn.diagnostics.iter().for_each(|d| terminal.diagnostic(d, &drawn.sources)));
    let ensemble = drawn.ensemble.ok_or(Failure::Reported)?;
    let title = &noise.title;
    let mut work = Work { args, title, ensemble, folder, progress: &progress, interrupt: &interrupt, plan };
    let done = session::on_threads(args.threads, || work.all(terminal)).map_err(Failure::Error)?;
    progress.finish();
    done?;
    let files = plural(work.folder.written().len() as u64, "file");
    err(format_args!("{}: {files} in {}", args.output.display(), seconds(start.elapsed().as_secs_f64())));
    Ok(())
}

/// One run of the command.
struct Work<'a> {
    args: &'a Args,
    title: &'a str,
    ensemble: Ensemble,
    progress: &'a Progress,
    interrupt: &'a Interrupt,
    plan: Plan,
    folder: Folder<'a>,
}

/// What `analysis.json` holds.
#[derive(Serialize)]
struct Numbers<'a> {
    noise: &'a str,
    #[serde(flatten)]
    found: &'a Analysis,
}

impl Work<'_> {
    fn wants(&self, name: &str) -> bool {
        self.args.only.is_empty() || self.args.only.iter().any(|o| o == name)
    }

    /// Makes and writes everything.
    fn all(&mut self, terminal: &Terminal) -> Outcome {
        if figures().into_iter().any(|name| name != SPHERE && self.wants(name)) {
            let found = self.analyse()?;
            for plate in Plate::ALL {
                if !self.wants(plate.name()) {
                    continue;
                }
                let figure = plate.draw(&found, self.title, self.args.size);
                let figure = figure.map_err(|e| Diagnostic::error(e.to_string()))?;
                self.folder.write(plate.name(), "png", self.progress, |f| figure.write_png(f))?;
            }
            if self.wants(NUMBERS) {
                let numbers = Numbers { noise: self.title, found: &found };
                let text = serde_json::to_string(&numbers)
                    .map_err(|e| Diagnostic::error(format!("cannot write the numbers ({e})")))?;
                self.folder.write(NUMBERS, "json", self.progress, |f| writeln!(f, "{text}"))?;
            }
            self.progress.aside(|| report(&found, terminal));
        }
        if self.wants(SPHERE) {
            self.sphere(terminal)?;
        }
        Ok(())
    }

    fn analyse(&self) -> Result<Analysis, Failure> {
        let flag = self.interrupt.flag();
        let step = |share| self.progress.set(share);
        let found = analysis::analyse(&self.ensemble, &self.plan, &Watch { cancel: &flag, progress: &step });
        found.map_err(|refusal| self.refused(refusal))
    }

    fn sphere(&mut self, terminal: &Terminal) -> Outcome {
        self.progress.restart(&format!("{}: {SPHERE}", self.title));
        let plain = &self.ensemble.plain;
        let tape = Arc::new(Tape::new(&plain.graph, &[plain.root]));
        let samples = survey(&tape, f64::from(self.args.cells), 0, 1 << 13);
        let moments = Moments::of(&samples).filter(|m| m.variance.is_finite());
        let moments =
            moments.ok_or_else(|| undefined("the noise is infinite or not a number somewhere".to_owned()))?;
        if self.args.only.iter().all(|only| only == SPHERE) && !self.args.only.is_empty() {
            let (mean, variance) = (format!("{:.4}", moments.mean), format!("{:.4}", moments.variance));
            self.progress.aside(|| table(&self::moments(&moments, mean, variance), terminal));
        }
        let sphere = Sphere {
            noise: plain,
            moments: &moments,
            cell: self.ensemble.cell,
            amplitude: self.args.amplitude,
            size: self.args.size,
        };
        let flag = self.interrupt.flag();
        let step = |share| self.progress.set(share);
        let figure = sphere.draw(&Watch { cancel: &flag, progress: &step });
        let figure = figure.map_err(|refusal| self.refused(refusal))?;
        self.folder.write(SPHERE, "png", self.progress, |f| figure.write_png(f))
    }

    /// What to say of an analysis or a sphere that there is not.
    fn refused(&self, refusal: Refusal) -> Failure {
        match refusal {
            Refusal::Cancelled => Failure::error("stopped before all was done", self.folder.account()),
            Refusal::Undefined(_) => undefined(refusal.to_string()),
            _ => Failure::error(refusal.to_string(), "see orogen noise --help"),
        }
    }
}

/// The noise, or one of its realisations, has no value somewhere.
fn undefined(message: String) -> Failure {
    Failure::error(
        message,
        "guard divisions and square roots; see a place with f.at([x, y, z]) in orogen repl",
    )
}

/// The table of findings.
fn report(found: &Analysis, terminal: &Terminal) {
    let Analysis { moments: m, verdict, .. } = found;
    let near = |value: f64, error: f64| format!("{value:.4} ± {error:.4}");
    let mut lines = moments(m, near(m.mean, found.mean_error), near(m.variance, found.variance_error));
    lines.extend(verdict.lines(&found.covariance, &found.radial));
    let edges = if found.periodic { "made to repeat" } else { "tapered at its edges" };
    lines.push(("from", format!("{}, {edges}", plural(found.realisations as u64, "realisation"))));
    table(&lines, terminal);
    warn(found, terminal);
}

/// The lines of the table that need no averages over realisations.
fn moments(m: &Moments, mean: String, variance: String) -> Vec<(&'static str, String)> {
    let seen = format!(
        "{:.3} to {:.3}; gradient {:.2} rms, {:.2} at most",
        m.min, m.max, m.gradient_rms, m.steepest
    );
    vec![("mean", mean), ("variance", variance), ("seen", seen)]
}

fn table(lines: &[(&str, String)], terminal: &Terminal) {
    for (name, text) in lines {
        out(format_args!("{} {text}", terminal.bold(format_args!("{name:<11}"))));
    }
}

/// Warns of what makes the findings wrong, or keeps them from being found.
fn warn(found: &Analysis, terminal: &Terminal) {
    let samples = found.plan.samples;
    let warning = match found.verdict.doubt {
        Some(Doubt::Aliased) => {
            Diagnostic::warning("the noise is finer than the samples, which show nothing of it")
                .hint("scale it down, or take more samples: see --samples and --cells")
        }
        Some(Doubt::Constant) => {
            Diagnostic::warning("the noise does not vary where it was sampled, on the plane z = 0")
        }
        Some(Doubt::Few) => {
            Diagnostic::warning("so few realisations tell little: what is undecided needs more")
                .hint("leave out --seeds, or take --seeds 100")
        }
        None if found.verdict.aliased => Diagnostic::warning(
            "the noise has detail that the samples do not resolve, so its spectrum is wrong near the end",
        )
        .hint(format!("take more: --samples {}", 2 * samples))
        .hint("or fewer octaves"),
        None => return,
    };
    terminal.diagnostic(&warning, &Default::default());
}
