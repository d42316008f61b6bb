//! PNG: 8-bit sRGB on the background, with the script in text chunks.
//!
//! A file that holds a part of a picture holds its pixels only. Where they are, and in how large a picture, is a text of
//! its own: `320,200,64x48 of 800x600`.

use super::save::SOFTWARE;
use super::{About, Rect};
use crate::scene::Film;
use png::{
    BitDepth, ColorType, Compression, Decoder, DecodingError, Encoder, EncodingError, SrgbRenderingIntent,
};
use std::io::{self, BufRead, Seek, Write};

/// Writes the rows of a picture's window, one by one, so that no second copy of it is held.
pub(super) fn write<R: AsRef<[u8]>>(
    file: impl Write,
    about: &About,
    rows: impl Iterator<Item = R>,
) -> io::Result<()> {
    let mut encoder = Encoder::new(file, about.window.width, about.window.height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    // Dithered pictures hardly get smaller with more effort, only later.
    encoder.set_compression(Compression::Fast);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    encoder.add_text_chunk("Software".to_owned(), SOFTWARE.to_owned()).map_err(io_error)?;
    let window = if about.is_whole() { String::new() } else { window_text(about) };
    let texts = [("Recipe", &about.recipe), ("Window", &window)];
    let texts = texts.into_iter().filter(|(_, text)| !text.is_empty());
    for (name, text) in
        [("Script", &about.script), ("Parameters", &about.parameters)].into_iter().chain(texts)
    {
        encoder.add_itxt_chunk(name.to_owned(), text.clone()).map_err(io_error)?;
    }
    let mut writer = encoder.write_header().map_err(io_error)?;
    let mut stream = writer.stream_writer().map_err(io_error)?;
    // Not in the thread pool: a picture is also written while the pool is busy with the next one.
    for row in rows {
        stream.write_all(row.as_ref())?;
    }
    stream.finish().map_err(io_error)?;
    writer.finish().map_err(io_error)
}

/// Reads what [`write`] wrote: all of it, so that a file whose end is missing is found out.
///
/// # Errors
/// [`io::ErrorKind::Unsupported`] for a picture that is not ours; otherwise what is wrong with the file.
pub(super) fn read(file: impl BufRead + Seek) -> io::Result<(About, Vec<u8>)> {
    let mut reader = Decoder::new(file).read_info().map_err(reading)?;
    let info = reader.info();
    if (info.color_type, info.bit_depth) != (ColorType::Rgb, BitDepth::Eight)
        || info.width.max(info.height) > Film::MAX_SIDE
    {
        return Err(io::ErrorKind::Unsupported.into());
    }
    let text = |name: &str| info.utf8_text.iter().find(|t| t.keyword == name).and_then(|t| t.get_text().ok());
    let held = (info.width, info.height);
    let (window, (width, height)) = match text("Window") {
        None => (Rect::whole(held.0, held.1), held),
        Some(text) => window_of(&text).ok_or(io::ErrorKind::InvalidData)?,
    };
    let about = About {
        width,
        height,
        window,
        script: text("Script").ok_or(io::ErrorKind::Unsupported)?,
        parameters: text("Parameters").unwrap_or_default(),
        recipe: text("Recipe").unwrap_or_default(),
    };
    if (window.width, window.height) != held || !Rect::whole(width, height).holds(&window) {
        return Err(io::ErrorKind::InvalidData.into());
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(3 * window.area() as usize).map_err(|_| io::ErrorKind::OutOfMemory)?;
    bytes.resize(3 * window.area() as usize, 0);
    reader.next_frame(&mut bytes).map_err(reading)?;
    reader.finish().map_err(reading)?;
    Ok((about, bytes))
}

fn window_text(about: &About) -> String {
    format!("{} of {}x{}", about.window, about.width, about.height)
}

/// The window and the size of the whole picture.
fn window_of(text: &str) -> Option<(Rect, (u32, u32))> {
    let (window, size) = text.split_once(" of ")?;
    let (width, height) = size.split_once('x')?;
    let side = |s: &str| s.parse().ok().filter(|side| (1..=Film::MAX_SIDE).contains(side));
    Some((window.parse().ok()?, (side(width)?, side(height)?)))
}

fn io_error(error: EncodingError) -> io::Error {
    match error {
        EncodingError::IoError(error) => error,
        other => io::Error::other(other),
    }
}

fn reading(error: DecodingError) -> io::Error {
    match error {
        DecodingError::IoError(error) => error,
        other => io::Error::new(io::ErrorKind::InvalidData, other),
    }
}
