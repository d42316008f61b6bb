//! The distance from a triangle mesh, with a sign.
//!
//! `|f|` is the Euclidean distance to the nearest place of the surface (`nearest.rs`), found in a
//! hierarchy of boxes (`tree.rs`, `search.rs`); `f` is negative where the surface winds around the point more often
//! one way than the other, more than half a turn in all (`winding.rs`).
//!
//! Any mesh will do. Triangles that are turned against their neighbours, and parts that are inside out, are turned
//! (`oriented.rs`); one with holes gets lids (`closed.rs`), so that the winding number is whole
//! and changes at triangles only; and since the distance is zero there, `f` is continuous, however the
//! triangles meet, overlap or pass through one another. Sheets inside of a solid, where it overlaps
//! itself, are places where `f` touches zero from below. Triangles without area are left out.
//!
//! At a place whose nearest place is inside a triangle the gradient is that triangle's normal, else the
//! unit vector from the nearest place; second derivatives are those of the distance to a plane, an edge
//! or a corner: zero, or one over the distance across what is nearest. On the surface itself the normal
//! serves. What is known of `f` around a point is worked out in `ball.rs`.

mod ball;
mod closed;
mod hints;
mod lattice;
mod lean;
mod nearest;
mod order;
mod oriented;
mod search;
#[cfg(test)]
mod tests;
mod tree;
mod winding;

use super::{Body, Digest, Flaw, Mesh};
use crate::num::{Bounds, Class, Interval, Jets, Kernel, Lean, Local, Order, Point, ROUNDOFF, widest};
use ball::Ball;
use closed::{Corners, closed};
use glam::DVec3;
use hints::Hints;
use nearest::{Feature, Place, gap, larger, place, turned};
use order::{MANY, PIECE, along_curve};
use oriented::turn_parts;
use search::{BATCH, Found, NOWHERE, Search, slack};
use std::ops::Range;
use tree::Tree;
use winding::{Surface, Witnesses};

/// The distance from a triangle mesh, negative inside.
#[derive(Clone, Debug)]
pub struct Distance {
    tree: Tree,
    hints: Hints,
    witnesses: Witnesses,
    /// Largest coordinate of a corner.
    size: f64,
    /// Diagonal of the box around them.
    extent: f64,
    /// How far the surface may be from what is measured: zero unless triangles are very thin.
    gap: f64,
    digest: Digest,
}

/// Why a mesh has no distance.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum Unfit {
    /// The mesh itself is wrong.
    #[error(transparent)]
    Flaw(#[from] Flaw),
    /// There is nothing to be far from.
    #[error("the mesh has no triangle that has an area")]
    Empty,
    /// Its numbers leave no room to compute with.
    #[error("the mesh has points farther than 1e60 from the origin, or is smaller than 1e-60")]
    Size,
    /// More triangles than can be numbered.
    #[error("the mesh has {0} triangles, of which 100 million can be measured")]
    Count(usize),
}

/// Most triangles; lids may make them four times as many, and eight numbers may go to each.
const MOST: usize = 100_000_000;
/// Points beyond see the whole mesh as a point at the origin.
const FAR: f64 = 1e120;

impl Distance {
    /// The distance from a mesh.
    ///
    /// # Errors
    /// The mesh is flawed, has no triangle with an area, or is too large or too small.
    pub fn new(mesh: &Mesh) -> Result<Distance, Unfit> {
        mesh.check()?;
        if mesh.triangles.len() > MOST {
            return Err(Unfit::Count(mesh.triangles.len()));
        }
        if mesh.points.iter().any(|p| p.abs().max_element() > 1e60) {
            return Err(Unfit::Size);
        }
        let (all, parts) = closed(mesh);
        let sound = all.into_iter().zip(parts).filter_map(|(t, part)| Some((turned(t)?, part)));
        let (mut triangles, parts): (Vec<_>, Vec<_>) = sound.unzip();
        let mut corners = triangles.iter().flatten();
        let first = *corners.next().ok_or(Unfit::Empty)?;
        let (lo, hi) = corners.fold((first, first), |(lo, hi), p| (lo.min(*p), hi.max(*p)));
        if (hi - lo).max_element() < 1e-60 {
            return Err(Unfit::Size);
        }
        let size = lo.abs().max(hi.abs()).max_element();
        let gap = triangles.iter().map(gap).fold(0.0, larger);
        let grown = |triangles: &[Corners]| {
            let tree = Tree::new(triangles);
            let witnesses = Witnesses::new(Surface { tree: &tree, size }, (lo, hi), triangles.len());
            (tree, witnesses)
        };
        let (mut tree, mut witnesses) = grown(&triangles);
        let winding = |x| witnesses.number(Surface { tree: &tree, size }, x, &mut Vec::new());
        if turn_parts(&mut triangles, &parts, winding) {
            triangles = triangles.into_iter().filter_map(turned).collect();
            (tree, witnesses) = grown(&triangles);
        }
        let mut digest = Digest::default();
        digest.numbers(triangles.iter().flatten().flat_map(|p| p.to_array()));
        let hints = Hints::new(&tree, size, (lo, hi), triangles.len());
        let extent = (hi - lo).length();
        Ok(Distance { tree, hints, witnesses, size, extent, gap, digest })
    }

    /// The jet at a point, given its nearest triangle; the stack may hold anything.
    #[inline(always)]
    fn jet_from(
        &self,
        order: Order,
        at: DVec3,
        Found { square, number }: Found,
        stack: &mut Vec<u32>,
    ) -> Point {
        if !is_near(at) {
            return far(at);
        }
        let slack = slack(self.size + at.abs().max_element());
        let distance = square.sqrt();
        let surface = Surface { tree: &self.tree, size: self.size };
        let inside = self.witnesses.is_inside(surface, at, (distance, slack + self.gap), stack);
        let sign = if inside { -1.0 } else { 1.0 };
        let mut jet = Point { value: sign * distance, ..Point::default() };
        if order >= Order::Gradient
            && let Some(triangle) = self.tree.triangle(number)
        {
            let place = place(triangle, at);
            if distance <= slack {
                jet.grad = place.normal.to_array();
            } else {
                jet.grad = (sign * place.away).to_array();
                jet.hess = if order >= Order::Hessian { bend(&place, sign / distance) } else { [0.0; 6] };
            }
        }
        jet
    }

    /// The jets at points of a range, in some order: which lane is the i-th.
    fn jets_in_order(
        &self,
        at: [&[f64]; 3],
        range: Range<usize>,
        lane: impl Fn(usize) -> usize,
        out: &mut Jets<'_>,
    ) {
        let order = match (&out.grad, &out.hess) {
            (None, _) => Order::Value,
            (Some(_), None) => Order::Gradient,
            (Some(_), Some(_)) => Order::Hessian,
        };
        widest(
            #[inline(always)]
            || {
                let mut search = Search::new(&self.tree, self.size);
                let mut stack = Vec::new();
                let mut points = [DVec3::ZERO; BATCH];
                let (mut hints, mut found) = ([NOWHERE; BATCH], [Found::NONE; BATCH]);
                for start in range.clone().step_by(BATCH) {
                    let batch = start..range.end.min(start + BATCH);
                    let point = |i| at.map(|at| at[lane(i)]).into();
                    for (known, p) in points.iter_mut().zip(batch.clone().map(point)) {
                        *known = if is_near(p) { p } else { DVec3::ZERO };
                    }
                    let known = &points[..batch.len()];
                    self.hints.of(&self.tree, known, &mut hints);
                    search.nearest(known, &hints, &mut found);
                    for (i, found) in batch.zip(found) {
                        let (lane, jet) = (lane(i), self.jet_from(order, point(i), found, &mut stack));
                        out.value[lane] = jet.value;
                        if let Some(grad) = &mut out.grad {
                            (0..3).for_each(|k| grad[k][lane] = jet.grad[k]);
                        }
                        if let Some(hess) = &mut out.hess {
                            (0..6).for_each(|k| hess[k][lane] = jet.hess[k]);
                        }
                    }
                }
            },
        );
    }
}

/// Whether a point is where distances are computed.
fn is_near(at: DVec3) -> bool {
    at.is_finite() && at.abs().max_element() <= FAR
}

/// The jet so far away that the mesh is a point at the origin.
#[cold]
fn far(at: DVec3) -> Point {
    let size = at.abs().max_element();
    let length = (at / size).length();
    Point { value: size * length, grad: (at / size / length).to_array(), hess: [0.0; 6] }
}

/// Second derivatives: `curvature` across what is nearest.
fn bend(place: &Place, curvature: f64) -> [f64; 6] {
    let along = match place.feature {
        Feature::Face => return [0.0; 6],
        Feature::Edge(along) => along,
        Feature::Corner => DVec3::ZERO,
    };
    let (g, t) = (place.away, along);
    let entry = |i: usize, j: usize| curvature * (f64::from(u8::from(i == j)) - g[i] * g[j] - t[i] * t[j]);
    [entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)]
}

impl Kernel for Distance {
    fn class(&self) -> Class {
        Class::C0
    }

    fn bounds(&self) -> Bounds {
        Bounds {
            range: f64::INFINITY,
            lipschitz: 1.0 + 8.0 * ROUNDOFF,
            hessian: f64::INFINITY,
            third: f64::INFINITY,
        }
    }

    fn jets(&self, at: [&[f64]; 3], mut out: Jets<'_>) {
        let count = out.value.len();
        if count < MANY {
            return self.jets_in_order(at, 0..count, |i| i, &mut out);
        }
        for start in (0..count).step_by(PIECE) {
            let piece = start..count.min(start + PIECE);
            let order = along_curve(self.hints.lattice(), at.map(|at| &at[piece.clone()]));
            self.jets_in_order(at, piece, |i| start + order[i - start] as usize, &mut out);
        }
    }

    fn is_uniform(&self) -> bool {
        false
    }

    fn local(&self, order: Order, at: [f64; 3], radius: f64) -> Local {
        let order = if order < Order::Gradient { Order::Gradient } else { order };
        let jet = self.jet(order, at);
        let centre = DVec3::from(at);
        let slack = slack(self.size + centre.abs().max_element());
        let distance = jet.value.abs();
        let unknown = Interval::radius(2.0 * radius);
        // On the surface the gradient is but one of those nearby.
        let bow = if distance > 4.0 * slack && distance <= FAR {
            let sign = jet.value.signum();
            let away = sign * DVec3::from(jet.grad);
            let bow = Ball { centre, radius, distance, away }.bow(&self.tree);
            if sign < 0.0 { -bow } else { bow }
        } else {
            unknown
        };
        // Places, and so the tangent planes of triangles, are off by the error of distances.
        let bow = bow + Interval::radius(4.0 * slack + 2.0 * self.gap);
        let bow = if bow.mag() < 2.0 * radius { bow } else { unknown };
        Local { jet, bounds: self.bounds(), bow, sag: f64::INFINITY, turn: f64::INFINITY }
    }

    fn lean(&self, at: [f64; 3], radius: f64) -> Option<Lean> {
        let centre = DVec3::from(at);
        if !is_near(centre) || !radius.is_finite() {
            return None;
        }
        let distance = self.jet(Order::Value, at).value.abs();
        // Farther away than that much of the surface would have to face one way.
        (distance + radius <= self.extent).then(|| self.lean_around(centre, radius, distance)).flatten()
    }

    /// Distances are off by less than the slack of searches. The sign may be wrong within as much of
    /// the surface, and between a thin triangle and its edges.
    fn error(&self, size: f64) -> [f64; 3] {
        [4.0 * slack(self.size + size) + 2.0 * self.gap, 16.0 * ROUNDOFF, f64::INFINITY]
    }
}

impl Body for Distance {
    fn name(&self) -> &'static str {
        "mesh"
    }

    fn digest(&self, digest: &mut Digest) {
        digest.join(self.digest);
    }
}
