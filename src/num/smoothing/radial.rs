//! The B-spline turned about its centre: a filter that is the same in all directions.
//!
//! The density at the distance `l` from the centre is `n_m(l + m/2)`, divided by its integral over the
//! plane. Up to the distance `l` lies the share `P(l)`, and beyond it
//!
//! ```text
//! 1 - P(l) = (l N_m(m/2 - l) + W(m/2 - l)) / W(m/2)         W(x) = int_0^x N_m = sum_k N_(m+1)(x - k)
//! ```
//!
//! by integration of `t n_m(t + m/2)` by parts; and `W` is a sum because `N_m` is one of differences:
//! `n_(m+1)(x) = N_m(x) - N_m(x - 1)`. The integral over the plane is `2 pi W(m/2)`, which for the cubic
//! spline is `7 pi / 15`. No quadrature is needed, for no order.
//!
//! The distance of a sample is the inverse of `P`, from a table for either half; its angle is uniform.

use super::BSpline;
use super::table::{Graded, LEAST};

/// Below this share around the centre the density is constant as far as anyone can tell, and the formula
/// above would subtract equals.
const FLAT: f64 = 1e-8;

/// The search for a distance ends with a step that is shorter than this, in knots; its error is of the
/// order of the square.
const TOLERANCE: f64 = 1e-9;

/// The distances from the centre of samples of the turned B-spline.
#[derive(Clone, Debug)]
pub struct Radial {
    spline: BSpline,
    inner: Graded,
    outer: Graded,
}

impl Radial {
    /// The table of a B-spline, which takes some 100 kB and from 0.2 ms to 0.3 s to make, as the order
    /// has it: less than 1 ms for the cubic spline.
    pub fn new(spline: BSpline) -> Radial {
        let profile = Profile::new(spline);
        let mut distance = 0.5 * profile.half_width;
        let inner = Graded::new(|share| {
            distance = profile.containing(share, distance);
            [distance, 1.0 / profile.density(distance)]
        });
        let outer = Graded::new(|share| {
            distance = profile.leaving(share, distance);
            [distance, -1.0 / profile.density(distance)]
        });
        Radial { spline, inner, outer }
    }

    /// The B-spline that is turned.
    pub fn spline(&self) -> BSpline {
        self.spline
    }

    /// The distance within which the share `y` of all samples lies, for `y` from 0 to 1. It is at most
    /// half the order, and its error is below 1e-7.
    #[inline]
    pub fn at(&self, y: f64) -> f64 {
        if y < LEAST {
            return 0.0;
        }
        // The next number below 1 leaves LEAST.
        match 1.0 - y {
            left if left >= 0.5 => self.inner.at(y),
            left if left >= LEAST => self.outer.at(left),
            _ => self.half_width(),
        }
    }

    fn half_width(&self) -> f64 {
        0.5 * f64::from(self.spline.order())
    }
}

/// The distribution of the distance from the centre, exactly.
struct Profile {
    spline: BSpline,
    half_width: f64,
    /// `W(m/2)`: the integral over the plane, divided by `2 pi`.
    total: f64,
}

impl Profile {
    fn new(spline: BSpline) -> Profile {
        let half_width = 0.5 * f64::from(spline.order());
        Profile { spline, half_width, total: spline.integral(half_width) }
    }

    /// The density of the distance.
    fn density(&self, distance: f64) -> f64 {
        distance * self.spline.density(self.half_width - distance) / self.total
    }

    /// The share of samples that lie farther away.
    fn beyond(&self, distance: f64) -> f64 {
        let x = self.half_width - distance;
        (distance * self.spline.distribution(x) + self.spline.integral(x)) / self.total
    }

    /// The distance within which a share from [`LEAST`] to about 1/2 lies, sought from a place near it.
    fn containing(&self, share: f64, near: f64) -> f64 {
        if share < FLAT {
            return (2.0 * share * self.total / self.spline.density(self.half_width)).sqrt();
        }
        self.leaving(1.0 - share, near)
    }

    /// The distance beyond which a share lies: Newton's method from a place near it, kept inside of a
    /// shrinking bracket.
    fn leaving(&self, share: f64, near: f64) -> f64 {
        let (mut low, mut high) = (0.0, self.half_width);
        let mut distance = near;
        while high - low > TOLERANCE {
            let excess = self.beyond(distance) - share;
            if excess > 0.0 {
                low = distance;
            } else {
                high = distance;
            }
            let next = distance + excess / self.density(distance);
            if (next - distance).abs() < TOLERANCE {
                return next;
            }
            let inside = next > low && next < high;
            distance = if inside { next } else { 0.5 * (low + high) };
        }
        distance
    }
}

impl BSpline {
    /// `int_0^x N`: the sum of the distribution of the next order, which may be one too high for others,
    /// over all knots below.
    fn integral(self, x: f64) -> f64 {
        let next = BSpline { order: self.order + 1 };
        let knots = x.max(0.0).ceil() as u32;
        (0..knots).map(|k| next.distribution(x - f64::from(k))).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::{mix, uniform};
    use std::f64::consts::PI;

    /// The share within a distance for the cubic spline.
    fn cubic(l: f64) -> f64 {
        let rest = 2.0 - l;
        let scale = 30.0 / 7.0;
        if l <= 1.0 {
            scale * l * l * (1.0 / 3.0 + l * l * (l / 10.0 - 0.25))
        } else {
            let fourth = rest * rest * rest * rest;
            1.0 - scale * (fourth / 12.0 - fourth * rest / 30.0)
        }
    }

    #[test]
    fn the_cubic_spline_has_its_closed_form() {
        let spline = BSpline::new(4).unwrap();
        let (profile, radial) = (Profile::new(spline), Radial::new(spline));
        assert!((2.0 * PI * profile.total - 7.0 * PI / 15.0).abs() < 1e-15);
        assert!((profile.beyond(1.0) - 3.0 / 14.0).abs() < 1e-15);
        assert!((radial.at(11.0 / 14.0) - 1.0).abs() < 1e-8);
        for i in 0..=200 {
            let l = f64::from(i) / 100.0;
            assert!((1.0 - profile.beyond(l) - cubic(l)).abs() < 1e-14, "{l}");
            assert!((radial.at(cubic(l)) - l).abs() < 2e-8 + 1e-8 * l, "{l}: {}", radial.at(cubic(l)));
        }
    }

    #[test]
    fn shares_are_integrals_of_the_density() {
        for order in 1..=BSpline::MAX_ORDER {
            let profile = Profile::new(BSpline::new(order).unwrap());
            let (steps, mut share) = (4000, 0.0);
            for i in 0..steps {
                let width = profile.half_width / f64::from(steps);
                assert!((1.0 - profile.beyond(f64::from(i) * width) - share).abs() < 1e-6, "{order} {i}");
                share += width * profile.density((f64::from(i) + 0.5) * width);
            }
            assert!((share - 1.0).abs() < 1e-6, "{order}: {share}");
        }
    }

    #[test]
    fn tables_invert_the_distribution() {
        let mut worst = 0.0_f64;
        for order in [1, 2, 3, 4, 5, 6, 7, 9, 15, 32] {
            let spline = BSpline::new(order).unwrap();
            let (profile, radial) = (Profile::new(spline), Radial::new(spline));
            for i in 0..3000 {
                let u = uniform(mix(i));
                let small = libm::exp2(-53.0 * u);
                for y in [u, small, 1.0 - small] {
                    let from = 0.5 * profile.half_width;
                    let exact =
                        if y < 0.5 { profile.containing(y, from) } else { profile.leaving(1.0 - y, from) };
                    worst = worst.max((radial.at(y) - exact).abs());
                }
            }
            assert_eq!([radial.at(0.0), radial.at(1.0)], [0.0, profile.half_width]);
        }
        assert!(worst < 1e-7, "{worst:e}");
        assert!(worst > 1e-12, "the reference is no better than what it checks: {worst:e}");
    }

    #[test]
    fn moments_are_those_of_the_density() {
        for order in [1, 3, 4, 8] {
            let spline = BSpline::new(order).unwrap();
            let (profile, radial) = (Profile::new(spline), Radial::new(spline));
            let count = 20_000;
            for power in [1, 2, 4] {
                let raised = |l: f64| (0..power).fold(1.0, |product, _| product * l);
                let (mut sampled, mut integrated) = (0.0, 0.0);
                for i in 0..count {
                    let y = (f64::from(i) + 0.5) / f64::from(count);
                    let l = y * profile.half_width;
                    sampled += raised(radial.at(y)) / f64::from(count);
                    integrated += raised(l) * profile.density(l) * profile.half_width / f64::from(count);
                }
                assert!((sampled / integrated - 1.0).abs() < 1e-4, "{order} {power}: {sampled} {integrated}");
            }
        }
    }
}
