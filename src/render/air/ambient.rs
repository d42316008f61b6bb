//! The light of the sky on a surface, for whatever does not look into all directions itself.

use super::dome::{Ray, rays, suns};
use super::march::Step;
use super::phase::Phases;
use super::shell::SunTable;
use super::sunlight::Sunlight;
use glam::DVec3;
use std::ops::{Add, Mul};
use std::sync::atomic::AtomicBool;

/// Heights of the sun, and levels.
const SIZE: [usize; 2] = [32, 12];

/// Rays above and below the horizon.
const RAYS: [usize; 2] = [10, 6];

/// Sides on which the sun is, half of the way round: many, for haze is bright about the sun.
const SIDES: usize = 8;

/// Mean radiance from above and from below a level surface, weighted by the cosine to the vertical:
/// irradiance over pi.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ambient {
    pub above: DVec3,
    pub below: DVec3,
}

impl Ambient {
    pub const NONE: Ambient = Ambient { above: DVec3::ZERO, below: DVec3::ZERO };
}

impl Add for Ambient {
    type Output = Ambient;

    fn add(self, other: Ambient) -> Ambient {
        Ambient { above: self.above + other.above, below: self.below + other.below }
    }
}

impl Mul<f64> for Ambient {
    type Output = Ambient;

    fn mul(self, by: f64) -> Ambient {
        Ambient { above: self.above * by, below: self.below * by }
    }
}

/// The table for a sun of irradiance 1, with the light that is scattered more than once; `None` if that was cancelled.
pub(super) fn table(
    sunlight: Sunlight<'_>,
    multiple: Option<&SunTable<DVec3>>,
    cancel: &AtomicBool,
) -> Option<SunTable<Ambient>> {
    SunTable::new(sunlight.medium.shell, SIZE, cancel, |r| {
        let rays = rays(sunlight.medium, r, RAYS);
        move |mu| {
            let from = |ray: &Ray| {
                let side = |sun| radiance(ray, sunlight, multiple, sun);
                let mean = suns(mu, SIDES).map(side).sum::<DVec3>() / SIDES as f64;
                // int L cos dOmega / pi, with dOmega = 4 pi share.
                let light = mean * (4.0 * ray.share * ray.direction.y.abs());
                if ray.direction.y > 0.0 {
                    Ambient { above: light, ..Ambient::NONE }
                } else {
                    Ambient { below: light, ..Ambient::NONE }
                }
            };
            rays.iter().map(from).fold(Ambient::NONE, Ambient::add)
        }
    })
}

/// Radiance of the air along a ray.
fn radiance(ray: &Ray, sunlight: Sunlight<'_>, multiple: Option<&SunTable<DVec3>>, sun: DVec3) -> DVec3 {
    let phases = Phases::new(sunlight.medium, ray.direction.dot(sun));
    let light = |step: &Step| {
        let direct = sunlight.to(step.point, sun);
        phases.scattered(&step.yields, direct, multiple.map_or(DVec3::ZERO, |psi| psi.to(step.point, sun)))
    };
    ray.steps.iter().map(light).sum()
}
