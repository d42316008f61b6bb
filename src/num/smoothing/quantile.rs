//! The inverse of the distribution: in closed form where there is one, else by Newton's method.
//!
//! From the middle Newton's iterates approach the root from one side, without any safeguard: on the
//! left half `N` is convex, and the middle is beyond the root. The right half is the mirror image.
//!
//! Close to the end `N = x^m / m!` has a root of order `m`, of which a step takes off only the `m`-th
//! part of the distance. There, up to `x = 1`, the closed form `(m! y)^(1/m)` takes over.

use super::BSpline;

/// Newton's method stops after a step that is shorter than this. As its convergence is quadratic, what
/// remains is of the order of the square.
const TOLERANCE: f64 = 1e-8;

/// Bound of the steps that any order takes to any number of [0, 1/2]; most take five.
const STEPS: u32 = 200;

impl BSpline {
    /// Where the distribution is `y`: the inverse of [`BSpline::distribution`], for `y` from 0 to 1, with
    /// an error below 1e-12.
    pub fn quantile(self, y: f64) -> f64 {
        if y > 0.5 {
            return f64::from(self.order) - self.lower_quantile(1.0 - y);
        }
        self.lower_quantile(y)
    }

    /// The quantile of `y` up to 1/2.
    fn lower_quantile(self, y: f64) -> f64 {
        let width = f64::from(self.order);
        let scaled = y * factorial(self.order);
        if scaled <= 1.0 {
            return root(scaled.max(0.0), self.order);
        }
        match self.order {
            3 => {
                let third = libm::asin((y - 0.5) * (4.0 / 3.0_f64.sqrt())) / 3.0;
                1.5 + 3.0_f64.sqrt() * libm::sin(third)
            }
            _ => self.lower_quantile_from(y, 0.5 * width),
        }
    }

    /// The quantile of `y` up to 1/2, by Newton's method from a place at or beyond it that is not beyond
    /// the middle.
    pub(super) fn lower_quantile_from(self, y: f64, start: f64) -> f64 {
        let mut x = start;
        for _ in 0..STEPS {
            let [distribution, density] = self.at(x);
            let step = (distribution - y) / density;
            x -= step;
            if step.abs() < TOLERANCE {
                break;
            }
        }
        x
    }
}

/// `m!`; rounded from 23! on.
fn factorial(m: u32) -> f64 {
    (1..=m).fold(1.0, |product, k| product * f64::from(k))
}

/// The root of an order of a number that is not negative.
fn root(x: f64, order: u32) -> f64 {
    match order {
        1 => x,
        2 => x.sqrt(),
        3 => libm::cbrt(x),
        4 => x.sqrt().sqrt(),
        _ => libm::pow(x, 1.0 / f64::from(order)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean and maximum of the steps of Newton's method for the cubic spline over `y = i / 1000`: from
    /// the middle to the end, or with the tails in closed form, which are no steps.
    fn steps(closed_tails: bool) -> (f64, u32) {
        let spline = BSpline::new(4).unwrap();
        let (mut sum, mut most) = (0, 0);
        for i in 1..1000 {
            let y = f64::from(i) / 1000.0;
            if closed_tails && y.min(1.0 - y) <= 1.0 / 24.0 {
                continue;
            }
            let (mut x, mut count) = (2.0, 0);
            loop {
                let [distribution, density] = spline.at(x);
                let step = (distribution - y) / density;
                x -= step;
                count += 1;
                if step.abs() < 1e-8 {
                    break;
                }
            }
            assert!((x - spline.quantile(y)).abs() < 1e-12);
            (sum, most) = (sum + count, most.max(count));
        }
        (f64::from(sum) / 999.0, most)
    }

    #[test]
    fn newtons_method_takes_as_many_steps_as_known() {
        let (mean, most) = steps(false);
        assert!((mean - 4.82).abs() < 0.005 && most == 10, "{mean} {most}");
        let (mean, most) = steps(true);
        assert!((mean - 4.205).abs() < 0.005 && most == 7, "{mean} {most}");
    }

    #[test]
    fn quantiles_invert_the_distribution() {
        for order in 1..=BSpline::MAX_ORDER {
            let spline = BSpline::new(order).unwrap();
            let ends = [0.0, 1e-300, 1e-40, 1e-18, 1e-12, 1e-9, 1e-6, 1e-3];
            let inner = (0..=500).map(|i| f64::from(i) / 500.0);
            for y in inner.chain(ends).chain(ends.map(|y| 1.0 - y)) {
                let x = spline.quantile(y);
                let [distribution, density] = spline.at(x);
                assert!((distribution - y).abs() < 1e-15 + 1e-12 * density, "{order} {y}: {x}");
                assert!((0.0..=f64::from(order)).contains(&x));
            }
            // Where the distribution is flat, its inverse is judged by the place.
            for i in 1..100 {
                let x = 0.5 * f64::from(order * i) / 100.0;
                let there = spline.quantile(spline.distribution(x));
                assert!((there - x).abs() < 1e-8, "{order} {x} {there}");
            }
        }
    }

    #[test]
    fn closed_forms_equal_newtons_method() {
        for order in [2, 3, 4] {
            let spline = BSpline::new(order).unwrap();
            for i in 1..=500 {
                let y = f64::from(i) / 1000.0;
                let by_steps = spline.lower_quantile_from(y, 0.5 * f64::from(order));
                assert!((spline.quantile(y) - by_steps).abs() < 1e-12, "{order} {y}");
            }
        }
    }
}
