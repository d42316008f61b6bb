//! `orogen heights`: a planet, or level land, as a map of its heights, for other programs.

use super::options::{self, ScriptOptions};
use super::report::{Failure, Outcome, Terminal, count, err, plural, seconds};
use super::work::{self, Conversion};
use crate::diag::Diagnostic;
use crate::field::{Field, Watch};
use crate::render::Format;
use crate::scene::{Aabb, Film, Scene};
use crate::session;
use crate::session::heights::{Chart, Datum, Mapped, Mapping, Projection, map_heights};
use crate::world::atomic;
use clap::ValueEnum;
use glam::DVec3;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::time::Instant;

/// Map the heights of a script's planet, or of its land
///
/// Writes how far the outermost surface is above a sphere, in every direction from its centre, or with --projection plane
/// above a level plane. A .png
/// has 16 bits of grey, from the lowest height to the highest, or over the range that is given; the file and
/// the last line say which. An .exr has heights in the units of the script, in 32 bits. Where there is no solid
/// down to the centre, a .png is black and an .exr has NaN. Components that the script leaves out are left out, and so are
/// octaves of fractals too fine for the pixels. Maps larger than memory are no problem.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  orogen heights planet.rhai -o planet.png                 1024 x 512 pixels
  orogen heights planet.rhai -o planet.exr --size 4096     8192 x 4096 pixels
  orogen heights planet.rhai -o planet.png --projection cube --size 1024
  orogen heights moon.rhai -o moon.png --radius 1737 --range -9..11
  orogen heights coast.rhai -o coast.png --projection plane --extent 4 --size 1024

An equirectangular map is N pixels high and twice as wide, with +z in its middle, +x a quarter of its
width to the right, and the north pole, +y, along its top edge. A cube is six squares of N pixels,
planet.px.png (+x), nx, py, ny, pz and nz, in the layout of OpenGL's cube maps. Seen from outside:

        py
     nx pz px nz
        ny

A plane is seen from above, +x to the right and +z down: load_heightfield(\"coast.exr\", #{ extent: 4.0 * 1023 / 1024 })
wears it again: its extent is from the middle of the first pixel to that of the last.")]
pub struct Args {
    /// Script of the planet
    #[arg(value_name = "SCRIPT")]
    script: PathBuf,

    /// Map to write: .png or .exr
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,

    /// How the ground becomes a picture: equirectangular or cube, of a planet, or plane, of level land
    #[arg(long, value_name = "KIND", default_value = "equirectangular", hide_possible_values = true)]
    projection: Kind,

    /// Height of the map, or of each face of the cube, in pixels
    #[arg(long, value_name = "N", default_value = "512")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=i64::from(Film::MAX_SIDE / 2)))]
    size: u32,

    /// Centre of the sphere, in the units of the script, or middle of the plane, where heights are zero [default: 0,0,0; of
    /// a plane the middle of the solid, at y = 0]
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    center: Option<DVec3>,

    /// Radius at which heights are zero; 0 for distances from the centre [default: 1]
    #[arg(long, value_name = "R", value_parser = radius, allow_hyphen_values = true)]
    radius: Option<f64>,

    /// How much of a plane is mapped, along x and z, or the side of a square [default: as far as the solid goes]
    #[arg(long, value_name = "WxD", value_parser = extent, allow_hyphen_values = true)]
    extent: Option<[f64; 2]>,

    /// Heights that are black and white in a .png [default: the lowest and the highest]
    #[arg(long, value_name = "LO..HI", value_parser = range, allow_hyphen_values = true)]
    range: Option<(f64, f64)>,

    #[command(flatten)]
    scripting: ScriptOptions,

    /// Threads to use [default: one per processor core]; the heights do not depend on it
    #[arg(long, value_name = "N", value_parser = options::threads)]
    threads: Option<NonZeroUsize>,
}

/// A projection by its name.
#[derive(Clone, Copy, ValueEnum)]
enum Kind {
    Equirectangular,
    Cube,
    Plane,
}

fn point(text: &str) -> Result<DVec3, String> {
    let numbers: Result<Vec<f64>, String> = text.split(',').map(options::finite).collect();
    match numbers.as_deref() {
        Ok(&[x, y, z]) if x.abs().max(y.abs()).max(z.abs()) <= 1e15 => Ok(DVec3::new(x, y, z)),
        _ => Err("a point is three numbers up to 1e15 with commas between them, such as 0,1.5,0".into()),
    }
}

fn radius(text: &str) -> Result<f64, String> {
    match options::finite(text)? {
        radius if (0.0..=1e15).contains(&radius) => Ok(radius),
        _ => Err("the radius must be from 0 to 1e15; for example: --radius 6371".into()),
    }
}

fn extent(text: &str) -> Result<[f64; 2], String> {
    let (width, depth) = text.split_once('x').unwrap_or((text, text));
    match [options::finite(width), options::finite(depth)] {
        [Ok(width), Ok(depth)] if [width, depth].iter().all(|side| (1e-15..=1e15).contains(side)) => {
            Ok([width, depth])
        }
        _ => Err("an extent is a number above 0, or two with an x between them, such as 4x3".into()),
    }
}

fn range(text: &str) -> Result<(f64, f64), String> {
    let ends = text.split_once("..").map(|(lo, hi)| (options::finite(lo), options::finite(hi)));
    match ends {
        Some((Ok(lo), Ok(hi))) if lo < hi => Ok((lo, hi)),
        _ => Err("a range is a number and a larger one, such as -0.01..0.02".into()),
    }
}

/// Runs the command.
pub fn run(args: &Args, terminal: &Terminal) -> Outcome {
    let start = Instant::now();
    check(args)?;
    let Conversion { loaded, scene, progress, flag } =
        Conversion::begin(&args.script, &args.scripting, &args.output, terminal)?;
    let mapping = mapping(args, &scene)?;
    work::spare(&loaded, mapping.chart.files(&args.output).iter().map(PathBuf::as_path))?;
    let watch = Watch { cancel: &flag, progress: &|share| progress.set(share) };
    let mapped = session::on_threads(args.threads, || map_heights(&scene, &mapping, &args.output, &watch));
    progress.finish();
    let mapped = mapped.and_then(|m| m).map_err(|error| work::failure(error, &loaded, terminal))?;
    for warning in mapped.warnings.iter().cloned().chain(warnings(&mapped, &mapping)) {
        terminal.diagnostic(&warning, &loaded.sources);
    }
    err(summary(args, &mapping, &mapped, start.elapsed().as_secs_f64()));
    Ok(())
}

/// Whether what is asked for makes sense, and can be written.
fn check(args: &Args) -> Outcome {
    let format = Format::of(&options::picture_path(args.output.clone())?);
    if args.range.is_some() && matches!(format, Ok(Format::OpenExr)) {
        let hint = "leave --range out, or write a .png";
        return Err(Failure::usage("an .exr holds heights as they are and has no --range", hint));
    }
    let is_plane = matches!(args.projection, Kind::Plane);
    if is_plane && args.radius.is_some() {
        let hint = "--center X,Y,Z says with Y at which height it is";
        return Err(Failure::usage("a plane has no --radius", hint));
    }
    if !is_plane && args.extent.is_some() {
        let hint = "--projection plane maps a part of level land";
        return Err(Failure::usage("a planet is mapped as a whole: --extent is for planes", hint));
    }
    let projection = match args.projection {
        Kind::Equirectangular => Projection::Equirectangular,
        Kind::Cube => Projection::Cube,
        Kind::Plane => Projection::Plane { width: args.size },
    };
    for file in (Chart { projection, size: args.size }).files(&args.output) {
        atomic::check(&file).map_err(|e| Diagnostic::error(e.to_string()))?;
    }
    Ok(())
}

/// What is asked for.
fn mapping(args: &Args, scene: &Scene) -> Result<Mapping, Failure> {
    let globe =
        || Datum::Globe { center: args.center.unwrap_or_default(), radius: args.radius.unwrap_or(1.0) };
    let (projection, datum) = match args.projection {
        Kind::Equirectangular => (Projection::Equirectangular, globe()),
        Kind::Cube => (Projection::Cube, globe()),
        Kind::Plane => plane(args, scene)?,
    };
    Ok(Mapping { chart: Chart { projection, size: args.size }, datum, range: args.range })
}

/// A rectangle of land: where it is said to be, or else where the solid is.
fn plane(args: &Args, scene: &Scene) -> Result<(Projection, Datum), Failure> {
    let solid = || Field::new(&scene.graph, scene.surface.field);
    let Aabb { min, max } = scene.bounds.unwrap_or_else(|| session::bounds(scene, &solid()));
    let [across, depth] = args.extent.unwrap_or([max.x - min.x, max.z - min.z]);
    let center = args.center.unwrap_or(0.5 * (min + max) * DVec3::new(1.0, 0.0, 1.0));
    let width = (f64::from(args.size) * across / depth).round().max(1.0);
    if width > f64::from(Film::MAX_SIDE) {
        let message = format!("a map of {across} by {depth} would be {width} pixels wide");
        return Err(Failure::usage(
            message,
            "choose a smaller --size, which is its height, or another --extent",
        ));
    }
    Ok((Projection::Plane { width: width as u32 }, Datum::Plane { center, depth }))
}

/// What is odd about a map.
fn warnings(mapped: &Mapped, mapping: &Mapping) -> Vec<Diagnostic> {
    let mut warnings = Vec::new();
    let of_all = |n: u64| format!("in {} of {}", count(n), plural(mapping.chart.pixels(), "pixel"));
    if mapped.tally.missed > 0 {
        let there = if mapped.range.is_some() { "they are black" } else { "they are NaN" };
        let what = format!("there is no solid {}; {there}", of_all(mapped.tally.missed));
        let hint = match mapping.datum {
            Datum::Globe { .. } => "put the centre inside of the solid with --center",
            Datum::Plane { .. } => "--extent and --center map a part of the land",
        };
        warnings.push(Diagnostic::warning(what).hint(hint));
    }
    if mapped.tally.cut > 0 {
        let what = format!("the solid reaches beyond the bounds of the scene {}", of_all(mapped.tally.cut));
        warnings.push(Diagnostic::warning(what).hint("widen the bounds in the script"));
    }
    warnings
}

/// `moon.png: 1024x512, 1.2 s, 524 288 rays`, and `heights within 0..0.012, 0..0.012 from black to white`
fn summary(args: &Args, mapping: &Mapping, mapped: &Mapped, elapsed: f64) -> String {
    let Chart { size, .. } = mapping.chart;
    let faces = match mapping.chart.faces() {
        1 => String::new(),
        n => format!("{n} files of "),
    };
    let mut line = format!(
        "{}: {faces}{}x{size}, {}, {}",
        args.output.display(),
        mapping.chart.width(),
        seconds(elapsed),
        plural(mapped.tally.cast.rays, "ray")
    );
    match mapped.tally.cast.uncertified {
        0 => {}
        n => line += &format!(", {} uncertified", count(n)),
    }
    let (lowest, highest) = mapped.heights;
    line += &format!("\nheights within {lowest}..{highest}");
    if let Some((black, white)) = mapped.range {
        line += &format!(", {black}..{white} from black to white");
        match mapped.beyond {
            0 => {}
            n => line += &format!(", {} beyond", plural(n, "pixel")),
        }
    }
    line
}
