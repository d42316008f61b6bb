//! Batches of expansions, as a structure of arrays.

use super::Taylor;
use crate::num::simd::widest;
use crate::num::{Function, Interval, Kernel, Number};

/// `B` expansions side by side, each over a ball of its own.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Taylors<const B: usize> {
    pub(super) value: [f64; B],
    pub(super) grad: [[f64; B]; 3],
    pub(super) hess: [[f64; B]; 6],
    pub(super) bow: [[f64; B]; 2],
    pub(super) turn: [[f64; B]; 2],
    pub(super) twist: [f64; B],
    pub(super) range: [[f64; B]; 2],
}

impl<const B: usize> Taylors<B> {
    /// Changes a lane of the coordinates of balls to another ball.
    #[inline(always)]
    pub fn set_ball(coordinates: &mut [Self; 3], lane: usize, centre: [f64; 3], radius: f64) {
        for axis in 0..3 {
            coordinates[axis].set(lane, &Taylor::coordinate(centre[axis], radius, axis));
        }
    }

    /// Becomes a coordinate over balls, by what it is in their middles and by their radii.
    pub fn set_coordinate(&mut self, axis: usize, middles: &[f64; B], radii: &[f64; B]) {
        widest(
            #[inline(always)]
            || match axis {
                0 => self.become_coordinate::<0>(middles, radii),
                1 => self.become_coordinate::<1>(middles, radii),
                _ => self.become_coordinate::<2>(middles, radii),
            },
        );
    }

    #[inline(always)]
    fn become_coordinate<const AXIS: usize>(&mut self, middles: &[f64; B], radii: &[f64; B]) {
        self.fill(
            #[inline(always)]
            |lane| Taylor::coordinate(middles[lane], radii[lane], AXIS),
        );
    }

    /// Sets a lane of three coordinates to a straight line through a point, which reaches so far to either side. What
    /// is computed from them is known along it: derivatives are the first ones, in units of half its length.
    pub fn set_line(coordinates: &mut [Self; 3], lane: usize, middle: [f64; 3], half: [f64; 3]) {
        for axis in 0..3 {
            coordinates[axis].set(lane, &Taylor::along(middle[axis], half[axis]));
        }
    }

    #[inline(always)]
    fn all(x: &Taylor) -> Self {
        Self::written(|out| {
            out.fill(
                #[inline(always)]
                |_| *x,
            );
        })
    }

    /// A lane.
    #[inline(always)]
    pub fn lane(&self, i: usize) -> Taylor {
        let mut hess = [0.0; 6];
        for k in 0..6 {
            hess[k] = self.hess[k][i];
        }
        Taylor {
            value: self.value[i],
            grad: [self.grad[0][i], self.grad[1][i], self.grad[2][i]],
            hess,
            bow: [self.bow[0][i], self.bow[1][i]],
            turn: [self.turn[0][i], self.turn[1][i]],
            twist: self.twist[i],
            range: Interval { lo: self.range[0][i], hi: self.range[1][i] },
        }
    }

    /// Sets a lane.
    #[inline(always)]
    pub(super) fn set(&mut self, i: usize, x: &Taylor) {
        self.value[i] = x.value;
        for k in 0..3 {
            self.grad[k][i] = x.grad[k];
        }
        for k in 0..6 {
            self.hess[k][i] = x.hess[k];
        }
        for k in 0..2 {
            (self.bow[k][i], self.turn[k][i]) = (x.bow[k], x.turn[k]);
        }
        self.twist[i] = x.twist;
        (self.range[0][i], self.range[1][i]) = (x.range.lo, x.range.hi);
    }

    /// Changes a lane to the quantity [on](Taylor::on) a disc or a diameter of its ball.
    pub fn hold(&mut self, i: usize, free: [bool; 3]) {
        let held = self.lane(i).on(free);
        self.set(i, &held);
    }

    /// Writes the lanes one by one, as a plain loop. Nothing that `f` reads is written meanwhile, which
    /// the compiler knows from the signature.
    #[inline(always)]
    pub(super) fn fill(&mut self, f: impl Fn(usize) -> Taylor) {
        for i in 0..B {
            self.set(i, &f(i));
        }
    }

    /// The same, compiled for the widest instruction set.
    #[inline(always)]
    pub(super) fn fill_widest(&mut self, f: impl Fn(usize) -> Taylor) {
        widest(
            #[inline(always)]
            || self.fill(f),
        );
    }

    /// Adds `k` times another batch. The compiler knows from the signature that the two are not one.
    #[inline(always)]
    fn accumulate(&mut self, other: &Self, k: f64) {
        for i in 0..B {
            let sum = self.lane(i).plus(&other.lane(i).times(k));
            self.set(i, &sum);
        }
    }

    /// The batch that `job` writes.
    #[inline(always)]
    pub(super) fn written(job: impl FnOnce(&mut Self)) -> Self {
        let mut out = Taylors {
            value: [0.0; B],
            grad: [[0.0; B]; 3],
            hess: [[0.0; B]; 6],
            bow: [[0.0; B]; 2],
            turn: [[0.0; B]; 2],
            twist: [0.0; B],
            range: [[0.0; B]; 2],
        };
        job(&mut out);
        out
    }
}

impl<const B: usize> Number for Taylors<B> {
    fn constant(c: f64) -> Self {
        Self::all(&Taylor::constant(c))
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
            |i| self.lane(i).plus(&other.lane(i)),
        );
    }
    fn sub_to(&self, other: &Self, out: &mut Self) {
        out.fill_widest(
            #[inline(always)]
            |i| self.lane(i).plus(&other.lane(i).negated()),
        );
    }
    fn add_scaled(&mut self, other: &Self, k: f64) {
        widest(
            #[inline(always)]
            || self.accumulate(other, k),
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
    fn kernel<K: Kernel + ?Sized>(k: &K, p: [&Self; 3]) -> Self {
        Self::written(|out| Self::image(k, p, out))
    }
    fn kernel_to<K: Kernel + ?Sized>(k: &K, p: [&Self; 3], out: &mut Self) {
        Self::image(k, p, out);
    }
    fn choose(by: &Self, test: impl Fn(Interval) -> bool, yes: &Self, no: &Self) -> Self {
        let mut out = *no;
        for i in 0..B {
            if test(by.lane(i).range) {
                out.set(i, &yes.lane(i));
            }
        }
        out
    }
    fn range(&self) -> Interval {
        let [lo, hi] = &self.range;
        let lane = |i: usize| Interval { lo: lo[i], hi: hi[i] };
        (1..B).fold(lane(0), |all, i| all.hull(lane(i)))
    }
}
