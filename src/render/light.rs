//! Light that a solid reflects: the sun, with the shadows that rays have found, and the sky.

use super::Atmosphere;
use super::surface::Patch;
use crate::scene::{Sky, Sun};
use glam::DVec3;
use std::f64::consts::PI;

/// Radiance that leaves a patch of a matt (Lambertian) solid, if the sun shines on it or not.
///
/// Under air, sunlight arrives filtered, and the light of the sky is that of the air.
pub(super) fn reflected(patch: &Patch, sun: &Sun, lit: bool, sky: &Sky, air: Option<&Atmosphere>) -> DVec3 {
    let up = sky.up.unwrap_or(patch.position).normalize_or(DVec3::Y);
    let suns = [(sun.direction, sun.irradiance)];
    let [zenith, nadir] = air.map_or([sky.zenith, sky.nadir], |air| air.ambient(patch.position, up, &suns));
    // Mean radiance over the hemisphere that the patch faces, weighted as a matt surface does: for a sky
    // that changes linearly from nadir to zenith, it is linear in the slope, too.
    let mut light = nadir.lerp(zenith, 0.5 * (1.0 + patch.normal.dot(up)));
    if lit {
        let facing = patch.normal.dot(sun.direction).max(0.0);
        let arriving = air.map_or(DVec3::ONE, |air| air.sunlight(patch.position, sun.direction));
        light += sun.irradiance * arriving * (facing / PI);
    }
    patch.albedo * light
}

/// Whether a patch can see the sun at all, were it not for shadows.
pub(super) fn faces(patch: &Patch, sun: &Sun) -> bool {
    patch.normal.dot(sun.direction) > 0.0
}
