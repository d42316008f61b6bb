//! The one evaluation loop.

use super::{Instr, Tape};
use crate::noise::Given;
use crate::num::Number;
use std::sync::Arc;

/// Evaluates a tape on one kind of number, with memory of its own; one per thread.
#[derive(Clone, Debug)]
pub struct Evaluator<T> {
    tape: Arc<Tape>,
    slots: Vec<T>,
}

impl<T: Number> Evaluator<T> {
    /// Memory for a tape; its constants are set once, here.
    pub fn new(tape: Arc<Tape>) -> Self {
        let constant = |i: &Instr| match i {
            Instr::Const(c) => T::constant(*c),
            _ => T::constant(0.0),
        };
        let slots = tape.code.iter().map(constant).collect();
        Evaluator { tape, slots }
    }

    /// The tape.
    pub fn tape(&self) -> &Arc<Tape> {
        &self.tape
    }

    /// Evaluates all outputs at a point and returns the first; see [`output`](Self::output).
    pub fn eval(&mut self, p: &[T; 3]) -> &T {
        for (i, instr) in self.tape.code.iter().enumerate() {
            let (done, rest) = self.slots.split_at_mut(i);
            let at = |a: u32| &done[a as usize];
            rest[0] = match instr {
                Instr::Const(_) => continue,
                Instr::Coordinate(axis) => p[*axis].clone(),
                Instr::Scale(a, k) => at(*a).scale(*k),
                Instr::Shift(a, c) => at(*a).shift(*c),
                Instr::Op(op, args) => op.apply(|i| at(args[i])),
                Instr::Noise(noise, p) => T::kernel(noise, p.map(at)),
                Instr::Grid(grid, p) => T::kernel(&**grid, p.map(at)),
                Instr::Fractal(fractal, p, further) => {
                    let [footprint, hurst] = further.map(|a| a.map(at));
                    fractal.eval_given(&Given { point: p.map(at), footprint, hurst })
                }
            };
        }
        self.output(0)
    }

    /// An output of the last evaluation.
    pub fn output(&self, k: usize) -> &T {
        &self.slots[self.tape.outputs[k] as usize]
    }

    /// The slots of the last evaluation, one an instruction.
    pub(super) fn slots(&self) -> &[T] {
        &self.slots
    }
}
