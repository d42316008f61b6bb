//! Plain sums of octaves, with early termination.
//!
//! Over a wide box the jet of a fine octave says no more than the range of the noise does, and the
//! same holds for all octaves that are finer still. There the sum stops: what is left is somewhere
//! within the sum of the remaining amplitudes. The decision is made for each lane of a batch by
//! itself, so that batches equal their lanes bit for bit.

use super::fractal::{Model, Term, Weight};
use super::shape::{Modulate, Ridge};
use crate::num::{Interval, Kernel, Number};

fn is_one(r: Interval) -> bool {
    r == Interval::point(1.0)
}

fn is_zero(r: Interval) -> bool {
    r == Interval::point(0.0)
}

/// `sum a_i s_i` where the signal `s_i` is the octave, or the ridges folded from it. Octaves that
/// are too fine for the footprint fade to their mean, so that distant relief keeps its height.
pub(super) fn sum<T: Number>(model: Model, terms: &[Term], p: [&T; 3], footprint: Option<&T>) -> T {
    let mean = model.mean();
    let reach = p.map(|p| p.range().rad()).into_iter().fold(0.0, f64::max);
    let mut total = T::constant(mean * amplitudes(terms));
    let mut ended: Option<Ended<T>> = None;
    for (i, term) in terms.iter().enumerate() {
        let weight = term.weight(footprint);
        if matches!(weight, Weight::Gone) {
            break;
        }
        let blind = term.blind_from();
        if reach >= blind
            && let Some(tail) = T::somewhere(tail(model, &terms[i..]))
        {
            let now = Ended::next(ended, blind, p, &weight, || total.add(&tail));
            if is_one(now.over.range()) {
                return now.total;
            }
            ended = Some(now);
        }
        let noise = T::kernel(&term.octave, p);
        let signal = match model {
            Model::Ridged => T::lift(&Ridge, [&noise]).shift(-mean),
            _ => noise,
        };
        total = match weight {
            Weight::Share(w) => {
                let faded = T::lift(&Modulate { base: 0.0, gain: 1.0 }, [&w, &signal]);
                let present = T::choose(&w, is_one, &signal, &faded);
                T::choose(&w, is_zero, &total, &total.add(&present.scale(term.amplitude)))
            }
            _ => total.add(&signal.scale(term.amplitude)),
        };
    }
    match ended {
        Some(ended) => T::choose(&ended.over, is_one, &ended.total, &total),
        None => total,
    }
}

fn amplitudes(terms: &[Term]) -> f64 {
    terms.iter().map(|t| t.amplitude).sum()
}

/// Where the sum of these octaves, less their means, is for certain.
fn tail(model: Model, terms: &[Term]) -> Interval {
    let signal = match model {
        Model::Ridged => Interval::new(-model.mean(), 1.0 - model.mean()),
        _ => Interval::radius(terms.iter().map(|t| t.octave.bounds().range).fold(0.0, f64::max)),
    };
    // Means and amplitudes are rounded; a faded signal lies between zero and the whole one.
    signal.hull(Interval::point(0.0)) * (amplitudes(terms) * (1.0 + 1e-12))
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
    /// Ends the lanes that are at least `blind` wide on some axis and not faded out already.
    fn next(before: Option<Self>, blind: f64, p: [&T; 3], weight: &Weight<T>, close: impl Fn() -> T) -> Self {
        let before = before.unwrap_or_else(|| Ended { over: T::constant(0.0), total: T::constant(0.0) });
        let one = T::constant(1.0);
        let mut over = before.over.clone();
        for axis in p {
            over = T::choose(axis, |r| r.rad() >= blind, &one, &over);
        }
        if let Weight::Share(w) = weight {
            over = T::choose(w, is_zero, &before.over, &over);
        }
        let closed = T::choose(&over, is_one, &close(), &before.total);
        Ended { total: T::choose(&before.over, is_one, &before.total, &closed), over }
    }
}
