//! A picture in which colours are numbers, pixel for pixel, with a bar that says which is which.

use super::bar::{Bar, pixels};
use super::{FONT, Figure, PlotError, TITLE, drawing, font};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// A picture of numbers.
#[derive(Clone, Debug)]
pub struct Heat<'a> {
    /// What is shown.
    pub title: String,
    /// Numbers in a row.
    pub width: u32,
    /// The numbers, row by row from the top.
    pub data: &'a [f64],
    /// The numbers at the ends of the colours; what lies beyond has the colour of the end.
    pub ends: (f64, f64),
    /// What the numbers are.
    pub bar: &'a str,
    /// The colour at a share from 0 to 1 of the way.
    pub color: fn(f64) -> [u8; 3],
}

/// Room above the picture, for the title; and beside it, for the bar.
const TOP: u32 = 34;
const RIGHT: u32 = 106;
/// White margin.
const MARGIN: u32 = 8;
/// The bar is at least so long, and the figure at least so wide, for the title, whatever the picture is.
const LENGTH: u32 = 160;
const TITLE_WIDTH: u32 = 430;

impl Heat<'_> {
    /// Draws it; the figure is a little larger than the picture.
    ///
    /// # Errors
    /// [`PlotError`]
    pub fn draw(&self) -> Result<Figure, PlotError> {
        font()?;
        let rows = (self.data.len() / self.width.max(1) as usize) as u32;
        let left = MARGIN + self.width;
        let (width, height) = ((left + RIGHT).max(TITLE_WIDTH), TOP + rows.max(LENGTH) + MARGIN);
        let mut figure = Figure::blank(width, height);
        let backend = BitMapBackend::with_buffer(&mut figure.rgb, (width, height));
        let root = backend.into_drawing_area();
        root.fill(&WHITE).map_err(drawing)?;
        let style = TextStyle::from((FONT, TITLE).into_font()).pos(Pos::new(HPos::Left, VPos::Center));
        root.draw(&Text::new(self.title.as_str(), (MARGIN as i32, TOP as i32 / 2), style))
            .map_err(drawing)?;
        let bar = Bar { label: self.bar, ends: self.ends, top: TOP, bottom: MARGIN, right: MARGIN };
        let bar = bar.frame(&root.split_horizontally(left).1.split_horizontally(RIGHT).0)?;
        root.present().map_err(drawing)?;
        drop(root);
        for (x, y, share) in pixels(bar) {
            figure.set(x, y, (self.color)(share));
        }
        let (low, high) = self.ends;
        for (y, row) in self.data.chunks_exact(self.width.max(1) as usize).enumerate() {
            for (x, number) in row.iter().enumerate() {
                let share = ((number - low) / (high - low)).clamp(0.0, 1.0);
                figure.set(x as i32 + MARGIN as i32, y as i32 + TOP as i32, (self.color)(share));
            }
        }
        Ok(figure)
    }
}
