//! The nearest nodes of a group of points: scouted in single precision, then measured.
//!
//! Most of a search is spent on nodes that are not the nearest. To tell so, single precision is
//! enough, and a vector holds twice as many lanes of it; nor need offsets be carried along. So a group
//! of points first looks for its `K + 1` nearest nodes *about*, each kept as two words: a **key**, the
//! measure in single precision with the cell's offset in place of its last bits, and the node's
//! place. Keys are compared as integers, with a sign because every instruction set can. Then the first
//! `K` are measured exactly. If the last of them is nearer than the `K + 1`-th can be, they are the
//! right ones. If not, or if two are equally near, so that their order matters, the lane is *unsure*
//! and searched for by itself, which happens once in thousands of points. Either way the outcome is
//! that of [`Search::nearest`], bit for bit.
//!
//! **Order of work.** Branches that processors cannot guess cost more than arithmetic. The eight cells
//! around the corner nearest to a point are looked at without asking whether they matter, in the same
//! order for all lanes. Of the others, those that matter to some lane are listed before any is looked
//! at. A lane to which a cell does not matter masks it, so that lanes cannot notice each other.
//!
//! **Errors.** Lengths are in grains, 1024 to a cell, so nodes are whole numbers. Places of points,
//! up to 4096, are off by 2^-15 and 2^-13 when they are rounded, and so are gaps; offsets, again up to
//! 4096, by another 2^-13. For offsets `d` below the cap that is an error of the Euclidean measure of
//! at most `2 (|d_x| + |d_y| + |d_z|) 2.75e-4 < 2`, and the roundings of a square of 2^22 add less
//! than 1; norms that are not squared are off by less than 0.002. [`Metric::SLACK`] is over thrice that,
//! enough for a cell and a node that are each off.

use super::metric::Metric;
use super::search::{Cell, Found, GRAIN, MOST, REACH, SPAN, Search, bits, gap, place, quantiles};
use crate::noise::lattice::{Lattice, STEP, hash, split};

/// Grains in a cell.
pub(super) const GRAINS: f32 = 1024.0;

/// The bits of a key that name a cell: three for the offset along each axis.
const CELL: i32 = 511;

/// Those of the measure, without its sign, which only NaN can have.
const ROUGH: i32 = i32::MAX - CELL;

/// Cells that touch the corner of a point's octant: no other can be nearer.
const OCTANT: usize = 8;

/// Nodes of such a cell that are looked at without asking whether there are as many: some lane will
/// have them, and processors do not guess well which.
const USUAL: usize = 2;

/// Cells that are considered at a time after those: as many as complete the block of three by three
/// by three.
const SOME: usize = 19;

/// Where a group of points stands among the cells around.
pub(super) struct Ground<const B: usize> {
    key: [u32; 2],
    /// The points' cells, and the step towards the nearest corner along each axis.
    home: [[u32; B]; 3],
    side: [[u32; B]; 3],
    /// Fractions.
    t: [[f64; B]; 3],
    nowhere: [f64; B],
    /// Products of the axes in the words of cells, by offset.
    words: [[[u32; B]; SPAN]; 3],
    /// Places of the points relative to the cells, less half a grain, by offset; in grains.
    places: [[[f32; B]; SPAN]; 3],
    /// What distances to the cells along the axes add to the measure, by offset; in grains.
    gaps: [[[f32; B]; SPAN]; 3],
}

impl<const B: usize> Ground<B> {
    #[inline(always)]
    pub(super) fn new(lattice: &Lattice) -> Ground<B> {
        Ground {
            key: lattice.key(),
            home: [[0; B]; 3],
            side: [[0; B]; 3],
            t: [[0.0; B]; 3],
            nowhere: [0.0; B],
            words: [[[0; B]; SPAN]; 3],
            places: [[[0.0; B]; SPAN]; 3],
            gaps: [[[0.0; B]; SPAN]; 3],
        }
    }

    /// Moves to other points.
    #[inline(always)]
    fn survey<M: Metric>(&mut self, metric: M, lattice: &Lattice, at: &[[f64; B]; 3], reach: usize) {
        self.nowhere = [0.0; B];
        for axis in 0..3 {
            for i in 0..B {
                let (cell, t) = split(at[axis][i]);
                self.home[axis][i] = cell;
                self.side[axis][i] = if t < 0.5 { u32::MAX } else { 1 };
                self.t[axis][i] = t;
                self.nowhere[i] += t * 0.0;
            }
        }
        for axis in 0..3 {
            self.stake(metric, axis, reach);
            if lattice.period[axis] != 0 {
                self.tile(lattice, axis);
            }
        }
    }

    /// What depends on the offset along an axis.
    #[inline(always)]
    fn stake<M: Metric>(&mut self, metric: M, axis: usize, reach: usize) {
        let (mut word, mut ahead) = ([0; B], [0; B]);
        let (mut place, mut upper, mut sign) = ([0.0; B], [0.0; B], [0.0; B]);
        for i in 0..B {
            // A point that is nowhere is near nothing, whatever its other coordinates.
            let t = self.t[axis][i] + self.nowhere[i];
            let grains = f64::from(GRAINS);
            place[i] = (t * grains - 0.5) as f32;
            upper[i] = (if t < 0.5 { grains - t * grains } else { t * grains }) as f32;
            sign[i] = self.side[axis][i] as i32 as f32;
            word[i] = self.home[axis][i].wrapping_mul(STEP[axis]);
            ahead[i] = self.side[axis][i].wrapping_mul(STEP[axis]);
        }
        for n in REACH - reach..=REACH + reach {
            let offset = n as i32 - REACH as i32;
            let [slope, shift] = gap(offset).map(|x| x as f32);
            let (grains, shift) = (GRAINS * offset as f32, GRAINS * shift);
            for i in 0..B {
                self.words[axis][n][i] = word[i].wrapping_add(ahead[i].wrapping_mul(offset as u32));
                self.places[axis][n][i] = place[i] - grains * sign[i];
                self.gaps[axis][n][i] = metric.part(slope * upper[i] + shift);
            }
        }
    }

    /// The words of cells on a lattice that repeats.
    #[inline(never)]
    fn tile(&mut self, lattice: &Lattice, axis: usize) {
        for (n, words) in self.words[axis].iter_mut().enumerate() {
            let offset = (n as u32).wrapping_sub(REACH as u32);
            for i in 0..B {
                let cell = self.home[axis][i].wrapping_add(self.side[axis][i].wrapping_mul(offset));
                words[i] = lattice.wrap(axis, cell).wrapping_mul(STEP[axis]);
            }
        }
    }

    /// The hashes of a cell.
    #[inline(always)]
    fn hashes(&self, cell: &Cell) -> [u32; B] {
        let [a, b, c] = cell.index;
        let (u, v, w) = (&self.words[0][a], &self.words[1][b], &self.words[2][c]);
        let mut hashes = [0; B];
        for i in 0..B {
            hashes[i] = hash(u[i] ^ v[i] ^ w[i], self.key);
        }
        hashes
    }

    /// For which lanes a cell is nearer than a limit, all bits of a word.
    #[inline(always)]
    fn near<M: Metric>(&self, metric: M, cell: &Cell, limit: &[f32; B]) -> [u32; B] {
        let [a, b, c] = cell.index;
        let (x, y, z) = (&self.gaps[0][a], &self.gaps[1][b], &self.gaps[2][c]);
        let mut near = [0; B];
        for i in 0..B {
            near[i] = if metric.joined([x[i], y[i], z[i]]) < limit[i] { u32::MAX } else { 0 };
        }
        near
    }
}

/// The nearest nodes so far.
struct Trail<const K: usize, const B: usize> {
    keys: [[i32; B]; K],
    places: [[u32; B]; K],
    /// The key of the best node that is not among them.
    next: [i32; B],
}

impl<const K: usize, const B: usize> Trail<K, B> {
    /// Looks at the `k`-th node of a cell, in the lanes where there is one.
    #[inline(always)]
    fn visit<M: Metric>(
        &mut self,
        metric: M,
        ground: &Ground<B>,
        cell: &Cell,
        hashes: &[u32; B],
        k: usize,
        least: u32,
    ) {
        let [a, b, c] = cell.index;
        let (x, y, z) = (&ground.places[0][a], &ground.places[1][b], &ground.places[2][c]);
        let name = (a | b << 3 | c << 6) as i32;
        for i in 0..B {
            let mut own = bits(hashes[i], k as u32);
            let [u, v, w] = place(own).map(|x| x as i32 as f32);
            let measure = metric.rough([x[i] - u, y[i] - v, z[i] - w]);
            let key = measure.to_bits() as i32 & ROUGH | name;
            let mut key = if hashes[i] >= least { key } else { i32::MAX };
            for l in 0..K {
                let (old, old_place) = (self.keys[l][i], self.places[l][i]);
                let nearer = key < old;
                self.keys[l][i] = if nearer { key } else { old };
                self.places[l][i] = if nearer { own } else { old_place };
                key = if nearer { old } else { key };
                own = if nearer { old_place } else { own };
            }
            self.next[i] = if key < self.next[i] { key } else { self.next[i] };
        }
    }

    /// Beyond these measures a cell cannot matter.
    #[inline(always)]
    fn limits(&self, slack: f32) -> [f32; B] {
        let mut limits = [0.0; B];
        for i in 0..B {
            limits[i] = f32::from_bits((self.keys[K - 1][i] | CELL) as u32) + slack;
        }
        limits
    }
}

/// Whether any is at least so large. One comparison of vectors and a test of its mask; the largest of all
/// would take many steps.
#[inline(always)]
fn any<const B: usize>(x: &[u32; B], least: u32) -> bool {
    x.iter().fold(false, |any, x| any | (*x >= least))
}

impl<M: Metric> Search<'_, M> {
    /// The nearest nodes of a group of points.
    #[inline(always)]
    pub(super) fn nearest_of_group<const K: usize, const B: usize>(
        &self,
        ground: &mut Ground<B>,
        at: &[[f64; B]; 3],
        found: &mut Found<K, B>,
    ) {
        ground.survey(self.metric, self.lattice, at, self.reach());
        found.nowhere = ground.nowhere;
        let unsure = match M::SLACK {
            Some(slack) => self.measure(ground, &self.scout(ground, slack), slack, found),
            None => [true; B],
        };
        self.one_by_one(&unsure, at, found);
    }

    /// Searches for lanes that are unsure by themselves.
    #[inline(always)]
    pub(super) fn one_by_one<const K: usize, const B: usize>(
        &self,
        unsure: &[bool; B],
        at: &[[f64; B]; 3],
        found: &mut Found<K, B>,
    ) {
        if unsure.iter().fold(false, |a, b| a | b) {
            for i in (0..B).filter(|i| unsure[*i]) {
                found.replace(i, &self.nearest_of_one([at[0][i], at[1][i], at[2][i]]));
            }
        }
    }

    /// In rare cases, so not where a group is searched for.
    #[inline(never)]
    fn nearest_of_one<const K: usize>(&self, at: [f64; 3]) -> Found<K, 1> {
        self.nearest(at)
    }

    /// The measure of no node: a little beyond the cap, so that none within it is missed.
    #[inline(always)]
    pub(super) fn nothing(&self) -> f32 {
        self.metric.rough([1.001 * GRAINS * self.cap as f32, 0.0, 0.0])
    }

    /// Its key.
    #[inline(always)]
    fn no_key(&self) -> i32 {
        self.nothing().to_bits() as i32 | CELL
    }

    /// The nearest nodes in single precision.
    #[inline(always)]
    fn scout<const K: usize, const B: usize>(&self, ground: &Ground<B>, slack: f32) -> Trail<K, B> {
        let (metric, quantiles, nothing) = (self.metric, quantiles(), self.no_key());
        let mut trail = Trail { keys: [[nothing; B]; K], places: [[0; B]; K], next: [nothing; B] };
        let (octant, rest) = self.cells.split_at(OCTANT);
        let mut hashes = [[0; B]; OCTANT];
        for (own, cell) in hashes.iter_mut().zip(octant) {
            *own = ground.hashes(cell);
        }
        for k in 0..USUAL {
            for (hashes, cell) in hashes.iter().zip(octant) {
                trail.visit(metric, ground, cell, hashes, k, quantiles[k]);
            }
        }
        for (hashes, cell) in hashes.iter().zip(octant) {
            for k in (USUAL..MOST).take_while(|k| any(hashes, quantiles[*k])) {
                trail.visit(metric, ground, cell, hashes, k, quantiles[k]);
            }
        }
        for cells in rest.chunks(SOME) {
            if !self.farther(ground, cells, slack, &mut trail) {
                break;
            }
        }
        trail
    }

    /// Goes on in some cells, of which most are too far for most lanes, unless all are too far. First
    /// those that matter to some lane are listed, so that the processor need not guess which will.
    #[inline(always)]
    fn farther<const K: usize, const B: usize>(
        &self,
        ground: &Ground<B>,
        cells: &[Cell],
        slack: f32,
        trail: &mut Trail<K, B>,
    ) -> bool {
        let (metric, quantiles) = (self.metric, quantiles());
        let limits = trail.limits(slack);
        let least = (cells[0].least / metric.measure([GRAIN, 0.0, 0.0], f64::INFINITY)) as f32;
        let least = least.next_down();
        if !limits.iter().fold(false, |any, limit| any | (*limit > least)) {
            return false;
        }
        let (mut list, mut count) = ([0; SOME], 0);
        let mut hashes = [[0; B]; SOME];
        for (n, cell) in cells.iter().enumerate() {
            let near = ground.near(metric, cell, &limits);
            list[count] = n;
            count += usize::from(any(&near, 1));
            hashes[n] = near;
        }
        let (mut crowded, mut crowds) = ([0; SOME], 0);
        for n in &list[..count] {
            let (cell, own) = (&cells[*n], ground.hashes(&cells[*n]));
            for i in 0..B {
                hashes[*n][i] &= own[i];
            }
            trail.visit(metric, ground, cell, &hashes[*n], 0, quantiles[0]);
            crowded[crowds] = *n;
            crowds += usize::from(any(&hashes[*n], quantiles[1]));
        }
        for n in &crowded[..crowds] {
            for k in (1..MOST).take_while(|k| any(&hashes[*n], quantiles[*k])) {
                trail.visit(metric, ground, &cells[*n], &hashes[*n], k, quantiles[k]);
            }
        }
        true
    }

    /// Measures exactly what was found. Which lanes are unsure.
    #[inline(always)]
    fn measure<const K: usize, const B: usize>(
        &self,
        ground: &Ground<B>,
        trail: &Trail<K, B>,
        slack: f32,
        found: &mut Found<K, B>,
    ) -> [bool; B] {
        let (metric, nothing) = (self.metric, self.no_key());
        let scale = metric.measure([f64::from(GRAINS), 0.0, 0.0], f64::INFINITY);
        let cap = metric.measure([self.cap, 0.0, 0.0], f64::INFINITY);
        found.measure = [[cap; B]; K];
        found.offset = [[[0.0; B]; 3]; K];
        let mut unsure = [false; B];
        for l in 0..K {
            let (mut measure, mut offset) = ([0.0; B], [[0.0; B]; 3]);
            for i in 0..B {
                let (key, node) = (trail.keys[l][i], place(trail.places[l][i]));
                let d = [0, 1, 2].map(|axis| {
                    let steps = (key as u32 >> (3 * axis) & 7).wrapping_sub(REACH as u32);
                    let step = ground.side[axis][i].wrapping_mul(steps) as i32;
                    let place = ground.t[axis][i] - f64::from(step) - 0.5 * GRAIN;
                    place - f64::from(node[axis] as i32) * GRAIN
                });
                let m = metric.measure(d, f64::INFINITY);
                measure[i] = if key == nothing { f64::INFINITY } else { m };
                for axis in 0..3 {
                    offset[axis][i] = d[axis];
                }
            }
            if K == 1 {
                for i in 0..B {
                    let d = [offset[0][i], offset[1][i], offset[2][i]];
                    unsure[i] |= found.insert(i, measure[i], d);
                }
            } else {
                found.insert_all(&measure, &offset, &mut unsure);
            }
        }
        for i in 0..B {
            let next = f64::from(f32::from_bits((trail.next[i] & ROUGH) as u32) - slack);
            unsure[i] |= found.measure[K - 1][i] * scale >= next;
        }
        unsure
    }
}
