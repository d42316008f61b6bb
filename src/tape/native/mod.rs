//! Machine code for plain numbers in bulk.
//!
//! The interpreter loads every argument of an instruction from memory, a batch at a time, and stores its
//! result there. For a sum that is three accesses to memory around one operation, and a loop written
//! by hand, whose values stay in registers, is up to seven times as fast. So tapes that are evaluated often
//! on batches of plain numbers are translated to such loops while the program runs, for AVX2 and for
//! AVX-512, as M. Keeter's Fidget does for implicit surfaces. On other machines, for other numbers,
//! and where no memory may be executed, the interpreter goes on.
//!
//! 1. A tape is cut into *runs* of plain arithmetic (`runs`); what is more stays interpreted between them.
//! 2. Every operation writes down what it does, step by step (`trace`).
//! 3. Each value gets one of the vector registers while it is needed (`registers`).
//! 4. Instructions become bytes (`encode`), and these are made executable (`memory`).
//!
//! The bits are those of the interpreter: the same operations of IEEE 754 in the same order, none fused.
//! One thing the machine does in its own way: its minimum of a number and a NaN is always the second of
//! the two, while ours is NaN (see [`Real`](crate::num::Real)). But it also notes, in a flag, that the
//! operation was invalid. A run clears the flag and looks at it in the end, and where it is raised, the
//! batch is left to the interpreter. So NaN costs nothing where there is none.

mod encode;
mod memory;
mod registers;
mod runs;
mod trace;

use super::eval::Outcome;
use super::{Instr, Tape};
use crate::num::{Class, Level, Number, simd_level};
use crate::op::{self, Op};
use encode::{Assembler, Width};
use memory::{Batches, Code};
use runs::Part;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

/// What a translation costs, in instructions that are interpreted for a lane: so many for each instruction
/// of the tape, and so many besides. A tape is translated when it has been interpreted for as long as
/// that takes, so that no more than about twice the better choice is ever spent. (Measured: 160 ns for each
/// and 6 us for all, where the interpreter takes 0.22 ns.)
const FOR_EACH: u64 = 1000;
const FOR_ALL: u64 = 50_000;

/// The machine code of a tape, for either width of vectors, as soon as there is some.
#[derive(Debug, Default)]
pub(super) struct Native {
    /// Lanes evaluated before that.
    lanes: AtomicU64,
    narrow: OnceLock<Option<Translated>>,
    wide: OnceLock<Option<Translated>>,
}

/// A copy of a tape starts anew.
impl Clone for Native {
    fn clone(&self) -> Self {
        Native::default()
    }
}

impl Native {
    /// Evaluates a tape into the registers of an evaluator, whose instructions have these homes;
    /// `interpret` does a single one of them.
    pub(super) fn eval<T: Number>(
        &self,
        tape: (&Tape, &[u32]),
        at: &[T; 3],
        registers: &mut Vec<T>,
        interpret: impl Fn(&mut [T], usize),
    ) -> Outcome {
        let Some(lanes) = T::plain().map(|plain| plain.count()) else { return Outcome::Absent };
        let Some(translated) = self.translated(tape, lanes) else { return Outcome::Absent };
        for step in &translated.steps {
            match *step {
                Step::One(slot) => interpret(registers, slot as usize),
                Step::Run(entry) => {
                    let aside = translated.make_room(registers, lanes);
                    let homes = registers.as_mut_ptr().cast::<f64>();
                    let coordinates = at.each_ref().map(|at| std::ptr::from_ref(at).cast());
                    let batches = Batches { homes, coordinates, bytes: 8 * lanes, aside };
                    // Safety: a `T` is so many numbers and nothing else, whole vectors of them that
                    // the machine has, and there are batches for all homes and for what is put aside.
                    if unsafe { translated.code.call(entry, &batches) } {
                        return Outcome::Invalid;
                    }
                }
            }
        }
        Outcome::Done
    }

    /// Evaluates the one output of a tape that is all one run, from slices to a slice, which must be of
    /// one length.
    pub(super) fn eval_slices<T: Number>(
        &self,
        tape: (&Tape, &[u32]),
        at: [&[f64]; 3],
        registers: &mut Vec<T>,
        out: &mut [f64],
    ) -> Outcome {
        let (Some(plain), true) = (T::plain(), at.iter().all(|at| at.len() == out.len())) else {
            return Outcome::Absent;
        };
        let Some(translated) = self.translated(tape, out.len()) else { return Outcome::Absent };
        let ([Step::Run(entry)], [output]) = (&translated.steps[..], &tape.0.outputs[..]) else {
            return Outcome::Absent;
        };
        let aside = translated.make_room(registers, plain.count());
        let home = tape.1[*output as usize] as usize;
        let batches = Batches {
            // The only home that is written is where it should be.
            homes: out.as_mut_ptr().wrapping_sub(home * out.len()),
            coordinates: at.map(|at| at.as_ptr()),
            bytes: 8 * out.len(),
            aside,
        };
        // Safety: all slices have so many numbers, whole vectors of them that the machine has. A tape of one
        // run reads no home and writes those of its outputs alone. There is room for what is put aside.
        if unsafe { translated.code.call(*entry, &batches) } { Outcome::Invalid } else { Outcome::Done }
    }

    /// Makes the code for the vectors in use; whether there is any.
    pub(super) fn translate(&self, tape: (&Tape, &[u32])) -> bool {
        self.in_use().is_some_and(|(width, slot)| slot.get_or_init(|| Translated::new(tape, width)).is_some())
    }

    /// The code for the vectors in use, if batches are made of them, and if it is worth having.
    fn translated(&self, tape: (&Tape, &[u32]), lanes: usize) -> Option<&Translated> {
        let (width, slot) = self.in_use()?;
        if lanes == 0 || !(8 * lanes).is_multiple_of(width.bytes()) {
            return None;
        }
        if slot.get().is_none() {
            // Relaxed: it hardly matters who counts what, since the bits are the same.
            let lanes = lanes as u64;
            let so_far = lanes + self.lanes.fetch_add(lanes, Ordering::Relaxed);
            let count = tape.0.len() as u64;
            if so_far * count >= FOR_ALL + FOR_EACH * count {
                self.translate(tape);
            }
        }
        slot.get()?.as_ref()
    }

    /// The vectors in use, and where their code is.
    fn in_use(&self) -> Option<(Width, &OnceLock<Option<Translated>>)> {
        match simd_level() {
            Level::Avx512 => Some((Width::Zmm, &self.wide)),
            Level::Avx2 => Some((Width::Ymm, &self.narrow)),
            Level::Baseline => None,
        }
    }
}

/// A tape as machine code.
#[derive(Debug)]
struct Translated {
    code: Code,
    steps: Vec<Step>,
    /// Registers of the evaluator.
    homes: usize,
    /// Bytes for vectors that are put aside.
    aside: usize,
}

/// A part of a tape.
#[derive(Debug)]
enum Step {
    /// The run that begins here in the code.
    Run(usize),
    /// An instruction that is interpreted.
    One(u32),
}

impl Translated {
    /// Makes registers for all homes, and behind them for what is put aside; where that is.
    fn make_room<T: Number>(&self, registers: &mut Vec<T>, lanes: usize) -> *mut f64 {
        let batches = self.homes + self.aside.div_ceil(8 * lanes);
        if registers.len() < batches {
            registers.resize(batches, T::constant(0.0));
        }
        registers.as_mut_ptr().wrapping_add(self.homes).cast()
    }

    /// `None` where there is nothing to gain, or no memory that may be executed.
    fn new(tape: (&Tape, &[u32]), width: Width) -> Option<Translated> {
        if tells_invalid() { Translated::unasked(tape, width) } else { None }
    }

    /// The same on a machine of which nothing is known.
    fn unasked((tape, home): (&Tape, &[u32]), width: Width) -> Option<Translated> {
        let mut asm = Assembler::new(width);
        let (mut numbers, mut aside) = (Vec::new(), 0);
        let mut translate = |part| match part {
            Part::One(slot) => Step::One(slot),
            Part::Run(lines) => {
                let run = registers::assemble(&lines, &mut asm, &mut numbers);
                aside = aside.max(run.aside);
                Step::Run(run.entry)
            }
        };
        let steps: Vec<Step> = runs::cut(tape, home).into_iter().map(&mut translate).collect();
        let homes = home.iter().max().map_or(0, |most| *most as usize + 1);
        let gains = steps.iter().any(|step| matches!(step, Step::Run(_)));
        let code = if gains { Code::new(&asm.code, numbers)? } else { return None };
        Some(Translated { code, steps, homes, aside: aside * width.bytes() })
    }
}

/// Whether the machine says that a minimum met a NaN, as emulators of one may not.
fn tells_invalid() -> bool {
    static TELLS: OnceLock<bool> = OnceLock::new();
    *TELLS.get_or_init(|| {
        let code =
            vec![Instr::Coordinate(0), Instr::Coordinate(1), Instr::Op(Op::Min(op::Min), [0, 1, 0, 0, 0, 0])];
        let tape = (&Tape::of(code, vec![2], Vec::new(), Class::C0), &[0, 1, 2][..]);
        let Some(translated) = Translated::unasked(tape, Width::Ymm) else { return false };
        let [Step::Run(entry)] = translated.steps[..] else { return false };
        let invalid = |x: f64| {
            let (coordinates, mut homes) = ([[x; 4], [1.0; 4], [0.0; 4]], [0.0; 12]);
            let coordinates = coordinates.each_ref().map(|at| at.as_ptr());
            let homes = homes.as_mut_ptr();
            let batches = Batches { homes, coordinates, bytes: 32, aside: homes };
            // Safety: a batch is one vector, there are three homes, and nothing is put aside. All machines
            // that are asked this have AVX2.
            unsafe { translated.code.call(entry, &batches) }
        };
        invalid(f64::NAN) && !invalid(0.0)
    })
}

#[cfg(test)]
mod tests;
