//! Rays that march alone.
//!
//! Where the field has no value there is nothing: a ray passes such places in strides that double, by
//! looking at points. What it meets behind them, if anything, is not certified.

use super::bundle::FIRST;
use super::march::{Answer, End, March, Next, PIECES, Piece};
use super::worth::worthwhile;
use crate::cast::{Hit, Ray};
use crate::num::{Interval, Parabola};
use crate::tape::{Cells, Tape};
use glam::DVec3;
use std::sync::Arc;

/// What is wanted of rays.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Want {
    /// The first hit.
    First,
    /// Whether the ray is inside anywhere.
    Any,
}

impl Want {
    /// The march of a ray that goes on from a beam. Those of which anything is wanted are turned around, and end where
    /// they began.
    pub(super) fn march(self, line: &Ray, stretch: f64, root: Option<f64>) -> March {
        let &Ray { near, far, tolerance, .. } = line;
        match self {
            Want::First => March::new(near, far, stretch, root),
            Want::Any if far < 0.0 => March::new(near, far, stretch, None),
            Want::Any => March::new(near, far, stretch, None).at_surface(End::Far, RIM * tolerance.at(0.0)),
        }
    }
}

/// Tolerances that a ray looks at around an end on a surface: less than half a pixel in pictures. (Measured: details of
/// rocks and canyons are about as large; where all is smooth it makes no difference.)
const RIM: f64 = 200.0;

/// The march of a ray of which nothing is known, but perhaps that it begins next to the surface.
pub(super) fn march_alone(&Ray { near, far, tolerance, .. }: &Ray, is_at_surface: bool) -> March {
    let march = March::new(near, far, FIRST * (far - near), None);
    let is_at_surface = is_at_surface || near <= 0.0;
    if is_at_surface { march.at_surface(End::Near, RIM * tolerance.at(near)) } else { march }
}

/// A ray under way.
pub(super) struct Thin {
    /// Its number in the group.
    pub(super) ray: usize,
    /// What is left of it, in either direction.
    line: Ray,
    pub(super) march: March,
    pub(super) piece: Piece,
    /// What it has passed without proof.
    passed: Passed,
    /// How it ended.
    pub(super) hit: Option<Hit>,
}

/// What a ray has passed without proof.
#[derive(Clone, Copy, PartialEq)]
enum Passed {
    Nothing,
    /// Some piece, long ago.
    Some,
    /// The last piece.
    Last,
}

impl Thin {
    pub(super) fn new(ray: usize, line: Ray, march: March) -> Thin {
        Thin { ray, line, march, piece: Piece::default(), passed: Passed::Nothing, hit: None }
    }

    /// Decides which piece to look at, and by which tape; or ends.
    pub(super) fn place<'a>(&mut self, cells: &'a Cells) -> Option<&'a Arc<Tape>> {
        let line = &self.line;
        let next = worthwhile(&mut self.march, cells, line.tolerance, |piece| around(line, piece));
        match &next {
            Some(question) => self.piece = question.piece,
            None => self.hit = Some(Hit { certified: self.passed == Passed::Nothing, ..Hit::MISS }),
        }
        next.map(|question| question.tape)
    }

    /// Where it is inside, if that is known, as `t` of a ray that it is or that it is the other way round.
    pub(super) fn inside(&self, ray: &Ray) -> Option<f64> {
        let t = Some(self.march.inside).filter(|t| t.is_finite())?;
        Some(if self.line.direction == ray.direction { t } else { -t })
    }

    /// Whether the field is known to have a value all over the piece, without another evaluation.
    pub(super) fn is_defined(&self, cells: &Cells) -> bool {
        let (at, reach) = around(&self.line, self.piece);
        cells.is_defined_around(at, reach)
    }

    /// The coordinates of the piece.
    pub(super) fn coordinates(&self) -> [Parabola<0>; 3] {
        let (ray, Piece { mid, half }) = (&self.line, self.piece);
        let (at, blur) = (ray.at(mid), ray.rounding(mid.abs() + half));
        [0, 1, 2].map(|axis| Parabola::coordinate(at[axis], half * ray.direction[axis], [], 0.0, blur))
    }

    /// The answer less the claim that the solid begins where the field has no value: what is known of a
    /// piece holds wherever it has one. If it is as short as pieces get, it is asked whether there is a value all over it.
    pub(super) fn checked(
        &self,
        mut answer: Answer,
        tape: &Arc<Tape>,
        mut value: impl FnMut(DVec3) -> f64,
    ) -> Answer {
        let (ray, Piece { mid, half }) = (&self.line, self.piece);
        if half <= 0.5 * ray.tolerance.at(self.march.free) {
            let (ends, blur) = ([mid - half, mid + half].map(|t| ray.at(t)), ray.rounding(mid.abs() + half));
            let along = |axis: usize| Interval::new(ends[0][axis], ends[1][axis]) + Interval::radius(blur);
            answer.whole &= tape.is_defined(&[0, 1, 2].map(along));
        }
        for (side, sign) in answer.halves.iter_mut().zip([-1.0, 1.0]) {
            // Forwards only the first place is of interest.
            let ends = if sign < 0.0 { 2 } else { 1 };
            for end in side.below.iter_mut().take(ends).filter(|end| **end < 1.0) {
                if value(ray.at(mid + sign * *end * half)).is_nan() {
                    *end = 1.0;
                }
            }
        }
        (answer.solid, answer.defined) = (false, false);
        answer
    }

    /// Takes an answer about the piece; `value` is the field at a point.
    pub(super) fn tell(&mut self, answer: &Answer, want: Want, value: impl FnMut(DVec3) -> f64) {
        let (tolerance, before) = (self.line.tolerance.at(self.march.free), self.march.free);
        let certified = self.passed == Passed::Nothing;
        self.hit = match self.march.tell(self.piece, answer, tolerance) {
            Next::Free => Some(Hit { certified, ..Hit::MISS }),
            _ if want == Want::Any && self.march.inside.is_finite() => {
                Some(Hit { t: self.march.inside, certified })
            }
            Next::Root(a, b) => {
                let root = answer.root.filter(|_| answer.defined);
                Some(Hit { t: answer.seen(root.unwrap_or(a).clamp(a, b), tolerance), certified })
            }
            Next::Stuck(t) if answer.whole => Some(Hit { t: answer.seen(t, tolerance), certified }),
            Next::Look if self.march.pieces > PIECES => Some(Hit { t: self.march.free, certified: false }),
            Next::Stuck(_) => self.pass(value, |f| f.is_nan() || f > 0.0),
            Next::Look if self.passed == Passed::Last && self.march.free == before => {
                self.pass(value, f64::is_nan)
            }
            Next::Look => None,
        };
    }

    /// Leaves the piece behind if it is empty at points, so that `is_empty` holds for their values. What
    /// is inside at the end of so short a piece that no more can be told is a hit.
    fn pass(&mut self, mut value: impl FnMut(DVec3) -> f64, is_empty: fn(f64) -> bool) -> Option<Hit> {
        let (ray, Piece { mid, half }) = (&self.line, self.piece);
        let values = [mid - half, mid, mid + half].map(|t| value(ray.at(t.clamp(ray.near, ray.far))));
        if values.into_iter().all(is_empty) {
            self.passed = Passed::Last;
            self.march.pass(self.piece);
            return (self.march.free >= self.march.far).then_some(Hit { certified: false, ..Hit::MISS });
        }
        if self.passed == Passed::Last {
            self.passed = Passed::Some;
            return None;
        }
        Some(Hit { t: self.march.free, certified: false })
    }
}

/// A place and how far, at most, a piece of a ray reaches from it along any axis.
fn around(ray: &Ray, Piece { mid, half }: Piece) -> ([f64; 3], f64) {
    (ray.at(mid).to_array(), half + ray.rounding(mid.abs() + half))
}
