//! What is told of a gallery, to pages and programs.

use super::super::report::{quoted, word};
use super::Args;
use crate::scene::Value;
use crate::session::explore::{Gallery, Subject};
use serde::Serialize;
use std::collections::BTreeMap;

/// A gallery, and what it is of.
#[derive(Serialize)]
pub struct Told<'a> {
    /// The script.
    pub script: String,
    /// What its copies are named after.
    pub name: String,
    /// The command that renders it, but for the parameters that vary.
    pub command: String,
    /// The options of that command.
    pub options: String,
    /// Width and height of small pictures.
    pub size: (u32, u32),
    /// Whether copies of the script have to stay beside it.
    pub company: bool,
    /// The parameters that do not vary.
    pub fixed: BTreeMap<String, Value>,
    #[serde(flatten)]
    pub gallery: &'a Gallery,
}

impl<'a> Told<'a> {
    /// About the gallery of a command.
    pub fn new(args: &Args, subject: &Subject, gallery: &'a Gallery, size: (u32, u32)) -> Told<'a> {
        let name = args.script.file_stem().unwrap_or("script".as_ref()).to_string_lossy().into_owned();
        Told {
            script: args.script.display().to_string(),
            name,
            command: format!("orogen render {}{}", quoted(&args.script), options(args, subject)),
            options: options(args, subject),
            size,
            company: subject.has_company(),
            fixed: subject.fixed(),
            gallery,
        }
    }
}

/// What renders the script at the time and with the parameters that are fixed.
fn options(args: &Args, subject: &Subject) -> String {
    let time =
        if args.scripting.time == 0.0 { String::new() } else { format!(" --time {:?}", args.scripting.time) };
    time + settings(&subject.fixed()).as_str()
}

/// Parameters as options of the command line.
pub fn settings(values: &BTreeMap<String, Value>) -> String {
    values.iter().map(|(name, value)| format!(" --set {name}={}", word(&value.to_string()))).collect()
}
