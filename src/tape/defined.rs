//! Where a field is known to have a value.
//!
//! What is undefined is empty, but ranges are of the values that there are: they do not tell. To ask of a place whether
//! the field has one all over it takes an evaluation. So the answer for a region is found once for all. On planets
//! directions have no value in the middle, and they have one everywhere else: a region is cut into ever smaller boxes as
//! long as it is but few of them that may have none, and what is left is the *hollow*, a box about these.

use super::Tape;
use crate::num::Interval;
use std::sync::Arc;

/// Where in a region a field has a value: everywhere but in its hollow.
#[derive(Clone, Copy, Debug)]
pub struct Defined {
    region: [Interval; 3],
    hollow: Option<[Interval; 3]>,
}

/// Times that boxes are cut into three along each axis: to a part in billions.
const CUTS: u32 = 20;

/// Boxes that may be left of one cut.
const MOST: usize = 32;

impl Defined {
    /// In a region; none if it might have none all over it.
    pub fn within(tape: &Arc<Tape>, region: &[Interval; 3]) -> Option<Defined> {
        let all = Defined { region: *region, hollow: None };
        let mut hollows = vec![*region];
        hollows.retain(|part| !tape.is_defined(part));
        for _ in 0..CUTS {
            let parts = hollows.iter().flat_map(thirds);
            let left: Vec<[Interval; 3]> =
                parts.filter(|part| !tape.is_defined(part)).take(MOST + 1).collect();
            if left.len() > MOST {
                break;
            }
            hollows = left;
        }
        let Some(hollow) = hollows.into_iter().reduce(|a, b| std::array::from_fn(|k| a[k].hull(b[k]))) else {
            return Some(all);
        };
        (hollow != *region).then_some(Defined { hollow: Some(hollow), ..all })
    }

    /// Where in the region the field may have no value.
    pub fn hollow(&self) -> Option<&[Interval; 3]> {
        self.hollow.as_ref()
    }

    /// Whether a box is in the region.
    pub fn is_about(&self, part: &[Interval; 3]) -> bool {
        self.region.iter().zip(part).all(|(all, part)| all.encloses(*part))
    }

    /// Whether the field is known to have a value everywhere in a box.
    pub fn holds(&self, part: &[Interval; 3]) -> bool {
        let is_apart = |(a, b): (&Interval, &Interval)| a.hi < b.lo || b.hi < a.lo;
        self.is_about(part) && self.hollow.is_none_or(|hollow| hollow.iter().zip(part).any(is_apart))
    }
}

/// A box cut into three along each axis; parts share their faces.
fn thirds(all: &[Interval; 3]) -> impl Iterator<Item = [Interval; 3]> + use<> {
    let cuts = all.map(|x| {
        let third = x.width() / 3.0;
        [x.lo, (x.lo + third).min(x.hi), (x.hi - third).max(x.lo), x.hi]
    });
    (0..27).map(move |i| {
        let part = |axis: usize, k: usize| Interval::new(cuts[axis][k], cuts[axis][k + 1]);
        [part(0, i % 3), part(1, i / 3 % 3), part(2, i / 9)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::{Graph, NodeId};
    use crate::op::{Add, Div, Length, Op, Sqrt, Sub};
    use crate::tape::Evaluator;

    fn cube(at: [f64; 3], half: f64) -> [Interval; 3] {
        at.map(|x| Interval::new(x - half, x + half))
    }

    /// A coordinate as a share of how far away a place is.
    fn direction(graph: &mut Graph, from: [f64; 3]) -> NodeId {
        let p = graph.point().unwrap();
        let off = [0, 1, 2].map(|axis| {
            let from = graph.constant(from[axis]).unwrap();
            graph.op(Op::Sub(Sub), &[p[axis], from]).unwrap()
        });
        let length = graph.op(Op::Length(Length), &off).unwrap();
        graph.op(Op::Div(Div), &[off[0], length]).unwrap()
    }

    fn tape(graph: &Graph, field: NodeId) -> Arc<Tape> {
        Arc::new(Tape::new(graph, &[field]))
    }

    fn widest(hollow: &[Interval; 3]) -> f64 {
        hollow.iter().map(|x| x.width()).fold(0.0, f64::max)
    }

    #[test]
    fn directions_have_a_value_beside_the_middle() {
        for at in [[0.0; 3], [0.3, -0.7, 0.1], [1.0, 1.0, -1.0]] {
            let mut graph = Graph::default();
            let share = direction(&mut graph, at);
            let found = Defined::within(&tape(&graph, share), &cube([0.0; 3], 2.0)).unwrap();
            let hollow = found.hollow().unwrap();
            assert!(
                widest(hollow) < 1e-7 && hollow.iter().zip(at).all(|(x, at)| x.contains(at)),
                "{hollow:?}"
            );
            let beside = |off: f64| at.map(|x| x + off);
            assert!(found.holds(&cube(beside(0.5), 0.4)) && found.holds(&cube(beside(-1e-3), 5e-4)));
            assert!(!found.holds(&cube(at, 0.1)) && !found.holds(&cube(beside(1e-9), 1e-8)));
            assert!(!found.holds(&cube([1.9; 3], 0.2)));
        }
    }

    #[test]
    fn two_middles_are_in_one_hollow() {
        let mut graph = Graph::default();
        let a = direction(&mut graph, [-0.5, 0.0, 0.0]);
        let b = direction(&mut graph, [0.5, 0.0, 0.0]);
        let sum = graph.op(Op::Add(Add), &[a, b]).unwrap();
        let found = Defined::within(&tape(&graph, sum), &cube([0.0; 3], 2.0)).unwrap();
        let [x, y, z] = found.hollow().unwrap();
        assert!(
            x.contains(-0.5) && x.contains(0.5) && x.width() < 1.0 + 1e-7 && y.width().max(z.width()) < 1e-7
        );
        assert!(found.holds(&cube([0.0, 0.5, 0.0], 0.4)) && !found.holds(&cube([0.0; 3], 0.4)));
    }

    #[test]
    fn what_ends_in_a_plane_has_values_on_one_side() {
        let mut graph = Graph::default();
        let [x, ..] = graph.point().unwrap();
        let root = graph.op(Op::Sqrt(Sqrt), &[x]).unwrap();
        let tape = tape(&graph, root);
        let all = Defined::within(&tape, &cube([2.0, 0.0, 0.0], 1.0)).unwrap();
        assert!(all.hollow().is_none() && all.holds(&cube([2.0, 0.0, 0.0], 1.0)));
        let half = Defined::within(&tape, &cube([0.0; 3], 1.0)).unwrap();
        assert!(half.holds(&cube([0.7, 0.0, 0.0], 0.3)) && !half.holds(&cube([-0.1, 0.0, 0.0], 0.2)));
        assert!(Defined::within(&tape, &cube([-2.0, 0.0, 0.0], 1.0)).is_none());
    }

    /// Nothing is held where there is a place without a value.
    #[test]
    fn what_is_held_has_a_value() {
        let mut graph = Graph::default();
        let [x, _, z] = graph.point().unwrap();
        let a = direction(&mut graph, [0.1, 0.2, 0.3]);
        let root = graph.op(Op::Sqrt(Sqrt), &[x]).unwrap();
        let share = graph.op(Op::Div(Div), &[a, z]).unwrap();
        let mut lacks = false;
        for field in [share, root] {
            let tape = tape(&graph, field);
            let found = Defined::within(&tape, &cube([0.0; 3], 1.0)).unwrap();
            let mut values = Evaluator::<f64>::new(tape);
            let (mut held, mut open) = (0, 0);
            for i in 0..4000u32 {
                let unit = |k: u32| {
                    f64::from((i * 11 + k).wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 23) - 1.0
                };
                let (at, half) = ([unit(0), unit(1), unit(2)], 0.3 * unit(3).abs());
                let place: [f64; 3] = std::array::from_fn(|axis| at[axis] + half * unit(4 + axis as u32));
                let has_value = values.eval(&place).is_finite();
                let is_held = found.holds(&cube(at, half));
                assert!(!is_held || has_value, "{place:?}");
                held += u32::from(is_held);
                open += u32::from(!has_value);
            }
            assert!(held > 100, "{held}");
            lacks |= open > 100;
        }
        assert!(lacks);
    }
}
