//! One tetrahedron with a polynomial in Bernstein form (Gamito 2009, 2.2.3).
//!
//! ```text
//! f = sum over |n| = d of b_n d! / (i! j! k! l!) r^i s^j t^k u^l,     n = (i, j, k, l),  (r, s, t, u) barycentric
//! ```
//!
//! The polynomial and each of its derivatives lie in the hull of their coefficients.

use crate::num::{Order, PAIRS, Point};
use glam::{DMat3, DVec3};

/// Highest degree.
pub const HIGHEST: usize = 6;

/// Coefficients of a polynomial of a degree.
pub const fn count(degree: usize) -> usize {
    (degree + 1) * (degree + 2) * (degree + 3) / 6
}

const MOST: usize = count(HIGHEST);

/// The place of a coefficient: those with the highest power of the first corner come first, then of the
/// second, then of the third. It does not depend on the power of the first, and so not on the degree.
pub fn place([_, j, k, l]: [usize; 4]) -> usize {
    let (n, m) = (j + k + l, k + l);
    n * (n + 1) * (n + 2) / 6 + m * (m + 1) / 2 + l
}

/// All powers of a degree, in order.
pub fn powers(degree: usize) -> impl Iterator<Item = [usize; 4]> {
    let row = move |n: usize| (0..=n).flat_map(move |m| (0..=m).map(move |l| [degree - n, n - m, m - l, l]));
    (0..=degree).flat_map(row)
}

/// A tetrahedron and a polynomial.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Corners.
    pub corners: [DVec3; 4],
    /// Gradients of the barycentric coordinates.
    pub slopes: [DVec3; 4],
    /// Coefficients.
    pub coefficients: Vec<f64>,
    degree: usize,
}

impl Cell {
    /// The polynomial over a tetrahedron; none if that is flat.
    pub fn new(corners: [DVec3; 4], coefficients: Vec<f64>, degree: usize) -> Option<Cell> {
        let [a, b, c, d] = corners;
        let edges = DMat3::from_cols(b - a, c - a, d - a);
        let inverse = edges.inverse().transpose();
        let [s, t, u] = [inverse.x_axis, inverse.y_axis, inverse.z_axis];
        let cell = Cell { corners, slopes: [-(s + t + u), s, t, u], coefficients, degree };
        // Heights over the faces are one over the slopes.
        let flat = cell.steepness().partial_cmp(&1e6).is_none_or(|o| o.is_ge());
        (!flat).then_some(cell)
    }

    /// Longest edge by least height: 1.2 if all edges are equal, large for a splinter.
    pub fn steepness(&self) -> f64 {
        let slope = self.slopes.iter().map(|g| g.length()).fold(0.0, f64::max);
        let [a, b, c, d] = self.corners;
        let edges = [b - a, c - a, d - a, c - b, d - b, d - c];
        let steep = slope * edges.iter().map(|e| e.length()).fold(0.0, f64::max);
        if self.slopes.iter().all(|g| g.is_finite()) { steep } else { f64::INFINITY }
    }

    /// Barycentric coordinates.
    pub fn barycentric(&self, x: DVec3) -> [f64; 4] {
        let d = x - self.corners[0];
        let [_, s, t, u] = self.slopes.map(|g| g.dot(d));
        [1.0 - s - t - u, s, t, u]
    }

    /// The jet at a point, by de Casteljau's steps; the last nets but one and two give the derivatives.
    pub fn jet(&self, order: Order, x: DVec3) -> Point {
        let at = self.barycentric(x);
        let d = self.degree;
        let mut net = [0.0; MOST];
        net[..self.coefficients.len()].copy_from_slice(&self.coefficients);
        let mut out = Point::default();
        let (times, twice) = (d as f64, (d * d.saturating_sub(1)) as f64);
        for level in (0..=d).rev() {
            if level == 2 && order == Order::Hessian {
                for (pair, (r, c)) in PAIRS.into_iter().enumerate() {
                    let term = |[m, n]: [usize; 2]| {
                        let mut power = [0; 4];
                        power[m] += 1;
                        power[n] += 1;
                        net[place(power)] * self.slopes[m][r] * self.slopes[n][c]
                    };
                    let all = (0..16).map(|k| [k / 4, k % 4]);
                    out.hess[pair] = twice * all.map(term).sum::<f64>();
                }
            }
            if level == 1 {
                let grad = (0..4).fold(DVec3::ZERO, |sum, m| sum + net[m] * self.slopes[m]);
                out.grad = (times * grad).into();
            }
            if level > 0 {
                step(&mut net, level, at);
            }
        }
        out.value = net[0];
        out
    }

    /// Bounds on the gradient and on second derivatives within the cell.
    pub fn bounds(&self) -> [f64; 2] {
        let (d, up) = (self.degree, 1.0 + 1e-9);
        let raised = |mut power: [usize; 4], by: &[usize]| {
            by.iter().for_each(|m| power[*m] += 1);
            self.coefficients[place(power)]
        };
        let slope =
            |power| (0..4).fold(DVec3::ZERO, |sum, m| sum + raised(power, &[m]) * self.slopes[m]).length();
        let lipschitz = powers(d - 1).map(slope).fold(0.0, f64::max) * d as f64;
        if d < 2 {
            return [lipschitz * up, 0.0];
        }
        let bend = |power| {
            let mut square = 0.0;
            for (r, c) in (0..9).map(|k| (k / 3, k % 3)) {
                let term =
                    |k: usize| raised(power, &[k / 4, k % 4]) * self.slopes[k / 4][r] * self.slopes[k % 4][c];
                let sum: f64 = (0..16).map(term).sum();
                square += sum * sum;
            }
            square.sqrt()
        };
        let hessian = powers(d - 2).map(bend).fold(0.0, f64::max) * (d * (d - 1)) as f64;
        [lipschitz * up, hessian * up]
    }

    /// The polar form: the polynomial with some of its arguments at the corners that `power` counts and the
    /// other `rest` at one place. A neighbour's coefficients are such values where it goes on smoothly.
    pub fn polar(&self, power: [usize; 4], rest: usize, at: [f64; 4]) -> f64 {
        if rest == 0 {
            return self.coefficients[place(power)];
        }
        let raised = |m: usize| {
            let mut power = power;
            power[m] += 1;
            power
        };
        (0..4).map(|m| at[m] * self.polar(raised(m), rest - 1, at)).sum()
    }
}

/// From the net of a level to the next one below. What is read is not yet written.
fn step(net: &mut [f64; MOST], level: usize, at: [f64; 4]) {
    for power in powers(level - 1) {
        let raised = |m: usize| {
            let mut power = power;
            power[m] += 1;
            net[place(power)]
        };
        net[place(power)] = (0..4).map(|m| at[m] * raised(m)).sum();
    }
}
