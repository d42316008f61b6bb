//! Values that go with the time, through keyframes.

use super::{Call, Library};
use crate::num::{Curve, interpolate};
use crate::script::fault::{Fault, Outcome};
use crate::script::options::{Options, describe};
use crate::script::value::{Scalar, Value, Vec3, number};
use rhai::{Array, Dynamic};

pub(super) fn register(lib: &mut Library<'_>) {
    let sentence = "The value that goes through given ones at given times, in seconds: a number, a pair, a vector or a colour, as it is at the time of the picture. Before the first and after the last time it stays what it is there. It moves smoothly, and comes to rest at both ends and between equal values: numbers and colours given as texts never overshoot (monotone cubics), pairs and vectors run on around corners (Catmull-Rom).";
    let example = "keyframes([[0.0, 4.0], [2.5, 1.5], [4.0, 2.0]])";
    lib.def("keyframes(frames)", sentence, example, |c| evaluate(c, Path::default()));
    let sentence = "The same with options: smooth (true unless given, else straight from one to the next), overshoot (pairs and vectors only; false keeps each coordinate between its values before and after, as colours want), geometric (in equal times by equal factors, for zooms; numbers must be positive), and repeat (over and over, without a rest; the last value has to be the first).";
    let example = "orbit(#{ distance: keyframes([[0.0, 3.0], [5.0, 1.01]], #{ geometric: true }) })";
    lib.def("keyframes(frames, options)", sentence, example, |c| {
        let mut o = Options::new(c, 1)?;
        let overshoot = o.get("overshoot").map(|_| o.flag("overshoot", true)).transpose()?;
        let (smooth, geometric) = (o.flag("smooth", true)?, o.flag("geometric", false)?);
        let path = Path { smooth, geometric, overshoot, repeat: o.flag("repeat", false)? };
        o.finish()?;
        evaluate(c, path)
    });
}

/// How a value goes from one keyframe to the next.
#[derive(Clone, Copy)]
struct Path {
    smooth: bool,
    geometric: bool,
    /// Whether coordinates may leave the range of their values, if that is said.
    overshoot: Option<bool>,
    repeat: bool,
}

impl Default for Path {
    fn default() -> Path {
        Path { smooth: true, geometric: false, overshoot: None, repeat: false }
    }
}

/// What a keyframe holds.
#[derive(Clone, Copy, PartialEq)]
enum Held {
    Number(f64),
    Pair([f64; 2]),
    Vector([f64; 3]),
    /// A colour that was given as a text.
    Color([f64; 3]),
}

fn evaluate(c: &Call<'_>, path: Path) -> Outcome<Dynamic> {
    let wanted = "an array of keyframes [time, value]";
    let list = c.args[0].read_lock::<Array>().map(|a| a.clone()).filter(|a| !a.is_empty());
    let list = list.ok_or_else(|| c.wrong(0, wanted))?;
    let frames = list.iter().enumerate().map(|(i, v)| frame(c, i, v)).collect::<Outcome<Vec<_>>>()?;
    let (times, values): (Vec<f64>, Vec<Held>) = frames.into_iter().unzip();
    if let Some(i) = times.windows(2).position(|pair| pair[0] >= pair[1]) {
        let message =
            format!("keyframe {} is at {}, but the one before at {}", i + 1, times[i + 1], times[i]);
        return Err(Fault::new(message).hint("times must increase"));
    }
    path.check(&values)?;
    let now = c.host.time;
    if path.repeat { path.at(round(times, values, now)?) } else { path.at((times, values, now)) }
}

/// Keyframes and a time among them, of those that are repeated for ever: one before and one after, so that the curve begins
/// as it ends.
fn round(mut times: Vec<f64>, mut values: Vec<Held>, now: f64) -> Outcome<(Vec<f64>, Vec<Held>, f64)> {
    let last = times.len() - 1;
    if last == 0 || !values[0].equals(values[last]) {
        let fault =
            Fault::new("keyframes that repeat must end with the value that they begin with").key("repeat");
        return Err(fault.hint("what turns on and on needs no keyframes: azimuth: 90.0 * time"));
    }
    let period = times[last] - times[0];
    let now = times[0] + (now - times[0]).rem_euclid(period);
    times.push(times[1] + period);
    values.push(values[1]);
    times.insert(0, times[last - 1] - period);
    values.insert(0, values[last - 1]);
    Ok((times, values, now))
}

/// What all values are, if they are of one kind.
fn all<T>(values: &[Held], kind: impl Fn(Held) -> Option<T>) -> Option<Vec<T>> {
    values.iter().copied().map(kind).collect()
}

/// A time and the value then.
fn frame(c: &Call<'_>, i: usize, v: &Dynamic) -> Outcome<(f64, Held)> {
    let hint = "write [0.0, 4.0], [0.0, [1, 2, 3]] or [0.0, \"#ff8800\"]";
    let pair = v.read_lock::<Array>().map(|a| a.clone()).filter(|a| a.len() == 2).ok_or_else(|| {
        Fault::new(format!("keyframe {i} must be a time and a value, [time, value], not {}", describe(v)))
    })?;
    let time = number(&pair[0]).filter(|t| t.is_finite()).ok_or_else(|| {
        let message = format!("the time of keyframe {i} must be a number, not {}", describe(&pair[0]));
        Fault::new(message).hint(hint)
    })?;
    let held = Held::of(c, &pair[1])?.filter(Held::is_finite).ok_or_else(|| {
        let given = describe(&pair[1]);
        let kinds = "a number, a pair, a vector or a colour";
        let message = format!("the value of keyframe {i} must be {kinds}, all of it finite, not {given}");
        Fault::new(message).hint(hint)
    })?;
    Ok((time, held))
}

impl Held {
    fn of(c: &Call<'_>, v: &Dynamic) -> Outcome<Option<Held>> {
        if v.is_string() {
            return Ok(c.constant_color(v)?.map(|color| Held::Color(color.to_array())));
        }
        let pair: Option<[f64; 2]> = v.read_lock::<Array>().and_then(|list| match &list[..] {
            [a, b] => Some([number(a)?, number(b)?]),
            _ => None,
        });
        if let Some(pair) = pair {
            return Ok(Some(Held::Pair(pair)));
        }
        if let Some(Value::Scalar(Scalar::Number(c), _)) = Value::of(c.host, v)? {
            return Ok(Some(Held::Number(c)));
        }
        Ok(c.vec3_of(v)?.map(|v| Held::Vector(v.to_array())))
    }

    fn is_finite(&self) -> bool {
        match self {
            Held::Number(c) => c.is_finite(),
            Held::Pair(pair) => pair.iter().all(|c| c.is_finite()),
            Held::Vector(v) | Held::Color(v) => v.iter().all(|c| c.is_finite()),
        }
    }

    fn number(self) -> Option<f64> {
        if let Held::Number(c) = self { Some(c) } else { None }
    }

    fn pair(self) -> Option<[f64; 2]> {
        if let Held::Pair(pair) = self { Some(pair) } else { None }
    }

    /// Whether both are the same, be it as a colour or as a vector.
    fn equals(self, other: Held) -> bool {
        self == other || self.vector().is_some_and(|v| other.vector() == Some(v))
    }

    fn vector(self) -> Option<[f64; 3]> {
        if let Held::Vector(v) | Held::Color(v) = self { Some(v) } else { None }
    }
}

impl Path {
    /// Refuses what the options do not go with.
    fn check(self, values: &[Held]) -> Outcome<()> {
        let Some(numbers) = all(values, Held::number) else {
            if self.geometric {
                let fault = Fault::new("only numbers can change geometrically, not vectors").key("geometric");
                return Err(fault.hint("let the distance of an orbit change so, or the length of an offset"));
            }
            return match self.overshoot {
                Some(true) if !self.smooth => {
                    Err(Fault::new("straight lines never overshoot").key("overshoot"))
                }
                _ => Ok(()),
            };
        };
        if self.overshoot == Some(true) {
            return Err(Fault::new("numbers never overshoot").key("overshoot"));
        }
        match numbers.iter().position(|v| *v <= 0.0) {
            Some(i) if self.geometric => {
                let fault = Fault::new(format!("keyframe {i} is {}, which no factor leads to", numbers[i]));
                Err(fault.hint("with geometric: true all values must be positive"))
            }
            _ => Ok(()),
        }
    }

    /// The value at a time.
    fn at(self, (times, values, now): (Vec<f64>, Vec<Held>, f64)) -> Outcome<Dynamic> {
        if let Some(numbers) = all(&values, Held::number) {
            return Ok(Dynamic::from_float(self.number(&times, numbers, now)));
        }
        if let Some(pairs) = all(&values, Held::pair) {
            let pair = interpolate(self.curve(&values), &times, &pairs, now);
            return Ok(pair.map(Dynamic::from_float).to_vec().into());
        }
        let vectors = all(&values, Held::vector).ok_or_else(|| {
            Fault::new("the values of keyframes must be all numbers, all pairs, or all vectors and colours")
        })?;
        Ok(Dynamic::from(Vec3(interpolate(self.curve(&values), &times, &vectors, now))))
    }

    fn number(self, times: &[f64], values: Vec<f64>, now: f64) -> f64 {
        let curve = if self.smooth { Curve::Monotone } else { Curve::Linear };
        let at = |values: Vec<f64>| {
            let values: Vec<[f64; 1]> = values.into_iter().map(|v| [v]).collect();
            interpolate(curve, times, &values, now)[0]
        };
        if self.geometric { libm::exp(at(values.into_iter().map(libm::log).collect())) } else { at(values) }
    }

    /// What leads from one to the next of pairs or vectors.
    fn curve(self, values: &[Held]) -> Curve {
        let are_colors = values.iter().any(|held| matches!(held, Held::Color(_)));
        match self.overshoot.unwrap_or(!are_colors) {
            _ if !self.smooth => Curve::Linear,
            true => Curve::CatmullRom,
            false => Curve::Monotone,
        }
    }
}
