//! Folding: constants are computed, and the identities of arithmetic applied, as nodes are added.
//!
//! Nothing is rewritten that would change a bit of a finite result, so a folded expression draws
//! the same picture. (`0 x` is 0 even where `x` is infinite or not a number, and a zero may lose its sign.)

use super::{Graph, NodeId};
use crate::op::{Op, Square};

/// What becomes of an operation.
pub(super) enum Folded {
    /// It is an expression that is there already.
    Node(NodeId),
    /// It is a number.
    Const(f64),
    /// It stays, or is another one that has the same bits, with its arguments in canonical order.
    Op(Op, Vec<NodeId>),
    /// It is the sum of the squares of these.
    Squares([NodeId; 3]),
}

/// What an operation is, given which of its arguments are numbers.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Identity {
    /// The argument with this number.
    Argument(usize),
    /// A number.
    Number(f64),
}

pub(super) fn fold(graph: &Graph, op: Op, args: &[NodeId]) -> Folded {
    match identity(op, |i| graph.as_const(args[i])) {
        Some(Identity::Argument(i)) => return Folded::Node(args[i]),
        Some(Identity::Number(c)) => return Folded::Const(c),
        None => {}
    }
    if let Some(folded) = of_equals(graph, op, args) {
        return folded;
    }
    let mut args = args.to_vec();
    // IEEE sums, products and the like do not depend on the order of two operands.
    if matches!(op, Op::Add(_) | Op::Mul(_)) {
        args.sort();
    }
    Folded::Op(op, args)
}

/// What an operation is, where that follows from those arguments that are numbers; `number(i)` says
/// what argument `i` is.
pub fn identity(op: Op, number: impl Fn(usize) -> Option<f64>) -> Option<Identity> {
    use Identity::{Argument, Number};
    let mut numbers = [None; 6];
    let consts = &mut numbers[..op.arity()];
    consts.iter_mut().enumerate().for_each(|(i, c)| *c = number(i));
    if consts.iter().all(Option::is_some) {
        let values = numbers.map(Option::unwrap_or_default);
        return Some(Number(op.apply(|i| &values[i])));
    }
    match (op, &*consts) {
        (Op::Add(_), [Some(0.0), _]) | (Op::Mul(_), [Some(1.0), _]) => Some(Argument(1)),
        (Op::Add(_) | Op::Sub(_), [_, Some(0.0)]) | (Op::Mul(_) | Op::Div(_), [_, Some(1.0)]) => {
            Some(Argument(0))
        }
        (Op::Mul(_), [Some(0.0), _] | [_, Some(0.0)]) => Some(Number(0.0)),
        (Op::Mix(_), [_, _, Some(0.0)]) => Some(Argument(0)),
        (Op::Dot(_), _) => coordinate(consts).map(Argument),
        _ => None,
    }
}

/// Which argument a sum of three products is, if it is that one times one, and two products with zero.
fn coordinate(args: &[Option<f64>]) -> Option<usize> {
    let is_nothing = |i: usize| args[i] == Some(0.0) || args[(i + 3) % 6] == Some(0.0);
    let is_alone = |i: usize| is_nothing((i + 1) % 3) && is_nothing((i + 2) % 3);
    (0..6).find(|&i| args[(i + 3) % 6] == Some(1.0) && is_alone(i % 3))
}

/// What an operation on the same expression twice is, or on its own inverse.
fn of_equals(graph: &Graph, op: Op, args: &[NodeId]) -> Option<Folded> {
    match op {
        Op::Min(_) | Op::Max(_) if args[0] == args[1] => Some(Folded::Node(args[0])),
        Op::Sub(_) if args[0] == args[1] => Some(Folded::Const(0.0)),
        // An enclosure of a product does not know that both are the same, and so may be below zero.
        Op::Mul(_) if args[0] == args[1] => Some(Folded::Op(Op::Square(Square), vec![args[0]])),
        Op::Dot(_) if args[..3] == args[3..] => Some(Folded::Squares([args[0], args[1], args[2]])),
        Op::Neg(_) => match graph.node(args[0]) {
            super::Node::Op(Op::Neg(_), inner) => Some(Folded::Node(inner[0])),
            _ => None,
        },
        _ => None,
    }
}
