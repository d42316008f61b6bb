//! The camera: from places in the picture to rays.

use super::{CameraError, Settings};
use crate::cast::{Ray, Tolerance};
use crate::scene::{Aabb, Camera};
use glam::DVec3;

/// A camera made ready for a picture of some size. Pixel (0, 0) is at the top left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Position.
    pub eye: DVec3,
    /// Unit vector in the direction of view.
    pub forward: DVec3,
    /// Unit vector to the right in the picture.
    pub right: DVec3,
    /// Unit vector up in the picture.
    pub up: DVec3,
    /// Half width and half height of the picture, one unit in front of the eye.
    half: [f64; 2],
    size: [f64; 2],
}

impl View {
    /// The view of a camera. Where its `up` is zero or along the line of sight, so that it does not
    /// say which way is up, the y axis stands in for it, and the z axis where that fails too: the
    /// picture is then turned about its middle, which is better than none.
    ///
    /// # Errors
    /// [`CameraError`] for an eye at its target, numbers that are not finite, and angles of view
    /// that are none.
    pub fn new(camera: &Camera, width: u32, height: u32) -> Result<View, CameraError> {
        let Camera { eye, target, up, fov } = *camera;
        if !(eye.is_finite() && target.is_finite() && up.is_finite()) {
            return Err(CameraError::NotFinite);
        }
        if !(fov > 0.0 && fov < 180.0) {
            return Err(CameraError::Fov(fov));
        }
        let forward = (target - eye).try_normalize().ok_or(CameraError::EyeIsTarget)?;
        let right = [up, DVec3::Y, DVec3::Z]
            .into_iter()
            .filter_map(DVec3::try_normalize)
            .map(|up| forward.cross(up))
            .find(|right| right.length() > 1e-6)
            .unwrap_or(DVec3::X)
            .normalize();
        let half_height = libm::tan(0.5 * fov.to_radians());
        let size = [f64::from(width), f64::from(height)];
        let half = [half_height * size[0] / size[1], half_height];
        Ok(View { eye, forward, right, up: right.cross(forward), half, size })
    }

    /// Unit vector from the eye through a place in the picture, given in pixels.
    pub fn direction(&self, x: f64, y: f64) -> DVec3 {
        let across = (2.0 * x / self.size[0] - 1.0) * self.half[0];
        let upwards = (1.0 - 2.0 * y / self.size[1]) * self.half[1];
        (self.forward + across * self.right + upwards * self.up).normalize()
    }

    /// The place in the picture, in pixels, where a point appears; `None` behind the camera.
    pub fn project(&self, p: DVec3) -> Option<[f64; 2]> {
        let d = p - self.eye;
        let depth = d.dot(self.forward);
        (depth > 0.0).then(|| {
            let across = d.dot(self.right) / (depth * self.half[0]);
            let upwards = d.dot(self.up) / (depth * self.half[1]);
            [0.5 * (1.0 + across) * self.size[0], 0.5 * (1.0 - upwards) * self.size[1]]
        })
    }

    /// Side of a pixel seen from one unit away.
    pub fn pixel(&self) -> f64 {
        2.0 * self.half[1] / self.size[1]
    }

    /// The piece of a line of sight that lies within `bounds`, and not nearer than the
    /// tolerance.
    pub fn ray(&self, direction: DVec3, bounds: &Aabb, tolerance: Tolerance) -> Option<Ray> {
        let (enter, far) = bounds.clip(self.eye, direction)?;
        let near = enter.max(tolerance.least);
        (near < far).then_some(Ray { origin: self.eye, direction, near, far, tolerance })
    }
}

/// Tolerance that suits a view: a five-hundredth of a pixel, wherever the ray is, down to what double
/// precision can give.
pub(super) fn tolerance(view: &View, settings: &Settings) -> Tolerance {
    let bounds = &settings.bounds;
    let reach = bounds.min.abs().max(bounds.max.abs()).max_element().max(view.eye.abs().max_element());
    Tolerance { least: 1e-13 * reach, growth: 0.002 * view.pixel() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn front(fov: f64) -> Camera {
        Camera { eye: DVec3::new(0.0, 0.0, 5.0), target: DVec3::ZERO, up: DVec3::Y, fov }
    }

    #[test]
    fn axes_are_where_people_expect_them() {
        let view = View::new(&front(90.0), 200, 100).unwrap();
        assert_eq!(view.right, DVec3::X);
        assert_eq!(view.up, DVec3::Y);
        assert!((view.direction(100.0, 50.0) - DVec3::NEG_Z).length() < 1e-15);
        let corner = view.direction(0.0, 0.0);
        assert!(corner.x < 0.0 && corner.y > 0.0);
        // 90 degrees from the top edge to the bottom edge; square pixels.
        let (top, bottom) = (view.direction(100.0, 0.0), view.direction(100.0, 100.0));
        assert!(top.dot(bottom).abs() < 1e-15);
        let left = view.direction(0.0, 50.0);
        assert!((left.x / left.z - 2.0).abs() < 1e-12);
        assert!((view.pixel() - 0.02).abs() < 1e-15);
    }

    #[test]
    fn projection_inverts_directions() {
        let view = View::new(&Camera::default(), 320, 240).unwrap();
        for (x, y) in [(0.0, 0.0), (17.3, 200.9), (320.0, 1.0)] {
            let [u, v] = view.project(view.eye + 3.0 * view.direction(x, y)).unwrap();
            assert!((u - x).abs() < 1e-9 && (v - y).abs() < 1e-9);
        }
        assert_eq!(view.project(view.eye - view.forward), None);
    }

    #[test]
    fn degenerate_cameras() {
        let at_target = Camera { target: front(35.0).eye, ..front(35.0) };
        assert_eq!(View::new(&at_target, 8, 8), Err(CameraError::EyeIsTarget));
        assert_eq!(View::new(&front(180.0), 8, 8), Err(CameraError::Fov(180.0)));
        assert!(View::new(&front(f64::NAN), 8, 8).is_err());
        for up in [DVec3::Z, DVec3::ZERO, DVec3::NEG_Z * 1e-300] {
            let view = View::new(&Camera { up, ..front(35.0) }, 8, 8).unwrap();
            assert_eq!((view.right, view.up), (DVec3::X, DVec3::Y));
        }
        let down = Camera { eye: DVec3::Y, target: DVec3::ZERO, up: DVec3::Y, fov: 35.0 };
        let view = View::new(&down, 8, 8).unwrap();
        assert!((view.up.length() - 1.0).abs() < 1e-15 && view.up.dot(view.forward) == 0.0);
    }

    #[test]
    fn rays_stay_in_the_bounds() {
        let view = View::new(&front(35.0), 8, 8).unwrap();
        let ray = view.ray(DVec3::NEG_Z, &Aabb::cube(1.0), Tolerance::fixed(1e-6)).unwrap();
        assert_eq!((ray.near, ray.far), (4.0, 6.0));
        assert_eq!(view.ray(DVec3::Z, &Aabb::cube(1.0), Tolerance::fixed(1e-6)), None);
        let inside = view.ray(DVec3::NEG_Z, &Aabb::cube(10.0), Tolerance::fixed(1e-6)).unwrap();
        assert_eq!((inside.near, inside.far), (1e-6, 15.0));
    }
}
