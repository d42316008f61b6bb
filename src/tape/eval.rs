//! The one evaluation loop.
//!
//! A tape names its values by the instructions that compute them. An evaluator keeps them in fewer
//! *registers*: one is taken again as soon as its value has been read for the last time, so that the
//! registers of a long tape stay in the first-level cache, however wide the batches are. Who asks for signs has no
//! registers for what is put together last, and keeps all that it is put together from (`crown`). For batches of
//! plain numbers there may be machine code in place of the loop (`native`), with the same bits.

use super::{Instr, Tape};
use crate::noise::Given;
use crate::num::{Many, Number};
use std::sync::Arc;

/// Evaluates a tape on one kind of number, with memory of its own; one per thread.
#[derive(Clone, Debug)]
pub struct Evaluator<T> {
    tape: Arc<Tape>,
    /// The register of the value of each instruction.
    home: Arc<[u32]>,
    registers: Vec<T>,
    /// So many evaluations go without machine code.
    pause: u32,
}

impl<T: Number> Evaluator<T> {
    /// Memory for a tape; its constants are set once, here.
    pub fn new(tape: Arc<Tape>) -> Self {
        Evaluator::with(tape.clone(), tape.registers())
    }

    /// The same with values in other registers.
    pub(super) fn with(tape: Arc<Tape>, registers: &Registers) -> Self {
        let home = registers.home.clone();
        let mut evaluator = Evaluator { tape: tape.clone(), home, registers: Vec::new(), pause: 0 };
        evaluator.load_with(tape, registers);
        evaluator
    }

    /// An evaluator that keeps the values of all instructions; see [`value`](Self::value).
    pub fn keeping_all(tape: Arc<Tape>) -> Self {
        let home = (0..tape.code.len() as u32).collect();
        let mut evaluator =
            Evaluator { registers: vec![T::constant(0.0); tape.code.len()], tape, home, pause: 0 };
        evaluator.set_constants();
        evaluator
    }

    /// Evaluates another tape from now on, in the same memory as far as that suffices.
    pub fn load(&mut self, tape: Arc<Tape>) {
        self.load_with(tape.clone(), tape.registers());
    }

    /// The same with values in other registers.
    pub(super) fn load_with(&mut self, tape: Arc<Tape>, Registers { home, count }: &Registers) {
        if self.registers.len() < *count {
            self.registers.resize(*count, T::constant(0.0));
        }
        self.home = home.clone();
        self.tape = tape;
        self.set_constants();
    }

    /// The same, unless it is that tape already.
    pub fn turn_to(&mut self, tape: &Arc<Tape>) -> &mut Self {
        if !Arc::ptr_eq(&self.tape, tape) {
            self.load(tape.clone());
        }
        self
    }

    fn set_constants(&mut self) {
        for (instr, &home) in self.tape.code.iter().zip(&self.home[..]) {
            if let Instr::Const(c) = instr {
                self.registers[home as usize] = T::constant(*c);
            }
        }
    }

    /// The tape.
    pub fn tape(&self) -> &Arc<Tape> {
        &self.tape
    }

    /// Evaluates all outputs at a point and returns the first; see [`output`](Self::output).
    pub fn eval(&mut self, p: &[T; 3]) -> &T {
        if self.eval_natively(p) {
            return self.output(0);
        }
        self.eval_by(coordinates(p))
    }

    /// The same at a point whose coordinates are written where they are read: `coordinate` is told which one, and where. It
    /// goes without machine code.
    pub fn eval_by(&mut self, coordinate: impl Fn(usize, &mut T)) -> &T {
        for i in 0..self.tape.code.len() {
            interpret(&self.tape.code[i], &self.home, i, &mut self.registers, &coordinate);
        }
        self.output(0)
    }

    /// Evaluates the instructions that have a register; see [`value`](Self::value).
    pub(super) fn run(&mut self, p: &[T; 3]) {
        for i in (0..self.tape.code.len()).filter(|&i| self.home[i] != NOWHERE) {
            interpret(&self.tape.code[i], &self.home, i, &mut self.registers, &coordinates(p));
        }
    }

    /// The same by machine code, if there is some and it can tell.
    fn eval_natively(&mut self, p: &[T; 3]) -> bool {
        self.natively(|tape, home, registers| {
            let one = |registers: &mut [T], i: usize| {
                interpret(&tape.code[i], home, i, registers, &coordinates(p));
            };
            tape.native.eval((tape, home), p, registers, one)
        })
    }

    /// Tries an evaluation by machine code, unless one has failed a short while ago.
    fn natively(&mut self, eval: impl FnOnce(&Tape, &[u32], &mut Vec<T>) -> Outcome) -> bool {
        // Known when this is compiled.
        if T::plain().is_none_or(|plain| plain.count() == 1) {
            return false;
        }
        let Evaluator { tape, home, registers, pause } = self;
        let keeps_all = !Arc::ptr_eq(home, &tape.registers().home);
        if keeps_all || *pause > 0 {
            *pause = pause.saturating_sub(1);
            return false;
        }
        let outcome = eval(tape, home, registers);
        if let Outcome::Invalid = outcome {
            *pause = PAUSE;
        }
        matches!(outcome, Outcome::Done)
    }

    /// An output of the last evaluation.
    pub fn output(&self, k: usize) -> &T {
        self.value(self.tape.outputs[k])
    }

    /// The value of an instruction in the last evaluation, if it is kept: outputs and constants are, all are if
    /// [wished](Self::keeping_all), and else what was chosen with the registers.
    pub fn value(&self, slot: u32) -> &T {
        &self.registers[self.home[slot as usize] as usize]
    }

    /// Evaluates at a point, with a change made to the value of each instruction before others read it; constants must
    /// stay as they are.
    pub fn eval_changed(&mut self, p: &[T; 3], mut change: impl FnMut(usize, &mut T)) -> &T {
        for i in 0..self.tape.code.len() {
            interpret(&self.tape.code[i], &self.home, i, &mut self.registers, &coordinates(p));
            change(i, &mut self.registers[self.home[i] as usize]);
        }
        self.output(0)
    }

    /// Executes instruction number `i` again, on the values that the last evaluation left. Only for an evaluator that
    /// [keeps all](Self::keeping_all).
    pub(super) fn again(&mut self, i: usize, p: &[T; 3]) {
        interpret(&self.tape.code[i], &self.home, i, &mut self.registers, &coordinates(p));
    }
}

/// Writes the coordinates of a point.
fn coordinates<T: Number>(p: &[T; 3]) -> impl Fn(usize, &mut T) {
    |axis, out| out.clone_from(&p[axis])
}

/// Points that [`Evaluator::eval_all`] does in one go.
const PIECE: usize = 1024;

impl<const B: usize> Evaluator<Many<f64, B>> {
    /// Evaluates the first output at as many points as the shortest of the slices has; what it costs to begin
    /// is spread over more of them than with single batches. Other outputs are not kept.
    pub fn eval_all(&mut self, at: [&[f64]; 3], out: &mut [f64]) {
        let count = at.iter().map(|at| at.len()).fold(out.len(), usize::min);
        for start in (0..count).step_by(PIECE) {
            let piece = start..count.min(start + PIECE);
            let at = at.map(|at| &at[piece.clone()]);
            let out = &mut out[piece];
            let slices = |tape: &Tape, home: &[u32], registers: &mut Vec<_>| {
                tape.native.eval_slices((tape, home), at, registers, out)
            };
            if !self.natively(slices) {
                self.eval_batches(at, out);
            }
        }
    }

    /// The same, batch by batch.
    fn eval_batches(&mut self, at: [&[f64]; 3], out: &mut [f64]) {
        let mut p = [Many([0.0; B]); 3];
        for (batch, out) in out.chunks_mut(B).enumerate() {
            for (p, at) in p.iter_mut().zip(at) {
                p.0[..out.len()].copy_from_slice(&at[B * batch..][..out.len()]);
            }
            out.copy_from_slice(&self.eval(&p).0[..out.len()]);
        }
    }
}

/// What came of an evaluation by machine code.
pub(super) enum Outcome {
    /// All is there.
    #[cfg_attr(not(target_arch = "x86_64"), expect(dead_code))]
    Done,
    /// There was a NaN where the machine has other rules than we.
    #[cfg_attr(not(target_arch = "x86_64"), expect(dead_code))]
    Invalid,
    /// There is none.
    Absent,
}

/// Evaluations that go without machine code after one that it could not do: where there is a NaN, another
/// is near.
const PAUSE: u32 = 8;

/// Executes instruction number `i`.
#[inline(always)]
fn interpret<T: Number>(
    instr: &Instr,
    home: &[u32],
    i: usize,
    registers: &mut [T],
    coordinate: &impl Fn(usize, &mut T),
) {
    let own = home[i];
    // The register that is written is none of those that are read.
    let (below, rest) = registers.split_at_mut(own as usize);
    let Some((out, above)) = rest.split_first_mut() else { return };
    let at = |a: u32| {
        let a = home[a as usize];
        if a < own { &below[a as usize] } else { &above[(a - own) as usize - 1] }
    };
    match instr {
        Instr::Const(_) => {}
        Instr::Coordinate(axis) => coordinate(*axis, out),
        Instr::Scale(a, k) => at(*a).scale_to(*k, out),
        Instr::Shift(a, c) => at(*a).shift_to(*c, out),
        Instr::Op(op, args) => op.apply_to(|i| at(args[i]), out),
        Instr::Noise(noise, p) => T::kernel_to(&**noise, p.map(at), out),
        Instr::Grid(grid, p) => T::kernel_to(&**grid, p.map(at), out),
        Instr::Shape(shape, p) => T::kernel_to(shape.body(), p.map(at), out),
        Instr::Flow(flowed, p) => T::kernel_to(&**flowed, p.map(at), out),
        Instr::Fractal(fractal, p, further) => {
            let [footprint, hurst] = further.map(|a| a.map(at));
            fractal.eval_to(&Given { point: p.map(at), footprint, hurst }, out);
        }
    }
}

/// The register of what is not evaluated.
const NOWHERE: u32 = u32::MAX;

/// Which register holds the value of each instruction.
#[derive(Clone, Debug)]
pub(super) struct Registers {
    home: Arc<[u32]>,
    count: usize,
}

impl Tape {
    /// The registers of the tape's values.
    pub(super) fn registers(&self) -> &Registers {
        self.registers.get_or_init(|| allocate(self, &self.outputs, &vec![false; self.code.len()]))
    }

    /// Has machine code made for the vectors in use now, rather than when evaluations in bulk have become
    /// many, and says whether there is any; values are the same with it and without.
    pub fn translate(&self) -> bool {
        self.native.translate((self, &self.registers().home))
    }
}

/// Chooses a register for each value. Registers whose values were read for the last time are taken
/// again, the latest first, but never for the very instruction that reads them; constants and what is kept
/// have theirs for good, and instructions that are skipped have none.
pub(super) fn allocate(tape: &Tape, kept: &[u32], skipped: &[bool]) -> Registers {
    let code = &tape.code;
    // The instruction that reads a value last; none does where that is the value's own.
    let mut last: Vec<u32> = (0..code.len() as u32).collect();
    for (i, instr) in code.iter().enumerate().filter(|(i, _)| !skipped[*i]) {
        instr.each_arg(|a| last[a as usize] = i as u32);
    }
    let constants = (0..code.len() as u32).filter(|&i| matches!(code[i as usize], Instr::Const(_)));
    constants.chain(kept.iter().copied()).for_each(|kept| last[kept as usize] = u32::MAX);
    let (mut free, mut count) = (Vec::new(), 0);
    let mut home: Vec<u32> = Vec::with_capacity(code.len());
    for (i, instr) in code.iter().enumerate() {
        if skipped[i] {
            home.push(NOWHERE);
            continue;
        }
        // Constants are written before all others, so their registers must be new.
        let again = if matches!(instr, Instr::Const(_)) { None } else { free.pop() };
        home.push(again.unwrap_or_else(|| {
            count += 1;
            count - 1
        }));
        instr.each_arg(|a| {
            // An argument that is read twice is free once.
            if last[a as usize] == i as u32 {
                last[a as usize] = u32::MAX;
                free.push(home[a as usize]);
            }
        });
    }
    Registers { home: home.into(), count: count as usize }
}
