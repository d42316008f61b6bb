//! How a scene is to be rendered: what its script says, unless somebody says otherwise.

use super::{Part, PartError, Rect, RenderError};
use crate::scene::{Aabb, Film, Filter, Scene, Tone};

/// How a scene is to be rendered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The part of it that is rendered.
    pub part: Part,
    /// Samples per pixel.
    pub samples: u32,
    /// Standard error at which a pixel has enough samples, as a share of white; 0 for all of them.
    pub noise: f64,
    /// How a pixel weighs its surroundings.
    pub filter: Filter,
    /// How often light is followed from surface to surface.
    pub bounces: u32,
    /// Pixels between places where light that bounces is gathered for what is around them; 0 where every sample goes on by itself.
    pub irradiance_spacing: u32,
    /// Where nothing bounces, how far the solid stands in the way of skylight; 0 where it does not.
    pub occlusion: f64,
    /// How light becomes brightness in 8-bit pictures.
    pub tone: Tone,
    /// Exposure in stops, for 8-bit pictures; float pictures hold the light as it is.
    pub exposure: f64,
    /// Where the solid is looked for. Space outside is empty, and solids that reach outside are cut.
    pub bounds: Aabb,
    /// How far a hit may lie in front of the surface; found from the size of a pixel where `None`.
    pub tolerance: Option<f64>,
    /// Another seed moves the samples within their pixels.
    pub seed: u64,
    /// Bytes that the pixels of the picture may take.
    pub memory: u64,
}

impl Settings {
    /// The settings that the scene's script asks for. A scene without bounds gets `bounds`.
    pub fn of(scene: &Scene, bounds: Aabb) -> Self {
        Settings::of_film(&scene.film, scene.bounds.unwrap_or(bounds))
    }

    /// The settings of a film.
    pub fn of_film(film: &Film, bounds: Aabb) -> Self {
        Settings {
            width: film.width,
            height: film.height,
            part: Part::Whole,
            samples: film.samples,
            noise: film.noise,
            filter: film.filter,
            bounces: film.bounces,
            irradiance_spacing: film.irradiance_spacing,
            occlusion: film.occlusion,
            tone: film.tone,
            exposure: film.exposure,
            bounds,
            tolerance: None,
            seed: 0,
            memory: 8 << 30,
        }
    }

    /// The filter. A lone sample is in the middle of its pixel: jitter would only fray its edges.
    pub(super) fn filter(&self) -> super::Filter {
        let Filter { order, isotropic } = self.filter;
        let order = if self.samples == 1 { 0 } else { order };
        super::Filter::new(order, isotropic).unwrap_or_default()
    }

    /// The pixels that are rendered.
    ///
    /// # Errors
    /// [`PartError`] if the picture has no such part.
    pub fn window(&self) -> Result<Rect, PartError> {
        self.part.window(self.width, self.height)
    }

    /// Bytes that those pixels take.
    pub fn memory_needed(&self) -> u64 {
        self.window().map_or(0, |window| window.area()) * size_of::<super::Pixel>() as u64
    }

    /// Whether a picture can be made like that.
    ///
    /// # Errors
    /// [`RenderError`] names the setting that cannot be.
    pub fn check(&self) -> Result<(), RenderError> {
        let &Settings { width, height, memory: limit, .. } = self;
        let side = 1..=Film::MAX_SIDE;
        if !side.contains(&width) || !side.contains(&height) {
            return Err(RenderError::Size { width, height });
        }
        self.window()?;
        let needed = self.memory_needed();
        if needed > limit {
            return Err(RenderError::Memory { width, height, needed, limit });
        }
        if !(1..=Film::MAX_SAMPLES).contains(&self.samples) {
            return Err(RenderError::Samples(self.samples));
        }
        if super::Filter::new(self.filter.order, self.filter.isotropic).is_err() {
            let value = f64::from(self.filter.order);
            return Err(RenderError::Setting {
                name: "filter",
                value,
                range: "an order of a B-spline, up to 32",
            });
        }
        if !(-64.0..=64.0).contains(&self.exposure) {
            let range = "from -64 to 64 stops";
            return Err(RenderError::Setting { name: "exposure", value: self.exposure, range });
        }
        if let Some(value) = self.tolerance
            && !(value > 0.0 && value.is_finite())
        {
            return Err(RenderError::Setting { name: "tolerance", value, range: "positive" });
        }
        if !self.bounds.is_proper() {
            return Err(RenderError::Bounds);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> Settings {
        Settings { memory: 1 << 30, ..Settings::of_film(&Film::default(), Aabb::cube(1.0)) }
    }

    #[test]
    fn what_cannot_be_is_named() {
        assert_eq!(settings().check(), Ok(()));
        let error = |s: Settings| s.check().unwrap_err().to_string();
        assert!(error(Settings { width: 0, ..settings() }).contains("0 x 600"));
        assert!(error(Settings { height: 70_000, ..settings() }).contains("65536"));
        assert!(error(Settings { width: 60_000, height: 60_000, ..settings() }).contains("memory"));
        let part = Part::Tile { number: 1, of: 4 };
        assert_eq!(Settings { width: 6_000, height: 6_000, part, ..settings() }.check(), Ok(()));
        let part = Part::Region(Rect { x: 790, y: 0, width: 20, height: 20 });
        assert!(error(Settings { part, ..settings() }).contains("800 x 600"));
        assert!(error(Settings { samples: 0, ..settings() }).contains("samples"));
        assert!(error(Settings { exposure: f64::NAN, ..settings() }).contains("exposure"));
        assert!(error(Settings { tolerance: Some(0.0), ..settings() }).contains("tolerance"));
        assert!(error(Settings { bounds: Aabb::cube(-1.0), ..settings() }).contains("bounds"));
    }
}
