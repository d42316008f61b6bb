//! Grids from files: pictures as heightfields, and volumes.

use super::files::with_options;
use super::grid::{done, failed, listed};
use super::{Call, Library};
use crate::exchange::{self, image};
use crate::grid::{Edge, Frame, Samples};
use crate::script::fault::{Fault, Outcome};
use crate::script::modules::Resolver;
use crate::script::options::Options;
use glam::DVec3;
use rhai::Dynamic;

pub(super) fn register(lib: &mut Library<'_>) {
    let sentence = listed(
        "A picture (PNG or EXR, in the folder of the main script or below) as a heightfield that is seen from above: its rows go along x, its top is at the least z.",
        &[
            "extent: its length along x; its pixels are square",
            "height: of white in a PNG, of one unit in an EXR; black and zero are 0",
            "center",
            "repeat: else it comes to rest within two samples beyond the edge",
            "channel: \"R\", \"A\" and so on, or a name in an EXR; else it is the brightness of a PNG, or the first of Y, R and Z in an EXR",
        ],
    );
    let example = "load_heightfield(\"hills.png\", #{ extent: 4.0, height: 0.5 })";
    with_options(lib, "load_heightfield", &sentence, example, load_heightfield);
    let sentence = listed(
        "A volume from a pair of files such as cloud.json and cloud.raw, in the folder of the main script or below: `load_grid` is given the name of the first, a header such as `{ \"type\": \"float32\", \"size\": [64, 32, 64], \"origin\": [-1, 0, -1], \"spacing\": [0.03, 0.03, 0.03], \"edge\": \"clamp\" }`. The other holds the numbers, four bytes each, the least first, along x first, then y, then z. The header says where it lies, unless the options do.",
        &["extent: its length along x", "center", "repeat: true or false"],
    );
    with_options(lib, "load_grid", &sentence, "load_grid(\"cloud.json\", #{ extent: 2.0 })", load_grid);
}

fn load_heightfield(c: &Call<'_>, folder: &Resolver) -> Outcome<Dynamic> {
    let mut o = Options::new(c, 1)?;
    let height = o.number("height", -1e9..=1e9, 1.0)?;
    let channel = o.get("channel").map(|given| {
        let wrong = |_| o.mismatch("channel", "a name such as \"R\"", &given);
        given.clone().into_string().map_err(wrong)
    });
    let channel = channel.transpose()?;
    let place = Place::read(&mut o)?;
    o.finish()?;
    let (name, bytes) = folder.bytes(&c.text(0)?)?;
    let image = image::read(&name, &bytes, channel.as_deref(), c.host.samples_left())?;
    let size = [image.width, 1, image.height];
    let frame = Frame { size, origin: [0.0; 3], spacing: [1.0; 3], edge: Edge::Clamp };
    let usual = Place { extent: Some(2.0), center: Some(DVec3::ZERO), edge: None };
    let frame = place.or(usual).of(frame)?;
    c.host.take_samples(frame.count())?;
    let values = image.values.iter().map(|v| height * v).collect();
    done(Ok(Samples { frame, values }))
}

fn load_grid(c: &Call<'_>, folder: &Resolver) -> Outcome<Dynamic> {
    let mut o = Options::new(c, 1)?;
    let place = Place::read(&mut o)?;
    o.finish()?;
    let file = c.text(0)?;
    if !file.ends_with(".json") {
        return Err(Fault::new(format!("{file:?} is not the name of a header"))
            .hint("a volume is two files, such as cloud.json and cloud.raw: give the name of the first"));
    }
    let (name, header) = folder.bytes(&file)?;
    let (_, data) = folder.bytes(&exchange::grid::data_name(&file))?;
    let samples = exchange::grid::read(&name, &header, &data)?;
    let frame = place.of(samples.frame)?;
    c.host.take_samples(frame.count())?;
    done(Ok(Samples { frame, ..samples }))
}

/// Where the options put a grid, as far as they say it.
struct Place {
    /// Length along x.
    extent: Option<f64>,
    /// The middle.
    center: Option<DVec3>,
    /// What lies beyond.
    edge: Option<Edge>,
}

impl Place {
    fn read(o: &mut Options<'_, '_>) -> Outcome<Place> {
        let extent = o.get("extent").map(|_| o.number("extent", 1e-9..=1e9, 0.0)).transpose()?;
        let center = o.get("center").map(|_| o.vector("center", DVec3::ZERO)).transpose()?;
        let repeat = o.get("repeat").map(|_| o.flag("repeat", false)).transpose()?;
        let edge = repeat.map(|repeat| if repeat { Edge::Repeat } else { Edge::Clamp });
        Ok(Place { extent, center, edge })
    }

    /// This where it says something, else another.
    fn or(self, other: Place) -> Place {
        Place {
            extent: self.extent.or(other.extent),
            center: self.center.or(other.center),
            edge: self.edge.or(other.edge),
        }
    }

    /// A frame moved there, with its proportions.
    fn of(self, frame: Frame) -> Outcome<Frame> {
        let lengths = |edge: Edge| {
            // The last sample of a grid that repeats is followed by the first.
            let gaps = |n: usize| if edge == Edge::Repeat { n } else { n.max(2) - 1 };
            DVec3::from_array(std::array::from_fn(|axis| gaps(frame.size[axis]) as f64 * frame.spacing[axis]))
        };
        let own = lengths(frame.edge);
        let edge = self.edge.unwrap_or(frame.edge);
        let lengths = lengths(edge);
        let scale = self.extent.map_or(1.0, |extent| extent / lengths.x);
        let center = self.center.unwrap_or(DVec3::from(frame.origin) + 0.5 * own);
        let (origin, spacing) = (center - 0.5 * scale * lengths, scale * DVec3::from(frame.spacing));
        // The samples of a heightfield lie in the plane y = 0, and nothing changes along y.
        let flat = |v: DVec3, y: f64| if frame.is_heightfield() { [v.x, y, v.z] } else { v.to_array() };
        let moved = Frame { origin: flat(origin, 0.0), spacing: flat(spacing, 1.0), edge, ..frame };
        moved.checked().map_err(failed)
    }
}
