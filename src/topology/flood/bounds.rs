//! What enclosures say of cells.
//!
//! Value and gradient are enclosed together. Where the value is not decided, the mean value form tries again:
//! it knows what cancels between the slopes of a sum. Where the gradient has no sign along any axis, as along
//! a crease, whose enclosure holds the slopes of both sides and all between, some other direction may do:
//! the shortest vector in the hull of the gradients at the corners rises with all of them, if anything does,
//! and an enclosure of the derivative along it proves that. A closer look asks the same of two axes at a time: at the rim
//! of a cone all ways go up the side, and on the side the way down its axis goes back to the rim, but there is another
//! across it.

use super::super::cell::places;
use super::tree::{Known, State};
use super::ways::Ways;
use crate::num::{Dual, Interval, Many, Slope, shortest};
use crate::scene::Aabb;
use crate::tape::{Cells, Evaluator, Tape};
use glam::{BVec3, DVec3};
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Cells bounded together.
const LANES: usize = 16;

/// Cells that one thread takes at a time.
const SHARE: usize = 512;

/// What is known of boxes, in their order; nothing of those that are left when it is cancelled.
/// A close look finds a way down along any set of axes that has one; another those along single axes, or else any one.
pub(super) fn bound(cells: &Cells, boxes: &[Aabb], is_close: bool, cancel: &AtomicBool) -> Vec<Known> {
    let share = |bounds: &mut Bounds, boxes: &[Aabb]| bounds.all(cells, boxes, cancel);
    boxes.par_chunks(SHARE).map_init(|| Bounds::new(cells, is_close), share).collect::<Vec<_>>().concat()
}

/// Evaluators of one thread.
struct Bounds {
    slopes: Evaluator<Many<Slope, LANES>>,
    middles: Evaluator<Many<Interval, LANES>>,
    corners: Evaluator<Many<Dual, { 2 * CORNERS }>>,
    along: Evaluator<Slope>,
    is_close: bool,
}

impl Bounds {
    fn new(cells: &Cells, is_close: bool) -> Bounds {
        let tape = || cells.tape().clone();
        Bounds {
            slopes: Evaluator::new(tape()),
            middles: Evaluator::new(tape()),
            corners: Evaluator::new(tape()),
            along: Evaluator::new(tape()),
            is_close,
        }
    }

    fn all(&mut self, cells: &Cells, boxes: &[Aabb], cancel: &AtomicBool) -> Vec<Known> {
        let mut known = vec![Known::NOTHING; boxes.len()];
        let order = cells.tapes_around(places(boxes));
        for batch in order.chunk_by(|a, b| Arc::ptr_eq(a.0, b.0)).flat_map(|same| same.chunks(LANES)) {
            if cancel.load(Ordering::Relaxed) {
                break;
            }
            let regions: [[Interval; 3]; LANES] =
                std::array::from_fn(|lane| boxes[batch[lane.min(batch.len() - 1)].1].intervals());
            let tape = batch[0].0;
            let defined = regions.map(|region| cells.is_defined_in(&region) || tape.is_defined(&region));
            let slopes = self.slopes(tape, &regions, &defined);
            for (lane, &(_, i)) in batch.iter().enumerate() {
                known[i] = self.one(tape, &regions[lane], &slopes[lane], defined[lane]);
            }
        }
        known
    }

    /// Values and gradients over boxes.
    fn slopes(
        &mut self,
        tape: &Arc<Tape>,
        regions: &[[Interval; 3]; LANES],
        defined: &[bool; LANES],
    ) -> [Slope; LANES] {
        let p = std::array::from_fn(|axis| {
            Many(std::array::from_fn(|lane| Slope::coordinate(regions[lane][axis], axis)))
        });
        let mut slopes = self.slopes.turn_to(tape).eval(&p).0;
        if slopes.iter().all(|s| !s.value.contains(0.0)) {
            return slopes;
        }
        let middle =
            |axis: usize| Many(std::array::from_fn(|lane: usize| Interval::point(regions[lane][axis].mid())));
        let middles = self.middles.turn_to(tape).eval(&std::array::from_fn(middle)).0;
        let whole = slopes.iter_mut().zip(regions).zip(middles).zip(defined).filter(|(_, defined)| **defined);
        for (((slope, region), middle), _) in whole {
            // f(x) = f(c) + g . (x - c) for some g that the gradient's enclosure holds.
            let mean = (0..3).fold(middle, |sum, axis| {
                sum + slope.grad[axis] * (region[axis] - Interval::point(region[axis].mid()))
            });
            slope.value = slope.value.meet(mean);
        }
        slopes
    }

    fn one(&mut self, tape: &Arc<Tape>, region: &[Interval; 3], slope: &Slope, is_defined: bool) -> Known {
        let Interval { lo, hi } = slope.value;
        // Where the field has no value there is nothing.
        if lo > 0.0 {
            return Known { state: State::Out, ..Known::NOTHING };
        }
        if !is_defined {
            return Known::NOTHING;
        }
        if hi < 0.0 {
            return Known { state: State::In, ..Known::NOTHING };
        }
        Known { ways: self.ways(tape, region, slope), ..Known::NOTHING }
    }

    /// Directions in which the field is proven to fall everywhere in a box.
    fn ways(&mut self, tape: &Arc<Tape>, region: &[Interval; 3], slope: &Slope) -> Ways {
        let falls = slope.grad.map(|g| if g.lo > 0.0 { -1 } else { i8::from(g.hi < 0.0) });
        let mut ways = Ways::NONE;
        for axis in 0..3 {
            ways.add(std::array::from_fn(|k| if k == axis { falls[axis] } else { 0 }));
        }
        let pairs = [[true, true, false], [true, false, true], [false, true, true]];
        let sets = if self.is_close { &[pairs[0], pairs[1], pairs[2], [true; 3]][..] } else { &[[true; 3]] };
        let mut gradients = None;
        for axes in sets {
            if !ways.serve(*axes) {
                let gradients = &*gradients.get_or_insert_with(|| self.gradients(tape, region));
                ways.add(self.slant(tape, region, (gradients, slope), *axes));
            }
        }
        ways
    }

    /// Gradients at the corners, and at others a little beyond them: a crease may touch the box in a face that all
    /// corners are on one side of.
    fn gradients(&mut self, tape: &Arc<Tape>, region: &[Interval; 3]) -> [DVec3; 2 * CORNERS] {
        let corner = |lane: usize, axis: usize| {
            let (middle, half) = (region[axis].mid(), 0.5 * region[axis].width());
            let reach = if lane < CORNERS { half } else { 1.25 * half };
            if lane >> axis & 1 == 0 { middle - reach } else { middle + reach }
        };
        let p = std::array::from_fn(|axis| {
            Many(std::array::from_fn(|lane| Dual::coordinate(corner(lane, axis), axis)))
        });
        self.corners.turn_to(tape).eval(&p).0.map(|dual| DVec3::from_array(dual.grad))
    }

    /// The signs of a direction along some axes in which the field is proven to fall everywhere in a box with these
    /// gradients at its corners, and this enclosure; all 0 if none is found.
    fn slant(
        &mut self,
        tape: &Arc<Tape>,
        region: &[Interval; 3],
        (gradients, slope): (&[DVec3; 2 * CORNERS], &Slope),
        axes: [bool; 3],
    ) -> [i8; 3] {
        let part = |v: DVec3| DVec3::select(BVec3::from_array(axes), v, DVec3::ZERO);
        let along = gradients.map(part);
        // Where little is known of a noise but that it is not steep, the middle is what the rest does.
        let middle = part(DVec3::from_array(slope.grad.map(Interval::mid)));
        let mut rises = |rise: &DVec3| self.rises_along(tape, region, *rise);
        let rise = common_rise(&along)
            .filter(&mut rises)
            .or_else(|| common_rise(&along[..CORNERS]).filter(&mut rises))
            .or_else(|| direction(middle).filter(&mut rises));
        rise.map_or([0; 3], |rise| rise.to_array().map(|d| i8::from(d < 0.0) - i8::from(d > 0.0)))
    }

    /// Whether the field is proven to rise along a direction everywhere in a box.
    fn rises_along(&mut self, tape: &Arc<Tape>, region: &[Interval; 3], rise: DVec3) -> bool {
        // Coordinates of which the first runs along that direction.
        let zero = Interval::point(0.0);
        let p = std::array::from_fn(|axis| Slope {
            value: region[axis],
            grad: [Interval::point(rise[axis]), zero, zero],
            norm: rise[axis].abs(),
        });
        self.along.turn_to(tape).eval(&p).grad[0].lo > 0.0
    }
}

/// Corners of a box.
const CORNERS: usize = 8;

/// A direction that goes up by all of these gradients.
fn common_rise(gradients: &[DVec3]) -> Option<DVec3> {
    let shortest = shortest(gradients);
    let rises = gradients.iter().all(|gradient| gradient.dot(shortest) > 0.0);
    direction(shortest).filter(|_| rises)
}

/// The direction of a vector, without the parts along axes that are next to nothing: they would only add faces to leave
/// the cell by.
fn direction(v: DVec3) -> Option<DVec3> {
    let most = v.abs().max_element();
    let direction = DVec3::select(v.abs().cmpgt(DVec3::splat(0.05 * most)), v, DVec3::ZERO);
    (most > 0.0 && direction.is_finite()).then(|| direction.normalize_or_zero())
}
