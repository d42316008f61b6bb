//! Where a tape is cut.
//!
//! A *run* is what of a tape stands together and is plain arithmetic; between runs are single
//! instructions, as of a noise. Within a run a value needs no home in memory. It gets the one that the
//! evaluator has for it only if somebody else reads it: another run, an instruction in between, or the one
//! who asked.
//!
//! Homes are shared by values that live at different times. A run keeps the order in which it
//! reads and writes them for every vector, and vectors do not meet, so they may be.

use super::trace::{Line, Trace, Traced, is_plain};
use crate::tape::{Instr, Tape};
use std::collections::HashMap;
use std::ops::Range;

/// A part of a tape, in the order of evaluation.
#[derive(Debug)]
pub(super) enum Part {
    /// A computation.
    Run(Vec<Line>),
    /// An instruction that is not plain.
    One(u32),
}

/// Cuts a tape.
pub(super) fn cut(tape: &Tape, home: &[u32]) -> Vec<Part> {
    let runs = runs(tape);
    let mut of = vec![0; tape.code.len()];
    runs.iter().enumerate().for_each(|(r, (slots, _))| of[slots.clone()].fill(r));
    let kept = kept(tape, &runs, &of);
    let part = |(slots, is_plain): &(Range<usize>, bool)| {
        if *is_plain { write(tape, home, slots.clone(), &kept) } else { Some(Part::One(slots.start as u32)) }
    };
    runs.iter().filter_map(part).collect()
}

/// Instructions that stand together, and whether they are plain; those that are not stand alone.
fn runs(tape: &Tape) -> Vec<(Range<usize>, bool)> {
    let mut runs: Vec<(Range<usize>, bool)> = Vec::new();
    for (i, instr) in tape.code.iter().enumerate() {
        let plain = is_plain(instr);
        match runs.last_mut() {
            Some((slots, true)) if plain => slots.end = i + 1,
            _ => runs.push((i..i + 1, plain)),
        }
    }
    runs
}

/// Which values need their homes. Those of constants are filled before, and runs read coordinates where
/// they are given.
fn kept(tape: &Tape, runs: &[(Range<usize>, bool)], of: &[usize]) -> Vec<bool> {
    let mut kept = vec![false; tape.code.len()];
    for (i, instr) in tape.code.iter().enumerate() {
        let (_, is_plain) = runs[of[i]];
        instr.each_arg(|a| {
            let a = a as usize;
            let at_hand = is_plain && (of[a] == of[i] || matches!(tape.code[a], Instr::Coordinate(_)));
            kept[a] |= !at_hand;
        });
    }
    tape.outputs.iter().for_each(|&o| kept[o as usize] = true);
    tape.code.iter().zip(&mut kept).for_each(|(instr, kept)| *kept &= !matches!(instr, Instr::Const(_)));
    kept
}

/// Writes down a run; `None` if nobody needs anything of it.
fn write(tape: &Tape, home: &[u32], slots: Range<usize>, kept: &[bool]) -> Option<Part> {
    if !kept[slots.clone()].contains(&true) {
        return None;
    }
    let trace = Trace::default();
    let mut values: Vec<Traced<'_>> = Vec::with_capacity(slots.len());
    let mut given: HashMap<u32, Traced<'_>> = HashMap::new();
    for i in slots.clone() {
        let instr = &tape.code[i];
        // What is from elsewhere is named before it is read.
        instr.each_arg(|a| {
            if (a as usize) < slots.start {
                given.entry(a).or_insert_with(|| match tape.code[a as usize] {
                    Instr::Const(c) => Traced::Number(c),
                    Instr::Coordinate(axis) => trace.value(Line::Coordinate(axis)),
                    _ => trace.value(Line::Home(home[a as usize])),
                });
            }
        });
        let arg = |a: u32| match (a as usize).checked_sub(slots.start) {
            Some(own) => values[own],
            None => given[&a],
        };
        let value = trace.instr(instr, arg)?;
        if kept[i] {
            trace.keep(value, home[i]);
        }
        values.push(value);
    }
    drop((values, given));
    Some(Part::Run(trace.into_lines()))
}
