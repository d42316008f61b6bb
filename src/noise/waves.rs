//! Plane waves of unit frequency in random directions.
//!
//! ```text
//! N(x) = sqrt(2/J) sum_j cos(2 pi (d_j . x + phi_j))
//! ```
//!
//! with `J` directions uniform on the sphere and phases uniform on the circle, all hashed from the
//! seed. Over seeds the noise is stationary and isotropic with mean 0 and variance 1, and nearly
//! Gaussian if `J` is large. Its power lies on the sphere of wavenumbers of length 1, which no noise
//! on a lattice can come near: it is as band-limited as can be.
//!
//! Summed over octaves by `fbm`, where each octave has directions of its own, it is the directional
//! Weierstrass-Mandelbrot function (Gamito 2009, 3.38). There amplitudes are Gaussian; here they are
//! equal, which gives the same covariance, and bounds that are finite and exact: all waves may crest
//! at once, so
//!
//! ```text
//! A = sqrt(2 J)        L = 2 pi A        M2 = (2 pi)^2 A        M3 = (2 pi)^3 A
//! ```
//!
//! They seldom do. Over a small ball the Hessian at its centre says more; see [`Local::smooth`].

use super::basis::Basis;
use super::bulk::{self, GRADIENT, HESSIAN, Lanes};
use super::lattice::Lattice;
use super::parameter::{Allowed, Parameter, Settings};
use crate::num::{
    Bounds, Class, Jets, Local, Order, Point, ROUNDOFF, TURN_ERROR, cos_turns, mix, sin_turns, uniform,
};
use std::f64::consts::TAU;

/// Plane waves at unit frequency: each is one unit long.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Waves {
    /// How many, 1 to [`Waves::MOST`].
    count: u32,
}

impl Waves {
    /// Most waves that there can be.
    pub const MOST: u32 = 64;

    fn amplitude(self) -> f64 {
        (2.0 / f64::from(self.count)).sqrt()
    }
}

impl Basis for Waves {
    const PARAMETERS: &'static [Parameter] = &[Parameter {
        name: "count",
        doc: "Number of waves; few make a regular pattern.",
        allowed: Allowed::Whole { least: 1, most: Waves::MOST, default: 32 },
    }];

    fn new(settings: &Settings) -> Self {
        Waves { count: (settings.number("count") as u32).clamp(1, Waves::MOST) }
    }

    fn class(&self) -> Class {
        Class::C2
    }

    fn bounds(&self) -> Bounds {
        // Directions have length 1 up to rounding.
        let range = self.amplitude() * f64::from(self.count) * (1.0 + 1e-12);
        Bounds { range, lipschitz: TAU * range, hessian: TAU * TAU * range, third: TAU * TAU * TAU * range }
    }

    /// All waves have wavenumber 1.
    fn band(&self) -> f64 {
        1.0
    }

    fn tiles(&self, period: [u32; 3]) -> Result<(), &'static str> {
        if period == [0; 3] {
            Ok(())
        } else {
            Err("waves in all directions never repeat: leave out the period")
        }
    }

    fn jets(&self, lattice: &Lattice, at: [&[f64]; 3], out: Jets<'_>) {
        let train = Train::new(*self, lattice);
        bulk::jets(|| &train, at, out);
    }

    fn jet(&self, lattice: &Lattice, order: Order, at: [f64; 3]) -> Point {
        bulk::jet(&Train::new(*self, lattice), order, at)
    }

    fn is_uniform(&self) -> bool {
        false
    }

    fn local(&self, lattice: &Lattice, _: Order, at: [f64; 3], radius: f64) -> Local {
        let jet = self.jet(lattice, Order::Hessian, at);
        Local::smooth(jet, self.bounds(), self.rounding(), radius)
    }

    /// A cosine is off by its own error and by that of adding the phase, a sum by a roundoff of its
    /// size for each term.
    fn rounding(&self) -> [f64; 3] {
        let b = self.bounds();
        let each = TURN_ERROR + (16.0 + f64::from(self.count)) * ROUNDOFF;
        [each * b.range, each * b.lipschitz, each * b.hessian]
    }

    /// A scalar product is off by three roundoffs of its terms, whose sum is at most `sqrt(3)` times
    /// the largest coordinate; adding the phase rounds once more.
    fn displacement(&self) -> f64 {
        7.0
    }
}

/// The waves of a seed.
struct Train {
    amplitude: f64,
    count: usize,
    /// Directions by axis.
    direction: [[f64; Waves::MOST as usize]; 3],
    /// Phases in turns.
    phase: [f64; Waves::MOST as usize],
}

impl Train {
    fn new(waves: Waves, lattice: &Lattice) -> Train {
        const MOST: usize = Waves::MOST as usize;
        let (seed, count) = (mix(lattice.seed), waves.count as usize);
        let mut train =
            Train { amplitude: waves.amplitude(), count, direction: [[0.0; MOST]; 3], phase: [0.0; MOST] };
        for j in 0..count {
            let random = |k: u64| uniform(mix(seed ^ mix(3 * j as u64 + k)));
            // Slices of a sphere of equal height have equal area (Archimedes).
            let (z, turn) = (2.0 * random(0) - 1.0, random(1));
            let rim = (1.0 - z * z).sqrt();
            train.direction[0][j] = rim * cos_turns(turn);
            train.direction[1][j] = rim * sin_turns(turn);
            train.direction[2][j] = z;
            train.phase[j] = random(2);
        }
        train
    }
}

impl Lanes for &Train {
    #[inline(always)]
    fn block<const ORDER: u8, const PARTS: usize, const B: usize>(
        &mut self,
        from: &[[f64; B]; 3],
        to: &mut [[f64; B]; PARTS],
    ) {
        let [x, y, z] = from;
        for part in to.iter_mut() {
            *part = [0.0; B];
        }
        for j in 0..self.count {
            let [a, b, c] = [self.direction[0][j], self.direction[1][j], self.direction[2][j]];
            let slope = [-TAU * a, -TAU * b, -TAU * c];
            let bend = TAU * TAU;
            let bend = [a * a, b * b, c * c, a * b, a * c, b * c].map(|p| -bend * p);
            for i in 0..B {
                let t = a * x[i] + b * y[i] + c * z[i] + self.phase[j];
                let cos = cos_turns(t);
                to[0][i] += cos;
                if ORDER >= GRADIENT {
                    let sin = sin_turns(t);
                    to[1][i] += slope[0] * sin;
                    to[2][i] += slope[1] * sin;
                    to[3][i] += slope[2] * sin;
                }
                if ORDER >= HESSIAN {
                    for k in 0..6 {
                        to[4 + k][i] += bend[k] * cos;
                    }
                }
            }
        }
        for part in to.iter_mut() {
            for x in part.iter_mut() {
                *x *= self.amplitude;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Setting;
    use crate::noise::tests::Random;

    fn waves(count: u32) -> Waves {
        let mut settings = Settings::new(Waves::PARAMETERS);
        settings.set("count", Setting::Number(f64::from(count))).unwrap();
        Waves::new(&settings)
    }

    #[test]
    fn variance_is_one_and_bounds_are_reached_by_one_wave() {
        let mut random = Random::new(1);
        let (mut sum, mut squares, n) = (0.0, 0.0, 200_000);
        for seed in 0..n {
            let v = waves(32).jet(&Lattice::new(seed), Order::Value, random.point(20.0)).value;
            sum += v;
            squares += v * v;
        }
        let n = n as f64;
        assert!((sum / n).abs() < 0.01 && (squares / n - 1.0).abs() < 0.015, "{sum} {squares}");
        let b = waves(1).bounds();
        let mut most = [0.0_f64; 3];
        for _ in 0..20_000 {
            let jet = waves(1).jet(&Lattice::new(3), Order::Hessian, random.point(5.0));
            let trace = jet.hess[0] + jet.hess[1] + jet.hess[2];
            let slope = jet.grad.iter().map(|g| g * g).sum::<f64>().sqrt();
            for (most, x) in most.iter_mut().zip([jet.value.abs(), slope, trace.abs()]) {
                *most = most.max(x);
            }
        }
        for (most, bound) in most.into_iter().zip([b.range, b.lipschitz, b.hessian]) {
            assert!(most <= bound && most > 0.999 * bound, "{most} {bound}");
        }
    }

    #[test]
    fn directions_are_uniform_on_the_sphere() {
        // E[d d^T] = I/3, E[d_z^4] = 1/5.
        let (mut second, mut fourth, seeds) = ([0.0; 6], 0.0, 4000);
        for seed in 0..seeds {
            let train = Train::new(waves(32), &Lattice::new(seed));
            for j in 0..32 {
                let d = [0, 1, 2].map(|k| train.direction[k][j]);
                assert!((d.iter().map(|d| d * d).sum::<f64>() - 1.0).abs() < 1e-14);
                for (k, (r, c)) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].into_iter().enumerate() {
                    second[k] += d[r] * d[c];
                }
                fourth += d[2] * d[2] * d[2] * d[2];
            }
        }
        let n = seeds as f64 * 32.0;
        for (k, s) in second.into_iter().enumerate() {
            assert!((s / n - if k < 3 { 1.0 / 3.0 } else { 0.0 }).abs() < 0.004, "{k} {}", s / n);
        }
        assert!((fourth / n - 0.2).abs() < 0.004);
    }

    #[test]
    fn the_sum_satisfies_its_wave_equation() {
        // Laplace N = -(2 pi)^2 N: an identity of the Hessian and the value.
        let mut random = Random::new(2);
        for _ in 0..1000 {
            let jet = waves(40).jet(&Lattice::new(5), Order::Hessian, random.point(100.0));
            let laplace = jet.hess[0] + jet.hess[1] + jet.hess[2];
            assert!((laplace + TAU * TAU * jet.value).abs() < 1e-11);
        }
    }
}
