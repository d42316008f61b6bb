//! Heat maps: pictures of what every pixel cost.

use super::Picture;
use crate::analysis::plot::{Figure, Heat, PlotError};
use crate::num::oklab;
use std::f64::consts::PI;

/// Share of the pixels that the colours tell apart. A few that graze the surface cost many times what
/// the others do, and would make these all alike.
const TOLD_APART: f64 = 0.995;

/// What the pixels of a picture cost.
#[derive(Clone, Debug)]
pub struct Heatmap {
    /// Field evaluations for each pixel, row by row.
    costs: Vec<f64>,
    width: u32,
}

impl Heatmap {
    /// Field evaluations that the rays of each pixel needed.
    pub fn of(picture: &Picture) -> Heatmap {
        let costs = picture.pixels.iter().map(|p| f64::from(p.evaluations)).collect();
        Heatmap { costs, width: picture.window.width }
    }

    /// The mean of all pixels.
    pub fn mean(&self) -> f64 {
        self.costs.iter().sum::<f64>() / self.costs.len().max(1) as f64
    }

    /// The largest of all pixels.
    pub fn most(&self) -> f64 {
        self.costs.iter().copied().fold(0.0, f64::max)
    }

    /// The number that no more than the most expensive pixels reach, at least 1.
    fn top(&self) -> f64 {
        let mut sorted = self.costs.clone();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().saturating_sub(1) as f64;
        sorted.get((TOLD_APART * last) as usize).map_or(1.0, |c| c.max(1.0))
    }

    /// The heat map as a figure: dark where pixels are cheap, with a scale.
    ///
    /// # Errors
    /// [`PlotError`]
    pub fn draw(&self) -> Result<Figure, PlotError> {
        let title = format!("field evaluations: {:.1} a pixel, {:.0} at most", self.mean(), self.most());
        let (ends, bar) = ((0.0, self.top()), "field evaluations");
        Heat { title, width: self.width, data: &self.costs, ends, bar, color }.draw()
    }
}

/// The colour at a share of the way from cheap to expensive: equal steps look equally large.
pub(super) fn color(share: f64) -> [u8; 3] {
    oklab::bytes(linear(share))
}

/// The same as linear red, green and blue. Lightness rises evenly while the hue turns from violet through red to
/// yellow, as strong as screens can show.
fn linear(share: f64) -> [f64; 3] {
    oklab::linear(0.2 + 0.75 * share, 0.11 + 0.05 * libm::sin(PI * share), -70.0 + 178.0 * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn screens_can_show_all_colours_and_brightness_rises() {
        let mut before = -1.0;
        for i in 0..=200 {
            let color = linear(f64::from(i) / 200.0);
            assert!(color.iter().all(|c| (0.0..=1.0).contains(c)), "{i}: {color:?}");
            let [r, g, b] = color;
            let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
            assert!(luminance > before, "{i}");
            before = luminance;
        }
    }

    #[test]
    fn a_few_expensive_pixels_do_not_hide_the_others() {
        let mut costs = vec![10.0; 1000];
        costs[17] = 1e6;
        let map = Heatmap { costs, width: 40 };
        assert_eq!((map.top(), map.most()), (10.0, 1e6));
        assert_eq!(map.mean(), (9990.0 + 1e6) / 1000.0);
        let figure = map.draw().unwrap();
        assert!(figure.width > 40 && figure.height > 25);
        assert_eq!(Heatmap { costs: vec![0.0; 4], width: 2 }.top(), 1.0);
    }
}
