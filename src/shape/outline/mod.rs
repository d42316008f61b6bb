//! Outlines in the plane: polygons, letters and drawings, as signed distances that do not depend on z.
//!
//! A [`Pen`] draws loops of lines, parabolas and cubics; what they wind around any number of times but
//! none is inside (the nonzero rule), which is how fonts and SVG fill, or an odd number of times, as SVG may fill too. Of
//! several drawings what any of them covers is inside. Lines, parabolas and cubics are
//! kept as they are, and the nearest place on them is found as on any other strand (`strand`), so the
//! distance is exact. What loops draw inside of others is no part of the outline and is dropped (`overlap`).
//!
//! **Around a point** `c` at distance `d` from the outline, with the nearest place `p` and the normal `n`
//! there: all that matters to the distances in the ball of radius `r` lies within `d + 2r` of `c`. If all
//! of the outline in there is within `e` of the tangent, `|n . (y - p)| <= e`, and beyond that band all is
//! outside on one side and inside on the other, then a point `x` at `s = n . (x - p) > e` sees nothing but
//! outside within `s - e`, and inside within `s + e`, and so on the other side: in the whole ball
//!
//! ```text
//! |f(x) - n . (x - p)| <= e
//! ```
//!
//! which is quadratic in `r` close to the outline, and zero where it is straight. Away from the outline
//! the bow of the strand holds, up or down. And the gradient at `x`, the direction away from its nearest place or to
//! it, is a normal of the outline there, or at a kink, one of the fan between both normals: all gradients in the ball
//! are within the fan of the normals within `d + 2r`, if it is less than half a turn.

mod fan;
mod glyphs;
mod overlap;
mod path;
mod pen;
#[cfg(test)]
mod tests;
mod winding;

pub use glyphs::{Align, Font, Layout, runs_left};
pub use path::{Garbled, drawn};
pub use pen::{MOST_PIECES, Pen};

use super::strand::{BOUNDS, Reading, Strand};
use super::{Body, Digest, lanes};
use crate::num::{Bounds, Class, Interval, Jets, Kernel, Lean, Local, Order, Point, ROUNDOFF};
use fan::Fan;
use glam::{DVec2, DVec3, Vec3Swizzles, Vec4Swizzles};
pub use winding::Rule;
use winding::Winding;

/// Why a drawing is no outline.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum Flaw {
    /// A coordinate is not finite, or too large.
    #[error("a point of the outline is not finite, or beyond 1e15")]
    Lost,
    /// Too many pieces.
    #[error("an outline has at most {MOST_PIECES} pieces, not {0}")]
    Count(usize),
    /// Nothing is inside.
    #[error("the outline encloses nothing")]
    Empty,
}

/// The inside of an outline as a field of x and y.
#[derive(Debug)]
pub struct Outline {
    strand: Strand,
    /// Which side of each piece is outside, as seen along it: 1 the left one, -1 the right one.
    outside: Vec<f64>,
    winding: Winding,
    /// Whether all that was drawn is part of the outline: then each piece has its neighbours.
    is_whole: bool,
}

impl Outline {
    /// The outline of what a pen drew, filled by the nonzero rule.
    ///
    /// # Errors
    /// When it encloses nothing, or a coordinate is not finite.
    pub fn new(pen: Pen) -> Result<Outline, Flaw> {
        Outline::of_layers(vec![(pen, Rule::NonZero)])
    }

    /// The outline of what several drawings cover, each filled by its own rule.
    ///
    /// # Errors
    /// As of one.
    pub fn of_layers(layers: Vec<(Pen, Rule)>) -> Result<Outline, Flaw> {
        let mut drawn = Vec::new();
        let mut winding = Vec::with_capacity(layers.len());
        for (pen, rule) in layers {
            let before = drawn.len();
            for (piece, straight) in pen.finish()? {
                drawn.extend(winding::turning(&piece).map(|part| (part, straight)));
            }
            if drawn.len() > MOST_PIECES {
                return Err(Flaw::Count(drawn.len()));
            }
            winding.push((rule, drawn[before..].iter().map(|(p, _)| *p).collect()));
        }
        let size = drawn.iter().flat_map(|p| p.0.0).fold(0.0, |m: f64, p| m.max(p.abs().max_element()));
        let winding = Winding::new(winding);
        let (mut pieces, mut outside) = (Vec::new(), Vec::new());
        let cut = overlap::cut_at_crossings(&drawn);
        let count = cut.len();
        for (piece, straight) in cut {
            if let Some(side) = overlap::outer_side(&piece, &winding, size) {
                pieces.push((piece, straight));
                outside.push(side);
            }
        }
        if pieces.is_empty() {
            return Err(Flaw::Empty);
        }
        let is_whole = pieces.len() == count && count == drawn.len();
        let strand = Strand::new(pieces);
        let outside = strand.origins().iter().map(|i| outside[*i]).collect();
        Ok(Outline { strand, outside, winding, is_whole })
    }

    /// Whether another drawing has the same outline.
    pub fn is_same_as(&self, other: &Outline) -> bool {
        self.strand.pieces() == other.strand.pieces() && self.outside == other.outside
    }

    /// Whether a point is inside, and not on the outline.
    pub fn covers(&self, x: DVec2) -> bool {
        self.jet(Order::Value, x.extend(0.0)).value < -1e-9 * self.strand.size()
    }

    /// The jet at a point within reach, and what is at the nearest place.
    fn nearest(&self, order: Order, x: DVec3) -> (Point, Reading) {
        let (foot, reading) = self.strand.reading(x);
        let tangent = reading.tangent.xy();
        let normal = self.outside[foot.piece] * tangent.perp().normalize_or_zero();
        // From a place within a piece the direction is across it, one way or the other. Far away it is not known which of
        // two places that are close together is the nearest.
        let is_told = self.is_whole && foot.is_within() && reading.distance <= self.strand.size();
        let across = if is_told { normal.dot(reading.toward.xy()) } else { 0.0 };
        let inside = if across.abs() > 0.5 { across < 0.0 } else { self.is_inside(x.xy()) };
        let sign = if inside { -1.0 } else { 1.0 };
        let value = sign * reading.value;
        let mut gradient = sign * reading.toward.xy();
        let mut jet = Point { value, ..Point::default() };
        // The direction to a place within a piece is that across it, without the rounding that grows as the
        // place gets close, until nothing else is left of it; so it is at a place where pieces join smoothly.
        let close = reading.distance <= 1e-7 * self.strand.size();
        let lost = reading.distance <= 1e-12 * self.strand.size();
        let beside = foot.is_within() || close && gradient.dot(normal) > 1.0 - 1e-6 || lost;
        if beside {
            gradient = if gradient.dot(normal) < 0.0 && !close { -normal } else { normal };
        }
        if order == Order::Hessian {
            // Parallel to a line of curvature k the outline's is k / (1 - f k); around a corner 1 / f.
            let second = self.strand.pieces()[foot.piece].at(foot.t)[2].xy();
            let k = -normal.dot(second) / tangent.length_squared();
            let smooth = beside || gradient.dot(normal) > 1.0 - 1e-12;
            let bend = if smooth { k / (1.0 + value * k) } else { 1.0 / value };
            let along = gradient.perp();
            jet.hess =
                [bend * along.x * along.x, bend * along.y * along.y, 0.0, bend * along.x * along.y, 0.0, 0.0];
        }
        let gradient = gradient.extend(0.0);
        jet.grad = gradient.into();
        (jet, reading)
    }

    fn is_inside(&self, x: DVec2) -> bool {
        self.winding.covers(x)
    }

    fn jet(&self, order: Order, x: DVec3) -> Point {
        let flat = x.with_z(0.0 * x.z);
        if Strand::reaches(flat) { self.nearest(order, flat).0 } else { self.strand.jet(order, flat) }
    }

    /// The bow from the band around the tangent that the outline near a point keeps to.
    fn band(&self, c: DVec2, r: f64, jet: &Point, at: DVec2) -> Option<Interval> {
        let n = DVec3::from(jet.grad).xy();
        let reach = jet.value.abs() + 2.0 * r;
        let mut e = self.strand.band((c.extend(0.0), reach), (at.extend(0.0), n.extend(0.0)), r)?;
        e += 4.0 * self.strand.slack(c.abs().max_element() + reach);
        let side = (e + 0.5 * r) * n;
        let splits = !self.is_inside(at + side) && self.is_inside(at - side);
        let shift = n.dot(c - at) - jet.value;
        (splits && e < r).then_some(Interval { lo: shift - e, hi: shift + e })
    }
}

impl Kernel for Outline {
    fn class(&self) -> Class {
        Class::C0
    }

    fn bounds(&self) -> Bounds {
        BOUNDS
    }

    fn jets(&self, at: [&[f64]; 3], out: Jets<'_>) {
        lanes::fill(at, out, |order, x| self.jet(order, x));
    }

    fn is_uniform(&self) -> bool {
        false
    }

    fn local(&self, order: Order, at: [f64; 3], radius: f64) -> Local {
        let x = DVec3::from(at).with_z(0.0 * at[2]);
        if !Strand::reaches(x) || !Strand::reaches(DVec3::splat(radius)) {
            return Local::uniform(self.jet(order, x), BOUNDS);
        }
        let (jet, reading) = self.nearest(order, x);
        let (d, sign) = (reading.distance, if jet.value < 0.0 { -1.0 } else { 1.0 });
        let gradient = DVec3::from(jet.grad);
        let place = x.xy() - jet.value * gradient.xy();
        let band = (d <= 2.0 * radius).then(|| self.band(x.xy(), radius, &jet, place)).flatten();
        let bow = match band {
            Some(band) => band,
            None if d > radius => self.strand.bow(x, radius, &reading, sign * gradient) * sign,
            None => Interval::ENTIRE,
        };
        Local { jet, bounds: BOUNDS, bow, sag: f64::INFINITY, turn: f64::INFINITY }
    }

    fn lean(&self, at: [f64; 3], radius: f64) -> Option<Lean> {
        let x = DVec3::from(at).with_z(0.0 * at[2]);
        if !self.is_whole || !Strand::reaches(x) || !Strand::reaches(DVec3::splat(radius)) {
            return None;
        }
        let (_, reading) = self.strand.reading(x);
        let reach = reading.distance + 2.0 * radius + self.strand.slack(x.abs().max_element() + radius);
        let (mut fan, mut off) = (None, 0.0_f64);
        let holds = self.strand.tangents(x, reach, |piece, tangent| {
            let (tangent, rounding) = (tangent.xy(), 16.0 * ROUNDOFF * self.strand.size());
            if tangent == DVec2::ZERO {
                return true;
            }
            let normal = self.outside[piece] * tangent.perp().normalize_or_zero();
            off = off.max(rounding / tangent.length());
            fan.get_or_insert(Fan::of(normal)).widen(normal)
        });
        if holds { fan.and_then(|fan: Fan| fan.lean(off)) } else { None }
    }

    fn error(&self, size: f64) -> [f64; 3] {
        [self.strand.slack(size), 16.0 * ROUNDOFF, f64::INFINITY]
    }
}

impl Body for Outline {
    fn name(&self) -> &'static str {
        "outline"
    }

    fn digest(&self, digest: &mut Digest) {
        self.strand.digest(digest);
        digest.numbers(self.outside.iter().copied());
        // What is covered by something else has no piece in the outline, but says where its inside is.
        digest.whole(u64::from(self.is_whole));
        self.winding.digest(digest);
    }
}
