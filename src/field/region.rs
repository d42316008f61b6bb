//! Questions about a whole region, answered by cutting it up. What is left of the tape in a part of the
//! region answers for that part.

use super::Field;
use crate::num::{Dual, Interval, Many, Number, Slope};
use crate::scene::Aabb;
use crate::tape::{Evaluator, Tape};
use glam::DVec3;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::sync::Arc;

/// Says whether nothing more is to be looked at; asked from any thread.
pub type Halt<'a> = &'a (dyn Fn() -> bool + Sync);

/// Questions and cuts that are not worth the while of several threads.
const FEW: usize = 16;

/// A part of a region, with what is left of the tape there.
#[derive(Clone)]
pub(super) struct Part {
    pub cell: Aabb,
    pub tape: Arc<Tape>,
}

impl Part {
    /// The eight halves.
    fn octants(&self) -> impl Iterator<Item = Part> + use<> {
        let shorter = self.tape.has_choices().then(|| Arc::new(self.tape.prune(&self.cell.intervals())));
        let tape = shorter.unwrap_or_else(|| self.tape.clone());
        octants(&self.cell).map(move |cell| Part { cell, tape: tape.clone() })
    }
}

/// The value of a field, or what is known of it.
fn eval<'a, T: Number>(evaluator: &'a mut Evaluator<T>, part: &Part, at: &[T; 3]) -> &'a T {
    evaluator.turn_to(&part.tape);
    evaluator.eval(at)
}

/// Parts that a box is cut into.
const OCTANTS: usize = 8;

/// The eight halves of a box.
pub(super) fn octants(b: &Aabb) -> impl Iterator<Item = Aabb> + use<> {
    let Aabb { min, max } = *b;
    let mid = (min + max) * 0.5;
    (0..OCTANTS).map(move |i| {
        let upper = glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0);
        Aabb { min: DVec3::select(upper, mid, min), max: DVec3::select(upper, max, mid) }
    })
}

/// Where a solid may be within a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Extent {
    /// Proven: there is nothing in the region.
    Empty,
    /// Proven: the part of the solid in the region lies in this box.
    Within(Aabb),
    /// The solid may go on beyond the region.
    Open(Aabb),
}

/// Cells that a search may look at before it settles for what it has,
const CELLS: usize = 4096;

/// and [work](Tape::work) that it may do for the next of its steps. Fields of at most a few thousand operations
/// get all of their cells.
const WORK: u64 = 1 << 24;

/// Whether cutting all of these once more would be too much.
fn is_last<'a>(parts: impl ExactSizeIterator<Item = &'a Part>) -> bool {
    8 * parts.len() > CELLS || 8 * parts.map(|part| part.tape.work()).sum::<u64>() > WORK
}

/// Finds a box around the solid `f <= 0` in `region`, by excluding cells where `f > 0` is certain.
pub fn extent(field: &Field, region: &Aabb) -> Extent {
    extent_until(field, region, &|| false)
}

/// The same, but nothing more is excluded when `halt` says so.
pub fn extent_until(field: &Field, region: &Aabb, halt: Halt<'_>) -> Extent {
    let parts = exclude(field, vec![Part { cell: *region, tape: field.tape().clone() }], halt);
    let Some(found) = parts.iter().map(|part| part.cell).reduce(|a, b| a.hull(&b)) else {
        return Extent::Empty;
    };
    // A little air, so that rays start outside of a solid that fills its cells.
    let margin = 1e-3 * found.diagonal();
    let grown = Aabb { min: found.min - margin, max: found.max + margin };
    let touches = found.min.cmple(region.min).any() || found.max.cmpge(region.max).any();
    if touches {
        Extent::Open(Aabb { min: grown.min.max(region.min), max: grown.max.min(region.max) })
    } else {
        Extent::Within(grown)
    }
}

/// Cuts up parts of space and leaves out those where it is certain that `f > 0`. Nothing more is left out when `halt`
/// says so.
pub(super) fn exclude(field: &Field, mut parts: Vec<Part>, halt: Halt<'_>) -> Vec<Part> {
    let ranges = || Evaluator::<Many<Interval, OCTANTS>>::new(field.tape().clone());
    let mut own = ranges();
    let hull = |parts: &[Part]| parts.iter().map(|part| part.cell).reduce(|a, b| a.hull(&b));
    let least = 1e-9 * hull(&parts).map_or(0.0, |all| all.diagonal());
    loop {
        let asked: Vec<&[Part]> = batches(&parts).collect();
        parts = if asked.len() < FEW {
            asked.into_iter().flat_map(|batch| possible(&mut own, batch, halt)).collect()
        } else {
            let ask = |own: &mut Evaluator<_>, batch: &&[Part]| possible(own, batch, halt);
            asked.par_iter().with_min_len(FEW / 4).map_init(ranges, ask).flatten_iter().collect()
        };
        let is_small = hull(&parts).is_none_or(|rest| rest.diagonal() < least);
        if halt() || is_small || is_last(parts.iter()) {
            return parts;
        }
        parts = if parts.len() < FEW {
            parts.iter().flat_map(Part::octants).collect()
        } else {
            parts.par_iter().flat_map_iter(Part::octants).collect()
        };
    }
}

/// Those of some parts with one tape where `f <= 0` may be.
fn possible(ranges: &mut Evaluator<Many<Interval, OCTANTS>>, batch: &[Part], halt: Halt<'_>) -> Vec<Part> {
    if halt() {
        return batch.to_vec();
    }
    let cell = |lane: usize| batch[lane.min(batch.len() - 1)].cell.intervals();
    let at = std::array::from_fn(|axis| Many(std::array::from_fn(|lane| cell(lane)[axis])));
    let found = eval(ranges, &batch[0], &at).0;
    // A cell that has no value is not excluded.
    batch
        .iter()
        .zip(found)
        .filter(|(_, f)| !matches!(f.lo.partial_cmp(&0.0), Some(Ordering::Greater)))
        .map(|(part, _)| part.clone())
        .collect()
}

/// Parts that can be asked about at once. Octants have one tape; without choices all parts have.
fn batches(parts: &[Part]) -> impl Iterator<Item = &[Part]> {
    parts.chunk_by(|a, b| Arc::ptr_eq(&a.tape, &b.tape)).flat_map(|same| same.chunks(OCTANTS))
}

/// Lipschitz bound of `f` over the part of a region where `f >= 0` is possible, which is all that a
/// ray approaching from outside ever sees. Infinite where there is no bound.
pub fn lipschitz_outside(field: &Field, region: &Aabb) -> f64 {
    lipschitz_until(field, region, &|| false).unwrap_or(f64::INFINITY)
}

/// The same, given up when `halt` says so.
pub fn lipschitz_until(field: &Field, region: &Aabb, halt: Halt<'_>) -> Option<f64> {
    let mut slopes = Evaluator::<Many<Slope, OCTANTS>>::new(field.tape().clone());
    let mut duals = Evaluator::<Dual>::new(field.tape().clone());
    let mut bound: f64 = 0.0;
    let mut parts = vec![Part { cell: *region, tape: field.tape().clone() }];
    for level in 0.. {
        let last = is_last(parts.iter());
        let mut steep = Vec::new();
        for same in batches(&parts) {
            if halt() {
                return None;
            }
            let cells = |i: usize| same[i.min(same.len() - 1)].cell.intervals();
            let coordinate =
                |axis: usize| Many(std::array::from_fn(|i| Slope::coordinate(cells(i)[axis], axis)));
            let all = eval(&mut slopes, &same[0], &std::array::from_fn(coordinate));
            for (part, slope) in same.iter().zip(&all.0) {
                if slope.value.hi < 0.0 {
                    continue;
                }
                // A cell that is no steeper than what is known anyway needs no cutting.
                if last || slope.norm <= bound {
                    bound = bound.max(slope.norm);
                } else {
                    steep.push((slope.norm, part.clone()));
                }
            }
        }
        if steep.is_empty() {
            break;
        }
        // The corner values of steep cells bound from below how far cutting can get.
        let mut corner = |part: &Part| {
            let p = part.cell.min.to_array();
            let dual = eval(&mut duals, part, &std::array::from_fn(|axis| Dual::coordinate(p[axis], axis)));
            DVec3::from_array(dual.grad).length()
        };
        let lowest = steep.iter().map(|(_, part)| corner(part)).fold(0.0, f64::max);
        let settled = level > 0 && steep.iter().all(|(norm, _)| *norm <= 1.02 * lowest.max(bound));
        if settled {
            bound = steep.iter().map(|s| s.0).fold(bound, f64::max);
            break;
        }
        parts = steep.iter().flat_map(|(_, part)| part.octants()).collect();
    }
    Some(bound)
}
