//! What people ask of a picture that they watch, and what they are told of it.

use super::steer::Move;
use crate::cast::Kind;
use crate::diag::{Diagnostic, Severity, Sources};
use crate::render::{Layer, Rect};
use crate::scene::{Camera, Domain, Film, Param, Unfit, Value};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What is to be shown, where it differs from what the script and the order say.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Wish {
    pub params: BTreeMap<String, Value>,
    pub time: f64,
    pub playing: bool,
    pub camera: Option<Camera>,
    pub caster: Kind,
    pub layer: Layer,
    pub components: bool,
    pub size: Option<[u32; 2]>,
    pub region: Option<Rect>,
}

/// What people say.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Command {
    /// Parameters have other values.
    Set(BTreeMap<String, Value>),
    /// Parameters have the values that the script gives them: these, or all.
    Reset(Option<Vec<String>>),
    /// The camera moves.
    Move(Move),
    /// The camera is that of the script again.
    SnapBack,
    /// Another caster, by name.
    Caster(String),
    /// Another layer.
    Layer(Layer),
    /// Each component of the solid in a colour of its own, or all as they are.
    Components(bool),
    /// Another time, in seconds.
    Time(f64),
    /// Time passes, or stands still.
    Play(bool),
    /// Another size in pixels, or that of the script.
    Size(Option<[u32; 2]>),
    /// What to work on first: column, row, width and height; or nothing in particular.
    Region(Option<[u32; 4]>),
}

/// Why a command is not obeyed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refused {
    /// There is no such thing.
    #[error("there is no {0} `{1}`")]
    Unknown(&'static str, String),
    /// A number makes no sense.
    #[error("{0} is not a number that makes sense there")]
    Number(&'static str),
    /// A parameter cannot have a value.
    #[error("`{0}` is {1}")]
    Unfit(String, Unfit),
    /// There is no picture yet.
    #[error("there is no picture yet")]
    Nothing,
}

/// Smallest and largest side of a picture that people watch.
const SIDES: [u32; 2] = [16, 8192];

/// Most pixels of one: some four gigabytes with all that is known of each.
pub(super) const LARGEST: u64 = 1 << 24;

impl Wish {
    /// How a picture of a given scene is to look: all but what needs the script to run, and what is to be worked on first.
    pub fn of_looks(&self) -> Wish {
        Wish { params: BTreeMap::new(), time: 0.0, playing: false, region: None, ..self.clone() }
    }

    /// Obeys a command, but for movements of the camera. `params` are those of the script.
    pub fn obey(&mut self, command: &Command, params: &[Param]) -> Result<(), Refused> {
        match command {
            Command::Set(values) => {
                for (name, value) in values {
                    let param = params.iter().find(|p| p.name == *name);
                    let param = param.ok_or_else(|| Refused::Unknown("parameter", name.clone()))?;
                    self.params.insert(name.clone(), meant(param, value)?);
                }
            }
            Command::Reset(None) => self.params.clear(),
            Command::Reset(Some(names)) => self.params.retain(|name, _| !names.contains(name)),
            Command::SnapBack => self.camera = None,
            Command::Caster(name) => {
                let found = Kind::ALL.iter().find(|(_, known)| known == name);
                self.caster = found.ok_or_else(|| Refused::Unknown("caster", name.clone()))?.0;
            }
            Command::Layer(layer) => self.layer = *layer,
            Command::Components(components) => self.components = *components,
            Command::Time(time) if time.is_finite() => self.time = *time,
            Command::Time(_) => return Err(Refused::Number("the time")),
            Command::Play(playing) => self.playing = *playing,
            Command::Size(size) => {
                let size = size.map(|s| s.map(|side| side.clamp(SIDES[0], SIDES[1])));
                if size.is_some_and(|[width, height]| u64::from(width) * u64::from(height) > LARGEST) {
                    return Err(Refused::Number("the size"));
                }
                // A region is a matter of pixels.
                (self.size, self.region) = (size, None);
            }
            Command::Region(region) => {
                self.region = region.map(|[x, y, width, height]| {
                    let [x, y] = [x, y].map(|at| at.min(Film::MAX_SIDE));
                    let [width, height] = [width, height].map(|side| side.clamp(1, Film::MAX_SIDE));
                    Rect { x, y, width, height }
                });
            }
            Command::Move(_) => {}
        }
        Ok(())
    }
}

/// The value that a parameter is to have: a number goes as far as it may.
fn meant(param: &Param, value: &Value) -> Result<Value, Refused> {
    match (&param.domain, value) {
        (Domain::Number { .. }, Value::Number(value)) if !value.is_finite() => {
            Err(Refused::Number("the value"))
        }
        (Domain::Number { least, most, whole }, Value::Number(value)) => {
            let value = if *whole { value.round() } else { *value };
            Ok(Value::Number(value.clamp(*least, *most)))
        }
        (domain, value) => domain.admit(value).map_err(|unfit| Refused::Unfit(param.name.clone(), unfit)),
    }
}

/// How far the picture is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// The script is being read.
    #[default]
    Reading,
    /// Coarse, and getting better.
    Drawing,
    /// As the script asks for it.
    Done,
    /// There is none; the last one stays.
    Failed,
}

/// What people are told.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Report {
    /// The script.
    pub script: String,
    /// Parameters, with the values that they have.
    pub params: Vec<Param>,
    /// What is wrong or odd.
    pub messages: Vec<Message>,
    /// What the script printed.
    pub output: Vec<String>,
    /// The call that makes the camera.
    pub camera: String,
    /// Whether the camera was moved.
    pub steered: bool,
    /// The caster.
    pub caster: &'static str,
    /// The layer.
    pub layer: Layer,
    /// Whether components have colours of their own.
    pub components: bool,
    /// How many components there are, and whether that is proven, where it was asked.
    pub parts: Option<(usize, bool)>,
    /// Animation time.
    pub time: f64,
    /// Whether it passes.
    pub playing: bool,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// What is worked on first.
    pub region: Option<[u32; 4]>,
    /// How far the picture is.
    pub stage: Stage,
    /// Share of the full picture that is there.
    pub progress: f64,
    /// Seconds until the first pixels were there.
    pub first: f64,
    /// Seconds until the full picture was there.
    pub whole: f64,
    /// Field evaluations for a pixel of the full picture.
    pub cost: f64,
    /// How often the script was read and right.
    pub revision: u64,
}

/// A diagnostic with the line that it is about.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Message {
    error: bool,
    message: String,
    label: Option<String>,
    hints: Vec<String>,
    file: Option<String>,
    line: u32,
    column: u32,
    width: u32,
    /// The text of the line.
    text: Option<String>,
}

impl Message {
    pub(super) fn new(diagnostic: &Diagnostic, sources: &Sources) -> Message {
        let Diagnostic { severity, message, place, label, hints, .. } = diagnostic.clone();
        let (line, column, width) = place.as_ref().map_or((0, 0, 0), |p| (p.line, p.column, p.width));
        let text = place.as_ref().and_then(|p| {
            let source = sources.get(&*p.file)?;
            source.lines().nth((p.line as usize).checked_sub(1)?).map(str::to_owned)
        });
        let file = place.map(|p| p.file.to_string());
        Message { error: severity == Severity::Error, message, label, hints, file, line, column, width, text }
    }
}
