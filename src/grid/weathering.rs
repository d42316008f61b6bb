//! Thermal weathering: slopes steeper than loose rock can hold crumble (Musgrave, Kolb and Mace 1989).
//!
//! Where a sample stands above one of its eight neighbours by more than the talus angle allows, a
//! share of the excess slides down:
//!
//! ```text
//! h_i  +=  rate / 16  sum_j ( max(h_j - h_i - T d_ij, 0) - max(h_i - h_j - T d_ij, 0) )
//! ```
//!
//! What one sample gives its neighbour receives, so mass is conserved (up to rounding). All samples
//! move at once, from the heights of the step before, so their order does not matter; with at most a
//! sixteenth of each excess the step is stable. Steps end early when nothing moves any more.

use super::{Cancel, Edge, Failure, Samples};
use rayon::prelude::*;

/// How slopes crumble.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Weathering {
    /// Steepest slope that holds: rise over run.
    pub talus: f64,
    /// How fast: 0 to 1.
    pub rate: f64,
    /// How long.
    pub steps: u32,
}

impl Weathering {
    /// The heights after weathering.
    ///
    /// # Errors
    /// For volumes, or when cancelled.
    pub fn weather(self, mut samples: Samples, cancel: Cancel<'_>) -> Result<Samples, Failure> {
        samples.heightfield("weathering")?;
        let frame = samples.frame;
        let [nx, _, nz] = frame.size;
        let [dx, _, dz] = frame.spacing;
        let holds = |x: f64, z: f64| self.talus * (x * x + z * z).sqrt();
        let around: Vec<(isize, isize, f64)> = [(1, 0), (0, 1), (1, 1), (1, -1)]
            .into_iter()
            .flat_map(|(x, z)| [(x, z), (-x, -z)])
            .map(|(x, z)| (x, z, holds(x as f64 * dx, z as f64 * dz)))
            .collect();
        let share = self.rate.clamp(0.0, 1.0) / 16.0;
        let mut next = samples.values.clone();
        for _ in 0..self.steps {
            if cancel() {
                return Err(Failure::Cancelled);
            }
            let old = &samples.values;
            let moved = next
                .par_chunks_mut(nx)
                .enumerate()
                .map(|(z, row)| {
                    let mut moved = false;
                    for (x, height) in row.iter_mut().enumerate() {
                        let here = old[z * nx + x];
                        let mut gain = 0.0;
                        for &(sx, sz, holds) in &around {
                            let (i, j) = (frame.neighbour(x, sx, nx), frame.neighbour(z, sz, nz));
                            // Beyond a clamped edge lies nothing, rather than the edge again: a corner
                            // would see its neighbours as its diagonals.
                            if frame.edge == Edge::Clamp && off(x, sx, nx) | off(z, sz, nz) {
                                continue;
                            }
                            let rise = old[j * nx + i] - here;
                            gain += (rise - holds).max(0.0) - (-rise - holds).max(0.0);
                        }
                        moved |= gain != 0.0;
                        *height = here + share * gain;
                    }
                    moved
                })
                .reduce(|| false, |a, b| a | b);
            std::mem::swap(&mut samples.values, &mut next);
            if !moved {
                break;
            }
        }
        Ok(samples)
    }
}

/// Whether a step leads off the end of an axis.
#[inline(always)]
fn off(i: usize, step: isize, n: usize) -> bool {
    !(0..n as isize).contains(&(i as isize + step))
}

#[cfg(test)]
mod tests {
    use super::super::{Frame, never, total};
    use super::*;

    fn cone(edge: Edge) -> Samples {
        let frame = Frame::over([48, 1, 40], [-1.2, 0.0, -1.0], [1.2, 1.0, 1.0], edge).unwrap();
        Samples::of(frame, |[x, _, z]| (1.0 - 3.0 * (x * x + z * z).sqrt()).max(0.0), &never).unwrap()
    }

    #[test]
    fn mass_is_conserved_and_slopes_end_below_the_talus() {
        for edge in [Edge::Repeat, Edge::Clamp] {
            let before = cone(edge);
            let after =
                Weathering { talus: 0.7, rate: 1.0, steps: 4000 }.weather(before.clone(), &never).unwrap();
            let (a, b) = (total(&before.values), total(&after.values));
            assert!((a - b).abs() < 1e-11 * a, "{edge:?}: {a} {b}");
            let Frame { size: [nx, _, nz], spacing, .. } = after.frame;
            let mut steepest: f64 = 0.0;
            for z in 0..nz - 1 {
                for x in 0..nx - 1 {
                    let h = |x: usize, z: usize| after.values[z * nx + x];
                    steepest = steepest.max((h(x + 1, z) - h(x, z)).abs() / spacing[0]);
                    steepest = steepest.max((h(x, z + 1) - h(x, z)).abs() / spacing[2]);
                }
            }
            assert!(steepest < 0.7 * 1.01, "{edge:?}: {steepest}");
        }
    }

    #[test]
    fn what_holds_is_left_alone() {
        let before = cone(Edge::Clamp);
        let after = Weathering { talus: 5.0, rate: 1.0, steps: 10 }.weather(before.clone(), &never).unwrap();
        assert_eq!(before, after);
    }
}
