//! Whether a solid ends within a box: whether its field is proven to be positive all over the box's faces.
//!
//! Morse theory in a box knows nothing of what is outside. A part of the solid that comes in through a face may have its
//! minimum beyond it, so that no critical point in the box tells of it, and two parts in the box may be joined
//! there. So whatever is said of a solid from its critical points in a box wants this proof. Faces are flat cells, cut up
//! until each is proven to be outside.

use super::cell::Cell;
use super::search::{Balls, LANES};
use super::verdict::is_outside;
use crate::scene::Aabb;
use crate::tape::Tape;
use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Cells of a face until it is given up.
const CELLS: usize = 1 << 16;

/// Whether nothing of the solid of a tape's first output is on the faces of a box, as far as that can be proven.
pub fn is_closed(tape: &Arc<Tape>, region: &Aabb, cancel: &AtomicBool) -> bool {
    let face = |field: &mut Balls, face: Cell| is_free(field, face, cancel);
    faces(region).par_iter().map_init(|| Balls::new(tape), |field, cell| face(field, *cell)).all(|free| free)
}

/// The six faces of a box, as flat cells.
fn faces(region: &Aabb) -> [Cell; 6] {
    let (middle, half) = (0.5 * (region.min + region.max), 0.5 * (region.max - region.min));
    std::array::from_fn(|i| {
        let (axis, end) = (i / 2, if i % 2 == 0 { region.min } else { region.max });
        let mut face = Cell { centre: middle, half };
        (face.centre[axis], face.half[axis]) = (end[axis], 0.0);
        face
    })
}

/// Whether a flat cell is proven to be outside.
fn is_free(field: &mut Balls, face: Cell, cancel: &AtomicBool) -> bool {
    let (mut stack, mut cells) = (vec![face], 0);
    while !stack.is_empty() {
        let batch: Vec<Cell> = stack.drain(stack.len().saturating_sub(LANES)..).collect();
        cells += batch.len();
        if cells > CELLS || cancel.load(Ordering::Relaxed) {
            return false;
        }
        let values = field.eval(batch.iter().map(|cell| (cell.centre, cell.radius())));
        for (i, cell) in batch.iter().enumerate() {
            let f = values.lane(i).on(cell.free_axes());
            if is_outside(&f, cell.share().to_array()) {
                continue;
            }
            // There is no need to look any further where the solid is met.
            if f.value < 0.0 || cell.half == DVec3::ZERO {
                return false;
            }
            stack.extend(cell.parts());
        }
    }
    true
}
