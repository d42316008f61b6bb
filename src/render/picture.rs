//! Pictures: light in every pixel, and what was seen there.

use super::{Rect, Settings, Stats, tone};
use crate::diag::Diagnostic;
use crate::render::RenderError;
use crate::scene::Tone;
use std::sync::atomic::{AtomicBool, Ordering};

/// What a picture holds in one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// Light from the solid and the air: linear red, green, blue, without the background.
    pub color: [f32; 3],
    /// Of that, what the solid gives off, or reflects straight from a light.
    pub direct: [f32; 3],
    /// Of that, what it reflects from the sky and from elsewhere on the solid.
    pub indirect: [f32; 3],
    /// Of that, what comes from the air and from what is behind everything.
    pub sky: [f32; 3],
    /// Share of light that the solid reflects; nothing where there is none.
    pub albedo: [f32; 3],
    /// Share of the background that is covered.
    pub alpha: f32,
    /// Distance from the eye of the nearest point seen in the pixel; infinite where there is none.
    pub depth: f32,
    /// That point; zero where there is none.
    pub position: [f32; 3],
    /// Unit normal there; zero where there is none.
    pub normal: [f32; 3],
    /// Distance between neighbouring pixels there; zero where there is none.
    pub footprint: f32,
    /// Samples taken.
    pub samples: f32,
    /// Square of the standard error of its luminance.
    pub variance: f32,
    /// Evaluations of the field that the rays of the pixel itself needed, those to the sun included: not what it took to gather
    /// light that it shares.
    pub evaluations: f32,
}

impl Pixel {
    /// Nothing.
    pub const EMPTY: Pixel = Pixel {
        color: [0.0; 3],
        direct: [0.0; 3],
        indirect: [0.0; 3],
        sky: [0.0; 3],
        albedo: [0.0; 3],
        alpha: 0.0,
        depth: f32::INFINITY,
        position: [0.0; 3],
        normal: [0.0; 3],
        footprint: 0.0,
        samples: 0.0,
        variance: 0.0,
        evaluations: 0.0,
    };

    /// The pixel in front of a background.
    pub fn over(&self, background: [f32; 3]) -> [f64; 3] {
        let left = 1.0 - f64::from(self.alpha);
        std::array::from_fn(|i| f64::from(self.color[i]) + left * f64::from(background[i]))
    }
}

/// A rendered scene, or as much of it as is finished.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The part of it that is held.
    pub window: Rect,
    /// The pixels of the window: rows from top to bottom.
    pub pixels: Vec<Pixel>,
    /// The colours of these pixels with their noise smoothed, if that is wanted; see [`denoise`](super::denoise).
    pub denoised: Option<Vec<[f32; 3]>>,
    /// The components of the solid that these pixels show, by number, if that is wanted; none where nothing is seen or
    /// where it is not known.
    pub components: Option<Vec<Option<u32>>>,
    /// Light behind everything, linear.
    pub background: [f32; 3],
    /// Exposure in stops for screens.
    pub exposure: f64,
    /// How light becomes brightness on screens.
    pub tone: Tone,
    /// Whether every tile of the window is there; not so after a cancellation.
    pub finished: bool,
    /// Tiles that are there.
    pub tiles: u32,
    /// Whether no ray met the solid.
    pub empty: bool,
    /// What is odd about the picture, with hints.
    pub warnings: Vec<Diagnostic>,
    /// What it cost.
    pub stats: Stats,
}

impl Picture {
    /// A picture that will hold a window, and has room for it but no pixels yet: to write to so much memory takes longer
    /// than the first rough tiles.
    pub(super) fn reserved(settings: &Settings, background: [f32; 3]) -> Result<Picture, RenderError> {
        let Settings { width, height, .. } = *settings;
        let window = settings.window()?;
        let count = window.width as usize * window.height as usize;
        let mut pixels = Vec::new();
        pixels.try_reserve_exact(count).map_err(|_| {
            let needed = settings.memory_needed();
            RenderError::Memory { width, height, needed, limit: 0 }
        })?;
        Ok(Picture {
            width,
            height,
            window,
            pixels,
            denoised: None,
            components: None,
            background,
            exposure: settings.exposure,
            tone: settings.tone,
            finished: false,
            tiles: 0,
            empty: true,
            warnings: Vec::new(),
            stats: Stats::default(),
        })
    }

    /// Fills the window with nothing, unless there is something in it already.
    pub(super) fn fill(&mut self) {
        self.fill_until(&AtomicBool::new(false));
    }

    /// The same bit by bit, and whether that came to its end: memory that was never used takes its time. Once `cancel` is
    /// set there is nothing in the window.
    pub(super) fn fill_until(&mut self, cancel: &AtomicBool) -> bool {
        /// Pixels in about 7 MB.
        const BIT: usize = 1 << 16;
        let count = self.window.area() as usize;
        while self.pixels.len() < count {
            if cancel.load(Ordering::Relaxed) {
                self.pixels.clear();
                return false;
            }
            self.pixels.resize((self.pixels.len() + BIT).min(count), Pixel::EMPTY);
        }
        true
    }

    /// Whether the window is all of the picture.
    pub fn is_whole(&self) -> bool {
        self.window == Rect::whole(self.width, self.height)
    }

    /// Where a pixel of the window is held.
    fn place(&self, x: u32, y: u32) -> usize {
        let Rect { x: left, y: top, width, .. } = self.window;
        (y - top) as usize * width as usize + (x - left) as usize
    }

    /// The pixel in a column and row of the picture, which must be in its window.
    pub fn pixel(&self, x: u32, y: u32) -> &Pixel {
        &self.pixels[self.place(x, y)]
    }

    /// Puts the pixels of a tile in their place, those that the window shows.
    pub(super) fn put(&mut self, tile: &Rect, pixels: &[Pixel]) {
        let Some(seen) = tile.intersection(&self.window) else { return };
        let columns = seen.width as usize;
        for y in seen.y..seen.bottom() {
            let from = (y - tile.y) as usize * tile.width as usize + (seen.x - tile.x) as usize;
            let to = self.place(seen.x, y);
            let row = &pixels[from..from + columns];
            self.pixels[to..to + columns].copy_from_slice(row);
            self.empty &= row.iter().all(|pixel| pixel.depth.is_infinite());
        }
    }

    /// A row of the picture, as far as it is in the window, as screens show it: red, green and blue bytes in sRGB,
    /// on the background. They are dithered by the place in the picture, whatever the window.
    pub fn row_bytes(&self, y: u32) -> Vec<u8> {
        let start = self.place(self.window.x, y);
        let number = u64::from(y) * u64::from(self.width) + u64::from(self.window.x);
        let gain = libm::exp2(self.exposure);
        let range = start..start + self.window.width as usize;
        let shown = |i: usize| match &self.denoised {
            Some(colors) => Pixel { color: colors[i], ..self.pixels[i] },
            None => self.pixels[i],
        };
        let row = range.map(shown).zip(number..);
        row.flat_map(|(p, number)| tone::bytes(p.over(self.background), (gain, self.tone), number)).collect()
    }
}
