//! Marching a group of rays: the loop that all casters share.
//!
//! A caster is a small state machine per ray: it asks for the field somewhere, is told the answer,
//! and in the end has one. The loop collects the questions of all rays that are still under way and
//! has them answered a batch at a time, by the tapes of the places that they are about.

use super::{CastStats, Caster, Hit, Ray};
use crate::num::{Affine, Centred, Interval, Many, Number};
use crate::tape::{Cells, Evaluator, Tape};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Questions answered together. More would amortise dispatch better but leave more lanes idle when
/// few rays are left.
pub(super) const LANES: usize = 32;

/// What the questions of several rays are gathered in.
pub(super) trait Batch: Number {
    /// A coordinate in a question, or an answer.
    type Lane: Number;

    /// Questions in a batch.
    const LANES: usize;

    /// All lanes alike.
    fn alike(lane: Self::Lane) -> Self;

    /// Changes a lane.
    fn set(&mut self, lane: usize, to: Self::Lane);

    /// A lane.
    fn lane(&self, lane: usize) -> &Self::Lane;
}

impl<T: Centred + Copy> Batch for Many<T, LANES> {
    type Lane = T;
    const LANES: usize = LANES;
    fn alike(lane: T) -> Self {
        Many([lane; LANES])
    }
    fn set(&mut self, lane: usize, to: T) {
        self.0[lane] = to;
    }
    fn lane(&self, lane: usize) -> &T {
        &self.0[lane]
    }
}

/// One question at a time.
impl Batch for Affine {
    type Lane = Affine;
    const LANES: usize = 1;
    fn alike(lane: Affine) -> Self {
        lane
    }
    fn set(&mut self, _: usize, to: Affine) {
        *self = to;
    }
    fn lane(&self, _: usize) -> &Affine {
        self
    }
}

/// A coordinate in a question of a strategy, or an answer to one.
type Lane<S> = <<S as Strategy>::Batch as Batch>::Lane;

/// One way to cast a ray.
pub(super) trait Strategy: Clone + Send + 'static {
    /// What the field is evaluated on.
    type Batch: Batch;
    /// Progress of one ray.
    type March;

    /// The same way, content with any place that is inside.
    fn any(&self) -> Self;

    /// The Lipschitz bound of the field that it goes by, if it does.
    fn lipschitz(&self) -> Option<f64> {
        None
    }

    /// Before the first question.
    fn start(&self, ray: &Ray) -> Self::March;

    /// The coordinates to evaluate the field on next.
    fn ask(&self, ray: &Ray, march: &Self::March) -> [Lane<Self>; 3];

    /// The field there; returns the hit once it is known.
    fn tell(&self, ray: &Ray, march: &mut Self::March, f: &Lane<Self>, stats: &mut CastStats) -> Option<Hit>;
}

/// A strategy with the memory to run it.
pub(super) struct Group<S: Strategy> {
    pub(super) strategy: S,
    any: S,
    pub(super) cells: Arc<Cells>,
    evaluator: Evaluator<S::Batch>,
    /// Evaluations for each ray of the last group.
    pub(super) costs: Vec<f64>,
}

impl<S: Strategy> Group<S> {
    pub(super) fn new(strategy: S, cells: Arc<Cells>) -> Self {
        let evaluator = Evaluator::new(cells.tape().clone());
        Group { any: strategy.any(), strategy, cells, evaluator, costs: Vec::new() }
    }

    /// The same with memory of its own.
    pub(super) fn again(&self) -> Self {
        Group::new(self.strategy.clone(), self.cells.clone())
    }
}

/// A ray under way.
struct Active<S: Strategy> {
    /// Of the group.
    ray: usize,
    march: S::March,
    /// Evaluations so far.
    asked: u32,
}

/// Marches all rays to their ends, or until cancelled; `done` gets the number of a ray, its last
/// state, its hit, and how often the field was evaluated for it.
pub(super) fn march<S: Strategy>(
    strategy: &S,
    (cells, evaluator): (&Cells, &mut Evaluator<S::Batch>),
    rays: &[Ray],
    stats: &mut CastStats,
    cancel: &AtomicBool,
    mut done: impl FnMut(usize, S::March, Hit, u32),
) {
    let mut active: Vec<Active<S>> = Vec::with_capacity(rays.len());
    for (i, ray) in rays.iter().enumerate() {
        stats.rays += 1;
        let march = strategy.start(ray);
        // A single point is a ray, too; there is nothing on one that ends before it begins.
        if ray.near <= ray.far {
            active.push(Active { ray: i, march, asked: 0 });
        } else {
            done(i, march, Hit::MISS, 0);
        }
    }
    let mut questions: Vec<[Lane<S>; 3]> = Vec::with_capacity(active.len());
    let mut outcomes: Vec<Option<Hit>> = Vec::with_capacity(active.len());
    while !active.is_empty() && !cancel.load(Ordering::Relaxed) {
        questions.clear();
        questions.extend(active.iter().map(|a| strategy.ask(&rays[a.ray], &a.march)));
        outcomes.clear();
        outcomes.resize(active.len(), None);
        let order = by_tape(cells, &questions);
        for batch in order.chunk_by(|a, b| Arc::ptr_eq(a.0, b.0)).flat_map(|s| s.chunks(S::Batch::LANES)) {
            if cancel.load(Ordering::Relaxed) {
                break;
            }
            evaluator.turn_to(batch[0].0);
            let answers = evaluator.eval(&gathered::<S>(&questions, batch));
            stats.evaluations += batch.len() as u64;
            stats.work += batch[0].0.work() * S::Batch::LANES as u64;
            for (lane, &(_, i)) in batch.iter().enumerate() {
                let Active { ray, march, asked } = &mut active[i];
                *asked += 1;
                outcomes[i] = strategy.tell(&rays[*ray], march, answers.lane(lane), stats);
            }
        }
        let settle = |(active, outcome): (Active<S>, &Option<Hit>)| match outcome {
            Some(hit) => {
                let hit = known(cells, &rays[active.ray], *hit);
                stats.hits += u64::from(hit.is_hit());
                stats.uncertified += u64::from(!hit.certified);
                done(active.ray, active.march, hit, active.asked);
                None
            }
            None => Some(active),
        };
        active = active.into_iter().zip(&outcomes).filter_map(settle).collect();
    }
}

/// A hit, certified only if the field is known to have a value there: at a pole of what it is made of no arithmetic tells a
/// crossing from a jump.
fn known(cells: &Cells, ray: &Ray, hit: Hit) -> Hit {
    let has_value = || {
        let reach = ray.tolerance.at(hit.t) + ray.rounding(hit.t);
        let part = ray.at(hit.t).to_array().map(|x| Interval::around(x, reach));
        cells.is_defined_in(&part) || cells.tape().is_defined(&part)
    };
    let certified = hit.certified && (!hit.is_hit() || has_value());
    Hit { certified, ..hit }
}

/// The questions, each with the tape that answers it, those with the same tape next to each other.
pub(super) fn by_tape<'a, T: Number>(cells: &'a Cells, questions: &[[T; 3]]) -> Vec<(&'a Arc<Tape>, usize)> {
    if cells.is_uniform() {
        return (0..questions.len()).map(|i| (cells.tape(), i)).collect();
    }
    cells.tapes_around(questions.iter().enumerate().map(|(i, question)| {
        let place = question.each_ref().map(Number::range);
        (i, place.map(Interval::mid), place.map(Interval::rad).into_iter().fold(0.0, f64::max))
    }))
}

/// The questions of a batch. Idle lanes repeat the first.
fn gathered<S: Strategy>(questions: &[[Lane<S>; 3]], batch: &[(&Arc<Tape>, usize)]) -> [S::Batch; 3] {
    let mut p = questions[batch[0].1].clone().map(S::Batch::alike);
    for (lane, &(_, i)) in batch.iter().enumerate().skip(1) {
        for (p, asked) in p.iter_mut().zip(&questions[i]) {
            p.set(lane, asked.clone());
        }
    }
    p
}

impl<S: Strategy> Caster for Group<S> {
    fn first_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool) {
        let Group { strategy, cells, evaluator, costs, .. } = self;
        costs.clear();
        costs.resize(rays.len(), 0.0);
        march(strategy, (cells, evaluator), rays, stats, cancel, |i, _, hit, asked| {
            (out[i], costs[i]) = (hit, f64::from(asked));
        });
    }

    fn any_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool) {
        std::mem::swap(&mut self.strategy, &mut self.any);
        self.first_hits(rays, out, stats, cancel);
        std::mem::swap(&mut self.strategy, &mut self.any);
    }

    fn costs(&self) -> &[f64] {
        &self.costs
    }

    fn clone_box(&self) -> Box<dyn Caster> {
        Box::new(self.again())
    }
}
