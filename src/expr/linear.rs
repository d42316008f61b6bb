//! Linear maps of the point that expressions are.

use super::graph::{Graph, Input, Node, NodeId};
use crate::op::Op;
use glam::{DMat3, DVec3};
use std::collections::HashMap;

/// Numbers as large as that leave too few digits of coordinates that they are added to.
const LARGEST: f64 = 1e9;

/// What of an expression is linear in the point.
#[derive(Clone, Copy)]
struct Linear {
    /// The slopes along the axes.
    slopes: DVec3,
    /// Whether the rest is a number that leaves digits to the coordinates.
    is_all: bool,
}

impl Graph {
    /// The slopes of an expression along the axes, if it is a sum of multiples of the coordinates and of a number that
    /// leaves digits to them.
    pub fn linear(&self, root: NodeId) -> Option<DVec3> {
        let Linear { slopes, is_all } = self.linear_part(root);
        is_all.then_some(slopes)
    }

    /// By how much a map of the point stretches space at most, as far as it is linear: 4 for `4 p`, and for `4 p` with
    /// some noise added. What has nothing linear in it, such as a distance from an axis, is taken to stretch by 1.
    pub fn stretch(&self, map: [NodeId; 3]) -> f64 {
        let parts = map.map(|part| self.linear_part(part));
        let is_wild = parts.iter().any(|part| !part.is_all && part.slopes == DVec3::ZERO);
        let m = DMat3::from_cols_array_2d(&parts.map(|part| part.slopes.to_array()));
        // Of the matrix times its transpose, the greatest eigenvalue, by powers.
        let squares = m.transpose() * m;
        let along = |axis: DVec3| {
            let v = (0..POWERS).fold(axis, |v, _| (squares * v).normalize_or(axis));
            (m * v).length()
        };
        let most = DVec3::AXES.map(along).into_iter().fold(0.0, f64::max);
        match most {
            _ if !(most > 0.0 && most.is_finite()) => 1.0,
            _ if is_wild => most.max(1.0),
            _ => most,
        }
    }

    fn linear_part(&self, root: NodeId) -> Linear {
        let mut parts: HashMap<NodeId, Linear> = HashMap::new();
        let all = |slopes: DVec3| Linear { slopes, is_all: true };
        let bent = Linear { slopes: DVec3::ZERO, is_all: false };
        for id in self.reachable_here(&[root]) {
            let part = match self.node(id) {
                Node::Const(bits) if f64::from_bits(*bits).abs() < LARGEST => all(DVec3::ZERO),
                Node::Input(Input::X) => all(DVec3::X),
                Node::Input(Input::Y) => all(DVec3::Y),
                Node::Input(Input::Z) => all(DVec3::Z),
                Node::Op(op, args) => {
                    let (part, number) = (|i: usize| parts[&args[i]], |i: usize| self.as_const(args[i]));
                    match (op, number(0), args.get(1).and_then(|_| number(1))) {
                        (Op::Add(_), ..) => part(0).plus(part(1)),
                        (Op::Sub(_), ..) => part(0).plus(part(1).times(-1.0)),
                        (Op::Neg(_), ..) => part(0).times(-1.0),
                        (Op::Mul(_), Some(k), _) => part(1).times(k),
                        (Op::Mul(_), _, Some(k)) => part(0).times(k),
                        (Op::Div(_), _, Some(k)) => part(0).times(1.0 / k),
                        _ => bent,
                    }
                }
                _ => bent,
            };
            parts.insert(id, part);
        }
        parts[&root]
    }
}

/// Powers of a matrix until the vector that it stretches most is all that is left: what is not it by then is stretched
/// nearly as much.
const POWERS: usize = 64;

impl Linear {
    fn plus(self, o: Linear) -> Linear {
        Linear { slopes: self.slopes + o.slopes, is_all: self.is_all && o.is_all }
    }

    fn times(self, k: f64) -> Linear {
        Linear { slopes: self.slopes * k, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::op::{Add, Div, Mul, Neg, Sub};

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
    fn maps_stretch_by_their_linear_part() {
        let mut graph = Graph::default();
        let [x, y, z] = graph.point().unwrap();
        let [four, small] = [4.0, 0.6].map(|c| graph.constant(c).unwrap());
        let mut op = |op: Op, args: &[NodeId]| graph.op(op, args).unwrap();
        let times = [x, y, z].map(|c| op(Op::Mul(Mul), &[four, c]));
        let product = op(Op::Mul(Mul), &[x, y]);
        let warped = times.map(|c| op(Op::Add(Add), &[c, product]));
        // A turn about z, by the angle of a triangle with sides 3, 4 and 5.
        let [a, b] = [x, y].map(|c| op(Op::Mul(Mul), &[small, c]));
        let (c, d) = (op(Op::Div(Div), &[a, four]), op(Op::Div(Div), &[b, four]));
        let turned = [op(Op::Sub(Sub), &[c, b]), op(Op::Add(Add), &[a, d]), z];
        let flat = [times[0], y, four];
        assert!((graph.stretch(times) - 4.0).abs() < 1e-12);
        assert!((graph.stretch(warped) - 4.0).abs() < 1e-12);
        assert!((graph.stretch(flat) - 4.0).abs() < 1e-12);
        assert_eq!(graph.stretch([product; 3]), 1.0);
        assert_eq!(graph.stretch([x, y, z]), 1.0);
        // Columns (0.15, 0.6) and (-0.6, 0.15) are perpendicular and alike, and shorter than z is.
        assert!((graph.stretch(turned) - 1.0).abs() < 1e-12);
        let only = [turned[0], turned[1], four];
        assert_eq!(graph.stretch([c, product, four]), 1.0);
        assert!((graph.stretch(only) - 0.15_f64.hypot(0.6)).abs() < 1e-12);
    }
}
