//! Steps of the classical method of Runge and Kutta, for any kind of number.

use super::{Code, Parts};
use crate::num::{Jets, Kernel, Many, Number};

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

/// Trajectories of points side by side where there are many: asking for velocities takes little then beside finding them.
const MANY: usize = 64;

/// Where trajectories end.
pub(super) fn ends<V: Code<3>>(velocity: &V, steps: u32, at: [&[f64]; 3]) -> Vec<[f64; 3]> {
    let mut ends = vec![[0.0; 3]; at[0].len()];
    let whole = ends.len() - ends.len() % MANY;
    let (many, few) = ends.split_at_mut(whole);
    carry::<V, MANY>(velocity, steps, at.map(|at| &at[..whole]), many);
    carry::<V, LANES>(velocity, steps, at.map(|at| &at[whole..]), few);
    ends
}

/// Carries points, so many at a time.
fn carry<V: Code<3>, const B: usize>(velocity: &V, steps: u32, at: [&[f64]; 3], ends: &mut [[f64; 3]]) {
    let mut run = velocity.runner();
    let mut speed = |p: &[Many<f64, B>; 3]| match velocity.parts() {
        Parts::Any => run(p),
        Parts::Kernels(parts) => parts.map(|(kernel, k)| value(kernel, p).scale(k)),
        Parts::Slope(kernel, k) => gradient(kernel, p).map(|slope| slope.scale(k)),
    };
    in_lanes(
        at,
        |x, _| x,
        |from| advect(&mut speed, steps, &from, |Many(v)| v.iter().all(|v| *v == 0.0)),
        |i, end| ends[i] = end,
    );
}

/// A kernel at points.
fn value<K: Kernel, const B: usize>(kernel: &K, p: &[Many<f64, B>; 3]) -> Many<f64, B> {
    let mut value = Many([0.0; B]);
    kernel.jets(p.each_ref().map(|p| &p.0[..]), Jets { value: &mut value.0, grad: None, hess: None });
    value
}

/// The slope of a kernel at points, along all three axes at once.
fn gradient<K: Kernel, const B: usize>(kernel: &K, p: &[Many<f64, B>; 3]) -> [Many<f64, B>; 3] {
    let (mut value, mut grad) = ([0.0; B], [Many([0.0; B]); 3]);
    let slopes = grad.each_mut().map(|slope| &mut slope.0[..]);
    kernel.jets(p.each_ref().map(|p| &p.0[..]), Jets { value: &mut value, grad: Some(slopes), hess: None });
    grad
}

/// Puts points through a function in lanes: `start` makes a coordinate, `store` takes a lane of the result. Lanes to
/// spare repeat the last point.
pub(super) fn in_lanes<T: Copy, const B: usize, const N: usize>(
    at: [&[f64]; 3],
    start: impl Fn(f64, usize) -> T,
    mut image: impl FnMut([Many<T, B>; 3]) -> [Many<T, B>; N],
    mut store: impl FnMut(usize, [T; N]),
) {
    let count = at[0].len();
    for first in (0..count).step_by(B) {
        let lane = |axis: usize, i: usize| start(at[axis][(first + i).min(count - 1)], axis);
        let values = image(std::array::from_fn(|axis| Many(std::array::from_fn(|i| lane(axis, i)))));
        for i in 0..B.min(count - first) {
            store(first + i, values.each_ref().map(|Many(lanes)| lanes[i]));
        }
    }
}
