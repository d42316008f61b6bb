//! Cameras as the calls that make them.

use crate::scene::{Camera, Projection};
use glam::DVec3;

/// The call that makes a camera, rounded to what matters: directions to a ten-thousandth, and where the eye is to a
/// billionth, since it may stand on the ground of a planet.
pub fn camera(camera: &Camera) -> String {
    let Camera { eye, target, up, projection } = camera;
    let unit = 1e-4 * eye.distance(*target);
    let point = |p: &DVec3, unit: f64| {
        let [x, y, z] = p.to_array().map(|c| rounded(c, unit));
        format!("[{x}, {y}, {z}]")
    };
    let exact = unit.min(1e-9 * eye.abs().max_element());
    let mut options = format!("eye: {}, target: {}", point(eye, exact), point(target, unit));
    if *up != DVec3::Y {
        let [x, y, z] = up.to_array().map(|c| rounded(c, 1e-6));
        options += &format!(", up: [{x}, {y}, {z}]");
    }
    let call = match projection {
        Projection::Panorama => "panorama",
        Projection::CubeMap => "cube_map",
        Projection::Orthographic { height } => {
            let height = rounded(*height, 1e-4 * height);
            options += &format!(", projection: \"orthographic\", height: {height}");
            "look_at"
        }
        Projection::Perspective { fov, lens } => {
            options += &format!(", fov: {}", rounded(*fov, 1e-3));
            if let Some(lens) = lens {
                let [aperture, focus] = [lens.radius, lens.focus].map(|c| rounded(c, 1e-4 * c));
                options += &format!(", aperture: {aperture}, focus: {focus}");
            }
            "look_at"
        }
    };
    format!("{call}(#{{ {options} }})")
}

/// A number with as many digits as tell parts of a unit apart.
fn rounded(value: f64, unit: f64) -> String {
    let digits = (-libm::log10(unit.abs())).ceil().clamp(0.0, 17.0) as usize;
    let text = format!("{value:.*}", digits.max(1));
    let short = text.trim_end_matches('0');
    // -0.0 is no number to read.
    let short = if short == "-0." { "0." } else { short };
    if short.ends_with('.') { format!("{short}0") } else { short.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_are_written_as_they_are_read() {
        use crate::script::{Request, compile};
        let lens = Some(crate::scene::Lens { radius: 0.01, focus: 2.5 });
        let askew = Camera { up: DVec3::new(0.1, 0.8, 0.1).normalize(), ..Camera::default() };
        for projection in [
            Projection::default(),
            Projection::Perspective { fov: 62.5, lens },
            Projection::Orthographic { height: 0.0123 },
            Projection::Panorama,
            Projection::CubeMap,
        ] {
            let text = camera(&askew.with(projection));
            let compiled = compile(&Request::text(format!("scene(#{{ surface: x, camera: {text} }})")));
            let read = compiled.scene.unwrap_or_else(|| panic!("{text}: {:?}", compiled.diagnostics)).camera;
            assert!(read.eye.distance(askew.eye) < 1e-8 && read.up.distance(askew.up) < 1e-5, "{text}");
            assert_eq!(read.projection, projection, "{text}");
        }
        let on_ground = DVec3::new(0.163_175_913, 0.342_020_143, 0.925_416_578) * (1.0 + 1e-6);
        let text = camera(&Camera::look_at(on_ground, DVec3::new(0.07, 1.2, 0.43)));
        let compiled = compile(&Request::text(format!("scene(#{{ surface: x, camera: {text} }})")));
        let read = compiled.scene.expect("a camera").camera;
        assert!((read.eye.length() - on_ground.length()).abs() < 2e-9, "{text}");
        assert_eq!(
            camera(&Camera::look_at(DVec3::new(0.0, 0.25, 4.0), DVec3::ZERO)),
            "look_at(#{ eye: [0.0, 0.25, 4.0], target: [0.0, 0.0, 0.0], fov: 35.0 })"
        );
    }
}
