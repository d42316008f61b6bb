//! The constants of noises, computed: a search from below, a proof from above.
//!
//! A bound that a noise states is a theorem, and its proof is a program: one file here for each
//! family of noises. [`ALL`] lists what they are asked to prove; `examples/certify_noise.rs` walks
//! the list and prints a table of what a search found, what was proven, and how far apart they are.
//! A bound is good when it lies above whatever an adversarial search finds and not far from it: within
//! a few thousandths for most, and within a tenth for all that are stated.
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
mod scattered;
mod search;
mod simplex;
mod wavelet;

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

/// Everything that is proven, by family.
pub const ALL: &[&[&dyn Subject]] = &[LATTICES, scattered::ALL];

/// Noises on lattices.
const LATTICES: &[&dyn Subject] = &[
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
    &wavelet::Tiled,
];

fn unit(p: [f64; 3]) -> [f64; 3] {
    let n = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
    p.map(|p| p / n)
}

#[cfg(test)]
mod tests {
    use super::node::Shape;
    use super::*;
    use crate::noise::Noise;
    use crate::noise::tests::Random;
    use crate::num::{Interval, Kernel, Order};

    #[test]
    fn searches_come_near_the_constants_and_not_above() {
        for subject in LATTICES {
            for claim in subject.claims() {
                let found = subject.search(claim.order, 1000);
                let what = format!("{} {}: {found} of {}", subject.name(), claim.name, claim.bound);
                assert!(found <= claim.bound * (1.0 + 1e-12), "{what}");
                assert!(claim.order > 3 || found >= 0.9 * claim.bound, "{what}");
            }
        }
    }

    #[test]
    fn coarse_proofs_succeed_and_false_claims_fail() {
        for subject in LATTICES {
            for claim in subject.claims().into_iter().filter(|c| c.order < 4) {
                let other = |factor: f64| Claim { bound: factor * claim.bound, ..claim };
                let what = format!("{} {}", subject.name(), claim.name);
                if claim.order < 3 {
                    assert!(subject.prove(&other([1.1, 1.2, 1.6][claim.order]), 1 << 20).is_some(), "{what}");
                }
                assert!(subject.prove(&other(0.7), 1 << 12).is_none(), "{what}");
            }
        }
    }

    fn family<S: Shape>(shape: S, kind: Kind, value: bool, directions: Option<Directions>) -> Family<S> {
        Family {
            name: "",
            kind,
            shape,
            content: Content { value, directions },
            beyond: [20_000.0, 420_000.0],
        }
    }

    const EDGES: Option<Directions> = Some(Directions::Edges);
    const SPHERE: Option<Directions> = Some(Directions::Sphere);

    #[test]
    fn known_witnesses_are_reached() {
        let gradient = family(Cube, Kind::Gradient(Gradient::EDGES), false, EDGES);
        let at = |k, x, u| gradient.largest::<f64>(k, x, unit(u));
        assert!((at(0, [0.4815, 0.6447, 0.5], [1.0, 0.0, 0.0]) - 1.036354).abs() < 1e-6);
        assert!((at(1, [0.5; 3], [1.0, 0.0, 0.0]) - 3.75).abs() < 1e-12);
        assert!((at(2, [0.3992, 0.3992, 0.5], [0.5816, -0.5816, 0.5687]) - 14.46515).abs() < 1e-4);
        assert!((at(3, [0.5, 0.4551, 0.0], [0.0, 0.0, 1.0]) - 150.6702).abs() < 1e-3);
        let value = family(Cube, Kind::Value(Value), true, None);
        let at_edge = value.largest::<f64>(2, [0.5, 0.5, 0.0], unit([1.0, 1.0, 0.0]));
        assert!((at_edge - 225.0 / 16.0).abs() < 1e-12);
    }

    /// What the constants bound is never below what the noise does.
    fn dominates<S: Shape>(family: &Family<S>) {
        let mut random = Random::new(11);
        for i in 0..20_000 {
            let p = random.point(30.0);
            let jet = Noise::new(family.kind, i / 100).jet(Order::Hessian, p);
            let u = unit(random.point(1.0));
            // Into the cube that the shape knows, by symmetry.
            let t = p.map(|p| p - p.floor());
            let flip = t.map(|t| t > S::SIDE);
            let x = [0, 1, 2].map(|k| if flip[k] { 1.0 - t[k] } else { t[k] });
            let v = [0, 1, 2].map(|k| if flip[k] { -u[k] } else { u[k] });
            let [a, b, c, d, e, f] = jet.hess;
            let slope = jet.grad[0] * u[0] + jet.grad[1] * u[1] + jet.grad[2] * u[2];
            let bend = a * u[0] * u[0]
                + b * u[1] * u[1]
                + c * u[2] * u[2]
                + 2.0 * (d * u[0] * u[1] + e * u[0] * u[2] + f * u[1] * u[2]);
            for (k, found) in [jet.value, slope, bend].into_iter().enumerate() {
                let most = family.largest::<f64>(k, x, v);
                assert!(found.abs() <= most + 1e-9, "{:?} {k} {found} {most} {p:?}", family.kind);
            }
        }
    }

    /// Intervals and models enclose values nearby.
    fn encloses<S: Shape>(family: &Family<S>) {
        let mut random = Random::new(12);
        for k in 0..6 {
            for _ in 0..300 {
                let x = random.point(0.25).map(|x| x + 0.25);
                let u = unit(random.point(1.0));
                let half = random.point(0.05).map(f64::abs);
                let boxes = [0, 1, 2].map(|i| Interval::new(x[i] - half[i], x[i] + half[i]));
                let enclosure = family.largest(k, boxes, u.map(Interval::point));
                let rho = half.iter().map(|h| h * h).sum::<f64>().sqrt();
                let bound = match k {
                    3 if !family.shape.bends(x, rho) => f64::INFINITY,
                    0..4 => family.modelled(k, x, u, half) + 0.5 * family.constants()[k + 2] * rho * rho,
                    _ => f64::INFINITY,
                };
                for _ in 0..10 {
                    let e = random.point(1.0);
                    let y = [0, 1, 2].map(|i| x[i] + e[i] * half[i]);
                    let value = family.largest(k, y, u);
                    assert!(enclosure.lo - 1e-9 <= value && value <= enclosure.hi + 1e-9);
                    assert!(value <= bound + 1e-9, "{:?} {k} {value} {bound}", family.kind);
                }
            }
        }
    }

    #[test]
    fn suprema_over_lattices_enclose_and_are_enclosed() {
        fn check<S: Shape>(family: Family<S>) {
            dominates(&family);
            encloses(&family);
        }
        check(family(Cube, Kind::Gradient(Gradient::EDGES), false, EDGES));
        check(family(Cube, Kind::Gradient(Gradient::SPHERE), false, SPHERE));
        check(family(Cube, Kind::Value(Value), true, None));
        for directions in [Directions::Edges, Directions::Sphere] {
            check(family(Cube, Kind::ValueGradient(ValueGradient { directions }), true, Some(directions)));
            let simplex = Simplex { directions };
            check(family(Balls { scale: simplex.scale() }, Kind::Simplex(simplex), false, Some(directions)));
        }
    }
}
