//! `orogen mesh`: a solid as triangles, for other programs.

use super::options::{self, ScriptOptions};
use super::report::{Failure, Outcome, Terminal, count, err, plural, seconds};
use super::work::{self, Conversion};
use crate::diag::Diagnostic;
use crate::exchange::mesh::{self as file, Format, Gloss};
use crate::field::Watch;
use crate::mesh::{self, Deviation, FINEST, Fineness, Meshed};
use crate::scene::{Finish, Scene};
use crate::session::topology::LeftOut;
use crate::session::{self, Solidified};
use crate::shape::{Census, Parts, creased};
use crate::world::atomic;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Make a mesh of a script's solid
///
/// Writes the surface as triangles that close up: every edge has two of them, no two parts share a point, and sharp
/// edges stay sharp. Where the surface comes nearer to itself than a cell, triangles may cross. The file is written whole
/// or not at all, in the format that its ending says: .glb (glTF) and .ply hold normals and colours, .obj too, .stl
/// holds triangles alone. Colours are those of the points, linear in a .glb and sRGB in the others, so that patterns take
/// a resolution that shows them; a finish that is the same everywhere goes into a .glb. A solid without an end is cut off at the bounds of the scene. Components that the script
/// leaves out are left out. Numbers are those of the script, whatever its unit is: slicers take them for millimetres,
/// and .glb says that they are metres.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  orogen mesh rock.rhai -o rock.glb                    128 cells along the longest edge
  orogen mesh rock.rhai -o rock.ply --resolution 512   finer
  orogen mesh part.rhai -o part.stl --tolerance 0.001  as fine as it takes, and as few triangles as will do
  orogen mesh part.rhai -o part.stl --up z             standing up in a slicer
  orogen mesh rock.rhai -o rock.glb --resolution 512 --tolerance 0.002

Both options together merge triangles of the given resolution where the surface is flat. The last
line says whether the mesh is proven to show all parts of the solid; if not, some that are smaller
than a cell may be missing.")]
pub struct Args {
    /// Script of the solid
    #[arg(value_name = "SCRIPT")]
    script: PathBuf,

    /// Mesh to write: .glb, .obj, .ply or .stl
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,

    /// Cells along the longest edge of the solid's bounds [default: 128, or what the tolerance needs, up to 512]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=i64::from(FINEST)), allow_negative_numbers = true)]
    resolution: Option<u32>,

    /// How far the mesh may be from the surface, in the units of the script; merges triangles of one colour up to that
    #[arg(long, value_name = "DISTANCE", value_parser = distance, allow_negative_numbers = true)]
    tolerance: Option<f64>,

    /// Edges sharper than this are shown sharp: a .glb has points of its own for each side there; 180 for none
    #[arg(long, value_name = "DEGREES", default_value = "30", value_parser = angle)]
    creases: f64,

    /// Which axis is up in the file: y, as in scripts, or z, as printers and most CAD programs have it
    #[arg(long, value_name = "AXIS", value_enum, default_value = "y", hide_possible_values = true)]
    up: Up,

    #[command(flatten)]
    scripting: ScriptOptions,

    /// Threads to use [default: one per processor core]; the mesh does not depend on it
    #[arg(long, value_name = "N", value_parser = options::threads, allow_negative_numbers = true)]
    threads: Option<NonZeroUsize>,
}

/// An axis that is up.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Up {
    Y,
    Z,
}

fn distance(text: &str) -> Result<f64, String> {
    match options::finite(text)? {
        distance if distance > 0.0 => Ok(distance),
        _ => Err("the distance must be above 0; for example: --tolerance 0.001".into()),
    }
}

fn angle(text: &str) -> Result<f64, String> {
    match options::finite(text)? {
        angle if (0.0..=180.0).contains(&angle) => Ok(angle),
        _ => Err("the angle must be from 0 to 180".into()),
    }
}

/// Runs the command.
pub fn run(args: &Args, terminal: &Terminal) -> Outcome {
    let format = Format::of(&args.output.to_string_lossy())
        .map_err(|fault| Failure::usage(fault.to_string(), "for example: -o rock.glb"))?;
    if (args.up, format) == (Up::Z, Format::Glb) {
        return Err(Failure::usage("y is up in every .glb", "leave --up out, or write a .stl, .ply or .obj"));
    }
    atomic::check(&args.output).map_err(|e| Diagnostic::error(e.to_string()))?;
    let start = Instant::now();
    let Conversion { loaded, scene, progress, flag } =
        Conversion::begin(&args.script, &args.scripting, &args.output, terminal)?;
    work::spare(&loaded, [&*args.output])?;
    let fineness = Fineness { resolution: args.resolution, tolerance: args.tolerance };
    let watch = Watch { cancel: &flag, progress: &|share| progress.set(share) };
    let made = session::on_threads(args.threads, || session::polygonise(&scene, &fineness, &watch));
    progress.finish();
    let made = made.and_then(|m| m).map_err(|error| work::failure(error, &loaded, terminal))?;
    // What is said of the mesh is said of the file.
    let made = if format.is_single() { rounded(made) } else { made };
    let Solidified { meshed, left_out, warnings, .. } = &made;
    let own = coarse(meshed).into_iter().chain(endless(&scene, &made)).chain(colorless(meshed));
    for warning in warnings.iter().cloned().chain(doubts(left_out)).chain(own) {
        terminal.diagnostic(&warning, &loaded.sources);
    }
    if meshed.mesh.triangles.is_empty() {
        let hint = match left_out.parts {
            0 => "the solid may be smaller than a cell; try a larger --resolution",
            _ => {
                "all that there is was left out; what is kept may be smaller than a cell: try a larger --resolution"
            }
        };
        return Err(Failure::error("there are no triangles, so no file was written", hint));
    }
    let shown = match format {
        Format::Glb => &creased(&meshed.mesh, args.creases),
        Format::Obj | Format::Ply(_) | Format::Stl(_) if args.up == Up::Z => &meshed.mesh.with_z_up(),
        Format::Obj | Format::Ply(_) | Format::Stl(_) => &meshed.mesh,
    };
    atomic::write(&args.output, |out| file::write_glossy(format, shown, &gloss(&scene), out))
        .map_err(|e| Diagnostic::error(e.to_string()))?;
    err(summary(&args.output, &made, start.elapsed().as_secs_f64()));
    err(judgement(&made, args.tolerance));
    Ok(())
}

/// The scene's material, as far as it is the same everywhere.
fn gloss(scene: &Scene) -> Gloss {
    let Some(material) = scene.surface.material else { return Gloss::default() };
    let even = |node| scene.graph.as_const(node).filter(|value| value.is_finite());
    let share = |finish: Finish, otherwise: f64| {
        even(material.finish[finish as usize]).unwrap_or(otherwise).clamp(0.0, 1.0)
    };
    let light = material.emission.map(|light| light.map(even));
    Gloss {
        metal: share(Finish::Metal, 0.0),
        coat: share(Finish::Coat, 0.0),
        roughness: share(Finish::Roughness, 1.0),
        light: match light {
            Some([Some(red), Some(green), Some(blue)]) => [red, green, blue].map(|part| part.max(0.0)),
            _ => [0.0; 3],
        },
    }
}

/// The mesh as numbers of 32 bits hold it.
fn rounded(made: Solidified) -> Solidified {
    let mesh = mesh::rounded(&made.meshed.mesh);
    Solidified { meshed: Meshed { mesh, ..made.meshed }, ..made }
}

/// That what is beyond the box in which the solid was found is missing, if there is anything.
fn endless(scene: &Scene, made: &Solidified) -> Option<Diagnostic> {
    (scene.bounds.is_none() && !made.is_whole).then(|| {
        Diagnostic::warning("the solid may go on beyond the mesh, which ends at bounds that were found but not proven")
            .hint("`orogen check` says which; give others: scene(#{ surface: ..., bounds: 2.0 }) is a cube from -2 to 2")
    })
}

/// That the mesh is far too coarse: most of what it should show may be missing.
fn coarse(meshed: &Meshed) -> Option<Diagnostic> {
    let Meshed { shown, hidden, .. } = *meshed;
    (hidden > MUCH * (shown + hidden) / 100).then(|| {
        let message = format!(
            "much of the solid may be missing, or of what is thinner than a cell: of {} in which samples found it the mesh shows {}",
            plural(shown + hidden, "cell"),
            count(shown),
        );
        Diagnostic::warning(message)
            .hint("--resolution takes smaller cells; a tolerance does so only as far as what is there needs them")
    })
}

/// That some points have no colour.
fn colorless(meshed: &Meshed) -> Option<Diagnostic> {
    (meshed.colorless > 0).then(|| {
        let points = plural(meshed.colorless, "point");
        Diagnostic::warning(format!("the colour is not a number at {points} of the mesh, which are black"))
            .hint("a root or a logarithm of less than nothing, or a division by zero, may be in it")
    })
}

/// Cells of a hundred that are too many to be left out.
const MUCH: u64 = 2;

/// That the mesh is too coarse to show what is joined and what is not.
fn doubts(left_out: &LeftOut) -> impl Iterator<Item = Diagnostic> {
    let of_mesh = |n: usize| match n {
        1 => "a part of the mesh".to_owned(),
        n => format!("{n} parts of the mesh"),
    };
    let LeftOut { unproven, unknown, joined, parted, .. } = *left_out;
    let warn = |n: usize, one: &str, many: &str, hint: &str| {
        let message = format!("{} {}", of_mesh(n), if n == 1 { one } else { many });
        (n > 0).then(|| Diagnostic::warning(message).hint(hint))
    };
    let finer = |what: &str| format!("{what} are thinner than a cell there; try a larger --resolution");
    let topology = "orogen topology says what is not decided";
    [
        warn(unproven, "is left out without proof", "are left out without proof", topology),
        warn(unknown, "is kept without proof", "are kept without proof", topology),
        warn(
            joined,
            "holds what should be left out, too",
            "hold what should be left out, too",
            &finer("gaps"),
        ),
        warn(
            parted,
            "floats beside the rest, which the solid does not",
            "float beside the rest, which the solid does not",
            &finer("necks"),
        ),
    ]
    .into_iter()
    .flatten()
}

/// `rock.glb: 1 234 triangles, 619 points, 1 part, 0 handles, closed, 66 parts left out, 1.2 s`. Voids are closed surfaces, too,
/// but no parts of the solid.
fn summary(file: &Path, made: &Solidified, elapsed: f64) -> String {
    let Solidified { meshed, left_out, .. } = made;
    let without = match left_out.parts {
        0 => String::new(),
        n => format!(", {} left out", plural(n as u64, "part")),
    };
    let census = Census::of(&meshed.mesh);
    let handles = census.parts as i64 - census.euler_characteristic() / 2;
    let kind = if census.is_closed_manifold() { "closed" } else { "not closed" };
    let volumes = Parts::of(&meshed.mesh).volumes(&meshed.mesh);
    let voids = volumes.into_iter().filter(|volume| *volume < 0.0).count();
    let hollow = if voids > 0 { format!(", {}", plural(voids as u64, "void")) } else { String::new() };
    format!(
        "{}: {}, {}, {}{hollow}, {}, {kind}{without}, {}",
        file.display(),
        plural(census.triangles as u64, "triangle"),
        plural(census.points as u64, "point"),
        plural((census.parts - voids) as u64, "part"),
        plural(handles.max(0) as u64, "handle"),
        seconds(elapsed),
    )
}

/// How far the mesh can be trusted.
fn judgement(made: &Solidified, tolerance: Option<f64>) -> String {
    let Solidified { meshed, is_whole, .. } = made;
    let Deviation { most, usual, samples, unknown } = meshed.deviation;
    let mut lines = String::new();
    if unknown > 0 {
        let [unknown, samples] = [unknown, samples].map(|n| count(n as u64));
        lines += &format!("how far {unknown} of {samples} samples are from the surface is not known; ");
    }
    if unknown < samples {
        let known = if unknown > 0 { "others" } else { "samples" };
        lines += &format!("within {usual:.2e} of the surface in 99.9 % of the {known}, {most:.2e} at most; ");
    }
    if tolerance.is_some_and(|tolerance| most > tolerance) {
        lines += "more than the tolerance, which takes smaller cells (--resolution) or is finer than numbers are; ";
    }
    lines += &match meshed.doubt {
        None if *is_whole => "proven to show all parts of the solid".to_owned(),
        None => "proven to show all parts of the solid that are within its bounds".to_owned(),
        Some(at) => format!(
            "what is smaller than a cell of {:.2e} may be missing, joined or torn in {} of {} blocks, as at ({:.4}, {:.4}, {:.4})",
            meshed.cell,
            count(meshed.doubtful),
            count(meshed.blocks),
            at.x,
            at.y,
            at.z
        ),
    };
    lines
}
