//! Curves over a common axis.

use super::{FONT, Figure, PlotError, TEXT, TITLE, decimals, drawing, font, tick};
use plotters::coord::Shift;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::prelude::*;
use std::ops::Range;

/// An axis: what it measures, from where to where.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Name and unit.
    pub label: String,
    /// Ends.
    pub range: (f64, f64),
    /// Whether equal steps are equal factors.
    pub logarithmic: bool,
}

/// A line through points.
#[derive(Clone, Debug)]
pub struct Line {
    /// What it is, for the legend; empty for no entry.
    pub label: String,
    /// Its points; what is not a finite number is a gap.
    pub points: Vec<(f64, f64)>,
    /// Whether it is there for comparison only: thin and grey.
    pub guide: bool,
}

/// A figure of curves.
#[derive(Clone, Debug)]
pub struct Curves {
    /// What is shown.
    pub title: String,
    /// To the right.
    pub x: Axis,
    /// Upwards.
    pub y: Axis,
    /// The curves, the first drawn first.
    pub lines: Vec<Line>,
}

/// The drawing library draws thick lines with jagged edges, so everything is drawn so many times as large, and made
/// small again.
const FINER: u32 = 3;
/// Sizes of letters there.
const LETTERS: [i32; 3] = [FINER as i32 * TITLE, FINER as i32 * TEXT, FINER as i32 * (TEXT + 1)];

/// What is drawn on.
type Area<'a> = DrawingArea<BitMapBackend<'a>, Shift>;

/// Colours of curves: dark enough on white, the first four told apart by people who see no red or green.
const COLORS: [RGBColor; 8] = [
    RGBColor(0, 90, 160),
    RGBColor(200, 85, 0),
    RGBColor(0, 130, 95),
    RGBColor(150, 60, 130),
    RGBColor(70, 175, 215),
    RGBColor(190, 30, 50),
    RGBColor(130, 120, 0),
    RGBColor(95, 60, 25),
];
const GUIDE: RGBColor = RGBColor(120, 120, 120);

/// An axis as the drawing library wants it. Its own logarithmic axis leaves out most ticks.
struct Scale {
    range: (f64, f64),
    logarithmic: bool,
}

impl Scale {
    fn place(&self, v: f64) -> f64 {
        let of = |v: f64| if self.logarithmic { libm::log10(v) } else { v };
        (of(v) - of(self.range.0)) / (of(self.range.1) - of(self.range.0))
    }
}

impl Ranged for Scale {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        limit.0 + (self.place(*value) * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        let (low, high) = self.range;
        if !self.logarithmic {
            return plotters::coord::types::RangedCoordf64::from(low..high).key_points(hint);
        }
        let decade = |v: f64| libm::floor(libm::log10(v)) as i32;
        let all = (decade(low)..=decade(high))
            .flat_map(|e| [1.0, 2.0, 5.0].map(|m| m * libm::pow(10.0, f64::from(e))));
        all.filter(|v| (low..=high).contains(v)).collect()
    }

    fn range(&self) -> Range<f64> {
        self.range.0..self.range.1
    }
}

impl Curves {
    /// Draws it, four wide to three high.
    ///
    /// # Errors
    /// [`PlotError`]
    pub fn draw(&self, width: u32) -> Result<Figure, PlotError> {
        font()?;
        let (width, height) = (FINER * width, FINER * (width * 3 / 4));
        let mut figure = Figure::blank(width, height);
        let backend = BitMapBackend::with_buffer(&mut figure.rgb, (width, height));
        let root = backend.into_drawing_area();
        self.draw_on(&root)?;
        root.present().map_err(drawing)?;
        drop(root);
        Ok(figure.coarser(FINER))
    }

    fn draw_on(&self, root: &Area<'_>) -> Result<(), PlotError> {
        root.fill(&WHITE).map_err(drawing)?;
        let scale = |axis: &Axis| Scale { range: axis.range, logarithmic: axis.logarithmic };
        let [title, text, label] = LETTERS;
        let mut chart = ChartBuilder::on(root)
            .caption(&self.title, (FONT, title))
            .margin(FINER * 10)
            .margin_right(FINER * 18)
            .x_label_area_size(FINER * 42)
            .y_label_area_size(FINER * 62)
            .build_cartesian_2d(scale(&self.x), scale(&self.y))
            .map_err(drawing)?;
        let format = |axis: &Axis| {
            let digits = decimals(axis.range.0, axis.range.1);
            let logarithmic = axis.logarithmic;
            move |v: &f64| if logarithmic { format!("{v}") } else { tick(*v, digits) }
        };
        let (x_format, y_format) = (format(&self.x), format(&self.y));
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12).stroke_width(FINER))
            .axis_style(BLACK.stroke_width(FINER))
            .set_all_tick_mark_size(FINER * 5)
            .x_desc(&self.x.label)
            .y_desc(&self.y.label)
            .x_labels(12)
            .y_labels(9)
            .x_label_formatter(&x_format)
            .y_label_formatter(&y_format)
            .label_style((FONT, text))
            .axis_desc_style((FONT, label))
            .draw()
            .map_err(drawing)?;
        let mut colors = COLORS.iter().cycle();
        for line in &self.lines {
            let style = match (line.guide, colors.next()) {
                (false, Some(color)) => color.stroke_width(2 * FINER),
                _ => GUIDE.stroke_width(FINER),
            };
            for piece in self.visible(line) {
                chart.draw_series(LineSeries::new(piece, style)).map_err(drawing)?;
            }
            if !line.label.is_empty() {
                let length = 18 * FINER as i32;
                let entry = LineSeries::new(std::iter::empty::<(f64, f64)>(), style);
                let entry = chart.draw_series(entry).map_err(drawing)?;
                entry
                    .label(&line.label)
                    .legend(move |(x, y)| PathElement::new([(x, y), (x + length, y)], style));
            }
        }
        if self.lines.iter().any(|l| !l.label.is_empty()) {
            chart
                .configure_series_labels()
                .position(self.legend())
                .label_font((FONT, text))
                .legend_area_size(FINER * 26)
                .margin(FINER * 5)
                .background_style(WHITE.mix(0.85))
                .border_style(BLACK.mix(0.2).stroke_width(FINER))
                .draw()
                .map_err(drawing)?;
        }
        Ok(())
    }

    /// The corner at the right that the first line leaves free.
    fn legend(&self) -> SeriesLabelPosition {
        let middle = 0.5 * (self.x.range.0 + self.x.range.1);
        let right = self.lines.iter().take(1).flat_map(|l| &l.points).filter(|p| p.0 > middle);
        let (sum, count) = right.fold((0.0, 0.0), |(s, n), p| (s + p.1, n + 1.0));
        let high = sum / f64::max(count, 1.0) > 0.5 * (self.y.range.0 + self.y.range.1);
        if high { SeriesLabelPosition::LowerRight } else { SeriesLabelPosition::UpperRight }
    }

    /// The pieces of a line between its gaps, kept on the paper: what falls below runs along the lower edge.
    fn visible(&self, line: &Line) -> Vec<Vec<(f64, f64)>> {
        let (x, y) = (self.x.range, self.y.range);
        let seen: Vec<(f64, f64)> =
            line.points.iter().filter(|p| (x.0..=x.1).contains(&p.0)).copied().collect();
        let pieces = seen.split(|p| !p.1.is_finite()).filter(|piece| !piece.is_empty());
        pieces.map(|piece| piece.iter().map(|p| (p.0, p.1.clamp(y.0, y.1))).collect()).collect()
    }
}
