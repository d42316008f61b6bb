//! Moats: cells without anything of the solid all around a crumb, which prove that it is joined with nothing else.
//!
//! From the cell of a place, all cells are taken in that touch one which may have something of the solid in it. A path in
//! the solid never leaves these, since from such a cell it goes to one that touches. So where no more are left to take in,
//! the component is in them as a whole; and so are all others that have something there.
//!
//! The cells next to the core come first, so that what is joined with it is soon seen to reach down for too far.

use super::super::search::LANES;
use super::core::Core;
use super::counters::Count;
use super::grid::{Grid, Voxel};
use super::voxel::Looker;
use ahash::HashSet;
use glam::DVec3;
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Cells to a voxel along each axis, as powers of two, and how far towards the core crumbs may reach in voxels: where gaps
/// are too narrow for the first, those after it are tried, for smaller crumbs. (Of those of surface (8.11) the first
/// part a third, all of them nine tenths.)
pub const LEVELS: [(u32, f64); 3] = [(3, 6.0), (4, 3.0), (5, 1.5)];

/// Cells that are looked at for a moat.
const CELLS: usize = 1 << 14;

impl Looker {
    /// Cells of one of the [`LEVELS`] that hold all that a place inside is joined with, and a moat around it. From all places
    /// of a component these are the same.
    pub fn moat(&mut self, at: DVec3, cancel: &AtomicBool) -> Option<(u32, Vec<Voxel>)> {
        let start = Instant::now();
        let found = LEVELS.into_iter().find_map(|(level, deep)| {
            let cells =
                self.within_moat(self.local.cells(level), deep * self.local.grid.size(), at, cancel)?;
            Some((level, cells))
        });
        self.local.counters.add_time(Count::Locating, start);
        found
    }

    fn within_moat(&mut self, grid: Grid, deep: f64, at: DVec3, cancel: &AtomicBool) -> Option<Vec<Voxel>> {
        let (core, region) = (self.local.core, self.local.region);
        let first = grid.voxel(at);
        let (mut known, mut waiting) =
            (HashSet::from_iter([first]), BTreeSet::from([by_depth(&grid, &core, first)]));
        let (mut lowest, mut highest) = (f64::INFINITY, 0.0_f64);
        let mut within = Vec::new();
        while !waiting.is_empty() {
            let batch: Vec<Voxel> = (0..LANES).map_while(|_| waiting.pop_first()).map(|(_, v)| v).collect();
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            let balls: Vec<(DVec3, f64)> = batch.iter().map(|&voxel| grid.ball(voxel)).collect();
            let values = self.paths.eval(balls.iter().copied());
            let is_empty: Vec<bool> = (0..batch.len()).map(|i| values.lane(i).range.lo > 0.0).collect();
            for ((voxel, (centre, reach)), _) in
                batch.into_iter().zip(balls).zip(is_empty).filter(|(_, is_empty)| !is_empty)
            {
                let distance = centre.distance(core.centre);
                (lowest, highest) = (lowest.min(distance), highest.max(distance));
                let is_inside =
                    (centre - reach).cmpge(region.min).all() && (centre + reach).cmple(region.max).all();
                let is_core = distance < core.radius + reach;
                if is_core || !is_inside || highest - lowest > deep || known.len() > CELLS {
                    return None;
                }
                within.push(voxel);
                let beside = voxel.beside().filter(|&voxel| known.insert(voxel));
                waiting.extend(beside.map(|voxel| by_depth(&grid, &core, voxel)));
            }
        }
        // A place in a cell without anything is not inside: of it nothing is known.
        (!within.is_empty() && known.len() <= CELLS).then_some(within)
    }
}

/// A cell by its distance from the core.
fn by_depth(grid: &Grid, core: &Core, voxel: Voxel) -> (u64, Voxel) {
    (grid.middle(voxel).distance(core.centre).to_bits(), voxel)
}
