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
        let shorter = is_pruned(&self.tape).then(|| Arc::new(self.tape.prune(&self.cell.intervals())));
        let tape = shorter.unwrap_or_else(|| self.tape.clone());
        octants(&self.cell).map(move |cell| Part { cell, tape: tape.clone() })
    }
}

/// Instructions of a tape that is as quickly evaluated for all octants as it is pruned.
const SHORT: usize = 128;

/// Whether octants have tapes of their own.
fn is_pruned(tape: &Tape) -> bool {
    tape.len() > SHORT && tape.has_choices()
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

/// Cells that a search may look at, and those for each operand where there are many, before it settles for what it has,
const CELLS: usize = 1 << 12;

/// all cells that are kept at a time,
const MOST: usize = 1 << 18;

/// and the work that may be done for the next step: fields of at most a few thousand operations get most of their cells.
const WORK: u64 = 1 << 28;

/// How much [work](Tape::work) it is to cut up a part: what is long is pruned, or full of noises.
fn cost(part: &Part) -> u64 {
    let each = if part.tape.len() > SHORT { LONG } else { 1 };
    part.tape.work().saturating_mul(OCTANTS as u64 * each)
}

/// As how many evaluations it counts to cut up a part with a long tape.
const LONG: u64 = 16;

/// Whether cutting all of these once more would be too much.
fn is_last<'a>(parts: impl ExactSizeIterator<Item = &'a Part>, most: usize) -> bool {
    OCTANTS * parts.len() > most.min(MOST) || parts.map(cost).fold(0, u64::saturating_add) > WORK
}

/// How much larger than it has to be a box may be, of its diagonal.
const CLOSE: f64 = 4e-3;

/// Finds a box around the solid `f <= 0` in `region`, by excluding cells where it is certain that `f > 0`, or that
/// `f` has no value.
pub fn extent(field: &Field, region: &Aabb) -> Extent {
    extent_until(field, region, &|| false)
}

/// The same, but nothing more is excluded when `halt` says so.
pub fn extent_until(field: &Field, region: &Aabb, halt: Halt<'_>) -> Extent {
    let Some(found) = hull(field, region, false, halt) else { return Extent::Empty };
    let grown = aired(&found);
    if touches(&found, region) {
        Extent::Open(Aabb { min: grown.min.max(region.min), max: grown.max.min(region.max) })
    } else {
        Extent::Within(grown)
    }
}

/// A box around all of the solid in a region, however far it goes on beyond, with a little air within the region; none if it is
/// proven that there is nothing, and no closer when `halt` says so.
pub fn part_within(field: &Field, region: &Aabb, halt: Halt<'_>) -> Option<Aabb> {
    let grown = aired(&hull(field, region, true, halt)?);
    Some(Aabb { min: grown.min.max(region.min), max: grown.max.min(region.max) })
}

/// A box with a little air around it, so that rays start outside of a solid that fills its cells.
fn aired(found: &Aabb) -> Aabb {
    let margin = 1e-3 * found.diagonal();
    Aabb { min: found.min - margin, max: found.max + margin }
}

/// Whether a box is not all inside of another.
fn touches(inner: &Aabb, outer: &Aabb) -> bool {
    inner.min.cmple(outer.min).any() || inner.max.cmpge(outer.max).any()
}

/// A box around all of the solid in a region; none if it is proven that there is nothing.
///
/// It is to hold points that are known to be solid, so of the cells that may be, only those that stick out of a box around such
/// points can make it larger, and only they are cut up. What goes on beyond the region is looked at more closely only if it is
/// `open` to that.
fn hull(field: &Field, region: &Aabb, open: bool, halt: Halt<'_>) -> Option<Aabb> {
    let mut values = Evaluator::<Many<f64, OCTANTS>>::new(field.tape().clone());
    let mut known: Option<Aabb> = None;
    let mut parts = parts_of(&field.tape().operands(), &[*region]);
    // There are few cells at the rim.
    let most = CELLS * parts.len().max(8);
    let whole = field.tape().is_defined(&region.intervals());
    loop {
        parts = all_possible(field, &parts, whole, halt);
        for p in batches(&parts).flat_map(|batch| solid(&mut values, batch, region)) {
            let point = Aabb { min: p, max: p };
            known = Some(known.map_or(point, |known| known.hull(&point)));
        }
        parts.retain(|part| known.is_none_or(|known| !known.holds(&part.cell)));
        let all = parts.iter().map(|part| part.cell).chain(known).reduce(|a, b| a.hull(&b))?;
        let is_known = known.is_some_and(|known| {
            let excess = (known.min - all.min).max(all.max - known.max).max_element();
            excess <= CLOSE * all.diagonal() || (!open && touches(&known, region))
        });
        if halt() || is_known || is_small(&all, region) || is_last(parts.iter(), most) {
            return Some(all);
        }
        parts = cut_up(&parts);
    }
}

/// Those points of parts with one tape that are in the solid, or would be if all of it had a value there, of a point of each:
/// of one at the edge of the region one there, else its middle.
fn solid(values: &mut Evaluator<Many<f64, OCTANTS>>, batch: &[Part], region: &Aabb) -> Vec<DVec3> {
    let point = |part: &Part| {
        let Aabb { min, max } = part.cell;
        let inner = DVec3::select(max.cmpge(region.max), max, 0.5 * (min + max));
        DVec3::select(min.cmple(region.min), min, inner)
    };
    let points: Vec<DVec3> = batch.iter().map(point).collect();
    let at = |axis: usize| Many(std::array::from_fn(|lane| points[lane.min(points.len() - 1)][axis]));
    let found = eval(values, &batch[0], &std::array::from_fn(at)).0;
    points.into_iter().zip(found).filter(|(_, f)| *f <= 0.0).map(|(p, _)| p).collect()
}

/// Cuts up cells, for each [operand](Tape::operands) of a field, and leaves out those parts where it is certain that
/// `f > 0`, or that it has no value. Nothing more is left out when `halt` says so.
pub(super) fn exclude(field: &Field, operands: &[Arc<Tape>], cells: &[Aabb], halt: Halt<'_>) -> Vec<Part> {
    let mut parts = parts_of(operands, cells);
    let hull = |parts: &[Part]| parts.iter().map(|part| part.cell).reduce(|a, b| a.hull(&b));
    let Some(region) = hull(&parts) else { return parts };
    let most = CELLS.max(CELLS / OCTANTS * parts.len());
    let whole = field.tape().is_defined(&region.intervals());
    loop {
        parts = all_possible(field, &parts, whole, halt);
        let is_done = hull(&parts).is_none_or(|rest| is_small(&rest, &region));
        if halt() || is_done || is_last(parts.iter(), most) {
            return parts;
        }
        parts = cut_up(&parts);
    }
}

/// Cells, for each operand.
fn parts_of(operands: &[Arc<Tape>], cells: &[Aabb]) -> Vec<Part> {
    let of = |tape: &Arc<Tape>| {
        cells.iter().map(|cell| Part { cell: *cell, tape: tape.clone() }).collect::<Vec<_>>()
    };
    operands.iter().flat_map(of).collect()
}

/// Whether it is not worth while to look closer at what is left of a region.
fn is_small(rest: &Aabb, region: &Aabb) -> bool {
    rest.diagonal() < 1e-9 * region.diagonal()
}

/// The octants of parts.
fn cut_up(parts: &[Part]) -> Vec<Part> {
    if parts.len() < FEW {
        parts.iter().flat_map(Part::octants).collect()
    } else {
        parts.par_iter().flat_map_iter(Part::octants).collect()
    }
}

/// Those of parts where `f <= 0` may be, of a field that has a value everywhere if it is `whole`.
fn all_possible(field: &Field, parts: &[Part], whole: bool, halt: Halt<'_>) -> Vec<Part> {
    let ranges = || Evaluator::<Many<Interval, OCTANTS>>::new(field.tape().clone());
    let asked: Vec<&[Part]> = batches(parts).collect();
    let mut left: Vec<Part> = if asked.len() < FEW {
        let mut own = ranges();
        asked.into_iter().flat_map(|batch| possible(&mut own, batch, halt)).collect()
    } else {
        let ask = |own: &mut Evaluator<_>, batch: &&[Part]| possible(own, batch, halt);
        asked.par_iter().with_min_len(FEW / 4).map_init(ranges, ask).flatten_iter().collect()
    };
    if !whole {
        left.retain(|part| halt() || !part.tape.is_nowhere(&part.cell.intervals()));
    }
    left
}

/// Those of some parts with one tape where `f <= 0` may be.
fn possible(ranges: &mut Evaluator<Many<Interval, OCTANTS>>, batch: &[Part], halt: Halt<'_>) -> Vec<Part> {
    if halt() {
        return batch.to_vec();
    }
    let cell = |lane: usize| batch[lane.min(batch.len() - 1)].cell.intervals();
    let at = std::array::from_fn(|axis| Many(std::array::from_fn(|lane| cell(lane)[axis])));
    let found = eval(ranges, &batch[0], &at).0;
    // One that has no value is asked for that alone.
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
        let last = is_last(parts.iter(), CELLS);
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
