//! The constants of gradient noise, computed: a search from below, a proof from above.
//!
//! **What is maximised.** The `k`-th derivative of the noise at a point `x` of a cell along a unit
//! vector `u`, `D^k N(x)[u^k]`, is a sum over the cell's corners `c`. With `W_c` the corner's weight
//! (a product of three fades), `W^(k)` its `k`-th derivative along `u`, and `d_c` the offset to it,
//!
//! ```text
//! D^k (W_c g_c.d_c)[u^k] = g_c . v_c       v_c = W_c^(k) d_c + k W_c^(k-1) u
//! ```
//!
//! Every corner has all twelve directions to choose from, so the largest value over all lattices is
//!
//! ```text
//! F_k(x, u) = sum_c max_g |g . v_c| = sum_c (sum of the two largest |components| of v_c)
//! ```
//!
//! and `A, L, M2, M3` are the suprema `M_k` of `F_k` for `k` = 0, 1, 2, 3 (a symmetric tensor takes
//! its norm with all arguments equal; Banach 1938). The symmetries of the cube map the twelve
//! directions to themselves, so `1/2 >= x >= y >= z >= 0` covers all points, and `+-u` are alike.
//!
//! **From above**, by branch and bound. For a box of radius `rho` about `x0` and of directions within
//! `delta` of `u0`: were the supremum taken inside, then
//! `M_k <= F_k(x0, u0) + M_(k+1) rho + k delta M_k`. So a claim `M_k <= T` follows when every leaf
//! satisfies `F_k(x0, u0) + M_(k+1) rho <= T (1 - k delta)`. Near a maximum a second-order bound is
//! far better: `M_(k+1) rho` gives way to what first-order models of the corners' terms gain in the
//! box (`model`) and the remainder `1/2 M_(k+2) rho^2`. The chain starts at `M_5`, for which `F_5`
//! is evaluated over whole boxes in interval arithmetic.
//!
//! The sums of a few hundred products below `1e5` are off by less than `1e-8`; [`SLACK`] covers
//! them. Within a cell the fades are polynomials, so `M_k` bounds changes there for every `k`.

use super::{Claim, Subject};
use crate::noise::{Basis, Gradient};
use crate::num::{Interval, Real, mix};
use rayon::prelude::*;

/// Covers the rounding of `F_k`.
pub const SLACK: f64 = 1e-6;

/// `w^(j + shift) u^j / j!` for `j <= K` at the two nodes of an axis, `t` being the fractional
/// coordinate: the Taylor coefficients of a weight, or of its derivative.
#[inline(always)]
fn axis<const K: usize, R: Real>(t: R, u: R, shift: usize) -> [[R; 6]; 2] {
    let c = R::of;
    let (q, one) = (t * (c(1.0) - t), c(1.0));
    // The fade and its derivatives; those of the other node's weight have the other sign.
    let s = [
        t.square() * t * (t * (c(6.0) * t - c(15.0)) + c(10.0)),
        c(30.0) * q.square(),
        c(60.0) * q * (one - c(2.0) * t),
        c(60.0) - c(360.0) * q,
        c(720.0) * t - c(360.0),
        c(720.0),
    ];
    let factorial = [1.0, 1.0, 2.0, 6.0, 24.0, 120.0];
    let mut far = [c(0.0); 6];
    let mut power = one;
    for j in 0..=K {
        far[j] = s[j + shift] * power * c(1.0 / factorial[j]);
        power = power * u;
    }
    let mut near = far.map(|x| -x);
    if shift == 0 {
        near[0] = one - s[0];
    }
    [near, far]
}

/// Coefficient `n` of the product of two polynomials.
#[inline(always)]
fn convolved<R: Real>(a: &[R; 6], b: &[R; 6], n: usize) -> R {
    (1..=n).fold(a[0] * b[n], |sum, i| sum + a[i] * b[n - i])
}

/// `max_g |g . v|` over the twelve directions.
#[inline(always)]
fn over_directions<R: Real>(v: [R; 3]) -> R {
    let [p, q, r] = v.map(R::abs);
    (p + q).max(p + r).max(q + r)
}

/// `F_K(x, u)`; over intervals, an enclosure of its values.
#[inline(always)]
fn extreme<const K: usize, R: Real>(x: [R; 3], u: [R; 3]) -> R {
    let [a, b, c] = [0, 1, 2].map(|i| axis::<K, R>(x[i], u[i], 0));
    let factorial = R::of((1..=K).product::<usize>() as f64);
    let mut sum = R::of(0.0);
    for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let mut ab = [R::of(0.0); 6];
        for (n, ab) in ab.iter_mut().enumerate().take(K + 1) {
            *ab = convolved(&a[i], &b[j], n);
        }
        for l in 0..2 {
            let high = factorial * convolved(&ab, &c[l], K);
            // k W^(k-1) = k (k-1)! times the coefficient.
            let low = if K == 0 { R::of(0.0) } else { factorial * convolved(&ab, &c[l], K - 1) };
            let node = [i, j, l];
            sum =
                sum + over_directions([0, 1, 2].map(|n| high * (x[n] - R::of(node[n] as f64)) + low * u[n]));
        }
    }
    sum
}

/// `F_k(x, u)` for `k` up to 5, at a point or enclosed over a box.
pub fn largest<R: Real>(k: usize, x: [R; 3], u: [R; 3]) -> R {
    match k {
        0 => extreme::<0, R>(x, u),
        1 => extreme::<1, R>(x, u),
        2 => extreme::<2, R>(x, u),
        3 => extreme::<3, R>(x, u),
        4 => extreme::<4, R>(x, u),
        _ => extreme::<5, R>(x, u),
    }
}

/// Largest value that first-order models of the corners' terms reach in the box `x +- half`.
///
/// `v_c` becomes `v_c + sum_i dx_i d v_c / d x_i`. A maximum over directions of affine functions is
/// convex in `dx`, and so is the sum over corners: the vertices of the box decide. Near a maximum
/// the corners' slopes cancel, so the bound converges with second order.
#[inline(always)]
fn model<const K: usize>(x: [f64; 3], u: [f64; 3], half: [f64; 3]) -> f64 {
    let w = [0, 1, 2].map(|i| axis::<K, f64>(x[i], u[i], 0));
    let d = [0, 1, 2].map(|i| axis::<K, f64>(x[i], u[i], 1));
    let factorial = (1..=K).product::<usize>() as f64;
    let mut sums = [0.0; 8];
    for c in 0..8 {
        let node = [c & 1, c >> 1 & 1, c >> 2];
        // Coefficients K and K - 1 of a product of three polynomials.
        let weights = |axes: [&[f64; 6]; 3]| {
            let ab: [f64; 6] =
                std::array::from_fn(|n| if n <= K { convolved(axes[0], axes[1], n) } else { 0.0 });
            let low = if K == 0 { 0.0 } else { convolved(&ab, axes[2], K - 1) };
            [factorial * convolved(&ab, axes[2], K), factorial * low]
        };
        let offset = [0, 1, 2].map(|n| x[n] - node[n] as f64);
        let [a, b, e] = [0, 1, 2].map(|n| &w[n][node[n]]);
        let [high, low] = weights([a, b, e]);
        let v = [0, 1, 2].map(|n| high * offset[n] + low * u[n]);
        let slope = [0, 1, 2].map(|i| {
            let own = &d[i][node[i]];
            let [h, l] = weights([[own, b, e], [a, own, e], [a, b, own]][i]);
            let mut s = [0, 1, 2].map(|n| h * offset[n] + l * u[n]);
            s[i] += high;
            s.map(|s| s * half[i])
        });
        for (vertex, sum) in sums.iter_mut().enumerate() {
            let side = [0, 1, 2].map(|i| if vertex >> i & 1 == 0 { -1.0 } else { 1.0 });
            *sum += over_directions(
                [0, 1, 2]
                    .map(|n| v[n] + (side[0] * slope[0][n] + side[1] * slope[1][n] + side[2] * slope[2][n])),
            );
        }
    }
    sums.into_iter().fold(0.0, f64::max)
}

fn modelled(k: usize, x: [f64; 3], u: [f64; 3], half: [f64; 3]) -> f64 {
    match k {
        0 => model::<0>(x, u, half),
        1 => model::<1>(x, u, half),
        2 => model::<2>(x, u, half),
        _ => model::<3>(x, u, half),
    }
}

/// A place where `F_k` was found large.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Witness {
    /// The value there.
    pub value: f64,
    /// Point of the cell.
    pub x: [f64; 3],
    /// Unit vector.
    pub u: [f64; 3],
}

fn unit(p: [f64; 3]) -> [f64; 3] {
    let n = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
    p.map(|p| p / n)
}

/// Lower bound on `M_k`: random search with shrinking steps from `starts` places.
pub fn search(k: usize, starts: u64) -> Witness {
    let one = |start: u64| {
        let mut state = 0;
        let mut random = || {
            state += 1;
            (mix(mix(start) ^ state) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        let mut best = Witness { value: 0.0, x: [0.5; 3], u: [1.0, 0.0, 0.0] };
        let mut step = 1.0;
        for _ in 0..3000 {
            let x = best.x.map(|x| (x + 0.5 * step * random()).clamp(0.0, 1.0));
            let u = unit(best.u.map(|u| u + step * random()));
            let value = largest(k, x, u);
            if value > best.value {
                best = Witness { value, x, u };
                step = f64::min(2.0 * step, 1.0);
            } else {
                step = f64::max(0.97 * step, 1e-9);
            }
        }
        best
    };
    let best = (0..starts).into_par_iter().map(one).reduce_with(|a, b| if b.value > a.value { b } else { a });
    best.unwrap_or(Witness { value: 0.0, x: [0.0; 3], u: [1.0, 0.0, 0.0] })
}

/// A box of points and directions: centre and half-widths of `x, y, z` and of the two coordinates
/// on a face of the cube of directions.
#[derive(Clone, Copy)]
struct Leaf {
    mid: [f64; 5],
    half: [f64; 5],
    face: usize,
}

impl Leaf {
    fn direction<R: Real>(&self, a: R, b: R) -> [R; 3] {
        let one = R::of(1.0);
        match self.face {
            0 => [one, a, b],
            1 => [a, one, b],
            _ => [a, b, one],
        }
    }

    /// Whether some point of the box has its coordinates in falling order.
    fn sorted(&self) -> bool {
        (0..2).all(|i| self.mid[i] + self.half[i] >= self.mid[i + 1] - self.half[i + 1])
    }

    /// Splits where the leaf is widest, a unit of position and of direction being worth as told.
    fn split(&self, position: f64, direction: f64) -> Verdict {
        let cost: [f64; 5] = std::array::from_fn(|i| self.half[i] * if i < 3 { position } else { direction });
        Verdict::Split((1..5).fold(0, |best, i| if cost[i] > cost[best] { i } else { best }))
    }

    fn halves(&self, i: usize) -> [Leaf; 2] {
        [-1.0, 1.0].map(|side| {
            let mut part = *self;
            part.half[i] *= 0.5;
            part.mid[i] += side * part.half[i];
            part
        })
    }
}

/// How a leaf is bounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Intervals over the whole leaf.
    Interval,
    /// From the value at its centre, with a proven bound on the next order.
    Next(f64),
    /// From value and slopes at its centre, with proven bounds on the next two orders; `k` up to 3.
    NextTwo(f64, f64),
}

/// What a leaf shows about a claim.
enum Verdict {
    Holds,
    Split(usize),
    Fails,
}

fn judge(k: usize, target: f64, method: Method, leaf: &Leaf) -> Verdict {
    let (m, h) = (leaf.mid, leaf.half);
    let u = unit(leaf.direction(m[3], m[4]));
    let value = largest(k, [m[0], m[1], m[2]], u);
    if value > target {
        return Verdict::Fails;
    }
    let [reach, turn] = match method {
        Method::Interval => {
            let [x, y, z, a, b] = [0, 1, 2, 3, 4].map(|i| Interval::new(m[i] - h[i], m[i] + h[i]));
            let p = leaf.direction(a, b);
            let norm = (p[0].square() + p[1].square() + p[2].square()).sqrt();
            if largest(k, [x, y, z], p.map(|p| p / norm)).hi <= target {
                return Verdict::Holds;
            }
            [2.0, 1.0]
        }
        Method::Next(next) | Method::NextTwo(next, _) => {
            let rho = (h[0] * h[0] + h[1] * h[1] + h[2] * h[2]).sqrt();
            // Central projection of a face onto the unit sphere inside it shortens distances.
            let delta = k as f64 * (h[3] * h[3] + h[4] * h[4]).sqrt();
            let room = target * (1.0 - delta) - SLACK;
            if delta < 1.0 && value + next * rho <= room {
                return Verdict::Holds;
            }
            let Method::NextTwo(_, second) = method else { return leaf.split(next, k as f64 * target) };
            let bend = 0.5 * second * rho * rho;
            let half = [h[0], h[1], h[2]];
            if delta < 1.0 && value + bend <= room && modelled(k, [m[0], m[1], m[2]], u, half) + bend <= room
            {
                return Verdict::Holds;
            }
            [f64::min(second * rho, next), k as f64 * target]
        }
    };
    leaf.split(reach, turn)
}

/// Boxes visited below `leaf`, or `None` when the claim fails or `budget` boxes do not settle it.
fn settle(k: usize, target: f64, method: Method, leaf: Leaf, budget: u64) -> Option<u64> {
    let mut open = vec![leaf];
    let mut visited = 0;
    while let Some(leaf) = open.pop() {
        visited += 1;
        match judge(k, target, method, &leaf) {
            Verdict::Holds => {}
            Verdict::Split(i) if visited < budget => {
                open.extend(leaf.halves(i).into_iter().filter(Leaf::sorted));
            }
            Verdict::Split(_) | Verdict::Fails => return None,
        }
    }
    Some(visited)
}

/// Cells along an axis of `[0, 1/2]`, and tiles along an edge of a face, at which a proof starts.
const CELLS: usize = 4;
const TILES: usize = 4;

/// Proves `M_k <= target`, and returns the number of boxes that took; or `None` when the claim is
/// false, or not settled with `budget` boxes in one of some thousand parts.
pub fn prove(k: usize, target: f64, method: Method, budget: u64) -> Option<u64> {
    // Values do not depend on directions: one point stands for all of them.
    let (faces, tiles, on) = if k == 0 { (1, 1, 0.0) } else { (3, TILES, 1.0) };
    let (x, u) = (0.25 / CELLS as f64, on / tiles as f64);
    let mut parts = Vec::new();
    for i in 0..CELLS.pow(3) {
        for j in 0..faces * tiles * tiles {
            let at = |n: usize| (2 * (n % CELLS) + 1) as f64 * x;
            let turned = |n: usize| (2 * (n % tiles) + 1) as f64 * u - on;
            let mid = [at(i), at(i / CELLS), at(i / CELLS / CELLS), turned(j), turned(j / tiles)];
            let leaf = Leaf { mid, half: [x, x, x, u, u], face: j / tiles / tiles };
            if leaf.sorted() {
                parts.push(leaf);
            }
        }
    }
    parts
        .into_par_iter()
        .map(|leaf| settle(k, target, method, leaf, budget))
        .try_reduce(|| 0, |a, b| Some(a + b))
}

/// Gradient noise.
pub(super) struct Edges;

impl Subject for Edges {
    fn name(&self) -> &'static str {
        "gradient"
    }

    fn claims(&self) -> Vec<Claim> {
        let b = Gradient::EDGES.bounds();
        let names = ["M5", "M4", "M3", "M2", "L", "A"];
        let bounds = [15_000.0, 1400.0, b.third, b.hessian, b.lipschitz, b.range];
        (0..6).map(|i| Claim { order: 5 - i, name: names[i], bound: bounds[i] }).collect()
    }

    fn search(&self, order: usize, starts: u64) -> f64 {
        search(order, starts).value
    }

    fn prove(&self, claim: &Claim, budget: u64) -> Option<u64> {
        let claims = self.claims();
        let above = |order: usize| claims[5 - order].bound;
        let method = match claim.order {
            5 => Method::Interval,
            4 => Method::Next(above(5)),
            k => Method::NextTwo(above(k + 1), above(k + 2)),
        };
        prove(claim.order, claim.bound, method, budget)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn constants() -> [f64; 4] {
        let b = Gradient::EDGES.bounds();
        [b.range, b.lipschitz, b.hessian, b.third]
    }

    #[test]
    fn no_search_exceeds_the_constants() {
        for (k, limit) in constants().into_iter().enumerate() {
            let found = search(k, 40);
            assert!(found.value <= limit, "{k} {found:?}");
            assert!(found.value >= 0.99 * limit, "{k}: the search lost its way: {found:?}");
        }
    }

    #[test]
    fn known_witnesses_are_reached() {
        let at = |k, x, u| largest::<f64>(k, x, unit(u));
        assert!((at(0, [0.4815, 0.6447, 0.5], [1.0, 0.0, 0.0]) - 1.036354).abs() < 1e-6);
        assert!((at(1, [0.5; 3], [1.0, 0.0, 0.0]) - 3.75).abs() < 1e-12);
        assert!((at(2, [0.3992, 0.3992, 0.5], [0.5816, -0.5816, 0.5687]) - 14.46515).abs() < 1e-4);
        assert!((at(3, [0.5, 0.4551, 0.0], [0.0, 0.0, 1.0]) - 150.6702).abs() < 1e-3);
    }

    #[test]
    fn coarse_proofs_succeed_and_false_claims_fail() {
        let budget = 1 << 20;
        assert!(prove(0, 1.05, Method::NextTwo(3.76, 14.62), budget).is_some());
        assert!(prove(1, 4.0, Method::NextTwo(14.62, 151.4), budget).is_some());
        assert!(prove(5, 40_000.0, Method::Interval, budget).is_some());
        assert!(prove(1, 3.7, Method::NextTwo(14.62, 151.4), budget).is_none());
        assert!(prove(3, 140.0, Method::Next(1400.0), budget).is_none());
    }

    #[test]
    fn intervals_and_models_enclose_values() {
        let mut random = crate::noise::tests::Random::new(12);
        for k in 0..4 {
            for _ in 0..300 {
                let x = random.point(0.25).map(|x| x + 0.25);
                let u = unit(random.point(1.0));
                let half = random.point(0.05).map(f64::abs);
                let boxes = [0, 1, 2].map(|i| Interval::new(x[i] - half[i], x[i] + half[i]));
                let enclosure = largest(k, boxes, u.map(Interval::point));
                let next = [3.76, 14.62, 151.4, 1400.0, 15_000.0][k + 1];
                let rho = half.iter().map(|h| h * h).sum::<f64>().sqrt();
                let bound = modelled(k, x, u, half) + 0.5 * next * rho * rho;
                for _ in 0..10 {
                    let e = random.point(1.0);
                    let y = [0, 1, 2].map(|i| x[i] + e[i] * half[i]);
                    let value = largest(k, y, u);
                    assert!(enclosure.lo <= value && value <= enclosure.hi + 1e-9);
                    assert!(value <= bound + 1e-9, "{k} {value} {bound}");
                }
            }
        }
    }
}
