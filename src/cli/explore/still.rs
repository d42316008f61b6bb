//! The page that `--headless` writes: nothing but pictures with their values and commands, so that it needs no server.

use super::super::report::plural;
use super::told::{Told, settings};
use crate::scene::{Domain, Value};
use std::collections::BTreeMap;

/// The look of the page, which is that of the served one.
const STYLE: &str = include_str!("page/style.css");

/// The page around the figures.
pub fn page(told: &Told<'_>, figures: &str) -> String {
    let script = escaped(&told.script);
    let (pictures, seed) = (plural(told.gallery.specimens.len() as u64, "picture"), told.gallery.seed);
    let axes = plural(told.gallery.space().axes.len() as u64, "parameter");
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"dark light\">\n<title>{script} – orogen explore</title>\n\
         <link rel=\"icon\" href=\"data:,\">\n<style>\n{STYLE}</style>\n</head>\n\
         <body class=\"still\">\n<main id=\"stage\">\n<header><h1>{script}</h1>\n\
         <p class=\"soft\">{pictures}, {axes}, seed {seed}. A click on a command selects all of it; \
         <a href=\"gallery.json\">gallery.json</a> has all values.</p></header>\n\
         <div id=\"grid\">\n{figures}</div>\n</main>\n</body>\n</html>\n"
    )
}

/// A picture with its values and the command that makes it, or with what is wrong with it.
pub fn figure(told: &Told<'_>, id: usize, values: &BTreeMap<String, Value>, fault: Option<&str>) -> String {
    let (width, height) = told.size;
    let command = escaped(&format!("{}{}", told.command, settings(values)));
    let list: String =
        told.gallery.space().axes.iter().map(|axis| entry(&axis.name, &axis.domain, values)).collect();
    let about = if id == 0 { "<span>the script as it is</span>" } else { "" };
    let (state, picture) = match fault {
        None => (
            "drawn",
            format!(
                "<a class=\"picture\" href=\"{id}.png\"><img src=\"{id}.png\" width=\"{width}\" height=\"{height}\" alt=\"picture {id}\"></a>"
            ),
        ),
        Some(message) => (
            "failed",
            format!(
                "<div class=\"picture\" style=\"aspect-ratio: {width} / {height}\"><p class=\"fault\">{}</p></div>",
                escaped(message)
            ),
        ),
    };
    format!(
        "<figure class=\"specimen {state}\">{picture}<figcaption><b>{id}</b>{about}</figcaption>\
         <dl>{list}</dl><code title=\"{command}\">{command}</code></figure>\n"
    )
}

/// The value of a parameter; beside that of a colour, the colour.
fn entry(name: &str, domain: &Domain, values: &BTreeMap<String, Value>) -> String {
    let value = values.get(name).map_or_else(String::new, |value| escaped(&value.to_string()));
    let swatch = match domain {
        Domain::Color => format!("<i style=\"background: {value}\"></i>"),
        _ => String::new(),
    };
    format!("<dt>{}</dt><dd>{swatch}{value}</dd>", escaped(name))
}

/// A text as HTML has it.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
