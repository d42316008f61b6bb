//! What is within moats, and the ways out.
//!
//! All of the solid that is within a moat is parted from the core, and parts that touch what is within and are not in it
//! themselves are empty (`moat.rs`). So a ray that meets anything there has nothing to look for until it comes to a part
//! that is not within: it goes from part to part, without asking the field for anything.
//!
//! A moat is there as a whole or not at all, and none is forgotten while a picture is made, however many there are: where a
//! ray comes out must not depend on that.

use super::blocks::Parts;
use super::grid::{Grid, Voxel};
use ahash::RandomState;
use glam::DVec3;
use std::collections::HashMap;
use std::sync::{PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

/// Parts that a way out may lead through.
const LONGEST: usize = 4096;

/// How far a way goes beyond the border of a part, as a share of the part: what it then skips touches that part.
const BEYOND: f64 = 1e-7;

/// Parts of cells, by how often voxels are halved for these.
type Within = HashMap<(u32, Voxel), Parts, RandomState>;

/// What is within moats.
#[derive(Debug, Default)]
pub struct Moats(RwLock<Within>);

impl Moats {
    /// How many cells there are something of.
    pub fn len(&self) -> usize {
        self.read().len()
    }

    /// Forgets all.
    pub fn clear(&self) {
        self.write().clear();
    }

    /// Adds what is within a moat.
    pub fn add(&self, level: u32, within: Vec<(Voxel, Parts)>) {
        let mut all = self.write();
        for (voxel, parts) in within {
            let known = all.entry((level, voxel)).or_default();
            *known = known.or(parts);
        }
    }

    /// Whether a place is in a part that is within a moat.
    pub fn holds(&self, voxels: &Grid, level: u32, p: DVec3) -> bool {
        Spot::of(&voxels.halved(level), p).is_in(&self.read(), level)
    }

    /// How far from a place within a moat a straight line, given by its unit direction, comes to where nothing is, having
    /// met nothing but what is within. It begins so far `before` the place, which must be less than half a part.
    pub fn way_out(
        &self,
        voxels: &Grid,
        level: u32,
        (from, direction): (DVec3, DVec3),
        before: f64,
    ) -> Option<f64> {
        let (grid, all) = (voxels.halved(level), self.read());
        let edge = Parts::edge(&grid);
        // Then it begins in a part that touches the one of the place.
        let is_near = (0.0..0.5 * edge).contains(&before);
        let mut spot = Some(Spot::of(&grid, from)).filter(|spot| is_near && spot.is_in(&all, level))?;
        let mut far = 0.0;
        for _ in 0..LONGEST {
            far += spot.to_border(&grid, from + far * direction, direction) + BEYOND * edge;
            spot = Spot::of(&grid, from + far * direction);
            if !spot.is_in(&all, level) {
                return Some(far);
            }
        }
        None
    }

    fn read(&self) -> RwLockReadGuard<'_, Within> {
        // A thread that panicked left a table that is whole.
        self.0.read().unwrap_or_else(PoisonError::into_inner)
    }

    fn write(&self) -> RwLockWriteGuard<'_, Within> {
        self.0.write().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A part of a cell.
struct Spot {
    voxel: Voxel,
    part: Parts,
}

impl Spot {
    /// The one that holds a place.
    fn of(grid: &Grid, p: DVec3) -> Spot {
        let voxel = grid.voxel(p);
        Spot { voxel, part: Parts::of(grid, voxel, p) }
    }

    fn is_in(&self, within: &Within, level: u32) -> bool {
        within.get(&(level, self.voxel)).is_some_and(|known| known.and(self.part).any())
    }

    /// How far a place in it is from where a direction leads out of it.
    fn to_border(&self, grid: &Grid, p: DVec3, direction: DVec3) -> f64 {
        let reach = 0.5 * Parts::edge(grid) * direction.signum();
        let to = (self.part.middle(grid, self.voxel) + reach - p) / direction;
        // Along an axis that it does not go along there is no border.
        let ways = (0..3).filter(|&axis| direction[axis] != 0.0).map(|axis| to[axis]);
        ways.fold(f64::INFINITY, f64::min).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_out_stay_within_until_they_are_out() {
        let (voxels, level) = (Grid::new(1.0), 3);
        let grid = voxels.halved(level);
        // The parts that begin in two balls that touch.
        let balls = [(DVec3::new(0.1, 0.7, -0.3), 0.25), (DVec3::new(0.45, 0.7, -0.3), 0.12)];
        let holds = |p: DVec3| balls.iter().any(|(centre, radius)| p.distance(*centre) < *radius);
        let mut within: HashMap<Voxel, Parts> = HashMap::default();
        let steps = || (-70..70).map(|i| f64::from(i) / 97.0);
        for p in steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| DVec3::new(x, y, z)))) {
            let p = p + balls[0].0;
            if holds(p) {
                let Spot { voxel, part } = Spot::of(&grid, p);
                let known = within.entry(voxel).or_default();
                *known = known.or(part);
            }
        }
        let moats = Moats::default();
        assert_eq!(moats.way_out(&voxels, level, (balls[0].0, DVec3::X), 0.0), None);
        moats.add(level, within.into_iter().collect());
        let is_in = |p: DVec3| moats.holds(&voxels, level, p);
        for i in 0..2000 {
            let a = f64::from(i);
            let direction =
                DVec3::new(libm::sin(a), libm::cos(1.7 * a), libm::sin(0.3 * a + 1.0)).normalize();
            let direction = if i % 10 == 0 { DVec3::AXES[i as usize / 10 % 3] } else { direction };
            let from = balls[0].0 + 0.2 * DVec3::new(libm::cos(a), libm::sin(2.3 * a), libm::cos(0.7 * a));
            let way = |before: f64| moats.way_out(&voxels, level, (from, direction), before);
            let Some(far) = way(1e-6) else {
                assert!(!is_in(from), "{from}");
                continue;
            };
            assert!(is_in(from) && !is_in(from + far * direction), "{from} {direction}");
            for k in 0..500 {
                assert!(is_in(from + (far - 1e-6).max(0.0) * f64::from(k) / 500.0 * direction), "{from} {k}");
            }
            assert_eq!((way(0.1), way(-1e-9)), (None, None));
        }
        moats.clear();
        assert_eq!((moats.len(), is_in(balls[0].0)), (0, false));
    }
}
