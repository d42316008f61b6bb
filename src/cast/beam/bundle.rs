//! Bundles: lines of sight of one frame that march as one, until their own width is what limits them.

use super::batch::Batches;
use super::close::{all_close, closes};
use super::frame::{Frame, Place, Section};
use super::march::{Answer, March, Next, Piece};
use super::sketch::Sketch;
use super::worth::{Question, is_too_much, worthwhile};
use crate::cast::{CastStats, Tolerance};
use crate::num::{Mix, Parabola};
use crate::scene::Aabb;
use crate::tape::{Cells, Tape};
use glam::DVec3;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A bundle marches while its pieces are longer than this share of its radius, and while they are no more work
/// than its rays would have alone.
const NARROW: f64 = 0.3;

/// Half the piece that a whole bundle looks at before it is given up, as a share of its radius.
const CLOSER: f64 = 0.6;

/// Pieces after which a bundle is cut, however well it goes on.
const PATIENCE: u32 = 200;

/// So few rays take what an answer says of their roots as soon as that is closer than their beam is wide: each looks once
/// more, and needs no beam to tell it where.
const FEW: usize = 4;

/// First stretch of a march about which nothing is known, as a share of the whole.
pub(in crate::cast) const FIRST: f64 = 0.25;

/// First stretch of a part of a bundle, as a share of the way to where its root is expected.
const TOWARDS: f64 = 0.4;

/// Lines of sight that march as one.
#[derive(Clone, Debug)]
pub struct Bundle {
    pub(in crate::cast) frame: Frame,
    pub(in crate::cast) section: Section,
    pub(in crate::cast) march: March,
    pub(in crate::cast) state: State,
    piece: Piece,
    /// What was seen last, in which section.
    last: Option<(Sketch, Section)>,
    /// Whether its rays may end by an answer about it, and the one that they do end by.
    closes: bool,
    closed: Option<Box<Mix<2>>>,
    rays: usize,
    tolerance: Tolerance,
    /// Whether a piece that is short because little of the way is left is looked at however wide the bundle is: for
    /// its own sake, where rays would go on by themselves.
    is_whole: bool,
}

/// What a bundle has come to.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(in crate::cast) enum State {
    Marching,
    /// Nothing is met by any ray.
    Free,
    /// Its parts go on, or its rays end by what was seen last.
    Ended,
}

/// What a bundle asks next.
#[derive(Clone, Copy)]
enum Asked<'a> {
    /// All that is left of it is free.
    Nothing,
    /// The next piece is too short or too much to be looked at.
    Narrow,
    By(&'a Arc<Tape>),
}

impl Bundle {
    /// So many rays through a section, which march as told.
    pub(super) fn of(
        frame: Frame,
        section: Section,
        march: March,
        (rays, tolerance): (usize, Tolerance),
    ) -> Bundle {
        let (state, piece) = (State::Marching, Piece::default());
        Bundle {
            frame,
            section,
            march,
            state,
            piece,
            last: None,
            closes: false,
            closed: None,
            rays,
            tolerance,
            is_whole: false,
        }
    }

    /// The same, but its rays may end by what is known of all of them.
    pub(super) fn that_closes(self) -> Bundle {
        Bundle { closes: true, ..self }
    }

    /// All lines through a rectangle of places in a frame, as far as they are in a region; `None` if none is.
    /// As much work is done for them as for `rays` rays that are cast to within `tolerance`.
    pub fn new(
        frame: &Frame,
        rectangle: [[f64; 2]; 2],
        region: &Aabb,
        (rays, tolerance): (usize, Tolerance),
    ) -> Option<Bundle> {
        let section = Section::through(frame, rectangle, region)?;
        let [near, far] = section.depth;
        let march = March::new(near, far, FIRST * (far - near), None);
        Some(Bundle { is_whole: true, ..Bundle::of(*frame, section, march, (rays, tolerance)) })
    }

    /// Those of its lines that go through a smaller rectangle: they go on where the bundle ended. The rectangle may be
    /// one of another frame for them, with the same axis or the same origin.
    pub fn part(
        &self,
        frame: &Frame,
        rectangle: [[f64; 2]; 2],
        region: &Aabb,
        rays: usize,
    ) -> Option<Bundle> {
        let section = Section::through(frame, rectangle, region)?;
        if *frame == self.frame {
            return self.onward(section, rays);
        }
        // What was seen last was seen through other planes.
        let mut turned = Bundle { frame: *frame, last: None, closed: None, ..*self };
        turned.march.free = frame.onward(&self.frame, self.march.free, section.slant());
        turned.onward(section, rays)
    }

    /// The part of it that goes through a smaller section; `None` where that ends before this bundle did.
    pub(super) fn onward(&self, section: Section, rays: usize) -> Option<Bundle> {
        let (from, to) = (self.march.free.max(section.depth[0]), section.depth[1]);
        if from > to {
            return None;
        }
        let ahead = self.root(&section.centre).map_or(0.0, |r| TOWARDS * (r - from));
        // A bundle that is whole looks at least as far ahead as it is wide: parts of one that got stuck get on.
        let least = if self.is_whole { section.radius(from) } else { 0.0 };
        let march = March::new(from, to, self.march.stretch.max(ahead).max(least), None);
        let part = Bundle::of(self.frame, section, march, (rays, self.tolerance));
        Some(Bundle { last: self.last, closes: self.closes, is_whole: self.is_whole, ..part })
    }

    /// Whether it is proven that none of its lines meets anything.
    pub fn is_free(&self) -> bool {
        self.state == State::Free
    }

    /// The depth in its frame up to which that is proven.
    pub fn free(&self) -> f64 {
        self.march.free
    }

    /// The point where its middle line is expected to meet the surface, if that is no farther ahead than the bundle is
    /// wide: guesses over more than that are no good. Else the one up to which it is known not to.
    pub fn face(&self) -> DVec3 {
        let March { free, far, .. } = self.march;
        let near = free..=(free + 2.0 * self.section.radius(free)).min(far);
        let expected = self.root(&self.section.centre).filter(|root| near.contains(root));
        self.section.spine_at(&self.frame, expected.unwrap_or(free))
    }

    /// Decides which piece to look at, and by which tape; or that nothing is left, or that the bundle is too wide to go on.
    fn place<'a>(&mut self, cells: &'a Cells) -> Option<&'a Arc<Tape>> {
        let radius = self.section.radius(self.march.free);
        let seen = self.piece.half;
        let mut next = self.take_piece(cells);
        if matches!(next, Asked::Narrow) && self.is_whole && seen > radius {
            // What was seen last was so long that it says nothing of pieces as long as the bundle is wide.
            self.march.stretch = CLOSER * radius;
            next = self.take_piece(cells);
        }
        self.state = match next {
            Asked::Nothing => State::Free,
            Asked::Narrow => State::Ended,
            Asked::By(tape) => return Some(tape),
        };
        None
    }

    /// Takes the next piece.
    fn take_piece<'a>(&mut self, cells: &'a Cells) -> Asked<'a> {
        let around = |piece| self.section.around_piece(&self.frame, piece);
        let Some(question) = worthwhile(&mut self.march, cells, self.tolerance, around) else {
            return Asked::Nothing;
        };
        let Question { piece, tape, work } = question;
        self.piece = piece;
        let free = self.march.free;
        let (at, _) = around(Piece { mid: free, half: 0.0 });
        let is_last = self.is_whole && piece.mid + piece.half >= self.march.far;
        let is_narrow = !is_last && piece.half < NARROW * self.section.radius(piece.mid);
        if is_narrow || is_too_much(work, self.rays, cells, self.tolerance, (at, free)) {
            return Asked::Narrow;
        }
        Asked::By(tape)
    }

    fn tell(
        &mut self,
        (f, answer): (&Parabola<2>, &Answer),
        mix: impl Fn() -> Option<Mix<2>>,
        cells: &Cells,
    ) {
        self.last = Some((Sketch::new(f, self.piece), self.section));
        self.state = match self.march.tell(self.piece, answer, 0.0) {
            Next::Free => State::Free,
            Next::Look if self.march.pieces <= PATIENCE => State::Marching,
            _ => State::Ended,
        };
        let wanted = self.tolerance.at(self.march.free);
        let radius = self.section.radius(self.march.free);
        let bracket = if self.is_of_few() { wanted.max(radius) } else { wanted };
        if !self.closes || self.state == State::Free {
            return;
        }
        let piece = self.piece;
        let closed = if answer.alone {
            closes(f, piece, bracket).then(|| Mix::of(*f))
        } else if answer.root.is_some_and(|root| (root - piece.mid).abs() <= piece.half) {
            mix().filter(|mix| all_close(mix, piece, bracket))
        } else {
            None
        };
        self.closed = closed.filter(|_| self.is_defined(cells)).map(Box::new);
        if self.closed.is_some() {
            self.state = State::Ended;
        }
    }

    /// Whether its rays take what they get.
    pub(super) fn is_of_few(&self) -> bool {
        self.rays <= FEW
    }

    /// How many rays it is made for.
    pub(super) fn rays(&self) -> usize {
        self.rays
    }

    /// Whether the field is known to have a value all over the piece: where it may have none each ray looks for itself.
    fn is_defined(&self, cells: &Cells) -> bool {
        let (at, reach) = self.section.around_piece(&self.frame, self.piece);
        cells.is_defined_around(at, reach)
    }

    /// The answer that its rays end by, if one closes in on their roots, and the piece that it is about.
    pub(super) fn closed(&self) -> Option<(&Mix<2>, Piece)> {
        Some((self.closed.as_deref()?, self.piece))
    }

    /// The depths between which it is expected to be zero on its lines, as far as its middle and its corners tell.
    pub(super) fn expected(&self) -> Option<[f64; 2]> {
        let mut between = [f64::INFINITY, f64::NEG_INFINITY];
        for place in self.section.centre_and_corners() {
            let root = self.root(&place)?;
            between = [between[0].min(root), between[1].max(root)];
        }
        Some(between)
    }

    /// The depth at which the field is expected to be zero on a line of the frame.
    pub(super) fn root(&self, place: &Place) -> Option<f64> {
        let (sketch, section) = self.last?;
        sketch.root(section.relative(place, sketch.depth()))
    }
}

impl AsRef<Bundle> for Bundle {
    fn as_ref(&self) -> &Bundle {
        self
    }
}

impl AsMut<Bundle> for Bundle {
    fn as_mut(&mut self) -> &mut Bundle {
        self
    }
}

/// Marches what has bundles until each of these is free or too wide to go on; `asked` is told of every evaluation
/// for one.
pub(in crate::cast) fn march_bundles<I: AsRef<Bundle> + AsMut<Bundle>>(
    (cells, wide): (&Cells, &mut Batches<2>),
    (items, active): (&mut [I], &mut Vec<usize>),
    stats: &mut CastStats,
    cancel: &AtomicBool,
    mut asked: impl FnMut(&I),
) {
    let is_marching = |item: &I| item.as_ref().state == State::Marching;
    active.clear();
    active.extend((0..items.len()).filter(|&i| is_marching(&items[i])));
    let goes_on = || !cancel.load(Ordering::Relaxed);
    while goes_on() {
        let mut asked_by = Vec::with_capacity(active.len());
        for &i in active.iter().take_while(|_| goes_on()) {
            let bundle = items[i].as_mut();
            asked_by.extend(bundle.place(cells).map(|tape| (tape, i)));
            stats.culled += u64::from(bundle.is_free());
        }
        if asked_by.is_empty() {
            break;
        }
        let count = asked_by.len() as u64;
        (stats.evaluations, stats.shared, stats.steps) =
            (stats.evaluations + count, stats.shared + count, stats.steps + count);
        stats.work += wide.answer(
            (&mut *items, asked_by),
            |item| {
                let bundle = item.as_ref();
                (bundle.piece, bundle.section.coordinates(&bundle.frame, bundle.piece))
            },
            |item, f, answer, mix| {
                item.as_mut().tell((f, &answer), mix, cells);
                stats.culled += u64::from(item.as_ref().is_free());
                asked(item);
            },
            cancel,
        );
        active.retain(|&i| is_marching(&items[i]));
    }
}
