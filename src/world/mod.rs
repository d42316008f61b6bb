//! Where bytes come from and go to: the disk, the embedded standard library, or a test.
//!
//! The layers above read scripts only through a [`World`], so that a script host can be tested
//! without files, and so that what a script touched is known and can be watched.

pub mod atomic;
pub mod claim;
pub mod scratch;
pub mod store;
pub mod watch;

use std::collections::BTreeMap;
use std::fs::Metadata;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use store::Store;

/// A source of files.
pub trait World {
    /// The text of a file.
    ///
    /// # Errors
    /// As for reading a file; text that is not UTF-8 is [`io::ErrorKind::InvalidData`].
    fn read(&self, path: &Path) -> io::Result<Arc<str>> {
        let bytes = self.bytes(path)?;
        let text = std::str::from_utf8(&bytes).map_err(|e| io::Error::new(io::ErrorKind::InvalidData, e))?;
        // Some editors begin files with a mark of their encoding.
        Ok(Arc::from(text.trim_start_matches('\u{feff}')))
    }

    /// The bytes of a file.
    ///
    /// # Errors
    /// As for reading a file.
    fn bytes(&self, path: &Path) -> io::Result<Arc<[u8]>>;

    /// Where what took long to find is kept for the next run; nowhere, unless a world says otherwise.
    fn store(&self) -> Option<Store> {
        None
    }
}

/// The file system.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disk;

impl World for Disk {
    fn bytes(&self, path: &Path) -> io::Result<Arc<[u8]>> {
        match endless(path, &std::fs::metadata(path)?) {
            Some(why) => Err(io::Error::new(io::ErrorKind::InvalidInput, why)),
            None => std::fs::read(path).map(Arc::from),
        }
    }

    fn store(&self) -> Option<Store> {
        Store::of_user()
    }
}

/// Why reading something might not come to an end.
#[cfg(unix)]
fn endless(path: &Path, file: &Metadata) -> Option<&'static str> {
    use std::os::unix::fs::FileTypeExt;
    let kind = file.file_type();
    if kind.is_char_device() || kind.is_block_device() {
        return Some("it is a device, which may have no end");
    }
    // What a shell gives as a file, `<(command)`, has somebody who writes to it.
    let is_given = ["/dev/fd", "/dev/stdin", "/proc"].iter().any(|given| path.starts_with(given));
    let is_named = kind.is_fifo() && !is_given;
    is_named.then_some("it is a named pipe, to which perhaps nobody writes")
}

#[cfg(not(unix))]
fn endless(_: &Path, _: &Metadata) -> Option<&'static str> {
    None
}

/// Files of another world as they were when they were first asked for: a job that asks again and again, as that of an
/// animation does for every frame, is of one piece, whoever saves something meanwhile.
#[derive(Debug, Default)]
pub struct Kept<W> {
    world: W,
    seen: Mutex<BTreeMap<PathBuf, Option<Arc<[u8]>>>>,
}

impl<W: World> World for Kept<W> {
    fn bytes(&self, path: &Path) -> io::Result<Arc<[u8]>> {
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = seen.get(path) {
            return known.clone().ok_or_else(|| io::ErrorKind::NotFound.into());
        }
        let found = self.world.bytes(path);
        match &found {
            Ok(bytes) => seen.insert(path.to_owned(), Some(bytes.clone())),
            Err(error) if error.kind() == io::ErrorKind::NotFound => seen.insert(path.to_owned(), None),
            Err(_) => None,
        };
        found
    }

    fn store(&self) -> Option<Store> {
        self.world.store()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_stays_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let [there, gone] = ["there", "gone"].map(|name| folder.path().join(name));
        std::fs::write(&there, "then").unwrap();
        let kept = Kept::<Disk>::default();
        let ask = || (kept.read(&there).unwrap(), kept.read(&gone).map_err(|e| e.kind()));
        let before = ask();
        std::fs::write(&there, "now").unwrap();
        std::fs::write(&gone, "now").unwrap();
        assert_eq!(ask(), before);
        assert_eq!(before, ("then".into(), Err(io::ErrorKind::NotFound)));
    }

    #[cfg(unix)]
    #[test]
    fn devices_and_named_pipes_are_not_read() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        for path in [Path::new("/dev/zero"), &pipe] {
            assert_eq!(Disk.bytes(path).unwrap_err().kind(), io::ErrorKind::InvalidInput);
        }
    }

    #[test]
    fn a_mark_of_the_encoding_is_no_text() {
        let world = Memory([("a".into(), "\u{feff}sphere(1.0)".to_owned())].into());
        assert_eq!(&*world.read(Path::new("a")).unwrap(), "sphere(1.0)");
    }
}
