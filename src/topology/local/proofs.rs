//! What is proven of parts of cells, by many threads for each other.
//!
//! A proof is never taken back, so that all that is known of the parts of a cell are bits that threads set. A thread that has
//! a brick of cells at hand need not ask the table for it again. What the table has dropped meanwhile comes back to it with
//! what that thread proves next.

use super::blocks::Parts;
use super::bricks::{COUNT, Name, name, place};
use super::cache::Cache;
use super::grid::Voxel;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// What is proven.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Proof {
    /// All of the solid in a part is within a moat.
    Parted,
    /// A part is all inside, and joined with the core.
    Joined,
    /// There is no moat around what touches a part by cells of its size.
    Vast,
}

/// The parts of the cells of a brick for which something is proven.
#[derive(Debug)]
pub struct Proofs([[AtomicU64; COUNT]; Proof::Vast as usize + 1]);

impl Proofs {
    fn none() -> Arc<Proofs> {
        Arc::new(Proofs([const { [const { AtomicU64::new(0) }; COUNT] }; Proof::Vast as usize + 1]))
    }

    /// The parts of a cell of the brick for which it is proven.
    pub fn get(&self, what: Proof, voxel: Voxel) -> Parts {
        Parts(self.0[what as usize][place(voxel)].load(Ordering::Relaxed))
    }

    /// It is proven for parts of a cell of the brick.
    pub fn add(&self, what: Proof, voxel: Voxel, Parts(bits): Parts) {
        self.0[what as usize][place(voxel)].fetch_or(bits, Ordering::Relaxed);
    }
}

/// Bricks of cells, by how often voxels are halved for these.
#[derive(Debug)]
pub struct Known(Cache<(u32, Name), Arc<Proofs>>);

impl Known {
    /// The bricks of so many cells are remembered, at most.
    pub fn new(cells: usize) -> Known {
        Known(Cache::new(cells / COUNT))
    }

    /// Another picture begins.
    pub fn turn(&self) {
        self.0.turn();
    }

    /// The brick of a cell, of which nothing need be known: that of the table, or else the one that somebody holds.
    pub fn brick(&self, level: u32, voxel: Voxel, held: Option<Arc<Proofs>>) -> Arc<Proofs> {
        let own = |known: Option<&Arc<Proofs>>| known.cloned().or(held).unwrap_or_else(Proofs::none);
        self.0.update((level, name(voxel)), own)
    }

    /// The brick of a cell, if something is known of it.
    pub fn get(&self, level: u32, voxel: Voxel) -> Option<Arc<Proofs>> {
        self.0.get(&(level, name(voxel)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_proven_is_known_of_these_parts_alone() {
        let known = Known::new(1 << 16);
        let cells = [Voxel([-1, 0, 0]), Voxel([0, 0, 0]), Voxel([1, 0, 0]), Voxel([1 << 40, 5, -7])];
        assert!(known.get(3, cells[0]).is_none());
        for (i, voxel) in cells.into_iter().enumerate() {
            known.brick(3, voxel, None).add(Proof::Joined, voxel, Parts(1 << i));
        }
        known.brick(3, cells[1], None).add(Proof::Joined, cells[1], Parts(1 << 9));
        known.brick(4, cells[0], None).add(Proof::Vast, cells[0], Parts(1));
        let get = |what: Proof, level: u32, voxel: Voxel| {
            known.get(level, voxel).map(|brick| brick.get(what, voxel))
        };
        let joined = cells.map(|voxel| get(Proof::Joined, 3, voxel));
        assert_eq!(joined, [1, 2 + (1 << 9), 4, 8].map(|bits| Some(Parts(bits))));
        assert_eq!(get(Proof::Parted, 3, cells[0]), Some(Parts::NONE));
        assert_eq!(get(Proof::Vast, 4, cells[0]), Some(Parts(1)));
        assert_eq!(get(Proof::Joined, 4, cells[3]), None);
    }

    #[test]
    fn what_was_dropped_comes_back_with_what_is_proven_next() {
        let known = Known::new(1);
        let cell = Voxel([0, 0, 0]);
        let held = known.brick(3, cell, None);
        held.add(Proof::Joined, cell, Parts(1));
        (0..10_000).for_each(|i| drop(known.brick(3, Voxel([4 * i, 8, 0]), None)));
        assert!(known.get(3, cell).is_none());
        known.brick(3, cell, Some(held)).add(Proof::Joined, cell, Parts(2));
        let found = known.get(3, cell).map(|brick| brick.get(Proof::Joined, cell));
        assert_eq!(found, Some(Parts(3)));
    }
}
