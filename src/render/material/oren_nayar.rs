//! Rough matt surfaces: the model of Oren and Nayar in a form that loses no light.
//!
//! A rough surface of matt facets throws light back towards where it came from, and looks flatter than
//! Lambert's law has it: the full moon is the famous example. Oren and Nayar's own formula loses light
//! with roughness, since it leaves out most of what facets throw at one another; nor is it the same all
//! round. This is its energy-preserving form, EON (Portsmouth, Kutz and Hill 2024, *EON: a practical
//! energy-preserving rough diffuse BRDF*), with its exact directional albedo:
//!
//! ```text
//! f       = rho/pi A (1 + r s/t)  +  rho_ms/pi (1 - E(v)) (1 - E(l)) / (1 - <E>)
//! s       = v . l - cos_v cos_l          t = max(cos_v, cos_l) if s > 0, else 1          (Fujii 2012)
//! A       = 1 / (1 + (1/2 - 2/(3 pi)) r)
//! E(mu)   = A (1 + r G(mu)/pi)           the directional albedo of the first term for rho = 1
//! G(mu)   = sin (acos mu - mu sin) + 2/3 (sin/mu (1 - sin^3) - sin)           sin = sqrt(1 - mu^2)
//! <E>     = A (1 + (2/3 - 28/(15 pi)) r)                               its mean, 2 int E mu dmu
//! rho_ms  = rho^2 <E> / (1 - rho (1 - <E>))
//! ```
//!
//! The second term is what is left, spread in proportion to what is missing in either direction, so that
//! a surface of white facets reflects all light, from everywhere. `rho_ms` sums a geometric series: light
//! that has met `n` facets is `rho^n` strong. Tests compare `E` and `<E>` with quadratures.

use super::{Bounce, Frame, Reflectance, bounce, choose, cosine_hemisphere, cosines, uniform_hemisphere};
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI};

/// A rough matt surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrenNayar {
    /// Share of light that a facet reflects, from 0 to 1 by channel. A rough surface reflects less, as
    /// facets light one another: for 0.5 and the roughness 1 some 0.45.
    pub albedo: DVec3,
    /// From 0, which is Lambert's law, to 1, the roughest.
    pub roughness: f64,
}

impl OrenNayar {
    fn flat_share(&self) -> f64 {
        1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * self.roughness)
    }

    /// The directional albedo of the first term for white facets.
    fn first(&self, mu: f64) -> f64 {
        self.flat_share() * (1.0 + self.roughness * gain(mu) * FRAC_1_PI)
    }

    /// The mean of [`OrenNayar::first`] over the hemisphere, weighted with the cosine.
    fn mean_first(&self) -> f64 {
        self.flat_share() * (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * PI)) * self.roughness)
    }

    /// What facets reflect that others have lit, of light that the first term leaves out.
    fn again(&self) -> DVec3 {
        let mean = self.mean_first();
        self.albedo * self.albedo * mean / (1.0 - self.albedo * (1.0 - mean))
    }

    /// The share of light from all around that leaves towards an eye at a cosine: the directional albedo.
    pub fn from_all_around(&self, mu: f64) -> DVec3 {
        let first = self.first(mu);
        self.albedo * first + self.again() * (1.0 - first)
    }

    /// Probability of a sample that is uniform over the hemisphere: the share of the first term's light
    /// that its rough part gives, which at grazing angles is spread like that. It keeps weights bounded.
    fn uniform_share(&self, mu: f64) -> f64 {
        let rough = self.roughness * gain(mu) * FRAC_1_PI;
        rough / (1.0 + rough)
    }
}

/// `G`: the integral of `s/t cos` over the hemisphere, as the eye's cosine has it. It rises from 0 for a
/// view along the normal to `pi/2 - 2/3`.
fn gain(mu: f64) -> f64 {
    let sin = ((1.0 - mu) * (1.0 + mu)).max(0.0).sqrt();
    // (1 - sin^3) / mu, with 1 - sin = mu^2 / (1 + sin) so that a level view does not divide by zero.
    let rest = mu * (1.0 + sin + sin * sin) / (1.0 + sin);
    sin * (libm::acos(mu) - sin * mu) + 2.0 / 3.0 * sin * (rest - 1.0)
}

impl Reflectance for OrenNayar {
    fn value(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> DVec3 {
        let Some([eye, light]) = cosines(normal, to_eye, to_light) else { return DVec3::ZERO };
        let s = to_eye.dot(to_light) - eye * light;
        let s_over_t = if s > 0.0 { s / eye.max(light) } else { s };
        let first = self.albedo * (self.flat_share() * (1.0 + self.roughness * s_over_t));
        let mean = self.mean_first();
        // What is missing is proportional to the roughness, to rounding.
        let missing = [eye, light].map(|mu| (1.0 - self.first(mu)).max(0.0));
        let spread = missing[0] * missing[1] / (1.0 - mean).max(f64::EPSILON);
        (first + self.again() * spread) * FRAC_1_PI
    }

    fn sample(&self, u: [f64; 2], normal: DVec3, to_eye: DVec3) -> Option<Bounce> {
        let (level, u) = choose(u, self.uniform_share(normal.dot(to_eye).clamp(0.0, 1.0)));
        let local = if level { uniform_hemisphere(u) } else { cosine_hemisphere(u) };
        bounce(self, normal, to_eye, Frame::around(normal).to_world(local))
    }

    fn pdf(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> f64 {
        let Some([eye, light]) = cosines(normal, to_eye, to_light) else { return 0.0 };
        let level = self.uniform_share(eye);
        (level * 0.5 + (1.0 - level) * light) * FRAC_1_PI
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{albedo, tilted};
    use super::*;

    #[test]
    fn light_from_all_around_leaves_as_the_law_says() {
        for roughness in [0.0, 0.3, 1.0] {
            let rock = OrenNayar { albedo: DVec3::new(0.9, 0.5, 0.1), roughness };
            for mu in [0.1, 0.5, 1.0] {
                let [known, seen] = [rock.from_all_around(mu), albedo(&rock, DVec3::Z, tilted(mu))];
                assert!((known - seen).abs().max_element() < 2e-3, "{roughness} {mu}: {known} {seen}");
            }
        }
    }

    #[test]
    fn albedos_are_integrals() {
        for roughness in [0.0, 0.3, 1.0] {
            // Facets so dark that light which meets two of them is lost.
            let dark = OrenNayar { albedo: DVec3::splat(1e-9), roughness };
            let steps = 40;
            let mut mean = 0.0;
            for i in 0..steps {
                let mu = (f64::from(i) + 0.5) / f64::from(steps);
                let first = albedo(&dark, DVec3::Z, tilted(mu)).x * 1e9;
                assert!(
                    (first - dark.first(mu)).abs() < 2e-4,
                    "{roughness} {mu}: {first} {}",
                    dark.first(mu)
                );
                mean += 2.0 * mu * dark.first(mu) / f64::from(steps);
            }
            assert!((mean - dark.mean_first()).abs() < 2e-4, "{roughness}: {mean}");
        }
        assert!(gain(1.0) == 0.0 && (gain(0.0) - (0.5 * PI - 2.0 / 3.0)).abs() < 1e-15);
    }

    #[test]
    fn white_facets_lose_no_light() {
        for roughness in [0.0, 0.2, 0.7, 1.0] {
            let white = OrenNayar { albedo: DVec3::ONE, roughness };
            for mu in [0.02, 0.1, 0.3, 0.6, 0.9, 1.0] {
                let all = albedo(&white, DVec3::Z, tilted(mu));
                assert!((all - DVec3::ONE).length() < 1e-3, "{roughness} {mu}: {all}");
            }
        }
    }

    #[test]
    fn without_roughness_it_is_lamberts_law() {
        let smooth = OrenNayar { albedo: DVec3::new(0.2, 0.5, 0.9), roughness: 0.0 };
        for light in [0.1, 0.5, 1.0] {
            let value = smooth.value(DVec3::Z, tilted(0.4), tilted(light));
            assert!((value * PI - smooth.albedo).length() < 1e-14);
        }
    }

    #[test]
    fn a_rough_surface_throws_light_back() {
        let rough = OrenNayar { albedo: DVec3::splat(0.5), roughness: 1.0 };
        let light = tilted(0.5);
        let mirrored = DVec3::new(-light.x, -light.y, light.z);
        let [back, forth] = [light, mirrored].map(|eye| rough.value(DVec3::Z, eye, light).x);
        assert!(back > 2.0 * forth, "{back} {forth}");
    }
}
