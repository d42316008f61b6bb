//! Applies an operation to values of any kind: component by component on vectors, with every
//! argument moved up to the widest kind of number present.

use super::fault::{Fault, Outcome};
use super::host::{Host, not_a_number};
use super::value::{Scalar, Value};
use crate::expr::NodeId;
use crate::num::{Affine, Interval};
use crate::op::{self, Op};

/// The operation on values; scalars spread over the components of vectors. Not for operations on
/// vectors as a whole.
pub fn apply(host: &Host, op: Op, args: &[Value]) -> Outcome<Value> {
    if args.iter().all(|a| matches!(a, Value::Scalar(..))) {
        let parts: Vec<Scalar> = args.iter().map(|a| component(a, 0)).collect();
        let result = scalar(host, op, &parts)?;
        let color = match result {
            Scalar::Field(_) => color(host, op, args, &parts)?,
            _ => None,
        };
        return Ok(Value::Scalar(result, color));
    }
    let part = |axis| scalar(host, op, &args.iter().map(|a| component(a, axis)).collect::<Vec<_>>());
    Ok(Value::Vector([part(0)?, part(1)?, part(2)?]))
}

/// The component of a vector, or the scalar itself.
pub fn component(v: &Value, axis: usize) -> Scalar {
    match v {
        Value::Scalar(s, _) => s.clone(),
        Value::Vector(parts) => parts[axis].clone(),
    }
}

/// The operation on as many scalars as it has arguments.
pub fn scalar(host: &Host, op: Op, args: &[Scalar]) -> Outcome<Scalar> {
    if args.len() != op.arity() {
        return Err(Fault::new(format!(
            "`{}` takes {} arguments, not {}",
            op.name(),
            op.arity(),
            args.len()
        )));
    }
    match args.iter().map(Scalar::rank).max().unwrap_or(0) {
        0 => {
            let x: Vec<f64> = args.iter().filter_map(Scalar::number).collect();
            let y = op.apply(|i| &x[i]);
            if y.is_nan() && !x.iter().any(|x| x.is_nan()) {
                let list: Vec<String> = x.iter().map(f64::to_string).collect();
                return Err(not_a_number(&format!("`{}` of {}", op.name(), list.join(", "))));
            }
            Ok(Scalar::Number(y))
        }
        1 => {
            let x: Vec<Interval> = args.iter().filter_map(Scalar::interval).collect();
            Ok(Scalar::Interval(op.apply(|i| &x[i])))
        }
        2 => {
            let x: Vec<Affine> = args.iter().filter_map(Scalar::affine).collect();
            Ok(Scalar::Affine(op.apply(|i| &x[i])))
        }
        _ => {
            let nodes = args.iter().map(|a| a.node(host)).collect::<Outcome<Vec<NodeId>>>()?;
            Ok(Scalar::Field(host.op(op, &nodes)?))
        }
    }
}

/// The colour of a result: of the side that is active in a minimum or maximum, mixed as values are in a mix, else of the
/// first argument that has one.
fn color(host: &Host, op: Op, args: &[Value], parts: &[Scalar]) -> Outcome<Option<[NodeId; 3]>> {
    let of = |v: &Value| match v {
        Value::Scalar(_, color) => *color,
        Value::Vector(_) => None,
    };
    let colors: Vec<_> = args.iter().map(of).collect();
    let first = colors.iter().flatten().next().copied();
    let (true, Some(_)) = (matches!(op, Op::Min(_) | Op::Max(_) | Op::Mix(_)), first) else {
        return Ok(first);
    };
    // What has no colour of its own, such as a bounding plane, lends none either.
    let (Some(a), Some(b)) = (colors[0], colors[1]) else { return Ok(first) };
    if a == b {
        return Ok(Some(a));
    }
    if let (Op::Mix(_), [_, _, share]) = (op, parts) {
        let [none, all] = [host.constant(0.0)?, host.constant(1.0)?];
        let share = host.op(Op::Clamp(op::Clamp), &[share.node(host)?, none, all])?;
        return blend(host, a, b, share).map(Some);
    }
    let (f, g) = (parts[0].node(host)?, parts[1].node(host)?);
    // 1 where the second argument is active.
    let (low, high) = if matches!(op, Op::Min(_)) { (g, f) } else { (f, g) };
    let choice = host.op(Op::Step(op::Step), &[low, high])?;
    blend(host, a, b, choice).map(Some)
}

/// A mix of colours.
pub fn blend(host: &Host, a: [NodeId; 3], b: [NodeId; 3], t: NodeId) -> Outcome<[NodeId; 3]> {
    let mix = |i: usize| host.op(Op::Mix(op::Mix), &[a[i], b[i], t]);
    Ok([mix(0)?, mix(1)?, mix(2)?])
}
