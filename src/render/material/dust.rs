//! Dust: loose particles that hide one another (Lommel and Seeliger; Blinn 1982, *Light reflection
//! functions for simulation of clouds and dusty surfaces*).
//!
//! A deep layer of particles with the albedo `w` and the phase function `p` attenuates light on its way
//! in and out. Light that is scattered once leaves with the radiance
//!
//! ```text
//! L = int_0^inf (w p / 4 pi) E e^(-t / mu0) e^(-t / mu) dt / mu = w p / (4 pi) E mu0 / (mu0 + mu)
//! ```
//!
//! for the cosines `mu0` to the light and `mu` to the eye: `f = w p(a) / (4 pi (mu0 + mu))`. With the sun
//! behind the viewer both are equal, and a ball looks flat like the full moon. Scattering more than once
//! is left out, which is right for dark dust: up to a `w` of about 0.4.
//!
//! Seen from the light, particles hide their own shadows, and the layer is brighter by
//! `1 + B / (1 + tan(a/2) / h)`: the *opposition surge* (Hapke 1986).

use super::frame::around_z;
use super::{Bounce, Frame, Phase, Reflectance, bounce, choose, cosines, uniform_hemisphere};
use glam::DVec3;
use std::f64::consts::PI;

/// How much brighter dust is that is lit from behind the viewer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surge {
    /// Excess of brightness at the phase angle 0, from 0 for none to 1.
    pub strength: f64,
    /// Tangent of half the phase angle at which the excess has fallen to half, above 0; some 0.05 for
    /// the moon.
    pub width: f64,
}

/// A deep layer of dust.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dust {
    /// Share of light that a particle scatters, from 0 to 1 by channel; 0.1 to 0.3 on the moon. The
    /// layer reflects much less.
    pub albedo: DVec3,
    /// Where particles scatter light to.
    pub phase: Phase,
    /// The brightening of dust that is lit from behind the viewer.
    pub surge: Surge,
}

impl Dust {
    /// Probability of a sample in proportion to the phase function, which may have a peak.
    fn peak_share(&self) -> f64 {
        match self.phase {
            Phase::HenyeyGreenstein { g } => g.abs(),
            Phase::Constant | Phase::Ball => 0.0,
        }
    }
}

impl Surge {
    /// No brightening.
    pub const NONE: Surge = Surge { strength: 0.0, width: 1.0 };

    /// The factor for the cosine of a phase angle.
    pub fn at(self, cos: f64) -> f64 {
        let cos = cos.clamp(-1.0, 1.0);
        let tan_half = ((1.0 - cos) / (1.0 + cos)).sqrt();
        1.0 + self.strength / (1.0 + tan_half / self.width)
    }
}

/// Cosines of the table of [`AllAround`], of which the roots are evenly spaced, and steps of the quadrature for each: cosines to
/// the light, and azimuths over half a turn.
const COSINES: usize = 33;
const QUADRATURE: [u32; 2] = [96, 96];

/// The share of light from all around that leaves dust of an albedo of 1 towards an eye, by its cosine: the directional albedo,
/// which is in proportion to that of the particles.
#[derive(Clone, Debug)]
pub struct AllAround([f64; COSINES]);

impl AllAround {
    /// The table of particles that scatter so.
    pub fn new(phase: Phase, surge: Surge) -> AllAround {
        let dust = Dust { albedo: DVec3::ONE, phase, surge };
        let middle = |i: u32, steps: u32| (f64::from(i) + 0.5) / f64::from(steps);
        let [rings, sectors] = QUADRATURE;
        AllAround(std::array::from_fn(|i| {
            let root = i.max(1) as f64 / (COSINES - 1) as f64;
            let eye = around_z(if i == 0 { 1e-9 } else { root * root }, 0.0);
            let lights = (0..rings).flat_map(|ring| (0..sectors).map(move |sector| [ring, sector]));
            let share = |[ring, sector]: [u32; 2]| {
                let light = around_z(middle(ring, rings), 0.5 * middle(sector, sectors));
                dust.value(DVec3::Z, eye, light).x * light.z
            };
            2.0 * PI * lights.map(share).sum::<f64>() / f64::from(rings * sectors)
        }))
    }

    /// The share at a cosine from 0 to 1.
    pub fn at(&self, cos: f64) -> f64 {
        let place = cos.sqrt() * (COSINES - 1) as f64;
        let column = (place as usize).min(COSINES - 2);
        let [low, high] = [self.0[column], self.0[column + 1]];
        low + (place - column as f64) * (high - low)
    }
}

impl Reflectance for Dust {
    fn value(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> DVec3 {
        let Some([eye, light]) = cosines(normal, to_eye, to_light) else { return DVec3::ZERO };
        let cos = to_eye.dot(to_light);
        self.albedo * (self.phase.at(cos) * self.surge.at(cos) / (4.0 * PI * (eye + light)))
    }

    fn sample(&self, u: [f64; 2], normal: DVec3, to_eye: DVec3) -> Option<Bounce> {
        let (peak, u) = choose(u, self.peak_share());
        let direction = if peak {
            Frame::around(to_eye).to_world(around_z(self.phase.sample(u[0]), u[1]))
        } else {
            Frame::around(normal).to_world(uniform_hemisphere(u))
        };
        bounce(self, normal, to_eye, direction)
    }

    fn pdf(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> f64 {
        if cosines(normal, to_eye, to_light).is_none() {
            return 0.0;
        }
        let peak = self.peak_share();
        (1.0 - peak) / (2.0 * PI) + peak * self.phase.at(to_eye.dot(to_light)) / (4.0 * PI)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{albedo, tilted};
    use super::*;
    use crate::num::sequence::point;

    #[test]
    fn the_full_moon_is_flat() {
        for phase in [Phase::Constant, Phase::Ball, Phase::HenyeyGreenstein { g: -0.3 }] {
            let surge = Surge { strength: 1.0, width: 0.05 };
            let dust = Dust { albedo: DVec3::splat(0.2), phase, surge };
            let radiance = |mu: f64| dust.value(DVec3::Z, tilted(mu), tilted(mu)).x * mu;
            let middle = radiance(1.0);
            assert!((middle - 0.2 * phase.at(1.0) * 2.0 / (8.0 * PI)).abs() < 1e-12);
            for mu in [0.01, 0.1, 0.5, 0.9] {
                assert!((radiance(mu) / middle - 1.0).abs() < 1e-6, "{phase:?} {mu}");
            }
        }
    }

    #[test]
    fn the_albedo_of_even_particles_has_a_closed_form() {
        let dust = Dust { albedo: DVec3::ONE, phase: Phase::Constant, surge: Surge::NONE };
        let table = AllAround::new(dust.phase, dust.surge);
        for i in 1..=100 {
            let mu = f64::from(i) / 100.0;
            let known = 0.5 * (1.0 - mu * libm::log((1.0 + mu) / mu));
            assert!((table.at(mu) - known).abs() < 2e-3, "{mu}: {} {known}", table.at(mu));
        }
        for mu in [0.05, 0.3, 0.7, 1.0] {
            let known = 0.5 * (1.0 - mu * libm::log((1.0 + mu) / mu));
            assert!((albedo(&dust, DVec3::Z, tilted(mu)).x - known).abs() < 1e-4, "{mu}");
        }
    }

    #[test]
    fn light_from_all_around_leaves_as_the_law_says() {
        let dust =
            Dust { albedo: DVec3::ONE, phase: Phase::Ball, surge: Surge { strength: 1.0, width: 0.05 } };
        let table = AllAround::new(dust.phase, dust.surge);
        for mu in [0.02, 0.1, 0.3, 0.7, 1.0] {
            let seen = albedo(&dust, DVec3::Z, tilted(mu)).x;
            assert!((table.at(mu) - seen).abs() < 3e-3, "{mu}: {} {seen}", table.at(mu));
        }
    }

    #[test]
    fn no_peak_is_so_strong_that_light_is_won() {
        let surge = Surge { strength: 1.0, width: 0.05 };
        for g in [-0.95, -0.8, 0.8] {
            let dust = Dust { albedo: DVec3::ONE, phase: Phase::HenyeyGreenstein { g }, surge };
            for mu in [0.01, 0.1, 0.3, 0.7, 1.0] {
                let weight =
                    |i| dust.sample(point(0, i, 0), DVec3::Z, tilted(mu)).map_or(0.0, |b| b.weight.x);
                let all = (0..1 << 13).map(weight).sum::<f64>() / f64::from(1 << 13);
                assert!(all > 0.0 && all < 1.0, "{g} {mu}: {all}");
            }
        }
    }

    #[test]
    fn a_surge_falls_to_half_at_its_width() {
        let surge = Surge { strength: 0.8, width: 0.05 };
        let angle = 2.0 * libm::atan(0.05);
        assert_eq!([surge.at(1.0), surge.at(-1.0)], [1.8, 1.0]);
        assert!((surge.at(libm::cos(angle)) - 1.4).abs() < 1e-12);
    }
}
