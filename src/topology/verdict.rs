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
use crate::num::{Taylor, Taylors, widest};
use glam::DVec3;

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
    #[inline(always)]
    fn are_apart_from(&self, middle: [f64; 3], share: [f64; 3]) -> bool {
        let (zeros, half) = (self.middle.to_array(), self.half.to_array());
        let apart = |axis: usize| {
            let between = (zeros[axis] - middle[axis]).abs() * (1.0 - 1e-12);
            between > share[axis] + half[axis] + 1e-12 * middle[axis].abs()
        };
        apart(0) | apart(1) | apart(2)
    }
}

/// What the tests say that need no inverse, E0 to E2; they drop most cells.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sifted {
    /// The cell is outside of the solid.
    pub outside: bool,
    /// The gradient does not vanish in it.
    pub regular: bool,
}

/// Sifts cells side by side, by half their extents in units of their balls. Of those that are flat it says nothing.
pub fn sift<const B: usize>(f: &Taylors<B>, shares: &[[f64; B]; 3], solid: bool) -> [Sifted; B] {
    let mut out = [Sifted::default(); B];
    widest(
        #[inline(always)]
        || {
            let (mut outside, mut regular) = ([false; B], [false; B]);
            for i in 0..B {
                let share = [shares[0][i], shares[1][i], shares[2][i]];
                let full = (share[0] > 0.0) & (share[1] > 0.0) & (share[2] > 0.0);
                let lane = f.lane(i);
                outside[i] = full & solid & is_outside(&lane, share);
                regular[i] = full & (is_steep(&lane) | is_regular(&lane, share));
            }
            for i in 0..B {
                out[i] = Sifted { outside: outside[i], regular: regular[i] };
            }
        },
    );
    out
}

/// E1
#[inline(always)]
fn is_steep(f: &Taylor) -> bool {
    let [x, y, z] = f.grad;
    x * x + y * y + z * z > f.turn[0] * f.turn[0] * (1.0 + 1e-12)
}

/// E2
#[inline(always)]
fn is_regular(f: &Taylor, share: [f64; 3]) -> bool {
    let turn = turns(f.hess, share);
    let leaves = |axis: usize| f.grad[axis].abs() * (1.0 - 1e-12) > turn[axis] + f.turn[1];
    leaves(0) | leaves(1) | leaves(2)
}

/// By how much the gradient turns along each axis to the farthest of a box, by the sizes of second derivatives.
#[inline(always)]
fn turns(hess: [f64; 6], [x, y, z]: [f64; 3]) -> [f64; 3] {
    let [xx, yy, zz, xy, xz, yz] = hess.map(f64::abs);
    [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z]
}

/// What is certain of a cell with these half extents in units of the ball. Values are of interest below zero
/// only if `solid`.
pub fn judge(f: &Taylor, share: DVec3, solid: bool) -> Verdict {
    if solid && is_outside(f, share.to_array()) {
        return Verdict::Outside;
    }
    if is_steep(f) {
        return Verdict::Regular;
    }
    let g = DVec3::from_array(f.grad);
    if g == DVec3::ZERO && f.turn[0] <= 1e-100 {
        return Verdict::Critical;
    }
    if is_regular(f, share.to_array()) {
        return Verdict::Regular;
    }
    let Some((y, least, defect)) = inverse(&matrix(f.hess)) else { return Verdict::Open(Zeros::ANYWHERE) };
    let step = y * g;
    let rounding = defect + 16.0 * f64::EPSILON * spectral(&y) * g.length();
    let row = |axis: usize| y.row(axis).length() * f.turn[1] + rounding;
    let zeros = Zeros { middle: -step, half: DVec3::new(row(0), row(1), row(2)) };
    if zeros.are_apart_from([0.0; 3], share.to_array()) {
        return Verdict::Regular;
    }
    if least > f.twist { Verdict::Single } else { Verdict::Open(zeros) }
}

/// Whether the values in the cell are positive.
#[inline(always)]
pub fn is_outside(f: &Taylor, w: [f64; 3]) -> bool {
    let [x, y, z] = f.grad.map(f64::abs);
    let first = x * w[0] + y * w[1] + z * w[2];
    let [xx, yy, zz, xy, xz, yz] = f.hess;
    let down = |bend: f64, w: f64| (if bend < 0.0 { bend } else { 0.0 }) * w * w;
    let dips = down(xx, w[0]) + down(yy, w[1]) + down(zz, w[2]);
    let twists = xy.abs() * w[0] * w[1] + xz.abs() * w[0] * w[2] + yz.abs() * w[1] * w[2];
    let curved = f.value + 0.5 * dips - (twists + first + f.bow[1]) * (1.0 + 1e-12);
    (f.range.lo > 0.0)
        | (f.value - (first + f.bow[0]) * (1.0 + 1e-12) > 0.0)
        | (curved > 1e-12 * f.value.abs())
}

/// Parts of a cell, at most.
pub const PARTS: usize = 8;

/// Which parts of a cell are outside of the solid, or free of critical points, by what is known of the whole cell: E0
/// and E2 with the expansion about the part's middle, and E3. It costs little beside an evaluation, and often saves one.
/// `share` are half the extents of all parts, and `middles` is where each lies, axis by axis, in units of the ball.
pub fn free_parts(
    f: &Taylor,
    zeros: &Zeros,
    (share, middles): ([f64; 3], &[[f64; PARTS]; 3]),
    solid: bool,
) -> [bool; PARTS] {
    let mut free = [false; PARTS];
    let turn = turns(f.hess, share);
    let dips = 0.5 * (turn[0] * share[0] + turn[1] * share[1] + turn[2] * share[2]);
    widest(
        #[inline(always)]
        || {
            for i in 0..PARTS {
                let middle = [middles[0][i], middles[1][i], middles[2][i]];
                let [a, b, c] = middle;
                let [xx, yy, zz, xy, xz, yz] = f.hess;
                let bent = [xx * a + xy * b + xz * c, xy * a + yy * b + yz * c, xz * a + yz * b + zz * c];
                let rounded = turns(f.hess, middle.map(f64::abs));
                let (mut leaves, mut value, mut first) = (false, f.value, 0.0);
                for axis in 0..3 {
                    let g = (f.grad[axis] + bent[axis]).abs();
                    leaves |= g * (1.0 - 1e-12) > turn[axis] + rounded[axis] * 1e-12 + f.turn[1];
                    value += (f.grad[axis] + 0.5 * bent[axis]) * middle[axis];
                    first += g * share[axis];
                }
                let outside = value - (first + dips + f.bow[1]) * (1.0 + 1e-12) > 1e-12 * f.value.abs();
                free[i] = leaves | (solid & outside) | zeros.are_apart_from(middle, share);
            }
        },
    );
    free
}
