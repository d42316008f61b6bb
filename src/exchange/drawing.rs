//! Drawings in SVG: what they paint.
//!
//! A drawing is read as a browser reads it, with its styles, groups, copies, transformations and units; what comes
//! out of that is paths. Each covers what its own rule says that it fills, and where it is stroked, what the stroke
//! covers; no matter in which colour, and what is painted over something else takes nothing away. Numbers are kept to
//! seven digits.

use super::fault::{Fault, Place};
use crate::shape::outline::{MOST_PIECES, Pen, Rule};
use glam::DVec2;
use usvg::roxmltree::{Document, ParsingOptions};
use usvg::tiny_skia_path::{PathSegment, Point, Transform};

/// Elements within elements; copies of copies go on from there, as far as `usvg` lets them.
const DEEPEST: usize = 200;

/// Letters of paths, times the copies that may be made of them, beyond which a drawing is refused: those in memory are many
/// times as long.
const LONGEST: usize = 300_000_000;

/// Dashes of one line.
const MOST_DASHES: f32 = 1e5;

/// The largest error of the edge of a stroke, in sizes of the drawing.
const PRECISION: f32 = 1e-4;

/// What to do about what is no drawing.
const PLAIN: &str = "save the drawing as plain SVG";

/// What is painted.
#[derive(Debug)]
pub struct Drawing {
    /// What covers something, each with what it covers of what it winds around.
    pub layers: Vec<(Pen, Rule)>,
    /// What there is that covers nothing here, in words.
    pub left_out: Vec<&'static str>,
}

/// Reads a drawing: without a size as large as it says, 96 units an inch, its upper left corner at the origin. With one its
/// middle is there, and the longest edge of the box around it is that.
///
/// # Errors
/// When it is no SVG, or there is too much of it.
pub fn read(name: &str, bytes: &[u8], size: Option<f64>) -> Result<Drawing, Fault> {
    let (tree, left_out) = parsed(bytes).map_err(|fault| fault.of(name))?;
    let mut painted = Painted { paths: Vec::new(), left_out, scale: 1.0, pieces: 0 };
    let extent = tree.root().abs_stroke_bounding_box();
    painted.scale = 0.25 / (PRECISION * extent.width().max(extent.height()).max(f32::MIN_POSITIVE));
    painted.group(tree.root());
    if painted.pieces > MOST_PIECES {
        return Err(too_much().of(name));
    }
    let place = placement(&painted.paths, size);
    let layers = painted.paths.iter().map(|(path, rule)| (drawn(path, &place), *rule)).collect();
    painted.left_out.sort_unstable();
    painted.left_out.dedup();
    Ok(Drawing { layers, left_out: painted.left_out })
}

fn too_much() -> Fault {
    Fault::new(Place::Whole, "there is too much in the drawing")
        .remedy("leave out copies of copies, and what is not needed")
}

/// How many letters paths have, with all copies and marks on their corners that may be made of them.
fn length_with_copies(document: &Document<'_>) -> usize {
    let lengths = document.descendants().filter_map(|node| node.attribute("d").or(node.attribute("points")));
    let length: usize = lengths.map(str::len).sum();
    let count = |tag: &str| document.descendants().filter(|node| node.tag_name().name() == tag).count();
    // A corner takes two letters or more.
    let marks = if count("marker") > 0 { length / 2 } else { 0 };
    length.saturating_mul(1 + count("use") + marks)
}

/// The tree of a file, and what in it is not read.
fn parsed(bytes: &[u8]) -> Result<(usvg::Tree, Vec<&'static str>), Fault> {
    let whole = |what: &str, remedy: &'static str| Fault::new(Place::Whole, what).remedy(remedy);
    if bytes.starts_with(&[0x1f, 0x8b]) {
        return Err(whole("the drawing is compressed", PLAIN));
    }
    let text = std::str::from_utf8(bytes).map_err(|_| whole("the file is no text", PLAIN))?;
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|e| {
        let said = e.to_string();
        let what = said.rsplit_once(" at ").map_or(&*said, |(what, _)| what);
        Fault::new(Place::Line(e.pos().row as usize), format!("the drawing is garbled: {what}"))
    })?;
    let first = document.root_element().tag_name().name();
    if first != "svg" {
        return Err(whole(
            &format!("the file is no drawing: `{first}` is its first element, not `svg`"),
            PLAIN,
        ));
    }
    let is_deep = |node: usvg::roxmltree::Node<'_, '_>| node.ancestors().nth(DEEPEST).is_some();
    if document.descendants().any(is_deep) {
        return Err(whole("too many groups lie within groups", "flatten the groups of the drawing"));
    }
    if length_with_copies(&document) > LONGEST {
        return Err(too_much());
    }
    let has = |tag: &str| document.descendants().any(|node| node.tag_name().name() == tag);
    let left_out = [("text", "text (make paths of it)"), ("image", "pictures")];
    let left_out = left_out.into_iter().filter(|(tag, _)| has(tag)).map(|(_, words)| words).collect();
    // Nothing is read but the file itself.
    let resolver = usvg::ImageHrefResolver {
        resolve_data: Box::new(|_, _, _| None),
        resolve_string: Box::new(|_, _| None),
    };
    let options = usvg::Options { image_href_resolver: resolver, ..usvg::Options::default() };
    let tree = usvg::Tree::from_xmltree(&document, &options).map_err(|e| match e {
        usvg::Error::InvalidSize => {
            whole("the drawing has no size", "give it a width and a height, or a viewBox")
        }
        usvg::Error::ElementsLimitReached => too_much(),
        usvg::Error::ParsingFailed(usvg::roxmltree::Error::NodesLimitReached) => too_much(),
        e => whole(&format!("the drawing is not understood: {e}"), PLAIN),
    })?;
    Ok((tree, left_out))
}

/// Paths that are filled, where they are in the drawing.
struct Painted {
    paths: Vec<(usvg::tiny_skia_path::Path, Rule)>,
    left_out: Vec<&'static str>,
    /// How finely the edges of strokes are followed.
    scale: f32,
    /// Pieces of all paths.
    pieces: usize,
}

impl Painted {
    fn group(&mut self, group: &usvg::Group) {
        if group.opacity().get() == 0.0 {
            return;
        }
        if group.clip_path().is_some() || group.mask().is_some() {
            self.left_out.push("clips and masks");
        }
        for node in group.children() {
            match node {
                usvg::Node::Group(group) => self.group(group),
                usvg::Node::Path(path) if path.is_visible() => self.path(path),
                _ => {}
            }
        }
    }

    fn path(&mut self, path: &usvg::Path) {
        let place = path.abs_transform();
        if let Some(fill) = path.fill().filter(|fill| fill.opacity().get() > 0.0) {
            let rule = match fill.rule() {
                usvg::FillRule::NonZero => Rule::NonZero,
                usvg::FillRule::EvenOdd => Rule::EvenOdd,
            };
            self.push(path.data().clone(), place, rule);
        }
        if let Some(stroke) = path.stroke().filter(|stroke| stroke.opacity().get() > 0.0) {
            let stroke = stroke.to_tiny_skia();
            let dashes =
                path.stroke().and_then(usvg::Stroke::dasharray).map(|dashes| dashes.iter().sum::<f32>());
            if dashes.is_some_and(|dashes| length(path.data()) > MOST_DASHES * dashes) {
                self.pieces = usize::MAX;
                return;
            }
            let dashed = stroke.dash.as_ref().and_then(|dash| path.data().dash(dash, self.scale));
            let scale = self.scale * usvg::tiny_skia_path::PathStroker::compute_resolution_scale(&place);
            if let Some(edge) = dashed.as_ref().unwrap_or(path.data()).stroke(&stroke, scale) {
                self.push(edge, place, Rule::NonZero);
            }
        }
    }

    fn push(&mut self, path: usvg::tiny_skia_path::Path, place: Transform, rule: Rule) {
        self.pieces = self.pieces.saturating_add(path.len());
        match path.transform(place) {
            Some(path) if self.pieces <= MOST_PIECES => self.paths.push((path, rule)),
            Some(_) => {}
            None => self.left_out.push("paths with numbers too large or too small"),
        }
    }
}

/// The length of the lines between the points of a path, which no curve between them is longer than.
fn length(path: &usvg::tiny_skia_path::Path) -> f32 {
    path.points().windows(2).map(|pair| pair[0].distance(pair[1])).sum()
}

/// Where a point of the drawing is, in which y goes down.
fn placement(
    paths: &[(usvg::tiny_skia_path::Path, Rule)],
    size: Option<f64>,
) -> impl Fn(Point) -> DVec2 + use<> {
    let boxes = paths.iter().filter_map(|(path, _)| path.compute_tight_bounds());
    let corners = boxes.flat_map(|b| {
        [DVec2::new(b.left().into(), b.top().into()), DVec2::new(b.right().into(), b.bottom().into())]
    });
    let both = corners.map(|p| (p, p)).reduce(|(lo, hi), (p, _)| (lo.min(p), hi.max(p)));
    let extent =
        both.map(|(lo, hi)| (0.5 * (lo + hi), (hi - lo).max_element())).filter(|(_, extent)| *extent > 0.0);
    let (middle, factor) = match (size, extent) {
        (Some(size), Some((middle, extent))) => (middle, size / extent),
        _ => (DVec2::ZERO, 1.0),
    };
    move |p| (DVec2::new(p.x.into(), p.y.into()) - middle) * DVec2::new(factor, -factor)
}

fn drawn(path: &usvg::tiny_skia_path::Path, place: &impl Fn(Point) -> DVec2) -> Pen {
    let mut pen = Pen::default();
    for segment in path.segments() {
        match segment {
            PathSegment::MoveTo(p) => pen.jump(place(p)),
            PathSegment::LineTo(p) => pen.line(place(p)),
            PathSegment::QuadTo(a, p) => pen.quadratic(place(a), place(p)),
            PathSegment::CubicTo(a, b, p) => pen.cubic(place(a), place(b), place(p)),
            PathSegment::Close => pen.close(),
        }
    }
    pen
}
