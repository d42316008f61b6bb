//! The nearest triangle of a surface.
//!
//! The hierarchy of boxes is gone through depth first, the nearest box first. What is farther than the
//! nearest triangle so far *by more than both may be off* is left out; so every triangle whose computed
//! distance could be the least is looked at, wherever the search begins and whatever it looks at first. The
//! least computed distance wins, of equal ones the triangle of the lowest number: the answer has the same
//! bits whatever the search begins with, and it may begin with a good guess (`hints.rs`).
//!
//! The children of a node are not sorted, which would cost more than all that is computed of them: the nearest
//! of the eight is picked when one is wanted, and often that is too far, and so are all that are left.
//!
//! Points that are close together, as compared to how far they are from the surface, go down
//! **together**: a box is fetched and measured once for all of them, and each point is compared to it,
//! since what one of them needs most of the others need. Points that are farther apart go **alone**, but
//! take turns: while what one needs next is on its way from memory, the others go on, and where one has
//! ended the next begins.

use super::nearest::{choose, square};
use super::tree::{BLOCK, IS_BLOCK, Node, Tree, WIDE, in_frame};
use crate::num::ROUNDOFF;
use glam::DVec3;
use std::hint::black_box;

/// The number of no triangle.
pub(super) const NOWHERE: u32 = u32::MAX;

/// The nearest triangle so far.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Found {
    /// Square of its distance.
    pub square: f64,
    /// Its number.
    pub number: u32,
}

impl Found {
    /// None.
    pub(super) const NONE: Found = Found { square: f64::INFINITY, number: NOWHERE };

    #[inline(always)]
    fn is_before(self, other: Found) -> bool {
        self.square < other.square || self.square == other.square && self.number < other.number
    }
}

/// How far a computed distance may be off, of a point and triangles that are no farther from the origin.
#[inline(always)]
pub(super) fn slack(size: f64) -> f64 {
    128.0 * ROUNDOFF * size
}

/// Most points of a batch.
pub(super) const BATCH: usize = 64;
/// Neighbours in a batch that may go together.
pub(super) const GROUP: usize = 8;
/// Points that take turns. (Measured: 8 are too few to wait for memory, beyond 16 there is no difference.)
const TURNS: usize = 16;
/// Points go together if the square of their distance from the first of them is below this share of the
/// square of its distance from what it begins with. (Measured: from a tenth to one it makes no difference.)
const CLOSE: f64 = 0.6;

/// Searches for the nearest triangles of points.
pub(super) struct Search<'a> {
    tree: &'a Tree,
    /// Largest coordinate of a corner.
    size: f64,
    pending: Vec<Pending>,
    /// Those of a batch that go alone, and their places in it.
    apart: Vec<(Query, usize)>,
}

/// A point and what is known of its nearest triangle.
#[derive(Clone, Copy)]
struct Query {
    x: DVec3,
    slack: f64,
    best: Found,
    /// Square of the distance from which on nothing can be nearer, as computed.
    most: f64,
}

/// The children of a node that are still to be looked into.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Siblings {
    /// Squares of their distances, as bits, which are in the same order, but for the last ones, which say which child
    /// it is. [`FAR`] for those that are not, or no longer, to be looked into.
    keys: [i64; WIDE],
    /// Numbers of the children, and from bit 32 on, which points want them.
    what: [u64; WIDE],
}

/// What is to be looked into: children of nodes that are below one another.
#[derive(Clone)]
struct Pending {
    levels: Vec<Siblings>,
    /// How many levels there are.
    depth: usize,
}

impl<'a> Search<'a> {
    /// Searches in a tree of triangles, the largest coordinate of which is `size`.
    pub(super) fn new(tree: &'a Tree, size: f64) -> Self {
        Search { tree, size, pending: vec![Pending::NOTHING], apart: Vec::new() }
    }

    /// The nearest triangles to the points of a batch, each of which comes with a guess: a triangle, or [`NOWHERE`].
    #[inline(always)]
    pub(super) fn nearest(&mut self, points: &[DVec3], hints: &[u32], found: &mut [Found]) {
        self.apart.clear();
        for start in (0..points.len()).step_by(GROUP) {
            let lanes = start..points.len().min(start + GROUP);
            let mut room = [Query::NONE; GROUP];
            let group = &mut room[..lanes.len()];
            for (query, lane) in group.iter_mut().zip(lanes.clone()) {
                *query = Query::new(self.tree, points[lane], self.size, hints[lane]);
            }
            let off = group.iter().map(|q| (q.x - group[0].x).length_squared());
            let off = off.fold(0.0, |a, b| choose(b > a, b, a));
            if off < CLOSE * group[0].best.square {
                together(self.tree, &mut self.pending[0], group);
                group.iter().zip(lanes).for_each(|(query, lane)| found[lane] = query.best);
            } else {
                self.apart.extend(group.iter().copied().zip(lanes));
            }
        }
        let turns = self.apart.len().min(TURNS);
        if turns > self.pending.len() {
            self.pending.resize(turns, Pending::NOTHING);
        }
        alone(self.tree, &mut self.pending, &mut self.apart);
        self.apart.iter().for_each(|(query, lane)| found[*lane] = query.best);
    }
}

impl Query {
    const NONE: Query = Query { x: DVec3::ZERO, slack: 0.0, best: Found::NONE, most: f64::MAX };

    #[inline(always)]
    fn new(tree: &Tree, x: DVec3, size: f64, hint: u32) -> Query {
        let mut query = Query { x, slack: slack(size + x.abs().max_element()), ..Query::NONE };
        if let Some(t) = tree.triangle(hint) {
            query.learn(Found { square: square(t, x), number: hint });
        }
        query
    }

    #[inline(always)]
    fn learn(&mut self, found: Found) {
        if found.is_before(self.best) {
            let far = found.square.sqrt() + 2.0 * self.slack;
            // The squares of boxes are off by a few roundoffs too.
            let square = far * far * (1.0 + 32.0 * ROUNDOFF);
            // Boxes that are not there are infinitely far.
            (self.best, self.most) = (found, choose(square < f64::MAX, square, f64::MAX));
        }
    }

    /// The greatest key of what may be nearer.
    #[inline(always)]
    fn most_key(&self) -> i64 {
        self.most.to_bits() as i64
    }
}

impl Pending {
    const NOTHING: Pending = Pending { levels: Vec::new(), depth: 0 };

    /// Takes the nearest of the lowest children unless it is farther than that: its key, its number, and which points
    /// want it.
    #[inline(always)]
    fn pop(&mut self, most: i64) -> Option<(i64, u32, u32)> {
        loop {
            let level = self.levels.get_mut(self.depth.checked_sub(1)?)?;
            let mut least = level.keys[0];
            for i in 1..WIDE {
                least = choose(level.keys[i] < least, level.keys[i], least);
            }
            let (key, lane) = (least & !LANE, (least & LANE) as usize);
            if key <= most {
                level.keys[lane] = FAR;
                let what = level.what[lane];
                return Some((key, what as u32, (what >> 32) as u32));
            }
            self.depth -= 1;
        }
    }

    /// Adds the children of a node.
    #[inline(always)]
    fn push(&mut self, keys: [i64; WIDE], what: [u64; WIDE]) {
        if self.depth == self.levels.len() {
            self.grow();
        }
        self.levels[self.depth] = Siblings { keys, what };
        self.depth += 1;
    }

    #[cold]
    fn grow(&mut self) {
        let none = Siblings { keys: [FAR; WIDE], what: [0; WIDE] };
        self.levels.resize(2 * self.levels.len() + 8, none);
    }
}

/// Every point goes down by itself, a step at a time.
#[inline(always)]
fn alone(tree: &Tree, pending: &mut [Pending], queries: &mut [(Query, usize)]) {
    /// Whose turn it is, where it keeps what is to be looked into, and what it looks into next.
    #[derive(Clone, Copy)]
    struct Turn {
        query: usize,
        pending: usize,
        child: u32,
    }
    let mut turns: [Turn; TURNS] = std::array::from_fn(|i| Turn { query: i, pending: i, child: ROOT });
    let mut count = queries.len().min(TURNS);
    let mut begun = count;
    pending[..count].iter_mut().for_each(|p| p.depth = 0);
    while count > 0 {
        let mut still = 0;
        for k in 0..count {
            let mut turn = turns[k];
            let (query, pending) = (&mut queries[turn.query].0, &mut pending[turn.pending]);
            look(tree, turn.child, pending, query);
            if let Some((_, next, _)) = pending.pop(query.most_key()) {
                tree.fetch(next);
                turn.child = next;
            } else if begun < queries.len() {
                (turn.query, turn.child) = (begun, ROOT);
                begun += 1;
            } else {
                continue;
            }
            turns[still] = turn;
            still += 1;
        }
        count = still;
    }
}

/// Looks into a box.
#[inline(always)]
fn look(tree: &Tree, child: u32, pending: &mut Pending, query: &mut Query) {
    if child & IS_BLOCK != 0 {
        query.learn(nearest_of(tree, child & !IS_BLOCK, query.x));
    } else {
        let node = &tree.nodes[child as usize];
        // Through memory: else the compiler, which sees that the eight are looked at one by one, does
        // not compute them side by side.
        let keys = black_box(keys(node, query));
        pending.push(keys, node.child.map(u64::from));
    }
}

/// All points go down together.
#[inline(always)]
fn together(tree: &Tree, pending: &mut Pending, queries: &mut [Query]) {
    pending.depth = 0;
    let mut next = Some((0, ROOT, (1_u32 << queries.len()) - 1));
    while let Some((key, child, mut wanting)) = next {
        if child & IS_BLOCK != 0 {
            while wanting != 0 {
                let query = &mut queries[wanting.trailing_zeros() as usize];
                wanting &= wanting - 1;
                if key <= query.most_key() {
                    query.learn(nearest_of(tree, child & !IS_BLOCK, query.x));
                }
            }
        } else {
            let node = &tree.nodes[child as usize];
            // Through memory, as in `look`.
            let (keys, what) = black_box(common_keys(node, queries));
            pending.push(keys, what);
        }
        let most = queries.iter().map(Query::most_key).fold(0, |a, b| choose(b > a, b, a));
        next = pending.pop(most);
    }
}

/// The root, as a child.
const ROOT: u32 = 0;
/// The bits of a key that say which child it is.
const LANE: i64 = WIDE as i64 - 1;
/// Which child, by place.
const LANES: [i64; WIDE] = [0, 1, 2, 3, 4, 5, 6, 7];
/// Of a box that is too far.
const FAR: i64 = i64::MAX & !LANE;

/// The keys of the children of a node.
#[inline(always)]
fn keys(node: &Node, query: &Query) -> [i64; WIDE] {
    let squares = box_squares(node, query.x);
    let mut keys = [FAR; WIDE];
    for i in 0..WIDE {
        keys[i] = choose(squares[i] <= query.most, squares[i].to_bits() as i64 & !LANE, FAR) | LANES[i];
    }
    keys
}

/// The same for several points: the least of their keys, and who wants what.
#[inline(always)]
fn common_keys(node: &Node, queries: &[Query]) -> ([i64; WIDE], [u64; WIDE]) {
    let mut least = [i64::MAX; WIDE];
    let mut what = node.child.map(u64::from);
    for (i, query) in queries.iter().enumerate() {
        let keys = keys(node, query);
        for lane in 0..WIDE {
            least[lane] = choose(keys[lane] < least[lane], keys[lane], least[lane]);
            what[lane] |= choose(keys[lane] < FAR, 1 << (32 + i), 0);
        }
    }
    (least, what)
}

/// Squares of the distances to the boxes of a node.
#[inline(always)]
fn box_squares(node: &Node, x: DVec3) -> [f64; WIDE] {
    let t = in_frame(x, node.origin, &node.axes).to_array();
    let mut out = [0.0; WIDE];
    for axis in 0..3 {
        for i in 0..WIDE {
            let before = f64::from(node.lo[axis][i]) - t[axis];
            let after = t[axis] - f64::from(node.hi[axis][i]);
            let off = choose(before > after, before, after);
            let off = choose(off > 0.0, off, 0.0);
            out[i] += off * off;
        }
    }
    out
}

/// The nearest triangle of a block.
#[inline(always)]
fn nearest_of(tree: &Tree, block: u32, x: DVec3) -> Found {
    let squares = tree.blocks[block as usize].map(
        #[inline(always)]
        |t| square(t, x),
    );
    let (mut square, mut at) = (squares[0], 0);
    for lane in 1..BLOCK {
        // Never one that is absent.
        let nearer = squares[lane] < square;
        square = choose(nearer, squares[lane], square);
        at = choose(nearer, lane as u32, at);
    }
    Found { square, number: block * BLOCK as u32 + at }
}
