//! `:plot`: functions along a ray, or against a variable.

use super::draw::{Drawing, shortened};
use super::{Shell, request};
use crate::analysis::plot::{Axis, Curves, Line as Drawn};
use crate::cli::pictures::Way;
use crate::cli::pictures::braille::{Chart, short};
use crate::cli::report::{Failure, Outcome, out};
use crate::diag::Diagnostic;
use crate::script::Line;
use crate::session;
use crate::tape::Tape;
use std::sync::Arc;

/// Places at which a function is asked.
const PLACES: usize = 2001;
/// Room above and below curves, as a share of their range.
const ROOM: f64 = 0.06;
/// Places where a curve crosses zero that are said.
const CROSSINGS: usize = 8;

/// Characters of a title and of a legend.
const TITLE: usize = 72;
const LEGEND: usize = 32;

type Points = Vec<(f64, f64)>;

/// Draws what was asked for.
pub fn run(shell: &Shell, argument: &str) -> Outcome {
    let asked = request::plot(argument).map_err(|e| shell.say(&e))?;
    let (line, ends) = path(shell, &asked)?;
    let mut tapes: Vec<Arc<Tape>> = Vec::new();
    for function in &asked.functions {
        let tape = shell.interpreter.borrow_mut().along(function, &line);
        tapes.push(tape.map_err(|e| shell.say(&e))?);
    }
    let curves = shell.watched("plot", |watch| {
        tapes.iter().map(|tape| session::along(tape, ends, PLACES, watch)).collect::<Result<Vec<Points>, _>>()
    });
    let curves = curves.map_err(|e| shell.say(&e))?;
    let y = range(&curves).ok_or_else(|| {
        let error = Diagnostic::error("no value along there is a finite number");
        shell.say(&error.hint("ask for one: f.at([1, 0, 0])"))
    })?;
    let several = asked.functions.len() > 1;
    let label = asked.variable.unwrap_or("distance along the ray");
    let figure =
        figure(&asked, &curves, Axis { label: label.to_owned(), range: ends, logarithmic: false }, y);
    let chart = Chart { lines: curves.iter().map(Vec::as_slice).collect(), x: ends, y, label, color: true };
    Drawing {
        name: "plot",
        file: asked.file.as_deref(),
        figure: &|(width, height)| {
            let drawn = figure.draw(width.min(height * 4 / 3));
            drawn.map_err(|e| Box::new(Diagnostic::error(e.to_string())))
        },
        characters: &|(columns, rows)| chart.draw(columns as usize, rows.min(24) as usize),
    }
    .deliver(shell)?;
    for (i, (name, points)) in asked.functions.iter().zip(&curves).enumerate() {
        let said = summary(name, points);
        out(if several && shell.screen.way() == Way::Blocks { chart.entry(i, &said) } else { said });
    }
    Ok(())
}

/// The line, and the ends of its coordinate.
fn path(shell: &Shell, asked: &request::Plot<'_>) -> Result<(Line, (f64, f64)), Failure> {
    let numbers = |text: &str| {
        let numbers = shell.interpreter.borrow_mut().numbers(text);
        numbers.map_err(|e| shell.say(&e))
    };
    let ends = (numbers(asked.ends.0)?, numbers(asked.ends.1)?);
    let wrong = |message: &str, hint: &str| Err(shell.say(&Diagnostic::error(message).hint(hint)));
    match (asked.variable, ends.0.as_slice(), ends.1.as_slice()) {
        (None, &[a, b, c], &[d, e, f]) => {
            let length = libm::hypot(libm::hypot(d - a, e - b), f - c);
            match length > 0.0 && length.is_finite() {
                true => Ok((Line::Ray([a, b, c], [d, e, f]), (0.0, length))),
                false => wrong("the ray has no length", "for example: along [0, 0, 0]..[2, 0, 0]"),
            }
        }
        (None, [_], [_]) => wrong("along which variable?", "for example: along x=-2..2"),
        (Some(name), &[low], &[high]) => match Line::variable(name) {
            Some(line) if low < high => Ok((line, (low, high))),
            Some(_) => wrong("the first end must be below the second", "for example: along x=-2..2"),
            None => wrong(&format!("`{name}` is no variable of fields"), "there are x, y, z and time"),
        },
        (Some(_), ..) => wrong("a variable goes from a number to a number", "for example: along x=-2..2"),
        _ => wrong("a ray goes from a point to a point", "for example: along [0, 0, 0]..[2, 0, 0]"),
    }
}

/// The curves with axes; zero is a line of its own, where it is in sight.
fn figure(asked: &request::Plot<'_>, curves: &[Points], x: Axis, y: (f64, f64)) -> Curves {
    let several = asked.functions.len() > 1;
    let drawn = |(name, points): (&&str, &Points)| Drawn {
        label: if several { shortened(name, LEGEND) } else { String::new() },
        points: points.clone(),
        guide: false,
    };
    let mut lines: Vec<Drawn> = asked.functions.iter().zip(curves).map(drawn).collect();
    if y.0 < 0.0 && y.1 > 0.0 {
        let points = vec![(x.range.0, 0.0), (x.range.1, 0.0)];
        lines.push(Drawn { label: String::new(), points, guide: true });
    }
    let y = Axis { label: if several { "" } else { "f" }.to_owned(), range: y, logarithmic: false };
    let way = asked.variable.map_or(String::new(), |name| format!("{name} = "));
    let title = format!("{} along {way}{}..{}", asked.functions.join(", "), asked.ends.0, asked.ends.1);
    Curves { title: shortened(&title, TITLE), x, y, lines }
}

/// From where to where the values of curves go, with some room; `None` if no value is finite.
fn range(curves: &[Points]) -> Option<(f64, f64)> {
    let values = curves.iter().flatten().map(|p| p.1).filter(|v| v.is_finite());
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (v.min(a), v.max(b)));
    let room = match high - low {
        span if span > 0.0 => ROOM * span,
        _ => (0.5 * high.abs()).max(0.5),
    };
    (low <= high && (high - low).is_finite()).then_some((low - room, high + room))
}

/// From where to where a curve goes, and about where it crosses zero.
fn summary(name: &str, points: &Points) -> String {
    let finite = points.iter().map(|p| p.1).filter(|v| v.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (v.min(a), v.max(b)));
    let pairs = points.windows(2).filter(|pair| (pair[0].1 < 0.0) != (pair[1].1 < 0.0));
    let pairs = pairs.filter(|pair| pair.iter().all(|p| p.1.is_finite()));
    // As exactly as steps tell.
    let digits = points.windows(2).next().map_or(1.0, |p| 1e-3 * (p[1].0 - p[0].0));
    let place = |p: &[(f64, f64)]| p[0].0 + (p[1].0 - p[0].0) * (p[0].1 / (p[0].1 - p[1].1));
    let crossings: Vec<f64> = pairs.map(|p| (place(p) / digits).round() * digits).collect();
    let places: Vec<String> = crossings.iter().take(CROSSINGS).map(|c| short(*c)).collect();
    let zeros = match crossings.len() {
        0 => String::new(),
        n if n > CROSSINGS => format!(", zero {n} times, first near {}", places.join(", ")),
        _ => format!(", zero near {}", places.join(", ")),
    };
    format!("{name}: from {} to {}{zeros}", short(low), short(high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_summed_up() {
        let points: Points = (0..=100).map(|i| f64::from(i) / 50.0).map(|x| (x, x * x - 1.0)).collect();
        assert_eq!(summary("f", &points), "f: from -1 to 3, zero near 1");
        assert_eq!(range(&[points]), Some((-1.24, 3.24)));
        assert_eq!(range(&[vec![(0.0, f64::NAN)]]), None);
        assert_eq!(range(&[vec![(0.0, 0.0)]]), Some((-0.5, 0.5)));
        let wave: Points = (0..1000).map(|i| (f64::from(i), libm::sin(f64::from(i)))).collect();
        assert!(summary("g", &wave).contains("times, first near"));
    }
}
