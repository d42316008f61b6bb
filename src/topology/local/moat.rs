//! Moats: parts of cells without anything of the solid all around a crumb, which prove that it is joined with nothing else.
//!
//! From the part that holds a place, all parts are taken in that may have something of the solid in them and touch one
//! that was taken in. A path in the solid never leaves these, since from one part it goes to one that touches. So where
//! no more are left to take in, the component is in them as a whole; and so are all others that have something there.
//!
//! The cells farthest from the place come first, so that what is no crumb is soon seen to reach too far. The same is then
//! true from all that was taken in, and from all that comes to it: parts that touch are one set, from whichever it begins.

use super::blocks::{Blocks, Flood, Parts};
use super::grid::Voxel;
use super::proofs::Proof;
use super::voxel::Looker;
use glam::DVec3;
use std::sync::atomic::{AtomicBool, Ordering};

/// How far crumbs may reach along each axis, in cells, and how many cells a moat and what is within may touch.
const REACH: i64 = 48;
const TOUCHED: usize = 1 << 14;

impl Looker {
    /// Parts of cells that hold all that a place inside is joined with, and a moat around it. From all places of a
    /// component these are the same.
    pub fn moat(
        &mut self,
        blocks: &mut Blocks,
        at: DVec3,
        cancel: &AtomicBool,
    ) -> Option<Vec<(Voxel, Parts)>> {
        let first = blocks.grid.voxel(at);
        let near = |voxel: Voxel| {
            let far: i64 = (0..3).map(|axis| (voxel.0[axis] - first.0[axis]).abs()).sum();
            u64::MAX - far.unsigned_abs()
        };
        let mut flood = Flood::new(&blocks.grid, at);
        let (mut low, mut high) = (first.0, first.0);
        loop {
            let batch = flood.next();
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            let mut is_vast = flood.len() > TOUCHED;
            if !is_vast && batch.is_empty() {
                let within = flood.within();
                // A place in a part without anything is not inside: of it nothing is known.
                return (!within.is_empty()).then_some(within);
            }
            self.look(blocks, &batch, &flood);
            for voxel in batch {
                let fresh = flood.take(voxel, blocks.get(voxel).solid, near);
                if !fresh.any() {
                    continue;
                }
                is_vast |= fresh.and(blocks.proofs(&self.local.known, voxel).get(Proof::Vast, voxel)).any();
                for axis in 0..3 {
                    (low[axis], high[axis]) = (low[axis].min(voxel.0[axis]), high[axis].max(voxel.0[axis]));
                }
                is_vast |= (0..3).any(|axis| high[axis] - low[axis] >= REACH);
                is_vast |= !self.is_beside_the_core(blocks.grid.ball(voxel));
            }
            if is_vast {
                blocks.learn(&self.local.known, Proof::Vast, &flood.within());
                return None;
            }
        }
    }

    /// Whether a ball is in the region, and the core is not in it.
    fn is_beside_the_core(&self, (centre, radius): (DVec3, f64)) -> bool {
        let core = &self.local.core;
        self.paths.is_within(centre, radius) && centre.distance(core.centre) >= core.radius + radius
    }
}
