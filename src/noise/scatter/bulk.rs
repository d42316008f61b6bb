//! Sums of spots in bulk: the lanes are points.

use super::{BEYOND, Draw, GRADIENT, HESSIAN, Scatter, Spot, VALUE};
use crate::noise::lattice::{Lattice, STEP, split};
use crate::num::{Jets, Level, at_level};

/// Lanes a block in bulk: two vectors of the widest instruction set.
const BLOCK: usize = 16;

/// [`Basis::jets`](crate::noise::Basis::jets) for spots.
pub(in crate::noise) fn jets<S: Spot>(
    scatter: &Scatter,
    spot: &S,
    lattice: &Lattice,
    level: Level,
    at: [&[f64]; 3],
    out: Jets<'_>,
) {
    let job = Job { draw: scatter.draw(lattice), spot, lattice, level, at };
    match out {
        Jets { value, grad: None, .. } => job.run::<VALUE, 1>([value]),
        Jets { value, grad: Some([x, y, z]), hess: None } => job.run::<GRADIENT, 4>([value, x, y, z]),
        Jets { value, grad: Some([x, y, z]), hess: Some([xx, yy, zz, xy, xz, yz]) } => {
            job.run::<HESSIAN, 10>([value, x, y, z, xx, yy, zz, xy, xz, yz]);
        }
    }
}

/// A batch to evaluate.
struct Job<'a, S> {
    draw: Draw,
    spot: &'a S,
    lattice: &'a Lattice,
    level: Level,
    at: [&'a [f64]; 3],
}

impl<S: Spot> Job<'_, S> {
    #[inline(always)]
    fn run<const ORDER: u8, const PARTS: usize>(&self, mut out: [&mut [f64]; PARTS]) {
        at_level(
            self.level,
            #[inline(always)]
            || {
                for start in (0..self.at[0].len()).step_by(BLOCK) {
                    let count = (self.at[0].len() - start).min(BLOCK);
                    let (mut from, mut to) = ([[0.0; BLOCK]; 3], [[0.0; BLOCK]; PARTS]);
                    for (own, at) in from.iter_mut().zip(self.at) {
                        own[..count].copy_from_slice(&at[start..start + count]);
                        // The last block is filled with copies of a point, which reach no cells of
                        // their own.
                        let last = own[count - 1];
                        own[count..].fill(last);
                    }
                    self.block::<ORDER, PARTS>(&from, &mut to);
                    for (slice, part) in out.iter_mut().zip(&to) {
                        slice[start..start + count].copy_from_slice(&part[..count]);
                    }
                }
            },
        );
    }

    #[inline(always)]
    fn block<const ORDER: u8, const PARTS: usize>(
        &self,
        from: &[[f64; BLOCK]; 3],
        to: &mut [[f64; BLOCK]; PARTS],
    ) {
        let draw = &self.draw;
        let (mut words, mut reach) = ([[[0; BLOCK]; 3]; 3], [[[0.0; BLOCK]; 3]; 3]);
        let mut away = reach;
        let mut start = [0.0; BLOCK];
        for axis in 0..3 {
            for i in 0..BLOCK {
                let (cell, t) = split(from[axis][i]);
                start[i] += t * t;
                for o in 0..3 {
                    words[axis][o][i] = cell.wrapping_add(o as u32).wrapping_sub(1);
                    reach[axis][o][i] = t - (o as f64 - 1.0) - draw.margin;
                    away[axis][o][i] = draw.distance(reach[axis][o][i]);
                }
            }
            if self.lattice.tiles() {
                words[axis].as_flattened_mut().iter_mut().for_each(|w| *w = self.lattice.wrap(axis, *w));
            }
            words[axis].as_flattened_mut().iter_mut().for_each(|w| *w = w.wrapping_mul(STEP[axis]));
        }
        // Zero, or NaN where there is no place.
        to.iter_mut().for_each(|part| (0..BLOCK).for_each(|i| part[i] = 0.0 * start[i]));
        for slot in 0..draw.slots {
            for cell in 0..27 {
                let o = [cell % 3, cell / 3 % 3, cell / 9];
                let [u, v, w] = [0, 1, 2].map(|axis| &words[axis][o[axis]]);
                let [x, y, z] = [0, 1, 2].map(|axis| &reach[axis][o[axis]]);
                let mut seen = 0_u32;
                for i in 0..BLOCK {
                    let [x, y, z] = [0, 1, 2].map(|axis| away[axis][o[axis]][i]);
                    // A lane that is nowhere is NaN already, with or without this cell.
                    seen |= u32::from(x + (y + z) < BEYOND);
                }
                if seen == 0 {
                    continue;
                }
                let mut present = [true; BLOCK];
                if let Some(tail) = draw.tail {
                    for i in 0..BLOCK {
                        present[i] = draw.count(u[i] ^ v[i] ^ w[i]) < tail[slot];
                    }
                    if present.iter().all(|p| !p) {
                        continue;
                    }
                }
                for i in 0..BLOCK {
                    let mut node = draw.node(u[i] ^ v[i] ^ w[i], slot, [x[i], y[i], z[i]]);
                    node.weight = if present[i] { node.weight } else { 0.0 };
                    let p = self.spot.jet::<ORDER>(&node);
                    to[0][i] += p.value;
                    if ORDER >= GRADIENT {
                        for k in 0..3 {
                            to[1 + k][i] += p.grad[k];
                        }
                    }
                    if ORDER >= HESSIAN {
                        for k in 0..6 {
                            to[4 + k][i] += p.hess[k];
                        }
                    }
                }
            }
        }
    }
}
