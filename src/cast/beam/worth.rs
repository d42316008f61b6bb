//! How far to look at a time.
//!
//! A piece of a march is answered by the tape of a place that has all of it, and the larger the place the
//! more there is in it. Where cells are known to be free, no tape need be asked.

use super::march::{March, Piece};
use crate::cast::Tolerance;
use crate::tape::Cells;

// All were chosen on fields of goblets and on a building of 800 operations; their minima are flat.

/// Tapes of no more work than this are not worth a shorter piece. (Measured on scenes of 100 to 5000 parts: four times as
/// much is slower by up to a quarter.)
const LITTLE: u64 = 64;

/// Nor are pieces of fewer tolerances than this: a pixel in pictures. Tapes of places that are smaller
/// serve too few rays.
const COARSE: f64 = 500.0;

/// An evaluation for a single ray is at least as much work as this.
const ONE: u64 = 30;

/// A piece that is twice as long is worth looking at if it is no more work than this many times as much.
const MORE: f64 = 1.2;

/// The next piece of a march and, where the field is cut into cells, how much work it is; or none if all that
/// is left of the line is free. `around` is a place and how far a piece reaches from it.
pub(super) fn worthwhile(
    march: &mut March,
    cells: &Cells,
    tolerance: Tolerance,
    around: impl Fn(Piece) -> ([f64; 3], f64),
) -> Option<(Piece, u64)> {
    let piece = march.piece(f64::INFINITY);
    if cells.is_uniform() {
        return Some((piece, 0));
    }
    // None where a piece is free.
    let work = |piece: Piece| {
        let (at, reach) = around(piece);
        cells.work_around(at, reach)
    };
    match work(piece) {
        Some(own) if own <= LITTLE => Some((piece, own)),
        _ => {
            let near = skip_free(march, tolerance, work)?;
            Some(widened(march, near, |piece| work(piece).unwrap_or(0)))
        }
    }
}

/// Whether a piece of so much work that serves `rays` rays is more than they would have to do by themselves,
/// each with what is close to a place where the piece begins.
pub(super) fn is_too_much(
    work: u64,
    rays: usize,
    cells: &Cells,
    tolerance: Tolerance,
    from: ([f64; 3], f64),
) -> bool {
    let rays = rays as u64;
    let (at, t) = from;
    work > ONE * rays && work > cells.work_around(at, COARSE * tolerance.at(t)).unwrap_or(0) * rays
}

/// Leaves free cells behind, in strides that double while they are and are halved where they are not; down
/// to a pixel, or to where little is close by. Returns the last stride, or nothing at the end of the line.
fn skip_free(march: &mut March, tolerance: Tolerance, work: impl Fn(Piece) -> Option<u64>) -> Option<f64> {
    let least = |from: f64| (COARSE * tolerance.at(from)).max(64.0 * f64::EPSILON * from.abs() + 1e-300);
    let mut half = (0.5 * march.stretch).max(least(march.free));
    loop {
        let piece = Piece::new(march.free + half, half);
        let work = work(piece);
        if march.inside.is_infinite() && work.is_none() {
            march.skip(piece.mid + half);
            half *= 2.0;
            if march.free >= march.far {
                return None;
            }
        } else if half < least(march.free) || work.is_none_or(|work| work <= LITTLE) {
            return Some(half);
        } else {
            half *= 0.5;
        }
    }
}

/// The longest piece that is hardly more work than one that reaches about `half` to either side. Many short
/// questions cost less than a long one about far more.
fn widened(march: &mut March, mut half: f64, work: impl Fn(Piece) -> u64) -> (Piece, u64) {
    let longest = march.piece(f64::INFINITY).half;
    let mut own = work(march.piece(half));
    while half < longest {
        let more = work(march.piece(2.0 * half));
        if more > LITTLE && more as f64 > MORE * own as f64 {
            break;
        }
        (half, own) = (2.0 * half, more);
    }
    // The march is to remember this one.
    (march.piece(half), own)
}
