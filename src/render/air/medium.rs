//! What the air is made of at each height.
//!
//! Four kinds of matter, three of them in layers that thin exponentially: `exp(-h / H)`. Wherever
//! amounts are counted by kind, they stand in the order gas, haze, fog, absorber.

use super::exp::exp;
use super::shell::Shell;
use crate::scene::{Air, Haze};
use glam::{DVec3, DVec4};

/// Heights `H` up to the top of a layer, where its density is e^-12: what lies above could not be seen.
pub(super) const TOP: f64 = 12.0;

/// How deep in the ground, in heights `H`, gas stops growing denser: nobody looks, but nothing must
/// overflow.
const DEPTH: f64 = 4.0;

/// Three layers that thin with height, side by side.
#[derive(Clone, Copy, Debug)]
struct Layers {
    /// 1 for a layer that is there.
    there: [f64; 3],
    /// How fast the logarithm of the density falls: one over the height of a factor e.
    fall: [f64; 3],
    /// Logarithm of the greatest density.
    most: [f64; 3],
}

impl Layers {
    const NONE: Layers = Layers { there: [0.0; 3], fall: [0.0; 3], most: [0.0; 3] };

    fn density(&self, h: f64) -> [f64; 3] {
        let power: [f64; 3] = std::array::from_fn(|i| (-h * self.fall[i]).min(self.most[i]));
        let power = exp(power);
        std::array::from_fn(|i| self.there[i] * power[i])
    }
}

/// The matter of some air.
#[derive(Clone, Copy, Debug)]
pub(super) struct Medium {
    /// The room that it takes.
    pub shell: Shell,
    /// Height over which the thinnest layer thins by a factor e.
    pub finest: f64,
    layers: Layers,
    /// Radius of the middle and half width of the absorber.
    tent: Option<(f64, f64)>,
    /// Scattering coefficients at density 1.
    scattering: [DVec3; 3],
    /// Coefficients of extinction: scattering and absorption.
    extinction: [DVec3; 4],
    /// Mean cosine of scattering by haze and fog.
    pub asymmetry: [DVec3; 2],
}

impl Medium {
    /// The matter of some air; `None` if it takes no room, does nothing, or makes no sense.
    pub fn new(air: &Air) -> Option<Medium> {
        let radius = positive(air.radius)?;
        let mut medium = Medium {
            shell: Shell { radius, top: radius },
            finest: f64::INFINITY,
            layers: Layers::NONE,
            tent: None,
            scattering: [DVec3::ZERO; 3],
            extinction: [DVec3::ZERO; 4],
            asymmetry: [DVec3::ZERO; 2],
        };
        medium.scattering[0] = coefficient(air.scattering)?;
        medium.extinction[0] = medium.scattering[0];
        medium.layer(0, positive(air.height)?, DEPTH);
        for (i, haze) in [air.haze, air.fog].into_iter().enumerate() {
            let Some(Haze { scattering, absorption, height, asymmetry }) = haze else { continue };
            medium.scattering[i + 1] = coefficient(scattering)?;
            medium.extinction[i + 1] = medium.scattering[i + 1] + coefficient(absorption)?;
            medium.layer(i + 1, positive(height)?, 0.0);
            medium.asymmetry[i] = (asymmetry.abs().max_element() < 1.0).then_some(asymmetry)?;
        }
        if let Some(ozone) = air.absorber {
            let (middle, width) = (radius + finite(ozone.center)?, positive(ozone.width)?);
            medium.extinction[3] = coefficient(ozone.absorption)?;
            medium.tent = Some((middle, width));
            medium.shell.top = medium.shell.top.max(middle + width);
        }
        (medium.extinction.iter().any(|&e| e != DVec3::ZERO) && medium.shell.top > radius).then_some(medium)
    }

    /// Puts a layer in its place. One that does nothing sets the scale of the air all the same.
    fn layer(&mut self, kind: usize, height: f64, most: f64) {
        let layers = &mut self.layers;
        layers.there[kind] = 1.0;
        (layers.fall[kind], layers.most[kind]) = (1.0 / height, most);
        self.shell.top = self.shell.top.max(self.shell.radius + TOP * height);
        self.finest = self.finest.min(height);
    }

    /// How dense each kind of matter is at a radius, relative to where its coefficients hold.
    pub fn density(&self, r: f64) -> DVec4 {
        let [gas, haze, fog] = self.layers.density(r - self.shell.radius);
        let tent = self.tent.map_or(0.0, |(middle, width)| (1.0 - (r - middle).abs() / width).max(0.0));
        DVec4::new(gas, haze, fog, tent)
    }

    /// Optical depths of what scatters above and below a radius, straight up and down.
    pub fn scatterers(&self, r: f64) -> [DVec3; 2] {
        let Shell { radius, top } = self.shell;
        let [ground, here, end] =
            [radius, r.clamp(radius, top), top].map(|r| self.layers.density(r - radius));
        let layers = |from: [f64; 3], to: [f64; 3]| {
            let column = |i: usize| {
                (from[i] - to[i]) / self.layers.fall[i].max(f64::MIN_POSITIVE) * self.scattering[i]
            };
            (0..3).map(column).sum()
        };
        [layers(here, end), layers(ground, here)]
    }

    /// Optical depth of an amount of each kind of matter: density times length.
    pub fn depth(&self, amount: DVec4) -> DVec3 {
        let e = &self.extinction;
        amount.x * e[0] + amount.y * e[1] + amount.z * e[2] + amount.w * e[3]
    }

    /// Share of light that an amount of matter scatters, by kind, where the amount is small.
    pub fn scattered(&self, amount: DVec4) -> [DVec3; 3] {
        let s = &self.scattering;
        [amount.x * s[0], amount.y * s[1], amount.z * s[2]]
    }
}

fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

fn positive(x: f64) -> Option<f64> {
    finite(x).filter(|&x| x > 0.0)
}

fn coefficient(x: DVec3) -> Option<DVec3> {
    (x.is_finite() && x.min_element() >= 0.0).then_some(x)
}
