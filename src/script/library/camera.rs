//! Cameras: where they stand, and how they see.

use super::{Call, Library};
use crate::scene::{Camera, Lens, Projection};
use crate::script::fault::{Fault, Outcome};
use crate::script::options::Options;
use crate::script::value::{Value, Vec3};
use glam::DVec3;
use rhai::Dynamic;

/// Farthest that anything is from anything, in units of length.
pub(super) const FAR: f64 = 1e9;

/// Smallest distance that is one.
pub(super) const NEAR: f64 = 1e-12;

/// Degrees of an angle that may go around many times, as it does in an animation.
pub(super) const TURNS: f64 = 1e6;

pub(super) fn register(lib: &mut Library<'_>) {
    lib.name_type::<Camera>("Camera");
    let sentence = "A camera on a sphere around a target. Options: distance (4), azimuth (degrees; 0 is in front, grows to the right; 30), elevation (20), target (the origin); and those of `look_at` for how it sees. Numbers may be functions of time: azimuth: 10.0 * time.";
    let example = "orbit(#{ distance: 3.2, azimuth: 40.0, elevation: 20.0, fov: 35.0 })";
    lib.def("orbit(options)", sentence, example, orbit);
    let sentence = "A camera at a point that looks at another. Options: eye ([0, 0, 4]), target (the origin), up (the y axis); fov (vertical, degrees; 35); aperture (radius of the lens in units of length, 0 unless given: everything is sharp) and focus (distance of what is sharp, or a point there; the target unless given). With projection: \"orthographic\" it has parallel rays and a height (of what the picture shows, in units of length) in place of fov.";
    let example = "look_at(#{ eye: [0, 1, 4], target: [0, 0, 0], aperture: 0.1 })";
    lib.def("look_at(options)", sentence, example, look_at);
    let sentence = "A camera that sees all around, equirectangular: 360 degrees across, the direction of the target in the middle, and 180 from straight up to straight down. It stays upright. Pictures are to be twice as wide as high. Options: eye, target (of which only the direction across `up` counts; -z unless given), up.";
    lib.def("panorama(options)", sentence, "panorama(#{ eye: [0, 0, 2] })", |c| {
        around(c, Projection::Panorama)
    });
    let sentence = "A camera that sees all around, as the six faces of a cube, each as OpenGL and glTF have it: +x, -x, +y in the upper row of the picture, -y, +z, -z in the lower one. Axes are those of the scene unless the camera is turned. Pictures are to be 3 : 2. Options as those of `panorama`.";
    lib.def("cube_map(options)", sentence, "cube_map(#{ eye: [0, 0, 2] })", |c| {
        around(c, Projection::CubeMap)
    });
    type Read = fn(&Camera) -> DVec3;
    let properties: [(&'static str, Read); 3] =
        [("eye", |c| c.eye), ("target", |c| c.target), ("up", |c| c.up)];
    for (name, read) in properties {
        lib.property::<Camera>(name, move |_, camera| Ok(Dynamic::from(Vec3(read(camera).to_array()))));
    }
}

fn orbit(c: &Call<'_>) -> Outcome<Dynamic> {
    let mut o = Options::new(c, 0)?;
    let distance = o.number("distance", 1e-9..=FAR, 4.0)?;
    let azimuth = o.number("azimuth", -TURNS..=TURNS, 30.0)?;
    let elevation = o.number("elevation", -90.0..=90.0, 20.0)?;
    let target = o.vector("target", DVec3::ZERO)?;
    let camera = Camera::orbit(target, distance, azimuth, elevation);
    let projection = projection(&mut o, &camera)?;
    o.finish()?;
    Ok(Dynamic::from(camera.with(projection)))
}

fn look_at(c: &Call<'_>) -> Outcome<Dynamic> {
    let mut o = Options::new(c, 0)?;
    let eye = o.vector("eye", DVec3::new(0.0, 0.0, 4.0))?;
    let target = o.vector("target", DVec3::ZERO)?;
    let camera = standing(&mut o, eye, target)?;
    let projection = projection(&mut o, &camera)?;
    o.finish()?;
    Ok(Dynamic::from(camera.with(projection)))
}

fn around(c: &Call<'_>, projection: Projection) -> Outcome<Dynamic> {
    let mut o = Options::new(c, 0)?;
    let eye = o.vector("eye", DVec3::ZERO)?;
    let target = o.vector("target", eye + DVec3::NEG_Z)?;
    let camera = standing(&mut o, eye, target)?;
    o.finish()?;
    Ok(Dynamic::from(camera.with(projection)))
}

/// A camera between two points that knows which way is up.
fn standing(o: &mut Options<'_, '_>, eye: DVec3, target: DVec3) -> Outcome<Camera> {
    let up = o.direction("up", DVec3::Y)?;
    let view = (target - eye).try_normalize();
    let view =
        view.ok_or_else(|| Fault::new("the camera looks nowhere: `eye` equals `target`").key("eye"))?;
    if view.cross(up).length() < 1e-9 {
        return Err(Fault::new("the camera has no upright: `up` points along the view").key("up"));
    }
    Ok(Camera { up, ..Camera::look_at(eye, target) })
}

/// How a camera is to see.
fn projection(o: &mut Options<'_, '_>, camera: &Camera) -> Outcome<Projection> {
    let distance = camera.eye.distance(camera.target);
    match o.choice("projection", &["perspective", "orthographic"])? {
        "orthographic" => {
            refuse(o, &["fov", "aperture", "focus"], "an orthographic camera")?;
            // What the usual perspective shows at the target.
            let usual = 2.0 * distance * libm::tan(0.5 * Camera::FOV.to_radians());
            Ok(Projection::Orthographic { height: o.number("height", NEAR..=FAR, usual)? })
        }
        _ => {
            refuse(o, &["height"], "a camera with a perspective")?;
            perspective(o, camera, Some(distance))
        }
    }
}

/// Options that a camera of another kind has.
fn refuse(o: &mut Options<'_, '_>, keys: &[&'static str], whose: &str) -> Outcome<()> {
    match keys.iter().find(|key| o.get(key).is_some()) {
        None => Ok(()),
        Some(key) => {
            let fault = Fault::new(format!("{whose} has no `{key}`")).key(key);
            Err(fault
                .hint("projection: \"orthographic\" takes height; \"perspective\" fov, aperture and focus"))
        }
    }
}

/// A perspective, sharp at a distance unless it says where.
pub(super) fn perspective(
    o: &mut Options<'_, '_>,
    camera: &Camera,
    usual: Option<f64>,
) -> Outcome<Projection> {
    let fov = o.number("fov", 0.001..=179.0, Camera::FOV)?;
    let has_lens = o.get("aperture").is_some();
    let radius = o.number("aperture", 0.0..=FAR, 0.0)?;
    let focus = match o.get("focus") {
        Some(_) if !has_lens => {
            let fault = Fault::new("`focus` needs an `aperture`: through a pinhole everything is sharp");
            return Err(fault.key("focus").hint("give the radius of the lens: aperture: 0.05"));
        }
        Some(given) => focus(o, camera, &given)?,
        None if !has_lens => return Ok(Projection::Perspective { fov, lens: None }),
        None => usual.ok_or_else(|| o.missing("focus"))?,
    };
    Ok(Projection::Perspective { fov, lens: (radius > 0.0).then_some(Lens { radius, focus }) })
}

/// The distance of what is sharp: given as such, or by a point there.
fn focus(o: &mut Options<'_, '_>, camera: &Camera, given: &Dynamic) -> Outcome<f64> {
    if !matches!(o.value(given)?, Some(Value::Vector(_))) {
        return o.number("focus", NEAR..=FAR, 1.0);
    }
    let there = o.vector("focus", camera.target)? - camera.eye;
    let depth = there.dot((camera.target - camera.eye).normalize_or_zero());
    if depth < NEAR {
        return Err(Fault::new("the point of `focus` does not lie in front of the camera").key("focus"));
    }
    Ok(depth)
}
