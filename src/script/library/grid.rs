//! Grids: what is computed once for many places at a time, and then is a field like any other.

use super::grid_store::{Of, remembered};
use super::{Call, Library};
use crate::expr::NodeId;
use crate::grid::additions;
use crate::grid::erosion::Rain;
use crate::grid::spectrum::{self, Motion, Wind};
use crate::grid::weathering::Weathering;
use crate::grid::{Edge, Failure, Frame, Grid, Samples, spot};
use crate::num::{Kernel, Order};
use crate::script::fault::{Fault, Outcome};
use crate::script::host::Host;
use crate::script::options::{Options, entries};
use crate::script::value::{Field, Vec3, number};
use glam::DVec3;
use rhai::{Array, Dynamic, INT, Map};
use std::sync::Arc;

/// A grid in scripts.
#[derive(Clone, Debug, PartialEq)]
pub struct GridValue(pub Arc<Grid>);

impl GridValue {
    /// Its field at the point.
    pub fn lower(&self, host: &Host) -> Outcome<NodeId> {
        let p = host.point()?;
        self.0.bind(&host.halt()).map_err(failed)?;
        Ok(host.graph.borrow_mut().grid(self.0.clone(), p)?)
    }
}

/// Longest edge of a grid in samples.
const LONGEST: INT = 1 << 16;

pub(super) fn register(lib: &mut Library<'_>) {
    lib.name_type::<GridValue>("Grid");
    spectra(lib);
    let sentence = listed(
        "Rough land by successive random additions.",
        &[
            "levels: 2 to this power is the number of cells along an edge",
            "hurst: roughness",
            "deviation: of the coarsest heights",
            "extent: length of an edge",
            "center",
            "repeat: true or false",
        ],
    );
    with_options(
        lib,
        "random_additions",
        "seed",
        &sentence,
        "random_additions(7, #{ levels: 6, hurst: 0.9 })",
        random_additions,
    );
    let sentence = listed(
        "Copies of a spot (a field on the unit ball, or on the disc y = 0) strewn with random weights, which repeat: zero mean, unit variance.",
        &[&PLACED[..], &[VOLUME, "radius: of a spot", "density: spots that cover a point"]].concat(),
    );
    with_options(
        lib,
        "spot_noise",
        "seed, spot",
        &sentence,
        "spot_noise(7, (1.0 - length(p)) * cos(12.0 * x), #{ size: 64 })",
        spot_noise,
    );
    let sentence = listed(
        "A field sampled: between the samples it is a smooth spline through them.",
        &[
            "size: samples along an edge, one number or three",
            PLACED[1],
            PLACED[2],
            "min, max: corners, in place of extent and center",
            "like: another grid, in place of all these",
            "volume: in all three directions; else it is the plane y = 0, and the same above and below",
            "repeat: else it comes to rest within two samples beyond the edge",
        ],
    );
    with_options(
        lib,
        "bake",
        "f",
        &sentence,
        "bake(gradient(7).scaled(3.0), #{ size: 64, extent: 2.0 })",
        bake,
    );
    weather(lib);
    let sentence = "How steep a heightfield is, as a grid of its own: 0 where it is flat, 1 at 45 degrees.";
    lib.def("steepness(grid)", sentence, "steepness(spectral(7, #{ size: 64, deviation: 0.1 }))", steepness);
    lib.def(
        "field(grid)",
        "The grid as a field, which it becomes by itself where one is needed.",
        "spectral(7, #{ size: 64 }).field()",
        |c| Ok(Dynamic::from(Field { node: grid(c, 0)?.lower(c.host)?, color: None })),
    );
    lib.property::<GridValue>("low", |_, g| Ok(g.0.samples().extremes().0.into()));
    lib.property::<GridValue>("high", |_, g| Ok(g.0.samples().extremes().1.into()));
    lib.property::<GridValue>("size", |_, g| Ok(Dynamic::from(Vec3(g.0.frame().size.map(|n| n as f64)))));
    lib.property::<GridValue>("extent", |_, g| Ok(Dynamic::from(Vec3(g.0.frame().extent()))));
}

/// Where a grid is.
const PLACED: [&str; 3] = ["size: samples along an edge", "extent: length of an edge", "center"];
const VOLUME: &str = "volume: in all three directions";

/// A sentence and the options.
pub(super) fn listed(sentence: &str, options: &[&str]) -> String {
    format!("{sentence} Options:\n\n- {}", options.join("\n- "))
}

/// Grids of random waves.
fn spectra(lib: &mut Library<'_>) {
    let own = [
        VOLUME,
        "spectrum: \"fbm\", \"markov\", or a field whose point is a frequency in cycles per unit",
        "hurst, largest: of fbm, the roughness and the size of the largest features",
        "alpha: of markov, the frequency below which all are alike",
        "deviation: typical height",
    ];
    let sentence = "Random hills or clouds of a given power spectrum, which repeat.";
    with_options(
        lib,
        "spectral",
        "seed",
        &listed(sentence, &[&PLACED[..], &own].concat()),
        "spectral(7, #{ size: 64, hurst: 0.8, deviation: 0.1 })",
        spectral,
    );
    let sentence = listed(
        "Waves on deep water after a steady wind (Pierson and Moskowitz), which repeat.",
        &[
            "wind: metres a second, 10 m above the water",
            "direction: degrees, where it blows to: 0 is +z, 90 is +x",
            "focus: how closely waves follow it; 0 is not at all",
            "extent: metres",
            "size: samples along an edge",
            "metre: its length in the scene",
            "time: seconds",
            "center",
        ],
    );
    with_options(lib, "sea", "seed", &sentence, "sea(7, #{ wind: 12.0, extent: 300.0, size: 128 })", sea);
}

/// What weather does to land.
fn weather(lib: &mut Library<'_>) {
    let sentence = listed(
        "A heightfield after rain: valleys, gullies and fans of debris.",
        &[
            "rain: drops a sample",
            "steps: that a drop takes",
            "evaporation",
            "capacity: of a drop for debris",
            "erosion, deposition: how fast it takes and drops",
            "inertia",
            "brush: width of what it takes, in samples",
            "seed",
        ],
    );
    with_options(
        lib,
        "eroded",
        "grid",
        &sentence,
        "eroded(spectral(7, #{ size: 64, deviation: 0.1 }), #{ rain: 0.5 })",
        eroded,
    );
    let sentence = listed(
        "A heightfield whose slopes crumble where they are steeper than the talus angle.",
        &["talus: degrees", "rate: 0 to 1", "steps"],
    );
    with_options(
        lib,
        "weathered",
        "grid",
        &sentence,
        "weathered(spectral(7, #{ size: 64 }), #{ talus: 32.0 })",
        weathered,
    );
}

/// Declares a function with options and the same without.
pub(super) fn with_options(
    lib: &mut Library<'_>,
    name: &str,
    params: &str,
    doc: &str,
    example: &str,
    f: fn(&Call<'_>) -> Outcome<Dynamic>,
) {
    lib.def(&format!("{name}({params}, options)"), doc, example, f);
    let arity = params.split(',').count();
    lib.bind(name, arity, move |c| {
        let mut args = c.args.to_vec();
        args.push(Dynamic::from(Map::new()));
        f(&Call { args: &args, place: c.place.clone(), ..*c })
    });
}

/// The grid that argument `i` is.
fn grid(c: &Call<'_>, i: usize) -> Outcome<GridValue> {
    let found = c.args[i].read_lock::<GridValue>().map(|g| g.clone());
    found.ok_or_else(|| {
        c.wrong(i, "a grid")
            .hint("bake(f, #{ ... }) makes a grid of a field; other grids are spectral, random_additions")
    })
}

/// Why there is no grid, for scripts.
pub(super) fn failed(failure: Failure) -> Fault {
    let fault = Fault::new(failure.to_string());
    match failure {
        Failure::Power(_) => {
            fault.key("size").label("a power of two expected").hint("such as 128, 256 or 512")
        }
        Failure::Size(_) | Failure::Count { .. } => fault.key("size"),
        Failure::Spacing(_) => fault.key("extent").hint("the box must have a length along each axis"),
        Failure::Place(_) => fault.key("center"),
        Failure::Volume(_) => fault.hint("leave out `volume: true`"),
        Failure::Spectrum { .. } => fault
            .key("spectrum")
            .hint("a power spectrum is not negative, and finite at all frequencies but zero"),
        Failure::Value { .. } | Failure::Silent(_) | Failure::Cancelled => fault,
    }
}

/// The finished grid.
pub(super) fn done(samples: Result<Samples, Failure>) -> Outcome<Dynamic> {
    let grid = samples.and_then(|samples| Grid::through(&samples)).map_err(failed)?;
    Ok(Dynamic::from(GridValue(Arc::new(grid))))
}

/// Heights times a factor.
fn times(samples: Result<Samples, Failure>, k: f64) -> Result<Samples, Failure> {
    samples.map(|mut s| {
        s.values.iter_mut().for_each(|v| *v *= k);
        s
    })
}

/// A square of the plane or a cube around a centre.
fn place(c: &Call<'_>, o: &mut Options<'_, '_>, edge: Edge) -> Outcome<Frame> {
    let size = o.integer("size", 2..=LONGEST, 256)? as usize;
    let extent = o.number("extent", 1e-9..=1e9, 2.0)?;
    let center = o.vector("center", DVec3::ZERO)?;
    let volume = o.flag("volume", false)?;
    let size = if volume { [size; 3] } else { [size, 1, size] };
    within(c, size, center - 0.5 * extent, center + 0.5 * extent, edge)
}

/// The frame over a box; the samples of a heightfield lie in the plane y = 0.
fn within(c: &Call<'_>, size: [usize; 3], min: DVec3, max: DVec3, edge: Edge) -> Outcome<Frame> {
    let flat = |v: DVec3| if size[1] == 1 { [v.x, 0.0, v.z] } else { v.to_array() };
    let frame = Frame::over(size, flat(min), flat(max), edge).map_err(failed)?;
    c.host.take_samples(frame.count())?;
    Ok(frame)
}

fn seed(c: &Call<'_>) -> Outcome<u64> {
    Ok(c.integer(0)? as u64)
}

fn spectral(c: &Call<'_>) -> Outcome<Dynamic> {
    let mut o = Options::new(c, 1)?;
    let frame = place(c, &mut o, Edge::Repeat)?;
    let extent = frame.extent()[0];
    let hurst = o.number("hurst", 0.0..=2.0, 0.8)?;
    let largest = o.number("largest", 1e-9..=1e9, extent)?;
    let alpha = o.number("alpha", 1e-9..=1e9, 2.0 / extent)?;
    let deviation = o.number("deviation", 0.0..=1e9, 1.0)?;
    let text = o.get("spectrum").unwrap_or_else(|| "fbm".into());
    let own = if text.is_string() { None } else { Some(o.field("spectrum")?) };
    let name = if own.is_some() { "" } else { o.choice("spectrum", &["fbm", "markov"])? };
    o.finish()?;
    let seed = seed(c)?;
    let axes = if frame.is_heightfield() { 2 } else { 3 };
    let job = |spectrum: String| format!("spectral {seed} {deviation:?} {spectrum}");
    match (own, name) {
        (Some(field), _) => {
            let density = c.host.sampler(field.node)?;
            remembered(c, frame, &job("own".into()), Of::Field(field.node), || {
                random_field(c, frame, seed, deviation, density)
            })
        }
        (None, "markov") => remembered(c, frame, &job(format!("markov {alpha:?}")), Of::Numbers, || {
            random_field(c, frame, seed, deviation, spectrum::markov(alpha))
        }),
        (None, _) => remembered(c, frame, &job(format!("fbm {hurst:?} {largest:?}")), Of::Numbers, || {
            random_field(c, frame, seed, deviation, spectrum::fbm(hurst, axes, largest))
        }),
    }
}

fn random_field<F>(c: &Call<'_>, frame: Frame, seed: u64, deviation: f64, density: F) -> Outcome<Samples>
where
    F: FnMut([f64; 3]) -> f64 + Clone + Send + Sync,
{
    let usual = spectrum::deviation(&frame, density.clone(), &c.host.halt()).map_err(failed)?;
    if usual == 0.0 {
        return Err(failed(Failure::Silent("the spectrum")).key("spectrum"));
    }
    let samples = spectrum::synthesize(frame, seed, Motion::Still, density, &c.host.halt());
    times(samples, deviation / usual).map_err(failed)
}

fn sea(c: &Call<'_>) -> Outcome<Dynamic> {
    let mut o = Options::new(c, 1)?;
    let speed = o.number("wind", 0.1..=100.0, 10.0)?;
    let direction = o.number("direction", -3600.0..=3600.0, 0.0)?.to_radians();
    let focus = o.number("focus", 0.0..=100.0, 4.0)?;
    let extent = o.number("extent", 1e-3..=1e6, 500.0)?;
    let size = o.integer("size", 2..=LONGEST, 256)? as usize;
    let metre = o.number("metre", 1e-9..=1e9, 1.0)?;
    let time = o.number("time", -1e6..=1e6, c.host.time)?;
    let center = o.vector("center", DVec3::ZERO)?;
    o.finish()?;
    let half = 0.5 * extent;
    let frame = within(c, [size, 1, size], DVec3::splat(-half), DVec3::splat(half), Edge::Repeat)?;
    let wind = Wind { speed, direction, focus };
    let halt = c.host.halt();
    let metres = spectrum::synthesize(frame, seed(c)?, Motion::DeepWater(time), wind.spectrum(), &halt);
    // Everything so far was in metres.
    done(times(metres, metre).map(|mut s| {
        s.frame.spacing = s.frame.spacing.map(|d| d * metre);
        s.frame.origin = [center.x - half * metre, 0.0, center.z - half * metre];
        s
    }))
}

fn random_additions(c: &Call<'_>) -> Outcome<Dynamic> {
    let mut o = Options::new(c, 1)?;
    let levels = o.integer("levels", 1..=13, 8)? as u32;
    let hurst = o.number("hurst", 0.0..=2.0, 0.8)?;
    let deviation = o.number("deviation", 0.0..=1e9, 1.0)?;
    let extent = o.number("extent", 1e-9..=1e9, 2.0)?;
    let center = o.vector("center", DVec3::ZERO)?;
    let edge = if o.flag("repeat", true)? { Edge::Repeat } else { Edge::Clamp };
    o.finish()?;
    let recipe = additions::Recipe { seed: seed(c)?, hurst, levels };
    let size = recipe.size(edge);
    let frame = within(c, [size, 1, size], center - 0.5 * extent, center + 0.5 * extent, edge)?;
    remembered(c, frame, &format!("random additions {recipe:?} {deviation:?}"), Of::Numbers, || {
        times(recipe.surface(frame, &c.host.halt()), deviation).map_err(failed)
    })
}

fn spot_noise(c: &Call<'_>) -> Outcome<Dynamic> {
    let mut o = Options::new(c, 2)?;
    let frame = place(c, &mut o, Edge::Repeat)?;
    let extent = frame.extent()[0];
    let radius = o.number("radius", 1e-9..=1e9, extent / 16.0)?;
    let density = o.number("density", 0.01..=spot::Recipe::MOST, 8.0)?;
    o.finish()?;
    if !(1e-3 * extent..=1e3 * extent).contains(&radius) {
        return Err(Fault::new(format!("spots of radius {radius} do not suit a grid of extent {extent}"))
            .key("radius")
            .hint("a radius is from a thousandth of the extent to a thousand times it"));
    }
    let recipe = spot::Recipe { seed: seed(c)?, radius, density };
    let spot = c.field(1)?.node;
    let sampler = c.host.sampler(spot)?;
    remembered(c, frame, &format!("spot noise {recipe:?}"), Of::Field(spot), || {
        recipe.texture(frame, sampler, &c.host.halt()).map_err(failed)
    })
}

fn bake(c: &Call<'_>) -> Outcome<Dynamic> {
    let mut o = Options::new(c, 1)?;
    let sizes = sizes(c, &mut o)?;
    let extent = o.number("extent", 1e-9..=1e9, 2.0)?;
    let center = o.vector("center", DVec3::ZERO)?;
    let min = o.vector("min", center - 0.5 * extent)?;
    let max = o.vector("max", center + 0.5 * extent)?;
    let volume = o.flag("volume", false)?;
    let edge = if o.flag("repeat", false)? { Edge::Repeat } else { Edge::Clamp };
    let like = o.get("like").map(|v| v.read_lock::<GridValue>().map(|g| g.clone()));
    o.finish()?;
    let frame = match like {
        Some(Some(grid)) => {
            c.host.take_samples(grid.0.frame().count())?;
            *grid.0.frame()
        }
        Some(None) => return Err(Fault::new("`like` of `bake` must be a grid").key("like")),
        None => {
            let size = if volume { sizes } else { [sizes[0], 1, sizes[2]] };
            within(c, size, min, max, edge)?
        }
    };
    let field = c.field(0)?.node;
    let sampler = c.host.sampler(field)?;
    remembered(c, frame, "bake", Of::Field(field), || {
        let samples = Samples::of(frame, sampler, &c.host.halt()).map_err(failed)?;
        if let Some(i) = samples.values.iter().position(|v| !v.is_finite()) {
            let [x, y, z] = frame.place(i);
            let message = format!("the field has no finite value at ({x}, {y}, {z}), where it is sampled");
            return Err(Fault::new(message));
        }
        Ok(samples)
    })
}

/// One number of samples for all axes, or one for each.
fn sizes(c: &Call<'_>, o: &mut Options<'_, '_>) -> Outcome<[usize; 3]> {
    let three = o.get("size").and_then(|v| v.read_lock::<Array>().map(|a| a.clone()));
    let Some(three) = three else { return Ok([o.integer("size", 2..=LONGEST, 256)? as usize; 3]) };
    let whole = |v: &Dynamic| number(v).filter(|v| v.fract() == 0.0 && (1.0..=LONGEST as f64).contains(v));
    let wrong = || {
        let message = format!("`size` of `{}` must be a number of samples, or three of them", c.name);
        Fault::new(message).key("size")
    };
    let sizes = entries("size", &three, |v| whole(v).map(|v| v as usize), wrong)?;
    <[usize; 3]>::try_from(sizes).map_err(|_| wrong())
}

fn eroded(c: &Call<'_>) -> Outcome<Dynamic> {
    let grid = grid(c, 0)?;
    let mut o = Options::new(c, 1)?;
    let usual = Rain::default();
    let rain = Rain {
        drops: o.number("rain", 0.0..=100.0, usual.drops)?,
        steps: o.integer("steps", 1..=10_000, usual.steps.into())? as u32,
        evaporation: o.number("evaporation", 0.0..=1.0, usual.evaporation)?,
        capacity: o.number("capacity", 0.0..=100.0, usual.capacity)?,
        erosion: o.number("erosion", 0.0..=1.0, usual.erosion)?,
        deposition: o.number("deposition", 0.0..=1.0, usual.deposition)?,
        inertia: o.number("inertia", 0.0..=0.99, usual.inertia)?,
        brush: o.number("brush", 1.0..=16.0, usual.brush)?,
        seed: o.integer("seed", INT::MIN..=INT::MAX, 1)? as u64,
    };
    o.finish()?;
    c.host.take_samples(grid.0.frame().count())?;
    remembered(c, *grid.0.frame(), &format!("eroded {rain:?}"), Of::Grid(&grid.0), || {
        rain.erode(grid.0.samples(), &c.host.halt()).map_err(failed)
    })
}

fn weathered(c: &Call<'_>) -> Outcome<Dynamic> {
    let grid = grid(c, 0)?;
    let mut o = Options::new(c, 1)?;
    let talus = libm::tan(o.number("talus", 0.0..=89.0, 35.0)?.to_radians());
    let rate = o.number("rate", 0.0..=1.0, 1.0)?;
    let steps = o.integer("steps", 1..=100_000, 60)? as u32;
    o.finish()?;
    c.host.take_samples(grid.0.frame().count())?;
    let weather = Weathering { talus, rate, steps };
    remembered(c, *grid.0.frame(), &format!("weathered {weather:?}"), Of::Grid(&grid.0), || {
        weather.weather(grid.0.samples(), &c.host.halt()).map_err(failed)
    })
}

fn steepness(c: &Call<'_>) -> Outcome<Dynamic> {
    let grid = grid(c, 0)?.0;
    c.host.take_samples(grid.frame().count())?;
    let slope = |p: [f64; 3]| {
        let [x, y, z] = grid.jet(Order::Gradient, p).grad;
        (x * x + y * y + z * z).sqrt()
    };
    done(Samples::of(*grid.frame(), slope, &c.host.halt()))
}
