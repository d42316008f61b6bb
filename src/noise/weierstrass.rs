//! The separable Weierstrass-Mandelbrot function, truncated (Gamito 2009, 3.37): a whole fractal as
//! one noise.
//!
//! ```text
//! N(x) = s sum_(i,j,k < m) e_ijk q^(i+j+k) cos(2 pi (r^i x + a_i)) cos(2 pi (r^j y + b_j)) cos(2 pi (r^k z + c_k))
//! ```
//!
//! with the lacunarity `r`, `q = r^(-H)`, random signs `e_ijk` and random phases, all hashed from the
//! seed. It has every pairing of frequencies along the three axes, which are its axes: the function
//! is not isotropic. `s^2 = 8 / (sum q^(2i))^3` makes the variance 1; signs in place of Gaussian
//! amplitudes have the same covariance, and bounds.
//!
//! **Work.** The `m^3` terms share `3 m` cosines, and the sum is contracted one axis at a time.
//!
//! **Bounds.** With `S_n = sum q^i (2 pi r^i)^n`, a derivative of order `(a, b, c)` along the axes is
//! at most `s S_a S_b S_c`. Along a unit vector `u` the first, second and third derivatives are sums
//! of these with weights `|u_i|`, `|u_i u_j|` and `|u_i u_j u_k|`, which are largest on the diagonal:
//!
//! ```text
//! A = s S_0^3                                    L  = sqrt(3) s S_1 S_0^2
//! M2 = s (S_2 S_0^2 + 2 S_1^2 S_0)               M3 = s (S_3 S_0^2 + (2/sqrt(3)) (3 S_2 S_1 S_0 + S_1^3))
//! ```
//!
//! If the lacunarity is a whole number, the function repeats after every cell as it is.

use super::basis::Basis;
use super::bulk::{self, GRADIENT, HESSIAN, Lanes};
use super::lattice::Lattice;
use super::parameter::{Allowed, Exact, Parameter, Settings};
use crate::num::{
    Bounds, Class, Jets, Local, Order, Point, ROUNDOFF, Real, TURN_ERROR, cos_turns, mix, sin_turns, uniform,
};
use std::f64::consts::TAU;

/// Most octaves along an axis.
const MOST: usize = 8;

/// The separable Weierstrass-Mandelbrot function; its longest waves are one unit long.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Weierstrass {
    octaves: u32,
    lacunarity: Exact,
    hurst: Exact,
    /// `range`, `lipschitz`, `hessian`, `third`.
    bounds: [Exact; 4],
}

impl Weierstrass {
    /// `q^i`
    fn amplitude(hurst: f64, lacunarity: f64, i: u32) -> f64 {
        libm::pow(lacunarity, -hurst * f64::from(i))
    }
}

impl Basis for Weierstrass {
    const PARAMETERS: &'static [Parameter] = &[
        Parameter {
            name: "octaves",
            doc: "Number of frequencies along each axis.",
            allowed: Allowed::Whole { least: 1, most: MOST as u32, default: 5 },
        },
        Parameter {
            name: "lacunarity",
            doc: "Ratio of successive frequencies; a whole number makes the function repeat in every cell.",
            allowed: Allowed::Number { least: 1.01, most: 8.0, default: 2.07 },
        },
        Parameter {
            name: "hurst",
            doc: "Exponent of the amplitudes: 0 is rough, 1 smooth.",
            allowed: Allowed::Number { least: 0.0, most: 2.0, default: 0.8 },
        },
    ];

    fn new(settings: &Settings) -> Self {
        let octaves = (settings.number("octaves") as u32).clamp(1, MOST as u32);
        let (r, h) = (settings.number("lacunarity"), settings.number("hurst"));
        let sum = |n: i32| {
            (0..octaves)
                .map(|i| Weierstrass::amplitude(h, r, i) * Real::powi(TAU * Real::powi(r, i as i32), n))
                .sum::<f64>()
        };
        let [s0, s1, s2, s3] = [0, 1, 2, 3].map(sum);
        let (s, two_thirds) = (scale(octaves, r, h) * (1.0 + 1e-12), 2.0 / 3.0_f64.sqrt());
        let bounds = [
            s * s0 * s0 * s0,
            s * 3.0_f64.sqrt() * s1 * s0 * s0,
            s * (s2 * s0 * s0 + 2.0 * s1 * s1 * s0),
            s * (s3 * s0 * s0 + two_thirds * (3.0 * s2 * s1 * s0 + s1 * s1 * s1)),
        ];
        Weierstrass { octaves, lacunarity: Exact(r), hurst: Exact(h), bounds: bounds.map(Exact) }
    }

    fn class(&self) -> Class {
        Class::C2
    }

    #[inline]
    fn bounds(&self) -> Bounds {
        let [range, lipschitz, hessian, third] = self.bounds.map(|b| b.0);
        Bounds { range, lipschitz, hessian, third }
    }

    /// A wave of wavenumber `r^i` along an axis has `r^(-2 H i)` times the power of the longest: a
    /// hundredth at `10^(1/H)`. Nothing is finer than the shortest waves on the diagonal.
    fn band(&self) -> f64 {
        let finest = 3.0_f64.sqrt() * Real::powi(self.lacunarity.0, self.octaves as i32 - 1);
        let faint = if self.hurst.0 > 0.0 { libm::pow(10.0, 1.0 / self.hurst.0) } else { f64::INFINITY };
        Real::min(finest, faint)
    }

    fn tiles(&self, period: [u32; 3]) -> Result<(), &'static str> {
        if period == [0; 3] || self.lacunarity.0.fract() == 0.0 {
            Ok(())
        } else {
            Err("waves repeat together if the lacunarity is a whole number, such as 2")
        }
    }

    fn jets(&self, lattice: &Lattice, at: [&[f64]; 3], out: Jets<'_>) {
        let terms = Terms::new(self, lattice);
        bulk::jets(|| &terms, at, out);
    }

    fn jet(&self, lattice: &Lattice, order: Order, at: [f64; 3]) -> Point {
        bulk::jet(&Terms::new(self, lattice), order, at)
    }

    fn is_uniform(&self) -> bool {
        false
    }

    fn local(&self, lattice: &Lattice, _: Order, at: [f64; 3], radius: f64) -> Local {
        let jet = self.jet(lattice, Order::Hessian, at);
        Local::smooth(jet, self.bounds(), self.rounding(), radius)
    }

    /// Three cosines with their phases and the amplitudes; `m` terms are summed three times over.
    fn rounding(&self) -> [f64; 3] {
        let b = self.bounds();
        let each = 3.0 * TURN_ERROR + (32.0 + 3.0 * f64::from(self.octaves)) * ROUNDOFF;
        // Phases are rounded once they are added, at most to a roundoff of a turn.
        let phase = 4.0 * ROUNDOFF;
        [
            each * b.range + phase * b.lipschitz,
            each * b.lipschitz + phase * b.hessian,
            each * b.hessian + phase * b.third,
        ]
    }

    /// The product with a frequency and the sum with a phase are rounded on each axis.
    fn displacement(&self) -> f64 {
        4.0
    }
}

/// The factor that makes the variance 1.
fn scale(octaves: u32, r: f64, h: f64) -> f64 {
    let squares: f64 = (0..octaves).map(|i| Weierstrass::amplitude(h, r, i).square()).sum();
    (8.0 / (squares * squares * squares)).sqrt()
}

/// The random numbers of a seed.
struct Terms {
    octaves: usize,
    scale: f64,
    frequency: [f64; MOST],
    amplitude: [f64; MOST],
    /// By axis and octave, in turns.
    phase: [[f64; MOST]; 3],
    /// A sign for each octave along z, by octave along x and along y.
    sign: [[[f64; MOST]; MOST]; MOST],
}

impl Terms {
    fn new(noise: &Weierstrass, lattice: &Lattice) -> Terms {
        let (r, h) = (noise.lacunarity.0, noise.hurst.0);
        let seed = mix(lattice.seed);
        let mut terms = Terms {
            octaves: noise.octaves as usize,
            scale: scale(noise.octaves, r, h),
            frequency: std::array::from_fn(|i| Real::powi(r, i as i32)),
            amplitude: std::array::from_fn(|i| Weierstrass::amplitude(h, r, i as u32)),
            phase: [[0.0; MOST]; 3],
            sign: [[[0.0; MOST]; MOST]; MOST],
        };
        for (axis, phases) in terms.phase.iter_mut().enumerate() {
            for (i, phase) in phases.iter_mut().enumerate() {
                *phase = uniform(mix(seed ^ mix((MOST * axis + i) as u64)));
            }
        }
        for (i, plane) in terms.sign.iter_mut().enumerate() {
            let bits = mix(seed ^ mix(1000 + i as u64));
            for (j, row) in plane.iter_mut().enumerate() {
                for (k, sign) in row.iter_mut().enumerate() {
                    *sign = if bits >> (MOST * j + k) & 1 == 0 { 1.0 } else { -1.0 };
                }
            }
        }
        terms
    }

    /// The weighted cosines of an axis and their derivatives.
    #[inline(always)]
    fn axis<const ORDER: u8, const B: usize>(&self, axis: usize, at: &[f64; B]) -> [[[f64; B]; MOST]; 3] {
        let mut out = [[[0.0; B]; MOST]; 3];
        for n in 0..self.octaves {
            let (f, a) = (self.frequency[n], self.amplitude[n]);
            let (slope, bend) = (-TAU * f * a, -(TAU * f) * (TAU * f) * a);
            for i in 0..B {
                let t = f * at[i] + self.phase[axis][n];
                let cos = cos_turns(t);
                out[0][n][i] = a * cos;
                if ORDER >= GRADIENT {
                    out[1][n][i] = slope * sin_turns(t);
                }
                if ORDER >= HESSIAN {
                    out[2][n][i] = bend * cos;
                }
            }
        }
        out
    }
}

impl Lanes for &Terms {
    #[inline(always)]
    fn block<const ORDER: u8, const PARTS: usize, const B: usize>(
        &mut self,
        from: &[[f64; B]; 3],
        to: &mut [[f64; B]; PARTS],
    ) {
        let m = self.octaves;
        let x = self.axis::<ORDER, B>(0, &from[0]);
        let y = self.axis::<ORDER, B>(1, &from[1]);
        let z = self.axis::<ORDER, B>(2, &from[2]);
        for part in to.iter_mut() {
            *part = [0.0; B];
        }
        for i in 0..m {
            // Sums over j and k of the derivatives along y and z: none, y, z, yy, zz, yz.
            let mut yz = [[0.0; B]; 6];
            for j in 0..m {
                let mut along = [[0.0; B]; 3];
                for k in 0..m {
                    let sign = self.sign[i][j][k];
                    for (n, along) in along.iter_mut().enumerate().take(ORDER as usize + 1) {
                        for l in 0..B {
                            along[l] += sign * z[n][k][l];
                        }
                    }
                }
                for l in 0..B {
                    yz[0][l] += y[0][j][l] * along[0][l];
                    if ORDER >= GRADIENT {
                        yz[1][l] += y[1][j][l] * along[0][l];
                        yz[2][l] += y[0][j][l] * along[1][l];
                    }
                    if ORDER >= HESSIAN {
                        yz[3][l] += y[2][j][l] * along[0][l];
                        yz[4][l] += y[0][j][l] * along[2][l];
                        yz[5][l] += y[1][j][l] * along[1][l];
                    }
                }
            }
            for l in 0..B {
                to[0][l] += x[0][i][l] * yz[0][l];
                if ORDER >= GRADIENT {
                    to[1][l] += x[1][i][l] * yz[0][l];
                    to[2][l] += x[0][i][l] * yz[1][l];
                    to[3][l] += x[0][i][l] * yz[2][l];
                }
                if ORDER >= HESSIAN {
                    to[4][l] += x[2][i][l] * yz[0][l];
                    to[5][l] += x[0][i][l] * yz[3][l];
                    to[6][l] += x[0][i][l] * yz[4][l];
                    to[7][l] += x[1][i][l] * yz[1][l];
                    to[8][l] += x[1][i][l] * yz[2][l];
                    to[9][l] += x[0][i][l] * yz[5][l];
                }
            }
        }
        for part in to.iter_mut() {
            for x in part.iter_mut() {
                *x *= self.scale;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Setting;
    use crate::noise::tests::Random;

    fn weierstrass(octaves: u32, lacunarity: f64, hurst: f64) -> Weierstrass {
        let mut settings = Settings::new(Weierstrass::PARAMETERS);
        settings.set("octaves", Setting::Number(f64::from(octaves))).unwrap();
        settings.set("lacunarity", Setting::Number(lacunarity)).unwrap();
        settings.set("hurst", Setting::Number(hurst)).unwrap();
        Weierstrass::new(&settings)
    }

    #[test]
    fn the_sum_is_the_one_of_the_definition() {
        let mut random = Random::new(1);
        for noise in [weierstrass(8, 2.0, 0.8), weierstrass(3, 1.7, 0.0), weierstrass(1, 2.0, 1.0)] {
            let (lattice, m) = (Lattice::new(4), noise.octaves as usize);
            let terms = Terms::new(&noise, &lattice);
            for _ in 0..50 {
                let p = random.point(3.0);
                let mut sum = 0.0;
                for n in 0..m * m * m {
                    let i = [n % m, n / m % m, n / m / m];
                    let mut term = terms.sign[i[0]][i[1]][i[2]] * terms.scale;
                    for axis in 0..3 {
                        let turns = terms.frequency[i[axis]] * p[axis] + terms.phase[axis][i[axis]];
                        term *= terms.amplitude[i[axis]] * libm::cos(TAU * turns);
                    }
                    sum += term;
                }
                let value = noise.jet(&lattice, Order::Value, p).value;
                assert!((value - sum).abs() < 1e-10, "{value} {sum}");
            }
        }
    }

    #[test]
    fn variance_is_one_over_seeds() {
        let noise = weierstrass(4, 2.0, 0.7);
        let mut random = Random::new(2);
        let (mut sum, mut squares, n) = (0.0, 0.0, 100_000);
        for seed in 0..n {
            let v = noise.jet(&Lattice::new(seed), Order::Value, random.point(20.0)).value;
            sum += v;
            squares += v * v;
        }
        let n = n as f64;
        assert!((sum / n).abs() < 0.015 && (squares / n - 1.0).abs() < 0.03, "{} {}", sum / n, squares / n);
    }

    #[test]
    fn bounds_of_a_single_product_are_close() {
        let noise = weierstrass(1, 2.0, 1.0);
        let (mut random, b, mut most) = (Random::new(3), noise.bounds(), [0.0_f64; 2]);
        for _ in 0..50_000 {
            let jet = noise.jet(&Lattice::new(1), Order::Hessian, random.point(1.0));
            most[0] = most[0].max(jet.value.abs());
            most[1] = most[1].max(jet.hess[0].abs());
        }
        assert!(most[0] <= b.range && most[0] > 0.98 * b.range, "{most:?} {b:?}");
        assert!(most[1] <= b.hessian && most[1] > 0.3 * b.hessian, "{most:?} {b:?}");
    }

    #[test]
    fn whole_lacunarities_repeat() {
        let (noise, mut random) = (weierstrass(6, 3.0, 0.5), Random::new(4));
        assert!(noise.tiles([1, 2, 3]).is_ok() && weierstrass(6, 2.1, 0.5).tiles([1, 0, 0]).is_err());
        for _ in 0..100 {
            let p = random.point(4.0);
            let at = |p| noise.jet(&Lattice::new(4), Order::Value, p).value;
            assert!((at(p) - at([p[0] + 1.0, p[1] - 2.0, p[2] + 3.0])).abs() < 1e-9);
        }
    }
}
