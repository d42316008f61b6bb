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
use super::{CHARGE, Parabola, ROUND_UP, TINY, choose};
use crate::num::ROUNDOFF;
use crate::num::simd::widest;
use crate::num::{Function, Interval};

/// Where partial derivatives are taken.
#[derive(Clone, Copy, PartialEq)]
enum Expansion {
    /// First ones in the middle, second ones everywhere.
    Second,
    /// First ones everywhere.
    First,
}

/// Covers the rounding of sums of up to thirty products, in proportion to each.
const SUMS: f64 = 32.0 * ROUNDOFF;

const ZERO: Interval = Interval { lo: 0.0, hi: 0.0 };

#[inline(always)]
fn point(x: f64) -> Interval {
    Interval { lo: x, hi: x }
}

/// `a b` for `b >= 0`, where zero silences what is unbounded.
#[inline(always)]
fn silenced(a: f64, b: f64) -> f64 {
    choose((a == 0.0) | (b == 0.0), 0.0, a * b)
}

impl<const B: usize, const K: usize> Parabolas<B, K> {
    /// The image under a function.
    pub(super) fn lifted<F: Function<N>, const N: usize>(f: &F, x: &[&Self; N]) -> Self {
        if f.is_vague() {
            let mut out = Self::all(Parabola::constant(ZERO));
            for l in 0..B {
                let range = f.range(Self::arguments(x, l, |x, l| x.range.lane(l)));
                out.set(l, &Parabola::constant(range));
            }
            return out;
        }
        if f.selects() {
            return widest(
                #[inline(always)]
                || Self::selected(f, x),
            );
        }
        let mut out = widest(
            #[inline(always)]
            || Self::expanded(f, x, Expansion::Second),
        );
        let mut finite = [true; B];
        for i in 0..B {
            finite[i] = out.lane(i).is_finite();
        }
        if finite != [true; B] {
            // Where second derivatives are unbounded, first ones may not be.
            let first = widest(
                #[inline(always)]
                || Self::expanded(f, x, Expansion::First),
            );
            for i in 0..B {
                if !finite[i] {
                    out.set(i, &first.lane(i));
                }
            }
        }
        Self::lanes(
            #[inline(always)]
            |i| {
                let lane = out.lane(i);
                lane.settled(lane.range)
            },
        )
    }

    /// The arguments of lane `l`, each as an interval.
    #[inline(always)]
    fn arguments<const N: usize>(
        x: &[&Self; N],
        l: usize,
        part: impl Fn(&Self, usize) -> Interval,
    ) -> [Interval; N] {
        let mut out = [ZERO; N];
        for i in 0..N {
            out[i] = part(x[i], l);
        }
        out
    }

    /// The form of a function, with its range apart; see the module text.
    #[inline(always)]
    fn expanded<F: Function<N>, const N: usize>(f: &F, x: &[&Self; N], by: Expansion) -> Self {
        let mut out = Self::all(Parabola::constant(ZERO));
        let (mut slope, mut steep, mut vague) = ([[0.0; B]; N], [[0.0; B]; N], [[0.0; B]; N]);
        for l in 0..B {
            let v = f.range(Self::arguments(
                x,
                l,
                #[inline(always)]
                |x, l| point(x.mid[0][l]),
            ));
            (out.mid[0][l], out.rest[0][l]) = (v.mid(), v.rad() + SUMS * v.mag());
        }
        for l in 0..B {
            let range = f.range(Self::arguments(
                x,
                l,
                #[inline(always)]
                |x, l| x.range.lane(l),
            ));
            out.range.set(l, range);
        }
        for l in 0..B {
            let grad = f.grad(Self::arguments(
                x,
                l,
                #[inline(always)]
                |x, l| match by {
                    Expansion::Second => point(x.mid[0][l]),
                    Expansion::First => x.lane(l).reached(),
                },
            ));
            for i in 0..N {
                slope[i][l] = grad[i].mid();
                steep[i][l] = grad[i].mag();
                vague[i][l] = grad[i].rad() + SUMS * steep[i][l];
            }
        }
        out.tilt(x, &slope, &steep, &vague);
        if by == Expansion::Second {
            out.bend(f, x);
        }
        for l in 0..B {
            for j in 0..3 {
                out.rest[j][l] *= ROUND_UP;
            }
            out.rest[0][l] += TINY;
        }
        out
    }

    /// Adds the linear terms: partial derivatives `slope`, at most `steep`, known to within `vague`.
    #[inline(always)]
    fn tilt<const N: usize>(
        &mut self,
        x: &[&Self; N],
        slope: &[[f64; B]; N],
        steep: &[[f64; B]; N],
        vague: &[[f64; B]; N],
    ) {
        for i in 0..N {
            for l in 0..B {
                self.rest[0][l] += silenced(steep[i][l], x[i].rest[0][l]);
            }
            for j in 1..3 {
                for l in 0..B {
                    self.mid[j][l] += slope[i][l] * x[i].mid[j][l];
                    self.rest[j][l] +=
                        silenced(steep[i][l], x[i].rest[j][l]) + silenced(vague[i][l], x[i].mid[j][l].abs());
                }
            }
            for k in 0..K {
                for l in 0..B {
                    self.side[k][l] += slope[i][l] * x[i].side[k][l];
                    self.rest[0][l] += silenced(vague[i][l], x[i].side[k][l].abs());
                }
            }
        }
    }

    /// Adds the quadratic terms.
    #[inline(always)]
    fn bend<F: Function<N>, const N: usize>(&mut self, f: &F, x: &[&Self; N]) {
        let (mut off, mut bent) = ([[0.0; B]; N], [[0.0; B]; N]);
        for i in 0..N {
            for l in 0..B {
                let lane = x[i].lane(l);
                (off[i][l], bent[i][l]) = (lane.off_middle(), lane.bent());
            }
        }
        let mut hess = [[Band::<B>::all(ZERO); N]; N];
        for l in 0..B {
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
            for l in 0..B {
                let h = hess[i][i].lane(l);
                let (y, s, q) = (off[i][l], x[i].mid[1][l].abs(), bent[i][l]);
                let (near, far) = (choose(s > q, s - q, 0.0), s + q);
                self.include(0, l, half_square(h, 0.0, y));
                self.include(2, l, half_square(h, near, far));
                self.rest[1][l] += silenced(h.mag(), y * far);
            }
        }
        for i in 0..N {
            for j in 0..i {
                for l in 0..B {
                    let h = hess[i][j].lane(l);
                    let ([v, w], [s, t]) = ([off[i][l], off[j][l]], [x[i].mid[1][l], x[j].mid[1][l]]);
                    let [q, r] = [bent[i][l], bent[j][l]];
                    let (p, doubt) = (s * t, s.abs() * r + q * t.abs() + q * r);
                    let (m, width) = (h.mid(), h.rad());
                    let silent = (h.lo == 0.0) & (h.hi == 0.0);
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

    /// Adds a term that is somewhere in an interval, times a power of `e`.
    #[inline(always)]
    fn include(&mut self, power: usize, l: usize, [lo, hi]: [f64; 2]) {
        let (mid, half) = (0.5 * lo + 0.5 * hi, 0.5 * hi - 0.5 * lo);
        self.mid[power][l] += mid;
        self.rest[power][l] += half + SUMS * (choose(-lo > hi, -lo, hi) + half);
    }

    /// A function that selects one of its arguments departs from the middle as one of them does that
    /// may be selected.
    #[inline(always)]
    fn selected<F: Function<N>, const N: usize>(f: &F, x: &[&Self; N]) -> Self {
        Self::lanes(
            #[inline(always)]
            |l| {
                let mut middles = [ZERO; N];
                let mut ranges = [ZERO; N];
                let mut apart = [ZERO; N];
                let first = x[0].lane(l);
                for i in 0..N {
                    let lane = x[i].lane(l);
                    middles[i] = point(lane.mid[0]);
                    ranges[i] = lane.range;
                    // Which is selected depends on how far they are apart, which may be known better
                    // than they are.
                    let difference = lane.plus(&first.negated());
                    apart[i] = difference.narrowed(difference.range).range;
                }
                apart[0] = ZERO;
                let grad = f.grad(apart);
                let known = f.range(ranges);
                let value = f.range(middles).mid();
                let mut out = Parabola::constant(known);
                let mut low = Departure { mid: [f64::INFINITY; 3], side: [f64::INFINITY; K] };
                let mut high = Departure { mid: [f64::NEG_INFINITY; 3], side: [f64::NEG_INFINITY; K] };
                for i in 0..N {
                    let lane = x[i].lane(l);
                    let may = grad[i].hi > 0.0;
                    for j in 0..3 {
                        let m = choose(j == 0, 0.0, lane.mid[j]);
                        let (least, most) = (m - lane.rest[j], m + lane.rest[j]);
                        low.mid[j] = choose(may & replaces(least < low.mid[j], least), least, low.mid[j]);
                        high.mid[j] = choose(may & replaces(most > high.mid[j], most), most, high.mid[j]);
                    }
                    for k in 0..K {
                        let s = lane.side[k];
                        low.side[k] = choose(may & replaces(s < low.side[k], s), s, low.side[k]);
                        high.side[k] = choose(may & replaces(s > high.side[k], s), s, high.side[k]);
                    }
                }
                for j in 0..3 {
                    let (lo, hi) = (low.mid[j], high.mid[j]);
                    let (m, half) = (0.5 * lo + 0.5 * hi, 0.5 * hi - 0.5 * lo);
                    out.mid[j] = m;
                    out.rest[j] = half + CHARGE * (choose(-lo > hi, -lo, hi) + half);
                }
                for k in 0..K {
                    let (lo, hi) = (low.side[k], high.side[k]);
                    out.side[k] = 0.5 * lo + 0.5 * hi;
                    out.rest[0] += 0.5 * hi - 0.5 * lo + CHARGE * choose(-lo > hi, -lo, hi);
                }
                let m = out.mid[0] + value;
                out.rest[0] = (out.rest[0] + CHARGE * (value.abs() + m.abs())) * ROUND_UP + TINY;
                out.mid[0] = m;
                out.settled(known)
            },
        )
    }
}

/// Whether a number takes the place of another: if it is beyond it, or is none, which must not be lost.
#[inline(always)]
fn replaces(beyond: bool, number: f64) -> bool {
    beyond | number.is_nan()
}

/// One end of what the arguments of a selecting function do away from the middle.
struct Departure<const K: usize> {
    mid: [f64; 3],
    side: [f64; K],
}

/// `h x^2 / 2` for `x` from `near` to `far`, both at least 0.
#[inline(always)]
fn half_square(h: Interval, near: f64, far: f64) -> [f64; 2] {
    let (near, far) = (0.5 * near * near, 0.5 * far * far);
    let lo = silenced(h.lo, choose(h.lo < 0.0, far, near));
    let hi = silenced(h.hi, choose(h.hi < 0.0, near, far));
    [lo, hi]
}

impl<const K: usize> Parabola<K> {
    #[inline(always)]
    fn is_finite(&self) -> bool {
        let mut sum = 0.0;
        for j in 0..3 {
            sum += self.mid[j].abs() + self.rest[j];
        }
        for k in 0..K {
            sum += self.side[k].abs();
        }
        sum.is_finite()
    }
}
