//! The box of all values that the parameters of a script may have.

use crate::scene::Param;
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
    /// Smallest value.
    pub least: f64,
    /// Largest value.
    pub most: f64,
    /// The value that the script gives it.
    pub default: f64,
    /// Whether only whole numbers will do.
    pub whole: bool,
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
    pub fn new(params: &[Param], fixed: &BTreeMap<String, f64>) -> Space {
        let free = params.iter().filter(|p| !fixed.contains_key(&p.name));
        Space { axes: free.filter_map(Axis::of).collect() }
    }

    /// What the script gives its parameters.
    pub fn defaults(&self) -> Vec<f64> {
        self.axes.iter().map(|axis| axis.default).collect()
    }

    /// The values at a point of the unit cube.
    pub fn values(&self, point: &[f64]) -> Vec<f64> {
        self.axes.iter().zip(point).map(|(axis, place)| axis.value(*place)).collect()
    }

    /// Values by name.
    pub fn named(&self, values: &[f64]) -> BTreeMap<String, f64> {
        self.axes.iter().zip(values).map(|(axis, value)| (axis.name.clone(), *value)).collect()
    }
}

impl Axis {
    /// The axis of a parameter, if it can have more than one value.
    fn of(param: &Param) -> Option<Axis> {
        let (least, most) = param.range;
        let (least, most) = if param.whole { (least.ceil(), most.floor()) } else { (least, most) };
        let axis = Axis {
            name: param.name.clone(),
            least,
            most,
            default: param.default,
            whole: param.whole,
            logarithmic: !param.whole && least > 0.0 && most / least >= FAR_APART,
        };
        (least < most).then_some(axis)
    }

    /// How many whole numbers there are.
    fn count(&self) -> f64 {
        self.most - self.least + 1.0
    }

    /// The value at a place in the unit interval, each whole number having an equal share of it. Others are rounded to
    /// what a person would write.
    pub fn value(&self, place: f64) -> f64 {
        let place = place.clamp(0.0, 1.0);
        let value = if self.whole {
            self.least + (place * self.count()).floor()
        } else if self.logarithmic {
            written(format!("{:.3e}", self.least * libm::pow(self.most / self.least, place)))
        } else {
            tidy(self.least * (1.0 - place) + self.most * place, self.most - self.least)
        };
        value.clamp(self.least, self.most)
    }

    /// Where a value is in the unit interval; of the share of a whole number, that which is `within` of it.
    pub fn place(&self, value: f64, within: f64) -> f64 {
        let place = if self.whole {
            (value - self.least + within) / self.count()
        } else if self.logarithmic {
            libm::log(value / self.least) / libm::log(self.most / self.least)
        } else {
            let reach = self.most / 2.0 - self.least / 2.0;
            (value / 2.0 - self.least / 2.0) / reach
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
