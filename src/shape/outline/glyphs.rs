//! Letters as outlines.

use super::Pen;
use glam::DVec2;
use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// A font, read from a TrueType or OpenType file.
#[derive(Clone, Debug)]
pub struct Font<'a>(Face<'a>);

/// On which side the lines of a text are flush.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Align {
    /// They begin at x = 0.
    Left,
    /// x = 0 is their middle.
    Center,
    /// They end at x = 0.
    Right,
}

/// How a text is set.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Layout {
    /// Height of the font's square, about that of a line without the gap to the next.
    pub size: f64,
    /// How lines are aligned.
    pub align: Align,
    /// Distance of lines, in sizes.
    pub leading: f64,
}

impl<'a> Font<'a> {
    /// The font in the bytes of a file, the first one if it holds several.
    pub fn new(bytes: &'a [u8]) -> Option<Font<'a>> {
        Face::parse(bytes, 0).ok().filter(|face| face.units_per_em() > 0).map(Font)
    }

    /// Draws a text: the first line stands on y = 0, the others below. Letters that the font kerns move
    /// together. Letters that it does not have are its box for those.
    pub fn write(&self, text: &str, layout: &Layout) -> Pen {
        let scale = layout.size / f64::from(self.0.units_per_em());
        let mut pen = Pen::default();
        for (number, line) in text.lines().enumerate() {
            let letters = self.placed(line);
            let width = letters.1;
            let start = match layout.align {
                Align::Left => 0.0,
                Align::Center => -0.5 * width,
                Align::Right => -width,
            };
            let y = -(number as f64) * layout.leading * layout.size;
            for (glyph, x) in letters.0 {
                let at = DVec2::new((start + x) * scale, y);
                self.0.outline_glyph(glyph, &mut Nib { pen: &mut pen, at, scale });
            }
        }
        pen
    }

    /// The characters of a text that it has no letters for, each once.
    pub fn missing(&self, text: &str) -> Vec<char> {
        let mut missing: Vec<char> = Vec::new();
        for c in text.lines().flat_map(seen) {
            if self.0.glyph_index(c).is_none() && !missing.contains(&c) {
                missing.push(c);
            }
        }
        missing
    }

    /// The letters of a line and where they begin, and where it ends, in the font's units.
    fn placed(&self, line: &str) -> (Vec<(GlyphId, f64)>, f64) {
        let (mut x, mut before) = (0.0, None);
        let mut letters = Vec::new();
        for c in seen(line) {
            let glyph = self.0.glyph_index(c).unwrap_or(GlyphId(0));
            x += before.map_or(0.0, |before| self.kerning(before, glyph));
            letters.push((glyph, x));
            x += f64::from(self.0.glyph_hor_advance(glyph).unwrap_or(0));
            before = Some(glyph);
        }
        (letters, x)
    }

    /// How far two letters move together.
    fn kerning(&self, left: GlyphId, right: GlyphId) -> f64 {
        let tables = self.0.tables().kern.into_iter().flat_map(|kern| kern.subtables);
        let plain = tables.filter(|t| t.horizontal && !t.variable && !t.has_cross_stream);
        plain.filter_map(|t| t.glyphs_kerning(left, right)).map(f64::from).next().unwrap_or(0.0)
    }
}

/// The characters of a line but those that only tell how to break, join and order others.
fn seen(line: &str) -> impl Iterator<Item = char> {
    line.chars().filter(|c| !matches!(c, '\u{ad}' | '\u{200b}'..='\u{200f}' | '\u{2060}' | '\u{feff}'))
}

/// Whether a text has letters of scripts that are written from right to left (Hebrew to Arabic, by their blocks), not in
/// the forms that joined ones have.
pub fn runs_left(text: &str) -> bool {
    let is_digit = |c| matches!(c, '\u{660}'..='\u{66c}' | '\u{6f0}'..='\u{6f9}');
    text.chars().any(|c| matches!(c, '\u{590}'..='\u{8ff}') && !is_digit(c))
}

/// Draws one letter.
struct Nib<'a> {
    pen: &'a mut Pen,
    at: DVec2,
    scale: f64,
}

impl Nib<'_> {
    fn place(&self, x: f32, y: f32) -> DVec2 {
        self.at + self.scale * DVec2::new(f64::from(x), f64::from(y))
    }
}

impl OutlineBuilder for Nib<'_> {
    fn move_to(&mut self, x: f32, y: f32) {
        self.pen.jump(self.place(x, y));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.pen.line(self.place(x, y));
    }

    fn quad_to(&mut self, px: f32, py: f32, x: f32, y: f32) {
        self.pen.quadratic(self.place(px, py), self.place(x, y));
    }

    fn curve_to(&mut self, ax: f32, ay: f32, bx: f32, by: f32, x: f32, y: f32) {
        self.pen.cubic(self.place(ax, ay), self.place(bx, by), self.place(x, y));
    }

    fn close(&mut self) {
        self.pen.close();
    }
}
