//! Tables of two variables.

use rayon::prelude::*;
use std::ops::{Add, Mul};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// Values at the nodes of a grid over the unit square.
#[derive(Clone, Debug)]
pub(super) struct Grid<T> {
    columns: usize,
    rows: usize,
    values: Box<[T]>,
}

impl<T: Copy + Send + Add<Output = T> + Mul<f64, Output = T>> Grid<T> {
    /// A grid of at least four columns and rows. `row(v)` gives the values at the height `v` for u = 0 to 1 in
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

    /// The value at a point, with straight lines between the nodes; outside of the unit square that of the nearest point in it.
    pub fn linear(&self, u: f64, v: f64) -> T {
        let ((i, s), (j, t)) = (place(u, self.columns), place(v, self.rows));
        self.mean([i, j], [1.0 - s, s], [1.0 - t, t])
    }

    /// The same with cubics through the four columns, and the four rows, that are nearest.
    pub fn cubic(&self, u: f64, v: f64) -> T {
        let (i, across) = four(u, self.columns);
        let (j, up) = four(v, self.rows);
        self.mean([i, j], across, up)
    }

    /// The sum of values from a column and a row on, with weights across and up.
    fn mean<const N: usize>(&self, [i, j]: [usize; 2], across: [f64; N], up: [f64; N]) -> T {
        mean(std::array::from_fn(|row| &self.values[(j + row) * self.columns + i..]), across, up)
    }
}

/// A grid of which rows are made when something is first asked of them.
#[derive(Debug)]
pub(super) struct Rows<T> {
    columns: usize,
    rows: Box<[OnceLock<Box<[T]>>]>,
}

impl<T: Copy + Send + Add<Output = T> + Mul<f64, Output = T>> Rows<T> {
    /// None of them yet.
    pub fn new([columns, rows]: [usize; 2]) -> Rows<T> {
        Rows { columns, rows: (0..rows).map(|_| OnceLock::new()).collect() }
    }

    /// What [`Grid::cubic`] says of a grid whose rows are made by `row`, which must give the same for the same height.
    pub fn cubic<R: Iterator<Item = T>>(&self, u: f64, v: f64, row: impl Fn(f64) -> R) -> T {
        let (i, across) = four(u, self.columns);
        let (j, up) = four(v, self.rows.len());
        let made = |j: usize| self.rows[j].get_or_init(|| row(share(j, self.rows.len())).collect());
        mean(std::array::from_fn(|k| &made(j + k)[i..]), across, up)
    }
}

/// The sum of the first values of rows, with weights across and up.
fn mean<T: Copy + Add<Output = T> + Mul<f64, Output = T>, const N: usize>(
    rows: [&[T]; N],
    across: [f64; N],
    up: [f64; N],
) -> T {
    let sum = |values: [T; N]| values.into_iter().reduce(T::add).unwrap_or(rows[0][0]);
    sum(std::array::from_fn(|row| sum(std::array::from_fn(|k| rows[row][k] * across[k])) * up[row]))
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

/// The first of the four nodes nearest to a coordinate, and their weights: Lagrange's polynomials.
fn four(u: f64, count: usize) -> (usize, [f64; 4]) {
    let (i, on) = place(u, count);
    let first = i.saturating_sub(1).min(count - 4);
    let x = (i - first) as f64 + on;
    let [a, b, c, d] = [x, x - 1.0, x - 2.0, x - 3.0];
    (first, [b * c * d / -6.0, a * c * d / 2.0, a * b * d / -2.0, a * b * c / 6.0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_and_cubics_are_kept() {
        let f = |u: f64, v: f64| 3.0 + 2.0 * u - v + 0.5 * u * v;
        let g = |u: f64, v: f64| f(u, v) - 0.3 * v * v + (1.0 - u * u * u) * v * v * v;
        let grid = |f: &(dyn Fn(f64, f64) -> f64 + Sync)| {
            let grid = Grid::new([5, 6], &AtomicBool::new(false), |v| (0..5).map(move |i| f(share(i, 5), v)));
            grid.unwrap()
        };
        let (lines, curves) = (grid(&f), grid(&g));
        let row = |v: f64| (0..5).map(move |i| g(share(i, 5), v));
        let rows = Rows::new([5, 6]);
        for (u, v) in [(0.0, 0.0), (1.0, 1.0), (0.3, 0.9), (0.25, 0.5), (0.6, 0.05), (0.9, 0.99)] {
            assert!((lines.linear(u, v) - f(u, v)).abs() < 1e-12);
            assert!((curves.cubic(u, v) - g(u, v)).abs() < 1e-12);
            assert_eq!(rows.cubic(u, v, row), curves.cubic(u, v));
        }
        for at in [Grid::linear, Grid::cubic] {
            assert_eq!((at(&lines, -1.0, 2.0), at(&lines, f64::NAN, 0.0).is_nan()), (f(0.0, 1.0), true));
        }
    }
}
