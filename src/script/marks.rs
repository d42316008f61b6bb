//! Names of functions kept apart: what a module calls is its own, or the library's.
//!
//! The engine finds a function by its name and the number of its arguments, and remembers what it found, whoever asked.
//! Where a script and a module, or two modules, have functions of the same name, one would be given that of the other;
//! and a function of a module that was found from within would be called from without as if it had no module around it,
//! and not see what is private there. So no two modules may have a function of the same name. Before a module is compiled,
//! its functions are *marked*, where they are defined and where they are called: the first character of the name becomes
//! one that no script has, a different one for each module. Lines and columns stay as they are.
//! Others call such a function by a second one with the plain name, on a line after the last. Functions that use `this`
//! cannot be called by others, and are left as they are.
//!
//! So are marked the calls of functions that need no import, native ones too, which have a second name with a mark: what a
//! script defines by the name of one of these is its own, and nothing of the library changes.

use super::lexer::{Definition, Kind, Token, closing, code, definitions};
use std::collections::HashMap;
use std::fmt::Write;

/// The characters that names may begin with.
const FIRST: &str = "_ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz";

/// The first character of marked names: ideographs so rare that no script has them.
const MARKS: u32 = 0x20000;

/// Modules for which there are enough.
const MODULES: usize = 0xa6d0 / FIRST.len();

/// A function by its name and number of arguments.
pub type Function = (String, usize);

/// The number of what is not written in the language. Modules begin after it.
pub const NATIVE: usize = 0;

/// Functions that are marked, and the module that they are of.
#[derive(Clone, Default, Debug)]
pub struct Marks(HashMap<Function, usize>);

/// A name with the mark of a module; none of an operator, of a name that begins with a letter which few scripts have, and
/// where there are no more marks.
pub fn marked(name: &str, module: usize) -> Option<String> {
    let mut rest = name.chars();
    let place = rest.next().and_then(|first| FIRST.find(first)).filter(|_| module < MODULES)?;
    let mark = char::from_u32(MARKS + (module * FIRST.len() + place) as u32)?;
    Some(format!("{mark}{}", rest.as_str()))
}

/// A message about names as scripts have them.
pub fn plain(text: &str) -> String {
    let of = |c: char| {
        let place = (c as u32).checked_sub(MARKS).map(|n| n as usize).filter(|n| *n < MODULES * FIRST.len());
        place.and_then(|n| FIRST.chars().nth(n % FIRST.len())).unwrap_or(c)
    };
    text.chars().map(of).collect()
}

/// How many arguments there are between brackets.
fn arguments(tokens: &[Token<'_>], open: usize) -> Option<usize> {
    let close = closing(tokens, open)?;
    let (mut count, mut i) = (usize::from(close > open + 1), open + 1);
    while i < close {
        match tokens[i].text {
            "(" | "{" | "[" => i = closing(tokens, i)?,
            // Parameters of a function without a name.
            "|" if matches!(tokens[i - 1].text, "(" | ",") => {
                i += 1 + tokens[i + 1..close].iter().position(|t| t.text == "|")?;
            }
            "," if i + 1 < close => count += 1,
            _ => {}
        }
        i += 1;
    }
    Some(count)
}

/// The functions that a text defines, with names for a module of this number; but for those that cannot be marked.
fn markable(text: &str, module: usize) -> impl Iterator<Item = (Definition, String)> {
    let of = move |own: Definition| {
        let name = marked(&own.name, module).filter(|_| !own.uses_this)?;
        Some((own, name))
    };
    definitions(text).into_iter().filter_map(of)
}

/// The function of a definition.
fn function(own: &Definition) -> Function {
    (own.name.clone(), own.parameters.len())
}

impl Marks {
    /// Takes native functions in, which are known by their marked names as well.
    pub fn learn_native(&mut self, functions: impl IntoIterator<Item = Function>) {
        self.0.extend(functions.into_iter().map(|function| (function, NATIVE)));
    }

    /// Takes the functions of a module in.
    pub fn learn(&mut self, text: &str, module: usize) {
        self.0.extend(markable(text, module).map(|(own, _)| (function(&own), module)));
    }

    /// The text of a module with its functions marked, and those that are marked already. When others call one, something is
    /// done first.
    pub fn put(&self, text: &str, module: usize, first: impl Fn(&Definition) -> String) -> String {
        let mut marks = self.clone();
        // What it defines itself and cannot be marked is not that of another.
        for own in definitions(text) {
            marks.0.remove(&function(&own));
        }
        marks.learn(text, module);
        // A text that ends too soon is said to on the line after its last.
        let mut out = marks.marked_text(text) + "\n";
        for (own, name) in markable(text, module) {
            let parameters = own.parameters.join(", ");
            let private = if own.is_private { "private " } else { "" };
            let first = first(&own);
            let _ = write!(out, "\n{private}fn {}({parameters}) {{ {first}{name}({parameters}) }}", own.name);
        }
        out
    }

    fn marked_text(&self, text: &str) -> String {
        let tokens = code(text);
        let (mut out, mut done) = (String::with_capacity(text.len()), 0);
        for (i, token) in tokens.iter().enumerate() {
            let is_private = token.text == "private" && self.is_marked(&tokens, i + 2);
            let replaced = match token.kind {
                Kind::Text => self.in_text(token.text, i > 1 && tokens[i - 2].text == "Fn"),
                // Nobody else knows the marked name, and others must find it.
                Kind::Word if is_private => Some(" ".repeat(token.text.len())),
                Kind::Word => self.module_of(&tokens, i).and_then(|module| marked(token.text, module)),
                _ => None,
            };
            if let Some(replaced) = replaced {
                out += &text[done..token.start];
                out += &replaced;
                done = token.end();
            }
        }
        out + &text[done..]
    }

    fn is_marked(&self, tokens: &[Token<'_>], i: usize) -> bool {
        tokens.get(i).is_some_and(|token| token.kind == Kind::Word) && self.module_of(tokens, i).is_some()
    }

    /// The module of the function that is called or defined at a token, if it is marked.
    fn module_of(&self, tokens: &[Token<'_>], i: usize) -> Option<usize> {
        let before = |n: usize| i.checked_sub(n).map_or("", |place| tokens[place].text);
        // One colon alone stands before the value of a key.
        let is_named_otherwise = before(1) == "." || before(1) == ":" && before(2) == ":";
        if is_named_otherwise || tokens.get(i + 1)?.text != "(" {
            return None;
        }
        self.0.get(&(tokens[i].text.to_owned(), arguments(tokens, i + 1)?)).copied()
    }

    /// A text with the expressions in it marked, or with the name that it is.
    fn in_text(&self, text: &str, is_name: bool) -> Option<String> {
        if is_name {
            let name = text.trim_matches(['"', '`']);
            let mut modules = self.0.iter().filter(|((own, _), _)| own == name).map(|(_, module)| *module);
            let module = modules.next()?;
            // With other arguments it may be of another module.
            let is_one = modules.all(|other| other == module);
            return marked(name, module).filter(|_| is_one).map(|marked| text.replacen(name, &marked, 1));
        }
        let (before, rest) = text.strip_prefix('`').and_then(|inner| inner.split_once("${"))?;
        // Brackets may be in brackets.
        let inner = format!("{{{rest}");
        let tokens = code(&inner);
        let end = tokens[closing(&tokens, 0)?].start;
        let after = format!("`{}", &inner[end..]);
        let after = self.in_text(&after, false).unwrap_or(after);
        Some(format!("`{before}${}{}", self.marked_text(&inner[..end]), &after[1..]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(text: &str) -> String {
        let marked = Marks::default().put(text, 7, |_| String::new());
        assert!(plain(&marked).starts_with(text) || text.contains("private"));
        marked.chars().map(|c| if c as u32 >= MARKS { '*' } else { c }).collect()
    }

    #[test]
    fn what_is_defined_is_marked_where_it_is_called() {
        let text =
            "fn half(a) { low(a, |i, j| i) / 2 }\nprivate fn low(a, b) { a.half() + m::half(a) + half }";
        let all =
            "fn *alf(a) { *ow(a, |i, j| i) / 2 }\n        fn *ow(a, b) { a.half() + m::half(a) + half }";
        let others = "\n\nfn half(a) { *alf(a) }\nprivate fn low(a, b) { *ow(a, b) }";
        assert_eq!(shown(text), format!("{all}{others}"));
    }

    #[test]
    fn texts_are_marked_within() {
        let text =
            "fn f(a) { `f(1) ${f(a) + #{b: f(2)}.b} and ${f( [1, 2] )}` + \"f(1)\" + Fn(\"f\").call(1) }";
        let all =
            "fn *(a) { `f(1) ${*(a) + #{b: *(2)}.b} and ${*( [1, 2] )}` + \"f(1)\" + Fn(\"*\").call(1) }";
        assert_eq!(shown(text), format!("{all}\n\nfn f(a) {{ *(a) }}"));
    }

    #[test]
    fn other_functions_stay() {
        for text in [
            "fn f(a) { this + f(a) }",
            "f(1) + g(2)",
            "let f = 1; fn int.f(a) { f }",
            "fn f(a) {",
            "fn ärmel(a) { ärmel(a) }",
        ] {
            assert_eq!(shown(text), format!("{text}\n"));
        }
        assert_eq!(
            shown("fn f(a, /* b, c */ d,) { f(1, 2) }"),
            "fn *(a, /* b, c */ d,) { *(1, 2) }\n\nfn f(a, d) { *(a, d) }"
        );
        // A function by the same name with other arguments is another.
        assert_eq!(shown("fn f(a) { f(a, 1,) + f() }"), "fn *(a) { f(a, 1,) + f() }\n\nfn f(a) { *(a) }");
    }

    #[test]
    fn modules_have_marks_of_their_own() {
        let names: std::collections::HashSet<String> = (0..MODULES)
            .flat_map(|module| FIRST.chars().map(move |c| marked(&c.to_string(), module)))
            .flatten()
            .collect();
        assert_eq!(names.len(), MODULES * FIRST.len());
        assert!(names.iter().all(|name| plain(name).len() == 1 && FIRST.contains(&plain(name))));
        assert_eq!(
            [marked("f", MODULES), marked("ä", 1), marked("+", 1), marked("", 1)],
            [const { None }; 4]
        );
    }
}
