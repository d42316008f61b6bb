//! Lines and dots over a picture, as seen by its camera.

use super::{Picture, View};
use glam::{DVec2, DVec3};

/// What is drawn over a picture.
#[derive(Clone, Debug, Default)]
pub struct Overlay {
    /// Lines through points, with a colour (linear red, green, blue) and a width, in thousandths of the picture's
    /// height.
    pub lines: Vec<(Vec<DVec3>, [f32; 3], f64)>,
    /// Points, with a colour and a diameter in the same unit.
    pub dots: Vec<(DVec3, [f32; 3], f64)>,
}

impl Overlay {
    /// Draws everything, the farthest first, fainter the farther it is. The picture must be one that the
    /// view sees.
    pub fn draw(&self, picture: &mut Picture, view: &View) {
        let segments = self.lines.iter().flat_map(|(points, color, width)| {
            points.windows(2).map(move |pair| ([pair[0], pair[1]], *color, *width))
        });
        let dots = self.dots.iter().map(|(p, color, size)| ([*p, *p], *color, *size));
        let mut marks: Vec<_> = segments.chain(dots).collect();
        let far = |mark: &([DVec3; 2], [f32; 3], f64)| view.depth(0.5 * (mark.0[0] + mark.0[1]));
        marks.sort_by(|a, b| far(b).total_cmp(&far(a)));
        let (Some(last), Some(first)) = (marks.first().map(far), marks.last().map(far)) else { return };
        for mark in &marks {
            let nearness = (last - far(mark)) / (last - first).max(1e-300);
            if let Some(ends) = view.project_line(mark.0) {
                let width = 1e-3 * f64::from(picture.height) * mark.2;
                stroke(picture, ends.map(DVec2::from_array), mark.1, width, 0.25 + 0.75 * nearness);
            }
        }
    }
}

/// Draws a line with round ends, smooth at its edges.
fn stroke(picture: &mut Picture, [a, b]: [DVec2; 2], color: [f32; 3], width: f64, opacity: f64) {
    let reach = 0.5 * width + 1.0;
    let (size, bright) = ([picture.width, picture.height], libm::exp2(-picture.exposure) as f32);
    let span = |low: f64, high: f64, size: u32| {
        let clamped = |x: f64| x.clamp(0.0, f64::from(size)) as u32;
        clamped((low - reach).floor())..clamped((high + reach).ceil())
    };
    let (low, high) = (a.min(b), a.max(b));
    for y in span(low.y, high.y, size[1]) {
        for x in span(low.x, high.x, size[0]) {
            let p = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let along = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            let along = if along.is_nan() { 0.0 } else { along };
            let off = p.distance(a + along * (b - a));
            let cover = (opacity * (0.5 * width + 0.5 - off).clamp(0.0, 1.0)) as f32;
            let pixel = &mut picture.pixels[(y * size[0] + x) as usize];
            for (channel, ink) in pixel.color.iter_mut().zip(color) {
                *channel += cover * (bright * ink - *channel);
            }
            pixel.alpha += cover * (1.0 - pixel.alpha);
        }
    }
}
