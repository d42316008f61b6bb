//! How often an outline winds around a point: the pieces that a line to the right crosses, those that go
//! up counted once and those that go down once less.
//!
//! Pieces are cut where they turn, so that each crosses a level once. It does so if it begins
//! on or below the level and ends above it, or the other way round: no end is counted twice.

use crate::num::Digest;
use crate::shape::boxes::{Boxes, Extent};
use crate::shape::strand::Piece;
use glam::{DVec2, DVec4, Vec4Swizzles};

/// What is covered of what a drawing winds around.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Rule {
    /// All of it.
    NonZero,
    /// What it winds around an odd number of times.
    EvenOdd,
}

impl Rule {
    fn covers(self, turns: i32) -> bool {
        match self {
            Rule::NonZero => turns != 0,
            Rule::EvenOdd => turns % 2 != 0,
        }
    }
}

/// Pieces that do not turn up or down, and the boxes around them.
#[derive(Debug)]
pub(super) struct Winding {
    /// Each with the number of its drawing.
    pieces: Vec<(Piece, usize)>,
    rules: Vec<Rule>,
    boxes: Boxes,
}

impl Winding {
    /// Takes all drawings in.
    pub fn digest(&self, digest: &mut Digest) {
        digest.whole(self.rules.len() as u64);
        self.rules.iter().for_each(|rule| digest.whole(*rule as u64));
        for (piece, drawing) in &self.pieces {
            digest.numbers(piece.0.iter().flat_map(DVec4::to_array));
            digest.whole(*drawing as u64);
        }
    }

    /// The winding of drawings, each of pieces none of which turns up or down within.
    pub fn new(layers: Vec<(Rule, Vec<Piece>)>) -> Winding {
        let rules = layers.iter().map(|(rule, _)| *rule).collect();
        let numbered = layers.into_iter().enumerate();
        let pieces: Vec<_> =
            numbered.flat_map(|(k, (_, pieces))| pieces.into_iter().map(move |piece| (piece, k))).collect();
        let extents: Vec<Extent> =
            pieces.iter().map(|(p, _)| Extent::of(p.0.map(|p| p.xyz()), 0.0)).collect();
        Winding { boxes: Boxes::new(&extents), pieces, rules }
    }

    /// Whether any of the drawings covers a point.
    pub fn covers(&self, p: DVec2) -> bool {
        // Of the first drawing, which is mostly the only one, and each crossing of the others.
        let (mut first, mut others) = (0, Vec::new());
        self.boxes.each(
            |e| e.lo.y <= p.y && p.y <= e.hi.y && p.x <= e.hi.x,
            |i| match &self.pieces[i] {
                (piece, 0) => first += crossing(piece, p),
                (piece, layer) => others.push((*layer, crossing(piece, p))),
            },
        );
        others.sort_unstable();
        let turns = |layer: &[(usize, i32)]| layer.iter().map(|(_, turn)| turn).sum();
        self.rules.first().is_some_and(|rule| rule.covers(first))
            || others.chunk_by(|a, b| a.0 == b.0).any(|layer| self.rules[layer[0].0].covers(turns(layer)))
    }
}

/// 1 or -1 if the piece crosses the line to the right of the point, upwards or downwards.
fn crossing(piece: &Piece, p: DVec2) -> i32 {
    let [a, .., d] = piece.0;
    let sense = match (a.y <= p.y, d.y <= p.y) {
        (true, false) => 1,
        (false, true) => -1,
        _ => return 0,
    };
    if is_right(piece, p, sense > 0) { sense } else { 0 }
}

/// Whether a piece that goes up (or down) is to the right of a point at its level, by halving. What goes on
/// to one side lies between its ends, so that it mostly takes a few steps to tell.
fn is_right(piece: &Piece, p: DVec2, up: bool) -> bool {
    let (mut lo, mut hi) = ((0.0, piece.0[0].x), (1.0, piece.0[3].x));
    for _ in 0..56 {
        if lo.1.min(hi.1) > p.x || lo.1.max(hi.1) <= p.x {
            break;
        }
        let t = 0.5 * (lo.0 + hi.0);
        let place = piece.at(t)[0];
        *if (place.y <= p.y) == up { &mut lo } else { &mut hi } = (t, place.x);
    }
    0.5 * (lo.1 + hi.1) > p.x
}

/// Cuts a piece where it turns up or down, left or right: what is left neither meets a level twice nor
/// crosses itself.
pub(super) fn turning(piece: &Piece) -> impl Iterator<Item = Piece> + use<> {
    let mut turns = [turns(piece.0.map(|p| p.x)), turns(piece.0.map(|p| p.y))].concat();
    turns.sort_by(f64::total_cmp);
    piece.cuts(&turns).into_iter()
}

/// Where the derivative `3 (constant + 2 linear t + square t^2)` of a cubic is zero, or not a number if
/// it is not.
fn turns([a, b, c, d]: [f64; 4]) -> [f64; 2] {
    let (constant, linear, square) = (b - a, c - b - (b - a), (d - c) - 2.0 * (c - b) + (b - a));
    let root = (linear * linear - square * constant).sqrt();
    // Without cancellation.
    let sum = -(linear + root.copysign(linear));
    [sum / square, constant / sum]
}
