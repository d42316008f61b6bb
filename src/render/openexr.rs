//! OpenEXR: linear light and what was seen, in floats, with the script in the header.
//!
//! Channels, by layers as their names say:
//!
//! | channels | |
//! |---|---|
//! | `R G B A` | all light, premultiplied, without the background, so that "over" composes |
//! | `direct` | of that, what the solid gives off, or reflects straight from a light |
//! | `indirect` | of that, what it reflects from the sky and from elsewhere on the solid |
//! | `sky` | of that, what comes from the air and from what is behind everything |
//! | `albedo` | share of light that the solid reflects |
//! | `denoised` | all light with its noise smoothed, if that was wanted |
//! | `Z`, `position.X Y Z`, `normal.X Y Z`, `footprint` | distance, place, direction and distance between pixels of the nearest sample, never averages, so that they belong together |
//! | `samples` | how many samples were taken |
//! | `component` | which component of the solid the nearest sample shows, if that was wanted: its number, or -1 where it is none or not known |
//!
//! The display window is the whole picture, the data window the part of it that the file holds.

use super::save::SOFTWARE;
use super::{About, Picture, Pixel, Precision, Rect};
use crate::scene::Film;
use exr::prelude::*;
use std::io::{self, BufRead, Seek, Write};

/// Reads one channel of a pixel.
type Read = fn(&Pixel) -> f32;

/// What a channel holds.
#[derive(Clone, Copy, PartialEq)]
enum Content {
    /// Light and shares of it, for which eleven bits can do.
    Light,
    /// Places and directions, for which they cannot.
    Geometry,
}

/// The channels by name.
const CHANNELS: [(&str, Content, Read); 25] = [
    ("R", Content::Light, |p| p.color[0]),
    ("G", Content::Light, |p| p.color[1]),
    ("B", Content::Light, |p| p.color[2]),
    ("A", Content::Light, |p| p.alpha),
    ("direct.R", Content::Light, |p| p.direct[0]),
    ("direct.G", Content::Light, |p| p.direct[1]),
    ("direct.B", Content::Light, |p| p.direct[2]),
    ("indirect.R", Content::Light, |p| p.indirect[0]),
    ("indirect.G", Content::Light, |p| p.indirect[1]),
    ("indirect.B", Content::Light, |p| p.indirect[2]),
    ("sky.R", Content::Light, |p| p.sky[0]),
    ("sky.G", Content::Light, |p| p.sky[1]),
    ("sky.B", Content::Light, |p| p.sky[2]),
    ("albedo.R", Content::Light, |p| p.albedo[0]),
    ("albedo.G", Content::Light, |p| p.albedo[1]),
    ("albedo.B", Content::Light, |p| p.albedo[2]),
    ("footprint", Content::Geometry, |p| p.footprint),
    ("samples", Content::Geometry, |p| p.samples),
    ("Z", Content::Geometry, |p| p.depth),
    ("position.X", Content::Geometry, |p| p.position[0]),
    ("position.Y", Content::Geometry, |p| p.position[1]),
    ("position.Z", Content::Geometry, |p| p.position[2]),
    ("normal.X", Content::Geometry, |p| p.normal[0]),
    ("normal.Y", Content::Geometry, |p| p.normal[1]),
    ("normal.Z", Content::Geometry, |p| p.normal[2]),
];

/// What stands before the recipe in the comments.
const RECIPE: &str = "\n\nRecipe:\n";

/// Channels as they are in a file, and what the file says of how to read them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sheet {
    channels: AnyChannels<FlatSamples>,
    comments: String,
}

/// The channels of a picture.
pub(super) fn sheet(picture: &Picture, precision: Precision) -> Sheet {
    let channels = CHANNELS.map(|(name, content, read)| {
        AnyChannel::new(name, samples_of(picture.pixels.iter().map(read), precision, content))
    });
    let smoothed = picture.denoised.iter().flat_map(|colors| {
        ["R", "G", "B"].into_iter().enumerate().map(|(c, name)| {
            let values = colors.iter().map(|color| color[c]);
            AnyChannel::new(
                format!("denoised.{name}").as_str(),
                samples_of(values, precision, Content::Light),
            )
        })
    });
    let components = picture.components.iter().map(|numbers| {
        let values = numbers.iter().map(|number| number.map_or(-1.0, |number| number as f32));
        AnyChannel::new("component", samples_of(values, precision, Content::Geometry))
    });
    let [r, g, b] = picture.background;
    let comments = format!(
        "Linear light, Rec. 709 primaries, premultiplied; background {r} {g} {b} left out; exposure \
         {} stops left out. Z is the distance from the eye; Z, position and normal are those of the \
         nearest sample in a pixel.",
        picture.exposure
    );
    Sheet {
        channels: AnyChannels::sort(channels.into_iter().chain(smoothed).chain(components).collect()),
        comments,
    }
}

/// Values as a file holds them.
fn samples_of(values: impl Iterator<Item = f32>, precision: Precision, content: Content) -> FlatSamples {
    match (precision, content) {
        (Precision::Half, Content::Light) => FlatSamples::F16(values.map(half_of).collect()),
        _ => FlatSamples::F32(values.collect()),
    }
}

/// The nearest half. What is brighter than all of them becomes the brightest, since infinite light spoils whatever it is
/// added to.
fn half_of(x: f32) -> f16 {
    let most = f16::MAX.to_f32();
    f16::from_f32(if x.is_finite() { x.clamp(-most, most) } else { x })
}

/// Writes a picture.
pub(super) fn write(file: impl Write + Seek, about: &About, sheet: Sheet) -> io::Result<()> {
    // Lines in order, so that equal pictures make equal files.
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let recipe = if about.recipe.is_empty() { String::new() } else { format!("{RECIPE}{}", about.recipe) };
    let attributes = LayerAttributes {
        layer_position: Vec2(about.window.x as i32, about.window.y as i32),
        software_name: Some(text(SOFTWARE)),
        comments: Some(text(&(format!("{}{recipe}", sheet.comments)))),
        ..LayerAttributes::default()
    };
    let size = (about.window.width as usize, about.window.height as usize);
    let mut image = Image::from_layer(Layer::new(size, attributes, encoding, sheet.channels));
    image.attributes.display_window =
        IntegerBounds::from_dimensions((about.width as usize, about.height as usize));
    // The library keeps such attributes in hash maps, in any order. With one in the map of the image
    // and one in that of its layer, equal pictures still make equal files.
    let layer = &mut image.layer_data.attributes.other;
    image.attributes.other.insert(text("script"), AttributeValue::Text(text(&about.script)));
    layer.insert(text("parameters"), AttributeValue::Text(text(&about.parameters)));
    image.write().to_buffered(file).map_err(io_error)
}

/// Reads what [`write`] wrote: all of it, so that a file whose end is missing is found out.
///
/// # Errors
/// [`io::ErrorKind::Unsupported`] for a picture that is not ours; otherwise what is wrong with the file.
pub(super) fn read(file: impl BufRead + Seek) -> io::Result<(About, Sheet)> {
    let reader = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels();
    let reader = reader.first_valid_layer().all_attributes().pedantic();
    let Image { attributes: image, layer_data: layer } = reader.from_buffered(file).map_err(io_error)?;
    let ours = || io::Error::from(io::ErrorKind::Unsupported);
    let attribute = |name: &str| match layer.attributes.other.get(&text(name)) {
        Some(AttributeValue::Text(found)) => Some(untext(found)),
        _ => None,
    };
    let script = attribute("script").ok_or_else(ours)?;
    let parameters = attribute("parameters").ok_or_else(ours)?;
    let comments = layer.attributes.comments.as_ref().map(untext).unwrap_or_default();
    let (comments, recipe) = comments.split_once(RECIPE).unwrap_or((&comments, ""));
    let Vec2(width, height) = image.display_window.size;
    let Vec2(x, y) = layer.attributes.layer_position;
    let side = |n: usize| u32::try_from(n).ok().filter(|n| (1..=Film::MAX_SIDE).contains(n)).ok_or_else(ours);
    let start = |n: i32| u32::try_from(n).map_err(|_| ours());
    let (width, height) = (side(width)?, side(height)?);
    let window = Rect { x: start(x)?, y: start(y)?, width: side(layer.size.0)?, height: side(layer.size.1)? };
    if image.display_window.position != Vec2(0, 0) || !Rect::whole(width, height).holds(&window) {
        return Err(ours());
    }
    let about = About { width, height, window, script, parameters, recipe: recipe.to_owned() };
    Ok((about, Sheet { channels: layer.channel_data, comments: comments.to_owned() }))
}

impl Sheet {
    /// Whether another has channels of the same names and kinds.
    pub(super) fn is_like(&self, other: &Sheet) -> bool {
        let kind = |s: &FlatSamples| std::mem::discriminant(s);
        let pairs = || self.channels.list.iter().zip(&other.channels.list);
        self.channels.list.len() == other.channels.list.len()
            && self.comments == other.comments
            && pairs().all(|(a, b)| a.name == b.name && kind(&a.sample_data) == kind(&b.sample_data))
    }

    /// The sheet of a whole picture, of those of its parts. There must be one at least, and all alike.
    pub(super) fn joined(parts: &[(Rect, &Sheet)], whole: Rect) -> Option<Sheet> {
        let ((_, first), area) = (parts.first()?, whole.area() as usize);
        let mut channels = first.channels.clone();
        for (i, channel) in channels.list.iter_mut().enumerate() {
            channel.sample_data = match channel.sample_data {
                FlatSamples::F16(_) => FlatSamples::F16(vec![f16::ZERO; area]),
                FlatSamples::F32(_) => FlatSamples::F32(vec![0.0; area]),
                FlatSamples::U32(_) => FlatSamples::U32(vec![0; area]),
            };
            for (window, part) in parts {
                match (&mut channel.sample_data, &part.channels.list.get(i)?.sample_data) {
                    (FlatSamples::F16(all), FlatSamples::F16(part)) => window.put(part, whole, all),
                    (FlatSamples::F32(all), FlatSamples::F32(part)) => window.put(part, whole, all),
                    (FlatSamples::U32(all), FlatSamples::U32(part)) => window.put(part, whole, all),
                    _ => return None,
                }
            }
        }
        Some(Sheet { channels, comments: first.comments.clone() })
    }
}

fn io_error(error: Error) -> io::Error {
    match error {
        Error::Io(error) => error,
        other => io::Error::new(io::ErrorKind::InvalidData, other.to_string()),
    }
}

/// Attributes are bytes; texts go in as UTF-8. (The library takes one character a byte.)
fn text(s: &str) -> Text {
    Text::new_or_none(s.bytes().map(char::from).collect::<String>()).unwrap_or_default()
}

/// The other way round.
fn untext(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}
