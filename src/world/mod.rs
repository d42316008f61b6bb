//! Where bytes come from and go to: the disk, the embedded standard library, or a test.
//!
//! The layers above read scripts only through a [`World`], so that a script host can be tested
//! without files, and so that what a script touched is known and can be watched.

pub mod atomic;
pub mod claim;
pub mod scratch;
pub mod watch;

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A source of files.
pub trait World {
    /// The text of a file.
    ///
    /// # Errors
    /// As for reading a file; text that is not UTF-8 is [`io::ErrorKind::InvalidData`].
    fn read(&self, path: &Path) -> io::Result<Arc<str>> {
        let bytes = self.bytes(path)?;
        let text = std::str::from_utf8(&bytes).map_err(|e| io::Error::new(io::ErrorKind::InvalidData, e))?;
        Ok(Arc::from(text))
    }

    /// The bytes of a file.
    ///
    /// # Errors
    /// As for reading a file.
    fn bytes(&self, path: &Path) -> io::Result<Arc<[u8]>>;
}

/// The file system.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disk;

impl World for Disk {
    fn bytes(&self, path: &Path) -> io::Result<Arc<[u8]>> {
        std::fs::read(path).map(Arc::from)
    }
}

/// Files in memory.
#[derive(Clone, Debug, Default)]
pub struct Memory(pub BTreeMap<PathBuf, String>);

impl World for Memory {
    fn bytes(&self, path: &Path) -> io::Result<Arc<[u8]>> {
        self.0.get(path).map(|text| Arc::from(text.as_bytes())).ok_or_else(|| io::ErrorKind::NotFound.into())
    }
}
