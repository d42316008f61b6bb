//! Pruning: over a region, a minimum whose one side is always smaller is that side.

use super::{Evaluator, Instr, Tape};
use crate::num::{Interval, Number, Parabolas};
use crate::op::Op;
use std::sync::Arc;

/// What is known of the values of a tape's instructions over a region.
trait Known {
    /// Encloses a value.
    fn range(&self, slot: u32) -> Interval;

    /// Whether one value is everywhere less than another.
    fn is_below(&self, a: u32, b: u32) -> bool {
        self.range(a).hi < self.range(b).lo
    }
}

impl Known for Evaluator<Interval> {
    fn range(&self, slot: u32) -> Interval {
        *self.value(slot)
    }
}

/// Values that are this close, relative to their size, may change places when they are rounded.
const MARGIN: f64 = 1e-10;

/// A lane of a batch.
struct Lane<'a, const B: usize, const K: usize> {
    values: &'a Evaluator<Parabolas<B, K>>,
    lane: usize,
}

impl<const B: usize, const K: usize> Known for Lane<'_, B, K> {
    fn range(&self, slot: u32) -> Interval {
        self.values.value(slot).lane(self.lane).range
    }

    /// Differences may be known better than the values. They enclose what is exact, and must be wider
    /// than what is rounded when values are computed.
    fn is_below(&self, a: u32, b: u32) -> bool {
        let lane = |slot: u32| Parabolas::<1, K>::all(self.values.value(slot).lane(self.lane));
        let (x, y) = (self.range(a), self.range(b));
        x.hi < y.lo || lane(a).sub(&lane(b)).lane(0).range.hi < -MARGIN * (x.mag() + y.mag())
    }
}

impl Tape {
    /// The tape with everything dropped that cannot matter within `region`. Equals the full tape
    /// there, bit for bit.
    pub fn prune(self: &Arc<Tape>, region: &[Interval; 3]) -> Tape {
        let mut evaluator = Evaluator::<Interval>::keeping_all(self.clone());
        evaluator.eval(region);
        self.without_losers(&evaluator)
    }

    /// The same for each of several regions, given by their coordinates along shared directions. Equals
    /// the full tape in exact arithmetic, and bit for bit but for values that are as close as rounding.
    pub fn prune_each<const B: usize, const K: usize>(
        self: &Arc<Tape>,
        regions: &[Parabolas<B, K>; 3],
    ) -> [Tape; B] {
        let mut values = Evaluator::keeping_all(self.clone());
        values.eval(regions);
        std::array::from_fn(|lane| self.without_losers(&Lane { values: &values, lane }))
    }

    /// Whether there is anything that pruning might decide.
    pub fn has_choices(&self) -> bool {
        self.code.iter().any(|i| matches!(i, Instr::Op(Op::Min(_) | Op::Max(_) | Op::Clamp(_), _)))
    }

    fn without_losers(&self, known: &impl Known) -> Tape {
        // Slot that stands for each slot; arguments are resolved before their users.
        let mut alias: Vec<u32> = (0..self.code.len() as u32).collect();
        let mut code = self.code.clone();
        let mut defined = vec![true; code.len()];
        for i in 0..code.len() {
            let mut whole = known.range(i as u32).is_finite();
            code[i].each_arg(|a| whole &= defined[a as usize]);
            if let Instr::Op(op, args) = &code[i] {
                whole &= op.is_defined(|k| known.range(args[k]));
            }
            defined[i] = whole;
            code[i].map_args(|a| alias[a as usize]);
            // Where a side may have no value, a minimum is not decided by the values that it has.
            if whole && let Some(side) = decided(&code[i], known) {
                alias[i] = side;
            }
        }
        let outputs = self.outputs.iter().map(|&o| alias[o as usize]).collect();
        Tape::of(code, outputs).without_dead_code()
    }
}

/// The argument that an instruction always equals.
fn decided(instr: &Instr, known: &impl Known) -> Option<u32> {
    let Instr::Op(op, [a, b, c, ..]) = instr else { return None };
    let below = |x: u32, y: u32| known.is_below(x, y);
    match op {
        Op::Min(_) if below(*a, *b) => Some(*a),
        Op::Min(_) if below(*b, *a) => Some(*b),
        Op::Max(_) if below(*b, *a) => Some(*a),
        Op::Max(_) if below(*a, *b) => Some(*b),
        Op::Clamp(_) if below(*b, *a) && below(*a, *c) => Some(*a),
        Op::Clamp(_) if below(*a, *b) && below(*b, *c) => Some(*b),
        Op::Clamp(_) if below(*c, *a) && below(*b, *c) => Some(*c),
        _ => None,
    }
}

impl Tape {
    /// Whether every instruction is known to have a value everywhere in a region.
    pub fn is_defined(self: &Arc<Tape>, region: &[Interval; 3]) -> bool {
        let mut evaluator = Evaluator::<Interval>::keeping_all(self.clone());
        evaluator.eval(region);
        self.code.iter().enumerate().all(|(i, instr)| {
            let is_within = match instr {
                Instr::Op(op, args) => op.is_defined(|k| *evaluator.value(args[k])),
                _ => true,
            };
            is_within && evaluator.value(i as u32).is_finite()
        })
    }
}
