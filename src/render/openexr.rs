//! OpenEXR: linear light and what was seen, in 32-bit floats, with the script in the header.
//!
//! Channels: `R G B A` (premultiplied, without the background, so that "over" composes), `Z`
//! (distance from the eye), `position.X Y Z` and `normal.X Y Z` (of the nearest sample in the
//! pixel, never averages, so that they belong together).

use super::save::SOFTWARE;
use super::{Metadata, Picture, Pixel};
use exr::prelude::*;
use std::io::{self, Seek, Write};

/// Reads one channel of a pixel.
type Read = fn(&Pixel) -> f32;

/// The channels by name.
const CHANNELS: [(&str, Read); 11] = [
    ("R", |p| p.color[0]),
    ("G", |p| p.color[1]),
    ("B", |p| p.color[2]),
    ("A", |p| p.alpha),
    ("Z", |p| p.depth),
    ("position.X", |p| p.position[0]),
    ("position.Y", |p| p.position[1]),
    ("position.Z", |p| p.position[2]),
    ("normal.X", |p| p.normal[0]),
    ("normal.Y", |p| p.normal[1]),
    ("normal.Z", |p| p.normal[2]),
];

/// Writes a picture.
pub(super) fn write(file: impl Write + Seek, picture: &Picture, metadata: &Metadata) -> io::Result<()> {
    let channels = CHANNELS.map(|(name, read)| {
        AnyChannel::new(name, FlatSamples::F32(picture.pixels.iter().map(read).collect()))
    });
    // Lines in order, so that equal pictures make equal files.
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let size = (picture.width as usize, picture.height as usize);
    let channels = AnyChannels::sort(channels.into_iter().collect());
    let software = LayerAttributes { software_name: Some(text(SOFTWARE)), ..LayerAttributes::default() };
    let mut image = Image::from_layer(Layer::new(size, software, encoding, channels));
    let mut add = |name: &str, value| image.attributes.other.insert(text(name), value);
    for (name, value) in metadata.texts() {
        add(&name.to_lowercase(), AttributeValue::Text(text(&value)));
    }
    add("exposure", AttributeValue::F32(picture.exposure as f32));
    let [r, g, b] = picture.background;
    add("background", AttributeValue::FloatVec3((r, g, b)));
    image.write().to_buffered(file).map_err(|error| match error {
        Error::Io(error) => error,
        other => io::Error::other(other.to_string()),
    })
}

/// Attributes are bytes; texts go in as UTF-8. (The library takes one character a byte.)
fn text(s: &str) -> Text {
    Text::new_or_none(s.bytes().map(char::from).collect::<String>()).unwrap_or_default()
}
