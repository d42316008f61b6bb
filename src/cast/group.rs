//! Marching a group of rays: the loop that all casters share.
//!
//! A caster is a small state machine per ray: it asks for the field somewhere, is told the answer,
//! and in the end has one. The loop collects the questions of all rays that are still under way and
//! has them answered a batch at a time.

use super::{CastStats, Caster, Hit, Ray};
use crate::num::{Centred, Many};
use crate::tape::{Evaluator, Tape};
use std::sync::Arc;

/// Questions answered together. More would amortise dispatch better but leave more lanes idle when
/// few rays are left.
const LANES: usize = 16;

/// One way to cast a ray.
pub(super) trait Strategy: Clone + Send + 'static {
    /// What the field is evaluated on.
    type Number: Centred + Copy;
    /// Progress of one ray.
    type March;

    /// Before the first question; a hit where there is nothing to ask.
    fn start(&self, ray: &Ray) -> Self::March;

    /// The coordinates to evaluate the field on next.
    fn ask(&self, ray: &Ray, march: &Self::March) -> [Self::Number; 3];

    /// The field there; returns the hit once it is known.
    fn tell(
        &self,
        ray: &Ray,
        march: &mut Self::March,
        f: &Self::Number,
        stats: &mut CastStats,
    ) -> Option<Hit>;
}

/// A strategy with the memory to run it.
pub(super) struct Group<S: Strategy> {
    strategy: S,
    evaluator: Evaluator<Many<S::Number, LANES>>,
}

impl<S: Strategy> Group<S> {
    pub(super) fn new(strategy: S, tape: Arc<Tape>) -> Self {
        Group { strategy, evaluator: Evaluator::new(tape) }
    }

    /// The same with memory of its own.
    pub(super) fn again(&self) -> Self {
        Group::new(self.strategy.clone(), self.evaluator.tape().clone())
    }

    /// Marches all rays to their ends; `done` gets the number of a ray, its last state and its hit.
    pub(super) fn march(
        &mut self,
        rays: &[Ray],
        stats: &mut CastStats,
        mut done: impl FnMut(usize, S::March, Hit),
    ) {
        let mut active: Vec<(usize, S::March)> = Vec::with_capacity(rays.len());
        for (i, ray) in rays.iter().enumerate() {
            stats.rays += 1;
            let march = self.strategy.start(ray);
            if ray.near < ray.far {
                active.push((i, march));
            } else {
                done(i, march, Hit::MISS);
            }
        }
        while !active.is_empty() {
            let mut next = Vec::with_capacity(active.len());
            let mut queue = active.into_iter().peekable();
            while queue.peek().is_some() {
                let mut batch: Vec<(usize, S::March)> = queue.by_ref().take(LANES).collect();
                let asked: Vec<[S::Number; 3]> =
                    batch.iter().map(|(i, march)| self.strategy.ask(&rays[*i], march)).collect();
                // Idle lanes repeat the first question.
                let lane = |l: usize| asked.get(l).unwrap_or(&asked[0]);
                let p = std::array::from_fn(|axis| Many(std::array::from_fn(|l| lane(l)[axis])));
                let answers = self.evaluator.eval(&p).0;
                stats.evaluations += batch.len() as u64;
                for (l, (i, mut march)) in batch.drain(..).enumerate() {
                    match self.strategy.tell(&rays[i], &mut march, &answers[l], stats) {
                        Some(hit) => {
                            stats.hits += u64::from(hit.is_hit());
                            stats.uncertified += u64::from(!hit.certified);
                            done(i, march, hit);
                        }
                        None => next.push((i, march)),
                    }
                }
            }
            active = next;
        }
    }
}

impl<S: Strategy> Caster for Group<S> {
    fn first_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats) {
        self.march(rays, stats, |i, _, hit| out[i] = hit);
    }

    fn clone_box(&self) -> Box<dyn Caster> {
        Box::new(self.again())
    }
}
