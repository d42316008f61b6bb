//! From above: branch and bound.
//!
//! The symmetries of the cube map what nodes carry to itself, so `1/2 >= x >= y >= z >= 0` covers all
//! points, and `+-u` are alike.
//!
//! For a box of radius `rho` about `x0` and of directions within `delta` of `u0`: were the supremum
//! taken inside, then `M_k <= F_k(x0, u0) + M_(k+1) rho + k delta M_k`. So a claim `M_k <= T` follows
//! when every leaf satisfies `F_k(x0, u0) + M_(k+1) rho <= T (1 - k delta)`. Near a maximum a
//! second-order bound is far better: `M_(k+1) rho` gives way to what first-order models of the nodes'
//! terms gain in the box ([`Shape::model`]) and the remainder `1/2 M_(k+2) rho^2`. The chain starts at
//! `M_5`, for which `F_5` is evaluated over whole boxes in interval arithmetic.
//!
//! The sums of a few hundred products below `1e6` are off by less than `1e-7`; [`SLACK`] covers
//! them. Where weights are polynomials, `M_k` bounds changes for every `k`; shapes that end
//! within a cell say where they do not ([`Shape::bends`], [`Shape::SMOOTH`]).

use super::node::{Family, Shape};
use super::unit;
use crate::num::{Interval, Real};
use rayon::prelude::*;

/// Covers the rounding of `F_k`.
const SLACK: f64 = 1e-6;

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
pub(super) enum Method {
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

fn judge<S: Shape>(family: &Family<S>, k: usize, target: f64, method: Method, leaf: &Leaf) -> Verdict {
    let (m, h) = (leaf.mid, leaf.half);
    let u = unit(leaf.direction(m[3], m[4]));
    let value = family.largest(k, [m[0], m[1], m[2]], u);
    if value > target {
        return Verdict::Fails;
    }
    let [reach, turn] = match method {
        Method::Interval => {
            let [x, y, z, a, b] = [0, 1, 2, 3, 4].map(|i| Interval::new(m[i] - h[i], m[i] + h[i]));
            let p = leaf.direction(a, b);
            let norm = (p[0].square() + p[1].square() + p[2].square()).sqrt();
            if family.largest(k, [x, y, z], p.map(|p| p / norm)).hi <= target {
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
            let at = [m[0], m[1], m[2]];
            if delta < 1.0
                && value + bend <= room
                && (k < 3 || family.shape.bends(at, rho))
                && family.modelled(k, at, u, half) + bend <= room
            {
                return Verdict::Holds;
            }
            [f64::min(second * rho, next), k as f64 * target]
        }
    };
    leaf.split(reach, turn)
}

/// Boxes visited below `leaf`, or `None` when the claim fails or `budget` boxes do not settle it.
fn settle<S: Shape>(
    family: &Family<S>,
    k: usize,
    target: f64,
    method: Method,
    leaf: Leaf,
    budget: u64,
) -> Option<u64> {
    let mut open = vec![leaf];
    let mut visited = 0;
    while let Some(leaf) = open.pop() {
        visited += 1;
        match judge(family, k, target, method, &leaf) {
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
pub(super) fn prove<S: Shape>(
    family: &Family<S>,
    k: usize,
    target: f64,
    method: Method,
    budget: u64,
) -> Option<u64> {
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
        .map(|leaf| settle(family, k, target, method, leaf, budget))
        .try_reduce(|| 0, |a, b| Some(a + b))
}
