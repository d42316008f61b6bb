//! Curves of characters, for terminals that show no pictures: a character of braille is two dots wide and four
//! high.

use std::fmt::Write;

/// Dots of a character, in columns and rows.
const DOTS: (usize, usize) = (2, 4);
/// The bit of each dot, by column and row.
const BITS: [[u8; 4]; 2] = [[0x01, 0x02, 0x04, 0x40], [0x08, 0x10, 0x20, 0x80]];
/// Colours of curves, as terminals number them.
const COLORS: [u8; 8] = [34, 33, 32, 35, 36, 31, 94, 93];

/// Curves over a common axis.
pub struct Chart<'a> {
    /// Points of the curves, from left to right.
    pub lines: Vec<&'a [(f64, f64)]>,
    /// Ends of the axes.
    pub x: (f64, f64),
    pub y: (f64, f64),
    /// What the horizontal axis is.
    pub label: &'a str,
    /// Whether there are colours.
    pub color: bool,
}

impl Chart<'_> {
    /// The chart in so many columns and rows of characters.
    pub fn draw(&self, columns: usize, rows: usize) -> String {
        let labels = [self.y.1, 0.0, self.y.0].map(short);
        let margin = labels.iter().map(|l| l.chars().count()).max().unwrap_or(0);
        let (width, height) = (columns.saturating_sub(margin + 3).max(8), rows.saturating_sub(2).max(3));
        let cells = self.cells(width, height);
        let zero = self.zero(height * DOTS.1).map(|y| y / DOTS.1);
        let mut out = String::new();
        for (row, line) in cells.chunks(width).enumerate() {
            let label = match row {
                0 => &labels[0],
                _ if row == height - 1 => &labels[2],
                _ if zero == Some(row) => &labels[1],
                _ => "",
            };
            // Writing to a text cannot fail.
            let _ = writeln!(
                out,
                "{label:>margin$} {}{}",
                if label.is_empty() { '│' } else { '┤' },
                self.row(line)
            );
        }
        let _ = writeln!(out, "{:margin$} └{}", "", "─".repeat(width));
        let (left, right) = (short(self.x.0), short(self.x.1));
        let gap = width.saturating_sub(left.chars().count() + right.chars().count());
        let _ = write!(out, "{:margin$}  {left}{:^gap$}{right}", "", self.label);
        out
    }

    /// The row of dots, from the top, in which zero is, if it is in sight.
    fn zero(&self, rows: usize) -> Option<usize> {
        let up = -self.y.0 / (self.y.1 - self.y.0) * (rows - 1) as f64;
        (self.y.0 < 0.0 && self.y.1 > 0.0).then(|| rows - 1 - (up.round() as usize).min(rows - 1))
    }

    /// What is said of a curve, with a line of its colour.
    pub fn entry(&self, curve: usize, text: &str) -> String {
        match self.color {
            true => format!("\x1b[{}m━\x1b[0m {text}", COLORS[curve % COLORS.len()]),
            false => text.to_owned(),
        }
    }

    /// A line of characters; neighbours of one colour are coloured together.
    fn row(&self, cells: &[(u8, usize)]) -> String {
        let mut out = String::new();
        for run in cells.chunk_by(|a, b| a.1 == b.1) {
            let text: String = run
                .iter()
                .map(|(bits, _)| char::from_u32(0x2800 + u32::from(*bits)).unwrap_or(' '))
                .collect();
            match run[0].1 {
                0 => out += &text.replace('\u{2800}', " "),
                line if self.color => {
                    let _ = write!(out, "\x1b[{}m{text}\x1b[0m", COLORS[(line - 1) % COLORS.len()]);
                }
                _ => out += &text,
            }
        }
        out.trim_end().to_owned()
    }

    /// The dots of every character, and which curve they are of, counting from 1; the zero line is of none.
    fn cells(&self, width: usize, height: usize) -> Vec<(u8, usize)> {
        let mut cells = vec![(0u8, 0usize); width * height];
        let (across, down) = (width * DOTS.0, height * DOTS.1);
        let place = |v: f64, (low, high): (f64, f64), n: usize| (v - low) / (high - low) * (n - 1) as f64;
        let mut dot = |x: usize, y: usize, line: usize| {
            let cell = &mut cells[y / DOTS.1 * width + x / DOTS.0];
            cell.0 |= BITS[x % DOTS.0][y % DOTS.1];
            cell.1 = line.max(cell.1);
        };
        if let Some(y) = self.zero(down) {
            (0..across).step_by(4).for_each(|x| dot(x, y, 0));
        }
        for (i, line) in self.lines.iter().enumerate() {
            for pair in line.windows(2).filter(|pair| pair.iter().all(|p| p.1.is_finite())) {
                let ends = [pair[0], pair[1]].map(|p| (place(p.0, self.x, across), place(p.1, self.y, down)));
                let steps =
                    (ends[1].0 - ends[0].0).abs().max((ends[1].1 - ends[0].1).abs()).ceil().clamp(1.0, 1e4);
                for k in 0..=steps as usize {
                    let t = k as f64 / steps;
                    let [x, y] =
                        [ends[0].0 + t * (ends[1].0 - ends[0].0), ends[0].1 + t * (ends[1].1 - ends[0].1)];
                    if (-0.5..across as f64 - 0.5).contains(&x) && (-0.5..down as f64 - 0.5).contains(&y) {
                        dot(x.round() as usize, down - 1 - y.round() as usize, i + 1);
                    }
                }
            }
        }
        cells
    }
}

/// A number in few characters.
pub fn short(v: f64) -> String {
    let size = v.abs();
    let text = if size != 0.0 && !(1e-3..1e5).contains(&size) {
        return format!("{v:.2e}");
    } else {
        format!("{v:.3}")
    };
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rising_line_rises() {
        let line: Vec<(f64, f64)> =
            (0..=20).map(|i| (f64::from(i) / 10.0, f64::from(i) / 10.0 - 1.0)).collect();
        let chart = Chart { lines: vec![&line], x: (0.0, 2.0), y: (-1.0, 1.0), label: "x", color: false };
        let text = chart.draw(30, 9);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 9, "{text}");
        assert!(lines.iter().all(|l| l.chars().count() <= 30), "{text}");
        assert!(
            lines[0].starts_with(" 1 ┤") && lines[6].starts_with("-1 ┤") && lines[3].starts_with(" 0 ┤"),
            "{text}"
        );
        let first = |line: &str| {
            line.chars().skip(4).position(|c| c != ' ' && !('\u{2801}'..='\u{2880}').contains(&c))
        };
        assert!(first(lines[6]).unwrap_or(0) < first(lines[0]).unwrap_or(usize::MAX), "{text}");
        assert!(lines[8].trim_start().starts_with('0') && lines[8].ends_with('2'), "{text}");
    }

    #[test]
    fn what_is_not_finite_is_left_out() {
        let line = [(0.0, f64::NAN), (1.0, 1.0), (2.0, f64::INFINITY)];
        let chart = Chart { lines: vec![&line], x: (0.0, 2.0), y: (0.0, 1.0), label: "", color: true };
        assert!(!chart.draw(40, 8).contains("\x1b["));
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(
            [0.0, -0.0001, 2.5, 1e-9, 123456.0].map(short),
            ["0", "-1.00e-4", "2.5", "1.00e-9", "1.23e5"]
        );
    }
}
