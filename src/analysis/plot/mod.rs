//! Figures: curves, and images of numbers with scales, as pixels.
//!
//! Axes, ticks and texts are drawn by `plotters` with a font that is part of the program, so that a
//! figure is the same, bit for bit, on every machine. Images are put into their frames pixel by pixel
//! here.

mod axes;
mod bar;
mod contours;
mod curves;
mod heat;
mod map;

pub use contours::Contours;
pub use curves::{Axis, Curves, Line};
pub use heat::Heat;
pub use map::Map;

use plotters::coord::Shift;
use plotters::prelude::{BitMapBackend, DrawingArea};
use png::{BitDepth, ColorType, Compression, Encoder, EncodingError};
use std::io::{self, Write};
use std::ops::Range;
use std::sync::OnceLock;

/// A picture with 8 bits for red, green and blue, row by row.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Three bytes a pixel.
    pub rgb: Vec<u8>,
}

/// Why a figure cannot be drawn.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum PlotError {
    /// The embedded font does not load.
    #[error("the font of the figures does not load")]
    Font,
    /// The library for drawing gave up.
    #[error("the figure cannot be drawn: {0}")]
    Drawing(String),
    /// There is no room for a frame.
    #[error("{0} pixels are too few for a figure with axes")]
    Small(u32),
}

/// What is drawn on.
type Area<'a> = DrawingArea<BitMapBackend<'a>, Shift>;
/// Pixels of a frame.
type Frame = (Range<i32>, Range<i32>);

/// Name under which the font is known to the drawing library.
const FONT: &str = "figure";
/// Height of titles in pixels.
const TITLE: i32 = 18;
/// Height of other texts.
const TEXT: i32 = 13;

/// Registers the font, once.
fn font() -> Result<(), PlotError> {
    static FONTS: OnceLock<bool> = OnceLock::new();
    let style = plotters::style::FontStyle::Normal;
    let loaded =
        FONTS.get_or_init(|| plotters::style::register_font(FONT, style, dejavu::sans::regular()).is_ok());
    if *loaded { Ok(()) } else { Err(PlotError::Font) }
}

fn drawing(error: impl std::fmt::Display) -> PlotError {
    PlotError::Drawing(error.to_string())
}

impl Figure {
    /// A white picture.
    fn blank(width: u32, height: u32) -> Figure {
        Figure { width, height, rgb: vec![255; width as usize * height as usize * 3] }
    }

    /// A picture of one byte a pixel.
    pub fn grey(width: u32, height: u32, bytes: impl Iterator<Item = u8>) -> Figure {
        Figure { width, height, rgb: bytes.flat_map(|b| [b; 3]).collect() }
    }

    /// The picture made smaller by a whole factor: each pixel is the mean of those that it covers.
    fn coarser(&self, by: u32) -> Figure {
        let (width, height) = (self.width / by, self.height / by);
        let mut rgb = Vec::with_capacity(3 * (width * height) as usize);
        for y in 0..height {
            for x in 0..width {
                let mut sum = [0; 3];
                for row in y * by..(y + 1) * by {
                    let start = 3 * (row * self.width + x * by) as usize;
                    let pixels = self.rgb[start..start + 3 * by as usize].chunks_exact(3);
                    pixels.for_each(|p| (0..3).for_each(|c| sum[c] += u32::from(p[c])));
                }
                rgb.extend(sum.map(|s| (s / (by * by)) as u8));
            }
        }
        Figure { width, height, rgb }
    }

    fn set(&mut self, x: i32, y: i32, color: [u8; 3]) {
        if (0..self.width as i32).contains(&x) && (0..self.height as i32).contains(&y) {
            let start = 3 * (y as usize * self.width as usize + x as usize);
            self.rgb[start..start + 3].copy_from_slice(&color);
        }
    }

    /// Writes a PNG: one byte a pixel where everything is grey.
    ///
    /// # Errors
    /// As for writing the file.
    pub fn write_png(&self, file: impl Write) -> io::Result<()> {
        let grey = self.rgb.chunks_exact(3).all(|p| p[0] == p[1] && p[1] == p[2]);
        let mut encoder = Encoder::new(file, self.width, self.height);
        encoder.set_color(if grey { ColorType::Grayscale } else { ColorType::Rgb });
        encoder.set_depth(BitDepth::Eight);
        encoder.set_compression(Compression::High);
        let mut writer = encoder.write_header().map_err(io_error)?;
        if grey {
            let bytes: Vec<u8> = self.rgb.iter().step_by(3).copied().collect();
            writer.write_image_data(&bytes).map_err(io_error)?;
        } else {
            writer.write_image_data(&self.rgb).map_err(io_error)?;
        }
        writer.finish().map_err(io_error)
    }
}

fn io_error(error: EncodingError) -> io::Error {
    match error {
        EncodingError::IoError(error) => error,
        other => io::Error::other(other),
    }
}

/// Decimals that tell the ticks of an axis apart, of which there are at most nine.
fn decimals(low: f64, high: f64) -> usize {
    let step = ((high - low).abs() / 9.0).max(1e-9);
    // Steps are 1, 2 or 5 of a decimal, and a little longer than that.
    libm::ceil(-libm::log10(step) - 0.1).clamp(0.0, 9.0) as usize
}

/// The label of a tick: zero has no sign, nor has what is rounded to it.
fn tick(v: f64, digits: usize) -> String {
    let text = format!("{v:.digits$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| matches!(c, '0' | '.')) => rest.to_owned(),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_told_apart() {
        assert_eq!(
            [(0.0, 8.0), (-90.0, -10.0), (-0.7, 0.6), (0.0, 0.13)].map(|(a, b)| decimals(a, b)),
            [0, 0, 1, 2]
        );
    }

    #[test]
    fn zero_has_no_sign() {
        assert_eq!([-0.0, -0.04, -0.06, 0.0].map(|v| tick(v, 1)), ["0.0", "0.0", "-0.1", "0.0"]);
        assert_eq!(tick(-3e-17, 0), "0");
    }

    #[test]
    fn coarser_pictures_are_means() {
        let figure = Figure::grey(5, 2, [0, 10, 20, 30, 9, 100, 110, 120, 130, 9].into_iter());
        let coarser = figure.coarser(2);
        assert_eq!((coarser.width, coarser.height), (2, 1));
        assert_eq!(coarser.rgb, [55, 55, 55, 75, 75, 75]);
    }

    #[test]
    fn figures_are_drawn_the_same_every_time() {
        let data: Vec<f64> = (0..64).map(f64::from).collect();
        let map = Map {
            title: "steps".to_owned(),
            labels: ["x", "y"],
            range: (0.0, 8.0),
            edge: 8,
            data: &data,
            shades: (0.0, 63.0),
            bar: "value",
        };
        let figure = map.draw(300).unwrap();
        assert_eq!(figure.rgb, map.draw(300).unwrap().rgb);
        let grey = |x: u32, y: u32| figure.rgb[3 * (y * figure.width + x) as usize];
        // The lowest row is at the bottom, and the first number at its left.
        assert!(grey(80, figure.height - 60) < 30 && grey(80, 50) > 200);
        assert_eq!(map.draw(100).unwrap_err(), PlotError::Small(100));
        let mut png = Vec::new();
        figure.write_png(&mut png).unwrap();
        assert_eq!(&png[1..4], b"PNG");
    }
}
