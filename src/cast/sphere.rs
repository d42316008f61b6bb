//! Sphere tracing, plain and speculative (thesis, 5.2; Hart; Worley and Hart).
//!
//! Where `f > 0` and `f` has the Lipschitz bound `L`, the ball of radius `f / L` is empty. Plain
//! tracing steps from ball to ball. Speculative tracing steps further, by the factor 1.46, and
//! keeps the step if the balls at its two ends cover it, else steps back to the plain one.
//!
//! Both classical forms stop when the step gets short, which reports grazing rays as hits. Here a
//! ray whose ball is shorter than the tolerance *creeps*: it looks one tolerance ahead. A change of
//! sign there is a hit known to within the tolerance; if the two balls cover the piece it is passed
//! for certain; else the plain step is taken. A ray that creeps too long grazes the surface, where
//! balls are a poor tool: it is handed over to affine arithmetic (`handover.rs`), from the frontier on.

use super::group::{LANES, Strategy};
use super::handover::undecided;
use super::{CastStats, Hit, Ray};
use crate::num::Many;

/// Creeping steps after which a ray is handed over.
const CREEP: u32 = 16;
/// Steps after which any ray is handed over.
const STEPS: u32 = 4096;

/// Sphere tracing with a given over-relaxation; 1 is the plain form.
#[derive(Clone, Copy, Debug)]
pub(super) struct SphereTracing {
    /// Certified Lipschitz bound of the field outside the solid, within the region of the rays.
    pub lipschitz: f64,
    /// Factor on the length of a step.
    pub relaxation: f64,
    /// Whether any place inside will do.
    pub any: bool,
}

/// Progress of one ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct March {
    /// Everything before is free.
    t: f64,
    /// Radius of the empty ball at `t`.
    radius: f64,
    /// Where the field is asked for.
    probe: f64,
    crept: u32,
    steps: u32,
}

impl SphereTracing {
    /// Moves the frontier to `t`, where the ball has this radius, and chooses the next probe.
    fn advance(&self, ray: &Ray, march: &mut March, t: f64, radius: f64) -> Option<Hit> {
        (march.t, march.radius) = (t, radius);
        if t + radius > ray.far {
            return Some(Hit::MISS);
        }
        let tolerance = ray.tolerance.at(t);
        let ahead = if radius < tolerance {
            march.crept += 1;
            tolerance
        } else {
            self.relaxation * radius
        };
        march.probe = (t + ahead).min(ray.far);
        // Grazing, or a ball too small to move a frontier this far out.
        (march.crept > CREEP || march.probe <= t).then_some(undecided(t))
    }
}

impl Strategy for SphereTracing {
    type Batch = Many<f64, LANES>;
    type March = March;

    fn any(&self) -> Self {
        SphereTracing { any: true, ..*self }
    }

    fn lipschitz(&self) -> Option<f64> {
        Some(self.lipschitz)
    }

    fn start(&self, ray: &Ray) -> March {
        March { t: ray.near, radius: 0.0, probe: ray.near, crept: 0, steps: 0 }
    }

    fn ask(&self, ray: &Ray, march: &March) -> [f64; 3] {
        ray.at(march.probe).to_array()
    }

    fn tell(&self, ray: &Ray, march: &mut March, f: &f64, stats: &mut CastStats) -> Option<Hit> {
        stats.steps += 1;
        march.steps += 1;
        if f.is_nan() || march.steps > STEPS {
            return Some(undecided(march.t));
        }
        if self.any && *f < 0.0 {
            return Some(Hit { t: march.t, certified: true });
        }
        // A hair less than f / L, for the rounding of the field, of this division, and of the point. Where that leaves
        // nothing, the place is not inside for that: the bound may be enormous.
        let radius = f / self.lipschitz * (1.0 - 1e-12) - 2.0 * ray.rounding(march.probe);
        let radius = radius.max(0.0);
        let step = march.probe - march.t;
        if *f <= 0.0 && step <= ray.tolerance.at(march.t) * (1.0 + 1e-9) {
            return Some(Hit { t: march.t, certified: true });
        }
        if step == 0.0 || step <= march.radius + radius && radius > 0.0 {
            return self.advance(ray, march, march.probe, radius);
        }
        stats.backtracks += 1;
        // The plain step ends where the ball does; its field value is asked for next.
        let plain = march.t + march.radius;
        if plain <= march.t {
            return Some(undecided(march.t));
        }
        march.t = plain;
        march.probe = plain;
        march.radius = 0.0;
        None
    }
}
