//! Small cells of which all that is inside leads to one place.
//!
//! Rays come to the surface in places next to one another, and most of what lines and paths find out is the same for
//! all of a cell. Let `d = -g / |g|` in the middle `c` of a ball, and a cell lie in `SHARE` times the ball, `u` in
//! units of the ball. If
//!
//! ```text
//! |g| > turn_0                                   the field falls along d everywhere in the ball
//! f - DEPTH |g| + bow_0 < 0                      and is below zero all over a disc of radius SHARE at DEPTH d
//! SHARE^2 + DEPTH^2 < 1                          which lies in the ball
//! the field has a value all over the ball        since what is undefined is empty
//! ```
//!
//! then every place of the cell that is inside is joined, along `d`, with the middle of the disc: one evaluation
//! answers for all of them. Where a cell is too rough for that, those of a finer grid are tried. From the place that
//! a cell leads to another leads on, so that chains of cells come down to where the solid is thick, or into hollows
//! where nothing leads on; that is where lines and paths begin, once for all cells of a chain. Where a chain ends
//! follows from where it begins, whoever went there before.

use super::super::search::{Balls, LANES};
use super::cache::Cache;
use super::grid::{Grid, Voxel};
use super::{Answer, Core};
use crate::num::Taylor;
use ahash::RandomState;
use glam::DVec3;
use std::collections::{BTreeSet, HashMap};

/// The size of a cell as a share of its ball, and how far the disc is from the middle.
const SHARE: f64 = 0.4;
const DEPTH: f64 = 0.916;

/// Cells to a voxel along each axis, as powers of two: of the largest, and of the smallest.
const LEVELS: [u32; 2] = [2, 6];

/// Which cell: how often voxels are halved for it, and where it is.
type Key = (u32, Voxel);

/// What is known of cells near some places that are asked about together: most of them come to the same ones.
type Memo = HashMap<Key, Patch, RandomState>;

/// What is known of a cell.
#[derive(Clone, Copy, Debug)]
enum Patch {
    /// Nothing; those in it may be known.
    Rough,
    /// What is inside leads to this place.
    Leads(DVec3),
    /// The same, and all about that place is inside.
    Thick(DVec3),
    /// What is inside is all alike.
    Known(Answer),
}

/// Cells, and what is known of them.
#[derive(Debug)]
pub struct Patches {
    cells: Cache<Key, Patch>,
    size: f64,
}

/// A point on its way along a chain.
struct Chase {
    index: usize,
    at: DVec3,
    trail: Vec<Key>,
}

/// What a look at what is known comes to.
enum Look {
    Answer(Answer),
    /// The chain ends here.
    End,
    /// Something is to be found out about a cell.
    Ask(Key),
}

impl Patches {
    /// For voxels of this size; so many cells are remembered.
    pub fn new(size: f64, capacity: usize) -> Patches {
        Patches { cells: Cache::new(capacity), size }
    }

    /// Another picture begins.
    pub fn turn(&self) {
        self.cells.turn();
    }

    /// The answers for places inside, of which `exact` knows those for the ends of chains, unless it was broken off.
    pub fn answers(
        &self,
        field: &mut Balls,
        core: &Core,
        points: &[DVec3],
        exact: impl FnOnce(&[DVec3]) -> Option<Vec<Answer>>,
    ) -> Vec<Answer> {
        let mut answers = vec![Answer::Unknown; points.len()];
        let start = |(index, at): (usize, &DVec3)| Chase { index, at: *at, trail: Vec::new() };
        let mut active: Vec<Chase> = points.iter().enumerate().map(start).collect();
        let mut ended: Vec<Chase> = Vec::new();
        let mut memo = Memo::default();
        while !active.is_empty() {
            let mut wanted = BTreeSet::new();
            let mut next = Vec::with_capacity(active.len());
            for mut chase in active {
                match self.look(core, &mut chase, &mut memo) {
                    Look::Answer(answer) => {
                        answers[chase.index] = answer;
                        self.learn(&chase.trail, answer, &mut memo);
                    }
                    Look::End => ended.push(chase),
                    Look::Ask(key) => {
                        wanted.insert(key);
                        next.push(chase);
                    }
                }
            }
            self.find(field, wanted);
            active = next;
        }
        // Many chains end in one place.
        ended.sort_by(|a, b| a.at.to_array().map(f64::to_bits).cmp(&b.at.to_array().map(f64::to_bits)));
        let groups: Vec<&[Chase]> = ended.chunk_by(|a, b| a.at == b.at).collect();
        let places: Vec<DVec3> = groups.iter().map(|group| group[0].at).collect();
        let found = exact(&places).unwrap_or_default();
        for (group, answer) in groups.into_iter().zip(found) {
            for chase in group {
                answers[chase.index] = answer;
                self.learn(&chase.trail, answer, &mut memo);
            }
        }
        answers
    }

    /// Follows a chain as far as it is known.
    fn look(&self, core: &Core, chase: &mut Chase, memo: &mut Memo) -> Look {
        'chain: loop {
            if core.holds(chase.at) {
                return Look::Answer(Answer::Joined);
            }
            for level in LEVELS[0]..=LEVELS[1] {
                let key = (level, self.grid(level).voxel(chase.at));
                match self.known(key, memo) {
                    None => return Look::Ask(key),
                    Some(Patch::Rough) => {}
                    Some(Patch::Known(answer)) => return Look::Answer(answer),
                    Some(Patch::Thick(at)) => {
                        chase.trail.push(key);
                        chase.at = at;
                        return Look::End;
                    }
                    Some(Patch::Leads(at)) => {
                        if let Some(first) = chase.trail.iter().position(|k| *k == key) {
                            match first_of(&chase.trail[first..], memo) {
                                Some(Patch::Known(answer)) => return Look::Answer(answer),
                                Some(Patch::Leads(at) | Patch::Thick(at)) => chase.at = at,
                                Some(Patch::Rough) | None => chase.at = at,
                            }
                            return Look::End;
                        }
                        chase.trail.push(key);
                        chase.at = at;
                        continue 'chain;
                    }
                }
            }
            return Look::End;
        }
    }

    fn learn(&self, trail: &[Key], answer: Answer, memo: &mut Memo) {
        for key in trail {
            self.cells.insert(*key, Patch::Known(answer));
            memo.insert(*key, Patch::Known(answer));
        }
    }

    fn known(&self, key: Key, memo: &mut Memo) -> Option<Patch> {
        if let Some(patch) = memo.get(&key) {
            return Some(*patch);
        }
        let patch = self.cells.get(&key)?;
        memo.insert(key, patch);
        Some(patch)
    }

    fn grid(&self, level: u32) -> Grid {
        Grid::new(libm::ldexp(self.size, -(level as i32)))
    }

    /// Finds out about cells.
    fn find(&self, field: &mut Balls, wanted: BTreeSet<Key>) {
        let wanted: Vec<Key> = wanted.into_iter().collect();
        for keys in wanted.chunks(LANES) {
            let ball = |&(level, cell): &Key| {
                let (centre, radius) = self.grid(level).ball(cell);
                (centre, radius / SHARE)
            };
            let values = *field.eval(keys.iter().map(ball));
            for (i, key) in keys.iter().enumerate() {
                let (centre, radius) = ball(key);
                let way = leads(&values.lane(i)).filter(|_| field.is_defined_around(centre, radius));
                let patch = way.map_or(Patch::Rough, |(u, thick)| {
                    let at = centre + radius * u;
                    if thick && key.0 == LEVELS[0] { Patch::Thick(at) } else { Patch::Leads(at) }
                });
                self.cells.insert(*key, patch);
            }
        }
    }
}

/// What is known of the first cell of a ring: the same wherever the ring was entered.
fn first_of(ring: &[Key], memo: &Memo) -> Option<Patch> {
    memo.get(ring.iter().min()?).copied()
}

/// Where all of a cell leads to, in units of its ball, and whether the ball is all inside.
fn leads(f: &Taylor) -> Option<(DVec3, bool)> {
    let g = DVec3::from_array(f.grad);
    let slope = g.length();
    let down = -g / slope;
    if f.range.hi < 0.0 {
        return Some((if down.is_finite() { DEPTH * down } else { DVec3::ZERO }, true));
    }
    let falls = slope * (1.0 - 1e-9) > f.turn[0];
    let deep = f.value - DEPTH * slope * (1.0 - 1e-9) + f.bow[0] * (1.0 + 1e-9) < -1e-12 * f.value.abs();
    (falls && deep).then_some((DEPTH * down, false))
}
