//! The variables that an input gives values to.

use crate::script::lexer::{self, Kind, Token};

/// Names that statements outside of all blocks make or set, in their order.
pub fn named(text: &str) -> Vec<&str> {
    let tokens = lexer::code(text);
    let (mut depth, mut starts, mut found) = (0i32, true, Vec::new());
    for (i, token) in tokens.iter().enumerate() {
        if starts && depth == 0 {
            found.extend(set_by(&tokens[i..]));
        }
        match token.text {
            "(" | "{" | "[" => depth += 1,
            ")" | "}" | "]" => depth -= 1,
            _ => {}
        }
        starts = matches!(token.text, ";" | "}" | "export");
    }
    found
}

/// The name that a statement makes or sets, if it does.
fn set_by<'a>(statement: &[Token<'a>]) -> Option<&'a str> {
    let (first, rest) = statement.split_first()?;
    if matches!(first.text, "let" | "const") {
        return rest.first().map(|name| name.text);
    }
    // As in `+=` and `**=`; `==`, `<=` and the like compare.
    let operator = rest.iter().take_while(|t| matches!(t.text, "+" | "-" | "*" | "/" | "%")).count();
    let sign = |i: usize| rest.get(i).is_some_and(|t| t.text == "=");
    (first.kind == Kind::Word && sign(operator) && !sign(operator + 1)).then_some(first.text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_statements() {
        assert_eq!(named("let f = sphere(1.0); const g = 2; f + g"), ["f", "g"]);
        assert_eq!(named("f = 1; g += 2; h **= 3; // i = 4\nexport let j = 5"), ["f", "g", "h", "j"]);
        assert_eq!(named("fn f() { let a = 1; a } if f() > 0 { b = 2; } c = 3"), ["c"]);
        assert_eq!(named("a == b; a <= b; a != b; a - b; \"x = 1\"; f(|q| q = 1); m.a = 2; ="), [""; 0]);
        assert_eq!(named("let"), [""; 0]);
    }
}
