//! Tables of two variables.

use rayon::prelude::*;
use std::ops::{Add, Mul};
use std::sync::atomic::{AtomicBool, Ordering};

/// Values at the nodes of a grid over the unit square, with straight lines in between.
#[derive(Clone, Debug)]
pub(super) struct Grid<T> {
    columns: usize,
    rows: usize,
    values: Box<[T]>,
}

impl<T: Copy + Send + Add<Output = T> + Mul<f64, Output = T>> Grid<T> {
    /// A grid of at least two columns and rows. `row(v)` gives the values at the height `v` for u = 0 to 1 in
    /// even steps, as many as there are columns; rows are made side by side. `None` if that was cancelled.
    pub fn new<R: Iterator<Item = T>>(
        [columns, rows]: [usize; 2],
        cancel: &AtomicBool,
        row: impl Fn(f64) -> R + Sync,
    ) -> Option<Grid<T>> {
        let row = |j| (!cancel.load(Ordering::Relaxed)).then(|| row(share(j, rows)).collect());
        let made: Option<Vec<Vec<T>>> = (0..rows).into_par_iter().map(row).collect();
        Some(Grid { columns, rows, values: made?.concat().into_boxed_slice() })
    }

    /// The value at a point; outside of the unit square that of the nearest point in it.
    pub fn at(&self, u: f64, v: f64) -> T {
        let ((i, s), (j, t)) = (place(u, self.columns), place(v, self.rows));
        let k = j * self.columns + i;
        let (low, high) = (&self.values[k..k + 2], &self.values[k + self.columns..k + self.columns + 2]);
        (low[0] * (1.0 - s) + low[1] * s) * (1.0 - t) + (high[0] * (1.0 - s) + high[1] * s) * t
    }
}

/// Coordinate of the `i`-th of `count` nodes.
pub(super) fn share(i: usize, count: usize) -> f64 {
    i as f64 / (count - 1) as f64
}

/// The node to the left of a coordinate, and how far on to the next it is.
fn place(u: f64, count: usize) -> (usize, f64) {
    let x = u.clamp(0.0, 1.0) * (count - 1) as f64;
    let i = (x as usize).min(count - 2);
    (i, x - i as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_kept() {
        let f = |u: f64, v: f64| 3.0 + 2.0 * u - v + 0.5 * u * v;
        let grid = Grid::new([5, 3], &AtomicBool::new(false), |v| (0..5).map(move |i| f(share(i, 5), v)));
        let grid = grid.unwrap();
        for (u, v) in [(0.0, 0.0), (1.0, 1.0), (0.3, 0.9), (0.25, 0.5)] {
            assert!((grid.at(u, v) - f(u, v)).abs() < 1e-12);
        }
        assert_eq!((grid.at(-1.0, 2.0), grid.at(f64::NAN, 0.0).is_nan()), (f(0.0, 1.0), true));
    }
}
