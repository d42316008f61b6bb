//! A square of numbers as shades of grey, with a bar that says which shade is which number.

use super::axes::{Axes, LEFT};
use super::bar::pixels;
use super::{Figure, Frame, PlotError};
use std::ops::Range;

/// A figure of a square of numbers.
#[derive(Clone, Debug)]
pub struct Map<'a> {
    /// What is shown.
    pub title: String,
    /// Names of the axes, to the right and upwards.
    pub labels: [&'a str; 2],
    /// Ends of both axes: the outer edges of the first and the last number.
    pub range: (f64, f64),
    /// Numbers along an edge.
    pub edge: usize,
    /// The numbers, row by row from the lowest row up.
    pub data: &'a [f64],
    /// The numbers that are black and white.
    pub shades: (f64, f64),
    /// What the numbers are.
    pub bar: &'a str,
}

/// Room on the right of the image, for the bar.
const RIGHT: u32 = 98;

impl Map<'_> {
    /// Draws it; the height follows from the width.
    ///
    /// # Errors
    /// [`PlotError`]
    pub fn draw(&self, width: u32) -> Result<Figure, PlotError> {
        let side = width.checked_sub(LEFT + RIGHT).filter(|s| *s >= 32).ok_or(PlotError::Small(width))?;
        let axes = Axes {
            title: &self.title,
            middle: width / 2,
            labels: self.labels,
            ends: [self.range; 2],
            ticks: [9; 2],
            size: (side, side),
            right: RIGHT,
            bar: (self.bar, self.shades),
        };
        let (mut figure, image, bar) = axes.draw()?;
        self.fill(&mut figure, image);
        for (x, y, share) in pixels(bar) {
            figure.set(x, y, [(255.0 * share).round() as u8; 3]);
        }
        Ok(figure)
    }

    /// Puts the shades into their frame: each pixel is the mean of the numbers that it covers.
    fn fill(&self, figure: &mut Figure, (across, down): Frame) {
        let (low, high) = self.shades;
        let columns = covers(self.edge, across.len());
        let rows = covers(self.edge, down.len());
        for (j, y) in down.rev().enumerate() {
            for (i, x) in across.clone().enumerate() {
                let numbers = rows[j].clone().flat_map(|r| &self.data[r * self.edge..][columns[i].clone()]);
                let (sum, count) = numbers.fold((0.0, 0.0), |(s, n), v| (s + v, n + 1.0));
                let share = (sum / count - low) / (high - low);
                figure.set(x, y, [(255.0 * share).round().clamp(0.0, 255.0) as u8; 3]);
            }
        }
    }
}

/// Which of `edge` numbers each of `pixels` pixels covers; at least one.
fn covers(edge: usize, pixels: usize) -> Vec<Range<usize>> {
    let start = |i: usize| i * edge / pixels;
    (0..pixels).map(|i| start(i)..start(i + 1).max(start(i) + 1)).collect()
}
