//! What an operation does, written down as it does it.
//!
//! Operations are stated once, over any [`Real`]. Here the scalar is a name: arithmetic on names leaves
//! the steps of the computation in a list, in the order in which plain numbers would take them. So machine
//! code follows whatever an operation states, and one that is added needs nothing more. Those that go
//! beyond IEEE arithmetic, as a sine does, are noticed and left to others.

use crate::num::{Real, power};
use crate::tape::Instr;
use std::cell::{Cell, RefCell};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// What the machine does in one step.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Do {
    Add,
    Sub,
    Mul,
    Div,
    /// The first where it is less, else the second.
    Min,
    /// The first where it is more, else the second.
    Max,
    And,
    /// The second without the bits of the first.
    AndNot,
    Or,
    Xor,
    /// All bits where the first is less, else none.
    Less,
    /// Square root of the second, which is the first, too.
    Sqrt,
    /// Largest integer not above the second, which is the first, too.
    Floor,
}

impl Do {
    /// Whether the arguments may change places.
    pub(super) fn commutes(self) -> bool {
        matches!(self, Do::Add | Do::Mul | Do::And | Do::Or | Do::Xor)
    }
}

/// One line of a computation; values are named by the lines that give them.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Line {
    /// The number with these bits.
    Number(u64),
    /// A coordinate of the points.
    Coordinate(usize),
    /// What was computed before and lies in this register of the evaluator.
    Home(u32),
    /// A step.
    Compute(Do, [u32; 2]),
    /// Keeps a value in a register of the evaluator.
    Store(u32, u32),
}

impl Line {
    /// Whether the machine and we differ about NaN here.
    pub(super) fn may_be_invalid(&self) -> bool {
        matches!(self, Line::Compute(Do::Min | Do::Max | Do::Less, _))
    }
}

/// The lines so far.
#[derive(Default)]
pub(super) struct Trace {
    lines: RefCell<Vec<Line>>,
    is_foreign: Cell<bool>,
}

impl Trace {
    /// Adds a line and returns its number.
    fn push(&self, line: Line) -> u32 {
        let mut lines = self.lines.borrow_mut();
        lines.push(line);
        lines.len() as u32 - 1
    }

    /// The value of a new line.
    pub(super) fn value(&self, line: Line) -> Traced<'_> {
        Traced::Value(self, self.push(line))
    }

    /// Keeps a value in a register of the evaluator.
    pub(super) fn keep(&self, value: Traced<'_>, home: u32) {
        let value = self.line_of(value);
        self.push(Line::Store(value, home));
    }

    /// Writes down an instruction; `None` where it is more than plain arithmetic.
    pub(super) fn instr<'a>(&'a self, instr: &Instr, arg: impl Fn(u32) -> Traced<'a>) -> Option<Traced<'a>> {
        let start = self.lines.borrow().len() as u32;
        self.is_foreign.set(false);
        let value = match instr {
            Instr::Const(c) => Traced::Number(*c),
            Instr::Coordinate(axis) => self.value(Line::Coordinate(*axis)),
            Instr::Scale(a, k) => arg(*a) * Traced::Number(*k),
            Instr::Shift(a, c) => arg(*a) + Traced::Number(*c),
            Instr::Op(op, args) => op.value(|i| arg(args[i])),
            Instr::Noise(..) | Instr::Fractal(..) | Instr::Grid(..) | Instr::Shape(..) | Instr::Flow(..) => {
                return None;
            }
        };
        if self.is_foreign.get() {
            return None;
        }
        // A value of its own, since that of an argument may not stay in its register for as long.
        Some(match value {
            Traced::Value(_, line) if line < start => self.value(Line::Compute(Do::Or, [line; 2])),
            own => own,
        })
    }

    /// The lines.
    pub(super) fn into_lines(self) -> Vec<Line> {
        self.lines.into_inner()
    }

    fn line_of(&self, value: Traced<'_>) -> u32 {
        match value {
            Traced::Number(x) => self.push(Line::Number(x.to_bits())),
            Traced::Value(_, line) => line,
        }
    }

    fn compute(&self, act: Do, args: [Traced<'_>; 2]) -> Traced<'_> {
        let args = args.map(|a| self.line_of(a));
        self.value(Line::Compute(act, args))
    }
}

/// Whether an instruction is plain arithmetic.
pub(super) fn is_plain(instr: &Instr) -> bool {
    let trace = Trace::default();
    let nothing = trace.value(Line::Home(0));
    trace.instr(instr, |_| nothing).is_some()
}

/// A number that is known, or the name of one.
#[derive(Clone, Copy)]
pub(super) enum Traced<'a> {
    Number(f64),
    Value(&'a Trace, u32),
}

use Traced::{Number, Value};

impl Traced<'_> {
    /// A step with two arguments, or what comes of it already.
    fn then(self, other: Self, act: Do, known: fn(f64, f64) -> f64) -> Self {
        match (self, other) {
            (Number(x), Number(y)) => Number(known(x, y)),
            (Value(trace, _), _) | (_, Value(trace, _)) => trace.compute(act, [self, other]),
        }
    }

    /// A step with one argument.
    fn alone(self, act: Do, known: fn(f64) -> f64) -> Self {
        match self {
            Number(x) => Number(known(x)),
            Value(trace, line) => trace.value(Line::Compute(act, [line; 2])),
        }
    }

    /// Something that is no step.
    fn beyond(self, known: fn(f64) -> f64) -> Self {
        match self {
            Number(x) => Number(known(x)),
            Value(trace, _) => {
                trace.is_foreign.set(true);
                self
            }
        }
    }

    /// The same of two arguments.
    fn beyond2(self, other: Self, known: fn(f64, f64) -> f64) -> Self {
        match (self, other) {
            (Number(x), Number(y)) => Number(known(x, y)),
            (Value(trace, _), _) | (_, Value(trace, _)) => {
                trace.is_foreign.set(true);
                self
            }
        }
    }
}

/// Implements the operators.
macro_rules! operators {
    ($($op:ident $name:ident),*) => {$(
        impl $op for Traced<'_> {
            type Output = Self;
            fn $name(self, other: Self) -> Self {
                self.then(other, Do::$op, f64::$name)
            }
        }
    )*};
}
operators!(Add add, Sub sub, Mul mul, Div div);

impl Neg for Traced<'_> {
    type Output = Self;
    fn neg(self) -> Self {
        match self {
            Number(x) => Number(-x),
            value => value.then(Number(-0.0), Do::Xor, |x, _| x),
        }
    }
}

/// Implements what is no step.
macro_rules! beyond {
    ($($name:ident),*) => {$(
        fn $name(self) -> Self {
            self.beyond(<f64 as Real>::$name)
        }
    )*};
}

impl Real for Traced<'_> {
    fn of(c: f64) -> Self {
        Number(c)
    }
    fn abs(self) -> Self {
        match self {
            Number(x) => Number(x.abs()),
            value => value.then(Number(f64::from_bits(!(1 << 63))), Do::And, |x, _| x),
        }
    }
    fn square(self) -> Self {
        self * self
    }
    fn sqrt(self) -> Self {
        self.alone(Do::Sqrt, f64::sqrt)
    }
    fn powi(self, n: i32) -> Self {
        power(self, n)
    }
    fn floor(self) -> Self {
        self.alone(Do::Floor, f64::floor)
    }
    fn min(self, other: Self) -> Self {
        self.then(other, Do::Min, Real::min)
    }
    fn max(self, other: Self) -> Self {
        self.then(other, Do::Max, Real::max)
    }
    fn if_less(self, other: Self, then: Self, otherwise: Self) -> Self {
        let mask = match (self, other) {
            (Number(x), Number(y)) if x < y => return then,
            (Number(x), Number(y)) if x >= y => return otherwise,
            (Number(_), Number(_)) => return Number(f64::NAN),
            (Value(trace, _), _) | (_, Value(trace, _)) => trace.compute(Do::Less, [self, other]),
        };
        // A mask is no number, and the arguments of these are not both known.
        let part = |act, of| mask.then(of, act, |x, _| x);
        part(Do::And, then).then(part(Do::AndNot, otherwise), Do::Or, |x, _| x)
    }
    fn slope_of_jump(self) -> Self {
        Number(0.0)
    }
    fn slope_of_floor(self) -> Self {
        Number(0.0)
    }
    fn powf(self, p: Self) -> Self {
        self.beyond2(p, Real::powf)
    }
    fn atan2(self, x: Self) -> Self {
        self.beyond2(x, Real::atan2)
    }
    beyond!(exp, ln, sin, cos, tan, asin, acos, atan);
}
