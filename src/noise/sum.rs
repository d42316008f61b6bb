//! Plain sums of octaves, with early termination.
//!
//! Over a wide box the jet of a fine octave says no more than the range of the noise does, and the
//! same holds for all octaves that are finer still. There the sum stops: what is left is somewhere
//! within the sum of the remaining amplitudes, each times what the footprint leaves of it. The
//! decision is made for each lane of a batch by itself, so that batches equal their lanes bit for bit.

use super::bundle::Bundle;
use super::fractal::{Fractal, Given, Term, Weight, is_one, is_zero};
use super::shape::{Modulate, Remaining};
use crate::num::{Interval, Kernel, Number};

/// `sum a_i q_i` with the signals `q_i` of octaves. Octaves that are too fine for the footprint fade
/// to their mean, so that distant relief keeps its height. Written to `total`.
pub(super) fn sum<T: Number>(f: &Fractal, given: &Given<'_, T>, total: &mut T) {
    let Given { point: p, footprint, hurst } = *given;
    if hurst.is_none()
        && let Some(sum) = T::pointwise(&Bundle::new(f), p, footprint)
    {
        *total = sum;
        return;
    }
    let means = if hurst.is_none() { f.mean * amplitudes(&f.terms) } else { 0.0 };
    let reach = p.map(|p| p.range().rad()).into_iter().fold(0.0, f64::max);
    // The sum is the first octave then, once that is there. (With a footprint, other lanes may have lost it.)
    let is_plain = means == 0.0 && hurst.is_none() && footprint.is_none();
    if !is_plain {
        *total = T::constant(means);
    }
    let mut room: Option<T> = None;
    let mut ended: Option<Ended<T>> = None;
    for (i, term) in f.terms.iter().enumerate() {
        let weight = term.weight(footprint);
        if matches!(weight, Weight::Gone) {
            if hurst.is_none() || f.mean == 0.0 {
                break;
            }
            *total = without(f, term, total, hurst);
            continue;
        }
        let blind = term.blind_from();
        if reach >= blind
            && hurst.is_none()
            && let Some(ending) = Ended::ending(ended.as_ref(), blind, p, &weight)
            && let Some(tail) = tail(f, &f.terms[i..], footprint)
        {
            let sum = if is_plain && i == 0 { tail } else { total.add(&tail) };
            let now = Ended::after(ended, &ending, &sum);
            if is_one(now.over.range()) {
                *total = now.total;
                return;
            }
            ended = Some(now);
        }
        if is_plain && i == 0 {
            T::kernel_to(&term.octave, p, total);
            f.deviate(total);
            if term.amplitude != 1.0 {
                *total = total.scale(term.amplitude);
            }
            continue;
        }
        let noise = room.get_or_insert_with(|| T::constant(0.0));
        T::kernel_to(&term.octave, p, noise);
        f.deviate(noise);
        match weight {
            Weight::Share(w) => {
                let faded = T::lift(&Modulate::PRODUCT, [&w, noise]);
                let present = T::choose(&w, is_one, noise, &faded);
                let without = without(f, term, total, hurst);
                add(f, term, total, &present, hurst);
                *total = T::choose(&w, is_zero, &without, total);
            }
            _ => add(f, term, total, noise, hurst),
        }
    }
    if let Some(ended) = ended {
        *total = T::choose(&ended.over, is_one, &ended.total, total);
    }
}

/// Adds an octave, of which the deviation from the mean is given. The means of octaves whose amplitudes are numbers are in
/// the sum from the start.
fn add<T: Number>(f: &Fractal, term: &Term, total: &mut T, deviation: &T, hurst: Option<&T>) {
    match hurst {
        None => total.add_scaled(deviation, term.amplitude),
        Some(_) if f.mean == 0.0 => *total = total.add(&term.amplified(deviation, hurst)),
        Some(_) => *total = total.add(&term.amplified(&deviation.shift(f.mean), hurst)),
    }
}

/// The sum with an octave of which nothing but its mean is left.
fn without<T: Number>(f: &Fractal, term: &Term, total: &T, hurst: Option<&T>) -> T {
    if hurst.is_none() || f.mean == 0.0 {
        total.clone()
    } else {
        total.add(&term.amplified(&T::constant(f.mean), hurst))
    }
}

pub(super) fn amplitudes(terms: &[Term]) -> f64 {
    terms.iter().map(|t| t.amplitude).sum()
}

/// Where the sum of these octaves, less their means, is for certain. With the footprint it shrinks
/// continuously to nothing.
fn tail<T: Number>(f: &Fractal, terms: &[Term], footprint: Option<&T>) -> Option<T> {
    // Octaves of a noise have one range; those of its slopes have ranges that grow, so that the first
    // and the last hold the others.
    let range = |term: &Term| f.recipe().model.signal.range(&term.octave.bounds());
    let signal = range(terms.first()?).hull(range(terms.last()?)) - Interval::point(f.mean);
    // Means and amplitudes are rounded; a faded signal lies between zero and the whole one.
    let signal = signal.hull(Interval::point(0.0)) * (1.0 + 1e-12);
    match footprint {
        None => T::somewhere(signal * amplitudes(terms)),
        Some(s) => {
            let whole = T::somewhere(signal)?;
            let left = T::lift(&Remaining { terms }, [s]);
            Some(T::lift(&Modulate::PRODUCT, [&left, &whole]))
        }
    }
}

impl Term {
    /// Half the width of a box from which on the octave's jet says nothing: its Lipschitz bound
    /// spans the whole range there.
    fn blind_from(&self) -> f64 {
        let b = self.octave.bounds();
        2.0 * b.range / b.lipschitz
    }
}

/// The lanes whose sums have ended early.
struct Ended<T> {
    /// 1 in those lanes, else 0.
    over: T,
    /// Their sums.
    total: T,
}

impl<T: Number> Ended<T> {
    /// 1 in the lanes that end now, because they are at least `blind` wide on some axis and not faded out already; `None` if
    /// there are none.
    fn ending(before: Option<&Self>, blind: f64, p: [&T; 3], weight: &Weight<T>) -> Option<T> {
        let (zero, one) = (T::constant(0.0), T::constant(1.0));
        let mut now = zero.clone();
        for axis in p {
            now = T::choose(axis, |r| r.rad() >= blind, &one, &now);
        }
        if let Weight::Share(w) = weight {
            now = T::choose(w, is_zero, &zero, &now);
        }
        if let Some(before) = before {
            now = T::choose(&before.over, is_one, &zero, &now);
        }
        (!is_zero(now.range())).then_some(now)
    }

    /// Those that ended `before`, and those that end now with a sum.
    fn after(before: Option<Self>, ending: &T, sum: &T) -> Self {
        let (zero, one) = (T::constant(0.0), T::constant(1.0));
        let before = before.unwrap_or_else(|| Ended { over: zero.clone(), total: zero });
        Ended {
            total: T::choose(ending, is_one, sum, &before.total),
            over: T::choose(ending, is_one, &one, &before.over),
        }
    }
}
