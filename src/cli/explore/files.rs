//! `orogen explore --headless`: pictures in a folder, with a page that shows them and their values as JSON.

use super::super::folder::Folder;
use super::super::interrupt::Interrupt;
use super::super::progress::Progress;
use super::super::report::{Failure, Outcome, Terminal, err, plural};
use super::told::{Told, settings};
use super::{Args, Beginning, begin};
use crate::diag::Diagnostic;
use crate::scene::Value;
use crate::session::Order;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

/// The look of the page, which is that of the served one.
const STYLE: &str = include_str!("page/style.css");

/// Runs the command.
pub fn run(args: &Args, folder: &Path, terminal: &Terminal) -> Outcome {
    let progress = Progress::new(terminal, &args.script.display().to_string());
    let flag = Interrupt::stopping(&progress).flag();
    let mut files = Folder::new(folder)?;
    let Beginning { subject, gallery, size } = begin(args, terminal, Some(&progress), &flag)?;
    let order = Order { size: Some(size), samples: Some(1), ..Order::default() };
    let told = Told::new(args, &subject, &gallery, size);
    let mut figures = String::new();
    let mut failed = 0;
    for (id, genome) in (0..).map_while(|id| Some((id, gallery.genome(id)?))) {
        let values = &genome.values;
        match subject.draw(&genome, &order, &flag) {
            Ok(Some(png)) => {
                files.write(&id.to_string(), "png", &progress, |file| file.write_all(&png))?;
                figures += &figure(&told, id, values, None);
            }
            _ if flag.load(std::sync::atomic::Ordering::SeqCst) => {
                return Err(Failure::error("stopped before all was done", files.account()));
            }
            Ok(None) => {}
            Err(error) => {
                failed += 1;
                progress.say(&format!("picture {id} cannot be made:{}: {}", settings(values), error.message));
                figures += &figure(&told, id, values, Some(&error.message));
            }
        }
        progress.set((id + 1) as f64 / gallery.specimens.len() as f64);
    }
    let text = serde_json::to_string_pretty(&told)
        .map_err(|e| Diagnostic::error(format!("cannot write the gallery ({e})")))?;
    files.write("gallery", "json", &progress, |file| writeln!(file, "{text}"))?;
    files.write("index", "html", &progress, |file| file.write_all(page(&told, &figures).as_bytes()))?;
    progress.finish();
    let made = plural((gallery.specimens.len() - failed) as u64, "picture");
    err(format_args!("{}: {made} in {}", args.script.display(), folder.display()));
    Ok(())
}

/// The page around the figures.
fn page(told: &Told<'_>, figures: &str) -> String {
    let script = escaped(&told.script);
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"dark light\">\n<title>{script}</title>\n<style>\n{STYLE}</style>\n</head>\n\
         <body class=\"still\">\n<main id=\"stage\">\n<h1>{script}</h1>\n<div id=\"grid\">\n{figures}</div>\n</main>\n</body>\n</html>\n"
    )
}

/// A picture with the command that makes it, or with what is wrong with it.
fn figure(told: &Told<'_>, id: usize, values: &BTreeMap<String, Value>, fault: Option<&str>) -> String {
    let (width, height) = told.size;
    let command = escaped(&format!("{}{}", told.command, settings(values)));
    let (state, picture) = match fault {
        None => (
            "drawn",
            format!(
                "<a class=\"picture\" href=\"{id}.png\"><img src=\"{id}.png\" width=\"{width}\" height=\"{height}\" alt=\"picture {id}\"></a>"
            ),
        ),
        Some(message) => ("failed", format!("<p class=\"fault\">{}</p>", escaped(message))),
    };
    format!(
        "<figure class=\"specimen {state}\">{picture}<figcaption><b>{id}</b></figcaption><code>{command}</code></figure>\n"
    )
}

/// A text as HTML has it.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
