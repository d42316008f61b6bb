//! How far to look at a time.
//!
//! A piece of a march is answered by the tape of a place that has all of it, and the larger the place the
//! more there is in it.

use super::march::{March, Piece};
use crate::cast::Ray;
use crate::tape::Cells;

// Both were chosen on fields of goblets and on a building of 800 operations; their minima are flat.

/// Tapes of no more work than this are not worth a shorter piece.
const LITTLE: u64 = 256;

/// Nor are pieces of fewer tolerances than this: a pixel in pictures. Tapes of places that are smaller
/// serve too few rays.
const COARSE: f64 = 500.0;

/// The next piece of a march. Where all that is close to a piece is far more than what is close to its
/// beginning, only that is looked at: many short questions then cost less than a long one.
pub(super) fn worthwhile(
    march: &mut March,
    cells: &Cells,
    ray: &Ray,
    around: impl Fn(Piece) -> ([f64; 3], f64),
) -> Piece {
    let work = |piece: Piece| {
        let (at, reach) = around(piece);
        cells.work_around(at, reach)
    };
    let mut piece = march.piece(f64::INFINITY);
    if cells.is_uniform() {
        return piece;
    }
    let (mut limit, mut own) = (f64::INFINITY, work(piece));
    let least = COARSE * ray.tolerance.at(march.free);
    'shorter: while own > LITTLE {
        for times in [2, 4, 8] {
            let part = piece.half / times as f64;
            if part < least {
                break 'shorter;
            }
            let shorter = march.piece(part);
            let less = work(shorter);
            if less * times <= own {
                (piece, limit, own) = (shorter, part, less);
                continue 'shorter;
            }
        }
        break;
    }
    // The march is to remember this one.
    march.piece(limit)
}
