//! Parameters: what a script lets its users turn, pick and switch.

use crate::diag;
use crate::num::srgb;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A value of a parameter, or what somebody typed for one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// Of a switch.
    Flag(bool),
    /// Of a number.
    Number(f64),
    /// A colour as `#rrggbb`, or a name.
    Text(String),
}

impl Value {
    /// The finite number that it is, or says.
    pub fn number(&self) -> Option<f64> {
        let number = match self {
            Value::Flag(_) => None,
            Value::Number(value) => Some(*value),
            Value::Text(text) => text.trim().parse().ok(),
        };
        number.filter(|value| value.is_finite())
    }

    /// Whether it is on, or says so.
    fn flag(&self) -> Option<bool> {
        // Numbers are what switches were before there were any.
        match self.to_string().to_lowercase().as_str() {
            "true" | "on" | "1" => Some(true),
            "false" | "off" | "0" => Some(false),
            _ => None,
        }
    }
}

impl From<f64> for Value {
    fn from(number: f64) -> Value {
        Value::Number(number)
    }
}

impl From<bool> for Value {
    fn from(flag: bool) -> Value {
        Value::Flag(flag)
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Value {
        Value::Text(text.to_owned())
    }
}

/// As it is set on the command line.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Flag(flag) => flag.fmt(f),
            Value::Number(number) => number.fmt(f),
            Value::Text(text) => text.fmt(f),
        }
    }
}

/// Which values a parameter may have.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Domain {
    /// The numbers of a range.
    Number {
        /// Smallest value.
        least: f64,
        /// Largest value.
        most: f64,
        /// Whether only whole numbers will do.
        whole: bool,
    },
    /// Colours.
    Color,
    /// One of some names.
    Choice {
        /// The names.
        names: Vec<String>,
    },
    /// True or false.
    Switch,
}

/// As it is said after a value: `from 0 to 1`.
impl fmt::Display for Domain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Domain::Number { least, most, whole: false } => write!(f, "from {least} to {most}"),
            Domain::Number { least, most, whole: true } => write!(f, "whole numbers from {least} to {most}"),
            Domain::Color => f.write_str("a colour #rrggbb"),
            Domain::Choice { names } => write!(f, "one of {}", names.join(", ")),
            Domain::Switch => f.write_str("true or false"),
        }
    }
}

/// Why a value is not one that a parameter may have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("set to {given}, {why}")]
pub struct Unfit {
    given: String,
    why: &'static str,
    /// The name that was perhaps meant.
    pub nearest: Option<String>,
}

impl Domain {
    /// The value that is meant by one, which may be a text that somebody typed.
    ///
    /// # Errors
    /// [`Unfit`]
    pub fn admit(&self, given: &Value) -> Result<Value, Unfit> {
        let unfit = |why| Unfit { given: given.to_string(), why, nearest: None };
        match self {
            Domain::Number { least, most, whole } => {
                let value = given.number().ok_or_else(|| unfit("which is not a number"))?;
                if !(*least..=*most).contains(&value) {
                    return Err(unfit("which is out of range"));
                }
                if *whole && value.fract() != 0.0 {
                    return Err(unfit("but is a whole number"));
                }
                Ok(Value::Number(value))
            }
            Domain::Color => {
                let bytes = srgb::from_hex(&given.to_string());
                Ok(Value::Text(srgb::to_hex(bytes.ok_or_else(|| unfit("which is not a colour"))?)))
            }
            Domain::Choice { names } => {
                let name = given.to_string();
                let nearest = || diag::nearest(&name, names.iter().map(String::as_str)).map(str::to_owned);
                if names.contains(&name) {
                    return Ok(Value::Text(name));
                }
                Err(Unfit { nearest: nearest(), ..unfit("which is none of its names") })
            }
            Domain::Switch => {
                given.flag().map(Value::Flag).ok_or_else(|| unfit("which is neither on nor off"))
            }
        }
    }
}

/// A value that the script lets its user choose.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Param {
    /// Name, for `--set name=value`.
    pub name: String,
    /// Value where nobody sets another.
    pub default: Value,
    /// Value used.
    pub value: Value,
    /// Which values it may have.
    #[serde(flatten)]
    pub domain: Domain,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_read_as_what_is_wanted() {
        let whole = Domain::Number { least: 1.0, most: 5.0, whole: true };
        let share = Domain::Number { least: 0.0, most: 1.0, whole: false };
        let choice = Domain::Choice { names: ["ridged", "007", "true"].map(str::to_owned).to_vec() };
        for (domain, typed, value) in [
            (&whole, "3", 3.0.into()),
            (&share, "1e-3", 1e-3.into()),
            (&Domain::Color, "#C98f5a", "#c98f5a".into()),
            (&Domain::Color, "#fa0", "#ffaa00".into()),
            (&choice, "ridged", "ridged".into()),
            (&choice, "007", "007".into()),
            (&Domain::Switch, "off", false.into()),
            (&Domain::Switch, "True", true.into()),
        ] {
            assert_eq!(domain.admit(&typed.into()), Ok(value), "{typed}");
        }
        assert_eq!(choice.admit(&Value::Flag(true)), Ok("true".into()));
        assert_eq!(Domain::Switch.admit(&Value::Number(1.0)), Ok(true.into()));
        for (domain, typed, why) in [
            (&whole, "2.5", "set to 2.5, but is a whole number"),
            (&share, "2", "set to 2, which is out of range"),
            (&share, "nan", "set to nan, which is not a number"),
            (&share, "true", "set to true, which is not a number"),
            (&Domain::Color, "c98f5a", "set to c98f5a, which is not a colour"),
            (&choice, "7", "set to 7, which is none of its names"),
            (&Domain::Switch, "no", "set to no, which is neither on nor off"),
        ] {
            assert_eq!(domain.admit(&typed.into()).unwrap_err().to_string(), why);
        }
        assert_eq!(choice.admit(&"rigded".into()).unwrap_err().nearest.as_deref(), Some("ridged"));
    }

    #[test]
    fn messages_hold_plain_values() {
        for (text, value) in
            [("1", 1.0.into()), ("0.5", 0.5.into()), ("true", true.into()), ("\"1\"", Value::from("1"))]
        {
            assert_eq!(serde_json::from_str::<Value>(text).unwrap(), value);
        }
        assert!(
            serde_json::from_str::<Value>("[1]").is_err() && serde_json::from_str::<Value>("null").is_err()
        );
        let domain = Domain::Number { least: 0.0, most: 2.0, whole: false };
        let param = Param { name: "r".into(), default: 0.5.into(), value: 1.0.into(), domain };
        let told = "{\"name\":\"r\",\"default\":0.5,\"value\":1.0,\"kind\":\"number\",\"least\":0.0,\"most\":2.0,\"whole\":false}";
        assert_eq!(serde_json::to_string(&param).unwrap(), told);
    }
}
