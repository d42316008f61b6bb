//! Small cells that lead places inside to where the solid is thick.
//!
//! Rays come to the surface in places next to one another, and one evaluation says much about all places of a cell. Let
//! `f`, `g` and `H` be the field and its derivatives in the middle of a ball around the cell, in units of the ball, and `v`
//! a place of the cell that is inside. With `d = -(g + H v) / |g + H v|` and `b = d^T H d`, if for a step `t > 0`
//!
//! ```text
//! |g + H v| - t max(b, 0) - turn_1 > 0       the field falls along d from v on,
//! |v + t d| < 1                              and all that lies in the ball,
//! the field has a value all over the ball    since what is undefined is empty,
//! ```
//!
//! then `v` is joined, along `d`, with `v + t d`, which is inside as well, and farther below zero. So an expansion leads
//! every place of its cell on, each on a way of its own, without another evaluation. Where one is too rough for
//! a step worth the name, that of a smaller cell is tried; after a step, that of the next larger one.
//!
//! From a ball that is all inside, all places go on alike: from a *knot*, a corner of the cell that it shares with seven
//! others. A knot leads to the next, down to where largest cells are all inside, or into hollows where nothing leads on.
//! That is where lines and paths begin, once for all chains that end in a knot. Where a chain ends follows from where it
//! begins, whoever went there before.

use super::super::matrix::matrix;
use super::super::search::{Balls, LANES};
use super::cache::Cache;
use super::grid::{Grid, Voxel};
use super::{Answer, Core};
use crate::num::Taylor;
use ahash::{HashSet, RandomState};
use glam::DVec3;
use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};

/// The size of a cell as a share of its ball, in which its corners are, too.
const SHARE: f64 = 0.99;

/// The shortest step to where the field may not fall any more, as a share of the ball. (To its rim, behind which other cells
/// lead on, it may be shorter.)
const STEP: f64 = 0.1;

/// The share of the slope that must be left for certain: by that a step falls far more than what is rounded of a place.
const SURE: f64 = 1e-3;

/// Steps from a place to a ball that is all inside, until it is left where it is.
const STEPS: u32 = 50;

/// Cells to a voxel along each axis, as powers of two: of the largest, and of the smallest,
const LEVELS: [u32; 2] = [2, 6];

/// and of those that hollows are named after.
const HOLLOWS: u32 = 5;

/// Which cell: how often voxels are halved for it, and where it is.
type Key = (u32, Voxel);

/// The field of a solid, and its core.
type Solid<'a> = (&'a mut Balls, &'a Core);

/// Something about each of many cells, or knots.
type Map<K, T> = HashMap<K, T, RandomState>;

/// A place at which chains meet.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
enum Knot {
    /// A corner of cells, by the one above it.
    Corner(Key),
    /// The middle of a cell that has the lowest place of a hollow in it.
    Hollow(Key),
}

/// What is known of a cell.
#[derive(Clone, Copy, Debug)]
enum Patch {
    /// Nothing.
    Blind,
    /// Its ball, the field in that, and whether all of it is inside.
    Known((DVec3, f64), Taylor, bool),
}

/// What a place leads to.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Next {
    /// It is in the core.
    Joined,
    /// A place at which chains meet.
    Knot(Knot),
    /// Nothing leads on from here.
    Nowhere(DVec3),
}

impl Knot {
    fn level(self) -> u32 {
        let (Knot::Corner((level, _)) | Knot::Hollow((level, _))) = self;
        level
    }

    /// Whether it may lead to another. Those of largest cells do not, nor do hollows.
    fn leads_on(self) -> bool {
        matches!(self, Knot::Corner((level, _)) if level > LEVELS[0])
    }
}

impl Next {
    fn knot(self) -> Option<Knot> {
        if let Next::Knot(knot) = self { Some(knot) } else { None }
    }

    fn nowhere(self) -> Option<DVec3> {
        if let Next::Nowhere(at) = self { Some(at) } else { None }
    }
}

/// A place on its way to the next knot.
struct Chase {
    index: usize,
    at: DVec3,
    /// The level of cells to try first.
    level: u32,
    /// The knot that it begins at.
    knot: Option<Knot>,
    steps: u32,
}

impl Chase {
    fn from_place(index: usize, at: DVec3) -> Chase {
        Chase { index, at, level: LEVELS[0], knot: None, steps: 0 }
    }

    fn from_knot(index: usize, knot: Knot, at: DVec3) -> Chase {
        Chase { index, at, level: knot.level() - 1, knot: Some(knot), steps: 0 }
    }
}

/// What a look at what is known comes to.
enum Look {
    Next(Next),
    /// Something is to be found out about a cell.
    Ask(Key),
}

/// What is known of knots that chains end in.
#[derive(Debug)]
pub struct Patches {
    ends: Cache<Knot, Answer>,
    voxels: Grid,
}

impl Patches {
    /// For cells of these voxels; so many answers are remembered.
    pub fn new(voxels: Grid, capacity: usize) -> Patches {
        Patches { ends: Cache::new(capacity), voxels }
    }

    /// Another picture begins.
    pub fn turn(&self) {
        self.ends.turn();
    }

    /// The answers for places inside, of which `exact` knows those for the ends of chains, unless it was broken off.
    pub fn answers(
        &self,
        solid: Solid<'_>,
        points: &[DVec3],
        cancel: &AtomicBool,
        exact: impl FnOnce(&[DVec3]) -> Option<Vec<Answer>>,
    ) -> Vec<Answer> {
        let ends = self.ends(solid, points, cancel);
        if cancel.load(Ordering::Relaxed) {
            return vec![Answer::Unknown; points.len()];
        }
        // Many chains end in one knot.
        let (mut known, mut open) = (Map::<Knot, Answer>::default(), Vec::new());
        for knot in ends.iter().filter_map(|end| end.knot()) {
            known.entry(knot).or_insert_with(|| {
                self.ends.get(&knot).unwrap_or_else(|| {
                    open.push(knot);
                    Answer::Unknown
                })
            });
        }
        let alone = ends.iter().filter_map(|end| end.nowhere());
        let places: Vec<DVec3> = open.iter().map(|knot| self.place(*knot)).chain(alone).collect();
        let Some(found) = exact(&places) else { return vec![Answer::Unknown; points.len()] };
        let (of_knots, alone) = found.split_at(open.len());
        for (knot, answer) in open.into_iter().zip(of_knots) {
            known.insert(knot, self.learn(knot, *answer));
        }
        let mut alone = alone.iter().copied();
        let mut answer = |end: Next| match end {
            Next::Joined => Some(Answer::Joined),
            Next::Knot(knot) => known.get(&knot).copied(),
            Next::Nowhere(_) => alone.next(),
        };
        ends.into_iter().map(|end| answer(end).unwrap_or(Answer::Unknown)).collect()
    }

    /// Remembers an answer, or what is proven; returns that.
    fn learn(&self, knot: Knot, answer: Answer) -> Answer {
        self.ends.update(knot, |old| answer.unless_proven(old))
    }

    /// Where chains from some places end.
    fn ends(&self, (field, core): Solid<'_>, points: &[DVec3], cancel: &AtomicBool) -> Vec<Next> {
        let mut cells = Map::with_capacity_and_hasher(points.len(), RandomState::default());
        let mut run = |starts: Vec<Chase>| self.run((field, core), starts, &mut cells, cancel);
        let first = run(points.iter().enumerate().map(|(i, at)| Chase::from_place(i, *at)).collect());
        let (mut knots, mut next) = (Map::<Knot, Next>::default(), first.clone());
        loop {
            let mut fresh = Vec::new();
            for knot in next.iter().filter_map(|next| next.knot()) {
                knots.entry(knot).or_insert_with(|| {
                    fresh.push(knot);
                    Next::Knot(knot)
                });
            }
            fresh.retain(|knot| knot.leads_on());
            if fresh.is_empty() || cancel.load(Ordering::Relaxed) {
                break;
            }
            let start = |(i, knot): (usize, &Knot)| Chase::from_knot(i, *knot, self.place(*knot));
            next = run(fresh.iter().enumerate().map(start).collect());
            knots.extend(fresh.into_iter().zip(next.iter().copied()));
        }
        let mut last = Map::<Knot, Next>::default();
        let mut end = |next: Next| match next {
            Next::Knot(knot) => *last.entry(knot).or_insert_with(|| last_of(knot, &knots)),
            _ => next,
        };
        first.into_iter().map(&mut end).collect()
    }

    /// Sends places on until each has come to the next knot, or to its end; once it is cancelled, it says nothing.
    fn run(
        &self,
        (field, core): Solid<'_>,
        mut active: Vec<Chase>,
        cells: &mut Map<Key, Patch>,
        cancel: &AtomicBool,
    ) -> Vec<Next> {
        let mut next = vec![Next::Joined; active.len()];
        while !(active.is_empty() || cancel.load(Ordering::Relaxed)) {
            let mut wanted = Vec::new();
            active.retain_mut(|chase| match self.look(core, chase, cells) {
                Look::Next(found) => {
                    next[chase.index] = found;
                    false
                }
                Look::Ask(key) => {
                    wanted.push(key);
                    true
                }
            });
            self.find(field, wanted, cells);
        }
        next
    }

    /// Sends a place on as far as cells are known.
    fn look(&self, core: &Core, chase: &mut Chase, cells: &Map<Key, Patch>) -> Look {
        'steps: while chase.steps < STEPS {
            if core.holds(chase.at) {
                return Look::Next(Next::Joined);
            }
            for level in chase.level..=LEVELS[1] {
                let key = (level, self.voxels.halved(level).voxel(chase.at));
                let ((centre, radius), f, is_full) = match cells.get(&key) {
                    None => {
                        // Cells before this one have nothing to say.
                        chase.level = level;
                        return Look::Ask(key);
                    }
                    Some(Patch::Blind) => continue,
                    Some(Patch::Known(ball, f, is_full)) => (*ball, f, *is_full),
                };
                let knot = is_full.then(|| self.corner(key));
                // One goes on to no smaller cells: from these it would only come back.
                let is_news =
                    |knot: &Knot| chase.knot.is_none_or(|own| own != *knot && own.level() >= knot.level());
                if let Some(knot) = knot.filter(is_news) {
                    return Look::Next(Next::Knot(knot));
                }
                if let Some(u) = leads(f, (chase.at - centre) / radius, is_full) {
                    chase.at = centre + radius * u;
                    chase.level = (level - 1).max(LEVELS[0]);
                    chase.steps += 1;
                    continue 'steps;
                }
                if is_full {
                    let hollow = self.hollow(key, f).or(chase.knot);
                    return Look::Next(hollow.map_or(Next::Nowhere(chase.at), Next::Knot));
                }
            }
            break;
        }
        Look::Next(chase.knot.map_or(Next::Nowhere(chase.at), Next::Knot))
    }

    /// The knot of a cell that is all inside: the one of its corners of which all numbers are even.
    fn corner(&self, (level, Voxel(cell)): Key) -> Knot {
        Knot::Corner((level, Voxel(cell.map(|i| i + (i & 1)))))
    }

    /// The knot about the lowest place of a ball that is all inside.
    fn hollow(&self, key: Key, f: &Taylor) -> Option<Knot> {
        let (centre, radius) = self.ball(key);
        let hollow = (HOLLOWS, self.voxels.halved(HOLLOWS).voxel(centre + radius * lowest(f)?));
        let knot = Knot::Hollow(hollow);
        (self.place(knot).distance(centre) < radius * DEEPEST).then_some(knot)
    }

    /// Where a knot is.
    fn place(&self, knot: Knot) -> DVec3 {
        match knot {
            Knot::Corner((level, Voxel(node))) => self.voxels.halved(level).corner(node),
            Knot::Hollow((level, cell)) => self.voxels.halved(level).middle(cell),
        }
    }

    /// The ball that is looked at for a cell.
    fn ball(&self, (level, cell): Key) -> (DVec3, f64) {
        let (centre, radius) = self.voxels.halved(level).ball(cell);
        (centre, radius / SHARE)
    }

    /// Finds out about cells, in the order in which they were asked for: places that are asked about one after the other
    /// are next to one another, and so balls have more in common.
    fn find(&self, field: &mut Balls, mut wanted: Vec<Key>, cells: &mut Map<Key, Patch>) {
        let mut seen = HashSet::default();
        wanted.retain(|key| seen.insert(*key));
        for keys in wanted.chunks(LANES) {
            let balls: Vec<(DVec3, f64)> = keys.iter().map(|key| self.ball(*key)).collect();
            let values = *field.eval(balls.iter().copied());
            for (i, (key, ball)) in keys.iter().zip(balls).enumerate() {
                let value = values.lane(i);
                let is_known = field.is_within(ball.0, ball.1) && field.is_defined_around(ball.0, ball.1);
                let is_full = value.range.hi < 0.0;
                cells.insert(*key, if is_known { Patch::Known(ball, value, is_full) } else { Patch::Blind });
            }
        }
    }
}

/// Where knots lead to in the end: of a ring, to the first in order, wherever it is entered.
fn last_of(mut knot: Knot, knots: &Map<Knot, Next>) -> Next {
    let mut trail = vec![knot];
    while let Some(next) = knots.get(&knot) {
        let Some(onward) = next.knot() else { return *next };
        if let Some(first) = trail.iter().position(|own| *own == onward) {
            knot = trail[first..].iter().copied().min().unwrap_or(onward);
            break;
        }
        trail.push(onward);
        knot = onward;
    }
    Next::Knot(knot)
}

/// Where a field is lowest in a ball, in units of it, if its expansion has such a place.
fn lowest(f: &Taylor) -> Option<DVec3> {
    let hessian = matrix(f.hess);
    let vertex = -(hessian.inverse() * DVec3::from_array(f.grad));
    (vertex.length() < DEEPEST && vertex.dot(hessian * vertex) > 0.0).then_some(vertex)
}

/// How far a step leads from the middle of a ball at most, as a share of it.
const DEEPEST: f64 = 0.9999;

/// Where a place leads to that is inside, in units of the ball; if nowhere, it may be next to the lowest place, or
/// the ball is too rough. Where the ball is all inside, it does not matter whether the field falls all the way.
fn leads(f: &Taylor, v: DVec3, is_full: bool) -> Option<DVec3> {
    let hessian = matrix(f.hess);
    let g = DVec3::from_array(f.grad) + hessian * v;
    let slope = g.length();
    let down = -g / slope;
    let bend = down.dot(hessian * down);
    let rounding = 1e-7 * (f.value.abs() + slope + f.curvature());
    let steady = if is_full { slope } else { slope - f.turn[1] - rounding };
    let along = v.dot(down);
    let rim = (along * along + DEEPEST * DEEPEST - v.length_squared()).sqrt() - along;
    let falls = if bend > 0.0 { steady / bend * (1.0 - 1e-9) } else { f64::INFINITY };
    (steady > SURE * slope && falls > STEP && rim > 0.0).then(|| v + rim.min(falls) * down)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Graph;
    use crate::num::Interval;
    use crate::op::{Mul, Op, Sin, Sub};
    use crate::tape::{Evaluator, Tape};
    use std::sync::Arc;

    /// `sin(x) sin(2 y) - z sin(z)`: it bends to all sides.
    fn waves() -> Arc<Tape> {
        let mut graph = Graph::default();
        let [x, y, z] = graph.point().unwrap();
        let two = graph.constant(2.0).unwrap();
        let y = graph.op(Op::Mul(Mul), &[y, two]).unwrap();
        let [a, b, c] = [x, y, z].map(|input| graph.op(Op::Sin(Sin), &[input]).unwrap());
        let ab = graph.op(Op::Mul(Mul), &[a, b]).unwrap();
        let zc = graph.op(Op::Mul(Mul), &[z, c]).unwrap();
        let field = graph.op(Op::Sub(Sub), &[ab, zc]).unwrap();
        Arc::new(Tape::new(&graph, &[field]))
    }

    #[test]
    fn what_is_proven_of_an_end_stays() {
        let patches = Patches::new(Grid::new(1.0), 10_000);
        let key = Knot::Corner((LEVELS[0], Voxel([0, 0, 0])));
        assert_eq!(patches.learn(key, Answer::Apart), Answer::Apart);
        assert_eq!(patches.learn(key, Answer::Joined), Answer::Joined);
        assert_eq!(patches.learn(key, Answer::Unknown), Answer::Joined);
        assert_eq!(patches.ends.get(&key), Some(Answer::Joined));
    }

    #[test]
    fn a_knot_is_in_the_balls_of_its_eight_cells() {
        let patches = Patches::new(Grid::new(2.5e-5), 10);
        for i in 0..1000 {
            let p = DVec3::new(0.7, -0.5, 0.51) + 1e-6 * f64::from(i) * DVec3::new(1.0, 0.7, -1.3);
            let level = LEVELS[0] + i as u32 % 5;
            let key = (level, patches.voxels.halved(level).voxel(p));
            let knot = patches.corner(key);
            let (place, edge) = (patches.place(knot), patches.voxels.halved(level).size());
            for corner in 0..8 {
                let beside = DVec3::from_array([0, 1, 2].map(|axis| f64::from(corner >> axis & 1) - 0.5));
                let cell = (level, patches.voxels.halved(level).voxel(place + edge * beside));
                let (centre, radius) = patches.ball(cell);
                assert_eq!(patches.corner(cell), knot);
                assert!(place.distance(centre) < radius);
            }
        }
    }

    #[test]
    fn chains_end_where_they_end_alone() {
        let tape = waves();
        let (mut balls, core) = (Balls::new(&tape), Core { centre: DVec3::splat(9.0), radius: 0.1 });
        let mut values = Evaluator::<Interval>::new(tape.clone());
        for size in [0.3, 1.0, 3.0] {
            let patches = Patches::new(Grid::new(size), 10_000);
            let places = (0..3000)
                .map(f64::from)
                .map(|i| 2.0 * DVec3::new(libm::sin(1.1 * i), libm::cos(1.7 * i), libm::sin(0.3 * i + 1.0)));
            let inside: Vec<DVec3> =
                places.filter(|p| values.eval(&p.to_array().map(Interval::point)).hi < 0.0).collect();
            let never = AtomicBool::new(false);
            let together = patches.ends((&mut balls, &core), &inside, &never);
            let knots = together.iter().filter(|end| end.knot().is_some()).count();
            assert!(3 * knots > 2 * inside.len(), "{knots} of {}", inside.len());
            for (p, end) in inside.iter().zip(together) {
                assert_eq!(patches.ends((&mut balls, &core), &[*p], &never), [end], "{p}");
            }
        }
    }

    #[test]
    fn a_ring_of_knots_ends_alike_wherever_it_is_entered() {
        let corner = |i: i64| Knot::Corner((3, Voxel([i, 0, 0])));
        let leads = [(1, 5), (5, 4), (4, 7), (7, 5), (2, 2), (3, 2)];
        let knots: Map<Knot, Next> =
            leads.into_iter().map(|(from, to)| (corner(from), Next::Knot(corner(to)))).collect();
        for (from, to) in [(1, 4), (5, 4), (4, 4), (7, 4), (2, 2), (3, 2)] {
            assert_eq!(last_of(corner(from), &knots), Next::Knot(corner(to)));
        }
    }

    #[test]
    fn a_place_inside_is_joined_with_where_it_is_led() {
        let tape = waves();
        let (mut balls, mut values) = (Balls::new(&tape), Evaluator::<Interval>::new(tape.clone()));
        let mut value = |p: DVec3| *values.eval(&p.to_array().map(Interval::point));
        let mut state = 7_u64;
        let mut inside = |low: f64, high: f64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            low + (high - low) * (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut found = [0, 0];
        for _ in 0..12_000 {
            let centre = DVec3::new(inside(-3.0, 3.0), inside(-3.0, 3.0), inside(-3.0, 3.0));
            let radius = inside(0.02, 0.6);
            let f = balls.eval([(centre, radius)].into_iter()).lane(0);
            for _ in 0..10 {
                let v = DVec3::new(inside(-1.0, 1.0), inside(-1.0, 1.0), inside(-1.0, 1.0));
                let p = centre + radius * v;
                if v.length() > 1.0 || value(p).hi >= 0.0 {
                    continue;
                }
                let is_full = f.range.hi < 0.0;
                let Some(u) = leads(&f, v, is_full) else { continue };
                assert!(u.length() < 1.0, "{u}");
                found[usize::from(is_full)] += 1;
                let mut before = value(p).hi;
                for k in 1..=20 {
                    let here = value(p.lerp(centre + radius * u, f64::from(k) / 20.0));
                    assert!(here.lo < if is_full { 0.0 } else { before }, "{centre} {radius} {v}");
                    before = here.hi;
                }
            }
        }
        assert!(found.iter().all(|n| *n > 3000), "{found:?}");
    }
}
