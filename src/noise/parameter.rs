//! The parameters of noises as data: scripts, the command line and the reference read one table.

use super::Invalid;
use std::hash::{Hash, Hasher};

/// What a noise can be told.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Name in scripts.
    pub name: &'static str,
    /// One sentence.
    pub doc: &'static str,
    /// What it may be, and what it is unless said otherwise.
    pub allowed: Allowed,
}

/// The values that a parameter may have, with its default.
#[derive(Clone, Copy, Debug)]
pub enum Allowed {
    /// A number of a range.
    Number {
        /// Smallest.
        least: f64,
        /// Largest; may be infinite.
        most: f64,
        /// Unless said otherwise.
        default: f64,
    },
    /// A whole number of a range.
    Whole {
        /// Smallest.
        least: u32,
        /// Largest.
        most: u32,
        /// Unless said otherwise.
        default: u32,
    },
    /// One of some names; the first unless said otherwise.
    Choice(&'static [&'static str]),
    /// Yes or no.
    Flag {
        /// Unless said otherwise.
        default: bool,
    },
    /// A direction, of any length but zero; none unless said otherwise.
    Direction,
    /// One to four numbers from `-most` to `most`; those left out are zero.
    Numbers {
        /// Largest absolute value.
        most: f64,
        /// Unless said otherwise.
        default: [f64; 4],
    },
}

/// The value of a parameter.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Setting {
    /// A number, whole or not.
    Number(f64),
    /// One of the names.
    Name(&'static str),
    /// Yes or no.
    Flag(bool),
    /// A direction, if there is one.
    Direction(Option<[f64; 3]>),
    /// Up to four numbers.
    Numbers([f64; 4]),
}

impl Allowed {
    /// The value unless said otherwise.
    pub fn default(&self) -> Setting {
        match *self {
            Allowed::Number { default, .. } => Setting::Number(default),
            Allowed::Whole { default, .. } => Setting::Number(f64::from(default)),
            Allowed::Choice(names) => Setting::Name(names.first().copied().unwrap_or_default()),
            Allowed::Flag { default } => Setting::Flag(default),
            Allowed::Direction => Setting::Direction(None),
            Allowed::Numbers { default, .. } => Setting::Numbers(default),
        }
    }

    /// The values in words.
    pub fn words(&self) -> String {
        match *self {
            Allowed::Number { least, most, .. } if most.is_infinite() => format!("{least} or more"),
            Allowed::Number { least, most, .. } => format!("{least} to {most}"),
            Allowed::Whole { least, most, .. } => format!("{least} to {most}"),
            Allowed::Choice(names) => names.join(", "),
            Allowed::Flag { .. } => "true or false".to_owned(),
            Allowed::Direction => "a vector".to_owned(),
            Allowed::Numbers { .. } => "up to four numbers".to_owned(),
        }
    }
}

/// Values for all parameters of a noise.
#[derive(Clone, Debug)]
pub struct Settings {
    parameters: &'static [Parameter],
    values: Vec<Setting>,
}

impl Settings {
    /// All defaults.
    pub fn new(parameters: &'static [Parameter]) -> Settings {
        Settings { parameters, values: parameters.iter().map(|p| p.allowed.default()).collect() }
    }

    /// Sets a parameter.
    ///
    /// # Errors
    /// If there is no such parameter, the value is of another kind, or a number is out of range.
    pub fn set(&mut self, name: &'static str, value: Setting) -> Result<(), Invalid> {
        let out = |value: f64, allowed: &'static str| Err(Invalid { field: name, value, allowed });
        let Some(i) = self.parameters.iter().position(|p| p.name == name) else {
            return out(f64::NAN, "left out: the noise has no such parameter");
        };
        match (self.parameters[i].allowed, value) {
            (Allowed::Number { least, most, .. }, Setting::Number(v)) if !(least..=most).contains(&v) => {
                out(v, "in its range")
            }
            (Allowed::Whole { least, most, .. }, Setting::Number(v))
                if v.fract() != 0.0 || !(f64::from(least)..=f64::from(most)).contains(&v) =>
            {
                out(v, "a whole number in its range")
            }
            (Allowed::Numbers { most, .. }, Setting::Numbers(v)) if !v.iter().all(|v| v.abs() <= most) => {
                out(
                    v.into_iter().fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a }),
                    "in their range",
                )
            }
            (Allowed::Choice(names), Setting::Name(v)) if !names.contains(&v) => {
                out(f64::NAN, "one of its names")
            }
            (Allowed::Number { .. } | Allowed::Whole { .. }, Setting::Number(_))
            | (Allowed::Choice(_), Setting::Name(_))
            | (Allowed::Flag { .. }, Setting::Flag(_))
            | (Allowed::Direction, Setting::Direction(_))
            | (Allowed::Numbers { .. }, Setting::Numbers(_)) => {
                self.values[i] = value;
                Ok(())
            }
            _ => out(f64::NAN, "of the kind that the parameter is"),
        }
    }

    fn get(&self, name: &str) -> Option<Setting> {
        let i = self.parameters.iter().position(|p| p.name == name)?;
        Some(self.values[i])
    }

    /// A number; 0 if there is no such parameter.
    pub fn number(&self, name: &str) -> f64 {
        match self.get(name) {
            Some(Setting::Number(v)) => v,
            _ => 0.0,
        }
    }

    /// A name; empty if there is no such parameter.
    pub fn name(&self, name: &str) -> &'static str {
        match self.get(name) {
            Some(Setting::Name(v)) => v,
            _ => "",
        }
    }

    /// Yes or no; no if there is no such parameter.
    pub fn flag(&self, name: &str) -> bool {
        matches!(self.get(name), Some(Setting::Flag(true)))
    }

    /// A direction, if there is one.
    pub fn direction(&self, name: &str) -> Option<[f64; 3]> {
        match self.get(name) {
            Some(Setting::Direction(v)) => v,
            _ => None,
        }
    }

    /// Four numbers; zeros if there is no such parameter.
    pub fn numbers(&self, name: &str) -> [f64; 4] {
        match self.get(name) {
            Some(Setting::Numbers(v)) => v,
            _ => [0.0; 4],
        }
    }
}

/// A number that is compared and hashed by its bits, as sharing expressions asks.
#[derive(Clone, Copy, Debug)]
pub struct Exact(pub f64);

impl PartialEq for Exact {
    fn eq(&self, other: &Self) -> bool {
        self.0.to_bits() == other.0.to_bits()
    }
}

impl Eq for Exact {}

impl Hash for Exact {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.to_bits().hash(state);
    }
}
