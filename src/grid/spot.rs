//! Spot noise: copies of a spot, each at a random place with a random weight, added up (van Wijk 1991;
//! thesis, 4.17).
//!
//! ```text
//! f(x) = sum_i w_i h((x - x_i) / r)
//! ```
//!
//! with the spot `h` on the unit ball (the unit disc of the plane y = 0 for a heightfield) and zero
//! outside, places `x_i` of a Poisson process and independent normal weights `w_i`. The power
//! spectrum of the sum is that of the spot, so the spot's shape is the texture's grain.
//!
//! Space is divided into cells no smaller than a spot, each with a hashed Poisson number of spots. A
//! sample looks into its own cell and those around, in a fixed order. Cells fit into the grid a whole
//! number of times and repeat with it. The result is scaled to zero mean and unit variance.

use super::random::{key, normals, poisson};
use super::{Cancel, Edge, Failure, Frame, Samples};
use crate::num::{mix, uniform};
use rayon::prelude::*;

/// How spots are strewn.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Recipe {
    /// Names the texture.
    pub seed: u64,
    /// Radius of a spot in units of length.
    pub radius: f64,
    /// How many spots cover a point, in the mean.
    pub density: f64,
}

/// One copy of the spot: where, in units of its radius, and its weight.
struct Copy {
    at: [f64; 3],
    weight: f64,
}

/// The cells of a periodic box.
struct Cells {
    seed: u64,
    /// Cells along each axis; one along an axis of one sample.
    count: [usize; 3],
    /// Their edges, in units of the radius.
    edge: [f64; 3],
    varies: [bool; 3],
    /// Spots expected in a cell.
    mean: f64,
}

impl Cells {
    fn new(recipe: Recipe, frame: &Frame) -> Self {
        let varies = frame.size.map(|n| n > 1);
        let extent = frame.extent();
        let count: [usize; 3] = std::array::from_fn(|axis| match varies[axis] {
            // Small cells have fewer spots out of reach; far smaller than a spot they cannot be.
            true => ((extent[axis] / recipe.radius).floor() as usize).max(1),
            false => 1,
        });
        let edge: [f64; 3] = std::array::from_fn(|axis| extent[axis] / count[axis] as f64 / recipe.radius);
        let volume: f64 = (0..3).filter(|axis| varies[*axis]).map(|axis| edge[axis]).product();
        // Measure of the unit ball in as many dimensions.
        let ball = [1.0, 2.0, std::f64::consts::PI, 4.0 / 3.0 * std::f64::consts::PI];
        let dimensions = varies.iter().filter(|v| **v).count();
        Cells { seed: recipe.seed, count, edge, varies, mean: recipe.density / ball[dimensions] * volume }
    }

    /// The spots of a cell, which may lie beyond the box: it repeats.
    fn spots(&self, cell: [i64; 3]) -> Vec<Copy> {
        let inside: [i64; 3] = std::array::from_fn(|axis| cell[axis].rem_euclid(self.count[axis] as i64));
        let hash = key(self.seed, inside);
        (0..poisson(mix(hash ^ 1), self.mean))
            .map(|i| {
                let hash = key(hash, [i64::from(i)]);
                let at = std::array::from_fn(|axis| {
                    let offset = uniform(mix(hash ^ (axis as u64 + 1)));
                    if self.varies[axis] { (cell[axis] as f64 + offset) * self.edge[axis] } else { 0.0 }
                });
                Copy { at, weight: normals(mix(hash ^ 4))[0] }
            })
            .collect()
    }
}

impl Recipe {
    /// Spots that may cover a point: more look no different, and take longer.
    pub const MOST: f64 = 200.0;

    /// The texture at the samples of a frame that repeats. The spot is cloned for every worker, so it may have
    /// memory of its own.
    ///
    /// # Errors
    /// When the frame is impossible, the texture is zero everywhere, or cancelled.
    pub fn texture<F>(self, frame: Frame, spot: F, cancel: Cancel<'_>) -> Result<Samples, Failure>
    where
        F: FnMut([f64; 3]) -> f64 + Clone + Send + Sync,
    {
        let frame = Frame { edge: Edge::Repeat, ..frame }.checked()?;
        let cells = Cells::new(self, &frame);
        let [nx, ny, _] = frame.size;
        let reach = cells.varies.map(i64::from);
        let mut values = vec![0.0; frame.count()];
        values.par_chunks_mut(nx).enumerate().try_for_each_init(
            || spot.clone(),
            |spot, (row, values)| {
                if cancel() {
                    return Err(Failure::Cancelled);
                }
                // Position of the row in units of the radius, from the first sample.
                let along = |axis: usize, i: usize| match cells.varies[axis] {
                    true => i as f64 * frame.spacing[axis] / self.radius,
                    false => 0.0,
                };
                let (y, z) = (along(1, row % ny), along(2, row / ny));
                let near = self.near_row(&cells, reach, y, z);
                for (i, value) in values.iter_mut().enumerate() {
                    let x = along(0, i);
                    let home = (x / cells.edge[0]).floor() as i64;
                    for copy in near.iter().skip_while(|c| c.0 < home - 1).take_while(|c| c.0 <= home + 1) {
                        let Copy { at, weight } = &copy.1;
                        let d = [x - at[0], y - at[1], z - at[2]];
                        if d[0] * d[0] + d[1] * d[1] + d[2] * d[2] < 1.0 {
                            *value += weight * spot(d);
                        }
                    }
                }
                Ok(())
            },
        )?;
        Samples { frame, values }.standardized("this spot noise")
    }

    /// The spots that reach a row, by the cell along it.
    fn near_row(self, cells: &Cells, reach: [i64; 3], y: f64, z: f64) -> Vec<(i64, Copy)> {
        let home = |v: f64, axis: usize| (v / cells.edge[axis]).floor() as i64;
        let (hy, hz) = (home(y, 1), home(z, 2));
        let mut near = Vec::new();
        for x in -reach[0]..cells.count[0] as i64 + reach[0] {
            for k in -reach[2]..=reach[2] {
                for j in -reach[1]..=reach[1] {
                    let spots = cells.spots([x, hy + j, hz + k]).into_iter();
                    near.extend(
                        spots
                            .filter(|c| {
                                let (dy, dz) = (y - c.at[1], z - c.at[2]);
                                dy * dy + dz * dz < 1.0
                            })
                            .map(|c| (x, c)),
                    );
                }
            }
        }
        near
    }
}

#[cfg(test)]
mod tests {
    use super::super::never;
    use super::*;

    fn bump([x, y, z]: [f64; 3]) -> f64 {
        let r2 = x * x + y * y + z * z;
        (1.0 - r2) * (1.0 - r2)
    }

    fn plane(n: usize) -> Frame {
        Frame::over([n, 1, n], [0.0; 3], [4.0, 1.0, 4.0], Edge::Repeat).unwrap()
    }

    #[test]
    fn mean_is_zero_and_variance_one() {
        let recipe = Recipe { seed: 3, radius: 0.25, density: 8.0 };
        let cube = Frame::over([32; 3], [0.0; 3], [2.0; 3], Edge::Repeat).unwrap();
        for frame in [plane(96), cube] {
            let (mean, variance) = recipe.texture(frame, bump, &never).unwrap().moments();
            assert!(mean.abs() < 1e-12 && (variance - 1.0).abs() < 1e-12, "{mean} {variance}");
        }
    }

    #[test]
    fn correlation_is_that_of_the_spot() {
        // (h * h)(tau) / (h * h)(0), by quadrature.
        let correlation = |tau: f64| {
            let (mut sum, n) = (0.0, 200);
            for i in 0..n {
                for j in 0..n {
                    let [x, z] = [i, j].map(|i| (f64::from(i) + 0.5) / f64::from(n) * 4.0 - 2.0);
                    let ball = |x: f64| if x * x + z * z < 1.0 { bump([x, 0.0, z]) } else { 0.0 };
                    sum += ball(x) * ball(x - tau);
                }
            }
            sum
        };
        let n = 256;
        let recipe = Recipe { seed: 5, radius: 4.0 * 8.0 / n as f64, density: 10.0 };
        let s = recipe.texture(plane(n), bump, &never).unwrap();
        for lag in [2usize, 4, 8, 12] {
            let got: f64 =
                (0..n * n).map(|i| s.values[i] * s.values[i / n * n + (i % n + lag) % n]).sum::<f64>()
                    / (n * n) as f64;
            let expected = correlation(lag as f64 / 8.0) / correlation(0.0);
            assert!((got - expected).abs() < 0.04, "{lag}: {got} {expected}");
        }
    }

    #[test]
    fn it_repeats_and_spots_may_be_as_large_as_the_grid() {
        // Every sample of a spot that reaches around is there: a shifted grid has the same spots.
        let recipe = Recipe { seed: 8, radius: 3.0, density: 3.0 };
        let s = recipe.texture(plane(32), bump, &never).unwrap();
        let jump = |x: usize| {
            (0..32)
                .map(|z| (s.values[z * 32 + (x + 1) % 32] - s.values[z * 32 + x]).abs())
                .fold(0.0, f64::max)
        };
        assert!(jump(31) < 3.0 * jump(15).max(jump(7)), "{} {}", jump(31), jump(15));
        let nothing = recipe.texture(plane(8), |_| 0.0, &never);
        assert_eq!(nothing, Err(Failure::Silent("this spot noise")));
    }
}
