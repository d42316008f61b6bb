//! All octaves of a sum at once, for numbers that stand for points.
//!
//! The sum is a function of the point and of the footprint `s`, with the jet
//!
//! ```text
//! f   = base + sum a w(s) d(x)          d = q - mean, how far a signal is from its mean
//! f_x = sum a w d_x       f_s = sum a w' d      f_xx = sum a w d_xx   and so on
//! ```
//!
//! It is accumulated octave by octave in arrays that stay in the first-level cache, one batch at a
//! time, in order: the same additions that the octaves one by one would cost, but no intermediate
//! numbers, and one chain rule for all. A lane adds up its own octaves whatever its neighbours do.

use super::batches::{BATCH, batch};
use super::fractal::{Fractal, Term};
use super::model::Signal;
use super::shape::{Fade, Fold, Ridge};
use super::sum::amplitudes;
use crate::num::{Function, Jets, Jets4, Kernel, Order, Point4, Pointwise, widest};

/// The octaves of a sum.
pub(super) struct Bundle<'a> {
    terms: &'a [Term],
    signal: Signal,
    mean: f64,
    /// What the sum is where all octaves are at their means.
    base: f64,
}

impl<'a> Bundle<'a> {
    pub(super) fn new(f: &'a Fractal) -> Bundle<'a> {
        let base = f.mean * amplitudes(&f.terms);
        Bundle { terms: &f.terms, signal: f.recipe().model.signal, mean: f.mean, base }
    }

    /// The noise of an octave as the deviation of its signal.
    #[inline(always)]
    fn fold(&self, jets: Jets<'_>) {
        match self.signal {
            Signal::Plain if self.mean == 0.0 => {}
            Signal::Plain => jets.value.iter_mut().for_each(|v| *v += -self.mean),
            Signal::Turbulent => fold_by(&Fold, self.mean, jets),
            Signal::Ridged => fold_by(&Ridge, self.mean, jets),
        }
    }
}

/// What a footprint leaves of an octave, lane by lane.
#[allow(clippy::large_enum_variant)] // one at a time, on the stack of a loop
enum Share {
    Whole,
    Gone,
    /// Weights with their first and second derivatives.
    Part([[f64; BATCH]; 3]),
}

impl Share {
    #[inline(always)]
    fn new(fade: &Fade, footprint: Option<&[f64]>, order: Order) -> Share {
        let Some(s) = footprint else { return Share::Whole };
        // A footprint that is not a number passes neither test.
        if s.iter().all(|&s| fade.is_whole(s)) {
            return Share::Whole;
        }
        if s.iter().all(|&s| fade.is_gone(s)) {
            return Share::Gone;
        }
        let mut weights = [[0.0; BATCH]; 3];
        let [w, w1, w2] = &mut weights;
        for (i, &s) in s.iter().enumerate() {
            let (whole, gone) = (fade.is_whole(s), fade.is_gone(s));
            let flat = whole || gone;
            w[i] = if whole {
                1.0
            } else if gone {
                0.0
            } else {
                fade.value([s])
            };
            w1[i] = if flat { 0.0 } else { fade.grad([s])[0] };
            if order >= Order::Hessian {
                w2[i] = if flat { 0.0 } else { fade.hess([s])[0][0] };
            }
        }
        Share::Part(weights)
    }
}

impl Pointwise for Bundle<'_> {
    fn jets(&self, at: [&[f64]; 3], with: Option<&[f64]>, mut out: Jets4<'_>) {
        let order = match (&out.space.grad, &out.space.hess) {
            (_, Some(_)) => Order::Hessian,
            (Some(_), None) => Order::Gradient,
            (None, None) => Order::Value,
        };
        // Which arrays there are follows from the order; the others cost nothing.
        let mut value = [0.0; BATCH];
        let (mut grad, mut hess);
        let (mut grads, mut hesses) = (None, None);
        if order >= Order::Gradient {
            grad = [[0.0; BATCH]; 3];
            grads = Some(&mut grad);
        }
        if order >= Order::Hessian {
            hess = [[0.0; BATCH]; 6];
            hesses = Some(&mut hess);
        }
        for start in (0..at[0].len()).step_by(BATCH) {
            let end = (start + BATCH).min(at[0].len());
            let count = end - start;
            let (at, with) = (at.map(|at| &at[start..end]), with.map(|s| &s[start..end]));
            let mut total = part(&mut out, start);
            total.space.value.fill(self.base);
            total.space.grad.iter_mut().flatten().for_each(|g| g.fill(0.0));
            total.space.hess.iter_mut().flatten().for_each(|h| h.fill(0.0));
            let mut own = Jets {
                value: &mut value[..count],
                grad: grads.as_mut().map(|g| g.each_mut().map(|g| &mut g[..count])),
                hess: hesses.as_mut().map(|h| h.each_mut().map(|h| &mut h[..count])),
            };
            for term in self.terms {
                let share = Share::new(&term.fade, with, order);
                if matches!(share, Share::Gone) {
                    break;
                }
                term.octave.jets(at, batch::<BATCH>(&mut own, 0));
                widest(
                    #[inline(always)]
                    || {
                        self.fold(batch::<BATCH>(&mut own, 0));
                        match &share {
                            Share::Part(weights) => add_part(term.amplitude, weights, &own, &mut total),
                            _ => add_whole(term.amplitude, &own, &mut total.space),
                        }
                    },
                );
            }
        }
    }

    fn jet(&self, order: Order, at: [f64; 3], with: Option<f64>) -> Point4 {
        let mut total = Point4 { value: self.base, ..Point4::default() };
        for term in self.terms {
            let share = Share::new(&term.fade, with.as_ref().map(std::slice::from_ref), order);
            if matches!(share, Share::Gone) {
                break;
            }
            let mut own = term.octave.jet(order, at);
            self.fold(own.as_jets(order));
            let (own, mut out) = (own.as_jets(order), total.as_jets(order));
            match &share {
                Share::Part(weights) => add_part(term.amplitude, weights, &own, &mut out),
                _ => add_whole(term.amplitude, &own, &mut out.space),
            }
        }
        total
    }
}

/// The lanes from `start` on, at most a batch of them.
#[inline(always)]
fn part<'a>(out: &'a mut Jets4<'_>, start: usize) -> Jets4<'a> {
    let end = (start + BATCH).min(out.space.value.len());
    Jets4 {
        slope: out.slope.as_mut().map(|s| &mut s[start..end]),
        bend: out.bend.as_mut().map(|b| b.each_mut().map(|b| &mut b[start..end])),
        space: batch::<BATCH>(&mut out.space, start),
    }
}

/// Jets of a noise as jets of a function of it, less `mean`.
#[inline(always)]
fn fold_by<F: Function<1>>(f: &F, mean: f64, jets: Jets<'_>) {
    let Jets { value, grad, hess } = jets;
    let count = value.len();
    if let Some(grad) = grad {
        let [x, y, z] = grad.map(|g| &mut g[..count]);
        if let Some(hess) = hess {
            let [xx, yy, zz, xy, xz, yz] = hess.map(|h| &mut h[..count]);
            for i in 0..count {
                let (f1, f2) = (f.grad([value[i]])[0], f.hess([value[i]])[0][0]);
                xx[i] = f1 * xx[i] + f2 * x[i] * x[i];
                yy[i] = f1 * yy[i] + f2 * y[i] * y[i];
                zz[i] = f1 * zz[i] + f2 * z[i] * z[i];
                xy[i] = f1 * xy[i] + f2 * x[i] * y[i];
                xz[i] = f1 * xz[i] + f2 * x[i] * z[i];
                yz[i] = f1 * yz[i] + f2 * y[i] * z[i];
            }
        }
        for i in 0..count {
            let f1 = f.grad([value[i]])[0];
            (x[i], y[i], z[i]) = (f1 * x[i], f1 * y[i], f1 * z[i]);
        }
    }
    for v in value {
        *v = f.value([*v]) + -mean;
    }
}

/// `total += a own`
#[inline(always)]
fn add_whole(a: f64, own: &Jets<'_>, total: &mut Jets<'_>) {
    let add = |to: &mut [f64], from: &[f64]| {
        for (to, from) in to.iter_mut().zip(from) {
            *to += from * a;
        }
    };
    add(total.value, own.value);
    if let (Some(to), Some(from)) = (&mut total.grad, &own.grad) {
        (0..3).for_each(|k| add(to[k], from[k]));
    }
    if let (Some(to), Some(from)) = (&mut total.hess, &own.hess) {
        (0..6).for_each(|k| add(to[k], from[k]));
    }
}

/// `total += a w(s) own`, with the derivatives by `s`. A lane without weight adds nothing, not even
/// what is not a number.
#[inline(always)]
fn add_part(a: f64, [w, w1, w2]: &[[f64; BATCH]; 3], own: &Jets<'_>, total: &mut Jets4<'_>) {
    let add = |to: &mut [f64], from: &[f64], by: &[f64; BATCH]| {
        for ((to, from), (by, w)) in to.iter_mut().zip(from).zip(by.iter().zip(w)) {
            *to += if *w == 0.0 { 0.0 } else { by * from * a };
        }
    };
    add(total.space.value, own.value, w);
    if let (Some(to), Some(from)) = (&mut total.space.grad, &own.grad) {
        (0..3).for_each(|k| add(to[k], from[k], w));
    }
    if let Some(slope) = &mut total.slope {
        add(slope, own.value, w1);
    }
    if let (Some(to), Some(from)) = (&mut total.space.hess, &own.hess) {
        (0..6).for_each(|k| add(to[k], from[k], w));
    }
    if let (Some([xs, ys, zs, ss]), Some([x, y, z])) = (&mut total.bend, &own.grad) {
        add(xs, x, w1);
        add(ys, y, w1);
        add(zs, z, w1);
        add(ss, own.value, w2);
    }
}
