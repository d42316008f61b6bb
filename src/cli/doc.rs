//! `orogen doc`: the reference of the scripting language as Markdown, with a picture of everything
//! that can be seen.

use super::interrupt::Interrupt;
use super::progress::Progress;
use super::report::{Failure, Outcome, Terminal, err, out, plural};
use crate::diag::Diagnostic;
use crate::render::{self, Job, Metadata};
use crate::script::{self, Entry, Request, STD, help};
use crate::session::{self, Order};
use crate::world::atomic;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Explain a function, or write the reference of the scripting language
///
/// With NAME, says what that is: a function, a module such as fractal, or a word such as hurst.
/// Without, writes FOLDER/reference.md, which explains every function with an example, and a picture of
/// each example that can be seen to FOLDER/reference/.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  orogen doc fbm                 what fractal::fbm does, here
  orogen doc                     docs/reference.md and its pictures
  orogen doc -o site --text      only the text, in a second
  orogen doc --only cellular     the text, and the pictures of one name")]
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
    let only = args.only.as_deref().map(|name| pictured(&entries, name)).transpose()?;
    let text = args.output.join("reference.md");
    write(&text, page(&entries).as_bytes())?;
    let mut pictures = 0;
    if !args.text {
        pictures = draw_all(&entries, args, only.as_deref(), terminal)?;
    }
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
    match help::explain(entries, name).or_else(|| help::topic(entries, name)) {
        Some(text) => out(text.trim_end()),
        None => return Err(unknown(entries, name, &format!("nothing is called `{name}`"))),
    }
    Ok(())
}

/// The full name of what has a picture, which may be given without its module.
fn pictured(entries: &[Entry], name: &str) -> Result<String, Failure> {
    let seen = || entries.iter().filter(|e| is_seen(e));
    let found = seen().find(|e| e.name == name).or_else(|| seen().find(|e| help::short(e) == name));
    match found {
        Some(entry) => Ok(entry.name.clone()),
        None => {
            let seen: Vec<Entry> = seen().cloned().collect();
            Err(unknown(&seen, name, &format!("the reference has no picture of `{name}`")))
        }
    }
}

fn unknown(entries: &[Entry], name: &str, message: &str) -> Failure {
    let names: Vec<String> = entries.iter().map(|e| e.name.clone()).collect();
    let hint = match help::nearest(entries, &names, name) {
        Some(near) => format!("did you mean `{near}`?"),
        None => {
            "docs/reference.md has everything; pictures show noises, fractals, grids and solids".to_owned()
        }
    };
    Failure::usage(message, hint)
}

fn write(path: &Path, bytes: &[u8]) -> Outcome {
    atomic::write(path, |f| f.write_all(bytes)).map_err(|e| Diagnostic::error(e.to_string()))?;
    Ok(())
}

fn draw_all(entries: &[Entry], args: &Args, only: Option<&str>, terminal: &Terminal) -> Result<u64, Failure> {
    let folder = args.output.join("reference");
    std::fs::create_dir_all(&folder).map_err(|e| {
        Failure::error(
            format!("cannot create the folder {} ({e})", folder.display()),
            "choose another with -o",
        )
    })?;
    let wanted = |e: &&Entry| is_seen(e) && only.is_none_or(|only| only == e.name);
    let seen: Vec<&Entry> = entries.iter().filter(wanted).collect();
    let progress = Progress::new(terminal, &folder.display().to_string());
    let interrupt = Interrupt::listen(|| {});
    let flag = interrupt.flag();
    for (i, entry) in seen.iter().enumerate() {
        progress.set(i as f64 / seen.len() as f64);
        let path = folder.join(picture_name(entry));
        if !draw(entry, &path, &Job::unwatched(&flag))? {
            progress.finish();
            let message = format!("stopped after {}", plural(i as u64, "picture"));
            return Err(Failure::error(message, "start again, or make one with --only NAME"));
        }
    }
    progress.finish();
    Ok(seen.len() as u64)
}

/// Renders the picture of an entry; `false` if it was cancelled.
fn draw(entry: &Entry, path: &Path, job: &Job<'_>) -> Result<bool, Failure> {
    let text = scene(entry);
    let compiled = script::compile(&Request::text(text.clone()));
    let Some(scene) = compiled.scene else {
        let first = compiled.diagnostics.into_iter().next();
        return Err(first
            .unwrap_or_else(|| Diagnostic::error(format!("{} has no scene", entry.name)))
            .into());
    };
    let order = Order { size: Some((SIDE, SIDE)), samples: Some(4), ..Order::default() };
    let picture = session::render(&scene, &order, job).map_err(Failure::Error)?;
    if picture.finished {
        let metadata = Metadata { script: text, params: Vec::new() };
        render::save(path, &picture, &metadata).map_err(|e| Diagnostic::error(e.to_string()))?;
    }
    Ok(picture.finished)
}

/// Width and height of the pictures in pixels.
const SIDE: u32 = 240;

/// Headings whose examples are things to look at.
const SEEN: [&str; 16] = [
    "Polynomials",
    "Noise",
    "Grids",
    "std/algebraic",
    "std/arrange",
    "std/blend",
    "std/blobs",
    "std/convolution",
    "std/csg",
    "std/deform",
    "std/displace",
    "std/fractal",
    "std/morph",
    "std/shapes",
    "std/terrain",
    "std/warp",
];

/// Functions under those headings whose examples are numbers or settings.
const UNSEEN: [&str; 12] = [
    "stats",
    "bounds",
    "slope",
    "vector_noise",
    "with_mixed_colors",
    "field",
    "fractal::positive",
    "fractal::power",
    "terrain::ground",
    "terrain::alpine",
    "warp::fold_by_noise",
    "warp::fold_by_flow",
];

fn is_seen(entry: &Entry) -> bool {
    SEEN.contains(&entry.group.as_str())
        && !UNSEEN.contains(&entry.name.as_str())
        && !entry.example.is_empty()
}

/// The file name of an entry's picture; functions with options have one of their own.
fn picture_name(entry: &Entry) -> String {
    let arguments = entry.signature.matches(',').count() + 1;
    format!("{}-{arguments}.png", entry.name.replace("::", "-"))
}

/// A script that shows an example: solids as they are, noises in a ball with an octant cut away,
/// which shows both what they do to a surface and what they are inside.
fn scene(entry: &Entry) -> String {
    let imports: String = STD
        .iter()
        .filter(|(m, _)| *m == "color" || entry.example.contains(&format!("{m}::")))
        .map(|(m, _)| format!("import \"std/{m}\" as {m};\n"))
        .collect();
    let scaled = if entry.example.contains(".scaled(") { "" } else { ".scaled(2.5)" };
    format!(
        "{imports}let it = {};
switch type_of(it) {{
    \"Noise\" => {{
        let noise = it{scaled};
        let usual = noise.stats();
        let level = (noise - usual.mean) / sqrt(usual.variance);
        let cut = max(max(-x, -y), -z);
        let shades = [[-2.0, rgb(\"#12233f\")], [0.0, rgb(\"#7f8790\")], [2.0, rgb(\"#f6e6cc\")]];
        scene(#{{
            surface: difference(sphere(1.0) - 0.025 * level, cut).colored(color::ramp(level, shades)),
            camera: orbit(#{{ distance: 4.2, azimuth: 38.0, elevation: 26.0, fov: 32.0 }}),
            sun: sun(#{{ azimuth: 85.0, elevation: 48.0 }}),
        }})
    }},
    \"Grid\" => {{
        // Heights over their square, none of them towering.
        let half = 0.5 * it.extent.x;
        let flat = min(1.0, 0.5 * half / (it.high - it.low));
        scene(#{{
            surface: y - flat * it,
            bounds: [vec3(-half, flat * it.low - 0.2 * half, -half), vec3(half, flat * it.high + 0.01 * half, half)],
            camera: orbit(#{{ distance: 5.0 * half, azimuth: 35.0, elevation: 32.0, fov: 34.0 }}),
            sun: sun(#{{ azimuth: 110.0, elevation: 30.0, strength: 3.5 }}),
        }})
    }},
    _ => it,
}}
",
        entry.example
    )
}

/// The whole reference.
fn page(entries: &[Entry]) -> String {
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
         of other `std/...` modules need an import, such as `import \"std/fractal\" as fractal;`.\n\n",
    );
    for group in &groups {
        page += &format!("- [{group}](#{})\n", anchor(group));
    }
    for group in groups {
        page += &format!("\n## {group}\n");
        for entry in entries.iter().filter(|e| e.group == group) {
            page += &section(entry);
        }
    }
    page
}

fn section(entry: &Entry) -> String {
    let mut text = format!("\n### `{}`\n\n{}\n", entry.signature, entry.doc.trim());
    if !entry.example.is_empty() {
        text += &format!("\n```rhai\n{}\n```\n", entry.example);
    }
    if is_seen(entry) {
        text += &format!("\n![{}](reference/{})\n", entry.name, picture_name(entry));
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
    use std::collections::BTreeSet;

    #[test]
    fn every_picture_has_a_name_of_its_own_and_a_scene() {
        let entries = script::reference();
        let seen: Vec<&Entry> = entries.iter().filter(|e| is_seen(e)).collect();
        let names: BTreeSet<String> = seen.iter().map(|e| picture_name(e)).collect();
        assert_eq!(names.len(), seen.len());
        for entry in seen {
            let compiled = script::compile(&Request::text(scene(entry)));
            assert!(compiled.scene.is_some(), "{}: {:?}", entry.name, compiled.diagnostics);
        }
        assert!(UNSEEN.iter().all(|name| entries.iter().any(|e| e.name == *name)));
    }

    #[test]
    fn headings_are_found() {
        assert_eq!(anchor("std/fractal"), "stdfractal");
        assert_eq!(anchor("Two words"), "two-words");
    }
}
