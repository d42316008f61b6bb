//! What is proven of parts of cells, by many threads for each other.
//!
//! A proof is never taken back, so that all that is known of the parts of a cell are bits that threads set. A thread that has
//! a brick of cells at hand need not ask the table for it again; whatever the table drops meanwhile, it knows for itself.

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

    fn add(&self, what: Proof, voxel: Voxel, Parts(bits): Parts) {
        self.0[what as usize][place(voxel)].fetch_or(bits, Ordering::Relaxed);
    }
}

/// Bricks of cells, by how often voxels are halved for these.
#[derive(Debug)]
pub struct Known(Cache<(u32, Name), Arc<Proofs>>);

impl Known {
    /// So many cells are remembered, at most.
    pub fn new(cells: usize) -> Known {
        Known(Cache::new(cells / COUNT))
    }

    /// Another picture begins.
    pub fn turn(&self) {
        self.0.turn();
    }

    /// The brick of a cell, of which nothing need be known.
    pub fn brick(&self, level: u32, voxel: Voxel) -> Arc<Proofs> {
        self.0.update((level, name(voxel)), |known| known.cloned().unwrap_or_else(Proofs::none))
    }

    /// The brick of a cell, if something is known of it.
    pub fn get(&self, level: u32, voxel: Voxel) -> Option<Arc<Proofs>> {
        self.0.get(&(level, name(voxel)))
    }

    /// Something is proven of parts of cells.
    pub fn add(&self, what: Proof, level: u32, parts: &[(Voxel, Parts)]) {
        for of_brick in parts.chunk_by(|a, b| name(a.0) == name(b.0)) {
            let brick = self.brick(level, of_brick[0].0);
            of_brick.iter().for_each(|&(voxel, parts)| brick.add(what, voxel, parts));
        }
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
        let held = known.brick(3, cells[1]);
        let parts: Vec<_> = cells.into_iter().zip((0..).map(|i| Parts(1 << i))).collect();
        known.add(Proof::Joined, 3, &parts);
        known.add(Proof::Joined, 3, &[(cells[1], Parts(1 << 9))]);
        known.add(Proof::Vast, 4, &parts[..1]);
        let get = |what: Proof, level: u32, voxel: Voxel| {
            known.get(level, voxel).map(|brick| brick.get(what, voxel))
        };
        let joined = cells.map(|voxel| get(Proof::Joined, 3, voxel));
        assert_eq!(joined, [1, 2 + (1 << 9), 4, 8].map(|bits| Some(Parts(bits))));
        assert_eq!(held.get(Proof::Joined, cells[2]), Parts(4));
        assert_eq!(get(Proof::Parted, 3, cells[0]), Some(Parts::NONE));
        assert_eq!(get(Proof::Vast, 4, cells[0]), Some(Parts(1)));
        assert_eq!(get(Proof::Joined, 4, cells[3]), None);
    }
}
