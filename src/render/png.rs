//! PNG: 8-bit sRGB on the background, with the script in text chunks.

use super::save::SOFTWARE;
use super::{Metadata, Picture};
use png::{BitDepth, ColorType, Compression, Encoder, EncodingError, SrgbRenderingIntent};
use std::io::{self, Write};

/// Writes a picture row by row, so that no second copy of it is held.
pub(super) fn write(file: impl Write, picture: &Picture, metadata: &Metadata) -> io::Result<()> {
    let mut encoder = Encoder::new(file, picture.width, picture.height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    // Dithered pictures hardly get smaller with more effort, only later.
    encoder.set_compression(Compression::Fast);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    encoder.add_text_chunk("Software".to_owned(), SOFTWARE.to_owned()).map_err(io_error)?;
    for (name, text) in [("Script", metadata.script.clone()), ("Parameters", metadata.parameters())] {
        encoder.add_itxt_chunk(name.to_owned(), text).map_err(io_error)?;
    }
    let mut writer = encoder.write_header().map_err(io_error)?;
    let mut rows = writer.stream_writer().map_err(io_error)?;
    // Not in the thread pool: a picture is also written while the pool is busy with the next one.
    for y in 0..picture.height {
        rows.write_all(&picture.row_bytes(y))?;
    }
    rows.finish().map_err(io_error)?;
    writer.finish().map_err(io_error)
}

fn io_error(error: EncodingError) -> io::Error {
    match error {
        EncodingError::IoError(error) => error,
        other => io::Error::other(other),
    }
}
