//! Sums of spots in bulk: the lanes are points.

use super::{BEYOND, Draw, Scatter, Spot};
use crate::noise::bulk::{self, GRADIENT, HESSIAN, Lanes};
use crate::noise::lattice::{Lattice, STEP, split};
use crate::num::Jets;

/// [`Basis::jets`](crate::noise::Basis::jets) for spots.
pub(in crate::noise) fn jets<S: Spot>(
    scatter: &Scatter,
    spot: &S,
    lattice: &Lattice,
    at: [&[f64]; 3],
    out: Jets<'_>,
) {
    bulk::jets(|| Field { draw: scatter.draw(lattice), spot: *spot, lattice: *lattice }, at, out);
}

/// A noise made of spots.
#[derive(Clone, Copy)]
struct Field<S> {
    draw: Draw,
    spot: S,
    lattice: Lattice,
}

impl<S: Spot> Lanes for Field<S> {
    #[inline(always)]
    fn block<const ORDER: u8, const PARTS: usize, const B: usize>(
        &mut self,
        from: &[[f64; B]; 3],
        to: &mut [[f64; B]; PARTS],
    ) {
        let draw = &self.draw;
        let (mut words, mut reach) = ([[[0; B]; 3]; 3], [[[0.0; B]; 3]; 3]);
        let mut away = reach;
        let mut start = [0.0; B];
        for axis in 0..3 {
            for i in 0..B {
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
        to.iter_mut().for_each(|part| (0..B).for_each(|i| part[i] = 0.0 * start[i]));
        for slot in 0..draw.slots {
            for cell in 0..27 {
                let o = [cell % 3, cell / 3 % 3, cell / 9];
                let [u, v, w] = [0, 1, 2].map(|axis| &words[axis][o[axis]]);
                let [x, y, z] = [0, 1, 2].map(|axis| &reach[axis][o[axis]]);
                let mut seen = 0_u32;
                for i in 0..B {
                    let [x, y, z] = [0, 1, 2].map(|axis| away[axis][o[axis]][i]);
                    // A lane that is nowhere is NaN already, with or without this cell.
                    seen |= u32::from(x + (y + z) < BEYOND);
                }
                if seen == 0 {
                    continue;
                }
                let mut present = [true; B];
                if let Some(tail) = draw.tail {
                    for i in 0..B {
                        present[i] = draw.count(u[i] ^ v[i] ^ w[i]) < tail[slot];
                    }
                    if present.iter().all(|p| !p) {
                        continue;
                    }
                }
                for i in 0..B {
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
