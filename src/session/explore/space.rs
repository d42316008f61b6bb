//! The box of all values that the parameters of a script may have.

use super::hilbert;
use crate::num::srgb;
use crate::scene::{Domain, Param, Value};
use serde::Serialize;
use std::collections::BTreeMap;

/// Ends of a range of positive numbers that are so many times apart are seen by their logarithms: evenly spread
/// numbers would hardly ever be small ones.
const FAR_APART: f64 = 1000.0;

/// One parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Axis {
    /// Its name.
    pub name: String,
    /// The value that the script gives it.
    pub default: Value,
    /// The values that it may have.
    #[serde(flatten)]
    pub domain: Domain,
    /// Whether its logarithm is what is spread evenly.
    pub logarithmic: bool,
}

/// All parameters that may vary.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Space {
    /// The parameters, in the order of the script.
    pub axes: Vec<Axis>,
}

impl Space {
    /// The parameters of a script, without those that are fixed or that have no choice.
    pub fn new(params: &[Param], fixed: &BTreeMap<String, Value>) -> Space {
        let free = params.iter().filter(|p| !fixed.contains_key(&p.name));
        Space { axes: free.filter_map(Axis::of).collect() }
    }

    /// What the script gives its parameters.
    pub fn defaults(&self) -> Vec<Value> {
        self.axes.iter().map(|axis| axis.default.clone()).collect()
    }

    /// The values at a point of the unit cube.
    pub fn values(&self, point: &[f64]) -> Vec<Value> {
        self.axes.iter().zip(point).map(|(axis, place)| axis.value(*place)).collect()
    }

    /// Values by name.
    pub fn named(&self, values: &[Value]) -> BTreeMap<String, Value> {
        self.axes.iter().zip(values).map(|(axis, value)| (axis.name.clone(), value.clone())).collect()
    }
}

impl Axis {
    /// The axis of a parameter, if it can have more than one value.
    fn of(param: &Param) -> Option<Axis> {
        let (is_free, logarithmic) = match &param.domain {
            Domain::Number { least, most, whole } => {
                (least < most, !whole && *least > 0.0 && most / least >= FAR_APART)
            }
            Domain::Choice { names } => (names.len() > 1, false),
            Domain::Color | Domain::Switch => (true, false),
        };
        let Param { name, default, domain, .. } = param.clone();
        is_free.then_some(Axis { name, default, domain, logarithmic })
    }

    /// How many values there are, where each has an equal share of the unit interval.
    fn count(&self) -> Option<f64> {
        match &self.domain {
            Domain::Number { whole: false, .. } => None,
            Domain::Number { least, most, whole: true } => Some(most - least + 1.0),
            Domain::Color => Some(f64::from(hilbert::COLORS)),
            Domain::Choice { names } => Some(names.len() as f64),
            Domain::Switch => Some(2.0),
        }
    }

    /// The value that so many others come before.
    fn nth(&self, number: f64) -> Value {
        match &self.domain {
            Domain::Number { least, most, .. } => Value::Number((least + number).clamp(*least, *most)),
            Domain::Color => Value::Text(srgb::to_hex(hilbert::color(number as u32))),
            Domain::Choice { names } => names
                .get(number as usize)
                .map_or_else(|| self.default.clone(), |name| Value::Text(name.clone())),
            Domain::Switch => Value::Flag(number > 0.0),
        }
    }

    /// How many values come before one.
    fn rank(&self, value: &Value) -> f64 {
        match (&self.domain, value) {
            (Domain::Number { least, .. }, Value::Number(value)) => value - least,
            (Domain::Color, Value::Text(text)) => {
                srgb::from_hex(text).map_or(0.0, |bytes| f64::from(hilbert::place(bytes)))
            }
            (Domain::Choice { names }, Value::Text(text)) => {
                names.iter().position(|name| name == text).unwrap_or(0) as f64
            }
            (Domain::Switch, Value::Flag(flag)) => f64::from(*flag),
            // No space has such values.
            _ => 0.0,
        }
    }

    /// The value at a place in the unit interval, each of those that can be counted having an equal share of it. Other
    /// numbers are rounded to what a person would write.
    pub fn value(&self, place: f64) -> Value {
        let place = place.clamp(0.0, 1.0);
        match (&self.domain, self.count()) {
            (_, Some(count)) => self.nth((place * count).floor().min(count - 1.0)),
            (Domain::Number { least, most, .. }, None) => {
                let value = if self.logarithmic {
                    written(format!("{:.3e}", least * libm::pow(most / least, place)))
                } else {
                    tidy(least * (1.0 - place) + most * place, most - least)
                };
                Value::Number(value.clamp(*least, *most))
            }
            _ => self.default.clone(),
        }
    }

    /// Where a value is in the unit interval; of the share of one that can be counted, that which is `within` of it.
    pub fn place(&self, value: &Value, within: f64) -> f64 {
        let place = match (&self.domain, self.count(), value) {
            (_, Some(count), _) => (self.rank(value) + within) / count,
            (Domain::Number { least, most, .. }, None, Value::Number(value)) if self.logarithmic => {
                libm::log(value / least) / libm::log(most / least)
            }
            (Domain::Number { least, most, .. }, None, Value::Number(value)) => {
                (value / 2.0 - least / 2.0) / (most / 2.0 - least / 2.0)
            }
            _ => 0.0,
        };
        place.clamp(0.0, 1.0)
    }
}

/// A number with no more digits than tell ten thousandths of a range apart.
fn tidy(value: f64, width: f64) -> f64 {
    if !width.is_finite() {
        return value;
    }
    let digits = 4.0 - libm::log10(width).floor();
    if digits >= 0.0 {
        written(format!("{value:.*}", digits as usize))
    } else {
        let unit = libm::exp10(-digits);
        (value / unit).round() * unit
    }
}

/// A number that was written down.
fn written(text: String) -> f64 {
    // What was a number is one.
    text.parse().unwrap_or(f64::NAN)
}
