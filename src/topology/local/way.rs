//! Ways of a few straight lines to the core, for places that do not see it.
//!
//! In foam a place below the surface seldom sees the core, but there are places around it that do, or that have such
//! places around them. So lines are drawn from it to all sides; of the places that they reach, all inside of the solid,
//! the one next to the core is gone on from. What is found is proven; that nothing is found says nothing.

use super::super::search::LANES;
use super::core::are_inside;
use super::counters::Count;
use super::voxel::Looker;
use glam::DVec3;
use std::f64::consts::TAU;
use std::time::Instant;

/// How often voxels are halved for cells that have ways in common.
const LEVEL: u32 = 6;

/// Places that are gone on from. (Of the joined minima of surface (8.11) that do not see the core a third has a way
/// after one, four fifths after twenty.)
const PLACES: usize = 20;

/// How far lines go aside and towards the core, in voxels.
const LINES: [[f64; 2]; 4] = [[0.3, 0.1], [0.5, 0.4], [0.7, 0.0], [1.0, 0.3]];

/// Turn between the lines from one place and those from the next.
const TURN: f64 = 0.618 * TAU;

impl Looker {
    /// Whether there is a way from a place inside. That is found out once for each of the cells that voxels are cut into,
    /// from its middle, if it is all inside.
    pub fn has_way(&mut self, at: DVec3) -> bool {
        let grid = self.local.cells(LEVEL);
        let voxel = grid.voxel(at);
        if let Some(known) = self.local.ways.get(&voxel) {
            return known;
        }
        let (centre, radius) = grid.ball(voxel);
        let is_full = self.paths.eval([(centre, radius)].into_iter()).lane(0).range.hi < 0.0
            && self.paths.is_defined_around(centre, radius);
        let found = is_full && self.finds_way(centre);
        self.local.ways.insert(voxel, found);
        found
    }

    fn finds_way(&mut self, from: DVec3) -> bool {
        let (core, size) = (self.local.core, self.local.grid.size());
        let mut reached = vec![from];
        for k in 0..PLACES {
            let nearest = (0..reached.len()).min_by(|&i, &j| {
                reached[i].distance(core.centre).total_cmp(&reached[j].distance(core.centre))
            });
            let Some(nearest) = nearest else { return false };
            let from = reached.swap_remove(nearest);
            let lines = star(from, (core.centre - from).normalize_or(DVec3::Y), k as f64 * TURN, size);
            let start = Instant::now();
            let inside = are_inside(&mut self.paths, &lines, size);
            self.local.counters.add_time(Count::Lines, start);
            let ends = lines.iter().zip(inside).filter(|(_, is_inside)| *is_inside).map(|([_, end], _)| *end);
            let ends: Vec<DVec3> = ends.collect();
            if self.see(&ends).contains(&true) {
                return true;
            }
            reached.extend(ends);
        }
        false
    }
}

/// Lines from a place to all sides of a direction.
fn star(from: DVec3, down: DVec3, turn: f64, size: f64) -> [[DVec3; 2]; LANES] {
    let (a, b) = down.any_orthonormal_pair();
    std::array::from_fn(|i| {
        let [aside, deeper] = LINES[i % LINES.len()];
        let angle = turn + TAU * i as f64 / LANES as f64;
        [from, from + size * (aside * (libm::cos(angle) * a + libm::sin(angle) * b) + deeper * down)]
    })
}
