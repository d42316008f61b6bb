//! A way to cast that is quick where it works, and affine arithmetic for the rays that it gives up.

use super::group::{Group, Strategy};
use super::pieces::Pieces;
use super::{CastStats, Caster, Hit, Ray};
use crate::num::Reduced;
use crate::tape::Cells;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// How a strategy hands a ray over: free up to `t`, and no more is known.
pub(super) fn undecided(t: f64) -> Hit {
    Hit { t, certified: false }
}

/// Casts by a strategy whose uncertified hits are [`undecided`].
pub(super) struct Handover<S: Strategy> {
    quick: Group<S>,
    sure: Group<Pieces<Reduced<1>>>,
}

/// One of the two questions a caster answers.
type Cast<C> = fn(&mut C, &[Ray], &mut [Hit], &mut CastStats, &AtomicBool);

impl<S: Strategy> Handover<S> {
    pub(super) fn new(strategy: S, cells: Arc<Cells>) -> Self {
        let sure = Group::new(Pieces::trimming(&cells), cells.clone());
        Handover { quick: Group::new(strategy, cells), sure }
    }

    fn cast(
        &mut self,
        (quickly, surely): (Cast<Group<S>>, Cast<Group<Pieces<Reduced<1>>>>),
        rays: &[Ray],
        out: &mut [Hit],
        stats: &mut CastStats,
        cancel: &AtomicBool,
    ) {
        let mut own = CastStats::default();
        quickly(&mut self.quick, rays, out, &mut own, cancel);
        let open: Vec<usize> = (0..rays.len()).filter(|&i| !out[i].certified).collect();
        let rest: Vec<Ray> = open.iter().map(|&i| Ray { near: out[i].t, ..rays[i] }).collect();
        let mut hits = vec![Hit::MISS; rest.len()];
        let mut theirs = CastStats::default();
        surely(&mut self.sure, &rest, &mut hits, &mut theirs, cancel);
        for ((&i, &hit), cost) in open.iter().zip(&hits).zip(&self.sure.costs) {
            out[i] = hit;
            self.quick.costs[i] += cost;
        }
        // A ray that was handed over is one ray, and was no hit before.
        theirs.rays = 0;
        own.hits -= rest.len() as u64;
        own.uncertified = 0;
        *stats += own;
        *stats += theirs;
    }
}

impl<S: Strategy> Caster for Handover<S> {
    fn first_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool) {
        self.cast((Group::first_hits, Group::first_hits), rays, out, stats, cancel);
    }

    fn any_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool) {
        self.cast((Group::any_hits, Group::any_hits), rays, out, stats, cancel);
    }

    fn costs(&self) -> &[f64] {
        &self.quick.costs
    }

    fn lipschitz(&self) -> Option<f64> {
        self.quick.strategy.lipschitz()
    }

    fn values(&self) -> Option<Arc<Cells>> {
        Some(self.quick.cells.clone())
    }

    fn clone_box(&self) -> Box<dyn Caster> {
        Box::new(Handover { quick: self.quick.again(), sure: self.sure.again() })
    }
}
