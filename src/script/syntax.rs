//! What the words of a script are, for those who colour it.

use super::engine::{INPUTS, KEYWORDS};
use super::lexer::{self, Kind};
use std::ops::Range;

/// What a piece of a script is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Role {
    /// A word of the language itself, such as `let`.
    Keyword,
    /// The name of a function, where it is called or made.
    Function,
    /// What a field is of: the point, its coordinates, the time; and the numbers that have names.
    Input,
    /// Another name.
    Name,
    /// A number.
    Number,
    /// A text with its quotes.
    Text,
    /// A comment.
    Comment,
    /// A character of an operator, or a bracket.
    Symbol,
}

/// The pieces of a text with their places in it, in bytes; what is between them is blank.
pub fn roles(text: &str) -> Vec<(Range<usize>, Role)> {
    let tokens = lexer::tokens(text);
    let mut found = Vec::with_capacity(tokens.len());
    for (i, token) in tokens.iter().enumerate() {
        let next = tokens.get(i + 1).map_or("", |t| t.text);
        let role = match token.kind {
            Kind::Word => word(token.text, next),
            Kind::Number => Role::Number,
            Kind::Text => Role::Text,
            Kind::Comment => Role::Comment,
            Kind::Symbol => Role::Symbol,
        };
        found.push((token.start..token.end(), role));
    }
    found
}

fn word(word: &str, next: &str) -> Role {
    match word {
        _ if KEYWORDS.contains(&word) => Role::Keyword,
        _ if next == "(" => Role::Function,
        "p" | "PI" | "TAU" => Role::Input,
        _ if INPUTS.iter().any(|(name, _)| *name == word) => Role::Input,
        _ => Role::Name,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_told_apart() {
        let text = "let f = fractal::fbm(x, \"é\", 1.5); // é";
        let of = |piece: &str| {
            let at = text.find(piece).unwrap();
            roles(text)
                .into_iter()
                .find(|(range, _)| range.start == at)
                .map(|(range, role)| (&text[range], role))
        };
        assert_eq!(of("let"), Some(("let", Role::Keyword)));
        assert_eq!(of("f ="), Some(("f", Role::Name)));
        assert_eq!(of("fbm"), Some(("fbm", Role::Function)));
        assert_eq!(of("x,"), Some(("x", Role::Input)));
        assert_eq!(of("\"é\""), Some(("\"é\"", Role::Text)));
        assert_eq!(of("1.5"), Some(("1.5", Role::Number)));
        assert_eq!(of("// é"), Some(("// é", Role::Comment)));
        assert_eq!(of("("), Some(("(", Role::Symbol)));
    }
}
