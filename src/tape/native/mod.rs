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
use crate::num::{Level, Number, simd_level};
use crate::op::{self, Op};
use encode::{Assembler, Width};
use memory::{Batches, Code};
use runs::Part;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use trace::Line;

/// What a translation costs, in instructions that are interpreted for a lane: so many for each instruction
/// of the tape, and so many besides. A tape is translated when it has been interpreted for as long as
/// that takes, so that no more than twice the better choice is ever spent.
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
        (tape, home): (&Tape, &[u32]),
        at: &[T; 3],
        registers: &mut Vec<T>,
        interpret: impl Fn(&mut [T], usize),
    ) -> Outcome {
        let Some(lanes) = T::plain().map(|plain| plain.count()) else { return Outcome::Absent };
        let Some(translated) = self.translated((tape, home), lanes) else { return Outcome::Absent };
        let batches = translated.homes + translated.aside.div_ceil(8 * lanes);
        if registers.len() < batches {
            registers.resize(batches, T::constant(0.0));
        }
        for step in &translated.steps {
            match *step {
                Step::One(slot) => interpret(registers, slot as usize),
                Step::Run(entry) => {
                    let homes = registers.as_mut_ptr().cast::<f64>();
                    let aside = homes.wrapping_add(translated.homes * lanes);
                    let batches =
                        Batches { homes, coordinates: at.as_ptr().cast(), bytes: 8 * lanes, aside };
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

    /// The code for the vectors in use, if batches are made of them, and if it is worth having.
    fn translated(&self, (tape, home): (&Tape, &[u32]), lanes: usize) -> Option<&Translated> {
        let (width, slot) = match simd_level() {
            Level::Avx512 => (Width::Zmm, &self.wide),
            Level::Avx2 => (Width::Ymm, &self.narrow),
            Level::Baseline => return None,
        };
        if !(8 * lanes).is_multiple_of(width.bytes()) {
            return None;
        }
        if let Some(known) = slot.get() {
            return known.as_ref();
        }
        // Relaxed: it hardly matters who counts what, since the bits are the same.
        let so_far = lanes as u64 + self.lanes.fetch_add(lanes as u64, Ordering::Relaxed);
        let count = tape.len() as u64;
        if so_far * count < FOR_ALL + FOR_EACH * count {
            return None;
        }
        let translate = || if tells_invalid() { Translated::new((tape, home), width) } else { None };
        slot.get_or_init(translate).as_ref()
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
    /// `None` where there is nothing to gain, or no memory that may be executed.
    fn new((tape, home): (&Tape, &[u32]), width: Width) -> Option<Translated> {
        let mut asm = Assembler::new(width);
        let (mut numbers, mut aside) = (Vec::new(), 0);
        let mut translate = |part| match part {
            Part::One(slot) => Step::One(slot),
            Part::Run(lines) => {
                let watches = lines.iter().any(Line::may_be_invalid);
                let [entry, start] = asm.begin(watches);
                aside = aside.max(registers::assemble(&lines, &mut asm, &mut numbers));
                asm.end(start, watches);
                Step::Run(entry)
            }
        };
        let steps: Vec<Step> = runs::cut(tape, home).into_iter().map(&mut translate).collect();
        let homes = home.iter().max().map_or(0, |most| *most as usize + 1);
        let gains = steps.iter().any(|step| matches!(step, Step::Run(_)));
        let code = if gains { Code::new(&asm.code, numbers)? } else { return None };
        Some(Translated { code, steps, homes, aside: aside as usize * width.bytes() })
    }
}

/// Whether the machine says that a minimum met a NaN, as emulators of one may not.
fn tells_invalid() -> bool {
    static TELLS: OnceLock<bool> = OnceLock::new();
    *TELLS.get_or_init(|| {
        let code = vec![Instr::Coordinate(0), Instr::Coordinate(1), Instr::Op(Op::Min(op::Min), [0, 1, 0, 0, 0, 0])];
        let tape = (&Tape::of(code, vec![2]), &[0, 1, 2][..]);
        let Some(translated) = Translated::new(tape, Width::Ymm) else { return false };
        let [Step::Run(entry)] = translated.steps[..] else { return false };
        let invalid = |x: f64| {
            let (coordinates, mut homes) = ([[x; 4], [1.0; 4], [0.0; 4]], [[0.0; 4]; 3]);
            let homes = homes.as_mut_ptr().cast::<f64>();
            let batches = Batches { homes, coordinates: coordinates.as_ptr().cast(), bytes: 32, aside: homes };
            // Safety: a batch is one vector, there are three homes, and nothing is put aside. All machines
            // that are asked this have AVX2.
            unsafe { translated.code.call(entry, &batches) }
        };
        invalid(f64::NAN) && !invalid(0.0)
    })
}
