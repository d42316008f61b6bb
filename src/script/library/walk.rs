//! Cameras that stand on the ground.
//!
//! The ground under a place is where a line straight down first comes into the solid. That it is the first is
//! proven, by enclosures of the field along the line ([`first_inside`]), so that no camera ends up in a cave or
//! under an overhang.

use super::camera::{FAR, TURNS, perspective};
use super::{Call, Library};
use crate::field::{Field, first_inside};
use crate::scene::{Camera, direction};
use crate::script::fault::{Fault, Outcome};
use crate::script::options::Options;
use crate::script::value::number;
use glam::DVec3;
use rhai::{Array, Dynamic};

/// Ground is looked for so far away at least, in units of length,
const REACH: f64 = 4096.0;

/// and so many times as far as the place is from the origin.
const REACHES: f64 = 16.0;

/// By how much farther each time, while all is solid.
const FARTHER: f64 = 1024.0;

/// How exactly the camera keeps its height, as a share of it.
const PRECISION: f64 = 1e-6;

pub(super) fn register(lib: &mut Library<'_>) {
    let sentence = "A camera that stands at a height above the ground, so that it can be led across country. Options: ground (needed: a planet around the origin, or any solid if `up` is given), at (a latitude and a longitude in degrees, [lat, lon], where longitude 0 is +z and 90 is +x; or a point above or below the place), height (above the first ground that is met from outside on the way down), heading (degrees from north to the east; north is +y on a planet, and -z where `up` is +y), pitch (degrees upwards), up (away from the origin unless given); fov, aperture and focus as `look_at`.";
    let example = "walk(#{ ground: sphere(1.0), at: [20.0, 10.0], height: 1.0, pitch: -75.0 })";
    lib.def("walk(options)", sentence, example, walk);
}

/// Where a camera is to stand.
struct Place {
    /// A point above or below it.
    at: DVec3,
    /// Away from the ground, and level: unit vectors.
    up: DVec3,
    north: DVec3,
    /// Whether the way down ends at the origin.
    is_on_planet: bool,
}

fn walk(c: &Call<'_>) -> Outcome<Dynamic> {
    let mut o = Options::new(c, 0)?;
    let ground = o.field("ground")?.node;
    let place = Place::read(&mut o)?;
    let height = o.number("height", 0.0..=FAR, 0.01)?;
    let heading = o.number("heading", -TURNS..=TURNS, 0.0)?.to_radians();
    let pitch = o.number("pitch", -90.0..=90.0, 0.0)?.to_radians();
    let eye = place.above(c, &mut Field::of_tape(&c.host.tape(ground)?), height)?;
    let Place { up, north, .. } = place;
    let ahead = libm::cos(heading) * north + libm::sin(heading) * north.cross(up);
    let view = libm::cos(pitch) * ahead + libm::sin(pitch) * up;
    let up = libm::cos(pitch) * up - libm::sin(pitch) * ahead;
    // As far away as numbers are large here, so that the direction is as exact as they.
    let target = eye + eye.length().max(1.0) * view;
    let camera = Camera { up, ..Camera::look_at(eye, target) };
    let projection = perspective(&mut o, &camera, None)?;
    o.finish()?;
    Ok(Dynamic::from(camera.with(projection)))
}

impl Place {
    /// The place that options say.
    fn read(o: &mut Options<'_, '_>) -> Outcome<Place> {
        let at = point(o)?;
        if o.get("up").is_some() {
            let up = o.direction("up", DVec3::Y)?;
            return Ok(Place { at, up, north: north_on_plain(up), is_on_planet: false });
        }
        let up = at.try_normalize().ok_or_else(|| {
            let fault = Fault::new("nothing is up at the centre of a planet").key("at");
            fault.hint("give a point away from the origin, a latitude and a longitude, or `up`")
        })?;
        Ok(Place { at, up, north: north_on_planet(up), is_on_planet: true })
    }

    /// The point at a height above the ground.
    fn above(&self, c: &Call<'_>, ground: &mut Field, height: f64) -> Outcome<DVec3> {
        let mut reach = REACH.max(REACHES * self.at.length());
        let down = -self.up;
        loop {
            let (origin, end) = if self.is_on_planet { (DVec3::ZERO, 0.0) } else { (self.at, reach) };
            match first_inside(ground, (origin, down), [-reach, end], PRECISION * height, &c.host.halt()) {
                Ok(Some(t)) if t > -reach => return Ok(origin + (t - height) * down),
                // All is solid so far up: planets may be larger.
                Ok(Some(_)) if reach < FAR => reach *= FARTHER,
                Ok(Some(_)) => {
                    return Err(nowhere("the ground has no top here: all is solid as far up as one can see"));
                }
                Ok(None) => return Err(nowhere("there is no ground here")),
                Err(unknown) => {
                    return Err(Fault::new(format!("no ground was found here: {unknown}")).key("ground"));
                }
            }
        }
    }
}

fn nowhere(message: &str) -> Fault {
    Fault::new(message)
        .key("at")
        .hint("the way down goes from `at` along -`up`, or to the origin of a planet")
}

/// The point that is meant.
fn point(o: &mut Options<'_, '_>) -> Outcome<DVec3> {
    let given = o.get("at").ok_or_else(|| o.missing("at"))?;
    let given = o.still("at", "a latitude and a longitude, or a point", &given)?;
    let pair = given.read_lock::<Array>().map(|a| a.clone()).filter(|a| a.len() == 2);
    let Some(pair) = pair else { return o.vector("at", DVec3::Y) };
    let wrong =
        || o.mismatch("at", "a latitude from -90 to 90 and a longitude in degrees, or a point", &given);
    let angle = |i: usize, most: f64| number(&pair[i]).filter(|angle| angle.abs() <= most).ok_or_else(wrong);
    Ok(direction(angle(1, TURNS)?, angle(0, 90.0)?))
}

/// North on a planet around the origin whose north pole is +y: along the meridian, which has a direction at
/// a pole too.
fn north_on_planet(up: DVec3) -> DVec3 {
    let meridian = libm::atan2(up.x, up.z);
    let outward = DVec3::new(libm::sin(meridian), 0.0, libm::cos(meridian));
    (libm::hypot(up.x, up.z) * DVec3::Y - up.y * outward).normalize_or(DVec3::Y)
}

/// North where the same direction is up everywhere: -z, which is ahead of a camera unless told otherwise; +y
/// where -z is not level at all.
fn north_on_plain(up: DVec3) -> DVec3 {
    let ahead = if up.z.abs() < 0.99 { DVec3::NEG_Z } else { DVec3::Y };
    ahead.reject_from_normalized(up).normalize_or(DVec3::Y)
}
