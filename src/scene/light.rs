//! Lights: suns, whose rays are parallel, and lamps, which are near.

use super::direction;
use glam::DVec3;

/// A source of light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Far away.
    Sun(Sun),
    /// Near.
    Lamp(Lamp),
}

/// A light so far away that its rays are parallel, but for the width of its disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Unit vector from the scene towards the middle of the sun.
    pub direction: DVec3,
    /// Irradiance on a surface that faces the sun, per channel; pi makes white come out as 1.
    pub irradiance: DVec3,
    /// Angle in degrees that the disc measures across; that of the Earth's sun is 0.53. Shadows of a point, 0, are hard.
    pub size: f64,
    /// Whether the solid throws shadows.
    pub shadows: bool,
}

impl Default for Sun {
    fn default() -> Self {
        Sun { direction: direction(60.0, 45.0), irradiance: DVec3::splat(2.6), size: 0.0, shadows: true }
    }
}

/// A ball that shines equally in all directions; it is not seen itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lamp {
    /// Its middle.
    pub position: DVec3,
    /// Radius; shadows of a point, 0, are hard.
    pub radius: f64,
    /// Irradiance at distance 1 on a surface that faces it, per channel; it falls with the square of the distance.
    pub intensity: DVec3,
    /// Whether the solid throws shadows.
    pub shadows: bool,
}
