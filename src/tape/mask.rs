//! Masks: what is asked first whether a tape of products has anything to say in a region.
//!
//! Velocities that act somewhere only are multiplied by something that ends: `noise * plus(1 - r^2, 3)`. Where that is zero
//! the whole is, and it takes much less work to tell than the noise does.

use super::prune::{ends, selects, settles};
use super::{Instr, Tape};
use crate::expr::{Identity, identity};
use crate::op::Op;

/// Operations that are tried.
const MOST: usize = 64;

impl Tape {
    /// A tape of less work: where all of its outputs are zero, so are those of this one that have values. None where
    /// nothing is known to be like that.
    pub(super) fn mask(&self) -> Option<Tape> {
        let mut masks = self.with_ends();
        if self.is_silent(&[]) || !self.is_silent(&masks) {
            return None;
        }
        // Those are left that it takes, of little work if there is a choice.
        masks.sort_by_cached_key(|slot| (self.part(vec![*slot]).work(), *slot));
        for i in (0..masks.len()).rev() {
            let slot = masks.remove(i);
            if !self.is_silent(&masks) {
                masks.insert(i, slot);
            }
        }
        let mask = self.part(masks);
        (mask.work() < self.work()).then_some(mask)
    }

    /// Operations that end somewhere, and what is made of nothing else, as in `1 - smoothstep(0, 1, r)`.
    fn with_ends(&self) -> Vec<u32> {
        let mut found = Vec::new();
        for (slot, instr) in self.code.iter().enumerate() {
            if found.len() == MOST {
                break;
            }
            let is_found = match instr {
                Instr::Op(op, args) => {
                    let args = &args[..op.arity()];
                    let is_const = |a: &u32| matches!(self.code[*a as usize], Instr::Const(_));
                    let over = args.iter().any(|a| found.contains(a))
                        && args.iter().all(|a| found.contains(a) || is_const(a));
                    over || ends(op) || settles(op) || selects(op)
                }
                Instr::Scale(a, _) | Instr::Shift(a, _) => found.contains(a),
                _ => false,
            };
            found.extend(is_found.then_some(slot as u32));
        }
        found
    }

    /// Whether all outputs that have values are zero if these slots are.
    fn is_silent(&self, slots: &[u32]) -> bool {
        let mut is_zero = vec![false; self.code.len()];
        for (slot, instr) in self.code.iter().enumerate() {
            let number = |a: u32| is_zero[a as usize].then_some(0.0);
            is_zero[slot] = slots.contains(&(slot as u32))
                || match instr {
                    Instr::Const(c) => *c == 0.0,
                    Instr::Scale(a, _) => is_zero[*a as usize],
                    Instr::Op(Op::Div(_), args) => is_zero[args[0] as usize],
                    Instr::Op(op, args) => match identity(*op, |k| number(args[k])) {
                        Some(Identity::Number(c)) => c == 0.0,
                        Some(Identity::Argument(k)) => is_zero[args[k] as usize],
                        None => false,
                    },
                    _ => false,
                };
        }
        self.outputs.iter().all(|o| is_zero[*o as usize])
    }

    /// What computes some of the slots.
    fn part(&self, outputs: Vec<u32>) -> Tape {
        Tape::of(self.code.clone(), outputs, self.origins.clone()).without_dead_code()
    }
}
