//! What expressions are, in 16 bytes: equal ones have equal fingerprints, whatever graphs they are nodes of.

use super::{Flow, Graph, Node, NodeId};
use crate::num::Digest;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::hash::Hash;

impl Graph {
    /// The fingerprint of an expression, which is the same in every run of the program.
    pub fn fingerprint(&self, root: NodeId) -> Digest {
        let mut digest = Digest::default();
        // Numbers of nodes in the order in which they are first come to, arguments before their users.
        let mut places = HashMap::new();
        let mut pending = vec![root];
        while let Some(&id) = pending.last() {
            let before = pending.len();
            if !places.contains_key(&id) {
                let args = self.node(id).args();
                pending.extend(args.into_iter().rev().filter(|arg| !places.contains_key(arg)));
            }
            if pending.len() > before {
                continue;
            }
            pending.pop();
            let count = places.len() as u32;
            if let Entry::Vacant(place) = places.entry(id) {
                place.insert(count);
                let number = |id: &NodeId| NodeId(places.get(id).copied().unwrap_or(u32::MAX));
                renumbered(self.node(id), number).hash(&mut digest);
            }
        }
        digest
    }
}

/// A node whose arguments have other names.
fn renumbered(node: &Node, name: impl Fn(&NodeId) -> NodeId) -> Node {
    let point = |p: &[NodeId; 3]| p.each_ref().map(&name);
    match node {
        Node::Const(_) | Node::Input(_) => node.clone(),
        Node::Op(op, args) => Node::Op(*op, args.iter().map(&name).collect()),
        Node::Noise(noise, p) => Node::Noise(*noise, point(p)),
        Node::Fractal(f, p, footprint, hurst) => {
            Node::Fractal(f.clone(), point(p), name(footprint), hurst.as_ref().map(&name))
        }
        Node::Grid(grid, p) => Node::Grid(grid.clone(), point(p)),
        Node::Shape(shape, p) => Node::Shape(shape.clone(), point(p)),
        Node::Flow(flow, p) => {
            let carried = Flow { field: name(&flow.field), velocity: point(&flow.velocity), ..**flow };
            Node::Flow(carried.into(), point(p))
        }
    }
}
