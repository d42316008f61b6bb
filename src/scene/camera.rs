//! Cameras: where a picture is taken from, and how directions become places in it.
//!
//! | projection | a place in the picture is | rays start at |
//! |---|---|---|
//! | perspective | a direction, by its tangents | the eye, or anywhere on the lens |
//! | orthographic | a place in the plane across the view | that place |
//! | panorama | a longitude and a latitude | the eye |
//! | cube map | a face and a place on it | the eye |

use super::{Aabb, direction};
use glam::DVec3;

/// Where a picture is taken from, and what of the world it shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position.
    pub eye: DVec3,
    /// The point in the middle of the picture; panoramas and cube maps stay upright and are only turned
    /// towards it.
    pub target: DVec3,
    /// Direction that points up in the picture; need not be perpendicular to the view.
    pub up: DVec3,
    /// How directions become places in the picture.
    pub projection: Projection,
}

/// How directions become places in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// As the eye and most cameras see.
    Perspective {
        /// Vertical field of view in degrees, between 0 and 180.
        fov: f64,
        /// The lens; a pinhole, to which everything is sharp, where `None`.
        lens: Option<Lens>,
    },
    /// Along parallel lines, so that things look equally large however far they are. What lies behind
    /// the plane through the eye is not seen.
    Orthographic {
        /// Height of what the picture shows, in units of length.
        height: f64,
    },
    /// All around, equirectangular: columns are longitudes, 360 degrees of them with the direction of view in
    /// the middle, and rows are latitudes, from straight up to straight down. Square pixels take a
    /// picture twice as wide as high.
    Panorama,
    /// All around, as the six [faces](super::FACES) of a cube: in the order of OpenGL, three in the upper and three
    /// in the lower row. Square pixels take a picture of 3 : 2.
    CubeMap,
}

/// A thin lens: what lies in the plane of focus is sharp, and a point elsewhere is a disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Radius in units of length: so it suits a scene of any scale, as an f-number would not. A lens of
    /// focal length `f` and f-number `N` has the radius `f / (2 N)`.
    pub radius: f64,
    /// Distance of the plane of focus from the eye, along the direction of view.
    pub focus: f64,
}

impl Default for Camera {
    fn default() -> Self {
        Camera::orbit(DVec3::ZERO, 4.0, 30.0, 20.0)
    }
}

impl Default for Projection {
    /// A pinhole with the usual field of view.
    fn default() -> Self {
        Projection::Perspective { fov: Camera::FOV, lens: None }
    }
}

impl Camera {
    /// The usual camera, moved so that a box fills the picture.
    pub fn framing(region: &Aabb) -> Camera {
        let usual = Camera::default();
        let radius = 0.5 * region.diagonal();
        let distance = 0.92 * radius / libm::sin(0.5 * Camera::FOV.to_radians());
        let target = 0.5 * (region.min + region.max);
        Camera { eye: target + distance * (usual.eye - usual.target).normalize(), target, ..usual }
    }

    /// The usual vertical field of view in degrees.
    pub const FOV: f64 = 35.0;

    /// A camera at a point that looks at another, with the y axis upwards.
    pub fn look_at(eye: DVec3, target: DVec3) -> Self {
        Camera { eye, target, up: DVec3::Y, projection: Projection::default() }
    }

    /// A camera on a sphere of radius `distance` around `target`. Azimuth 0 looks along -z; it grows
    /// eastwards (towards +x); elevation grows upwards. Angles in degrees.
    pub fn orbit(target: DVec3, distance: f64, azimuth: f64, elevation: f64) -> Self {
        let eye = target + distance * direction(azimuth, elevation);
        // Straight above or below the target "up" would be the line of sight.
        let up =
            if elevation.abs() > 89.9 { direction(azimuth, 0.0) * -elevation.signum() } else { DVec3::Y };
        Camera { up, ..Camera::look_at(eye, target) }
    }

    /// The same camera with another projection.
    pub fn with(self, projection: Projection) -> Self {
        Camera { projection, ..self }
    }

    /// The same camera, a pinhole with a vertical field of view in degrees.
    pub fn with_fov(self, fov: f64) -> Self {
        self.with(Projection::Perspective { fov, lens: None })
    }

    /// How far from the origin the camera and what it is meant to show reach.
    pub fn reach(&self) -> f64 {
        let height = match self.projection {
            Projection::Orthographic { height } => height,
            _ => 0.0,
        };
        self.eye.length().max(self.target.length()) + self.eye.distance(self.target).max(height)
    }
}
