//! A square of numbers as shades of grey, with a bar that says which shade is which number.

use super::bar::{Bar, pixels};
use super::{Area, FONT, Figure, Frame, PlotError, TEXT, TITLE, decimals, drawing, font, tick};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
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

/// Room around the image: for labels on its left, the bar on its right, the title, labels below.
const LEFT: u32 = 62;
const RIGHT: u32 = 98;
/// White margin outside of all labels.
const MARGIN: u32 = 8;
const TOP: u32 = 34;
const BOTTOM: u32 = 46;

impl Map<'_> {
    /// Draws it; the height follows from the width.
    ///
    /// # Errors
    /// [`PlotError`]
    pub fn draw(&self, width: u32) -> Result<Figure, PlotError> {
        font()?;
        let side = width.checked_sub(LEFT + RIGHT).filter(|s| *s >= 32).ok_or(PlotError::Small(width))?;
        let height = side + TOP + BOTTOM;
        let mut figure = Figure::blank(width, height);
        let backend = BitMapBackend::with_buffer(&mut figure.rgb, (width, height));
        let root = backend.into_drawing_area();
        let (image, bar) = self.frames(&root, side)?;
        root.present().map_err(drawing)?;
        drop(root);
        self.fill(&mut figure, image);
        for (x, y, share) in pixels(bar) {
            figure.set(x, y, [(255.0 * share).round() as u8; 3]);
        }
        Ok(figure)
    }

    /// Draws everything but the shades; says where they belong.
    fn frames(&self, root: &Area<'_>, side: u32) -> Result<(Frame, Frame), PlotError> {
        root.fill(&WHITE).map_err(drawing)?;
        let centred = Pos::new(HPos::Center, VPos::Center);
        let style = TextStyle::from((FONT, TITLE).into_font()).pos(centred);
        let middle = ((LEFT + side + RIGHT) / 2) as i32;
        root.draw(&Text::new(self.title.as_str(), (middle, TOP as i32 / 2), style)).map_err(drawing)?;
        let (left, right) = root.split_horizontally(LEFT + side);
        let (low, high) = self.range;
        let mut chart = ChartBuilder::on(&left)
            .margin_top(TOP)
            .margin_bottom(MARGIN)
            .x_label_area_size(BOTTOM - MARGIN)
            .margin_left(MARGIN)
            .y_label_area_size(LEFT - MARGIN)
            .build_cartesian_2d(low..high, low..high)
            .map_err(drawing)?;
        let format = ticks(self.range);
        chart
            .configure_mesh()
            .disable_mesh()
            .x_labels(9)
            .y_labels(9)
            .x_label_formatter(&format)
            .y_label_formatter(&format)
            .label_style((FONT, TEXT))
            .axis_desc_style((FONT, TEXT + 1))
            .x_desc(self.labels[0])
            .y_desc(self.labels[1])
            .draw()
            .map_err(drawing)?;
        let image = chart.plotting_area().get_pixel_range();
        let bar = Bar { label: self.bar, ends: self.shades, top: TOP, bottom: BOTTOM, right: MARGIN };
        Ok((image, bar.frame(&right)?))
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

/// Labels that tell the ticks of a range apart.
fn ticks((low, high): (f64, f64)) -> impl Fn(&f64) -> String {
    let digits = decimals(low, high);
    move |v: &f64| tick(*v, digits)
}
