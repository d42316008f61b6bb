//! Places at equal steps over a box, to keep something at each.

use glam::DVec3;

/// The places of a lattice.
#[derive(Clone, Debug)]
pub(super) struct Lattice {
    /// The first place.
    pub origin: DVec3,
    /// From each place to the next, along every axis.
    pub step: f64,
    /// How many places there are along each axis.
    pub size: [usize; 3],
}

impl Lattice {
    /// About so many places over a box, and so many more beyond its end, along each axis.
    pub(super) fn new((lo, hi): (DVec3, DVec3), wanted: f64, more: usize) -> Lattice {
        let diagonal = (hi - lo).length();
        // No axis is so short that the others would have too many.
        let extent = (hi - lo).max(DVec3::splat(diagonal / 64.0)) + DVec3::splat(f64::MIN_POSITIVE);
        let step = libm::cbrt(extent.x / wanted * extent.y * extent.z);
        let size = (extent / step).to_array().map(|n| n as usize + more);
        Lattice { origin: lo, step, size }
    }

    /// Where a place is.
    pub(super) fn place(&self, at: [usize; 3]) -> DVec3 {
        self.origin + self.step * DVec3::new(at[0] as f64, at[1] as f64, at[2] as f64)
    }

    /// The place that is nearest to a point, which need not be one of the lattice.
    #[inline(always)]
    pub(super) fn nearest(&self, x: DVec3) -> [isize; 3] {
        let at = (x - self.origin) / self.step;
        [at.x, at.y, at.z].map(|t| (t + 0.5).floor() as isize)
    }

    /// The number of a place: along x first.
    #[inline(always)]
    pub(super) fn number(&self, at: [usize; 3]) -> usize {
        (at[2] * self.size[1] + at[1]) * self.size[0] + at[0]
    }

    /// The rows along x.
    pub(super) fn rows(&self) -> usize {
        self.size[1] * self.size[2]
    }

    /// The places of a row, in order.
    pub(super) fn row(&self, row: usize) -> impl Iterator<Item = DVec3> + '_ {
        let (j, k) = (row % self.size[1], row / self.size[1]);
        (0..self.size[0]).map(move |i| self.place([i, j, k]))
    }
}
