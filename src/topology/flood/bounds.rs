//! What enclosures say of cells.
//!
//! Value and gradient are enclosed together. Where the value is not decided, the mean value form tries again:
//! it knows what cancels between the slopes of a sum. Where the gradient has no sign along any axis, as along
//! a crease, whose enclosure holds the slopes of both sides and all between, some other direction may do:
//! the shortest vector in the hull of the gradients at the corners rises with all of them, if anything does,
//! and an enclosure of the derivative along it proves that.

use super::tree::{Known, State};
use crate::num::{Dual, Interval, Many, Slope, shortest};
use crate::scene::Aabb;
use crate::tape::{Cells, Evaluator, Tape};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Cells bounded together.
const LANES: usize = 16;

/// Cells that one thread takes at a time.
const SHARE: usize = 512;

/// What is known of boxes, in their order; nothing of those that are left when it is cancelled.
pub(super) fn bound(cells: &Cells, boxes: &[Aabb], cancel: &AtomicBool) -> Vec<Known> {
    let share = |bounds: &mut Bounds, boxes: &[Aabb]| bounds.all(cells, boxes, cancel);
    boxes.par_chunks(SHARE).map_init(|| Bounds::new(cells), share).collect::<Vec<_>>().concat()
}

/// Evaluators of one thread.
struct Bounds {
    slopes: Evaluator<Many<Slope, LANES>>,
    middles: Evaluator<Many<Interval, LANES>>,
    corners: Evaluator<Many<Dual, LANES>>,
    along: Evaluator<Slope>,
}

impl Bounds {
    fn new(cells: &Cells) -> Bounds {
        let tape = || cells.tape().clone();
        Bounds {
            slopes: Evaluator::new(tape()),
            middles: Evaluator::new(tape()),
            corners: Evaluator::new(tape()),
            along: Evaluator::new(tape()),
        }
    }

    fn all(&mut self, cells: &Cells, boxes: &[Aabb], cancel: &AtomicBool) -> Vec<Known> {
        let mut known = vec![Known::NOTHING; boxes.len()];
        let places = boxes.iter().enumerate().map(|(i, cell)| {
            let x = cell.intervals();
            (i, x.map(Interval::mid), x.map(Interval::rad).into_iter().fold(0.0, f64::max))
        });
        let order = cells.tapes_around(places);
        for batch in order.chunk_by(|a, b| Arc::ptr_eq(a.0, b.0)).flat_map(|same| same.chunks(LANES)) {
            if cancel.load(Ordering::Relaxed) {
                break;
            }
            let regions: [[Interval; 3]; LANES] =
                std::array::from_fn(|lane| boxes[batch[lane.min(batch.len() - 1)].1].intervals());
            let tape = batch[0].0;
            let defined = regions.map(|region| cells.is_defined() || tape.is_defined(&region));
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
        let falls = slope.grad.map(|g| if g.lo > 0.0 { -1 } else { i8::from(g.hi < 0.0) });
        let slant = if falls == [0; 3] { self.slant(tape, region) } else { [0; 3] };
        Known { falls, slant, ..Known::NOTHING }
    }

    /// The signs of a direction in which the field is proven to fall everywhere in a box.
    fn slant(&mut self, tape: &Arc<Tape>, region: &[Interval; 3]) -> [i8; 3] {
        // The corners, and others a little beyond them: a crease may touch the box in a face that all corners
        // are on one side of.
        let corner = |lane: usize, axis: usize| {
            let (middle, half) = (region[axis].mid(), 0.5 * region[axis].width());
            let reach = if lane < CORNERS { half } else { 1.25 * half };
            if lane >> axis & 1 == 0 { middle - reach } else { middle + reach }
        };
        let p = std::array::from_fn(|axis| {
            Many(std::array::from_fn(|lane| Dual::coordinate(corner(lane, axis), axis)))
        });
        let duals = self.corners.turn_to(tape).eval(&p).0;
        let gradients = duals.map(|dual| DVec3::from_array(dual.grad));
        for gradients in [&gradients[..], &gradients[..CORNERS]] {
            if let Some(rise) = common_rise(gradients)
                && self.rises_along(tape, region, rise)
            {
                return rise.to_array().map(|d| i8::from(d < 0.0) - i8::from(d > 0.0));
            }
        }
        [0; 3]
    }

    /// Whether the field is proven to rise along a direction everywhere in a box.
    fn rises_along(&mut self, tape: &Arc<Tape>, region: &[Interval; 3], rise: DVec3) -> bool {
        // Coordinates of which the first runs along that direction.
        let zero = Interval::point(0.0);
        let p = std::array::from_fn(|axis| Slope {
            value: region[axis],
            grad: [Interval::point(rise[axis]), zero, zero],
            norm: f64::INFINITY,
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
    // The part along an axis that is next to nothing would only add a face to leave the cell by.
    let most = shortest.abs().max_element();
    let direction = DVec3::select(shortest.abs().cmpgt(DVec3::splat(0.05 * most)), shortest, DVec3::ZERO);
    (rises && most > 0.0 && direction.is_finite()).then(|| direction.normalize_or_zero())
}
