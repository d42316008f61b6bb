//! Filters: where in and around a pixel its samples lie, and when in and around a frame.
//!
//! The light of a pixel is the picture as a function of the place, weighted with a filter. Samples that
//! are distributed *as the filter* need no weights: their plain mean is the light. So a filter is a map
//! from the unit square to places, and keeps what is even about the points that it is given
//! (`sequence`). Filters are B-splines ([`BSpline`]), which are never negative and sum to one over all
//! pixels; those of order 4 leave hardly any alias, and blur little.

use crate::num::{BSpline, Quantiles, Radial, cos_turns, sin_turns};
use thiserror::Error;

/// An order that no filter has.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Error)]
#[error("a filter of order {0} is not available: use 0 (none) to {max}; 4 is the best for most", max = BSpline::MAX_ORDER)]
pub struct OrderError(pub u32);

/// A filter in the plane of the picture, ready to place samples.
#[derive(Clone, Debug, Default)]
pub struct Filter {
    shape: Shape,
}

#[derive(Clone, Debug, Default)]
enum Shape {
    #[default]
    Centre,
    Separable(Quantiles),
    Isotropic(Radial),
}

impl Filter {
    /// The filter of an order: 0 for none, with all samples in the centres of pixels; 1 for the box, 2
    /// for the tent, 4 for the cubic spline. It is as many pixels wide.
    ///
    /// An isotropic filter is the same in all directions; otherwise it is the product of one across and
    /// one down.
    pub fn new(order: u32, isotropic: bool) -> Result<Filter, OrderError> {
        if order == 0 {
            return Ok(Filter { shape: Shape::Centre });
        }
        let spline = BSpline::new(order).ok_or(OrderError(order))?;
        let shape = match isotropic {
            true => Shape::Isotropic(Radial::new(spline)),
            false => Shape::Separable(Quantiles::new(spline)),
        };
        Ok(Filter { shape })
    }

    /// Where to put a sample: its offset from the pixel's centre, in pixels. Points `u` that are uniform
    /// in [0, 1)^2 give places that are distributed as the filter.
    #[inline]
    pub fn place(&self, u: [f64; 2]) -> [f64; 2] {
        match &self.shape {
            Shape::Centre => [0.0; 2],
            Shape::Separable(table) => u.map(|u| table.at(u) - 0.5 * f64::from(table.spline().order())),
            Shape::Isotropic(table) => {
                let distance = table.at(u[0]);
                [distance * cos_turns(u[1]), distance * sin_turns(u[1])]
            }
        }
    }

    /// The farthest that samples lie from the pixel's centre, across and down, in pixels.
    pub fn reach(&self) -> f64 {
        match &self.shape {
            Shape::Centre => 0.0,
            Shape::Separable(table) => 0.5 * f64::from(table.spline().order()),
            Shape::Isotropic(table) => 0.5 * f64::from(table.spline().order()),
        }
    }
}

/// A filter in time, ready to place samples.
#[derive(Clone, Debug)]
pub struct Shutter {
    motion: Motion,
}

#[derive(Clone, Debug)]
enum Motion {
    Open(f64),
    Spline(Quantiles),
}

impl Shutter {
    /// A camera's shutter, which opens at the time of the frame for a share of the time between
    /// frames: 0 for a moment, 1 for all of it. Other shares count as the nearer of these, NaN as 0.
    pub fn open(share: f64) -> Shutter {
        let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
        Shutter { motion: Motion::Open(share) }
    }

    /// A B-spline around the time of the frame, as many frames wide as its order says: smoother than any
    /// shutter, but it looks ahead. An order of 0 is a moment.
    pub fn spline(order: u32) -> Result<Shutter, OrderError> {
        if order == 0 {
            return Ok(Shutter::open(0.0));
        }
        let spline = BSpline::new(order).ok_or(OrderError(order))?;
        Ok(Shutter { motion: Motion::Spline(Quantiles::new(spline)) })
    }

    /// When to take a sample: its offset from the time of the frame, in frames. Numbers `u` that are
    /// uniform in [0, 1) give times that are distributed as the filter.
    #[inline]
    pub fn place(&self, u: f64) -> f64 {
        match &self.motion {
            Motion::Open(share) => share * u,
            Motion::Spline(table) => table.at(u) - 0.5 * f64::from(table.spline().order()),
        }
    }

    /// The earliest and the latest offset that samples may have, in frames.
    pub fn span(&self) -> [f64; 2] {
        match &self.motion {
            Motion::Open(share) => [0.0, *share],
            Motion::Spline(table) => [-0.5, 0.5].map(|side| side * f64::from(table.spline().order())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::mix;
    use crate::num::sequence::point;
    use std::f64::consts::PI;

    fn points(count: u32) -> impl Iterator<Item = [f64; 2]> {
        (0..count).map(|i| point(mix(5), i, 0))
    }

    #[test]
    fn orders_have_limits() {
        for order in [33, u32::MAX] {
            let error = Filter::new(order, false).unwrap_err();
            assert!(error.to_string().contains(&format!("{order}")) && error.to_string().contains("32"));
            assert!(Filter::new(order, true).is_err() && Shutter::spline(order).is_err());
        }
    }

    #[test]
    fn no_filter_is_the_centre_and_a_box_is_the_pixel() {
        let (none, pixel) = (Filter::new(0, true).unwrap(), Filter::new(1, false).unwrap());
        for u in points(100) {
            assert_eq!(none.place(u), [0.0, 0.0]);
            let at = pixel.place(u);
            assert!((0..2).all(|k| (at[k] + 0.5 - u[k]).abs() < 1e-14));
        }
        assert_eq!([none.reach(), pixel.reach()], [0.0, 0.5]);
    }

    #[test]
    fn places_are_distributed_as_the_filter() {
        for order in [1, 2, 3, 4, 7] {
            let spline = BSpline::new(order).unwrap();
            let filter = Filter::new(order, false).unwrap();
            let (count, half) = (1 << 14, 0.5 * f64::from(order));
            for share in [0.1, 0.3, 0.5, 0.8] {
                let edge = (share - 0.5) * 2.0 * half;
                for axis in 0..2 {
                    let below = points(count).filter(|u| filter.place(*u)[axis] < edge).count();
                    let known = spline.distribution(edge + half);
                    // One point in each of so many strata.
                    assert!((below as f64 / f64::from(count) - known).abs() < 2.0 / f64::from(count));
                }
            }
            assert!(points(count).all(|u| filter.place(u).iter().all(|x| x.abs() <= filter.reach())));
            // Sums of uniform numbers have a variance of 1/12 for each.
            let square: f64 = points(count).map(|u| filter.place(u)[0] * filter.place(u)[0]).sum();
            assert!((square / f64::from(count) - f64::from(order) / 12.0).abs() < 1e-3, "{order}");
        }
    }

    #[test]
    fn isotropic_places_prefer_no_direction() {
        let filter = Filter::new(4, true).unwrap();
        let count = 1 << 14;
        for turn in 0..8 {
            let angle = f64::from(turn) * PI / 8.0;
            let (cos, sin) = (libm::cos(angle), libm::sin(angle));
            let along = |u| {
                let [x, y] = filter.place(u);
                (cos * x + sin * y) * (cos * x + sin * y)
            };
            let square = points(count).map(along).sum::<f64>() / f64::from(count);
            // Half of the mean square of the distance: int t^3 n / (2 int t n) = (31/210) / (7/15).
            assert!((square - 31.0 / 98.0).abs() < 2e-3, "{turn}: {square}");
        }
        assert!(points(count).all(|u| libm::hypot(filter.place(u)[0], filter.place(u)[1]) <= filter.reach()));
    }

    #[test]
    fn shutters_place_samples_in_their_span() {
        let third = Shutter::open(1.0 / 3.0);
        assert_eq!([third.place(0.0), third.place(0.5)], [0.0, 0.5 / 3.0]);
        assert_eq!(third.span(), [0.0, 1.0 / 3.0]);
        for (odd, kept) in [(f64::NAN, 0.0), (-1.0, 0.0), (7.0, 1.0)] {
            assert_eq!(Shutter::open(odd).span(), [0.0, kept]);
        }
        let cubic = Shutter::spline(4).unwrap();
        assert_eq!(cubic.span(), [-2.0, 2.0]);
        assert_eq!(cubic.place(0.0), -2.0);
        assert!(cubic.place(0.5).abs() < 1e-12);
        assert!((cubic.place(1.0 / 24.0) + 1.0).abs() < 1e-8);
        assert_eq!(Shutter::spline(0).unwrap().place(0.7), 0.0);
    }
}
