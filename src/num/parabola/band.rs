//! Batches of intervals as structures of arrays.
//!
//! A lane is an [`Interval`]; only the layout in memory differs, so that a loop over lanes becomes
//! vector instructions.

use crate::num::Interval;

/// `B` intervals side by side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Band<const B: usize> {
    lo: [f64; B],
    hi: [f64; B],
}

impl<const B: usize> Band<B> {
    /// The same interval in every lane.
    #[inline(always)]
    pub fn all(x: Interval) -> Self {
        Band { lo: [x.lo; B], hi: [x.hi; B] }
    }

    /// A lane.
    #[inline(always)]
    pub fn lane(&self, i: usize) -> Interval {
        Interval { lo: self.lo[i], hi: self.hi[i] }
    }

    /// Sets a lane.
    #[inline(always)]
    pub fn set(&mut self, i: usize, x: Interval) {
        (self.lo[i], self.hi[i]) = (x.lo, x.hi);
    }

    /// Of the intervals in each lane.
    #[inline(always)]
    pub fn map(&self, f: impl Fn(Interval) -> Interval) -> Self {
        self.with(self, |x, _| f(x))
    }

    /// Of both intervals in each lane.
    #[inline(always)]
    pub fn with(&self, other: &Self, f: impl Fn(Interval, Interval) -> Interval) -> Self {
        let mut out = *self;
        for i in 0..B {
            out.set(i, f(self.lane(i), other.lane(i)));
        }
        out
    }

    /// Whether something holds of both intervals in every lane.
    #[inline(always)]
    pub fn every(&self, other: &Self, holds: impl Fn(Interval, Interval) -> bool) -> bool {
        (0..B).all(|i| holds(self.lane(i), other.lane(i)))
    }
}
