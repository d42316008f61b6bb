//! Separatrices to look at: the streamlines of `-grad f` from a 1-saddle down to the minima on both sides.
//!
//! What is joined with what is decided elsewhere ([`descent`](super::descent)); these are for pictures. The
//! unit vector field `-grad f / |grad f|` is integrated by the classical method of Runge and Kutta in steps
//! that are a small share of the region at most, until it is a few steps from a minimum in whose basin it is. (In a basin a
//! straight line would lead down too, but streamlines bend there as they do anywhere.) The rest is a straight line to the
//! minimum of the basin, or to the one that is known to be the end where even short steps do not lead down. Of the places that
//! a line came by it keeps those that it needs to stay close to all (Douglas and Peucker 1973).

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

/// How far from places that it came by a line may pass, in steps.
const CLOSE: f64 = 0.1;

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
        thinned(&line, CLOSE * step)
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

/// The points of a line without which it would pass some of them at more than a distance.
fn thinned(line: &[DVec3], most: f64) -> Vec<DVec3> {
    let mut kept = vec![line[0]];
    // The ends of pieces that are left to be thinned, the first one last.
    let mut pieces = vec![(0, line.len() - 1)];
    while let Some((from, to)) = pieces.pop() {
        let off = |i: usize| distance(line[i], [line[from], line[to]]);
        let between = from + 1..to;
        let farthest = between.map(|i| (off(i), i)).max_by(|a, b| a.0.total_cmp(&b.0));
        match farthest.filter(|farthest| farthest.0 > most) {
            Some((_, middle)) => pieces.extend([(middle, to), (from, middle)]),
            None => kept.push(line[to]),
        }
    }
    kept
}

/// How far a point is from the straight line between two others.
fn distance(p: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    let along = b - a;
    let share = (p - a).dot(along) / along.length_squared();
    // Nothing is between two points at one place.
    let share = if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) };
    p.distance(a + share * along)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thin_lines_pass_all_points_closely() {
        let turn = |i: u32| {
            let angle = 0.01 * f64::from(i);
            DVec3::new(libm::cos(angle), libm::sin(angle), 0.1 * angle)
        };
        let straight = (0..100).map(|i| DVec3::new(1.0 - 0.01 * f64::from(i), 0.0, -1.0));
        let line: Vec<DVec3> = (0..600).map(turn).chain(straight).collect();
        let close = 1e-3;
        let thin = thinned(&line, close);
        assert!((20..120).contains(&thin.len()), "{} points", thin.len());
        assert_eq!((thin.first(), thin.last()), (line.first(), line.last()));
        for p in &line {
            let least = thin.windows(2).map(|ends| distance(*p, [ends[0], ends[1]]));
            assert!(least.fold(f64::INFINITY, f64::min) <= close, "{p}");
        }
        assert_eq!(thinned(&line[..2], close), line[..2]);
        assert_eq!(thinned(&[DVec3::ONE; 3], close), [DVec3::ONE; 2]);
    }
}
