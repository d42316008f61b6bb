//! Light that a solid reflects: the sun, with the shadows that rays have found, and the sky.

use super::air::Atmosphere;
use super::surface::Patch;
use crate::scene::{Sky, Sun};
use glam::DVec3;
use std::f64::consts::PI;

/// Radiance that leaves a patch of a matt (Lambertian) solid, if the sun shines on it or not.
///
/// Under air, sunlight arrives filtered, and the light of the sky is as strong as the daylight.
pub(super) fn reflected(patch: &Patch, sun: &Sun, lit: bool, sky: &Sky, air: Option<&Atmosphere>) -> DVec3 {
    let mut light = ambient(patch, sky);
    if let Some(air) = air {
        light *= air.daylight(patch.position, sun.direction);
    }
    if lit {
        let facing = patch.normal.dot(sun.direction).max(0.0);
        let arriving = air.map_or(DVec3::ONE, |air| air.sunlight(patch.position, sun.direction));
        light += sun.irradiance * arriving * (facing / PI);
    }
    patch.albedo * light
}

/// Mean radiance of the sky over the hemisphere that a patch faces, weighted as a matt surface
/// does. For a sky that changes linearly from nadir to zenith, that is linear in the slope, too.
fn ambient(patch: &Patch, sky: &Sky) -> DVec3 {
    let up = sky.up.unwrap_or(patch.position).normalize_or(DVec3::Y);
    let above = 0.5 * (1.0 + patch.normal.dot(up));
    sky.nadir.lerp(sky.zenith, above)
}

/// Whether a patch can see the sun at all, were it not for shadows.
pub(super) fn faces(patch: &Patch, sun: &Sun) -> bool {
    patch.normal.dot(sun.direction) > 0.0
}
