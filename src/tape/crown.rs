//! What a tape puts together last.
//!
//! Most solids are made of others: the last instructions of a tape are minima, maxima and negatives. They are its *crown*,
//! and what they put together its *leaves*. Who asks for signs alone has them put together as sets of places
//! ([`Classifier`]), and needs no values of the crown. What is read elsewhere besides is a leaf.

use super::eval::{Registers, allocate};
use super::{Evaluator, Instr, Tape};
use crate::num::{Classifier, Joint, Mix, Parabolas, Part, Signs, parts_of};
use crate::op::Op;
use std::sync::Arc;

/// How a tape puts its leaves together, and where their values are kept.
#[derive(Clone, Debug)]
pub(super) struct Crown {
    parts: Vec<Part>,
    registers: Registers,
}

impl Tape {
    fn crown(&self) -> &Crown {
        self.crown.get_or_init(|| Box::new(Crown::of(self)))
    }
}

impl Crown {
    fn of(tape: &Tape) -> Crown {
        let code = &tape.code;
        let mut reads = vec![0_u32; code.len()];
        code.iter().for_each(|instr| instr.each_arg(|a| reads[a as usize] += 1));
        tape.outputs.iter().for_each(|&output| reads[output as usize] += 1);
        let is_joint = |slot: u32| {
            let joins = match &code[slot as usize] {
                Instr::Op(Op::Min(_) | Op::Max(_) | Op::Neg(_), _) => true,
                Instr::Scale(_, k) => k.abs() > 0.0,
                _ => false,
            };
            joins && reads[slot as usize] == 1
        };
        // How many leaves each instruction would have.
        let mut counts = vec![1_u32; code.len()];
        for slot in (0..code.len() as u32).filter(|&slot| is_joint(slot)) {
            let mut count = 0;
            code[slot as usize].each_arg(|a| count += counts[a as usize]);
            counts[slot as usize] = count;
        }
        let joint = |slot: u32| match &code[slot as usize] {
            Instr::Scale(a, k) if *k > 0.0 => Joint::Same(*a),
            Instr::Scale(a, _) | Instr::Op(Op::Neg(_), [a, ..]) => Joint::Turned(*a),
            Instr::Op(op, [a, b, ..]) => {
                // The larger one comes first, so that few are pending at a time.
                let is_larger = counts[*a as usize] >= counts[*b as usize];
                let (first, last) = if is_larger { (*a, *b) } else { (*b, *a) };
                if matches!(op, Op::Max(_)) { Joint::All(first, last) } else { Joint::Any(first, last) }
            }
            _ => Joint::Leaf(slot),
        };
        let (mut leaves, mut skipped) = (Vec::new(), vec![false; code.len()]);
        let parts = parts_of(tape.outputs[0], |slot| {
            if is_joint(slot) {
                skipped[slot as usize] = true;
                return joint(slot);
            }
            leaves.push(slot);
            Joint::Leaf(slot)
        });
        let has_none = leaves == [tape.outputs[0]];
        let registers = if has_none { tape.registers().clone() } else { allocate(tape, &leaves, &skipped) };
        Crown { parts, registers }
    }
}

/// Evaluates the signs of the first output of a tape along pieces of lines, with memory of its own; one per thread.
#[derive(Debug)]
pub struct Signer<const B: usize, const K: usize> {
    leaves: Evaluator<Parabolas<B, K>>,
    classifier: Classifier<B>,
}

impl<const B: usize, const K: usize> Signer<B, K> {
    /// Memory for a tape.
    pub fn new(tape: &Arc<Tape>) -> Self {
        let leaves = Evaluator::with(tape.clone(), &tape.crown().registers);
        Signer { leaves, classifier: Classifier::default() }
    }

    /// Evaluates another tape from now on, unless it is that tape already.
    pub fn turn_to(&mut self, tape: &Arc<Tape>) -> &mut Self {
        if !Arc::ptr_eq(self.tape(), tape) {
            self.leaves.load_with(tape.clone(), &tape.crown().registers);
        }
        self
    }

    /// The tape.
    pub fn tape(&self) -> &Arc<Tape> {
        self.leaves.tape()
    }

    /// The signs along pieces with these coordinates.
    pub fn eval(&mut self, p: &[Parabolas<B, K>; 3]) -> Signs<B> {
        self.leaves.run(p);
        let leaves = &self.leaves;
        self.classifier.classify(&leaves.tape().crown().parts, |slot| leaves.value(slot))
    }

    /// The form of a leaf in the last evaluation.
    pub fn leaf(&self, leaf: u32) -> &Parabolas<B, K> {
        self.leaves.value(leaf)
    }

    /// What decides of the sign in a lane of the last evaluation; `None` if that is more than so many leaves.
    pub fn mix(&self, lane: usize, most: usize) -> Option<Mix<K>> {
        let leaves = &self.leaves;
        self.classifier.mix(&leaves.tape().crown().parts, (lane, most), |slot| leaves.value(slot))
    }
}
