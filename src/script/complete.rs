//! What can be typed next: names that begin like a word, methods after a dot, the options of a call.
//!
//! Everything follows from the text before the cursor and from the reference, in whose sentences the options of
//! a function are listed: as lines `- name: ...`, or in a sentence `Options: name (...), ...`. A function that
//! says `Options as of other` has those of the other.

use super::help;
use super::lexer::{self, Kind, Token};
use super::library::Entry;
use super::modules;

/// A way to go on.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Candidate {
    /// What takes the place of the word before the cursor.
    pub text: String,
    /// How it is called, or what it is.
    pub signature: String,
    /// What it means, in a sentence; may be empty.
    pub about: String,
}

/// Ways to go on.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Completion {
    /// Where the word starts that is to be replaced, in bytes.
    pub start: usize,
    /// The ways, in alphabetical order.
    pub candidates: Vec<Candidate>,
    /// Whether a text is open, in which a file may be named.
    pub in_text: bool,
}

/// What is known of a session.
pub struct Known<'a> {
    /// The reference.
    pub entries: &'a [Entry],
    /// What the session itself has named, and the words of the language.
    pub others: Vec<Candidate>,
    /// Names under which modules of the standard library were imported, with those modules.
    pub aliases: &'a [(String, String)],
    /// Names under which the user's own modules were imported, with their functions.
    pub own: &'a [(String, Vec<Entry>)],
}

impl<'a> Known<'a> {
    /// How a text that ends at the cursor can go on.
    pub fn complete(&self, text: &str) -> Completion {
        let all = lexer::tokens(text);
        if all.last().is_some_and(|t| t.kind == Kind::Comment && (!t.closed || t.end() == text.len())) {
            return Completion { start: text.len(), ..Completion::default() };
        }
        let tokens: Vec<Token<'_>> = all.into_iter().filter(|t| t.kind != Kind::Comment).collect();
        if let Some(open) = tokens.last().filter(|t| t.kind == Kind::Text && !t.closed) {
            return in_text(open, &tokens);
        }
        let is_word = |t: &&Token<'_>| t.kind == Kind::Word && t.end() == text.len();
        let word = tokens.last().filter(is_word).map_or("", |t| t.text);
        let before = &tokens[..tokens.len() - usize::from(!word.is_empty())];
        let start = text.len() - word.len();
        let mut candidates = match before {
            [.., a, b] if a.text == ":" && b.text == ":" && a.end() == b.start => {
                let module = before.len().checked_sub(3).map_or("", |i| before[i].text);
                self.members(module, word)
            }
            [rest @ .., dot] if dot.text == "." && rest.last().is_none_or(|t| t.text != ".") => {
                self.methods(word)
            }
            _ => match options_of(before) {
                Some(call) => self.options(&call, word),
                None if word.is_empty() => Vec::new(),
                None => self.names(word),
            },
        };
        candidates.sort_by(|a, b| (&a.text, &a.signature).cmp(&(&b.text, &b.signature)));
        candidates.dedup();
        Completion { start, candidates, in_text: false }
    }

    /// What the innermost call at the end of a text wants: its signatures.
    pub fn signatures(&self, text: &str) -> Vec<&'a Entry> {
        let tokens = lexer::code(text);
        let call = lexer::open_brackets(&tokens).into_iter().rev().find_map(|i| called(&tokens, i));
        call.map_or(Vec::new(), |name| self.entries_of(&name))
    }

    /// The entries of a name, which may have a module in front of it by the name that it was imported under.
    fn entries_of(&self, name: &str) -> Vec<&'a Entry> {
        if let Some(own) = name.split_once("::").and_then(|(alias, _)| self.own_module(alias)) {
            return own.iter().filter(|e| e.name == name).collect();
        }
        let full = match name.split_once("::") {
            Some((alias, rest)) => format!("{}::{rest}", self.module(alias)),
            None => name.to_owned(),
        };
        self.entries.iter().filter(|e| e.name == full).collect()
    }

    /// The module behind a name.
    fn module<'b>(&'b self, alias: &'b str) -> &'b str {
        self.aliases.iter().rev().find(|(name, _)| name == alias).map_or(alias, |(_, module)| module)
    }

    /// Functions of a module of the user's.
    fn own_module(&self, alias: &str) -> Option<&'a [Entry]> {
        self.own.iter().find(|(name, _)| name == alias).map(|(_, entries)| &entries[..])
    }

    fn names(&self, word: &str) -> Vec<Candidate> {
        let modules = modules::STD.iter().map(|(name, _)| *name);
        let modules = modules.filter(|name| name.starts_with(word) && !modules::PRELUDE.contains(name));
        let entries = self.entries.iter().filter(|e| e.name.starts_with(word) && !e.name.contains("::"));
        let mut found: Vec<Candidate> = entries.map(|e| candidate(e, &e.name, &e.signature)).collect();
        found.extend(self.others.iter().filter(|c| c.text.starts_with(word)).cloned());
        let own = self.own.iter().filter(|(alias, _)| alias.starts_with(word));
        found.extend(own.map(|(alias, _)| Candidate {
            text: format!("{alias}::"),
            signature: format!("{alias}::"),
            about: "a module of yours".to_owned(),
        }));
        found.extend(modules.map(|name| Candidate {
            text: format!("{name}::"),
            signature: format!("{name}::"),
            about: format!("the module std/{name}"),
        }));
        found
    }

    /// Functions of a module.
    fn members(&self, alias: &str, word: &str) -> Vec<Candidate> {
        let (start, entries) = match self.own_module(alias) {
            Some(own) => (format!("{alias}::{word}"), own),
            None => (format!("{}::{word}", self.module(alias)), self.entries),
        };
        let entries = entries.iter().filter(|e| e.name.starts_with(&start));
        entries.map(|e| candidate(e, help::short(e), &e.signature)).collect()
    }

    /// Functions of at least one argument, which is the one in front of the dot.
    fn methods(&self, word: &str) -> Vec<Candidate> {
        let callable = |e: &&Entry| e.name.starts_with(word) && !e.name.contains("::");
        let method = |e: &Entry| {
            let (name, rest) = e.signature.split_once('(')?;
            let is_name = name.starts_with(|c: char| c.is_alphabetic());
            let (first, others) = rest.split_once(", ").unwrap_or((rest.split_once(')')?.0, ")"));
            let wanted = is_name && name == e.name && !first.is_empty();
            wanted.then(|| candidate(e, &e.name, &format!(".{name}({}", others)))
        };
        self.entries.iter().filter(callable).filter_map(method).collect()
    }

    /// Options of a call.
    fn options(&self, call: &str, word: &str) -> Vec<Candidate> {
        let mut found = Vec::new();
        for entry in self.entries_of(call) {
            self.collect_options(entry, 0, &mut found);
        }
        let candidate =
            |(key, about): (String, String)| Candidate { text: format!("{key}: "), signature: key, about };
        found.into_iter().filter(|(key, _)| key.starts_with(word)).map(candidate).collect()
    }

    fn collect_options(&self, entry: &Entry, depth: usize, found: &mut Vec<(String, String)>) {
        for (key, about) in listed(&entry.doc) {
            if !found.iter().any(|(known, _)| *known == key) {
                found.push((key, about));
            }
        }
        if let Some((_, rest)) = entry.doc.split_once("ptions as of ").filter(|_| depth < 4) {
            let name = rest.trim_start_matches('`');
            let end = name.find(|c: char| !(c.is_alphanumeric() || matches!(c, '_' | ':')));
            for other in self.entries_of(&name[..end.unwrap_or(name.len())]) {
                self.collect_options(other, depth + 1, found);
            }
        }
    }
}

fn candidate(entry: &Entry, text: &str, signature: &str) -> Candidate {
    Candidate { text: text.to_owned(), signature: signature.to_owned(), about: help::sentence(&entry.doc) }
}

/// Within a text: after `import` the modules that there are.
fn in_text(open: &Token<'_>, tokens: &[Token<'_>]) -> Completion {
    let imports = tokens.len() >= 2 && tokens[tokens.len() - 2].text == "import";
    let start = open.start + 1;
    let typed = &open.text[1..];
    let names = modules::STD.iter().map(|(name, _)| format!("std/{name}"));
    let module = |text: String| Candidate { signature: text.clone(), text, about: String::new() };
    let candidates: Vec<Candidate> =
        names.filter(|name| imports && name.starts_with(typed)).map(module).collect();
    Completion { start, in_text: candidates.is_empty(), candidates }
}

/// The call whose options stand where the tokens end: `name(..., #{ key: value,`.
fn options_of(before: &[Token<'_>]) -> Option<String> {
    let last = before.last()?;
    let open = lexer::open_brackets(before);
    let (&brace, outer) = open.split_last()?;
    let is_map = before[brace].text == "{" && brace > 0 && before[brace - 1].text == "#";
    (is_map && matches!(last.text, "{" | ",")).then(|| called(before, *outer.last()?)).flatten()
}

/// The function that a bracket calls.
fn called(tokens: &[Token<'_>], bracket: usize) -> Option<String> {
    let name = tokens[..bracket].last().filter(|t| t.kind == Kind::Word)?;
    (tokens[bracket].text == "(").then_some(())?;
    match &tokens[..bracket - 1] {
        [.., module, a, b] if a.text == ":" && b.text == ":" => {
            Some(format!("{}::{}", module.text, name.text))
        }
        _ => Some(name.text.to_owned()),
    }
}

/// The options that a documentation lists.
fn listed(doc: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    for line in doc.lines().filter_map(|line| line.strip_prefix("- ")) {
        let Some((keys, about)) = line.split_once(": ") else { continue };
        found
            .extend(keys.split(", ").filter(|key| is_key(key)).map(|key| (key.to_owned(), about.to_owned())));
    }
    if let Some((_, rest)) = doc.split_once("Options: ").filter(|_| found.is_empty()) {
        for item in items(rest) {
            let end = item.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(item.len());
            let (key, about) = item.split_at(end);
            if is_key(key) {
                found.push((key.to_owned(), about.trim().to_owned()));
            }
        }
    }
    found
}

fn is_key(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|c| c.is_alphanumeric() || c == '_')
}

/// What commas part in the first sentence of a text, but for those within brackets.
fn items(text: &str) -> Vec<&str> {
    let (mut depth, mut start, mut found) = (0i32, 0, Vec::new());
    for (i, c) in text.char_indices() {
        match c {
            '(' | '[' => depth += 1,
            ')' | ']' => depth -= 1,
            ',' if depth == 0 => {
                found.push(text[start..i].trim());
                start = i + 1;
            }
            '.' if depth == 0 => {
                found.push(text[start..i].trim());
                return found;
            }
            _ => {}
        }
    }
    found.push(text[start..].trim());
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::script::entries_of;

    fn with<T>(ask: impl FnOnce(&Known<'_>) -> T) -> T {
        let aliases = [("fr".to_owned(), "fractal".to_owned())];
        let mine =
            Candidate { text: "spherical".into(), signature: "spherical".into(), about: "mine".into() };
        let functions = lexer::functions("/// Land.\nfn ground(height) { height }");
        let own = [("planet".to_owned(), entries_of("planet", functions, ""))];
        ask(&Known { entries: &crate::script::reference(), others: vec![mine], aliases: &aliases, own: &own })
    }

    fn texts(text: &str) -> Vec<String> {
        with(|known| known.complete(text).candidates.into_iter().map(|c| c.text).collect())
    }

    #[test]
    fn names_begin_like_the_word() {
        let found = with(|known| known.complete("let f = spher"));
        assert_eq!(found.start, 8);
        assert!(found.candidates.iter().any(|c| c.signature == "sphere(radius)" && !c.about.is_empty()));
        assert!(found.candidates.iter().any(|c| c.about == "mine"));
        assert!(texts("fract").contains(&"fractal::".to_owned()));
        for nothing in ["", "let f = ", "// spher", "/* spher"] {
            assert_eq!(texts(nothing), [""; 0], "{nothing}");
        }
    }

    #[test]
    fn modules_methods_and_options_are_known() {
        assert_eq!(texts("fractal::ridg"), ["ridged"; 2]);
        assert_eq!(texts("fr::ridg"), ["ridged"; 2]);
        assert!(texts("fractal::").len() > 5);
        let methods = with(|known| known.complete("sphere(1.0).ran").candidates);
        assert!(methods.iter().any(|c| c.text == "range" && c.signature == ".range(box)"), "{methods:?}");
        assert_eq!(texts("octave_sum(gradient(7), \"fbm\", #{ lac"), ["lacunarity: "]);
        assert_eq!(texts("fr::fbm(gradient(7), #{ octaves: 3, hu"), ["hurst: "]);
        assert!(texts("blobs::blobs([], #{ ").contains(&"threshold: ".to_owned()));
        assert!(texts("film(#{ ").contains(&"height: ".to_owned()));
        // A value is no key.
        assert!(!texts("film(#{ width: hei").contains(&"height: ".to_owned()));
    }

    #[test]
    fn modules_of_ones_own_hide_those_of_the_library() {
        assert_eq!(texts("planet::"), ["ground"]);
        assert!(texts("plane").contains(&"planet::".to_owned()));
        let wanted = with(|known| known.signatures("planet::ground(").iter().map(|e| e.doc.clone()).next());
        assert_eq!(wanted.as_deref(), Some("Land."));
    }

    #[test]
    fn texts_name_modules_and_files() {
        assert_eq!(texts("import \"std/frac"), ["std/fractal"]);
        let file = with(|known| known.complete("mesh(\"roc"));
        assert!(file.in_text && file.candidates.is_empty());
        assert_eq!(file.start, 6);
    }

    #[test]
    fn calls_say_what_they_want() {
        let of = |text: &str| {
            with(|known| known.signatures(text).iter().map(|e| e.signature.clone()).collect::<Vec<_>>())
        };
        assert_eq!(of("sphere("), ["sphere(radius)"]);
        assert_eq!(of("fr::ridged(gradient(7), #{ octaves: "), of("fractal::ridged("));
        assert!(of("1 + 2").is_empty() && of("sphere(1.0)").is_empty());
    }
}
