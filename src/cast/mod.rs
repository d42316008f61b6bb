//! Ray casting: where a ray first meets a surface.
//!
//! A caster takes rays in groups, because the work of a group is batched: one instruction of the
//! tape serves many rays. Rays never influence one another, so any grouping gives the same hits.

//!
//! Three casters share the loop of [`group`](self): [`Kind::Sphere`] and [`Kind::Speculative`]
//! sphere tracing, which need a Lipschitz bound, and [`Kind::Affine`], which needs none.

mod affine;
mod group;
mod sphere;

use crate::field::{Field, lipschitz_outside};
use crate::scene::{Aabb, direction};
use affine::AffineMarch;
use glam::DVec3;
use group::Group;
use sphere::{SphereTracing, Spheres};

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
}

impl Ray {
    /// The point at `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }
}

/// Where a ray meets the surface, or that it does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray of a point just in front of the surface; infinite for a miss.
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
    /// Steps taken forward, or pieces examined.
    pub steps: u64,
    /// Steps that had to be taken back.
    pub backtracks: u64,
    /// Rays whose answer is not proven.
    pub uncertified: u64,
}

impl std::ops::AddAssign for CastStats {
    fn add_assign(&mut self, o: CastStats) {
        self.rays += o.rays;
        self.hits += o.hits;
        self.evaluations += o.evaluations;
        self.steps += o.steps;
        self.backtracks += o.backtracks;
        self.uncertified += o.uncertified;
    }
}

/// A way to find first hits. One value serves one thread; `clone_box` makes another.
pub trait Caster: Send {
    /// First hits of a group of rays, in their order. `out` has as many entries as `rays`.
    fn first_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats);

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
}

impl Kind {
    /// All kinds, with the names that the command line uses.
    pub const ALL: [(Kind, &'static str); 4] = [
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

/// A caster for a field within a region, with a tolerance along the ray.
///
/// # Errors
/// [`CastError::NoLipschitzBound`] where sphere tracing was asked for and cannot be had.
pub fn caster(
    kind: Kind,
    field: &mut Field,
    region: &Aabb,
    tolerance: f64,
) -> Result<Box<dyn Caster>, CastError> {
    let tape = field.tape().clone();
    let affine = || Box::new(Group::new(AffineMarch { tolerance, all: false }, tape.clone()));
    if kind == Kind::Affine {
        return Ok(affine());
    }
    let lipschitz = lipschitz_outside(field, region);
    let bounded = lipschitz.is_finite() && lipschitz > 0.0;
    let spheres =
        |relaxation| Box::new(Spheres::new(SphereTracing { lipschitz, relaxation, tolerance }, tape.clone()));
    match kind {
        Kind::Auto if bounded && lipschitz < STEEP => {
            let (mut one, mut other) = (spheres(RELAXATION), affine());
            let rays = trial_rays(region);
            let cost = [trial(&mut *one, &rays), AFFINE_COST * trial(&mut *other, &rays)];
            Ok(if cost[0] <= cost[1] { one } else { other })
        }
        Kind::Auto => Ok(affine()),
        _ if !bounded => Err(CastError::NoLipschitzBound),
        Kind::Sphere => Ok(spheres(1.0)),
        _ => Ok(spheres(RELAXATION)),
    }
}

/// What an evaluation along a piece of a ray costs, in evaluations at a point (`benches/casting.rs`).
const AFFINE_COST: f64 = 5.0;
/// Lipschitz bound above which sphere tracing is not worth a trial.
const STEEP: f64 = 1e4;

/// Rays from around the region to points all over it, spread by irrational steps.
fn trial_rays(region: &Aabb) -> Vec<Ray> {
    let (centre, reach) = ((region.min + region.max) * 0.5, region.diagonal());
    let fraction = |i: u32, step: f64| (f64::from(i) * step).fract();
    let ray = |i: u32| {
        let from =
            direction(360.0 * fraction(i, 0.618_033_988_75), 180.0 * fraction(i, 0.754_877_666_25) - 90.0);
        let spread = DVec3::new(
            fraction(i, 0.819_172_513_4),
            fraction(i, 0.671_043_606_7),
            fraction(i, 0.549_700_477_9),
        );
        let (origin, aim) = (centre + reach * from, region.min + spread * (region.max - region.min));
        let direction = (aim - origin).normalize_or_zero();
        let (near, far) = region.clip(origin, direction)?;
        Some(Ray { origin, direction, near: near.max(0.0), far })
    };
    (1..=96).filter_map(ray).collect()
}

/// Evaluations that the rays need.
fn trial(caster: &mut dyn Caster, rays: &[Ray]) -> f64 {
    let mut stats = CastStats::default();
    caster.first_hits(rays, &mut vec![Hit::MISS; rays.len()], &mut stats);
    stats.evaluations as f64
}

/// Over-relaxation of speculative sphere tracing, as Worley and Hart recommend.
const RELAXATION: f64 = 1.46;

/// All roots along each ray in increasing order, as pieces no longer than the tolerance that hold
/// at least one change of sign or come within rounding of zero, and whether each list is proven
/// complete.
pub fn all_hits(
    field: &Field,
    rays: &[Ray],
    tolerance: f64,
    stats: &mut CastStats,
) -> Vec<(Vec<(f64, f64)>, bool)> {
    let mut group = Group::new(AffineMarch { tolerance, all: true }, field.tape().clone());
    let mut out = vec![(Vec::new(), true); rays.len()];
    group.march(rays, stats, |i, march, hit| out[i] = (march.roots, hit.certified));
    out
}
