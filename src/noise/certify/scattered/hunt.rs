//! From below: climbs over places and directions.
//!
//! `F_k` is tabulated on a grid: places and nodes at twentieths of a cell (tenths for few starts), and as
//! many directions along an edge of the cube. From each start the grid is climbed, a step along any of its
//! five axes at a time, until no step leads up. Many starts meet on one peak. The best thousand peaks
//! are then climbed off the grid, where the nodes move too, by random steps that shrink when they fail:
//! for a while all, then the best of them, and to the last digit the best of those.

use super::super::unit;
use super::spots::{Spots, dot};
use super::windows::Windows;
use crate::noise::scatter::MARGIN;
use crate::num::{mix, uniform};
use rayon::prelude::*;

/// How many peaks are climbed for how many steps.
const ROUNDS: [(usize, usize); 3] = [(1000, 50), (150, 300), (24, 3000)];

/// `F_k` by direction and place.
struct Grid {
    values: Vec<f32>,
    directions: Vec<[usize; 2]>,
    /// Places to a cell and tiles to an edge of a face of the cube of directions.
    n: usize,
}

impl Grid {
    fn new(spots: &Spots, k: usize, n: usize) -> Grid {
        let directions: Vec<[usize; 2]> = (0..n).flat_map(|i| (0..=i).map(move |j| [i, j])).collect();
        let margin = if spots.margin { (MARGIN * n as f64).round() as usize } else { 0 };
        let sums = |tile: &[usize; 2]| -> Vec<f32> {
            let v = direction(*tile, n);
            let at = |i: usize| (i as f64 - n as f64) / n as f64;
            let side = 2 * n;
            let offset = |i: usize| [i / side / side, i / side % side, i % side].map(at);
            let table = (0..side * side * side).map(|i| spots.at(k, offset(i), v) as f32).collect();
            Windows::new(table, n, margin).sums().map(|sum| sum as f32).collect()
        };
        let values = directions.par_iter().flat_map_iter(sums).collect();
        Grid { values, directions, n }
    }

    /// The neighbours of a point of the grid. Places repeat after a cell.
    fn neighbours(&self, at: usize) -> impl Iterator<Item = usize> {
        let n = self.n;
        let (d, place) = (at / (n * n * n), at % (n * n * n));
        let moved = move |stride: usize| {
            let i = place / stride % n;
            let rest = place - i * stride;
            [(i + 1) % n, (i + n - 1) % n].map(|i| d * n * n * n + rest + i * stride)
        };
        // Direction [i, j] has the number i (i + 1) / 2 + j.
        let [i, j] = self.directions[d];
        let number = |i: usize, j: usize| i * (i + 1) / 2 + j;
        let turned = [
            (i + 1 < n).then(|| number(i + 1, j)),
            (i > j).then(|| number(i.wrapping_sub(1), j)),
            (j < i).then(|| number(i, j + 1)),
            (j > 0).then(|| number(i, j.wrapping_sub(1))),
        ];
        let turned = turned.into_iter().flatten().map(move |d| d * n * n * n + place);
        [1, n, n * n].into_iter().flat_map(moved).chain(turned)
    }

    /// The peak that steepest steps from a point lead to.
    fn peak(&self, mut at: usize) -> usize {
        loop {
            let best =
                self.neighbours(at).fold(at, |a, b| if self.values[b] > self.values[a] { b } else { a });
            if best == at {
                return at;
            }
            at = best;
        }
    }

    /// Peaks that are reached from so many starts, the highest first.
    fn peaks(&self, starts: u64) -> Vec<usize> {
        let start = |n: u64| self.peak((uniform(mix(n)) * self.values.len() as f64) as usize);
        let mut peaks: Vec<usize> = (0..starts).into_par_iter().map(start).collect();
        peaks.sort_unstable();
        peaks.dedup();
        peaks.sort_by(|a, b| self.values[*b].total_cmp(&self.values[*a]));
        peaks
    }
}

fn direction([i, j]: [usize; 2], n: usize) -> [f64; 3] {
    let middle = |i: usize| (i as f64 + 0.5) / n as f64;
    unit([1.0, middle(i), middle(j)])
}

/// A place, a direction and a node in each cell, seen from the place's cell.
#[derive(Clone, Copy)]
struct Climber {
    value: f64,
    x: [f64; 3],
    v: [f64; 3],
    nodes: [[f64; 3]; 27],
}

/// Where a node may be, and what it adds there.
struct Cell<'a> {
    spots: &'a Spots,
    k: usize,
    v: [f64; 3],
    /// The place, seen from the cell.
    from: [f64; 3],
    best: (f64, [f64; 3]),
}

impl Cell<'_> {
    fn offset(&self, p: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|i| self.from[i] - p[i])
    }

    fn reaches(&self, p: [f64; 3]) -> bool {
        let d = self.offset(p);
        dot(d, d) < 1.0
    }

    /// The place just within reach in the direction of another. Third derivatives end with a jump.
    fn on_rim(&self, p: [f64; 3]) -> [f64; 3] {
        let d = self.offset(p);
        let r = dot(d, d).sqrt().max(1e-9);
        [0, 1, 2].map(|i| self.from[i] - d[i] / r * (1.0 - 1e-12))
    }

    fn look(&mut self, p: [f64; 3]) {
        let margin = if self.spots.margin { MARGIN } else { 0.0 };
        let p = p.map(|p| p.clamp(margin, 1.0 - margin));
        let value = self.spots.at(self.k, self.offset(p), self.v);
        if value > self.best.0 {
            self.best = (value, p);
        }
    }
}

impl Climber {
    fn new(spots: &Spots, k: usize, x: [f64; 3], v: [f64; 3]) -> Climber {
        let mut new = Climber { value: 0.0, x, v, nodes: [[0.5; 3]; 27] };
        let margin = if spots.margin { MARGIN } else { 0.0 };
        new.settle(spots, k, |cell, _| {
            for i in 0..343 {
                let at = [i / 49, i / 7 % 7, i % 7].map(|i| f64::from(i) / 6.0);
                cell.look(at.map(|t| margin + (1.0 - 2.0 * margin) * t));
            }
        });
        new
    }

    /// Lets every node go to the best place that is looked at, and adds up.
    fn settle(&mut self, spots: &Spots, k: usize, mut look: impl FnMut(&mut Cell<'_>, [f64; 3])) {
        self.value = 0.0;
        for (c, node) in self.nodes.iter_mut().enumerate() {
            let corner = [c % 3, c / 3 % 3, c / 9].map(|o| o as f64 - 1.0);
            let from = [0, 1, 2].map(|i| self.x[i] - corner[i]);
            let mut cell = Cell { spots, k, v: self.v, from, best: (-1.0, *node) };
            cell.look(*node);
            look(&mut cell, *node);
            (self.value, *node) = (self.value + cell.best.0, cell.best.1);
        }
    }

    /// Somewhere near: within half a step for place and nodes, and a step for the direction.
    fn moved(&self, spots: &Spots, k: usize, step: f64, random: &mut impl FnMut() -> f64) -> Climber {
        let mut next = *self;
        let shift = [0; 3].map(|_| step * random());
        next.x = [0, 1, 2].map(|i| (self.x[i] + shift[i]).clamp(0.0, 1.0));
        next.v = unit(self.v.map(|v| v + 2.0 * step * random()));
        let v = next.v;
        next.settle(spots, k, |cell, node| {
            let from = cell.from;
            // Nodes may go along with the place, stay in its line, or go astray. The peaks of a spot lie
            // ahead and behind, at the centre, at the rim and between.
            cell.look([0, 1, 2].map(|i| node[i] + shift[i]));
            cell.look(cell.on_rim(node));
            for r in [0.0, 0.211, 0.33, 0.5, 0.789, 1.0 - 1e-12] {
                cell.look([0, 1, 2].map(|i| from[i] + r * v[i]));
                cell.look([0, 1, 2].map(|i| from[i] - r * v[i]));
            }
            for size in [1.0, 1.0, 0.3, 0.3, 0.1, 0.1] {
                let near = cell.best.1.map(|p| p + size * step * random());
                cell.look(if cell.reaches(near) { near } else { cell.on_rim(near) });
            }
            cell.look([0; 3].map(|_| 0.5 + random()));
        });
        next
    }

    fn climb(mut self, spots: &Spots, k: usize, seed: u64, steps: usize) -> Climber {
        let mut state = 0;
        let mut random = || {
            state += 1;
            uniform(mix(mix(seed) ^ state)) - 0.5
        };
        let mut step = 0.1;
        for _ in 0..steps {
            let next = self.moved(spots, k, step, &mut random);
            if next.value > self.value {
                (self, step) = (next, f64::min(1.5 * step, 0.5));
            } else {
                step = f64::max(0.97 * step, 1e-7);
            }
        }
        self
    }
}

/// The largest `F_k` that climbs from so many starts find.
pub(super) fn hunt(spots: &Spots, k: usize, starts: u64) -> f64 {
    let n = if starts < 10_000 { 10 } else { 20 };
    let grid = Grid::new(spots, k, n);
    let climber = |at: usize| {
        let place = at % n.pow(3);
        let x = [place / n / n, place / n % n, place % n].map(|i| i as f64 / n as f64);
        Climber::new(spots, k, x, direction(grid.directions[at / n.pow(3)], n))
    };
    let mut peaks = grid.peaks(starts);
    peaks.truncate(ROUNDS[0].0.min(16 + starts as usize / 100));
    let mut best: Vec<Climber> = peaks.into_par_iter().map(climber).collect();
    for (round, (kept, steps)) in ROUNDS.into_iter().enumerate() {
        best.truncate(kept);
        best = best
            .into_par_iter()
            .enumerate()
            .map(|(i, from)| from.climb(spots, k, (round * kept + i) as u64, steps))
            .collect();
        best.sort_by(|a, b| b.value.total_cmp(&a.value));
    }
    best.first().map_or(0.0, |best| best.value)
}
