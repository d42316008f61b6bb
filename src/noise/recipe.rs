//! The parameters of a fractal, and what they must be.

use super::model::{Model, Signal};
use super::{Noise, Part};
use crate::num::Real;
use std::hash::{Hash, Hasher};
use std::ops::RangeInclusive;
use std::sync::Arc;

/// How amplitudes fall from octave to octave: by `r^-H` with the lacunarity `r` and an exponent `H`,
/// the *Hurst exponent*, which may differ between octaves (Haruyama and Barsky 1984).
///
/// The graph of a sum with `0 < H < 1` has dimension `3 - H` over the plane; beyond that range sums
/// are still sums, smoother or rougher than any fractal.
#[derive(Clone, Debug)]
pub struct Hurst(Arc<[f64]>);

impl Hurst {
    /// One exponent for all octaves.
    pub fn uniform(h: f64) -> Hurst {
        Hurst(Arc::new([h]))
    }

    /// An exponent for each octave, from the coarsest on; the last one serves all that follow.
    pub fn octaves(h: &[f64]) -> Hurst {
        Hurst(h.into())
    }

    /// The exponents that were given.
    pub fn exponents(&self) -> &[f64] {
        &self.0
    }

    /// Amplitudes of octaves `first`, `first + 1`, ...: `r^(-i H)`, or the product of `r^(-H_j)` up
    /// to the octave; octave 0 of a uniform exponent has amplitude 1.
    pub(super) fn amplitudes(&self, lacunarity: f64, first: i32, count: u32) -> Vec<f64> {
        let at = |k: usize| self.0.get(k).or(self.0.last()).copied().unwrap_or(0.0);
        // A sum of exponents times one logarithm would do for both, but products of equal exponents
        // are kept as they are: they are what every picture so far was made of.
        let uniform = self.0.windows(2).all(|pair| pair[0].to_bits() == pair[1].to_bits());
        let mut total = f64::from(first) * at(0);
        (0..count)
            .map(|k| {
                if uniform {
                    return libm::pow(lacunarity, -f64::from(first + k as i32) * at(0));
                }
                if k > 0 {
                    total += at(k as usize);
                }
                libm::pow(lacunarity, -total)
            })
            .collect()
    }
}

impl PartialEq for Hurst {
    fn eq(&self, other: &Self) -> bool {
        self.0.iter().map(|h| h.to_bits()).eq(other.0.iter().map(|h| h.to_bits()))
    }
}

impl Eq for Hurst {}

impl Hash for Hurst {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.iter().for_each(|h| h.to_bits().hash(state));
    }
}

/// The parameters of a fractal. Equal when equal bit for bit.
#[derive(Clone, Debug)]
pub struct Recipe {
    /// Octave 0.
    pub noise: Noise,
    /// What is made of an octave, and how octaves combine.
    pub model: Model,
    /// The coarsest octave, -16 to 16; below 0, features larger than those of the noise are added.
    pub first: i32,
    /// Number of octaves, 1 to 32.
    pub octaves: u32,
    /// Ratio of the frequencies of successive octaves, above 1 and up to 16. A little off 2 keeps
    /// features of different octaves from lining up.
    pub lacunarity: f64,
    /// Exponents of the amplitudes, -2 to 4.
    pub hurst: Hurst,
    /// Added to the signal in the altitude models, -4 to 4; 0.6 makes gradient noise nearly positive.
    pub offset: f64,
    /// Whether every octave is turned and shifted at random, which hides the lattice.
    pub rotate: bool,
}

/// Cells after which a lattice can repeat, at most.
const LONGEST_PERIOD: u32 = 1 << 24;

impl Recipe {
    /// How many octaves there may be.
    pub const OCTAVES: RangeInclusive<i32> = 1..=32;
    /// Which octave may be the coarsest.
    pub const FIRST: RangeInclusive<i32> = -16..=16;
    /// Ratios of frequencies: above 1.
    pub const LACUNARITY: RangeInclusive<f64> = 1.000001..=16.0;
    /// Exponents of all octaves at once; that of a single octave may lie farther out.
    pub const HURST: RangeInclusive<f64> = 0.0..=2.0;
    /// What may be added to the signal.
    pub const OFFSET: RangeInclusive<f64> = -4.0..=4.0;

    /// Eight octaves with the lacunarity and the exponent of mountains.
    pub fn new(noise: Noise, model: Model) -> Recipe {
        Recipe {
            noise,
            model,
            first: 0,
            octaves: 8,
            lacunarity: 2.1,
            hurst: Hurst::uniform(0.9),
            offset: Recipe::offset_of(model.signal),
            rotate: false,
        }
    }

    /// The offset of altitude models unless said otherwise: folded signals are positive already.
    pub fn offset_of(signal: Signal) -> f64 {
        match signal {
            Signal::Plain => 0.6,
            Signal::Turbulent | Signal::Ridged => 0.0,
        }
    }

    #[allow(clippy::type_complexity)] // a list of everything there is
    fn identity(&self) -> (Noise, Model, i32, u32, [u64; 2], &Hurst, bool) {
        let bits = [self.lacunarity, self.offset].map(f64::to_bits);
        (self.noise, self.model, self.first, self.octaves, bits, &self.hurst, self.rotate)
    }

    /// Frequency of octave `i`.
    pub fn frequency(&self, i: i32) -> f64 {
        self.noise.frequency * Real::powi(self.lacunarity, i)
    }

    /// Cells after which octave `i` repeats, if the noise does: as far as the noise, which is
    /// `r^i` as many cells. Where those are too many to count, it repeats earlier by whole factors
    /// of `r`, so that the sum still repeats where it should. `None` if that is no whole number.
    fn period(&self, i: i32) -> Option<[u32; 3]> {
        let mut period = self.noise.lattice.period;
        let r = self.lacunarity as u32;
        for p in &mut period {
            for _ in 0..i.unsigned_abs() {
                if i > 0 && *p <= LONGEST_PERIOD / r {
                    *p *= r;
                } else if i < 0 {
                    *p = if *p % r == 0 { *p / r } else { return None };
                }
            }
        }
        Some(period)
    }

    /// The period of octave `i` of a recipe that [`tiles`](Self::tiles).
    pub(super) fn period_or_none(&self, i: i32) -> [u32; 3] {
        self.period(i).unwrap_or_default()
    }

    /// Whether octaves of the noise, if that repeats, fit into its period; `Err` names the parameter
    /// that does not let them, and says what it must be.
    pub fn tiles(&self) -> Result<(), (&'static str, &'static str)> {
        if self.noise.lattice.period == [0; 3] {
            return Ok(());
        }
        if self.rotate {
            return Err(("rotate", "octaves that are turned do not repeat: set rotate to false"));
        }
        if self.lacunarity.fract() != 0.0 && (self.first, self.octaves) != (0, 1) {
            let whole = "octaves repeat together if the lacunarity is a whole number, such as 2";
            return Err(("lacunarity", whole));
        }
        for i in (self.first..).take(self.octaves as usize) {
            let Some(period) = self.period(i) else {
                let fit = "the cells of coarser octaves fit into the period if it is a multiple of lacunarity^-first";
                return Err(("first", fit));
            };
            self.noise.kind.tiles(period).map_err(|must| ("first", must))?;
        }
        Ok(())
    }

    /// Names the first parameter that is out of range.
    pub fn validate(&self) -> Result<(), Invalid> {
        let frequency = self.noise.frequency;
        let (r, h) = (self.lacunarity, self.hurst.exponents());
        let wild = h.iter().copied().find(|h| !(-2.0..=4.0).contains(h));
        let folded = self.model != Model::FBM;
        let checks = [
            ("frequency", frequency, "from 1e-12 to 1e12", (1e-12..=1e12).contains(&frequency)),
            ("octaves", f64::from(self.octaves), "from 1 to 32", (1..=32).contains(&self.octaves)),
            ("first", f64::from(self.first), "from -16 to 16", (-16..=16).contains(&self.first)),
            ("lacunarity", r, "above 1 and up to 16", r > 1.0 && r <= 16.0),
            ("hurst", wild.unwrap_or(0.0), "from -2 to 4", wild.is_none()),
            ("hurst", h.len() as f64, "one to 32 exponents", (1..=32).contains(&h.len())),
            ("offset", self.offset, "from -4 to 4", (-4.0..=4.0).contains(&self.offset)),
            (
                "noise",
                f64::NAN,
                "a value, since slopes only add up",
                self.noise.part == Part::Value || !folded,
            ),
        ];
        if let Some((field, value, allowed, _)) = checks.into_iter().find(|(.., fine)| !fine) {
            return Err(Invalid { field, value, allowed });
        }
        match self.tiles() {
            Err((field, allowed)) => Err(Invalid { field, value: f64::NAN, allowed }),
            Ok(()) => Ok(()),
        }
    }
}

impl PartialEq for Recipe {
    fn eq(&self, other: &Self) -> bool {
        self.identity() == other.identity()
    }
}

impl Eq for Recipe {}

impl Hash for Recipe {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.identity().hash(state);
    }
}

/// A parameter that is out of range.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
#[error("`{field}` is {value}, but must be {allowed}")]
pub struct Invalid {
    /// The parameter.
    pub field: &'static str,
    /// What it was.
    pub value: f64,
    /// What it may be, in words.
    pub allowed: &'static str,
}
