//! What is known of balls that are next to one another: they have their nodes in common.
//!
//! A ball of an enclosure is often far smaller than a cell, and those of a batch are beside one another. Then it takes longer
//! to find the few nodes in reach than to sum up their spots. So the nodes in reach of a box around some balls are
//! found once, and each ball sums up all of them, in the order in which it would have found its own: those beyond its reach
//! add exact zeros.

use super::near::{LANES, LARGEST, Nodes, PARTS, known, limits, local, terms, widened};
use super::{Draw, Node, Scatter, Spot};
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
    /// Their numbers.
    which: [usize; BALLS],
    at: [[Place; 3]; BALLS],
    wide: [f64; BALLS],
    /// A box around their middles, seen from the first one's cell, and the largest radius.
    low: [f64; 3],
    high: [f64; 3],
    widest: f64,
}

impl Balls {
    const NONE: Balls = Balls {
        count: 0,
        which: [0; BALLS],
        at: [[(0, 0.0); 3]; BALLS],
        wide: [0.0; BALLS],
        low: [f64::INFINITY; 3],
        high: [f64::NEG_INFINITY; 3],
        widest: 0.0,
    };

    /// Takes the first one of a list, and those that go together with it. One that is too large for that, or nowhere, is alone.
    fn take(&mut self, open: &mut Open, ball: impl Fn(usize) -> ([f64; 3], f64)) {
        (self.count, self.widest) = (0, 0.0);
        (self.low, self.high) = (Balls::NONE.low, Balls::NONE.high);
        open.retain(|i| {
            let (at, radius) = ball(i);
            let (places, wide) = (at.map(split), widened(radius));
            let base = if self.count == 0 { places } else { self.at[0] };
            let seen: [f64; 3] =
                std::array::from_fn(|axis| from(base[axis].0, places[axis].0) + places[axis].1);
            let low: [f64; 3] = std::array::from_fn(|axis| self.low[axis].min(seen[axis]));
            let high: [f64; 3] = std::array::from_fn(|axis| self.high[axis].max(seen[axis]));
            let is_somewhere = wide <= LARGEST && !seen.iter().any(|x| x.is_nan());
            if is_somewhere && (0..3).all(|axis| high[axis] - low[axis] <= EDGE) {
                (self.low, self.high, self.widest) = (low, high, self.widest.max(wide));
            } else if self.count == 0 {
                (self.low, self.high) = ([f64::NEG_INFINITY; 3], [f64::INFINITY; 3]);
            } else {
                return true;
            }
            self.which[self.count] = i;
            (self.at[self.count], self.wide[self.count]) = (places, wide);
            self.count += 1;
            false
        });
    }
}

/// The numbers of balls that are not done.
struct Open {
    count: usize,
    which: [usize; BALLS],
}

impl Open {
    fn all(first: usize, end: usize) -> Open {
        Open { count: BALLS.min(end - first), which: std::array::from_fn(|i| first + i) }
    }

    fn retain(&mut self, mut is_open: impl FnMut(usize) -> bool) {
        let mut left = 0;
        for k in 0..self.count {
            let i = self.which[k];
            self.which[left] = i;
            left += usize::from(is_open(i));
        }
        self.count = left;
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
    /// Finds those of some balls.
    #[inline(always)]
    fn find(&mut self, draw: &Draw, lattice: &Lattice, balls: &Balls) {
        self.count = 0;
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
                    let n = self.count;
                    self.words[n] = u.0 ^ v.0 ^ w.0;
                    (self.at[0][n], self.at[1][n], self.at[2][n]) = (u.1, v.1, w.1);
                    self.count = n + 1;
                }
            }
        }
    }
}

/// Nodes of one number of some cells next to one another in order, drawn side by side.
struct Drawn {
    cell: [[f64; LANES]; 3],
    place: [[f64; LANES]; 3],
    weight: [f64; LANES],
    word: [u32; LANES],
    /// Which are in reach of some balls.
    is_near: [bool; LANES],
}

impl Drawn {
    #[inline(always)]
    fn of(draw: &Draw, (cells, first): (&Cells, usize), slot: usize, balls: &Balls) -> Drawn {
        let reach = 1.0 + balls.widest + SLACK;
        let zero = [[0.0; LANES]; 3];
        let mut drawn = Drawn {
            cell: zero,
            place: zero,
            weight: [0.0; LANES],
            word: [0; LANES],
            is_near: [false; LANES],
        };
        for i in 0..LANES {
            let node = draw.node(cells.words[first + i], slot, [0.0; 3]);
            for axis in 0..3 {
                drawn.cell[axis][i] = cells.at[axis][first + i];
                // Exact, as is the place of a node seen from where nodes may be.
                drawn.place[axis][i] = -node.d[axis];
            }
            (drawn.weight[i], drawn.word[i]) = (node.weight, node.word);
            let mut distance = 0.0;
            for axis in 0..3 {
                let at = drawn.cell[axis][i] + draw.margin + drawn.place[axis][i];
                let (below, above) = (balls.low[axis] - at, at - balls.high[axis]);
                let out = if below > above { below } else { above };
                distance += if out > 0.0 { out * out } else { 0.0 };
            }
            drawn.is_near[i] = distance < reach * reach;
        }
        if let Some(tail) = draw.tail {
            for i in 0..LANES {
                drawn.is_near[i] &= draw.count(cells.words[first + i]) < tail[slot];
            }
        }
        drawn
    }

    /// One of them, and its cell.
    #[inline(always)]
    fn node(&self, i: usize) -> ([f64; 3], Node) {
        let at = |all: &[[f64; LANES]; 3]| [all[0][i], all[1][i], all[2][i]];
        (at(&self.cell), Node { d: at(&self.place), weight: self.weight[i], word: self.word[i] })
    }
}

/// Balls as lanes, and what they sum up.
#[derive(Clone, Copy)]
struct Block {
    /// Cells of the middles, seen from the first ball's, and the places in them.
    cell: [[f64; LANES]; 3],
    place: [[f64; LANES]; 3],
    wide: [f64; LANES],
    sum: [[f64; LANES]; PARTS],
    bounds: [[f64; LANES]; 4],
}

impl Block {
    const NONE: Block = Block {
        cell: [[0.0; LANES]; 3],
        place: [[0.0; LANES]; 3],
        wide: [0.0; LANES],
        sum: [[0.0; LANES]; PARTS],
        bounds: [[0.0; LANES]; 4],
    };

    /// Begins with some balls, from one of them on; lanes beyond the last hold that one, too.
    #[inline(always)]
    fn begin(&mut self, balls: &Balls, first: usize) {
        self.sum = [[0.0; LANES]; PARTS];
        for i in 0..LANES {
            let ball = if first + i < balls.count { first + i } else { first };
            for axis in 0..3 {
                let (cell, place) = balls.at[ball][axis];
                self.cell[axis][i] = from(balls.at[0][axis].0, cell);
                self.place[axis][i] = place;
            }
            self.wide[i] = balls.wide[ball];
        }
    }

    /// Adds what a node contributes, by the operations of a ball that is alone. Of one that no ball reaches, that is exactly
    /// nothing.
    #[inline(always)]
    fn add<S: Spot>(&mut self, draw: &Draw, spot: &S, (cell, node): ([f64; 3], Node)) {
        let mut seen = Nodes { d: [[0.0; LANES]; 3], weight: [node.weight; LANES], word: [node.word; LANES] };
        for axis in 0..3 {
            for i in 0..LANES {
                let cell = cell[axis] - self.cell[axis][i];
                seen.d[axis][i] = self.place[axis][i] - cell - draw.margin - node.d[axis];
            }
        }
        let mut is_near = false;
        for i in 0..LANES {
            let [x, y, z] = [seen.d[0][i], seen.d[1][i], seen.d[2][i]];
            let reach = 1.0 + self.wide[i] + SLACK;
            is_near |= x * x + y * y + z * z < reach * reach;
        }
        if !is_near {
            return;
        }
        let terms = terms::<HESSIAN, true, S>(spot, &seen, &self.wide);
        for k in 0..PARTS {
            for i in 0..LANES {
                self.sum[k][i] += terms[k][i];
            }
        }
    }

    /// Bounds, when all is summed up.
    #[inline(always)]
    fn limit(&mut self, global: Bounds, rounding: [f64; 3]) {
        for i in 0..LANES {
            let own = limits(&self.sums(i), self.wide[i], global, rounding);
            [self.bounds[0][i], self.bounds[1][i]] = [own.range, own.lipschitz];
            [self.bounds[2][i], self.bounds[3][i]] = [own.hessian, own.third];
        }
    }

    #[inline(always)]
    fn sums(&self, i: usize) -> [f64; PARTS] {
        let mut sums = [0.0; PARTS];
        for k in 0..PARTS {
            sums[k] = self.sum[k][i];
        }
        sums
    }

    /// What is known of one of the balls.
    fn ball(&self, i: usize, global: Bounds) -> Local {
        let [range, lipschitz, hessian, third] = [0, 1, 2, 3].map(|k| self.bounds[k][i]);
        known(self.sums(i), Bounds { range, lipschitz, hessian, third }, global)
    }
}

/// Some balls next to one another, the cells in reach of them, and what they sum up.
struct Group {
    balls: Balls,
    cells: Cells,
    blocks: [Block; BALLS / LANES],
}

impl Group {
    const NONE: Group = Group {
        balls: Balls::NONE,
        cells: Cells { count: 0, words: [0; CELLS], at: [[0.0; CELLS]; 3] },
        blocks: [Block::NONE; BALLS / LANES],
    };

    /// Finds the nodes in reach, and sums them up.
    fn sum<S: Spot>(&mut self, draw: &Draw, spot: &S, lattice: &Lattice, limits: (Bounds, [f64; 3])) {
        let Group { balls, cells, blocks } = self;
        let blocks = &mut blocks[..balls.count.div_ceil(LANES)];
        widest(
            #[inline(always)]
            || {
                cells.find(draw, lattice, balls);
                for (i, block) in blocks.iter_mut().enumerate() {
                    block.begin(balls, i * LANES);
                }
                for slot in 0..draw.slots {
                    for begin in (0..cells.count).step_by(LANES) {
                        let drawn = Drawn::of(draw, (cells, begin), slot, balls);
                        for i in (0..LANES.min(cells.count - begin)).filter(|&i| drawn.is_near[i]) {
                            let node = drawn.node(i);
                            // What is called here must be inlined, and `for_each` seldom is.
                            for block in blocks.iter_mut() {
                                block.add(draw, spot, node);
                            }
                        }
                    }
                }
                for block in blocks.iter_mut() {
                    block.limit(limits.0, limits.1);
                }
            },
        );
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
    let mut group = Group::NONE;
    for first in (0..out.len()).step_by(BALLS) {
        let mut open = Open::all(first, out.len());
        while open.count > 0 {
            group.balls.take(&mut open, ball);
            let Balls { which, count, .. } = group.balls;
            if count == 1 {
                let (at, radius) = ball(which[0]);
                out[which[0]] = local(scatter, spot, lattice, (order, at, radius), global, rounding);
                continue;
            }
            group.sum(&draw, spot, lattice, (global, rounding));
            for (i, &number) in which[..count].iter().enumerate() {
                out[number] = group.blocks[i / LANES].ball(i % LANES, global);
            }
        }
    }
}
