//! Functions of expansions.
//!
//! With `m_i` the arguments in the centre, `d_i = x_i - m_i`, and `a_i(u)` by how much the partial derivative
//! `f_i` differs from the one in the centre,
//!
//! ```text
//! grad f(u) = sum (f_i + a_i) grad x_i         H(u) = sum (f_i + a_i) H_i + sum f_ij(u) grad x_i grad x_j^T
//! ```
//!
//! What these are apart from their expansions follows by sorting terms, from how far each argument departs
//! from its own. Second derivatives `f_ij` vary by at most `spread_ij` over the box of the arguments, of
//! which their ranges tell; with it `a_i` is `sum f_ij g_j . u` but for `sum spread_ij |d_j| + |f_ij| bow_j`.

use super::batch::Taylors;
use super::{ROUND_UP, TINY, least, length, spectral};
use crate::num::interval::choose;
use crate::num::parabola::known;
use crate::num::simd::widest;
use crate::num::{Function, Interval, PAIRS, ROUNDOFF};

/// Covers the rounding of sums of up to forty products of three, in proportion to their sizes.
const SUMS: f64 = 48.0 * ROUNDOFF;

const ZERO: Interval = Interval { lo: 0.0, hi: 0.0 };

/// What a function says of its arguments' boxes.
struct Partials<const N: usize, const B: usize> {
    /// First ones in the centre.
    grad: [[f64; B]; N],
    /// By how much these may be off.
    vague: [[f64; B]; N],
    /// Second ones in the middle of their range,
    hess: [[[f64; B]; N]; N],
    /// and how far they may be from it.
    spread: [[[f64; B]; N]; N],
    /// How far first ones go from those in the centre, where second ones are not bounded.
    sway: [[f64; B]; N],
    /// Which of these are not zero everywhere.
    bends: [[bool; N]; N],
}

/// What is known of the arguments.
struct Arguments<const N: usize, const B: usize> {
    /// Norms of the gradients in the centre,
    slope: [[f64; B]; N],
    /// and anywhere.
    steep: [[f64; B]; N],
    /// How far the values go from the one in the centre.
    far: [[f64; B]; N],
    /// Norms of the second derivatives in the centre.
    bent: [[f64; B]; N],
}

/// `a b` of two sizes; nothing times what is unbounded is nothing.
#[inline(always)]
fn product(a: f64, b: f64) -> f64 {
    choose((a == 0.0) | (b == 0.0), 0.0, a * b)
}

impl<const N: usize, const B: usize> Partials<N, B> {
    /// A quantity is computed for all lanes before the next one is, since a loop that computes all of them
    /// is too much for the compiler to vectorise.
    #[inline(always)]
    fn new<F: Function<N>>(f: &F, x: &[&Taylors<B>; N]) -> Self {
        let mut out = Partials {
            grad: [[0.0; B]; N],
            vague: [[0.0; B]; N],
            hess: [[[0.0; B]; N]; N],
            spread: [[[0.0; B]; N]; N],
            sway: [[f64::INFINITY; B]; N],
            bends: [[true; N]; N],
        };
        for l in 0..B {
            let mut here = [[0.0; 2]; N];
            match f.roundoffs() {
                Some(n) => {
                    let plain = f.grad(plain(x, l));
                    for i in 0..N {
                        here[i] = known(plain[i], n);
                    }
                }
                None => {
                    let ranges = f.grad(points(x, l));
                    for i in 0..N {
                        here[i] = [ranges[i].mid(), ranges[i].rad()];
                    }
                }
            }
            for i in 0..N {
                [out.grad[i][l], out.vague[i][l]] = here[i];
            }
        }
        if is_any(&out.vague, f64::is_nan) {
            out.settle(f, x);
        }
        if f.is_quadratic() {
            let same = f.hess([ZERO; N]);
            for i in 0..N {
                for j in 0..N {
                    out.hess[i][j] = [same[i][j].lo; B];
                    out.bends[i][j] = same[i][j] != ZERO;
                }
            }
            return out;
        }
        for l in 0..B {
            let bend = f.hess(boxes(x, l));
            for i in 0..N {
                for j in 0..=i {
                    (out.hess[i][j][l], out.spread[i][j][l]) = (bend[i][j].mid(), bend[i][j].rad());
                }
            }
        }
        let mut creased = false;
        for i in 0..N {
            creased |= is_any(&out.spread[i][..=i], |spread| !spread.is_finite());
        }
        if creased {
            out.crease(f, x);
        }
        for i in 0..N {
            for j in i + 1..N {
                (out.hess[i][j], out.spread[i][j]) = (out.hess[j][i], out.spread[j][i]);
            }
        }
        out
    }
}

impl<const N: usize, const B: usize> Partials<N, B> {
    /// At a crease first partial derivatives over the boxes say what second ones do not.
    #[cold]
    fn crease<F: Function<N>>(&mut self, f: &F, x: &[&Taylors<B>; N]) {
        for l in 0..B {
            if (0..N).all(|i| (0..=i).all(|j| self.spread[i][j][l].is_finite())) {
                continue;
            }
            for (i, range) in f.grad(boxes(x, l)).into_iter().enumerate() {
                let grad = self.grad[i][l];
                let sway = choose(range.hi - grad > grad - range.lo, range.hi - grad, grad - range.lo);
                self.sway[i][l] = choose(sway.is_finite(), sway, f64::INFINITY);
            }
        }
    }

    /// Takes first partial derivatives from intervals where numbers are too small, or too large, for their rounding
    /// to be known.
    #[cold]
    fn settle<F: Function<N>>(&mut self, f: &F, x: &[&Taylors<B>; N]) {
        for l in 0..B {
            if (0..N).any(|i| self.vague[i][l].is_nan()) {
                let ranges = f.grad(points(x, l));
                for i in 0..N {
                    (self.grad[i][l], self.vague[i][l]) = (ranges[i].mid(), ranges[i].rad());
                }
            }
        }
    }
}

/// Takes values in the centre from intervals where it is not known how far they may be off.
#[cold]
fn settle<F: Function<N>, const N: usize, const B: usize>(
    f: &F,
    x: &[&Taylors<B>; N],
    [value, vague]: [&mut [f64; B]; 2],
) {
    for l in 0..B {
        if vague[l].is_nan() {
            let range = f.range(points(x, l));
            (value[l], vague[l]) = (range.mid(), range.rad());
        }
    }
}

/// Whether something is so in any lane. A loop that left off at the first, or called what is rare, would not be
/// vectorised.
#[inline(always)]
fn is_any<const B: usize>(all: &[[f64; B]], test: impl Fn(f64) -> bool) -> bool {
    let mut any = false;
    for lanes in all {
        for l in 0..B {
            any |= test(lanes[l]);
        }
    }
    any
}

/// The arguments in the centre.
#[inline(always)]
fn plain<const N: usize, const B: usize>(x: &[&Taylors<B>; N], l: usize) -> [f64; N] {
    let mut out = [0.0; N];
    for i in 0..N {
        out[i] = x[i].value[l];
    }
    out
}

/// The same as intervals.
#[inline(always)]
fn points<const N: usize, const B: usize>(x: &[&Taylors<B>; N], l: usize) -> [Interval; N] {
    let mut out = [ZERO; N];
    for i in 0..N {
        out[i] = Interval { lo: x[i].value[l], hi: x[i].value[l] };
    }
    out
}

/// All that they may be.
#[inline(always)]
fn boxes<const N: usize, const B: usize>(x: &[&Taylors<B>; N], l: usize) -> [Interval; N] {
    let mut out = points(x, l);
    for i in 0..N {
        out[i] = out[i].hull(Interval { lo: x[i].range[0][l], hi: x[i].range[1][l] });
    }
    out
}

impl<const N: usize, const B: usize> Arguments<N, B> {
    #[inline(always)]
    fn new(x: &[&Taylors<B>; N]) -> Self {
        let none = [[0.0; B]; N];
        let mut out = Arguments { slope: none, steep: none, far: none, bent: none };
        for i in 0..N {
            for l in 0..B {
                let lane = x[i].lane(l);
                out.slope[i][l] = length(lane.grad);
                out.steep[i][l] = (out.slope[i][l] + lane.turn[0]) * ROUND_UP;
                out.far[i][l] = lane.reach();
                out.bent[i][l] = spectral(lane.hess);
            }
        }
        out
    }
}

impl<const B: usize> Taylors<B> {
    /// Writes the image under a function to `out`; see the module text.
    pub(super) fn lifted<F: Function<N>, const N: usize>(f: &F, x: &[&Self; N], out: &mut Self) {
        let known = widest(
            #[inline(always)]
            || Self::around(f, x, out),
        );
        if known {
            return;
        }
        let (partials, lost);
        // Functions of the mathematical library work lane by lane anyway; to compile all of them for every
        // instruction set would take minutes. Those with few roundoffs are not of that kind.
        if f.is_quadratic() || f.roundoffs().is_some() {
            partials = widest(
                #[inline(always)]
                || Partials::new(f, x),
            );
            lost = out.combine(&partials, x);
            widest(
                #[inline(always)]
                || out.place(f, x, &lost),
            );
        } else {
            partials = Partials::new(f, x);
            lost = out.combine(&partials, x);
            out.place(f, x, &lost);
        }
    }

    /// Sets values and ranges, and makes room for rounding.
    #[inline(always)]
    fn place<F: Function<N>, const N: usize>(&mut self, f: &F, x: &[&Self; N], lost: &[[f64; B]; 2]) {
        let (mut value, mut vague) = ([0.0; B], [0.0; B]);
        for l in 0..B {
            [value[l], vague[l]] = match f.roundoffs() {
                Some(n) => known(f.value(plain(x, l)), n),
                None => {
                    let range = f.range(points(x, l));
                    [range.mid(), range.rad()]
                }
            };
        }
        if is_any(&[vague], f64::is_nan) {
            settle(f, x, [&mut value, &mut vague]);
        }
        for l in 0..B {
            let mut lane = self.lane(l);
            lane.value = value[l];
            lane.blur([vague[l], lost[0][l], lost[1][l]]);
            self.set(l, &lane);
        }
        for l in 0..B {
            let range = f.range(boxes(x, l));
            let lane = self.lane(l).narrowed(range);
            (self.range[0][l], self.range[1][l]) = (lane.range.lo, lane.range.hi);
        }
    }

    /// Sets derivatives and bounds, all that follows from the partial derivatives alone: compiled once for all
    /// functions of so many arguments. Returns by how much the derivatives may be off.
    #[inline(never)]
    fn combine<const N: usize>(&mut self, f: &Partials<N, B>, x: &[&Self; N]) -> [[f64; B]; 2] {
        widest(
            #[inline(always)]
            || {
                let arguments = Arguments::new(x);
                let lost = self.expand(f, &arguments, x);
                self.bound(f, &arguments, x);
                lost
            },
        )
    }

    /// The chain rule: `g = sum f_i g_i`, `H = sum f_i H_i + sum f_ij g_i g_j^T`. Returns by how much either may be
    /// off: their entries are sums of products whose sizes the norms bound, and add up to no more than three times
    /// the Frobenius norm, which is less than twice the spectral one.
    #[inline(always)]
    fn expand<const N: usize>(
        &mut self,
        f: &Partials<N, B>,
        a: &Arguments<N, B>,
        x: &[&Self; N],
    ) -> [[f64; B]; 2] {
        let mut lost = [[0.0; B]; 2];
        let (mut grad, mut hess) = ([[0.0; B]; 3], [[0.0; B]; 6]);
        for i in 0..N {
            // sum f_ij g_j
            let (mut turn, mut size) = ([[0.0; B]; 3], [0.0; B]);
            for j in 0..N {
                if !f.bends[i][j] {
                    continue;
                }
                for l in 0..B {
                    let h = f.hess[i][j][l];
                    size[l] += product(h.abs(), a.slope[j][l]);
                    for axis in 0..3 {
                        turn[axis][l] += h * x[j].grad[axis][l];
                    }
                }
            }
            for l in 0..B {
                let slope = f.grad[i][l];
                for axis in 0..3 {
                    grad[axis][l] += slope * x[i].grad[axis][l];
                }
                for pair in 0..6 {
                    let (row, column) = PAIRS[pair];
                    hess[pair][l] += slope * x[i].hess[pair][l] + x[i].grad[row][l] * turn[column][l];
                }
                let rounded = f.vague[i][l] + 6.0 * SUMS * slope.abs();
                lost[0][l] += product(rounded, a.slope[i][l]);
                lost[1][l] += product(rounded, a.bent[i][l]) + 6.0 * SUMS * product(size[l], a.slope[i][l]);
            }
        }
        (self.grad, self.hess) = (grad, hess);
        lost
    }

    /// What the expansion leaves out.
    #[inline(always)]
    fn bound<const N: usize>(&mut self, f: &Partials<N, B>, a: &Arguments<N, B>, x: &[&Self; N]) {
        let (mut bows, mut turns, mut twist) = ([[0.0; B]; 2], [[0.0; B]; 2], [0.0; B]);
        for i in 0..N {
            let rates = Rates::new(f, a, x, i);
            for l in 0..B {
                let (size, steep) = (f.grad[i][l].abs() + f.vague[i][l], a.steep[i][l]);
                let [bow, bow1, turn, turn1] =
                    [x[i].bow[0][l], x[i].bow[1][l], x[i].turn[0][l], x[i].turn[1][l]];
                let bends = rates.wide[l] + rates.far[l];
                let goes = f.vague[i][l] + least(bends, f.sway[i][l]);
                bows[0][l] += product(size, bow) + product(least(0.5 * bends, f.sway[i][l]), a.far[i][l]);
                bows[1][l] += product(size, bow1)
                    + 0.5 * product(rates.wide[l], a.far[i][l])
                    + 0.5 * product(rates.far[l] + rates.slope[l], bow);
                turns[0][l] += product(size, turn) + product(goes, steep);
                turns[1][l] += product(size, turn1)
                    + product(rates.wide[l] + rates.bow[l], steep)
                    + product(rates.slope[l], turn);
                twist[l] += product(size, x[i].twist[l])
                    + product(goes, a.bent[i][l] + x[i].twist[l])
                    + product(rates.spread[l], steep)
                    + product(rates.steep[l], turn)
                    + product(rates.turn[l], a.slope[i][l]);
            }
        }
        for l in 0..B {
            for k in 0..2 {
                bows[k][l] = bows[k][l] * ROUND_UP + TINY;
                turns[k][l] *= ROUND_UP;
            }
            twist[l] *= ROUND_UP;
        }
        (self.bow, self.turn, self.twist) = (bows, turns, twist);
    }
}

/// Sums over `j` of second partial derivatives, by size or by spread, times what the arguments do.
struct Rates<const B: usize> {
    /// `spread_ij |d_j|`
    wide: [f64; B],
    /// `spread_ij |grad x_j|`
    spread: [f64; B],
    /// `|f_ij| |d_j|`
    far: [f64; B],
    /// `|f_ij| bow_j`
    bow: [f64; B],
    /// `|f_ij| |g_j|`
    slope: [f64; B],
    /// `|f_ij| |grad x_j|`
    steep: [f64; B],
    /// `|f_ij| turn_j`
    turn: [f64; B],
}

impl<const B: usize> Rates<B> {
    #[inline(always)]
    fn new<const N: usize>(f: &Partials<N, B>, a: &Arguments<N, B>, x: &[&Taylors<B>; N], i: usize) -> Self {
        let none = [0.0; B];
        let mut out =
            Rates { wide: none, spread: none, far: none, bow: none, slope: none, steep: none, turn: none };
        for j in 0..N {
            if !f.bends[i][j] {
                continue;
            }
            for l in 0..B {
                let (h, s) = (f.hess[i][j][l].abs(), f.spread[i][j][l]);
                out.wide[l] += product(s, a.far[j][l]);
                out.spread[l] += product(s, a.steep[j][l]);
                out.far[l] += product(h, a.far[j][l]);
                out.bow[l] += product(h, x[j].bow[0][l]);
                out.slope[l] += product(h, a.slope[j][l]);
                out.steep[l] += product(h, a.steep[j][l]);
                out.turn[l] += product(h, x[j].turn[0][l]);
            }
        }
        out
    }
}
