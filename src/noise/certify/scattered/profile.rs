//! Upper bounds of `g_k` over boxes of offsets.
//!
//! For a direction `v`, `g_k` depends on two numbers: how far the offset `d` reaches along `v`, and how
//! far aside, `p = |d.v|` and `q = |d - (d.v) v|`. Over small squares of `p` and `q` it is bounded
//! once, by its value in the middle and bounds on slopes ([`Spots::slopes`]), whatever `v`. A box of
//! offsets meets a rectangle of squares, whose largest bound comes from tables of the largest bounds in
//! blocks of 2, 4, 8, ... squares from each square on.

use super::spots::{Spots, dot};
use std::f64::consts::TAU;

/// Squares to a unit of length.
const FINE: usize = 1024;

/// Levels of blocks: the largest are 128 squares wide, more than a voxel of the coarsest proofs.
const LEVELS: usize = 8;

/// More than the rounding of coordinates.
const NEARLY: f64 = 1e-12;

/// Upper bounds of `g_k`.
pub(super) struct Profile {
    spots: Spots,
    k: usize,
    /// The largest bound in the block of `2^l` squares from a square on along both axes; `p` is outer.
    blocks: Vec<Vec<f32>>,
}

impl Profile {
    pub(super) fn new(spots: &Spots, k: usize) -> Profile {
        let one = |i: usize| above(square(spots, k, i / FINE, i % FINE));
        let mut blocks: Vec<Vec<f32>> = vec![(0..FINE * FINE).map(one).collect()];
        for level in 1..LEVELS {
            let (below, half) = (&blocks[level - 1], 1 << (level - 1));
            let at = |i: usize, j: usize| below[i.min(FINE - 1) * FINE + j.min(FINE - 1)];
            let four = |n: usize| {
                let (i, j) = (n / FINE, n % FINE);
                at(i, j).max(at(i + half, j)).max(at(i, j + half)).max(at(i + half, j + half))
            };
            let next = (0..FINE * FINE).map(four).collect();
            blocks.push(next);
        }
        Profile { spots: *spots, k, blocks }
    }

    /// Upper bound over the voxel of side `e` at `low`.
    pub(super) fn voxel(&self, v: [f64; 3], low: [f64; 3], e: f64) -> f32 {
        let near: f64 = low.map(|a| f64::max(a, -(a + e)).max(0.0)).map(|a| a * a).into_iter().sum();
        if near >= 1.0 + NEARLY {
            return 0.0;
        }
        if self.k == 0 {
            // Spots fall with distance.
            return above(self.spots.size(0, near.sqrt().min(1.0), 0.0));
        }
        let size = |v: [f64; 3]| 0.5 * e * (v[0].abs() + v[1].abs() + v[2].abs());
        let middle = low.map(|a| a + 0.5 * e);
        let (p, along) = (dot(middle, v), size(v));
        let aside = [0, 1, 2].map(|i| middle[i] - p * v[i]);
        let (q, rho) = (dot(aside, aside).sqrt(), 0.5 * e * 3.0_f64.sqrt());
        // The distance aside changes by what an offset adds along `aside`, and across it by rho at most.
        let toward = if q > NEARLY { size(aside.map(|a| a / q)) } else { rho };
        let most = f64::min(q + rho, ((q + toward) * (q + toward) + rho * rho).sqrt());
        self.rectangle([p.abs() - along, p.abs() + along], [q - toward, most])
    }

    /// Largest bound of the squares that meet a rectangle.
    fn rectangle(&self, p: [f64; 2], q: [f64; 2]) -> f32 {
        let [[i, last_i], [j, last_j]] = [p, q].map(|[low, high]| {
            [low - NEARLY, high + NEARLY].map(|a| ((a.max(0.0) * FINE as f64) as usize).min(FINE - 1))
        });
        let least = (last_i - i).min(last_j - j) + 1;
        let level = (least.ilog2() as usize).min(LEVELS - 1);
        let (step, table) = (1 << level, &self.blocks[level]);
        let starts =
            |first: usize, last: usize| (first..=last).step_by(step).map(move |a| a.min(last + 1 - step));
        let mut most = 0.0;
        for a in starts(i, last_i) {
            for b in starts(j, last_j) {
                most = f32::max(most, table[a * FINE + b]);
            }
        }
        most
    }
}

/// A number above another, with more to spare than the roundings of both.
fn above(x: f64) -> f32 {
    (x * (1.0 + 1e-6) + 1e-30) as f32
}

/// Upper bound of `g_k` in a square.
fn square(spots: &Spots, k: usize, i: usize, j: usize) -> f64 {
    let [p, q] = [i, j].map(|a| a as f64 / FINE as f64);
    let e = 1.0 / FINE as f64;
    let near = libm::hypot(p, q);
    if near >= 1.0 + NEARLY {
        return 0.0;
    }
    let (near, far) = (near.min(1.0), libm::hypot(p + e, q + e).min(1.0));
    let (least, most) = (p / libm::hypot(p, q + e), (p + e) / libm::hypot(p + e, q));
    let (reach, turn) = (0.5 * (far - near), 0.5 * (most - least));
    let slopes = spots.slopes(0.5 * (near + far), most, reach);
    // By what the real and the imaginary part can change.
    let (mut moved, mut top) = ([0.0; 2], [0.0; 2]);
    for (j, (slope, peak)) in slopes.into_iter().zip(spots.peaks()).enumerate().take(k + 1) {
        let weight = BINOMIAL[k][j] * (0..k - j).fold(1.0, |p, _| p * TAU * spots.frequency);
        moved[(k - j) % 2] += weight * (slope[0] * reach + slope[1] * turn);
        top[(k - j) % 2] += weight * peak;
    }
    let (moved, top) = (libm::hypot(moved[0], moved[1]), libm::hypot(top[0], top[1]));
    (spots.size(k, 0.5 * (near + far), 0.5 * (least + most)) + moved).min(top)
}

const BINOMIAL: [[f64; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0], [1.0, 2.0, 1.0, 0.0], [1.0, 3.0, 3.0, 1.0]];
