//! Gloss, and evenly spread what it does not mirror at once, so that no light is lost on the way.
//!
//! What facets do not mirror at once, the share `1 - E(v)`, may leave the surface yet, in any direction: of a film
//! after a while in the matt ground below, of metal after further facets. Where it leaves as evenly as it came in,
//!
//! ```text
//! f = f_gloss + (1 - E(v)) (1 - E(l)) / (1 - <E>)  rest / pi            <E> = 2 int E(mu) mu dmu
//! ```
//!
//! is the same with both directions exchanged, and the integral of the second term is `rest (1 - E(v))`: what
//! is not mirrored at once, times the share of it that gets out at last. Samples of it have the density
//! `(1 - E(l)) cos / (pi (1 - <E>))`: where hardly anything is left, it is at grazing angles. (The form with
//! tabulated albedos is that of Kelemen and Szirmay-Kalos 2001, *A microfacet based coupled specular-matte BRDF
//! model*.)

use super::frame::around_z;
use super::mirrored::Share;
use super::{Bounce, Frame, Gloss, Reflectance, bounce, choose, cosines};
use glam::DVec3;

/// Gloss, and what it leaves.
#[derive(Clone, Copy, Debug)]
pub struct Balanced<'a> {
    pub(super) gloss: Gloss,
    /// `E`.
    pub(super) mirrored: Share<'a>,
    /// The share of what is not mirrored at once that leaves later, by channel.
    pub(super) rest: DVec3,
}

impl Balanced<'_> {
    /// The share of light that leaves late, for a view at a cosine and light from all around, by channel.
    pub fn late(&self, cos: f64) -> DVec3 {
        self.rest * (1.0 - self.mirrored.at(cos))
    }

    /// The share of it that is mirrored at once, but for the [colour](super::Metals::at_once) of a metal.
    pub fn at_once(&self, cos: f64) -> f64 {
        self.mirrored.at(cos)
    }

    /// Probability of a sample of the gloss.
    fn gloss_share(&self, cos: f64) -> f64 {
        let gloss = self.at_once(cos);
        gloss / (gloss + self.late(cos).max_element()).max(f64::MIN_POSITIVE)
    }
}

impl Reflectance for Balanced<'_> {
    fn value(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> DVec3 {
        let Some([eye, light]) = cosines(normal, to_eye, to_light) else { return DVec3::ZERO };
        let late = self.late(eye) * (self.mirrored.density(light) / light);
        self.gloss.value(normal, to_eye, to_light) + late
    }

    fn gloss(&self) -> Option<Gloss> {
        Some(self.gloss)
    }

    fn sample(&self, u: [f64; 2], normal: DVec3, to_eye: DVec3) -> Option<Bounce> {
        let (gloss, u) = choose(u, self.gloss_share(normal.dot(to_eye).clamp(0.0, 1.0)));
        let direction = match gloss {
            true => self.gloss.sample(u, normal, to_eye)?.direction,
            false => Frame::around(normal).to_world(around_z(self.mirrored.sample(u[0]), u[1])),
        };
        Some(Bounce { is_spread: !gloss, ..bounce(self, normal, to_eye, direction)? })
    }

    fn pdf(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> f64 {
        let Some([eye, light]) = cosines(normal, to_eye, to_light) else { return 0.0 };
        let share = self.gloss_share(eye);
        share * self.gloss.pdf(normal, to_eye, to_light) + (1.0 - share) * self.mirrored.density(light)
    }
}
