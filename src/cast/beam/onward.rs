//! Rays that begin next to the surface, each somewhere else, and go the same way.
//!
//! Where they begin they have nothing in common, so each marches alone until it is well away from there. What is left of
//! them is cast by beams like other rays: of rays that come out of a crumb next to one another, most go on to the same
//! ground.

use super::Beams;
use crate::cast::{CastStats, Caster, Hit, Ray};
use crate::tape::Cells;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// How far rays march alone, in tolerances: some pixels in pictures.
const CLEAR: f64 = 8000.0;

/// Casts rays that begin next to the surface; see the module text.
pub(in crate::cast) struct Onward {
    alone: Beams,
    together: Beams,
    costs: Vec<f64>,
    insides: Vec<f64>,
}

impl Onward {
    pub(in crate::cast) fn new(cells: Arc<Cells>) -> Onward {
        let (alone, together) = (Beams::alone(cells.clone()), Beams::new(cells));
        Onward { alone, together, costs: Vec::new(), insides: Vec::new() }
    }

    /// The same with memory of its own.
    pub(in crate::cast) fn again(&self) -> Onward {
        Onward::new(self.together.cells.clone())
    }
}

impl Caster for Onward {
    fn first_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool) {
        let clear = |ray: &Ray| ray.near + CLEAR * ray.tolerance.at(ray.near);
        let short: Vec<Ray> = rays.iter().map(|ray| Ray { far: ray.far.min(clear(ray)), ..*ray }).collect();
        self.alone.first_hits(&short, out, stats, cancel);
        self.costs.clone_from(&self.alone.memory.costs);
        self.insides.clone_from(&self.alone.memory.insides);
        if cancel.load(Ordering::Relaxed) {
            return;
        }
        // Of a ray that has met something there is nothing left.
        let left = |(ray, hit): (&Ray, &Hit)| Ray {
            near: if hit.is_hit() { f64::INFINITY } else { clear(ray) },
            ..*ray
        };
        let left: Vec<Ray> = rays.iter().zip(&*out).map(left).collect();
        let mut hits = vec![Hit::MISS; rays.len()];
        self.together.first_hits(&left, &mut hits, stats, cancel);
        let own = self.together.costs().iter().zip(self.together.insides());
        for (i, (cost, inside)) in own.enumerate() {
            self.costs[i] += cost;
            self.insides[i] = self.insides[i].min(*inside);
            if hits[i].is_hit() {
                out[i].t = hits[i].t;
            }
            out[i].certified &= hits[i].certified;
        }
    }

    fn costs(&self) -> &[f64] {
        &self.costs
    }

    fn insides(&self) -> &[f64] {
        &self.insides
    }

    fn clone_box(&self) -> Box<dyn Caster> {
        Box::new(self.again())
    }
}
