//! Ray casting: where a ray first meets a surface.
//!
//! A caster takes rays in groups, because the work of a group is batched: one instruction of the
//! tape serves many rays.
//!
//! Three casters share one loop (`group.rs`), in which rays never influence one another:
//! [`Kind::Sphere`] and [`Kind::Speculative`] sphere tracing, which need a Lipschitz bound, and
//! [`Kind::Affine`], which needs none. [`Kind::Beam`] (`beam/`) has rays of one origin share what is
//! certain of all of them; their hits depend on the group, within the tolerance.

mod affine;
mod beam;
mod group;
mod sphere;

use crate::field::{Field, lipschitz_outside};
use crate::num::ROUNDOFF;
use crate::scene::Aabb;
use crate::tape::Census;
use affine::AffineMarch;
use beam::Beams;
use glam::DVec3;
use group::Group;
use sphere::{SphereTracing, Spheres};
use std::sync::atomic::AtomicBool;

/// A piece of a line: `origin + t direction` for `near <= t <= far`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where `t` is zero.
    pub origin: DVec3,
    /// Unit vector.
    pub direction: DVec3,
    /// Smallest `t`.
    pub near: f64,
    /// Largest `t`.
    pub far: f64,
    /// How precisely a hit is wanted.
    pub tolerance: Tolerance,
}

/// How far a hit may lie in front of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// At least this far.
    pub least: f64,
    /// As a share of the distance along the ray: what looks equally precise from the origin.
    pub growth: f64,
}

impl Tolerance {
    /// The same everywhere.
    pub fn fixed(least: f64) -> Self {
        Tolerance { least, growth: 0.0 }
    }

    /// At `t` along a ray.
    pub fn at(&self, t: f64) -> f64 {
        self.least.max(self.growth * t)
    }
}

impl Ray {
    /// The point at `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }

    /// How far, on any axis, the computed points up to `t` may lie from the line: a product and a sum
    /// are rounded, for the middle of a piece and for its half length.
    fn rounding(&self, t: f64) -> f64 {
        4.0 * ROUNDOFF * (self.origin.abs().max_element() + t.abs())
    }
}

/// Where a ray meets the surface, or that it does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray of a point within the tolerance of the surface; infinite for a miss.
    pub t: f64,
    /// Whether it is proven that nothing was missed before `t`, and that the field changes sign or
    /// comes within the tolerance there.
    pub certified: bool,
}

impl Hit {
    /// A proven miss.
    pub const MISS: Hit = Hit { t: f64::INFINITY, certified: true };

    /// Whether the surface was met.
    pub fn is_hit(&self) -> bool {
        self.t.is_finite()
    }
}

/// What casting cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct CastStats {
    /// Rays cast.
    pub rays: u64,
    /// Rays that met the surface.
    pub hits: u64,
    /// Evaluations of the field, at points or over pieces of rays.
    pub evaluations: u64,
    /// Of these, the ones that served a whole beam of rays.
    pub shared: u64,
    /// Beams of which every ray was proven to miss at once.
    pub culled: u64,
    /// Steps taken forward, or pieces examined.
    pub steps: u64,
    /// Steps that had to be taken back.
    pub backtracks: u64,
    /// Rays whose answer is not proven.
    pub uncertified: u64,
    /// Of these, the ones that were given up after too many pieces; the others came by places where
    /// the field is not known to be finite.
    pub given_up: u64,
}

impl std::ops::AddAssign for CastStats {
    fn add_assign(&mut self, o: CastStats) {
        self.rays += o.rays;
        self.hits += o.hits;
        self.evaluations += o.evaluations;
        self.shared += o.shared;
        self.culled += o.culled;
        self.steps += o.steps;
        self.backtracks += o.backtracks;
        self.uncertified += o.uncertified;
        self.given_up += o.given_up;
    }
}

/// A way to find first hits. One value serves one thread; `clone_box` makes another.
pub trait Caster: Send {
    /// First hits of a group of rays, in their order. `out` has as many entries as `rays`. Once
    /// `cancel` is set, rays that are still under way are given up and their entries left alone.
    fn first_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool);

    /// Evaluations of the field that each ray of the last group needed, in their order; one that served
    /// `n` rays at once is `1 / n` to each of them. Together they are what the group added to
    /// [`CastStats::evaluations`], but for rounding. They are always counted, since that costs nothing
    /// beside an evaluation.
    fn costs(&self) -> &[f64];

    /// The same caster with memory of its own, for another thread.
    fn clone_box(&self) -> Box<dyn Caster>;
}

/// Which caster.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// The one that suits the field.
    #[default]
    Auto,
    /// Sphere tracing.
    Sphere,
    /// Speculative sphere tracing.
    Speculative,
    /// Reduced affine arithmetic with interval optimisation.
    Affine,
    /// Beams of rays with certificates on both sides.
    Beam,
}

impl Kind {
    /// All kinds, with the names that the command line uses.
    pub const ALL: [(Kind, &'static str); 5] = [
        (Kind::Beam, "beam"),
        (Kind::Auto, "auto"),
        (Kind::Sphere, "sphere"),
        (Kind::Speculative, "speculative"),
        (Kind::Affine, "affine"),
    ];
}

/// Why a caster cannot serve a field.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
pub enum CastError {
    /// Sphere tracing without a Lipschitz bound.
    #[error(
        "the field has no Lipschitz bound in the region, so sphere tracing cannot be certain of anything; use the affine caster"
    )]
    NoLipschitzBound,
}

/// A caster for a field within a region. `typical` rays help [`Kind::Auto`] to choose.
///
/// # Errors
/// [`CastError::NoLipschitzBound`] where sphere tracing was asked for and cannot be had.
pub fn caster(
    kind: Kind,
    field: &mut Field,
    region: &Aabb,
    typical: &[Ray],
) -> Result<Box<dyn Caster>, CastError> {
    let tape = field.tape().clone();
    let affine = || Box::new(Group::new(AffineMarch { all: false }, tape.clone()));
    if kind == Kind::Affine {
        return Ok(affine());
    }
    if kind == Kind::Beam {
        return Ok(Box::new(Beams::new(tape)));
    }
    let lipschitz = lipschitz_outside(field, region);
    let bounded = lipschitz.is_finite() && lipschitz > 0.0;
    let spheres = |relaxation| Box::new(Spheres::new(SphereTracing { lipschitz, relaxation }, tape.clone()));
    match kind {
        Kind::Auto if bounded && lipschitz < STEEP => {
            let (mut one, mut other) = (spheres(RELAXATION), affine());
            let (at_points, along_pieces) = costs(tape.census());
            let cost = [at_points * trial(&mut *one, typical), along_pieces * trial(&mut *other, typical)];
            Ok(if cost[0] < cost[1] { one } else { other })
        }
        Kind::Auto => Ok(affine()),
        _ if !bounded => Err(CastError::NoLipschitzBound),
        Kind::Sphere => Ok(spheres(1.0)),
        _ => Ok(spheres(RELAXATION)),
    }
}

/// What an evaluation at a point costs, and what one along a piece of a ray: about as many
/// nanoseconds in batches with AVX-512 (`benches/casting.rs`). Their ratio decides, not the clock, so
/// that the choice, and with it the picture, is the same on every machine.
fn costs(census: Census) -> (f64, f64) {
    let [sums, functions, octaves] = [census.sums, census.functions, census.octaves].map(|n| n as f64);
    (2.0 * (sums + functions) + 10.0 * octaves, 10.0 * sums + 60.0 * (functions + octaves))
}

/// Lipschitz bound above which sphere tracing is not worth a trial.
const STEEP: f64 = 1e4;

/// Evaluations that the rays need.
fn trial(caster: &mut dyn Caster, rays: &[Ray]) -> f64 {
    let mut stats = CastStats::default();
    caster.first_hits(rays, &mut vec![Hit::MISS; rays.len()], &mut stats, &AtomicBool::new(false));
    stats.evaluations as f64
}

/// Over-relaxation of speculative sphere tracing, as Worley and Hart recommend.
const RELAXATION: f64 = 1.46;

/// All roots along each ray in increasing order, as pieces no longer than the tolerance that hold
/// at least one change of sign or come within rounding of zero, and whether each list is proven
/// complete.
pub fn all_hits(field: &Field, rays: &[Ray], stats: &mut CastStats) -> Vec<(Vec<(f64, f64)>, bool)> {
    let mut group = Group::new(AffineMarch { all: true }, field.tape().clone());
    let mut out = vec![(Vec::new(), true); rays.len()];
    group.march(rays, stats, &AtomicBool::new(false), |i, march, hit| out[i] = (march.roots, hit.certified));
    out
}
