//! Sparse convolution noise (Lewis 1984, 1989; Gamito 2009, 4.13 to 4.16): round smooth spots of
//! random height on random nodes.
//!
//! With the nodes `n_i` and weights `w_i` of [`scatter`](super::scatter), `d = x - n_i`, `r = |d|`,
//!
//! ```text
//! N = sum w_i h(r)      grad N = sum w_i (h'/r) d      H = sum w_i ((h'' - h'/r) d d^T / r^2 + (h'/r) I)
//! ```
//!
//! over the nodes with `r < 1`. It is white noise on nodes convolved with `h`: its power spectrum is
//! that of the kernel, low-pass and the same in all directions, and no lattice shows. Two kernels:
//!
//! ```text
//! quintic    h = 1 - 10 r^3 + 15 r^4 - 6 r^5     = q^3 (1 + 3 r + 6 r^2),  q = 1 - r         C2
//!            h'/r = -30 r q^2      (h'' - h'/r) / r = 30 q (3 r - 1)
//! Lewis      h = (1 + cos pi r) / 2                                                          C1
//! ```
//!
//! Written with `q` the quintic and its derivatives vanish without cancellation at the rim, and
//! nothing divides by a small number at the centre. The second derivative of Lewis' kernel is
//! `pi^2 / 2` at the rim, where the Hessian of the noise jumps.
//!
//! **Amplitude** is the thesis': the variance is the number of nodes to a cell times
//! `int h^2 dV`, 0.37313 for the quintic and 0.37713 for Lewis' kernel (on average over space, where
//! nodes are placed as discs).
//!
//! **Bounds** are those of one node of unit weight in every cell at its worst place, computed in
//! [`certify`](super::certify), times the largest sum of weights that a cell can have.

use super::basis::Basis;
use super::bulk::{GRADIENT, HESSIAN};
use super::lattice::Lattice;
use super::parameter::{Allowed, Parameter, Settings};
use super::scatter::{self, NODES, Node, PLACEMENT, Placement, Scatter, Spot, WEIGHTS};
use crate::num::{Bounds, Class, Jets, Local, Order, Point, ROUNDOFF, cos_turns, sin_turns};
use std::f64::consts::PI;

/// Sparse convolution noise at unit frequency: about one spot of radius 1 to a lattice cell.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Sparse {
    scatter: Scatter,
    /// Whether the kernel is Lewis'.
    lewis: bool,
}

/// Bounds with one node of unit weight in every cell: quintic and Lewis' kernel, each for nodes
/// anywhere in their cells and for nodes that keep a margin. Proven by `examples/certify_noise.rs`.
pub(super) const UNIT: [[Bounds; 2]; 2] = [
    [
        Bounds { range: 8.13, lipschitz: 24.6, hessian: 101.5, third: 982.0 },
        Bounds { range: 3.84, lipschitz: 10.2, hessian: 45.8, third: 434.0 },
    ],
    [
        Bounds { range: 8.13, lipschitz: 22.5, hessian: 92.7, third: f64::INFINITY },
        Bounds { range: 3.94, lipschitz: 8.8, hessian: 48.1, third: f64::INFINITY },
    ],
];

const KERNEL: &str = "kernel";

impl Basis for Sparse {
    const PARAMETERS: &'static [Parameter] = &[
        NODES,
        Parameter {
            name: KERNEL,
            doc: "profile of a spot: smooth to second order, or a raised cosine, smooth to first order",
            allowed: Allowed::Choice(&["quintic", "lewis"]),
        },
        PLACEMENT,
        WEIGHTS,
    ];

    fn new(settings: &Settings) -> Self {
        Sparse { scatter: Scatter::new(settings), lewis: settings.name(KERNEL) == "lewis" }
    }

    fn class(&self) -> Class {
        if self.lewis { Class::C1 } else { Class::C2 }
    }

    fn bounds(&self) -> Bounds {
        let unit = UNIT[usize::from(self.lewis)][usize::from(self.scatter.placement == Placement::Disc)];
        unit.times(self.scatter.most_weight())
    }

    /// Where the square of the kernel's Fourier transform has fallen to a hundredth.
    fn band(&self) -> f64 {
        if self.lewis { 0.95 } else { 1.0 }
    }

    fn jets(&self, lattice: &Lattice, at: [&[f64]; 3], out: Jets<'_>) {
        match self.lewis {
            false => scatter::jets(&self.scatter, &Quintic, lattice, at, out),
            true => scatter::jets(&self.scatter, &Lewis, lattice, at, out),
        }
    }

    fn jet(&self, lattice: &Lattice, order: Order, at: [f64; 3]) -> Point {
        match self.lewis {
            false => scatter::jet(&self.scatter, &Quintic, lattice, order, at),
            true => scatter::jet(&self.scatter, &Lewis, lattice, order, at),
        }
    }

    fn is_uniform(&self) -> bool {
        false
    }

    fn local(&self, lattice: &Lattice, order: Order, at: [f64; 3], radius: f64) -> Local {
        let (ball, global, rounding) = ((order, at, radius), self.bounds(), self.rounding());
        match self.lewis {
            false => scatter::local(&self.scatter, &Quintic, lattice, ball, global, rounding),
            true => scatter::local(&self.scatter, &Lewis, lattice, ball, global, rounding),
        }
    }

    fn locals(&self, lattice: &Lattice, order: Order, at: [&[f64]; 3], radius: &[f64], out: &mut [Local]) {
        let (balls, limits) = ((order, at, radius), (self.bounds(), self.rounding()));
        match self.lewis {
            false => scatter::locals(&self.scatter, &Quintic, lattice, balls, limits, out),
            true => scatter::locals(&self.scatter, &Lewis, lattice, balls, limits, out),
        }
    }

    /// An offset to a node is off by up to 3 roundoffs on each axis, hence less than 6 in length, a
    /// distance by 3 more of its own, and a spot by as many as it has operations, which
    /// [`Scatter::roundoffs`] counts together with those of the sums. The Hessian of Lewis' kernel
    /// jumps, and is accurate but for its rim.
    fn rounding(&self) -> [f64; 3] {
        let (b, n) = (self.bounds(), self.scatter.roundoffs());
        let third = if b.third.is_finite() { b.third } else { 4.0 * b.hessian };
        [
            ROUNDOFF * (n * b.range + 16.0 * b.lipschitz),
            ROUNDOFF * (n * b.lipschitz + 16.0 * b.hessian),
            ROUNDOFF * (n * b.hessian + 16.0 * third),
        ]
    }
}

/// The quintic kernel.
#[derive(Clone, Copy)]
pub(super) struct Quintic;

/// `d x d` for the six second derivatives.
#[inline(always)]
pub(super) fn outer(a: [f64; 3], b: [f64; 3]) -> [f64; 6] {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2], a[0] * b[1], a[0] * b[2], a[1] * b[2]]
}

/// Keeps divisions by a distance finite; what is divided vanishes there.
const TINY: f64 = 1e-150;

#[inline(always)]
fn length(d: [f64; 3]) -> f64 {
    (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt()
}

impl Spot for Quintic {
    #[inline(always)]
    fn jet<const ORDER: u8>(&self, node: &Node) -> Point {
        let (d, w) = (node.d, node.weight);
        let r = length(d);
        let q = if r < 1.0 { 1.0 - r } else { 0.0 };
        let mut out = Point { value: w * (q * q * q * (1.0 + r * (3.0 + 6.0 * r))), ..Point::default() };
        if ORDER >= GRADIENT {
            let slope = w * (-30.0 * r * (q * q));
            out.grad = d.map(|d| slope * d);
            if ORDER >= HESSIAN {
                let rate = w * (30.0 * q * (3.0 * r - 1.0)) / (if r > TINY { r } else { TINY });
                out.hess = outer(d.map(|d| rate * d), d);
                (0..3).for_each(|i| out.hess[i] += slope);
            }
        }
        out
    }

    #[inline(always)]
    fn sizes(&self, near: f64, far: f64) -> [f64; 4] {
        let far = if far < 1.0 { far } else { 1.0 };
        // The largest size of a function at both ends and at its peaks in between.
        let most = |f: fn(f64) -> f64, peaks: &[[f64; 2]]| {
            let ends = f64::max(f(near).abs(), f(far).abs());
            peaks
                .iter()
                .fold(ends, |most, &[at, size]| if near <= at && at <= far { most.max(size) } else { most })
        };
        let (inner, outer) = (0.211_324_865_405_187_1, 0.788_675_134_594_812_9);
        let bend =
            most(|r| 60.0 * r * (1.0 - r) * (1.0 - 2.0 * r), &[[inner, 5.773_502_7], [outer, 5.773_502_7]]);
        let slant = most(|r| 30.0 * r * (1.0 - r) * (1.0 - r), &[[1.0 / 3.0, 4.444_444_5]]);
        // Along a unit vector at an angle of cosine c to d the third derivative is
        // h''' c^3 + 3 g (c - c^3), g = (h''/r - h'/r^2): a cubic in c whose largest size on [0, 1]
        // is at c = 1, or two thirds of its linear term 3 g c.
        let radial = most(|r| 60.0 - 360.0 * r * (1.0 - r), &[[0.5, 30.0]]);
        let across = most(|r| 60.0 * (1.0 - r) * (3.0 * r - 1.0), &[[2.0 / 3.0, 20.0]]);
        let q = 1.0 - near;
        [
            q * q * q * (1.0 + near * (3.0 + 6.0 * near)),
            most(|r| 30.0 * r * r * (1.0 - r) * (1.0 - r), &[[0.5, 1.875]]),
            bend.max(slant),
            radial.max(across),
        ]
    }
}

/// Lewis' kernel.
#[derive(Clone, Copy)]
struct Lewis;

impl Spot for Lewis {
    #[inline(always)]
    fn jet<const ORDER: u8>(&self, node: &Node) -> Point {
        let (d, w) = (node.d, node.weight);
        let r = length(d);
        let half = if r < 1.0 { 0.5 * r } else { 0.5 };
        let cos = cos_turns(half);
        let mut out = Point { value: w * (0.5 + 0.5 * cos), ..Point::default() };
        if ORDER >= GRADIENT {
            let half = if half > TINY { half } else { TINY };
            let slope = w * (-0.25 * PI * sin_turns(half) / half);
            out.grad = d.map(|d| slope * d);
            if ORDER >= HESSIAN {
                let n = d.map(|d| d / (2.0 * half));
                let bend = if r < 1.0 { w * (-0.5 * PI * PI * cos) } else { 0.0 };
                out.hess = outer(n.map(|n| (bend - slope) * n), n);
                (0..3).for_each(|i| out.hess[i] += slope);
            }
        }
        out
    }

    #[inline(always)]
    fn sizes(&self, near: f64, far: f64) -> [f64; 4] {
        let rim = far >= 1.0;
        let far = if rim { 1.0 } else { far };
        let (c, e) = (cos_turns(0.5 * near), cos_turns(0.5 * far));
        let slopes = f64::max(sin_turns(0.5 * near), sin_turns(0.5 * far));
        let slope = if near <= 0.5 && 0.5 <= far { 1.0 } else { slopes };
        // h'/r falls in size from its value of pi^2 / 2 at the centre.
        let half = if near > 1e-9 { 0.5 * near } else { 1e-9 };
        let slant = 0.25 * PI * sin_turns(half) / half * (1.0 + 1e-15);
        let bend = 0.5 * PI * PI * c.abs().max(e.abs());
        // |h'''| <= pi^3 / 2, and of h''/r - h'/r^2 = int_0^r s h''' ds / r^2 half of that. At the rim
        // the second derivative jumps.
        let third = if rim { f64::INFINITY } else { 15.503_2 };
        [0.5 + 0.5 * c, 0.5 * PI * slope, bend.max(slant), third]
    }
}
