//! The pen that outlines are drawn with: loops of lines, parabolas and cubics in the plane.

use super::Flaw;
use crate::shape::curve::{FARTHEST, raised};
use crate::shape::strand::Piece;
use glam::{DVec2, DVec4};

/// Pieces that an outline may have.
pub const MOST_PIECES: usize = 1_000_000;

/// Loops, as far as they are drawn. Every loop is closed by a line where it does not end at its start.
#[derive(Clone, Debug, Default)]
pub struct Pen {
    /// Pieces, and whether each is straight.
    pieces: Vec<(Piece, bool)>,
    /// Where the loop began.
    start: DVec2,
    /// Where the pen is.
    here: DVec2,
    /// Whether a number was not one, or too large.
    lost: bool,
}

fn flat(p: DVec2) -> DVec4 {
    DVec4::new(p.x, p.y, 0.0, 0.0)
}

impl Pen {
    /// Closes the loop, and begins another.
    pub fn jump(&mut self, to: DVec2) {
        self.close();
        self.lost |= !lies(to);
        (self.start, self.here) = (to, to);
    }

    /// A line.
    pub fn line(&mut self, to: DVec2) {
        if to != self.here {
            self.push(Piece::straight(flat(self.here), flat(to)), true, to);
        }
    }

    /// A parabola, by the point that it is pulled to.
    pub fn quadratic(&mut self, pull: DVec2, to: DVec2) {
        self.push(raised([self.here, pull, to].map(flat)), false, to);
    }

    /// A cubic, by the two points that it is pulled to.
    pub fn cubic(&mut self, first: DVec2, second: DVec2, to: DVec2) {
        self.push(Piece([self.here, first, second, to].map(flat)), false, to);
    }

    /// Closes the loop.
    pub fn close(&mut self) {
        self.line(self.start);
    }

    /// Where the pen is.
    pub fn here(&self) -> DVec2 {
        self.here
    }

    fn push(&mut self, piece: Piece, straight: bool, to: DVec2) {
        self.lost |= !piece.0.iter().all(|p| lies(p.truncate().truncate()));
        self.pieces.push((piece, straight));
        self.here = to;
    }

    /// What was drawn.
    ///
    /// # Errors
    /// When a number was not finite or too large, or there is too much of it.
    pub fn finish(mut self) -> Result<Vec<(Piece, bool)>, Flaw> {
        self.close();
        if self.lost {
            return Err(Flaw::Lost);
        }
        if self.pieces.len() > MOST_PIECES {
            return Err(Flaw::Count(self.pieces.len()));
        }
        Ok(self.pieces)
    }
}

fn lies(p: DVec2) -> bool {
    p.is_finite() && p.abs().max_element() <= FARTHEST
}
