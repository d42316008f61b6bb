//! Marching a group of rays: the loop that all casters share.
//!
//! A caster is a small state machine per ray: it asks for the field somewhere, is told the answer,
//! and in the end has one. The loop collects the questions of all rays that are still under way and
//! has them answered a batch at a time.

use super::{CastStats, Caster, Hit, Ray};
use crate::num::{Centred, Many};
use crate::tape::{Evaluator, Tape};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Questions answered together. More would amortise dispatch better but leave more lanes idle when
/// few rays are left.
const LANES: usize = 32;

/// One way to cast a ray.
pub(super) trait Strategy: Clone + Send + 'static {
    /// What the field is evaluated on.
    type Number: Centred + Copy;
    /// Progress of one ray.
    type March;

    /// Before the first question.
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
    /// Evaluations for each ray of the last group.
    pub(super) costs: Vec<f64>,
}

impl<S: Strategy> Group<S> {
    pub(super) fn new(strategy: S, tape: Arc<Tape>) -> Self {
        Group { strategy, evaluator: Evaluator::new(tape), costs: Vec::new() }
    }

    /// The same with memory of its own.
    pub(super) fn again(&self) -> Self {
        Group::new(self.strategy.clone(), self.evaluator.tape().clone())
    }

    /// Marches all rays to their ends, or until cancelled; `done` gets the number of a ray, its last state and its hit.
    pub(super) fn march(
        &mut self,
        rays: &[Ray],
        stats: &mut CastStats,
        cancel: &AtomicBool,
        mut done: impl FnMut(usize, S::March, Hit),
    ) {
        self.costs.clear();
        self.costs.resize(rays.len(), 0.0);
        let mut active: Vec<(usize, S::March)> = Vec::with_capacity(rays.len());
        for (i, ray) in rays.iter().enumerate() {
            stats.rays += 1;
            let march = self.strategy.start(ray);
            // A single point is a ray, too; there is nothing on one that ends before it begins.
            if ray.near <= ray.far {
                active.push((i, march));
            } else {
                done(i, march, Hit::MISS);
            }
        }
        let mut outcomes: Vec<Option<Hit>> = Vec::with_capacity(rays.len());
        while !active.is_empty() && !cancel.load(Ordering::Relaxed) {
            outcomes.clear();
            for batch in active.chunks_mut(LANES) {
                self.round(rays, batch, &mut outcomes, stats);
            }
            let settle = |((i, march), outcome): ((usize, S::March), &Option<Hit>)| match outcome {
                Some(hit) => {
                    stats.hits += u64::from(hit.is_hit());
                    stats.uncertified += u64::from(!hit.certified);
                    done(i, march, *hit);
                    None
                }
                None => Some((i, march)),
            };
            active = active.into_iter().zip(&outcomes).filter_map(settle).collect();
        }
    }

    /// One question and answer for each ray of a batch.
    fn round(
        &mut self,
        rays: &[Ray],
        batch: &mut [(usize, S::March)],
        outcomes: &mut Vec<Option<Hit>>,
        stats: &mut CastStats,
    ) {
        // Idle lanes repeat the first question.
        let first = self.strategy.ask(&rays[batch[0].0], &batch[0].1);
        let mut p = first.map(|c| Many([c; LANES]));
        for (l, (i, march)) in batch.iter().enumerate().skip(1) {
            let asked = self.strategy.ask(&rays[*i], march);
            for axis in 0..3 {
                p[axis].0[l] = asked[axis];
            }
        }
        let answers = self.evaluator.eval(&p);
        stats.evaluations += batch.len() as u64;
        for (l, (i, march)) in batch.iter_mut().enumerate() {
            self.costs[*i] += 1.0;
            outcomes.push(self.strategy.tell(&rays[*i], march, &answers.0[l], stats));
        }
    }
}

impl<S: Strategy> Caster for Group<S> {
    fn first_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool) {
        self.march(rays, stats, cancel, |i, _, hit| out[i] = hit);
    }

    fn costs(&self) -> &[f64] {
        &self.costs
    }

    fn clone_box(&self) -> Box<dyn Caster> {
        Box::new(self.again())
    }
}
