//! Fractals: sums and cascades of octaves of a noise, with level of detail.
//!
//! Octave `i` is the noise at `r^i` times the frequency (`r` the *lacunarity*) and `a_i = r^(-i H)`
//! times the amplitude (`H` the *hurst* exponent; the fractal dimension of the graph falls with it).
//! With `q_i` the signal of an octave and the offset `xi`, the models are (Gamito 2009, 3.3)
//!
//! ```text
//! fbm         sum a_i q_i                                      rescale-and-add (3.40)
//! ridged      sum a_i q_i                    with ridges       Musgrave
//! altitude1   f_i = f_(i-1) (1 + a_i (q_i + xi)),  f_0 = q_0 + xi                       (3.44)
//! altitude2   sum w_i,  w_i = clamp(a_i w_(i-1) (q_i + xi), 0, 1),  w_(-1) = 1          (3.45)
//! ```
//!
//! where `q_i` is the noise itself, or for ridges `max(1 - |noise|, 0)^2`.
//!
//! **Level of detail.** Gradient noise holds its power below about 1.25 cycles a lattice cell (its
//! upper -20 dB edge), which takes 2.5 samples a cell to represent. So an octave is gone where a
//! footprint (the size of a pixel at the point) spans 1/2.5 of its cells, is whole where it spans
//! half of that, and fades smoothly between (`shape::Fade`); nothing pops as a camera approaches. It
//! fades to its mean, not to zero, so that distant relief keeps its height.
//!
//! **Work saved.** An octave whose weight is zero is not evaluated. Nor is one whose cells are so
//! small against a box that its jet could say nothing that its bounds do not (`Centred::blind`):
//! the fine octaves of a fractal over a large box cost next to nothing, and a plain sum ends there
//! (`sum.rs`).

use super::Noise;
use super::cascade::{cascade, product};
use super::octave::{Octave, Placement};
use super::shape::{Fade, Ridge};
use super::sum::sum;
use crate::num::{Bounds, Class, Interval, Kernel, Number, Real, mix};
use std::hash::{Hash, Hasher};
use std::sync::Arc;

/// How octaves combine; see the module text.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Model {
    /// Sum of octaves; fractional Brownian motion.
    Fbm,
    /// Sum of octaves folded into ridges.
    Ridged,
    /// Rough peaks on a plain: roughness grows with altitude.
    Altitude1,
    /// Smooth valleys at all altitudes: roughness follows the coarser octaves.
    Altitude2,
}

impl Model {
    /// Every model.
    pub const ALL: &'static [Model] = &[Model::Fbm, Model::Ridged, Model::Altitude1, Model::Altitude2];

    /// Name in scripts.
    pub fn name(self) -> &'static str {
        match self {
            Model::Fbm => "fbm",
            Model::Ridged => "ridged",
            Model::Altitude1 => "altitude1",
            Model::Altitude2 => "altitude2",
        }
    }

    /// One sentence of documentation.
    pub fn doc(self) -> &'static str {
        match self {
            Model::Fbm => "Sum of octaves: fractional Brownian motion.",
            Model::Ridged => "Sum of octaves folded into sharp ridges.",
            Model::Altitude1 => "Octaves multiplied: rough peaks on a plain.",
            Model::Altitude2 => "Octaves weighted by the coarser ones: rough heights, smooth valleys.",
        }
    }

    /// The value that an octave's signal has on average.
    pub(super) fn mean(self) -> f64 {
        match self {
            Model::Fbm | Model::Altitude1 | Model::Altitude2 => 0.0,
            Model::Ridged => Ridge::MEAN,
        }
    }
}

/// The parameters of a fractal. Equal when equal bit for bit.
#[derive(Clone, Copy, Debug)]
pub struct Recipe {
    /// The coarsest octave.
    pub noise: Noise,
    /// How octaves combine.
    pub model: Model,
    /// Number of octaves, 1 to 32.
    pub octaves: u32,
    /// Ratio of the frequencies of successive octaves, above 1 and up to 16. A little off 2 keeps
    /// features of different octaves from lining up.
    pub lacunarity: f64,
    /// Exponent of the amplitudes, 0 to 2.
    pub hurst: f64,
    /// Added to the noise in the altitude models, -4 to 4; 0.6 makes gradient noise nearly positive.
    pub offset: f64,
    /// Whether every octave is turned and shifted at random, which hides the lattice.
    pub rotate: bool,
}

impl Recipe {
    fn identity(&self) -> (Noise, Model, u32, [u64; 3], bool) {
        let bits = [self.lacunarity, self.hurst, self.offset].map(f64::to_bits);
        (self.noise, self.model, self.octaves, bits, self.rotate)
    }

    /// Whether octaves of a noise that repeats fit into its period; `Err` says what they need.
    pub fn tiles(&self) -> Result<(), &'static str> {
        if self.rotate {
            Err("octaves that are turned do not repeat: set rotate to false")
        } else if self.lacunarity.fract() != 0.0 {
            Err("octaves repeat together if the lacunarity is a whole number, such as 2")
        } else {
            Ok(())
        }
    }

    /// Names the first parameter that is out of range.
    pub fn validate(&self) -> Result<(), Invalid> {
        let checks = [
            (
                "frequency",
                self.noise.frequency,
                "from 1e-12 to 1e12",
                (1e-12..=1e12).contains(&self.noise.frequency),
            ),
            ("octaves", f64::from(self.octaves), "from 1 to 32", (1..=32).contains(&self.octaves)),
            (
                "lacunarity",
                self.lacunarity,
                "above 1 and up to 16",
                self.lacunarity > 1.0 && self.lacunarity <= 16.0,
            ),
            ("hurst", self.hurst, "from 0 to 2", (0.0..=2.0).contains(&self.hurst)),
            ("offset", self.offset, "from -4 to 4", (-4.0..=4.0).contains(&self.offset)),
        ];
        match checks.into_iter().find(|(.., fine)| !fine) {
            Some((field, value, allowed, _)) => Err(Invalid { field, value, allowed }),
            None => Ok(()),
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

/// A parameter of a fractal that is out of range.
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

/// A fractal, ready to evaluate. Cheap to clone; equal when its recipe is.
#[derive(Clone, Debug)]
pub struct Fractal {
    recipe: Recipe,
    terms: Arc<[Term]>,
}

impl PartialEq for Fractal {
    fn eq(&self, other: &Self) -> bool {
        self.recipe == other.recipe
    }
}

impl Eq for Fractal {}

impl Hash for Fractal {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.recipe.hash(state);
    }
}

/// An octave with its amplitude and the way it fades.
#[derive(Clone, Copy, Debug)]
pub(super) struct Term {
    pub octave: Octave,
    pub amplitude: f64,
    fade: Fade,
}

/// How much of an octave a footprint leaves.
pub(super) enum Weight<T> {
    /// All of it.
    Whole,
    /// None of it, nor of any finer one.
    Gone,
    /// A share from 0 to 1; in a batch some lanes may still be whole, or gone.
    Share(T),
}

/// Lattice cells that a footprint may span before an octave is gone.
const GONE: f64 = 1.0 / 2.5;

impl Term {
    fn new(recipe: &Recipe, i: u32) -> Term {
        let Recipe { noise, lacunarity, hurst, rotate, .. } = *recipe;
        // The coarsest octave keeps the noise's own seed: one octave is the noise itself.
        let seed = noise.lattice.seed;
        let seed = if i == 0 { seed } else { mix(seed ^ mix(u64::from(i))) };
        let frequency = noise.frequency * Real::powi(lacunarity, i as i32);
        Term {
            octave: Octave {
                noise: noise.seeded(seed).at_frequency(frequency),
                placement: rotate.then(|| Placement::random(seed)),
            },
            amplitude: libm::pow(lacunarity, -f64::from(i) * hurst),
            fade: Fade { gone: GONE / frequency },
        }
    }

    /// What a footprint leaves of the octave.
    pub(super) fn weight<T: Number>(&self, footprint: Option<&T>) -> Weight<T> {
        let Some(s) = footprint else { return Weight::Whole };
        match self.fade.plateau(s.range()) {
            Some(0.0) => Weight::Gone,
            Some(_) => Weight::Whole,
            None => Weight::Share(T::lift(&self.fade, [s])),
        }
    }
}

impl Fractal {
    /// Prepares the octaves.
    pub fn new(recipe: Recipe) -> Result<Fractal, Invalid> {
        recipe.validate()?;
        let terms = (0..recipe.octaves).map(|i| Term::new(&recipe, i)).collect();
        Ok(Fractal { recipe, terms })
    }

    /// The parameters.
    pub fn recipe(&self) -> &Recipe {
        &self.recipe
    }

    /// The fractal at `p`, for any kind of number. With a footprint, the size of a pixel at `p` in
    /// the same unit, octaves too fine for it fade out.
    pub fn eval<T: Number>(&self, p: [&T; 3], footprint: Option<&T>) -> T {
        match self.recipe.model {
            Model::Fbm | Model::Ridged => sum(self.recipe.model, &self.terms, p, footprint),
            Model::Altitude1 => product(self.recipe.offset, &self.terms, p, footprint),
            Model::Altitude2 => cascade(self.recipe.offset, &self.terms, p, footprint),
        }
    }

    /// Continuity class. A footprint that varies in space makes it at most C1.
    pub fn class(&self) -> Class {
        match self.recipe.model {
            Model::Fbm | Model::Altitude1 => self.recipe.noise.class(),
            Model::Ridged | Model::Altitude2 => Class::C0,
        }
    }

    /// The values that the fractal can take.
    pub fn range(&self) -> Interval {
        let r = self.bounds().range;
        match self.recipe.model {
            Model::Fbm | Model::Altitude1 => Interval::radius(r),
            Model::Ridged | Model::Altitude2 => Interval::new(0.0, r),
        }
    }

    /// Bounds over all of space, without a footprint. Second derivatives of the creased models are
    /// unbounded on their creases.
    pub fn bounds(&self) -> Bounds {
        let model = self.recipe.model;
        let zero = Bounds { range: 0.0, lipschitz: 0.0, hessian: 0.0, third: 0.0 };
        let mut total = zero;
        let mut weight = Bounds { range: 1.0, ..zero };
        for (i, term) in self.terms.iter().enumerate() {
            let (a, octave) = (term.amplitude, term.octave.bounds());
            let positive = Bounds { range: octave.range + self.recipe.offset.abs(), ..octave };
            total = match model {
                Model::Fbm => plus(total, times(a, octave)),
                Model::Ridged => {
                    let folded = Bounds { range: 1.0, lipschitz: 2.0 * octave.lipschitz, ..octave };
                    plus(total, times(a, folded))
                }
                Model::Altitude1 if i == 0 => positive,
                Model::Altitude1 => {
                    let factor = times(a, positive);
                    multiply(total, Bounds { range: 1.0 + factor.range, ..factor })
                }
                Model::Altitude2 => {
                    weight = multiply(weight, times(a, positive));
                    weight.range = weight.range.min(1.0);
                    plus(total, weight)
                }
            };
        }
        // The sums above round to nearest.
        let up = times(1.0 + 1e-12, total);
        match self.class() {
            Class::C2 => up,
            Class::Jump | Class::C0 | Class::C1 => {
                Bounds { hessian: f64::INFINITY, third: f64::INFINITY, ..up }
            }
        }
    }
}

fn plus(a: Bounds, b: Bounds) -> Bounds {
    Bounds {
        range: a.range + b.range,
        lipschitz: a.lipschitz + b.lipschitz,
        hessian: a.hessian + b.hessian,
        third: a.third + b.third,
    }
}

fn times(k: f64, a: Bounds) -> Bounds {
    Bounds { range: k * a.range, lipschitz: k * a.lipschitz, hessian: k * a.hessian, third: k * a.third }
}

/// Bounds of a product, by the product rule.
fn multiply(a: Bounds, b: Bounds) -> Bounds {
    Bounds {
        range: a.range * b.range,
        lipschitz: a.range * b.lipschitz + a.lipschitz * b.range,
        hessian: a.range * b.hessian + 2.0 * a.lipschitz * b.lipschitz + a.hessian * b.range,
        third: a.range * b.third
            + 3.0 * (a.lipschitz * b.hessian + a.hessian * b.lipschitz)
            + a.third * b.range,
    }
}
