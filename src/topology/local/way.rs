//! What is around places that do not see the core: a way to it, or a moat.
//!
//! In foam a place below the surface seldom sees the core, but it is joined with places that do. So from the part of a cell
//! that holds it, parts that are all inside are taken in, those next to the core first, and lines are drawn to the core
//! from them. What is found is proven, for all parts that were taken in, and floods that come to these later are there;
//! that nothing is found says nothing.

use super::super::search::LANES;
use super::blocks::{Blocks, Flood, Parts};
use super::counters::Count;
use super::grid::Voxel;
use super::proofs::Proof;
use super::voxel::Looker;
use super::{Answer, SMALL};
use ahash::HashSet;
use glam::DVec3;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// How often voxels are halved for the small cells of which all is alike.
const LEVEL: u32 = 6;

/// And for those from each of which one line is drawn to the core.
const VIEWS: u32 = 1;

/// Cells that are touched on a way.
const TOUCHED: usize = 1 << 12;

impl Looker {
    /// What moats and ways say of a place inside. That is found out once for each small cell that is all inside, from its
    /// middle.
    pub fn around(&mut self, at: DVec3, cancel: &AtomicBool) -> Answer {
        let grid = self.local.grid.halved(LEVEL);
        let voxel = grid.voxel(at);
        if let Some(known) = self.local.around.get(&voxel) {
            return known;
        }
        let (centre, radius) = grid.ball(voxel);
        let range = self.paths.eval([(centre, radius)].into_iter()).lane(0).range;
        if !self.paths.is_full(centre, radius, range) {
            return self.moat_or_way(at, cancel);
        }
        let found = self.moat_or_way(centre, cancel);
        // What was broken off is not to be remembered.
        if cancel.load(Ordering::Relaxed) {
            return found;
        }
        self.local.around.update(voxel, |old| found.unless_proven(old))
    }

    /// What moats and ways say of a place inside.
    pub fn moat_or_way(&mut self, at: DVec3, cancel: &AtomicBool) -> Answer {
        if let Some(known) = self.local.proven(at) {
            return known;
        }
        let mut small = std::mem::take(&mut self.small);
        let found = small.iter_mut().find_map(|blocks| self.prove(blocks, at, cancel));
        self.small = small;
        found.unwrap_or(Answer::Unknown)
    }

    /// The same, by cells of one size. Of what larger ones say nothing about, more is a crumb.
    fn prove(&mut self, blocks: &mut Blocks, at: DVec3, cancel: &AtomicBool) -> Option<Answer> {
        if blocks.level == SMALL[0] {
            self.joins(blocks, at, cancel).or_else(|| self.parts(blocks, at, cancel))
        } else {
            self.parts(blocks, at, cancel).or_else(|| self.joins(blocks, at, cancel))
        }
    }

    /// Whether a way joins a place with the core.
    fn joins(&mut self, blocks: &mut Blocks, at: DVec3, cancel: &AtomicBool) -> Option<Answer> {
        let way = self.way(blocks, at, cancel)?;
        blocks.learn(&self.local.known, Proof::Joined, &way);
        Some(Answer::Joined)
    }

    /// Whether a moat parts a place from the core.
    fn parts(&mut self, blocks: &mut Blocks, at: DVec3, cancel: &AtomicBool) -> Option<Answer> {
        let within = self.moat(blocks, at, cancel)?;
        blocks.learn(&self.local.known, Proof::Parted, &within);
        self.local.counters.add(Count::Moats, 1);
        Some(Answer::Parted)
    }

    /// Looks at cells of a flood.
    pub(super) fn look(&mut self, blocks: &mut Blocks, voxels: &[Voxel], flood: &Flood) {
        let start = Instant::now();
        blocks.look(&mut self.paths, voxels, flood.ahead());
        self.local.counters.add_time(Count::Locating, start);
    }

    /// Parts that are all inside and touch one another from a place on, if a straight line from one of them leads to the
    /// core, or one of them is known to be joined with it.
    fn way(&mut self, blocks: &mut Blocks, at: DVec3, cancel: &AtomicBool) -> Option<Vec<(Voxel, Parts)>> {
        let (core, grid, views) = (self.local.core, blocks.grid, self.local.grid.halved(VIEWS));
        let depth = |voxel: Voxel| grid.middle(voxel).distance(core.centre).to_bits();
        let mut flood = Flood::new(&grid, at);
        let (mut seen, mut places) = (HashSet::default(), Vec::new());
        loop {
            let batch = flood.next();
            let is_last = batch.is_empty() || flood.len() > TOUCHED || cancel.load(Ordering::Relaxed);
            if is_last || places.len() >= LANES {
                if self.see(&places).contains(&true) {
                    return Some(flood.within());
                }
                places.clear();
            }
            if is_last {
                return None;
            }
            self.look(blocks, &batch, &flood);
            for voxel in batch {
                let fresh = flood.take(voxel, blocks.get(voxel).inside, depth);
                if !fresh.any() {
                    continue;
                }
                if fresh.and(blocks.proofs(&self.local.known, voxel).get(Proof::Joined, voxel)).any() {
                    return Some(flood.within());
                }
                if seen.insert(views.voxel(grid.middle(voxel))) {
                    places.extend(fresh.first().map(|part| part.middle(&grid, voxel)));
                }
            }
        }
    }
}
