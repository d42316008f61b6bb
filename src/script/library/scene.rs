//! Light, sky, film, and the scene that holds everything.

use super::components::Corrected;
use super::{Call, Library, fields};
use crate::scene::{self, Aabb, Air, Camera, Film, Keep, Sky, Sun};
use crate::script::fault::{Fault, Outcome};
use crate::script::options::Options;
use crate::script::value::{Field, number};
use glam::DVec3;
use rhai::{Array, Dynamic};

/// A scene before its graph is complete.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneValue {
    /// The solid.
    pub surface: Field,
    /// Where it is seen from.
    pub camera: Camera,
    /// Its main light.
    pub sun: Sun,
    /// Everything around it.
    pub sky: Sky,
    /// Picture size and exposure.
    pub film: Film,
    /// Where it is, if the script says.
    pub bounds: Option<Aabb>,
    /// Which of its components are there.
    pub keep: Option<Keep>,
}

impl SceneValue {
    /// A field seen by default.
    pub fn new(surface: Field) -> Self {
        let (camera, sun, sky, film) = (Camera::default(), Sun::default(), Sky::default(), Film::default());
        SceneValue { surface, camera, sun, sky, film, bounds: None, keep: None }
    }
}

pub(super) fn register(lib: &mut Library<'_>) {
    lib.name_type::<SceneValue>("Scene");
    lib.name_type::<Sun>("Sun");
    lib.name_type::<Sky>("Sky");
    lib.name_type::<Film>("Film");
    let sentence = "The light of a sun. Options: azimuth, elevation (degrees), strength, color, shadows.";
    lib.def("sun(options)", sentence, "sun(#{ azimuth: 120.0, elevation: 35.0 })", sun);
    let sentence = "What surrounds the solid. Options: zenith, nadir (light from above and below), up (a direction, or \"outward\" on a planet), background, air (which gives light of its own in place of zenith and nadir), stars (true, or how bright they are beside those of a photograph).";
    lib.def("sky(options)", sentence, "sky(#{ zenith: \"#8090a0\", background: \"#000\" })", sky);
    let sentence = "The picture. Options: width, height (pixels), samples (per pixel), exposure (stops).";
    lib.def("film(options)", sentence, "film(#{ width: 1920, height: 1080, samples: 16 })", film);
    let sentence = "What a picture shows. Options: surface (needed), camera, sun, sky, film, bounds (half the size of a cube, or [min, max]).";
    lib.def(
        "scene(options)",
        sentence,
        "scene(#{ surface: sphere(1.0), camera: orbit(#{ distance: 3.0 }) })",
        build,
    );
}

fn sun(c: &Call<'_>) -> Outcome<Dynamic> {
    let default = Sun::default();
    let mut o = Options::new(c, 0)?;
    let azimuth = o.number("azimuth", -3600.0..=3600.0, 60.0)?;
    let elevation = o.number("elevation", -90.0..=90.0, 45.0)?;
    let strength = o.number("strength", 0.0..=1e6, 2.6)?;
    let color = o.color("color", DVec3::ONE)?;
    let shadows = o.flag("shadows", default.shadows)?;
    o.finish()?;
    let direction = scene::direction(azimuth, elevation);
    Ok(Dynamic::from(Sun { direction, irradiance: strength * color, shadows }))
}

fn sky(c: &Call<'_>) -> Outcome<Dynamic> {
    let default = Sky::default();
    let mut o = Options::new(c, 0)?;
    let zenith = o.color("zenith", default.zenith)?;
    let nadir = o.color("nadir", default.nadir)?;
    let background = o.color("background", default.background)?;
    let outward = o.get("up").is_some_and(|v| v.into_string().is_ok_and(|text| text == "outward"));
    let up = if outward { None } else { Some(o.direction("up", DVec3::Y)?) };
    let air = o.typed("air", "air(#{ ... })", Air::clear(0.0, 0.0, DVec3::ZERO))?;
    let air = (air.radius > 0.0).then_some(air);
    let stars = o.amount("stars", 0.0..=1e9)?;
    o.finish()?;
    Ok(Dynamic::from(Sky { zenith, nadir, up, background, stars, air }))
}

fn film(c: &Call<'_>) -> Outcome<Dynamic> {
    let default = Film::default();
    let mut o = Options::new(c, 0)?;
    let width = o.integer("width", 1..=Film::MAX_SIDE.into(), i64::from(default.width))?;
    let height = o.integer("height", 1..=Film::MAX_SIDE.into(), i64::from(default.height))?;
    let samples = o.integer("samples", 1..=Film::MAX_SAMPLES.into(), i64::from(default.samples))?;
    let exposure = o.number("exposure", -64.0..=64.0, default.exposure)?;
    o.finish()?;
    // The ranges above fit.
    Ok(Dynamic::from(Film { width: width as u32, height: height as u32, samples: samples as u32, exposure }))
}

fn build(c: &Call<'_>) -> Outcome<Dynamic> {
    let mut o = Options::new(c, 0)?;
    let corrected = o.get("surface").and_then(|v| v.read_lock::<Corrected>().map(|c| *c));
    let (surface, keep) = match corrected {
        Some(Corrected { field, keep }) => (field, Some(keep)),
        None => (o.field("surface")?, None),
    };
    let default = SceneValue { keep, ..SceneValue::new(surface) };
    let scene = SceneValue {
        camera: o.typed("camera", "a camera such as orbit(#{ ... })", default.camera)?,
        sun: o.typed("sun", "sun(#{ ... })", default.sun)?,
        sky: o.typed("sky", "sky(#{ ... })", default.sky)?,
        film: o.typed("film", "film(#{ ... })", default.film)?,
        bounds: o.get("bounds").map(|v| bounds(c, &v)).transpose()?,
        ..default
    };
    o.finish()?;
    Ok(Dynamic::from(scene))
}

fn bounds(c: &Call<'_>, v: &Dynamic) -> Outcome<Aabb> {
    let wrong = || {
        Fault::new("`bounds` of `scene` must be half the size of a cube, or two corners [min, max]")
            .key("bounds")
    };
    if let Some(half) = number(v) {
        return if half > 0.0 && half.is_finite() { Ok(Aabb::cube(half)) } else { Err(wrong()) };
    }
    if let Some(r) = fields::region_of(v) {
        let (min, max) = (DVec3::from_array(r.0.map(|i| i.lo)), DVec3::from_array(r.0.map(|i| i.hi)));
        return Ok(Aabb { min, max });
    }
    let corners = v.read_lock::<Array>().map(|a| a.clone()).filter(|a| a.len() == 2).ok_or_else(wrong)?;
    let corner = |i: usize| c.vec3_of(&corners[i])?.filter(|v| v.is_finite()).ok_or_else(wrong);
    let (min, max) = (corner(0)?, corner(1)?);
    if min.cmplt(max).all() {
        return Ok(Aabb { min, max });
    }
    Err(Fault::new(
        "`bounds` of `scene` is empty: each coordinate of the first corner must lie below that of the second",
    )
    .key("bounds"))
}
