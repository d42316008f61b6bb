//! Pruning: over a region, a minimum whose one side is always smaller is that side.

use super::{Evaluator, Instr, Tape};
use crate::num::Interval;
use crate::op::Op;
use std::sync::Arc;

impl Tape {
    /// The tape with everything dropped that cannot matter within `region`. Equals the full tape
    /// there, bit for bit.
    pub fn prune(self: &Arc<Tape>, region: &[Interval; 3]) -> Tape {
        let mut evaluator = Evaluator::<Interval>::keeping_all(self.clone());
        evaluator.eval(region);
        let range = |slot: u32| *evaluator.value(slot);
        // Slot that stands for each slot; arguments are resolved before their users.
        let mut alias: Vec<u32> = (0..self.code.len() as u32).collect();
        let mut code = self.code.clone();
        let mut defined = vec![true; code.len()];
        for i in 0..code.len() {
            let mut whole = range(i as u32).is_finite();
            code[i].each_arg(|a| whole &= defined[a as usize]);
            if let Instr::Op(op, args) = &code[i] {
                whole &= op.is_defined(|k| range(args[k]));
            }
            defined[i] = whole;
            code[i].map_args(|a| alias[a as usize]);
            // Where a side may have no value, a minimum is not decided by the values that it has.
            if whole && let Some(side) = decided(&code[i], &range) {
                alias[i] = side;
            }
        }
        let outputs = self.outputs.iter().map(|&o| alias[o as usize]).collect();
        Tape { code, outputs }.without_dead_code()
    }
}

/// The argument that an instruction always equals.
fn decided(instr: &Instr, range: &dyn Fn(u32) -> Interval) -> Option<u32> {
    let Instr::Op(op, [a, b, c, ..]) = instr else { return None };
    let below = |x: u32, y: u32| range(x).hi < range(y).lo;
    match op {
        Op::Min(_) if below(*a, *b) => Some(*a),
        Op::Min(_) if below(*b, *a) => Some(*b),
        Op::Max(_) if below(*b, *a) => Some(*a),
        Op::Max(_) if below(*a, *b) => Some(*b),
        Op::Clamp(_) if below(*b, *a) && below(*a, *c) => Some(*a),
        _ => None,
    }
}
