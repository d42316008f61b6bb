//! A clear film on something matt: wet rock, varnish, glazed snow.
//!
//! The film mirrors the share `E(v)` of what arrives from `v`, as [`Gloss`] of its roughness does. The
//! rest gets in, meets the matt ground of the albedo `rho`, and most of it the film from below, which
//! throws back the share `K`: that repeats, and is the reason why wet stones are dark. The sum of the
//! series is what leaves, spread by the film as what came in was ([`Balanced`]):
//!
//! ```text
//! rho_wet = rho (1 - K) / (1 - rho K)
//! ```
//!
//! For a white ground it is 1, so that no light is lost or won. (The series is Saunderson's, 1942.) For a
//! smooth film `1 - K` is `(1 - <F>) / n^2`: light within is spread over a cone that is wider than the one
//! that gets out.

use super::mirrored::Mirrored;
use super::{Balanced, Fresnel, Gloss, dielectric_mean};
use glam::DVec3;

/// Clear films of one index of refraction: what they mirror, for all roughnesses.
#[derive(Clone, Debug)]
pub struct Film {
    fresnel: Fresnel,
    mirrored: Mirrored,
    /// `K`.
    inside: f64,
}

impl Film {
    /// Films of an index of refraction, at least 1; 1.333 for water.
    pub fn new(ior: f64) -> Film {
        let ior = ior.max(1.0);
        let fresnel = Fresnel::Dielectric { ior };
        let outside = dielectric_mean(ior);
        Film { fresnel, mirrored: Mirrored::new(fresnel), inside: 1.0 - (1.0 - outside) / (ior * ior) }
    }

    /// A film of a roughness from 0 to 1 on a matt ground, of which the albedo is that in the dry.
    pub fn on(&self, albedo: DVec3, roughness: f64) -> Balanced<'_> {
        let wet = albedo * (1.0 - self.inside) / (1.0 - albedo * self.inside);
        Balanced {
            gloss: Gloss::new(roughness, self.fresnel),
            mirrored: self.mirrored.of(roughness),
            rest: wet,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{albedo, film, tilted};
    use super::super::{Reflectance, dielectric};
    use super::*;
    use std::f64::consts::FRAC_1_PI;

    #[test]
    fn a_film_on_white_loses_no_light() {
        let film = film(1.5);
        for roughness in [0.35, 0.5, 0.73, 1.0] {
            let coat = film.on(DVec3::ONE, roughness);
            for mu in [0.05, 0.1, 0.37, 0.7, 1.0] {
                let all = albedo(&coat, DVec3::Z, tilted(mu)).x;
                assert!((all - 1.0).abs() < 3e-3, "{roughness} {mu}: {all}");
            }
        }
    }

    #[test]
    fn light_inside_is_thrown_back_as_fresnel_says() {
        for ior in [1.0, 1.333, 1.5] {
            let steps = 100_000;
            let inside: f64 = (0..steps)
                .map(|i| (f64::from(i) + 0.5) / f64::from(steps))
                .map(|cos| 2.0 * cos * dielectric(cos, 1.0 / ior) / f64::from(steps))
                .sum();
            assert!((film(ior).inside - inside).abs() < 1e-4, "{ior}: {inside}");
        }
    }

    #[test]
    fn wet_ground_is_darker() {
        let dry = DVec3::new(0.1, 0.3, 0.6);
        let wet = albedo(&film(1.333).on(dry, 0.4), DVec3::Z, DVec3::Z);
        assert!(wet.x > 0.05 && wet.x < 0.09 && wet.y < 0.22 && wet.z < 0.5, "{wet}");
        // A film of nothing leaves the ground as it is.
        let none = film(1.0);
        let value = none.on(dry, 0.4).value(DVec3::Z, tilted(0.3), tilted(0.8));
        assert!((value - dry * FRAC_1_PI).length() < 1e-12, "{value}");
    }
}
