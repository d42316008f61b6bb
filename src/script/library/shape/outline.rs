//! `polygon`, `outline` and `text`: what is inside of lines in the plane.

use super::{flat_field, list};
use crate::diag::Diagnostic;
use crate::exchange::drawing;
use crate::script::fault::{Fault, Outcome};
use crate::script::library::files::with_options;
use crate::script::library::grid::listed;
use crate::script::library::{Call, Library};
use crate::script::modules::Resolver;
use crate::script::options::{Options, describe};
use crate::script::value::number;
use crate::shape::outline::{Align, Flaw, Font, Layout, Outline, Pen, drawn, runs_left};
use glam::DVec2;
use rhai::{Dynamic, Map};

pub(super) fn register(lib: &mut Library<'_>) {
    lib.def(
        "polygon(points)",
        "The inside of a polygon in the plane, as a field of x and y that is the same for all z: the signed distance from its edges. Points are pairs [x, y]; several loops are an array of arrays of pairs, and what they wind around is inside, so that a hole goes round the other way. A solid is max(polygon, abs(z) - height).",
        "max(polygon([[0, 0], [1, 0], [0, 1]]), abs(z) - 0.2)",
        polygon,
    );
    lib.def(
        "outline(path)",
        "The inside of a drawing in the plane, as a field of x and y: the signed distance. The path is written as in SVG, M L H V C S Q T A Z and their small letters, and stands upright as it does there, so that its y goes down and ours goes up. What its loops wind around is inside (the nonzero rule).",
        "outline(\"M 0 0 H 2 V -1 Q 1 -2 0 -1 Z\")",
        outline,
    );
    let sentence = listed(
        "What an SVG file in the folder of the main script or below paints, in whatever colour, as an outline in the plane: filled shapes, and strokes as wide as they are. Text is to be made paths of; clips and masks do not count.",
        &[
            "size: scales it so that this is the longest edge of the box around it, the middle of which is at the origin; without it the drawing is as large as it says, 96 units an inch, with its upper left corner at the origin (.scaled(25.4 / 96.0) for millimetres)",
        ],
    );
    let example = "max(load_outline(\"leaf.svg\", #{ size: 2.0 }), abs(z) - 0.1)";
    with_options(lib, "load_outline", &sentence, example, load_outline);
    let sentence = listed(
        "A text as an outline in the plane, a field of x and y: the signed distance from its letters. The first line stands on y = 0, the next one is below. Cut into a plate up to z = top they are difference(plate, max(letters, top - depth - z)), and for a stamp letters.scaled([-1, 1, 1]).",
        &[
            "font: a TrueType or OpenType file in the folder of the script; DejaVu Sans unless given",
            "size: of the font, about the height of a line",
            "align: \"left\", \"center\" or \"right\" of x = 0",
            "leading: distance of lines, in sizes",
        ],
    );
    let folder = lib.folder.clone();
    let text = move |c: &Call<'_>| {
        let mut o = Options::new(c, 1)?;
        let font = o.typed("font", "the name of a file", rhai::ImmutableString::new())?;
        let size = o.number("size", 1e-9..=1e9, 1.0)?;
        let align = match o.choice("align", &["left", "center", "right"])? {
            "center" => Align::Center,
            "right" => Align::Right,
            _ => Align::Left,
        };
        let leading = o.number("leading", 0.0..=100.0, 1.2)?;
        o.finish()?;
        let layout = Layout { size, align, leading };
        let text = c.text(0)?;
        let write = |f: Font<'_>| {
            let missing: Vec<String> =
                f.missing(&text).into_iter().map(|c| format!("`{}`", c.escape_debug())).collect();
            if !missing.is_empty() {
                let name = if font.is_empty() { "DejaVu Sans" } else { &font };
                let message = format!("{name} has no letters for {}, which become boxes", missing.join(", "));
                let hint = "text(string, #{ font: \"file.ttf\" }) takes another font";
                c.host.doubt(Diagnostic::warning(message).at(c.place.clone()).hint(hint));
            }
            if runs_left(&text) {
                let message = "letters are set from left to right, each by itself, and these are written from right to left";
                let hint = "give them in the order in which they are seen, and Arabic ones in their presentation forms";
                c.host.doubt(Diagnostic::warning(message).at(c.place.clone()).hint(hint));
            }
            f.write(&text, &layout)
        };
        let pen = if font.is_empty() {
            Font::new(dejavu::sans::regular()).map(write)
        } else {
            let (_, bytes) = folder.bytes(&font).map_err(|fault| fault.key("font"))?;
            Font::new(&bytes).map(write)
        };
        let pen = pen.ok_or_else(|| {
            Fault::new(format!("{font} is no TrueType or OpenType font"))
                .key("font")
                .hint("such files end in .ttf or .otf")
        })?;
        flat_field(c, enclosed(pen, "a text has letters, not only spaces")?)
    };
    let text = std::rc::Rc::new(text);
    let plain = text.clone();
    let example = "max(text(\"orogen\", #{ size: 0.5, align: \"center\" }), abs(z) - 0.1)";
    lib.def("text(string, options)", &sentence, example, move |c| text(c));
    lib.bind("text", 1, move |c| {
        let args = [c.args[0].clone(), Dynamic::from(Map::new())];
        plain(&Call { args: &args, place: c.place.clone(), ..*c })
    });
}

fn load_outline(c: &Call<'_>, folder: &Resolver) -> Outcome<Dynamic> {
    let (file, bytes) = folder.bytes(&c.text(0)?)?;
    let mut o = Options::new(c, 1)?;
    let is_fitted = o.get("size").is_some();
    let size = o.number("size", 1e-9..=1e9, 1.0)?;
    o.finish()?;
    let drawing = drawing::read(&file, &bytes, is_fitted.then_some(size))
        .map_err(|e| Fault::new(format!("{}{}: {}", e.file, e.place, e.what)).hint(e.remedy))?;
    if !drawing.left_out.is_empty() {
        let message = format!("{file} has {}, which is left out", drawing.left_out.join(", "));
        c.host.doubt(Diagnostic::warning(message).at(c.place.clone()));
    }
    let empty = "nothing in it is filled or stroked";
    flat_field(c, outlined(Outline::of_layers(drawing.layers), empty)?)
}

/// What a pen drew, and what to say if nothing is in it.
fn enclosed(pen: Pen, empty: &str) -> Outcome<Outline> {
    outlined(Outline::new(pen), empty)
}

fn outlined(outline: Result<Outline, Flaw>, empty: &str) -> Outcome<Outline> {
    outline.map_err(|flaw| {
        let fault = Fault::new(flaw.to_string());
        if flaw == Flaw::Empty { fault.hint(empty) } else { fault }
    })
}

fn polygon(c: &Call<'_>) -> Outcome<Dynamic> {
    let entries = list(&c.args[0]).ok_or_else(|| c.wrong(0, "an array of pairs [x, y]"))?;
    // A loop of points, or a list of loops.
    let nested = entries.first().and_then(list).is_some_and(|first| first.first().and_then(list).is_some());
    let loops = if nested { entries } else { vec![Dynamic::from(entries)] };
    let loops: Vec<_> = loops
        .iter()
        .enumerate()
        .map(|(k, points)| corners(points, nested.then_some(k)))
        .collect::<Outcome<_>>()?;
    let outline =
        enclosed(pen_of(&loops, None), "a polygon has three points or more that are not on a line")?;
    if nested {
        doubt_lost(c, &outline, &loops);
    }
    flat_field(c, outline)
}

/// Draws loops, but for one perhaps.
fn pen_of(loops: &[Vec<DVec2>], without: Option<usize>) -> Pen {
    let mut pen = Pen::default();
    for (_, corners) in loops.iter().enumerate().filter(|(k, _)| Some(*k) != without) {
        let Some((first, rest)) = corners.split_first() else { continue };
        pen.jump(*first);
        rest.iter().for_each(|corner| pen.line(*corner));
    }
    pen
}

/// The points of a loop, which may be one of several.
fn corners(points: &Dynamic, which: Option<usize>) -> Outcome<Vec<DVec2>> {
    let of = which.map_or(String::new(), |k| format!(" of loop {k}"));
    let points = list(points).ok_or_else(|| {
        let number = which.unwrap_or_default();
        Fault::new(format!("loop {number} of `polygon` must be an array of pairs, not {}", describe(points)))
    })?;
    let corner = |(i, point): (usize, &Dynamic)| {
        let wrong = |what: &str| Fault::new(format!("point {i}{of} of `polygon` must be {what}"));
        let entries = list(point).filter(|entries| entries.len() == 2);
        let entries = entries.ok_or_else(|| wrong(&format!("a pair [x, y], not {}", describe(point))))?;
        match (number(&entries[0]), number(&entries[1])) {
            (Some(x), Some(y)) if x.is_finite() && y.is_finite() => Ok(DVec2::new(x, y)),
            _ => {
                Err(wrong(&format!("two finite numbers, not [{}, {}]", told(&entries[0]), told(&entries[1]))))
            }
        }
    };
    points.iter().enumerate().map(corner).collect()
}

/// An entry of a point as it is to be read.
fn told(entry: &Dynamic) -> String {
    if number(entry).is_some() { entry.to_string() } else { describe(entry) }
}

/// Tells of loops that lie within what others enclose, and without which the outline is the same.
fn doubt_lost(c: &Call<'_>, outline: &Outline, loops: &[Vec<DVec2>]) {
    let is_lost = |lost: &usize| {
        let corners = &loops[*lost];
        let is_covered = !corners.is_empty() && corners.iter().all(|corner| outline.covers(*corner));
        is_covered && Outline::new(pen_of(loops, Some(*lost))).is_ok_and(|rest| rest.is_same_as(outline))
    };
    for lost in (0..loops.len()).filter(is_lost) {
        c.host.doubt(
            Diagnostic::warning(format!("loop {lost} lies within what the others enclose, and changes nothing"))
                .at(c.place.clone())
                .hint("inside is what is wound around any number of times but none: a hole goes the other way round, as often as all that it is in"),
        );
    }
}

fn outline(c: &Call<'_>) -> Outcome<Dynamic> {
    let path = c.text(0)?;
    let pen = drawn(&path).map_err(|garbled| {
        // Around the place, since paths are long.
        let from = garbled.at.saturating_sub(20);
        let near: String = path.chars().skip(from).take(40).collect();
        let fault = Fault::new(garbled.to_string()).hint(format!("there it says {near:?}"));
        let is_file = path.contains('<') || path.ends_with(".svg");
        if is_file { fault.hint("load_outline(file) reads SVG files") } else { fault }
    })?;
    flat_field(c, enclosed(pen, "nothing is between the lines that it draws")?)
}
