//! Heights from and to PNG pictures.

use super::{Image, Rows, Sheet, checked, no_channel};
use crate::exchange::fault::{Fault, Place};
use png::{
    BitDepth, ColorType, DecodeOptions, Decoder, DecodingError, Encoder, EncodingError, Transformations,
};
use std::io::{self, Cursor, Write};

/// Bytes that one byte of deflated data can become at most: a symbol of two bits for 258 bytes.
const MOST_INFLATED: usize = 1032;

/// How bright the primaries of Rec. 709 are.
const BRIGHTNESS: [f64; 3] = [0.2126, 0.7152, 0.0722];

pub(super) fn read(bytes: &[u8], channel: Option<&str>, most: usize) -> Result<Image, Fault> {
    let mut options = DecodeOptions::default();
    options.set_ignore_text_chunk(true);
    options.set_ignore_iccp_chunk(true);
    let mut decoder = Decoder::new_with_options(Cursor::new(bytes), options);
    decoder.set_transformations(Transformations::EXPAND);
    let damaged =
        |error: DecodingError| Fault::new(Place::Whole, format!("the picture cannot be read: {error}"));
    let header = decoder.read_header_info().map_err(damaged)?;
    let (width, height) = (header.width as usize, header.height as usize);
    let count = checked(width, height, most)?;
    // Each pixel is a bit or more, and room is made for all of them at once.
    if count / 8 > bytes.len().saturating_mul(MOST_INFLATED) {
        let what = format!("{width} x {height} pixels cannot be in {} bytes", bytes.len());
        return Err(Fault::new(Place::Whole, what));
    }
    let mut reader = decoder.read_info().map_err(damaged)?;
    let too_large = || Fault::new(Place::Whole, "the picture is too large").remedy("make it smaller");
    let mut pixels = vec![0; reader.output_buffer_size().ok_or_else(too_large)?];
    reader.next_frame(&mut pixels).map_err(damaged)?;
    let (color, depth) = reader.output_color_type();
    let weights = weights(color, channel)?;
    let wide = depth == BitDepth::Sixteen;
    let sample = |pixel: &[u8], k: usize| match wide {
        true => f64::from(u16::from_be_bytes([pixel[2 * k], pixel[2 * k + 1]])) / 65535.0,
        false => f64::from(pixel[k]) / 255.0,
    };
    let value = |pixel: &[u8]| weights.iter().map(|(k, weight)| weight * sample(pixel, *k)).sum();
    let bytes = color.samples() * if wide { 2 } else { 1 };
    Ok(Image { width, height, values: pixels.chunks_exact(bytes).map(value).collect() })
}

/// What a channel is made of: samples of a pixel, and how much each counts.
fn weights(color: ColorType, channel: Option<&str>) -> Result<Vec<(usize, f64)>, Fault> {
    let names: &[&str] = match color {
        ColorType::GrayscaleAlpha => &["Y", "A"],
        ColorType::Rgb => &["R", "G", "B"],
        ColorType::Rgba => &["R", "G", "B", "A"],
        // Palettes are expanded to colours.
        ColorType::Grayscale | ColorType::Indexed => &["Y"],
    };
    let wanted = channel.unwrap_or("Y");
    match names.iter().position(|name| *name == wanted) {
        Some(k) => Ok(vec![(k, 1.0)]),
        None if wanted == "Y" => Ok(BRIGHTNESS.into_iter().enumerate().collect()),
        None => Err(no_channel(wanted, names.iter().map(|name| (*name).to_owned()))),
    }
}

/// Writes a grey picture in 16 bits, band by band, of numbers from 0 to 1. Those that are less or NaN become
/// black, those that are more white.
///
/// # Errors
/// When `out` or `rows` fails.
pub fn write_png(sheet: &Sheet<'_>, out: impl Write, rows: Rows<'_>) -> io::Result<()> {
    let mut encoder = Encoder::new(out, sheet.width, sheet.height);
    encoder.set_color(ColorType::Grayscale);
    encoder.set_depth(BitDepth::Sixteen);
    encoder.add_text_chunk("Software".to_owned(), "orogen".to_owned()).map_err(io_error)?;
    for (name, text) in sheet.notes {
        encoder.add_text_chunk((*name).to_owned(), text.clone()).map_err(io_error)?;
    }
    let mut writer = encoder.write_header().map_err(io_error)?;
    let mut pixels = writer.stream_writer().map_err(io_error)?;
    let mut bytes = Vec::new();
    sheet.bands(rows, |_, band| {
        bytes.clear();
        // The cast saturates, and takes NaN to zero.
        bytes.extend(band.iter().flat_map(|v| ((v * 65535.0).round() as u16).to_be_bytes()));
        pixels.write_all(&bytes)
    })?;
    pixels.finish().map_err(io_error)?;
    writer.finish().map_err(io_error)
}

fn io_error(error: EncodingError) -> io::Error {
    match error {
        EncodingError::IoError(error) => error,
        other => io::Error::other(other),
    }
}
