//! Casting with reduced affine arithmetic and interval optimisation (thesis, 5.3 and 5.4).
//!
//! Over a piece of the ray, `t = t0 + t1 e`, the field lies in `g0 + g1 e +- g2`. If that excludes
//! zero the piece is free; if not, only the part where the band crosses zero,
//!
//! ```text
//! t0 - (g0 / g1) t1 +- (g2 / |g1|) t1,
//! ```
//!
//! can hold roots. The thesis bisects the whole ray, depth first. Marching needs fewer evaluations
//! and no stack: it tries the piece ahead of the free frontier, twice as long as the last free one;
//! when the piece is not free the trimmed part is tried next, or half of it if trimming gained
//! little. The same march goes on behind a root, which gives all of them in order.

use super::group::Strategy;
use super::{CastStats, Hit, Ray};
use crate::num::Reduced;

/// Pieces after which a ray is given up, uncertified.
const PIECES: u32 = 20_000;

/// Reduced affine arithmetic along the ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct AffineMarch {
    /// Whether to go on behind roots.
    pub all: bool,
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
    pieces: u32,
    certified: bool,
    /// Roots found, as pieces no longer than the tolerance.
    pub roots: Vec<(f64, f64)>,
}

impl AffineMarch {
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

    /// The first hit of a ray that meets the inside before any root: there the frontier has not left
    /// the ray's beginning, unless it went past something undefined.
    fn began_inside(&self, march: &March) -> Hit {
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
        if !self.all {
            return Some(Hit { t: a, certified: march.certified });
        }
        let beyond = march.beyond;
        self.advance(ray, march, if b >= march.end { beyond } else { b }, ray.tolerance.at(b))
    }
}

impl Strategy for AffineMarch {
    type Number = Reduced<1>;
    type March = March;

    fn start(&self, ray: &Ray) -> March {
        let end = ray.near + (ray.far - ray.near) * 0.25;
        March { free: ray.near, end, beyond: end, pieces: 0, certified: true, roots: Vec::new() }
    }

    fn ask(&self, ray: &Ray, march: &March) -> [Reduced<1>; 3] {
        let (mid, half) = middle(march.free, march.end);
        let (c, d) = (ray.at(mid).to_array(), (ray.direction * half).to_array());
        let rest = ray.rounding(march.end);
        std::array::from_fn(|axis| Reduced::within(c[axis], [d[axis]], rest))
    }

    fn tell(&self, ray: &Ray, march: &mut March, g: &Reduced<1>, stats: &mut CastStats) -> Option<Hit> {
        stats.steps += 1;
        march.pieces += 1;
        let (a, b) = (march.free, march.end);
        if !g.range.contains(0.0) {
            if g.range.hi < 0.0 && !self.all {
                return Some(self.began_inside(march));
            }
            let at = march.beyond;
            return self.advance(ray, march, at, 2.0 * (b - a));
        }
        if march.pieces > PIECES {
            march.certified = false;
            stats.given_up += 1;
            return Some(Hit { t: a, certified: false });
        }
        let (ta, tb) = trim(a, b, g);
        if ta > a && g.mid < g.slope[0] && !self.all {
            // The band is below zero at the left end, where it is free of roots.
            return Some(self.began_inside(march));
        }
        // A band that crosses zero within the piece changes sign there. One that reaches zero only
        // at an end of the piece proves nothing until that end has been looked at by itself.
        let tolerance = ray.tolerance.at(a);
        let crosses = a < ta && tb < b && tb - ta <= tolerance;
        if crosses || b - a <= tolerance || a + (b - a) * 0.5 <= a {
            if g.range.is_finite() {
                return self.found(ray, march, ta, tb);
            }
            // Undefined or unbounded here, however closely one looks: pass, but say so.
            march.certified = false;
            let at = march.beyond;
            return self.advance(ray, march, at, b - a);
        }
        let trimmed = tb - ta < 0.5 * (b - a);
        march.free = ta;
        if trimmed {
            if tb < b {
                march.beyond = march.beyond.max(b);
            }
            march.end = tb;
        } else {
            stats.backtracks += 1;
            march.end = ta + 0.5 * (tb - ta);
            march.beyond = march.end;
        }
        None
    }
}

/// Middle and half length of a piece; the half length covers both ends.
fn middle(a: f64, b: f64) -> (f64, f64) {
    let mid = 0.5 * (a + b);
    (mid, (mid - a).max(b - mid))
}

/// The part of `[a, b]` where the affine band meets zero, rounded outward.
fn trim(a: f64, b: f64, g: &Reduced<1>) -> (f64, f64) {
    let (mid, half) = middle(a, b);
    let slope = g.slope[0];
    let centre = mid - g.mid / slope * half;
    let width = g.rest / slope.abs() * half;
    let slack = 8.0 * f64::EPSILON * (mid.abs() + centre.abs() + width);
    let (ta, tb) = ((centre - width - slack).max(a), (centre + width + slack).min(b));
    // A flat band (slope zero gives NaN or infinity) cannot be trimmed; neither can one that
    // rounding has pushed past the piece.
    if ta <= tb { (ta, tb) } else { (a, b) }
}
