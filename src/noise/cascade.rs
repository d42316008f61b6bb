//! The two cascades whose statistics depend on altitude (thesis, 3.44 and 3.45; after Musgrave).
//!
//! ```text
//! first    f_i = f_(i-1) (1 + a_i (N_i + offset))
//! second   w_i = clamp(w_(i-1) a_i (N_i + offset), 0, 1),   f_i = f_(i-1) + w_i
//! ```
//!
//! The first is rough where it is high and flat near zero; the second has smooth valleys at every
//! altitude.

use super::fractal::{Term, Weight};
use super::shape::{Modulate, Saturate};
use crate::num::{Interval, Number};

/// The first cascade.
pub(super) fn product<T: Number>(offset: f64, terms: &[Term], p: [&T; 3], footprint: Option<&T>) -> T {
    let mut total: Option<T> = None;
    for term in terms {
        let signal = signal(term, p, footprint);
        total = Some(match total {
            None => signal.shift(offset),
            Some(total) => {
                let a = term.amplitude;
                T::lift(&Modulate { base: 1.0 + a * offset, gain: a }, [&total, &signal])
            }
        });
    }
    total.unwrap_or_else(|| T::constant(0.0))
}

/// The second cascade.
pub(super) fn cascade<T: Number>(offset: f64, terms: &[Term], p: [&T; 3], footprint: Option<&T>) -> T {
    let mut state: Option<(T, T)> = None;
    for term in terms {
        let signal = signal(term, p, footprint);
        state = Some(match state {
            None => {
                let weight = T::lift(&Saturate, [&signal.shift(offset)]);
                (weight.clone(), weight)
            }
            Some((total, weight)) => {
                let a = term.amplitude;
                let product = T::lift(&Modulate { base: a * offset, gain: a }, [&weight, &signal]);
                let weight = T::lift(&Saturate, [&product]);
                (total.add(&weight), weight)
            }
        });
    }
    state.map_or_else(|| T::constant(0.0), |(total, _)| total)
}

/// What an octave contributes, faded to zero where it is too fine; decided lane by lane.
fn signal<T: Number>(term: &Term, p: [&T; 3], footprint: Option<&T>) -> T {
    let whole = |r: Interval| r == Interval::point(1.0);
    let gone = |r: Interval| r == Interval::point(0.0);
    match term.weight(footprint) {
        Weight::Gone => T::constant(0.0),
        Weight::Whole => T::kernel(&term.octave, p),
        Weight::Share(w) => {
            let noise = T::kernel(&term.octave, p);
            let faded = T::lift(&Modulate { base: 0.0, gain: 1.0 }, [&w, &noise]);
            T::choose(&w, gone, &T::constant(0.0), &T::choose(&w, whole, &noise, &faded))
        }
    }
}
