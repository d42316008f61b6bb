//! Cameras.

use super::Library;
use crate::scene::Camera;
use crate::script::fault::Fault;
use crate::script::options::Options;
use glam::DVec3;
use rhai::Dynamic;

const FAR: f64 = 1e9;

pub(super) fn register(lib: &mut Library<'_>) {
    lib.name_type::<Camera>("Camera");
    let sentence = "A camera on a sphere around a target. Options: distance, azimuth (0 is in front, grows to the right), elevation, fov (vertical, degrees), target.";
    lib.def(
        "orbit(options)",
        sentence,
        "orbit(#{ distance: 3.2, azimuth: 40.0, elevation: 20.0, fov: 35.0 })",
        |c| {
            let mut o = Options::new(c, 0)?;
            let distance = o.number("distance", 1e-9..=FAR, 4.0)?;
            let azimuth = o.number("azimuth", -3600.0..=3600.0, 30.0)?;
            let elevation = o.number("elevation", -90.0..=90.0, 20.0)?;
            let fov = o.number("fov", 0.001..=179.0, 35.0)?;
            let target = o.vector("target", DVec3::ZERO)?;
            o.finish()?;
            Ok(Dynamic::from(Camera::orbit(target, distance, azimuth, elevation, fov)))
        },
    );
    let sentence =
        "A camera at a point that looks at another. Options: eye, target, up, fov (vertical, degrees).";
    lib.def("look_at(options)", sentence, "look_at(#{ eye: [0, 1, 4], target: [0, 0, 0] })", |c| {
        let mut o = Options::new(c, 0)?;
        let eye = o.vector("eye", DVec3::new(0.0, 0.0, 4.0))?;
        let target = o.vector("target", DVec3::ZERO)?;
        let up = o.direction("up", DVec3::Y)?;
        let fov = o.number("fov", 0.001..=179.0, 35.0)?;
        o.finish()?;
        let view = (target - eye).try_normalize();
        let view =
            view.ok_or_else(|| Fault::new("the camera looks nowhere: `eye` equals `target`").key("eye"))?;
        if view.cross(up).length() < 1e-9 {
            return Err(Fault::new("the camera has no upright: `up` points along the view").key("up"));
        }
        Ok(Dynamic::from(Camera { eye, target, up, fov }))
    });
}
