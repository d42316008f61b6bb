//! Values that go with the time, through keyframes.

use super::{Call, Library};
use crate::num::{Curve, interpolate};
use crate::script::fault::{Fault, Outcome};
use crate::script::options::{Options, describe};
use crate::script::value::{Scalar, Value, Vec3, number};
use rhai::{Array, Dynamic};

pub(super) fn register(lib: &mut Library<'_>) {
    let sentence = "The number or vector that goes through given ones at given times, in seconds: its value at the time of the picture. Before the first and after the last time it stays what it is there. It moves smoothly, and comes to rest at both ends: numbers never overshoot (monotone cubics), vectors run on through their points (Catmull-Rom).";
    let example = "keyframes([[0.0, 4.0], [2.5, 1.5], [4.0, 2.0]])";
    lib.def("keyframes(frames)", sentence, example, |c| evaluate(c, Path { smooth: true, geometric: false }));
    let sentence = "The same with options: smooth (true unless given, else straight from one to the next) and geometric (in equal times by equal factors, for zooms; numbers must be positive).";
    let example = "orbit(#{ distance: keyframes([[0.0, 3.0], [5.0, 1.01]], #{ geometric: true }) })";
    lib.def("keyframes(frames, options)", sentence, example, |c| {
        let mut o = Options::new(c, 1)?;
        let path = Path { smooth: o.flag("smooth", true)?, geometric: o.flag("geometric", false)? };
        o.finish()?;
        evaluate(c, path)
    });
}

/// How a value goes from one keyframe to the next.
#[derive(Clone, Copy)]
struct Path {
    smooth: bool,
    geometric: bool,
}

fn evaluate(c: &Call<'_>, path: Path) -> Outcome<Dynamic> {
    let wanted = "an array of keyframes [time, value]";
    let list = c.args[0].read_lock::<Array>().map(|a| a.clone()).filter(|a| !a.is_empty());
    let list = list.ok_or_else(|| c.wrong(0, wanted))?;
    let frames = list.iter().enumerate().map(|(i, v)| frame(c, i, v)).collect::<Outcome<Vec<_>>>()?;
    let (times, values): (Vec<f64>, Vec<Value>) = frames.into_iter().unzip();
    if let Some(i) = times.windows(2).position(|pair| pair[0] >= pair[1]) {
        let message =
            format!("keyframe {} is at {}, but the one before at {}", i + 1, times[i + 1], times[i]);
        return Err(Fault::new(message).hint("times must increase"));
    }
    let numbers: Option<Vec<f64>> = values.iter().map(as_number).collect();
    if let Some(numbers) = numbers {
        return path.number(c, &times, &numbers).map(Dynamic::from_float);
    }
    let vectors: Option<Vec<[f64; 3]>> = values.iter().map(as_vector).collect();
    let vectors = vectors.ok_or_else(|| {
        Fault::new("the values of keyframes must be all numbers, or all vectors of numbers")
    })?;
    if path.geometric {
        let fault = Fault::new("only numbers can change geometrically, not vectors").key("geometric");
        return Err(fault.hint("let the distance of an orbit change so, or the length of an offset"));
    }
    let curve = if path.smooth { Curve::CatmullRom } else { Curve::Linear };
    Ok(Dynamic::from(Vec3(std::array::from_fn(|axis| {
        let along: Vec<f64> = vectors.iter().map(|v| v[axis]).collect();
        interpolate(curve, &times, &along, c.host.time)
    }))))
}

/// A time and the value then.
fn frame(c: &Call<'_>, i: usize, v: &Dynamic) -> Outcome<(f64, Value)> {
    let wrong =
        || Fault::new(format!("keyframe {i} must be a time and a value, [time, value], not {}", describe(v)));
    let pair = v.read_lock::<Array>().map(|a| a.clone()).filter(|a| a.len() == 2).ok_or_else(wrong)?;
    let time = number(&pair[0]).filter(|t| t.is_finite()).ok_or_else(wrong)?;
    let value = Value::of(c.host, &pair[1])?.ok_or_else(wrong)?;
    Ok((time, value))
}

fn as_number(v: &Value) -> Option<f64> {
    match v {
        Value::Scalar(Scalar::Number(c), _) if c.is_finite() => Some(*c),
        _ => None,
    }
}

fn as_vector(v: &Value) -> Option<[f64; 3]> {
    let Value::Vector([x, y, z]) = v else { return None };
    let parts = [x.number()?, y.number()?, z.number()?];
    parts.iter().all(|c| c.is_finite()).then_some(parts)
}

impl Path {
    fn number(self, c: &Call<'_>, times: &[f64], values: &[f64]) -> Outcome<f64> {
        let curve = if self.smooth { Curve::Monotone } else { Curve::Linear };
        if !self.geometric {
            return Ok(interpolate(curve, times, values, c.host.time));
        }
        if let Some(i) = values.iter().position(|v| *v <= 0.0) {
            let message = format!("keyframe {i} is {}, which no factor leads to", values[i]);
            return Err(Fault::new(message).hint("with geometric: true all values must be positive"));
        }
        let logs: Vec<f64> = values.iter().map(|v| libm::log(*v)).collect();
        Ok(libm::exp(interpolate(curve, times, &logs, c.host.time)))
    }
}
