//! Linear maps of the point that expressions are.

use super::graph::{Graph, Input, Node, NodeId};
use crate::op::Op;
use glam::DVec3;
use std::collections::HashMap;

/// Numbers as large as that leave too few digits of coordinates that they are added to.
const LARGEST: f64 = 1e9;

impl Graph {
    /// The slopes of an expression along the axes, if it is a sum of multiples of the coordinates and of a number that
    /// leaves digits to them.
    pub fn linear(&self, root: NodeId) -> Option<DVec3> {
        let mut slopes: HashMap<NodeId, DVec3> = HashMap::new();
        for id in self.reachable_here(&[root]) {
            let slope = match self.node(id) {
                Node::Const(bits) if f64::from_bits(*bits).abs() < LARGEST => DVec3::ZERO,
                Node::Input(Input::X) => DVec3::X,
                Node::Input(Input::Y) => DVec3::Y,
                Node::Input(Input::Z) => DVec3::Z,
                Node::Op(op, args) => {
                    let (slope, number) = (|i: usize| slopes[&args[i]], |i: usize| self.as_const(args[i]));
                    match op {
                        Op::Add(_) => slope(0) + slope(1),
                        Op::Sub(_) => slope(0) - slope(1),
                        Op::Neg(_) => -slope(0),
                        Op::Mul(_) => match (number(0), number(1)) {
                            (Some(times), _) => times * slope(1),
                            (_, Some(times)) => times * slope(0),
                            _ => return None,
                        },
                        Op::Div(_) => slope(0) / number(1)?,
                        _ => return None,
                    }
                }
                _ => return None,
            };
            slopes.insert(id, slope);
        }
        Some(slopes[&root])
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
}
