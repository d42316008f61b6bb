//! Numbers from and to OpenEXR pictures.

use super::{Image, Rows, Sheet, checked, no_channel};
use crate::exchange::fault::{Fault, Place};
use exr::block::chunk::Chunk;
use exr::block::reader::ChunksReader;
use exr::block::writer::ChunksWriter;
use exr::block::{BlockIndex, UncompressedBlock};
use exr::error::UnitResult;
use exr::meta::BlockDescription;
use exr::meta::header::Header;
use exr::prelude::{
    ChannelDescription, Compression, Error, LayerAttributes, LineOrder, MetaData, SampleType, Text, Vec2, f16,
};
use rayon::prelude::*;
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
    let (Ok(columns), Ok(lines)) = (u32::try_from(*width), u32::try_from(*height)) else {
        return unfit("the picture is too large");
    };
    if width.checked_mul(*height) != Some(values.len()) {
        return unfit("there are not as many numbers as pixels");
    }
    if values.iter().any(|v| v.is_nan()) {
        return unfit(BEYOND);
    }
    let mut rest = &values[..];
    write_exr(&Sheet { width: columns, height: lines, notes: &[] }, out, &mut |band| {
        let (next, after) = rest.split_at(band.len());
        band.copy_from_slice(next);
        rest = after;
        Ok(())
    })
}

const BEYOND: &str = "a number is not finite in 32 bits";

fn unfit<T>(what: &str) -> io::Result<T> {
    Err(io::Error::new(io::ErrorKind::InvalidInput, what))
}

/// Writes a picture of one channel, `Y`, in 32 bits, band by band. A number may be NaN: nothing is there.
///
/// # Errors
/// When `out` or `rows` fails; [`io::ErrorKind::InvalidInput`] when a number is infinite in 32 bits.
pub fn write_exr(sheet: &Sheet<'_>, out: impl Write + Seek, rows: Rows<'_>) -> io::Result<()> {
    // The library has errors of its own; this one is to come out as it went in.
    let mut failed = None;
    let written = exr::block::write(out, [header(sheet)].into_iter().collect(), true, |meta, chunks| {
        let written = sheet.bands(rows, |first, band| {
            let packed = pack(sheet, &meta, first, band)?;
            for (i, chunk) in (first as usize / LINES..).zip(packed) {
                chunks.write_chunk(i, chunk).map_err(io_error)?;
            }
            Ok(())
        });
        written.map_err(|error| {
            failed = Some(error);
            Error::Aborted
        })
    });
    match failed {
        Some(error) => Err(error),
        None => written.map_err(io_error),
    }
}

/// Lines that are compressed together.
const LINES: usize = Compression::ZIP16.scan_lines_per_block();

fn header(sheet: &Sheet<'_>) -> Header {
    let channels = [ChannelDescription::named("Y", SampleType::F32)].into_iter().collect();
    let size = (sheet.width as usize, sheet.height as usize);
    let notes: Vec<String> = sheet.notes.iter().map(|(name, text)| format!("{name}: {text}")).collect();
    let attributes = LayerAttributes {
        software_name: Text::new_or_none("orogen"),
        comments: Text::new_or_none(notes.join("; ")).filter(|_| !notes.is_empty()),
        ..LayerAttributes::default()
    };
    // Lines in order, so that equal pictures make equal files.
    Header::new(Text::default(), size, channels)
        .with_encoding(Compression::ZIP16, BlockDescription::ScanLines, LineOrder::Increasing)
        .with_attributes(attributes)
}

/// The lines of a band, compressed.
fn pack(sheet: &Sheet<'_>, meta: &MetaData, first: u32, band: &[f64]) -> io::Result<Vec<Chunk>> {
    let width = sheet.width as usize;
    let parts = band.par_chunks(LINES * width).enumerate();
    let packed = parts.map(|(i, lines)| {
        let mut data = Vec::with_capacity(4 * lines.len());
        for value in lines {
            let single = *value as f32;
            if single.is_infinite() {
                return unfit(BEYOND);
            }
            data.extend(single.to_ne_bytes());
        }
        let index = BlockIndex {
            layer: 0,
            pixel_position: Vec2(0, first as usize + i * LINES),
            pixel_size: Vec2(width, lines.len() / width),
            level: Vec2(0, 0),
        };
        UncompressedBlock { index, data }.compress_to_chunk(&meta.headers).map_err(io_error)
    });
    packed.collect()
}

fn io_error(error: Error) -> io::Error {
    match error {
        Error::Io(error) => error,
        other => io::Error::other(other.to_string()),
    }
}
