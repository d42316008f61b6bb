//! The numbers of the body of a PLY file, one after another.

use super::header::{Element, Encoding, Header, Kind, Property};
use crate::exchange::fault::{Fault, Place};
use crate::exchange::text::shown;

const ENDED: &str = "the file ends in the middle of its data";

/// What is left of a body.
pub struct Values<'a> {
    rest: &'a [u8],
    encoding: Encoding,
    /// Bytes of the file.
    total: usize,
    line: usize,
}

impl<'a> Values<'a> {
    /// The body of a file.
    pub fn of(file: &'a [u8], header: &Header) -> Self {
        let rest = file.get(header.bytes..).unwrap_or_default();
        Values { rest, encoding: header.encoding, total: file.len(), line: header.lines + 1 }
    }

    /// Where the next number is.
    pub fn place(&mut self) -> Place {
        match self.encoding {
            Encoding::Text => {
                let start = self.rest.iter().position(|b| !b.is_ascii_whitespace());
                let (space, rest) = self.rest.split_at(start.unwrap_or(self.rest.len()));
                self.line += space.iter().filter(|b| **b == b'\n').count();
                self.rest = rest;
                Place::Line(self.line)
            }
            _ => Place::Byte(self.total - self.rest.len()),
        }
    }

    /// Numbers of these kinds that the rest of the file has room for.
    fn room(&self, kinds: impl Iterator<Item = Kind>) -> u64 {
        match self.encoding {
            // A digit and a space, which the last one needs not have.
            Encoding::Text => (self.rest.len() as u64 + 1) / (2 * kinds.count() as u64).max(1),
            _ => self.rest.len() as u64 / (kinds.map(Kind::size).sum::<usize>() as u64).max(1),
        }
    }

    /// How many there are of an element, which the file has room for.
    ///
    /// # Errors
    /// When there is no room.
    pub fn count(&self, element: &Element) -> Result<usize, Fault> {
        // Lists may be empty, so that they are at least their lengths.
        let room = self.room(element.properties.iter().map(|p| p.length.unwrap_or(p.kind)));
        match element.properties.len() {
            // Nothing at all, as often as you like.
            0 => Ok(0),
            _ if element.count <= room => Ok(element.count as usize),
            _ => {
                let (name, count) = (shown(&element.name), element.count);
                let what = format!("{count} of {name} are announced, and the file has room for {room}");
                Err(Fault::new(Place::Line(element.line), what))
            }
        }
    }

    /// The length of a list, which the file has room for.
    ///
    /// # Errors
    /// When there is no room, or it is no length.
    pub fn length(&mut self, kind: Kind, item: Kind) -> Result<usize, Fault> {
        let place = self.place();
        let given = self.number(kind)?;
        let room = self.room(std::iter::once(item));
        if given.fract() == 0.0 && (0.0..=room as f64).contains(&given) {
            return Ok(given as usize);
        }
        Err(Fault::new(place, format!("a list of {given} is announced, and the file has room for {room}")))
    }

    /// Passes over a property.
    ///
    /// # Errors
    /// When the file ends before.
    pub fn skip(&mut self, property: &Property) -> Result<(), Fault> {
        let count = match property.length {
            Some(length) => self.length(length, property.kind)?,
            None => 1,
        };
        match self.encoding {
            Encoding::Text => (0..count).try_for_each(|_| self.word().map(drop)),
            _ => self.bytes(count * property.kind.size()).map(drop),
        }
    }

    /// The next number, which may be infinite or none.
    ///
    /// # Errors
    /// When the file ends before, or a word is no number.
    #[inline]
    pub fn number(&mut self, kind: Kind) -> Result<f64, Fault> {
        match self.encoding {
            Encoding::Text => self.word_as(kind),
            Encoding::Little => self.bytes(kind.size()).map(|bytes| decode(kind, bytes, |b| b)),
            Encoding::Big => self.bytes(kind.size()).map(|bytes| {
                decode(kind, bytes, |mut b| {
                    b[..kind.size()].reverse();
                    b
                })
            }),
        }
    }

    #[inline]
    fn bytes(&mut self, count: usize) -> Result<&'a [u8], Fault> {
        let Some((bytes, rest)) = self.rest.split_at_checked(count) else {
            return Err(Fault::new(self.place(), ENDED));
        };
        self.rest = rest;
        Ok(bytes)
    }

    fn word_as(&mut self, kind: Kind) -> Result<f64, Fault> {
        let word = self.word()?;
        let text = std::str::from_utf8(word).ok();
        // What was written as the shortest text of 32 bits is meant to be just these.
        let number = match kind {
            Kind::F32 => text.and_then(|text| text.parse::<f32>().ok()).map(f64::from),
            _ => text.and_then(|text| text.parse().ok()),
        };
        number.ok_or_else(|| Fault::new(Place::Line(self.line), format!("{} is no number", shown(word))))
    }

    fn word(&mut self) -> Result<&'a [u8], Fault> {
        let place = self.place();
        let end = self.rest.iter().position(u8::is_ascii_whitespace).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        if word.is_empty() { Err(Fault::new(place, ENDED)) } else { Ok(word) }
    }
}

/// A number from its bytes, which `order` puts in order from the least.
#[inline]
fn decode(kind: Kind, bytes: &[u8], order: impl Fn([u8; 8]) -> [u8; 8]) -> f64 {
    let mut all = [0; 8];
    all.iter_mut().zip(bytes).for_each(|(to, from)| *to = *from);
    let all = order(all);
    let [a, b, c, d, ..] = all;
    match kind {
        Kind::I8 => f64::from(a as i8),
        Kind::U8 => f64::from(a),
        Kind::I16 => f64::from(i16::from_le_bytes([a, b])),
        Kind::U16 => f64::from(u16::from_le_bytes([a, b])),
        Kind::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
        Kind::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
        Kind::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
        Kind::F64 => f64::from_le_bytes(all),
    }
}
