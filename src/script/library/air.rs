//! The air around a planet.

use super::{Call, Library};
use crate::scene::{Absorber, Air, Haze};
use crate::script::fault::Outcome;
use crate::script::options::Options;
use glam::DVec3;
use rhai::{Dynamic, Map};

/// Allowed lengths.
const LENGTHS: std::ops::RangeInclusive<f64> = 1e-9..=1e9;

/// The Earth's aerosols and ozone in proportion to its gas, for air of which no more is said than that it
/// has some: coefficients to that of green light, heights to that over which gas thins (Hillaire 2020).
const HAZE: [f64; 2] = [3.996 / 13.558, 1.2 / 8.0];
const OZONE: [f64; 3] = [0.650 / 13.558, 1.881 / 13.558, 0.085 / 13.558];
const OZONE_CENTER: f64 = 25.0 / 8.0;
const OZONE_WIDTH: f64 = 15.0 / 8.0;

/// A thin fog: its height to that of gas, and how many of its heights one sees through it, about.
const FOG: [f64; 2] = [1.0 / 50.0, 40.0];

pub(super) fn register(lib: &mut Library<'_>) {
    lib.name_type::<Air>("Air");
    let sentence = "Air around a planet. Options: radius, height (over which it thins by a factor e), scattering (per unit of length, at the radius), haze and fog (maps: scattering, absorption, height, asymmetry from -0.99 to 0.99, 0.8 for light that goes mostly straight on), ozone (a map: absorption, center and width, as heights), ground (the albedo of the planet, which lights from below), multiple (whether light counts that is scattered more than once), shafts (whether the solid throws shadows into the air; some ten times as many rays for each sun). Haze and fog are two layers of the same kind; an empty map makes them, or ozone, as strong beside the gas as on the Earth.";
    let example = "air(#{ radius: 1.0, height: 0.01, scattering: [5.8, 13.5, 33.1], haze: #{ asymmetry: 0.7 }, multiple: true })";
    lib.def("air(options)", sentence, example, air);
}

fn air(c: &Call<'_>) -> Outcome<Dynamic> {
    let mut o = Options::new(c, 0)?;
    let radius = o.number("radius", LENGTHS, 1.0)?;
    let height = o.number("height", LENGTHS, 0.01)?;
    let scattering = o.color("scattering", DVec3::new(5.8, 13.5, 33.1))?;
    let clear = Air::clear(radius, height, scattering);
    let like_earth = DVec3::splat(scattering.y * HAZE[0]);
    let thin = height * FOG[0];
    let visible = DVec3::splat(4.0 / (FOG[1] * thin));
    let haze = part(c, &mut o, "haze", |o| layer(o, like_earth, 0.11, height * HAZE[1]))?;
    let fog = part(c, &mut o, "fog", |o| layer(o, visible, 0.0, thin))?;
    let absorber = part(c, &mut o, "ozone", |o| ozone(o, &clear))?;
    let ground = o.color("ground", clear.ground)?.min(DVec3::ONE);
    let multiple = o.flag("multiple", clear.multiple)?;
    let shafts = o.flag("shafts", clear.shafts)?;
    o.finish()?;
    Ok(Dynamic::from(Air { haze, fog, absorber, ground, multiple, shafts, ..clear }))
}

/// A part of the air that has options of its own, if it is given.
fn part<T>(
    c: &Call<'_>,
    o: &mut Options<'_, '_>,
    key: &'static str,
    read: impl FnOnce(&mut Options<'_, '_>) -> Outcome<T>,
) -> Outcome<Option<T>> {
    let Some(given) = o.get(key) else { return Ok(None) };
    if !given.is::<Map>() {
        return Err(o.mismatch(key, "an object map, #{ ... }", &given));
    }
    let inner = Call { host: c.host, name: key, place: c.place.clone(), args: &[given] };
    let mut options = Options::new(&inner, 0)?;
    let found = read(&mut options)?;
    options.finish()?;
    Ok(Some(found))
}

/// A layer, with its scattering coefficient, the share of it that is absorbed, and its height unless given.
fn layer(o: &mut Options<'_, '_>, scattering: DVec3, absorbed: f64, height: f64) -> Outcome<Haze> {
    let scattering = o.color("scattering", scattering)?;
    let absorption = o.color("absorption", absorbed * scattering)?;
    let height = o.number("height", LENGTHS, height)?;
    let asymmetry = o.channels("asymmetry", -0.99..=0.99, DVec3::splat(0.8))?;
    Ok(Haze { scattering, absorption, height, asymmetry })
}

fn ozone(o: &mut Options<'_, '_>, gas: &Air) -> Outcome<Absorber> {
    let absorption = o.color("absorption", gas.scattering.y * DVec3::from_array(OZONE))?;
    let center = o.number("center", 0.0..=*LENGTHS.end(), gas.height * OZONE_CENTER)?;
    let width = o.number("width", LENGTHS, gas.height * OZONE_WIDTH)?;
    Ok(Absorber { absorption, center, width })
}
