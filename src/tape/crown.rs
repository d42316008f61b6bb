//! What a tape puts together last.
//!
//! Most solids are made of others: the last instructions of a tape are minima, maxima and negatives. They are its *crown*,
//! and what they put together its *leaves*. Who asks for signs alone has them put together as sets of places
//! ([`Classifier`]), and needs no values of the crown. What is read elsewhere besides is a leaf.

use super::eval::{Registers, allocate};
use super::{Evaluator, Instr, Tape};
use crate::num::{Classifier, Interval, Joint, Mix, Parabola, Parabolas, Part, Sign, Signs, parts_of};
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
        // The larger one comes first, so that few are pending at a time.
        let in_order =
            |a: u32, b: u32| if counts[a as usize] >= counts[b as usize] { (a, b) } else { (b, a) };
        let parts = parts_of((tape.outputs[0], ZERO), |(slot, shift)| {
            let is_joint = joints[slot as usize];
            skipped[slot as usize] = is_joint;
            match &code[slot as usize] {
                // k x + c has the sign of x + c / k, or of its negative.
                Instr::Scale(a, k) if is_joint => {
                    let shift = if shift == ZERO { ZERO } else { shift / Interval::point(*k) };
                    if *k > 0.0 { Joint::Same((*a, shift)) } else { Joint::Turned((*a, shift)) }
                }
                Instr::Shift(a, c) if is_joint => Joint::Same((*a, shift + Interval::point(*c))),
                Instr::Op(Op::Neg(_), [a, ..]) if is_joint => Joint::Turned((*a, -shift)),
                Instr::Op(Op::Max(_), [a, b, ..]) if is_joint => {
                    let (first, last) = in_order(*a, *b);
                    Joint::All((first, shift), (last, shift))
                }
                Instr::Op(Op::Min(_), [a, b, ..]) if is_joint => {
                    let (first, last) = in_order(*a, *b);
                    Joint::Any((first, shift), (last, shift))
                }
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

/// Evaluates the signs of the first output of tapes along pieces of lines, with memory of its own; one per thread.
#[derive(Debug)]
pub struct Signer<const B: usize, const K: usize> {
    /// Made when they are first needed: all leaves of a tape are kept at a time.
    leaves: Option<Evaluator<Parabolas<B, K>>>,
    /// Those that something is added to.
    shifted: Vec<Parabolas<B, K>>,
    classifier: Classifier<B>,
}

impl<const B: usize, const K: usize> Default for Signer<B, K> {
    fn default() -> Self {
        Signer { leaves: None, shifted: Vec::new(), classifier: Classifier::default() }
    }
}

impl<const B: usize, const K: usize> Signer<B, K> {
    /// The signs of a tape along pieces with these coordinates.
    pub fn eval(&mut self, tape: &Arc<Tape>, p: &[Parabolas<B, K>; 3]) -> Signed<'_, B, K> {
        let Signer { leaves, shifted, classifier } = self;
        let Crown { parts, leaves: all, registers } = tape.crown();
        let leaves = match leaves {
            Some(leaves) => {
                if !Arc::ptr_eq(leaves.tape(), tape) {
                    leaves.load_with(tape.clone(), registers);
                }
                leaves
            }
            none => none.insert(Evaluator::with(tape.clone(), registers)),
        };
        leaves.run(p);
        shifted.clear();
        for leaf in all.iter().filter(|leaf| leaf.shift != ZERO) {
            shifted.push(leaves.value(leaf.slot).shifted_by(leaf.shift));
        }
        let forms = Forms { leaves, shifted };
        let signs = classifier.classify(parts, |leaf| forms.of(leaf));
        Signed { signs, forms, classifier }
    }
}

/// The forms of the leaves of a tape.
struct Forms<'a, const B: usize, const K: usize> {
    leaves: &'a Evaluator<Parabolas<B, K>>,
    shifted: &'a [Parabolas<B, K>],
}

impl<'a, const B: usize, const K: usize> Forms<'a, B, K> {
    fn of(&self, leaf: u32) -> &'a Parabolas<B, K> {
        let Leaf { slot, order, .. } = self.leaves.tape().crown().leaves[leaf as usize];
        order.map_or_else(|| self.leaves.value(slot), |order| &self.shifted[order as usize])
    }
}

/// What is known of signs, piece by piece.
pub struct Signed<'a, const B: usize, const K: usize> {
    signs: Signs<B>,
    forms: Forms<'a, B, K>,
    classifier: &'a Classifier<B>,
}

impl<const B: usize, const K: usize> Signed<'_, B, K> {
    /// What is known of the sign along a piece.
    pub fn lane(&self, lane: usize) -> Sign {
        self.signs.lane(lane)
    }

    /// The form of what is expected to become negative first, or else of something that may.
    pub fn form(&self, lane: usize) -> Parabola<K> {
        let Sign { leaf, is_turned, .. } = self.signs.lane(lane);
        let form = self.forms.of(leaf).lane(lane);
        if is_turned { form.negated() } else { form }
    }

    /// What decides of the sign along a piece; `None` if that is more than so many leaves.
    pub fn mix(&self, lane: usize, most: usize) -> Option<Mix<K>> {
        let parts = &self.forms.leaves.tape().crown().parts;
        self.classifier.mix(parts, (lane, most), |leaf| self.forms.of(leaf))
    }
}
