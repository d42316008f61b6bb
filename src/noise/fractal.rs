//! Fractals: sums and cascades of octaves of a noise, with level of detail.
//!
//! Octave `i` is the noise at `r^i` times the frequency (`r` the *lacunarity*) and `a_i = r^(-i H)`
//! times the amplitude (`H` the *Hurst* exponent; the fractal dimension of the graph falls with it).
//! With `q_i` the signal of an octave (the noise, its absolute value, or a ridge along its zeros; see
//! `model.rs`) and the offset `xi`, octaves combine as (Gamito 2009, 3.3)
//!
//! ```text
//! sum         sum a_i q_i                                      rescale-and-add (3.40)
//! altitude1   f_i = f_(i-1) (1 + a_i (q_i + xi)),  first a_i (q_i + xi)                 (3.44)
//! altitude2   sum w_i,  w_i = clamp(a_i w_(i-1) (q_i + xi), 0, 1),  first w = 1         (3.45)
//! ```
//!
//! **Roughness.** `H` is one number, a number for each octave (`a_i` is then a product of `r^(-H_j)`),
//! or a field: a fractal takes an expression as a further argument and has `a_i = exp(-i ln r H(x))`,
//! whose derivatives follow from the chain rule like all others.
//!
//! **Level of detail.** A noise states the frequency above which it has no power to speak of, in
//! cycles a lattice cell ([`Basis::band`](super::Basis::band)); a sample a pixel represents half a
//! cycle. So an octave is gone where a footprint (the size of a pixel at the point) spans more than
//! `1 / (2 band)` of its cells, is whole where it spans half of that, and fades smoothly between
//! (`shape::Fade`); nothing pops as a camera approaches. It fades to its mean, not to zero, so that
//! distant relief keeps its height (`mean.rs`).
//!
//! **Work saved.** Numbers that stand for points see all octaves of a sum at once (`bundle.rs`). Of
//! enclosures, an octave whose weight is zero is not evaluated. Nor is one whose cells are so small
//! against a box that its jet could say nothing that its bounds do not (`Centred::blind`): the fine
//! octaves of a fractal over a large box cost next to nothing, and a plain sum ends there (`sum.rs`).

use super::Part;
use super::cascade::{cascade, product};
use super::mean::mean;
use super::model::Combination;
use super::octave::{Octave, Placement};
use super::recipe::{Invalid, Recipe};
use super::shape::{Fade, Gain, Modulate};
use super::sum::sum;
use crate::num::{Class, Interval, Kernel, Number, mix};
use std::hash::{Hash, Hasher};
use std::sync::Arc;

/// A fractal, ready to evaluate. Cheap to clone; equal when its recipe is.
#[derive(Clone, Debug)]
pub struct Fractal {
    recipe: Recipe,
    pub(super) terms: Arc<[Term]>,
    /// The value that a signal has on average.
    pub(super) mean: f64,
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

/// What a fractal is a function of.
#[derive(Clone, Copy, Debug)]
pub struct Given<'a, T> {
    /// Where.
    pub point: [&'a T; 3],
    /// The size of a pixel there, in the same unit; octaves too fine for it fade out.
    pub footprint: Option<&'a T>,
    /// The exponent of the amplitudes there, in place of the recipe's.
    pub hurst: Option<&'a T>,
}

/// An octave with its amplitude and the way it fades.
#[derive(Clone, Copy, Debug)]
pub(super) struct Term {
    pub octave: Octave,
    pub amplitude: f64,
    /// The amplitude of an exponent `H` that varies.
    pub gain: Gain,
    pub fade: Fade,
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

impl Term {
    fn new(recipe: &Recipe, i: i32, amplitude: f64) -> Term {
        // Octave 0 keeps the noise's own seed: one octave is the noise itself.
        let mut noise = recipe.noise;
        if i != 0 {
            noise.lattice.seed = mix(noise.lattice.seed ^ mix(i64::from(i) as u64));
        }
        noise.lattice.period = recipe.period_or_none(i);
        noise.frequency = recipe.frequency(i);
        Term {
            octave: Octave { noise, placement: recipe.rotate.then(|| Placement::random(noise.lattice.seed)) },
            amplitude,
            gain: Gain { rate: f64::from(i) * libm::log(recipe.lacunarity) },
            fade: Fade { gone: 1.0 / (2.0 * noise.kind.band()) / noise.frequency },
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

    /// A number times the amplitude.
    pub(super) fn amplified<T: Number>(&self, x: &T, hurst: Option<&T>) -> T {
        match hurst {
            None if self.amplitude == 1.0 => x.clone(),
            None => x.scale(self.amplitude),
            Some(_) if self.gain.rate == 0.0 => x.clone(),
            Some(h) => T::lift(&Modulate::PRODUCT, [&T::lift(&self.gain, [h]), x]),
        }
    }
}

pub(super) fn is_one(r: Interval) -> bool {
    r == Interval::point(1.0)
}

pub(super) fn is_zero(r: Interval) -> bool {
    r == Interval::point(0.0)
}

impl Fractal {
    /// Prepares the octaves.
    pub fn new(recipe: Recipe) -> Result<Fractal, Invalid> {
        recipe.validate()?;
        let amplitudes = recipe.hurst.amplitudes(recipe.lacunarity, recipe.first, recipe.octaves);
        let terms = (recipe.first..).zip(amplitudes).map(|(i, a)| Term::new(&recipe, i, a)).collect();
        let mean = match recipe.noise.part {
            Part::Value => mean(&recipe.noise.kind, recipe.model.signal),
            // What a noise gains along an axis it loses again.
            Part::Slope(_) => 0.0,
        };
        Ok(Fractal { recipe, terms, mean })
    }

    /// How many octaves a footprint leaves something of.
    pub fn octaves_within(&self, footprint: f64) -> u32 {
        self.terms.iter().take_while(|term| !term.fade.is_gone(footprint)).count() as u32
    }

    /// The parameters.
    pub fn recipe(&self) -> &Recipe {
        &self.recipe
    }

    /// The fractal at `p`, for any kind of number. With a footprint, the size of a pixel at `p` in
    /// the same unit, octaves too fine for it fade out.
    pub fn eval<T: Number>(&self, p: [&T; 3], footprint: Option<&T>) -> T {
        self.eval_given(&Given { point: p, footprint, hurst: None })
    }

    /// The same, of everything that a fractal may be a function of.
    pub fn eval_given<T: Number>(&self, given: &Given<'_, T>) -> T {
        let mut out = T::constant(0.0);
        self.eval_to(given, &mut out);
        out
    }

    /// The same, written to `out`.
    pub fn eval_to<T: Number>(&self, given: &Given<'_, T>, out: &mut T) {
        match self.recipe.model.combination {
            Combination::Sum => sum(self, given, out),
            Combination::Altitude1 => *out = product(self, given),
            Combination::Altitude2 => *out = cascade(self, given),
        }
    }

    /// Makes the noise of an octave how far its signal is from its mean.
    #[inline]
    pub(super) fn deviate<T: Number>(&self, noise: &mut T) {
        self.recipe.model.signal.apply(noise);
        if self.mean != 0.0 {
            *noise = noise.shift(-self.mean);
        }
    }

    /// Continuity class, where the footprint does not vary in space. One that does leaves C1 at most.
    pub fn class(&self) -> Class {
        let signal = self.recipe.model.signal.class(self.recipe.noise.class());
        match self.recipe.model.combination {
            Combination::Sum | Combination::Altitude1 => signal,
            Combination::Altitude2 => signal.min(Class::C0),
        }
    }
}
