//! Sunlight on its way to a point in the air.

use super::columns::Columns;
use super::exp::exp;
use super::medium::Medium;
use glam::{DVec3, DVec4};

/// Angular radius of the sun as seen from the Earth.
const SUN_RADIUS: f64 = 0.004_67;

/// Mean length of the ways through a layer of light from all around, in its thickness (Elsasser 1942).
pub(super) const SLANT: f64 = 1.66;

/// What tells how much sunlight gets to a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sunlight<'a> {
    pub medium: &'a Medium,
    pub columns: &'a Columns,
}

impl Sunlight<'_> {
    /// Share of sunlight that arrives, by channel, at a point, with the direction towards the sun.
    pub fn to(&self, p: DVec3, sun: DVec3) -> DVec3 {
        let r = p.length();
        if r > 0.0 { self.at(r, (p.dot(sun) / r).clamp(-1.0, 1.0)) } else { DVec3::ZERO }
    }

    /// Share of sunlight that arrives, by channel, at the radius `r`, where the sun is at the cosine `mu`
    /// to the vertical. Where the planet covers the sun there is none; the edge of its shadow is as wide
    /// as the sun's disc makes it.
    pub fn at(&self, r: f64, mu: f64) -> DVec3 {
        let visible = self.visible(r, mu);
        if visible == 0.0 {
            return DVec3::ZERO;
        }
        visible * through(self.medium.depth(self.amount(r, mu)))
    }

    /// Share of light, by channel, that gets from ground which shines evenly up to the radius `r`.
    pub fn up_from_ground(&self, r: f64) -> DVec3 {
        let [all, above] = [0.0, r].map(|r| self.rising(r.max(self.medium.shell.radius), 1.0));
        through(SLANT * self.medium.depth((all - above).max(DVec4::ZERO)))
    }

    /// Amount of matter on the way. A ray of a sun that sets grazes the ground, and goes no deeper.
    fn amount(&self, r: f64, mu: f64) -> DVec4 {
        let medium = self.medium;
        if mu >= 0.0 {
            return self.rising(r, mu);
        }
        let b = (r * ((1.0 - mu) * (1.0 + mu)).sqrt()).max(medium.shell.radius.min(r));
        if b >= medium.shell.top {
            return DVec4::ZERO;
        }
        (2.0 * self.rising(b, 0.0) - self.rising(r, -mu)).max(DVec4::ZERO)
    }

    /// The same for a ray that rises; what is below the ground goes up to it first.
    fn rising(&self, r: f64, mu: f64) -> DVec4 {
        let Sunlight { medium, columns } = self;
        let ground = medium.shell.radius;
        if r >= ground {
            return columns.rising(r, medium.density(r), mu);
        }
        let (b, from) = (r * ((1.0 - mu) * (1.0 + mu)).sqrt(), r * mu);
        let to = ((ground - b) * (ground + b)).sqrt();
        medium.amount(b, [from, to]) + columns.rising(ground, medium.density(ground), to / ground)
    }

    /// Share of the sun's disc above the horizon of the sphere, or of level ground for a point below
    /// that: about `3 x^2 - 2 x^3` of the share `x` of its diameter.
    fn visible(&self, r: f64, mu: f64) -> f64 {
        // Sine and cosine of the angle between the vertical and the horizon.
        let sine = (self.medium.shell.radius / r).min(1.0);
        let cosine = -((1.0 - sine) * (1.0 + sine)).sqrt();
        let x = (0.5 + 0.5 * (mu - cosine) / (SUN_RADIUS * sine)).clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    }
}

/// Share of light that an optical depth lets through, by channel.
pub(super) fn through(depth: DVec3) -> DVec3 {
    DVec3::from_array(exp((-depth).to_array()))
}
