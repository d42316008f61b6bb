//! Where a quadratic polynomial is positive for certain.

use crate::num::ROUNDOFF;

/// The first part of [0, 1] in which `c + b t + a t^2` is positive for certain; `[1, 1]` if there is none.
///
/// Roots only propose its ends. A proposal counts where the polynomial is positive beyond rounding at
/// both ends, and at its vertex should that be a minimum between them: then it is so throughout.
pub(super) fn positive(polynomial @ [c, b, a]: [f64; 3]) -> [f64; 2] {
    const NONE: [f64; 2] = [1.0, 1.0];
    let is_positive = |t: f64| {
        let (linear, square) = (b * t, a * t * t);
        c + linear + square > 16.0 * ROUNDOFF * (c.abs() + linear.abs() + square.abs())
    };
    let [start, end] = proposal(polynomial);
    if start >= end || start.is_nan() || end.is_nan() {
        return NONE;
    }
    let vertex = -0.5 * b / a;
    let sure = |from: f64, to: f64| {
        let dips = a > 0.0 && from < vertex && vertex < to;
        is_positive(from) && is_positive(to) && (!dips || is_positive(vertex))
    };
    // Roots are rounded: draw back a little, then more.
    for back in [8.0 * f64::EPSILON, 1e-9, 1e-3] {
        let from = if start > 0.0 { start * (1.0 + back) } else { 0.0 };
        let to = if end < 1.0 { end * (1.0 - back) } else { 1.0 };
        if from < to && sure(from, to) {
            return [from, to];
        }
    }
    NONE
}

/// Where in [0, 1] the polynomial first becomes positive and where it ceases to be, by its roots.
fn proposal([c, b, a]: [f64; 3]) -> [f64; 2] {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 || discriminant.is_nan() {
        return if c > 0.0 { [0.0, 1.0] } else { [1.0, 1.0] };
    }
    // Both roots without cancellation.
    let q = -0.5 * (b + discriminant.sqrt().copysign(b));
    let (r, s) = (q / a, c / q);
    let (low, high) = if r < s { (r, s) } else { (s, r) };
    let within = |t: f64| if t > 0.0 && t < 1.0 { t } else { 1.0 };
    if c > 0.0 {
        // Up to the first root ahead.
        [0.0, if low > 0.0 { within(low) } else { within(high) }]
    } else if a < 0.0 {
        [if low > 0.0 { low } else { 0.0 }, within(high)]
    } else {
        // From the greater root on; a straight line has one root only.
        let root = if high.is_finite() { high } else { low };
        [if root >= 0.0 { root } else { 1.0 }, 1.0]
    }
}
