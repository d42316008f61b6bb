//! How surfaces reflect light: one model a file.
//!
//! A model is a *bidirectional reflectance distribution function* `f`: light that arrives from `l` with
//! radiance `L` adds `f(v, l) L cos` to what leaves towards the eye `v`, for each unit of solid angle. It
//! has three laws, and tests hold every model to them:
//!
//! - it is not negative, and the same with the directions exchanged (Helmholtz' reciprocity);
//! - no more light leaves than arrives: the *directional albedo* `int f(v, l) cos dl` is at most 1;
//! - light can be chosen in proportion to something like `f cos`, with a known density, so that means of
//!   weighted samples are unbiased.
//!
//! | model | for |
//! |---|---|
//! | [`Lambert`] | what is matt |
//! | [`OrenNayar`] | what is matt and rough: dry rock, sand, snow |
//! | [`Dust`] | loose grains that shade one another: regolith, ash |
//! | [`Gloss`] | facets that mirror, each for itself: rough water |
//! | [`Balanced`] | the same, and all that leaves later: [`Metals`]; a rough clear [`Film`] on something matt, as wet rock |
//! | [`Water`] | a smooth surface with depth below it, which is no distribution but two directions |
//!
//! All directions are of length 1 and point away from the surface; the normal is that of the side that
//! the eye sees. Colours are shares of red, green and blue.

mod balanced;
mod coat;
mod dust;
mod frame;
mod fresnel;
mod gloss;
mod lambert;
mod metal;
mod mirrored;
mod oren_nayar;
mod phase;
mod water;

#[cfg(test)]
mod tests;

pub use balanced::Balanced;
pub use coat::Film;
pub use dust::{AllAround, Dust, Surge};
pub use frame::{Frame, cosine_hemisphere, uniform_hemisphere};
pub use fresnel::{Fresnel, dielectric, dielectric_mean, refract, schlick};
pub use gloss::Gloss;
pub use lambert::Lambert;
pub use metal::Metals;
pub use oren_nayar::OrenNayar;
pub use phase::Phase;
pub use water::{Split, Water};

use glam::DVec3;

/// A direction that light is looked for in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounce {
    /// Where the light comes from, away from the surface.
    pub direction: DVec3,
    /// What its radiance counts: `f cos` over the density of the direction.
    pub weight: DVec3,
    /// Whether it was chosen among all directions, as what is matt does, not about a mirrored one.
    pub is_spread: bool,
}

/// What reflects light in all directions.
pub trait Reflectance {
    /// The reflectance `f` for each channel, in 1/sr; zero where a direction is below the surface.
    fn value(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> DVec3;

    /// A direction for `u`, uniform in [0, 1)^2. `None` is a sample, too, of a weight of zero: it counts
    /// where a mean is taken.
    fn sample(&self, u: [f64; 2], normal: DVec3, to_eye: DVec3) -> Option<Bounce>;

    /// The part of it that mirrors, if it has one.
    fn gloss(&self) -> Option<Gloss> {
        None
    }

    /// The density with which [`Reflectance::sample`] gives a direction, in 1/sr. Its integral over the
    /// hemisphere is the share of samples that are not `None`.
    fn pdf(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> f64;
}

/// The cosines to the normal of both directions, if both are above the surface.
fn cosines(normal: DVec3, to_eye: DVec3, to_light: DVec3) -> Option<[f64; 2]> {
    let cosines = [normal.dot(to_eye), normal.dot(to_light)];
    cosines.iter().all(|cos| *cos > 0.0).then(|| cosines.map(|cos| cos.min(1.0)))
}

/// The bounce to a direction, with the weight that value and density give it. For models whose weight
/// has no simpler form.
fn bounce(model: &impl Reflectance, normal: DVec3, to_eye: DVec3, direction: DVec3) -> Option<Bounce> {
    let [_, cos] = cosines(normal, to_eye, direction)?;
    let pdf = model.pdf(normal, to_eye, direction);
    (pdf > 0.0).then(|| {
        let weight = model.value(normal, to_eye, direction) * (cos / pdf);
        Bounce { direction, weight, is_spread: true }
    })
}

/// Chooses between two ways to sample, the first with a probability: which, and `u` spread anew over
/// [0, 1)^2 for it.
fn choose(u: [f64; 2], probability: f64) -> (bool, [f64; 2]) {
    // Rounding may carry a quotient to 1.
    let spread = |x: f64| x.min(1.0 - f64::EPSILON);
    match u[0] < probability {
        true => (true, [spread(u[0] / probability), u[1]]),
        false => (false, [spread((u[0] - probability) / (1.0 - probability)), u[1]]),
    }
}
