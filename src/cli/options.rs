//! Options that several commands share, and the forms in which their values are written.

use super::report::Failure;
use crate::cast::Kind;
use crate::render::{Format, Part, Precision, Rect};
use crate::scene::{Film, Value};
use clap::builder::PossibleValuesParser;
use clap::builder::TypedValueParser as _;
use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// What a script is run with.
#[derive(clap::Args, Clone, Debug)]
pub struct ScriptOptions {
    /// Sets a parameter of the script: a number, a colour #rrggbb, a name, on or off; may be given several times
    #[arg(long = "set", value_name = "NAME=VALUE", allow_hyphen_values = true)]
    settings: Vec<Setting>,

    /// Animation time in seconds, the `time` of the script
    #[arg(long, value_name = "SECONDS", default_value = "0", value_parser = finite, allow_hyphen_values = true)]
    pub time: f64,
}

impl ScriptOptions {
    /// Parameters by name.
    pub fn params(&self) -> Result<BTreeMap<String, Value>, Failure> {
        let mut params = BTreeMap::new();
        for Setting { name, value } in &self.settings {
            if params.insert(name.clone(), Value::Text(value.clone())).is_some() {
                let hint = "a parameter has one value; leave one of them out";
                return Err(Failure::usage(format!("--set gives `{name}` twice"), hint));
            }
        }
        Ok(params)
    }
}

/// What a picture is made with.
#[derive(clap::Args, Clone, Debug)]
pub struct PictureOptions {
    /// Picture to write, .png or .exr [default: the name of the script, here, with .png]
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,

    /// Width and height in pixels, such as 1920x1080 [default: what the script says, or 800x600]
    #[arg(long, value_name = "WxH", allow_hyphen_values = true)]
    pub size: Option<Size>,

    /// Samples per pixel; more are smoother and slower [default: what the script says, or 4]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(Film::MAX_SAMPLES)), allow_negative_numbers = true)]
    pub samples: Option<u32>,

    /// How rays find the surface: auto, beam, octree, sphere, speculative, segment or affine; to compare with,
    /// reduced, standard, interval or, for flowed solids, bent
    #[arg(long, value_name = "KIND", default_value = "auto", hide_possible_values = true)]
    #[arg(value_parser = PossibleValuesParser::new(Kind::ALL.map(|k| k.1)).map(|s| kind(&s)))]
    pub caster: Kind,

    /// Threads to use [default: one per processor core]; the picture does not depend on it
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    pub threads: Option<NonZeroUsize>,
}

impl PictureOptions {
    /// The file to write: what was asked for, or the stem of the script in the current folder, with
    /// this ending.
    pub fn output(&self, script: &Path, ending: &str) -> Result<PathBuf, Failure> {
        let stem = || script.file_stem().unwrap_or("picture".as_ref());
        let path = self.output.clone().unwrap_or_else(|| Path::new(stem()).with_extension(ending));
        picture_path(path)
    }
}

/// Which part of a picture is made, and how a file holds it.
#[derive(clap::Args, Clone, Debug)]
pub struct FileOptions {
    /// Renders these pixels only: first column, first row, width and height, in the picture of full size
    ///
    /// They are the same, bit for bit, as in the whole picture. A .png is as large as the region; an .exr has it as its
    /// data window within the picture.
    #[arg(long, value_name = "X,Y,WxH", conflicts_with = "tile", allow_hyphen_values = true)]
    pub region: Option<Rect>,

    /// Renders the I-th of N parts of the picture, to NAME.IofN.png; `orogen merge` puts them together
    #[arg(long, value_name = "I/N", value_parser = tile)]
    pub tile: Option<Part>,

    /// Smooths noise, a preview of what more samples would give; an .exr has it beside the light as it is
    #[arg(long, conflicts_with_all = ["region", "tile"])]
    pub denoise: bool,

    /// Adds a channel to an .exr that says which component of the solid is seen: its number in `orogen topology`
    ///
    /// It is -1 where nothing is seen, and where that is not known. The topology is found out first, which may take a while.
    #[arg(long)]
    pub components: bool,

    /// How closely an .exr holds light: float, or half for half the size; depth, positions and normals are floats always
    #[arg(long, value_name = "PRECISION", hide_possible_values = true)]
    pub exr: Option<Light>,
}

/// How closely an .exr holds light.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub enum Light {
    /// 32 bits.
    Float,
    /// 16 bits.
    Half,
}

impl FileOptions {
    /// The part that is wanted.
    pub fn part(&self) -> Part {
        self.region.map(Part::Region).or(self.tile).unwrap_or_default()
    }

    /// The ending of the file, unless it is named: parts do not go where the whole picture does.
    pub fn ending(&self) -> String {
        let format = if self.exr.is_some() || self.components { "exr" } else { "png" };
        match self.part() {
            Part::Whole => format.to_owned(),
            Part::Region(_) => format!("region.{format}"),
            Part::Tile { number, of } => format!("{number}of{of}.{format}"),
        }
    }

    /// How closely the file holds light.
    pub fn precision(&self, file: &Path) -> Result<Precision, Failure> {
        let asked = [(self.exr.is_some(), "--exr"), (self.components, "--components")];
        let is_open_exr = matches!(Format::of(file), Ok(Format::OpenExr));
        if let Some((_, option)) = asked.iter().find(|(asked, _)| *asked && !is_open_exr) {
            let hint = format!("for example: -o {}", file.with_extension("exr").display());
            return Err(Failure::usage(format!("{option} is about .exr files"), hint));
        }
        Ok(if matches!(self.exr, Some(Light::Half)) { Precision::Half } else { Precision::Float })
    }
}

/// Parses `I/N`.
fn tile(text: &str) -> Result<Part, String> {
    let number = |s: &str| s.trim().parse::<u32>().ok().filter(|n| *n > 0);
    let numbers = text.split_once('/').and_then(|(i, n)| Some((number(i)?, number(n)?)));
    let example = "for example the second of four: --tile 2/4";
    match numbers {
        Some((number, of)) if number <= of => Ok(Part::Tile { number, of }),
        Some((number, of)) => Err(format!("there is no part {number} of {of}; {example}")),
        None => Err(format!("parts count from 1; {example}")),
    }
}

/// A path that a picture can be written to, going by its ending.
pub fn picture_path(path: PathBuf) -> Result<PathBuf, Failure> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match ending.as_deref() {
        Some("png" | "exr") => Ok(path),
        _ => {
            let hint = format!("for example: -o {}", path.with_extension("png").display());
            let message = format!("`{}` does not end in .png or .exr", path.display());
            Err(Failure::usage(message, hint))
        }
    }
}

/// Parses a path for statistics. Another ending is a mistake, and may be that of a script.
pub fn statistics_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension() {
        Some(ending) if ending.eq_ignore_ascii_case("json") => Ok(path),
        _ => Err(
            "it does not end in .json; for example: --stats statistics.json, or a lone --stats at the end"
                .into(),
        ),
    }
}

fn kind(name: &str) -> Kind {
    Kind::ALL.into_iter().find(|k| k.1 == name).map(|k| k.0).unwrap_or_default()
}

/// Most threads; more than any machine that this may run on has cores.
const MOST_THREADS: usize = 1024;

/// Parses a number of threads.
pub fn threads(text: &str) -> Result<NonZeroUsize, String> {
    let number = text.trim().parse().ok().filter(|n: &NonZeroUsize| n.get() <= MOST_THREADS);
    number.ok_or(format!("a number from 1 to {MOST_THREADS} is needed; for example: --threads 4"))
}

/// Parses a number that is finite.
pub fn finite(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("a number is needed, such as 1.5".into()),
    }
}

/// `name=value`; the script says what the value may be.
#[derive(Clone, Debug, PartialEq)]
struct Setting {
    name: String,
    value: String,
}

impl FromStr for Setting {
    type Err = String;

    fn from_str(text: &str) -> Result<Setting, String> {
        let example = "for example: --set relief=0.04";
        let (name, value) = text.split_once('=').ok_or(format!("there is no `=`; {example}"))?;
        let name = name.trim();
        if name.is_empty() {
            return Err(format!("there is no name before the `=`; {example}"));
        }
        let value = value.trim();
        if value.is_empty() {
            return Err(format!("there is no value after the `=`; {example}"));
        }
        Ok(Setting { name: name.into(), value: value.into() })
    }
}

/// Width and height of a picture in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Size, String> {
        let side = |s: &str| s.trim().parse::<u32>().ok();
        let longest = 1..=Film::MAX_SIDE;
        let sides = text.split_once(['x', 'X', '×']).and_then(|(w, h)| Some((side(w)?, side(h)?)));
        match sides {
            Some((width, height)) if longest.contains(&width) && longest.contains(&height) => {
                Ok(Size { width, height })
            }
            Some(_) => {
                Err(format!("each side must be from 1 to {} pixels; for example: 1920x1080", Film::MAX_SIDE))
            }
            None => Err("a size is width x height in pixels; for example: 1920x1080".into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!("640x480".parse(), Ok(Size { width: 640, height: 480 }));
        assert_eq!("640X480".parse(), Ok(Size { width: 640, height: 480 }));
        for bad in ["", "640", "640x", "x480", "0x4", "4x0", "-1x4", "640x480x2", "99999x1", "a x b"] {
            assert!(bad.parse::<Size>().unwrap_err().contains("1920x1080"), "{bad}");
        }
    }

    #[test]
    fn tiles() {
        assert_eq!(tile("2/4"), Ok(Part::Tile { number: 2, of: 4 }));
        for bad in ["", "2", "0/3", "4/3", "1/0", "-1/3", "1/2/3", "a/b"] {
            assert!(tile(bad).unwrap_err().contains("--tile 2/4"), "{bad}");
        }
    }

    #[test]
    fn settings() {
        for (text, value) in [("a=-1e-3", "-1e-3"), (" a = #fa0 ", "#fa0"), ("a=1=2", "1=2")] {
            assert_eq!(text.parse(), Ok(Setting { name: "a".into(), value: value.into() }));
        }
        for bad in ["a", "=1", "a=", "a= "] {
            assert!(bad.parse::<Setting>().unwrap_err().contains("--set relief=0.04"), "{bad}");
        }
    }

    #[test]
    fn every_caster_has_its_name() {
        assert!(Kind::ALL.iter().all(|(kind_, name)| kind(name) == *kind_));
    }
}
