//! Lambert's law: a matt surface looks equally bright from everywhere.
//!
//! `f = albedo / pi`, since the cosine has the integral `pi` over the hemisphere.

use super::{Bounce, Frame, Reflectance, cosine_hemisphere, cosines};
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// A matt surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambert {
    /// Share of light that is reflected, from 0 to 1 by channel.
    pub albedo: DVec3,
}

impl Reflectance for Lambert {
    fn value(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> DVec3 {
        cosines(normal, to_eye, to_light).map_or(DVec3::ZERO, |_| self.albedo * FRAC_1_PI)
    }

    fn sample(&self, u: [f64; 2], normal: DVec3, to_eye: DVec3) -> Option<Bounce> {
        let direction = Frame::around(normal).to_world(cosine_hemisphere(u));
        cosines(normal, to_eye, direction).map(|_| Bounce { direction, weight: self.albedo, is_spread: true })
    }

    fn pdf(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> f64 {
        cosines(normal, to_eye, to_light).map_or(0.0, |[_, cos]| cos * FRAC_1_PI)
    }
}
