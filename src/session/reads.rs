//! A world that remembers what was read from it.
//!
//! That is all of dependency tracking: the result of a script is up to date as long as every file
//! that it read, or tried to read, still reads the same.

use crate::world::World;
use crate::world::store::Store;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What a read gave: the bytes, or the kind of the error.
type Outcome = Result<Arc<[u8]>, io::ErrorKind>;

/// Files that were read, and what they held.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reads(BTreeMap<PathBuf, Outcome>);

impl Reads {
    /// Whether any of the files reads differently now.
    pub fn changed_in(&self, world: &dyn World) -> bool {
        self.0.iter().any(|(path, before)| {
            let now = world.bytes(path).map_err(|e| e.kind());
            now != *before
        })
    }

    /// The files with what they held; `None` for those that could not be read.
    pub fn contents(&self) -> impl Iterator<Item = (&Path, Option<&[u8]>)> {
        self.0.iter().map(|(path, outcome)| (path.as_path(), outcome.as_deref().ok()))
    }

    /// The scripts among them: the main one, whatever its name, and then its modules.
    pub fn scripts<'a>(&'a self, main: &'a Path) -> impl Iterator<Item = (&'a Path, &'a str)> {
        let is_main = move |path: &Path| path == main;
        let is_module = move |path: &Path| path != main && path.extension().is_some_and(|e| e == "rhai");
        let own = self.contents().filter(move |(path, _)| is_main(path));
        let modules = self.contents().filter(move |(path, _)| is_module(path));
        own.chain(modules).filter_map(|(path, bytes)| Some((path, std::str::from_utf8(bytes?).ok()?)))
    }

    /// The files, whether they could be read or not.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.0.keys().map(PathBuf::as_path)
    }
}

/// Passes reads on to another world, and notes them.
pub struct Recorder {
    world: Arc<dyn World + Send + Sync>,
    reads: Mutex<Reads>,
}

impl Recorder {
    /// Nothing was read yet.
    pub fn new(world: Arc<dyn World + Send + Sync>) -> Self {
        Recorder { world, reads: Mutex::default() }
    }

    /// What was read so far.
    pub fn reads(&self) -> Reads {
        self.lock().clone()
    }

    fn lock(&self) -> MutexGuard<'_, Reads> {
        self.reads.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl World for Recorder {
    /// A file that is read twice in one run reads the same both times, whatever happens to it.
    fn bytes(&self, path: &Path) -> io::Result<Arc<[u8]>> {
        if let Some(Ok(bytes)) = self.lock().0.get(path) {
            return Ok(bytes.clone());
        }
        let outcome = self.world.bytes(path);
        let noted = outcome.as_ref().map(Arc::clone).map_err(io::Error::kind);
        self.lock().0.insert(path.to_owned(), noted);
        outcome
    }

    fn store(&self) -> Option<Store> {
        self.world.store()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Memory;

    fn memory(files: &[(&str, &str)]) -> Memory {
        Memory(files.iter().map(|(name, text)| (name.into(), text.to_string())).collect())
    }

    #[test]
    fn only_what_was_read_matters() {
        let before = memory(&[("a", "1"), ("b", "2")]);
        let recorder = Recorder::new(Arc::new(before.clone()));
        assert!(recorder.read(Path::new("a")).is_ok() && recorder.read(Path::new("c")).is_err());
        let reads = recorder.reads();
        assert!(!reads.changed_in(&before));
        assert!(!reads.changed_in(&memory(&[("a", "1"), ("b", "changed")])));
        assert!(reads.changed_in(&memory(&[("a", "changed"), ("b", "2")])));
        assert!(reads.changed_in(&memory(&[("a", "1"), ("c", "appeared")])));
        assert!(reads.changed_in(&memory(&[])));
        assert_eq!(reads.files().collect::<Vec<_>>(), [Path::new("a"), Path::new("c")]);
    }
}
