//! The shape of the source, checked: who may import whom, how long a file may be, what library code
//! may not do. Rules that a machine checks need no reviewer.

use std::fs;
use std::path::{Path, PathBuf};

/// The layers of the design, lowest first. A module imports only from lower rows, never from a
/// sibling.
const ROWS: &[&[&str]] = &[
    &["num", "diag"],
    &["op", "noise", "grid", "shape", "flow", "world"],
    &["expr", "exchange"],
    &["tape", "scene"],
    &["field"],
    &["script", "cast", "topology", "mesh", "analysis"],
    &["render"],
    &["session"],
    &["cli"],
];

/// Lines that a file may have, not counting its unit tests.
const LONGEST: usize = 500;

/// What library code leaves to its callers: it returns errors, and neither prints nor exits.
const FORBIDDEN: &[&str] = &[
    ".unwrap()",
    ".expect(",
    "panic!",
    "todo!",
    "unimplemented!",
    "dbg!",
    "println!",
    "print!",
    "eprintln!",
    "eprint!",
    "process::exit",
    "process::abort",
];

/// Exceptions: file, what it may do, and why.
const ALLOWED: &[(&str, &str, &str)] = &[];

/// One source file.
struct Source {
    /// Path below `src/`.
    path: PathBuf,
    /// Everything but the unit tests, comments and the contents of strings blanked out.
    code: String,
    /// The text as it is, without the unit tests.
    text: String,
}

impl Source {
    fn read(root: &Path, path: &Path) -> Source {
        let full = fs::read_to_string(path).unwrap();
        let text = without_tests(&full).to_string();
        Source { path: path.strip_prefix(root).unwrap().to_path_buf(), code: blank(&text), text }
    }

    /// Whether the file is unit tests as a whole.
    fn is_tests(&self) -> bool {
        self.path.ends_with("tests.rs") || self.path.components().any(|c| c.as_os_str() == "tests")
    }

    /// The module of the table that the file belongs to; `None` for `lib.rs` and `main.rs`.
    fn module(&self) -> Option<String> {
        let first = self.path.components().next()?.as_os_str().to_str()?;
        let name = first.strip_suffix(".rs").unwrap_or(first);
        (!matches!(name, "lib" | "main")).then(|| name.to_string())
    }
}

fn sources() -> Vec<Source> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let (mut folders, mut found) = (vec![root.clone()], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                found.push(Source::read(&root, &path));
            }
        }
    }
    found.sort_by(|a, b| a.path.cmp(&b.path));
    found
}

/// The text before its trailing `#[cfg(test)] mod tests`.
fn without_tests(text: &str) -> &str {
    let start = text.match_indices("#[cfg(test)]").find(|(i, attribute)| {
        let next = text[i + attribute.len()..].trim_start();
        next.starts_with("mod ")
    });
    start.map_or(text, |(i, _)| &text[..i])
}

/// The text with comments and the contents of strings replaced by spaces; lines stay lines.
fn blank(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let opaque = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |i| i + 2)
        } else if let Some(hashes) = raw_string(rest) {
            let close = format!("\"{}", "#".repeat(hashes));
            let body = hashes + 2;
            rest[body..].find(&close).map_or(rest.len(), |i| body + i + close.len())
        } else if c == '"' {
            quoted(rest)
        } else if c == '\'' {
            character(rest)
        } else {
            0
        };
        let (piece, tail) = rest.split_at(opaque.max(c.len_utf8()));
        if opaque == 0 {
            out.push(c);
        } else {
            out.extend(piece.chars().map(|c| if c == '\n' { '\n' } else { ' ' }));
        }
        rest = tail;
    }
    out
}

/// Number of hashes if `text` starts with a raw string.
fn raw_string(text: &str) -> Option<usize> {
    let after = text.strip_prefix('r')?;
    let hashes = after.chars().take_while(|&c| c == '#').count();
    after[hashes..].starts_with('"').then_some(hashes)
}

/// Length of the string literal that `text` starts with.
fn quoted(text: &str) -> usize {
    let mut escaped = false;
    for (i, c) in text.char_indices().skip(1) {
        match c {
            '"' if !escaped => return i + 1,
            _ => escaped = c == '\\' && !escaped,
        }
    }
    text.len()
}

/// Length of the character literal that `text` starts with; 0 if it is a lifetime.
fn character(text: &str) -> usize {
    let body: Vec<char> = text.chars().skip(1).take(12).collect();
    let length = match body.as_slice() {
        ['\\', ..] => body.iter().skip(2).position(|&c| c == '\'').map(|i| i + 2),
        [_, '\'', ..] => Some(1),
        _ => None,
    };
    length.map_or(0, |n| 2 + body[..n].iter().map(|c| c.len_utf8()).sum::<usize>())
}

fn row(module: &str) -> Option<usize> {
    ROWS.iter().position(|row| row.contains(&module))
}

/// The modules that `code` names as `crate::module`, each with its line; groups are opened.
fn imports(code: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        let line = code[..at].matches('\n').count() + 1;
        let path = &code[at + "crate::".len()..];
        let names = match path.strip_prefix('{') {
            Some(group) => top_level(group),
            None => vec![path],
        };
        for name in names {
            let end = name.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(name.len());
            let is_macro = name[end..].starts_with('!');
            if end > 0 && !is_macro {
                found.push((line, name[..end].to_string()));
            }
        }
    }
    found
}

/// The entries of a `{...}` group whose opening brace is gone.
fn top_level(group: &str) -> Vec<&str> {
    let (mut depth, mut start, mut entries) = (0usize, 0, Vec::new());
    for (i, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth > 0 => depth -= 1,
            '}' | ',' if depth == 0 => {
                entries.push(group[start..i].trim());
                start = i + 1;
                if c == '}' {
                    break;
                }
            }
            _ => {}
        }
    }
    entries
}

/// Fails with all complaints at once.
fn report(complaints: Vec<String>) {
    assert!(complaints.is_empty(), "\n{}\n", complaints.join("\n"));
}

#[test]
fn imports_point_down() {
    let mut complaints = Vec::new();
    for source in sources() {
        let Some(module) = source.module() else { continue };
        let file = source.path.display();
        let Some(own) = row(&module) else {
            complaints.push(format!("src/{file}: the module `{module}` is in no row of the table"));
            continue;
        };
        for (line, name) in imports(&source.code) {
            if name == module || matches!(row(&name), Some(other) if other < own) {
                continue;
            }
            complaints.push(format!("src/{file}:{line}: `{module}` may not import `{name}`"));
        }
    }
    report(complaints);
}

#[test]
fn every_file_says_what_it_is() {
    let silent = sources().into_iter().filter(|s| !s.text.starts_with("//!"));
    report(silent.map(|s| format!("src/{}: starts without a `//!` comment", s.path.display())).collect());
}

#[test]
fn files_are_short() {
    let length = |s: &Source| s.text.lines().count();
    let long = sources().into_iter().filter(|s| length(s) > LONGEST);
    report(long.map(|s| format!("src/{}: {} lines", s.path.display(), length(&s))).collect());
}

#[test]
fn library_code_returns_errors() {
    let mut complaints = Vec::new();
    for source in sources() {
        if source.is_tests() || matches!(source.module().as_deref(), None | Some("cli")) {
            continue;
        }
        let file = source.path.to_string_lossy().replace('\\', "/");
        for (i, line) in source.code.lines().enumerate() {
            for what in FORBIDDEN.iter().filter(|what| contains_word(line, what)) {
                if !ALLOWED.iter().any(|(f, w, _)| *f == file && *w == *what) {
                    complaints.push(format!("src/{file}:{}: `{what}`", i + 1));
                }
            }
        }
    }
    report(complaints);
}

/// Whether `line` contains `what` at the start of a word: `panic!` is not in `my_panic!`.
fn contains_word(line: &str, what: &str) -> bool {
    line.match_indices(what).any(|(i, _)| {
        what.starts_with('.') || !line[..i].ends_with(|c: char| c.is_alphanumeric() || c == '_')
    })
}

#[test]
fn exceptions_are_needed_and_explained() {
    let sources = sources();
    let stale = ALLOWED.iter().filter(|(file, what, why)| {
        let used = sources.iter().any(|s| s.path == Path::new(file) && s.code.contains(what));
        !used || why.is_empty()
    });
    report(stale.map(|(file, what, _)| format!("src/{file} needs no exception for `{what}`")).collect());
}

#[test]
fn the_rules_see_through_comments_strings_and_groups() {
    let code =
        blank("a // crate::x\nuse crate::{num::{A, B}, op}; \"crate::y\" r#\"crate::z\"# '\"' 'a crate::w");
    let names: Vec<String> = imports(&code).into_iter().map(|(_, name)| name).collect();
    assert_eq!(names, ["num", "op", "w"]);
    assert_eq!(imports(&code)[0].0, 2);
    assert_eq!(without_tests("a\n#[cfg(test)]\nmod tests {}"), "a\n");
    assert!(contains_word("x.unwrap()", ".unwrap()") && !contains_word("eprint!()", "print!"));
}
