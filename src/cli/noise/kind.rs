//! Which noise is meant: a name with options becomes the script that one would write for it.

use super::super::options::finite;
use super::super::report::Failure;
use super::settings;
use crate::diag::nearest;
use crate::noise::{Combination, Kind, Model, Recipe};
use crate::scene::Value;
use crate::script::{Request, Script};
use crate::world::Disk;
use std::ops::RangeInclusive;
use std::path::Path;
use std::str::FromStr;
use std::sync::Arc;

/// What the noise is told.
#[derive(clap::Args, Clone, Debug)]
pub struct KindOptions {
    /// Sets an option of the noise, such as kernel=quintic of sparse, or a parameter of the script;
    /// may be given several times
    #[arg(long = "set", value_name = "NAME=VALUE", allow_hyphen_values = true)]
    settings: Vec<Setting>,

    /// Noise that a sum of octaves is made of: a name, or an expression [default: gradient]
    #[arg(long, value_name = "NOISE")]
    of: Option<String>,

    /// Octaves of a sum, 1 to 32
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(i32).range(whole(Recipe::OCTAVES)))]
    octaves: Option<i32>,

    /// Exponent of the amplitudes of a sum, 0 to 2: 1 is smooth, 0 rough
    #[arg(long, value_name = "H", allow_negative_numbers = true, value_parser = |text: &str| within(text, Recipe::HURST))]
    hurst: Option<f64>,

    /// Ratio of the frequencies of successive octaves, above 1 and up to 16
    #[arg(long, value_name = "R", allow_negative_numbers = true, value_parser = |text: &str| within(text, Recipe::LACUNARITY))]
    lacunarity: Option<f64>,

    /// Seed of the first realisation; the others follow it [default: 0, or what KIND says]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub seed: Option<i64>,
}

/// A range for the parser of the command line.
fn whole(range: RangeInclusive<i32>) -> RangeInclusive<i64> {
    i64::from(*range.start())..=i64::from(*range.end())
}

/// Parses a number of a range.
fn within(text: &str, range: RangeInclusive<f64>) -> Result<f64, String> {
    finite(text).ok().filter(|value| range.contains(value)).ok_or(format!(
        "a number from {} to {} is needed",
        range.start(),
        range.end()
    ))
}

/// `name=value`, the value as it was typed.
#[derive(Clone, Debug)]
pub struct Setting {
    /// What is set.
    pub name: String,
    /// To what, as it was typed.
    pub value: String,
}

impl FromStr for Setting {
    type Err = String;

    fn from_str(text: &str) -> Result<Setting, String> {
        match text.split_once('=') {
            Some((name, value)) if !name.trim().is_empty() && !value.trim().is_empty() => {
                Ok(Setting { name: name.trim().to_owned(), value: value.trim().to_owned() })
            }
            _ => Err("name=value is needed; for example: orogen noise sparse --set kernel=quintic -o sparse"
                .to_owned()),
        }
    }
}

/// A noise to analyse.
pub struct Found {
    /// Its name in titles.
    pub title: String,
    /// The script that has it as its value.
    pub request: Request,
}

impl KindOptions {
    /// The noise that a word, expression or path stands for.
    pub fn find(&self, kind: &str) -> Result<Found, Failure> {
        if let Some(twice) = twice(&self.settings) {
            return Err(Failure::usage(format!("--set gives `{twice}` twice"), "leave one of them out"));
        }
        if kind.ends_with(".rhai") {
            self.refuse_octaves("a script")?;
            if !Path::new(kind).exists() {
                let hint = "KIND is a path that ends in .rhai, the name of a noise, or an expression";
                return Err(Failure::error(format!("there is no script {kind}"), hint));
            }
            let title = Path::new(kind).file_stem().map_or(kind.into(), |s| s.to_string_lossy().into_owned());
            return Ok(self.scripted(title, Script::File(kind.into())));
        }
        if let Some(model) = Model::NAMED.iter().copied().find(|m| m.name() == kind) {
            let text = self.sum(model)?;
            return Ok(named(kind, text));
        }
        if let Some(listing) = Kind::ALL.iter().find(|k| k.name == kind) {
            self.refuse_octaves("a single noise")?;
            settings::check(kind, &self.settings, &[listing.parameters])?;
            return Ok(named(kind, self.single(kind, &self.settings)));
        }
        if is_path(kind) {
            return Err(not_a_script(kind));
        }
        if is_word(kind) {
            return Err(unknown(kind));
        }
        self.refuse_octaves("an expression")?;
        let script = Script::Text { name: "KIND".to_owned(), text: kind.to_owned() };
        Ok(self.scripted(shortened(kind), script))
    }

    /// A script or an expression, with parameters.
    fn scripted(&self, title: String, script: Script) -> Found {
        let mut request = Request::new(script, Arc::new(Disk));
        let set = self.settings.iter().map(|s| (s.name.clone(), Value::Text(s.value.clone())));
        request.params.extend(set);
        Found { title, request }
    }

    /// A sum of octaves: what the noise below it knows goes to that, the rest to the sum.
    fn sum(&self, model: Model) -> Result<String, Failure> {
        let of = self.of.as_deref().unwrap_or("gradient");
        let listing = Kind::ALL.iter().find(|k| k.name == of);
        if models().contains(&of) {
            let hint = format!("--of takes one of {}, or an expression", kinds().join(", "));
            return Err(Failure::usage(format!("`{of}` is a sum of octaves itself"), hint));
        }
        if listing.is_none() && is_word(of) {
            return Err(unknown(of));
        }
        let cascade = if model.combination == Combination::Sum { &[] } else { settings::CASCADE };
        let inner = listing.map_or(&[][..], |k| k.parameters);
        settings::check(model.name(), &self.settings, &[settings::SUM, cascade, inner])?;
        let own = |s: &&Setting| listing.is_some_and(|k| k.parameters.iter().any(|p| p.name == s.name));
        let (inner, mut outer): (Vec<Setting>, Vec<Setting>) = {
            let (a, b): (Vec<&Setting>, Vec<&Setting>) = self.settings.iter().partition(own);
            (a.into_iter().cloned().collect(), b.into_iter().cloned().collect())
        };
        let mut add = |name: &str, value: Option<String>| {
            outer.extend(value.map(|value| Setting { name: name.to_owned(), value }));
        };
        add("octaves", self.octaves.map(|v| v.to_string()));
        add("hurst", self.hurst.map(|v| v.to_string()));
        add("lacunarity", self.lacunarity.map(|v| v.to_string()));
        if let Some(twice) = twice(&outer) {
            let message = format!("`{twice}` is given twice, by --set and by --{twice}");
            return Err(Failure::usage(message, "leave one of them out"));
        }
        let noise = if listing.is_some() { self.single(of, &inner) } else { of.to_owned() };
        Ok(format!("octave_sum({noise}, \"{}\", {})", model.name(), map(&outer)))
    }

    fn single(&self, kind: &str, settings: &[Setting]) -> String {
        let seed = self.seed.unwrap_or(0);
        if settings.is_empty() {
            format!("{kind}({seed})")
        } else {
            format!("{kind}({seed}, {})", map(settings))
        }
    }

    fn refuse_octaves(&self, what: &str) -> Result<(), Failure> {
        let given = [
            ("--of", self.of.is_some()),
            ("--octaves", self.octaves.is_some()),
            ("--hurst", self.hurst.is_some()),
            ("--lacunarity", self.lacunarity.is_some()),
        ];
        match given.into_iter().find(|(_, given)| *given) {
            None => Ok(()),
            Some((option, _)) => Err(Failure::usage(
                format!("{option} is for sums of octaves, and KIND is {what}"),
                format!(
                    "the sums are {}; for example: orogen noise fbm --octaves 5 -o fbm",
                    models().join(", ")
                ),
            )),
        }
    }
}

fn named(name: &str, text: String) -> Found {
    let script = Script::Text { name: "KIND".to_owned(), text };
    Found { title: name.to_owned(), request: Request::new(script, Arc::new(Disk)) }
}

/// Settings as an object map; what is not a number, a list or a truth value is a text.
fn map(settings: &[Setting]) -> String {
    let value = |v: &str| {
        let literal = v.parse::<f64>().is_ok() || v.starts_with('[') || matches!(v, "true" | "false");
        if literal { v.to_owned() } else { format!("{v:?}") }
    };
    let parts: Vec<String> = settings.iter().map(|s| format!("{:?}: {}", s.name, value(&s.value))).collect();
    format!("#{{ {} }}", parts.join(", "))
}

fn models() -> Vec<&'static str> {
    Model::NAMED.iter().map(|m| m.name()).collect()
}

fn kinds() -> Vec<&'static str> {
    Kind::ALL.iter().map(|k| k.name).collect()
}

/// The first name that is set twice.
fn twice(settings: &[Setting]) -> Option<&str> {
    let again = |i: usize| settings[..i].iter().any(|s| s.name == settings[i].name);
    (0..settings.len()).find(|&i| again(i)).map(|i| settings[i].name.as_str())
}

/// Whether a text is meant as a path, though not as that of a script.
fn is_path(text: &str) -> bool {
    let like_one = text.contains(['/', '\\']) && !text.contains(['(', ' ']);
    like_one || (text.contains('.') && Path::new(text).exists())
}

fn not_a_script(path: &str) -> Failure {
    let script = Path::new(path).with_extension("rhai");
    let message = format!("{path} is no noise, and a script ends in .rhai");
    if script.exists() {
        Failure::usage(message, format!("did you mean {}?", script.display()))
    } else {
        Failure::usage(message, "for example: orogen noise marble.rhai -o marble")
    }
}

/// Whether a text can be no expression but a name.
fn is_word(text: &str) -> bool {
    text.chars().all(|c| c.is_alphanumeric() || c == '_' || c == '-')
}

fn unknown(word: &str) -> Failure {
    let names = [kinds(), models()].concat();
    let list = format!(
        "there are {}; or an expression such as 'gradient(7).scaled(2.0)', or a script",
        names.join(", ")
    );
    let message = format!("there is no noise called `{word}`");
    match nearest(word, names.iter().copied()) {
        Some(near) => Failure::usage(message, format!("did you mean `{near}`? {list}")),
        None => Failure::usage(message, list),
    }
}

/// An expression as a title.
fn shortened(text: &str) -> String {
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    if line.chars().count() <= 36 { line } else { line.chars().take(35).chain(['…']).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn setting(text: &str) -> Setting {
        text.parse().unwrap()
    }

    #[test]
    fn settings_become_script() {
        let all = ["nodes=2", "kernel=quintic", "weights=[1,0]", "smooth=true"].map(setting);
        let wanted = r#"#{ "nodes": 2, "kernel": "quintic", "weights": [1,0], "smooth": true }"#;
        assert_eq!(map(&all), wanted);
        for bad in ["a", "=1", "a="] {
            assert!(bad.parse::<Setting>().unwrap_err().contains("sparse --set kernel=quintic"), "{bad}");
        }
        assert_eq!(twice(&["a=1", "b=1", "a=2"].map(setting)), Some("a"));
    }

    #[test]
    fn paths_are_told_from_expressions() {
        assert!(is_path("scripts/marble") && is_path("..\\marble"));
        assert!(
            !is_path("gradient") && !is_path("gradient(7)/2.0") && !is_path("x / 2.0") && !is_path("0.5")
        );
    }

    #[test]
    fn long_expressions_are_shortened() {
        assert_eq!(shortened("gradient(7)\n  .scaled(2.0)"), "gradient(7) .scaled(2.0)");
        assert_eq!(shortened(&"x".repeat(80)).chars().count(), 36);
    }
}
