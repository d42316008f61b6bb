//! What names and words mean, for the REPL and for `orogen doc NAME`: the reference, searched.

use super::library::Entry;
use super::modules;
use super::synonyms;
use crate::diag;

/// Columns of a page on a terminal.
const WIDTH: usize = 96;
/// Columns at its left that stay free, at most.
const INDENT: usize = 6;
/// A word that more functions than these speak of says nothing.
const MOST: usize = 30;

/// What a name means: signatures, sentences, an example. `fbm` finds `fractal::fbm` too.
pub fn explain(entries: &[Entry], name: &str) -> Option<String> {
    let found = entries.iter().filter(|e| e.name == name || short(e) == name);
    let text: String = found.map(section).collect();
    (!text.is_empty()).then_some(text)
}

/// What there is under a heading or in a module, or where a word is spoken of.
pub fn topic(entries: &[Entry], word: &str) -> Option<String> {
    let is_heading = |e: &&Entry| {
        let module = e.group.strip_prefix("std/").unwrap_or(&e.group);
        module.eq_ignore_ascii_case(word) || e.group == word
    };
    let under: Vec<&Entry> = entries.iter().filter(is_heading).collect();
    if let Some(first) = under.first() {
        let line = |e: &&Entry| line(e, sentence(&e.doc));
        let text: String = under.iter().map(line).collect();
        return Some(format!("{}\n{text}", heading(&first.group)));
    }
    let spoken: Vec<&Entry> = entries.iter().filter(|e| speaks_of(e, word)).collect();
    let few = (1..=MOST).contains(&spoken.len()) && word.chars().count() >= 3;
    let line = |e: &&Entry| {
        // An option is explained where it is listed.
        let listed = e.doc.lines().find(|line| line.starts_with("- ") && has_word(line, word));
        line(e, listed.map_or_else(|| sentence(&e.doc), str::to_owned))
    };
    few.then(|| {
        let text: String = spoken.iter().map(line).collect();
        format!("`{word}` is a word in the documentation of\n{text}")
    })
}

/// What a name stands for that every script has.
pub fn input(name: &str) -> Option<&'static str> {
    Some(match name {
        "x" => "x: the first coordinate of the point, as a field\n",
        "y" => "y: the second coordinate of the point, as a field; it grows upwards\n",
        "z" => "z: the third coordinate of the point, as a field; it grows towards the viewer\n",
        "p" => "p: the point (x, y, z), as a vector of fields\n",
        "time" => "time: the time of an animation in seconds, as a field\n",
        "PI" => "PI: 3.14159...\n",
        "TAU" => "TAU: 2 PI\n",
        _ => return None,
    })
}

/// What to write for a function that is called so elsewhere.
pub fn elsewhere(name: &str) -> Option<&'static str> {
    synonyms::function(name)
}

/// The name that is meant by one that is nothing's. Names of the standard library need not be
/// written with their module to be near.
pub fn nearest<'a>(entries: &'a [Entry], others: &'a [String], name: &str) -> Option<&'a str> {
    let shorts = entries.iter().filter(|e| e.name.contains("::"));
    let shorts = shorts.map(|e| (short(e), e.name.as_str()));
    // What needs no module is meant first.
    let all: Vec<(&str, &str)> = others.iter().map(|n| (n.as_str(), n.as_str())).chain(shorts).collect();
    let near = diag::nearest(name, all.iter().map(|(said, _)| *said))?;
    all.iter().find(|(said, _)| *said == near).map(|(_, full)| *full)
}

/// The name without its module.
pub fn short(entry: &Entry) -> &str {
    entry.name.rsplit("::").next().unwrap_or(&entry.name)
}

fn section(entry: &Entry) -> String {
    let mut out = format!("{}\n", entry.signature);
    for line in entry.doc.lines() {
        out += &paragraph(line);
    }
    if !entry.example.is_empty() {
        out += &format!("\n    {}\n", entry.example.replace('\n', "\n    "));
    }
    out + "\n"
}

/// A module says itself what it is for, in its first comment.
fn heading(group: &str) -> String {
    let Some(module) = group.strip_prefix("std/") else { return group.to_owned() };
    let text = modules::STD.iter().find(|(name, _)| *name == module).map_or("", |(_, text)| text);
    let comment: Vec<&str> = text.lines().map_while(|line| line.strip_prefix("// ")).collect();
    let import = match modules::PRELUDE.contains(&module) {
        true => String::new(),
        false => format!(" It needs import \"{group}\" as {module};"),
    };
    format!("{group}: {}{import}", comment.join(" ").trim_end())
}

/// A function with something about it.
fn line(entry: &Entry, about: String) -> String {
    format!("  {}\n{}", entry.signature, paragraph(&about))
}

/// The first sentence of a documentation.
pub fn sentence(doc: &str) -> String {
    let words: Vec<&str> = doc.lines().take_while(|line| !line.is_empty()).collect();
    let text = words.join(" ");
    match text.split_once(". ") {
        Some((first, _)) => format!("{first}."),
        None => text,
    }
}

/// A text in lines that fit a screen, with some room on their left.
pub fn wrapped(text: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.last().map_or(0, |line| line.chars().count());
        if last > 0 && last + 1 + word.chars().count() > WIDTH - INDENT {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            *line += if line.is_empty() { "" } else { " " };
            *line += word;
        }
    }
    lines.retain(|line| !line.is_empty());
    lines
}

/// A line of a documentation in lines of a screen's width, indented; entries of a list a little more.
fn paragraph(text: &str) -> String {
    let hanging = if text.starts_with("- ") { "      " } else { "    " };
    let lines = wrapped(text);
    if lines.is_empty() {
        return "\n".to_owned();
    }
    let line = |(i, line): (usize, &String)| format!("{}{line}\n", if i == 0 { "    " } else { hanging });
    lines.iter().enumerate().map(line).collect()
}

fn speaks_of(entry: &Entry, word: &str) -> bool {
    has_word(&entry.doc, word) || has_word(&entry.signature, word)
}

fn has_word(text: &str, word: &str) -> bool {
    text.split(|c: char| !c.is_alphanumeric() && c != '_').any(|w| w.eq_ignore_ascii_case(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries() -> Vec<Entry> {
        crate::script::reference()
    }

    #[test]
    fn names_headings_and_words_are_found() {
        let all = entries();
        assert!(explain(&all, "ridged").is_some_and(|t| t.starts_with("fractal::ridged(")));
        assert!(explain(&all, "hurst").is_none());
        for word in ["fractal", "std/fractal", "warp", "noise", "hurst", "csg"] {
            assert!(topic(&all, word).is_some(), "{word}");
        }
        assert!(topic(&all, "fractal").is_some_and(|t| t.contains("import \"std/fractal\" as fractal;")));
        assert!(topic(&all, "hurst").is_some_and(|t| t.contains("octave_sum(")));
        assert!(topic(&all, "the").is_none() && topic(&all, "zzz").is_none());
    }

    #[test]
    fn std_names_are_near_without_their_module() {
        let all = entries();
        let names: Vec<String> = all.iter().map(|e| e.name.clone()).collect();
        assert_eq!(nearest(&all, &names, "ridgd"), Some("fractal::ridged"));
        assert_eq!(nearest(&all, &names, "sphre"), Some("sphere"));
    }

    #[test]
    fn pages_fit_a_terminal_and_keep_their_lists() {
        let text = explain(&entries(), "cellular").unwrap();
        assert!(text.lines().all(|l| l.chars().count() <= WIDTH), "{text}");
        assert!(text.contains("\n    - norm: "), "{text}");
    }
}
