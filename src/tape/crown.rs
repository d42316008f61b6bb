//! What a tape puts together last.
//!
//! Most solids are made of others: the last instructions of a tape are minima, maxima and negatives. They are its *crown*,
//! and what they put together its *leaves*. Who asks for signs alone has them put together as sets of places
//! ([`Classifier`]), and needs no values of the crown. What is read elsewhere besides is a leaf.

use super::eval::{Registers, allocate};
use super::{Evaluator, Instr, Tape};
use crate::num::{Classifier, Interval, Joint, Mix, Parabolas, Part, Signs, parts_of};
use crate::op::Op;
use std::sync::Arc;

/// How a tape puts its leaves together, and where their values are kept.
#[derive(Clone, Debug)]
pub(super) struct Crown {
    parts: Vec<Part>,
    leaves: Vec<Leaf>,
    registers: Registers,
}

/// A value, and what is added to it: of `max(a, b) + c` the leaves are `a + c` and `b + c`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Leaf {
    slot: u32,
    shift: Interval,
    /// Its place among those that are shifted.
    order: Option<u32>,
}

const ZERO: Interval = Interval { lo: 0.0, hi: 0.0 };

impl Tape {
    fn crown(&self) -> &Crown {
        self.crown.get_or_init(|| Box::new(Crown::of(self)))
    }
}

impl Crown {
    fn of(tape: &Tape) -> Crown {
        let code = &tape.code;
        let (joints, counts) = joints(tape);
        let (mut leaves, mut skipped) = (Vec::new(), vec![false; code.len()]);
        let mut shifted = 0..;
        let parts = parts_of((tape.outputs[0], ZERO), |(slot, shift)| {
            let with = |slot: &u32, shift: Interval| (*slot, shift);
            skipped[slot as usize] = joints[slot as usize];
            match &code[slot as usize] {
                instr if joints[slot as usize] => match instr {
                    // k x + c has the sign of x + c / k, or of its negative.
                    Instr::Scale(a, k) => {
                        let all = if shift == ZERO { ZERO } else { shift / Interval::point(*k) };
                        if *k > 0.0 { Joint::Same(with(a, all)) } else { Joint::Turned(with(a, all)) }
                    }
                    Instr::Shift(a, c) => Joint::Same(with(a, shift + Interval::point(*c))),
                    Instr::Op(op, [a, b, ..]) => {
                        // The larger one comes first, so that few are pending at a time.
                        let is_larger = counts[*a as usize] >= counts[*b as usize];
                        let (first, last) = if is_larger { (a, b) } else { (b, a) };
                        match op {
                            Op::Max(_) => Joint::All(with(first, shift), with(last, shift)),
                            Op::Min(_) => Joint::Any(with(first, shift), with(last, shift)),
                            _ => Joint::Turned(with(a, -shift)),
                        }
                    }
                    _ => Joint::Leaf(0),
                },
                _ => {
                    let order = if shift == ZERO { None } else { shifted.next() };
                    leaves.push(Leaf { slot, shift, order });
                    Joint::Leaf(leaves.len() as u32 - 1)
                }
            }
        });
        let kept: Vec<u32> = leaves.iter().map(|leaf| leaf.slot).collect();
        let has_none = kept == [tape.outputs[0]];
        let registers = if has_none { tape.registers().clone() } else { allocate(tape, &kept, &skipped) };
        Crown { parts, leaves, registers }
    }
}

/// Which instructions put others together that nobody else reads, and how many leaves each would have.
fn joints(tape: &Tape) -> (Vec<bool>, Vec<u32>) {
    let mut reads = vec![0_u32; tape.code.len()];
    tape.code.iter().for_each(|instr| instr.each_arg(|a| reads[a as usize] += 1));
    tape.outputs.iter().for_each(|&output| reads[output as usize] += 1);
    let (mut joints, mut counts) = (Vec::new(), Vec::<u32>::new());
    for (instr, reads) in tape.code.iter().zip(reads) {
        let joins = match instr {
            Instr::Op(Op::Min(_) | Op::Max(_) | Op::Neg(_), _) => true,
            Instr::Scale(_, k) => k.abs() > 0.0,
            // There is nothing to gain from the shift of a single leaf.
            Instr::Shift(a, _) => counts[*a as usize] > 1,
            _ => false,
        };
        let is_joint = joins && reads == 1;
        let mut count = 0;
        instr.each_arg(|a| count += counts[a as usize]);
        joints.push(is_joint);
        counts.push(if is_joint { count } else { 1 });
    }
    (joints, counts)
}

/// Evaluates the signs of the first output of a tape along pieces of lines, with memory of its own; one per thread.
#[derive(Debug)]
pub struct Signer<const B: usize, const K: usize> {
    leaves: Evaluator<Parabolas<B, K>>,
    /// Of the last evaluation, those that something is added to.
    shifted: Vec<Parabolas<B, K>>,
    classifier: Classifier<B>,
}

impl<const B: usize, const K: usize> Signer<B, K> {
    /// Memory for a tape.
    pub fn new(tape: &Arc<Tape>) -> Self {
        let leaves = Evaluator::with(tape.clone(), &tape.crown().registers);
        Signer { leaves, shifted: Vec::new(), classifier: Classifier::default() }
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
        let Signer { leaves, shifted, classifier } = self;
        leaves.run(p);
        let tape = leaves.tape();
        let Crown { parts, leaves: all, .. } = tape.crown();
        shifted.clear();
        for leaf in all.iter().filter(|leaf| leaf.shift != ZERO) {
            shifted.push(leaves.value(leaf.slot).shifted_by(leaf.shift));
        }
        classifier.classify(parts, |leaf| found(leaves, shifted, leaf))
    }

    /// The form of a leaf in the last evaluation.
    pub fn leaf(&self, leaf: u32) -> &Parabolas<B, K> {
        found(&self.leaves, &self.shifted, leaf)
    }

    /// What decides of the sign in a lane of the last evaluation; `None` if that is more than so many leaves.
    pub fn mix(&self, lane: usize, most: usize) -> Option<Mix<K>> {
        self.classifier.mix(&self.tape().crown().parts, (lane, most), |leaf| self.leaf(leaf))
    }
}

/// The form of a leaf, of which some are shifted.
fn found<'a, const B: usize, const K: usize>(
    leaves: &'a Evaluator<Parabolas<B, K>>,
    shifted: &'a [Parabolas<B, K>],
    leaf: u32,
) -> &'a Parabolas<B, K> {
    let Leaf { slot, order, .. } = leaves.tape().crown().leaves[leaf as usize];
    order.map_or_else(|| leaves.value(slot), |order| &shifted[order as usize])
}
