//! How much of the light that comes from one direction leaves a patch in another.

use super::light::Surroundings;
use super::surface::Patch;
use crate::scene::Material;
use glam::DVec3;
use std::f64::consts::PI;

/// How a patch reflects.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reflector {
    normal: DVec3,
    albedo: DVec3,
}

impl Reflector {
    /// That of a patch of a material.
    pub fn new(patch: &Patch, _material: Option<&Material>) -> Reflector {
        Reflector { normal: patch.shading, albedo: patch.albedo }
    }

    /// The reflectance function, per steradian.
    pub fn value(&self, _to_eye: DVec3, _to_light: DVec3) -> DVec3 {
        self.albedo / PI
    }

    /// A direction to look for light in, and the share of it that is reflected; with numbers in [0, 1).
    pub fn sample(&self, _choice: f64, u: [f64; 2], _to_eye: DVec3) -> Option<(DVec3, DVec3)> {
        let (radius, turn) = (u[0].sqrt(), 2.0 * PI * u[1]);
        let (a, b) = self.normal.any_orthonormal_pair();
        let direction =
            radius * (libm::cos(turn) * a + libm::sin(turn) * b) + (1.0 - u[0]).sqrt() * self.normal;
        Some((direction.normalize(), self.albedo))
    }

    /// Light of the sky that is reflected, as if nothing stood in its way.
    pub fn ambient(&self, _to_eye: DVec3, around: &Surroundings<'_>, patch: &Patch) -> DVec3 {
        self.albedo * around.ambient(patch)
    }
}
