//! Whether a solid is a star: whether all of it is in sight of one point of it.
//!
//! Planets and pebbles are: detail that is a matter of direction alone leaves no overhangs, however rough it is. Then the
//! solid is one component, and a ball, without handles and voids; nothing has to be known of what the detail does from
//! place to place, and no crease or critical point of it matters.
//!
//! # Proof
//!
//! A box is cut into closed cells, of each of which one thing is proven: that it is *out* (nothing in it is solid), *in*
//! (all of it is), or that the field *rises* along every ray from the centre `c` that passes through it. Let `p` be
//! solid, and suppose that not all of the way from `p` to `c` is. Let `q` be the first point of the way that is not.
//! There `f = 0`, as `f` is continuous, and before it `f < 0`. Of the finitely many cells one holds `q` and a piece of the way
//! before it. It is neither out, since the piece is solid, nor in, since `q` is not. If `f` rises in it, away from the
//! centre, then `f` is greater on the piece than at `q`, where it is 0. So there is no `q`, unless it is `c` itself.
//! The cell that has `c` cannot be one where `f` rises: the derivative along a way that has no length is 0. So it is out,
//! and there is nothing solid at all, or in, and all of the way is solid. (Of a field with creases the enclosure of the
//! derivative holds the slopes of both sides and all between.)
//!
//! What is a [matter of direction alone](Tape::directions) does not change along rays from the origin, however steep it is
//! across them; this is made use of where the centre is there.
//!
//! A box is convex, so that what of the solid is within it is a star as well.
//!
//! Two points tell that it is none: one that is solid, and one before it that is not.

use super::cell::places;
use super::search::LANES;
use crate::field::{Stopped, Watch};
use crate::num::{Interval, Many, Slope};
use crate::scene::Aabb;
use crate::tape::{Cells, Evaluator, Tape};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Nearer to the origin it is not relied on that directions do not change along rays.
const NEAR: f64 = 1e-100;

/// By how much of itself, at most, a direction changes as a point farther from the origin than that is moved away from it by
/// all of its distance.
const DRIFT: f64 = 1e-180;

/// Cells that one thread takes at a time.
const SHARE: usize = 256;

/// Times that a box is cut, at most.
const DEEPEST: u32 = 20;

/// Whether what of a solid is in a box is proven to be all in sight of a point there; its field is the first output
/// of the tape. No more than so many cells are looked at.
///
/// # Errors
/// When stopped.
pub(super) fn is_star(
    cells: &Cells,
    region: &Aabb,
    centre: DVec3,
    most: usize,
    watch: &Watch<'_>,
) -> Result<bool, Stopped> {
    if !region.holds(&Aabb { min: centre, max: centre }) {
        return Ok(false);
    }
    let (mut open, mut seen) = (vec![*region], 0);
    for _ in 0..DEEPEST {
        seen += open.len();
        if seen > most {
            return Ok(false);
        }
        let look = |sight: &mut Sight, boxes: &[Aabb]| {
            let is_stopped = watch.cancel.load(Ordering::Relaxed);
            if is_stopped { None } else { sight.look(cells, boxes) }
        };
        let shares = open.par_chunks(SHARE).map_init(|| Sight::new(cells, centre), look);
        let found: Option<Vec<Vec<Aabb>>> = shares.collect();
        watch.check()?;
        let Some(found) = found else { return Ok(false) };
        open = found.iter().flatten().flat_map(parts).collect();
        if open.is_empty() {
            return Ok(true);
        }
    }
    Ok(false)
}

/// The eight parts of a box. They share their faces to the bit, so that nothing is left between them.
fn parts(whole: &Aabb) -> [Aabb; 8] {
    let middle = 0.5 * (whole.min + whole.max);
    std::array::from_fn(|i| {
        let mut part = *whole;
        for axis in 0..3 {
            let end = if i >> axis & 1 == 0 { &mut part.max } else { &mut part.min };
            end[axis] = middle[axis];
        }
        part
    })
}

/// Evaluators of one thread that look along rays from a point.
struct Sight {
    slopes: Evaluator<Many<Slope, LANES>>,
    values: Evaluator<f64>,
    centre: DVec3,
}

impl Sight {
    fn new(cells: &Cells, centre: DVec3) -> Sight {
        let tape = cells.tape();
        Sight { slopes: Evaluator::new(tape.clone()), values: Evaluator::new(tape.clone()), centre }
    }

    /// Those of some boxes of which nothing is proven; none at all where points tell that the solid is no star.
    fn look(&mut self, cells: &Cells, boxes: &[Aabb]) -> Option<Vec<Aabb>> {
        let mut open = Vec::new();
        let order = cells.tapes_around(places(boxes));
        for same in order.chunk_by(|a, b| Arc::ptr_eq(a.0, b.0)) {
            let tape = same[0].0;
            let directions = if self.centre == DVec3::ZERO { tape.directions() } else { Vec::new() };
            for batch in same.chunks(LANES) {
                let regions: [[Interval; 3]; LANES] =
                    std::array::from_fn(|lane| boxes[batch[lane.min(batch.len() - 1)].1].intervals());
                let slopes = self.rises(tape, &directions, &regions);
                for ((slope, region), &(_, i)) in slopes.iter().zip(&regions).zip(batch) {
                    if is_known(slope, || cells.is_defined_in(region) || tape.is_defined(region)) {
                        continue;
                    }
                    if self.is_hidden(tape, &boxes[i]) {
                        return None;
                    }
                    open.push(boxes[i]);
                }
            }
        }
        Some(open)
    }

    /// Values over boxes, and first of their gradients the derivatives along the ways from the centre.
    fn rises(
        &mut self,
        tape: &Arc<Tape>,
        directions: &[usize],
        regions: &[[Interval; 3]; LANES],
    ) -> [Slope; LANES] {
        let zero = Interval::point(0.0);
        let away = |x: Interval, axis: usize| {
            let off = x - Interval::point(self.centre[axis]);
            Slope { value: x, grad: [off, zero, zero], norm: off.mag() }
        };
        let p = std::array::from_fn(|axis| {
            Many(std::array::from_fn(|lane: usize| away(regions[lane][axis], axis)))
        });
        let slopes = self.slopes.turn_to(tape);
        if directions.is_empty() || !regions.iter().all(|region| distance(region) > NEAR) {
            return slopes.eval(&p).0;
        }
        let mut next = 0;
        let still = |i: usize, slope: &mut Many<Slope, LANES>| {
            if directions.get(next) == Some(&i) {
                next += 1;
                slope.0.iter_mut().for_each(hold);
            }
        };
        slopes.eval_changed(&p, still).0
    }

    /// Whether something solid in a box is seen to lie behind something that is not, on the ray through its middle.
    fn is_hidden(&mut self, tape: &Arc<Tape>, cell: &Aabb) -> bool {
        let middle = 0.5 * (cell.min + cell.max);
        // Not beyond the centre.
        let reach = (0.5 * (cell.max - cell.min).min_element()).min(0.9 * middle.distance(self.centre));
        let way = (middle - self.centre).normalize_or_zero() * reach;
        let values = self.values.turn_to(tape);
        let mut at = |p: DVec3| *values.eval(&p.to_array());
        at(middle - way) > 0.0 && at(middle + way) < 0.0
    }
}

/// Whether it is proven of a cell that it is out, in, or that the field rises there. Where the field has no value there is
/// nothing.
fn is_known(slope: &Slope, is_defined: impl FnOnce() -> bool) -> bool {
    let Slope { value, grad: [rise, ..], .. } = slope;
    value.lo > 0.0 || (value.hi < 0.0 || rise.lo > 0.0) && is_defined()
}

/// Knows of a direction that it does not change along rays.
fn hold(direction: &mut Slope) {
    let drift = Interval::radius(DRIFT * direction.value.mag());
    direction.grad[0] = direction.grad[0].meet(drift);
    direction.norm = direction.norm.min(drift.hi);
}

/// How far off the origin a box is along some axis.
fn distance(region: &[Interval; 3]) -> f64 {
    region.iter().map(|x| x.lo.max(-x.hi)).fold(0.0, f64::max)
}

/// Points that solids may be in sight of: where scripts put them, and the middle of what they are in.
pub(super) fn centres(region: &Aabb) -> impl Iterator<Item = DVec3> {
    let middle = 0.5 * (region.min + region.max);
    [Some(DVec3::ZERO), Some(middle).filter(|middle| *middle != DVec3::ZERO)].into_iter().flatten()
}
