//! Where bytes come from and go to: the disk, the embedded standard library, or a test.
//!
//! The layers above read scripts only through a [`World`], so that a script host can be tested
//! without files, and so that what a script touched is known and can be watched.

pub mod atomic;
pub mod watch;

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A source of texts.
pub trait World {
    /// The text of a file.
    ///
    /// # Errors
    /// As for reading a file; text that is not UTF-8 is [`io::ErrorKind::InvalidData`].
    fn read(&self, path: &Path) -> io::Result<Arc<str>>;
}

/// The file system.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disk;

impl World for Disk {
    fn read(&self, path: &Path) -> io::Result<Arc<str>> {
        std::fs::read_to_string(path).map(Arc::from)
    }
}

/// Files in memory.
#[derive(Clone, Debug, Default)]
pub struct Memory(pub BTreeMap<PathBuf, String>);

impl World for Memory {
    fn read(&self, path: &Path) -> io::Result<Arc<str>> {
        self.0.get(path).map(|text| Arc::from(text.as_str())).ok_or_else(|| io::ErrorKind::NotFound.into())
    }
}
