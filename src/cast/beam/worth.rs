//! How far to look at a time.
//!
//! A piece of a march is answered by the tape of a place that has all of it, and the larger the place the
//! more there is in it. Where cells are known to be free, no tape need be asked.

use super::march::{March, Piece};
use crate::cast::Tolerance;
use crate::tape::{Cells, Tape};
use std::sync::Arc;

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

/// What is to be asked next.
pub(super) struct Question<'a> {
    pub piece: Piece,
    /// Of a place that has all of it.
    pub tape: &'a Arc<Tape>,
    /// How much work that is, where the field is cut into cells.
    pub work: u64,
}

/// The next piece of a march; or none if all that is left of the line is free. `around` is a place and how far a piece
/// reaches from it.
pub(super) fn worthwhile<'a>(
    march: &mut March,
    cells: &'a Cells,
    tolerance: Tolerance,
    around: impl Fn(Piece) -> ([f64; 3], f64),
) -> Option<Question<'a>> {
    let piece = march.piece(f64::INFINITY);
    if cells.is_uniform() {
        return Some(Question { piece, tape: cells.tape(), work: 0 });
    }
    let occupied = |piece: Piece| {
        let (at, reach) = around(piece);
        cells.occupied_around(at, reach)
    };
    if let Some((tape, work)) = occupied(piece).filter(|(_, work)| *work <= LITTLE) {
        return Some(Question { piece, tape, work });
    }
    let near = skip_free(march, tolerance, occupied)?;
    let (piece, found) = widened(march, near, occupied);
    // What is free costs nothing.
    let (tape, work) = found.unwrap_or_else(|| {
        let (at, reach) = around(piece);
        (cells.tape_around(at, reach), 0)
    });
    Some(Question { piece, tape, work })
}

/// What there is to be asked, and how much work it is; nothing where a piece is free.
type Occupied<'a> = Option<(&'a Arc<Tape>, u64)>;

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
    let least = || cells.occupied_around(at, COARSE * tolerance.at(t)).map_or(0, |(_, work)| work);
    work > ONE * rays && work > least() * rays
}

/// Leaves free cells behind, in strides that double while they are and are halved where they are not; down
/// to a pixel, or to where little is close by. Returns the last stride, or nothing at the end of the line.
fn skip_free<'a>(
    march: &mut March,
    tolerance: Tolerance,
    occupied: impl Fn(Piece) -> Occupied<'a>,
) -> Option<f64> {
    let least = |from: f64| (COARSE * tolerance.at(from)).max(64.0 * f64::EPSILON * from.abs() + 1e-300);
    let mut half = (0.5 * march.stretch).max(least(march.free));
    loop {
        let piece = Piece::new(march.free + half, half);
        let work = occupied(piece).map(|(_, work)| work);
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
fn widened<'a>(
    march: &mut March,
    mut half: f64,
    occupied: impl Fn(Piece) -> Occupied<'a>,
) -> (Piece, Occupied<'a>) {
    let work = |found: Occupied<'_>| found.map_or(0, |(_, work)| work);
    let longest = march.piece(f64::INFINITY).half;
    let mut own = occupied(march.piece(half));
    while half < longest {
        let more = occupied(march.piece(2.0 * half));
        if work(more) > LITTLE && work(more) as f64 > MORE * work(own) as f64 {
            break;
        }
        (half, own) = (2.0 * half, more);
    }
    // The march is to remember this one.
    (march.piece(half), own)
}
