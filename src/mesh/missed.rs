//! Whether much is missed, where it is not proven that nothing is.
//!
//! Of an edge of a solid that is told by its distance, or of a carved letter, it may be impossible to prove that a mesh
//! shows all there is, though it does. So cells of which the mesh has no surface are sampled: where a sample is on the
//! other side than the cell's corners there is something that is smaller than the cell.

use super::blocks::Block;
use super::contour::Contour;
use super::lattice::{Lattice, Place, SIDE};
use crate::num::Many;
use crate::tape::Evaluator;
use glam::DVec3;

/// Samples of a cell.
const SAMPLES: usize = 2;

/// Where samples are, from one to the next, in cells: the plastic number's relative in three dimensions spreads
/// them evenly (Roberts 2018).
const STEP: DVec3 = DVec3::new(0.819_172_513_396_164_5, 0.671_043_606_703_789_2, 0.549_700_477_901_970_2);

/// Points evaluated together.
pub(super) const LANES: usize = 32;

/// How many cells of a block have surface, as samples say, of which the mesh has none there.
pub(super) fn hidden(
    block: &Block,
    contour: &Contour,
    lattice: &Lattice,
    values: &mut Evaluator<Many<f64, LANES>>,
) -> u64 {
    let offsets = (0..SIDE * SIDE * SIDE).map(|i| [i % SIDE, i / SIDE % SIDE, i / (SIDE * SIDE)]);
    let cells = offsets.map(|offset| -> Place { std::array::from_fn(|axis| block.at[axis] + offset[axis]) });
    let bare: Vec<Place> = cells.filter(|at| contour.cell(*at).is_none()).collect();
    let mut points = Vec::with_capacity(bare.len() * (1 + SAMPLES));
    for (i, at) in bare.iter().enumerate() {
        let corner = lattice.corner(*at);
        let sample = |k: usize| corner + lattice.step * (((SAMPLES * i + k) as f64 + 0.5) * STEP).fract();
        points.push(corner);
        points.extend((0..SAMPLES).map(sample));
    }
    let along = |axis: usize| points.iter().map(|p| p[axis]).collect::<Vec<f64>>();
    let at = [along(0), along(1), along(2)];
    let mut found = vec![0.0; points.len()];
    values.turn_to(&block.tape);
    values.eval_all(at.each_ref().map(Vec::as_slice), &mut found);
    let is_hidden = |of: &&[f64]| of[1..].iter().any(|value| (*value < 0.0) != (of[0] < 0.0));
    found.chunks(1 + SAMPLES).filter(is_hidden).count() as u64
}
