//! Smooth corners between two parabolas.
//!
//! A corner `y + g(x - y)` bends along the difference alone. With `d` the departure of the difference from the one in
//! the middle, and `s` the slope of `g` there,
//!
//! ```text
//! f = f(m) + s (x - m_x) + (1 - s) (y - m_y) + 1/2 g''(t) d^2,     t in the range of x - y
//! ```
//!
//! where three entries of a Hessian, each with a sign of its own, would forget that `d` is small where both depart
//! alike. And where the difference is beyond the corner's reach one of the two is all there is.

use super::Parabola;
use super::batch::Parabolas;
use super::lift::{Expansion, SUMS, ZERO, point};
use crate::num::Function;
use crate::num::simd::widest;

/// What is known of the differences of the arguments of corners.
pub(super) struct Corners<const B: usize, const K: usize> {
    apart: Parabolas<B, K>,
    /// Whether the first argument, or the second one, is all there is.
    is_sole: [[bool; B]; 2],
}

impl<const B: usize, const K: usize> Corners<B, K> {
    /// Those of a function that has a seam.
    #[inline(always)]
    pub fn new<F: Function<N>, const N: usize>(f: &F, x: &[&Parabolas<B, K>; N]) -> Self {
        let mut out = Corners { apart: Parabolas::all(Parabola::constant(ZERO)), is_sole: [[false; B]; 2] };
        let reach = f.seam(&[0.0; N], ZERO).map_or(f64::INFINITY, |seam| seam.reach);
        widest(
            #[inline(always)]
            || {
                for l in 0..B {
                    let apart = x[0].lane(l).plus(&x[N - 1].lane(l).negated());
                    let apart = apart.narrowed(apart.range);
                    out.apart.set(l, &apart);
                    out.is_sole[0][l] = apart.range.hi <= -reach;
                    out.is_sole[1][l] = apart.range.lo >= reach;
                }
            },
        );
        out
    }

    /// The argument that is all there is in all lanes.
    #[inline(always)]
    pub fn sole(&self) -> Option<usize> {
        (0..2).find(|&i| self.is_sole[i] == [true; B])
    }

    /// The form of the function, with its range apart; see the module text.
    #[inline(always)]
    pub fn expand<F: Function<N>, const N: usize>(
        &self,
        f: &F,
        x: &[&Parabolas<B, K>; N],
        out: &mut Parabolas<B, K>,
    ) {
        let (mut slope, mut steep, mut vague) = ([[0.0; B]; N], [[0.0; B]; N], [[0.0; B]; N]);
        let mut bend = [ZERO; B];
        for l in 0..B {
            let m = middles(x, l);
            let middle = point(m[0]) - point(m[N - 1]);
            let value = f.value(m);
            // Where there is none nothing is known.
            let seam = f.seam(&m, self.apart.lane(l).range.hull(middle));
            let [blur, skew] = seam.map_or([f64::NAN; 2], |seam| seam.blur);
            bend[l] = seam.map_or(ZERO, |seam| seam.bend);
            (out.mid[0][l], out.rest[0][l]) = (value, blur + SUMS * value.abs());
            let grad = f.grad(m);
            for i in 0..N {
                slope[i][l] = grad[i];
                steep[i][l] = grad[i].abs() + skew;
                vague[i][l] = skew + SUMS * steep[i][l];
            }
        }
        out.enclose(f, x);
        for j in 1..3 {
            (out.mid[j], out.rest[j]) = ([0.0; B], [0.0; B]);
        }
        out.side = [[0.0; B]; K];
        out.tilt(x, Expansion::Second, &slope, &steep, &vague);
        for l in 0..B {
            let apart = self.apart.lane(l);
            let departs = [apart.off_middle(), apart.mid[1].abs(), apart.bent()];
            out.bow(l, Expansion::Second, bend[l], departs);
        }
        out.round();
    }

    /// Leaves in each lane the argument that is all there is.
    pub fn leave<const N: usize>(&self, x: &[&Parabolas<B, K>; N], out: &mut Parabolas<B, K>) {
        widest(
            #[inline(always)]
            || {
                for l in 0..B {
                    let lane = out.lane(l).unless(self.is_sole[0][l], &x[0].lane(l));
                    out.set(l, &lane.unless(self.is_sole[1][l], &x[N - 1].lane(l)));
                }
            },
        );
    }
}

/// The middles of the arguments.
#[inline(always)]
fn middles<const B: usize, const K: usize, const N: usize>(x: &[&Parabolas<B, K>; N], l: usize) -> [f64; N] {
    let mut out = [0.0; N];
    for i in 0..N {
        out[i] = x[i].mid[0][l];
    }
    out
}
