//! Casting with an enclosure of the field along pieces of the ray (thesis, 5.3 and 5.4).
//!
//! Over a piece of the ray an [`Along`] arithmetic encloses the field. If that excludes zero the piece
//! is free; if not, it is cut. The thesis bisects the whole ray, depth first. Marching needs fewer
//! evaluations and no stack: it tries the piece ahead of the free frontier, twice as long as the last
//! free one, and halves a piece that is not free. The same march goes on behind a root, which gives
//! all of them in order. Every arithmetic has the same march, so that it alone makes the difference.
//!
//! *Interval optimisation*: where the arithmetic knows the field as a band `g0 + g1 e +- g2` along the
//! piece `t = t0 + t1 e`, only the part where the band crosses zero,
//!
//! ```text
//! t0 - (g0 / g1) t1 +- (g2 / |g1|) t1,
//! ```
//!
//! can hold roots. That part is tried next, or half of it if trimming gained little. A band that crosses
//! zero within the piece proves a root. Without bands a piece as short as the tolerance says nothing
//! of a root but that there may be one: then the field at its end tells a root from a near miss. Where the field may
//! jump, no arithmetic gets across, even if values are alike on both sides: such a piece is passed without a proof if it
//! does not end inside.

use super::along::{Along, Band};
use super::group::Strategy;
use super::{CastStats, Hit, Ray};
use crate::num::Class;
use crate::tape::Cells;
use std::marker::PhantomData;

/// Pieces after which a ray is given up, uncertified.
const PIECES: u32 = 20_000;

/// Share of the tolerance at which a piece is a hit although no change of sign is proven.
const GRAZE: f64 = 1.0 / 64.0;

/// What is wanted of a ray.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Seek {
    /// Its first root, or its beginning if that is inside.
    First,
    /// Whether it meets the solid.
    Any,
    /// All of its roots.
    All,
}

/// A march along enclosed pieces.
#[derive(Debug)]
pub(super) struct Pieces<A> {
    seek: Seek,
    /// Whether to trim pieces.
    optimised: bool,
    /// Whether the field may jump.
    jumps: bool,
    arithmetic: PhantomData<fn() -> A>,
}

impl<A> Clone for Pieces<A> {
    fn clone(&self) -> Self {
        Pieces { ..*self }
    }
}

/// Progress of one ray.
#[derive(Clone, Debug)]
pub(super) struct March {
    /// Everything before is free, or its roots are known.
    free: f64,
    /// End of the piece under examination.
    end: f64,
    /// Free beyond `end`, up to here: the part that trimming cut off.
    beyond: f64,
    /// Whether the field is asked for at the end alone.
    probing: bool,
    pieces: u32,
    certified: bool,
    /// Roots found, as pieces no longer than the tolerance.
    pub roots: Vec<(f64, f64)>,
}

impl<A> Pieces<A> {
    /// Looks for first roots of the field in these cells by cutting pieces in halves.
    pub(super) fn halving(cells: &Cells) -> Self {
        let jumps = cells.tape().class() == Class::Jump;
        Pieces { seek: Seek::First, optimised: false, jumps, arithmetic: PhantomData }
    }

    /// The same by trimming pieces to where they may hold roots.
    pub(super) fn trimming(cells: &Cells) -> Self {
        Pieces { optimised: true, ..Pieces::halving(cells) }
    }

    /// The same way to all roots.
    pub(super) fn all(self) -> Self {
        Pieces { seek: Seek::All, ..self }
    }

    /// Moves the frontier to `t` and tries a piece of this length next.
    fn advance(&self, ray: &Ray, march: &mut March, t: f64, length: f64) -> Option<Hit> {
        march.free = t;
        if t >= ray.far {
            return Some(match march.roots.first() {
                Some(&(t, _)) => Hit { t, certified: march.certified },
                None => Hit { certified: march.certified, ..Hit::MISS },
            });
        }
        // Never nothing: a piece too short to move a frontier this far out would be tried for ever.
        march.end = (t + length).max(t.next_up()).min(ray.far);
        march.beyond = march.end;
        None
    }

    /// Tries half of a piece.
    fn halve(&self, march: &mut March, a: f64, b: f64, stats: &mut CastStats) -> Option<Hit> {
        stats.backtracks += 1;
        march.free = a;
        march.end = a + 0.5 * (b - a);
        march.beyond = march.end;
        None
    }

    /// The hit of a ray that is inside, or is certain to get there, within the piece at the frontier.
    fn inside(&self, march: &March) -> Hit {
        Hit { t: march.free, certified: march.certified }
    }

    /// A root in `[a, b]`, known to the tolerance.
    fn found(&self, ray: &Ray, march: &mut March, a: f64, b: f64) -> Option<Hit> {
        let merged = match march.roots.last_mut() {
            // Neighbouring pieces around one root.
            Some(last) if a <= last.1 + ray.tolerance.at(a) => {
                last.1 = b;
                true
            }
            _ => false,
        };
        if !merged {
            march.roots.push((a, b));
        }
        if self.seek != Seek::All {
            return Some(Hit { t: a, certified: march.certified });
        }
        let beyond = march.beyond;
        self.advance(ray, march, if b >= march.end { beyond } else { b }, ray.tolerance.at(b))
    }
}

impl<A: Along> Strategy for Pieces<A> {
    type Batch = A::Batch;
    type March = March;

    fn any(&self) -> Self {
        Pieces { seek: Seek::Any, ..*self }
    }

    fn start(&self, ray: &Ray) -> March {
        let end = ray.near + (ray.far - ray.near) * 0.25;
        March {
            free: ray.near,
            end,
            beyond: end,
            probing: false,
            pieces: 0,
            certified: true,
            roots: Vec::new(),
        }
    }

    fn ask(&self, ray: &Ray, march: &March) -> [A; 3] {
        let (mid, half) = middle(if march.probing { march.end } else { march.free }, march.end);
        A::line(ray.at(mid).to_array(), (ray.direction * half).to_array(), ray.rounding(march.end))
    }

    fn tell(&self, ray: &Ray, march: &mut March, g: &A, stats: &mut CastStats) -> Option<Hit> {
        stats.steps += 1;
        march.pieces += 1;
        let (a, b, range) = (march.free, march.end, g.range());
        if std::mem::take(&mut march.probing) {
            let inside = range.hi < 0.0;
            return if inside { self.found(ray, march, a, b) } else { self.halve(march, a, b, stats) };
        }
        if !range.contains(0.0) {
            // A first hit that is inside before any root: the frontier has not left the ray's
            // beginning, unless it went past something undefined.
            if range.hi < 0.0 && self.seek != Seek::All {
                return Some(self.inside(march));
            }
            let at = march.beyond;
            return self.advance(ray, march, at, 2.0 * (b - a));
        }
        if march.pieces > PIECES {
            stats.given_up += 1;
            march.certified = false;
            return Some(Hit { t: a, certified: false });
        }
        let band = g.band().filter(|_| self.optimised);
        let (ta, tb) = band.as_ref().map_or((a, b), |band| trim(a, b, band));
        if ta > a && band.is_some_and(|g| g.mid < g.slope) && self.seek != Seek::All {
            // The band is below zero at the left end, where it is free of roots.
            return Some(self.inside(march));
        }
        // A band that crosses zero within the piece changes sign there. One that reaches zero only
        // at an end of the piece proves nothing until that end has been looked at by itself.
        let crosses = a < ta && tb < b;
        if crosses && self.seek == Seek::Any {
            return Some(self.inside(march));
        }
        let tolerance = ray.tolerance.at(a);
        let close = crosses && tb - ta <= tolerance;
        let shortest = a + (b - a) * 0.5 <= a;
        if close || b - a <= tolerance || shortest {
            let probes = !self.optimised || self.jumps && !close && self.seek != Seek::All;
            if probes && !shortest && b - a > GRAZE * tolerance && range.is_finite() {
                march.probing = true;
                return None;
            }
            // Undefined, unbounded or torn here, however closely one looks: pass, but say so.
            let is_whole = close || !self.jumps;
            march.certified &= range.is_finite() && is_whole;
            if range.is_finite() && (is_whole || self.seek == Seek::All) {
                return self.found(ray, march, ta, tb);
            }
            // What was trimmed off behind has no roots, but may be inside.
            let at = if range.is_finite() { b } else { march.beyond };
            return self.advance(ray, march, at, b - a);
        }
        if tb - ta >= 0.5 * (b - a) {
            return self.halve(march, ta, tb, stats);
        }
        march.free = ta;
        if tb < b {
            march.beyond = march.beyond.max(b);
        }
        march.end = tb;
        None
    }
}

/// Middle and half length of a piece; the half length covers both ends.
fn middle(a: f64, b: f64) -> (f64, f64) {
    let mid = 0.5 * (a + b);
    (mid, (mid - a).max(b - mid))
}

/// The part of `[a, b]` where the affine band meets zero, rounded outward.
fn trim(a: f64, b: f64, g: &Band) -> (f64, f64) {
    let (mid, half) = middle(a, b);
    let centre = mid - g.mid / g.slope * half;
    let width = g.rest / g.slope.abs() * half;
    let slack = 8.0 * f64::EPSILON * (mid.abs() + centre.abs() + width);
    let (ta, tb) = ((centre - width - slack).max(a), (centre + width + slack).min(b));
    // A flat band (slope zero gives NaN or infinity) cannot be trimmed; neither can one that
    // rounding has pushed past the piece.
    if ta <= tb { (ta, tb) } else { (a, b) }
}
