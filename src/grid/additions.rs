//! Successive random additions: fractional Brownian motion by refinement (thesis, 3.32 and 3.33;
//! Voss 1985).
//!
//! A coarse lattice of random heights is refined by interpolation, over and over, and after each step
//! *every* height, old or new, gets a random number added to it. (Midpoint displacement leaves the old
//! ones as they are, which shows as dents and peaks that stay in place through all scales.) On a
//! square lattice a step puts a height in the middle of every square, the mean of its corners; the
//! next puts one in the middle of every edge, the mean of its neighbours on the lattice turned by 45
//! degrees. Each step shortens the spacing by `sqrt(2)`, and the deviation of what is added by
//! `2^(-hurst / 2)`, so that increments over a distance `r` have a variance near `r^(2 hurst)`.
//!
//! Numbers are hashes of the step and of the place on its lattice, so a terrain of more levels is the
//! same with more detail. A surface that repeats takes its neighbours around the corner.

use super::random::{key, normals};
use super::{Cancel, Edge, Failure, Frame, Samples};
use rayon::prelude::*;

/// How a surface is made.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Recipe {
    /// Names the surface.
    pub seed: u64,
    /// Roughness: 1 is smooth, 0 is rough.
    pub hurst: f64,
    /// Doublings of the resolution: `2^levels` cells along an edge.
    pub levels: u32,
}

impl Recipe {
    /// Samples along an edge: one more than cells, except where the last is the first again.
    pub fn size(self, edge: Edge) -> usize {
        (1 << self.levels.min(30)) + usize::from(edge == Edge::Clamp)
    }

    /// The surface at the samples of a frame of [`size`](Recipe::size), with coarsest heights of unit deviation.
    ///
    /// # Errors
    /// When the frame does not fit, or cancelled.
    pub fn surface(self, frame: Frame, cancel: Cancel<'_>) -> Result<Samples, Failure> {
        let n = self.size(frame.edge);
        if frame.size != [n, 1, n] {
            return Err(Failure::Size(frame.size));
        }
        let frame = frame.checked()?;
        let mut samples = Samples { frame, values: vec![0.0; frame.count()] };
        let mut step = 1 << self.levels;
        let mut deviation = 1.0;
        self.add(&mut samples, 0, step, false, deviation);
        let mut round = 1;
        while step > 1 {
            for centres in [true, false] {
                if cancel() {
                    return Err(Failure::Cancelled);
                }
                deviation *= libm::pow(2.0, -0.5 * self.hurst);
                refine(&mut samples, step, centres);
                if !centres {
                    step /= 2;
                }
                // With centres the lattice is that of half the step, without the middles of edges.
                self.add(&mut samples, round, if centres { step / 2 } else { step }, centres, deviation);
                round += 1;
            }
        }
        Ok(samples)
    }

    /// Adds a random number to every sample of a lattice; `quincunx` leaves out the middles of the
    /// edges between squares of twice the step.
    fn add(self, samples: &mut Samples, round: i64, step: usize, quincunx: bool, deviation: f64) {
        let n = samples.frame.size[0];
        samples.values.par_chunks_mut(n).enumerate().filter(|(z, _)| z % step == 0).for_each(|(z, row)| {
            for x in (0..n).step_by(step) {
                let (i, j) = (x / step, z / step);
                if !(quincunx && (i + j) % 2 == 1) {
                    row[x] += deviation * normals(key(self.seed, [round, i as i64, j as i64]))[0];
                }
            }
        });
    }
}

/// Puts heights in the middle of every square of a lattice of `step`, or of every edge.
fn refine(samples: &mut Samples, step: usize, centres: bool) {
    let n = samples.frame.size[0];
    let half = step / 2;
    let frame = samples.frame;
    let old = samples.values.clone();
    // Beyond the edge of a surface that does not repeat there is nothing.
    let height = |x: isize, z: isize| -> Option<f64> {
        let inside = |v: isize| (0..n as isize).contains(&v);
        match frame.edge {
            Edge::Clamp if !(inside(x) && inside(z)) => None,
            _ => {
                let [x, z] = [x, z].map(|v| v.rem_euclid(n as isize) as usize);
                Some(old[z * n + x])
            }
        }
    };
    let h = half as isize;
    let around =
        if centres { [[-h, -h], [h, -h], [-h, h], [h, h]] } else { [[-h, 0], [h, 0], [0, -h], [0, h]] };
    samples.values.par_chunks_mut(n).enumerate().filter(|(z, _)| z % half == 0).for_each(|(z, row)| {
        for x in (0..n).step_by(half) {
            let odd = (x / half % 2, z / half % 2);
            let wanted = if centres { odd == (1, 1) } else { odd.0 != odd.1 };
            if wanted {
                let (mut sum, mut count) = (0.0, 0.0);
                for [dx, dz] in around {
                    if let Some(h) = height(x as isize + dx, z as isize + dz) {
                        sum += h;
                        count += 1.0;
                    }
                }
                row[x] = sum / count;
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::super::never;
    use super::*;

    fn surface(seed: u64, hurst: f64, levels: u32, edge: Edge) -> Samples {
        let recipe = Recipe { seed, hurst, levels };
        let n = recipe.size(edge);
        recipe.surface(Frame::over([n, 1, n], [0.0; 3], [1.0; 3], edge).unwrap(), &never).unwrap()
    }

    #[test]
    fn corners_have_the_variance_of_all_additions() {
        // A corner is never interpolated: it is a sum of independent numbers, one a step.
        let (hurst, levels, runs) = (0.6, 3, 4000);
        let expected: f64 = (0..=2 * levels).map(|j| libm::pow(2.0, -hurst * f64::from(j))).sum();
        let mean = (0..runs)
            .map(|seed| surface(seed, hurst, levels, Edge::Clamp).values[0])
            .map(|h| h * h)
            .sum::<f64>()
            / runs as f64;
        assert!((mean / expected - 1.0).abs() < 0.1, "{mean} {expected}");
    }

    #[test]
    fn increments_grow_with_the_distance_as_theory_says() {
        for hurst in [0.4, 0.6, 0.8] {
            for edge in [Edge::Clamp, Edge::Repeat] {
                // Mean square of increments over 1, 2, 4, 8 samples, over many surfaces.
                let mut squares = [0.0; 4];
                for seed in 0..40 {
                    let s = surface(seed, hurst, 8, edge);
                    let n = s.frame.size[0];
                    for (k, sum) in squares.iter_mut().enumerate() {
                        let lag = 1 << k;
                        for z in 0..n {
                            for x in 0..n - lag {
                                let d = s.values[z * n + x + lag] - s.values[z * n + x];
                                *sum += d * d / ((n - lag) * n) as f64;
                            }
                        }
                    }
                }
                // Every sample has its own last addition, so the finest increments are a little too
                // large, and the slope comes near its value at some distance only.
                let slopes = [1, 2, 3].map(|k| 0.5 * libm::log2(squares[k] / squares[k - 1]));
                assert!(slopes[0] < slopes[2] || hurst < 0.5, "{hurst} {edge:?}: {slopes:?}");
                assert!((slopes[2] - hurst).abs() < 0.12, "{hurst} {edge:?}: {slopes:?}");
            }
        }
    }

    #[test]
    fn more_levels_refine_the_same_surface() {
        let (coarse, fine) = (surface(4, 1.0, 4, Edge::Clamp), surface(4, 1.0, 7, Edge::Clamp));
        // What the last levels add is small.
        for z in 0..17 {
            for x in 0..17 {
                let d = coarse.values[z * 17 + x] - fine.values[z * 8 * 129 + x * 8];
                assert!(d.abs() < 0.6, "{d}");
            }
        }
    }

    #[test]
    fn seams_are_like_any_other_place() {
        let s = surface(11, 0.8, 8, Edge::Repeat);
        let n = s.frame.size[0];
        let roughness = |x: usize| {
            (0..n).map(|z| s.values[z * n + (x + 1) % n] - s.values[z * n + x]).map(|d| d * d).sum::<f64>()
        };
        let mean = (0..n).map(roughness).sum::<f64>() / n as f64;
        assert!(roughness(n - 1) < 2.0 * mean);
    }
}
