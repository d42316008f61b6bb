//! Bounds on a spline, over all of space and over any ball, from the differences of its coefficients.
//!
//! The derivative of a B-spline by one coordinate is the B-spline of one degree less on that axis
//! whose coefficients are the differences along it, divided by the spacing. Weights are not negative
//! and sum to 1. So any derivative lies in the hull of the differences that reach the point, and the
//! largest of them bounds it:
//!
//! ```text
//! |d^(a+b+c) s / dx^a dy^b dz^c|  <=  max |D_x^a D_y^b D_z^c c| / (hx^a hy^b hz^c),    a, b, c <= 3
//! ```
//!
//! This is done for blocks of cells, each with the coefficients that reach it. Mountains are steep in
//! few places, and a box is bounded by the blocks that it touches. Over the blocks stands a pyramid
//! of maxima, so that a box of any size touches a few blocks of the right level.

use super::{Cancel, Edge, Frame};
use crate::num::{Bounds, Interval, ROUNDOFF};
use rayon::prelude::*;

/// Bounds of blocks, and of blocks of blocks.
#[derive(Debug)]
pub(super) struct Pyramid {
    levels: Vec<Level>,
    all: Block,
    /// The hull of the first and the last coefficients along each axis, which are all that counts beyond the margins.
    rims: [[Interval; 2]; 3],
}

/// What is known of a block.
#[derive(Clone, Copy, Debug)]
struct Block {
    bounds: Bounds,
    /// The hull of the coefficients that reach it, and so of the values.
    values: Interval,
}

/// Blocks of one size.
#[derive(Debug)]
struct Level {
    /// Cells along the edges of a block.
    edge: [usize; 3],
    /// Blocks along each axis.
    size: [usize; 3],
    blocks: Vec<Block>,
}

/// Cells beyond the first and the last sample of a clamped grid: two before, where the spline comes
/// to rest, and as many after.
const MARGIN: usize = 2;

/// Number of cells along an axis.
fn cells(n: usize, edge: Edge) -> usize {
    match edge {
        _ if n == 1 => 1,
        Edge::Repeat => n,
        Edge::Clamp => n + 2 * MARGIN,
    }
}

const NOTHING: Block = Block {
    bounds: Bounds { range: 0.0, lipschitz: 0.0, hessian: 0.0, third: 0.0 },
    values: Interval { lo: f64::INFINITY, hi: f64::NEG_INFINITY },
};

const EVERYTHING: Block = {
    let most = f64::INFINITY;
    let bounds = Bounds { range: most, lipschitz: most, hessian: most, third: most };
    Block { bounds, values: Interval::ENTIRE }
};

fn hull(a: Block, b: Block) -> Block {
    let (x, y) = (a.bounds, b.bounds);
    let bounds = Bounds {
        range: x.range.max(y.range),
        lipschitz: x.lipschitz.max(y.lipschitz),
        hessian: x.hessian.max(y.hessian),
        third: x.third.max(y.third),
    };
    Block { bounds, values: a.values.hull(b.values) }
}

/// The least interval that holds all of some numbers.
fn hull_of(numbers: impl Iterator<Item = f64>) -> Interval {
    numbers.map(Interval::point).fold(NOTHING.values, Interval::hull)
}

impl Pyramid {
    /// The bounds of a spline. When cancelled it has none in the blocks that are left.
    pub(super) fn new(frame: &Frame, scale: [f64; 3], coefficients: &[f64], cancel: Cancel<'_>) -> Pyramid {
        let count = frame.size.map(|n| cells(n, frame.edge));
        // Small blocks where there are few of them: a heightfield.
        let side = if frame.size.contains(&1) { 4 } else { 8 };
        let edge = count.map(|n| side.min(n));
        let size: [usize; 3] = std::array::from_fn(|axis| count[axis].div_ceil(edge[axis]));
        let [bx, by, bz] = size;
        let mut blocks = vec![EVERYTHING; bx * by * bz];
        let rows = blocks.par_chunks_mut(bx).enumerate();
        rows.for_each_init(<[Patch; 4]>::default, |patches, (row, blocks)| {
            for (i, block) in blocks.iter_mut().enumerate().take_while(|_| !cancel()) {
                let at = [i * edge[0], row % by * edge[1], row / by * edge[2]];
                patches[0].cut(frame, coefficients, at, edge);
                let values = hull_of(patches[0].values.iter().copied());
                *block = Block { bounds: bounds(patches, scale), values };
            }
        });
        let all = blocks.iter().copied().fold(NOTHING, hull);
        let mut levels = vec![Level { edge, size, blocks }];
        while let Some(coarser) = levels.last().and_then(Level::coarser) {
            levels.push(coarser);
        }
        Pyramid { levels, all, rims: rims(frame, coefficients) }
    }

    /// Bounds over all of space.
    #[inline]
    pub(super) fn all(&self) -> Bounds {
        self.all.bounds
    }

    /// The largest coefficient.
    pub(super) fn magnitude(&self) -> f64 {
        self.all.bounds.range
    }

    /// Bounds over the ball around a point.
    pub(super) fn around(&self, frame: &Frame, scale: [f64; 3], at: [f64; 3], radius: f64) -> Bounds {
        match spans(frame, scale, at, [radius; 3]) {
            Some(spans) => self.within(&spans, frame).bounds,
            None => self.all.bounds,
        }
    }

    /// The hull of the coefficients that matter in a box, given by its middle and half its edges.
    pub(super) fn values(&self, frame: &Frame, scale: [f64; 3], at: [f64; 3], half: [f64; 3]) -> Interval {
        let Some(spans) = spans(frame, scale, at, half) else { return self.all.values };
        let mut values = self.within(&spans, frame).values;
        for axis in (0..3).filter(|&axis| frame.edge == Edge::Clamp && frame.size[axis] > 1) {
            let Span { first, count } = spans[axis];
            let last = cells(frame.size[axis], frame.edge) - 1;
            let [low, high] = self.rims[axis];
            match (first, count) {
                (0, 1) => values = values.meet(low),
                (first, _) if first == last => values = values.meet(high),
                _ => {}
            }
        }
        values
    }

    /// What is known of the blocks that some cells are in.
    fn within(&self, spans: &[Span; 3], frame: &Frame) -> Block {
        let coarse = |level: &Level| (0..3).all(|axis| spans[axis].count <= 2 * level.edge[axis] + 1);
        self.levels.iter().find(|l| coarse(l)).map_or(self.all, |level| level.over(spans, frame))
    }
}

/// The hull of the first and the last coefficients along each axis.
fn rims(frame: &Frame, coefficients: &[f64]) -> [[Interval; 2]; 3] {
    let size = frame.size;
    let strides = [1, size[0], size[0] * size[1]];
    [0, 1, 2].map(|axis| {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        [0, size[axis] - 1].map(|place| {
            let plane = (0..size[v]).flat_map(|j| (0..size[u]).map(move |i| i * strides[u] + j * strides[v]));
            hull_of(plane.map(|i| coefficients[place * strides[axis] + i]))
        })
    })
}

/// The cells along each axis that a box may reach, given by its middle and half its edges; `None` where that is all of them.
fn spans(frame: &Frame, scale: [f64; 3], at: [f64; 3], half: [f64; 3]) -> Option<[Span; 3]> {
    let mut spans = [Span { first: 0, count: 1 }; 3];
    for axis in (0..3).filter(|&axis| frame.size[axis] > 1) {
        let u = (at[axis] - frame.origin[axis]) * scale[axis];
        // The cells that the true point may be in, rounded or not.
        let reach = half[axis] * scale[axis]
            + 1e-12
            + 16.0 * ROUNDOFF * (at[axis].abs() + frame.origin[axis].abs()) * scale[axis];
        // Where these are no numbers, nothing is known of cells.
        if !(u + reach).is_finite() {
            return None;
        }
        spans[axis] = Span::new(u, reach, frame.size[axis], frame.edge)?;
    }
    Some(spans)
}

/// Cells along an axis that repeats, or not.
#[derive(Clone, Copy)]
struct Span {
    first: usize,
    count: usize,
}

impl Span {
    /// The cells within `reach` of `u`; `None` for all of them.
    #[inline]
    fn new(u: f64, reach: f64, n: usize, edge: Edge) -> Option<Span> {
        let (lo, hi) = ((u - reach).floor(), (u + reach).floor());
        let all = cells(n, edge);
        match edge {
            Edge::Clamp => {
                // Not a number is clamped to one that is not either, and becomes 0.
                let within = |v: f64| (v + MARGIN as f64).clamp(0.0, (all - 1) as f64) as usize;
                let (lo, hi) = (within(lo), within(hi));
                (lo <= hi).then_some(Span { first: lo, count: hi - lo + 1 })
            }
            Edge::Repeat => {
                let size = n as f64;
                if !(hi - lo < size - 1.0 && lo.abs() < 4e15) {
                    return None;
                }
                let first = lo - size * (lo / size).floor();
                let first = if first < 0.0 { first + size } else { first };
                Some(Span { first: (first as usize).min(n - 1), count: (hi - lo) as usize + 1 })
            }
        }
    }
}

impl Level {
    /// Blocks of twice the size; `None` for a single block.
    fn coarser(&self) -> Option<Level> {
        if self.blocks.len() == 1 {
            return None;
        }
        let edge = std::array::from_fn(|axis| self.edge[axis] * if self.size[axis] > 1 { 2 } else { 1 });
        let half = self.size.map(|n| n.div_ceil(2));
        let mut blocks = vec![NOTHING; half.iter().product()];
        for (i, block) in self.blocks.iter().enumerate() {
            let [x, y, z] =
                [i % self.size[0], i / self.size[0] % self.size[1], i / (self.size[0] * self.size[1])];
            let to = &mut blocks[(z / 2 * half[1] + y / 2) * half[0] + x / 2];
            *to = hull(*to, *block);
        }
        Some(Level { edge, size: half, blocks })
    }

    fn over(&self, spans: &[Span; 3], frame: &Frame) -> Block {
        let ranges: [(usize, usize); 3] = std::array::from_fn(|axis| {
            let Span { first, count } = spans[axis];
            let all = cells(frame.size[axis], frame.edge);
            let (block, last) = (first / self.edge[axis], first + count - 1);
            let blocks = if last < all {
                last / self.edge[axis] - block + 1
            } else {
                self.size[axis] - block + (last - all) / self.edge[axis] + 1
            };
            (block, blocks.min(self.size[axis]))
        });
        let wrap = |axis: usize, k: usize| {
            let i = ranges[axis].0 + k;
            if i < self.size[axis] { i } else { i - self.size[axis] }
        };
        let mut found = NOTHING;
        for k in 0..ranges[2].1 {
            for j in 0..ranges[1].1 {
                let row = (wrap(2, k) * self.size[1] + wrap(1, j)) * self.size[0];
                for i in 0..ranges[0].1 {
                    found = hull(found, self.blocks[row + wrap(0, i)]);
                }
            }
        }
        found
    }
}

/// A box of coefficients or of their differences, in memory that many take their turns in.
#[derive(Default)]
struct Patch {
    size: [usize; 3],
    values: Vec<f64>,
}

impl Patch {
    /// The coefficients that reach a block of cells.
    fn cut(&mut self, frame: &Frame, coefficients: &[f64], at: [usize; 3], edge: [usize; 3]) {
        let [nx, ny, _] = frame.size;
        let before = 1 + if frame.edge == Edge::Clamp { MARGIN } else { 0 };
        self.size = std::array::from_fn(|axis| match frame.size[axis] {
            1 => 1,
            n => edge[axis].min(cells(n, frame.edge) - at[axis]) + 3,
        });
        let index = |axis: usize, k: usize| match frame.size[axis] {
            1 => 0,
            n => frame.neighbour(at[axis] + k, -(before as isize), n),
        };
        self.values.clear();
        for z in 0..self.size[2] {
            for y in 0..self.size[1] {
                let row = (index(2, z) * ny + index(1, y)) * nx;
                self.values.extend((0..self.size[0]).map(|x| coefficients[row + index(0, x)]));
            }
        }
    }

    /// The differences of another along an axis; none along one where nothing changes.
    fn difference(&mut self, of: &Patch, axis: usize) {
        self.values.clear();
        self.size = of.size;
        if self.size[axis] < 2 {
            self.size = [0; 3];
            return;
        }
        self.size[axis] -= 1;
        let [nx, ny, _] = of.size;
        let step = [1, nx, nx * ny][axis];
        for z in 0..self.size[2] {
            for y in 0..self.size[1] {
                let row = (z * ny + y) * nx;
                let (here, next) = (&of.values[row..][..self.size[0]], &of.values[row + step..]);
                self.values.extend(here.iter().zip(next).map(|(a, b)| b - a));
            }
        }
    }

    fn largest(&self) -> f64 {
        // Side by side, for each of these waits for the one before it; and all are numbers.
        let mut most = [0.0_f64; 8];
        let widen = |most: &mut f64, v: &f64| *most = if v.abs() > *most { v.abs() } else { *most };
        let chunks = self.values.chunks_exact(most.len());
        most.iter_mut().zip(chunks.remainder()).for_each(|(most, v)| widen(most, v));
        chunks.for_each(|chunk| most.iter_mut().zip(chunk).for_each(|(most, v)| widen(most, v)));
        most.into_iter().fold(0.0, f64::max)
    }
}

/// Bounds of the block that the first of these patches reaches; the others are for its differences.
fn bounds([patch, d1, d2, d3]: &mut [Patch; 4], scale: [f64; 3]) -> Bounds {
    let range = patch.largest();
    // A difference of order k has 2^k terms and k roundings of each.
    let bound = |patch: &Patch, order: i32, scale: f64| {
        if patch.values.is_empty() {
            0.0
        } else {
            (patch.largest() + 32.0 * f64::from(order) * ROUNDOFF * range) * scale
        }
    };
    let mut first = [0.0; 3];
    let mut second = [[0.0; 3]; 3];
    let mut third = [[[0.0; 3]; 3]; 3];
    for i in 0..3 {
        d1.difference(patch, i);
        first[i] = bound(d1, 1, scale[i]);
        for j in i..3 {
            d2.difference(d1, j);
            second[i][j] = bound(d2, 2, scale[i] * scale[j]);
            second[j][i] = second[i][j];
            for k in j..3 {
                d3.difference(d2, k);
                let b = bound(d3, 3, scale[i] * scale[j] * scale[k]);
                for [p, q, r] in [[i, j, k], [i, k, j], [j, i, k], [j, k, i], [k, i, j], [k, j, i]] {
                    third[p][q][r] = b;
                }
            }
        }
    }
    Bounds {
        range,
        lipschitz: length(first),
        hessian: spectral(second),
        // |T(u, u, .)| for unit u has the components u^T T_i u.
        third: length(third.map(spectral)),
    }
}

/// Covers the roundings of a norm.
const ROUND_UP: f64 = 1.0 + 64.0 * ROUNDOFF;

fn length([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt() * ROUND_UP
}

/// Bound on the spectral norm of every symmetric matrix whose entries are no larger than those of
/// `m`, which is the largest eigenvalue of `m` (Perron and Frobenius): for any positive `v` it is at
/// most the largest of `(m v)_i / v_i` (Collatz and Wielandt), and close to that for a `v` near the
/// eigenvector, which a few multiplications find.
fn spectral(m: [[f64; 3]; 3]) -> f64 {
    let times = |v: [f64; 3]| m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
    let most = m.iter().flatten().fold(0.0, |most: f64, v| most.max(*v));
    if most == 0.0 {
        return 0.0;
    }
    let mut v = [1.0; 3];
    for _ in 0..6 {
        let image = times(v);
        let largest = image[0].max(image[1]).max(image[2]);
        // Positive everywhere, or the quotient says nothing.
        v = std::array::from_fn(|i| image[i] / largest + 1e-3);
    }
    let image = times(v);
    (0..3).map(|i| image[i] / v[i]).fold(0.0, f64::max) * ROUND_UP
}
