//! `:slice`: a plane through a field.

use super::draw::{Drawing, shortened};
use super::{Shell, request};
use crate::analysis::plot::Contours;
use crate::cli::pictures::braille::short;
use crate::cli::report::{Failure, Outcome, out};
use crate::diag::Diagnostic;
use crate::field::Watch;
use crate::scene::Scene;
use crate::session::Plane;
use std::cell::RefCell;
use std::rc::Rc;

/// Characters of a field in a title.
const TITLE: usize = 48;

/// Draws what was asked for.
pub fn run(shell: &Shell, argument: &str) -> Outcome {
    let asked = request::slice(argument).map_err(|e| shell.say(&e))?;
    let scene = shell.solid(asked.field)?;
    let plane = plane(shell, &asked, &scene)?;
    // What is said below is about the values that are seen.
    let seen = RefCell::new(None);
    let sample = |size: (u32, u32)| {
        let values = shell.watched("slice", |watch: &Watch<'_>| plane.sample(&scene, size, watch))?;
        let values: Rc<[f64]> = values.into();
        seen.replace(Some((size.0, values.clone())));
        Ok::<_, Box<Diagnostic>>(values)
    };
    let name = shortened(asked.field.unwrap_or("f"), TITLE);
    let title = format!("{name}, {} = {}", plane.name(), short(plane.offset));
    let figure = |(width, height): (u32, u32)| {
        let too_small =
            || Diagnostic::error("there is no room for a figure").hint("give it a file: to slice.png");
        let size = Contours::inner(width, height, plane.aspect()).ok_or_else(|| Box::new(too_small()))?;
        let values = sample(size)?;
        contours(&title, &plane, size.0, &values)
            .draw()
            .map_err(|e| Box::new(Diagnostic::error(e.to_string())))
    };
    let characters = |(columns, rows): (u32, u32)| {
        let width = f64::from(columns).min(f64::from(2 * rows) / plane.aspect()).max(8.0);
        let size = (width as u32, (width * plane.aspect()).max(2.0) as u32);
        match sample(size) {
            Ok(values) => shell.screen.text(&contours(&title, &plane, size.0, &values).image()),
            Err(error) => {
                shell.say(&error);
                String::new()
            }
        }
    };
    Drawing { name: "slice", file: asked.file.as_deref(), figure: &figure, characters: &characters }
        .deliver(shell)?;
    if let Some((width, values)) = seen.take() {
        out(summary(&plane, &contours(&title, &plane, width, &values)));
    }
    Ok(())
}

/// The picture of values on a plane.
fn contours<'a>(title: &str, plane: &Plane, width: u32, data: &'a [f64]) -> Contours<'a> {
    Contours { title: title.to_owned(), labels: plane.labels(), ends: plane.ends, width, data }
}

/// The plane that was asked for.
fn plane(shell: &Shell, asked: &request::Slice<'_>, scene: &Scene) -> Result<Plane, Failure> {
    let number = |text: &str| {
        let numbers = shell.interpreter.borrow_mut().numbers(text);
        let numbers = numbers.map_err(|e| shell.say(&e))?;
        let wrong =
            || Diagnostic::error(format!("`{text}` is a point, not a number")).hint("for example: z=0.5");
        <[f64; 1]>::try_from(numbers).map(|[number]| number).map_err(|_| shell.say(&wrong()))
    };
    let (axis, offset) = match asked.plane {
        Some((axis, place)) => (axis, number(place)?),
        None => (2, 0.0),
    };
    let ends = match asked.window {
        None => return Ok(Plane::around(scene, axis, offset)),
        Some((half, None)) => (-number(half)?, number(half)?),
        Some((low, Some(high))) => (number(low)?, number(high)?),
    };
    if ends.0 < ends.1 {
        return Ok(Plane { axis, offset, ends: [ends; 2] });
    }
    let error = Diagnostic::error("a window reaches from a number to a larger one");
    Err(shell.say(&error.hint("for example: in 1.5, or in -1..2")))
}

/// What is shown, from where to where the values go, and what the lines are.
fn summary(plane: &Plane, contours: &Contours<'_>) -> String {
    let finite = contours.data.iter().copied().filter(|v| v.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (v.min(a), v.max(b)));
    let [x, y] = plane.ends.map(|(low, high)| format!("{}..{}", short(low), short(high)));
    let [right, up] = plane.labels();
    if low > high {
        return format!("{right} {x}, {up} {y}; no value there is a finite number");
    }
    let side = match (low < 0.0, high > 0.0) {
        (true, true) => "blue is inside",
        (true, false) => "all of it is inside",
        _ => "all of it is outside",
    };
    let step = short(contours.step());
    format!("{right} {x}, {up} {y}; f from {} to {}, {side}; lines {step} apart", short(low), short(high))
}
