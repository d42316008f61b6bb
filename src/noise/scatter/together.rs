//! What is known of balls that are next to one another: they have their nodes in common.
//!
//! A ball of an enclosure is often far smaller than a cell, and those of a batch are beside one another. Then it takes longer
//! to find the few nodes in reach than to sum up their spots. So the nodes in reach of a box around some balls are
//! found once, and each ball sums up all of them, in the order in which it would have found its own: those beyond its reach
//! add exact zeros.

use super::near::{LANES, LARGEST, Nodes, PARTS, add, known, local, widened};
use super::{Draw, Scatter, Spot};
use crate::noise::bulk::HESSIAN;
use crate::noise::lattice::{Lattice, STEP, split};
use crate::num::{Bounds, Local, Order, widest};

/// Most balls of a group.
const BALLS: usize = 16;

/// Largest edge of a box around their middles.
const EDGE: f64 = 0.5;

/// Most cells of nodes in reach: six along an axis.
const CELLS: usize = 216;

/// Beyond all rounding.
const SLACK: f64 = 1e-6;

/// The middle of a ball on an axis: its cell, and its place in that.
type Place = (u32, f64);

/// Some balls next to one another.
struct Balls {
    count: usize,
    at: [[Place; 3]; BALLS],
    wide: [f64; BALLS],
    /// A box around their middles, seen from the first one's cell, and the largest radius.
    low: [f64; 3],
    high: [f64; 3],
    widest: f64,
}

impl Balls {
    /// As many as go together.
    fn first_of(balls: impl Iterator<Item = ([f64; 3], f64)>) -> Balls {
        let mut all = Balls {
            count: 0,
            at: [[(0, 0.0); 3]; BALLS],
            wide: [0.0; BALLS],
            low: [f64::INFINITY; 3],
            high: [f64::NEG_INFINITY; 3],
            widest: 0.0,
        };
        for (at, radius) in balls.take(BALLS) {
            let (places, wide) = (at.map(split), widened(radius));
            let base = if all.count == 0 { places } else { all.at[0] };
            let seen: [f64; 3] =
                std::array::from_fn(|axis| from(base[axis].0, places[axis].0) + places[axis].1);
            let low: [f64; 3] = std::array::from_fn(|axis| all.low[axis].min(seen[axis]));
            let high: [f64; 3] = std::array::from_fn(|axis| all.high[axis].max(seen[axis]));
            let fits = (0..3).all(|axis| high[axis] - low[axis] <= EDGE) && wide <= LARGEST;
            if !fits || seen.iter().any(|x| x.is_nan()) {
                break;
            }
            (all.at[all.count], all.wide[all.count]) = (places, wide);
            all = Balls { count: all.count + 1, low, high, widest: all.widest.max(wide), ..all };
        }
        all
    }
}

/// How many cells further one is than another.
#[inline(always)]
fn from(base: u32, cell: u32) -> f64 {
    f64::from(cell.wrapping_sub(base) as i32)
}

/// Cells in reach of some balls, in the order of their numbers, seen from the first one's.
struct Cells {
    count: usize,
    words: [u32; CELLS],
    at: [[f64; CELLS]; 3],
}

impl Cells {
    #[inline(always)]
    fn around(draw: &Draw, lattice: &Lattice, balls: &Balls) -> Cells {
        let mut cells = Cells { count: 0, words: [0; CELLS], at: [[0.0; CELLS]; 3] };
        let reach = 1.0 + balls.widest + SLACK;
        // The cells along an axis that may have nodes in reach, and how far these are at least.
        let along = |axis: usize| {
            let mut steps = [(0_u32, 0.0, f64::INFINITY); 6];
            for (i, step) in steps.iter_mut().enumerate() {
                let at = balls.low[axis].floor() - 2.0 + i as f64;
                let least = at + draw.margin;
                let distance =
                    f64::max(least - balls.high[axis], balls.low[axis] - (least + draw.side)).max(0.0);
                let cell = balls.at[0][axis].0.wrapping_add(at as i32 as u32);
                *step = (lattice.wrap(axis, cell).wrapping_mul(STEP[axis]), at, distance * distance);
            }
            steps
        };
        let [x, y, z] = [along(0), along(1), along(2)];
        for w in &z {
            for v in &y {
                for u in x.iter().filter(|u| u.2 + (v.2 + w.2) < reach * reach) {
                    let n = cells.count;
                    cells.words[n] = u.0 ^ v.0 ^ w.0;
                    (cells.at[0][n], cells.at[1][n], cells.at[2][n]) = (u.1, v.1, w.1);
                    cells.count = n + 1;
                }
            }
        }
        cells
    }
}

/// Nodes in reach of some balls, one of each cell: which cell, and the place in it.
struct Reached {
    count: usize,
    cell: [[f64; CELLS]; 3],
    place: [[f64; CELLS]; 3],
    weight: [f64; CELLS],
    word: [u32; CELLS],
}

impl Reached {
    #[inline(always)]
    fn of(draw: &Draw, cells: &Cells, slot: usize, balls: &Balls) -> Reached {
        let zero = [[0.0; CELLS]; 3];
        let mut found = Reached { count: 0, cell: zero, place: zero, weight: [0.0; CELLS], word: [0; CELLS] };
        let reach = 1.0 + balls.widest + SLACK;
        for i in 0..cells.count {
            let node = draw.node(cells.words[i], slot, [0.0; 3]);
            let distance = |axis: usize| {
                let at = cells.at[axis][i] + draw.margin - node.d[axis];
                let out = f64::max(at - balls.high[axis], balls.low[axis] - at).max(0.0);
                out * out
            };
            let is_there = draw.tail.is_none_or(|tail| draw.count(cells.words[i]) < tail[slot]);
            let n = found.count;
            for axis in 0..3 {
                found.cell[axis][n] = cells.at[axis][i];
                // Exact, as is the place of a node seen from where nodes may be.
                found.place[axis][n] = -node.d[axis];
            }
            (found.weight[n], found.word[n]) = (node.weight, node.word);
            let is_near = distance(0) + distance(1) + distance(2) < reach * reach;
            found.count = n + usize::from(is_near && is_there);
        }
        found
    }

    /// Some of them as seen from a place; what is beyond the last is far away.
    #[inline(always)]
    fn seen(&self, draw: &Draw, first: usize, base: &[Place; 3], at: &[Place; 3]) -> Nodes {
        let mut nodes = Nodes { d: [[8.0; LANES]; 3], weight: [0.0; LANES], word: [0; LANES] };
        for i in 0..LANES.min(self.count - first) {
            let n = first + i;
            for axis in 0..3 {
                let cell = self.cell[axis][n] - from(base[axis].0, at[axis].0);
                // The operations of a ball that is alone.
                nodes.d[axis][i] = at[axis].1 - cell - draw.margin - self.place[axis][n];
            }
            (nodes.weight[i], nodes.word[i]) = (self.weight[n], self.word[n]);
        }
        nodes
    }
}

/// [`Basis::locals`](crate::noise::Basis::locals) for spots; other arguments as of [`local`].
pub(in crate::noise) fn locals<S: Spot>(
    scatter: &Scatter,
    spot: &S,
    lattice: &Lattice,
    (order, at, radius): (Order, [&[f64]; 3], &[f64]),
    (global, rounding): (Bounds, [f64; 3]),
    out: &mut [Local],
) {
    let draw = scatter.draw(lattice);
    let ball = |i: usize| (at.map(|at| at[i]), radius[i]);
    let mut first = 0;
    while first < out.len() {
        let balls = Balls::first_of((first..out.len()).map(ball));
        if balls.count < 2 {
            let (at, radius) = ball(first);
            out[first] = local(scatter, spot, lattice, (order, at, radius), global, rounding);
            first += 1;
            continue;
        }
        let sums = widest(
            #[inline(always)]
            || sums(&draw, spot, lattice, &balls),
        );
        for i in 0..balls.count {
            out[first + i] = known(sums[i], balls.wide[i], global, rounding);
        }
        first += balls.count;
    }
}

#[inline(always)]
fn sums<S: Spot>(draw: &Draw, spot: &S, lattice: &Lattice, balls: &Balls) -> [[f64; PARTS]; BALLS] {
    let mut sums = [[0.0; PARTS]; BALLS];
    let cells = Cells::around(draw, lattice, balls);
    for slot in 0..draw.slots {
        let reached = Reached::of(draw, &cells, slot, balls);
        for (ball, sum) in sums[..balls.count].iter_mut().enumerate() {
            for first in (0..reached.count).step_by(LANES) {
                let nodes = reached.seen(draw, first, &balls.at[0], &balls.at[ball]);
                add::<HESSIAN, true, S>(spot, &nodes, reached.count - first, balls.wide[ball], sum);
            }
        }
    }
    sums
}
