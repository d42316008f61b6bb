//! What a minimum is of.
//!
//! A solid of many parts is the minimum of their fields, and is where one of them is: what encloses each encloses all.
//! Asked one by one, parts take little: of a thousand, each is a thousandth of the tape.
//!
//! A maximum, a sum, a difference and a product with a positive number grow with each of their arguments (a difference
//! with its first), so the minimum may be taken after them as well: `max(min(a, b), c) = min(max(a, c), max(b, c))`. What
//! is read elsewhere besides is not split.

use super::prune::Fate;
use super::{Instr, Tape};
use crate::op::Op;
use std::collections::VecDeque;
use std::sync::Arc;

/// How much more [work](Tape::work) all operands may be than what they are of: what they have in common, each has.
const MOST: u64 = 2;

impl Tape {
    /// Tapes of which the first output is the least, wherever all have values: this one if it has no others. What has too
    /// much in common stays together.
    pub fn operands(self: &Arc<Tape>) -> Vec<Arc<Tape>> {
        let (mut found, mut rest) = (Vec::new(), VecDeque::from([self.clone()]));
        let mut work = self.work();
        while let Some(tape) = rest.pop_front() {
            let halves = tape.halves().map(|halves| halves.map(Arc::new));
            let parted = halves
                .as_ref()
                .map(|[a, b]| (work - tape.work()).saturating_add(a.work()).saturating_add(b.work()));
            match (halves, parted) {
                (Some(halves), Some(parted)) if parted <= self.work().saturating_mul(MOST) => {
                    work = parted;
                    rest.extend(halves);
                }
                _ => found.push(tape),
            }
        }
        found
    }

    /// Two tapes with half of the operands each.
    fn halves(&self) -> Option<[Tape; 2]> {
        let &[output] = self.outputs.as_slice() else { return None };
        let counts = self.counts();
        let mut rest = counts[output as usize] / 2;
        if rest == 0 {
            return None;
        }
        let mut halves: [Vec<(u32, u32)>; 2] = Default::default();
        let mut at = output;
        while rest > 0 {
            let Instr::Op(Op::Min(_), [a, b, ..]) = &self.code[at as usize] else {
                at = self.grows_with(at, &counts)?;
                continue;
            };
            // Each half keeps the side that all of its operands are on; the one that has both goes on as it is.
            let first = counts[*a as usize];
            if rest <= first {
                halves[0].push((at, *a));
            }
            if rest >= first {
                halves[1].push((at, *b));
            }
            (at, rest) = match rest {
                rest if rest < first => (*a, rest),
                rest => (*b, rest - first),
            };
        }
        Some(halves.map(|sides| self.keeping(&sides)))
    }

    /// Of how many operands each instruction is the minimum.
    fn counts(&self) -> Vec<u32> {
        let mut reads = vec![0_u32; self.code.len()];
        for instr in &self.code {
            instr.each_arg(|a| reads[a as usize] += 1);
        }
        let mut counts = Vec::with_capacity(self.code.len());
        for (slot, instr) in self.code.iter().enumerate() {
            let count = match instr {
                _ if reads[slot] > 1 => 1,
                Instr::Op(Op::Min(_), [a, b, ..]) => counts[*a as usize] + counts[*b as usize],
                _ => self.grows_with(slot as u32, &counts).map_or(1, |a| counts[a as usize]),
            };
            counts.push(count);
        }
        counts
    }

    /// The argument with the most operands, of those that an instruction grows with.
    fn grows_with(&self, slot: u32, counts: &[u32]) -> Option<u32> {
        match &self.code[slot as usize] {
            Instr::Shift(a, _) | Instr::Op(Op::Sub(_), [a, ..]) => Some(*a),
            Instr::Scale(a, k) if *k > 0.0 => Some(*a),
            Instr::Op(Op::Max(_) | Op::Add(_), [a, b, ..]) => {
                Some(if counts[*b as usize] > counts[*a as usize] { *b } else { *a })
            }
            _ => None,
        }
    }

    /// The tape with some of its minima, from the last to the first, replaced by one of their arguments.
    fn keeping(&self, sides: &[(u32, u32)]) -> Tape {
        self.decided(|slot| {
            let found = sides.binary_search_by(|(minimum, _)| slot.cmp(&(*minimum as usize)));
            found.map_or(Fate::Stays, |i| Fate::Is(sides[i].1))
        })
    }
}
