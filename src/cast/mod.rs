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
use crate::scene::Aabb;
use affine::AffineMarch;
use glam::DVec3;
use group::Group;
use sphere::SphereTracing;

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

/// Largest Lipschitz bound at which spheres are the better choice for a field without noise: a
/// distance field that smooth blends and stretching have steepened a little.
const NEARLY_A_DISTANCE: f64 = 2.0;

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
    let spheres = |field: &mut Field, relaxation: f64| {
        let lipschitz = lipschitz_outside(field, region);
        (lipschitz.is_finite() && lipschitz > 0.0).then_some(SphereTracing {
            lipschitz,
            relaxation,
            tolerance,
        })
    };
    let affine = AffineMarch { tolerance, all: false };
    let tape = field.tape().clone();
    let chosen = match kind {
        Kind::Affine => None,
        Kind::Auto if tape.noises() > 0 => None,
        Kind::Auto => spheres(field, RELAXATION).filter(|s| s.lipschitz <= NEARLY_A_DISTANCE),
        Kind::Sphere => Some(spheres(field, 1.0).ok_or(CastError::NoLipschitzBound)?),
        Kind::Speculative => Some(spheres(field, RELAXATION).ok_or(CastError::NoLipschitzBound)?),
    };
    Ok(match chosen {
        Some(spheres) => Box::new(Group::new(spheres, tape)),
        None => Box::new(Group::new(affine, tape)),
    })
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
