//! The air around a planet.

use glam::DVec3;

/// Air in spherical shells around the origin, as plain data.
///
/// Three kinds of matter scatter light or hold it back. *Gas*, whose molecules are much smaller than
/// a wavelength, scatters blue more than red and backward as much as forward (Rayleigh). Grains and
/// droplets ([`Haze`], of which there may be a second, low layer, the fog) scatter mostly forward
/// (Mie). An [`Absorber`] such as ozone only takes light away. Coefficients are shares of light lost
/// per unit of length, in red, green and blue; heights are measured from `radius`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Air {
    /// Radius of the ground, at which `scattering` holds.
    pub radius: f64,
    /// Height over which the gas thins by a factor e.
    pub height: f64,
    /// Scattering coefficient of the gas at `radius`.
    pub scattering: DVec3,
    /// Grains that float in the air.
    pub haze: Option<Haze>,
    /// A second layer of them.
    pub fog: Option<Haze>,
    /// What takes light away and scatters none.
    pub absorber: Option<Absorber>,
    /// Albedo of the ground at `radius`, which lights surfaces from below, and the air where `multiple` is set.
    pub ground: DVec3,
    /// Whether light counts that is scattered more than once.
    pub multiple: bool,
    /// Whether the solid throws shadows into the air, which makes shafts of light.
    pub shafts: bool,
}

impl Air {
    /// Nothing but gas, which scatters light once: radius, height and scattering coefficient as of
    /// the fields of these names.
    pub fn clear(radius: f64, height: f64, scattering: DVec3) -> Self {
        let ground = DVec3::splat(0.2);
        Air {
            radius,
            height,
            scattering,
            haze: None,
            fog: None,
            absorber: None,
            ground,
            multiple: false,
            shafts: false,
        }
    }
}

/// A layer of grains or droplets, which thins with height, and is even below the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Haze {
    /// Scattering coefficient at the ground.
    pub scattering: DVec3,
    /// Absorption coefficient there.
    pub absorption: DVec3,
    /// Height over which the layer thins by a factor e.
    pub height: f64,
    /// Mean cosine of the angle by which light is turned, by channel: 0 for all directions alike, up
    /// to 1 for straight on. Within (-1, 1).
    pub asymmetry: DVec3,
}

/// A layer that absorbs, most at its middle and linearly less to either side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Absorber {
    /// Absorption coefficient in the middle.
    pub absorption: DVec3,
    /// Height of the middle.
    pub center: f64,
    /// Distance from the middle to where there is none.
    pub width: f64,
}
