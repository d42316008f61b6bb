//! Where a field is known to have a value.
//!
//! What is undefined is empty, but ranges are of the values that there are: they do not tell. To ask of a place whether
//! the field has one all over it takes an evaluation. So the answer for a region is found once for all. On planets
//! directions have no value in the middle, and they have one everywhere else: what is between two cubes is cut
//! into boxes, around an ever smaller cube.

use crate::scene::Aabb;
use crate::tape::Tape;
use glam::DVec3;
use std::sync::Arc;

/// The field has a value everywhere within `reach` of a place along every axis, but maybe within `hollow` of it.
#[derive(Clone, Copy, Debug)]
pub struct Defined {
    centre: DVec3,
    reach: f64,
    hollow: f64,
}

/// Times that the cube in the middle is made three times smaller: to a part in billions.
const SHELLS: u32 = 20;

/// A hollow is small if it is less than this share of what is around it.
const SMALL: f64 = 1e-6;

/// A little more, so that boxes overlap.
const OVERLAP: f64 = 1e-9;

impl Defined {
    /// About a place; none if the hollow would be as large as the rest.
    pub fn about(tape: &Arc<Tape>, centre: DVec3, reach: f64) -> Option<Defined> {
        let is_defined = |at: DVec3, half: f64| {
            let half = half * (1.0 + OVERLAP) + 16.0 * f64::EPSILON * at.abs().max_element();
            tape.is_defined(&Aabb { min: at - half, max: at + half }.intervals())
        };
        if is_defined(centre, reach) {
            return Some(Defined { centre, reach, hollow: 0.0 });
        }
        let mut hollow = reach;
        for _ in 0..SHELLS {
            let half = hollow / 3.0;
            let off = |i: usize| DVec3::from_array([i % 3, i / 3 % 3, i / 9].map(|k| k as f64 - 1.0));
            let middle = 13;
            if !(0..27).filter(|i| *i != middle).all(|i| is_defined(centre + 2.0 * half * off(i), half)) {
                break;
            }
            hollow = half;
        }
        (hollow < reach).then_some(Defined { centre, reach, hollow: hollow * (1.0 + OVERLAP) })
    }

    /// Whether the hollow is next to nothing.
    pub fn is_whole(&self) -> bool {
        self.hollow < SMALL * self.reach
    }

    /// Whether a box is known to be in it.
    pub fn holds(&self, part: &Aabb) -> bool {
        let (low, high) = (part.min - self.centre, part.max - self.centre);
        let is_within = low.abs().max(high.abs()).max_element() <= self.reach;
        let is_beside =
            self.hollow == 0.0 || low.max_element() > self.hollow || high.min_element() < -self.hollow;
        is_within && is_beside
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Graph;
    use crate::op::{Div, Length, Op, Sqrt};

    fn cube(at: DVec3, half: f64) -> Aabb {
        Aabb { min: at - half, max: at + half }
    }

    /// Directions have no value in the middle.
    #[test]
    fn all_but_the_middle_is_defined() {
        let mut graph = Graph::default();
        let [x, y, z] = graph.point().unwrap();
        let length = graph.op(Op::Length(Length), &[x, y, z]).unwrap();
        let share = graph.op(Op::Div(Div), &[x, length]).unwrap();
        let tape = Arc::new(Tape::new(&graph, &[share]));
        let found = Defined::about(&tape, DVec3::ZERO, 2.0).unwrap();
        assert!(found.is_whole());
        assert!(found.holds(&cube(DVec3::X, 0.9)) && found.holds(&cube(DVec3::splat(-1e-3), 5e-4)));
        assert!(!found.holds(&cube(DVec3::ZERO, 0.1)) && !found.holds(&cube(DVec3::splat(1e-9), 1e-9)));
        assert!(!found.holds(&cube(DVec3::splat(1.9), 0.2)));
        // From beside the middle one sees no farther than that.
        let beside = Defined::about(&tape, DVec3::X * 0.5, 1.0);
        assert!(beside.is_none_or(|beside| !beside.is_whole()));
    }

    #[test]
    fn what_ends_in_a_plane_is_not_whole() {
        let mut graph = Graph::default();
        let [x, ..] = graph.point().unwrap();
        let root = graph.op(Op::Sqrt(Sqrt), &[x]).unwrap();
        let tape = Arc::new(Tape::new(&graph, &[root]));
        assert!(Defined::about(&tape, DVec3::ZERO, 1.0).is_none());
        assert!(
            Defined::about(&tape, DVec3::X * 2.0, 1.0)
                .is_some_and(|found| found.holds(&cube(DVec3::X * 2.0, 1.0)))
        );
    }
}
