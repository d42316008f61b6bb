//! Steps of the classical method of Runge and Kutta, for any kind of number.

use super::Code;
use crate::num::{Many, Number};

/// `a + k b`.
#[inline]
fn along<T: Number>(a: &[T; 3], k: f64, b: &[T; 3]) -> [T; 3] {
    std::array::from_fn(|axis| a[axis].add(&b[axis].scale(k)))
}

/// Carries a point through so many steps of equal length in a unit of time; it stays where it is if the velocity there is
/// nothing but zero.
pub fn advect<T: Number>(
    mut velocity: impl FnMut(&[T; 3]) -> [T; 3],
    steps: u32,
    from: &[T; 3],
    is_still: impl Fn(&T) -> bool,
) -> [T; 3] {
    let h = 1.0 / f64::from(steps);
    let mut y = from.clone();
    for step in 0..steps {
        let k1 = velocity(&y);
        if step == 0 && k1.iter().all(&is_still) {
            break;
        }
        let k2 = velocity(&along(&y, 0.5 * h, &k1));
        let k3 = velocity(&along(&y, 0.5 * h, &k2));
        let k4 = velocity(&along(&y, h, &k3));
        y = std::array::from_fn(|axis| {
            let sum = k1[axis].add(&k4[axis]).add(&k2[axis].add(&k3[axis]).scale(2.0));
            y[axis].add(&sum.scale(h / 6.0))
        });
    }
    y
}

/// Trajectories side by side.
pub(super) const LANES: usize = 16;

/// Where trajectories end.
pub(super) fn ends<V: Code<3>>(velocity: &V, steps: u32, at: [&[f64]; 3]) -> Vec<[f64; 3]> {
    let mut ends = vec![[0.0; 3]; at[0].len()];
    let mut run = velocity.runner();
    in_lanes(
        at,
        |x, _| x,
        |from| advect(&mut run, steps, &from, |Many(v)| v.iter().all(|v| *v == 0.0)),
        |i, end| ends[i] = end,
    );
    ends
}

/// Puts points through a function in lanes: `start` makes a coordinate, `store` takes a lane of the result. Lanes to
/// spare repeat the last point.
pub(super) fn in_lanes<T: Copy, const N: usize>(
    at: [&[f64]; 3],
    start: impl Fn(f64, usize) -> T,
    mut image: impl FnMut([Many<T, LANES>; 3]) -> [Many<T, LANES>; N],
    mut store: impl FnMut(usize, [T; N]),
) {
    let count = at[0].len();
    for first in (0..count).step_by(LANES) {
        let lane = |axis: usize, i: usize| start(at[axis][(first + i).min(count - 1)], axis);
        let values = image(std::array::from_fn(|axis| Many(std::array::from_fn(|i| lane(axis, i)))));
        for i in 0..LANES.min(count - first) {
            store(first + i, values.each_ref().map(|Many(lanes)| lanes[i]));
        }
    }
}
