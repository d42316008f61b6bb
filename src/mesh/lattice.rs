//! The lattice that a solid is sampled on, and the names of the parts of its cells.
//!
//! A cell has the corner numbers `x + 2 y + 4 z` of its offsets. Its edges are numbered
//! `4 axis + u + 2 v`, where `u` and `v` are the offsets along the two axes that follow `axis` in the
//! cycle x, y, z; its faces `2 axis + side`.

use crate::num::Interval;
use crate::scene::Aabb;
use glam::DVec3;

/// Cells along the edge of a block.
pub(super) const SIDE: u32 = 8;

/// The cell, or the corner, that so many steps from the origin begin at.
pub(super) type Place = [u32; 3];

/// Cubic cells in whole blocks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lattice {
    origin: DVec3,
    /// Length of an edge.
    pub step: f64,
    /// Blocks along each axis.
    pub blocks: [u32; 3],
}

impl Lattice {
    /// Cells of so large a step that cover a box, with one more all around, in which the solid is not.
    pub fn over(region: &Aabb, step: f64) -> Lattice {
        let size = (region.max - region.min) / step;
        let blocks = size.to_array().map(|cells| ((cells.ceil() as u32) + 2).div_ceil(SIDE).max(1));
        let spare = DVec3::from_array(blocks.map(|b| f64::from(b * SIDE))) - size;
        Lattice { origin: region.min - 0.5 * step * spare, step, blocks }
    }

    /// Where a corner is.
    pub fn corner(&self, at: Place) -> DVec3 {
        DVec3::new(self.along(0, at[0]), self.along(1, at[1]), self.along(2, at[2]))
    }

    /// A coordinate of the corners of that number along an axis.
    pub fn along(&self, axis: usize, i: u32) -> f64 {
        self.origin[axis] + f64::from(i) * self.step
    }

    /// Where a point is that is so many steps from the origin.
    pub fn point(&self, steps: DVec3) -> DVec3 {
        self.origin + steps * self.step
    }

    /// A coordinate a little beside one, where the field is asked if it has no value at a corner.
    pub fn aside(&self, axis: usize, coordinate: f64) -> f64 {
        coordinate + ASIDE[axis] * self.step
    }

    /// The box of so many cells along each axis, and a little more, so that all that is asked aside is in it.
    pub fn region_and_aside(&self, at: Place, cells: u32) -> [Interval; 3] {
        let region = self.region(at, cells);
        std::array::from_fn(|axis| Interval {
            hi: self.aside(axis, region[axis].hi + ASIDE[axis] * self.step),
            ..region[axis]
        })
    }

    /// The box of so many cells along each axis.
    pub fn region(&self, at: Place, cells: u32) -> [Interval; 3] {
        std::array::from_fn(|axis| {
            Interval::new(self.along(axis, at[axis]), self.along(axis, at[axis] + cells))
        })
    }
}

/// How far aside, in cells.
const ASIDE: [f64; 3] = [1e-6, 0.618e-6, 0.382e-6];

/// The first cell of the block that a cell is in.
pub(super) fn block_of(cell: Place) -> Place {
    cell.map(|i| i / SIDE * SIDE)
}

/// The offsets of an edge's lower end.
pub(super) fn edge_start(edge: usize) -> Place {
    let axis = edge / 4;
    let mut at = [0; 3];
    at[(axis + 1) % 3] = (edge & 1) as u32;
    at[(axis + 2) % 3] = (edge >> 1 & 1) as u32;
    at
}

/// The number of the corner at these offsets.
pub(super) fn corner(at: Place) -> usize {
    (at[0] + 2 * at[1] + 4 * at[2]) as usize
}
