//! Pictures to files: the ending of the name picks the format, and the file appears whole or not
//! at all.

use super::{About, Picture, openexr, png};
use crate::scene::Value;
use crate::world::atomic::{self, WriteError};
use std::io;
use std::path::{Path, PathBuf};

/// A picture format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 8-bit sRGB for screens, on the background.
    Png,
    /// Linear light in floats, with alpha, depth, positions and normals.
    OpenExr,
}

impl Format {
    /// All formats, with the endings of their files.
    pub const ALL: [(Format, &'static str); 2] = [(Format::Png, "png"), (Format::OpenExr, "exr")];

    /// The format that the ending of a path stands for.
    ///
    /// # Errors
    /// [`SaveError::Ending`] lists the endings that there are.
    pub fn of(path: &Path) -> Result<Format, SaveError> {
        let ending = path.extension().unwrap_or_default();
        Format::ALL
            .into_iter()
            .find(|(_, known)| ending.eq_ignore_ascii_case(known))
            .map(|(format, _)| format)
            .ok_or_else(|| SaveError::Ending { path: path.to_owned() })
    }
}

/// Name and version of the program.
pub const SOFTWARE: &str = concat!("orogen ", env!("CARGO_PKG_VERSION"));

/// How closely a file of floats holds light. Places and directions have 32 bits always.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// 32 bits: all that was computed.
    #[default]
    Float,
    /// 16 bits: three decimal digits, from 6e-8 to 65 504, in about half the space.
    Half,
}

/// What a file says about how its picture came about.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metadata {
    /// Text of the script.
    pub script: String,
    /// Parameters with the values used.
    pub params: Vec<(String, Value)>,
    /// What the picture was made of and how, in lines: two pictures with the same recipe are the same. Empty where
    /// nobody needs to know.
    pub recipe: String,
}

impl Metadata {
    /// The parameters as a text, one a line.
    pub(super) fn parameters(&self) -> String {
        let lines: Vec<String> = self.params.iter().map(|(name, value)| format!("{name}={value}")).collect();
        lines.join("\n")
    }
}

/// Why a picture was not saved.
#[derive(Debug, thiserror::Error)]
pub enum SaveError {
    /// The name does not say which format is meant.
    #[error("{path:?} does not end in a known picture format; use .png or .exr")]
    Ending {
        /// The path.
        path: PathBuf,
    },
    /// The file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Whether a picture could be saved there; to be asked before minutes are spent on rendering it.
///
/// # Errors
/// The error that [`save`] would give.
pub fn can_save(path: &Path) -> Result<Format, SaveError> {
    let format = Format::of(path)?;
    atomic::check(path)?;
    Ok(format)
}

/// Saves a picture in the format that its path asks for, in 32 bits if those are floats. An earlier file is replaced
/// only once the new one is complete.
///
/// # Errors
/// [`SaveError`] with the path and what to do about it.
pub fn save(path: &Path, picture: &Picture, metadata: &Metadata) -> Result<(), SaveError> {
    save_as(path, picture, metadata, Precision::Float)
}

/// The same as [`save`], as closely as is asked for.
///
/// # Errors
/// [`SaveError`] with the path and what to do about it.
pub fn save_as(
    path: &Path,
    picture: &Picture,
    metadata: &Metadata,
    precision: Precision,
) -> Result<(), SaveError> {
    let format = Format::of(path)?;
    let about = About::new(picture, metadata);
    atomic::write(path, |file| match format {
        Format::Png => {
            let rows = picture.window.y..picture.window.bottom();
            png::write(file, &about, rows.map(|y| picture.row_bytes(y)))
        }
        Format::OpenExr => openexr::write(file, &about, openexr::sheet(picture, precision)),
    })?;
    Ok(())
}

/// The bytes of a PNG of a picture.
///
/// # Errors
/// What the encoder says.
pub fn png_bytes(picture: &Picture, metadata: &Metadata) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let rows = picture.window.y..picture.window.bottom();
    png::write(&mut bytes, &About::new(picture, metadata), rows.map(|y| picture.row_bytes(y)))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endings() {
        assert_eq!(Format::of(Path::new("a/b.PNG")).unwrap(), Format::Png);
        assert_eq!(Format::of(Path::new("b.exr")).unwrap(), Format::OpenExr);
        for bad in ["b.jpg", "b", ".png"] {
            let error = Format::of(Path::new(bad)).unwrap_err().to_string();
            assert!(Format::ALL.iter().all(|(_, ending)| error.contains(ending)), "{error}");
        }
    }
}
