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
    let mut image = Image::from_layer(Layer::new(size, about(picture), encoding, channels));
    // The library keeps such attributes in hash maps, in any order. With one in the map of the image
    // and one in that of its layer, equal pictures still make equal files.
    let layer = &mut image.layer_data.attributes.other;
    image.attributes.other.insert(text("script"), AttributeValue::Text(text(&metadata.script)));
    layer.insert(text("parameters"), AttributeValue::Text(text(&metadata.parameters())));
    image.write().to_buffered(file).map_err(|error| match error {
        Error::Io(error) => error,
        other => io::Error::other(other.to_string()),
    })
}

/// Standard attributes: who made the picture, and how to read it.
fn about(picture: &Picture) -> LayerAttributes {
    let [r, g, b] = picture.background;
    let comments = format!(
        "Linear light, Rec. 709 primaries, premultiplied; background {r} {g} {b} left out; exposure \
         {} stops left out. Z is the distance from the eye; Z, position and normal are those of the \
         nearest sample in a pixel.",
        picture.exposure
    );
    LayerAttributes {
        software_name: Some(text(SOFTWARE)),
        comments: Some(text(&comments)),
        ..LayerAttributes::default()
    }
}

/// Attributes are bytes; texts go in as UTF-8. (The library takes one character a byte.)
fn text(s: &str) -> Text {
    Text::new_or_none(s.bytes().map(char::from).collect::<String>()).unwrap_or_default()
}
