//! How many steps a flow takes.
//!
//! The classical method has a companion of third order, whose last stage is the first one of the next step:
//!
//! ```text
//! k5 = u(y1)      y1 - y1* = h/6 (k4 - k5)
//! ```
//!
//! Their difference measures the error of a step. Trajectories from probes are followed with steps as long as keep it
//! below a share of how far the flow carries anything, and the shortest step that any of them took becomes the step
//! of the flow: everywhere the same, so that the map is smooth and has an inverse. It has one if a step moves no two
//! points into one, for which `h Lip(u) < 1` is enough; that is seen to at the probes too.

use super::Code;
use crate::num::{Dual, uniform};

/// How close the steps come to the flow.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Precision {
    /// So many steps.
    Steps(u32),
    /// An error of this share of how far anything is carried; the bits of the number, so that it can be hashed.
    Share(u64),
}

/// Most steps that a flow takes.
pub const MOST: u32 = 512;

/// Fewest steps that are chosen.
const FEWEST: u32 = 4;

/// How many trajectories are followed.
const PROBES: u64 = 256;

/// Steps that keep the error of a flow below a share of the way that it carries anything, as far as trajectories tell
/// that begin at points of the cube from -1.5 to 1.5 around the origin, in which solids are by habit, and at
/// points of its own that the field names.
pub fn choose<V: Code<3>>(velocity: &V, tolerance: f64, own: &[[f64; 3]]) -> u32 {
    let mut run = velocity.runner::<Dual>();
    let mut at = |y: [f64; 3]| {
        let u = run(&std::array::from_fn(|axis| Dual::coordinate(y[axis], axis)));
        let slope = u.iter().flat_map(|u| u.grad).map(|g| g * g).sum::<f64>().sqrt();
        (u.map(|u| u.value), slope)
    };
    let spread = (0..PROBES).map(|i| std::array::from_fn(|axis| 3.0 * uniform(i * 3 + axis as u64) - 1.5));
    let starts: Vec<[f64; 3]> = spread.chain(own.iter().copied()).collect();
    // How far points are carried at most, as their first velocities tell.
    let far = starts.iter().map(|&y| norm(at(y).0)).filter(|u| u.is_finite()).fold(0.0, f64::max);
    let steps = starts.into_iter().map(|start| needed(&mut at, start, tolerance * far)).max();
    steps.unwrap_or(FEWEST).clamp(FEWEST, MOST)
}

fn norm([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

/// How many steps of equal length a trajectory needs so that none is off by more than its share.
fn needed(at: &mut impl FnMut([f64; 3]) -> ([f64; 3], f64), start: [f64; 3], tolerance: f64) -> u32 {
    let along = |y: [f64; 3], h: f64, k: [f64; 3]| std::array::from_fn(|axis| y[axis] + h * k[axis]);
    let (mut y, mut time, mut h, mut shortest) = (start, 0.0, 1.0 / f64::from(FEWEST), 1.0_f64);
    let (mut k1, mut slope) = at(y);
    while time < 1.0 {
        let (k2, _) = at(along(y, 0.5 * h, k1));
        let (k3, _) = at(along(y, 0.5 * h, k2));
        let (k4, _) = at(along(y, h, k3));
        let end: [f64; 3] = std::array::from_fn(|axis| {
            y[axis] + h / 6.0 * (k1[axis] + 2.0 * k2[axis] + 2.0 * k3[axis] + k4[axis])
        });
        let (k5, next) = at(end);
        let error = h / 6.0 * norm(std::array::from_fn(|axis| k4[axis] - k5[axis]));
        let is_one_to_one = h * slope.max(next) < 1.0;
        let is_short = h <= 1.0 / f64::from(MOST);
        // Where the velocity is no number, no step is short enough.
        if !(error + tolerance).is_finite() {
            break;
        }
        if (error > tolerance * h || !is_one_to_one) && !is_short {
            h *= 0.5;
            continue;
        }
        (time, y, k1, slope) = (time + h, end, k5, next);
        shortest = shortest.min(h);
        // The error of a step is of fourth order.
        if error < tolerance * h / 64.0 {
            h = (2.0 * h).min(1.0 / f64::from(FEWEST));
        }
    }
    (1.0 / shortest).round() as u32
}
