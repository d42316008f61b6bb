//! Questions about many points at once: how far they are from the surface, and what colour they have.

use crate::num::{Dual, Many};
use crate::tape::{Cells, Evaluator, Tape};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;

/// Points evaluated together.
const LANES: usize = 16;

/// Points that one thread takes at a time.
const SHARE: usize = 4096;

/// The field at each point, and Newton's step from there to the surface: infinite where the field is flat, nothing where it
/// is infinitely steep, and not a number where it is none.
fn steps(cells: &Cells, points: &[DVec3]) -> Vec<(f64, DVec3)> {
    let mut out = vec![(f64::NAN, DVec3::NAN); points.len()];
    let mut field = Evaluator::<Many<Dual, LANES>>::new(cells.tape().clone());
    let places = points.iter().enumerate().map(|(i, p)| (i, p.to_array(), 0.0));
    for same in cells.tapes_around(places).chunk_by(|a, b| Arc::ptr_eq(a.0, b.0)) {
        field.turn_to(same[0].0);
        for batch in same.chunks(LANES) {
            let at = |lane: usize| points[batch[lane.min(batch.len() - 1)].1];
            let duals =
                |axis: usize| Many(std::array::from_fn(|lane| Dual::coordinate(at(lane)[axis], axis)));
            let duals = *field.eval(&std::array::from_fn(duals));
            for ((_, i), dual) in batch.iter().zip(duals.0) {
                let slope = DVec3::from_array(dual.grad);
                // Squares of what is not of common size are lost.
                let size = slope.abs().max_element();
                let unit = slope / size;
                // On the surface there may be no gradient.
                let step = if dual.value == 0.0 || size == f64::INFINITY {
                    DVec3::ZERO
                } else if size == 0.0 {
                    DVec3::INFINITY
                } else {
                    -(dual.value / size) * unit / unit.length_squared()
                };
                out[*i] = (dual.value, step);
            }
        }
    }
    out
}

/// The distance of each point from the surface, to first order: `|f| / |grad f|`. Not a number where the field is
/// not.
pub(super) fn distances(cells: &Cells, points: &[DVec3]) -> Vec<f64> {
    let share = |points: &[DVec3]| steps(cells, points).into_iter().map(|(_, step)| step.length());
    points.par_chunks(SHARE).flat_map_iter(share).collect()
}

/// How much farther than to where Newton's step leads one looks for the other side of the surface, walk by walk: the first
/// makes sure that the surface is no farther than that.
const FARTHER: [f64; 8] = [1.01, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0];

/// Times that the way to the other side is halved.
const HALVINGS: usize = 6;

/// No less, but for a hundredth, than the distance of each point from the surface: the length of Newton's step where that
/// leads to the other side; elsewhere, as where the surface has edges and where the gradient vanishes with the field,
/// as far as to a place on the other side. Not a number where none is found within `farthest`.
pub(super) fn reaches(cells: &Cells, points: &[DVec3], farthest: f64) -> Vec<f64> {
    let share = |points: &[DVec3]| share_of_reaches(cells, points, farthest);
    points.par_chunks(SHARE).flat_map_iter(share).collect()
}

fn share_of_reaches(cells: &Cells, points: &[DVec3], farthest: f64) -> Vec<f64> {
    let mut out = vec![f64::NAN; points.len()];
    let first = steps(cells, points);
    let (mut at, mut next) = (points.to_vec(), first.clone());
    let mut open: Vec<usize> = (0..points.len()).collect();
    let mut across = Vec::new();
    for (walk, farther) in FARTHER.into_iter().enumerate() {
        open.retain(|&i| {
            let step = next[i].1;
            at[i] += (farther * step).clamp_length_max(farthest);
            step.is_finite() && at[i].distance(points[i]) <= farthest * (1.0 + 1e-9)
        });
        let places: Vec<DVec3> = open.iter().map(|&i| at[i]).collect();
        let found = steps(cells, &places);
        open.iter().zip(found).for_each(|(&i, found)| next[i] = found);
        open.retain(|&i| {
            let is_across = (next[i].0 <= 0.0) != (first[i].0 <= 0.0);
            let step = first[i].1.length();
            let is_on_it = step <= 64.0 * f64::EPSILON * points[i].abs().max_element();
            let is_settled = is_on_it || is_across && walk == 0 && farther * step <= farthest;
            if is_settled {
                out[i] = step;
            } else if is_across {
                across.push(i);
            }
            !(is_settled || is_across)
        });
    }
    // The straight way to the other side crosses the surface.
    let mut ways: Vec<[f64; 2]> = vec![[0.0, 1.0]; across.len()];
    for _ in 0..HALVINGS {
        let middle = |([low, high], &i): (&[f64; 2], &usize)| points[i].lerp(at[i], 0.5 * (low + high));
        let places: Vec<DVec3> = ways.iter().zip(&across).map(middle).collect();
        for ((way, &i), (value, _)) in ways.iter_mut().zip(&across).zip(steps(cells, &places)) {
            let is_across = (value <= 0.0) != (first[i].0 <= 0.0);
            way[usize::from(is_across)] = 0.5 * (way[0] + way[1]);
        }
    }
    for (way, i) in ways.into_iter().zip(across) {
        out[i] = way[1] * at[i].distance(points[i]);
    }
    out
}

/// Linear colours between 0 and 1.
pub(super) fn colors(tape: &Arc<Tape>, points: &[DVec3]) -> Vec<[f32; 3]> {
    let share = |points: &[DVec3]| {
        let mut color = Evaluator::<Many<f64, LANES>>::new(tape.clone());
        let mut out = Vec::with_capacity(points.len());
        for batch in points.chunks(LANES) {
            let at =
                |axis: usize| Many(std::array::from_fn(|lane: usize| batch[lane.min(batch.len() - 1)][axis]));
            color.eval(&std::array::from_fn(at));
            let channels = [0, 1, 2].map(|channel| color.output(channel).0);
            let clamp = |c: f64| if c.is_nan() { 0.0 } else { c.clamp(0.0, 1.0) as f32 };
            out.extend((0..batch.len()).map(|lane| channels.map(|c| clamp(c[lane]))));
        }
        out
    };
    points.par_chunks(SHARE).flat_map_iter(share).collect()
}
