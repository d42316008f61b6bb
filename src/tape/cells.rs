//! Tapes for parts of space.
//!
//! A region is cut into eight cells, each again into eight, and so on; a cell has the tape pruned for
//! it. So what is close to a place is evaluated there and nothing else, however many parts a scene has.
//! Cells are made when they are first asked for, each by itself, and serve whoever asks later, on any
//! thread: what a cell holds depends on nothing but where it is. A cell also knows whether it is free of
//! the solid, so that rays may pass it without an evaluation of their own; one that is free has no tape until somebody
//! wants it.
//!
//! Cells are *loose*: the tape of a cell holds within twice its size, so that for every ball there is a
//! cell of about the ball's size that has all of it, also next to the faces of larger cells (Ulrich's
//! loose octrees).

use super::prune::Bounded;
use super::{Defined, Tape, Wanted};
use crate::num::{Class, Interval};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

/// Children of a cell.
const PARTS: usize = 8;

/// Times that a region is cut, but for cuts that count for nothing.
const DEEPEST: u32 = 10;

/// A tape of less [work](Tape::work) is not worth pruning: its children are soon more work than what they
/// save. (Measured on scenes of 100 to 5000 parts: twice as much is slower by a tenth.)
const SHORT: u64 = 32;

/// A tape of more work than this share of its parent's is no gain. (With 0.95 a coral takes as long, and 1.7 times the
/// memory; with 0.6 half of that, and a third more time.)
const GAIN: f64 = 0.8;

/// So many times a cell is cut in vain before it is cut no more: all parts may be far from the faces that
/// it is cut along.
const PATIENCE: u32 = 5;

/// Where so many of the parts of a cell are free of the solid, or gain, a cut in vain has found out where most of it is. So is
/// what is small beside the bounds, as they are wished or as something far away has them: all of it is in one cell until cells
/// are as small as it is. As long as nothing was gained, such cuts count for nothing,
const EASIER: usize = 5;

/// but after so many that were in vain nobody asks any more, since asking takes as much as all parts.
const ASKED: u32 = 2;

/// Times that a region is cut, with those that count for nothing.
const CUTS: u32 = 32;

/// A region cut into cells; see the module text.
#[derive(Debug)]
pub struct Cells {
    whole: Own,
    parts: Parts,
    centre: [f64; 3],
    half: f64,
    /// Reaches that are less are taken for this one.
    least: f64,
    wanted: Wanted,
    is_uniform: bool,
    /// Where in the region the field has a value.
    defined: Option<Defined>,
    /// Tapes made, and instructions in all of them.
    pruned: AtomicU64,
    kept: AtomicU64,
}

#[derive(Debug)]
struct Cell {
    /// Whether the field is known to be above zero wherever the cell's tape holds and there is a value.
    is_free: bool,
    /// Free cells may have none yet: most of them are passed, and theirs are long.
    own: OnceLock<Own>,
    parts: Parts,
}

/// Made when they are asked for.
type Parts = [OnceLock<Box<Cell>>; PARTS];

/// The tape of a cell.
#[derive(Debug)]
struct Own {
    tape: Arc<Tape>,
    /// Work in the tape.
    work: u64,
    /// How often its ancestors were cut, and how often in vain, one after the other.
    cuts: u32,
    vain: u32,
    /// Whether it is worth cutting.
    is_open: bool,
    /// Whether most of its parts are free, or gain.
    is_sparse: OnceLock<bool>,
}

/// The cells that a search for a smaller one goes through.
#[derive(Clone, Copy, PartialEq)]
enum Through {
    All,
    /// Those that are not free.
    Occupied,
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
        let defined = Defined::within(&tape, region);
        Cells { defined, ..Cells::undivided(tape) }.divided(region)
    }

    /// The same cut into cells.
    fn divided(self, region: &[Interval; 3]) -> Cells {
        let is_uniform = !self.whole.is_open;
        let centre = region.map(|r| r.mid());
        // A hair more, so that what is cut as the cells are fits into them.
        let half = (1.0 + 1e-8) * region.iter().map(|r| r.rad()).fold(0.0, f64::max);
        Cells { is_uniform, centre, half, ..self }
    }

    /// New cells of the same region, for a tape that has a value wherever this one has.
    pub fn again(&self, tape: Arc<Tape>, region: &[Interval; 3], wanted: Wanted) -> Cells {
        Cells { defined: self.defined, wanted, ..Cells::undivided(tape) }.divided(region)
    }

    /// The same for who wants no more of the field than on which side of zero it is, and what it is close to that; tapes of
    /// other cells may differ elsewhere.
    pub fn of_sides(tape: Arc<Tape>, region: &[Interval; 3]) -> Cells {
        Cells { wanted: Wanted::Sides, ..Cells::new(tape, region) }
    }

    /// The same with no cells that are smaller than to hold all within `reach` of a place in them: for many questions that
    /// are about as far apart, which would each have cells of their own made.
    pub fn no_smaller(self, reach: f64) -> Cells {
        Cells { least: reach, ..self }
    }

    /// All of space as one cell.
    pub fn undivided(tape: Arc<Tape>) -> Cells {
        let work = tape.work();
        Cells {
            whole: Own::new(tape, work, [0, 0]),
            parts: Default::default(),
            centre: [0.0; 3],
            half: 0.0,
            least: 0.0,
            wanted: Wanted::Values,
            is_uniform: true,
            defined: None,
            pruned: AtomicU64::new(0),
            kept: AtomicU64::new(0),
        }
    }

    /// These cells if their tapes keep all values, else such cells of the same region.
    pub fn of_values(self: &Arc<Cells>, region: &[Interval; 3]) -> Arc<Cells> {
        match self.wanted {
            Wanted::Values => self.clone(),
            Wanted::Sides => Arc::new(self.again(self.tape().clone(), region, Wanted::Values)),
        }
    }

    /// The whole tape.
    pub fn tape(&self) -> &Arc<Tape> {
        &self.whole.tape
    }

    /// Whether there is one tape for all places.
    pub fn is_uniform(&self) -> bool {
        self.is_uniform
    }

    /// Whether the field is known to have a value everywhere in the region.
    pub fn is_defined(&self) -> bool {
        self.defined.is_some_and(|defined| defined.hollow().is_none())
    }

    /// Whether the field is known to have a value everywhere in a part of the region: always if it has one in all of it, and
    /// without another evaluation.
    pub fn is_defined_in(&self, part: &[Interval; 3]) -> bool {
        self.defined.is_some_and(|defined| defined.hollow().is_none() || defined.holds(part))
    }

    /// The same of all within `reach` of a place along every axis.
    pub fn is_defined_around(&self, at: [f64; 3], reach: f64) -> bool {
        self.is_defined_in(&at.map(|x| Interval::around(x, reach)))
    }

    /// Whether the field may be torn in the region: it may jump, or have a pole or no value somewhere. What is made of
    /// something that has a pole may jump there and be bounded all the same.
    pub fn is_torn(&self) -> bool {
        !self.is_defined() || self.tape().class() == Class::Jump
    }

    /// What pruning has gained so far.
    pub fn prunings(&self) -> Prunings {
        Prunings {
            tapes: self.pruned.load(Ordering::Relaxed),
            instructions: self.kept.load(Ordering::Relaxed),
            whole: self.whole.tape.len() as u64,
        }
    }

    /// A tape that equals the whole one within `reach` of a place along every axis, as far as it is wanted to.
    pub fn tape_around(&self, at: [f64; 3], reach: f64) -> &Arc<Tape> {
        let own = self.descend(at, reach, Through::All);
        &own.unwrap_or(&self.whole).tape
    }

    /// That tape and how much [work](Tape::work) it is, or nothing where there is known to be no solid.
    pub fn occupied_around(&self, at: [f64; 3], reach: f64) -> Option<(&Arc<Tape>, u64)> {
        let own = self.descend(at, reach, Through::Occupied)?;
        Some((&own.tape, own.work))
    }

    /// The own tape of the smallest cell that has all within `reach` of a place; nothing where the way there ends at one
    /// that is free.
    fn descend(&self, at: [f64; 3], reach: f64, through: Through) -> Option<&Own> {
        let (mut own, mut parts) = (&self.whole, &self.parts);
        let (mut centre, mut half) = (self.centre, self.half);
        let off = (0..3).map(|axis| (at[axis] - centre[axis]).abs()).fold(0.0, f64::max);
        let is_within = off <= half;
        if self.is_uniform || !is_within {
            return Some(own);
        }
        for _ in 0..CUTS {
            let quarter = 0.5 * half;
            // The cell reaches a whole `half` of its child beyond the child's faces.
            let fits = reach.max(self.least) <= quarter * (1.0 - 1e-9);
            if !fits || !own.is_open {
                break;
            }
            let index: usize = (0..3).map(|axis| usize::from(at[axis] >= centre[axis]) << axis).sum();
            let all = Regions { centre, half };
            let cell = parts[index].get_or_init(|| Box::new(self.part(own, all, index, through)));
            if cell.is_free && through == Through::Occupied {
                return None;
            }
            own = cell
                .own
                .get_or_init(|| self.cut(own, all, own.tape.bound(&all.of(index)).pruned(self.wanted)));
            (parts, centre, half) = (&cell.parts, all.middle(index), quarter);
        }
        Some(own)
    }

    /// A part of a cell.
    fn part(&self, own: &Own, all: Regions, index: usize, through: Through) -> Cell {
        let bounded = own.tape.bound(&all.of(index));
        let is_free = self.is_free(&bounded);
        let is_passed = is_free && through == Through::Occupied;
        let own =
            if is_passed { OnceLock::new() } else { self.cut(own, all, bounded.pruned(self.wanted)).into() };
        Cell { is_free, own, parts: Default::default() }
    }

    fn is_free(&self, bounded: &Bounded) -> bool {
        bounded.range().lo > 0.0 || (!self.is_defined() && bounded.is_nowhere())
    }

    /// What one of all parts of a cell has, of which this is left.
    fn cut(&self, own: &Own, all: Regions, left: Tape) -> Own {
        self.pruned.fetch_add(1, Ordering::Relaxed);
        self.kept.fetch_add(left.len() as u64, Ordering::Relaxed);
        let less = left.work();
        if own.gains(less) {
            return Own::new(Arc::new(left), less, [own.cuts + 1, 0]);
        }
        // One that is hardly less work is not worth its memory.
        let is_asked = own.work == self.whole.work && own.vain <= ASKED;
        let counts = u32::from(!(is_asked && self.is_sparse(own, all)));
        Own::new(own.tape.clone(), own.work, [own.cuts + counts, own.vain + counts])
    }

    /// Whether most of all parts of a cell are free, or gain.
    fn is_sparse(&self, own: &Own, all: Regions) -> bool {
        let is_easier = |index: &usize| {
            let bounded = own.tape.bound(&all.of(*index));
            self.is_free(&bounded) || own.gains(bounded.pruned(self.wanted).work())
        };
        *own.is_sparse.get_or_init(|| (0..PARTS).filter(is_easier).take(EASIER).count() == EASIER)
    }
}

/// The parts of a cell.
#[derive(Clone, Copy)]
struct Regions {
    /// Of the cell.
    centre: [f64; 3],
    half: f64,
}

impl Regions {
    /// The middle of a part.
    fn middle(&self, index: usize) -> [f64; 3] {
        let quarter = 0.5 * self.half;
        std::array::from_fn(|axis| {
            self.centre[axis] + if index >> axis & 1 == 1 { quarter } else { -quarter }
        })
    }

    /// Where the tape of a part holds.
    fn of(&self, index: usize) -> [Interval; 3] {
        self.middle(index).map(|c| Interval::around(c, self.half))
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

impl Own {
    fn new(tape: Arc<Tape>, work: u64, [cuts, vain]: [u32; 2]) -> Own {
        let is_open = vain < PATIENCE && cuts < DEEPEST && work >= SHORT && tape.has_choices();
        Own { tape, work, cuts, vain, is_open, is_sparse: OnceLock::new() }
    }

    /// Whether so much work is enough less.
    fn gains(&self, less: u64) -> bool {
        less as f64 <= GAIN * self.work as f64
    }
}
