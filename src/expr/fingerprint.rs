//! What expressions are, in 16 bytes: equal ones have equal fingerprints, whatever graphs they are nodes of and whatever was
//! made before them. That of a node is made of its own data and the fingerprints of its arguments (Merkle 1987).

use super::{Flow, Graph, Node, NodeId};
use crate::num::Digest;
use crate::op::Op;
use std::collections::HashMap;
use std::hash::Hash;

impl Graph {
    /// The fingerprint of an expression, which is the same in every run of the program.
    pub fn fingerprint(&self, root: NodeId) -> Digest {
        let mut known: HashMap<NodeId, Digest> = HashMap::new();
        // Arguments come before their users.
        for id in self.reachable(&[root]) {
            let node = self.node(id);
            let mut args: Vec<Digest> =
                node.args().iter().filter_map(|arg| known.get(arg).copied()).collect();
            // Their order is that in which they were made, and means nothing.
            if matches!(node, Node::Op(Op::Add(_) | Op::Mul(_), _)) {
                args.sort();
            }
            let mut digest = Digest::default();
            alone(node).hash(&mut digest);
            args.into_iter().for_each(|arg| digest.join(arg));
            known.insert(id, digest);
        }
        known.remove(&root).unwrap_or_default()
    }
}

/// A node without the names of its arguments.
fn alone(node: &Node) -> Node {
    const NONE: NodeId = NodeId(0);
    match node {
        Node::Const(_) | Node::Input(_) => node.clone(),
        Node::Op(op, args) => Node::Op(*op, vec![NONE; args.len()]),
        Node::Noise(noise, _) => Node::Noise(*noise, [NONE; 3]),
        Node::Fractal(fractal, _, _, hurst) => {
            Node::Fractal(fractal.clone(), [NONE; 3], NONE, hurst.map(|_| NONE))
        }
        Node::Grid(grid, _) => Node::Grid(grid.clone(), [NONE; 3]),
        Node::Shape(shape, _) => Node::Shape(shape.clone(), [NONE; 3]),
        Node::Flow(flow, _) => {
            Node::Flow(Flow { field: NONE, velocity: [NONE; 3], ..**flow }.into(), [NONE; 3])
        }
    }
}
