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

/// The distance of each point from the surface, to first order: `|f| / |grad f|`. Not a number where the field is
/// not.
pub(super) fn distances(cells: &Cells, points: &[DVec3]) -> Vec<f64> {
    let share = |points: &[DVec3]| {
        let mut out = vec![f64::NAN; points.len()];
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
                    let slope = DVec3::from_array(dual.grad).length();
                    // On the surface there may be no gradient.
                    out[*i] = if dual.value == 0.0 { 0.0 } else { dual.value.abs() / slope };
                }
            }
        }
        out
    };
    points.par_chunks(SHARE).flat_map_iter(share).collect()
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
