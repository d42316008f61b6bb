//! Functions of parabolas.
//!
//! With `m_i` the middles of the arguments and `d_i = x_i - m_i`,
//!
//! ```text
//! f(x) = f(m) + grad f(m) . d + 1/2 d^T H d,     H in the Hessian's range over the box of all x and m
//! ```
//!
//! where `d_i = y_i + t_i e`: `y_i` is what the side symbols and the rest do in the middle, at most
//! [`Parabola::off_middle`], and the slope `t_i` of the chord is within [`Parabola::bent`] of the slope
//! `mid_1`. So the quadratic term has a part without `e`, one with `e` and one with `e^2`.
//!
//! A quantity is computed for all lanes before the next one is, since a loop that computes all of them
//! is too much for the compiler to vectorise.

use super::band::Band;
use super::batch::Parabolas;
use super::crease::{chords, mixed, mixture};
use super::seam::Corners;
use super::{CHARGE, Parabola, ROUND_UP, TINY, choose};
use crate::num::ROUNDOFF;
use crate::num::simd::widest;
use crate::num::{Function, Interval};

/// Where partial derivatives are taken.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Expansion {
    /// First ones in the middle, second ones everywhere.
    Second,
    /// The same where some may be unbounded, which zeros silence.
    Careful,
    /// First ones everywhere, or chords where these say more.
    First,
}

impl Expansion {
    /// `a b` for `b >= 0`. Next to what is unbounded a zero that is not silenced is no number, which
    /// tells that more care is needed.
    #[inline(always)]
    fn product(self, a: f64, b: f64) -> f64 {
        if self == Expansion::Second { a * b } else { choose((a == 0.0) | (b == 0.0), 0.0, a * b) }
    }

    /// `h x^2 / 2` for `x` from `near` to `far`, both at least 0.
    #[inline(always)]
    fn half_square(self, h: Interval, near: f64, far: f64) -> [f64; 2] {
        let (near, far) = (0.5 * near * near, 0.5 * far * far);
        let lo = self.product(h.lo, choose(h.lo < 0.0, far, near));
        let hi = self.product(h.hi, choose(h.hi < 0.0, near, far));
        [lo, hi]
    }
}

/// Covers the rounding of sums of up to thirty products, in proportion to each.
pub(super) const SUMS: f64 = 32.0 * ROUNDOFF;

pub(super) const ZERO: Interval = Interval { lo: 0.0, hi: 0.0 };

#[inline(always)]
pub(super) fn point(x: f64) -> Interval {
    Interval { lo: x, hi: x }
}

#[inline(always)]
pub(super) fn points<const N: usize>(m: [f64; N]) -> [Interval; N] {
    let mut out = [ZERO; N];
    for i in 0..N {
        out[i] = point(m[i]);
    }
    out
}

/// Middle and radius of an interval.
#[inline(always)]
fn split(x: Interval) -> [f64; 2] {
    [x.mid(), x.rad()]
}

/// Middle and radius of what was computed as `x` and may be off by this many roundoffs of its size.
/// Sizes of which squares or reciprocals are not represented as well are no numbers here.
#[inline(always)]
pub(in crate::num) fn known(x: f64, roundoffs: f64) -> [f64; 2] {
    let size = x.abs();
    let ordinary = (size == 0.0) | ((size > 1e-140) & (size < 1e140));
    [x, choose(ordinary, 1.01 * roundoffs * ROUNDOFF * size, f64::NAN)]
}

impl<const B: usize, const K: usize> Parabolas<B, K> {
    /// Writes the image under a function to `out`.
    pub(super) fn lifted<F: Function<N>, const N: usize>(f: &F, x: &[&Self; N], out: &mut Self) {
        if f.is_vague() {
            for l in 0..B {
                let range = f.range(Self::arguments(x, l, |x, l| x.range.lane(l)));
                out.set(l, &Parabola::constant(range));
            }
            return;
        }
        if f.selects() {
            return widest(
                #[inline(always)]
                || Self::selected(f, x, out),
            );
        }
        // Of a broken line chords say all there is.
        let is_broken = f.bows(ZERO).is_some() && f.hess([1.0; N]) == [[0.0; N]; N];
        let by = if is_broken { Expansion::First } else { Expansion::Second };
        let corners = f.seam(&[0.0; N], ZERO).map(|_| Corners::new(f, x));
        if let Some(sole) = corners.as_ref().and_then(Corners::sole) {
            *out = *x[sole];
            return;
        }
        let done = widest(
            #[inline(always)]
            || {
                match &corners {
                    Some(corners) => corners.expand(f, x, out),
                    None => Self::expanded(f, x, by, out),
                }
                out.are_finite()
            },
        );
        if !done {
            Self::lifted_with_care(f, x, out);
        }
        widest(
            #[inline(always)]
            || {
                for l in 0..B {
                    let lane = out.lane(l);
                    out.set(l, &lane.settled(lane.range));
                }
            },
        );
        if let Some(corners) = corners {
            corners.leave(x, out);
        }
    }

    /// Writes the lanes again that are not finite.
    #[cold]
    fn lifted_with_care<F: Function<N>, const N: usize>(f: &F, x: &[&Self; N], out: &mut Self) {
        let mut again = *out;
        // Where second derivatives are unbounded, first ones may not be.
        for by in [Expansion::Careful, Expansion::First] {
            widest(
                #[inline(always)]
                || Self::expanded(f, x, by, &mut again),
            );
            for l in 0..B {
                if !out.lane(l).is_finite() {
                    out.set(l, &again.lane(l));
                }
            }
        }
    }

    /// Whether all lanes are.
    #[inline(always)]
    fn are_finite(&self) -> bool {
        let mut finite = true;
        for l in 0..B {
            finite &= self.lane(l).is_finite();
        }
        finite
    }

    /// A part of each argument of lane `l`.
    #[inline(always)]
    fn arguments<T: Copy, const N: usize>(
        x: &[&Self; N],
        l: usize,
        part: impl Fn(&Self, usize) -> T,
    ) -> [T; N] {
        let mut out = [part(x[0], l); N];
        for i in 1..N {
            out[i] = part(x[i], l);
        }
        out
    }

    /// The form of a function, with its range apart; see the module text.
    #[inline(always)]
    fn expanded<F: Function<N>, const N: usize>(f: &F, x: &[&Self; N], by: Expansion, out: &mut Self) {
        let (mut slope, mut steep, mut vague) = ([[0.0; B]; N], [[0.0; B]; N], [[0.0; B]; N]);
        out.enclose(f, x);
        for l in 0..B {
            let m = Self::arguments(
                x,
                l,
                #[inline(always)]
                |x, l| x.mid[0][l],
            );
            let [mid, rad] = match f.roundoffs() {
                Some(n) if by == Expansion::Second => known(f.value(m), n),
                _ => split(f.range(points(m))),
            };
            (out.mid[0][l], out.rest[0][l]) = (mid, rad + SUMS * (mid.abs() + rad));
        }
        for l in 0..B {
            let m = Self::arguments(
                x,
                l,
                #[inline(always)]
                |x, l| x.mid[0][l],
            );
            let mut grad = [[0.0; 2]; N];
            match f.roundoffs() {
                Some(n) if by == Expansion::Second => {
                    let plain = f.grad(m);
                    for i in 0..N {
                        grad[i] = known(plain[i], n);
                    }
                }
                _ => {
                    let reached = Self::arguments(
                        x,
                        l,
                        #[inline(always)]
                        |x, l| x.lane(l).reached(),
                    );
                    let mut ranges = f.grad(if by == Expansion::First { reached } else { points(m) });
                    if by == Expansion::First && N == 1 {
                        ranges[0] = chords(f, m, reached[0], ranges[0]);
                    }
                    for i in 0..N {
                        grad[i] = split(ranges[i]);
                    }
                }
            }
            for i in 0..N {
                let [mid, rad] = grad[i];
                slope[i][l] = mid;
                steep[i][l] = mid.abs() + rad;
                vague[i][l] = rad + SUMS * steep[i][l];
            }
        }
        for j in 1..3 {
            (out.mid[j], out.rest[j]) = ([0.0; B], [0.0; B]);
        }
        out.side = [[0.0; B]; K];
        out.tilt(x, by, &slope, &steep, &vague);
        if by != Expansion::First {
            out.bend(f, x, by);
        }
        out.round();
    }

    /// Sets the ranges to those of a function of others.
    #[inline(always)]
    pub(super) fn enclose<F: Function<N>, const N: usize>(&mut self, f: &F, x: &[&Self; N]) {
        for l in 0..B {
            let range = f.range(Self::arguments(
                x,
                l,
                #[inline(always)]
                |x, l| x.range.lane(l),
            ));
            self.range.set(l, range);
        }
    }

    /// Makes room for what the sums of rests have lost.
    #[inline(always)]
    pub(super) fn round(&mut self) {
        for l in 0..B {
            for j in 0..3 {
                self.rest[j][l] *= ROUND_UP;
            }
            self.rest[0][l] += TINY;
        }
    }

    /// Adds the linear terms: partial derivatives `slope`, at most `steep`, known to within `vague`.
    #[inline(always)]
    pub(super) fn tilt<const N: usize>(
        &mut self,
        x: &[&Self; N],
        by: Expansion,
        slope: &[[f64; B]; N],
        steep: &[[f64; B]; N],
        vague: &[[f64; B]; N],
    ) {
        for i in 0..N {
            for l in 0..B {
                self.rest[0][l] += by.product(steep[i][l], x[i].rest[0][l]);
            }
            for j in 1..3 {
                for l in 0..B {
                    self.mid[j][l] += slope[i][l] * x[i].mid[j][l];
                    self.rest[j][l] += by.product(steep[i][l], x[i].rest[j][l])
                        + by.product(vague[i][l], x[i].mid[j][l].abs());
                }
            }
            for k in 0..K {
                for l in 0..B {
                    self.side[k][l] += slope[i][l] * x[i].side[k][l];
                    self.rest[0][l] += by.product(vague[i][l], x[i].side[k][l].abs());
                }
            }
        }
    }

    /// Adds the quadratic terms.
    #[inline(always)]
    fn bend<F: Function<N>, const N: usize>(&mut self, f: &F, x: &[&Self; N], by: Expansion) {
        let (mut off, mut bent) = ([[0.0; B]; N], [[0.0; B]; N]);
        for i in 0..N {
            for l in 0..B {
                let lane = x[i].lane(l);
                (off[i][l], bent[i][l]) = (lane.off_middle(), lane.bent());
            }
        }
        // One that is the same everywhere is known when this is compiled, and so are its zeros.
        let same = if f.is_quadratic() { Some(f.hess([ZERO; N])) } else { None };
        let mut hess = [[Band::<B>::all(ZERO); N]; N];
        for l in 0..if same.is_some() { 0 } else { B } {
            let at = Self::arguments(
                x,
                l,
                #[inline(always)]
                |x, l| x.lane(l).reached(),
            );
            if let Some(all) = f.curvature(&at) {
                for i in 0..N {
                    hess[i][i].set(l, all);
                }
            } else {
                let h = f.hess(at);
                for i in 0..N {
                    for j in 0..N {
                        if j <= i {
                            hess[i][j].set(l, h[i][j]);
                        }
                    }
                }
            }
        }
        for i in 0..N {
            if same.is_some_and(|h| h[i][i] == ZERO) {
                continue;
            }
            for l in 0..B {
                let h = same.map_or(hess[i][i].lane(l), |h| h[i][i]);
                self.bow(l, by, h, [off[i][l], x[i].mid[1][l].abs(), bent[i][l]]);
            }
        }
        for i in 0..N {
            for j in 0..i {
                if same.is_some_and(|h| h[i][j] == ZERO) {
                    continue;
                }
                for l in 0..B {
                    let h = same.map_or(hess[i][j].lane(l), |h| h[i][j]);
                    let ([v, w], [s, t]) = ([off[i][l], off[j][l]], [x[i].mid[1][l], x[j].mid[1][l]]);
                    let [q, r] = [bent[i][l], bent[j][l]];
                    let (p, doubt) = (s * t, s.abs() * r + q * t.abs() + q * r);
                    let (m, width) = (h.mid(), h.rad());
                    let silent = (by == Expansion::Careful) & (h.lo == 0.0) & (h.hi == 0.0);
                    let size = doubt + SUMS * p.abs();
                    self.mid[2][l] += choose(silent, 0.0, m * p);
                    self.rest[2][l] += choose(silent, 0.0, h.mag() * size + width * p.abs());
                    self.rest[0][l] += choose(silent, 0.0, h.mag() * (v * w));
                    let across = v * (t.abs() + r) + w * (s.abs() + q);
                    self.rest[1][l] += choose(silent, 0.0, h.mag() * across);
                }
            }
        }
    }

    /// Adds `h d^2 / 2` for a departure `d` of at most `y` in the middle, and of a slope of the size `s`, known to
    /// within `q`.
    #[inline(always)]
    pub(super) fn bow(&mut self, l: usize, by: Expansion, h: Interval, [y, s, q]: [f64; 3]) {
        let (near, far) = (choose(s > q, s - q, 0.0), s + q);
        self.include(0, l, by.half_square(h, 0.0, y));
        self.include(2, l, by.half_square(h, near, far));
        self.rest[1][l] += by.product(h.mag(), y * far);
    }

    /// Adds a term that is somewhere in an interval, times a power of `e`.
    #[inline(always)]
    fn include(&mut self, power: usize, l: usize, [lo, hi]: [f64; 2]) {
        let (mid, half) = (0.5 * lo + 0.5 * hi, 0.5 * hi - 0.5 * lo);
        self.mid[power][l] += mid;
        self.rest[power][l] += half + SUMS * (choose(-lo > hi, -lo, hi) + half);
    }

    /// A function that selects one of two arguments departs from the middle as a mixture of both does. The one that is
    /// selected there has all of it, but for as far as the other one may come to be selected (`mixture`).
    #[inline(always)]
    fn selected<F: Function<N>, const N: usize>(f: &F, x: &[&Self; N], out: &mut Self) {
        // Positive where an argument may be selected.
        let mut chance = [[0.0; B]; N];
        // Which one it is depends on how far they are apart, which may be known better than they are.
        let mut apart = Band::<B>::all(ZERO);
        for l in 0..B {
            let difference = x[0].lane(l).plus(&x[N - 1].lane(l).negated());
            let difference = difference.narrowed(difference.range).range;
            let mut at = [ZERO; N];
            at[0] = difference;
            let grad = f.grad(at);
            for i in 0..N {
                chance[i][l] = grad[i].hi;
            }
            apart.set(l, difference);
        }
        // The others have none.
        let is_sole = |i: usize, l: usize| {
            let mut sole = true;
            for k in 0..N {
                sole &= (chance[k][l] > 0.0) == (k == i);
            }
            sole
        };
        for i in 0..N {
            let mut always = true;
            for l in 0..B {
                always &= is_sole(i, l);
            }
            if always {
                *out = *x[i];
                return;
            }
        }
        let mut share = [[0.0; B]; 2];
        for l in 0..B {
            let [least, most] = mixture(f, x[0].mid[0][l] - x[N - 1].mid[0][l], apart.lane(l));
            (share[0][l], share[1][l]) = (least, most);
        }
        out.fill(
            #[inline(always)]
            |l| {
                let mut middles = [ZERO; N];
                let mut ranges = [ZERO; N];
                for i in 0..N {
                    middles[i] = point(x[i].mid[0][l]);
                    ranges[i] = x[i].range.lane(l);
                }
                let known = f.range(ranges);
                let value = f.range(middles).mid();
                let mut out = Parabola::constant(known);
                let (a, b) = (x[0].lane(l), x[N - 1].lane(l));
                for j in 0..3 {
                    let part = |p: &Parabola<K>| (choose(j == 0, 0.0, p.mid[j]), p.rest[j]);
                    let ((m, r), (n, s)) = (part(&a), part(&b));
                    let [lo, _] = mixed(share[0][l], share[1][l], m - r, n - s);
                    let [_, hi] = mixed(share[0][l], share[1][l], m + r, n + s);
                    let size = m.abs() + r + n.abs() + s;
                    out.mid[j] = 0.5 * lo + 0.5 * hi;
                    out.rest[j] = 0.5 * hi - 0.5 * lo + 2.0 * CHARGE * size;
                }
                for k in 0..K {
                    let [lo, hi] = mixed(share[0][l], share[1][l], a.side[k], b.side[k]);
                    let size = a.side[k].abs() + b.side[k].abs();
                    out.side[k] = 0.5 * lo + 0.5 * hi;
                    out.rest[0] += 0.5 * hi - 0.5 * lo + 2.0 * CHARGE * size;
                }
                let m = out.mid[0] + value;
                out.rest[0] = (out.rest[0] + CHARGE * (value.abs() + m.abs())) * ROUND_UP + TINY;
                out.mid[0] = m;
                let mut out = out.settled(known);
                for i in 0..N {
                    out = out.unless(is_sole(i, l), &x[i].lane(l));
                }
                out
            },
        );
    }
}
