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
//! This is the search at one point. That of many points at a time, in `scout.rs`, gives the same.
//! Both mirror a point's cell so that the point lies in its upper octant: then the cells that are
//! near come in the same order for all points.

use super::metric::Metric;
use crate::noise::lattice::{Lattice, STEP, hash, split};
use std::sync::OnceLock;

/// Cells on each side of a point's own that may matter.
pub(super) const REACH: usize = 3;
pub(super) const SPAN: usize = 2 * REACH + 1;

/// A cell by its offset from the point's own, in units that grow towards the point's octant.
pub(super) struct Cell {
    /// Offset plus [`REACH`], by axis.
    pub(super) index: [usize; 3],
    /// Distance to it along each axis: a factor of the fraction, and a constant.
    gaps: [[f64; 2]; 3],
    /// Least measure of a node in it from any point of the upper octant.
    pub(super) least: f64,
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
pub(super) fn gap(offset: i32) -> [f64; 2] {
    match offset {
        0 => [0.0, 0.0],
        1.. => [-1.0, f64::from(offset)],
        _ => [1.0, f64::from(-offset - 1)],
    }
}

/// Most nodes of a cell.
pub(super) const MOST: usize = 12;

/// A cell has more than `k` nodes if its hash is at least the `k`-th of these: quantiles of the
/// Poisson law with mean 1 in units of 2^-32.
pub(super) fn quantiles() -> &'static [u32; MOST] {
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

/// Random bits of the `k`-th node in the cell with hash `cell`.
#[inline(always)]
pub(super) fn bits(cell: u32, k: u32) -> u32 {
    let h = cell.wrapping_add(k.wrapping_mul(STEP[0]));
    let h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    let h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    h ^ (h >> 15)
}

/// The place of a node in its cell in grains, less half a grain.
#[inline(always)]
pub(super) fn place(bits: u32) -> [u32; 3] {
    [bits >> 22, bits >> 12 & 1023, bits >> 2 & 1023]
}

/// A node's place is a multiple of this, less half of it.
pub(super) const GRAIN: f64 = 1.0 / 1024.0;

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

/// Where a point stands relative to the cells around.
struct Frame {
    key: [u32; 2],
    quantiles: &'static [u32; MOST],
    /// Fractions, mirrored into the upper half.
    upper: [f64; 3],
    /// Products of the axes in the words of cells, by offset.
    words: [[u32; SPAN]; 3],
    /// Places of the point relative to the cells, less half a grain, by offset.
    places: [[f64; SPAN]; 3],
    nowhere: f64,
}

impl Frame {
    #[inline(always)]
    fn new(lattice: &Lattice, at: [f64; 3], reach: usize) -> Frame {
        let mut frame = Frame {
            key: lattice.key(),
            quantiles: quantiles(),
            upper: [0.0; 3],
            words: [[0; SPAN]; 3],
            places: [[0.0; SPAN]; 3],
            nowhere: 0.0,
        };
        for axis in 0..3 {
            let (home, t) = split(at[axis]);
            let side = if t < 0.5 { u32::MAX } else { 1 };
            frame.nowhere += t * 0.0;
            frame.upper[axis] = if t < 0.5 { 1.0 - t } else { t };
            for n in REACH - reach..=REACH + reach {
                let step = side.wrapping_mul((n as u32).wrapping_sub(REACH as u32));
                let cell = lattice.wrap(axis, home.wrapping_add(step));
                frame.words[axis][n] = cell.wrapping_mul(STEP[axis]);
                frame.places[axis][n] = t - f64::from(step as i32) - 0.5 * GRAIN;
            }
        }
        // A point that is nowhere is near nothing, whatever its other coordinates.
        frame.upper = frame.upper.map(|x| x + frame.nowhere);
        frame
    }

    /// Calls `each` with the offset from every node in a cell, unless the cell is not nearer than a
    /// limit.
    #[inline(always)]
    fn visit<M: Metric>(&self, metric: M, cell: &Cell, limit: f64, mut each: impl FnMut([f64; 3])) {
        let gap = [0, 1, 2].map(|axis| cell.gaps[axis][0] * self.upper[axis] + cell.gaps[axis][1]);
        if metric.floor(gap) < limit {
            let [u, v, w] = [0, 1, 2].map(|axis| self.words[axis][cell.index[axis]]);
            let at = [0, 1, 2].map(|axis| self.places[axis][cell.index[axis]]);
            let h = hash(u ^ v ^ w, self.key);
            for (k, _) in self.quantiles.iter().enumerate().take_while(|(_, least)| h >= **least) {
                let node = place(bits(h, k as u32)).map(|x| f64::from(x as i32) * GRAIN);
                each([at[0] - node[0], at[1] - node[1], at[2] - node[2]]);
            }
        }
    }
}

impl<M: Metric> Search<'_, M> {
    /// The nearest nodes of a point.
    #[inline(always)]
    pub(super) fn nearest<const K: usize>(&self, at: [f64; 3]) -> Found<K, 1> {
        let metric = self.metric;
        let frame = Frame::new(self.lattice, at, self.reach());
        let cap = metric.measure([self.cap, 0.0, 0.0], f64::INFINITY);
        let mut found = Found::<K, 1>::new(cap, [frame.nowhere]);
        for cell in self.cells {
            let limit = found.measure[K - 1][0];
            if cell.least >= limit {
                break;
            }
            frame.visit(metric, cell, limit, |d| {
                found.insert(0, metric.measure(d, found.measure[K - 1][0]), d);
            });
        }
        found
    }

    /// Calls `each` with the offset from every node that may be nearer than `limit`, which is at most
    /// the cap, and with some that are not.
    pub(super) fn within(&self, at: [f64; 3], limit: f64, mut each: impl FnMut([f64; 3])) {
        let frame = Frame::new(self.lattice, at, self.reach());
        let limit = self.metric.measure([limit, 0.0, 0.0], f64::INFINITY);
        for cell in self.cells.iter().take_while(|cell| cell.least < limit) {
            frame.visit(self.metric, cell, limit, &mut each);
        }
    }

    /// Cells on each side within the cap.
    #[inline(always)]
    pub(super) fn reach(&self) -> usize {
        (self.cap as usize).min(REACH)
    }
}

impl<const K: usize, const B: usize> Found<K, B> {
    /// Nothing nearer than the cap.
    #[inline(always)]
    pub(super) fn new(cap: f64, nowhere: [f64; B]) -> Found<K, B> {
        Found { measure: [[cap; B]; K], offset: [[[0.0; B]; 3]; K], nowhere }
    }

    /// Puts a node into the order of lane `i`, after those that are as near. Whether there are any.
    #[inline(always)]
    pub(super) fn insert(&mut self, i: usize, measure: f64, offset: [f64; 3]) -> bool {
        let (mut m, mut d, mut tied) = (measure, offset, false);
        for l in 0..K {
            let own = self.measure[l][i];
            let nearer = m < own;
            tied |= measure == own;
            self.measure[l][i] = if nearer { m } else { own };
            m = if nearer { own } else { m };
            for axis in 0..3 {
                let own = self.offset[l][axis][i];
                self.offset[l][axis][i] = if nearer { d[axis] } else { own };
                d[axis] = if nearer { own } else { d[axis] };
            }
        }
        tied
    }

    /// Puts a node into the order of every lane, and marks those where there is one as near. Not part
    /// of what is compiled for wide vectors, where sorting in lanes is slow at best: for AVX2 the
    /// compiler has been seen to mix up offsets.
    #[inline(never)]
    pub(super) fn insert_all(&mut self, measure: &[f64; B], offset: &[[f64; B]; 3], tied: &mut [bool; B]) {
        for i in 0..B {
            tied[i] |= self.insert(i, measure[i], [offset[0][i], offset[1][i], offset[2][i]]);
        }
    }

    /// Has lane `i` be those of a point.
    pub(super) fn replace(&mut self, i: usize, point: &Found<K, 1>) {
        for l in 0..K {
            self.measure[l][i] = point.measure[l][0];
            for axis in 0..3 {
                self.offset[l][axis][i] = point.offset[l][axis][0];
            }
        }
    }
}
