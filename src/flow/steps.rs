//! How many steps a flow takes.
//!
//! Steps are equally long everywhere, so that the map is as smooth as the velocity and has an inverse; a method that chose
//! them for each trajectory would tear space a little wherever its choice changes. So the choice is made beforehand:
//! trajectories from probes are followed in so many steps and in twice as many, and so on until they end in the same
//! places, to within a share of how far the flow carries points on average. The map has an inverse if no step moves two points
//! into one, for which `h Lip(u) < 1` is enough; that is seen to at the probes too.

use super::{Code, advect};
use crate::num::{Dual, Many, mix, uniform};

/// How close the steps come to the flow.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Precision {
    /// So many steps.
    Steps(u32),
    /// An error of this share of how far points are carried on average; the bits of the number, so that it can be hashed.
    Share(u64),
}

/// Most steps that a flow takes.
pub const MOST: u32 = 512;

/// Fewest steps that are chosen.
const FEWEST: u32 = 4;

/// How many trajectories are followed, beside those from the field's own points.
const PROBES: u64 = 256;

/// Trajectories side by side.
const LANES: usize = 16;

/// Steps that keep the mean error of a flow below a share of how far it carries points, as far as trajectories tell that
/// begin at points of the cube from -1.5 to 1.5 around the origin, in which solids are by habit, and at points of
/// its own that the field names.
pub fn choose<V: Code<3>>(velocity: &V, tolerance: f64, own: &[[f64; 3]]) -> u32 {
    let spread = |i: u64| std::array::from_fn(|axis| 3.0 * uniform(mix(3 * i + axis as u64)) - 1.5);
    let starts: Vec<[f64; 3]> = (0..PROBES).map(spread).chain(own.iter().copied()).collect();
    let mut steps = FEWEST.max(one_to_one(velocity, &starts));
    let mut ends = ends(velocity, steps, &starts);
    while steps < MOST {
        let finer = self::ends(velocity, 2 * steps, &starts);
        // The method is of fourth order: what is left of the error is little more than what has gone.
        if moved(&ends, &finer) <= tolerance * moved(&starts, &finer) {
            break;
        }
        (steps, ends) = (2 * steps, finer);
    }
    steps.min(MOST)
}

/// The root of the mean squared distance between points, as far as there is one. Not the largest: where a trajectory
/// passes a crease of the velocity, no method is of high order.
fn moved(from: &[[f64; 3]], to: &[[f64; 3]]) -> f64 {
    let square = |(a, b): (&[f64; 3], &[f64; 3])| (0..3).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum::<f64>();
    let squares: Vec<f64> = from.iter().zip(to).map(square).filter(|d| d.is_finite()).collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}

/// Steps so short that none moves two points into one, as far as slopes at these points tell.
fn one_to_one<V: Code<3>>(velocity: &V, starts: &[[f64; 3]]) -> u32 {
    let mut run = velocity.runner::<Dual>();
    let mut slope = |y: &[f64; 3]| {
        let u = run(&std::array::from_fn(|axis| Dual::coordinate(y[axis], axis)));
        u.iter().flat_map(|u| u.grad).map(|g| g * g).sum::<f64>().sqrt()
    };
    let steepest = starts.iter().map(&mut slope).filter(|s| s.is_finite()).fold(0.0, f64::max);
    (steepest.ceil() as u32).clamp(1, MOST).next_power_of_two()
}

/// Where trajectories end.
fn ends<V: Code<3>>(velocity: &V, steps: u32, starts: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut ends = Vec::with_capacity(starts.len());
    for batch in starts.chunks(LANES) {
        let lane = |axis: usize, i: usize| batch[i.min(batch.len() - 1)][axis];
        let from = std::array::from_fn(|axis| Many::<f64, LANES>(std::array::from_fn(|i| lane(axis, i))));
        let end = advect(velocity.runner(), steps, &from, |Many(v)| v.iter().all(|v| *v == 0.0));
        ends.extend((0..batch.len()).map(|i| end.each_ref().map(|axis| axis.0[i])));
    }
    ends
}
