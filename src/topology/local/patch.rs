//! Small cells of which all that is inside leads to one place.
//!
//! Rays come to the surface in places next to one another, and most of what lines and paths find out is the same for
//! all of a cell. Let `d = -g / |g|` in the middle of a ball, and a cell lie in a ball of radius `s`, in units of the
//! first. With `b = d^T H d`, `a = |H d - b d|` and `c` the greatest eigenvalue of `H` across `d`, if for a depth `t > s`
//!
//! ```text
//! |g| - s a - max(t b, -s b) - turn_1 > 0                              the field falls along d within s of the axis, from -s to t,
//! f - t |g| + t^2 b / 2 + t s a + s^2 max(c, 0) / 2 + bow_1 < 0     and is below zero all over a disc of radius s at t d,
//! s^2 + t^2 < 1                                                        which lies in the ball,
//! the field has a value all over the ball                              since what is undefined is empty,
//! ```
//!
//! then every place of the cell that is inside is joined, along `d`, with the middle of the disc: one evaluation
//! answers for all of them. Where a cell is too rough for that, those of a finer grid are tried. From the place that
//! a cell leads to another leads on, so that chains of cells come down to where the solid is thick, or into hollows
//! where nothing leads on; that is where lines and paths begin, once for all cells of a chain. Where a chain ends
//! follows from where it begins, whoever went there before.
//!
//! Small cells are seldom shared by the places that rays come to, as far apart as pixels are. So a place whose largest cell
//! is too rough is looked at by balls around itself, for which `s = 0`. That takes no less work (126 million octaves in a
//! picture of surface (8.11) for 122 with cells alone), but nothing of it is looked up in tables or remembered there.
//!
//! Chains that end in one place save the most. So a ball that is all inside leads to the lowest place in it, if the
//! expansion has one there, and the largest, at which chains end, to a place that they share with those beside them.

use super::super::matrix::matrix;
use super::super::search::{Balls, LANES};
use super::cache::Cache;
use super::grid::{Grid, Voxel};
use super::{Answer, Core};
use crate::num::Taylor;
use ahash::{HashSet, RandomState};
use glam::DVec3;
use std::collections::HashMap;

/// The size of a cell as a share of its ball, and how far the disc is from the middle at most. (A picture of surface (8.11)
/// takes 6.0 million cells with a share of 0.5, 4.4 with 0.6, 3.9 with this; at 0.707 nothing is left of the depth.)
const CELL: Shape = Shape { share: 0.65, depth: 0.7599 };

/// The same of a place alone in the middle of a ball.
const PLACE: Shape = Shape { share: 0.0, depth: 0.9999 };

/// What of a ball leads to one place.
#[derive(Clone, Copy)]
struct Shape {
    share: f64,
    depth: f64,
}

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
    voxels: Grid,
}

/// A point on its way along a chain.
struct Chase {
    index: usize,
    at: DVec3,
    /// The level of cells to try first; at the beginning, of balls around the place, once its largest cell is too rough.
    level: u32,
    begins: bool,
    trail: Vec<Key>,
}

impl Chase {
    fn new(index: usize, at: DVec3) -> Chase {
        Chase { index, at, level: LEVELS[0] + 1, begins: true, trail: Vec::new() }
    }

    /// Goes on to a place that something of this level leads to.
    fn follow(&mut self, at: DVec3, level: u32) {
        self.at = at;
        self.level = (level - 1).max(LEVELS[0]);
        self.begins = false;
    }
}

/// What a look at what is known comes to.
enum Look {
    Answer(Answer),
    /// The chain ends here.
    End,
    /// Something is to be found out about a cell.
    Ask(Key),
    /// And about a ball around the place.
    Around,
}

impl Patches {
    /// For cells of these voxels, of which so many are remembered.
    pub fn new(voxels: Grid, capacity: usize) -> Patches {
        Patches { cells: Cache::new(capacity), voxels }
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
        let mut active: Vec<Chase> = points.iter().enumerate().map(|(i, at)| Chase::new(i, *at)).collect();
        let mut ended: Vec<Chase> = Vec::new();
        let mut memo = Memo::with_capacity_and_hasher(2 * points.len(), RandomState::default());
        while !active.is_empty() {
            let (mut wanted, mut around) = (Vec::new(), Vec::new());
            let mut next = Vec::with_capacity(active.len());
            for mut chase in active {
                match self.look(core, &mut chase, &mut memo) {
                    Look::Answer(answer) => {
                        answers[chase.index] = self.learn(&chase.trail, answer, &mut memo);
                    }
                    Look::End => ended.push(chase),
                    Look::Ask(key) => {
                        wanted.push(key);
                        next.push(chase);
                    }
                    Look::Around => around.push(chase),
                }
            }
            self.find(field, wanted, &mut memo);
            self.look_around(field, &mut around);
            next.append(&mut around);
            active = next;
        }
        // Many chains end in one place.
        ended.sort_by(|a, b| a.at.to_array().map(f64::to_bits).cmp(&b.at.to_array().map(f64::to_bits)));
        let groups: Vec<&[Chase]> = ended.chunk_by(|a, b| a.at == b.at).collect();
        let places: Vec<DVec3> = groups.iter().map(|group| group[0].at).collect();
        let found = exact(&places).unwrap_or_default();
        for (group, answer) in groups.into_iter().zip(found) {
            for chase in group {
                answers[chase.index] = self.learn(&chase.trail, answer, &mut memo);
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
            let levels = if chase.begins { LEVELS[0]..=LEVELS[0] } else { chase.level..=LEVELS[1] };
            for level in levels {
                let key = (level, self.voxels.halved(level).voxel(chase.at));
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
                            chase.at = at;
                            match first_of(&chase.trail[first..], memo) {
                                Some(Patch::Known(answer)) => return Look::Answer(answer),
                                Some(Patch::Leads(first)) => chase.at = first,
                                _ => {}
                            }
                            return Look::End;
                        }
                        chase.trail.push(key);
                        chase.follow(at, level);
                        continue 'chain;
                    }
                }
            }
            return if chase.begins && chase.level <= LEVELS[1] { Look::Around } else { Look::End };
        }
    }

    /// Remembers an answer for all cells of a chain, or what is proven of one of them. Returns that.
    fn learn(&self, trail: &[Key], answer: Answer, memo: &mut Memo) -> Answer {
        let proven = |key: &Key| match self.cells.get(key)? {
            Patch::Known(known) if known.is_proven() => Some(known),
            _ => None,
        };
        let known = if answer.is_proven() { None } else { trail.iter().find_map(proven) };
        let answer = known.unwrap_or(answer);
        for key in trail {
            if matches!(memo.get(key), Some(Patch::Known(known)) if *known == answer) {
                continue;
            }
            let patch = self.cells.update(*key, |old| match old {
                Some(Patch::Known(before)) => Patch::Known(answer.unless_proven(Some(before))),
                _ => Patch::Known(answer),
            });
            memo.insert(*key, patch);
        }
        answer
    }

    fn known(&self, key: Key, memo: &mut Memo) -> Option<Patch> {
        if let Some(patch) = memo.get(&key) {
            return Some(*patch);
        }
        let patch = self.cells.get(&key)?;
        memo.insert(key, patch);
        Some(patch)
    }

    /// The ball that is looked at for a cell.
    fn ball(&self, (level, cell): Key) -> (DVec3, f64) {
        let (centre, radius) = self.voxels.halved(level).ball(cell);
        (centre, radius / CELL.share)
    }

    /// Looks at balls around the places of chains that begin, which go on where they lead, or to smaller ones.
    fn look_around(&self, field: &mut Balls, chases: &mut [Chase]) {
        for batch in chases.chunks_mut(LANES) {
            // As large as those of cells.
            let radius = |level: u32| 0.5 * 3.0_f64.sqrt() * self.voxels.halved(level).size() / CELL.share;
            let balls: Vec<(DVec3, f64)> =
                batch.iter().map(|chase| (chase.at, radius(chase.level))).collect();
            let values = *field.eval(balls.iter().copied());
            for (i, (chase, (centre, radius))) in batch.iter_mut().zip(balls).enumerate() {
                let is_known = field.is_within(centre, radius) && field.is_defined_around(centre, radius);
                match is_known.then(|| leads(&values.lane(i), PLACE)).flatten() {
                    Some(u) => chase.follow(centre + radius * u, chase.level),
                    None => chase.level += 1,
                }
            }
        }
    }

    /// Finds out about cells, in the order in which they were asked for: places that are asked about one after the other
    /// are next to one another, and so balls have more in common. Where a cell leads need not be remembered for others,
    /// since soon it is known what all of its chain comes to.
    fn find(&self, field: &mut Balls, mut wanted: Vec<Key>, memo: &mut Memo) {
        let mut seen = HashSet::default();
        wanted.retain(|key| seen.insert(*key));
        for keys in wanted.chunks(LANES) {
            let values = *field.eval(keys.iter().map(|key| self.ball(*key)));
            for (i, key) in keys.iter().enumerate() {
                let (centre, radius) = self.ball(*key);
                let value = values.lane(i);
                let patch = if !(field.is_within(centre, radius) && field.is_defined_around(centre, radius)) {
                    Patch::Rough
                } else if key.0 == LEVELS[0] && value.range.hi < 0.0 {
                    let wide = self.voxels.halved(LEVELS[0] - 1);
                    let shared = wide.middle(wide.voxel(centre));
                    let is_near = shared.distance(centre) < radius * (1.0 - 1e-9);
                    Patch::Thick(if is_near { shared } else { centre })
                } else {
                    leads(&value, CELL).map_or(Patch::Rough, |u| Patch::Leads(centre + radius * u))
                };
                if let Patch::Rough = patch {
                    // Another thread may know more by now.
                    self.cells.update(*key, |old| old.copied().unwrap_or(patch));
                }
                memo.insert(*key, patch);
            }
        }
    }
}

/// What is known of the first cell of a ring: the same wherever the ring was entered.
fn first_of(ring: &[Key], memo: &Memo) -> Option<Patch> {
    memo.get(ring.iter().min()?).copied()
}

/// Where all of such a shape leads to, in units of its ball.
fn leads(f: &Taylor, Shape { share, depth: deepest }: Shape) -> Option<DVec3> {
    let (g, hessian) = (DVec3::from_array(f.grad), matrix(f.hess));
    let slope = g.length();
    let down = -g / slope;
    if f.range.hi < 0.0 {
        let lowest = -(hessian.inverse() * g);
        let is_lowest = lowest.length() < deepest && lowest.dot(hessian * lowest) > 0.0;
        let at = if is_lowest { lowest } else { deepest * down };
        return Some(if at.is_finite() { at } else { DVec3::ZERO });
    }
    let turned = hessian * down;
    let bend = turned.dot(down);
    let aside = (turned - bend * down).length();
    let rounding = 1e-7 * (f.value.abs() + slope + f.curvature());
    let steady = slope - share * aside - f.turn[1] - rounding;
    let depth = if bend > 0.0 { deepest.min(steady / bend * (1.0 - 1e-9)) } else { deepest };
    let falls = steady + share * bend.min(0.0) > 0.0 && depth > share;
    let highest = f.value
        + depth * (0.5 * depth * bend - slope + share * aside)
        + 0.5 * share * share * across(f.hess, bend, aside).max(0.0)
        + f.bow[1]
        + rounding;
    (falls && highest < 0.0).then_some(depth * down)
}

/// The greatest eigenvalue of a symmetric matrix across a direction, along which it bends by so much and turns aside by
/// so much: of what is left the trace and the squares say it.
fn across([xx, yy, zz, xy, xz, yz]: [f64; 6], bend: f64, aside: f64) -> f64 {
    let trace = xx + yy + zz - bend;
    let squares = xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + xz * xz + yz * yz);
    let squares = squares - bend * bend - 2.0 * aside * aside;
    0.5 * (trace + (2.0 * squares - trace * trace).max(0.0).sqrt())
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
    fn what_is_proven_of_a_cell_is_known_of_its_chain_and_stays() {
        let patches = Patches::new(Grid::new(1.0), 10_000);
        let key = |x: i64| (LEVELS[0], Voxel([x, 0, 0]));
        let known = |x: i64| match patches.cells.get(&key(x)) {
            Some(Patch::Known(answer)) => Some(answer),
            _ => None,
        };
        let learn = |trail: &[Key], answer: Answer| patches.learn(trail, answer, &mut Memo::default());
        assert_eq!(learn(&[key(0), key(1)], Answer::Apart), Answer::Apart);
        assert_eq!(learn(&[key(1), key(2)], Answer::Joined), Answer::Joined);
        assert_eq!([known(0), known(1)], [Some(Answer::Apart), Some(Answer::Joined)]);
        assert_eq!(learn(&[key(0), key(2), key(3)], Answer::Unknown), Answer::Joined);
        assert_eq!([0, 1, 2, 3].map(known), [Some(Answer::Joined); 4]);
    }

    #[test]
    fn all_of_a_shape_that_is_inside_comes_to_where_it_leads() {
        let tape = waves();
        let (mut balls, mut values) = (Balls::new(&tape), Evaluator::<Interval>::new(tape.clone()));
        let mut value = |p: DVec3| values.eval(&p.to_array().map(Interval::point)).hi;
        let mut state = 7_u64;
        let mut inside = |low: f64, high: f64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            low + (high - low) * (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for (shape, places) in [(CELL, 40), (PLACE, 1)] {
            let mut found = [0, 0];
            for _ in 0..4000 {
                let centre = DVec3::new(inside(-3.0, 3.0), inside(-3.0, 3.0), inside(-3.0, 3.0));
                let radius = inside(0.02, 0.6);
                let f = balls.eval([(centre, radius)].into_iter()).lane(0);
                let Some(place) = leads(&f, shape).map(|u| centre + radius * u) else { continue };
                let is_full = f.range.hi < 0.0;
                let down = (place - centre).normalize_or_zero();
                let mut is_met = false;
                for _ in 0..places {
                    let u = DVec3::new(inside(-1.0, 1.0), inside(-1.0, 1.0), inside(-1.0, 1.0));
                    let p = centre + shape.share * radius * u;
                    if u.length() > 1.0 && shape.share > 0.0 || value(p) >= 0.0 {
                        continue;
                    }
                    is_met = true;
                    let foot = if is_full { p } else { p + (place - p).dot(down) * down };
                    for k in 0..=20 {
                        let t = f64::from(k) / 20.0;
                        assert!(
                            value(p.lerp(foot, t)) < 0.0 && value(foot.lerp(place, t)) < 0.0,
                            "{centre} {radius}"
                        );
                    }
                }
                found[usize::from(is_full)] += usize::from(is_met);
            }
            assert!(found.iter().all(|n| *n > 300), "{found:?}");
        }
    }
}
