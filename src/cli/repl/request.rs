//! What stands behind `:plot` and `:slice`: expressions, and small words that tell where to look.
//!
//! Only words outside of all brackets count, so that an expression may be anything.

use crate::diag::Diagnostic;
use crate::script::{Role, roles};
use std::path::{Path, PathBuf};

/// A word or sign outside of brackets: where it starts and ends.
type Piece<'a> = (usize, usize, &'a str);

/// What `:plot` is asked for.
#[derive(Clone, PartialEq, Debug)]
pub struct Plot<'a> {
    /// The functions.
    pub functions: Vec<&'a str>,
    /// The variable that they are drawn against, if it is one.
    pub variable: Option<&'a str>,
    /// From where to where.
    pub ends: (&'a str, &'a str),
    /// The file that it goes to.
    pub file: Option<PathBuf>,
}

/// What `:slice` is asked for.
#[derive(Clone, PartialEq, Debug)]
pub struct Slice<'a> {
    /// The field, if it is not the last one.
    pub field: Option<&'a str>,
    /// The axis that the plane is across, and where.
    pub plane: Option<(usize, &'a str)>,
    /// What is shown of it: up to a distance, or from a place to another.
    pub window: Option<(&'a str, Option<&'a str>)>,
    /// The file that it goes to.
    pub file: Option<PathBuf>,
}

/// Reads what stands behind `:plot`.
///
/// # Errors
/// What is missing, with an example.
pub fn plot(text: &str) -> Result<Plot<'_>, Box<Diagnostic>> {
    let (text, file) = file(text)?;
    let example = "for example: :plot f along [0, 0, 0]..[2, 0, 0], or :plot f along x=-2..2";
    let wrong = |what: &str| Box::new(Diagnostic::error(what).hint(example));
    let all = pieces(text);
    let along =
        all.iter().rfind(|p| p.2 == "along").ok_or_else(|| wrong("`:plot` needs `along FROM..TO`"))?;
    let mut commas = vec![0];
    for piece in all.iter().filter(|p| p.2 == "," && p.1 <= along.0) {
        commas.extend([piece.0, piece.1]);
    }
    commas.push(along.0);
    let functions: Vec<&str> = commas.chunks_exact(2).map(|ends| text[ends[0]..ends[1]].trim()).collect();
    if functions.iter().any(|f| f.is_empty()) {
        return Err(wrong("a function is missing before `along`"));
    }
    let line = &text[along.1..];
    let (variable, range) = match assignment(line) {
        Some((name, _, after)) if line[..name.0].trim().is_empty() => (Some(name.2), &line[after..]),
        _ => (None, line),
    };
    let ends = range_of(range).ok_or_else(|| wrong("`along` needs two ends, FROM..TO"))?;
    Ok(Plot { functions, variable, ends, file })
}

/// Reads what stands behind `:slice`.
///
/// # Errors
/// What is wrong, with an example.
pub fn slice(text: &str) -> Result<Slice<'_>, Box<Diagnostic>> {
    let (text, file) = file(text)?;
    let wrong = |what: String| {
        Box::new(Diagnostic::error(what).hint("for example: :slice f z=0, or :slice f y=0.5 in 1.5"))
    };
    let all = pieces(text);
    let (rest, window) = match all.iter().rfind(|p| p.2 == "in") {
        Some(piece) => (&text[..piece.0], Some(text[piece.1..].trim())),
        None => (text, None),
    };
    if window.is_some_and(str::is_empty) {
        return Err(wrong("`in` needs a size, or LOW..HIGH".to_owned()));
    }
    let (field, plane) = match assignment(rest) {
        None => (rest, None),
        Some((name, _, after)) => {
            let axis = ["x", "y", "z"].iter().position(|axis| *axis == name.2);
            let axis = axis.ok_or_else(|| wrong(format!("a plane is across x, y or z, not `{}`", name.2)))?;
            let place = rest[after..].trim();
            if place.is_empty() {
                return Err(wrong(format!("there is no number after `{}=`", name.2)));
            }
            (&rest[..name.0], Some((axis, place)))
        }
    };
    let field = Some(field.trim()).filter(|field| !field.is_empty());
    let window = window.map(|w| range_of(w).map_or((w, None), |(low, high)| (low, Some(high))));
    Ok(Slice { field, plane, window, file })
}

/// The words and signs outside of brackets.
fn pieces(text: &str) -> Vec<Piece<'_>> {
    let mut depth = 0i32;
    let mut found = Vec::new();
    for (range, role) in roles(text) {
        let piece = &text[range.clone()];
        match piece {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            _ if depth == 0 && !matches!(role, Role::Text | Role::Comment) => {
                found.push((range.start, range.end, piece));
            }
            _ => {}
        }
    }
    found
}

/// The last `NAME =` that is no comparison: the name, and where the sign starts and ends.
fn assignment(text: &str) -> Option<(Piece<'_>, usize, usize)> {
    let all = pieces(text);
    let is_sign = |p: &Piece<'_>| p.2 == "=";
    (1..all.len()).rev().find_map(|i| {
        let (name, sign) = (all[i - 1], all[i]);
        let is_name = name.2.starts_with(|c: char| c.is_alphabetic());
        let compares = all.get(i + 1).is_some_and(|next| is_sign(next) && next.0 == sign.1);
        (is_sign(&sign) && is_name && !compares).then_some((name, sign.0, sign.1))
    })
}

/// Both ends of `FROM..TO`.
fn range_of(text: &str) -> Option<(&str, &str)> {
    let all = pieces(text);
    let dots = all.windows(2).find(|p| p[0].2 == "." && p[1].2 == "." && p[0].1 == p[1].0)?;
    let (low, high) = (text[..dots[0].0].trim(), text[dots[1].1..].trim());
    (!low.is_empty() && !high.is_empty()).then_some((low, high))
}

/// Takes `to FILE` from the end.
fn file(text: &str) -> Result<(&str, Option<PathBuf>), Box<Diagnostic>> {
    let Some(&(start, end, _)) = pieces(text).iter().rfind(|p| p.2 == "to") else { return Ok((text, None)) };
    let path = Path::new(text[end..].trim().trim_matches('"'));
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png")) {
        return Ok((&text[..start], Some(path.to_path_buf())));
    }
    let error = Diagnostic::error("a figure is written as .png");
    Err(Box::new(error.hint(format!("for example: to {}", path.with_extension("png").display()))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plots_are_read() {
        let read = plot("f, max(g, h).at(p) along [0, 0, 0]..[1, 2, 3] to a b.png").unwrap();
        assert_eq!(read.functions, ["f", "max(g, h).at(p)"]);
        assert_eq!((read.variable, read.ends), (None, ("[0, 0, 0]", "[1, 2, 3]")));
        assert_eq!(read.file, Some("a b.png".into()));
        let read = plot("sin(x) along x = -2..2.5").unwrap();
        assert_eq!((read.variable, read.ends, read.file), (Some("x"), ("-2", "2.5"), None));
        for (bad, piece) in [
            ("", "along"),
            ("f", "along"),
            ("along x=0..1", "missing"),
            ("f, along x=0..1", "missing"),
            ("f along", "two ends"),
            ("f along x=1", "two ends"),
            ("f along 1..", "two ends"),
            ("f along x=0..1 to a.gif", ".png"),
        ] {
            let error = plot(bad).unwrap_err();
            assert!(error.message.contains(piece) && !error.hints.is_empty(), "{bad}: {}", error.message);
        }
    }

    #[test]
    fn slices_are_read() {
        let read = slice("max(f, box([1, 1, 1])) z=-0.5 in 2").unwrap();
        assert_eq!(read.field, Some("max(f, box([1, 1, 1]))"));
        assert_eq!((read.plane, read.window), (Some((2, "-0.5")), Some(("2", None))));
        assert_eq!(slice("").unwrap(), Slice { field: None, plane: None, window: None, file: None });
        assert_eq!(slice("y = 1 to s.PNG").unwrap().file, Some("s.PNG".into()));
        assert_eq!(slice("f in 0.25..1").unwrap().window, Some(("0.25", Some("1"))));
        assert_eq!(slice("if a == 1 { f } else { g }").unwrap().plane, None);
        for (bad, piece) in [("f w=0", "`w`"), ("f z=", "no number"), ("f in", "size"), ("f to s", ".png")] {
            let error = slice(bad).unwrap_err();
            assert!(error.message.contains(piece) && !error.hints.is_empty(), "{bad}: {}", error.message);
        }
    }
}
