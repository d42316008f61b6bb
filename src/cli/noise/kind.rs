//! Which noise is meant: a name with options becomes the script that one would write for it.

use super::super::options::finite;
use super::super::report::Failure;
use crate::diag::nearest;
use crate::noise::{Kind, Model};
use crate::script::{Request, Script};
use crate::world::Disk;
use std::path::Path;
use std::str::FromStr;
use std::sync::Arc;

/// What the noise is told.
#[derive(clap::Args, Clone, Debug)]
pub struct KindOptions {
    /// Sets an option of the noise, such as kernel=quintic, or a parameter of the script; may be
    /// given several times
    #[arg(long = "set", value_name = "NAME=VALUE", allow_hyphen_values = true)]
    settings: Vec<Setting>,

    /// Noise that a sum of octaves is made of: a name, or an expression [default: gradient]
    #[arg(long, value_name = "NOISE")]
    of: Option<String>,

    /// Octaves of a sum, 1 to 32
    #[arg(long, value_name = "N")]
    octaves: Option<u32>,

    /// Exponent of the amplitudes of a sum: 1 smooth, 0 rough
    #[arg(long, value_name = "H")]
    hurst: Option<f64>,

    /// Ratio of the frequencies of successive octaves
    #[arg(long, value_name = "R")]
    lacunarity: Option<f64>,

    /// Seed of the first realisation; the others follow it [default: 0, or what KIND says]
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
}

/// `name=value`, the value as it was typed.
#[derive(Clone, Debug)]
struct Setting {
    name: String,
    value: String,
}

impl FromStr for Setting {
    type Err = String;

    fn from_str(text: &str) -> Result<Setting, String> {
        match text.split_once('=') {
            Some((name, value)) if !name.trim().is_empty() && !value.trim().is_empty() => {
                Ok(Setting { name: name.trim().to_owned(), value: value.trim().to_owned() })
            }
            _ => Err("name=value is needed; for example: --set kernel=quintic".to_owned()),
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
        if kind.ends_with(".rhai") {
            self.refuse_octaves("a script")?;
            let title = Path::new(kind).file_stem().map_or(kind.into(), |s| s.to_string_lossy().into_owned());
            return self.scripted(title, Script::File(kind.into()));
        }
        if Model::NAMED.iter().any(|m| m.name() == kind) {
            let text = self.sum(kind)?;
            return Ok(named(kind, text));
        }
        if Kind::ALL.iter().any(|k| k.name == kind) {
            self.refuse_octaves("a single noise")?;
            return Ok(named(kind, self.single(kind, &self.settings)));
        }
        if is_word(kind) {
            return Err(unknown(kind));
        }
        self.refuse_octaves("an expression")?;
        let script = Script::Text { name: "KIND".to_owned(), text: kind.to_owned() };
        self.scripted(shortened(kind), script)
    }

    /// A script or an expression, with parameters, which are numbers.
    fn scripted(&self, title: String, script: Script) -> Result<Found, Failure> {
        let mut request = Request::new(script, Arc::new(Disk));
        for Setting { name, value } in &self.settings {
            let wrong = |why| {
                Failure::usage(format!("--set {name}={value}: {why}"), "for example: --set relief=0.04")
            };
            let number = finite(value).map_err(wrong)?;
            if request.params.insert(name.clone(), number).is_some() {
                return Err(Failure::usage(format!("--set gives `{name}` twice"), "leave one of them out"));
            }
        }
        Ok(Found { title, request })
    }

    /// A sum of octaves: what the noise below it knows goes to that, the rest to the sum.
    fn sum(&self, model: &str) -> Result<String, Failure> {
        let of = self.of.as_deref().unwrap_or("gradient");
        let listing = Kind::ALL.iter().find(|k| k.name == of);
        if listing.is_none() && is_word(of) {
            return Err(unknown(of));
        }
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
        let noise = if listing.is_some() { self.single(of, &inner) } else { of.to_owned() };
        Ok(format!("octave_sum({noise}, \"{model}\", {})", map(&outer)))
    }

    fn single(&self, kind: &str, settings: &[Setting]) -> String {
        let seed = self.seed.unwrap_or(0) as i64;
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

/// Whether a text can be no expression but a name.
fn is_word(text: &str) -> bool {
    text.chars().all(|c| c.is_alphanumeric() || c == '_' || c == '-')
}

fn unknown(word: &str) -> Failure {
    let names: Vec<&str> = Kind::ALL.iter().map(|k| k.name).chain(models()).collect();
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
            assert!(bad.parse::<Setting>().unwrap_err().contains("--set kernel=quintic"), "{bad}");
        }
    }

    #[test]
    fn long_expressions_are_shortened() {
        assert_eq!(shortened("gradient(7)\n  .scaled(2.0)"), "gradient(7) .scaled(2.0)");
        assert_eq!(shortened(&"x".repeat(80)).chars().count(), 36);
    }
}
