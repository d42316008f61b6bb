//! Level of detail: octaves that are finer than the samples of a picture, a mesh or a grid fade out.
//!
//! Fractals ask for the *footprint*, the distance between neighbouring samples at a point. Whoever samples a
//! scene knows it, and puts it into the expressions. As it is part of them from then on, casting and
//! bounding are as exact as for any other field. A fractal that is asked at another place, by `f.at(4 * p)` or
//! on a sphere, asks for the footprint there: scripts multiply it by how far the map stretches space
//! ([`Graph::stretch`]), and divide it by the distance from the origin.

use crate::expr::{Graph, Input, Node, NodeId, TooLarge};
use crate::op::{Add, Length, Mul, Op};
use glam::DVec3;
use std::sync::Arc;

/// How far apart neighbouring samples are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spacing {
    /// Equally far everywhere.
    Even(f64),
    /// In proportion to the distance from a point.
    Angle {
        /// The point.
        from: DVec3,
        /// How far apart they are at distance one.
        angle: f64,
    },
}

impl Spacing {
    /// Expressions with their detail limited, and the graph that they are nodes of now: the same one where
    /// they have no such detail.
    ///
    /// # Errors
    /// If the expressions become too large.
    pub fn limit(&self, graph: &Arc<Graph>, roots: &[NodeId]) -> Result<(Arc<Graph>, Vec<NodeId>), TooLarge> {
        let footprint = Node::Input(Input::Footprint);
        if !graph.reachable(roots).iter().any(|&id| *graph.node(id) == footprint) {
            return Ok((graph.clone(), roots.to_vec()));
        }
        let mut graph = Graph::clone(graph);
        let footprint = self.node(&mut graph)?;
        let limited = |root: &NodeId| graph.substitute(*root, &[(Input::Footprint, footprint)]);
        let roots = roots.iter().map(limited).collect::<Result<_, _>>()?;
        Ok((Arc::new(graph), roots))
    }

    /// The footprint as an expression.
    fn node(&self, graph: &mut Graph) -> Result<NodeId, TooLarge> {
        let (from, angle) = match *self {
            Spacing::Even(spacing) => return graph.constant(spacing),
            Spacing::Angle { from, angle } => (from, angle),
        };
        let mut offset = graph.point()?;
        for (axis, node) in offset.iter_mut().enumerate() {
            let start = graph.constant(-from[axis])?;
            *node = graph.op(Op::Add(Add), &[*node, start])?;
        }
        let distance = graph.op(Op::Length(Length), &offset)?;
        let angle = graph.constant(angle)?;
        graph.op(Op::Mul(Mul), &[distance, angle])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tape::{Evaluator, Tape};

    #[test]
    fn the_footprint_is_the_distance_between_samples() {
        let mut graph = Graph::default();
        let root = graph.input(Input::Footprint).unwrap();
        let graph = Arc::new(graph);
        let at = |spacing: Spacing, p: DVec3| {
            let (graph, roots) = spacing.limit(&graph, &[root]).unwrap();
            *Evaluator::<f64>::new(Arc::new(Tape::new(&graph, &roots))).eval(&p.to_array())
        };
        let from = DVec3::new(1.0, 2.0, 3.0);
        let seen = at(Spacing::Angle { from, angle: 0.01 }, from + DVec3::new(3.0, 0.0, 4.0));
        assert!((seen - 0.05).abs() < 1e-15);
        assert_eq!(at(Spacing::Even(0.25), from), 0.25);
    }

    #[test]
    fn a_field_without_footprint_keeps_its_graph() {
        let mut graph = Graph::default();
        let root = graph.input(Input::X).unwrap();
        let graph = Arc::new(graph);
        let (same, roots) = Spacing::Even(1.0).limit(&graph, &[root]).unwrap();
        assert!(Arc::ptr_eq(&graph, &same) && roots == [root]);
    }
}
