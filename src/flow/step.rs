//! Steps of the classical method of Runge and Kutta, for any kind of number.

use crate::num::Number;

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
