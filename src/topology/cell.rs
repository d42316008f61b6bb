//! Boxes that a search cuts up.
//!
//! A box may be flat. Then the search is for critical points of the field on its plane or line, with the
//! coordinates held that do not vary there.

use crate::num::Interval;
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

/// Cells along an axis that a region begins as, at most: one that is thinner begins as cells that are flatter than cubes.
const ALONG: f64 = 8.0;

/// An axis is not cut along which a cell is thinner than this share of its longest edge.
const THIN: f64 = 0.5;

impl Cell {
    /// The box as a few nearly cubic cells, or flat ones.
    pub fn of(region: &Aabb) -> Vec<Cell> {
        let extent = region.max - region.min;
        let least = extent.min_element();
        let count = (extent / least).round().clamp(DVec3::ONE, DVec3::splat(ALONG));
        let half = 0.5 * extent / count;
        let [nx, ny, nz] = count.to_array().map(|n| n as usize);
        let at = |i: usize, j: usize, k: usize| {
            let steps = DVec3::new(i as f64, j as f64, k as f64) * 2.0 + 1.0;
            Cell { centre: region.min + steps * half, half }
        };
        let places = (0..nx).flat_map(|i| (0..ny).flat_map(move |j| (0..nz).map(move |k| (i, j, k))));
        places.map(|(i, j, k)| at(i, j, k)).collect()
    }

    /// Its parts: eight octants, or fewer of a cell that is thin or flat along an axis.
    pub fn parts(&self) -> impl Iterator<Item = Cell> + use<> {
        let octants = self.octants();
        (0..8).filter(move |i| octants.has(*i)).map(move |i| octants.part(i))
    }

    /// How it is cut.
    pub fn octants(&self) -> Octants {
        let Cell { centre, half } = *self;
        let cut = half.cmpgt(DVec3::splat(THIN * half.max_element()));
        let (half, off) = (DVec3::select(cut, 0.5 * half, half), DVec3::select(cut, 0.5 * half, DVec3::ZERO));
        Octants { centre, half, off, whole: 7 & !cut.bitmask() as usize }
    }

    /// Along which axes it is not flat.
    pub fn free_axes(&self) -> [bool; 3] {
        self.half.to_array().map(|half| half > 0.0)
    }

    /// Whether it is flat along an axis.
    pub fn is_flat(&self) -> bool {
        !self.half.cmpgt(DVec3::ZERO).all()
    }

    /// Radius of a ball around the middle that holds the cell and a little more.
    pub fn radius(&self) -> f64 {
        self.half.length() * (1.0 + 2.0 * OVERLAP)
    }

    /// A length of 1 in units of that radius, and a little more.
    pub fn unit(&self) -> f64 {
        (1.0 + OVERLAP) / self.radius()
    }

    /// Half the extents in these units.
    pub fn share(&self) -> DVec3 {
        self.half * self.unit()
    }

    /// Whether a point lies in the cell, or a little beside it.
    pub fn holds(&self, p: DVec3, margin: f64) -> bool {
        (p - self.centre).abs().cmple(self.half * (1.0 + OVERLAP) + margin).all()
    }
}

/// The octants of a cell, by number: bits of it say on which sides of the middle they are.
#[derive(Clone, Copy, Debug)]
pub struct Octants {
    centre: DVec3,
    /// Half their extents.
    pub half: DVec3,
    /// How far their middles are from that of the cell along each axis, which is exact; nothing where it is not cut.
    pub off: DVec3,
    /// Bits of axes along which it is not cut.
    whole: usize,
}

/// On which side of the middle each octant is, axis by axis.
pub const SIDES: [[f64; 8]; 3] = [
    [-1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0],
    [-1.0, -1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0],
    [-1.0, -1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0],
];

impl Octants {
    /// Whether there is one of this number: of those that are one another, the first.
    pub fn has(&self, i: usize) -> bool {
        i & self.whole == 0
    }

    /// One of them.
    pub fn part(&self, i: usize) -> Cell {
        let side = DVec3::new(SIDES[0][i], SIDES[1][i], SIDES[2][i]);
        Cell { centre: self.centre + self.off * side, half: self.half }
    }
}

/// The numbers and middles of boxes, and how far they reach along any axis: what their tapes are asked for by
/// ([`Cells::tapes_around`](crate::tape::Cells::tapes_around)).
pub(super) fn places(boxes: &[Aabb]) -> impl Iterator<Item = (usize, [f64; 3], f64)> {
    boxes.iter().enumerate().map(|(i, cell)| {
        let x = cell.intervals();
        (i, x.map(Interval::mid), x.map(Interval::rad).into_iter().fold(0.0, f64::max))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The octants of a cell are on all sides of its middle, and meet there.
    #[test]
    fn octants_are_on_all_sides() {
        let centre = DVec3::new(1.0, 2.0, 3.0);
        for half in [DVec3::new(0.5, 0.25, 0.375), DVec3::new(0.5, 0.0, 0.5), DVec3::new(0.0, 0.125, 1.0)] {
            let parts: Vec<Cell> = Cell { centre, half }.parts().collect();
            let mut volume = 0.0;
            for (i, part) in parts.iter().enumerate() {
                let off = (part.centre - centre).abs();
                let is_cut = |axis: usize| off[axis] == part.half[axis] && 2.0 * off[axis] == half[axis];
                let is_whole = |axis: usize| off[axis] == 0.0 && part.half[axis] == half[axis];
                assert!((0..3).all(|axis| is_cut(axis) || is_whole(axis)), "{half}: {part:?}");
                assert!(parts[..i].iter().all(|other| other.centre != part.centre), "{half}");
                let shares =
                    (0..3).map(|axis| if half[axis] > 0.0 { part.half[axis] / half[axis] } else { 1.0 });
                volume += shares.product::<f64>();
            }
            assert_eq!(volume, 1.0, "{half}");
        }
    }

    /// A region of any shape is a few cells, and cells are cut where they are long, until they are nearly cubes.
    #[test]
    fn thin_regions_are_few_cells() {
        for thin in [4.0, 0.7, 1e-2, 1e-5, 1e-300, 0.0] {
            let region = Aabb { min: DVec3::splat(-2.0), max: DVec3::new(2.0, 2.0, thin - 2.0) };
            let mut cells = Cell::of(&region);
            assert!(cells.len() <= 64, "{thin}: {}", cells.len());
            let volume = |cells: &[Cell]| cells.iter().map(|c| c.half.x * c.half.y).sum::<f64>();
            for _ in 0..4 {
                let before = volume(&cells);
                let cut = cells[0].parts().count();
                cells = cells.iter().flat_map(Cell::parts).collect();
                let layers = if cut == 8 { 2.0 } else { 1.0 };
                assert!((volume(&cells) - layers * before).abs() < 1e-9, "{thin}: the parts are the whole");
                assert!(cut == 4 || cut == 8, "{thin}: {cut}");
            }
        }
    }
}
