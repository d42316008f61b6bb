//! Air around a planet: light that is held back, and light that is scattered once and more often.
//!
//! What there is at each height is the [`medium`]'s to know. Tables over the height and the direction,
//! made once per picture, answer for what is too far to look: how much air there is on the way out
//! ([`columns`], and from them the [`sunlight`] that arrives at a point), how much light arrives from all
//! around after several turns ([`multiple`], after Hillaire 2020), and how bright the whole sky is
//! ([`ambient`]). A line of sight is then cut into steps ([`line`], [`march`]; Nishita et al. 1993), each of
//! which asks for the light at one point.
//!
//! Sources: T. Nishita, T. Sirai, K. Tadamura and E. Nakamae, Display of the Earth taking into account
//! atmospheric scattering, 1993; E. Bruneton and F. Neyret, Precomputed atmospheric scattering, 2008;
//! S. Hillaire, A scalable and production ready sky and atmosphere rendering technique, 2020.

mod ambient;
mod columns;
mod dome;
mod exp;
mod grid;
mod line;
mod march;
mod medium;
mod multiple;
mod phase;
mod shell;
mod sunlight;

#[cfg(test)]
mod tests;

use super::recent::Recent;
use crate::scene::Air;
use ambient::Ambient;
use columns::Columns;
use dome::to_ground;
use glam::DVec3;
use line::{Count, Line};
use march::{Step, march, march_evenly};
use medium::Medium;
use phase::Phases;
use shell::SunTable;
use std::f64::consts::PI;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use sunlight::Sunlight;

/// Steps along a line of sight.
const SEEN: Count = Count { one_way: 16, each_half: 10 };

/// Steps along a ray that only looks for the light of the sky, each at two nodes.
const SKY: Count = Count { one_way: 14, each_half: 8 };

/// Air made ready for questions. Suns are pairs of the unit vector towards a sun and its irradiance above
/// the air. Clones share their tables.
#[derive(Clone, Debug)]
pub struct Atmosphere {
    medium: Medium,
    tables: Arc<Tables>,
}

#[derive(Debug)]
struct Tables {
    columns: Columns,
    /// Light of a sun of irradiance 1 that is scattered more than once, if it counts.
    multiple: Option<SunTable<DVec3>>,
    ambient: ambient::Table,
    /// Albedo of the ground.
    albedo: DVec3,
}

/// What air does to a line of sight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Share of the light from behind that gets through, by channel.
    pub transmittance: DVec3,
    /// Radiance that joins it.
    pub scattered: DVec3,
}

impl Atmosphere {
    /// The atmosphere of some air; `None` for air that takes no room, does nothing, or has coefficients
    /// and heights that make no sense, and where `cancel` was set in time.
    pub fn new(air: &Air, cancel: &AtomicBool) -> Option<Atmosphere> {
        /// Tables take longer than a first rough picture may.
        static KEPT: Recent<Air, Atmosphere> = Recent::new();
        let medium = Medium::new(air)?;
        KEPT.get_or(air, || Atmosphere::make(medium, air, cancel))
    }

    /// Makes the tables; `None` if that was cancelled.
    fn make(medium: Medium, air: &Air, cancel: &AtomicBool) -> Option<Atmosphere> {
        let columns = Columns::new(&medium, cancel)?;
        let sunlight = Sunlight { medium: &medium, columns: &columns };
        let albedo = air.ground.max(DVec3::ZERO).min(DVec3::ONE);
        let multiple = match air.multiple {
            true => Some(multiple::table(sunlight, albedo, cancel)?),
            false => None,
        };
        let ambient = ambient::Table::new(&medium);
        Some(Atmosphere { medium, tables: Arc::new(Tables { columns, multiple, ambient, albedo }) })
    }

    /// Radii of its ground, and of its top.
    pub fn reach(&self) -> [f64; 2] {
        [self.medium.shell.radius, self.medium.shell.top]
    }

    /// The points along a line of sight of length `distance` (infinite if nothing is in the way) at which
    /// [`Atmosphere::along`] asks for sunlight, from the eye outwards; none outside of the air. `jitter`
    /// in [0, 1) picks the point of each step. They are added to `out`.
    pub fn nodes(&self, eye: DVec3, direction: DVec3, distance: f64, jitter: f64, out: &mut Vec<DVec3>) {
        out.extend(self.steps(eye, direction, distance, SEEN, jitter).iter().map(|step| step.point));
    }

    /// What a line of sight goes through. `visible` is the share of each sun in turn that terrain leaves at
    /// each of [`Atmosphere::nodes`]; where it is empty all is lit that is not in the shadow of the
    /// planet's sphere. Other arguments as there.
    pub fn along(
        &self,
        eye: DVec3,
        direction: DVec3,
        distance: f64,
        suns: &[(DVec3, DVec3)],
        jitter: f64,
        visible: &[f64],
    ) -> Seen {
        let steps = self.steps(eye, direction, distance, SEEN, jitter);
        let transmittance = steps.last().map_or(DVec3::ONE, |step| step.through);
        Seen { transmittance, scattered: self.scattered(&steps, direction, suns, visible) }
    }

    /// Radiance of the sky from a point, and of the planet's sphere where the ray meets that. With few steps:
    /// for light that comes from all around.
    pub fn sky(&self, p: DVec3, direction: DVec3, suns: &[(DVec3, DVec3)]) -> DVec3 {
        let distance = to_ground(self.medium.shell.radius, p, direction);
        let line = Line::new(&self.medium, p, direction, distance);
        let steps = line.map_or(Vec::new(), |line| march_evenly(&self.medium, &line, SKY));
        let scattered = self.scattered(&steps, direction, suns, &[]);
        if distance == f64::INFINITY {
            return scattered;
        }
        let through = steps.last().map_or(DVec3::ONE, |step| step.through);
        scattered + through * self.ground((p + distance * direction).normalize_or(-direction), suns)
    }

    /// Radiance of level matt ground in the light of the suns and of their sky, where `up` is above.
    fn ground(&self, up: DVec3, suns: &[(DVec3, DVec3)]) -> DVec3 {
        let radius = self.medium.shell.radius;
        let light = |&(towards, irradiance): &(DVec3, DVec3)| {
            let mu = up.dot(towards).clamp(-1.0, 1.0);
            irradiance * (mu.max(0.0) / PI * self.rays().at(radius, mu) + self.mean_sky(radius, mu).above)
        };
        self.tables.albedo * suns.iter().map(light).sum::<DVec3>()
    }

    /// Share of sunlight that arrives at a point, by channel, with the unit vector towards the sun. The
    /// planet's sphere throws a shadow with an edge as wide as the sun's disc makes it; a point below the
    /// sphere stands on level ground.
    pub fn sunlight(&self, p: DVec3, towards: DVec3) -> DVec3 {
        self.rays().to(p, towards)
    }

    /// Mean radiance above and below a surface at `p` that faces the unit vector `up`, which should be about
    /// vertical: irradiance over pi, of light as of [`Atmosphere::sky`].
    pub fn ambient(&self, p: DVec3, up: DVec3, suns: &[(DVec3, DVec3)]) -> [DVec3; 2] {
        let (radius, r) = (self.medium.shell.radius, p.length());
        let air = suns.iter().fold(Ambient::NONE, |sum, &(towards, irradiance)| {
            sum + self.mean_sky(r, up.dot(towards).clamp(-1.0, 1.0)).times(irradiance)
        });
        // Far up the ground takes less than the half of all directions.
        let nearness = radius / r.max(radius);
        let below = self.ground(up, suns) * (nearness * nearness * self.rays().up_from_ground(r));
        [air.above, air.below + below]
    }

    /// The light of the sky at a radius, of a sun of irradiance 1 at the cosine `mu` to the vertical.
    fn mean_sky(&self, radius: f64, mu: f64) -> Ambient {
        self.tables.ambient.at(radius, mu, self.rays(), self.tables.multiple.as_ref())
    }

    fn rays(&self) -> Sunlight<'_> {
        Sunlight { medium: &self.medium, columns: &self.tables.columns }
    }

    /// The steps of a line of sight; none outside of the air.
    fn steps(&self, eye: DVec3, direction: DVec3, distance: f64, count: Count, jitter: f64) -> Vec<Step> {
        let line = Line::new(&self.medium, eye, direction, distance);
        line.map_or(Vec::new(), |line| march(&self.medium, &line, count, jitter))
    }

    /// Radiance that the steps of a line of sight add to it; `visible` as of [`Atmosphere::along`].
    fn scattered(&self, steps: &[Step], direction: DVec3, suns: &[(DVec3, DVec3)], visible: &[f64]) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for (i, &(towards, irradiance)) in suns.iter().enumerate() {
            let phases = Phases::new(&self.medium, direction.dot(towards));
            let shares = visible.get(i * steps.len()..).unwrap_or(&[]);
            let shares = shares.iter().copied().chain(std::iter::repeat(1.0));
            let light = |(step, share): (&Step, f64)| {
                let r = step.point.length().max(f64::MIN_POSITIVE);
                let mu = step.point.dot(towards) / r;
                let direct = if share > 0.0 { share * self.rays().at(r, mu) } else { DVec3::ZERO };
                let psi = self.tables.multiple.as_ref().map(|psi| psi.at(r, mu));
                phases.scattered(&step.yields, direct, psi.unwrap_or(DVec3::ZERO))
            };
            sum += irradiance * steps.iter().zip(shares).map(light).sum::<DVec3>();
        }
        sum
    }
}
