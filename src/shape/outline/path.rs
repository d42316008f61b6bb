//! Path data as SVG writes them: `M 0 0 L 1 0 Q 1 1 0 1 Z`.
//!
//! ```text
//! M m (x y)+                move              H h x+   V v y+           level, upright line
//! L l (x y)+                line              Z z                       close
//! C c (x1 y1 x2 y2 x y)+    cubic             S s (x2 y2 x y)+          cubic that goes on smoothly
//! Q q (x1 y1 x y)+          parabola          T t (x y)+                parabola that goes on smoothly
//! A a (rx ry angle large sweep x y)+          arc of an ellipse
//! ```
//!
//! Small letters count from where the pen is. Arcs become cubics of a 32nd of a turn or less, which
//! depart from them by less than 10^-9 of their size.

use super::Pen;
use glam::DVec2;
use std::f64::consts::TAU;

/// A text that is no path.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("the path is garbled at character {at}: {wanted} expected, {found}")]
pub struct Garbled {
    /// Which character, from 1.
    pub at: usize,
    /// What should be there.
    pub wanted: &'static str,
    /// What is there.
    pub found: String,
}

/// Draws a path. In its text y goes down, as on a screen; here it goes up, so that a drawing looks as it
/// does there.
///
/// # Errors
/// Where the text is no path.
pub fn drawn(text: &str) -> Result<Pen, Garbled> {
    let mut plotter = Plotter {
        reader: Reader { text, at: 0 },
        pen: Pen::default(),
        here: DVec2::ZERO,
        start: DVec2::ZERO,
        pull: None,
    };
    plotter.run()?;
    Ok(plotter.pen)
}

/// Reads letters and numbers.
struct Reader<'a> {
    text: &'a str,
    at: usize,
}

impl Reader<'_> {
    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    fn skip(&mut self) {
        let rest = self.rest().trim_start_matches(|c: char| c.is_whitespace() || c == ',');
        self.at = self.text.len() - rest.len();
    }

    fn garbled(&self, wanted: &'static str) -> Garbled {
        let found = match self.rest().chars().next() {
            Some(c) => format!("not {c:?}"),
            None => "not the end".to_owned(),
        };
        Garbled { at: self.text[..self.at].chars().count() + 1, wanted, found }
    }

    /// The next command letter, if there is one.
    fn letter(&mut self) -> Option<char> {
        self.skip();
        let c = self.rest().chars().next().filter(char::is_ascii_alphabetic)?;
        self.at += 1;
        Some(c)
    }

    /// Whether a number comes next.
    fn has_number(&mut self) -> bool {
        self.skip();
        self.rest().starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.'))
    }

    /// A number; it ends where it cannot go on, as in `1-2` and `.5.5`.
    fn number(&mut self) -> Result<f64, Garbled> {
        self.skip();
        let bytes = self.rest().as_bytes();
        let digits = |from: usize| bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
        let sign = |at: usize| usize::from(matches!(bytes.get(at), Some(b'+' | b'-')));
        let mut end = sign(0);
        end += digits(end);
        if bytes.get(end) == Some(&b'.') {
            end += 1 + digits(end + 1);
        }
        if matches!(bytes.get(end), Some(b'e' | b'E')) {
            let power = end + 1 + sign(end + 1);
            let count = digits(power);
            end = if count > 0 { power + count } else { end };
        }
        let value = self.rest()[..end].parse().map_err(|_| self.garbled("a number"))?;
        self.at += end;
        Ok(value)
    }

    /// A flag of an arc, which needs nothing after it.
    fn flag(&mut self) -> Result<bool, Garbled> {
        self.skip();
        let flag = match self.rest().as_bytes().first() {
            Some(b'0') => false,
            Some(b'1') => true,
            _ => return Err(self.garbled("a flag, 0 or 1,")),
        };
        self.at += 1;
        Ok(flag)
    }
}

/// Draws what is read.
struct Plotter<'a> {
    reader: Reader<'a>,
    pen: Pen,
    /// Where the pen is and where the loop began, as the text counts.
    here: DVec2,
    start: DVec2,
    /// The last point that a curve was pulled to, and whether that was a cubic.
    pull: Option<(DVec2, bool)>,
}

fn upright(p: DVec2) -> DVec2 {
    DVec2::new(p.x, -p.y)
}

impl Plotter<'_> {
    fn run(&mut self) -> Result<(), Garbled> {
        let mut first = true;
        while let Some(letter) = self.reader.letter() {
            if first && !matches!(letter, 'M' | 'm') {
                self.reader.at -= 1;
                return Err(self.reader.garbled("a move, M or m,"));
            }
            first = false;
            if matches!(letter, 'Z' | 'z') {
                self.pen.close();
                self.here = self.start;
                self.pull = None;
                continue;
            }
            let mut letter = letter;
            loop {
                self.command(letter)?;
                // More points after a move are lines.
                letter = match letter {
                    'M' => 'L',
                    'm' => 'l',
                    other => other,
                };
                if !self.reader.has_number() {
                    break;
                }
            }
        }
        if first || !self.reader.rest().is_empty() {
            return Err(self.reader.garbled("a command such as M, L or Z"));
        }
        Ok(())
    }

    /// A point, absolute or relative.
    fn point(&mut self, relative: bool) -> Result<DVec2, Garbled> {
        let p = DVec2::new(self.reader.number()?, self.reader.number()?);
        Ok(if relative { self.here + p } else { p })
    }

    fn command(&mut self, letter: char) -> Result<(), Garbled> {
        let relative = letter.is_ascii_lowercase();
        let base = if relative { self.here } else { DVec2::ZERO };
        let pull = self.pull.take();
        // The last pull, mirrored, if the last curve was of the same kind.
        let smooth = |here: DVec2, cubic: bool| match pull {
            Some((p, kind)) if kind == cubic => 2.0 * here - p,
            _ => here,
        };
        let here = self.here;
        let to = match letter.to_ascii_uppercase() {
            'M' => {
                let to = self.point(relative)?;
                self.pen.jump(upright(to));
                self.start = to;
                to
            }
            'L' => self.line(|p| p.point(relative))?,
            'H' => self.line(|p| Ok(DVec2::new(base.x + p.reader.number()?, here.y)))?,
            'V' => self.line(|p| Ok(DVec2::new(here.x, base.y + p.reader.number()?)))?,
            kind @ ('C' | 'S') => {
                let a = if kind == 'C' { self.point(relative)? } else { smooth(here, true) };
                let (b, to) = (self.point(relative)?, self.point(relative)?);
                self.pen.cubic(upright(a), upright(b), upright(to));
                self.pull = Some((b, true));
                to
            }
            kind @ ('Q' | 'T') => {
                let a = if kind == 'Q' { self.point(relative)? } else { smooth(here, false) };
                let to = self.point(relative)?;
                self.pen.quadratic(upright(a), upright(to));
                self.pull = Some((a, false));
                to
            }
            'A' => {
                let radii = DVec2::new(self.reader.number()?, self.reader.number()?).abs();
                let turn = self.reader.number()?.to_radians();
                let (large, sweep) = (self.reader.flag()?, self.reader.flag()?);
                let to = self.point(relative)?;
                self.arc(radii, turn, large, sweep, to);
                to
            }
            _ => {
                self.reader.at -= 1;
                return Err(self.reader.garbled("a command such as M, L or Z"));
            }
        };
        self.here = to;
        Ok(())
    }

    fn line(&mut self, end: impl Fn(&mut Self) -> Result<DVec2, Garbled>) -> Result<DVec2, Garbled> {
        let to = end(self)?;
        self.pen.line(upright(to));
        Ok(to)
    }

    /// An arc of an ellipse from here. Where the ellipse is a circle of radius 1, both ends lie on it:
    /// its centre is on the bisector of their chord. Radii that are too small grow until there is one.
    fn arc(&mut self, radii: DVec2, turn: f64, large: bool, sweep: bool, to: DVec2) {
        let axis = DVec2::new(libm::cos(turn), libm::sin(turn));
        let round = |p: DVec2| DVec2::new(p.dot(axis), p.dot(axis.perp())) / radii;
        let half = 0.5 * round(to - self.here);
        let size = half.length();
        if radii.min_element() == 0.0 || size == 0.0 {
            self.pen.line(upright(to));
            return;
        }
        let grown = size.max(1.0);
        let half = half / grown;
        let side = (1.0 - half.length_squared()).max(0.0).sqrt() / half.length();
        let to_centre = half + half.perp() * if large == sweep { -side } else { side };
        let angle = |v: DVec2| libm::atan2(v.y, v.x);
        let (from, end) = (angle(-to_centre), angle(2.0 * half - to_centre));
        let full = (end - from).rem_euclid(TAU);
        let sweep = if sweep { full } else { full - TAU };
        let steps = (sweep.abs() / TAU * 32.0).ceil().max(1.0);
        let plain = |v: DVec2| {
            let v = v * radii * grown;
            v.x * axis + v.y * axis.perp()
        };
        let centre = self.here + plain(to_centre);
        let pull = 4.0 / 3.0 * libm::tan(sweep / steps / 4.0);
        let on = |k: f64| {
            let a = from + sweep * k / steps;
            DVec2::new(libm::cos(a), libm::sin(a))
        };
        for k in 0..steps as usize {
            let [a, b] = [k as f64, k as f64 + 1.0].map(on);
            let last = k as f64 + 1.0 == steps;
            let place = |v: DVec2| upright(centre + plain(v));
            let end = if last { upright(to) } else { place(b) };
            self.pen.cubic(place(a + pull * a.perp()), place(b - pull * b.perp()), end);
        }
    }
}
