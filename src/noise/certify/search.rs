//! From below: `F_k` is climbed from many places.
//!
//! `F_k` has many local maxima, in five dimensions. From each start a few dozen random steps, which
//! shrink when they fail, lead near one; the best thousand of these are climbed to the last digit.

use super::node::{Family, Shape};
use super::unit;
use crate::num::{mix, uniform};
use rayon::prelude::*;

/// A place where `F_k` was found large.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Witness {
    /// The value there.
    pub value: f64,
    /// Point of the cell.
    pub x: [f64; 3],
    /// Unit vector.
    pub u: [f64; 3],
}

/// Steps of a short climb and of a long one.
const SHORT: u64 = 32;
const LONG: u64 = 3000;
/// Climbs that are continued: one in a hundred, but not more than these.
const BEST: usize = 1000;
/// Starts looked at together, which bounds the memory.
const TOGETHER: u64 = 1 << 16;

/// Lower bound on `M_k`.
pub(super) fn search<S: Shape>(family: &Family<S>, k: usize, starts: u64) -> Witness {
    let mut best: Vec<Witness> = Vec::new();
    for first in (0..starts).step_by(TOGETHER as usize) {
        let some = first..starts.min(first + TOGETHER);
        best.par_extend(some.into_par_iter().map(|start| {
            let [a, b, c, d, e, f] = [0, 1, 2, 3, 4, 5].map(|i| uniform(mix(mix(start) ^ i)));
            let x = [a, b, c].map(|x| x * S::SIDE);
            let u = unit([d, e, f].map(|x| x - 0.499));
            let start_at = Witness { value: family.largest(k, x, u), x, u };
            climb(family, k, start_at, mix(start), SHORT, 0.4, 0.88)
        }));
        best.sort_unstable_by(|a, b| b.value.total_cmp(&a.value));
        best.truncate(BEST.min(16 + starts as usize / 100));
    }
    best.par_iter()
        .enumerate()
        .map(|(i, from)| climb(family, k, *from, mix(!(i as u64)), LONG, 0.5, 0.97))
        .reduce_with(|a, b| if b.value > a.value { b } else { a })
        .unwrap_or(Witness { value: 0.0, x: [0.0; 3], u: [1.0, 0.0, 0.0] })
}

/// Random steps that grow with success and shrink by a factor with every failure.
fn climb<S: Shape>(
    family: &Family<S>,
    k: usize,
    from: Witness,
    seed: u64,
    steps: u64,
    step: f64,
    shrink: f64,
) -> Witness {
    let mut state = 0;
    let mut random = || {
        state += 1;
        2.0 * uniform(mix(seed ^ (state << 20))) - 1.0
    };
    let (mut best, mut step) = (from, step);
    for _ in 0..steps {
        let x = best.x.map(|x| (x + S::SIDE * 0.5 * step * random()).clamp(0.0, S::SIDE));
        let u = unit(best.u.map(|u| u + step * random()));
        let value = family.largest(k, x, u);
        if value > best.value {
            best = Witness { value, x, u };
            step = f64::min(2.0 * step, 1.0);
        } else {
            step = f64::max(shrink * step, 1e-9);
        }
    }
    best
}
