//! Separatrices to look at: the streamlines of `-grad f` from a 1-saddle down to the minima on both sides.
//!
//! What is joined with what is decided elsewhere ([`descent`](super::descent)); these are for pictures. The
//! unit vector field `-grad f / |grad f|` is integrated by the classical method of Runge and Kutta in steps
//! that are a small share of the region at most, until it is a few steps from a minimum in whose basin it is. (In a basin a
//! straight line would lead down too, but streamlines bend there as they do anywhere.) The rest is a straight line to the
//! minimum of the basin, or to the one that is known to be the end where even short steps do not lead down.

use super::complex::{Arc1, Complex};
use crate::num::Dual;
use crate::tape::{Evaluator, Tape};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;

/// Length of a step, as a share of the region's diagonal.
const STEP: f64 = 1e-3;

/// Steps from a minimum at which a line goes straight there.
const NEAR: f64 = 4.0;

/// Steps are halved where they do not lead down, as on the floors of narrow valleys, until they are as short as that share.
const SHORTEST: f64 = 1e-3;

/// Steps until a line is given up.
const STEPS: usize = 16_000;

/// Both separatrices of each of a complex's arcs as one line, from minimum to minimum through the saddle.
pub fn separatrices(tape: &Arc<Tape>, complex: &Complex) -> Vec<Vec<DVec3>> {
    let basins = complex.basins();
    let step = STEP * complex.region.diagonal();
    let place = |minimum: usize| complex.points[minimum].position;
    let trace = |field: &mut Evaluator<Dual>, from: DVec3, side: DVec3, end: Option<usize>| {
        let mut line = vec![from, from + 0.5 * step * side];
        let (mut at, mut length) = (line[1], step);
        let mut value = dual(field, at).value;
        let mut minimum = end;
        for _ in 0..STEPS {
            let within = basins.find(at).map(|i| complex.basins[i].0);
            minimum = within.or(end);
            let is_near = within.is_some_and(|minimum| place(minimum).distance(at) < NEAR * step);
            if is_near || length < SHORTEST * step {
                break;
            }
            let next = advanced(field, at, length);
            let below = dual(field, next).value;
            if below < value {
                (at, value, length) = (next, below, (2.0 * length).min(step));
                line.push(at);
            } else {
                length *= 0.5;
            }
        }
        line.extend(minimum.map(place));
        line
    };
    let arc = |field: &mut Evaluator<Dual>, arc: &Arc1| {
        let point = &complex.points[arc.saddle];
        let [back, forth] = arc.minima;
        let mut line = trace(field, point.position, -point.down, back);
        line.reverse();
        line.extend(trace(field, point.position, point.down, forth).into_iter().skip(1));
        line
    };
    complex.arcs.par_iter().map_init(|| Evaluator::new(tape.clone()), |field, a| arc(field, a)).collect()
}

fn dual(field: &mut Evaluator<Dual>, p: DVec3) -> Dual {
    *field.eval(&std::array::from_fn(|axis| Dual::coordinate(p[axis], axis)))
}

/// One step of length `h` down.
fn advanced(field: &mut Evaluator<Dual>, p: DVec3, h: f64) -> DVec3 {
    let mut down = |p: DVec3| -DVec3::from_array(dual(field, p).grad).normalize_or_zero();
    let a = down(p);
    let b = down(p + 0.5 * h * a);
    let c = down(p + 0.5 * h * b);
    let d = down(p + h * c);
    p + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
}
