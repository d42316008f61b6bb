//! Layers: what of a pixel a screen shows.

use super::picture::Pixel;
use super::{heatmap, tone};
use crate::num::srgb;
use crate::scene::{Film, Scene, Tone};

/// What of a picture is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Layer {
    /// Light, as a photograph has it.
    #[default]
    Light,
    /// Which way the surface faces: x, y and z as red, green and blue.
    Normals,
    /// What the pixel cost: evaluations of the field, ten colours for powers of two.
    Cost,
    /// How far away the surface is: brightness halves as distance doubles.
    Depth,
    /// Share of light that the surface reflects.
    Albedo,
}

/// Evaluations of the dearest colour of [`Layer::Cost`]: a power of two.
const DEAREST: f64 = 10.0;

/// How light becomes what screens show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Light behind everything.
    pub background: [f32; 3],
    /// Exposure in stops.
    pub exposure: f64,
    /// The tone curve.
    pub tone: Tone,
    /// Distance that [`Layer::Depth`] shows as bright as can be.
    pub near: f64,
}

impl Look {
    /// As a scene wants it.
    pub fn of(scene: &Scene) -> Look {
        let Film { exposure, tone, .. } = scene.film;
        let near = 0.5 * scene.camera.eye.distance(scene.camera.target);
        Look { background: scene.sky.background.as_vec3().to_array(), exposure, tone, near }
    }
}

impl Layer {
    /// Bytes in sRGB of a pixel, which has a `number` that it is dithered by.
    pub fn bytes(self, pixel: &Pixel, look: &Look, number: u64) -> [u8; 3] {
        let plain = |light: [f64; 3]| light.map(|c| (255.0 * srgb::encode(c.clamp(0.0, 1.0))).round() as u8);
        match self {
            Layer::Light => {
                let gain = libm::exp2(look.exposure);
                tone::bytes(pixel.over(look.background), (gain, look.tone), number)
            }
            Layer::Normals if pixel.depth.is_finite() => {
                pixel.normal.map(|c| (127.5 + 127.5 * f64::from(c)).round() as u8)
            }
            Layer::Cost => heatmap::color(libm::log2(1.0 + f64::from(pixel.evaluations)) / DEAREST),
            Layer::Depth if pixel.depth.is_finite() => {
                plain([look.near / f64::from(pixel.depth).max(look.near); 3])
            }
            Layer::Albedo => plain(pixel.albedo.map(f64::from)),
            Layer::Normals | Layer::Depth => [0; 3],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_show_what_they_are_of() {
        let look = Look { background: [0.0; 3], exposure: 0.0, tone: Tone::Neutral, near: 2.0 };
        let pixel = Pixel {
            color: [0.2; 3],
            alpha: 1.0,
            depth: 4.0,
            normal: [0.0, 1.0, -1.0],
            albedo: [1.0, 0.0, 0.5],
            evaluations: 1023.0,
            ..Pixel::EMPTY
        };
        let show = |layer: Layer| layer.bytes(&pixel, &look, 0);
        assert_eq!(show(Layer::Normals), [128, 255, 0]);
        assert_eq!(show(Layer::Albedo), [255, 0, 188]);
        assert_eq!(show(Layer::Depth), [188; 3]);
        assert_eq!(show(Layer::Cost), heatmap::color(1.0));
        assert!(show(Layer::Light).iter().all(|b| b.abs_diff(124) <= 1), "{:?}", show(Layer::Light));
        let nothing = |layer: Layer| layer.bytes(&Pixel::EMPTY, &look, 0);
        assert_eq!([nothing(Layer::Normals), nothing(Layer::Depth), nothing(Layer::Albedo)], [[0; 3]; 3]);
    }
}
