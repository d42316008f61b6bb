//! The fractal models: what is made of an octave's noise, and how octaves combine.
//!
//! The two choices are independent. The signal `q` of an octave is the noise `N` itself, its
//! absolute value (*turbulence*, Perlin 1985: billows that meet in creases), or a ridge along its
//! zeros (Musgrave). Signals are added up, or form one of the two cascades in which detail depends
//! on altitude (Gamito 2009, 3.3.3, after Musgrave).

use super::shape::{Fold, Ridge};
use super::{Bounds, Class};
use crate::num::{Interval, Number};

/// What is made of an octave's noise.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Signal {
    /// The noise itself.
    #[default]
    Plain,
    /// Its absolute value: billows between creases.
    Turbulent,
    /// `max(1 - |N|, 0)^2`: ridges along its zeros.
    Ridged,
}

impl Signal {
    /// Every signal.
    pub const ALL: &'static [Signal] = &[Signal::Plain, Signal::Turbulent, Signal::Ridged];

    /// Name in scripts.
    pub const fn name(self) -> &'static str {
        match self {
            Signal::Plain => "plain",
            Signal::Turbulent => "turbulent",
            Signal::Ridged => "ridged",
        }
    }

    /// Makes a noise its signal.
    #[inline]
    pub(super) fn apply<T: Number>(self, noise: &mut T) {
        match self {
            Signal::Plain => {}
            Signal::Turbulent => *noise = T::lift(&Fold, [noise]),
            Signal::Ridged => *noise = T::lift(&Ridge, [noise]),
        }
    }

    /// Continuity class of the signal of a noise of a class.
    pub(super) fn class(self, noise: Class) -> Class {
        match self {
            Signal::Plain => noise,
            Signal::Turbulent | Signal::Ridged => noise.min(Class::C0),
        }
    }

    /// The values that the signal can have.
    pub(super) fn range(self, noise: &Bounds) -> Interval {
        match self {
            Signal::Plain => Interval::radius(noise.range),
            Signal::Turbulent => Interval::new(0.0, noise.range),
            Signal::Ridged => Interval::UNIT,
        }
    }

    /// Bounds of the signal, from those of the noise; second derivatives count only off the creases.
    pub(super) fn bounds(self, noise: &Bounds) -> Bounds {
        match self {
            Signal::Plain | Signal::Turbulent => *noise,
            Signal::Ridged => Bounds { range: 1.0, lipschitz: 2.0 * noise.lipschitz, ..*noise },
        }
    }
}

/// How octaves combine.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Combination {
    /// Their sum.
    #[default]
    Sum,
    /// Their product: roughness grows with altitude.
    Altitude1,
    /// The sum of their weights, each a product with the weight before: roughness follows the
    /// coarser octaves.
    Altitude2,
}

/// A fractal model.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub struct Model {
    /// What is made of an octave's noise.
    pub signal: Signal,
    /// How octaves combine.
    pub combination: Combination,
}

impl Model {
    /// Sum of octaves; fractional Brownian motion.
    pub const FBM: Model = Model::sum(Signal::Plain);
    /// Sum of the absolute values of octaves.
    pub const TURBULENCE: Model = Model::sum(Signal::Turbulent);
    /// Sum of octaves folded into ridges.
    pub const RIDGED: Model = Model::sum(Signal::Ridged);
    /// Rough peaks on a plain.
    pub const ALTITUDE1: Model = Model { signal: Signal::Plain, combination: Combination::Altitude1 };
    /// Smooth valleys at all altitudes.
    pub const ALTITUDE2: Model = Model { signal: Signal::Plain, combination: Combination::Altitude2 };

    /// The models that have names in scripts. The cascades take any signal besides.
    pub const NAMED: &'static [Model] =
        &[Model::FBM, Model::TURBULENCE, Model::RIDGED, Model::ALTITUDE1, Model::ALTITUDE2];

    const fn sum(signal: Signal) -> Model {
        Model { signal, combination: Combination::Sum }
    }

    /// The same of another signal.
    pub const fn of(self, signal: Signal) -> Model {
        Model { signal, ..self }
    }

    /// Every signal in every combination.
    pub fn all() -> impl Iterator<Item = Model> {
        let combinations = [Combination::Sum, Combination::Altitude1, Combination::Altitude2];
        combinations
            .into_iter()
            .flat_map(|combination| Signal::ALL.iter().map(move |&signal| Model { signal, combination }))
    }

    /// Name in scripts; the signal of a cascade is an option of its own.
    pub fn name(self) -> &'static str {
        match (self.combination, self.signal) {
            (Combination::Sum, Signal::Plain) => "fbm",
            (Combination::Sum, Signal::Turbulent) => "turbulence",
            (Combination::Sum, Signal::Ridged) => "ridged",
            (Combination::Altitude1, _) => "altitude1",
            (Combination::Altitude2, _) => "altitude2",
        }
    }
}
