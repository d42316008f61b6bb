//! The two-sided march along a ray or a beam.
//!
//! An answer certifies places on both sides of the middle of its piece, so a march looks ahead of its
//! frontier: far enough to gain ground, near enough that the answer reaches back. An answer that does
//! not reach back is kept as an *island* beyond a gap, which is looked at next; nothing is lost by a
//! failed guess. Once a place inside the solid is known, the root lies between the frontier and that
//! place, and the middle of the next piece goes to where the answers so far predict it (thesis notes,
//! ray casting, 9.4 and 9.5). One answer there closes the gap to what the curvature of the field leaves
//! open, which is the square of what it was.

use super::sketch::FARTHEST;
use crate::num::{Half, Sign};

/// A piece of the line: its middle and half of its length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Piece {
    pub mid: f64,
    pub half: f64,
}

impl Piece {
    /// The piece around `mid` that reaches at least `half` to either side, whatever is rounded.
    pub(super) fn new(mid: f64, half: f64) -> Piece {
        Piece { mid, half: half * (1.0 + 1e-9) + 8.0 * f64::EPSILON * mid.abs() + 1e-300 }
    }
}

/// What an evaluation says of a piece.
#[derive(Clone, Copy, Debug)]
pub(super) struct Answer {
    /// Backwards and forwards.
    pub halves: [Half; 2],
    /// Where the field is expected to be zero, if it is expected within the piece or a little beyond.
    pub root: Option<f64>,
    /// Whether the field is known to have finite values all over it, and no jumps.
    pub whole: bool,
    /// Whether all of it is inside for certain.
    pub solid: bool,
    /// Whether the form that comes with it has the sign of the field all over it.
    pub alone: bool,
    /// Whether the field is known to have a value all over it: else what is expected of roots says nothing of where the solid
    /// begins.
    pub defined: bool,
}

impl Answer {
    /// By what is known of signs over the piece.
    pub(super) fn new(sign: &Sign, Piece { mid, half }: Piece) -> Answer {
        let &Sign { halves, fall, range, is_alone, .. } = sign;
        let root = fall.filter(|at| at.abs() < FARTHEST).map(|at| mid + at * half);
        Answer {
            halves,
            root,
            whole: range.is_finite(),
            solid: range.hi < 0.0,
            alone: is_alone,
            defined: true,
        }
    }

    /// Where a hit is seen whose place is known to a tolerance: a little before it, unless one surface decides alone. What
    /// several make may be as thin as rounding, and its other side is right behind.
    pub(super) fn seen(&self, t: f64, tolerance: f64) -> f64 {
        if self.alone { t } else { t - 0.5 * tolerance }
    }
}

/// An end of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    Near,
    Far,
}

/// How a march goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Next {
    /// Another piece is to be looked at.
    Look,
    /// The first root lies between two places.
    Root(f64, f64),
    /// Neither free nor inside here, however closely one looks.
    Stuck(f64),
    /// There is none.
    Free,
}

/// Islands that are remembered; of more the farthest is forgotten.
const ISLANDS: usize = 4;

// The numbers below were chosen on surface (5.11) of the thesis; what they trade is evaluations that
// reach back to the frontier for sure against evaluations that gain more if they do. All minima are flat.

/// Where the next middle lies ahead of the frontier, as a share of the stretch that is expected.
const AHEAD: f64 = 0.5;

/// Half the next piece, as a multiple of that.
const SPAN: f64 = 2.0;

/// What is expected after an answer that was certain of only part of its piece, as a share of that.
const SHORT: f64 = 1.0;

/// What is expected at most after an answer that was certain of all of its piece, as a multiple of half
/// of it: so much to begin with,
const FARTHER: f64 = 6.0;

/// so much after an answer that gained nothing, since where one guess was too bold the next will be,
const CAUTIOUS: f64 = 1.0;

/// and so many times as much after each that did gain. (Measured on canyons, mountains and crumbs: of the evaluations a
/// sixth to a third goes, half of which had gained nothing; where the ground is smooth it makes no difference.)
const BOLDER: f64 = 1.25;

/// The next stretch after an answer that gained nothing, as a share of what was looked at.
const SHRINK: f64 = 0.5;

/// The next piece around an end of the line after one that was certain of nothing.
const SHRINKS_AT_RIM: f64 = 0.35;

/// What is expected after an island around the beginning of the line, as a multiple of it.
const STARTS: f64 = 3.0;

/// A root is aimed at when it is expected within this many stretches. (Twice as many save a sixth of the evaluations on a
/// building of 800 operations, and cost 7 % more where the ground is rough.)
const AIM: f64 = 1.0;

/// Pieces after which a march is given up.
pub(super) const PIECES: u32 = 20_000;

/// Progress along a line.
#[derive(Clone, Copy, Debug)]
pub(in crate::cast) struct March {
    /// Everything before is free.
    pub free: f64,
    /// End of the line.
    pub far: f64,
    /// How long a stretch the last answers gained beyond the frontier.
    pub stretch: f64,
    /// A place inside the solid, or infinity.
    pub inside: f64,
    /// Where the root is expected.
    pub root: Option<f64>,
    /// What is expected at most after an answer that is certain of all of its piece.
    most: f64,
    /// Whether the last piece was placed on the expected root.
    aimed: bool,
    islands: [[f64; 2]; ISLANDS],
    count: usize,
    /// Half the piece that is to be looked at around an end of the line, or zero.
    rim: f64,
    /// Which end that is.
    end: End,
    pub pieces: u32,
}

impl March {
    /// A march from `near` to `far`; `stretch` is a first guess.
    pub(super) fn new(near: f64, far: f64, stretch: f64, root: Option<f64>) -> March {
        March {
            free: near,
            far,
            stretch,
            inside: f64::INFINITY,
            root,
            most: FARTHER,
            aimed: false,
            islands: [[0.0; 2]; ISLANDS],
            count: 0,
            rim: 0.0,
            end: End::Near,
            pieces: 0,
        }
    }

    /// The same for a line that has an end close to the surface. There only a piece with its middle on that
    /// end is certain of anything: so one makes an island of it first, of about this size.
    pub(super) fn at_surface(self, end: End, size: f64) -> March {
        March { rim: size.min(self.stretch).min(self.far - self.free), end, ..self }
    }

    /// The piece to look at next; half of it is at most about `limit`.
    pub(super) fn piece(&mut self, limit: f64) -> Piece {
        if self.rim > 0.0 {
            self.aimed = false;
            let at = if self.end == End::Near { self.free } else { self.far };
            return Piece::new(at, self.rim.min(limit));
        }
        let end =
            self.far.min(self.inside).min(if self.count > 0 { self.islands[0][0] } else { f64::INFINITY });
        let gap = end - self.free;
        self.aimed = false;
        if let Some(root) = self.root
            && root > self.free
            && root < end + 0.25 * gap
            && (self.inside.is_finite() || self.pieces == 0 || root - self.free < AIM * self.stretch)
        {
            let mid = root.min(end);
            // Both ends of a bracket are worth knowing; else it is enough to reach back.
            let ahead = if self.inside.is_finite() { self.inside - mid } else { 0.0 };
            let half = (mid - self.free).max(ahead) * 1.02;
            if half <= limit {
                self.aimed = true;
                return Piece::new(mid, half);
            }
        }
        let ahead = (AHEAD * self.stretch).min(limit / SPAN);
        if 2.0 * ahead >= gap {
            // The rest of the gap at once.
            let mid = self.free + 0.5 * gap;
            return Piece::new(mid, (mid - self.free).max(end - mid));
        }
        Piece::new(self.free + ahead, SPAN * ahead)
    }

    /// Takes an answer about a piece; `tolerance` is how closely a root is wanted.
    pub(super) fn tell(&mut self, piece: Piece, answer: &Answer, tolerance: f64) -> Next {
        self.pieces += 1;
        let gap = self.inside.min(self.far) - self.free;
        let before = self.free;
        let Piece { mid, half } = piece;
        let place = |t: f64| mid + t * half;
        let [back, fore] = answer.halves;
        self.root = answer.root;
        if answer.solid && (mid - half..=mid + half).contains(&self.free) && self.free <= self.far {
            // The line begins inside, and is so just behind, too, which is not on the edge of where anything is known.
            self.inside = (self.free + 0.5 * tolerance).min(mid + half).min(self.far);
        }
        for t in [-back.below[1], -back.below[0], fore.below[0]] {
            // A piece may reach back beyond the frontier, and out of the line at either end.
            if t.abs() < 1.0 && (self.free..=self.far).contains(&place(t)) {
                self.inside = self.inside.min(place(t));
            }
        }
        let [behind, beyond] = [[-back.above[1], -back.above[0]], fore.above];
        if behind[1] == 0.0 && beyond[0] == 0.0 {
            self.join(place(behind[0]), place(beyond[1]));
        } else {
            self.join(place(behind[0]), place(behind[1]));
            self.join(place(beyond[0]), place(beyond[1]));
        }
        if self.rim > 0.0 {
            let size = self.island_at_end(before);
            let shorter = SHRINKS_AT_RIM * self.rim;
            let least = tolerance.max(64.0 * f64::EPSILON * self.far.abs());
            if self.end == End::Near {
                self.stretch = if size > 0.0 { STARTS * size } else { shorter };
            }
            let is_done = size > 0.0 || self.inside.is_finite() || shorter < least;
            self.rim = if is_done { 0.0 } else { shorter };
            if self.free < self.far.min(self.inside) {
                return Next::Look;
            }
        }
        if self.free >= self.far.min(self.inside) {
            return if self.inside <= self.far {
                Next::Root(self.free.min(self.inside), self.inside)
            } else {
                Next::Free
            };
        }
        let left = self.inside.min(self.far) - self.free;
        if self.inside.is_finite() && left <= tolerance {
            return Next::Root(self.free, self.inside);
        }
        self.plan(piece, before, [gap, left], fore.reach, tolerance);
        if half <= 0.5 * tolerance && self.free == before {
            return Next::Stuck(self.free);
        }
        Next::Look
    }

    /// How large the island is that an end of the line belongs to; `before` is where the frontier was.
    fn island_at_end(&self, before: f64) -> f64 {
        match self.end {
            End::Near => self.free - before,
            End::Far => {
                let last = self.islands[..self.count].iter().find(|i| i[1] >= self.far);
                last.map_or(0.0, |i| i[1] - i[0])
            }
        }
    }

    /// Leaves a piece behind of which nothing is known, and looks at twice as much next.
    pub(super) fn pass(&mut self, piece: Piece) {
        self.free = self.free.max(piece.mid + piece.half);
        self.stretch = 4.0 * piece.half;
        self.root = None;
        self.take_islands();
    }

    /// Leaves behind what is known to be free, as far as `to`.
    pub(in crate::cast) fn skip(&mut self, to: f64) {
        self.free = self.free.max(to);
        if self.end == End::Near {
            // That end is behind.
            self.rim = 0.0;
        }
        self.take_islands();
    }

    /// Guesses the next stretch.
    fn plan(&mut self, piece: Piece, before: f64, [gap, left]: [f64; 2], reach: f64, tolerance: f64) {
        let gained = self.free - before;
        let whole = self.free >= piece.mid + 0.999 * piece.half;
        if gained > 0.0 {
            // How far from its middle the answer is certain, or would be if the piece were longer.
            let reach =
                if whole { reach.min(self.most) } else { SHORT * (self.free - piece.mid) / piece.half };
            self.stretch = (reach * piece.half).max(0.5 * gained);
            self.most = (BOLDER * self.most).min(FARTHER);
        } else {
            self.stretch = SHRINK * self.stretch.min(piece.half * 2.0);
            self.most = CAUTIOUS;
        }
        // No shorter than what is wanted, and than what can be told from nothing.
        self.stretch = self.stretch.max(0.25 * tolerance).max(64.0 * f64::EPSILON * self.free.abs());
        if self.aimed && left > 0.5 * gap {
            // The expectation was no good: march instead.
            self.root = None;
            self.stretch = self.stretch.min(0.6 * left);
        }
    }

    /// Adds a free stretch of the line.
    fn join(&mut self, from: f64, to: f64) {
        // The places are rounded.
        let (from, to) = (from.next_up(), to.next_down());
        let gains = from < to && to > self.free;
        if gains && from <= self.free {
            self.free = to;
        } else if gains && (self.count < ISLANDS || from < self.islands[ISLANDS - 1][0]) {
            self.count = (self.count + 1).min(ISLANDS);
            self.islands[self.count - 1] = [from, to];
            self.islands[..self.count].sort_by(|a, b| a[0].total_cmp(&b[0]));
        }
        self.take_islands();
    }

    /// Joins the islands that the frontier has reached.
    fn take_islands(&mut self) {
        while self.count > 0 && self.islands[0][0] <= self.free {
            self.free = self.free.max(self.islands[0][1]);
            self.islands.copy_within(1.., 0);
            self.count -= 1;
        }
    }
}
