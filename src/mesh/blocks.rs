//! Where the surface may be.
//!
//! The lattice is cut into eighths until a part is a block of cells. A part over which the enclosure of the
//! field excludes zero has no surface in it, nor has one in which the field is known to have no value: that is a proof, so
//! that nothing is missed in what is dropped.
//! Blocks come in the order of their Morton codes, whatever the threads did.

use super::lattice::{Lattice, Place, SIDE};
use crate::field::{Stopped, Watch};
use crate::num::Interval;
use crate::tape::{Bounded, Evaluator, Tape, Wanted};
use rayon::prelude::*;
use std::sync::Arc;

/// A cube of [`SIDE`] cells along each edge, with what is left of the tape there.
pub(super) struct Block {
    /// Its first cell.
    pub at: Place,
    pub tape: Arc<Tape>,
}

/// A part of the lattice: a cube of so many cells along an edge.
struct Part {
    at: Place,
    cells: u32,
    tape: Arc<Tape>,
}

/// The blocks that the surface may pass.
///
/// # Errors
/// When stopped.
pub(super) fn blocks(tape: &Arc<Tape>, lattice: &Lattice, watch: &Watch<'_>) -> Result<Vec<Block>, Stopped> {
    let widest = lattice.blocks.into_iter().max().unwrap_or(1).next_power_of_two();
    let mut parts = vec![Part { at: [0; 3], cells: widest * SIDE, tape: tape.clone() }];
    loop {
        watch.check()?;
        let ranges = || Evaluator::<Interval>::new(tape.clone());
        let kept = parts.into_par_iter().map_init(ranges, |ranges, part| part.narrowed(lattice, ranges));
        parts = kept.flatten().collect();
        if parts.first().is_none_or(|part| part.cells == SIDE) {
            return Ok(parts.into_iter().map(|part| Block { at: part.at, tape: part.tape }).collect());
        }
        parts = parts.iter().flat_map(|part| part.eighths(lattice)).collect();
    }
}

impl Part {
    /// The part with its tape pruned, unless there is no surface in it.
    fn narrowed(mut self, lattice: &Lattice, ranges: &mut Evaluator<Interval>) -> Option<Part> {
        let region = lattice.region_and_aside(self.at, self.cells);
        let bounded = self.tape.has_choices().then(|| self.tape.bound(&region));
        let range = match &bounded {
            Some(bounded) => bounded.range(),
            None => *ranges.turn_to(&self.tape).eval(&region),
        };
        let is_nowhere =
            || bounded.as_ref().map_or_else(|| self.tape.is_nowhere(&region), Bounded::is_nowhere);
        if range.lo > 0.0 || is_nowhere() {
            return None;
        }
        // One that is as much work may be shared, which costs less.
        let shorter = bounded.map(|bounded| bounded.pruned(Wanted::Values));
        if let Some(shorter) = shorter.filter(|shorter| shorter.work() < self.tape.work()) {
            self.tape = Arc::new(shorter);
        }
        // What is undefined is empty, so that a part is full only if the field has a value everywhere.
        let is_full = range.hi < 0.0 && self.tape.is_defined(&region);
        (!is_full).then_some(self)
    }

    fn eighths(&self, lattice: &Lattice) -> impl Iterator<Item = Part> + use<'_> {
        let cells = self.cells / 2;
        let ends = lattice.blocks.map(|b| b * SIDE);
        (0..8_u32).filter_map(move |i| {
            let at = std::array::from_fn(|axis| self.at[axis] + (i >> axis & 1) * cells);
            let is_within = (0..3).all(|axis| at[axis] < ends[axis]);
            is_within.then(|| Part { at, cells, tape: self.tape.clone() })
        })
    }
}
