//! Light that is scattered more than once.
//!
//! After two encounters light has nearly forgotten where it came from. Hillaire (2020, section 5.5) takes
//! all scattering from the second on to be even in all directions, and the neighbourhood that scatters
//! light on and on to be as bright as the point itself. So the light `L2` that comes to a point to be
//! scattered for the second time is repeated by the share `f` of light that even surroundings send back:
//!
//! ```text
//! Psi = L2 (1 + f + f^2 + ...) = L2 / (1 - f)
//! L2  = mean over directions of  int T sigma T_sun / (4 pi) ds + T_ground albedo / pi T_sun mu_sun
//! f   = mean over directions of  int T sigma ds
//! ```
//!
//! for sunlight of irradiance 1: a function of the height and of the sun's height alone.

use super::dome::{Ray, rays, suns};
use super::line::Count;
use super::shell::SunTable;
use super::sunlight::Sunlight;
use glam::DVec3;
use std::f64::consts::PI;
use std::sync::atomic::AtomicBool;

/// Heights of the sun, and of places.
const SIZE: [usize; 2] = [32, 32];

/// Rays above and below the horizon.
const RAYS: [usize; 2] = [14, 6];

/// Steps along a ray, each at two nodes.
const STEPS: Count = Count { one_way: 16, each_half: 12 };

/// Sides on which the sun is, half of the way round.
const SIDES: usize = 4;

/// The table of `Psi` above ground of an albedo; `None` if that was cancelled.
pub(super) fn table(sunlight: Sunlight<'_>, albedo: DVec3, cancel: &AtomicBool) -> Option<SunTable<DVec3>> {
    SunTable::new(sunlight.medium, SIZE, cancel, |r| {
        let rays = rays(sunlight.medium, r, RAYS, STEPS);
        let sent_back: DVec3 = rays.iter().map(sent_back).sum();
        move |mu| {
            let second = |(sun, weight)| {
                let light = rays.iter().map(|ray| second(ray, sunlight, albedo, sun));
                light.sum::<DVec3>() * weight
            };
            suns(mu, SIDES).map(second).sum::<DVec3>() / (1.0 - sent_back)
        }
    })
}

/// A ray's part of `f`.
fn sent_back(ray: &Ray) -> DVec3 {
    ray.share * ray.steps.iter().map(|step| even(&step.yields)).sum::<DVec3>()
}

/// A ray's part of `L2`.
fn second(ray: &Ray, sunlight: Sunlight<'_>, albedo: DVec3, sun: DVec3) -> DVec3 {
    let once: DVec3 = ray.steps.iter().map(|step| even(&step.yields) * sunlight.to(step.point, sun)).sum();
    let ground = ray.ground.map_or(DVec3::ZERO, |(point, through)| {
        through * albedo * sunlight.to(point, sun) * point.normalize().dot(sun).max(0.0)
    });
    ray.share * (once / (4.0 * PI) + ground / PI)
}

/// What matter of all kinds scatters, whatever the angle.
fn even(yields: &[DVec3; 3]) -> DVec3 {
    yields[0] + yields[1] + yields[2]
}
