//! Diagnostics as text, with an excerpt of the source.

use super::{Diagnostic, Place, Severity, Sources};
use ariadne::{CharSet, Color, Config, IndexType, Label, Report, ReportKind, Source};
use std::fmt::Write;

/// The diagnostic as text that ends in a newline; with terminal colours if `color`.
pub fn render(diagnostic: &Diagnostic, sources: &Sources, color: bool) -> String {
    let mut out = match excerpt(diagnostic, sources, color) {
        Some(text) => text,
        None => plain(diagnostic),
    };
    for (what, place) in &diagnostic.trace {
        // Writing to a string cannot fail.
        let _ = writeln!(out, "   {what} at {}:{}:{}", place.file, place.line, place.column);
    }
    out
}

fn plain(d: &Diagnostic) -> String {
    let kind = match d.severity {
        Severity::Error => "Error",
        Severity::Warning => "Warning",
    };
    let mut out = format!("{kind}: {}\n", d.message);
    if let Some(place) = &d.place {
        let _ = match place.line {
            0 => writeln!(out, "   in {}", place.file),
            line => writeln!(out, "   in {}:{line}:{}", place.file, place.column),
        };
        if let Some(label) = &d.label {
            let _ = writeln!(out, "   {label}");
        }
    }
    for hint in &d.hints {
        let _ = writeln!(out, "   Help: {hint}");
    }
    out
}

/// Longest line that is shown, in bytes. What nobody wrote by hand nobody wants to read, several times over.
const LONGEST: usize = 1000;

fn excerpt(d: &Diagnostic, sources: &Sources, color: bool) -> Option<String> {
    let place = d.place.as_ref()?;
    let text = sources.get(&place.file)?;
    let start = offset(text, place)?;
    let before = text[..start].rfind('\n').map_or(start, |end| start - end);
    let after = text[start..].find('\n').unwrap_or(text.len() - start);
    if before + after > LONGEST {
        return None;
    }
    let left = text[start..].lines().next().map_or(0, |rest| rest.chars().count());
    let width = text[start..]
        .chars()
        .take((place.width.max(1) as usize).min(left.max(1)))
        .map(char::len_utf8)
        .sum::<usize>();
    let span = (place.file.to_string(), start..start + width);
    let (kind, tint) = match d.severity {
        Severity::Error => (ReportKind::Error, Color::Red),
        Severity::Warning => (ReportKind::Warning, Color::Yellow),
    };
    let charset = if color { CharSet::Unicode } else { CharSet::Ascii };
    let config = Config::new().with_color(color).with_char_set(charset).with_index_type(IndexType::Byte);
    // A label without text would not be drawn, nor the caret with it.
    let label = Label::new(span.clone()).with_color(tint).with_message(d.label.as_deref().unwrap_or("here"));
    let mut report = Report::build(kind, span).with_config(config).with_message(&d.message).with_label(label);
    for hint in &d.hints {
        report.add_help(hint);
    }
    let mut out = Vec::new();
    let cache = (place.file.to_string(), Source::from(text.to_string()));
    report.finish().write(cache, &mut out).ok()?;
    String::from_utf8(out).ok()
}

/// Byte offset of a place.
fn offset(text: &str, place: &Place) -> Option<usize> {
    let line = text.split_inclusive('\n').nth((place.line as usize).checked_sub(1)?)?;
    let start = line.as_ptr() as usize - text.as_ptr() as usize;
    let column = place.column.saturating_sub(1) as usize;
    let body = line.trim_end_matches(['\n', '\r']);
    Some(start + body.char_indices().nth(column).map_or(body.len(), |(i, _)| i))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_are_not_shown() {
        let told = |length: usize| {
            let text = format!("\n{}y2\n", "x".repeat(length));
            let place = Place { file: "a.rhai".into(), line: 2, column: length as u32 + 1, width: 2 };
            let diagnostic = Diagnostic::error("no such name").at(place).hint("write y");
            render(&diagnostic, &Sources::from([("a.rhai".into(), text.into())]), false)
        };
        assert!(told(100).contains("xxy2"));
        assert_eq!(told(1000), "Error: no such name\n   in a.rhai:2:1001\n   Help: write y\n");
    }
}
