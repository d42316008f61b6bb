//! `orogen doc`: the reference of the scripting language as Markdown, with a picture of everything
//! that can be seen.

mod thumbnail;

use super::interrupt::Interrupt;
use super::progress::Progress;
use super::report::{Failure, Outcome, Terminal, err, out, plural};
use crate::diag::Diagnostic;
use crate::render::Job;
use crate::script::{self, Entry, help};
use crate::world::atomic;
use std::io::Write;
use std::path::{Path, PathBuf};
use thumbnail::Thumbnail;

/// Explain a function, or write the reference of the scripting language
///
/// With NAME, says what that is: a function, a name such as p, a module such as fractal, or a word such as hurst.
/// Without, writes FOLDER/reference.md, which explains every function with an example, and a picture of
/// each example that can be seen to FOLDER/reference/.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  orogen doc fbm                 what fractal::fbm does, here
  orogen doc                     docs/reference.md and its pictures
  orogen doc -o site --text      only the text, in seconds
  orogen doc --only cellular     only the pictures of one name")]
pub struct Args {
    /// What to explain; nothing is written then
    #[arg(value_name = "NAME", conflicts_with_all = ["output", "text", "only"])]
    name: Option<String>,

    /// Folder to write to, which must exist
    #[arg(short, long, value_name = "FOLDER", default_value = "docs")]
    output: PathBuf,

    /// Writes no pictures
    #[arg(long)]
    text: bool,

    /// Makes the pictures of one function alone
    #[arg(long, value_name = "NAME", conflicts_with = "text")]
    only: Option<String>,
}

/// Runs the command.
pub fn run(args: &Args, terminal: &Terminal) -> Outcome {
    let entries = script::reference();
    if let Some(name) = &args.name {
        return explain(&entries, name);
    }
    let folder = args.output.join("reference");
    if let Some(name) = &args.only {
        let pictures = draw_all(&pictured(&entries, name)?, &folder, terminal)?;
        err(format_args!("{}: {}", folder.display(), plural(pictures, "picture")));
        return Ok(());
    }
    let text = args.output.join("reference.md");
    // Before it takes its time to find out what can be seen.
    atomic::check(&text).map_err(|e| Diagnostic::error(e.to_string()))?;
    let thumbnails = thumbnail::all(entries.iter());
    write(&text, page(&entries, &thumbnails).as_bytes())?;
    let pictures = if args.text { 0 } else { draw_all(&thumbnails, &folder, terminal)? };
    err(format_args!(
        "{}: {}, {}",
        text.display(),
        plural(entries.len() as u64, "function"),
        plural(pictures, "picture")
    ));
    Ok(())
}

/// Says on the terminal what a name means.
fn explain(entries: &[Entry], name: &str) -> Outcome {
    let input = || help::input(name).map(str::to_owned);
    match help::explain(entries, name).or_else(input).or_else(|| help::topic(entries, name)) {
        Some(text) => out(text.trim_end()),
        None => return Err(unknown(entries, name, &format!("nothing is called `{name}`"))),
    }
    Ok(())
}

/// The pictures of a name, which may be given without its module.
fn pictured<'a>(entries: &'a [Entry], name: &str) -> Result<Vec<Thumbnail<'a>>, Failure> {
    let exact = entries.iter().find(|e| e.name == name);
    let found = exact.or_else(|| entries.iter().find(|e| help::short(e) == name));
    let thumbnails = found.map(|found| thumbnail::all(entries.iter().filter(|e| e.name == found.name)));
    thumbnails
        .filter(|thumbnails| !thumbnails.is_empty())
        .ok_or_else(|| unknown(entries, name, &format!("the reference has no picture of `{name}`")))
}

fn unknown(entries: &[Entry], name: &str, message: &str) -> Failure {
    let names: Vec<String> = entries.iter().map(|e| e.name.clone()).collect();
    let hint = match (help::elsewhere(name), help::nearest(entries, &names, name)) {
        (Some(here), _) => format!("here that is {here}"),
        (None, Some(near)) => format!("did you mean `{near}`?"),
        (None, None) => "docs/reference.md has everything; pictures show what can be seen".to_owned(),
    };
    Failure::usage(message, hint)
}

fn write(path: &Path, bytes: &[u8]) -> Outcome {
    atomic::write(path, |f| f.write_all(bytes)).map_err(|e| Diagnostic::error(e.to_string()))?;
    Ok(())
}

fn draw_all(thumbnails: &[Thumbnail<'_>], folder: &Path, terminal: &Terminal) -> Result<u64, Failure> {
    std::fs::create_dir_all(folder).map_err(|e| {
        Failure::error(
            format!("cannot create the folder {} ({e})", folder.display()),
            "choose another with -o",
        )
    })?;
    let progress = Progress::new(terminal, &folder.display().to_string());
    let interrupt = Interrupt::stopping(&progress);
    let flag = interrupt.flag();
    for (i, thumbnail) in thumbnails.iter().enumerate() {
        progress.set(i as f64 / thumbnails.len() as f64);
        if !thumbnail.draw(&folder.join(thumbnail.file_name()), &Job::unwatched(&flag))? {
            progress.finish();
            let message = format!("stopped after {}", plural(i as u64, "picture"));
            return Err(Failure::error(message, "start again, or make one with --only NAME"));
        }
    }
    progress.finish();
    Ok(thumbnails.len() as u64)
}

/// The whole reference.
fn page(entries: &[Entry], thumbnails: &[Thumbnail<'_>]) -> String {
    let mut groups: Vec<&str> = Vec::new();
    for entry in entries {
        if !groups.contains(&entry.group.as_str()) {
            groups.push(&entry.group);
        }
    }
    let mut page = String::from(
        "# Reference\n\n\
         Every function of the scripting language. `orogen doc` writes this page; in the REPL,\n\
         `:help NAME` shows a part of it. Functions of `std/shapes` and `std/csg` are always there; those\n\
         of other `std/...` modules need an import, such as `import \"std/fractal\" as fractal;`.\n\n\
         Besides, `x`, `y` and `z` are the coordinates of the place as fields, and `p` is all three; `time` is the time\n\
         of the picture or of its frame in seconds, a field that is the same everywhere; `PI` and `TAU` are numbers.\n\n",
    );
    for group in &groups {
        page += &format!("- [{group}](#{})\n", anchor(group));
    }
    for group in groups {
        page += &format!("\n## {group}\n");
        for entry in entries.iter().filter(|e| e.group == group) {
            page += &section(entry, thumbnails.iter().find(|t| std::ptr::eq(t.entry, entry)));
        }
    }
    page
}

fn section(entry: &Entry, thumbnail: Option<&Thumbnail<'_>>) -> String {
    let mut text =
        format!("\n### `{}`\n\n{}\n\n```rhai\n{}\n```\n", entry.signature, entry.doc.trim(), entry.example);
    if let Some(thumbnail) = thumbnail {
        text += &format!("\n![{}](reference/{})\n", entry.name, thumbnail.file_name());
    }
    text
}

/// The link target that Markdown gives a heading.
fn anchor(heading: &str) -> String {
    heading
        .to_lowercase()
        .chars()
        .filter(|c| c.is_alphanumeric() || *c == '-' || *c == ' ')
        .collect::<String>()
        .replace(' ', "-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_are_found() {
        assert_eq!(anchor("std/fractal"), "stdfractal");
        assert_eq!(anchor("Two words"), "two-words");
    }
}
