//! Casting through cubes that all rays share, for fields that take long to evaluate.
//!
//! What is found out of the field around a cube, once, serves all rays that pass it, those to the eye as those to lights: most
//! are through with hardly an evaluation of their own, and where a ray meets the surface it does so within a cube in which
//! the field falls for sure, down to a root that a few values at points tell (`walk.rs`). Fields that flows carry are cast in
//! this way: a value takes a whole trajectory, and an expansion over a ball several times as much.
//!
//! Which cubes there are depends on the rays, not what is known of them (`tree.rs`), so that hits are the same whoever
//! asks first. So are statistics: a ray counts what it wants to know of cubes, be it known by then or not.

mod tree;
mod walk;

use super::group::{LANES, by_tape};
use super::{CastStats, Caster, Hit, Ray};
use crate::field::{Field, lipschitz_until};
use crate::num::{Many, Number, Taylors};
use crate::scene::Aabb;
use crate::tape::{Cells, Evaluator};
use glam::DVec3;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use tree::{Cube, Fact, Tree};
use walk::{Next, Walk};

/// Balls that are asked about together.
const BALLS: usize = 8;

/// Casts through cubes; see the module text.
pub(super) struct Octree {
    cells: Arc<Cells>,
    tree: Arc<Tree>,
    balls: Evaluator<Taylors<BALLS>>,
    points: Evaluator<Many<f64, LANES>>,
    /// Bound on gradients outside of the solid in all cubes, which may be infinite.
    steep: f64,
    costs: Vec<f64>,
}

impl Octree {
    /// For rays within a region; none once `cancel` is set.
    pub fn new(field: &Field, region: &Aabb, cells: &Arc<Cells>, cancel: &AtomicBool) -> Option<Octree> {
        let tree = Tree::new(region);
        let steep = lipschitz_until(field, &tree.bounds(), &|| cancel.load(Ordering::Relaxed))?;
        Some(Octree::within(cells.clone(), Arc::new(tree), steep))
    }

    fn within(cells: Arc<Cells>, tree: Arc<Tree>, steep: f64) -> Octree {
        let (balls, points) = (Evaluator::new(cells.tape().clone()), Evaluator::new(cells.tape().clone()));
        Octree { cells, tree, balls, points, steep, costs: Vec::new() }
    }

    /// Marches rays to their ends.
    fn cast(&mut self, any: bool, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool) {
        stats.rays += rays.len() as u64;
        self.costs.clear();
        self.costs.resize(rays.len(), 0.0);
        let walk = |(i, ray)| Walk::new(i, ray, any, (&self.tree, self.steep));
        let mut walks: Vec<Walk> = rays.iter().enumerate().map(walk).collect();
        let (mut cubes, mut places) = (Vec::new(), Vec::new());
        while !walks.is_empty() && !cancel.load(Ordering::Relaxed) {
            cubes.clear();
            places.clear();
            walks.retain_mut(|walk| {
                let ray = walk.ray;
                let hit = match walk.next(&self.tree) {
                    Next::Fact(cube) => {
                        cubes.push((cube, ray));
                        return true;
                    }
                    Next::Middle(cube) => {
                        places.push((Some(cube), ray, self.tree.ball(cube).0));
                        return true;
                    }
                    Next::Value(t) => {
                        places.push((None, ray, rays[ray].at(t)));
                        return true;
                    }
                    Next::Done(hit) => hit,
                    Next::GivenUp(t) => {
                        stats.given_up += 1;
                        Hit { t, certified: false }
                    }
                };
                let [asked, of_cubes] = walk.asked;
                self.costs[ray] = asked as f64;
                stats.evaluations += asked;
                stats.steps += asked;
                stats.shared += of_cubes;
                stats.work += asked * self.cells.tape().work();
                out[ray] = hit;
                stats.hits += u64::from(hit.is_hit());
                stats.uncertified += u64::from(!hit.certified);
                false
            });
            self.tell_facts(&mut walks, &mut cubes, cancel);
            self.tell_values(&mut walks, &mut places, cancel);
        }
    }

    /// Finds out about cubes, and tells the rays that asked.
    fn tell_facts(&mut self, walks: &mut [Walk], asked: &mut [(Cube, usize)], cancel: &AtomicBool) {
        asked.sort_unstable();
        let groups: Vec<&[(Cube, usize)]> = asked.chunk_by(|a, b| a.0 == b.0).collect();
        let ball = |group: &[(Cube, usize)]| self.tree.ball(group[0].0);
        let places = groups.iter().enumerate().map(|(i, group)| {
            let (middle, radius) = ball(group);
            (i, middle.to_array(), radius)
        });
        for same in self.cells.tapes_around(places).chunk_by(|a, b| Arc::ptr_eq(a.0, b.0)) {
            let evaluator = self.balls.turn_to(same[0].0);
            for batch in same.chunks(BALLS) {
                if cancel.load(Ordering::Relaxed) {
                    return;
                }
                let mut p = [Taylors::<BALLS>::constant(0.0); 3];
                for lane in 0..BALLS {
                    let (middle, radius) = ball(groups[batch[lane.min(batch.len() - 1)].1]);
                    Taylors::set_ball(&mut p, lane, middle.to_array(), radius);
                }
                let f = evaluator.eval(&p);
                for (lane, &(_, i)) in batch.iter().enumerate() {
                    let (group, cube) = (groups[i], groups[i][0].0);
                    let fact = Fact::new(&f.lane(lane), self.tree.ball(cube).1);
                    self.tree.keep_fact(cube, fact);
                    for &(_, ray) in group {
                        of(walks, ray).look(&self.tree, &fact);
                    }
                }
            }
        }
    }

    /// Finds values, those in the middles of cubes once for all who ask, and tells the rays.
    fn tell_values(
        &mut self,
        walks: &mut [Walk],
        asked: &mut [(Option<Cube>, usize, DVec3)],
        cancel: &AtomicBool,
    ) {
        asked.sort_unstable_by_key(|&(cube, ray, _)| (cube, ray));
        let groups: Vec<_> = asked.chunk_by(|a, b| a.0.is_some() && a.0 == b.0).collect();
        let places: Vec<[f64; 3]> = groups.iter().map(|group| group[0].2.to_array()).collect();
        for same in by_tape(&self.cells, &places).chunk_by(|a, b| Arc::ptr_eq(a.0, b.0)) {
            let evaluator = self.points.turn_to(same[0].0);
            for batch in same.chunks(LANES) {
                if cancel.load(Ordering::Relaxed) {
                    return;
                }
                let lane = |axis: usize, lane: usize| places[batch[lane.min(batch.len() - 1)].1][axis];
                let p = [0, 1, 2].map(|axis| Many(std::array::from_fn(|i| lane(axis, i))));
                let f = evaluator.eval(&p);
                for (&value, &(_, i)) in f.0.iter().zip(batch) {
                    let group = groups[i];
                    if let Some(cube) = group[0].0 {
                        self.tree.keep_value(cube, value);
                    }
                    for &(cube, ray, _) in group {
                        match cube {
                            Some(_) => of(walks, ray).come(&self.tree, value),
                            None => of(walks, ray).learn(&self.tree, value),
                        }
                    }
                }
            }
        }
    }
}

/// The walk of a ray; they are in the order of these.
fn of(walks: &mut [Walk], ray: usize) -> &mut Walk {
    let at = walks.partition_point(|walk| walk.ray < ray);
    &mut walks[at]
}

impl Caster for Octree {
    fn first_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool) {
        self.cast(false, rays, out, stats, cancel);
    }

    fn any_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool) {
        self.cast(true, rays, out, stats, cancel);
    }

    fn costs(&self) -> &[f64] {
        &self.costs
    }

    fn lipschitz(&self) -> Option<f64> {
        Some(self.steep).filter(|steep| steep.is_finite())
    }

    fn values(&self) -> Option<Arc<Cells>> {
        Some(self.cells.clone())
    }

    fn clone_box(&self) -> Box<dyn Caster> {
        Box::new(Octree::within(self.cells.clone(), self.tree.clone(), self.steep))
    }
}
