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

use super::cell::SIDES;
use super::matrix::{Inverse, inverse, rows};
use crate::num::{Taylor, Taylors, widest};

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
    middle: [f64; 3],
    half: [f64; 3],
}

impl Zeros {
    /// By the inverse of the second derivatives. Where they have none, zeros may be anywhere.
    #[inline(always)]
    fn new(f: &Taylor, inverse: &Inverse) -> Zeros {
        let [x, y, z] = f.grad;
        let slope = (x * x + y * y + z * z).sqrt();
        let rounding = inverse.defect + 16.0 * f64::EPSILON * inverse.norm * slope;
        let (step, rows) = (inverse.times(f.grad), rows(inverse.entries));
        let mut zeros = Zeros { middle: [0.0; 3], half: [f64::INFINITY; 3] };
        for axis in 0..3 {
            let [x, y, z] = rows[axis];
            let row = (x * x + y * y + z * z).sqrt();
            zeros.middle[axis] = if inverse.exists() { -step[axis] } else { 0.0 };
            zeros.half[axis] = if inverse.exists() { row * f.turn[1] + rounding } else { f64::INFINITY };
        }
        zeros
    }

    /// Whether it is apart from a part of the cell, by the part's middle and half its extents.
    #[inline(always)]
    fn are_apart_from(&self, middle: [f64; 3], share: [f64; 3]) -> bool {
        let apart = |axis: usize| {
            let between = (self.middle[axis] - middle[axis]).abs() * (1.0 - 1e-12);
            between > share[axis] + self.half[axis] + 1e-12 * middle[axis].abs()
        };
        apart(0) | apart(1) | apart(2)
    }
}

/// What is certain of cells side by side.
#[derive(Clone, Debug)]
pub struct Verdicts<const B: usize> {
    outside: [bool; B],
    regular: [bool; B],
    critical: [bool; B],
    single: [bool; B],
    /// Middles and half extents of boxes of zeros, axis by axis.
    zeros: [[[f64; B]; 3]; 2],
}

impl<const B: usize> Verdicts<B> {
    /// Of a cell.
    pub fn of(&self, i: usize) -> Verdict {
        if self.outside[i] {
            Verdict::Outside
        } else if self.regular[i] {
            Verdict::Regular
        } else if self.critical[i] {
            Verdict::Critical
        } else if self.single[i] {
            Verdict::Single
        } else {
            let [middle, half] = self.zeros.map(|part| part.map(|lanes| lanes[i]));
            Verdict::Open(Zeros { middle, half })
        }
    }
}

/// What is certain of cells with these half extents in units of their balls. Values are of interest below zero only if
/// `solid`.
pub fn judge<const B: usize>(f: &Taylors<B>, shares: &[[f64; B]; 3], solid: bool) -> Verdicts<B> {
    // Arrays of their own: the compiler knows that nothing that is read is in them.
    widest(
        #[inline(always)]
        || {
            let (mut outside, mut regular) = ([false; B], [false; B]);
            for i in 0..B {
                let (lane, share) = (f.lane(i), [shares[0][i], shares[1][i], shares[2][i]]);
                outside[i] = solid & is_outside(&lane, share);
                regular[i] = is_steep(&lane) | is_regular(&lane, share);
            }
            let (mut critical, mut single) = ([false; B], [false; B]);
            let mut zeros = [[[f64::INFINITY; B]; 3]; 2];
            // Without an inverse most cells are dropped already.
            if (0..B).any(|i| !(outside[i] | regular[i])) {
                for i in 0..B {
                    let (lane, share) = (f.lane(i), [shares[0][i], shares[1][i], shares[2][i]]);
                    let inverse = inverse(lane.hess);
                    let own = Zeros::new(&lane, &inverse);
                    critical[i] = is_level(&lane);
                    regular[i] |= !critical[i] & own.are_apart_from([0.0; 3], share);
                    single[i] = inverse.least > lane.twist;
                    for axis in 0..3 {
                        (zeros[0][axis][i], zeros[1][axis][i]) = (own.middle[axis], own.half[axis]);
                    }
                }
            }
            Verdicts { outside, regular, critical, single, zeros }
        },
    )
}

/// Whether the gradient is zero all over a ball.
#[inline(always)]
fn is_level(f: &Taylor) -> bool {
    let [x, y, z] = f.grad;
    (x == 0.0) & (y == 0.0) & (z == 0.0) & (f.turn[0] <= 1e-100)
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
    let [xx, yy, zz] = [hess[0].abs(), hess[1].abs(), hess[2].abs()];
    let [xy, xz, yz] = [hess[3].abs(), hess[4].abs(), hess[5].abs()];
    [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z]
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

/// Which octants of a cell are outside of the solid, or free of critical points, by what is known of the whole cell: E0
/// and E2 with the expansion about the octant's middle, and E3. It costs little beside an evaluation, and often saves one.
/// `share` are half their extents, and their middles are `off` to one or the other side along each axis, in units of the
/// ball.
pub fn free_parts(f: &Taylor, zeros: &Zeros, (share, off): ([f64; 3], [f64; 3]), solid: bool) -> [bool; 8] {
    widest(
        #[inline(always)]
        || {
            let (f, zeros, mut free) = (*f, *zeros, [false; 8]);
            let [xx, yy, zz, xy, xz, yz] = f.hess;
            let turn = turns(f.hess, share);
            let dips = 0.5 * (turn[0] * share[0] + turn[1] * share[1] + turn[2] * share[2]);
            for i in 0..8 {
                let middle = [off[0] * SIDES[0][i], off[1] * SIDES[1][i], off[2] * SIDES[2][i]];
                let [a, b, c] = middle;
                let bent = [xx * a + xy * b + xz * c, xy * a + yy * b + yz * c, xz * a + yz * b + zz * c];
                let rounded = turns(f.hess, [a.abs(), b.abs(), c.abs()]);
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
            free
        },
    )
}
