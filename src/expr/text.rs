//! Expressions as text: the plain files that modelling programs of Fidget's kind exchange.
//!
//! A line names a value, an operation and the values that it works on; the last line's value is the
//! expression. Names are any words, each defined once and before its use:
//!
//! ```text
//! # a ball of radius one
//! _0 var-x
//! _1 square _0
//! ...
//! _8 const 1
//! _9 sub _7 _8
//! ```
//!
//! Operations that exist here under another name, or as two or three others, become those.

use super::{Graph, Input, NodeId, TooLarge};
use crate::diag::{Diagnostic, Place, nearest};
use crate::op::{self, Op};
use std::collections::HashMap;
use std::sync::Arc;

/// What a word for an operation stands for.
#[derive(Clone, Copy)]
enum Meaning {
    /// The number that follows.
    Number,
    /// A coordinate.
    Coordinate(Input),
    /// An operation.
    Op(Op),
    /// Several operations on a number of arguments.
    Ops(usize, fn(&mut Graph, &[NodeId]) -> Result<NodeId, TooLarge>),
}

/// Every operation of the format.
const MEANINGS: &[(&str, Meaning)] = &[
    ("const", Meaning::Number),
    ("var-x", Meaning::Coordinate(Input::X)),
    ("var-y", Meaning::Coordinate(Input::Y)),
    ("var-z", Meaning::Coordinate(Input::Z)),
    ("add", Meaning::Op(Op::Add(op::Add))),
    ("sub", Meaning::Op(Op::Sub(op::Sub))),
    ("mul", Meaning::Op(Op::Mul(op::Mul))),
    ("div", Meaning::Op(Op::Div(op::Div))),
    ("neg", Meaning::Op(Op::Neg(op::Neg))),
    ("abs", Meaning::Op(Op::Abs(op::Abs))),
    ("square", Meaning::Op(Op::Square(op::Square))),
    ("sqrt", Meaning::Op(Op::Sqrt(op::Sqrt))),
    ("min", Meaning::Op(Op::Min(op::Min))),
    ("max", Meaning::Op(Op::Max(op::Max))),
    ("exp", Meaning::Op(Op::Exp(op::Exp))),
    ("ln", Meaning::Op(Op::Ln(op::Ln))),
    ("sin", Meaning::Op(Op::Sin(op::Sin))),
    ("cos", Meaning::Op(Op::Cos(op::Cos))),
    ("tan", Meaning::Op(Op::Tan(op::Tan))),
    ("asin", Meaning::Op(Op::Asin(op::Asin))),
    ("acos", Meaning::Op(Op::Acos(op::Acos))),
    ("atan", Meaning::Op(Op::Atan(op::Atan))),
    ("atan2", Meaning::Op(Op::Atan2(op::Atan2))),
    ("floor", Meaning::Op(Op::Floor(op::Floor))),
    ("recip", Meaning::Ops(1, reciprocal)),
    ("ceil", Meaning::Ops(1, ceiling)),
    ("round", Meaning::Ops(1, rounded)),
    ("not", Meaning::Ops(1, is_zero)),
    ("mod", Meaning::Ops(2, remainder)),
    ("compare", Meaning::Ops(2, compared)),
    ("and", Meaning::Ops(2, and)),
    ("or", Meaning::Ops(2, or)),
];

/// `1 / x`
fn reciprocal(g: &mut Graph, x: &[NodeId]) -> Result<NodeId, TooLarge> {
    let one = g.constant(1.0)?;
    g.op(Op::Div(op::Div), &[one, x[0]])
}

/// The smallest integer not below: `-floor(-x)`.
fn ceiling(g: &mut Graph, x: &[NodeId]) -> Result<NodeId, TooLarge> {
    let mirrored = g.op(Op::Neg(op::Neg), x)?;
    let floor = g.op(Op::Floor(op::Floor), &[mirrored])?;
    g.op(Op::Neg(op::Neg), &[floor])
}

/// The nearest integer, away from zero where two are: `sign(x) (floor |x| + step(1/2, fract |x|))`.
fn rounded(g: &mut Graph, x: &[NodeId]) -> Result<NodeId, TooLarge> {
    let (sign, size) = (g.op(Op::Sign(op::Sign), x)?, g.op(Op::Abs(op::Abs), x)?);
    let (floor, rest) = (g.op(Op::Floor(op::Floor), &[size])?, g.op(Op::Fract(op::Fract), &[size])?);
    let half = g.constant(0.5)?;
    let up = g.op(Op::Step(op::Step), &[half, rest])?;
    let size = g.op(Op::Add(op::Add), &[floor, up])?;
    g.op(Op::Mul(op::Mul), &[sign, size])
}

/// 1 where `x` is not zero, else 0: `|sign(x)|`.
fn is_not_zero(g: &mut Graph, x: NodeId) -> Result<NodeId, TooLarge> {
    let sign = g.op(Op::Sign(op::Sign), &[x])?;
    g.op(Op::Abs(op::Abs), &[sign])
}

/// 1 where `x` is zero, else 0.
fn is_zero(g: &mut Graph, x: &[NodeId]) -> Result<NodeId, TooLarge> {
    let (one, otherwise) = (g.constant(1.0)?, is_not_zero(g, x[0])?);
    g.op(Op::Sub(op::Sub), &[one, otherwise])
}

/// What is left above whole periods, never negative: `modulo(x, |period|)`.
fn remainder(g: &mut Graph, x: &[NodeId]) -> Result<NodeId, TooLarge> {
    let period = g.op(Op::Abs(op::Abs), &x[1..])?;
    g.op(Op::Modulo(op::Modulo), &[x[0], period])
}

/// -1, 0 or 1 as `a` is below, at or above `b`: `sign(a - b)`.
fn compared(g: &mut Graph, x: &[NodeId]) -> Result<NodeId, TooLarge> {
    let gap = g.op(Op::Sub(op::Sub), x)?;
    g.op(Op::Sign(op::Sign), &[gap])
}

/// `a` where that is zero, else `b`.
fn and(g: &mut Graph, x: &[NodeId]) -> Result<NodeId, TooLarge> {
    let chosen = is_not_zero(g, x[0])?;
    g.op(Op::Mul(op::Mul), &[x[1], chosen])
}

/// `a` unless that is zero, else `b`.
fn or(g: &mut Graph, x: &[NodeId]) -> Result<NodeId, TooLarge> {
    let chosen = is_zero(g, &x[..1])?;
    let other = g.op(Op::Mul(op::Mul), &[x[1], chosen])?;
    g.op(Op::Add(op::Add), &[x[0], other])
}

/// Reads an expression; `file` is its name in places.
///
/// # Errors
/// The first line that cannot be understood, and why; also where the graph has no room.
pub fn read(graph: &mut Graph, file: &str, text: &str) -> Result<NodeId, Box<Diagnostic>> {
    let file: Arc<str> = Arc::from(file);
    let mut known = HashMap::new();
    let mut last = None;
    for (line, number) in text.trim_start_matches('\u{feff}').lines().zip(1..) {
        let words = words(line);
        let Some(&name) = words.first().filter(|name| !name.text.starts_with('#')) else { continue };
        let at = Line { file: &file, number, words: &words };
        let node = at.node(graph, &known)?;
        if known.insert(name.text, node).is_some() {
            let message = format!("`{}` is defined a second time", name.text);
            return Err(at.wrong(0, message, "every line needs a name of its own"));
        }
        last = Some(node);
    }
    last.ok_or_else(|| {
        let empty = Diagnostic::error(format!("{file} has no expression in it"));
        Box::new(empty.hint("a line is `name operation arguments`, such as `_0 var-x`; the last one counts"))
    })
}

/// A word and the column where it starts, from 1.
#[derive(Clone, Copy)]
struct Word<'a> {
    text: &'a str,
    column: u32,
}

fn words(line: &str) -> Vec<Word<'_>> {
    let mut next = 1;
    let placed = line.split(char::is_whitespace).map(|text| {
        let column = next;
        next += text.chars().count() as u32 + 1;
        Word { text, column }
    });
    placed.filter(|word| !word.text.is_empty()).collect()
}

/// A line that is not empty, and where it is.
struct Line<'a> {
    file: &'a Arc<str>,
    number: u32,
    words: &'a [Word<'a>],
}

impl Line<'_> {
    /// What the line defines.
    fn node(&self, graph: &mut Graph, known: &HashMap<&str, NodeId>) -> Result<NodeId, Box<Diagnostic>> {
        let (arity, meaning) = self.meaning()?;
        let given = self.words.len() - 2;
        if given != arity {
            let op = self.words[1].text;
            let message =
                format!("`{op}` takes {arity} argument{}, not {given}", if arity == 1 { "" } else { "s" });
            return Err(self.wrong(1, message, "a line is `name operation arguments`"));
        }
        let args = match meaning {
            Meaning::Number => Vec::new(),
            _ => (2..self.words.len()).map(|i| self.argument(i, known)).collect::<Result<Vec<_>, _>>()?,
        };
        let before = graph.len();
        let node = match meaning {
            Meaning::Number => graph.constant(self.number(2)?),
            Meaning::Coordinate(input) => graph.input(input),
            Meaning::Op(op) => graph.op(op, &args),
            Meaning::Ops(_, make) => make(graph, &args),
        };
        let node =
            node.map_err(|e| self.wrong(0, e.to_string(), "a script has no room for so large a model"))?;
        if graph.as_const(node).is_some_and(f64::is_nan) {
            let hint = "it comes from something like 0 / 0 or the square root of a negative number";
            return Err(self.wrong(1, "the value of this line is not a number".to_owned(), hint));
        }
        // What is made of several operations comes from this line as a whole.
        graph.since(before).for_each(|made| graph.set_place(made, &self.place(1)));
        Ok(node)
    }

    /// The operation of the line, and how many arguments it takes.
    fn meaning(&self) -> Result<(usize, Meaning), Box<Diagnostic>> {
        let Some(op) = self.words.get(1) else {
            let message = format!("`{}` has no operation", self.words[0].text);
            return Err(self.wrong(0, message, "a line is `name operation arguments`; remarks start with #"));
        };
        let found = MEANINGS.iter().find(|(name, _)| *name == op.text).map(|(_, meaning)| *meaning);
        let Some(meaning) = found else {
            let names = MEANINGS.iter().map(|(name, _)| *name);
            let hint = match nearest(op.text, names.clone()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("there are {}", names.collect::<Vec<_>>().join(", ")),
            };
            return Err(self.wrong(1, format!("there is no operation `{}`", op.text), &hint));
        };
        let arity = match meaning {
            Meaning::Coordinate(_) => 0,
            Meaning::Number => 1,
            Meaning::Op(op) => op.arity(),
            Meaning::Ops(arity, _) => arity,
        };
        Ok((arity, meaning))
    }

    /// The value that word `i` names.
    fn argument(&self, i: usize, known: &HashMap<&str, NodeId>) -> Result<NodeId, Box<Diagnostic>> {
        let name = self.words[i].text;
        known.get(name).copied().ok_or_else(|| {
            self.wrong(i, format!("`{name}` is not defined"), "a value is defined on a line above its use")
        })
    }

    /// The number that word `i` writes.
    fn number(&self, i: usize) -> Result<f64, Box<Diagnostic>> {
        let text = self.words[i].text;
        text.parse().ok().filter(|c: &f64| c.is_finite()).ok_or_else(|| {
            self.wrong(i, format!("`{text}` is not a finite number"), "numbers look like -0.5, 12 or 1e-3")
        })
    }

    fn place(&self, i: usize) -> Place {
        let Word { text, column } = self.words[i];
        Place { file: self.file.clone(), line: self.number, column, width: text.chars().count() as u32 }
    }

    fn wrong(&self, i: usize, message: String, hint: &str) -> Box<Diagnostic> {
        Box::new(Diagnostic::error(message).at(self.place(i)).hint(hint))
    }
}
