//! Sky, and the scene that holds everything.

use super::components::Corrected;
use super::surroundings::{MoonValue, SeaValue};
use super::{Call, Library, fields, light};
use crate::scene::{Aabb, Air, Camera, Film, Keep, Light, Material, Sky, Sun};
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
    /// How it reflects, if not matt.
    pub material: Option<Material>,
    /// Its main light.
    pub sun: Sun,
    /// Other lights.
    pub lights: Vec<Light>,
    /// Everything around it.
    pub sky: Sky,
    /// A moon.
    pub moon: Option<MoonValue>,
    /// Water that the solid stands in.
    pub sea: Option<SeaValue>,
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
        SceneValue {
            surface,
            material: None,
            camera,
            sun,
            lights: Vec::new(),
            sky,
            moon: None,
            sea: None,
            film,
            bounds: None,
            keep: None,
        }
    }
}

pub(super) fn register(lib: &mut Library<'_>) {
    lib.name_type::<SceneValue>("Scene");
    lib.name_type::<Sky>("Sky");
    let sentence = "What surrounds the solid. Options: zenith, nadir (light from above and below), up (a direction, or \"outward\" on a planet), background, air (which gives light of its own in place of zenith and nadir), stars (true, or how bright they are beside those of a photograph).";
    lib.def("sky(options)", sentence, "sky(#{ zenith: \"#8090a0\", background: \"#000\" })", sky);
    let sentence = "What a picture shows. Options: surface (needed), material, camera, sun, lights (an array of more suns, and lamps), sky, moon, sea, film, bounds (half the size of a cube, or [min, max]; what is beyond is left out; found around all of the solid unless given).";
    lib.def(
        "scene(options)",
        sentence,
        "scene(#{ surface: sphere(1.0), camera: orbit(#{ distance: 3.0 }) })",
        build,
    );
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
        material: o.given("material", "material(#{ ... })")?,
        lights: light::lights(&mut o)?,
        moon: o.given("moon", "moon(#{ ... })")?,
        sea: o.given("sea", "sea(#{ ... })")?,
        film: o.typed("film", "film(#{ ... })", default.film)?,
        bounds: bounds(c, &mut o)?,
        ..default
    };
    o.finish()?;
    Ok(Dynamic::from(scene))
}

/// The option of this name.
pub(super) fn bounds(c: &Call<'_>, o: &mut Options<'_, '_>) -> Outcome<Option<Aabb>> {
    let Some(given) = o.get("bounds") else { return Ok(None) };
    let given = o.still("bounds", "half the size of a cube, or two corners [min, max]", &given)?;
    boxed(c, &given).map(Some)
}

fn boxed(c: &Call<'_>, v: &Dynamic) -> Outcome<Aabb> {
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
