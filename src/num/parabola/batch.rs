//! Batches of parabolas, as a structure of arrays.

use super::Parabola;
use super::band::Band;
use crate::num::simd::widest;
use crate::num::{Function, Interval, Kernel, Number};

/// `B` parabolas side by side, each along a piece of its own.
#[derive(Clone, Copy, Debug)]
pub struct Parabolas<const B: usize, const K: usize> {
    pub(super) mid: [[f64; B]; 3],
    pub(super) rest: [[f64; B]; 3],
    pub(super) side: [[f64; B]; K],
    pub(super) range: Band<B>,
}

impl<const B: usize, const K: usize> Parabolas<B, K> {
    /// The same number in every lane.
    #[inline(always)]
    pub fn all(x: Parabola<K>) -> Self {
        let mut out = Parabolas {
            mid: [[0.0; B]; 3],
            rest: [[0.0; B]; 3],
            side: [[0.0; B]; K],
            range: Band::all(x.range),
        };
        for j in 0..3 {
            (out.mid[j], out.rest[j]) = ([x.mid[j]; B], [x.rest[j]; B]);
        }
        for k in 0..K {
            out.side[k] = [x.side[k]; B];
        }
        out
    }

    /// A lane.
    #[inline(always)]
    pub fn lane(&self, i: usize) -> Parabola<K> {
        let mut side = [0.0; K];
        for k in 0..K {
            side[k] = self.side[k][i];
        }
        Parabola {
            mid: [self.mid[0][i], self.mid[1][i], self.mid[2][i]],
            rest: [self.rest[0][i], self.rest[1][i], self.rest[2][i]],
            side,
            range: self.range.lane(i),
        }
    }

    /// Sets a lane.
    #[inline(always)]
    pub fn set(&mut self, i: usize, x: &Parabola<K>) {
        for j in 0..3 {
            (self.mid[j][i], self.rest[j][i]) = (x.mid[j], x.rest[j]);
        }
        for k in 0..K {
            self.side[k][i] = x.side[k];
        }
        self.range.set(i, x.range);
    }

    /// Writes the lanes one by one, as a plain loop. Nothing that `f` reads is written meanwhile, which
    /// the compiler knows from the signature.
    #[inline(always)]
    pub(super) fn fill(&mut self, f: impl Fn(usize) -> Parabola<K>) {
        for i in 0..B {
            self.set(i, &f(i));
        }
    }

    /// The same, compiled for the widest instruction set.
    #[inline(always)]
    pub(super) fn fill_widest(&mut self, f: impl Fn(usize) -> Parabola<K>) {
        widest(
            #[inline(always)]
            || self.fill(f),
        );
    }

    /// With something added that is somewhere in an interval.
    pub fn shifted_by(&self, c: Interval) -> Self {
        Self::written(|out| {
            out.fill_widest(
                #[inline(always)]
                |i| self.lane(i).plus(&Parabola::constant(c)),
            );
        })
    }

    /// The batch that `job` writes.
    #[inline(always)]
    pub(super) fn written(job: impl FnOnce(&mut Self)) -> Self {
        let mut out = Self::constant(0.0);
        job(&mut out);
        out
    }
}

impl<const B: usize, const K: usize> Number for Parabolas<B, K> {
    fn constant(c: f64) -> Self {
        Self::all(Parabola::constant(Interval::point(c)))
    }
    fn add(&self, other: &Self) -> Self {
        Self::written(|out| self.add_to(other, out))
    }
    fn sub(&self, other: &Self) -> Self {
        Self::written(|out| self.sub_to(other, out))
    }
    fn neg(&self) -> Self {
        Self::written(|out| {
            out.fill_widest(
                #[inline(always)]
                |i| self.lane(i).negated(),
            );
        })
    }
    fn scale(&self, k: f64) -> Self {
        Self::written(|out| self.scale_to(k, out))
    }
    fn shift(&self, c: f64) -> Self {
        Self::written(|out| self.shift_to(c, out))
    }
    fn lift<F: Function<N>, const N: usize>(f: &F, x: [&Self; N]) -> Self {
        Self::written(|out| Self::lifted(f, &x, out))
    }
    fn add_to(&self, other: &Self, out: &mut Self) {
        out.fill_widest(
            #[inline(always)]
            |i| {
                let sum = self.lane(i).plus(&other.lane(i));
                sum.narrowed(sum.range)
            },
        );
    }
    fn sub_to(&self, other: &Self, out: &mut Self) {
        out.fill_widest(
            #[inline(always)]
            |i| {
                let difference = self.lane(i).plus(&other.lane(i).negated());
                difference.narrowed(difference.range)
            },
        );
    }
    fn add_scaled(&mut self, other: &Self, k: f64) {
        widest(
            #[inline(always)]
            || {
                for i in 0..B {
                    let sum = self.lane(i).plus(&other.lane(i).times(k));
                    self.set(i, &sum.narrowed(sum.range));
                }
            },
        );
    }
    fn scale_to(&self, k: f64, out: &mut Self) {
        out.fill_widest(
            #[inline(always)]
            |i| self.lane(i).times(k),
        );
    }
    fn shift_to(&self, c: f64, out: &mut Self) {
        out.fill_widest(
            #[inline(always)]
            |i| self.lane(i).shifted(c),
        );
    }
    fn lift_to<F: Function<N>, const N: usize>(f: &F, x: [&Self; N], out: &mut Self) {
        Self::lifted(f, &x, out);
    }
    fn kernel<K2: Kernel + ?Sized>(k: &K2, p: [&Self; 3]) -> Self {
        Self::written(|out| Self::image(k, p, out))
    }
    fn kernel_to<K2: Kernel + ?Sized>(k: &K2, p: [&Self; 3], out: &mut Self) {
        Self::image(k, p, out);
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
