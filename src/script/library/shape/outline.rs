//! `polygon`, `outline` and `text`: what is inside of lines in the plane.

use super::{field, list, numbers};
use crate::diag::Diagnostic;
use crate::script::fault::{Fault, Outcome};
use crate::script::library::grid::listed;
use crate::script::library::{Call, Library};
use crate::script::options::{Options, describe};
use crate::shape::outline::{Align, Flaw, Font, Layout, Outline, Pen, drawn};
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
        "A text as an outline in the plane, a field of x and y: the signed distance from its letters. The first line stands on y = 0, the next one is below.",
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
        inside(c, pen).map_err(|fault| fault.hint("a text has letters, not only spaces"))
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

/// The field of what a pen drew.
fn inside(c: &Call<'_>, pen: Pen) -> Outcome<Dynamic> {
    field(c, Outline::new(pen).map_err(|flaw: Flaw| Fault::new(flaw.to_string()))?)
}

fn polygon(c: &Call<'_>) -> Outcome<Dynamic> {
    let entries = list(&c.args[0]).ok_or_else(|| c.wrong(0, "an array of pairs [x, y]"))?;
    // A loop of points, or a list of loops.
    let nested = entries.first().and_then(list).is_some_and(|first| first.first().and_then(list).is_some());
    let loops = if nested { entries } else { vec![Dynamic::from(entries)] };
    let mut pen = Pen::default();
    for (number, points) in loops.iter().enumerate() {
        let points = list(points).ok_or_else(|| {
            Fault::new(format!(
                "loop {number} of `polygon` must be an array of pairs, not {}",
                describe(points)
            ))
        })?;
        for (i, point) in points.iter().enumerate() {
            let pair = pair(point).ok_or_else(|| {
                let given = describe(point);
                let of = if nested { format!(" of loop {number}") } else { String::new() };
                Fault::new(format!("point {i}{of} of `polygon` must be a pair [x, y], not {given}"))
            })?;
            if i == 0 { pen.jump(pair) } else { pen.line(pair) }
        }
    }
    inside(c, pen).map_err(|fault| fault.hint("a polygon has three points or more that are not on a line"))
}

fn pair(v: &Dynamic) -> Option<DVec2> {
    match numbers(&list(v)?)?[..] {
        [x, y] => Some(DVec2::new(x, y)),
        _ => None,
    }
}

fn outline(c: &Call<'_>) -> Outcome<Dynamic> {
    let path = c.text(0)?;
    let pen = drawn(&path).map_err(|garbled| {
        // Around the place, since paths are long.
        let from = garbled.at.saturating_sub(20);
        let near: String = path.chars().skip(from).take(40).collect();
        Fault::new(garbled.to_string()).hint(format!("there it says {near:?}"))
    })?;
    inside(c, pen)
}
