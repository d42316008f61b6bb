//! No machine code for this kind of machine: the interpreter does all.

use super::Tape;
use super::eval::Outcome;

/// Nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct Native;

impl Native {
    /// As on x86-64, but never there.
    pub(super) fn eval<T>(
        &self,
        _: (&Tape, &[u32]),
        _: &[T; 3],
        _: &mut Vec<T>,
        _: impl Fn(&mut [T], usize),
    ) -> Outcome {
        Outcome::Absent
    }

    /// The same.
    pub(super) fn eval_slices<T>(
        &self,
        _: (&Tape, &[u32]),
        _: [&[f64]; 3],
        _: &mut Vec<T>,
        _: &mut [f64],
    ) -> Outcome {
        Outcome::Absent
    }

    /// Never any.
    pub(super) fn translate(&self, _: (&Tape, &[u32])) -> bool {
        false
    }
}
