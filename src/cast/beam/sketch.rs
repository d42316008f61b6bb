//! What the last answer suggests about a root. Nothing here is certain, nor needs to be: it only says
//! where to look next.

use super::march::Piece;
use crate::num::Parabola;

/// So far from the middle of a piece, in halves of it, roots are expected.
pub(super) const FARTHEST: f64 = 8.0;

/// What the field is like around a piece: middles of an answer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sketch {
    piece: Piece,
    /// Value, slope and bend along the piece.
    along: [f64; 3],
    /// Slopes across, to the edges of the section.
    across: [f64; 2],
}

impl Sketch {
    pub(super) fn new<const K: usize>(f: &Parabola<K>, piece: Piece) -> Sketch {
        let mut across = [0.0; 2];
        across.iter_mut().zip(f.side).for_each(|(across, side)| *across = side);
        Sketch { piece, along: f.mid, across }
    }

    /// The depth of the middle of the piece.
    pub(super) fn depth(&self) -> f64 {
        self.piece.mid
    }

    /// Where the field is expected to be zero, at a place in the section given in units of its extent.
    pub(super) fn root(&self, [x, y]: [f64; 2]) -> Option<f64> {
        let [value, slope, bend] = self.along;
        let e = descent([value + x * self.across[0] + y * self.across[1], slope, bend])?;
        Some(self.piece.mid + e * self.piece.half)
    }
}

/// A place where a form is expected to fall through zero, in the middle of the section.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fall {
    /// In halves of the piece from its middle.
    pub at: f64,
    /// How steeply, for each half of the piece.
    pub slope: f64,
}

impl Fall {
    pub(super) fn of<const K: usize>(f: &Parabola<K>) -> Option<Fall> {
        let at = descent(f.mid)?;
        Some(Fall { at, slope: (f.mid[1] + 2.0 * at * f.mid[2]).abs() })
    }

    /// How far the root of a line may be from where it is expected, so far from the middle of the piece.
    pub(super) fn doubt<const K: usize>(&self, f: &Parabola<K>, distance: f64) -> f64 {
        (f.rest[0] + distance * (f.rest[1] + distance * f.rest[2])) / self.slope
    }
}

/// The place near zero where a parabola falls through zero, within a few units.
fn descent([c, b, a]: [f64; 3]) -> Option<f64> {
    if b >= 0.0 || b.is_nan() {
        return None;
    }
    // The root next to the straight line's; where the parabola has none, the line's.
    let root = -2.0 * c / (b - (b * b - 4.0 * a * c).max(0.0).sqrt());
    (root.abs() < FARTHEST).then_some(root)
}
