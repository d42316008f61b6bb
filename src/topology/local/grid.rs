//! Voxels, and the borders between them.

use super::super::cell::Cell;
use glam::DVec3;

/// Which voxel: its place in the grid.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Voxel(pub [i64; 3]);

/// The grid that space is cut up into.
///
/// Its origin is beside the one of space by a share of a voxel that is far from every simple fraction: the critical
/// points of lattice noise often lie on the planes of its lattice, and those of most solids on planes through the
/// origin.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    size: f64,
}

/// Where the planes of the grid lie on each axis, in voxels.
const SHIFT: DVec3 = DVec3::new(0.381_966_011, 0.236_067_977, 0.414_213_562);

impl Grid {
    /// Voxels of this size.
    pub fn new(size: f64) -> Grid {
        Grid { size }
    }

    /// The grid of cells that voxels halved so often make.
    pub fn halved(&self, times: u32) -> Grid {
        Grid::new(libm::ldexp(self.size, -(times as i32)))
    }

    /// Edge of a voxel.
    pub fn size(&self) -> f64 {
        self.size
    }

    /// The voxel that holds a point.
    pub fn voxel(&self, p: DVec3) -> Voxel {
        Voxel((p / self.size - SHIFT).floor().to_array().map(|i| i as i64))
    }

    /// The voxels that a ball may reach into.
    pub fn around(&self, p: DVec3, radius: f64) -> impl Iterator<Item = Voxel> + use<> {
        let margin = radius + 1e-9 * self.size;
        let (Voxel(low), Voxel(high)) = (self.voxel(p - margin), self.voxel(p + margin));
        box_of(low, high)
    }

    /// The lowest corner of a voxel. Voxels that share a corner have the same numbers for it.
    pub fn corner(&self, node: [i64; 3]) -> DVec3 {
        let [x, y, z] = node.map(|i| i as f64);
        (DVec3::new(x, y, z) + SHIFT) * self.size
    }

    /// The middle of a voxel.
    pub fn middle(&self, voxel: Voxel) -> DVec3 {
        self.cell(voxel).centre
    }

    /// A voxel as a cell.
    pub fn cell(&self, voxel: Voxel) -> Cell {
        self.stratum(voxel.0, [true; 3])
    }

    /// A ball that holds a voxel, however its corners are rounded.
    pub fn ball(&self, voxel: Voxel) -> (DVec3, f64) {
        let cell = self.cell(voxel);
        (cell.centre, cell.radius() + 16.0 * f64::EPSILON * cell.centre.abs().max_element())
    }

    /// The part of a lattice cell that is as long as a voxel along free axes, and flat along others.
    fn stratum(&self, node: [i64; 3], free: [bool; 3]) -> Cell {
        let next = |axis: usize| if free[axis] { node[axis] + 1 } else { node[axis] };
        let (low, high) = (self.corner(node), self.corner([next(0), next(1), next(2)]));
        // Flat cells are exactly flat: their middles are the planes.
        Cell { centre: 0.5 * (low + high), half: 0.5 * (high - low) }
    }

    /// The faces and edges of a voxel, and its corners.
    pub fn borders(&self, voxel: Voxel) -> impl Iterator<Item = Cell> + use<> {
        let grid = *self;
        // Each axis at its low end, at its high end, or free.
        (0..27_usize).filter(|&i| i != 26).map(move |i| {
            let ends = [i % 3, i / 3 % 3, i / 9];
            let node = std::array::from_fn(|axis| voxel.0[axis] + i64::from(ends[axis] == 1));
            grid.stratum(node, ends.map(|end| end == 2))
        })
    }

    /// All voxels but one that hold a point of its border. A coordinate that is not exactly on a plane is inside.
    pub fn across(&self, voxel: Voxel, p: DVec3) -> impl Iterator<Item = Voxel> + use<> {
        let (low, high) = (self.corner(voxel.0), self.corner(voxel.0.map(|i| i + 1)));
        let step = |axis: usize, plane: DVec3| i64::from(p[axis] == plane[axis]);
        let from = std::array::from_fn(|axis| voxel.0[axis] - step(axis, low));
        let to = std::array::from_fn(|axis| voxel.0[axis] + step(axis, high));
        box_of(from, to).filter(move |other| *other != voxel)
    }
}

/// All places from one to another.
fn box_of(low: [i64; 3], high: [i64; 3]) -> impl Iterator<Item = Voxel> {
    let rows = move |x: i64| (low[1]..=high[1]).map(move |y| (x, y));
    let places = (low[0]..=high[0]).flat_map(rows);
    places.flat_map(move |(x, y)| (low[2]..=high[2]).map(move |z| Voxel([x, y, z])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn voxels_share_their_borders() {
        let grid = Grid::new(0.3);
        let voxel = grid.voxel(DVec3::new(1.0, -2.0, 0.1));
        let mut kinds = [0; 3];
        for border in grid.borders(voxel) {
            let flat = border.half.to_array().into_iter().filter(|h| *h == 0.0).count();
            kinds[flat - 1] += 1;
            let others: Vec<Voxel> = grid.across(voxel, border.centre).collect();
            assert_eq!(others.len(), (1 << flat) - 1);
            for other in others {
                assert!(grid.borders(other).any(|b| b == border), "{border:?} of {voxel:?} and {other:?}");
                assert!(grid.across(other, border.centre).any(|v| v == voxel));
            }
        }
        assert_eq!(kinds, [6, 12, 8]);
    }

    #[test]
    fn a_point_is_in_its_voxel() {
        let grid = Grid::new(2.5e-5);
        for i in 0..1000 {
            let p = DVec3::new(0.7, -0.5, 0.51) + 1e-6 * f64::from(i) * DVec3::new(1.0, 0.7, -1.3);
            let voxel = grid.voxel(p);
            assert!(grid.cell(voxel).holds(p, 0.0));
            assert!(grid.around(p, 0.0).any(|v| v == voxel));
            assert!(grid.around(p, 2.5e-5).count() >= 27);
        }
    }
}
