//! Water: what its surface does to light, and its depth.
//!
//! A smooth surface reflects the share of light that Fresnel's equations say, and lets the rest down, bent as Snell says.
//! On its way light is taken away, `exp(-a s)` of it being left after a distance `s` (Beer and Lambert). What deep water
//! sends back from all around is like light of a matt surface; of what is seen through a distance `s`, it makes up what
//! is missing.

use super::surface::Patch;
use crate::scene::{Material, Sea};
use glam::DVec3;
use std::f64::consts::PI;

/// The water of a sea.
#[derive(Clone, Copy, Debug)]
pub(super) struct Water {
    /// How its surface reflects lights.
    pub material: Material,
    absorption: DVec3,
    color: DVec3,
}

/// A way on which light comes to a point of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Way {
    /// Towards where it comes from.
    pub direction: DVec3,
    /// Share of it that takes part.
    pub share: f64,
    /// Whether it comes from below.
    pub is_down: bool,
}

impl Water {
    /// That of a sea.
    pub fn new(sea: &Sea) -> Water {
        Water { material: sea.material, absorption: sea.absorption, color: sea.color }
    }

    /// Radiance that deep water sends back of light that falls on its surface.
    pub fn glow(&self, irradiance: DVec3) -> DVec3 {
        self.color * irradiance / PI
    }

    /// Share of light that is left after a distance, which may be infinite.
    pub fn through(&self, distance: f64) -> DVec3 {
        DVec3::from_array(
            self.absorption.to_array().map(|a| if a > 0.0 { libm::exp(-a * distance) } else { 1.0 }),
        )
    }

    /// The ways on which light comes that leaves the surface against a direction, which comes from above.
    pub fn ways(&self, patch: &Patch, direction: DVec3) -> [Way; 2] {
        // Waves that face away from the eye are seen from their backs only by mistake.
        let normal = if patch.shading.dot(direction) < 0.0 { patch.shading } else { patch.normal };
        let cosine = -normal.dot(direction);
        let mirrored = direction + 2.0 * cosine * normal;
        // What is mirrored into the water meets the next wave, about as if it came along the surface.
        let rising = mirrored.dot(patch.normal);
        let mirrored = if rising > 0.0 { mirrored } else { mirrored - 1.01 * rising * patch.normal };
        let eta = 1.0 / self.material.ior;
        let below = (1.0 - eta * eta * (1.0 - cosine * cosine)).max(0.0).sqrt();
        let bent = eta * direction + (eta * cosine - below) * normal;
        let reflected = fresnel(cosine, below, self.material.ior);
        [
            Way { direction: mirrored.normalize_or(patch.normal), share: reflected, is_down: false },
            Way { direction: bent.normalize_or(-patch.normal), share: 1.0 - reflected, is_down: true },
        ]
    }
}

/// Fresnel's reflectance of unpolarised light from the cosines above and below.
fn fresnel(above: f64, below: f64, ior: f64) -> f64 {
    let parallel = (ior * above - below) / (ior * above + below);
    let perpendicular = (above - ior * below) / (above + ior * below);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}
