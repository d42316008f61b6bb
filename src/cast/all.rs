//! All roots along rays: what is inside the solid, and what is not, from one end of a ray to the other.

use super::group::march;
use super::pieces::Pieces;
use super::{CastStats, Ray};
use crate::field::Field;
use crate::num::{Interval, Reduced};
use crate::tape::{Cells, Evaluator};
use std::sync::atomic::AtomicBool;

/// A piece of a ray, hardly longer than the tolerance, in which the field has a root or comes within rounding of zero; roots
/// that are closer to one another than the tolerance are in one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Root {
    pub from: f64,
    pub to: f64,
    /// Whether it is proven, where the field has a value, that one end is inside the solid and the other outside. If not, the
    /// ray may touch the surface, pass it twice, or pass a hair's breadth from it; or an end cannot be told from zero.
    pub crosses: bool,
}

/// The roots along a ray, in increasing order.
#[derive(Clone, Debug, PartialEq)]
pub struct Roots {
    pub roots: Vec<Root>,
    /// Whether it is proven that there are none beside these.
    pub certified: bool,
}

/// All roots along each ray, by [trimmed pieces](super::Kind::Affine).
pub fn all_hits(field: &Field, rays: &[Ray], stats: &mut CastStats) -> Vec<Roots> {
    let cells = Cells::undivided(field.tape().clone());
    let strategy = Pieces::<Reduced<1>>::trimming(&cells).all();
    let mut evaluator = Evaluator::new(cells.tape().clone());
    let mut found = vec![Roots { roots: Vec::new(), certified: true }; rays.len()];
    let never = AtomicBool::new(false);
    march(&strategy, (&cells, &mut evaluator), rays, stats, &never, |i, march, hit, _| {
        let root = |(from, to)| Root { from, to, crosses: false };
        found[i] = Roots { roots: march.roots.into_iter().map(root).collect(), certified: hit.certified };
    });
    let mut values = Evaluator::<Interval>::new(cells.tape().clone());
    for (ray, found) in rays.iter().zip(&mut found) {
        for root in &mut found.roots {
            let [a, b] = [root.from, root.to].map(|t| *values.eval(&place(ray, t)));
            root.crosses = a.lo > 0.0 && b.hi < 0.0 || a.hi < 0.0 && b.lo > 0.0;
        }
    }
    found
}

/// Encloses a place on a ray.
fn place(ray: &Ray, t: f64) -> [Interval; 3] {
    let (origin, direction) = (ray.origin.to_array(), ray.direction.to_array());
    std::array::from_fn(|axis| {
        Interval::point(origin[axis]) + Interval::point(direction[axis]) * Interval::point(t)
    })
}
