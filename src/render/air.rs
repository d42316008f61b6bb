//! Air around a planet: light that is scattered once on its way (Rayleigh; Nishita et al. 1993).
//!
//! Density falls off as `exp(-h / H)` with the height `h` above a sphere around the origin. Light
//! that reaches the eye along a ray is
//!
//! ```text
//! L = T(eye, end) L_end + E P(mu) int T(eye, p) beta rho(p) T(p, sun) V(p) ds
//! ```
//!
//! with transmittance `T = exp(-beta int rho ds)`, phase function `P(mu) = 3/(16 pi) (1 + mu^2)` and
//! visibility `V` of the sun past the planet. The integral is cut into steps, and each step gives
//! `T (1 - T_step)` times the sunlight at one point of it, so that no amount of air scatters more
//! light than it holds back, however coarse the steps are.
//!
//! Everything is measured from the *perigee*, the point of a line that is nearest to the origin, at
//! radius `b`: with the signed distance `s` from there, `r^2 = b^2 + s^2` has no cancellation.

use crate::scene::{Air, Sun};
use glam::DVec3;
use std::f64::consts::PI;

/// Heights `H` up to the top, where the density is e^-12: what lies above could not be seen.
const TOP: f64 = 12.0;

/// Steps along a ray that only comes down, or only goes up, and along each half of one that does
/// both.
const STEPS: (u32, u32) = (16, 10);

/// Angular radius of the sun as seen from the Earth.
const SUN_RADIUS: f64 = 0.004_67;

/// Air made ready for questions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Atmosphere {
    radius: f64,
    height: f64,
    top: f64,
    scattering: DVec3,
}

/// What air does to a line of sight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// Share of the light from behind that gets through, by channel.
    pub transmittance: DVec3,
    /// Sunlight that joins it.
    pub scattered: DVec3,
}

impl Atmosphere {
    /// The atmosphere of some air; `None` for air that takes no room or does nothing.
    pub(super) fn new(air: &Air) -> Option<Self> {
        let Air { radius, height, scattering, .. } = *air;
        let fine = radius > 0.0 && radius.is_finite() && height > 0.0 && height.is_finite();
        (fine && scattering.is_finite() && scattering.max_element() > 0.0).then(|| Atmosphere {
            radius,
            height,
            top: radius + TOP * height,
            scattering: scattering.max(DVec3::ZERO),
        })
    }

    /// What a line of sight of length `distance` (infinite if nothing is in the way) goes through.
    /// `jitter` in [0, 1) picks the point at which each step asks for sunlight.
    pub(super) fn along(
        &self,
        eye: DVec3,
        direction: DVec3,
        distance: f64,
        suns: &[(DVec3, DVec3)],
        jitter: f64,
        _: &[f64],
    ) -> Seen {
        let sun = Sun { direction: suns[0].0, irradiance: suns[0].1, ..Sun::default() };
        let mut seen = Seen { transmittance: DVec3::ONE, scattered: DVec3::ZERO };
        let to_perigee = -eye.dot(direction);
        let perigee = eye + to_perigee * direction;
        let perigee = perigee - perigee.dot(direction) * direction;
        let b = perigee.length();
        if b >= self.top {
            return seen;
        }
        let half = ((self.top - b) * (self.top + b)).sqrt();
        let (s0, s1) = ((-to_perigee).max(-half), (distance - to_perigee).min(half));
        if s0 >= s1 {
            return seen;
        }
        let steps = if s0 < 0.0 && s1 > 0.0 { STEPS.1 } else { STEPS.0 };
        let mut step = |from: f64, to: f64| {
            let through = exp(-self.scattering * self.mass(b, from, to));
            let sunlight = self.sunlight(perigee + (from + jitter * (to - from)) * direction, sun.direction);
            seen.scattered += seen.transmittance * (1.0 - through) * sunlight;
            seen.transmittance *= through;
        };
        if s0 < 0.0 {
            let node = |i: u32| -self.node(b, s1.min(0.0), s0, f64::from(i) / f64::from(steps));
            (0..steps).rev().for_each(|i| step(node(i + 1), node(i)));
        }
        if s1 > 0.0 {
            let node = |i: u32| self.node(b, s0.max(0.0), s1, f64::from(i) / f64::from(steps));
            (0..steps).for_each(|i| step(node(i), node(i + 1)));
        }
        let mu = direction.dot(sun.direction);
        seen.scattered *= sun.irradiance * (3.0 / (16.0 * PI) * (1.0 + mu * mu));
        seen
    }

    /// Distance from the perigee of the node at `u` in [0, 1] between the dense end `a` and the thin
    /// end `z` of a piece of a line. Heights grow as `u^2`: that spaces nodes evenly along a line
    /// at its perigee, and by fractions of `H`, slowly growing, where it goes straight up.
    fn node(&self, b: f64, a: f64, z: f64, u: f64) -> f64 {
        let (ra, rz) = (hypot(b, a), hypot(b, z));
        let rise = (z - a) * (z + a) / (ra + rz) * (u * u);
        (a * a + rise * (2.0 * ra + rise)).sqrt()
    }

    pub(super) fn nodes(&self, _: DVec3, _: DVec3, _: f64, _: f64, _: &mut Vec<DVec3>) {}

    pub(super) fn sky(&self, p: DVec3, direction: DVec3, suns: &[(DVec3, DVec3)]) -> DVec3 {
        self.along(p, direction, f64::INFINITY, suns, 0.5, &[]).scattered
    }

    pub(super) fn ambient(&self, p: DVec3, _: DVec3, suns: &[(DVec3, DVec3)]) -> [DVec3; 2] {
        [DVec3::splat(0.1 * self.daylight(p, suns[0].0)); 2]
    }

    /// Density at a radius, relative to that at `self.radius`. Deep in the ground it stays what it
    /// is there: nobody looks, but nothing must overflow.
    fn density(&self, r: f64) -> f64 {
        libm::exp(((self.radius - r) / self.height).min(4.0))
    }

    /// `int rho ds` over a step, by Gauss's rule with two points (error below 0.2% of a step).
    fn mass(&self, b: f64, from: f64, to: f64) -> f64 {
        let (mid, half) = (0.5 * (from + to), 0.5 * (to - from));
        let off = half * 0.577_350_269_189_625_8;
        half * (self.density(hypot(b, mid - off)) + self.density(hypot(b, mid + off)))
    }

    /// `int rho ds` from radius `r` outwards to infinity along a line at the cosine `mu >= 0` to the
    /// vertical. With the height expanded to second order along the line this is
    /// `rho sqrt(pi r H / 2) / sin erfcx(z)`, `z = mu / sin sqrt(r / 2H)`; the error is of order `H/r`.
    fn mass_above(&self, r: f64, mu: f64) -> f64 {
        let sine = ((1.0 - mu) * (1.0 + mu)).max(1e-18).sqrt();
        let z = mu / sine * (0.5 * r / self.height).sqrt();
        self.density(r) * (0.5 * PI * r * self.height).sqrt() / sine * erfcx(z)
    }

    /// Share of sunlight that arrives at a point, by channel. Where the planet covers the sun there
    /// is none; the edge of its shadow is as wide as the sun's disc makes it, and half a height
    /// `H`, which stands for the terrain that the sphere does not have.
    pub(super) fn sunlight(&self, p: DVec3, sun: DVec3) -> DVec3 {
        let r = p.length();
        if r == 0.0 {
            return DVec3::ZERO;
        }
        let mu = (p.dot(sun) / r).clamp(-1.0, 1.0);
        if mu >= 0.0 {
            return exp(-self.scattering * self.mass_above(r, mu));
        }
        let b = r * ((1.0 - mu) * (1.0 + mu)).sqrt();
        let edge = 0.5 * self.height + SUN_RADIUS * -mu * r;
        let above = ((b - self.radius) / edge + 1.0).clamp(0.0, 1.0);
        if above == 0.0 {
            return DVec3::ZERO;
        }
        let visible = above * above * (3.0 - 2.0 * above);
        let mass = 2.0 * self.mass_above(b, 0.0) - self.mass_above(r, -mu);
        exp(-self.scattering * mass.max(0.0)) * visible
    }

    /// How bright the sky is above a point, relative to the sun overhead: the mean sunlight two
    /// heights further up, where most of what the sky scatters down has yet to be scattered, times
    /// how steeply it falls in. It fades towards sunset, lingers after it, and goes out.
    pub(super) fn daylight(&self, p: DVec3, sun: DVec3) -> f64 {
        let up = p.normalize_or_zero();
        let mu = up.dot(sun);
        // `max(mu, 0)` with its corner rounded off to 0.1, for the light from beyond the horizon.
        let steepness = 0.5 * (mu + (mu * mu + 0.04).sqrt());
        steepness.min(1.0) * self.sunlight(p + 2.0 * self.height * up, sun).element_sum() / 3.0
    }
}

/// The exponential by channel, from a library that gives the same bits on every machine.
fn exp(x: DVec3) -> DVec3 {
    DVec3::from_array(x.to_array().map(libm::exp))
}

/// Length of the hypotenuse; planets are neither so large nor so small that squares overflow.
fn hypot(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}

/// `exp(z^2) erfc(z)` for `z >= 0`.
fn erfcx(z: f64) -> f64 {
    if z < 10.0 {
        return libm::exp(z * z) * libm::erfc(z);
    }
    let q = 0.5 / (z * z);
    (1.0 - q * (1.0 - 3.0 * q * (1.0 - 5.0 * q))) / (z * PI.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The Earth with a radius of 1.
    fn earth() -> Atmosphere {
        let air = Air {
            radius: 1.0,
            height: 8.0 / 6371.0,
            scattering: DVec3::new(5.8, 13.5, 33.1) * 1e-6 * 6371e3,
            shafts: false,
        };
        Atmosphere::new(&air).unwrap()
    }

    fn noon() -> Sun {
        Sun { direction: DVec3::Y, irradiance: DVec3::ONE, ..Sun::default() }
    }

    #[test]
    fn zenith_and_horizon() {
        let earth = earth();
        let zenith = earth.sunlight(DVec3::Y, DVec3::Y);
        let expected = DVec3::new(0.0464, 0.108, 0.2648);
        assert!((zenith - (-expected).exp()).abs().max_element() < 1e-3);
        let air_mass = earth.mass_above(1.0, 0.0) / earth.mass_above(1.0, 1.0);
        assert!((air_mass - 35.4).abs() < 0.5, "{air_mass}");
    }

    #[test]
    fn steps_add_up_to_the_closed_form() {
        let earth = earth();
        for mu in [1.0f64, 0.7, 0.2, 0.05, 0.0] {
            let direction = DVec3::new((1.0 - mu * mu).sqrt(), mu, 0.0);
            let seen = earth.along(DVec3::Y, direction, f64::INFINITY, &noon(), 0.5);
            let depth = -seen.transmittance.x.ln() / earth.scattering.x;
            let closed = earth.mass_above(1.0, mu);
            assert!((depth / closed - 1.0).abs() < 0.01, "{mu}: {depth} {closed}");
        }
    }

    #[test]
    fn halves_of_a_ray_compose() {
        let earth = earth();
        let (eye, direction) = (DVec3::new(-3.0, 1.002, 0.0), DVec3::X);
        let t = |eye: DVec3, d: f64| earth.along(eye, direction, d, &noon(), 0.5).transmittance;
        let whole = t(eye, f64::INFINITY);
        let parts = t(eye, 2.99) * t(eye + 2.99 * direction, f64::INFINITY);
        assert!((whole - parts).abs().max_element() < 1e-3, "{whole} {parts}");
    }

    #[test]
    fn the_sky_is_blue_and_the_night_dark() {
        let earth = earth();
        let up = |sun: DVec3| {
            let sun = Sun { direction: sun, ..noon() };
            earth.along(DVec3::Y * 1.000001, DVec3::Y, f64::INFINITY, &sun, 0.5).scattered
        };
        let day = up(DVec3::new(0.6, 0.8, 0.0));
        assert!(day.z > 2.0 * day.y && day.y > 1.5 * day.x && day.x > 0.0);
        assert_eq!(up(DVec3::NEG_Y), DVec3::ZERO);
        let dusk = up(DVec3::new(0.9998, -0.02, 0.0));
        assert!(dusk.x > 0.0 && dusk.max_element() < 0.3 * day.max_element());
    }

    #[test]
    fn no_air_gives_back_more_than_it_takes() {
        let thick = Atmosphere { scattering: DVec3::splat(1e6), ..earth() };
        let seen = thick.along(DVec3::Y * 2.0, DVec3::NEG_Y, 1.0, &noon(), 0.3);
        assert_eq!(seen.transmittance, DVec3::ZERO);
        assert!(seen.scattered.max_element() <= 3.0 / (8.0 * PI));
    }

    #[test]
    fn odd_air_is_no_air() {
        let air = Air { radius: 1.0, height: 0.0, scattering: DVec3::ONE };
        assert!(Atmosphere::new(&air).is_none());
        assert!(Atmosphere::new(&Air { height: f64::NAN, ..air }).is_none());
        assert!(Atmosphere::new(&Air { height: 0.1, scattering: DVec3::ZERO, ..air }).is_none());
    }

    #[test]
    fn the_scaled_error_function_is_continuous() {
        let (a, b) = (erfcx(10.0 - 1e-9), erfcx(10.0));
        assert!((a / b - 1.0).abs() < 1e-6);
        assert!((erfcx(1.0) - 0.427_583_576).abs() < 1e-9);
    }
}
