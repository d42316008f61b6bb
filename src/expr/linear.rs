//! Linear maps of the point that expressions are.

use super::graph::{Graph, Input, Node, NodeId};
use crate::op::Op;
use glam::{DMat3, DVec3};
use std::collections::HashMap;

/// Numbers as large as that leave too few digits of coordinates that they are added to.
const LARGEST: f64 = 1e9;

/// What is known of how an expression changes with the point.
#[derive(Clone, Copy)]
struct Slopes {
    /// The slopes along the axes of what of it is linear.
    linear: DVec3,
    /// Whether the rest is a number that leaves digits to the coordinates.
    is_linear: bool,
    /// About how fast the rest changes, but for noises: operations are taken to change as their arguments do.
    other: f64,
}

impl Graph {
    /// The slopes of an expression along the axes, if it is a sum of multiples of the coordinates and of a number that
    /// leaves digits to them.
    pub fn linear(&self, root: NodeId) -> Option<DVec3> {
        let Slopes { linear, is_linear, .. } = self.slopes(root);
        is_linear.then_some(linear)
    }

    /// By how much a map of the point stretches space at most, or about that: 4 for `4 p`, also with some noise added, and
    /// for four times the direction from the origin. 1 if nothing of it changes but noises, or with time.
    pub fn stretch(&self, map: [NodeId; 3]) -> f64 {
        let parts = map.map(|part| self.slopes(part));
        let m = DMat3::from_cols_array_2d(&parts.map(|part| part.linear.to_array()));
        // Of the matrix times its transpose, the greatest eigenvalue, by powers.
        let squares = m.transpose() * m;
        let along = |axis: DVec3| {
            let v = (0..POWERS).fold(axis, |v, _| (squares * v).normalize_or(axis));
            (m * v).length()
        };
        let others = parts.iter().map(|part| part.other);
        let most = DVec3::AXES.into_iter().map(along).chain(others).fold(0.0, f64::max);
        if most > 0.0 && most.is_finite() { most } else { 1.0 }
    }

    fn slopes(&self, root: NodeId) -> Slopes {
        let mut known: HashMap<NodeId, Slopes> = HashMap::new();
        for id in self.reachable_here(&[root]) {
            let slopes = match self.node(id) {
                Node::Const(bits) if f64::from_bits(*bits).abs() < LARGEST => Slopes::along(DVec3::ZERO),
                Node::Input(Input::X) => Slopes::along(DVec3::X),
                Node::Input(Input::Y) => Slopes::along(DVec3::Y),
                Node::Input(Input::Z) => Slopes::along(DVec3::Z),
                Node::Op(op, args) => {
                    let number =
                        |i: usize| args.get(i).and_then(|a| self.as_const(*a)).filter(|k| k.abs() < LARGEST);
                    let of = |i: usize| known[&args[i]];
                    match (op, number(0), number(1)) {
                        (Op::Add(_), ..) => of(0).plus(of(1)),
                        (Op::Sub(_), ..) => of(0).plus(of(1).map(|slope| -slope)),
                        (Op::Neg(_), ..) => of(0).map(|slope| -slope),
                        (Op::Mul(_), Some(k), _) => of(1).map(|slope| k * slope),
                        (Op::Mul(_), _, Some(k)) => of(0).map(|slope| slope * k),
                        (Op::Div(_), _, Some(k)) => of(0).map(|slope| slope / k),
                        // What a noise is multiplied with makes no other thing of it.
                        (Op::Mul(_), ..) if of(0).size() == 0.0 || of(1).size() == 0.0 => Slopes::bent(0.0),
                        _ => Slopes::bent(args.iter().map(|a| known[a].size()).fold(0.0, f64::max)),
                    }
                }
                _ => Slopes::bent(0.0),
            };
            known.insert(id, slopes);
        }
        known[&root]
    }
}

/// Powers of a matrix until the vector that it stretches most is all that is left: what is not it by then is stretched
/// nearly as much.
const POWERS: usize = 64;

impl Slopes {
    fn along(linear: DVec3) -> Slopes {
        Slopes { linear, is_linear: true, other: 0.0 }
    }

    fn bent(other: f64) -> Slopes {
        Slopes { linear: DVec3::ZERO, is_linear: false, other }
    }

    fn plus(self, o: Slopes) -> Slopes {
        Slopes {
            linear: self.linear + o.linear,
            is_linear: self.is_linear && o.is_linear,
            other: self.other.max(o.other),
        }
    }

    /// The slopes of a multiple.
    fn map(self, times: impl Fn(f64) -> f64) -> Slopes {
        let linear = DVec3::from_array(self.linear.to_array().map(&times));
        Slopes { linear, other: times(self.other).abs(), ..self }
    }

    /// About how fast it changes.
    fn size(self) -> f64 {
        self.linear.length().max(self.other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::{Kind, Noise};
    use crate::op::{Add, Div, Length, Mul, Neg, Sub};

    #[test]
    fn slopes_of_linear_maps_are_known() {
        let mut graph = Graph::default();
        let [x, y, z] = graph.point().unwrap();
        let four = graph.constant(4.0).unwrap();
        let mut op = |op: Op, args: &[NodeId]| graph.op(op, args).unwrap();
        let a = op(Op::Mul(Mul), &[four, x]);
        let b = op(Op::Div(Div), &[y, four]);
        let c = op(Op::Neg(Neg), &[z]);
        let sum = op(Op::Add(Add), &[a, b]);
        let sum = op(Op::Sub(Sub), &[sum, c]);
        let sum = op(Op::Add(Add), &[sum, four]);
        let bent = op(Op::Mul(Mul), &[x, y]);
        let over = op(Op::Div(Div), &[four, x]);
        assert_eq!(graph.linear(sum), Some(DVec3::new(4.0, 0.25, 1.0)));
        let vast = graph.constant(1e17).unwrap();
        let far = graph.op(Op::Add(Add), &[x, vast]).unwrap();
        assert_eq!([bent, over, far].map(|root| graph.linear(root)), [None; 3]);
    }

    #[test]
    fn maps_stretch_as_what_they_are_made_of_changes() {
        let mut graph = Graph::default();
        let [x, y, z] = graph.point().unwrap();
        let [four, small, time] = [4.0, 0.6, 0.0].map(|c| graph.constant(c).unwrap());
        let noise = graph.noise(Noise::new(Kind::ALL[0].plain(), 7), [x, y, z]).unwrap();
        let clock = graph.input(Input::Time).unwrap();
        let mut op = |op: Op, args: &[NodeId]| graph.op(op, args).unwrap();
        let times = [x, y, z].map(|c| op(Op::Mul(Mul), &[four, c]));
        let far = op(Op::Mul(Mul), &[four, times[0]]);
        let loud = op(Op::Mul(Mul), &[noise, far]);
        let warped = times.map(|c| op(Op::Add(Add), &[c, loud]));
        let length = op(Op::Length(Length), &[x, y, z]);
        let unit = [x, y, z].map(|c| op(Op::Div(Div), &[c, length]));
        let ball = unit.map(|c| op(Op::Mul(Mul), &[four, c]));
        let axis = op(Op::Length(Length), &[x, time, z]);
        let around = [op(Op::Div(Div), &[axis, four]), op(Op::Div(Div), &[y, four]), time];
        let slow = [x, y, z].map(|c| op(Op::Mul(Mul), &[clock, c]));
        // A turn about z that shrinks what is across it.
        let [a, b] = [x, y].map(|c| op(Op::Mul(Mul), &[small, c]));
        let (c, d) = (op(Op::Div(Div), &[a, four]), op(Op::Div(Div), &[b, four]));
        let turned = [op(Op::Sub(Sub), &[c, b]), op(Op::Add(Add), &[a, d]), z];
        let only = [turned[0], turned[1], four];
        for (map, stretch) in [
            (times, 4.0),
            (warped, 4.0),
            (ball, 4.0),
            ([times[0], y, four], 4.0),
            (around, 0.25),
            (slow, 1.0),
            ([noise; 3], 1.0),
            ([x, y, z], 1.0),
            // Columns (0.15, 0.6) and (-0.6, 0.15) are perpendicular and alike, and shorter than z is.
            (turned, 1.0),
            (only, 0.15_f64.hypot(0.6)),
        ] {
            assert!((graph.stretch(map) - stretch).abs() < 1e-12, "{stretch}: {}", graph.stretch(map));
        }
    }
}
