//! What one evaluation says of critical points in a cell.
//!
//! With the gradient `g + H u` but for `turn_1` in the ball around the cell, `|u| <= 1`, `|u_a| <= w_a` in the
//! cell itself, there is no critical point where one of these holds (numbers as in the prototype):
//!
//! ```text
//! E0  f > 0 throughout, by its range or by its expansion to either order      (only the solid is of interest)
//! E1  |g| > turn_0
//! E2  |g_a| > sum_b w_b |H_ab| + turn_1          for an axis a
//! E3  |(Y g)_a| > w_a + |row_a Y| turn_1         for an axis a, with Y = H^-1 up to rounding
//! ```
//!
//! E3 is Krawczyk's test: a zero has `u = -Y g - Y (grad f - g - H u) + (I - Y H) u`. And there is at most one
//! where the smallest eigenvalue of `H`, in size, exceeds `twist`: then every mean of Hessians in the ball
//! can be inverted, and the gradient takes no value twice.

use super::matrix::{inverse, matrix, spectral};
use crate::num::Taylor;
use glam::{DMat3, DVec3};

/// What is certain of a cell.
#[derive(Clone, Copy, Debug)]
pub enum Verdict {
    /// It is outside of the solid.
    Outside,
    /// The gradient does not vanish in it.
    Regular,
    /// The gradient vanishes all over it, but for rounding, so that no critical point is isolated.
    Critical,
    /// The gradient vanishes at most once in the ball around it.
    Single,
    /// Nothing, but that zeros of the gradient are here, if anywhere.
    Open(Zeros),
}

/// A box that holds all zeros of the gradient in a ball, in units of the ball: E3 without its comparison.
#[derive(Clone, Copy, Debug)]
pub struct Zeros {
    middle: DVec3,
    half: DVec3,
}

impl Zeros {
    /// Where nothing is known.
    const ANYWHERE: Zeros = Zeros { middle: DVec3::ZERO, half: DVec3::INFINITY };

    /// Whether it is apart from a part of the cell, by the part's middle and half its extents.
    fn are_apart_from(&self, middle: DVec3, share: DVec3) -> bool {
        let between = (self.middle - middle).abs() * (1.0 - 1e-12);
        between.cmpgt(share + self.half + 1e-12 * middle.abs()).any()
    }
}

/// What is certain of a cell with these half extents in units of the ball. Values are of interest below zero
/// only if `solid`.
pub fn judge(f: &Taylor, share: DVec3, solid: bool) -> Verdict {
    if solid && is_outside(f, share) {
        return Verdict::Outside;
    }
    let g = DVec3::from_array(f.grad);
    if g.length_squared() > f.turn[0] * f.turn[0] * (1.0 + 1e-12) {
        return Verdict::Regular;
    }
    if g == DVec3::ZERO && f.turn[0] <= 1e-100 {
        return Verdict::Critical;
    }
    let h = matrix(f.hess);
    let rows = DMat3::from_cols(h.x_axis.abs(), h.y_axis.abs(), h.z_axis.abs());
    if (g.abs() * (1.0 - 1e-12)).cmpgt(rows * share + f.turn[1]).any() {
        return Verdict::Regular;
    }
    let Some((y, least, defect)) = inverse(&h) else { return Verdict::Open(Zeros::ANYWHERE) };
    let step = y * g;
    let rounding = defect + 16.0 * f64::EPSILON * spectral(&y) * g.length();
    let row = |axis: usize| y.row(axis).length() * f.turn[1] + rounding;
    let zeros = Zeros { middle: -step, half: DVec3::new(row(0), row(1), row(2)) };
    if zeros.are_apart_from(DVec3::ZERO, share) {
        return Verdict::Regular;
    }
    if least > f.twist { Verdict::Single } else { Verdict::Open(zeros) }
}

/// Whether the values in the cell are positive.
pub fn is_outside(f: &Taylor, share: DVec3) -> bool {
    let [x, y, z] = f.grad.map(f64::abs);
    let first = x * share.x + y * share.y + z * share.z;
    if f.range.lo > 0.0 || f.value - (first + f.bow[0]) * (1.0 + 1e-12) > 0.0 {
        return true;
    }
    let [xx, yy, zz, xy, xz, yz] = f.hess;
    let w = share;
    let dips = xx.min(0.0) * w.x * w.x + yy.min(0.0) * w.y * w.y + zz.min(0.0) * w.z * w.z;
    let twists = xy.abs() * w.x * w.y + xz.abs() * w.x * w.z + yz.abs() * w.y * w.z;
    f.value + 0.5 * dips - (twists + first + f.bow[1]) * (1.0 + 1e-12) > 1e-12 * f.value.abs()
}

/// Whether a part of a cell is outside of the solid, or free of critical points, by what is known of the whole cell: E0
/// and E2 with the expansion about the part's middle, and E3. It costs little beside an evaluation, and often saves one.
/// `share` are half the extents of the part, and `middle` is where it lies, in units of the ball.
pub fn is_free(f: &Taylor, zeros: &Zeros, (share, middle): (DVec3, DVec3), solid: bool) -> bool {
    if zeros.are_apart_from(middle, share) {
        return true;
    }
    let h = matrix(f.hess);
    let bent = h * middle;
    let g = DVec3::from_array(f.grad) + bent;
    let rows = DMat3::from_cols(h.x_axis.abs(), h.y_axis.abs(), h.z_axis.abs());
    let turns = rows * share;
    if (g.abs() * (1.0 - 1e-12)).cmpgt((turns + rows * middle.abs() * 1e-12) + f.turn[1]).any() {
        return true;
    }
    let value = f.value + (DVec3::from_array(f.grad) + 0.5 * bent).dot(middle);
    solid
        && value - (g.abs().dot(share) + 0.5 * turns.dot(share) + f.bow[1]) * (1.0 + 1e-12)
            > 1e-12 * f.value.abs()
}
