//! Expressions that are their own mirror images.
//!
//! An expression and its mirror image, in which one coordinate has the other sign, are brought into one form: signs go
//! outwards through sums and products, and vanish where an operation is even; what is added or chosen among is put in
//! order. Where both forms are the same the expression is even, in every bit but for the signs of zeros, and of the
//! infinities that they divide to: negation is exact, and so `(-a) + (-b) = -(a + b)` and `max(a, b) = -min(-a, -b)`. So a
//! solid is seen to be symmetric of which one half is even itself, and of which two parts are mirror images of each
//! other.

use super::graph::{Graph, Input, Node, NodeId};
use crate::op::{Add, Op};
use std::collections::HashMap;

/// A form or what it is with the other sign.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
struct Signed {
    form: usize,
    is_negative: bool,
}

impl Signed {
    fn negated_if(self, is_other: bool) -> Signed {
        Signed { is_negative: self.is_negative ^ is_other, ..self }
    }
}

/// What has no sign of its own.
#[derive(PartialEq, Eq, Hash)]
enum Form {
    /// The bits of a number that is not below zero.
    Const(u64),
    Input(Input),
    Op(Op, Vec<Signed>),
    /// The least of several.
    Least(Vec<Signed>),
    /// Anything else.
    Other(NodeId, Vec<Signed>),
}

/// All forms there are, each by its number.
#[derive(Default)]
struct Forms {
    numbers: HashMap<Form, usize>,
    /// Of those that are numbers, which.
    values: HashMap<usize, f64>,
    /// Of those that are the least of several, what these are.
    least: HashMap<usize, Vec<Signed>>,
}

impl Graph {
    /// Whether an expression is seen to have the same value where an input, such as a coordinate, has the other sign.
    /// There are expressions that have, and are not seen to.
    pub fn is_even(&self, root: NodeId, input: Input) -> bool {
        let mut forms = Forms::default();
        let plain = self.form(root, None, &mut forms);
        plain == self.form(root, Some(input), &mut forms)
    }

    /// The form of an expression, with the sign of an input changed.
    fn form(&self, root: NodeId, turned: Option<Input>, forms: &mut Forms) -> Signed {
        let mut known: HashMap<NodeId, Signed> = HashMap::new();
        for id in self.reachable_here(&[root]) {
            let node = self.node(id);
            let args: Vec<Signed> = node.outer_args().iter().map(|arg| known[arg]).collect();
            let form = match node {
                Node::Const(bits) => {
                    let c = f64::from_bits(*bits);
                    let form = forms.plain(Form::Const(c.abs().to_bits()));
                    forms.values.insert(form.form, c.abs());
                    form.negated_if(c.is_sign_negative())
                }
                Node::Input(input) => forms.plain(Form::Input(*input)).negated_if(turned == Some(*input)),
                Node::Op(op, _) => forms.of(*op, args),
                _ => forms.plain(Form::Other(id, args)),
            };
            known.insert(id, form);
        }
        known[&root]
    }
}

impl Forms {
    fn plain(&mut self, form: Form) -> Signed {
        let next = self.numbers.len();
        Signed { form: *self.numbers.entry(form).or_insert(next), is_negative: false }
    }

    fn of(&mut self, op: Op, mut args: Vec<Signed>) -> Signed {
        match op {
            Op::Neg(_) => args[0].negated_if(true),
            Op::Sub(_) => self.sum(args[0], args[1].negated_if(true)),
            Op::Add(_) => self.sum(args[0], args[1]),
            Op::Mul(_) | Op::Div(_) => {
                let is_negative = args[0].is_negative ^ args[1].is_negative;
                args.iter_mut().for_each(|arg| arg.is_negative = false);
                self.quotient_or_product(op, args).negated_if(is_negative)
            }
            Op::Dot(_) => self.products(op, args),
            Op::Min(_) => self.least(&args),
            Op::Max(_) => self.least(&[args[0].negated_if(true), args[1].negated_if(true)]).negated_if(true),
            Op::Clamp(_) if args[0].is_negative && self.are_in_order(args[1], args[2]) => {
                let turned = [0, 2, 1].map(|i: usize| args[i].negated_if(true));
                self.plain(Form::Op(op, turned.to_vec())).negated_if(true)
            }
            _ => {
                if op.is_even() {
                    args.iter_mut().for_each(|arg| arg.is_negative = false);
                }
                self.plain(Form::Op(op, args))
            }
        }
    }

    /// Whether these are known to be numbers of which the first is not above the second: else they clamp otherwise from
    /// the other side.
    fn are_in_order(&self, low: Signed, high: Signed) -> bool {
        let value =
            |of: Signed| self.values.get(&of.form).map(|value| if of.is_negative { -value } else { *value });
        value(low).zip(value(high)).is_some_and(|(low, high)| low <= high)
    }

    /// The sum of two, of which the first has no sign.
    fn sum(&mut self, a: Signed, b: Signed) -> Signed {
        let [a, b] = if a <= b { [a, b] } else { [b, a] };
        let terms = [a, b].map(|term| term.negated_if(a.is_negative));
        self.plain(Form::Op(Op::Add(Add), terms.to_vec())).negated_if(a.is_negative)
    }

    /// Of two without signs. Those by one are what is left of those by minus one.
    fn quotient_or_product(&mut self, op: Op, mut args: Vec<Signed>) -> Signed {
        let one = self.plain(Form::Const(1f64.to_bits()));
        match op {
            _ if args[1] == one => args[0],
            Op::Mul(_) if args[0] == one => args[1],
            Op::Mul(_) => {
                args.sort();
                self.plain(Form::Op(op, args))
            }
            _ => self.plain(Form::Op(op, args)),
        }
    }

    /// A sum of three products, of which the first that is not zero has no sign.
    fn products(&mut self, op: Op, mut args: Vec<Signed>) -> Signed {
        let zero = self.plain(Form::Const(0));
        let mut is_negative = None;
        for i in 0..3 {
            let sign = args[i].is_negative ^ args[i + 3].is_negative;
            [args[i].is_negative, args[i + 3].is_negative] = [false; 2];
            if args[i] != zero && args[i + 3] != zero {
                args[i].is_negative = sign ^ *is_negative.get_or_insert(sign);
            }
        }
        self.plain(Form::Op(op, args)).negated_if(is_negative.unwrap_or_default())
    }

    fn least(&mut self, args: &[Signed]) -> Signed {
        let mut all = Vec::new();
        for arg in args {
            match self.least.get(&arg.form) {
                Some(parts) if !arg.is_negative => all.extend_from_slice(parts),
                _ => all.push(*arg),
            }
        }
        all.sort();
        all.dedup();
        let form = self.plain(Form::Least(all.clone()));
        self.least.insert(form.form, all);
        form
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::op::{Abs, Clamp, Div, Dot, Max, Min, Mul, Neg, Sub};
    use crate::tape::{Evaluator, Tape};
    use rand::{RngExt, SeedableRng, rngs::StdRng};
    use std::sync::Arc;

    /// Bounds that cross clamp otherwise from the other side, and zero times infinity is no number.
    #[test]
    fn what_is_odd_or_nothing_only_here_is_not_even() {
        let mut graph = Graph::default();
        let [x, y, _] = graph.point().unwrap();
        let [zero, one] = [0.0, 1.0].map(|c| graph.constant(c).unwrap());
        let mut op = |op: Op, args: &[NodeId]| graph.op(op, args).unwrap();
        let (more, less) = (op(Op::Add(Add), &[x, one]), op(Op::Sub(Sub), &[x, one]));
        let clamped = op(Op::Clamp(Clamp), &[x, more, less]);
        let crossed = op(Op::Abs(Abs), &[clamped]);
        let half = op(Op::Max(Max), &[x, zero]);
        let pole = op(Op::Div(Div), &[one, half]);
        let nothing = op(Op::Dot(Dot), &[zero, y, y, pole, one, one]);
        let minus = op(Op::Neg(Neg), &[one]);
        let inner = op(Op::Clamp(Clamp), &[x, minus, one]);
        let even = op(Op::Abs(Abs), &[inner]);
        assert_eq!([crossed, nothing, even].map(|root| graph.is_even(root, Input::X)), [false, false, true]);
    }

    /// Random expressions: what is seen to be even has the same values on both sides, and what is made of the sum or the
    /// least of something and its mirror image is seen to be.
    #[test]
    fn what_is_seen_to_be_even_is() {
        let mut rng = StdRng::seed_from_u64(5);
        let mut seen = 0;
        for _ in 0..3000 {
            let mut graph = Graph::default();
            let [x, y, z] = graph.point().unwrap();
            let mut turned = HashMap::from([(x, graph.op(Op::Neg(Neg), &[x]).unwrap()), (y, y), (z, z)]);
            let mut all = vec![x, y, z];
            for _ in 0..8 {
                let constant = graph.constant(f64::from(rng.random_range(-3..4)) * 0.3).unwrap();
                turned.insert(constant, constant);
                all.push(constant);
                let op = Op::ALL[rng.random_range(0..Op::ALL.len())];
                let args: Vec<NodeId> =
                    (0..op.arity()).map(|_| all[rng.random_range(0..all.len())]).collect();
                let image: Vec<NodeId> = args.iter().map(|arg| turned[arg]).collect();
                let node = graph.op(op, &args).unwrap();
                turned.insert(node, graph.op(op, &image).unwrap());
                all.push(node);
            }
            let last = all[all.len() - 1];
            for op in [Op::Min(Min), Op::Add(Add), Op::Max(Max), Op::Mul(Mul)] {
                let both = graph.op(op, &[last, turned[&last]]).unwrap();
                assert!(graph.is_even(both, Input::X), "{op:?}");
            }
            if graph.is_even(last, Input::X) {
                seen += 1;
                let mut field = Evaluator::<f64>::new(Arc::new(Tape::new(&graph, &[last])));
                for _ in 0..20 {
                    let p: [f64; 3] = std::array::from_fn(|_| rng.random_range(-2.0..2.0));
                    let [a, b] = [p, [-p[0], p[1], p[2]]].map(|p| *field.eval(&p));
                    assert!(a == b || a.is_nan() && b.is_nan(), "{a} and {b}");
                }
            }
        }
        assert!(seen > 300, "{seen}");
    }
}
