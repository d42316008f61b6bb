//! What is known of a velocity over balls.
//!
//! Any velocity says so by Taylor expansions. Most are noises, though, with a factor, at the point itself, or the slope of
//! one: these are asked directly, many balls at a time, which is several times quicker. With `H` the second derivatives
//! of a noise in the middle of a ball of radius `r`, and `M2`, `M3` its bounds,
//!
//! ```text
//! a component      slope k g    bow k min(M2 r^2 / 2, |H| r^2 / 2 + M3 r^3 / 6)
//! a slope          slope k H    bow k M3 r^2 / 2
//! ```
//!
//! The derivatives of a slope are a symmetric matrix, of which these are bounds as a whole.

use super::tube::{Rounding, UP, larger, least, length};
use crate::num::{Jets, Kernel, ROUNDOFF, Taylor, widest};

/// Matrices by rows.
pub(super) type Matrix = [[f64; 3]; 3];

/// What a velocity is made of.
#[derive(Debug)]
pub enum Parts<'a, K> {
    /// Anything.
    Any,
    /// Three kernels at the point, with factors.
    Kernels([(&'a K, f64); 3]),
    /// The slope of a kernel at the point, with a factor.
    Slope(&'a K, f64),
}

/// A velocity over a ball.
#[derive(Clone, Copy, Default)]
pub(super) struct Stage {
    pub velocity: [f64; 3],
    pub slope: Matrix,
    /// What `slope` leaves out of the velocity over the ball.
    pub bow: f64,
    /// How far the velocity may be from the one in the middle.
    pub spread: f64,
    /// Bounds on first and second derivatives over the ball.
    pub steep: f64,
    pub bent: f64,
}

impl Stage {
    /// Whether nothing moves.
    pub fn is_still(&self) -> bool {
        self.velocity == [0.0; 3] && self.spread == 0.0
    }

    /// From what is known of the components. Derivatives of a gradient are a symmetric matrix, of which bounds on the rows
    /// are bounds on the whole; what is rounded is not.
    #[inline(always)]
    pub fn new(u: &[Taylor; 3], radius: f64, is_gradient: bool, rounding: Rounding) -> Stage {
        let (mut velocity, mut slope) = ([0.0; 3], [[0.0; 3]; 3]);
        let (mut bow, mut spread, mut steep, mut bent) = ([0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3]);
        let scale = 1.0 / radius;
        for i in 0..3 {
            velocity[i] = u[i].value;
            for j in 0..3 {
                slope[i][j] = u[i].grad[j] * scale;
            }
            bow[i] = u[i].bow[0];
            spread[i] = larger(u[i].range.hi - u[i].value, u[i].value - u[i].range.lo);
            steep[i] = u[i].steepness();
            bent[i] = u[i].curvature();
        }
        let all = |rows: [f64; 3]| {
            let [a, b, c] = rows;
            if is_gradient { larger(larger(a, b), c) } else { length(rows) }
        };
        let rounded = if is_gradient { 2.0 * (rounding.value + rounding.grad * radius) } else { 0.0 };
        Stage {
            velocity,
            slope,
            bow: all(bow) + rounded,
            spread: length(spread),
            steep: all(steep) * scale + rounding.grad,
            bent: all(bent) * scale * scale,
        }
    }
}

/// Jets of a kernel in the middles of balls.
struct Middles<const B: usize> {
    value: [f64; B],
    grad: [[f64; B]; 3],
    hess: [[f64; B]; 6],
}

impl<const B: usize> Middles<B> {
    #[inline(always)]
    fn new<K: Kernel>(kernel: &K, at: &[[f64; B]; 3]) -> Self {
        let mut own = Middles { value: [0.0; B], grad: [[0.0; B]; 3], hess: [[0.0; B]; 6] };
        let out = Jets {
            value: &mut own.value,
            grad: Some(own.grad.each_mut().map(|g| &mut g[..])),
            hess: Some(own.hess.each_mut().map(|h| &mut h[..])),
        };
        kernel.jets([&at[0], &at[1], &at[2]], out);
        own
    }

    /// The Frobenius norm of the second derivatives.
    #[inline(always)]
    fn curvature(&self, i: usize) -> f64 {
        let h = &self.hess;
        let square = h[0][i] * h[0][i] + h[1][i] * h[1][i] + h[2][i] * h[2][i];
        (square + 2.0 * (h[3][i] * h[3][i] + h[4][i] * h[4][i] + h[5][i] * h[5][i])).sqrt() * UP
    }

    #[inline(always)]
    fn gradient(&self, i: usize) -> [f64; 3] {
        [self.grad[0][i], self.grad[1][i], self.grad[2][i]]
    }
}

/// Three kernels over balls.
pub(super) fn of_kernels<K: Kernel, const B: usize>(
    parts: &[(&K, f64); 3],
    at: &[[f64; B]; 3],
    radius: &[f64; B],
    out: &mut [Stage; B],
) {
    let mut sums = [[0.0; 4]; B];
    *out = [Stage::default(); B];
    for (row, (kernel, k)) in parts.iter().enumerate() {
        let (bounds, (k, size)) = (kernel.bounds(), (*k, k.abs()));
        let (start, one) = (kernel.error(0.0), kernel.error(1.0));
        let middles = Middles::new(*kernel, at);
        widest(
            #[inline(always)]
            || {
                for i in 0..B {
                    let far = larger(larger(at[0][i].abs(), at[1][i].abs()), at[2][i].abs());
                    let error = |order: usize| start[order] + (one[order] - start[order]) * far;
                    let (r, h, g) = (radius[i], middles.curvature(i) + error(2), middles.gradient(i));
                    let third = bounds.third * r;
                    let bend = least(bounds.hessian, h + third);
                    let bow = least(0.5 * bounds.hessian, 0.5 * h + third / 6.0) * r * r;
                    let steep = least(
                        bounds.lipschitz,
                        length(g) + error(1) + least(h + 0.5 * third, bounds.hessian) * r,
                    );
                    // A factor rounds once more.
                    let rounded = error(0)
                        + 2.0 * error(1) * r
                        + 4.0 * ROUNDOFF * (middles.value[i].abs() + length(g) * r);
                    let own = [
                        bow + rounded,
                        least(steep * r, bounds.range + middles.value[i].abs()) + rounded,
                        steep,
                        bend,
                    ];
                    for (sum, own) in sums[i].iter_mut().zip(own) {
                        *sum += size * own * size * own;
                    }
                    out[i].velocity[row] = k * middles.value[i];
                    for axis in 0..3 {
                        out[i].slope[row][axis] = k * g[axis];
                    }
                }
            },
        );
    }
    for (out, sums) in out.iter_mut().zip(sums) {
        let [bow, spread, steep, bent] = sums.map(|sum| sum.sqrt() * UP);
        *out = Stage { bow, spread, steep, bent, ..*out };
    }
}

/// The slope of a kernel over balls.
pub(super) fn of_slope<K: Kernel, const B: usize>(
    kernel: &K,
    k: f64,
    at: &[[f64; B]; 3],
    radius: &[f64; B],
    out: &mut [Stage; B],
) {
    let (bounds, size) = (kernel.bounds(), k.abs());
    let (start, one) = (kernel.error(0.0), kernel.error(1.0));
    let middles = Middles::new(kernel, at);
    widest(
        #[inline(always)]
        || {
            for i in 0..B {
                let far = larger(larger(at[0][i].abs(), at[1][i].abs()), at[2][i].abs());
                let error = |order: usize| start[order] + (one[order] - start[order]) * far;
                let (r, g) = (radius[i], middles.gradient(i));
                let [xx, yy, zz, xy, xz, yz] = middles.hess.each_ref().map(|h| k * h[i]);
                let steep = least(bounds.hessian, middles.curvature(i) + error(2) + bounds.third * r);
                let rounded =
                    2.0 * (error(1) + error(2) * r) + 4.0 * ROUNDOFF * (length(g) + middles.curvature(i) * r);
                out[i] = Stage {
                    velocity: [k * g[0], k * g[1], k * g[2]],
                    slope: [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]],
                    bow: size * (0.5 * bounds.third * r * r + rounded) * UP,
                    spread: size * (least(steep * r, bounds.lipschitz + length(g)) + rounded) * UP,
                    steep: size * steep * UP,
                    bent: size * bounds.third * UP,
                };
            }
        },
    );
}
