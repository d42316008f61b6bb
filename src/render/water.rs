//! Seas: water with waves, for paths of light.
//!
//! What its surface does is in [`material::Water`]. What deep water sends back from all around is like light of a matt
//! surface; of what is seen through a distance `s` of water, it makes up what has been taken away.

use super::material::{self, Fresnel, Gloss, Reflectance, Split};
use super::surface::Patch;
use crate::scene::{Finish, Sea};
use glam::DVec3;
use std::f64::consts::PI;

/// The water of a sea.
#[derive(Clone, Copy, Debug)]
pub(super) struct Water {
    law: material::Water,
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
        let law = material::Water { ior: sea.material.ior, absorption: sea.absorption };
        Water { law, color: sea.color }
    }

    /// How its surface reflects lights, per steradian: a sharper image of them would be seen by chance only.
    pub fn value(&self, patch: &Patch, to_eye: DVec3, to_light: DVec3) -> DVec3 {
        let fresnel = Fresnel::Dielectric { ior: self.law.ior };
        Gloss::new(patch.finish[Finish::Roughness as usize], fresnel).value(patch.shading, to_eye, to_light)
    }

    /// Radiance that deep water sends back of light that falls on its surface.
    pub fn glow(&self, irradiance: DVec3) -> DVec3 {
        self.color * irradiance / PI
    }

    /// Share of light that is left after a distance, which may be infinite.
    pub fn through(&self, distance: f64) -> DVec3 {
        self.law.transmittance(distance.min(f64::MAX))
    }

    /// The ways on which light comes that leaves the surface towards the eye, above it.
    pub fn ways(&self, patch: &Patch, to_eye: DVec3) -> [Option<Way>; 2] {
        // Waves that face away from the eye are seen from their backs only by mistake.
        let normal = if patch.shading.dot(to_eye) > 0.0 { patch.shading } else { patch.normal };
        let Split { reflectance, reflected, refracted } = self.law.split(normal, to_eye);
        // What is mirrored into the water meets the next wave, about as if it came along the surface.
        let rising = reflected.dot(patch.normal);
        let along = reflected + (1e-3 - rising) * patch.normal;
        let up = if rising > 0.0 { reflected } else { along.normalize_or(patch.normal) };
        let down = |direction: DVec3| Way { direction, share: 1.0 - reflectance, is_down: true };
        [Some(Way { direction: up, share: reflectance, is_down: false }), refracted.map(down)]
    }
}
