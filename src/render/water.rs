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
    /// Mean share of light from all around that gets in.
    mean: f64,
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
        Water::of(material::Water { ior: sea.material.ior, absorption: sea.absorption }, sea.color)
    }

    fn of(law: material::Water, color: DVec3) -> Water {
        Water { law, color, mean: 1.0 - material::dielectric_mean(law.ior) }
    }

    /// How its surface reflects lights, per steradian: a sharper image of them would be seen by chance only.
    pub fn value(&self, patch: &Patch, to_eye: DVec3, to_light: DVec3) -> DVec3 {
        self.gloss(patch).value(patch.shading, to_eye, to_light)
    }

    /// Its ripples, too small to be seen.
    fn gloss(&self, patch: &Patch) -> Gloss {
        Gloss::new(patch.finish[Finish::Roughness as usize], Fresnel::Dielectric { ior: self.law.ior })
    }

    /// What light at this cosine to the vertical brings to what is below the surface, relative to light from all around: the
    /// less, the more of it is mirrored. What the surface throws back from below comes back again, so that light from all around
    /// loses nothing, and a white floor under clear water sends out all light that falls on the surface, whatever its
    /// angle. Light from below the horizon has not come through the surface.
    pub fn entering(&self, cos: f64) -> f64 {
        if cos > 0.0 { (1.0 - material::dielectric(cos, self.law.ior)) / self.mean } else { 1.0 }
    }

    /// Radiance that deep water sends back of light that falls on its surface.
    pub fn glow(&self, irradiance: DVec3) -> DVec3 {
        self.color * irradiance / PI
    }

    /// Share of light that is left after a distance, which may be infinite.
    pub fn through(&self, distance: f64) -> DVec3 {
        self.law.transmittance(distance.min(f64::MAX))
    }

    /// The ways on which light comes that leaves the surface towards the eye, above it: by a facet of its ripples, one for each
    /// `u` in the unit square; without that, as if there were none.
    pub fn ways(&self, patch: &Patch, to_eye: DVec3, u: Option<[f64; 2]>) -> [Option<Way>; 2] {
        // Waves that face away from the eye are seen from their backs only by mistake.
        let normal = if patch.shading.dot(to_eye) > 0.0 { patch.shading } else { patch.normal };
        let facet = u.map_or(normal, |u| self.gloss(patch).facet(u, normal, to_eye));
        let Split { reflectance, reflected, refracted } = self.law.split(facet, to_eye);
        // What is mirrored into the water meets the next wave, about as if it came along the surface.
        let rising = reflected.dot(patch.normal);
        let along = reflected + (1e-3 - rising) * patch.normal;
        let up = if rising > 0.0 { reflected } else { along.normalize_or(patch.normal) };
        let down = |direction: DVec3| Way { direction, share: 1.0 - reflectance, is_down: true };
        [Some(Way { direction: up, share: reflectance, is_down: false }), refracted.map(down)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_white_floor_under_clear_water_sends_out_all_light() {
        for ior in [1.0, 1.333, 1.6] {
            let law = material::Water { ior, absorption: DVec3::ZERO };
            let water = Water::of(law, DVec3::ZERO);
            let n = 10_000;
            let all = |f: &dyn Fn(f64) -> f64| {
                (0..n).map(|i| (f64::from(i) + 0.5) / f64::from(n)).map(|cos| 2.0 * cos * f(cos)).sum::<f64>()
                    / f64::from(n)
            };
            let out = all(&|cos| 1.0 - material::dielectric(cos, ior));
            assert!(
                (all(&|cos| water.entering(cos)) - 1.0).abs() < 1e-3,
                "light from all around loses nothing"
            );
            for cos in [0.05, 0.1, 0.3, 1.0] {
                let mirrored = material::dielectric(cos, ior);
                assert!((mirrored + water.entering(cos) * out - 1.0).abs() < 1e-3, "{ior}, {cos}");
            }
        }
    }

    #[test]
    fn a_floor_under_water_is_the_same_with_directions_exchanged() {
        let water = Water::of(material::Water { ior: 1.333, absorption: DVec3::ZERO }, DVec3::ZERO);
        let patch = Patch { normal: DVec3::Y, shading: DVec3::Y, ..Patch::PLAIN };
        let towards = |cos: f64| DVec3::new((1.0 - cos * cos).sqrt(), cos, 0.0);
        let seen = |eye: f64, light: f64| {
            let ways = water.ways(&patch, towards(eye), None);
            let down = ways.into_iter().flatten().find(|way| way.is_down).unwrap();
            down.share * water.entering(light)
        };
        for (a, b) in [(1.0, 0.1), (0.3, 0.05), (0.7, 0.2)] {
            assert!((seen(a, b) / seen(b, a) - 1.0).abs() < 1e-12, "{a} {b}");
        }
    }
}
