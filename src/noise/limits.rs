//! What is known of a fractal over all of space: its range, and bounds on its derivatives.
//!
//! Bounds of sums and products follow from those of the octaves by the rules of calculus. A fade
//! `w(s)` is no steeper than `3 / gone`, so a footprint whose own slope is `l` adds `3 l / gone` times
//! the height of the octave; an exponent that varies adds `i ln r` times its slope and the octave's
//! amplitude, height included.

use super::fractal::{Fractal, Term};
use super::model::Combination;
use crate::num::{Bounds, Class, Interval, Kernel};

/// What is known of the arguments of a fractal besides the point.
#[derive(Clone, Copy, Debug, Default)]
pub struct Surroundings {
    /// Lipschitz bound of the footprint; 0 where it is the same everywhere.
    pub footprint: f64,
    /// Range and Lipschitz bound of the exponent, where it is not the recipe's.
    pub hurst: Option<(Interval, f64)>,
}

/// Sums here round to nearest.
const ROUND_UP: f64 = 1.0 + 1e-12;

const ZERO: Bounds = Bounds { range: 0.0, lipschitz: 0.0, hessian: 0.0, third: 0.0 };

impl Fractal {
    /// The values that the fractal can take, whatever the footprint.
    pub fn range(&self) -> Interval {
        self.range_given(&Surroundings::default())
    }

    /// The same with an exponent that varies.
    pub fn range_given(&self, around: &Surroundings) -> Interval {
        let recipe = self.recipe();
        let (mut total, mut weight) = (Interval::point(0.0), Interval::point(1.0));
        for (k, term) in self.terms.iter().enumerate() {
            let a = term.amplitudes(around);
            let signal = recipe.model.signal.range(&term.octave.bounds());
            let level = a * (signal + Interval::point(recipe.offset));
            total = match recipe.model.combination {
                Combination::Sum => total + a * signal,
                Combination::Altitude1 if k == 0 => level,
                Combination::Altitude1 => total * (Interval::point(1.0) + level),
                Combination::Altitude2 => {
                    let product = weight * level;
                    weight = Interval::new(product.lo.clamp(0.0, 1.0), product.hi.clamp(0.0, 1.0));
                    total + weight
                }
            };
        }
        // Means are sampled, and the last digits of the points' arithmetic differ from those here.
        total + Interval::radius(1e-12 * total.mag())
    }

    /// Bounds over all of space, without a footprint. Second derivatives of models with creases are
    /// unbounded there.
    pub fn bounds(&self) -> Bounds {
        self.bounds_given(&Surroundings::default())
    }

    /// The same with a footprint or an exponent that varies in space.
    pub fn bounds_given(&self, around: &Surroundings) -> Bounds {
        let recipe = self.recipe();
        let (mut total, mut weight) = (ZERO, Bounds { range: 1.0, ..ZERO });
        for (k, term) in self.terms.iter().enumerate() {
            let (a, signal) = (term.amplitude_bounds(around), self.signal_bounds(term, around));
            let level = multiply(a, Bounds { range: signal.range + recipe.offset.abs(), ..signal });
            total = match recipe.model.combination {
                Combination::Sum => plus(total, multiply(a, signal)),
                Combination::Altitude1 if k == 0 => level,
                Combination::Altitude1 => multiply(total, Bounds { range: 1.0 + level.range, ..level }),
                Combination::Altitude2 => {
                    weight = multiply(weight, level);
                    weight.range = weight.range.min(1.0);
                    plus(total, weight)
                }
            };
        }
        let varies = around.footprint != 0.0 || around.hurst.is_some_and(|(_, slope)| slope != 0.0);
        let smooth = self.class() == Class::C2 && !varies;
        let up = |b: f64| if b.is_nan() { f64::INFINITY } else { b * ROUND_UP };
        Bounds {
            range: self.range_given(around).mag(),
            lipschitz: up(total.lipschitz),
            hessian: if smooth { up(total.hessian) } else { f64::INFINITY },
            third: if smooth { up(total.third) } else { f64::INFINITY },
        }
    }

    /// Bounds of an octave's signal as it fades.
    fn signal_bounds(&self, term: &Term, around: &Surroundings) -> Bounds {
        let noise = term.octave.bounds();
        let signal = self.recipe().model.signal;
        let own = signal.bounds(&noise);
        let height = (signal.range(&noise) - Interval::point(self.mean)).mag();
        let fading =
            if around.footprint == 0.0 { 0.0 } else { height * 3.0 * around.footprint / term.fade.gone };
        Bounds { lipschitz: own.lipschitz + fading, ..own }
    }
}

impl Term {
    /// The amplitudes that the octave can have.
    fn amplitudes(&self, around: &Surroundings) -> Interval {
        match around.hurst {
            None => Interval::point(self.amplitude),
            Some((h, _)) => crate::num::Number::lift(&self.gain, [&h]),
        }
    }

    fn amplitude_bounds(&self, around: &Surroundings) -> Bounds {
        let range = self.amplitudes(around).mag();
        let slope = around.hurst.map_or(0.0, |(_, slope)| slope);
        let lipschitz = if slope == 0.0 { 0.0 } else { self.gain.rate.abs() * range * slope };
        Bounds { range, lipschitz, ..ZERO }
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
