//! The constants of wavelet noise, from the coefficients that it is made of.
//!
//! Within a cell the noise is a polynomial of degree 2 along each axis, and so, with degrees to
//! spare, are its gradient and its Hessian. In Bernstein form such a polynomial lies in the convex
//! hull of its 27 control points (numbers, vectors or matrices alike), and a norm is largest at one of
//! them. Halving the cell (de Casteljau) brings the control points to the polynomial. There are only
//! so many cells: those of the tiles, since a block of the noise is a tile.

use super::{Claim, Subject};
use crate::noise::Basis;
use crate::noise::wavelet::{EDGE, RATE, TILES, Wavelet, tiles};
use crate::num::{mix, quadratic, uniform};
use rayon::prelude::*;

/// Wavelet noise.
pub struct Tiled;

impl Subject for Tiled {
    fn name(&self) -> &'static str {
        "wavelet"
    }

    fn claims(&self) -> Vec<Claim> {
        let b = Wavelet.bounds();
        let bounds = [(2, "M2", b.hessian), (1, "L", b.lipschitz), (0, "A", b.range)];
        bounds.map(|(order, name, bound)| Claim { order, name, bound }).to_vec()
    }

    fn search(&self, order: usize, starts: u64) -> f64 {
        search(order, starts as usize)
    }

    fn prove(&self, claim: &Claim, budget: u64) -> Option<u64> {
        prove(claim.order, claim.bound, budget)
    }
}

/// Climbs that are continued to the last digit.
const BEST: usize = 2000;

/// Far more than the rounding of a few dozen sums, relative to a bound.
const SLACK: f64 = 1e-9;

/// The coefficients around a cell, by z, y, x.
type Cell = [f64; 27];

/// Control points of each component, by z, y, x: the value, or three first derivatives, or six
/// second ones.
type Net = [[f64; 27]; 6];

fn cells() -> usize {
    TILES * EDGE * EDGE * EDGE
}

fn cell(n: usize) -> Cell {
    let at = [n % EDGE, n / EDGE % EDGE, n / EDGE / EDGE % EDGE];
    let rows = tiles();
    let mut cell = [0.0; 27];
    for (r, row) in cell.chunks_exact_mut(3).enumerate() {
        row.copy_from_slice(&rows.row(n / EDGE / EDGE / EDGE, at, r % 3, r / 3));
    }
    cell
}

/// Applies a map of three numbers along an axis.
fn along(net: &[f64; 27], axis: usize, map: impl Fn([f64; 3]) -> [f64; 3]) -> [f64; 27] {
    let stride = [1, 3, 9][axis];
    let mut out = *net;
    for start in (0..27).filter(|n| n / stride % 3 == 0) {
        let line = map([net[start], net[start + stride], net[start + 2 * stride]]);
        for (i, x) in line.into_iter().enumerate() {
            out[start + i * stride] = x;
        }
    }
    out
}

/// Bernstein coefficients of the derivative, again of degree 2.
fn slope(net: &[f64; 27], axis: usize) -> [f64; 27] {
    along(net, axis, |[a, b, c]| {
        let (first, last) = (2.0 * RATE * (b - a), 2.0 * RATE * (c - b));
        [first, 0.5 * (first + last), last]
    })
}

fn net(cell: &Cell, order: usize) -> Net {
    let bernstein = |[a, b, c]: [f64; 3]| [0.5 * (a + b), b, 0.5 * (b + c)];
    let value = (0..3).fold(*cell, |net, axis| along(&net, axis, bernstein));
    let mut net = [[0.0; 27]; 6];
    match order {
        0 => net[0] = value,
        1 => (0..3).for_each(|axis| net[axis] = slope(&value, axis)),
        _ => {
            for (own, (i, j)) in net.iter_mut().zip([(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]) {
                *own = slope(&slope(&value, i), j);
            }
        }
    }
    net
}

/// Absolute value, length, or spectral norm.
fn size(order: usize, [a, b, c, d, e, f]: [f64; 6]) -> f64 {
    match order {
        0 => a.abs(),
        1 => (a * a + b * b + c * c).sqrt(),
        _ => {
            // Eigenvalues of a symmetric matrix in closed form (Smith 1961).
            let mean = (a + b + c) / 3.0;
            let [x, y, z] = [a - mean, b - mean, c - mean];
            let p = ((x * x + y * y + z * z + 2.0 * (d * d + e * e + f * f)) / 6.0).sqrt();
            if p == 0.0 {
                return mean.abs();
            }
            let det = x * (y * z - f * f) - d * (d * z - f * e) + e * (d * f - y * e);
            let angle = libm::acos((0.5 * det / (p * p * p)).clamp(-1.0, 1.0)) / 3.0;
            let most = mean + 2.0 * p * libm::cos(angle);
            let least = mean + 2.0 * p * libm::cos(angle + 2.0 * std::f64::consts::FRAC_PI_3);
            most.abs().max(least.abs())
        }
    }
}

fn component(net: &Net, n: usize) -> [f64; 6] {
    [net[0][n], net[1][n], net[2][n], net[3][n], net[4][n], net[5][n]]
}

/// At most this size in the cell of the net.
fn bound(net: &Net, order: usize) -> f64 {
    (0..27).map(|n| size(order, component(net, n))).fold(0.0, f64::max)
}

/// The same, cheaper and larger: matrices by their Frobenius norm.
fn loose(net: &Net, order: usize) -> f64 {
    let square = |n: usize| {
        let [a, b, c, d, e, f] = component(net, n).map(|x| x * x);
        let twice = if order == 2 { 2.0 } else { 1.0 };
        a + b + c + twice * (d + e + f)
    };
    (0..27).map(square).fold(0.0, f64::max).sqrt()
}

/// The net of one half of the cell.
fn half(net: &Net, axis: usize, upper: bool) -> Net {
    net.map(|n| {
        along(&n, axis, |[a, b, c]| {
            let (low, high) = (0.5 * (a + b), 0.5 * (b + c));
            let middle = 0.5 * (low + high);
            if upper { [middle, high, c] } else { [a, low, middle] }
        })
    })
}

/// Proves that no derivative of an order is larger than `target`, and returns how many boxes that
/// took; or `None` if it is false, or not settled with `budget` boxes in some cell.
pub fn prove(order: usize, target: f64, budget: u64) -> Option<u64> {
    let room = target * (1.0 - SLACK);
    let settle = |n: usize| {
        let mut open = vec![(net(&cell(n), order), 0)];
        let mut visited = 0;
        while let Some((net, depth)) = open.pop() {
            visited += 1;
            if loose(&net, order) <= room || bound(&net, order) <= room {
                continue;
            }
            // A corner of the net is a value of the polynomial.
            if size(order, component(&net, 0)) > room || visited >= budget || depth > 60 {
                return None;
            }
            open.extend([false, true].map(|upper| (half(&net, depth % 3, upper), depth + 1)));
        }
        Some(visited)
    };
    (0..cells()).into_par_iter().map(settle).try_reduce(|| 0, |a, b| Some(a + b))
}

/// The size of a derivative at a point of a cell.
fn at(cell: &Cell, order: usize, t: [f64; 3]) -> f64 {
    let w = t.map(quadratic);
    let sum = |d: [usize; 3]| {
        let weight = |axis: usize, i: usize| {
            let own = &w[axis];
            [own.value[i], RATE * own.first[i], RATE * RATE * own.second[i]][d[axis]]
        };
        (0..27).map(|n| cell[n] * weight(0, n % 3) * weight(1, n / 3 % 3) * weight(2, n / 9)).sum::<f64>()
    };
    let derivatives: &[[usize; 3]] = match order {
        0 => &[[0, 0, 0]],
        1 => &[[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        _ => &[[2, 0, 0], [0, 2, 0], [0, 0, 2], [1, 1, 0], [1, 0, 1], [0, 1, 1]],
    };
    let mut values = [0.0; 6];
    for (value, d) in values.iter_mut().zip(derivatives) {
        *value = sum(*d);
    }
    size(order, values)
}

/// A place in a cell of a number, and the size of the derivative there.
#[derive(Clone, Copy)]
struct Climber {
    value: f64,
    place: [f64; 3],
    cell: usize,
}

impl Climber {
    /// From the middle of a cell, steps of a quarter of it along an axis while one of them leads up, then
    /// of an eighth, and of a sixteenth.
    fn coarse(number: usize, order: usize) -> Climber {
        let cell = cell(number);
        let (mut best, mut place, mut step) = (at(&cell, order, [0.5; 3]), [0.5; 3], 0.25);
        while step > 0.05 {
            let last = place;
            for i in 0..6 {
                let mut next = last;
                next[i / 2] = f64::clamp(next[i / 2] + if i % 2 == 0 { step } else { -step }, 0.0, 1.0);
                let value = at(&cell, order, next);
                if value > best {
                    (best, place) = (value, next);
                }
            }
            if place == last {
                step *= 0.5;
            }
        }
        Climber { value: best, place, cell: number }
    }

    /// Random steps that grow with success and shrink with failure.
    fn finish(mut self, order: usize) -> f64 {
        let cell = cell(self.cell);
        let (mut state, mut step) = (mix(self.cell as u64), 0.125);
        for _ in 0..600 {
            let next = self.place.map(|t: f64| {
                state = mix(state);
                (t + step * (uniform(state) - 0.5)).clamp(0.0, 1.0)
            });
            let value = at(&cell, order, next);
            if value > self.value {
                (self.value, self.place, step) = (value, next, f64::min(2.0 * step, 1.0));
            } else {
                step = f64::max(0.97 * step, 1e-9);
            }
        }
        self.value
    }
}

/// Lower bound on the largest derivative of an order: climbs in as many cells as there are starts,
/// those whose control points reach farthest, and on from the best.
pub fn search(order: usize, starts: usize) -> f64 {
    let mut ranked: Vec<(f64, usize)> =
        (0..cells()).into_par_iter().map(|n| (loose(&net(&cell(n), order), order), n)).collect();
    let falling = |a: &(f64, usize), b: &(f64, usize)| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
    ranked.par_sort_unstable_by(falling);
    ranked.truncate(starts);
    let mut climbs: Vec<Climber> = ranked.into_par_iter().map(|(_, n)| Climber::coarse(n, order)).collect();
    climbs.par_sort_by(|a, b| b.value.total_cmp(&a.value));
    climbs.truncate(BEST);
    climbs.into_par_iter().map(|climb| climb.finish(order)).reduce(|| 0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_search_exceeds_the_constants_and_none_is_far() {
        for claim in Tiled.claims() {
            let found = search(claim.order, 1000);
            assert!(found <= claim.bound && found >= 0.9 * claim.bound, "{} {found}", claim.name);
            assert!(prove(claim.order, claim.bound, 1 << 16).is_some(), "{}", claim.name);
            assert!(prove(claim.order, 0.95 * found, 1 << 10).is_none(), "{}", claim.name);
        }
    }

    #[test]
    fn nets_enclose_and_halves_are_the_same_polynomial() {
        for n in (0..cells()).step_by(70_001) {
            let cell = cell(n);
            for order in 0..3 {
                let whole = net(&cell, order);
                let upper = half(&half(&whole, 0, true), 2, true);
                assert!((size(order, component(&upper, 0)) - at(&cell, order, [0.5, 0.0, 0.5])).abs() < 1e-9);
                for k in 0..20 {
                    let t = [k % 3, k % 5, k % 7].map(|i| f64::from(i) / 6.0);
                    assert!(at(&cell, order, t) <= bound(&whole, order) + 1e-9);
                }
            }
        }
    }
}
