//! Questions about what a session has made: an expression as a solid, as numbers, as a function along a line. They
//! leave no trace among the inputs.

use super::{Effects, Interpreter};
use crate::diag::Diagnostic;
use crate::expr::Input;
use crate::op::{self, Op};
use crate::scene::Scene;
use crate::script::options::{describe, with_article};
use crate::script::value::{Scalar, Value, type_name};
use crate::script::{fault, finish, scene_value};
use crate::tape::Tape;
use rhai::Dynamic;
use std::sync::Arc;

/// A line that a function is asked along.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Line {
    /// From a point to another; the coordinate is the distance from the first.
    Ray([f64; 3], [f64; 3]),
    /// Along a variable, all others being zero; the coordinate is that variable.
    Variable(Input),
}

impl Line {
    /// The variable of this name.
    pub fn variable(name: &str) -> Option<Line> {
        Some(Line::Variable(match name {
            "x" => Input::X,
            "y" => Input::Y,
            "z" => Input::Z,
            "time" => Input::Time,
            _ => return None,
        }))
    }
}

impl Interpreter {
    /// The scene that an expression means; the last one there was, without one.
    ///
    /// # Errors
    /// Whatever is wrong with the expression, or that it is no solid; or that there is none yet.
    pub fn solid(&mut self, expression: Option<&str>) -> Result<Scene, Box<Diagnostic>> {
        let Some(expression) = expression else {
            let missing = || Diagnostic::error("there is no solid yet").hint("for example: sphere(1.0)");
            return self.scene().ok_or_else(|| Box::new(missing()));
        };
        let value = self.evaluate(expression, Effects::None)?;
        let scene = scene_value(&self.setup, &value).map_err(|_| Box::new(no_field(&value)))?;
        finish(&self.setup.host, &scene).map_err(failed)
    }

    /// The numbers that an expression means: one, or the three of a point.
    ///
    /// # Errors
    /// Whatever is wrong with the expression, or that it is something else.
    pub fn numbers(&mut self, expression: &str) -> Result<Vec<f64>, Box<Diagnostic>> {
        let value = self.evaluate(expression, Effects::None)?;
        let numbers = match Value::of(&self.setup.host, &value).map_err(failed)? {
            Some(Value::Scalar(Scalar::Number(c), _)) => Some(vec![c]),
            Some(Value::Vector(v)) => v.iter().map(Scalar::number).collect(),
            _ => None,
        };
        numbers.filter(|all| all.iter().all(|c| c.is_finite())).ok_or_else(|| {
            let error = Diagnostic::error(format!(
                "a number or a point is needed, and `{}` is {}",
                expression.trim(),
                with_article(type_name(&value))
            ));
            Box::new(error.hint("a number such as 1.5, or a point such as [1, 0, 0]"))
        })
    }

    /// An expression as a function of the first coordinate alone, along a line.
    ///
    /// # Errors
    /// Whatever is wrong with the expression, or that it is no field.
    pub fn along(&mut self, expression: &str, line: &Line) -> Result<Arc<Tape>, Box<Diagnostic>> {
        let value = self.evaluate(expression, Effects::None)?;
        let Some(Value::Scalar(Scalar::Field(_) | Scalar::Number(_), _)) =
            Value::of(&self.setup.host, &value).map_err(failed)?
        else {
            return Err(Box::new(no_field(&value)));
        };
        self.lowered(&value, line).map_err(failed)
    }

    fn lowered(&self, value: &Dynamic, line: &Line) -> fault::Outcome<Arc<Tape>> {
        let host = &self.setup.host;
        let root = match Value::of(host, value)? {
            Some(Value::Scalar(scalar, _)) => scalar.node(host)?,
            _ => host.constant(0.0)?,
        };
        let (x, zero) = (host.input(Input::X)?, host.constant(0.0)?);
        let mut with = vec![(Input::Time, host.constant(host.time)?)];
        match line {
            Line::Variable(variable) => {
                with.extend([Input::X, Input::Y, Input::Z].map(|input| (input, zero)));
                with.retain(|(input, _)| input != variable);
                with.push((*variable, x));
            }
            Line::Ray(from, to) => {
                let length = from.iter().zip(to).map(|(a, b)| (b - a) * (b - a)).sum::<f64>();
                let scale = if length > 0.0 { 1.0 / libm::sqrt(length) } else { 0.0 };
                for (axis, input) in [Input::X, Input::Y, Input::Z].into_iter().enumerate() {
                    let slope = host.constant((to[axis] - from[axis]) * scale)?;
                    let way = host.op(Op::Mul(op::Mul), &[slope, x])?;
                    let start = host.constant(from[axis])?;
                    with.push((input, host.op(Op::Add(op::Add), &[start, way])?));
                }
            }
        }
        let root = host.substitute(root, &with)?;
        Ok(Arc::new(Tape::new(&host.graph.borrow(), &[root])))
    }
}

fn failed(fault: fault::Fault) -> Box<Diagnostic> {
    let mut error = Diagnostic::error(fault.message);
    error.hints = fault.hints;
    Box::new(error)
}

fn no_field(value: &Dynamic) -> Diagnostic {
    let error = Diagnostic::error(format!("a field is needed, not {}", describe(value)));
    error.hint("a field is a function of x, y and z, such as sphere(1.0) or x ** 2 + y")
}
