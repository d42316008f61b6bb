//! What is given by `--set` against what a noise can be told, before a script is made of it: an error
//! in the command line is said in its own terms.

use super::super::report::{Failure, Outcome};
use super::kind::Setting;
use crate::diag::nearest;
use crate::noise::{Allowed, Parameter, Recipe, Signal};

/// The options of sums of octaves.
pub const SUM: &[Parameter] = &[
    Parameter {
        name: "octaves",
        doc: "how many",
        allowed: Allowed::Whole {
            least: *Recipe::OCTAVES.start() as u32,
            most: *Recipe::OCTAVES.end() as u32,
            default: 8,
        },
    },
    Parameter {
        name: "first",
        doc: "the coarsest",
        // It may be negative, which whole numbers of noises never are.
        allowed: number(*Recipe::FIRST.start() as f64, *Recipe::FIRST.end() as f64),
    },
    Parameter {
        name: "lacunarity",
        doc: "ratio of frequencies",
        allowed: number(*Recipe::LACUNARITY.start(), *Recipe::LACUNARITY.end()),
    },
    Parameter {
        name: "hurst",
        doc: "exponent of amplitudes",
        allowed: number(*Recipe::HURST.start(), *Recipe::HURST.end()),
    },
    Parameter {
        name: "offset",
        doc: "added to the octaves",
        allowed: number(*Recipe::OFFSET.start(), *Recipe::OFFSET.end()),
    },
    Parameter { name: "rotate", doc: "turn every octave", allowed: Allowed::Flag { default: false } },
    Parameter { name: "detail", doc: "fade what is too small", allowed: Allowed::Flag { default: true } },
];

/// The option that the altitude models have besides.
pub const CASCADE: &[Parameter] =
    &[Parameter { name: "signal", doc: "what is made of the octaves", allowed: Allowed::Choice(&SIGNALS) }];

const SIGNALS: [&str; 3] = [Signal::Plain.name(), Signal::Turbulent.name(), Signal::Ridged.name()];

const fn number(least: f64, most: f64) -> Allowed {
    Allowed::Number { least, most, default: least }
}

/// Refuses what `kind` does not have, and values that it cannot have.
pub fn check(kind: &str, settings: &[Setting], tables: &[&[Parameter]]) -> Outcome {
    let known = || tables.iter().copied().flatten();
    for Setting { name, value } in settings {
        let Some(parameter) = known().find(|p| p.name == *name) else {
            return Err(unknown(kind, name, &known().map(|p| p.name).collect::<Vec<_>>()));
        };
        // The script reads arrays, and exponents of octaves may be one.
        let listed = value.starts_with('[') && (is_array(&parameter.allowed) || name == "hurst");
        if !listed && !fits(&parameter.allowed, value) {
            let words = parameter.allowed.words();
            let wanted =
                if is_array(&parameter.allowed) { format!("{words}, such as [1, 0, 0]") } else { words };
            return Err(Failure::usage(
                format!("--set {name}={value}: it cannot be that"),
                format!("`{name}` of {kind} may be: {wanted}"),
            ));
        }
    }
    Ok(())
}

fn is_array(allowed: &Allowed) -> bool {
    matches!(allowed, Allowed::Direction | Allowed::Numbers { .. })
}

/// Whether a value is one of those that are allowed, none of which is an array.
fn fits(allowed: &Allowed, value: &str) -> bool {
    let number = || value.parse::<f64>().ok().filter(|v| v.is_finite());
    match *allowed {
        Allowed::Number { least, most, .. } => number().is_some_and(|v| (least..=most).contains(&v)),
        Allowed::Whole { least, most, .. } => value.parse().is_ok_and(|v: u32| (least..=most).contains(&v)),
        Allowed::Choice(names) => names.contains(&value),
        Allowed::Flag { .. } => matches!(value, "true" | "false"),
        Allowed::Direction | Allowed::Numbers { .. } => false,
    }
}

fn unknown(kind: &str, name: &str, known: &[&str]) -> Failure {
    let message = format!("{kind} has no option `{name}`");
    match nearest(name, known.iter().copied()) {
        Some(near) => Failure::usage(message, format!("did you mean `{near}`?")),
        None if known.is_empty() => Failure::usage(message, "it has none"),
        None => Failure::usage(message, format!("its options are {}", known.join(", "))),
    }
}
