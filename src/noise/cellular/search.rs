//! The nearest nodes of points, found cell by cell from the nearest cell outwards.
//!
//! Space is cut into unit cells. The number of nodes in a cell is a Poisson quantile of a hash of
//! the cell, and their places are further hashes, so the nodes are a Poisson process with one node
//! a cell on average: it has no lattice left in it. (A cell holds at most twelve; more would be
//! there once in 10^10 cells. Places are multiples of 2^-10 of a cell, off the cell's faces.)
//!
//! Cells are visited in a fixed order, sorted by how near they can be to a point. A cell is skipped
//! where it is farther than the nodes found so far, and the search ends where all that follow are.
//! Nothing is cut off early: the order statistics are exact, as far as the *cap* at which distances
//! saturate. (The 3x3x3 block of the usual implementations misses the true fourth neighbour of every
//! tenth point, and the noise jumps there.)
//!
//! **Speed.** A group of points moves through the cells together. Every point's cell is mirrored so
//! that the point lies in its upper octant: then the same offsets are near for all lanes, and a few
//! cells serve a group. A lane for which a cell is too far masks it, so that lanes cannot notice
//! each other.

use super::metric::Metric;
use crate::noise::lattice::{Lattice, STEP, hash, split};
use std::sync::OnceLock;

/// Points that are searched for together: one vector of the widest instruction set. More would wait
/// for one another.
pub(super) const GROUP: usize = 8;

/// Cells on each side of a point's own that may matter.
const REACH: usize = 3;
const SPAN: usize = 2 * REACH + 1;

/// A cell by its offset from the point's own, in units that grow towards the point's octant.
pub(super) struct Cell {
    /// Offset plus [`REACH`], by axis.
    index: [usize; 3],
    /// Distance to it along each axis: a factor of the fraction, and a constant.
    gaps: [[f64; 2]; 3],
    /// Least measure of a node in it from any point of the upper octant.
    least: f64,
}

/// The cells that may hold a node within `cap` of a point, nearest first.
pub(super) fn cells<M: Metric>(metric: M, cap: f64) -> Vec<Cell> {
    let limit = metric.measure([cap, 0.0, 0.0], f64::INFINITY);
    let mut cells: Vec<Cell> = (0..SPAN.pow(3))
        .map(|n| [n % SPAN, n / SPAN % SPAN, n / SPAN / SPAN])
        .map(|index| {
            let offset = index.map(|i| i as i32 - REACH as i32);
            Cell { index, gaps: offset.map(gap), least: metric.floor(offset.map(least_gap)) }
        })
        .filter(|cell| cell.least < limit)
        .collect();
    // A stable sort: cells that can be equally near keep their order.
    cells.sort_by(|a, b| a.least.total_cmp(&b.least));
    cells
}

/// Least distance along an axis to the cell at `offset` from the upper half of a cell.
fn least_gap(offset: i32) -> f64 {
    let ([slope, shift], nearest) = (gap(offset), if offset > 0 { 1.0 } else { 0.5 });
    slope * nearest + shift
}

/// The distance along an axis to the cell at `offset` is this slope times the fraction plus a shift.
fn gap(offset: i32) -> [f64; 2] {
    match offset {
        0 => [0.0, 0.0],
        1.. => [-1.0, f64::from(offset)],
        _ => [1.0, f64::from(-offset - 1)],
    }
}

/// Most nodes of a cell.
const MOST: usize = 12;

/// A cell has more than `k` nodes if its hash is at least the `k`-th of these: quantiles of the
/// Poisson law with mean 1 in units of 2^-32.
fn quantiles() -> &'static [u32; MOST] {
    static QUANTILES: OnceLock<[u32; MOST]> = OnceLock::new();
    QUANTILES.get_or_init(|| {
        let (mut term, mut sum) = (libm::exp(-1.0), 0.0);
        std::array::from_fn(|k| {
            sum += term;
            term /= (k + 1) as f64;
            (sum * 4_294_967_296.0).round() as u32
        })
    })
}

/// The place of the `k`-th node in the cell with hash `cell`, less half a grain.
#[inline(always)]
fn node(cell: u32, k: u32) -> [f64; 3] {
    let h = cell.wrapping_add(k.wrapping_mul(STEP[0]));
    let h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    let h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    let h = h ^ (h >> 15);
    let place = |bits: u32| f64::from(bits as i32) * GRAIN;
    [place(h >> 22), place(h >> 12 & 1023), place(h >> 2 & 1023)]
}

/// The largest of some numbers that are not negative: as integers, which a vector may reorder.
#[inline(always)]
fn largest<const B: usize>(x: &[f64; B]) -> f64 {
    f64::from_bits(x.iter().fold(0, |a: u64, b| if b.to_bits() > a { b.to_bits() } else { a }))
}

/// A node's place is a multiple of this, less half of it.
const GRAIN: f64 = 1.0 / 1024.0;

/// What a search needs to know.
#[derive(Clone, Copy)]
pub(super) struct Search<'a, M> {
    pub(super) metric: M,
    pub(super) cells: &'a [Cell],
    pub(super) lattice: &'a Lattice,
    /// Distances end here.
    pub(super) cap: f64,
}

/// The `K` smallest measures of `B` points, in order, with the points' offsets from their nodes;
/// those of a distance that has saturated are zero.
pub(super) struct Found<const K: usize, const B: usize> {
    pub(super) measure: [[f64; B]; K],
    pub(super) offset: [[[f64; B]; 3]; K],
    /// Zero, or NaN for a point that is nowhere.
    pub(super) nowhere: [f64; B],
}

/// Where a group of points stands relative to the cells around.
struct Frame<const B: usize> {
    /// Fractions, mirrored into the upper half.
    upper: [[f64; B]; 3],
    /// Products of the axes in the words of cells, by offset.
    words: [[[u32; B]; SPAN]; 3],
    /// Places of the points relative to the cells, less half a grain, by offset.
    places: [[[f64; B]; SPAN]; 3],
    nowhere: [f64; B],
}

impl<const B: usize> Frame<B> {
    #[inline(always)]
    fn new(lattice: &Lattice, at: &[[f64; B]; 3], reach: usize) -> Frame<B> {
        let mut frame = Frame {
            upper: [[0.0; B]; 3],
            words: [[[0; B]; SPAN]; 3],
            places: [[[0.0; B]; SPAN]; 3],
            nowhere: [0.0; B],
        };
        for axis in 0..3 {
            let (mut home, mut t, mut side) = ([0_u32; B], [0.0; B], [0_u32; B]);
            let (upper, nowhere) = (&mut frame.upper[axis], &mut frame.nowhere);
            for i in 0..B {
                let (cell, fraction) = split(at[axis][i]);
                (home[i], t[i]) = (cell, fraction);
                nowhere[i] += fraction * 0.0;
                upper[i] = if fraction < 0.5 { 1.0 - fraction } else { fraction };
                side[i] = if fraction < 0.5 { u32::MAX } else { 1 };
            }
            for n in REACH - reach..=REACH + reach {
                let offset = n as i32 - REACH as i32;
                let (words, places) = (&mut frame.words[axis][n], &mut frame.places[axis][n]);
                for i in 0..B {
                    let step = side[i].wrapping_mul(offset as u32);
                    words[i] = home[i].wrapping_add(step).wrapping_mul(STEP[axis]);
                    places[i] = t[i] - f64::from(step as i32) - 0.5 * GRAIN;
                }
            }
            if lattice.period[axis] != 0 {
                frame.tile(lattice, axis, &home, &side);
            }
        }
        // A point that is nowhere is near nothing, whatever its other coordinates.
        for upper in &mut frame.upper {
            for i in 0..B {
                upper[i] += frame.nowhere[i];
            }
        }
        frame
    }

    /// The words of cells on a lattice that repeats.
    #[inline(never)]
    fn tile(&mut self, lattice: &Lattice, axis: usize, home: &[u32; B], side: &[u32; B]) {
        for (n, words) in self.words[axis].iter_mut().enumerate() {
            let offset = (n as u32).wrapping_sub(REACH as u32);
            for i in 0..B {
                let cell = home[i].wrapping_add(side[i].wrapping_mul(offset));
                words[i] = lattice.wrap(axis, cell).wrapping_mul(STEP[axis]);
            }
        }
    }
}

impl<M: Metric> Search<'_, M> {
    /// The nearest nodes of a group of points; without their offsets unless `OFFSETS`.
    #[inline(always)]
    pub(super) fn nearest<const K: usize, const B: usize, const OFFSETS: bool>(
        &self,
        at: &[[f64; B]; 3],
    ) -> Found<K, B> {
        let Search { metric, lattice, cap, .. } = *self;
        let frame = Frame::new(lattice, at, self.reach());
        let cap = metric.measure([cap, 0.0, 0.0], f64::INFINITY);
        let mut found = Found { measure: [[cap; B]; K], offset: [[[0.0; B]; 3]; K], nowhere: frame.nowhere };
        let (key, quantiles) = (lattice.key(), quantiles());
        for cell in self.cells {
            if cell.least >= largest(&found.measure[K - 1]) {
                break;
            }
            let hashes = frame.hashes(metric, key, cell, &found.measure[K - 1]);
            let top = hashes.iter().fold(0, |a: u32, b| if *b > a { *b } else { a });
            let [a, b, c] = cell.index;
            let (x, y, z) = (&frame.places[0][a], &frame.places[1][b], &frame.places[2][c]);
            for (k, least) in quantiles.iter().enumerate() {
                if top < *least {
                    break;
                }
                for i in 0..B {
                    let [u, v, w] = node(hashes[i], k as u32);
                    let d = [x[i] - u, y[i] - v, z[i] - w];
                    let m = metric.measure(d, found.measure[K - 1][i]);
                    let m = if hashes[i] >= *least { m } else { f64::INFINITY };
                    found.insert::<OFFSETS>(i, m, d);
                }
            }
        }
        found
    }

    /// Calls `each` with the offset from every node that may be nearer than `limit`, which is at most
    /// the cap, and with some that are not.
    pub(super) fn within(&self, at: [f64; 3], limit: f64, mut each: impl FnMut([f64; 3])) {
        let frame = Frame::<1>::new(self.lattice, &at.map(|x| [x]), self.reach());
        let (key, quantiles) = (self.lattice.key(), quantiles());
        let limit = [self.metric.measure([limit, 0.0, 0.0], f64::INFINITY)];
        for cell in self.cells.iter().take_while(|cell| cell.least < limit[0]) {
            let [h] = frame.hashes(self.metric, key, cell, &limit);
            let place = [0, 1, 2].map(|axis| frame.places[axis][cell.index[axis]][0]);
            for k in (0..MOST).take_while(|k| h >= quantiles[*k]) {
                let node = node(h, k as u32);
                each([0, 1, 2].map(|axis| place[axis] - node[axis]));
            }
        }
    }

    /// Cells on each side within the cap.
    #[inline(always)]
    fn reach(&self) -> usize {
        (self.cap as usize).min(REACH)
    }
}

impl<const B: usize> Frame<B> {
    /// The hashes of a cell for every lane; zero, which means no nodes, where it is not nearer than
    /// the limit.
    #[inline(always)]
    fn hashes<M: Metric>(&self, metric: M, key: [u32; 2], cell: &Cell, limit: &[f64; B]) -> [u32; B] {
        let ([p, q, r], [a, b, c]) = (cell.gaps, cell.index);
        let (u, v, w) = (&self.words[0][a], &self.words[1][b], &self.words[2][c]);
        let [x, y, z] = &self.upper;
        let mut hashes = [0; B];
        for i in 0..B {
            let gap = [p[0] * x[i] + p[1], q[0] * y[i] + q[1], r[0] * z[i] + r[1]];
            let near = metric.floor(gap) < limit[i];
            let h = hash(u[i] ^ v[i] ^ w[i], key);
            hashes[i] = if near { h } else { 0 };
        }
        hashes
    }
}

impl<const K: usize, const B: usize> Found<K, B> {
    /// Puts a node into the order of lane `i`, after those that are as near.
    #[inline(always)]
    fn insert<const OFFSETS: bool>(&mut self, i: usize, measure: f64, offset: [f64; 3]) {
        let (mut m, mut d) = (measure, offset);
        for l in 0..K {
            let own = self.measure[l][i];
            let nearer = m < own;
            self.measure[l][i] = if nearer { m } else { own };
            m = if nearer { own } else { m };
            if OFFSETS {
                for axis in 0..3 {
                    let own = self.offset[l][axis][i];
                    self.offset[l][axis][i] = if nearer { d[axis] } else { own };
                    d[axis] = if nearer { own } else { d[axis] };
                }
            }
        }
    }
}
