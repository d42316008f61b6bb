//! Numbers from and to OpenEXR pictures.

use super::{Image, checked, no_channel};
use crate::exchange::fault::{Fault, Place};
use exr::block::UncompressedBlock;
use exr::block::reader::ChunksReader;
use exr::error::UnitResult;
use exr::image::Image as Picture;
use exr::meta::header::Header;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, Error, FlatSamples, Layer, LayerAttributes,
    LineOrder, SampleType, Text, Vec2, WritableImage, f16,
};
use std::io::{self, Cursor, Seek, Write};

/// Bytes that the pixels of a part may have, all channels together, for each pixel that is possible.
/// They pass by in blocks, and those of other channels are dropped.
const DEPTH: usize = 64;

/// What is chosen where nothing is asked for.
const USUAL: [&str; 3] = ["Y", "R", "Z"];

pub(super) fn read(bytes: &[u8], channel: Option<&str>, most: usize) -> Result<Image, Fault> {
    let damaged = |error| match error {
        Error::NotSupported(what) => Fault::new(Place::Whole, format!("pictures with {what} are not read"))
            .remedy("save the picture in another way"),
        other => Fault::new(Place::Whole, format!("the picture cannot be read: {other}")),
    };
    let reader = exr::block::read(Cursor::new(bytes), false).map_err(damaged)?;
    let (layer, channel) = choose(reader.headers(), channel)?;
    let header = &reader.headers()[layer];
    let Vec2(width, height) = header.layer_size;
    let count = checked(width, height, most)?;
    if header.channels.bytes_per_pixel.checked_mul(count).is_none_or(|all| all > DEPTH.saturating_mul(most)) {
        let what = "all channels of the picture together are too large";
        return Err(Fault::new(Place::Whole, what).remedy("save one channel alone, or a smaller picture"));
    }
    // What no block of the file fills stays what no number is.
    let mut values = vec![f64::NAN; count];
    let channels = header.channels.clone();
    let insert = |block: UncompressedBlock| {
        for line in block.lines(&channels).filter(|line| line.location.channel == channel) {
            let Vec2(x, y) = line.location.position;
            let start = y.saturating_mul(width).saturating_add(x);
            let row = values.get_mut(start..).unwrap_or_default().iter_mut();
            match channels.list[channel].sample_type {
                SampleType::F16 => fill(row, line.read_samples::<f16>(), |v| v.to_f64())?,
                SampleType::F32 => fill(row, line.read_samples::<f32>(), f64::from)?,
                SampleType::U32 => fill(row, line.read_samples::<u32>(), f64::from)?,
            }
        }
        Ok(())
    };
    read_blocks(reader, layer, insert).map_err(damaged)?;
    Ok(Image { width, height, values })
}

/// Passes the blocks of one part, in full resolution, to a function.
fn read_blocks(
    reader: exr::block::reader::Reader<Cursor<&[u8]>>,
    layer: usize,
    mut insert: impl FnMut(UncompressedBlock) -> UnitResult,
) -> UnitResult {
    let chunks =
        reader.filter_chunks(false, |_, _, block| block.layer == layer && block.level == Vec2(0, 0))?;
    chunks.decompress_sequential(false, |_, block| insert(block))
}

fn fill<'a, T>(
    row: impl Iterator<Item = &'a mut f64>,
    samples: impl Iterator<Item = exr::error::Result<T>>,
    number: impl Fn(T) -> f64,
) -> UnitResult {
    for (value, sample) in row.zip(samples) {
        *value = number(sample?);
    }
    Ok(())
}

/// The number of the part and of the channel in it that is wanted.
fn choose(headers: &[Header], wanted: Option<&str>) -> Result<(usize, usize), Fault> {
    let all: Vec<(usize, usize, String)> = headers
        .iter()
        .enumerate()
        .flat_map(|(layer, header)| {
            let part = header.own_attributes.layer_name.as_ref().filter(|_| headers.len() > 1);
            header.channels.list.iter().enumerate().map(move |(i, channel)| {
                let name = part.map_or(channel.name.to_string(), |part| format!("{part}.{}", channel.name));
                (layer, i, name)
            })
        })
        .collect();
    let called = |name: &str| {
        let short = |(layer, i, _): &&(usize, usize, String)| headers[*layer].channels.list[*i].name.eq(name);
        all.iter().find(|(.., full)| full == name).or_else(|| all.iter().find(short))
    };
    let found = match (wanted, &all[..]) {
        (Some(name), _) => called(name),
        (None, [only]) => Some(only),
        (None, _) => USUAL.iter().find_map(|name| called(name)),
    };
    let names = || all.iter().map(|(.., name)| name.clone());
    let (layer, channel, name) = found.ok_or_else(|| no_channel(wanted.unwrap_or("Y"), names()))?;
    let header = &headers[*layer];
    let unfit = match () {
        () if header.deep => "is deep: it has several numbers a pixel",
        // Its decoder counts on numbers that only honest files have.
        () if matches!(header.compression, Compression::B44 | Compression::B44A) => "is compressed as B44",
        () if header.channels.list[*channel].sampling != Vec2(1, 1) => "has fewer numbers than pixels",
        () => return Ok((*layer, *channel)),
    };
    Err(Fault::new(Place::Whole, format!("the channel {name:?} {unfit}"))
        .remedy("save it in another way, such as lines compressed as ZIP"))
}

/// Writes a picture of one channel, `Y`, in 32 bits.
///
/// # Errors
/// When `out` fails; [`io::ErrorKind::InvalidInput`] when there are not as many numbers as pixels, or one
/// is not finite in 32 bits.
pub fn write(image: &Image, out: impl Write + Seek) -> io::Result<()> {
    let Image { width, height, values } = image;
    let unfit = |what| Err(io::Error::new(io::ErrorKind::InvalidInput, what));
    if width.checked_mul(*height) != Some(values.len()) {
        return unfit("there are not as many numbers as pixels");
    }
    let values: Vec<f32> = values.iter().map(|v| *v as f32).collect();
    if values.iter().any(|v| !v.is_finite()) {
        return unfit("a number is not finite in 32 bits");
    }
    let samples = FlatSamples::F32(values);
    // Lines in order, so that equal pictures make equal files.
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let channels = AnyChannels::sort([AnyChannel::new("Y", samples)].into_iter().collect());
    let attributes =
        LayerAttributes { software_name: Text::new_or_none("orogen"), ..LayerAttributes::default() };
    let image = Picture::from_layer(Layer::new((*width, *height), attributes, encoding, channels));
    image.write().to_buffered(out).map_err(|error| match error {
        Error::Io(error) => error,
        other => io::Error::other(other.to_string()),
    })
}
