//! Folding: constants are computed, and the identities of arithmetic applied, as nodes are added.
//!
//! Nothing is rewritten that would change a bit of a finite result, so a folded expression draws
//! the same picture. (`0 x` is 0 even where `x` is infinite or not a number.)

use super::{Graph, NodeId};
use crate::op::Op;

/// What becomes of an operation.
pub(super) enum Folded {
    /// It is an expression that is there already.
    Node(NodeId),
    /// It is a number.
    Const(f64),
    /// It stays, with its arguments in canonical order.
    Op(Vec<NodeId>),
}

pub(super) fn fold(graph: &Graph, op: Op, args: &[NodeId]) -> Folded {
    let consts: Vec<Option<f64>> = args.iter().map(|&a| graph.as_const(a)).collect();
    if let Some(values) = consts.iter().copied().collect::<Option<Vec<f64>>>() {
        return Folded::Const(op.apply(|i| &values[i]));
    }
    if let Some(folded) = identity(graph, op, args, &consts) {
        return folded;
    }
    let mut args = args.to_vec();
    // IEEE sums, products and the like do not depend on the order of two operands.
    if matches!(op, Op::Add(_) | Op::Mul(_)) {
        args.sort();
    }
    Folded::Op(args)
}

fn identity(graph: &Graph, op: Op, args: &[NodeId], consts: &[Option<f64>]) -> Option<Folded> {
    let node = |i: usize| Some(Folded::Node(args[i]));
    match (op, consts) {
        (Op::Add(_), [Some(0.0), _]) | (Op::Mul(_), [Some(1.0), _]) => node(1),
        (Op::Add(_) | Op::Sub(_), [_, Some(0.0)]) | (Op::Mul(_) | Op::Div(_), [_, Some(1.0)]) => node(0),
        (Op::Mul(_), [Some(0.0), _] | [_, Some(0.0)]) => Some(Folded::Const(0.0)),
        (Op::Min(_) | Op::Max(_), _) if args[0] == args[1] => node(0),
        (Op::Sub(_), _) if args[0] == args[1] => Some(Folded::Const(0.0)),
        (Op::Neg(_), _) => match graph.node(args[0]) {
            super::Node::Op(Op::Neg(_), inner) => Some(Folded::Node(inner[0])),
            _ => None,
        },
        _ => None,
    }
}
