//! Phase functions: how a small particle spreads the light that it scatters.
//!
//! They depend on the *phase angle* `a` between the directions to the light and to the eye: at 0 the sun
//! is behind the viewer and scattering is backward. All are normalised to a mean of 1 over the sphere.

use std::f64::consts::PI;

/// The phase function of a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Phase {
    /// The same in all directions.
    Constant,
    /// A large matt ball, of which the lit part is seen: `8/(3 pi) (sin a + (pi - a) cos a)`.
    Ball,
    /// `(1 - g^2) / (1 + g^2 + 2 g cos a)^(3/2)` (Henyey and Greenstein 1941).
    HenyeyGreenstein {
        /// The mean cosine of the angle by which light is turned, between -1 and 1: negative for light
        /// that is thrown back.
        g: f64,
    },
}

impl Phase {
    /// The value for the cosine of a phase angle.
    pub fn at(self, cos: f64) -> f64 {
        let cos = cos.clamp(-1.0, 1.0);
        match self {
            Phase::Constant => 1.0,
            Phase::Ball => {
                let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
                8.0 / (3.0 * PI) * (sin + (PI - libm::acos(cos)) * cos)
            }
            Phase::HenyeyGreenstein { g } => {
                let base = 1.0 + g * g + 2.0 * g * cos;
                (1.0 - g * g) / (base * base.sqrt())
            }
        }
    }

    /// The cosine of a phase angle with the density [`Phase::at`] `/ 2`, for `u` uniform in [0, 1); the
    /// inverse of the distribution of Henyey and Greenstein's function. Other functions are so even that
    /// their samples are uniform.
    pub(super) fn sample(self, u: f64) -> f64 {
        match self {
            Phase::HenyeyGreenstein { g } if g.abs() > 1e-4 => {
                let root = (1.0 - g * g) / (1.0 + g - 2.0 * g * u);
                ((root * root - 1.0 - g * g) / (2.0 * g)).clamp(-1.0, 1.0)
            }
            _ => 2.0 * u - 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_over_the_sphere_are_one_and_g_is_the_mean_cosine() {
        let backward = Phase::HenyeyGreenstein { g: -0.4 };
        let forward = Phase::HenyeyGreenstein { g: 0.7 };
        // The ball: int p cos = -4/9.
        for (phase, g) in
            [(Phase::Constant, 0.0), (Phase::Ball, -4.0 / 9.0), (backward, -0.4), (forward, 0.7)]
        {
            let steps = 20_000;
            let (mut mean, mut cosine) = (0.0, 0.0);
            for i in 0..steps {
                let cos = (2.0 * f64::from(i) + 1.0) / f64::from(steps) - 1.0;
                mean += phase.at(cos) / f64::from(steps);
                cosine -= cos * phase.at(cos) / f64::from(steps);
            }
            assert!((mean - 1.0).abs() < 1e-5 && (cosine - g).abs() < 1e-5, "{phase:?}: {mean} {cosine}");
        }
        assert!((Phase::Ball.at(1.0) - 8.0 / 3.0).abs() < 1e-15 && Phase::Ball.at(-1.0).abs() < 1e-15);
    }

    #[test]
    fn samples_are_distributed_as_the_function() {
        for g in [-0.8, -0.3, 0.0, 0.5] {
            let phase = Phase::HenyeyGreenstein { g };
            let steps = 10_000;
            for limit in [-0.5, 0.0, 0.7] {
                let below = (0..steps)
                    .filter(|i| phase.sample((f64::from(*i) + 0.5) / f64::from(steps)) < limit)
                    .count();
                let known: f64 = (0..steps)
                    .map(|i| (f64::from(i) + 0.5) / f64::from(steps) * (limit + 1.0) - 1.0)
                    .map(|cos| 0.5 * phase.at(cos) * (limit + 1.0) / f64::from(steps))
                    .sum();
                assert!((below as f64 / f64::from(steps) - known).abs() < 2e-4, "{g} {limit}");
            }
        }
    }
}
