//! A plane through a field: what is inside is blue, what is outside is ochre, the surface is a clear dark line, and
//! thin lines join places of equal value.
//!
//! Lines are drawn by distance: where the field is `f` and has the slope `g` a pixel, the line of the level `c` is
//! about `|f - c| / |g|` pixels away. So lines have the same width everywhere and smooth edges, without being traced.
//! Where they would come too close to be told apart, they fade.

use super::axes::{Axes, BOTTOM, LEFT, TOP};
use super::bar::pixels;
use super::{Figure, PlotError};
use crate::num::oklab;

/// A figure of a plane.
#[derive(Clone, Debug)]
pub struct Contours<'a> {
    /// What is shown.
    pub title: String,
    /// Names of the axes, to the right and upwards.
    pub labels: [&'a str; 2],
    /// Ends of the axes: the outer edges of the first and the last pixel.
    pub ends: [(f64, f64); 2],
    /// Pixels in a row.
    pub width: u32,
    /// The values at the centres of pixels, row by row from the top; what is not finite has no colour.
    pub data: &'a [f64],
}

/// Room on the right of the picture, for the bar.
const RIGHT: u32 = 106;

/// Values that the strongest colours need not reach: a few that are very large would make all others pale.
const TOLD_APART: f64 = 0.99;
/// Lines of equal value on one side of the surface, about.
const LINES: f64 = 8.0;
/// Half widths of the surface's line and of the others, in pixels.
const SURFACE: f64 = 1.1;
const THIN: f64 = 0.5;
/// Lines that are so close begin to fade, and are gone; in pixels.
const CLOSE: (f64, f64) = (7.0, 3.0);
/// What has no value.
const NOTHING: [u8; 3] = [216, 216, 216];

impl Contours<'_> {
    /// Size of a figure around a picture of this size.
    pub fn outer(width: u32, height: u32) -> (u32, u32) {
        (LEFT + width + RIGHT, TOP + height + BOTTOM)
    }

    /// The largest picture, of so many rows for a column, that fits into a figure of a size; `None` if there is no
    /// room for any.
    pub fn inner(width: u32, height: u32, aspect: f64) -> Option<(u32, u32)> {
        let (width, height) = (width.checked_sub(LEFT + RIGHT)?, height.checked_sub(TOP + BOTTOM)?);
        let columns = f64::from(width).min(f64::from(height) / aspect);
        let (columns, rows) = (columns as u32, (columns * aspect).round() as u32);
        (columns >= 32 && rows >= 32).then_some((columns, rows))
    }

    /// Draws it, with axes and a scale.
    ///
    /// # Errors
    /// [`PlotError`]
    pub fn draw(&self) -> Result<Figure, PlotError> {
        let image = self.image();
        let shades = self.shades();
        let ticks = [image.width, image.height].map(|pixels| (pixels as usize / 60).clamp(2, 9));
        let axes = Axes {
            title: &self.title,
            middle: LEFT + image.width / 2,
            labels: self.labels,
            ends: self.ends,
            ticks,
            size: (image.width, image.height),
            right: RIGHT,
            bar: ("f", (-shades.most, shades.most)),
        };
        let (mut figure, (across, down), bar) = axes.draw()?;
        for (y, row) in (down.start..).zip(image.rgb.chunks_exact(3 * image.width as usize)) {
            for (x, pixel) in (across.start..).zip(row.chunks_exact(3)) {
                figure.set(x, y, [pixel[0], pixel[1], pixel[2]]);
            }
        }
        let length = f64::from(bar.1.end - bar.1.start).max(1.0);
        for (x, y, share) in pixels(bar) {
            let value = shades.most * (2.0 * share - 1.0);
            figure.set(x, y, shades.pixel(value, 2.0 * shades.most / length));
        }
        Ok(figure)
    }

    /// The picture without anything around it.
    pub fn image(&self) -> Figure {
        let width = self.width.max(1) as usize;
        let rows = self.data.len() / width;
        let shades = self.shades();
        let mut rgb = Vec::with_capacity(3 * self.data.len());
        for y in 0..rows {
            for x in 0..width {
                let value = self.data[y * width + x];
                rgb.extend(shades.pixel(value, self.slope(x, y, rows)));
            }
        }
        Figure { width: self.width, height: rows as u32, rgb }
    }

    /// The value that has the strongest colour.
    pub fn most(&self) -> f64 {
        let mut sizes: Vec<f64> = self.data.iter().map(|v| v.abs()).filter(|v| v.is_finite()).collect();
        sizes.sort_by(f64::total_cmp);
        let last = sizes.len().saturating_sub(1) as f64;
        sizes.get((TOLD_APART * last) as usize).copied().filter(|v| *v > 0.0).unwrap_or(1.0)
    }

    /// How much a line of equal value is from the next.
    pub fn step(&self) -> f64 {
        self.shades().step
    }

    fn shades(&self) -> Shades {
        let most = self.most();
        Shades { most, step: round_step(most / LINES) }
    }

    /// How much the value changes from a pixel to the next, in the steepest direction. Of both neighbours along an
    /// axis the one counts that differs more: across a crease they may have the same value.
    fn slope(&self, x: usize, y: usize, rows: usize) -> f64 {
        let width = self.width.max(1) as usize;
        let at = |x: usize, y: usize| self.data[y * width + x];
        let here = at(x, y);
        let steeper = |before: Option<f64>, after: Option<f64>| {
            [before, after].into_iter().flatten().map(|v| (v - here).abs()).fold(0.0, f64::max)
        };
        let across = steeper((x > 0).then(|| at(x - 1, y)), (x + 1 < width).then(|| at(x + 1, y)));
        let down = steeper((y > 0).then(|| at(x, y - 1)), (y + 1 < rows).then(|| at(x, y + 1)));
        libm::hypot(across, down)
    }
}

/// What colours stand for.
#[derive(Clone, Copy)]
struct Shades {
    most: f64,
    step: f64,
}

impl Shades {
    /// The colour of a pixel with this value, which changes so much to the next pixel.
    fn pixel(&self, value: f64, slope: f64) -> [u8; 3] {
        if !value.is_finite() {
            return NOTHING;
        }
        let mut color = shade(value / self.most);
        if !(slope > 0.0 && slope.is_finite()) {
            return oklab::bytes(color);
        }
        let level = (value / self.step).round();
        if level != 0.0 {
            let apart = self.step / slope;
            let room = ((apart - CLOSE.1) / (CLOSE.0 - CLOSE.1)).clamp(0.0, 1.0);
            let ink = 0.45 * room * covered((value - level * self.step).abs() / slope, THIN);
            color = color.map(|c| c * (1.0 - ink));
        }
        let ink = covered(value.abs() / slope, SURFACE);
        oklab::bytes(color.map(|c| c * (1.0 - ink) + SURFACE_COLOR * ink))
    }
}

/// Light that the line of the surface gives off.
const SURFACE_COLOR: f64 = 0.012;

/// How much of a pixel is under a line whose middle is so far away.
fn covered(distance: f64, half_width: f64) -> f64 {
    (half_width + 0.5 - distance).clamp(0.0, 1.0)
}

/// The linear colour of a share from -1, deep inside, to 1, far outside: pale at the surface, and darker and stronger
/// away from it. Blue and ochre are told apart by everybody, and by lightness the sides are alike.
fn shade(share: f64) -> [f64; 3] {
    let size = libm::sqrt(share.abs().min(1.0));
    let (hue, chroma, fall) = if share < 0.0 { (250.0, 0.1, 0.42) } else { (72.0, 0.105, 0.27) };
    oklab::linear(0.95 - fall * size * size, chroma * size * (1.6 - 0.6 * size), hue)
}

/// The next of 1, 2, 5, 10, ... that is no less.
fn round_step(least: f64) -> f64 {
    let decade = libm::pow(10.0, libm::floor(libm::log10(least)));
    [1.0, 2.0, 5.0].into_iter().map(|m| m * decade).find(|step| *step >= least).unwrap_or(10.0 * decade)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A circle, 64 pixels for two radii and a half.
    fn circle() -> Vec<f64> {
        let at = |i: usize| (i as f64 + 0.5) / 64.0 * 2.5 - 1.25;
        (0..64 * 64).map(|i| f64::hypot(at(i % 64), at(i / 64)) - 1.0).collect()
    }

    fn contours(data: &[f64]) -> Contours<'_> {
        let ends = [(-1.25, 1.25); 2];
        Contours { title: "circle".to_owned(), labels: ["x", "y"], ends, width: 64, data }
    }

    #[test]
    fn inside_is_blue_outside_is_not_and_the_surface_is_dark() {
        let data = circle();
        let image = contours(&data).image();
        let at = |x: usize, y: usize| {
            let i = 3 * (y * 64 + x);
            [image.rgb[i], image.rgb[i + 1], image.rgb[i + 2]].map(i32::from)
        };
        let [inside, outside] = [at(30, 34), at(2, 3)];
        assert!(inside[2] > inside[0] + 30, "{inside:?}");
        assert!(outside[0] > outside[2] + 20, "{outside:?}");
        // The row through the middle crosses the surface at x = -1.
        let darkest = (0..32).min_by_key(|x| at(*x, 32).iter().sum::<i32>()).unwrap();
        assert!((5..=7).contains(&darkest) && at(darkest, 32).iter().all(|c| *c < 80), "{darkest}");
    }

    #[test]
    fn what_has_no_value_is_grey_and_hides_nothing() {
        let mut data = circle();
        data[0] = f64::NAN;
        data[1] = f64::INFINITY;
        let contours = contours(&data);
        assert!(contours.most() < 1.0 && contours.most() > 0.5, "{}", contours.most());
        assert_eq!(contours.image().rgb[..3], NOTHING);
        let nothing = Contours { data: &[f64::NAN; 64 * 64], ..contours };
        assert_eq!((nothing.most(), nothing.draw().unwrap().width), (1.0, 64 + LEFT + RIGHT));
    }

    #[test]
    fn pictures_fit_their_figures() {
        assert_eq!(Contours::inner(LEFT + RIGHT + 100, 1000, 0.5), Some((100, 50)));
        assert_eq!(Contours::inner(1000, TOP + BOTTOM + 100, 0.5), Some((200, 100)));
        assert_eq!(Contours::inner(100, 100, 1.0), None);
        assert_eq!(Contours::outer(10, 20), (LEFT + RIGHT + 10, TOP + BOTTOM + 20));
        assert_eq!([0.1, 0.3, 0.7].map(round_step), [0.1, 0.5, 1.0]);
    }

    #[test]
    fn screens_can_show_all_shades() {
        for i in -100..=100 {
            let color = shade(f64::from(i) / 100.0);
            assert!(color.iter().all(|c| (-0.002..=1.002).contains(c)), "{i}: {color:?}");
        }
    }
}
