//! Boxes that a search cuts up.
//!
//! A box may be flat. Then the search is for critical points of the field on its plane or line, with the
//! coordinates held that do not vary there.

use crate::scene::Aabb;
use glam::DVec3;

/// A box, by its middle and half its extents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// The middle.
    pub centre: DVec3,
    /// Half its extents.
    pub half: DVec3,
}

/// Cells are taken to be larger than they are by this share, so that what lies on a face lies in the cells on
/// both sides of it, however their middles are rounded.
const OVERLAP: f64 = 1e-9;

/// Where octant number `i` lies: one of `(-1, -1, -1)` to `(1, 1, 1)`.
pub fn side(i: usize) -> DVec3 {
    let side = |bit: usize| if i & bit == 0 { -1.0 } else { 1.0 };
    DVec3::new(side(1), side(2), side(4))
}

impl Cell {
    /// The box as nearly cubic cells.
    pub fn of(region: &Aabb) -> Vec<Cell> {
        let extent = region.max - region.min;
        let least = extent.min_element();
        let count = (extent / least).round().max(DVec3::ONE);
        let half = 0.5 * extent / count;
        let [nx, ny, nz] = count.to_array().map(|n| n as usize);
        let at = |i: usize, j: usize, k: usize| {
            let steps = DVec3::new(i as f64, j as f64, k as f64) * 2.0 + 1.0;
            Cell { centre: region.min + steps * half, half }
        };
        let places = (0..nx).flat_map(|i| (0..ny).flat_map(move |j| (0..nz).map(move |k| (i, j, k))));
        places.map(|(i, j, k)| at(i, j, k)).collect()
    }

    /// The halves by their numbers: eight, four of a flat cell, two of one that is flat along two axes.
    pub fn octants(&self) -> impl Iterator<Item = (usize, Cell)> + use<> {
        let Cell { centre, half } = *self;
        let flat = (0..3).filter(|&axis| half[axis] == 0.0).map(|axis| 1 << axis).sum::<usize>();
        let octant = move |i: usize| Cell { centre: centre + 0.5 * half * side(i), half: 0.5 * half };
        (0..8).filter(move |i| i & flat == 0).map(move |i| (i, octant(i)))
    }

    /// Along which axes it is not flat.
    pub fn free_axes(&self) -> [bool; 3] {
        self.half.to_array().map(|half| half > 0.0)
    }

    /// Radius of a ball around the middle that holds the cell and a little more.
    pub fn radius(&self) -> f64 {
        self.half.length() * (1.0 + 2.0 * OVERLAP)
    }

    /// Half the extents in units of that radius, and a little more.
    pub fn share(&self) -> DVec3 {
        self.half * ((1.0 + OVERLAP) / self.radius())
    }

    /// Whether a point lies in the cell, or a little beside it.
    pub fn holds(&self, p: DVec3, margin: f64) -> bool {
        (p - self.centre).abs().cmple(self.half * (1.0 + OVERLAP) + margin).all()
    }
}
