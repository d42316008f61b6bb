//! The bar beside a picture of numbers, which says which shade is which number.

use super::{Area, FONT, Frame, PlotError, TEXT, decimals, drawing, tick};
use plotters::prelude::*;

/// Room in front of the bar and for its labels.
const GAP: u32 = 14;
const LABELS: u32 = 60;

/// A bar that fills an area but for these margins above and below.
pub(super) struct Bar<'a> {
    /// What the numbers are.
    pub label: &'a str,
    /// The numbers at the bottom and at the top.
    pub ends: (f64, f64),
    pub top: u32,
    pub bottom: u32,
    pub right: u32,
}

impl Bar<'_> {
    /// Draws everything but the shades; says where they belong.
    pub(super) fn frame(&self, area: &Area<'_>) -> Result<Frame, PlotError> {
        let mut chart = ChartBuilder::on(area)
            .margin_top(self.top)
            .margin_bottom(self.bottom)
            .margin_left(GAP)
            .margin_right(self.right)
            .set_label_area_size(LabelAreaPosition::Right, LABELS)
            .build_cartesian_2d(0.0..1.0, self.ends.0..self.ends.1)
            .map_err(drawing)?;
        let digits = decimals(self.ends.0, self.ends.1);
        // Apart from the tick in front of it, which would look like a minus sign.
        let format = |v: &f64| format!("  {}", tick(*v, digits));
        chart
            .configure_mesh()
            .disable_mesh()
            .disable_x_axis()
            .y_labels(9)
            .y_label_formatter(&format)
            .label_style((FONT, TEXT))
            .axis_desc_style((FONT, TEXT + 1))
            .y_desc(self.label)
            .draw()
            .map_err(drawing)?;
        Ok(chart.plotting_area().get_pixel_range())
    }
}

/// The pixels of a bar, each with its share of the way up.
pub(super) fn pixels((across, down): Frame) -> impl Iterator<Item = (i32, i32, f64)> {
    let last = f64::from(down.end - down.start - 1).max(1.0);
    let bottom = down.end - 1;
    down.flat_map(move |y| across.clone().map(move |x| (x, y, f64::from(bottom - y) / last)))
}
