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

/// How far rays march alone, in tolerances: some pixels in pictures. (Measured on the ground of a planet with crumbs: a
/// quarter of it takes a tenth more evaluations, and a sixteenth of it two thirds more.)
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
        // Of a ray that has met something, or has come to its end, there is nothing left.
        let left = |(ray, hit): (&Ray, &Hit)| {
            let near = Some(clear(ray)).filter(|clear| !hit.is_hit() && *clear < ray.far);
            Ray { near: near.unwrap_or(f64::INFINITY), ..*ray }
        };
        let left: Vec<Ray> = rays.iter().zip(&*out).map(left).collect();
        let mut hits = vec![Hit::MISS; rays.len()];
        self.together.first_hits(&left, &mut hits, stats, cancel);
        let own = self.together.costs().iter().zip(self.together.insides());
        for (i, (cost, inside)) in own.enumerate() {
            self.costs[i] += cost;
            if hits[i].is_hit() {
                (out[i].t, self.insides[i]) = (hits[i].t, *inside);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cast::Tolerance;
    use crate::expr::Graph;
    use crate::num::Interval;
    use crate::op::{Add, Mul, Op, Sin};
    use crate::tape::{Evaluator, Tape};
    use glam::DVec3;
    use std::sync::atomic::AtomicBool;

    #[test]
    fn rays_meet_what_they_meet_alone() {
        // sin(x) sin(y) + z sin(z) / 4
        let mut graph = Graph::default();
        let [x, y, z] = graph.point().unwrap();
        let [a, b, c] = [x, y, z].map(|input| graph.op(Op::Sin(Sin), &[input]).unwrap());
        let ab = graph.op(Op::Mul(Mul), &[a, b]).unwrap();
        let quarter = graph.constant(0.25).unwrap();
        let zc = graph.op(Op::Mul(Mul), &[z, c]).unwrap();
        let zc = graph.op(Op::Mul(Mul), &[zc, quarter]).unwrap();
        let field = graph.op(Op::Add(Add), &[ab, zc]).unwrap();
        let tape = Arc::new(Tape::new(&graph, &[field]));
        let mut values = Evaluator::<f64>::new(tape.clone());
        let mut value = |p: DVec3| *values.eval(&p.to_array());
        let cells = Arc::new(Cells::of_sides(tape, &[Interval::new(-60.0, 60.0); 3]));
        // Rays through a grid of pixels, each from beside the surface on.
        let tolerance = Tolerance { least: 1e-6, growth: 6e-6 };
        let (mut rays, step) = (Vec::new(), 0.01);
        for i in 0..1024 {
            let (across, up) = (f64::from(i % 32) - 15.5, f64::from(i / 32) - 15.5);
            let direction = DVec3::new(1.0, 0.7 + 0.003 * across, 0.15 + 0.003 * up).normalize();
            let origin = DVec3::new(0.1, 0.2, 0.3);
            let at = |k: i32| step * f64::from(k);
            let is_exit = |k: &i32| {
                value(origin + at(*k) * direction) < 0.0 && value(origin + at(k + 1) * direction) > 0.0
            };
            let near = (10..2000).find(is_exit).map(|k| at(k + 1));
            let far = if near.is_some() { 40.0 } else { f64::NEG_INFINITY };
            rays.push(Ray { origin, direction, near: near.unwrap_or(f64::INFINITY), far, tolerance });
        }
        let never = AtomicBool::new(false);
        let cast = |caster: &mut dyn Caster| {
            let (mut hits, mut stats) = (vec![Hit::MISS; rays.len()], CastStats::default());
            caster.first_hits(&rays, &mut hits, &mut stats, &never);
            let costs: f64 = caster.costs().iter().sum();
            assert!((costs - stats.evaluations as f64).abs() < 1e-6 * costs);
            (hits, caster.insides().to_vec(), costs)
        };
        let (alone, _, own) = cast(&mut Beams::alone(cells.clone()));
        let (together, insides, all) = cast(&mut Onward::new(cells));
        let met = alone.iter().filter(|hit| hit.is_hit()).count();
        assert!(met > 500, "{met}");
        assert!(all < 0.9 * own, "{all} {own}");
        for (i, (a, b)) in alone.iter().zip(&together).enumerate() {
            assert_eq!((a.certified, a.is_hit()), (b.certified, b.is_hit()), "{i}");
            assert!(!a.is_hit() || (a.t - b.t).abs() <= rays[i].tolerance.at(a.t), "{a:?} {b:?}");
            let inside = insides[i];
            assert!(!inside.is_finite() || value(rays[i].at(inside)) < 0.0, "{i}");
        }
    }
}
