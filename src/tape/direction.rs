//! What of a tape is a matter of direction alone.
//!
//! Detail on a sphere is evaluated at `p / |p|`, which is the same all along a ray from the origin. An enclosure of its
//! derivative along the ray does not see that: the numerator rises there as the denominator does, and in a box that is the
//! difference of two numbers of which neither is known. A function `g` is *homogeneous* of degree `k` if `g(t p) = t^k g(p)`
//! for every `t > 0`; coordinates are of degree 1, and so is `|p|`. Quotients of two of degree 1 do not change along rays.

use super::{Instr, Tape};
use crate::op::Op;

/// Lengths may be larger by that, lest something is divided by zero at the origin.
const LEAST: f64 = 1e-280;

/// How a value grows along rays.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Degree {
    /// It is zero, which is of every degree.
    Nothing,
    Of(i32),
    Unknown,
}

impl Degree {
    /// Of what is of both degrees at once.
    fn with(self, other: Degree) -> Degree {
        match (self, other) {
            (Degree::Nothing, one) | (one, Degree::Nothing) => one,
            (one, other) if one == other => one,
            _ => Degree::Unknown,
        }
    }

    fn times(self, other: Degree) -> Degree {
        match (self, other) {
            (Degree::Nothing, _) | (_, Degree::Nothing) => Degree::Nothing,
            (Degree::Of(a), Degree::Of(b)) => Degree::Of(a + b),
            _ => Degree::Unknown,
        }
    }
}

impl Tape {
    /// The instructions that divide something of degree 1 by the length of the point `p`, in their order. Where that is
    /// `|p| + e` with a tiny `e` the derivative of the quotient `q` along `p` is `q e / (|p| + e)`, and so next to
    /// nothing but at the origin.
    pub fn directions(&self) -> Vec<usize> {
        let mut degrees = Vec::with_capacity(self.code.len());
        let mut found = Vec::new();
        for (i, instr) in self.code.iter().enumerate() {
            degrees.push(degree(instr, &degrees));
            if let Instr::Op(Op::Div(_), [above, below, ..]) = instr
                && degrees[*above as usize] == Degree::Of(1)
                && self.is_length(*below)
            {
                found.push(i);
            }
        }
        found
    }

    /// Whether a slot has the length of the point, or hardly more.
    fn is_length(&self, slot: u32) -> bool {
        let length = match &self.code[slot as usize] {
            Instr::Shift(length, more) if (0.0..=LEAST).contains(more) => *length,
            _ => slot,
        };
        let Instr::Op(Op::Length(_), args) = &self.code[length as usize] else { return false };
        let is_coordinate = |axis: usize| {
            args[..3].iter().any(|&a| matches!(self.code[a as usize], Instr::Coordinate(k) if k == axis))
        };
        (0..3).all(is_coordinate)
    }
}

fn degree(instr: &Instr, known: &[Degree]) -> Degree {
    let of = |slot: &u32| known[*slot as usize];
    match instr {
        Instr::Const(0.0) => Degree::Nothing,
        Instr::Const(_) => Degree::Of(0),
        Instr::Coordinate(_) => Degree::Of(1),
        Instr::Scale(slot, _) => of(slot),
        Instr::Op(op, args) => {
            let args = &args[..op.arity()];
            match op {
                Op::Add(_)
                | Op::Sub(_)
                | Op::Neg(_)
                | Op::Abs(_)
                | Op::Min(_)
                | Op::Max(_)
                | Op::Length(_) => args.iter().map(of).fold(Degree::Nothing, Degree::with),
                Op::Mul(_) => of(&args[0]).times(of(&args[1])),
                Op::Square(_) => of(&args[0]).times(of(&args[0])),
                _ => Degree::Unknown,
            }
        }
        _ => Degree::Unknown,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::{Graph, Input, NodeId};
    use crate::op;

    /// The quotients among some that do not change along rays, and no others, are found.
    #[test]
    fn directions_are_what_is_the_same_along_rays() {
        let mut graph = Graph::default();
        let [x, y, z] = [Input::X, Input::Y, Input::Z].map(|input| graph.input(input).unwrap());
        let [tiny, two, zero] = [1e-290, 2.0, 0.0].map(|c| graph.constant(c).unwrap());
        let mut op = |op: Op, args: &[NodeId]| graph.op(op, args).unwrap();
        let length = op(Op::Length(op::Length), &[z, x, y]);
        let nearly = op(Op::Add(op::Add), &[length, tiny]);
        let more = op(Op::Add(op::Add), &[length, two]);
        let around = op(Op::Length(op::Length), &[x, zero, z]);
        let product = op(Op::Mul(op::Mul), &[x, y]);
        let twice = op(Op::Mul(op::Mul), &[y, two]);
        let size = op(Op::Abs(op::Abs), &[twice]);
        let sum = op(Op::Add(op::Add), &[size, around]);
        let mut over = |a, b| op(Op::Div(op::Div), &[a, b]);
        let same = [over(x, length), over(sum, nearly), over(around, length)];
        let other = [over(x, more), over(product, length), over(x, around), over(more, length)];
        for (nodes, count) in [(&same[..], same.len()), (&other, 0)] {
            assert_eq!(Tape::new(&graph, nodes).directions().len(), count);
        }
    }
}
