//! Curves with a radius that varies along them: wires, vines, knots, corals.
//!
//! The distance from the surface that a ball sweeps as it runs along the curve and grows and shrinks:
//! the least of `|x - C(t)| - R(t)`. Curves of all kinds are cubics with a radius for a fourth
//! coordinate (see `strand`); lower degrees are raised, which changes nothing. The distance is exact
//! outside; inside it is that to the nearest of the balls' surfaces as seen from their centres.

use super::strand::{BOUNDS, Piece, Strand};
use super::{Body, Digest, lanes};
use crate::num::{Bounds, Class, Jets, Kernel, Lean, Local, Order, ROUNDOFF};
use glam::{DVec3, DVec4};

/// How a curve follows its points.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kind {
    /// Straight from point to point.
    Polyline,
    /// Bezier curves of a degree, one after the other; each begins where the last one ends.
    Bezier(Degree),
    /// The uniform B-spline of a degree, which the points pull at; an open one begins and ends at the
    /// outermost points.
    Bspline(Degree),
    /// A cubic spline through all points, parallel at each to the line between its neighbours.
    CatmullRom,
}

/// Of polynomials.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Degree {
    /// Lines.
    One,
    /// Parabolas.
    Two,
    /// Cubics.
    Three,
}

/// Points that a curve may have.
pub const MOST_POINTS: usize = 1_000_000;

/// Largest coordinate and radius.
pub const FARTHEST: f64 = 1e15;

/// Why some points and radii are no curve.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
pub enum Flaw {
    /// Too few points, or too many.
    #[error("a curve of this kind needs from {least} to {MOST_POINTS} points, not {given}")]
    Count {
        /// How few there may be.
        least: usize,
        /// How many there are.
        given: usize,
    },
    /// Pieces that do not come out even.
    #[error("{given} points do not make whole pieces: {first} and then {step} more for each piece")]
    Rest {
        /// How many there are.
        given: usize,
        /// Points before the first piece.
        first: usize,
        /// Points a piece.
        step: usize,
    },
    /// A point is nowhere, or too far away.
    #[error("point {0} of the curve is not finite, or beyond 1e15")]
    Point(usize),
    /// There is no radius.
    #[error("the curve has no radius")]
    NoRadius,
    /// A radius is negative, or not a number.
    #[error("radius {at} of the curve is {radius}: radii are from 0 to 1e15")]
    Radius {
        /// Which.
        at: usize,
        /// What it is.
        radius: f64,
    },
}

/// A curve with a radius.
#[derive(Debug)]
pub struct Curve {
    strand: Strand,
}

impl Curve {
    /// The curve that follows points. Radii are spread evenly over the points and vary linearly between:
    /// one is the radius of all, as many as there are points are theirs. A closed curve goes on from the
    /// last point to the first.
    ///
    /// # Errors
    /// When there are too few points for the kind, or a number is not finite, or a radius negative.
    pub fn new(points: &[DVec3], radii: &[f64], kind: Kind, closed: bool) -> Result<Curve, Flaw> {
        let least = if closed { 3 } else { 2 };
        if !(least..=MOST_POINTS).contains(&points.len()) {
            return Err(Flaw::Count { least, given: points.len() });
        }
        if let Some(at) = points.iter().position(|p| !(p.is_finite() && p.abs().max_element() <= FARTHEST)) {
            return Err(Flaw::Point(at));
        }
        if let Some(at) = radii.iter().position(|r| !(0.0..=FARTHEST).contains(r)) {
            return Err(Flaw::Radius { at, radius: radii[at] });
        }
        if radii.is_empty() {
            return Err(Flaw::NoRadius);
        }
        // The way round of a closed curve ends at the first radius again.
        let around = usize::from(!closed);
        let (steps, gaps) = (points.len() - around, radii.len() - around.min(radii.len() - 1));
        let own = |i: usize| {
            let at = (i * gaps) as f64 / steps as f64;
            let before = at.floor();
            let [a, b] = [0, 1].map(|k| radii[(before as usize + k) % radii.len()]);
            a + (b - a) * (at - before)
        };
        let controls: Vec<DVec4> =
            points.iter().enumerate().map(|(i, p)| p.extend(own(i).max(0.0))).collect();
        let straight =
            matches!(kind, Kind::Polyline | Kind::Bezier(Degree::One) | Kind::Bspline(Degree::One));
        let strand = Strand::new(pieces(&controls, kind, closed)?.into_iter().map(|p| (p, straight)));
        Ok(Curve { strand })
    }
}

#[cfg(test)]
impl Curve {
    pub(super) fn strand(&self) -> &Strand {
        &self.strand
    }
}

/// A parabola as a cubic.
pub(super) fn raised([a, b, c]: [DVec4; 3]) -> Piece {
    Piece([a, (a + 2.0 * b) / 3.0, (2.0 * b + c) / 3.0, c])
}

/// The cubics of a curve.
fn pieces(p: &[DVec4], kind: Kind, closed: bool) -> Result<Vec<Piece>, Flaw> {
    let n = p.len();
    let spans = if closed { n } else { n - 1 };
    // Points before the first and after the last go on as the outermost two do.
    let at = |i: isize| match (closed, i) {
        (true, i) => p[i.rem_euclid(n as isize) as usize],
        (false, ..0) => 2.0 * p[0] - p[1],
        (false, i) if i as usize >= n => 2.0 * p[n - 1] - p[n - 2],
        (false, i) => p[i as usize],
    };
    let each = |f: &dyn Fn(isize) -> Piece| (0..spans as isize).map(f).collect();
    Ok(match kind {
        Kind::Polyline | Kind::Bezier(Degree::One) | Kind::Bspline(Degree::One) => {
            each(&|i| Piece::straight(at(i), at(i + 1)))
        }
        Kind::Bezier(degree) => {
            let step = if degree == Degree::Two { 2 } else { 3 };
            let first = usize::from(!closed);
            if n < first + step || !(n - first).is_multiple_of(step) {
                return Err(Flaw::Rest { given: n, first, step });
            }
            let piece = |i: isize| match step {
                2 => raised([at(i), at(i + 1), at(i + 2)]),
                _ => Piece([at(i), at(i + 1), at(i + 2), at(i + 3)]),
            };
            (0..n - first).step_by(step).map(|i| piece(i as isize)).collect()
        }
        Kind::Bspline(Degree::Two) if n == 2 => vec![Piece::straight(p[0], p[1])],
        Kind::Bspline(Degree::Two) => {
            let middle = |i: isize| 0.5 * (at(i) + at(i + 1));
            let inner = if closed { 0..n as isize } else { 1..n as isize - 1 };
            let last = n as isize - 1;
            let begin = |i: isize| if !closed && i == 1 { at(0) } else { middle(i - 1) };
            let end = |i: isize| if !closed && i == last - 1 { at(last) } else { middle(i) };
            inner.map(|i| raised([begin(i), at(i), end(i)])).collect()
        }
        Kind::Bspline(Degree::Three) => {
            let knot = |i: isize| (at(i - 1) + 4.0 * at(i) + at(i + 1)) / 6.0;
            each(&|i| {
                let (a, b) = (at(i), at(i + 1));
                Piece([knot(i), (2.0 * a + b) / 3.0, (a + 2.0 * b) / 3.0, knot(i + 1)])
            })
        }
        Kind::CatmullRom => each(&|i| {
            let (a, b) = (at(i), at(i + 1));
            Piece([a, a + (b - at(i - 1)) / 6.0, b - (at(i + 2) - a) / 6.0, b])
        }),
    })
}

impl Kernel for Curve {
    fn class(&self) -> Class {
        Class::C0
    }

    fn bounds(&self) -> Bounds {
        BOUNDS
    }

    fn jets(&self, at: [&[f64]; 3], out: Jets<'_>) {
        lanes::fill(at, out, |order, x| self.strand.jet(order, x));
    }

    fn is_uniform(&self) -> bool {
        false
    }

    fn local(&self, order: Order, at: [f64; 3], radius: f64) -> Local {
        let (jet, bow) = self.strand.around(order, at.into(), radius);
        Local { jet, bounds: BOUNDS, bow, sag: f64::INFINITY, turn: f64::INFINITY }
    }

    fn lean(&self, at: [f64; 3], radius: f64) -> Option<Lean> {
        self.strand.lean(at.into(), radius)
    }

    fn error(&self, size: f64) -> [f64; 3] {
        [self.strand.slack(size), 16.0 * ROUNDOFF, f64::INFINITY]
    }
}

impl Body for Curve {
    fn name(&self) -> &'static str {
        "curve"
    }

    fn digest(&self, digest: &mut Digest) {
        self.strand.digest(digest);
    }
}
