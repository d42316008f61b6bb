//! The constants of noises, computed: a search from below, a proof from above.
//!
//! A bound that a noise states is a theorem, and its proof is a program: one file here for each
//! family of noises. [`ALL`] lists what they are asked to prove; `examples/certify_noise.rs` walks
//! the list and prints a table of what a search found, what was proven, and how far apart they are.
//! A bound is good when it lies above whatever an adversarial search finds and within a few
//! thousandths of it.
//!
//! **What is maximised.** The noises on lattices are sums over nodes `n`, of which finitely many reach
//! a point. With a node's weight `W(d)` at the offset `d = x - n`, its value `a` and direction `g`,
//!
//! ```text
//! N(x) = sum_n W(d_n) (a_n + g_n . d_n)
//! ```
//!
//! (for most noises one of the two). The `k`-th derivative at `x` along a unit vector `u` is again such
//! a sum. With `W^(k)` for the `k`-th derivative of the weight along `u`,
//!
//! ```text
//! D^k (W (a + g.d))[u^k] = a W^(k) + g.v      v = W^(k) d + k W^(k-1) u
//! ```
//!
//! Nodes are independent: every combination of what they can carry occurs somewhere. So the largest
//! value over all lattices is taken term by term,
//!
//! ```text
//! F_k(x, u) = sum_n (max_a |a W_n^(k)| + max_g |g . v_n|)
//! ```
//!
//! (see [`node`]), and `A, L, M2, M3` are the suprema `M_k` of `F_k` for `k` = 0, 1, 2, 3: a symmetric
//! tensor takes its norm with all arguments equal (Banach 1938). [`lattice`] and [`simplex`] evaluate
//! `F_k` for their weights, [`search`] climbs it, and [`bound`] bounds it.

mod bound;
mod lattice;
mod node;
mod search;
mod simplex;

use super::{Directions, Gradient, Kind, Simplex, Value, ValueGradient};
use lattice::Cube;
use node::{Content, Family};
use simplex::Balls;

/// A noise with fixed parameters whose bounds are to be proven.
pub trait Subject: Sync {
    /// Name in tables: the noise, then the settings that are not the default.
    fn name(&self) -> &'static str;

    /// What is claimed, in an order in which every claim leans on those before it.
    fn claims(&self) -> Vec<Claim>;

    /// The largest value of a derivative of this order that a search from so many starts finds: a
    /// lower bound on the supremum.
    fn search(&self, order: usize, starts: u64) -> f64;

    /// Proves a claim, those before it being proven. Returns how many boxes that took, or `None` if
    /// the claim is false or `budget` boxes do not settle one of its parts.
    fn prove(&self, claim: &Claim, budget: u64) -> Option<u64>;
}

/// The claim that no derivative of an order exceeds a bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Claim {
    /// Order of the derivative: 0 for the value.
    pub order: usize,
    /// What the bound is called: `A`, `L`, `M2`, `M3`, and beyond those `M4`, `M5`.
    pub name: &'static str,
    /// The bound.
    pub bound: f64,
}

/// Everything that is proven.
pub const ALL: &[&dyn Subject] = &[
    &Family {
        name: "gradient",
        kind: Kind::Gradient(Gradient::EDGES),
        shape: Cube,
        content: Content { value: false, directions: Some(Directions::Edges) },
        beyond: [1400.0, 15_000.0],
    },
    &Family {
        name: "gradient, sphere",
        kind: Kind::Gradient(Gradient::SPHERE),
        shape: Cube,
        content: Content { value: false, directions: Some(Directions::Sphere) },
        beyond: [1600.0, 17_000.0],
    },
    &Family {
        name: "value",
        kind: Kind::Value(Value),
        shape: Cube,
        content: Content { value: true, directions: None },
        beyond: [850.0, 10_000.0],
    },
    &Family {
        name: "value_gradient",
        kind: Kind::ValueGradient(ValueGradient { directions: Directions::Edges }),
        shape: Cube,
        content: Content { value: true, directions: Some(Directions::Edges) },
        beyond: [2300.0, 25_000.0],
    },
    &Family {
        name: "value_gradient, sphere",
        kind: Kind::ValueGradient(ValueGradient { directions: Directions::Sphere }),
        shape: Cube,
        content: Content { value: true, directions: Some(Directions::Sphere) },
        beyond: [2450.0, 26_000.0],
    },
    &Family {
        name: "simplex",
        kind: Kind::Simplex(Simplex { directions: Directions::Edges }),
        shape: Balls { scale: Simplex { directions: Directions::Edges }.scale() },
        content: Content { value: false, directions: Some(Directions::Edges) },
        beyond: [17_500.0, 420_000.0],
    },
    &Family {
        name: "simplex, sphere",
        kind: Kind::Simplex(Simplex { directions: Directions::Sphere }),
        shape: Balls { scale: Simplex { directions: Directions::Sphere }.scale() },
        content: Content { value: false, directions: Some(Directions::Sphere) },
        beyond: [17_500.0, 420_000.0],
    },
];

fn unit(p: [f64; 3]) -> [f64; 3] {
    let n = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
    p.map(|p| p / n)
}
