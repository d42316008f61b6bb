//! The bytes of a glTF file and the numbers in them.

use super::at;
use super::json::{Accessor, Buffer, BufferView, Gltf};
use crate::exchange::fault::Fault;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::borrow::Cow;

/// The bytes of all buffers.
pub struct Data<'a> {
    accessors: &'a [Accessor],
    views: &'a [BufferView],
    buffers: Vec<Cow<'a, [u8]>>,
}

/// What an accessor shows; every item lies within the bytes.
pub struct Items<'a> {
    bytes: &'a [u8],
    stride: usize,
    kind: Kind,
    normalized: bool,
    /// How many there are.
    pub count: usize,
}

/// Kinds of number.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl<'a> Data<'a> {
    /// The buffers of a file, with its binary part.
    ///
    /// # Errors
    /// When bytes are missing, or in another file.
    pub fn of(gltf: &'a Gltf<'_>, binary: Option<&'a [u8]>) -> Result<Self, Fault> {
        let bytes = |(i, buffer): (usize, &'a Buffer<'_>)| {
            let bytes = bytes(buffer, if i == 0 { binary } else { None }, i)?;
            if bytes.len() < buffer.byte_length {
                let what = format!("the buffer has {} bytes and not {}", bytes.len(), buffer.byte_length);
                return Err(at(format!("buffers[{i}]"), what));
            }
            Ok(bytes)
        };
        let buffers = gltf.buffers.iter().enumerate().map(bytes).collect::<Result<_, _>>()?;
        Ok(Data { accessors: &gltf.accessors, views: &gltf.buffer_views, buffers })
    }

    /// The items of an accessor that has one of these shapes.
    ///
    /// # Errors
    /// When it leaves the bytes, or is something else.
    pub fn items(&self, accessor: usize, shapes: &[&str]) -> Result<Items<'_>, Fault> {
        let place = || format!("accessors[{accessor}]");
        let found = self.accessors.get(accessor).ok_or_else(|| at(place(), "there is no such accessor"))?;
        if found.sparse.is_some() || found.buffer_view.is_none() {
            return Err(at(place(), "sparse accessors are not read")
                .remedy("write the file without sparse accessors"));
        }
        if !shapes.contains(&found.shape.as_str()) {
            let what =
                format!("the accessor holds items {:?}, and {} is needed", found.shape, shapes.join(" or "));
            return Err(at(place(), what));
        }
        let numbers = if found.shape == "VEC4" {
            4
        } else if found.shape == "VEC3" {
            3
        } else {
            1
        };
        let kind = Kind::of(found.component_type)
            .ok_or_else(|| at(place(), format!("{} is no type of components", found.component_type)))?;
        let size = numbers * kind.size();
        let view = self.view(found.buffer_view.unwrap_or_default())?;
        let stride = view.1.unwrap_or(size);
        if stride < size {
            return Err(at(place(), format!("items of {size} bytes are {stride} bytes apart")));
        }
        let end = found.count.checked_sub(1).and_then(|gaps| gaps.checked_mul(stride)?.checked_add(size));
        let end = end.and_then(|length| length.checked_add(found.byte_offset));
        match end.and_then(|end| view.0.get(found.byte_offset..end)) {
            Some(bytes) => {
                Ok(Items { bytes, stride, kind, normalized: found.normalized, count: found.count })
            }
            None => {
                let what =
                    format!("{} items leave the {} bytes that there are for them", found.count, view.0.len());
                Err(at(place(), what))
            }
        }
    }

    /// A part of a buffer, and the distance of its items.
    fn view(&self, view: usize) -> Result<(&[u8], Option<usize>), Fault> {
        let place = || format!("bufferViews[{view}]");
        let found = self.views.get(view).ok_or_else(|| at(place(), "there is no such part of a buffer"))?;
        let buffer = self.buffers.get(found.buffer).ok_or_else(|| at(place(), "there is no such buffer"))?;
        let end = found.byte_offset.checked_add(found.byte_length);
        let bytes = end.and_then(|end| buffer.get(found.byte_offset..end));
        let bytes = bytes
            .ok_or_else(|| at(place(), format!("it leaves the {} bytes of the buffer", buffer.len())))?;
        Ok((bytes, found.byte_stride))
    }
}

/// The bytes of buffer `i`.
fn bytes<'a>(buffer: &'a Buffer<'_>, binary: Option<&'a [u8]>, i: usize) -> Result<Cow<'a, [u8]>, Fault> {
    let place = || format!("buffers[{i}].uri");
    let Some(uri) = &buffer.uri else {
        let none = || at(format!("buffers[{i}]"), "the buffer has no data");
        return binary.map(Cow::Borrowed).ok_or_else(none);
    };
    let Some((about, data)) = uri.strip_prefix("data:").and_then(|uri| uri.split_once(',')) else {
        let name: String = uri.chars().take(40).collect();
        return Err(at(place(), format!("the data are in another file, {name:?}"))
            .remedy("write the mesh as .glb, which is one file"));
    };
    if !about.ends_with(";base64") {
        return Err(at(place(), "the data are not written in base64").remedy("write the mesh as .glb"));
    }
    STANDARD.decode(data).map(Cow::Owned).map_err(|e| at(place(), format!("the data are not in base64: {e}")))
}

impl Items<'_> {
    /// The number of a point.
    pub fn index(&self, i: usize) -> Option<u32> {
        let bytes = self.bytes.get(i * self.stride..)?;
        match (self.kind, bytes) {
            (Kind::U8, [a, ..]) => Some(u32::from(*a)),
            (Kind::U16, [a, b, ..]) => Some(u32::from(u16::from_le_bytes([*a, *b]))),
            (Kind::U32, [a, b, c, d, ..]) => Some(u32::from_le_bytes([*a, *b, *c, *d])),
            _ => None,
        }
    }

    /// The first three numbers of an item.
    pub fn three(&self, i: usize) -> [f64; 3] {
        let start = i * self.stride;
        std::array::from_fn(|k| self.number(start + k * self.kind.size()))
    }

    /// The number at a byte.
    fn number(&self, start: usize) -> f64 {
        let whole = |x: f64, most: f64| if self.normalized { (x / most).max(-1.0) } else { x };
        match (self.kind, self.bytes.get(start..).unwrap_or_default()) {
            (Kind::I8, [a, ..]) => whole(f64::from(*a as i8), 127.0),
            (Kind::U8, [a, ..]) => whole(f64::from(*a), 255.0),
            (Kind::I16, [a, b, ..]) => whole(f64::from(i16::from_le_bytes([*a, *b])), 32767.0),
            (Kind::U16, [a, b, ..]) => whole(f64::from(u16::from_le_bytes([*a, *b])), 65535.0),
            (Kind::U32, [a, b, c, d, ..]) => f64::from(u32::from_le_bytes([*a, *b, *c, *d])),
            (Kind::F32, [a, b, c, d, ..]) => f64::from(f32::from_le_bytes([*a, *b, *c, *d])),
            _ => f64::NAN,
        }
    }
}

impl Kind {
    fn of(code: u32) -> Option<Kind> {
        Some(match code {
            5120 => Kind::I8,
            5121 => Kind::U8,
            5122 => Kind::I16,
            5123 => Kind::U16,
            5125 => Kind::U32,
            5126 => Kind::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::U32 | Kind::F32 => 4,
        }
    }
}
