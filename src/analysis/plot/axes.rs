//! The axes of a picture of numbers, with a title above it and a bar on its right.

use super::bar::Bar;
use super::{FONT, Figure, Frame, PlotError, TEXT, TITLE, decimals, drawing, font, tick};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Room around the picture: for labels on its left, the title, labels below.
pub(super) const LEFT: u32 = 62;
pub(super) const TOP: u32 = 34;
pub(super) const BOTTOM: u32 = 46;
/// White margin outside of all labels.
const MARGIN: u32 = 8;

/// All of a figure but its picture.
pub(super) struct Axes<'a> {
    pub title: &'a str,
    /// The column of the title's middle.
    pub middle: u32,
    /// Names of the axes, to the right and upwards.
    pub labels: [&'a str; 2],
    /// Their ends: the outer edges of the first and the last pixel.
    pub ends: [(f64, f64); 2],
    /// Most of their ticks.
    pub ticks: [usize; 2],
    /// Width and height of the picture, and the room on its right, for the bar.
    pub size: (u32, u32),
    pub right: u32,
    /// What the numbers are, and those at the ends of the bar.
    pub bar: (&'a str, (f64, f64)),
}

impl Axes<'_> {
    /// Draws them; says where the pixels of the picture belong, and those of the bar.
    pub(super) fn draw(&self) -> Result<(Figure, Frame, Frame), PlotError> {
        font()?;
        let (width, height) = (LEFT + self.size.0 + self.right, TOP + self.size.1 + BOTTOM);
        let mut figure = Figure::blank(width, height);
        let backend = BitMapBackend::with_buffer(&mut figure.rgb, (width, height));
        let root = backend.into_drawing_area();
        root.fill(&WHITE).map_err(drawing)?;
        let centred = Pos::new(HPos::Center, VPos::Center);
        let style = TextStyle::from((FONT, TITLE).into_font()).pos(centred);
        let place = (self.middle as i32, TOP as i32 / 2);
        root.draw(&Text::new(self.title, place, style)).map_err(drawing)?;
        let (left, right) = root.split_horizontally(LEFT + self.size.0);
        let [x, y] = self.ends;
        let mut chart = ChartBuilder::on(&left)
            .margin_top(TOP)
            .margin_bottom(MARGIN)
            .x_label_area_size(BOTTOM - MARGIN)
            .margin_left(MARGIN)
            .y_label_area_size(LEFT - MARGIN)
            .build_cartesian_2d(x.0..x.1, y.0..y.1)
            .map_err(drawing)?;
        let [x_format, y_format] = self.ends.map(|(low, high)| {
            let digits = decimals(low, high);
            move |v: &f64| tick(*v, digits)
        });
        chart
            .configure_mesh()
            .disable_mesh()
            .x_labels(self.ticks[0])
            .y_labels(self.ticks[1])
            .x_label_formatter(&x_format)
            .y_label_formatter(&y_format)
            .label_style((FONT, TEXT))
            .axis_desc_style((FONT, TEXT + 1))
            .x_desc(self.labels[0])
            .y_desc(self.labels[1])
            .draw()
            .map_err(drawing)?;
        let image = chart.plotting_area().get_pixel_range();
        let (label, ends) = self.bar;
        let bar = Bar { label, ends, top: TOP, bottom: BOTTOM, right: MARGIN }.frame(&right)?;
        root.present().map_err(drawing)?;
        drop((chart, left, right, root));
        Ok((figure, image, bar))
    }
}
