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
}
