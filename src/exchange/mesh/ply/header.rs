//! The header of a PLY file: lines that declare the elements of the body.

use crate::exchange::fault::{Fault, Place};
use crate::exchange::text::{shown, words};

/// Kinds of number.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn of(word: &[u8]) -> Option<Kind> {
        Some(match word {
            b"char" | b"int8" => Kind::I8,
            b"uchar" | b"uint8" => Kind::U8,
            b"short" | b"int16" => Kind::I16,
            b"ushort" | b"uint16" => Kind::U16,
            b"int" | b"int32" => Kind::I32,
            b"uint" | b"uint32" => Kind::U32,
            b"float" | b"float32" => Kind::F32,
            b"double" | b"float64" => Kind::F64,
            _ => return None,
        })
    }

    /// Bytes that one takes.
    pub fn size(self) -> usize {
        match self {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::I32 | Kind::U32 | Kind::F32 => 4,
            Kind::F64 => 8,
        }
    }
}

/// A number, or a list of them, that each of some elements has.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Property {
    /// What it is called.
    pub name: Vec<u8>,
    /// The kind of its number or numbers.
    pub kind: Kind,
    /// The kind of the number that says how many follow, if it is a list.
    pub length: Option<Kind>,
}

/// Things of one sort.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Element {
    /// What they are called.
    pub name: Vec<u8>,
    /// How many there are said to be.
    pub count: u64,
    /// What each has, in order.
    pub properties: Vec<Property>,
    /// The line that declares them.
    pub line: usize,
}

/// How the body is written.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Encoding {
    /// Numbers of fixed size, the least byte first.
    Little,
    /// Numbers of fixed size, the greatest byte first.
    Big,
    /// Text; exact, and two to three times as long.
    Text,
}

/// What a header says.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Header {
    /// How the body is written.
    pub encoding: Encoding,
    /// What is in the body, in order.
    pub elements: Vec<Element>,
    /// Bytes of the header.
    pub bytes: usize,
    /// Lines of the header.
    pub lines: usize,
}

impl Header {
    /// Reads the header at the beginning of a file.
    pub fn of(file: &[u8]) -> Result<Header, Fault> {
        let (mut encoding, mut elements) = (None, Vec::new());
        let mut end = 0;
        for (i, text) in file.split_inclusive(|b| *b == b'\n').enumerate() {
            let line = i + 1;
            end += text.len();
            let words: Vec<&[u8]> = words(text).take(6).collect();
            let wrong = |what: String| Fault::new(Place::Line(line), what);
            match words[..] {
                [b"ply"] if line == 1 => {}
                _ if line == 1 => return Err(wrong("a PLY file begins with the word `ply`".into())),
                [b"format", name, _] => {
                    encoding = Some(match name {
                        b"ascii" => Encoding::Text,
                        b"binary_little_endian" => Encoding::Little,
                        b"binary_big_endian" => Encoding::Big,
                        _ => return Err(wrong(format!("the format {} is not known", shown(name)))),
                    });
                }
                [] | [b"comment" | b"obj_info", ..] => {}
                [b"element", name, count] => {
                    let count = std::str::from_utf8(count).ok().and_then(|count| count.parse().ok());
                    let count = count.ok_or_else(|| wrong("an element has no number of them".into()))?;
                    elements.push(Element { name: name.to_owned(), count, properties: Vec::new(), line });
                }
                [b"property", ..] => {
                    let Some(element) = elements.last_mut() else {
                        return Err(wrong("a property is declared before any element".into()));
                    };
                    element.properties.push(property(&words).map_err(wrong)?);
                }
                [b"end_header"] => {
                    let encoding = encoding.ok_or_else(|| wrong("the header declares no format".into()))?;
                    return Ok(Header { encoding, elements, bytes: end, lines: line });
                }
                [word, ..] => {
                    return Err(wrong(format!("{} is no line of a header that makes sense", shown(word))));
                }
            }
        }
        Err(Fault::new(Place::Whole, "the header has no end"))
    }
}

fn property(words: &[&[u8]]) -> Result<Property, String> {
    let kind = |word: &[u8]| Kind::of(word).ok_or_else(|| format!("{} is no kind of number", shown(word)));
    match words {
        [_, b"list", length, item, name] => {
            Ok(Property { name: name.to_vec(), kind: kind(item)?, length: Some(kind(length)?) })
        }
        [_, item, name] => Ok(Property { name: name.to_vec(), kind: kind(item)?, length: None }),
        _ => Err("a property has a kind and a name".into()),
    }
}
