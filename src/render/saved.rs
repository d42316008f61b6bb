//! Pictures read back from their files: to put parts together, and to tell whether a frame is there.
//!
//! A file is read to its end before anything is said about it, so one that was cut off, as by a copy that was broken off,
//! is never taken for a whole one.

use super::{About, Format, SaveError, openexr, png};
use crate::world::atomic;
use std::fs::File;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};

/// A picture, or a part of one, as it was in a file.
#[derive(Clone, Debug)]
pub struct Saved {
    /// The file.
    pub path: PathBuf,
    /// What it says about the picture.
    pub about: About,
    pub(super) content: Content,
}

/// The pixels of the window, as they are in the file.
#[derive(Clone, Debug)]
pub(super) enum Content {
    /// Red, green and blue of every pixel, row by row.
    Png(Vec<u8>),
    /// The channels, each row by row.
    OpenExr(Box<openexr::Sheet>),
}

/// Why a picture was not read.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The ending of the name is none of ours.
    #[error(transparent)]
    Ending(#[from] SaveError),
    /// The system does not give the file.
    #[error("cannot read {path:?} ({source}); check its name and permissions")]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// It is not a picture that this program made.
    #[error("{0:?} is not a picture that orogen made, so what it is a part of is not known; leave it out")]
    Foreign(PathBuf),
    /// It is cut off, or its bytes are not those that were written.
    #[error("{path:?} is damaged ({source}); render it again")]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: io::Error,
    },
}

impl Saved {
    /// Reads a picture.
    ///
    /// # Errors
    /// [`OpenError`] names the file and what to do about it.
    pub fn open(path: &Path) -> Result<Saved, OpenError> {
        let format = Format::of(path)?;
        let file = File::open(path);
        let file = file.map_err(|source| OpenError::Unreadable { path: path.to_owned(), source })?;
        let file = BufReader::with_capacity(1 << 16, file);
        let read = match format {
            Format::Png => png::read(file).map(|(about, bytes)| (about, Content::Png(bytes))),
            Format::OpenExr => {
                openexr::read(file).map(|(about, sheet)| (about, Content::OpenExr(Box::new(sheet))))
            }
        };
        match read {
            Ok((about, content)) => Ok(Saved { path: path.to_owned(), about, content }),
            Err(source) if source.kind() == io::ErrorKind::Unsupported => {
                Err(OpenError::Foreign(path.to_owned()))
            }
            Err(source) => Err(OpenError::Damaged { path: path.to_owned(), source }),
        }
    }

    /// Writes the picture to its file, with the bytes that it has when it is rendered and saved.
    ///
    /// # Errors
    /// [`SaveError`] with the path and what to do about it.
    pub fn write(self) -> Result<(), SaveError> {
        let Saved { path, about, content } = self;
        atomic::write(&path, |file| match content {
            Content::Png(bytes) => {
                png::write(file, &about, bytes.chunks_exact(3 * about.window.width as usize))
            }
            Content::OpenExr(sheet) => openexr::write(file, &about, *sheet),
        })?;
        Ok(())
    }
}
