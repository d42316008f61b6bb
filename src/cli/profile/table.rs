//! A profile for people: tables with bars, and hints.

use crate::cli::report::{Terminal, out};
use crate::session::Line;
use crate::session::profile::{Bound, Cost, Hint, Profile};
use std::path::Path;

/// Characters of a bar that is full,
const BAR: usize = 10;

/// and those that are shown of a line of a script.
const TEXT: usize = 56;

/// Characters in a line of a hint.
const WIDE: usize = 92;

/// Shares that are not worth a row.
const LEAST: f64 = 5e-4;

/// How a profile is shown.
pub struct Table<'a> {
    script: &'a Path,
    top: usize,
    terminal: &'a Terminal,
}

impl<'a> Table<'a> {
    /// With no more than so many lines of a script in each table.
    pub fn new(script: &'a Path, top: usize, terminal: &'a Terminal) -> Self {
        Table { script, top, terminal }
    }

    /// Prints it.
    pub fn print(&self, profile: &Profile) {
        let evaluations = format!("{:.1} evaluations a ray", profile.evaluations);
        self.cost("solid", &evaluations, "an evaluation", &profile.solid);
        if let Some(shading) = &profile.shading {
            self.cost("colours, material", "one evaluation a point", "a point", shading);
        }
        self.bound(&profile.bound);
        profile.hints.iter().for_each(|hint| self.hint(hint));
    }

    fn cost(&self, title: &str, often: &str, what: &str, cost: &Cost) {
        out(format!("{}  {:.0} ns {what}, {often}", self.terminal.bold(title), cost.nanoseconds));
        let width = self.width(cost.lines.iter().map(|line| &line.line));
        let rows = self.rows(cost.lines.iter().map(|line| line.share));
        for line in cost.lines.iter().take(rows) {
            let parts: Vec<&str> = line.what.iter().take(2).map(String::as_str).collect();
            let more = if line.what.len() > 2 { ", ..." } else { "" };
            let aside = self.terminal.dim(format_args!("{}{more}", parts.join(", ")));
            out(self.row(line.share, &line.line, width, &aside));
        }
        self.rest(cost.lines.iter().map(|line| line.share));
    }

    fn bound(&self, bound: &Bound) {
        let title = self.terminal.bold("bound of the slope");
        if bound.lines.is_empty() {
            out(format!("{title}  there is none near the surface\n"));
            return;
        }
        out(format!(
            "{title}  {} on average, {} at most; in samples {}, {:.1} times less",
            number(bound.mean),
            number(bound.most),
            number(bound.steepest),
            bound.looseness(),
        ));
        if bound.unbounded > 0.0 {
            out(format!("  in {:.1} % of the places there is none", 100.0 * bound.unbounded));
        }
        let width = self.width(bound.lines.iter().map(|line| &line.line));
        let rows = self.rows(bound.lines.iter().map(|line| line.share));
        for line in bound.lines.iter().take(rows) {
            let without = line.without.map(|bound| format!("without {}, ", number(bound)));
            let aside = format!("{}loose {:.1}", without.unwrap_or_default(), line.looseness);
            out(self.row(line.share, &line.line, width, &self.terminal.dim(aside)));
        }
        self.rest(bound.lines.iter().map(|line| line.share));
    }

    fn hint(&self, hint: &Hint) {
        let Hint { line, finding, remedy } = hint;
        let text: String = line.text.chars().take(WIDE).collect();
        out(format!("{} {text}", self.terminal.bold(format_args!("{}:", self.place(line)))));
        wrapped(finding).iter().for_each(|line| out(format!("  {line}")));
        let help = wrapped(&format!("Help: {remedy}")).join("\n  ");
        out(format!("  {}\n", help.replacen("Help:", &self.terminal.bold("Help:"), 1)));
    }

    /// `  41.2 % ||||        12  let fine = ...   what`
    fn row(&self, share: f64, line: &Line, width: usize, aside: &str) -> String {
        let text: String = line.text.chars().take(TEXT).collect();
        let percent = 100.0 * share;
        format!("{percent:>6.1} % {} {:>width$}  {text:<TEXT$}  {aside}", self.bar(share), self.place(line))
    }

    /// How many lines the table shows.
    fn rows(&self, shares: impl Iterator<Item = f64>) -> usize {
        shares.take(self.top).take_while(|share| *share >= LEAST).count()
    }

    /// What the lines that are not in the table come to, and an empty line.
    fn rest(&self, shares: impl Iterator<Item = f64> + Clone) {
        let rest: Vec<f64> = shares.clone().skip(self.rows(shares)).collect();
        let sum: f64 = rest.iter().sum();
        if sum >= LEAST {
            out(format!("{:>6.1} % in {} more, see --top", 100.0 * sum, rest.len()));
        }
        out("");
    }

    /// A bar as long as a share.
    fn bar(&self, share: f64) -> String {
        if !self.terminal.color {
            let full = (share * BAR as f64).round() as usize;
            return format!("{:<BAR$}", "#".repeat(full.min(BAR)));
        }
        let eighths = (share * 8.0 * BAR as f64).round() as usize;
        let (full, part) = ((eighths / 8).min(BAR), [' ', '▏', '▎', '▍', '▌', '▋', '▊', '▉'][eighths % 8]);
        let bar: String = std::iter::repeat_n('█', full).chain([part]).take(BAR).collect();
        format!("\x1b[36m{bar:<BAR$}\x1b[0m")
    }

    fn width<'b>(&self, lines: impl Iterator<Item = &'b Line>) -> usize {
        lines.take(self.top).map(|line| self.place(line).chars().count()).max().unwrap_or(0)
    }

    /// The number of a line of the script; with its file if it is in another.
    fn place(&self, line: &Line) -> String {
        match line {
            Line { line: 0, .. } => "?".to_owned(),
            Line { file, line, .. } if Path::new(file) == self.script => line.to_string(),
            Line { file, line, .. } => format!("{file}:{line}"),
        }
    }
}

/// A sentence in lines.
fn wrapped(text: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.is_empty() => line.push_str(word),
            Some(line) if line.chars().count() + 1 + word.chars().count() <= WIDE => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// A number with three digits that say something.
fn number(x: f64) -> String {
    if x >= 1e6 {
        return format!("{x:.2e}");
    }
    let digits = if x > 0.0 { (2.0 - libm::log10(x).floor()).clamp(0.0, 9.0) as usize } else { 0 };
    format!("{x:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_are_as_long_as_shares() {
        let table = |color| Terminal { color, live: false };
        let bar = |color, share| Table::new(Path::new(""), 1, &table(color)).bar(share);
        assert_eq!(bar(false, 0.0), "          ");
        assert_eq!(bar(false, 0.52), "#####     ");
        assert_eq!(bar(false, 1.0), "##########");
        assert_eq!(bar(true, 1.0), "\x1b[36m██████████\x1b[0m");
        assert_eq!(bar(true, 0.25), "\x1b[36m██▌       \x1b[0m");
        for i in 0..=100 {
            assert_eq!(bar(true, f64::from(i) / 100.0).chars().count(), BAR + 9);
        }
    }

    #[test]
    fn hints_are_wrapped_between_words() {
        let text = "a line that goes on and on ".repeat(9);
        let lines = wrapped(&text);
        assert!(lines.len() > 2 && lines.iter().all(|line| line.chars().count() <= WIDE));
        assert_eq!(lines.join(" "), text.trim_end());
    }

    #[test]
    fn numbers_keep_three_digits() {
        let said: Vec<String> =
            [0.0, 0.01234, 1.2345, 12.345, 1234.5, 1.4567e52].into_iter().map(number).collect();
        assert_eq!(said, ["0", "0.0123", "1.23", "12.3", "1234", "1.46e52"]);
    }
}
