//! Enclosures along a line by bands between two parabolas.
//!
//! Over a piece of a line, `x(e) = c + e d` with `e` in [-1, 1], a quantity is known as
//!
//! ```text
//! f  is in  value + side_1 u_1 + ... + side_K u_K + slope e + bend e^2,     u_k in [-1, 1]
//! ```
//!
//! with intervals for `value`, `slope` and `bend`, and besides as an interval `range`. So one
//! evaluation says not only whether the piece is free of roots, but how far from its middle, on either
//! side, that is certain: up to a root of a quadratic polynomial ([`Parabola::halves`]). This is the
//! two-sided certificate of a jet, made an arithmetic, so that it holds for any expression.
//!
//! The `K` side symbols are shared by all quantities, like those of affine arithmetic. A beam of
//! rays has two, which say where in the beam a ray is; a single ray has none.
//!
//! **Functions** are expanded to second order about the value in the middle, with second derivatives
//! enclosed over the whole piece. Where those are unbounded, because a crease may be crossed, first
//! derivatives over the piece serve as slopes; and a minimum or maximum has the hull of its arguments'
//! slopes. **Kernels** have the best of three bounds: their jet's Taylor form, their Lipschitz bound, or
//! their range.
//!
//! [`Parabolas`] are a batch of them as a structure of arrays. An operation is a loop over the lanes
//! that loads a [`Parabola`], computes with plain numbers and stores the result: what the compiler
//! makes vector instructions of. No lane influences another.

use super::interval::{choose, pick};
use super::number::Jets;
use super::simd::widest;
use super::{Band, Function, Interval, Kernel, Local, Number, Order, Point, ROUNDOFF, Real};

/// A quantity along a piece of a line; see the module text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parabola<const K: usize> {
    /// Where the quantity is in the middle of the piece, but for the side symbols.
    pub value: Interval,
    /// Factor of `e`.
    pub slope: Interval,
    /// Factor of `e^2`.
    pub bend: Interval,
    /// Factors of the side symbols.
    pub side: [f64; K],
    /// Encloses the quantity over the whole piece.
    pub range: Interval,
}

/// What is certain of one half of a piece, in units of its half length from the middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Half {
    /// The quantity is positive between these two places; `[1, 1]` where it is certain of none.
    pub above: [f64; 2],
    /// Nearest place where the quantity is negative for certain; 1 if there is none.
    pub below: f64,
}

/// Covers the roundings of the handful of additions inside a bound.
const ROUND_UP: f64 = 1.0 + 16.0 * ROUNDOFF;

const ZERO: Interval = Interval { lo: 0.0, hi: 0.0 };

/// `[-r, r]`
#[inline(always)]
fn radius(r: f64) -> Interval {
    Interval { lo: -r, hi: r }
}

/// `g . (x, y, z)`
#[inline(always)]
fn dot(g: [f64; 3], x: Interval, y: Interval, z: Interval) -> Interval {
    x * g[0] + y * g[1] + z * g[2]
}

/// How far a value may be from its own middle.
#[inline(always)]
fn off_middle<const K: usize>(x: &Parabola<K>) -> Interval {
    x.value - Interval::point(x.value.mid())
}

/// `a b`, where a factor that is exactly zero silences an unbounded one.
#[inline(always)]
fn silenced(a: Interval, b: Interval) -> Interval {
    let p = a * b;
    pick((b.lo == 0.0) & (b.hi == 0.0), ZERO, p)
}

/// One part of each of `N` numbers; a plain loop, since `array::map` is not always inlined, and what is
/// not inlined is not vectorised.
#[inline(always)]
fn each<T: Copy, const K: usize, const N: usize>(
    x: &[Parabola<K>; N],
    part: impl Fn(&Parabola<K>) -> T,
) -> [T; N] {
    let mut out = [part(&x[0]); N];
    for i in 1..N {
        out[i] = part(&x[i]);
    }
    out
}

impl<const K: usize> Parabola<K> {
    /// The number `c`.
    #[inline(always)]
    pub fn constant(c: Interval) -> Self {
        Parabola { value: c, slope: ZERO, bend: ZERO, side: [0.0; K], range: c }
    }

    /// A coordinate: `mid + side u + slope e`, known to within `blur`; `spread` is by how much the slope
    /// may differ across a beam.
    #[inline(always)]
    pub fn coordinate(mid: f64, slope: f64, side: [f64; K], spread: f64, blur: f64) -> Self {
        let mut reach = slope.abs() + spread + blur;
        for side in side {
            reach += side.abs();
        }
        Parabola {
            value: Interval::around(mid, blur),
            slope: Interval::around(slope, spread),
            bend: ZERO,
            side,
            range: Interval::around(mid, reach * ROUND_UP),
        }
    }

    /// Sum of the magnitudes of the side symbols' factors, rounded up.
    #[inline(always)]
    fn width(&self) -> f64 {
        let mut width = 0.0;
        for k in 0..K {
            width += self.side[k].abs();
        }
        width * ROUND_UP
    }

    /// The hull of all that the form allows.
    #[inline(always)]
    fn hull(&self) -> Interval {
        // `bend e^2` has the sign of the bend, `slope e` either one.
        let lo = self.bend.lo.min(0.0);
        let hi = self.bend.hi.max(0.0);
        self.value + radius((self.slope.mag() + self.width()) * ROUND_UP) + Interval { lo, hi }
    }

    /// Intersects with a range known otherwise; where the form has nothing to add, drops it.
    #[inline(always)]
    fn tightened(self, known: Interval) -> Self {
        let own = self.hull();
        let whole = own.lo.is_finite() & own.hi.is_finite();
        let range = pick(whole, own.meet(known), known);
        // How far the quantity may be from a straight line.
        let bent = self.bend.hi.max(0.0) - self.bend.lo.min(0.0);
        let doubt = self.value.width() + self.slope.width() + bent;
        let idle = !(whole & (doubt <= range.width()));
        let mut out = Parabola {
            value: pick(idle, range, self.value),
            slope: pick(idle, ZERO, self.slope),
            bend: pick(idle, ZERO, self.bend),
            side: self.side,
            range,
        };
        for k in 0..K {
            out.side[k] = choose(idle, 0.0, out.side[k]);
        }
        out
    }

    /// `slope + bend e`: the slope of any chord from the middle.
    #[inline(always)]
    fn chord(&self) -> Interval {
        self.slope + radius(self.bend.mag())
    }

    #[inline(always)]
    fn is_finite(&self) -> bool {
        self.value.is_finite() & self.slope.is_finite() & self.bend.is_finite()
    }

    /// Charges the rounding of side symbols to the value: of up to six terms, which together are of
    /// this size.
    #[inline(always)]
    fn rounded(mut self, size: f64) -> Self {
        if K > 0 {
            self.value = self.value + radius(8.0 * ROUNDOFF * size + 1e-300);
        }
        self
    }

    /// Expansion to first order, with partial derivatives over the whole piece.
    #[inline(always)]
    fn sloped<F: Function<N>, const N: usize>(f: &F, x: &[Self; N], value: Interval) -> Self {
        let grad = f.grad(each(x, |x| x.range));
        let mut out = Parabola { value, ..Self::constant(ZERO) };
        for i in 0..N {
            out.slope = out.slope + silenced(grad[i], x[i].chord());
            out.value = out.value + silenced(grad[i], radius(x[i].width()));
        }
        out
    }

    /// A function that selects one of its arguments departs from the middle as one of them does that
    /// may be selected.
    #[inline(always)]
    fn selected<F: Function<N>, const N: usize>(f: &F, x: &[Self; N], value: Interval) -> Self {
        let grad = f.grad(each(x, |x| x.range));
        let none = Interval { lo: f64::INFINITY, hi: f64::NEG_INFINITY };
        let (mut slope, mut bend, mut wide) = (none, none, 0.0_f64);
        for i in 0..N {
            if grad[i].hi > 0.0 {
                (slope, bend) = (slope.hull(x[i].slope), bend.hull(x[i].bend));
                wide = wide.max(x[i].width());
            }
        }
        Parabola { value: value + radius(wide), slope, bend, ..Self::constant(ZERO) }
    }

    /// What is certain of both halves of the piece: backwards, then forwards.
    #[inline]
    pub fn halves(&self) -> [Half; 2] {
        let (v, b, wide) = (self.value, self.bend, self.width());
        let half = |slope: Interval| Half {
            above: if self.range.lo > 0.0 {
                [0.0, 1.0]
            } else {
                positive([(v.lo - wide).next_down(), slope.lo, b.lo])
            },
            below: if self.range.hi < 0.0 {
                0.0
            } else {
                positive([(-v.hi - wide).next_down(), -slope.hi, -b.hi])[0]
            },
        };
        [half(-self.slope), half(self.slope)]
    }
}

/// The first part of [0, 1] in which `c + b t + a t^2` is positive for certain; `[1, 1]` if there is none.
///
/// Roots only propose its ends. A proposal counts where the polynomial is positive beyond rounding at
/// both ends, and at its vertex should that be a minimum between them: then it is so throughout.
fn positive(polynomial @ [c, b, a]: [f64; 3]) -> [f64; 2] {
    const NONE: [f64; 2] = [1.0, 1.0];
    let is_positive = |t: f64| {
        let (linear, square) = (b * t, a * t * t);
        c + linear + square > 16.0 * ROUNDOFF * (c.abs() + linear.abs() + square.abs())
    };
    let [start, end] = proposal(polynomial);
    if !(start < end) {
        return NONE;
    }
    let vertex = -0.5 * b / a;
    let sure = |from: f64, to: f64| {
        let dips = a > 0.0 && from < vertex && vertex < to;
        is_positive(from) && is_positive(to) && (!dips || is_positive(vertex))
    };
    // Roots are rounded: draw back a little, then more.
    for back in [8.0 * f64::EPSILON, 1e-9, 1e-3] {
        let from = if start > 0.0 { start * (1.0 + back) } else { 0.0 };
        let to = if end < 1.0 { end * (1.0 - back) } else { 1.0 };
        if from < to && sure(from, to) {
            return [from, to];
        }
    }
    NONE
}

/// Where in [0, 1] the polynomial first becomes positive and where it ceases to be, by its roots.
fn proposal([c, b, a]: [f64; 3]) -> [f64; 2] {
    let discriminant = b * b - 4.0 * a * c;
    if !(discriminant >= 0.0) {
        return if c > 0.0 { [0.0, 1.0] } else { [1.0, 1.0] };
    }
    // Both roots without cancellation.
    let q = -0.5 * (b + discriminant.sqrt().copysign(b));
    let (r, s) = (q / a, c / q);
    let (low, high) = if r < s { (r, s) } else { (s, r) };
    let within = |t: f64| if t > 0.0 && t < 1.0 { t } else { 1.0 };
    if c > 0.0 {
        // Up to the first root ahead.
        [0.0, if low > 0.0 { within(low) } else { within(high) }]
    } else if a < 0.0 {
        [if low > 0.0 { low } else { 0.0 }, within(high)]
    } else {
        // From the greater root on; a straight line has one root only.
        let root = if high.is_finite() { high } else { low };
        [if root >= 0.0 { root } else { 1.0 }, 1.0]
    }
}

/// How far a point reaches from the middle, as lengths of vectors.
#[derive(Clone, Copy)]
struct Reach {
    /// Along the line, at its ends.
    along: f64,
    /// Across it, and by not being known.
    beside: f64,
}

impl Reach {
    #[inline(always)]
    fn new<const K: usize>(p: &[Parabola<K>; 3]) -> Reach {
        let along = norm(each(p, |x| x.slope.mag() + x.bend.mag()));
        let mut beside = norm(each(p, |x| x.value.rad()));
        if K > 0 {
            beside += norm(each(p, |x| x.width()));
        }
        Reach { along, beside: beside * ROUND_UP }
    }

    #[inline(always)]
    fn whole(self) -> f64 {
        (self.along + self.beside) * ROUND_UP
    }
}

#[inline(always)]
fn norm([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt() * ROUND_UP
}

impl<const K: usize> Parabola<K> {
    /// What is known of a kernel at a point that reaches this far.
    #[inline(always)]
    fn expand(local: &Local, error: [f64; 3], reach: Reach, p: &[Self; 3]) -> Self {
        let Local { jet, bounds: b, bow } = *local;
        let (d, w, r) = (reach.along, reach.beside, reach.whole());
        let rounding = error[0] + 2.0 * error[1] * r;
        let cone = b.lipschitz * r * ROUND_UP;
        let bent = 0.5 * b.hessian * r * r;
        let own_bow = bow.mag() < bent;
        let is_value = jet.value.is_finite();
        let taylor = is_value & (choose(own_bow, bow.mag(), bent) <= choose(cone < b.range, cone, b.range));
        let lipschitz = is_value & !taylor & (cone <= b.range);

        let all = radius(b.range);
        let flat = Interval::around(jet.value, (cone + rounding) * ROUND_UP).meet(all);
        let known = pick(is_value, flat, all);
        let at = Interval::around(jet.value, rounding);
        // The three terms of `M (w + d e)^2 / 2`.
        let rest = choose(own_bow, 0.0, 0.5 * b.hessian * w * w * ROUND_UP);
        let cross = choose(own_bow, 0.0, b.hessian * d * w * ROUND_UP);
        let square = choose(own_bow, 0.0, 0.5 * b.hessian * d * d * ROUND_UP);
        let off = dot(jet.grad, off_middle(&p[0]), off_middle(&p[1]), off_middle(&p[2]));
        let value = at + off + radius(rest) + pick(own_bow, bow, ZERO);
        let slope = dot(jet.grad, p[0].slope, p[1].slope, p[2].slope) + radius(cross);
        let bend = dot(jet.grad, p[0].bend, p[1].bend, p[2].bend) + radius(square);

        let value = pick(taylor, value, pick(lipschitz, at + radius(b.lipschitz * w * ROUND_UP), known));
        let slope = pick(taylor, slope, pick(lipschitz, radius(b.lipschitz * d * ROUND_UP), ZERO));
        let bend = pick(taylor, bend, ZERO);
        let mut out = Parabola { value, slope, bend, side: [0.0; K], range: known };
        let mut size = 0.0;
        for k in 0..K {
            let (x, y, z) =
                (p[0].side[k] * jet.grad[0], p[1].side[k] * jet.grad[1], p[2].side[k] * jet.grad[2]);
            out.side[k] = choose(taylor, x + y + z, 0.0);
            size += choose(taylor, x.abs() + y.abs() + z.abs(), 0.0);
        }
        out.rounded(size).narrowed(known)
    }

    /// The range is what both the form and `known` allow.
    #[inline(always)]
    fn narrowed(mut self, known: Interval) -> Self {
        let own = self.hull();
        let whole = own.lo.is_finite() & own.hi.is_finite();
        self.range = pick(whole, own.meet(known), known);
        self
    }
}

/// The rounding of a kernel's jets, which grows with the size of the point like `a + b size`.
struct Growing {
    start: [f64; 3],
    growth: [f64; 3],
}

impl Growing {
    fn new<K: Kernel + ?Sized>(k: &K) -> Self {
        let (start, one) = (k.error(0.0), k.error(1.0));
        // What is unbounded at the origin is so everywhere.
        let grows = |i: usize| if start[i].is_finite() { (one[i] - start[i]) * ROUND_UP } else { 0.0 };
        Growing { start, growth: [grows(0), grows(1), grows(2)] }
    }

    #[inline(always)]
    fn at(&self, size: f64) -> [f64; 3] {
        let at = |i: usize| (self.start[i] + self.growth[i] * size) * ROUND_UP;
        [at(0), at(1), at(2)]
    }
}

/// Largest coordinate.
#[inline(always)]
fn size([x, y, z]: [f64; 3]) -> f64 {
    x.abs().max(y.abs()).max(z.abs())
}

/// `B` parabolas side by side, each along a piece of its own.
#[derive(Clone, Copy, Debug)]
pub struct Parabolas<const B: usize, const K: usize> {
    value: Band<B>,
    slope: Band<B>,
    bend: Band<B>,
    side: [[f64; B]; K],
    range: Band<B>,
}

impl<const B: usize, const K: usize> Parabolas<B, K> {
    /// The same number in every lane.
    pub fn all(x: Parabola<K>) -> Self {
        let mut side = [[0.0; B]; K];
        for k in 0..K {
            side[k] = [x.side[k]; B];
        }
        let [value, slope, bend] = [Band::all(x.value), Band::all(x.slope), Band::all(x.bend)];
        Parabolas { value, slope, bend, side, range: Band::all(x.range) }
    }

    /// A lane.
    #[inline(always)]
    pub fn lane(&self, i: usize) -> Parabola<K> {
        let mut side = [0.0; K];
        for k in 0..K {
            side[k] = self.side[k][i];
        }
        Parabola {
            value: self.value.lane(i),
            slope: self.slope.lane(i),
            bend: self.bend.lane(i),
            side,
            range: self.range.lane(i),
        }
    }

    /// Sets a lane.
    #[inline(always)]
    pub fn set(&mut self, i: usize, x: &Parabola<K>) {
        self.value.set(i, x.value);
        self.slope.set(i, x.slope);
        self.bend.set(i, x.bend);
        self.range.set(i, x.range);
        for k in 0..K {
            self.side[k][i] = x.side[k];
        }
    }

    /// The lanes one by one, as a plain loop.
    #[inline(always)]
    fn lanes(f: impl Fn(usize) -> Parabola<K>) -> Self {
        widest(
            #[inline(always)]
            || {
                let mut out = Self::all(Parabola::constant(ZERO));
                for i in 0..B {
                    out.set(i, &f(i));
                }
                out
            },
        )
    }

    /// A lane of each argument.
    #[inline(always)]
    fn gather<const N: usize>(x: &[&Self; N], i: usize) -> [Parabola<K>; N] {
        let mut out = [x[0].lane(i); N];
        for j in 1..N {
            out[j] = x[j].lane(i);
        }
        out
    }

    /// Expansion of a function to second order about the middle: a loop over the lanes for each
    /// quantity, since a loop that computes all of them is too much for the compiler to vectorise.
    #[inline(always)]
    fn curved<F: Function<N>, const N: usize>(f: &F, x: &[&Self; N]) -> Self {
        let zero = Band::all(ZERO);
        let mut out = Self::all(Parabola::constant(ZERO));
        let (mut grad, mut hess, mut chord) = ([zero; N], [[zero; N]; N], [zero; N]);
        for l in 0..B {
            let mut at = [ZERO; N];
            for i in 0..N {
                at[i] = x[i].value.lane(l);
            }
            out.value.set(l, f.range(at));
        }
        for l in 0..B {
            let mut at = [ZERO; N];
            for i in 0..N {
                at[i] = x[i].range.lane(l);
            }
            out.range.set(l, f.range(at));
        }
        for l in 0..B {
            let mut at = [ZERO; N];
            for i in 0..N {
                at[i] = x[i].value.lane(l);
            }
            let g = f.grad(at);
            for i in 0..N {
                grad[i].set(l, g[i]);
            }
        }
        for l in 0..B {
            let mut at = [ZERO; N];
            for i in 0..N {
                at[i] = x[i].range.lane(l);
            }
            let h = f.hess(at);
            for i in 0..N {
                for j in 0..N {
                    if j <= i {
                        hess[i][j].set(l, h[i][j]);
                    }
                }
            }
        }
        for i in 0..N {
            for l in 0..B {
                let (g, t) = (grad[i].lane(l), x[i].slope.lane(l) + radius(x[i].bend.lane(l).mag()));
                chord[i].set(l, t);
                out.slope.set(l, out.slope.lane(l) + silenced(g, x[i].slope.lane(l)));
                let half = silenced(hess[i][i].lane(l), t.square() * 0.5);
                out.bend.set(l, out.bend.lane(l) + silenced(g, x[i].bend.lane(l)) + half);
            }
        }
        for i in 0..N {
            for j in 0..i {
                for l in 0..B {
                    let t = chord[i].lane(l) * chord[j].lane(l);
                    out.bend.set(l, out.bend.lane(l) + silenced(hess[i][j].lane(l), t));
                }
            }
        }
        if K > 0 {
            out.spread(&grad, &hess, x, &chord);
        }
        out
    }

    /// Adds what the side symbols of the arguments do to a second-order expansion.
    #[inline(always)]
    fn spread<const N: usize>(
        &mut self,
        grad: &[Band<B>; N],
        hess: &[[Band<B>; N]; N],
        x: &[&Self; N],
        chord: &[Band<B>; N],
    ) {
        let mut wide = [[0.0; B]; N];
        let mut size = [0.0; B];
        for i in 0..N {
            for k in 0..K {
                for l in 0..B {
                    wide[i][l] += x[i].side[k][l].abs();
                    let term = grad[i].lane(l).mid() * x[i].side[k][l];
                    self.side[k][l] += term;
                    size[l] += term.abs();
                }
            }
            for l in 0..B {
                wide[i][l] *= ROUND_UP;
                let (h, w) = (hess[i][i].lane(l), radius(wide[i][l]));
                // Only the middle of a partial derivative acts on a shared symbol.
                let own = silenced(h, w.square() * 0.5) + silenced(radius(grad[i].lane(l).rad()), w);
                self.value.set(l, self.value.lane(l) + own);
                self.slope.set(l, self.slope.lane(l) + silenced(h, chord[i].lane(l) * w));
            }
        }
        for i in 0..N {
            for j in 0..i {
                for l in 0..B {
                    let (h, v, w) = (hess[i][j].lane(l), radius(wide[i][l]), radius(wide[j][l]));
                    let both = chord[i].lane(l) * w + chord[j].lane(l) * v;
                    self.value.set(l, self.value.lane(l) + silenced(h, v * w));
                    self.slope.set(l, self.slope.lane(l) + silenced(h, both));
                }
            }
        }
        for l in 0..B {
            self.value.set(l, self.value.lane(l) + radius(8.0 * ROUNDOFF * size[l] + 1e-300));
        }
    }

    /// The image of a point under a kernel.
    fn image<K2: Kernel + ?Sized>(k: &K2, p: [&Self; 3]) -> Self {
        let bounds = k.bounds();
        let mut at = [[0.0; B]; 3];
        let mut reach = [[0.0; B]; 2];
        let mut least = f64::INFINITY;
        widest(
            #[inline(always)]
            || {
                for i in 0..B {
                    let p = Self::gather(&p, i);
                    for axis in 0..3 {
                        at[axis][i] = p[axis].value.mid();
                    }
                    let own = Reach::new(&p);
                    (reach[0][i], reach[1][i]) = (own.along, own.beside);
                }
                for i in 0..B {
                    least = least.min(reach[0][i] + reach[1][i]);
                }
            },
        );
        let reach = |i: usize| Reach { along: reach[0][i], beside: reach[1][i] };
        let blind = bounds.lipschitz * least >= 2.0 * bounds.range;
        if blind {
            return Self::all(Parabola::constant(radius(bounds.range)));
        }
        let place = |i: usize| [at[0][i], at[1][i], at[2][i]];
        if !k.is_uniform() {
            let mut out = Self::all(Parabola::constant(ZERO));
            for i in 0..B {
                let (p, c) = (Self::gather(&p, i), place(i));
                let local = k.local(Order::Gradient, c, reach(i).whole());
                out.set(i, &Parabola::expand(&local, k.error(size(c)), reach(i), &p));
            }
            return out;
        }
        let (mut value, mut grad) = ([0.0; B], [[0.0; B]; 3]);
        let [gx, gy, gz] = &mut grad;
        k.jets([&at[0], &at[1], &at[2]], Jets { value: &mut value, grad: Some([gx, gy, gz]), hess: None });
        let error = Growing::new(k);
        Self::lanes(
            #[inline(always)]
            |i| {
                let p = Self::gather(&p, i);
                let jet =
                    Point { value: value[i], grad: [grad[0][i], grad[1][i], grad[2][i]], hess: [0.0; 6] };
                Parabola::expand(&Local::uniform(jet, bounds), error.at(size(place(i))), reach(i), &p)
            },
        )
    }
}

impl<const B: usize, const K: usize> Number for Parabolas<B, K> {
    fn constant(c: f64) -> Self {
        Self::all(Parabola::constant(Interval::point(c)))
    }
    fn add(&self, other: &Self) -> Self {
        Self::lanes(
            #[inline(always)]
            |i| {
                let (a, b) = (self.lane(i), other.lane(i));
                let mut out = Parabola {
                    value: a.value + b.value,
                    slope: a.slope + b.slope,
                    bend: a.bend + b.bend,
                    side: a.side,
                    range: a.range + b.range,
                };
                let mut size = 0.0;
                for k in 0..K {
                    out.side[k] += b.side[k];
                    size += out.side[k].abs();
                }
                out.rounded(size).narrowed(out.range)
            },
        )
    }
    fn sub(&self, other: &Self) -> Self {
        self.add(&other.neg())
    }
    fn neg(&self) -> Self {
        Self::lanes(
            #[inline(always)]
            |i| {
                let x = self.lane(i);
                let mut out = Parabola {
                    value: -x.value,
                    slope: -x.slope,
                    bend: -x.bend,
                    side: x.side,
                    range: -x.range,
                };
                for k in 0..K {
                    out.side[k] = -x.side[k];
                }
                out
            },
        )
    }
    fn scale(&self, k: f64) -> Self {
        Self::lanes(
            #[inline(always)]
            |i| {
                let x = self.lane(i);
                let mut out = Parabola {
                    value: x.value * k,
                    slope: x.slope * k,
                    bend: x.bend * k,
                    side: x.side,
                    range: x.range * k,
                };
                let mut size = 0.0;
                for s in 0..K {
                    out.side[s] *= k;
                    size += out.side[s].abs();
                }
                out.rounded(size)
            },
        )
    }
    fn shift(&self, c: f64) -> Self {
        let c = Interval::point(c);
        Self::lanes(
            #[inline(always)]
            |i| {
                let x = self.lane(i);
                Parabola { value: x.value + c, range: x.range + c, ..x }
            },
        )
    }
    fn lift<F: Function<N>, const N: usize>(f: &F, x: [&Self; N]) -> Self {
        let mut out = widest(
            #[inline(always)]
            || Self::curved(f, &x),
        );
        // Where second derivatives are unbounded, first ones may not be.
        for i in 0..B {
            if !out.lane(i).is_finite() {
                let x = Self::gather(&x, i);
                let value = f.range(each(&x, |x| x.value));
                let first = if f.selects() {
                    Parabola::selected(f, &x, value)
                } else {
                    Parabola::sloped(f, &x, value)
                };
                out.set(i, &Parabola { range: out.range.lane(i), ..first });
            }
        }
        Self::lanes(
            #[inline(always)]
            |i| {
                let x = out.lane(i);
                x.tightened(x.range)
            },
        )
    }
    fn kernel<K2: Kernel + ?Sized>(k: &K2, p: [&Self; 3]) -> Self {
        Self::image(k, p)
    }
    fn somewhere(range: Interval) -> Option<Self> {
        Some(Self::all(Parabola::constant(range)))
    }
    fn choose(by: &Self, test: impl Fn(Interval) -> bool, yes: &Self, no: &Self) -> Self {
        let mut out = *no;
        for i in 0..B {
            if test(by.range.lane(i)) {
                out.set(i, &yes.lane(i));
            }
        }
        out
    }
    fn range(&self) -> Interval {
        (1..B).fold(self.range.lane(0), |all, i| all.hull(self.range.lane(i)))
    }
}
