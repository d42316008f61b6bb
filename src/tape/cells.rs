//! Tapes for parts of space.
//!
//! A region is cut into eight cells, each again into eight, and so on; a cell has the tape pruned for
//! it. So what is close to a place is evaluated there and nothing else, however many parts a scene has.
//! Cells are made when they are first asked for, and serve whoever asks later, on any thread: what a
//! cell holds depends on nothing but where it is.
//!
//! Cells are *loose*: the tape of a cell holds within twice its size, so that for every ball there is a
//! cell of about the ball's size that has all of it, also next to the faces of larger cells (Ulrich's
//! loose octrees).

use super::Tape;
use crate::num::{Interval, Parabola, Parabolas};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

/// Children of a cell.
const PARTS: usize = 8;

/// Times that a region is cut.
const DEEPEST: u32 = 10;

/// A tape of less [work](Tape::work) is not worth pruning: eight children for each cell are soon more work
/// than what they save. (Measured on 512 parts; half as much is slower, twice as much no faster.)
const SHORT: u64 = 64;

/// A tape of more work than this share of its parent's is no gain.
const GAIN: f64 = 0.95;

/// So many times a cell is cut in vain before it is cut no more: all parts may be far from the faces that
/// it is cut along.
const PATIENCE: u32 = 5;

/// A region cut into cells; see the module text.
#[derive(Debug)]
pub struct Cells {
    root: Cell,
    centre: [f64; 3],
    half: f64,
    is_uniform: bool,
    is_defined: bool,
    /// Tapes made, and instructions in all of them.
    pruned: AtomicU64,
    kept: AtomicU64,
}

#[derive(Debug)]
struct Cell {
    tape: Arc<Tape>,
    /// Work in the tape.
    work: u64,
    /// How often its ancestors were cut in vain, one after the other.
    vain: u32,
    parts: OnceLock<Option<Box<[Cell; PARTS]>>>,
}

/// What pruning has gained so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Prunings {
    /// Tapes made.
    pub tapes: u64,
    /// Instructions in all of them.
    pub instructions: u64,
    /// Instructions of the whole tape.
    pub whole: u64,
}

impl Cells {
    /// The cells of a box. Outside of it, and for what is larger, there is the whole tape.
    pub fn new(tape: Arc<Tape>, region: &[Interval; 3]) -> Cells {
        let mut cells = Cells::undivided(tape);
        cells.is_defined = cells.tape().is_defined(region);
        cells.is_uniform = !cells.root.is_open();
        cells.centre = region.map(|r| r.mid());
        // A hair more, so that what is cut as the cells are fits into them.
        cells.half = (1.0 + 1e-8) * region.iter().map(|r| r.rad()).fold(0.0, f64::max);
        cells
    }

    /// All of space as one cell.
    pub fn undivided(tape: Arc<Tape>) -> Cells {
        let work = tape.work();
        Cells {
            root: Cell { tape, work, vain: 0, parts: OnceLock::new() },
            centre: [0.0; 3],
            half: 0.0,
            is_uniform: true,
            is_defined: false,
            pruned: AtomicU64::new(0),
            kept: AtomicU64::new(0),
        }
    }

    /// The whole tape.
    pub fn tape(&self) -> &Arc<Tape> {
        &self.root.tape
    }

    /// Whether there is one tape for all places.
    pub fn is_uniform(&self) -> bool {
        self.is_uniform
    }

    /// Whether the field is known to have a value everywhere in the region.
    pub fn is_defined(&self) -> bool {
        self.is_defined
    }

    /// What pruning has gained so far.
    pub fn prunings(&self) -> Prunings {
        Prunings {
            tapes: self.pruned.load(Ordering::Relaxed),
            instructions: self.kept.load(Ordering::Relaxed),
            whole: self.root.tape.len() as u64,
        }
    }

    /// A tape that equals the whole one within `reach` of a place along every axis.
    pub fn tape_around(&self, at: [f64; 3], reach: f64) -> &Arc<Tape> {
        &self.cell_around(at, reach).tape
    }

    /// How much work that tape is; see [`Tape::work`].
    pub fn work_around(&self, at: [f64; 3], reach: f64) -> u64 {
        self.cell_around(at, reach).work
    }

    fn cell_around(&self, at: [f64; 3], reach: f64) -> &Cell {
        let (mut cell, mut centre, mut half) = (&self.root, self.centre, self.half);
        let off = (0..3).map(|axis| (at[axis] - centre[axis]).abs()).fold(0.0, f64::max);
        let is_within = off <= half;
        if self.is_uniform || !is_within {
            return &self.root;
        }
        for _ in 0..DEEPEST {
            let quarter = 0.5 * half;
            // The cell reaches a whole `half` of its child beyond the child's faces.
            let fits = reach <= quarter * (1.0 - 1e-9);
            if !fits {
                break;
            }
            let Some(parts) = cell.parts(self, centre, half) else { break };
            let mut index = 0;
            for axis in 0..3 {
                let above = at[axis] >= centre[axis];
                index |= usize::from(above) << axis;
                centre[axis] += if above { quarter } else { -quarter };
            }
            (cell, half) = (&parts[index], quarter);
        }
        cell
    }
}

impl Cells {
    /// The tapes around places, each with the number of its place: places that have the same tape are
    /// neighbours in the list, in no order that means anything.
    pub fn tapes_around(
        &self,
        places: impl Iterator<Item = (usize, [f64; 3], f64)>,
    ) -> Vec<(&Arc<Tape>, usize)> {
        let mut list: Vec<_> = places.map(|(i, at, reach)| (self.tape_around(at, reach), i)).collect();
        list.sort_by_key(|(tape, i)| (Arc::as_ptr(tape), *i));
        list
    }
}

impl Cell {
    /// Whether anything may be dropped somewhere within.
    fn is_open(&self) -> bool {
        self.work >= SHORT && self.tape.has_choices()
    }

    /// The eight parts of the cell around `centre`, if it is worth cutting.
    fn parts(&self, all: &Cells, centre: [f64; 3], half: f64) -> Option<&[Cell; PARTS]> {
        let cut = || {
            if !self.is_open() || self.vain >= PATIENCE {
                return None;
            }
            let mut p = [Parabolas::<PARTS, 2>::all(Parabola::constant(Interval::point(0.0))); 3];
            let quarter = 0.5 * half;
            for i in 0..PARTS {
                for axis in 0..3 {
                    let sign = if i >> axis & 1 == 1 { 1.0 } else { -1.0 };
                    p[axis].set(i, &whole(centre[axis] + sign * quarter, half, axis));
                }
            }
            let tapes = self.tape.prune_each(&p);
            all.pruned.fetch_add(PARTS as u64, Ordering::Relaxed);
            all.kept.fetch_add(tapes.iter().map(|t| t.len() as u64).sum(), Ordering::Relaxed);
            let cells = tapes.map(|tape| {
                // One that is no less work is the same.
                let (tape, work) = match tape.work() {
                    less if less < self.work => (Arc::new(tape), less),
                    _ => (self.tape.clone(), self.work),
                };
                let gains = work as f64 <= GAIN * self.work as f64;
                Cell { tape, work, vain: if gains { 0 } else { self.vain + 1 }, parts: OnceLock::new() }
            });
            Some(Box::new(cells))
        };
        self.parts.get_or_init(cut).as_deref()
    }
}

/// A coordinate of a box, of which each axis is a direction of its own.
fn whole(mid: f64, half: f64, axis: usize) -> Parabola<2> {
    let along = |k: usize| if axis == k { half } else { 0.0 };
    // Cells far from the origin are known to the rounding of their places.
    let blur = 4.0 * f64::EPSILON * (mid.abs() + half);
    Parabola::coordinate(mid, along(0), [along(1), along(2)], 0.0, blur)
}
