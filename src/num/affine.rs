//! Standard affine forms with any number of symbols, condensed to a budget (thesis, 5.2.4).
//!
//! ```text
//! x^ = mid + sum x_i e_i,  e_i in [-1, 1] shared between quantities
//! ```
//!
//! Every operation that is not affine adds a fresh symbol for what it lost. When a form holds more
//! than [`Affine::BUDGET`] symbols the smallest are merged into one fresh symbol: safe, at the
//! price of their correlations. As in [`Reduced`](super::Reduced), an interval is carried along.

use super::number::{Centred, centred_kernel};
use super::{Bounds, Form, Function, Interval, Kernel, Local, Number, Order, ROUNDOFF};
use std::cell::Cell;

/// Names an affine symbol.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Hash)]
pub struct Symbol(u64);

thread_local! {
    // Identity and relative order are all that matters of a symbol, and both depend only on the
    // order of operations within one computation, so results do not depend on the thread.
    static NEXT: Cell<u64> = const { Cell::new(0) };
}

impl Symbol {
    /// A symbol that no other quantity of this thread has.
    pub fn fresh() -> Symbol {
        NEXT.with(|next| {
            next.set(next.get() + 1);
            Symbol(next.get())
        })
    }
}

/// An affine form and an interval that also holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Affine {
    /// Centre.
    pub mid: f64,
    /// Symbols in increasing order, with their coefficients.
    pub terms: Vec<(Symbol, f64)>,
    /// Encloses the values, at least as tightly as the form.
    pub range: Interval,
}

/// Covers the roundings inside a bound.
const ROUND_UP: f64 = 1.0 + 64.0 * ROUNDOFF;

impl Affine {
    /// Number of symbols above which a form is condensed.
    pub const BUDGET: usize = 24;

    /// `mid + radius e` with a given symbol: an input of a computation.
    pub fn new(mid: f64, radius: f64, symbol: Symbol) -> Self {
        Affine { mid, terms: vec![(symbol, radius)], range: Interval::around(mid, radius.abs()) }
    }

    /// An input that varies over `range`, with a symbol of its own.
    pub fn over(range: Interval) -> Self {
        Affine { mid: range.mid(), terms: vec![(Symbol::fresh(), range.rad())], range }
    }

    /// Sum of the absolute coefficients, rounded up.
    pub fn radius(&self) -> f64 {
        self.terms.iter().map(|t| t.1.abs()).sum::<f64>() * ROUND_UP
    }

    /// Merges the smallest symbols into a fresh one until at most `budget` are left.
    pub fn condensed(mut self, budget: usize) -> Self {
        if self.terms.len() > budget.max(1) {
            let mut by_size: Vec<f64> = self.terms.iter().map(|t| t.1.abs()).collect();
            by_size.sort_by(|a, b| b.total_cmp(a));
            let keep = by_size[budget.max(1) - 1];
            let mut merged = 0.0;
            self.terms.retain(|t| {
                let stays = t.1.abs() > keep;
                merged += if stays { 0.0 } else { t.1.abs() };
                stays
            });
            self.terms.push((Symbol::fresh(), merged * ROUND_UP));
        }
        self
    }

    /// Adds a fresh symbol for `error`, intersects with `known`, condenses.
    fn finished(mut self, error: f64, known: Interval) -> Self {
        let finite = self.mid.is_finite() && error.is_finite() && self.terms.iter().all(|t| t.1.is_finite());
        if !finite {
            return Affine { mid: known.mid(), terms: vec![(Symbol::fresh(), known.rad())], range: known };
        }
        self.terms.retain(|t| t.1 != 0.0);
        if error > 0.0 {
            self.terms.push((Symbol::fresh(), error * ROUND_UP));
        }
        self.range = Interval::around(self.mid, self.radius()).meet(known);
        self.condensed(Affine::BUDGET)
    }

    /// `sum w_i (x_i - c_i)` with its rounding error.
    fn combine<const N: usize>(x: &[&Affine; N], centre: &[f64; N], w: &[f64; N]) -> (Affine, f64) {
        let mut sum = Affine::constant(0.0);
        let mut error = 0.0;
        for i in 0..N {
            let offset = x[i].mid - centre[i];
            sum.mid += w[i] * offset;
            error += ROUNDOFF * (N + 3) as f64 * (w[i] * offset).abs();
            sum.terms = merge(&sum.terms, &x[i].terms, w[i], &mut error);
        }
        (sum, error)
    }

    /// Enclosure of `1/2 (x - c)^T M (x - c)`; symbols that two arguments share give squares, whose
    /// mean moves to the centre.
    fn quadratic<const N: usize>(x: &[&Affine; N], m: &[[f64; N]; N]) -> Interval {
        let radii = x.map(|x| x.radius());
        let mut sum = Interval::point(0.0);
        for i in 0..N {
            for j in 0..N {
                let squares = shared(&x[i].terms, &x[j].terms);
                let size: f64 = squares.iter().map(|s| s.abs()).sum();
                let square = squares.iter().fold(Interval::point(0.0), |sum, &s| sum + Interval::UNIT * s);
                let cross = Interval::radius(
                    (radii[i] * radii[j] - size * (1.0 - 64.0 * ROUNDOFF)).max(0.0) * ROUND_UP,
                );
                sum = sum + (square + cross) * (0.5 * m[i][j]);
            }
        }
        sum
    }
}

/// `a + w b`, term by term.
fn merge(a: &[(Symbol, f64)], b: &[(Symbol, f64)], w: f64, error: &mut f64) -> Vec<(Symbol, f64)> {
    let mut out = Vec::with_capacity(a.len() + b.len() + 1);
    let (mut i, mut j) = (0, 0);
    while i < a.len() || j < b.len() {
        let before = j == b.len() || (i < a.len() && a[i].0 < b[j].0);
        let both = i < a.len() && j < b.len() && a[i].0 == b[j].0;
        let (symbol, sum) = if both {
            (a[i].0, a[i].1 + w * b[j].1)
        } else if before {
            a[i]
        } else {
            (b[j].0, w * b[j].1)
        };
        let scaled = if before { 0.0 } else { (w * b[j].1).abs() };
        *error += ROUNDOFF * 2.0 * (sum.abs() + scaled);
        i += usize::from(both || before);
        j += usize::from(both || !before);
        out.push((symbol, sum));
    }
    out
}

/// Products of the coefficients of the symbols that occur in both.
fn shared(a: &[(Symbol, f64)], b: &[(Symbol, f64)]) -> Vec<f64> {
    let (mut i, mut j, mut out) = (0, 0, Vec::new());
    while i < a.len() && j < b.len() {
        match a[i].0.cmp(&b[j].0) {
            std::cmp::Ordering::Less => i += 1,
            std::cmp::Ordering::Greater => j += 1,
            std::cmp::Ordering::Equal => {
                out.push(a[i].1 * b[j].1);
                (i, j) = (i + 1, j + 1);
            }
        }
    }
    out
}

impl Number for Affine {
    fn constant(c: f64) -> Self {
        Affine { mid: c, terms: Vec::new(), range: Interval::point(c) }
    }
    fn add(&self, other: &Self) -> Self {
        let (sum, error) = Affine::combine(&[self, other], &[0.0; 2], &[1.0, 1.0]);
        sum.finished(error, self.range + other.range)
    }
    fn sub(&self, other: &Self) -> Self {
        let (sum, error) = Affine::combine(&[self, other], &[0.0; 2], &[1.0, -1.0]);
        sum.finished(error, self.range - other.range)
    }
    fn neg(&self) -> Self {
        let terms = self.terms.iter().map(|t| (t.0, -t.1)).collect();
        Affine { mid: -self.mid, terms, range: -self.range }
    }
    fn scale(&self, k: f64) -> Self {
        let (sum, error) = Affine::combine(&[self], &[0.0], &[k]);
        sum.finished(error, self.range * k)
    }
    fn shift(&self, c: f64) -> Self {
        let shifted = Affine { mid: self.mid + c, ..self.clone() };
        let error = ROUNDOFF * shifted.mid.abs();
        shifted.finished(error, self.range + Interval::point(c))
    }
    fn lift<F: Function<N>, const N: usize>(f: &F, x: [&Self; N]) -> Self {
        let boxes = x.map(|x| x.range);
        let range = f.range(boxes);
        let combine = |w: &[f64; N]| {
            let (sum, error) = Affine::combine(&x, &[0.0; N], w);
            let natural = (0..N).fold(Interval::point(0.0), |sum, i| sum + boxes[i] * w[i]);
            Interval::around(sum.mid, (sum.radius() + error) * ROUND_UP).meet(natural)
        };
        let form: Form<N> = f.form(&boxes, &combine);
        let centre = boxes.map(Interval::mid);
        let (mut sum, mut error) = Affine::combine(&x, &centre, &form.slope);
        let mut rest = form.rest;
        if form.bend.lo != 0.0 || form.bend.hi != 0.0 {
            let centred = (0..N).all(|i| x[i].mid == centre[i]);
            let whole: [Affine; N];
            let recentred = if centred {
                x
            } else {
                // The boxes are tighter than the forms: one anonymous symbol each.
                whole = std::array::from_fn(|i| Affine::over(boxes[i]));
                std::array::from_fn(|i| &whole[i])
            };
            rest = rest + Affine::quadratic(&recentred, &form.matrix) * form.bend;
        }
        sum.mid += rest.mid();
        error += rest.rad() + 2.0 * ROUNDOFF * sum.mid.abs();
        sum.finished(error, range)
    }
    fn kernel<K: Kernel + ?Sized>(k: &K, p: [&Self; 3]) -> Self {
        centred_kernel(k, p)
    }
    fn somewhere(range: Interval) -> Option<Self> {
        Some(Affine::over(range))
    }
    fn range(&self) -> Interval {
        self.range
    }
}

impl Centred for Affine {
    const ORDER: Order = Order::Gradient;
    fn centre(p: [&Self; 3]) -> [f64; 3] {
        p.map(|p| p.mid)
    }
    fn blind(b: &Bounds, p: [&Self; 3]) -> bool {
        b.drown(reach(p))
    }
    fn reach(p: [&Self; 3]) -> f64 {
        reach(p)
    }
    fn expand(local: &Local, error: [f64; 3], p: [&Self; 3]) -> Self {
        let Local { jet, bounds: b, .. } = local;
        let all = Interval::radius(b.range);
        let d = reach(p);
        if b.drown(d) || !jet.value.is_finite() {
            return Affine::over(all);
        }
        let (mut sum, mut rest) = Affine::combine(&p, &p.map(|p| p.mid), &jet.grad);
        let bend = local.bend(d);
        sum.mid += jet.value + bend.mid();
        rest += bend.rad() + error[0] + 2.0 * error[1] * d;
        rest += 2.0 * ROUNDOFF * (jet.value.abs() + bend.mag() + sum.mid.abs());
        let flat = Interval::around(jet.value, (b.lipschitz * d + error[0]) * ROUND_UP);
        sum.finished(rest, all.meet(flat))
    }
}

/// Largest distance of a point from its centre.
fn reach(p: [&Affine; 3]) -> f64 {
    p.iter().map(|p| p.radius()).map(|r| r * r).sum::<f64>().sqrt() * ROUND_UP
}
