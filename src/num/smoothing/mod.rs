//! B-splines as densities: how far from the centre of a pixel, or of a moment, a sample should lie.
//!
//! The B-spline of order `m` is the density of the sum of `m` independent numbers that are uniform in
//! `[0, 1)`. Order 1 is the box, 2 the tent, 4 the cubic spline; the order is one more than the degree.
//! It is positive on `(0, m)` and zero elsewhere, symmetric about `m / 2`, and has the spectrum
//! `|sin(pi k) / (pi k)|^m`, which is what makes it a good low-pass filter: with an order of 4 the
//! largest side lobe is 0.2% high.
//!
//! Never negative and of integral 1, it can be sampled instead of weighted: points
//! `x = N^-1(y)`, with `y` spread evenly over `[0, 1)` and the distribution `N`, are distributed as the
//! filter, and their plain mean is the filtered value.
//!
//! ```text
//! n_1(x) = 1 on [0, 1)                          N_1(x) = x on [0, 1)
//! n_m(x) = N_(m-1)(x) - N_(m-1)(x - 1)          N_m(x) = x/m N_(m-1)(x) + (1 - x/m) N_(m-1)(x - 1)
//! ```
//!
//! (de Boor, *A Practical Guide to Splines*, 2001; the recurrence of `N` follows from that of `n` by
//! integration by parts.) Where `0 <= x <= m` both weights are shares, so that nothing cancels, and `N`
//! keeps its relative accuracy down to where it vanishes as `x^m / m!`.
//!
//! | question | answer |
//! |---|---|
//! | `n` and `N` at a place | [`BSpline`], in closed form up to order 4, else by the recurrence |
//! | `N^-1` to full accuracy | [`BSpline::quantile`] |
//! | `N^-1` fast, of any order | [`Quantiles`], from a table |
//! | the filter turned about its centre | [`Radial`] |

mod closed;
mod quantile;
mod radial;
mod table;

pub use radial::Radial;
pub use table::Quantiles;

/// The B-spline of one order on its support `[0, order]`; the unit of length is the distance of knots.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct BSpline {
    order: u32,
}

impl BSpline {
    /// The highest order: no picture gains from a filter that is wider, and the recurrence costs the
    /// square of the order.
    pub const MAX_ORDER: u32 = 32;

    /// The B-spline of an order from 1 to [`BSpline::MAX_ORDER`]; `None` for other orders.
    pub fn new(order: u32) -> Option<BSpline> {
        (1..=BSpline::MAX_ORDER).contains(&order).then_some(BSpline { order })
    }

    /// Its order: the width of its support, and one more than its degree.
    pub fn order(self) -> u32 {
        self.order
    }

    /// The density `n` at `x`. In the two places where that of order 1 jumps it is 1.
    pub fn density(self, x: f64) -> f64 {
        self.at(x)[1]
    }

    /// The distribution `N` at `x`, from 0 to 1.
    pub fn distribution(self, x: f64) -> f64 {
        self.at(x)[0]
    }

    /// The distribution and the density at `x`.
    #[inline]
    pub fn at(self, x: f64) -> [f64; 2] {
        let mirrored = f64::from(self.order) - x;
        // Seen from its nearer end, neither of them is a difference of equals.
        if mirrored < x {
            let [beyond, density] = self.left(mirrored);
            return [1.0 - beyond, density];
        }
        self.left(x)
    }

    /// The distribution and the density at `x` up to the middle.
    #[inline]
    fn left(self, x: f64) -> [f64; 2] {
        match self.order {
            1..=4 => closed::left(self.order, x),
            _ => self.by_recurrence(x),
        }
    }

    /// The distribution and the density at `x` by the recurrence, row by row of its triangle: the
    /// reference for the closed forms, and the way of all orders that have none.
    pub fn by_recurrence(self, x: f64) -> [f64; 2] {
        let m = self.order as usize;
        // Row k holds N_k at x, x - 1, x - 2 ...
        let mut row = [0.0; BSpline::MAX_ORDER as usize + 1];
        row.iter_mut().take(m).enumerate().for_each(|(j, n)| *n = (x - j as f64).clamp(0.0, 1.0));
        let mut density = if (0.0..=1.0).contains(&x) { 1.0 } else { 0.0 };
        for k in 2..=m {
            density = row[0] - row[1];
            for j in 0..=m - k {
                // Beyond the support both operands are alike, and any share of them is the same.
                let share = ((x - j as f64) / k as f64).clamp(0.0, 1.0);
                row[j] = share * row[j] + (1.0 - share) * row[j + 1];
            }
        }
        [row[0], density]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The definition, written down as it stands; exponential in the order.
    fn naive(m: u32, x: f64) -> f64 {
        if m == 1 {
            return x.clamp(0.0, 1.0);
        }
        let share = x / f64::from(m);
        share * naive(m - 1, x) + (1.0 - share) * naive(m - 1, x - 1.0)
    }

    fn orders() -> impl Iterator<Item = BSpline> {
        (1..=BSpline::MAX_ORDER).filter_map(BSpline::new)
    }

    #[test]
    fn orders_have_limits() {
        assert_eq!(orders().count(), 32);
        assert!(BSpline::new(0).is_none() && BSpline::new(33).is_none());
    }

    #[test]
    fn the_triangle_gives_what_the_definition_says() {
        for spline in orders().take(9) {
            let m = spline.order();
            for i in -20..=20 + 20 * m as i32 {
                let x = f64::from(i) / 20.0 + 0.013;
                let [n_m, density] = spline.by_recurrence(x);
                assert!((n_m - naive(m, x)).abs() < 1e-14, "{m} {x}");
                if m > 1 {
                    assert!((density - naive(m - 1, x) + naive(m - 1, x - 1.0)).abs() < 1e-14, "{m} {x}");
                }
            }
        }
    }

    #[test]
    fn closed_forms_equal_the_recurrence() {
        for spline in orders().take(4) {
            for i in -100..=500 {
                let x = f64::from(i) / 100.0;
                let (closed, by_recurrence) = (spline.at(x), spline.by_recurrence(x));
                for k in 0..2 {
                    assert!((closed[k] - by_recurrence[k]).abs() < 1e-15, "{spline:?} {x}: {closed:?}");
                }
            }
        }
    }

    #[test]
    fn densities_are_symmetric_and_distributions_rise_to_one() {
        for spline in orders() {
            let width = f64::from(spline.order());
            let (mut before, count) = (0.0, 4000);
            let mut integral = 0.0;
            for i in 0..count {
                let x = width * (f64::from(i) + 0.5) / f64::from(count);
                let [distribution, density] = spline.at(x);
                let [mirrored, same] = spline.at(width - x);
                assert!((density - same).abs() < 1e-13 && density > 0.0, "{spline:?} {x}");
                assert!((distribution + mirrored - 1.0).abs() < 1e-14, "{spline:?} {x}");
                assert!(distribution >= before);
                before = distribution;
                integral += density * width / f64::from(count);
            }
            assert!((integral - 1.0).abs() < 1e-6, "{spline:?} {integral}");
            assert_eq!([spline.at(-1.0), spline.at(width + 1.0)], [[0.0, 0.0], [1.0, 0.0]]);
        }
    }

    #[test]
    fn densities_are_convolutions_with_the_box() {
        for pair in orders().collect::<Vec<_>>().windows(2) {
            let [narrow, wide] = [pair[0], pair[1]];
            for i in 0..40 {
                let x = f64::from(wide.order()) * (f64::from(i) + 0.3) / 40.0;
                let over_a_box: f64 =
                    (0..2000).map(|j| narrow.density(x - (f64::from(j) + 0.5) / 2000.0)).sum::<f64>()
                        / 2000.0;
                assert!((over_a_box - wide.density(x)).abs() < 1e-3, "{wide:?} {x}");
            }
        }
    }

    #[test]
    fn small_values_keep_their_relative_accuracy() {
        for spline in orders() {
            let m = f64::from(spline.order());
            let x = 0.75;
            let [distribution, density] = spline.at(x);
            let exact = (1..=spline.order()).fold(1.0, |y, k| y * x / f64::from(k));
            assert!((distribution / exact - 1.0).abs() < 1e-13, "{spline:?}");
            assert!((density / (exact * m / x) - 1.0).abs() < 1e-13, "{spline:?}");
        }
    }
}
