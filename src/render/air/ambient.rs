//! The light of the sky on a surface, for whatever does not look into all directions itself.

use super::dome::{Ray, rays, suns};
use super::line::Count;
use super::march::{Step, mean_through};
use super::medium::Medium;
use super::phase::Phases;
use super::shell::{Light, SunRows, SunTable};
use super::sunlight::{SLANT, Sunlight, through};
use glam::DVec3;
use std::ops::{Add, Mul};

/// Heights of the sun, and of places.
const SIZE: [usize; 2] = [34, 32];

/// Rays above and below the horizon.
const RAYS: [usize; 2] = [18, 6];

/// Steps along a ray, each at two nodes.
const STEPS: Count = Count { one_way: 12, each_half: 8 };

/// Levels nearer than this to the ground and the top are taken for it.
const NEAR: f64 = 1e-3;

/// Sides on which the sun is, half of the way round.
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

    /// The same of suns of an irradiance.
    pub fn times(self, irradiance: DVec3) -> Ambient {
        Ambient { above: irradiance * self.above, below: irradiance * self.below }
    }

    fn zip(self, other: Ambient, f: impl Fn(DVec3, DVec3) -> DVec3) -> Ambient {
        Ambient { above: f(self.above, other.above), below: f(self.below, other.below) }
    }
}

impl Add for Ambient {
    type Output = Ambient;

    fn add(self, other: Ambient) -> Ambient {
        self.zip(other, DVec3::add)
    }
}

impl Mul<f64> for Ambient {
    type Output = Ambient;

    fn mul(self, by: f64) -> Ambient {
        self.map(|light| light * by)
    }
}

impl Light for Ambient {
    fn map(self, f: impl Fn(DVec3) -> DVec3) -> Ambient {
        Ambient { above: f(self.above), below: f(self.below) }
    }
}

/// The light of the sky at all heights for suns at all heights. Few heights are asked for as a rule, and all of them took half of
/// the time of a first picture of the shore, so they are made as they are.
#[derive(Debug)]
pub(super) struct Table {
    /// Shares of what [`scale`] says, which hardly depend on the height.
    shares: SunRows<Ambient>,
}

impl Table {
    /// The table for the air of a medium.
    pub fn new(medium: &Medium) -> Table {
        Table { shares: SunRows::new(medium, SIZE) }
    }

    /// The light at a radius, of a sun of irradiance 1 at the cosine `mu` to the vertical, in that air and with the light that
    /// is scattered more than once.
    pub fn at(&self, r: f64, mu: f64, sunlight: Sunlight<'_>, multiple: Option<&SunTable<DVec3>>) -> Ambient {
        self.shares.at(r, mu, |r| shares(r, sunlight, multiple)).zip(scale(sunlight.medium, r), DVec3::mul)
    }
}

/// The shares at a radius, for cosines of the sun.
fn shares(r: f64, sunlight: Sunlight<'_>, multiple: Option<&SunTable<DVec3>>) -> impl Fn(f64) -> Ambient {
    // Where there is nothing above, or below, the share of nothing is what it tends to.
    let shell = sunlight.medium.shell;
    let r = r.clamp(shell.radius_at(NEAR), shell.radius_at(1.0 - NEAR));
    let rays = rays(sunlight.medium, r, RAYS, STEPS);
    let scale = scale(sunlight.medium, r);
    move |mu| {
        let from = |ray: &Ray| {
            let side = |(sun, weight)| radiance(ray, sunlight, multiple, sun) * weight;
            let mean = suns(mu, SIDES).map(side).sum::<DVec3>();
            // int L cos dOmega / pi, with dOmega = 4 pi share.
            let light = mean * (4.0 * ray.share * ray.direction.y.abs());
            if ray.direction.y > 0.0 {
                Ambient { above: light, ..Ambient::NONE }
            } else {
                Ambient { below: light, ..Ambient::NONE }
            }
        };
        let all = rays.iter().map(from).fold(Ambient::NONE, Ambient::add);
        all.zip(scale, |light, most| light / most.max(DVec3::splat(f64::MIN_POSITIVE)))
    }
}

/// Light from above and from below of air that shines evenly, `1 - e^-t`: near the ground there is next to nothing below, and
/// high up next to nothing above, but as little as the light itself is, without cancellation.
fn scale(medium: &Medium, r: f64) -> Ambient {
    let [above, below] = medium.scatterers(r).map(|depth| {
        let t = SLANT * depth;
        t * mean_through(t, through(t))
    });
    Ambient { above, below }
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
