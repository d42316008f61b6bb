//! Ray casting: where a ray first meets a surface.
//!
//! A caster takes rays in groups, because the work of a group is batched: one instruction of the
//! tape serves many rays. Rays never influence one another, so any grouping gives the same hits.

use glam::DVec3;

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
