//! Pictures as arrays of numbers: heights, masks, slices of volumes.
//!
//! | ending | read | written |
//! |---|---|---|
//! | `.png` | 8 and 16 bits, grey or in colours, with palettes too: from 0 to 1 | 16 bits, grey: from 0 to 1 |
//! | `.exr` | 16 and 32 bits, any channel of any part: as it is | 32 bits, one channel: as it is |
//!
//! Numbers are taken as they are stored; no transfer function is undone, since heights have none. Pictures
//! are written in bands of rows, which are asked for one after the other, so that a picture may be larger than
//! memory.

mod openexr;
mod png;

pub use openexr::{write, write_exr};
pub use png::write_png;

use super::fault::{Fault, Place, ending};
use std::io;

/// One number for each pixel.
#[derive(Clone, PartialEq, Debug)]
pub struct Image {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Numbers, row by row from the top.
    pub values: Vec<f64>,
}

/// A picture that is written in bands.
#[derive(Clone, Copy, Debug)]
pub struct Sheet<'a> {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// What the file says about itself: names, and texts in Latin letters.
    pub notes: &'a [(&'a str, String)],
}

/// Fills a band with the next numbers, row by row from the top.
pub type Rows<'a> = &'a mut dyn FnMut(&mut [f64]) -> io::Result<()>;

/// Rows in a band; the last may have fewer. Both formats pack rows together in numbers that divide this.
pub const BAND: u32 = 64;

impl Sheet<'_> {
    /// Asks for all bands, and passes each on with the number of its first row.
    pub fn bands(
        &self,
        rows: Rows<'_>,
        mut put: impl FnMut(u32, &[f64]) -> io::Result<()>,
    ) -> io::Result<()> {
        let width = self.width as usize;
        let mut band = vec![0.0; width * BAND.min(self.height) as usize];
        for first in (0..self.height).step_by(BAND as usize) {
            let band = &mut band[..width * BAND.min(self.height - first) as usize];
            rows(band)?;
            put(first, band)?;
        }
        Ok(())
    }
}

/// Reads one channel of a picture of `most` pixels at most, in the format that the ending of the file's
/// name says.
///
/// Without a name for it the channel is the brightness of a PNG, and of an EXR the first that there is
/// of `Y`, `R` and `Z`, or the only one. With one it is `Y` (brightness), `R`, `G`, `B` or `A` of a
/// PNG, and whatever an EXR calls so, after the name of its part and a dot if there are several parts.
///
/// # Errors
/// When the ending is neither, the file is damaged or too large, has no such channel, or a number in it
/// is not finite.
pub fn read(name: &str, bytes: &[u8], channel: Option<&str>, most: usize) -> Result<Image, Fault> {
    let image = match ending(name).as_str() {
        "png" => png::read(bytes, channel, most),
        "exr" => openexr::read(bytes, channel, most),
        _ => {
            let fault =
                Fault::new(Place::Whole, "the ending of the name is that of no known kind of picture");
            Err(fault.remedy("heights are read from files that end with .png or .exr"))
        }
    };
    let image = image.map_err(|fault| fault.of(name))?;
    match image.values.iter().position(|v| !v.is_finite()) {
        None => Ok(image),
        Some(i) => {
            let (x, y) = (i % image.width, i / image.width);
            let what = format!("the number of pixel ({x}, {y}) is {}, which is not finite", image.values[i]);
            let fault = Fault::new(Place::Whole, what);
            Err(fault.remedy("choose another channel, or fill what is empty in it").of(name))
        }
    }
}

/// The number of pixels, unless there are none or too many.
fn checked(width: usize, height: usize, most: usize) -> Result<usize, Fault> {
    width.checked_mul(height).filter(|count| (1..=most).contains(count)).ok_or_else(|| {
        let what = format!("the picture has {width} x {height} pixels, and {most} are possible");
        Fault::new(Place::Whole, what).remedy("make it smaller")
    })
}

/// A channel that is not there.
fn no_channel(wanted: &str, there: impl IntoIterator<Item = String>) -> Fault {
    let names: Vec<String> = there.into_iter().take(30).collect();
    Fault::new(Place::Whole, format!("the picture has no channel {wanted:?}"))
        .remedy(format!("its channels are {}", names.join(", ")))
}
