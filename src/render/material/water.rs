//! Clear water with a smooth surface: what it mirrors, what it shows, and what it swallows.
//!
//! The surface mirrors the share `F` of light (Fresnel) and lets in the rest, bent towards the normal
//! (Snell). Within the water light fades by `e^(-a d)` over the distance `d` (Beer and Lambert), red
//! first. Radiance counts `n^2` times as much in the water as above it, since its cone is narrower; light
//! from below the surface that is seen from above goes the way back, so that only `1 - F` remains.

use super::{dielectric, refract};
use glam::DVec3;

/// Absorption of pure water in 1/m at 680, 550 and 440 nm (Pope and Fry 1997, *Absorption spectrum of
/// pure water*).
const PURE: DVec3 = DVec3::new(0.465, 0.0565, 0.006_35);

/// Clear water.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Water {
    /// Index of refraction: 1.333 for fresh water, 1.34 for the sea.
    pub ior: f64,
    /// Absorption, in 1/unit of the scene by channel.
    pub absorption: DVec3,
}

/// What becomes of a line of sight at the surface of water.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Split {
    /// Share of light that is mirrored; the rest comes from below.
    pub reflectance: f64,
    /// Where mirrored light comes from, away from the surface.
    pub reflected: DVec3,
    /// Where the line of sight goes on below; `None` if all light is mirrored, as it may be for an
    /// `ior` below 1, seen from the water.
    pub refracted: Option<DVec3>,
}

impl Water {
    /// Pure water, in a scene of which a unit is so many metres.
    pub fn pure(metres: f64) -> Water {
        Water { ior: 1.333, absorption: PURE * metres }
    }

    /// What the eye sees at the surface, from the side of the normal.
    pub fn split(&self, normal: DVec3, to_eye: DVec3) -> Split {
        let cos = normal.dot(to_eye);
        Split {
            reflectance: dielectric(cos, self.ior),
            reflected: (2.0 * cos * normal - to_eye).normalize(),
            refracted: refract(normal, to_eye, self.ior),
        }
    }

    /// Share of light that is left after a way through the water, in units of the scene.
    pub fn transmittance(&self, distance: f64) -> DVec3 {
        DVec3::from_array(self.absorption.to_array().map(|a| libm::exp(-a * distance.max(0.0))))
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::tilted;
    use super::*;

    #[test]
    fn a_line_of_sight_is_split_in_one_plane() {
        let water = Water::pure(1.0);
        for mu in [0.01, 0.3, 0.9, 1.0] {
            let eye = tilted(mu);
            let Split { reflectance, reflected, refracted } = water.split(DVec3::Z, eye);
            let refracted = refracted.unwrap();
            assert!((reflected.z - eye.z).abs() < 1e-14 && (reflected + eye).truncate().length() < 1e-14);
            assert!(refracted.z < -0.66, "no line is flatter in water than the critical angle");
            assert!(eye.cross(DVec3::Z).dot(refracted).abs() < 1e-14);
            assert!((0.02..=1.0).contains(&reflectance));
        }
        assert!((water.split(DVec3::Z, DVec3::Z).reflectance - 0.0204).abs() < 1e-4);
        let seen_from_below = Water { ior: 1.0 / 1.333, ..water }.split(DVec3::Z, tilted(0.5));
        assert_eq!((seen_from_below.reflectance, seen_from_below.refracted), (1.0, None));
    }

    #[test]
    fn depths_multiply_and_red_goes_first() {
        let water = Water::pure(2.0);
        let [near, far, both] = [1.5, 4.0, 5.5].map(|d| water.transmittance(d));
        assert!((near * far - both).length() < 1e-15);
        assert!(both.x < both.y && both.y < both.z && both.z < 1.0);
        assert!((near.y - libm::exp(-3.0 * 0.0565)).abs() < 1e-15);
        assert_eq!([water.transmittance(0.0), water.transmittance(-1.0)], [DVec3::ONE; 2]);
    }
}
