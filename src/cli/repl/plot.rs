//! `:plot`: functions along a ray, or against a variable.

use super::draw::{Drawing, shortened};
use super::zeros::{Zeros, has_pole};
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
/// The share of the values of a curve with poles, at either end of their range, that are out of sight.
const UNSEEN: f64 = 0.03;
/// Places where a curve is zero that are said, and where it jumps over zero.
const CROSSINGS: usize = 8;

/// Characters of a title and of a legend.
const TITLE: usize = 72;
const LEGEND: usize = 32;

/// Samples of a curve, from left to right.
pub type Points = Vec<(f64, f64)>;

/// A curve, and what is to be known of it.
struct Curve {
    points: Points,
    zeros: Zeros,
    has_pole: bool,
}

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
        let sampled = |tape: &Arc<Tape>| {
            let sample = |ends: (f64, f64), count: usize| session::along(tape, ends, count, watch);
            let points = sample(ends, PLACES)?;
            let (zeros, has_pole) = (Zeros::of(&points, &sample)?, has_pole(&points, &sample)?);
            Ok(Curve { points, zeros, has_pole })
        };
        tapes.iter().map(sampled).collect::<Result<Vec<Curve>, _>>()
    });
    let curves = curves.map_err(|e| shell.say(&e))?;
    let y = range(&curves).ok_or_else(|| {
        let error = Diagnostic::error("no value along there is a finite number");
        shell.say(&error.hint("ask for one: f.at([1, 0, 0])"))
    })?;
    let several = asked.functions.len() > 1;
    let label = asked.variable.unwrap_or("distance along the ray");
    let drawn: Vec<Points> = curves.iter().map(broken).collect();
    let figure = figure(&asked, &drawn, Axis { label: label.to_owned(), range: ends, logarithmic: false }, y);
    let chart = Chart { lines: drawn.iter().map(Vec::as_slice).collect(), x: ends, y, label, color: true };
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
    for (i, (name, curve)) in asked.functions.iter().zip(&curves).enumerate() {
        let said = summary(name, curve);
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

/// The points of a curve, with a gap wherever it jumps over zero.
fn broken(curve: &Curve) -> Points {
    let mut jumps = curve.zeros.jumps.iter().copied().peekable();
    let mut points = Points::with_capacity(curve.points.len());
    for point in &curve.points {
        while let Some(jump) = jumps.next_if(|jump| *jump < point.0) {
            points.push((jump, f64::NAN));
        }
        points.push(*point);
    }
    points
}

/// From where to where the values of curves are in sight, with some room; `None` if no value is finite.
fn range(curves: &[Curve]) -> Option<(f64, f64)> {
    let ends = curves.iter().filter_map(sight);
    let (low, high) = ends.reduce(|(low, high), (a, b)| (low.min(a), high.max(b)))?;
    let room = match high - low {
        span if span > 0.0 => ROOM * span,
        _ => (0.5 * high.abs()).max(0.5),
    };
    (high - low).is_finite().then_some((low - room, high + room))
}

/// From where to where the values of a curve are in sight: all of them, if it has no pole.
fn sight(curve: &Curve) -> Option<(f64, f64)> {
    let mut values: Vec<f64> = curve.points.iter().map(|p| p.1).filter(|v| v.is_finite()).collect();
    values.sort_unstable_by(f64::total_cmp);
    let unseen = (UNSEEN * values.len() as f64) as usize;
    let ends = |left_out: usize| Some((*values.get(left_out)?, *values.iter().rev().nth(left_out)?));
    ends(unseen).filter(|(low, high)| curve.has_pole && low < high).or_else(|| ends(0))
}

/// From where to where a curve goes, about where it is zero, and where it jumps over zero.
fn summary(name: &str, curve: &Curve) -> String {
    let finite = curve.points.iter().map(|p| p.1).filter(|v| v.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (v.min(a), v.max(b)));
    // Places are known to a small part of a step, and what is within it of 0 is 0.
    let digits = curve.points.windows(2).next().map_or(1.0, |p| 1e-6 * (p[1].0 - p[0].0));
    let place = |x: f64| short((x / digits).round() * digits);
    let stretch = |(low, high): &(f64, f64)| match (place(*low), place(*high)) {
        (low, high) if low == high => low,
        (low, high) => format!("{low}..{high}"),
    };
    let zeros = listed("zero", &curve.zeros.zeros.iter().map(stretch).collect::<Vec<_>>());
    let jumps = listed("jumps over zero", &curve.zeros.jumps.iter().map(|x| place(*x)).collect::<Vec<_>>());
    format!("{name}: from {} to {}{zeros}{jumps}", short(low), short(high))
}

/// What a curve does at these places, if there are any.
fn listed(what: &str, places: &[String]) -> String {
    let first = places.iter().take(CROSSINGS).map(String::as_str).collect::<Vec<_>>().join(", ");
    match places.len() {
        0 => String::new(),
        n if n > CROSSINGS => format!(", {what} {n} times, first near {first}"),
        _ => format!(", {what} near {first}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(ends: (f64, f64), f: impl Fn(f64) -> f64) -> Curve {
        let sample = |(from, to): (f64, f64), count: usize| {
            let place = |i: usize| from + (to - from) * (i as f64 / (count - 1) as f64);
            Ok((0..count).map(place).map(|x| (x, f(x))).collect::<Points>())
        };
        let points = sample(ends, 101).unwrap();
        let (zeros, has_pole) = (Zeros::of(&points, &sample).unwrap(), has_pole(&points, &sample).unwrap());
        Curve { points, zeros, has_pole }
    }

    #[test]
    fn curves_are_summed_up() {
        let parabola = curve((0.0, 2.0), |x| x * x - 1.0);
        assert_eq!(summary("f", &parabola), "f: from -1 to 3, zero near 1");
        assert_eq!(range(&[parabola]), Some((-1.24, 3.24)));
        assert_eq!(range(&[curve((0.0, 1.0), |_| f64::NAN)]), None);
        let zero = curve((0.0, 1.0), |_| 0.0);
        assert_eq!(summary("o", &zero), "o: from 0 to 0, zero near 0..1");
        assert_eq!(range(&[zero]), Some((-0.5, 0.5)));
        assert!(summary("g", &curve((0.5, 99.0), libm::sin)).contains(", zero 31 times, first near 3.142, "));
    }

    #[test]
    fn curves_with_poles_have_gaps_and_an_axis_that_shows_the_rest() {
        let tangent = curve((0.0, 6.0), libm::tan);
        let said = summary("tan", &tangent);
        assert!(said.ends_with(", zero near 0, 3.142, jumps over zero near 1.571, 4.712"), "{said}");
        let gaps: Vec<f64> = broken(&tangent).iter().filter(|p| p.1.is_nan()).map(|p| p.0).collect();
        assert_eq!(gaps, tangent.zeros.jumps);
        let (low, high) = range(&[tangent]).unwrap();
        assert!((-20.0..-5.0).contains(&low) && (5.0..20.0).contains(&high), "{low} {high}");
        // A peak is in sight to its top, however thin.
        let peak = curve((-1.0, 1.0), |x| libm::exp(-1e3 * x * x));
        assert!(range(&[peak]).unwrap().1 > 1.0);
    }
}
