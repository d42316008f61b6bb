//! Inverses of distributions from a table, fast and alike for all orders.
//!
//! The inverse `x(y)` of a distribution that starts as `y ~ x^m` has a root in its end, where its
//! derivatives grow without bound: evenly spaced nodes with linear interpolation, 257 of them, are off by
//! a quarter of a pixel there for the cubic spline. But `y^k x^(k)(y)` stays as small as `x` itself. So
//! nodes are spaced in proportion to `y`: each octave of `y` has as many cells of equal width, as the
//! exponent and the first bits of the fraction of a floating point number count them. In a cell of the
//! width `h = y / 32` a cubic polynomial that agrees with value and slope in both ends is off by at most
//!
//! ```text
//! h^4 / 384 max |x''''| = (1/32)^4 / 384 (1/m) (1 - 1/m) (2 - 1/m) (3 - 1/m) x < 3e-9 x
//! ```
//!
//! for `x = c y^(1/m)`, and that needs neither the distribution nor Newton's method: the cost of a sample
//! is that of a cubic polynomial. The error over all orders is measured by a test.

use super::BSpline;

/// Bits of the fraction that tell the cells of an octave apart: 32 cells each.
const CELL_BITS: u32 = 5;

/// Bits of a fraction within a cell.
const REST_BITS: u32 = f64::MANTISSA_DIGITS - 1 - CELL_BITS;

/// The least `y` of a table, 2^-53: random numbers of 53 bits are this or zero, if not more.
pub(super) const LEAST: f64 = f64::EPSILON / 2.0;

/// The inverse of a distribution up to its median, cell by cell.
#[derive(Clone, Debug)]
pub(super) struct Graded {
    /// Coefficients of the polynomial of the position in [0, 1) within a cell.
    cells: Vec<[f64; 4]>,
}

impl Graded {
    /// A table of a function, which gives `x` and its derivative by `y` for `y` from [`LEAST`] to a
    /// little above 1/2, asked in falling order.
    pub(super) fn new(mut inverse: impl FnMut(f64) -> [f64; 2]) -> Graded {
        let count = index(0.5) + 1;
        let mut end = inverse(start(count));
        let mut cells: Vec<[f64; 4]> = (0..count)
            .rev()
            .map(|i| {
                let width = start(i + 1) - start(i);
                let from = inverse(start(i));
                let cell = hermite(from[0], width * from[1], end[0], width * end[1]);
                end = from;
                cell
            })
            .collect();
        cells.reverse();
        Graded { cells }
    }

    /// `x` at `y` from [`LEAST`] to 1/2; what is outside counts as the nearer of them.
    #[inline]
    pub(super) fn at(&self, y: f64) -> f64 {
        let y = y.clamp(LEAST, 0.5);
        let [c0, c1, c2, c3] = self.cells[index(y)];
        // The bits within the cell, as the fraction of a number in [1, 2).
        let rest = y.to_bits() << (CELL_BITS + 12) >> 12;
        let t = f64::from_bits(1.0_f64.to_bits() | rest) - 1.0;
        c0 + t * (c1 + t * (c2 + t * c3))
    }
}

/// The cell that `y` is in, counted from [`LEAST`].
#[inline]
fn index(y: f64) -> usize {
    ((y.to_bits() - LEAST.to_bits()) >> REST_BITS) as usize
}

/// The lower end of a cell.
fn start(index: usize) -> f64 {
    f64::from_bits(LEAST.to_bits() + ((index as u64) << REST_BITS))
}

/// Coefficients of the cubic polynomial with the given values and slopes at 0 and 1.
fn hermite(from: f64, slope_from: f64, to: f64, slope_to: f64) -> [f64; 4] {
    let rise = to - from;
    [from, slope_from, 3.0 * rise - 2.0 * slope_from - slope_to, slope_from + slope_to - 2.0 * rise]
}

/// The quantiles of a B-spline from a table, the same for every order in speed.
#[derive(Clone, Debug)]
pub struct Quantiles {
    spline: BSpline,
    left: Graded,
}

impl Quantiles {
    /// The table of a B-spline, which takes some 50 kB, and from 0.05 to 20 ms to make, as the order has it.
    pub fn new(spline: BSpline) -> Quantiles {
        let mut x = 0.5 * f64::from(spline.order());
        let left = Graded::new(|y| {
            x = if y < 0.5 { spline.lower_quantile_from(y, x) } else { spline.quantile(y) };
            let slope = 1.0 / spline.density(x);
            let found = [x, slope];
            // Rounding must not put the start of the next search before its end.
            x = (x * (1.0 + 1e-9)).min(0.5 * f64::from(spline.order()));
            found
        });
        Quantiles { spline, left }
    }

    /// The B-spline that they are of.
    pub fn spline(&self) -> BSpline {
        self.spline
    }

    /// Where the distribution is `y`, for `y` from 0 to 1, with an error below 2e-8.
    #[inline]
    pub fn at(&self, y: f64) -> f64 {
        let width = f64::from(self.spline.order());
        let end = y.min(1.0 - y);
        if end < LEAST {
            return self.spline.quantile(y);
        }
        let left = self.left.at(end);
        if y > 0.5 { width - left } else { left }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::{mix, uniform};

    #[test]
    fn tables_of_all_orders_are_as_exact_as_stated() {
        let mut worst = 0.0_f64;
        for order in 1..=BSpline::MAX_ORDER {
            let spline = BSpline::new(order).unwrap();
            let table = Quantiles::new(spline);
            for i in 0..2000 {
                let u = uniform(mix(i));
                // Evenly, and evenly over the octaves of either end.
                let small = libm::exp2(-60.0 * u);
                for y in [u, small, 1.0 - small] {
                    let (fast, exact) = (table.at(y), spline.quantile(y));
                    worst = worst.max((fast - exact).abs());
                    assert!((0.0..=f64::from(order)).contains(&fast), "{order} {y}: {fast}");
                }
            }
            for y in [0.0, 0.5, 1.0] {
                assert!((table.at(y) - spline.quantile(y)).abs() < 1e-12, "{order} {y}");
            }
        }
        assert!(worst < 2e-8, "{worst:e}");
        assert!(worst > 1e-12, "the reference is no better than what it checks: {worst:e}");
    }

    #[test]
    fn quantiles_rise() {
        for order in [1, 2, 3, 4, 5, 20] {
            let table = Quantiles::new(BSpline::new(order).unwrap());
            let mut before = 0.0;
            for i in 0..=100_000 {
                let x = table.at(f64::from(i) / 100_000.0);
                assert!(x >= before, "{order} {i}");
                before = x;
            }
        }
    }

    #[test]
    fn even_cells_would_not_do() {
        let spline = BSpline::new(4).unwrap();
        let (mut inner, mut end) = (0.0_f64, 0.0_f64);
        for i in 0..256 * 64 {
            let y = (f64::from(i) + 0.5) / (256.0 * 64.0);
            let from = (y * 256.0).floor();
            let [a, b] = [from, from + 1.0].map(|node| spline.quantile(node / 256.0));
            let off = (a + (y * 256.0 - from) * (b - a) - spline.quantile(y)).abs();
            let to = if (1.0 / 24.0..23.0 / 24.0).contains(&y) { &mut inner } else { &mut end };
            *to = to.max(off);
        }
        assert!((inner - 1.9e-4).abs() < 0.2e-4 && (end - 0.26).abs() < 0.02, "{inner} {end}");
    }
}
