//! Questions about many points at once: how far they are from the surface, and what colour they have.

use crate::field::{Stopped, Watch};
use crate::num::{Dual, Many, Number};
use crate::tape::{Cells, Evaluator, Tape};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;

/// Points evaluated together.
const LANES: usize = 16;

/// Points that one thread takes at a time.
const SHARE: usize = 4096;

/// Evaluates the field at all points, and says of each what it is.
fn visit<N: Copy>(
    cells: &Cells,
    points: &[DVec3],
    coordinate: impl Fn(f64, usize) -> N,
    mut found: impl FnMut(usize, N),
) where
    Many<N, LANES>: Number,
{
    let mut field = Evaluator::<Many<N, LANES>>::new(cells.tape().clone());
    let places = points.iter().enumerate().map(|(i, p)| (i, p.to_array(), 0.0));
    for same in cells.tapes_around(places).chunk_by(|a, b| Arc::ptr_eq(a.0, b.0)) {
        field.turn_to(same[0].0);
        for batch in same.chunks(LANES) {
            let at = |lane: usize| points[batch[lane.min(batch.len() - 1)].1];
            let along = |axis: usize| Many(std::array::from_fn(|lane| coordinate(at(lane)[axis], axis)));
            let values = *field.eval(&std::array::from_fn(along));
            batch.iter().zip(values.0).for_each(|(&(_, i), value)| found(i, value));
        }
    }
}

/// The field at each point.
fn values(cells: &Cells, points: &[DVec3]) -> Vec<f64> {
    let mut out = vec![f64::NAN; points.len()];
    visit(cells, points, |x, _| x, |i, value| out[i] = value);
    out
}

/// The field at each point, and Newton's step from there to the surface: infinite where the field is flat, nothing where it
/// is infinitely steep, and not a number where it is none.
fn steps(cells: &Cells, points: &[DVec3]) -> Vec<(f64, DVec3)> {
    let mut out = vec![(f64::NAN, DVec3::NAN); points.len()];
    visit(cells, points, Dual::coordinate, |i, dual| {
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
        out[i] = (dual.value, step);
    });
    out
}

/// The distance of each point from the surface, to first order: `|f| / |grad f|`. Not a number where the field is
/// not, and when stopped.
pub(super) fn distances(cells: &Cells, points: &[DVec3], watch: &Watch<'_>) -> Vec<f64> {
    let share = |points: &[DVec3]| steps(cells, points).into_iter().map(|(_, step)| step.length()).collect();
    shared(points, share, watch)
}

/// What is said of each point, asked for by the share, or not a number when stopped.
fn shared(points: &[DVec3], ask: impl Fn(&[DVec3]) -> Vec<f64> + Sync, watch: &Watch<'_>) -> Vec<f64> {
    let share = |points: &[DVec3]| match watch.check() {
        Ok(()) => ask(points),
        Err(Stopped) => vec![f64::NAN; points.len()],
    };
    points.par_chunks(SHARE).flat_map_iter(share).collect()
}

/// How much farther than Newton's step the other side of the surface is looked for: that makes sure that the surface is
/// no farther than the step.
const FARTHER: f64 = 1.01;

/// The same, walk by walk, where it is not found there.
const WALKS: [f64; 7] = [2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0];

/// Times that the way to the other side is halved.
const HALVINGS: usize = 6;

/// No less, but for a hundredth, than the distance of each point from the surface: the length of Newton's step where that
/// leads to the other side; elsewhere, as where the surface has edges and where the gradient vanishes with the field,
/// as far as to a place on the other side. Not a number where none is found within `farthest`, and when stopped.
pub(super) fn reaches(cells: &Cells, points: &[DVec3], farthest: f64, watch: &Watch<'_>) -> Vec<f64> {
    shared(points, |points| share_of_reaches(cells, points, farthest), watch)
}

/// A way from a point towards the other side of the surface.
struct Way {
    point: usize,
    from: DVec3,
    to: DVec3,
    /// What the field is at its beginning, and whether it is something else at its end.
    is_inside: bool,
    is_across: bool,
}

fn share_of_reaches(cells: &Cells, points: &[DVec3], farthest: f64) -> Vec<f64> {
    let mut out = vec![f64::NAN; points.len()];
    let newton = steps(cells, points);
    let mut ways: Vec<Way> = Vec::with_capacity(points.len());
    for (point, (&from, &(value, step))) in points.iter().zip(&newton).enumerate() {
        if step.is_finite() {
            let to = from + (FARTHER * step).clamp_length_max(farthest);
            ways.push(Way { point, from, to, is_inside: value <= 0.0, is_across: false });
        }
    }
    look(cells, &mut ways.iter_mut().collect::<Vec<_>>());
    ways.retain(|way| {
        let step = newton[way.point].1.length();
        let is_on_it = step <= 64.0 * f64::EPSILON * way.from.abs().max_element();
        let is_settled = is_on_it || way.is_across && FARTHER * step <= farthest;
        if is_settled {
            out[way.point] = step;
        }
        !is_settled
    });
    walk(cells, &mut ways, farthest);
    ways.retain(|way| way.is_across);
    for (reach, way) in crossings(cells, &ways).into_iter().zip(&ways) {
        out[way.point] = reach;
    }
    out
}

/// Asks at the ends of all ways on which side they are.
fn look(cells: &Cells, ways: &mut [&mut Way]) {
    let ends: Vec<DVec3> = ways.iter().map(|way| way.to).collect();
    for (way, value) in ways.iter_mut().zip(values(cells, &ends)) {
        way.is_across = (value <= 0.0) != way.is_inside;
    }
}

/// Goes on by Newton's steps, longer with every walk, until the other side is found, or the next step is none or leads
/// beyond `farthest`.
fn walk(cells: &Cells, ways: &mut [Way], farthest: f64) {
    let mut open: Vec<&mut Way> = ways.iter_mut().filter(|way| !way.is_across).collect();
    for farther in WALKS {
        let ends: Vec<DVec3> = open.iter().map(|way| way.to).collect();
        let mut next = steps(cells, &ends).into_iter();
        open.retain_mut(|way| {
            let step = next.next().map_or(DVec3::NAN, |(_, step)| step);
            way.to += (farther * step).clamp_length_max(farthest);
            step.is_finite() && way.to.distance(way.from) <= farthest * (1.0 + 1e-9)
        });
        look(cells, &mut open);
        open.retain(|way| !way.is_across);
    }
}

/// How far along ways that lead across it the surface is, at most: each crosses it, and is halved.
fn crossings(cells: &Cells, ways: &[Way]) -> Vec<f64> {
    let mut parts = vec![[0.0, 1.0]; ways.len()];
    for _ in 0..HALVINGS {
        let middle = |([low, high], way): (&[f64; 2], &Way)| way.from.lerp(way.to, 0.5 * (low + high));
        let places: Vec<DVec3> = parts.iter().zip(ways).map(middle).collect();
        for ((part, way), value) in parts.iter_mut().zip(ways).zip(values(cells, &places)) {
            let is_across = (value <= 0.0) != way.is_inside;
            part[usize::from(is_across)] = 0.5 * (part[0] + part[1]);
        }
    }
    parts.iter().zip(ways).map(|(part, way)| part[1] * way.to.distance(way.from)).collect()
}

/// Linear colours between 0 and 1, or not a number where they have no value.
pub(super) fn colors(tape: &Arc<Tape>, points: &[DVec3]) -> Vec<[f32; 3]> {
    let share = |points: &[DVec3]| {
        let mut color = Evaluator::<Many<f64, LANES>>::new(tape.clone());
        let mut out = Vec::with_capacity(points.len());
        for batch in points.chunks(LANES) {
            let at =
                |axis: usize| Many(std::array::from_fn(|lane: usize| batch[lane.min(batch.len() - 1)][axis]));
            color.eval(&std::array::from_fn(at));
            let channels = [0, 1, 2].map(|channel| color.output(channel).0);
            out.extend((0..batch.len()).map(|lane| channels.map(|c| c[lane].clamp(0.0, 1.0) as f32)));
        }
        out
    };
    points.par_chunks(SHARE).flat_map_iter(share).collect()
}
