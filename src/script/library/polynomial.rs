//! Polynomials in x, y and z, written as mathematicians write them or as a list of coefficients.
//!
//! A text is read into an expression that keeps its parentheses, since `(x^2 + y^2 - 1)^2` is shorter and
//! better enclosed than what it expands to. Sums of monomials are built by Horner's scheme in several
//! variables: the variable that most terms share is taken out of them in its least power, which leaves two
//! smaller sums. Powers are shared, and even ones are known not to be negative.

use super::Library;
use crate::expr::NodeId;
use crate::num::power;
use crate::op::{self, Op};
use crate::script::fault::{Fault, Outcome};
use crate::script::host::Host;
use crate::script::options::describe;
use crate::script::value::{Field, number};
use rhai::{Array, Dynamic};

/// The largest exponent.
const HIGHEST: u32 = 64;
/// Parentheses inside one another.
const DEEPEST: usize = 32;

pub(super) fn register(lib: &mut Library<'_>) {
    lib.def(
        "polynomial(terms)",
        "The polynomial that a text says, such as \"x^4 + y^4 - 2xy^2 + 1\": numbers, x, y and z, + - * / ^ and parentheses, where * may be left out; or an array of terms [c, i, j, k], each of which is c x^i y^j z^k. Exponents go up to 64. It is negative inside, like every solid, where its author meant it to be: else put a minus before it.",
        "polynomial(\"(x^2 + 9/4 y^2 + z^2 - 1)^3 - x^2 z^3 - 9/80 y^2 z^3\")",
        |c| {
            let node = match c.args[0].read_lock::<Array>() {
                Some(list) => sum(c.host, terms(&list)?)?,
                None => {
                    let wanted = "a text such as \"x^2 + y^2 - 1\" or an array of terms [c, i, j, k]";
                    let text = c.text(0).map_err(|_| c.wrong(0, wanted))?;
                    build(c.host, &Reader::new(&text).whole()?)?
                }
            };
            Ok(Dynamic::from(Field { node, color: None }))
        },
    );
}

/// `coefficient x^i y^j z^k`
#[derive(Clone, Copy, Debug, PartialEq)]
struct Term {
    coefficient: f64,
    powers: [u32; 3],
}

impl Term {
    /// The same, unless an exponent has become too large to be one.
    fn within_reach(self) -> Option<Term> {
        self.powers.iter().all(|p| *p <= HIGHEST).then_some(self)
    }
}

/// The terms in an array of arrays of four numbers.
fn terms(list: &[Dynamic]) -> Outcome<Vec<Term>> {
    let wrong = |i: usize, v: &Dynamic| {
        Fault::new(format!("term {i} of the polynomial is {}", describe(v)))
            .hint("a term is [c, i, j, k] for c x^i y^j z^k, with whole exponents from 0 to 64")
    };
    let term = |(i, v): (usize, &Dynamic)| {
        let parts = v.read_lock::<Array>().map(|a| a.iter().map(number).collect::<Vec<_>>());
        let Some(&[Some(coefficient), Some(x), Some(y), Some(z)]) = parts.as_deref() else {
            return Err(wrong(i, v));
        };
        let is_power = |p: f64| p.fract() == 0.0 && (0.0..=f64::from(HIGHEST)).contains(&p);
        if !(coefficient.is_finite() && [x, y, z].into_iter().all(is_power)) {
            return Err(wrong(i, v).label(format!("[{coefficient}, {x}, {y}, {z}]")));
        }
        Ok(Term { coefficient, powers: [x, y, z].map(|p| p as u32) })
    };
    list.iter().enumerate().map(term).collect()
}

/// What a text says.
#[derive(Clone, Debug, PartialEq)]
enum Expr {
    Number(f64),
    /// x, y or z.
    Variable(usize),
    Sum(Vec<Expr>),
    Product(Vec<Expr>),
    Power(Box<Expr>, u32),
}

impl Expr {
    /// As a single term, if it is one.
    fn term(&self) -> Option<Term> {
        let one = Term { coefficient: 1.0, powers: [0; 3] };
        match self {
            Expr::Number(c) => Some(Term { coefficient: *c, ..one }),
            Expr::Variable(axis) => {
                let powers = std::array::from_fn(|i| u32::from(i == *axis));
                Some(Term { powers, ..one })
            }
            Expr::Sum(parts) => match parts.as_slice() {
                [only] => only.term(),
                _ => None,
            },
            Expr::Product(parts) => parts.iter().try_fold(one, |all, part| {
                let part = part.term()?;
                let powers = std::array::from_fn(|i| all.powers[i] + part.powers[i]);
                Term { coefficient: all.coefficient * part.coefficient, powers }.within_reach()
            }),
            Expr::Power(base, n) => {
                let base = base.term()?;
                let powers = base.powers.map(|p| p * n);
                Term { coefficient: power(base.coefficient, *n as i32), powers }.within_reach()
            }
        }
    }
}

fn build(host: &Host, expr: &Expr) -> Outcome<NodeId> {
    if let Some(term) = expr.term() {
        return sum(host, vec![term]);
    }
    match expr {
        Expr::Number(c) => host.constant(*c),
        Expr::Variable(axis) => Ok(host.point()?[*axis]),
        Expr::Power(base, n) => {
            let base = build(host, base)?;
            raised(host, base, *n)
        }
        Expr::Product(parts) => {
            let mut product = host.constant(1.0)?;
            for part in parts {
                product = host.op(Op::Mul(op::Mul), &[product, build(host, part)?])?;
            }
            Ok(product)
        }
        Expr::Sum(parts) => {
            let mut all = sum(host, parts.iter().filter_map(Expr::term).collect())?;
            for part in parts.iter().filter(|part| part.term().is_none()) {
                all = host.op(Op::Add(op::Add), &[all, build(host, part)?])?;
            }
            Ok(all)
        }
    }
}

fn raised(host: &Host, base: NodeId, n: u32) -> Outcome<NodeId> {
    match n {
        0 => host.constant(1.0),
        1 => Ok(base),
        2 => host.op(Op::Square(op::Square), &[base]),
        _ => host.op(Op::Powi(op::Powi { n: n as i32 }), &[base]),
    }
}

/// A sum of terms by Horner's scheme.
fn sum(host: &Host, terms: Vec<Term>) -> Outcome<NodeId> {
    let having = |axis: usize| terms.iter().filter(|t| t.powers[axis] > 0).count();
    // The first of those that most terms share.
    let shared = (0..3).rev().max_by_key(|&axis| having(axis)).filter(|&axis| having(axis) > 0);
    let Some(axis) = shared else {
        return host.constant(terms.iter().map(|t| t.coefficient).sum());
    };
    let (mut with, without): (Vec<Term>, Vec<Term>) = terms.into_iter().partition(|t| t.powers[axis] > 0);
    let least = with.iter().map(|t| t.powers[axis]).min().unwrap_or(0);
    with.iter_mut().for_each(|t| t.powers[axis] -= least);
    let taken = raised(host, host.point()?[axis], least)?;
    let with = host.op(Op::Mul(op::Mul), &[taken, sum(host, with)?])?;
    match without.is_empty() {
        true => Ok(with),
        false => host.op(Op::Add(op::Add), &[with, sum(host, without)?]),
    }
}

/// Reads a text from its start to its end.
struct Reader<'a> {
    text: &'a str,
    /// Bytes that were read.
    at: usize,
    /// Parentheses that are open.
    depth: usize,
}

impl<'a> Reader<'a> {
    fn new(text: &'a str) -> Self {
        Reader { text, at: 0, depth: 0 }
    }

    /// The next character after blanks.
    fn next(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.text[self.at..].chars().next()
    }

    /// Goes past a symbol if it is next.
    fn skip(&mut self, symbol: &str) -> bool {
        self.next();
        let is_next = self.text[self.at..].starts_with(symbol);
        self.at += if is_next { symbol.len() } else { 0 };
        is_next
    }

    /// An error at the next character.
    fn wrong(&mut self, wanted: &str) -> Fault {
        /// Characters shown on either side.
        const AROUND: usize = 24;
        let what = match self.next() {
            Some(c) => {
                let digits: String = self.text[self.at..].chars().take_while(char::is_ascii_digit).collect();
                format!("`{}`", if digits.is_empty() { c.to_string() } else { digits })
            }
            None => "the end".to_owned(),
        };
        let before = self.text[..self.at].chars().count();
        let from = before.saturating_sub(AROUND);
        let shown: String = self.text.chars().skip(from).take(before - from + AROUND).collect();
        let shown = shown.replace('\n', " ");
        let arrow = format!("{}^", " ".repeat(before - from));
        Fault::new(format!("{wanted} instead of {what}, character {} of the polynomial", before + 1))
            .hint(format!("{shown}\n{arrow}"))
    }

    fn whole(mut self) -> Outcome<Expr> {
        let all = self.sum()?;
        match self.next() {
            None => Ok(all),
            Some(')') => Err(self.wrong("no parenthesis is open: expected + or -")),
            Some(_) => Err(self.wrong("expected + - * / or ^")),
        }
    }

    fn sum(&mut self) -> Outcome<Expr> {
        let mut parts = Vec::new();
        loop {
            let minus = self.skip("-");
            if !minus && !self.skip("+") && !parts.is_empty() {
                return Ok(Expr::Sum(parts));
            }
            let part = self.product()?;
            parts.push(if minus { Expr::Product(vec![Expr::Number(-1.0), part]) } else { part });
        }
    }

    fn product(&mut self) -> Outcome<Expr> {
        let mut parts = vec![self.factor()?];
        loop {
            if self.skip("*") {
                parts.push(self.factor()?);
            } else if self.skip("/") {
                let divisor = self.number().filter(|d| *d != 0.0);
                let divisor =
                    divisor.ok_or_else(|| self.wrong("expected a number to divide by, other than 0,"))?;
                parts.push(Expr::Number(1.0 / divisor));
            } else if matches!(self.next(), Some('(' | 'x' | 'y' | 'z')) {
                parts.push(self.factor()?);
            } else {
                return Ok(Expr::Product(parts));
            }
        }
    }

    fn factor(&mut self) -> Outcome<Expr> {
        let base = self.base()?;
        if !(self.skip("^") || self.skip("**")) {
            return Ok(base);
        }
        self.next();
        let start = self.at;
        let exponent = self.number().filter(|n| n.fract() == 0.0 && (0.0..=f64::from(HIGHEST)).contains(n));
        let exponent = exponent.ok_or_else(|| {
            self.at = start;
            self.wrong("expected a whole exponent from 0 to 64")
        })?;
        Ok(Expr::Power(Box::new(base), exponent as u32))
    }

    fn base(&mut self) -> Outcome<Expr> {
        if let Some(axis) = ["x", "y", "z"].iter().position(|name| self.skip(name)) {
            return Ok(Expr::Variable(axis));
        }
        if self.skip("(") {
            self.depth += 1;
            if self.depth > DEEPEST {
                return Err(
                    self.wrong("parentheses are nested more than 32 deep: expected a number or a variable")
                );
            }
            let inner = self.sum()?;
            if !self.skip(")") {
                return Err(self.wrong("expected a closing parenthesis"));
            }
            self.depth -= 1;
            return Ok(inner);
        }
        self.number()
            .map(Expr::Number)
            .ok_or_else(|| self.wrong("expected a number, x, y, z or a parenthesis"))
    }

    /// A number without a sign.
    fn number(&mut self) -> Option<f64> {
        self.next();
        let rest = &self.text[self.at..];
        let digits =
            |from: usize| rest[from..].find(|c: char| !c.is_ascii_digit()).map_or(rest.len(), |n| from + n);
        let mut end = digits(0);
        if rest[end..].starts_with('.') {
            end = digits(end + 1);
        }
        let sign = usize::from(rest.get(end + 1..).is_some_and(|r| r.starts_with(['+', '-'])));
        if rest[end..].starts_with(['e', 'E']) && digits(end + 1 + sign) > end + 1 + sign {
            end = digits(end + 1 + sign);
        }
        let value = rest[..end].parse().ok().filter(|v: &f64| v.is_finite())?;
        self.at += end;
        Some(value)
    }
}
