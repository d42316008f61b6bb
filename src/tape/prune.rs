//! Pruning: what a region leaves of a tape.
//!
//! Over a region a minimum whose one side is always smaller *is* that side; a step, a clamp, a
//! `smoothstep` or a truncated power that has come to its end is a number; and what is multiplied by a mask of zero is
//! nothing. What a flow carries that rests there is the field itself, whose instructions take its place. What only fed the
//! rest goes.
//!
//! Octaves of a sum need no pruning: a sum ends by itself at the first octave that the footprint leaves
//! nothing of, after one comparison for a whole batch (`noise/sum.rs`).
//!
//! Values stay what they are, bit for bit, but for the sign of a zero; and where only the sides of a surface matter, more
//! goes (`levels.rs`).

use super::levels::{Levels, Wanted};
use super::{Evaluator, Instr, Tape, inner};
use crate::expr::{Identity, identity};
use crate::num::{Interval, Number};
use crate::op::{Op, Ramp};
use std::sync::Arc;

impl Tape {
    /// The tape [without](Bounded::pruned) what cannot matter in a region.
    pub fn prune(self: &Arc<Tape>, region: &[Interval; 3]) -> Tape {
        self.bound(region).pruned(Wanted::Values)
    }

    /// What encloses the values of the tape's instructions in `region`.
    pub fn bound(self: &Arc<Tape>, region: &[Interval; 3]) -> Bounded {
        let mut ranges = Evaluator::keeping_all(self.clone());
        ranges.eval(region);
        Bounded(ranges)
    }

    /// Whether there is anything that pruning might decide.
    pub fn has_choices(&self) -> bool {
        self.choices().next().is_some()
    }

    /// The instructions that pruning might decide.
    pub fn choices(&self) -> impl Iterator<Item = &Instr> {
        self.code.iter().filter(|instr| match instr {
            Instr::Op(op, _) => selects(op) || settles(op) || ends(op),
            Instr::Flow(flowed, _) => inner::may_rest(flowed),
            _ => false,
        })
    }

    /// The tape after what becomes of its instructions, which is asked from the last to the first, and only of those that
    /// something that stays reads.
    pub(super) fn decided(&self, mut fate: impl FnMut(usize) -> Fate) -> Tape {
        let mut fates = vec![Fate::Goes; self.code.len()];
        let stays = |fates: &mut [Fate], slot: u32| {
            let fate = &mut fates[slot as usize];
            if matches!(fate, Fate::Goes) {
                *fate = Fate::Stays;
            }
        };
        self.outputs.iter().for_each(|&o| stays(&mut fates, o));
        for slot in (0..self.code.len()).rev() {
            if matches!(fates[slot], Fate::Goes) {
                continue;
            }
            let fate = fate(slot);
            match &fate {
                Fate::Stays | Fate::Rests(_) => self.code[slot].each_arg(|a| stays(&mut fates, a)),
                Fate::Is(a) => stays(&mut fates, *a),
                Fate::Goes | Fate::Number(_) => {}
            }
            fates[slot] = fate;
        }
        self.with(&fates)
    }

    /// The code after its fate.
    fn with(&self, fates: &[Fate]) -> Tape {
        let mut moved = vec![u32::MAX; self.code.len()];
        let count = fates.iter().map(Fate::instructions).sum();
        let (mut code, mut origins) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for (slot, fate) in fates.iter().enumerate() {
            match fate {
                Fate::Goes => continue,
                Fate::Is(a) => {
                    moved[slot] = moved[*a as usize];
                    continue;
                }
                Fate::Number(c) => code.push(Instr::Const(*c)),
                Fate::Stays => {
                    let mut instr = self.code[slot].clone();
                    instr.map_args(|a| moved[a as usize]);
                    code.push(instr);
                }
                Fate::Rests(field) => {
                    let Instr::Flow(_, p) = &self.code[slot] else { continue };
                    let p = p.map(|a| moved[a as usize]);
                    moved[slot] = field.append_to(&mut code, &mut origins, p);
                    continue;
                }
            }
            origins.extend(self.origins.get(slot));
            moved[slot] = code.len() as u32 - 1;
        }
        Tape::of(code, self.outputs.iter().map(|&o| moved[o as usize]).collect(), origins, self.class())
    }
}

/// A tape, and what encloses the values of its instructions in a region.
pub struct Bounded(Evaluator<Interval>);

impl Bounded {
    pub(super) fn tape(&self) -> &Arc<Tape> {
        self.0.tape()
    }

    pub(super) fn ranges(&self) -> &Evaluator<Interval> {
        &self.0
    }

    /// Encloses the first output wherever that has a value.
    pub fn range(&self) -> Interval {
        *self.0.output(0)
    }

    /// The tape with everything dropped that cannot matter in the region for what is wanted.
    pub fn pruned(&self, wanted: Wanted) -> Tape {
        let tape = self.0.tape();
        let mut levels = Levels::new(tape, Facts::new(&tape.code, &self.0), wanted);
        tape.decided(|slot| levels.fate(slot))
    }
}

/// What becomes of an instruction.
#[derive(Clone)]
pub(super) enum Fate {
    /// Nothing reads it.
    Goes,
    Stays,
    /// It always equals an earlier one.
    Is(u32),
    /// It always equals a number.
    Number(f64),
    /// It is a flow that carries nothing: this field.
    Rests(Arc<Tape>),
}

impl Fate {
    /// How many instructions it takes.
    fn instructions(&self) -> usize {
        match self {
            Fate::Goes | Fate::Is(_) => 0,
            Fate::Stays | Fate::Number(_) => 1,
            Fate::Rests(field) => field.len(),
        }
    }
}

/// What is known of every instruction, from the first to the last.
pub(super) struct Facts<'a> {
    code: &'a [Instr],
    ranges: &'a Evaluator<Interval>,
    /// Which have a value everywhere. Where a side may have none, a minimum is not decided by the
    /// values that it has.
    whole: Vec<bool>,
    /// Which are numbers.
    numbers: Vec<Option<f64>>,
}

impl<'a> Facts<'a> {
    fn new(code: &'a [Instr], ranges: &'a Evaluator<Interval>) -> Facts<'a> {
        let (whole, numbers) = (Vec::with_capacity(code.len()), Vec::with_capacity(code.len()));
        let mut facts = Facts { code, ranges, whole, numbers };
        for (slot, instr) in code.iter().enumerate() {
            let mut whole = facts.range(slot as u32).is_finite();
            instr.each_arg(|a| whole &= facts.whole[a as usize]);
            whole &= match instr {
                Instr::Op(op, args) => op.is_defined(|k| facts.range(args[k])),
                Instr::Flow(flowed, p) => !whole || inner::is_defined(flowed, p.map(|a| facts.range(a))),
                _ => true,
            };
            let number = if whole { facts.number(slot) } else { None };
            facts.whole.push(whole);
            facts.numbers.push(number);
        }
        facts
    }

    /// Whether there is a value everywhere.
    pub(super) fn is_whole(&self, slot: u32) -> bool {
        self.whole[slot as usize]
    }

    /// Encloses a value.
    pub(super) fn range(&self, slot: u32) -> Interval {
        *self.ranges.value(slot)
    }

    /// The number that an instruction is, given what those before it are.
    fn number(&self, slot: usize) -> Option<f64> {
        let number = |a: u32| self.numbers[a as usize];
        match &self.code[slot] {
            Instr::Const(c) => Some(*c),
            Instr::Scale(a, k) => number(*a).map(|x| x.scale(*k)),
            Instr::Shift(a, c) => number(*a).map(|x| x.shift(*c)),
            Instr::Op(op, args) => match self.identity(op, args) {
                Some(Identity::Number(c)) => Some(c),
                Some(Identity::Argument(k)) => number(args[k]),
                None if self.is_zero(op, args) => Some(0.0),
                None if selects(op) || settles(op) => self.settled(slot),
                None => None,
            },
            _ => None,
        }
    }

    /// Whether an operation that ends smoothly at zero has ended. (Enclosures of powers of zero are a little wider.)
    fn is_zero(&self, op: &Op, args: &[u32; 6]) -> bool {
        let most = || self.range(args[0]).hi;
        match op {
            Op::Plus(_) => most() < 0.0,
            Op::Ramp(ramp) => *ramp != Ramp::Exponential && most() <= -1.0,
            _ => false,
        }
    }

    /// What an operation is by those arguments that are numbers, if any are.
    fn identity(&self, op: &Op, args: &[u32; 6]) -> Option<Identity> {
        let number = |k: usize| self.numbers[args[k] as usize];
        (0..op.arity()).any(|k| number(k).is_some()).then(|| identity(*op, number))?
    }

    /// The number at which an operation has come to its end.
    fn settled(&self, slot: usize) -> Option<f64> {
        let Instr::Op(op, args) = &self.code[slot] else { return None };
        let all = self.range(slot as u32);
        if all.lo != all.hi {
            return None;
        }
        let x: [Interval; 6] = std::array::from_fn(|k| {
            if k >= op.arity() {
                return all;
            }
            self.numbers[args[k] as usize].map_or_else(|| self.range(args[k]), Interval::point)
        });
        let all = op.apply(|k| &x[k]);
        (all.lo == all.hi).then_some(all.lo)
    }

    /// What becomes of it if all of its values matter.
    pub(super) fn fate(&self, slot: usize) -> Fate {
        if let Some(c) = self.numbers[slot] {
            return Fate::Number(c);
        }
        let (op, args) = match &self.code[slot] {
            Instr::Op(op, args) => (op, args),
            Instr::Flow(flowed, p) if p.iter().all(|a| self.whole[*a as usize]) => {
                let rest = inner::resting(flowed, &p.map(|a| self.range(a)));
                return rest.map_or(Fate::Stays, |field| Fate::Rests(Arc::new(field)));
            }
            _ => return Fate::Stays,
        };
        if !self.whole[slot] {
            return Fate::Stays;
        }
        if let Some(Identity::Argument(k)) = self.identity(op, args) {
            return Fate::Is(args[k]);
        }
        self.selected(op, args).map_or(Fate::Stays, Fate::Is)
    }

    /// The argument that an operation always equals.
    fn selected(&self, op: &Op, &[a, b, c, ..]: &[u32; 6]) -> Option<u32> {
        let below = |x: u32, y: u32| self.range(x).hi < self.range(y).lo;
        match op {
            Op::Abs(_) if self.range(a).lo > 0.0 => Some(a),
            Op::Ramp(ramp) if *ramp != Ramp::Exponential && self.range(a).lo >= 1.0 => Some(a),
            Op::Corner(_) if self.range(a).hi < 0.0 && below(b, a) => Some(a),
            Op::Corner(_) if self.range(b).hi < 0.0 && below(a, b) => Some(b),
            Op::Melt(melt) if self.range(b).lo - self.range(a).hi >= melt.reach() => Some(a),
            Op::Melt(melt) if self.range(a).lo - self.range(b).hi >= melt.reach() => Some(b),
            Op::Min(_) if below(a, b) => Some(a),
            Op::Min(_) if below(b, a) => Some(b),
            Op::Max(_) if below(b, a) => Some(a),
            Op::Max(_) if below(a, b) => Some(b),
            Op::Clamp(_) if below(b, a) && below(a, c) => Some(a),
            Op::Clamp(_) if below(a, b) && below(b, c) => Some(b),
            Op::Clamp(_) if below(c, a) && below(b, c) => Some(c),
            _ => None,
        }
    }
}

/// Whether the values of an operation are those of its arguments.
fn selects(op: &Op) -> bool {
    matches!(op, Op::Min(_) | Op::Max(_) | Op::Clamp(_))
}

/// Whether an operation has the same value for many arguments.
fn settles(op: &Op) -> bool {
    matches!(op, Op::Step(_) | Op::Smoothstep(_) | Op::Smootherstep(_) | Op::Sign(_) | Op::Floor(_))
}

/// Whether an operation with a smooth part has ends where it is simpler.
fn ends(op: &Op) -> bool {
    matches!(op, Op::Melt(_) | Op::Plus(_) | Op::Ramp(_))
}

impl Tape {
    /// Whether all outputs are known to be zero everywhere in a region, and every instruction to have a value there.
    pub(super) fn is_zero(self: &Arc<Tape>, region: &[Interval; 3]) -> bool {
        let mut ranges = Evaluator::keeping_all(self.clone());
        ranges.eval(region);
        let Facts { whole, numbers, .. } = Facts::new(&self.code, &ranges);
        whole.into_iter().all(|whole| whole) && self.outputs.iter().all(|o| numbers[*o as usize] == Some(0.0))
    }

    /// Whether every instruction is known to have a value everywhere in a region.
    pub fn is_defined(self: &Arc<Tape>, region: &[Interval; 3]) -> bool {
        let mut ranges = Evaluator::keeping_all(self.clone());
        ranges.eval(region);
        Facts::new(&self.code, &ranges).whole.into_iter().all(|whole| whole)
    }

    /// The first instruction that is not known to have a value everywhere in a region, though those before it have.
    pub fn first_undefined(self: &Arc<Tape>, region: &[Interval; 3]) -> Option<u32> {
        let mut ranges = Evaluator::keeping_all(self.clone());
        ranges.eval(region);
        Facts::new(&self.code, &ranges).whole.into_iter().position(|whole| !whole).map(|slot| slot as u32)
    }
}
