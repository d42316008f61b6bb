//! Sums over nodes: what a node may carry, and a noise made of such nodes as a subject of proof.

use super::bound::{Method, prove};
use super::search::search;
use super::{Claim, Subject};
use crate::noise::node::OnSphere;
use crate::noise::{Directions, Kind};
use crate::num::Real;

/// What the nodes of a noise may carry.
#[derive(Clone, Copy)]
pub(super) struct Content {
    /// A value from -1 to 1.
    pub value: bool,
    /// A direction.
    pub directions: Option<Directions>,
}

impl Content {
    /// `max_a |a w| + max_g |g . v|`, a convex function of `w` and `v`.
    ///
    /// The twelve directions of the edges have two components of size 1: the sum of the two largest
    /// sizes among the components of `v`. Directions on the sphere follow `v`.
    #[inline(always)]
    pub(super) fn most<R: Real>(self, w: R, v: [R; 3]) -> R {
        let sloped = match self.directions {
            None => return w.abs(),
            Some(Directions::Edges) => {
                let [p, q, r] = v.map(R::abs);
                (p + q).max(p + r).max(q + r)
            }
            Some(Directions::Sphere) => {
                R::of(OnSphere::LENGTH) * (v[0].square() + v[1].square() + v[2].square()).sqrt()
            }
        };
        if self.value { w.abs() + sloped } else { sloped }
    }
}

/// The weights of the nodes that reach a cube of space.
pub(super) trait Shape: Copy + Sync {
    /// Where a search looks: `0 <= x, y, z <= SIDE`.
    const SIDE: f64;

    /// Whether `F_4` is continuous, so that its values bound those nearby.
    const SMOOTH: bool;

    /// `F_K(x, u)`; over intervals, an enclosure of its values.
    fn sum<const K: usize, R: Real>(&self, content: Content, x: [R; 3], u: [R; 3]) -> R;

    /// Largest value that first-order models of the nodes' terms reach in the box `x +- half`.
    ///
    /// `W^(k)` and `v` become `W^(k) + sum_i dx_i d W^(k) / d x_i` and likewise for `v`. A maximum over
    /// what a node carries of affine functions is convex in `dx`, and so is the sum over nodes: the
    /// vertices of the box decide. Near a maximum the nodes' slopes cancel, so the bound converges
    /// with second order.
    fn model<const K: usize>(&self, content: Content, x: [f64; 3], u: [f64; 3], half: [f64; 3]) -> f64;

    /// Whether the third derivatives have derivatives throughout a ball.
    fn bends(&self, x: [f64; 3], rho: f64) -> bool {
        let _ = (x, rho);
        true
    }
}

/// A node's `W^(k)` and `v`, or a slope of these.
#[derive(Clone, Copy)]
pub(super) struct Term {
    pub w: f64,
    pub v: [f64; 3],
}

/// Adds what a node's model reaches at each vertex of a box, `slopes` being those over half an edge.
#[inline(always)]
pub(super) fn at_vertices(content: Content, at: Term, slopes: [Term; 3], sums: &mut [f64; 8]) {
    for (vertex, sum) in sums.iter_mut().enumerate() {
        let side = [0, 1, 2].map(|i| if vertex >> i & 1 == 0 { -1.0 } else { 1.0 });
        let moved = |part: [f64; 3]| side[0] * part[0] + side[1] * part[1] + side[2] * part[2];
        *sum += content.most(
            at.w + moved(slopes.map(|s| s.w)),
            [0, 1, 2].map(|n| at.v[n] + moved(slopes.map(|s| s.v[n]))),
        );
    }
}

/// A noise whose nodes have weights of some shape.
pub(super) struct Family<S> {
    pub name: &'static str,
    pub kind: Kind,
    pub shape: S,
    pub content: Content,
    /// Coarse bounds on the fourth and fifth derivatives, on which the others lean.
    pub beyond: [f64; 2],
}

impl<S: Shape> Family<S> {
    /// `F_k(x, u)` for `k` up to 5, at a point or enclosed over a box.
    #[inline(always)]
    pub(super) fn largest<R: Real>(&self, k: usize, x: [R; 3], u: [R; 3]) -> R {
        match k {
            0 => self.shape.sum::<0, R>(self.content, x, u),
            1 => self.shape.sum::<1, R>(self.content, x, u),
            2 => self.shape.sum::<2, R>(self.content, x, u),
            3 => self.shape.sum::<3, R>(self.content, x, u),
            4 => self.shape.sum::<4, R>(self.content, x, u),
            _ => self.shape.sum::<5, R>(self.content, x, u),
        }
    }

    pub(super) fn modelled(&self, k: usize, x: [f64; 3], u: [f64; 3], half: [f64; 3]) -> f64 {
        match k {
            0 => self.shape.model::<0>(self.content, x, u, half),
            1 => self.shape.model::<1>(self.content, x, u, half),
            2 => self.shape.model::<2>(self.content, x, u, half),
            _ => self.shape.model::<3>(self.content, x, u, half),
        }
    }

    pub(super) fn constants(&self) -> [f64; 6] {
        let b = self.kind.bounds();
        [b.range, b.lipschitz, b.hessian, b.third, self.beyond[0], self.beyond[1]]
    }

    pub(super) fn method(&self, order: usize) -> Method {
        let bound = self.constants();
        match order {
            5 => Method::Interval,
            4 if !S::SMOOTH => Method::Interval,
            4 => Method::Next(bound[5]),
            k => Method::NextTwo(bound[k + 1], bound[k + 2]),
        }
    }
}

impl<S: Shape> Subject for Family<S> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn claims(&self) -> Vec<Claim> {
        let bounds = self.constants();
        let claim = |order: usize, name| Claim { order, name, bound: bounds[order] };
        vec![claim(5, "M5"), claim(4, "M4"), claim(3, "M3"), claim(2, "M2"), claim(1, "L"), claim(0, "A")]
    }

    fn search(&self, order: usize, starts: u64) -> f64 {
        search(self, order, starts).value
    }

    fn prove(&self, claim: &Claim, budget: u64) -> Option<u64> {
        if claim.order == 0 && self.content.directions.is_none() {
            // The weights are positive and add up to one, so values from -1 to 1 stay there. No box
            // could show a bound that is attained everywhere.
            return (claim.bound >= 1.0).then_some(0);
        }
        prove(self, claim.order, claim.bound, self.method(claim.order), budget)
    }
}
