//! Expressions that a flow carries as a whole, and linear maps of the point.
//!
//! What is made of nothing but values of fields that one flow carries is carried by that flow itself. With `phi` the flow,
//! and `m(p)` the place where it is asked,
//!
//! ```text
//! h(f(phi(m(p))), g(phi(m(p))))  =  h(f, g) (phi(m(p)))
//! ```
//!
//! So `f.flow(v) - 0.1`, and the union of `f.flow(v)` and `g.flow(v)`, are flowed solids. That is so bit for bit.

use super::graph::{Flow, Graph, Input, Node, NodeId, TooLarge};
use crate::op::Op;
use glam::DVec3;
use std::collections::HashMap;
use std::sync::Arc;

impl Graph {
    /// The same expression as a flow of one field; none where it reads the point by other ways than by one flow.
    ///
    /// # Errors
    /// [`TooLarge`].
    pub fn carried(&mut self, root: NodeId) -> Result<Option<NodeId>, TooLarge> {
        let outer = self.walk(&[root], |node| match node {
            Node::Flow(..) => Vec::new(),
            _ => node.outer_args(),
        });
        let mut whose = None;
        for &id in &outer {
            match self.node(id) {
                Node::Input(Input::X | Input::Y | Input::Z | Input::Footprint) => return Ok(None),
                Node::Flow(flow, p) => {
                    let this = (flow.velocity, flow.precision, *p);
                    if *whose.get_or_insert(this) != this {
                        return Ok(None);
                    }
                }
                _ => {}
            }
        }
        let Some((velocity, precision, p)) = whose else { return Ok(None) };
        let (mut image, within_flows) = (HashMap::with_capacity(outer.len()), HashMap::new());
        for id in outer {
            let now = match self.node(id) {
                Node::Flow(flow, _) => flow.field,
                _ => self.replaced(id, &[], &image, &within_flows)?,
            };
            image.insert(id, now);
        }
        let flow = self.flow(Arc::new(Flow { field: image[&root], velocity, precision }), p)?;
        if let Some(place) = self.place(root).cloned() {
            self.set_place(flow, &place);
        }
        Ok(Some(flow))
    }

    /// The slopes of an expression along the axes, if it is a sum of multiples of the coordinates and of a number.
    pub fn linear(&self, root: NodeId) -> Option<DVec3> {
        let mut slopes: HashMap<NodeId, DVec3> = HashMap::new();
        for id in self.reachable_here(&[root]) {
            let slope = match self.node(id) {
                Node::Const(_) => DVec3::ZERO,
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
    use crate::flow::Precision;
    use crate::op::{Add, Div, Mul, Neg, Sin, Sub};

    /// Flows of fields by one velocity, asked at a place.
    fn flows(graph: &mut Graph, fields: [NodeId; 2], p: [NodeId; 3]) -> [NodeId; 2] {
        let velocity = graph.point().unwrap();
        fields.map(|field| {
            let precision = Precision::Steps(4);
            graph.flow(Arc::new(Flow { field, velocity, precision }), p).unwrap()
        })
    }

    #[test]
    fn what_is_made_of_one_flow_is_carried_by_it() {
        let mut graph = Graph::default();
        let [x, y, z] = graph.point().unwrap();
        let two = graph.constant(2.0).unwrap();
        let moved = graph.op(Op::Sub(Sub), &[x, two]).unwrap();
        let [f, g] = flows(&mut graph, [y, z], [moved, y, z]);
        let sum = graph.op(Op::Add(Add), &[f, g]).unwrap();
        let sine = graph.op(Op::Sin(Sin), &[sum]).unwrap();
        let carried = graph.carried(sine).unwrap().unwrap();
        let Node::Flow(flow, p) = graph.node(carried).clone() else { panic!("it is a flow") };
        assert_eq!(p, [moved, y, z]);
        let inner = graph.op(Op::Add(Add), &[y, z]).unwrap();
        assert_eq!(flow.field, graph.op(Op::Sin(Sin), &[inner]).unwrap());
        assert_eq!(graph.carried(carried), Ok(Some(carried)));
        // It reads the point beside the flow, or another flow, or none.
        let beside = graph.op(Op::Add(Add), &[sine, x]).unwrap();
        let [other, _] = flows(&mut graph, [y, z], [x, y, z]);
        let both = graph.op(Op::Add(Add), &[sine, other]).unwrap();
        let pixel = graph.input(Input::Footprint).unwrap();
        let blurred = graph.op(Op::Mul(Mul), &[sine, pixel]).unwrap();
        for root in [beside, both, blurred, two, x] {
            assert_eq!(graph.carried(root), Ok(None));
        }
    }

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
        assert_eq!([bent, over].map(|root| graph.linear(root)), [None; 2]);
    }
}
