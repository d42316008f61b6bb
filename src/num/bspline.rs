//! Uniform B-splines: the weights with which the coefficients around a point enter a spline.
//!
//! A spline of degree `d` over the integers is `s(u) = sum_i c_i B(u - i)` with one bump `B` of width
//! `d + 1`, made of polynomials of degree `d` that meet with `d - 1` continuous derivatives. Within
//! one cell only `d + 1` bumps matter, and their values there are polynomials of the position `t` in
//! `[0, 1)` within the cell.
//!
//! What makes B-splines good for certificates (de Boor, *A Practical Guide to Splines*, 2001):
//!
//! - The weights are not negative and their sum is 1, so a spline lies in the hull of the
//!   coefficients that it is made of.
//! - The derivative of a spline is the spline, one degree lower, of the differences of its
//!   coefficients. So differences bound derivatives, by the same argument.
//!
//! Cubic splines are C2, with a second derivative that is linear in each cell; quadratic ones are C1.

use super::Real;

/// The weights of the `N` coefficients around a point, and their derivatives by the position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights<R, const N: usize> {
    /// Weights of the value.
    pub value: [R; N],
    /// Their first derivatives.
    pub first: [R; N],
    /// Their second derivatives.
    pub second: [R; N],
}

/// Weights of the cubic B-spline at `t` in `[0, 1)` beyond coefficient `i`, for the coefficients
/// `i - 1` to `i + 2`.
#[inline(always)]
pub fn cubic<R: Real>(t: R) -> Weights<R, 4> {
    let k = R::of;
    let s = k(1.0) - t;
    let (t2, s2) = (t.square(), s.square());
    let sixth = k(1.0 / 6.0);
    // Both inner weights in the same form, seen from either side.
    let inner = |a: R, a2: R| k(2.0 / 3.0) - a2 * (k(1.0) - a * k(0.5));
    Weights {
        value: [s2 * s * sixth, inner(t, t2), inner(s, s2), t2 * t * sixth],
        first: [-(s2 * k(0.5)), t * (t * k(1.5) - k(2.0)), -(s * (s * k(1.5) - k(2.0))), t2 * k(0.5)],
        second: [s, t * k(3.0) - k(2.0), s * k(3.0) - k(2.0), t],
    }
}

/// Weights of the quadratic B-spline at `t` in `[0, 1)` beyond `i - 1/2`, for the coefficients
/// `i - 1` to `i + 1`. Coefficient `i` is the one nearest to the point.
#[inline(always)]
pub fn quadratic<R: Real>(t: R) -> Weights<R, 3> {
    let k = R::of;
    let s = k(1.0) - t;
    Weights {
        value: [s.square() * k(0.5), k(0.5) + t * s, t.square() * k(0.5)],
        first: [-s, s - t, t],
        second: [k(1.0), k(-2.0), k(1.0)],
    }
}

/// The pole of the filter that turns samples into coefficients of the cubic spline through them:
/// the root of `z^2 + 4 z + 1` inside the unit circle, `sqrt(3) - 2`.
pub const CUBIC_POLE: f64 = -0.267_949_192_431_122_7;

/// What follows beyond the ends of a sequence.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Edge {
    /// The sequence again.
    Repeat,
    /// Its last element for ever.
    Clamp,
}

/// Replaces samples by the coefficients of the cubic spline through them: solves
/// `(c_(i-1) + 4 c_i + c_(i+1)) / 6 = s_i`, where elements beyond the ends are those that `edge` says.
///
/// The matrix is the product of two filters of one pole, one for each direction (Unser, Aldroubi and
/// Eden 1993, *B-spline signal processing*). Where they start is known in closed form: a repeated
/// sequence has passed through the filter infinitely often; and the system of a clamped one is that
/// of its mirror image, since both say `c_(-1) = c_0`, and no equation asks for more.
pub fn interpolate_cubic(line: &mut [f64], edge: Edge) {
    let n = line.len();
    if n < 2 {
        return;
    }
    let z = CUBIC_POLE;
    let period = Real::powi(z, n.min(1 << 20) as i32);
    // Powers of the pole vanish soon.
    let near = n.min(64);
    line[0] = match edge {
        Edge::Repeat => {
            let back = (1..near).rev().fold(0.0, |sum, k| (sum + line[n - k]) * z);
            (line[0] + back) / (1.0 - period)
        }
        Edge::Clamp => {
            let there = (0..near).rev().fold(0.0, |sum, k| sum * z + line[k]);
            let again = (0..near).rev().fold(0.0, |sum, k| sum * z + line[n - 1 - k]) * period;
            line[0] + z * (there + again) / (1.0 - period * period)
        }
    };
    for i in 1..n {
        line[i] += z * line[i - 1];
    }
    line[n - 1] = match edge {
        Edge::Repeat => {
            let ahead = (0..near - 1).rev().fold(0.0, |sum, k| sum * z + line[k]) * z;
            // With every element of a short sequence the sum is complete, else nearly.
            -z * (line[n - 1] + ahead) / (1.0 - period)
        }
        Edge::Clamp => line[n - 1] * z / (z - 1.0),
    };
    for i in (0..n - 1).rev() {
        line[i] = z * (line[i + 1] - line[i]);
    }
    line.iter_mut().for_each(|c| *c *= 6.0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::{Interval, ROUNDOFF};

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-13
    }

    #[test]
    fn weights_are_not_negative_and_sum_to_one() {
        for i in 0..1000 {
            let t = f64::from(i) / 1000.0;
            let (c, q) = (cubic(t), quadratic(t));
            assert!(c.value.iter().all(|w| *w >= 0.0) && q.value.iter().all(|w| *w >= 0.0));
            assert!((c.value.iter().sum::<f64>() - 1.0).abs() < 8.0 * ROUNDOFF);
            assert!((q.value.iter().sum::<f64>() - 1.0).abs() < 8.0 * ROUNDOFF);
            for sum in [c.first.iter().sum(), c.second.iter().sum(), q.first.iter().sum::<f64>()] {
                assert!(close(sum, 0.0));
            }
            // Splines of coefficients on a line are that line.
            assert!(close(c.value[2] - c.value[0] + 2.0 * c.value[3], t));
            assert!(close(q.value[2] - q.value[0], t - 0.5));
        }
    }

    #[test]
    fn pieces_meet_and_derivatives_are_derivatives() {
        let (end, start) = (cubic(1.0), cubic(0.0));
        for k in 0..3 {
            assert!(close(end.value[k + 1], start.value[k]));
            assert!(close(end.first[k + 1], start.first[k]));
            assert!(close(end.second[k + 1], start.second[k]));
        }
        let (end, start) = (quadratic(1.0), quadratic(0.0));
        for k in 0..2 {
            assert!(close(end.value[k + 1], start.value[k]));
            assert!(close(end.first[k + 1], start.first[k]));
        }
        let h = 1e-4;
        for i in 1..50 {
            let t = f64::from(i) / 50.0;
            let (a, m, b) = (cubic(t - h), cubic(t), cubic(t + h));
            for k in 0..4 {
                assert!(((b.value[k] - a.value[k]) / (2.0 * h) - m.first[k]).abs() < 1e-7);
                assert!(((b.first[k] - a.first[k]) / (2.0 * h) - m.second[k]).abs() < 1e-7);
            }
            let (a, m, b) = (quadratic(t - h), quadratic(t), quadratic(t + h));
            for k in 0..3 {
                assert!(((b.value[k] - a.value[k]) / (2.0 * h) - m.first[k]).abs() < 1e-7);
                assert!(((b.first[k] - a.first[k]) / (2.0 * h) - m.second[k]).abs() < 1e-7);
            }
        }
    }

    #[test]
    fn weights_over_intervals_enclose() {
        let over = cubic(Interval::new(0.25, 0.5));
        for i in 0..=20 {
            let at = cubic(0.25 + 0.0125 * f64::from(i));
            for k in 0..4 {
                assert!(over.value[k].contains(at.value[k]) && over.first[k].contains(at.first[k]));
            }
        }
    }

    #[test]
    fn interpolation_passes_through_the_samples() {
        for n in [1usize, 2, 3, 4, 5, 7, 16, 63, 64, 65, 200] {
            let samples: Vec<f64> =
                (0..n).map(|i| ((i * i * 37 + 11 * i) % 101) as f64 / 50.0 - 1.0).collect();
            for edge in [Edge::Repeat, Edge::Clamp] {
                let mut c = samples.clone();
                interpolate_cubic(&mut c, edge);
                for i in 0..n {
                    let (before, after) = match edge {
                        Edge::Repeat => (c[(i + n - 1) % n], c[(i + 1) % n]),
                        Edge::Clamp => (c[i.max(1) - 1], c[(i + 1).min(n - 1)]),
                    };
                    let s = (before + 4.0 * c[i] + after) / 6.0;
                    assert!(close(s, samples[i]), "{edge:?} {n} {i}: {s} {}", samples[i]);
                }
            }
        }
    }
}
