//! Phase functions: how much light is scattered by how large an angle, per steradian.

use super::medium::Medium;
use glam::DVec3;
use std::f64::consts::PI;

/// Phase functions of gas, haze and fog at one angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Phases([DVec3; 3]);

impl Phases {
    /// Those at the angle between a line of sight and the sun, of which `mu` is the cosine.
    pub fn new(medium: &Medium, mu: f64) -> Phases {
        let [haze, fog] = medium.asymmetry;
        Phases([DVec3::splat(molecules(mu)), grains(mu, haze), grains(mu, fog)])
    }

    /// Light that comes out of air with the yields of [`super::march::Step`], of sunlight that arrives and
    /// light `psi` that is even in all directions.
    pub fn scattered(&self, yields: &[DVec3; 3], sunlight: DVec3, psi: DVec3) -> DVec3 {
        let by = |i: usize| yields[i] * (self.0[i] * sunlight + psi);
        by(0) + by(1) + by(2)
    }
}

/// Molecules, for the cosine `mu` of the angle by which light turns (Rayleigh):
/// `3 / (16 pi) (1 + mu^2)`.
fn molecules(mu: f64) -> f64 {
    3.0 / (16.0 * PI) * (1.0 + mu * mu)
}

/// Grains and droplets of the asymmetry `g`, by channel (Cornette and Shanks 1992, after Henyey and
/// Greenstein):
/// `3 / (8 pi) (1 - g^2) / (2 + g^2) (1 + mu^2) / (1 + g^2 - 2 g mu)^(3/2)`.
fn grains(mu: f64, g: DVec3) -> DVec3 {
    let one = |g: f64| {
        let d = 1.0 + g * g - 2.0 * g * mu;
        3.0 / (8.0 * PI) * (1.0 - g * g) / (2.0 + g * g) * (1.0 + mu * mu) / (d * d.sqrt())
    };
    DVec3::new(one(g.x), one(g.y), one(g.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_light_goes_somewhere() {
        for g in [0.0, 0.5, 0.8, -0.6] {
            let n = 100_000;
            let (mut rayleigh, mut mie) = (0.0, 0.0);
            for i in 0..n {
                let mu = (2.0 * f64::from(i) + 1.0) / f64::from(n) - 1.0;
                rayleigh += molecules(mu);
                mie += grains(mu, DVec3::splat(g)).y;
            }
            let ring = 4.0 * PI / f64::from(n);
            assert!((rayleigh * ring - 1.0).abs() < 1e-6 && (mie * ring - 1.0).abs() < 1e-4, "{g}");
        }
    }
}
