//! How far around a box there is nothing else.
//!
//! That a solid keeps off the faces of a box says nothing of what is farther away: another part of it may be there. So
//! what is around the box is looked at shell by shell, each to a cube 16 times as large as the one before. Of most
//! solids a distance bounds the field from below, and the six slabs of a shell are excluded at a glance.

use super::Field;
use super::region::{Halt, Part, exclude, octants};
use crate::scene::Aabb;
use crate::tape::Evaluator;
use glam::DVec3;

/// How many times as large as the one before the cubes are.
const GROWTH: f64 = 16.0;

/// Half edge of the smallest.
const LEAST: f64 = 2.0;

/// Half edge of the largest, 2^61: there neighbouring numbers are hundreds apart, and nothing has a shape.
pub const FAR: f64 = (1_u64 << 61) as f64;

/// What is known of a solid around a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Around {
    /// Half edge of a cube around the origin of which it is proven that nothing of the solid is in it but outside of the
    /// box; 0 where that is so of none.
    pub clear: f64,
    /// A point of the solid outside, if one was met.
    pub met: Option<DVec3>,
}

/// Looks for a solid `f <= 0` around a region, in cubes around the origin, the last of which has at least half the edge
/// `far`, [`FAR`] at most. No more is looked at when `halt` says so.
pub fn around(field: &Field, region: &Aabb, far: f64, halt: Halt<'_>) -> Around {
    let operands = field.tape().operands();
    let mut inner = *region;
    let mut clear = 0.0;
    while clear < far.min(FAR) && !halt() {
        let half = f64::max(LEAST, GROWTH * clear);
        let outer = Aabb::cube(half).hull(&inner);
        let left = exclude(field, &operands, &between(&inner, &outer), halt);
        if !left.is_empty() {
            return Around { clear, met: inside(field, &left) };
        }
        (inner, clear) = (outer, half);
    }
    Around { clear, met: None }
}

/// A point of the solid among the middles of the octants of parts of space. Where one operand says so, another may have no
/// value.
fn inside(field: &Field, parts: &[Part]) -> Option<DVec3> {
    let mut field = field.clone();
    let mut values = Evaluator::<f64>::new(field.tape().clone());
    let likely = parts.iter().filter_map(|part| {
        let mut middles = octants(&part.cell).map(|cell| 0.5 * (cell.min + cell.max));
        values.turn_to(&part.tape);
        middles.find(|p| *values.eval(&p.to_array()) <= 0.0)
    });
    likely.take(ASKED).find(|p| field.value(*p) <= 0.0)
}

/// Points at which all of a field is asked.
const ASKED: usize = 64;

/// What of one box is outside of another in it, as boxes, two at most on each axis.
fn between(inner: &Aabb, outer: &Aabb) -> Vec<Aabb> {
    let mut rest = *outer;
    let mut slabs = Vec::new();
    for axis in 0..3 {
        let (mut below, mut above) = (rest, rest);
        (below.max[axis], above.min[axis]) = (inner.min[axis], inner.max[axis]);
        (rest.min[axis], rest.max[axis]) = (inner.min[axis], inner.max[axis]);
        slabs.extend([below, above]);
    }
    slabs.retain(|slab| slab.min.cmplt(slab.max).all());
    slabs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Graph;
    use crate::op::{self, Op};
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    fn ball(centre: DVec3, radius: f64) -> Field {
        let mut graph = Graph::default();
        let point = graph.point().expect("a small graph");
        let off = [0, 1, 2].map(|axis| {
            let c = graph.constant(centre[axis]).expect("a small graph");
            graph.op(Op::Sub(op::Sub), &[point[axis], c]).expect("a small graph")
        });
        let distance = graph.op(Op::Length(op::Length), &off).expect("a small graph");
        let radius = graph.constant(radius).expect("a small graph");
        let root = graph.op(Op::Sub(op::Sub), &[distance, radius]).expect("a small graph");
        Field::new(&graph, root)
    }

    #[test]
    fn slabs_fill_what_is_between() {
        let [inner, outer] =
            [Aabb { min: DVec3::new(-1.0, 0.0, -3.0), max: DVec3::new(2.0, 1.0, 3.0) }, Aabb::cube(3.0)];
        let volume = |b: &Aabb| (b.max - b.min).element_product();
        let slabs = between(&inner, &outer);
        // Of the six one on either side of z is empty.
        assert_eq!(slabs.len(), 4);
        assert_eq!(slabs.iter().map(volume).sum::<f64>(), volume(&outer) - volume(&inner));
    }

    /// No cube that is said to be clear holds anything of a ball that is outside of the region, and what is met does.
    #[test]
    fn what_is_clear_is() {
        let mut rng = StdRng::seed_from_u64(5);
        let mut counts = [0; 2];
        for _ in 0..200 {
            let far = 4.0 * rng.random_range(0.1..200.0_f64);
            let centre = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-far..far)));
            let radius = rng.random_range(0.05..4.0);
            let region = Aabb::cube(rng.random_range(1.0..800.0));
            let found = around(&ball(centre, radius), &region, FAR, &|| false);
            let about = format!("{centre} {radius} {region:?}: {found:?}");
            let is_inside = centre.abs().max_element() + radius < region.max.x;
            // How far from the origin it begins, in the maximum norm.
            let starts = (centre.abs().max_element() - radius).max(0.0);
            assert!(is_inside || found.clear <= starts.max(region.max.x), "{about}");
            if is_inside && centre.abs().max_element() + 2.0 * radius < region.max.x {
                assert_eq!(found.clear, FAR, "{about}");
            }
            if let Some(p) = found.met {
                assert!(p.distance(centre) <= radius && p.abs().max_element() >= region.max.x, "{about}");
            }
            counts[usize::from(found.met.is_some())] += 1;
        }
        assert!(counts.iter().all(|&n| n > 50), "{counts:?}");
    }

    #[test]
    fn nothing_is_said_of_what_was_not_looked_at() {
        let field = ball(DVec3::ZERO, 1.0);
        assert_eq!(around(&field, &Aabb::cube(2.0), FAR, &|| true), Around { clear: 0.0, met: None });
        assert_eq!(around(&field, &Aabb::cube(2.0), 100.0, &|| false), Around { clear: 512.0, met: None });
    }
}
