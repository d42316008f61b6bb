//! The two cascades whose statistics depend on altitude (thesis, 3.44 and 3.45; after Musgrave).
//!
//! ```text
//! first    f_i = f_(i-1) (1 + a_i (q_i + offset))
//! second   w_i = clamp(w_(i-1) a_i (q_i + offset), 0, 1),   f_i = f_(i-1) + w_i
//! ```
//!
//! The first is rough where it is high and flat near zero; the second has smooth valleys at every
//! altitude. Octaves that are too fine for the footprint act with their mean: `q_i` is written as
//! the mean, which joins the offset, and a deviation, which fades.

use super::fractal::{Fractal, Given, Term, Weight, is_one, is_zero};
use super::shape::{Modulate, Saturate};
use crate::num::Number;

/// The first cascade.
pub(super) fn product<T: Number>(f: &Fractal, given: &Given<'_, T>) -> T {
    let level = f.recipe().offset + f.mean;
    let mut total: Option<T> = None;
    for term in f.terms.iter() {
        let signal = signal(f, term, given);
        total = Some(match (total, given.hurst) {
            (None, hurst) => term.amplified(&signal.shift(level), hurst),
            (Some(total), None) => {
                let a = term.amplitude;
                T::lift(&Modulate { base: 1.0 + a * level, gain: a }, [&total, &signal])
            }
            (Some(total), hurst) => {
                let factor = term.amplified(&signal.shift(level), hurst);
                T::lift(&Modulate { base: 1.0, gain: 1.0 }, [&total, &factor])
            }
        });
    }
    total.unwrap_or_else(|| T::constant(0.0))
}

/// The second cascade.
pub(super) fn cascade<T: Number>(f: &Fractal, given: &Given<'_, T>) -> T {
    let level = f.recipe().offset + f.mean;
    let mut state: Option<(T, T)> = None;
    for term in f.terms.iter() {
        let signal = signal(f, term, given);
        state = Some(match state {
            None => {
                let weight = T::lift(&Saturate, [&term.amplified(&signal.shift(level), given.hurst)]);
                (weight.clone(), weight)
            }
            Some((total, weight)) => {
                let product = match given.hurst {
                    None => {
                        let a = term.amplitude;
                        T::lift(&Modulate { base: a * level, gain: a }, [&weight, &signal])
                    }
                    hurst => {
                        let factor = term.amplified(&signal.shift(level), hurst);
                        T::lift(&Modulate::PRODUCT, [&weight, &factor])
                    }
                };
                let weight = T::lift(&Saturate, [&product]);
                (total.add(&weight), weight)
            }
        });
    }
    state.map_or_else(|| T::constant(0.0), |(total, _)| total)
}

/// How far an octave is from its mean, faded to zero where it is too fine; decided lane by lane.
fn signal<T: Number>(f: &Fractal, term: &Term, given: &Given<'_, T>) -> T {
    let whole = || {
        let mut noise = T::kernel(&term.octave, given.point);
        f.deviate(&mut noise);
        noise
    };
    match term.weight(given.footprint) {
        Weight::Gone => T::constant(0.0),
        Weight::Whole => whole(),
        Weight::Share(w) => {
            let signal = whole();
            let faded = T::lift(&Modulate::PRODUCT, [&w, &signal]);
            T::choose(&w, is_zero, &T::constant(0.0), &T::choose(&w, is_one, &signal, &faded))
        }
    }
}
