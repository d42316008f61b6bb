//! Expressions that a flow carries as a whole.
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
use crate::flow::Precision;
use std::collections::HashMap;
use std::sync::Arc;

impl Graph {
    /// The same expression as a flow of one field; none where it reads the point by other ways than by one flow.
    ///
    /// # Errors
    /// [`TooLarge`].
    pub fn carried(&mut self, root: NodeId) -> Result<Option<NodeId>, TooLarge> {
        let Some((outer, Carrier { velocity, precision, p })) = self.carrier(root) else { return Ok(None) };
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

    /// Whether that is so.
    pub fn is_carried(&self, root: NodeId) -> bool {
        self.carrier(root).is_some()
    }

    /// The only flow by which an expression reads the point, and what the expression is made of as far as that.
    fn carrier(&self, root: NodeId) -> Option<(Vec<NodeId>, Carrier)> {
        let outer = self.walk(&[root], |node| match node {
            Node::Flow(..) => Vec::new(),
            _ => node.outer_args(),
        });
        let mut carrier = None;
        for &id in &outer {
            match self.node(id) {
                Node::Input(Input::X | Input::Y | Input::Z | Input::Footprint) => return None,
                Node::Flow(flow, p) => {
                    let this = Carrier { velocity: flow.velocity, precision: flow.precision, p: *p };
                    if *carrier.get_or_insert(this) != this {
                        return None;
                    }
                }
                _ => {}
            }
        }
        Some((outer, carrier?))
    }
}

/// A flow apart from what it carries, and where it is asked.
#[derive(Clone, Copy, PartialEq)]
struct Carrier {
    velocity: [NodeId; 3],
    precision: Precision,
    p: [NodeId; 3],
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::op::{Add, Mul, Op, Sin, Sub};

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
            assert!(!graph.is_carried(root));
        }
    }
}
