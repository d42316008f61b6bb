//! Light that falls on a solid: from suns and lamps straight, and from the sky.
//!
//! Each sample asks each light at one point of its disc; over many samples that makes soft shadows. Light of the sky
//! is found by rays that escape, where light bounces; else it is taken as if nothing stood in its way, which has a
//! closed form: of a sky with one radiance above and another below, a matt patch sees the share `(1 + n.up) / 2` of the
//! upper half.

use super::Atmosphere;
use super::surface::Patch;
use crate::scene::{Lamp, Light, Sky, Sun};
use glam::DVec3;
use std::f64::consts::PI;

/// A light as a point sees it, if nothing stands in its way: a disc, or a point without a size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Disc {
    /// Unit vector to its middle.
    middle: DVec3,
    /// `1 - edge`, with the cosine `edge` of the angle from its middle to its edge.
    height: f64,
    /// How far away it is.
    pub distance: f64,
    /// On a surface that faces it, as if all of the disc were in the direction that is asked about. (A disc is seen under angles up
    /// to that of its edge; with directions spread evenly over it, `2 / (1 + edge)` makes up for those that come in
    /// slantwise.)
    pub irradiance: DVec3,
}

impl Disc {
    /// That of a light, seen from `p`.
    pub fn of(light: &Light, p: DVec3, air: Option<&Atmosphere>) -> Disc {
        match light {
            Light::Sun(sun) => {
                Disc::of_sun(sun, air.map_or(DVec3::ONE, |air| air.sunlight(p, sun.direction)))
            }
            Light::Lamp(lamp) => Disc::of_lamp(lamp, p),
        }
    }

    /// That of a sun, of whose light such a share comes through the air.
    pub fn of_sun(sun: &Sun, through: DVec3) -> Disc {
        let height = 1.0 - libm::cos(0.5 * sun.size.to_radians());
        let irradiance = sun.irradiance * through * (2.0 / (2.0 - height));
        Disc { middle: sun.direction, height, distance: f64::INFINITY, irradiance }
    }

    /// That of a lamp: the directions in which the ball is seen.
    fn of_lamp(lamp: &Lamp, p: DVec3) -> Disc {
        let to = lamp.position - p;
        let squared = to.length_squared().max(f64::MIN_POSITIVE);
        let distance = squared.sqrt();
        let sine = (lamp.radius / distance).min(1.0);
        let edge = ((1.0 - sine) * (1.0 + sine)).sqrt();
        // 1 - cos, without cancellation for what is far away.
        let height = sine * sine / (1.0 + edge);
        let irradiance = lamp.intensity / squared * (2.0 / (1.0 + edge));
        Disc { middle: to / distance, height, distance: (distance - lamp.radius).max(0.0), irradiance }
    }

    /// The direction to one of its points, which `u` in the unit square picks.
    pub fn direction(&self, u: [f64; 2]) -> DVec3 {
        if self.height == 0.0 {
            return self.middle;
        }
        in_cone(self.middle, 1.0 - u[0] * self.height, u[1])
    }

    /// The density of these directions, in 1/sr; `None` of a point.
    pub fn density(&self) -> Option<f64> {
        (self.height > 0.0).then(|| 1.0 / (2.0 * PI * self.height))
    }

    /// Whether it is seen in a direction.
    pub fn holds(&self, direction: DVec3) -> bool {
        // 1 - cos, without cancellation.
        0.5 * direction.distance_squared(self.middle) < self.height
    }
}

/// Whether what stands in a light's way throws a shadow.
pub(super) fn has_shadows(light: &Light) -> bool {
    match light {
        Light::Sun(sun) => sun.shadows,
        Light::Lamp(lamp) => lamp.shadows,
    }
}

/// The direction at an angle, given by its cosine, from an axis, and so far around it (0 to 1).
fn in_cone(axis: DVec3, cosine: f64, around: f64) -> DVec3 {
    let sine = ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt();
    let turn = 2.0 * PI * around;
    let (a, b) = axis.any_orthonormal_pair();
    (cosine * axis + sine * (libm::cos(turn) * a + libm::sin(turn) * b)).normalize()
}

/// Radiance from beyond everything: that of the discs of suns.
pub(super) fn beyond(lights: &[Light], direction: DVec3) -> DVec3 {
    let disc = |light: &Light| match light {
        Light::Sun(sun) if sun.size > 0.0 => {
            let edge = libm::cos(0.5 * sun.size.to_radians());
            // The solid angle of the disc, seen slantwise at its rim as irradiance is.
            let angle = PI * (1.0 - edge) * (1.0 + edge);
            if direction.dot(sun.direction) >= edge { sun.irradiance / angle } else { DVec3::ZERO }
        }
        _ => DVec3::ZERO,
    };
    lights.iter().map(disc).sum()
}

/// Light from all around.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surroundings<'a> {
    /// What the script says of it.
    pub sky: &'a Sky,
    /// The air, if there is any.
    pub air: Option<&'a Atmosphere>,
    /// Directions and irradiances of suns, for the air.
    pub suns: &'a [(DVec3, DVec3)],
}

impl Surroundings<'_> {
    /// The direction that counts as above.
    pub fn up(&self, p: DVec3) -> DVec3 {
        self.sky.up.unwrap_or(p).normalize_or(DVec3::Y)
    }

    /// Radiance that reaches a point from a direction in which there is nothing but sky.
    pub fn radiance(&self, p: DVec3, direction: DVec3) -> DVec3 {
        match self.air {
            Some(air) => air.sky(p, direction, self.suns),
            None if direction.dot(self.up(p)) > 0.0 => self.sky.zenith,
            None => self.sky.nadir,
        }
    }

    /// The same, as a mirror of a roughness from 0 to 1 shows it. Where the sky is two halves, facets throw what comes from
    /// the height `a` beyond their edge if their slope in its direction is more than `m = tan(a / 2)`; of the facets of
    /// [`Gloss`](super::material::Gloss), the share `(1 + m / sqrt(m^2 + alpha^2)) / 2` is less than so steep.
    /// Of what they would throw below the horizon, the surface throws up what is below itself, all of it where it is level.
    ///
    /// What is rough mirrors from so far around that in the end it is `all_around`.
    pub fn blurred(&self, patch: &Patch, direction: DVec3, roughness: f64, all_around: DVec3) -> DVec3 {
        let Patch { position, normal, .. } = *patch;
        let alpha = roughness * roughness;
        if self.air.is_some() || alpha == 0.0 {
            return self.radiance(position, direction).lerp(all_around, roughness);
        }
        // The share that is thrown below a plane.
        let below = |plane: DVec3| {
            let sine = direction.dot(plane).clamp(-1.0, 1.0);
            // tan(a / 2) = sin a / (1 + cos a)
            let slope = sine / (1.0 + ((1.0 - sine) * (1.0 + sine)).sqrt());
            0.5 * (1.0 - slope / (slope * slope + alpha * alpha).sqrt())
        };
        let up = self.up(position);
        let nadir = (below(up) - up.dot(normal) * below(normal)).clamp(0.0, 1.0);
        self.sky.zenith.lerp(self.sky.nadir, nadir).lerp(all_around, alpha)
    }

    /// Radiance that reaches a point from straight above.
    pub fn overhead(&self, p: DVec3) -> DVec3 {
        self.radiance(p, self.up(p))
    }

    /// What the air does to light that comes along a piece of a line, given by its beginning, its direction and its length: the
    /// share that gets through, and what it adds. `sunny` says where along it the sun shines.
    pub fn along(&self, ray: (DVec3, DVec3, f64), jitter: f64, sunny: &[f64]) -> (DVec3, DVec3) {
        let Some(air) = self.air else { return (DVec3::ONE, DVec3::ZERO) };
        let seen = air.along(ray.0, ray.1, ray.2, self.suns, jitter, sunny);
        (seen.transmittance, seen.scattered)
    }

    /// Mean radiance over the hemisphere that a patch faces, weighted as a matt surface does. A bump sees what the surface
    /// below it does not hide, and what its surface [throws](super::reflect) to it; this is their sum where the surface is
    /// level or upright.
    pub fn ambient(&self, patch: &Patch) -> DVec3 {
        let up = self.up(patch.position);
        let Sky { zenith, nadir, .. } = *self.sky;
        let [above, below] =
            self.air.map_or([zenith, nadir], |air| air.ambient(patch.position, up, self.suns));
        let Patch { normal, shading, .. } = *patch;
        let along = shading - shading.dot(normal) * normal;
        below.lerp(above, (0.5 * (1.0 + up.dot(normal + along))).clamp(0.0, 1.0))
    }
}
