//! Lights.

use super::{Call, Library};
use crate::scene::{Lamp, Light, Sun, direction};
use crate::script::fault::Outcome;
use crate::script::options::{Options, entries};
use glam::DVec3;
use rhai::{Array, Dynamic};

pub(super) fn register(lib: &mut Library<'_>) {
    lib.name_type::<Sun>("Sun");
    lib.name_type::<Lamp>("Lamp");
    let sentence = "The light of a sun. Options: azimuth (degrees; 60), elevation (45), strength (2.6; of PI, what is white and faces it has the brightness 1), color (white), size (degrees across, up to 90; 0, a point; its shadows are soft where it has one, 0.53 as seen from the Earth), shadows (true).";
    lib.def("sun(options)", sentence, "sun(#{ azimuth: 120.0, elevation: 35.0, size: 0.53 })", sun);
    let sentence = "The light of a ball that is not seen itself. Options: position ([2, 3, 2]), strength (that of a sun at a distance of 1, and a quarter of it at 2; 20), color (white), radius (its shadows are soft where it has one; 0), shadows (true). Water does not dim it by how far it is, but by how deep what it lights lies, as if it shone from above.";
    lib.def("lamp(options)", sentence, "lamp(#{ position: [2, 3, 1], strength: 8.0, radius: 0.2 })", lamp);
}

fn sun(c: &Call<'_>) -> Outcome<Dynamic> {
    let default = Sun::default();
    let mut o = Options::new(c, 0)?;
    let azimuth = o.number("azimuth", -3600.0..=3600.0, 60.0)?;
    let elevation = o.number("elevation", -90.0..=90.0, 45.0)?;
    let strength = o.number("strength", 0.0..=1e6, 2.6)?;
    let color = o.color("color", DVec3::ONE)?;
    let size = o.number("size", 0.0..=90.0, default.size)?;
    let shadows = o.flag("shadows", default.shadows)?;
    o.finish()?;
    let direction = direction(azimuth, elevation);
    Ok(Dynamic::from(Sun { direction, irradiance: strength * color, size, shadows }))
}

fn lamp(c: &Call<'_>) -> Outcome<Dynamic> {
    let mut o = Options::new(c, 0)?;
    let position = o.vector("position", DVec3::new(2.0, 3.0, 2.0))?;
    let strength = o.number("strength", 0.0..=1e12, 20.0)?;
    let color = o.color("color", DVec3::ONE)?;
    let radius = o.number("radius", 0.0..=1e9, 0.0)?;
    let shadows = o.flag("shadows", true)?;
    o.finish()?;
    Ok(Dynamic::from(Lamp { position, radius, intensity: strength * color, shadows }))
}

/// The lights of an option: an array of them.
pub(super) fn lights(o: &mut Options<'_, '_>) -> Outcome<Vec<Light>> {
    let Some(given) = o.get("lights") else { return Ok(Vec::new()) };
    let wrong = || o.mismatch("lights", "an array of sun(#{ ... }) and lamp(#{ ... })", &given);
    let list = given.read_lock::<Array>().map(|a| a.clone()).ok_or_else(wrong)?;
    let light = |v: &Dynamic| {
        let sun = v.read_lock::<Sun>().map(|sun| Light::Sun(*sun));
        sun.or_else(|| v.read_lock::<Lamp>().map(|lamp| Light::Lamp(*lamp)))
    };
    entries("lights", &list, light, wrong)
}
