//! Spectral synthesis: random fields of a given power spectrum, and the sea.
//!
//! A stationary random field is a sum of waves of all frequencies `k` (in cycles a unit of length),
//! each with a random phase and a random amplitude whose variance the power spectral density `S(k)`
//! gives (thesis, 3.27; Voss 1985). On a grid of `n` samples a distance `h` apart the frequencies
//! are the multiples of `1 / (n h)` up to `1 / (2 h)`, and the sum is an inverse Fourier transform:
//!
//! ```text
//! f(x) = sum_k g_k exp(2 pi i k.x)
//! g_k  = a_k exp(-i w_k t) + conj(a_(-k)) exp(i w_k t)          E|a_k|^2 = S(k) dk / 2
//! ```
//!
//! with independent complex normal amplitudes `a_k`. Frequencies are *signed*: the upper half of the
//! indices stands for negative ones. `g_(-k)` is the conjugate of `g_k` by construction, so the field
//! is real; where a frequency is its own negative (zero, and the highest of an axis), `g_k` is
//! twice the real part of `a_k`, and so real with the doubled variance that the missing imaginary part
//! would have had. The two terms are the waves that travel along `k` and against it: with a
//! dispersion relation `w(k)` the field moves, and keeps its spectrum. The field repeats after the
//! length of the grid along each axis. Its mean is zero.
//!
//! An amplitude is a hash of the seed and its frequency's number, so a finer grid of the same extent
//! has the same waves and some shorter ones besides.

use super::random::{key, normals};
use super::{Cancel, Failure, Frame, Samples};
use crate::num::{Complex, Direction, Real, Unfit, transform};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Acceleration of gravity on Earth, in metres per square second.
pub const GRAVITY: f64 = 9.81;

/// How waves move: what their angular frequency is.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Motion {
    /// They do not.
    Still,
    /// As waves on deep water do after a time in seconds: `w = sqrt(g |2 pi k|)`, frequencies in
    /// cycles a metre.
    DeepWater(f64),
}

impl Motion {
    /// Phase by which waves of a frequency have advanced.
    fn phase(self, k: [f64; 3]) -> f64 {
        match self {
            Motion::Still => 0.0,
            Motion::DeepWater(time) => (GRAVITY * TAU * length(k)).sqrt() * time,
        }
    }
}

fn length(k: [f64; 3]) -> f64 {
    (k[0] * k[0] + k[1] * k[1] + k[2] * k[2]).sqrt()
}

/// Frequency number of an index: the upper half is negative.
fn signed(i: usize, n: usize) -> i64 {
    if i <= n / 2 { i as i64 } else { i as i64 - n as i64 }
}

/// A random field with the power spectral density `density(k)`, at the samples of a frame. Along axes
/// of one sample it does not change. A density that differs between `k` and `-k` says where waves go.
///
/// # Errors
/// Unless every axis has a power of two of samples and the density is finite and not negative.
pub fn synthesize<F>(
    frame: Frame,
    seed: u64,
    motion: Motion,
    density: F,
    cancel: Cancel<'_>,
) -> Result<Samples, Failure>
where
    F: FnMut([f64; 3]) -> f64 + Clone + Send + Sync,
{
    let frame = frame.checked()?;
    let waves = amplitudes(&frame, seed, motion, density, cancel)?;
    let mut data = waves;
    transform(&mut data, frame.size, Direction::Inverse).map_err(unfit)?;
    if cancel() {
        return Err(Failure::Cancelled);
    }
    Ok(Samples { frame, values: data.iter().map(|c| c.re).collect() })
}

fn unfit(e: Unfit) -> Failure {
    match e {
        Unfit::Length(n) => Failure::Power(n),
        Unfit::Count { given, wanted } => Failure::Count { given, wanted },
    }
}

/// The frequencies of a frame.
struct Frequencies {
    size: [usize; 3],
    /// Distances of neighbours along the axes. One of a single sample has no frequencies, and takes no part in the measure: 0.
    step: [f64; 3],
    /// Of one of them, as a part of their space.
    measure: f64,
}

impl Frequencies {
    fn of(frame: &Frame) -> Frequencies {
        let extent = frame.extent();
        let step = std::array::from_fn(|axis| if frame.size[axis] > 1 { 1.0 / extent[axis] } else { 0.0 });
        Frequencies { size: frame.size, step, measure: step.iter().filter(|step| **step > 0.0).product() }
    }

    /// Which frequency is stored at an index.
    fn number(&self, index: [usize; 3]) -> [i64; 3] {
        std::array::from_fn(|axis| signed(index[axis], self.size[axis]))
    }

    /// A frequency by its number.
    fn vector(&self, number: [i64; 3]) -> [f64; 3] {
        std::array::from_fn(|axis| number[axis] as f64 * self.step[axis])
    }

    /// The power at a frequency.
    fn power(&self, density: &mut impl FnMut([f64; 3]) -> f64, at: [f64; 3]) -> Result<f64, Failure> {
        let value = density(at);
        if !(value >= 0.0 && value.is_finite()) {
            return Err(Failure::Spectrum { value, at });
        }
        Ok(value * self.measure)
    }

    /// Something for each of them, by their indices; for that of zero there is nothing.
    fn map<T: Default + Clone + Send, F>(
        &self,
        density: F,
        of: impl Fn(&mut F, [usize; 3]) -> Result<T, Failure> + Sync + Send,
        cancel: Cancel<'_>,
    ) -> Result<Vec<T>, Failure>
    where
        F: FnMut([f64; 3]) -> f64 + Clone + Send + Sync,
    {
        let mut found = vec![T::default(); self.size.iter().product()];
        let row_of = |density: &mut F, (row, found): (usize, &mut [T])| {
            if cancel() {
                return Err(Failure::Cancelled);
            }
            for (i, found) in found.iter_mut().enumerate().skip(usize::from(row == 0)) {
                *found = of(density, [i, row % self.size[1], row / self.size[1]])?;
            }
            Ok(())
        };
        let rows = found.par_chunks_mut(self.size[0]).enumerate();
        rows.try_for_each_init(|| density.clone(), row_of)?;
        Ok(found)
    }
}

/// The `g_k`.
fn amplitudes<F>(
    frame: &Frame,
    seed: u64,
    motion: Motion,
    density: F,
    cancel: Cancel<'_>,
) -> Result<Vec<Complex>, Failure>
where
    F: FnMut([f64; 3]) -> f64 + Clone + Send + Sync,
{
    let Frame { size, .. } = *frame;
    if let Some(n) = size.iter().find(|n| !n.is_power_of_two()) {
        return Err(Failure::Power(*n));
    }
    let all = Frequencies::of(frame);
    let wave = |density: &mut F, index: [usize; 3]| {
        // What travels one way, and what travels the other.
        let mut one = |index: [usize; 3]| {
            let number = all.number(index);
            let k = all.vector(number);
            let power = all.power(density, k)?;
            let [re, im] = normals(key(seed, number));
            let turn = Complex::turn(-motion.phase(k));
            Ok(Complex { re, im }.scale((0.25 * power).sqrt()) * turn)
        };
        let back = std::array::from_fn(|axis| (size[axis] - index[axis]) % size[axis]);
        Ok(one(index)? + one(back)?.conj())
    };
    all.map(density, wave, cancel)
}

/// Standard deviation that a field of a spectrum is to be expected to have on a frame: the root of
/// the sum of the density over all frequencies of the grid.
///
/// # Errors
/// As [`synthesize`].
pub fn deviation<F>(frame: &Frame, density: F, cancel: Cancel<'_>) -> Result<f64, Failure>
where
    F: FnMut([f64; 3]) -> f64 + Clone + Send + Sync,
{
    let all = Frequencies::of(frame);
    let power = |density: &mut F, index| all.power(density, all.vector(all.number(index)));
    Ok(super::total(&all.map(density, power, cancel)?).sqrt())
}

/// Fractional Brownian motion of `axes` dimensions (thesis, 3.26): `|k|^-beta` with
/// `beta = 2 hurst + axes`, which ends at features of size `largest`: without an end its variance would
/// grow with the size of the grid.
pub fn fbm(hurst: f64, axes: u32, largest: f64) -> impl Fn([f64; 3]) -> f64 + Clone + Send + Sync {
    let beta = 2.0 * hurst + f64::from(axes);
    let lowest = 1.0 / largest;
    move |k| {
        let k = length(k);
        // Rounded frequencies of the largest waves still count.
        if k < lowest * (1.0 - 1e-9) { 0.0 } else { libm::pow(k, -beta) }
    }
}

/// A Markov field (thesis, figure 3.4): `1 / (|k|^2 + alpha^2)`, flat below the frequency `alpha`.
pub fn markov(alpha: f64) -> impl Fn([f64; 3]) -> f64 + Clone + Send + Sync {
    move |[x, y, z]| 1.0 / (x * x + y * y + z * z + alpha * alpha)
}

/// A wind over the open sea.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Wind {
    /// Speed 10 metres above the water, in metres a second.
    pub speed: f64,
    /// Where it blows to: angle in radians in the plane of x and z, 0 along z, growing towards x.
    pub direction: f64,
    /// How narrowly waves follow it: the `p` of `cos^2p(angle / 2)`. 0 is every direction alike.
    pub focus: f64,
}

impl Wind {
    /// Spectrum of the waves that a wind has raised when it has blown for long (Pierson and Moskowitz
    /// 1964), by the frequency of a wave in time:
    ///
    /// ```text
    /// F(f) = a g^2 / ((2 pi)^4 f^5) exp(-5/4 (f_m / f)^4),    a = 0.0081,   f_m = 0.13 g / speed
    /// ```
    ///
    /// On deep water `(2 pi f)^2 = 2 pi g k`, hence `df = f / (2 k) dk`, and a ring of frequencies in
    /// space has the circumference `2 pi k` over which the directional factor (Longuet-Higgins 1963),
    /// of unit integral, spreads the energy: `S(k) = F(f) f / (2 k^2) D(angle)`. Metres and seconds.
    pub fn spectrum(self) -> impl Fn([f64; 3]) -> f64 + Clone + Send + Sync {
        let peak = 0.13 * GRAVITY / self.speed;
        let factor = 0.0081 * GRAVITY * GRAVITY / (TAU * TAU * TAU * TAU);
        let p = self.focus;
        let whole = 2.0 * PI.sqrt() * libm::exp(libm::lgamma(p + 0.5) - libm::lgamma(p + 1.0));
        move |[x, _, z]| {
            let k = (x * x + z * z).sqrt();
            if k == 0.0 {
                return 0.0;
            }
            let f = (GRAVITY * k / TAU).sqrt();
            let calm = libm::exp(-1.25 * Real::powi(peak / f, 4));
            let energy = factor / Real::powi(f, 5) * calm;
            let half = 0.5 * (libm::atan2(x, z) - self.direction);
            let cos = libm::cos(half);
            let spread = libm::pow(cos * cos, p) / whole;
            energy * f / (2.0 * k * k) * spread
        }
    }

    /// Standard deviation of the water's height in metres, over all waves: `F` integrates to
    /// `a g^2 / ((2 pi)^4 5 f_m^4)`. Four of it are the significant height of the waves.
    pub fn deviation(self) -> f64 {
        let peak = 0.13 * GRAVITY / self.speed;
        (0.0081 * GRAVITY * GRAVITY / (5.0 * Real::powi(TAU * peak, 4))).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Edge, never};
    use super::*;

    fn flat(n: usize, extent: f64) -> Frame {
        Frame::over([n, 1, n], [0.0; 3], [extent, 1.0, extent], Edge::Repeat).unwrap()
    }

    fn cube(n: usize) -> Frame {
        Frame::over([n; 3], [0.0; 3], [1.0; 3], Edge::Repeat).unwrap()
    }

    /// Slope of the logarithm of the mean power at a frequency over the logarithm of the frequency.
    fn slope(s: &Samples) -> f64 {
        let Frame { size, .. } = s.frame;
        let mut data: Vec<Complex> = s.values.iter().map(|v| Complex { re: *v, im: 0.0 }).collect();
        transform(&mut data, size, Direction::Forward).unwrap();
        let mut rings = vec![(0.0, 0.0, 0.0); size[0] / 2];
        for (i, c) in data.iter().enumerate().skip(1) {
            let index = s.frame.index(i);
            let k: [f64; 3] = std::array::from_fn(|a| signed(index[a], size[a]) as f64);
            let r = length(k);
            if let Some(ring) = rings.get_mut(r.round() as usize) {
                *ring = (ring.0 + c.norm_squared(), ring.1 + 1.0, ring.2 + r);
            }
        }
        let points: Vec<(f64, f64, f64)> =
            rings.iter().skip(3).map(|(p, n, r)| (libm::log(r / n), libm::log(p / n), *n)).collect();
        let weight: f64 = points.iter().map(|p| p.2).sum();
        let mean =
            |f: &dyn Fn(&(f64, f64, f64)) -> f64| points.iter().map(|p| p.2 * f(p)).sum::<f64>() / weight;
        let (mx, my) = (mean(&|p| p.0), mean(&|p| p.1));
        mean(&|p| (p.0 - mx) * (p.1 - my)) / mean(&|p| (p.0 - mx) * (p.0 - mx))
    }

    #[test]
    fn fields_are_real_and_without_mean() {
        for frame in [flat(64, 3.0), cube(16)] {
            let mut waves = amplitudes(&frame, 5, Motion::DeepWater(3.7), fbm(0.7, 2, 4.0), &never).unwrap();
            assert_eq!(waves[0], Complex::default());
            transform(&mut waves, frame.size, Direction::Inverse).unwrap();
            let most = waves.iter().map(|c| c.im.abs()).fold(0.0, f64::max);
            assert!(most < 1e-12, "{most}");
            let field = synthesize(frame, 5, Motion::DeepWater(3.7), fbm(0.7, 2, 4.0), &never).unwrap();
            assert!(field.moments().0.abs() < 1e-13);
        }
    }

    #[test]
    fn spectra_have_the_slope_of_theory() {
        for (seed, hurst) in [(1, 0.2), (2, 0.5), (3, 0.8)] {
            let plane = synthesize(flat(256, 1.0), seed, Motion::Still, fbm(hurst, 2, 1.0), &never).unwrap();
            let got = slope(&plane);
            assert!((got + 2.0 * hurst + 2.0).abs() < 0.1, "{hurst}: {got}");
            let volume = synthesize(cube(64), seed, Motion::Still, fbm(hurst, 3, 1.0), &never).unwrap();
            let got = slope(&volume);
            assert!((got + 2.0 * hurst + 3.0).abs() < 0.1, "{hurst}: {got}");
        }
    }

    #[test]
    fn variance_is_the_integral_of_the_spectrum() {
        let frame = flat(128, 2.0);
        let expected = deviation(&frame, markov(3.0), &never).unwrap();
        let runs = 40;
        let mean = (0..runs)
            .map(|seed| synthesize(frame, seed, Motion::Still, markov(3.0), &never).unwrap().moments().1)
            .sum::<f64>()
            / runs as f64;
        assert!((mean / (expected * expected) - 1.0).abs() < 0.03, "{mean} {expected}");
    }

    #[test]
    fn finer_grids_have_the_same_waves() {
        // Band-limited, so that the coarse grid has all of it.
        let band = |k: [f64; 3]| if length(k) < 10.0 { 1.0 } else { 0.0 };
        let coarse = synthesize(flat(32, 1.0), 9, Motion::Still, band, &never).unwrap();
        let fine = synthesize(flat(128, 1.0), 9, Motion::Still, band, &never).unwrap();
        for z in 0..32 {
            for x in 0..32 {
                let (a, b) = (coarse.values[z * 32 + x], fine.values[4 * z * 128 + 4 * x]);
                assert!((a - b).abs() < 1e-10);
            }
        }
    }

    #[test]
    fn the_sea_is_as_rough_as_its_wind() {
        for (speed, focus) in [(6.0, 0.0), (10.0, 2.0), (14.0, 8.5)] {
            let wind = Wind { speed, direction: 0.6, focus };
            let frame = flat(512, 20.0 * speed * speed);
            let grid = deviation(&frame, wind.spectrum(), &never).unwrap();
            // The shortest waves are missing.
            assert!((grid / wind.deviation() - 1.0).abs() < 0.02, "{grid} {}", wind.deviation());
        }
        // Published: about 2.5 metres of significant height at 10 metres a second.
        let high = 4.0 * Wind { speed: 10.0, direction: 0.0, focus: 2.0 }.deviation();
        assert!((high - 2.46).abs() < 0.05, "{high}");
    }

    #[test]
    fn waves_travel_with_the_wind_at_their_own_speed() {
        // Only one wave, along z.
        let length_of_wave = 16.0;
        let one = move |k: [f64; 3]| {
            let on = (k[2] - 1.0 / length_of_wave).abs() < 1e-6 && k[0].abs() < 1e-6;
            if on { 1000.0 } else { 0.0 }
        };
        let frame = flat(64, 64.0);
        let speed = (GRAVITY * length_of_wave / TAU).sqrt();
        let at = |t: f64| synthesize(frame, 3, Motion::DeepWater(t), one, &never).unwrap().values;
        // In the time of three spacings the wave has moved by three samples.
        let (before, after) = (at(0.0), at(3.0 / speed));
        for z in 3..64 {
            assert!((after[z * 64] - before[(z - 3) * 64]).abs() < 1e-9);
        }
        assert!(before.iter().any(|v| v.abs() > 0.1));
    }

    #[test]
    fn impossible_spectra_are_refused() {
        let frame = Frame { size: [48, 1, 32], ..flat(32, 1.0) };
        let got = synthesize(frame, 1, Motion::Still, markov(1.0), &never);
        assert_eq!(got, Err(Failure::Power(48)));
        let negative = synthesize(flat(8, 1.0), 1, Motion::Still, |k| k[0], &never);
        assert!(matches!(negative, Err(Failure::Spectrum { .. })));
        let stopped = synthesize(flat(8, 1.0), 1, Motion::Still, markov(1.0), &|| true);
        assert_eq!(stopped, Err(Failure::Cancelled));
    }
}
