//! What took long to find, on disk, so that the next run need not find it again.
//!
//! A [`Store`] is a folder: `OROGEN_CACHE` if that is set, else `orogen` in `XDG_CACHE_HOME` or in `.cache` at home;
//! nowhere if it is set to `off`. Each kind of finding has a [`Shelf`] in it, a folder of files that are named after what they
//! are the findings of. The first line of a file holds that name, the version of the program, and a digest of the rest: a
//! file that does not match, or cannot be read, is as if it were not there. Files may be removed at any time; those that
//! were not used for longest are when there are too many.

use super::atomic;
use crate::num::Digest;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::env::var_os;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// A folder of findings.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Store {
    folder: PathBuf,
}

/// Findings of one kind.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Shelf {
    /// The name of its folder.
    pub name: &'static str,
    /// How names of its files end.
    pub kind: &'static str,
    /// Raised when findings of old must not be taken for those of now.
    pub revision: u32,
    /// Bytes that its files may take.
    pub most: u64,
}

impl Store {
    /// The folder of the user, if there is to be one.
    pub fn of_user() -> Option<Store> {
        let named = |name: &str| var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
        if var_os("OROGEN_CACHE").is_some_and(|v| v == "off") {
            return None;
        }
        let folder = named("OROGEN_CACHE")
            .or_else(|| Some(named("XDG_CACHE_HOME")?.join("orogen")))
            .or_else(|| Some(named("HOME")?.join(".cache/orogen")))?;
        Some(Store::at(folder))
    }

    /// A folder, which need not be there yet.
    pub fn at(folder: impl Into<PathBuf>) -> Store {
        Store { folder: folder.into() }
    }

    fn file(&self, shelf: &Shelf, key: Digest) -> PathBuf {
        self.folder.join(shelf.name).join(format!("{key}.{}", shelf.kind))
    }

    /// What was found of something before, if it is still there.
    pub fn load<T: DeserializeOwned>(&self, shelf: &Shelf, key: Digest) -> Option<T> {
        let path = self.file(shelf, key);
        let found = read(shelf, key, &std::fs::read(&path).ok()?)?;
        touch(&path);
        Some(found)
    }

    /// Keeps what was found of something, where that is possible; that it is not is no harm.
    pub fn save(&self, shelf: &Shelf, key: Digest, found: &impl Serialize) {
        let path = self.file(shelf, key);
        let Some(bytes) = bytes(shelf, key, found) else { return };
        // One so large would drive out all others, and itself.
        if bytes.len() as u64 > shelf.most {
            return;
        }
        if let Some(folder) = path.parent()
            && std::fs::create_dir_all(folder).is_ok()
        {
            // Next time it is found anew.
            let _ = atomic::write(&path, |f| f.write_all(&bytes));
            trim(folder, shelf.kind, shelf.most);
        }
    }
}

/// What is on the first line of a file; the finding follows.
#[derive(Serialize, Deserialize, PartialEq)]
struct Head {
    revision: u32,
    version: String,
    key: String,
    digest: String,
}

impl Head {
    fn new(shelf: &Shelf, key: Digest, found: &[u8]) -> Head {
        let mut digest = Digest::default();
        digest.bytes(found);
        let version = env!("CARGO_PKG_VERSION").to_owned();
        Head { revision: shelf.revision, version, key: key.to_string(), digest: digest.to_string() }
    }
}

/// The bytes of a file.
fn bytes(shelf: &Shelf, key: Digest, found: &impl Serialize) -> Option<Vec<u8>> {
    let found = postcard::to_allocvec(found).ok()?;
    let mut bytes = serde_json::to_vec(&Head::new(shelf, key, &found)).ok()?;
    bytes.push(b'\n');
    bytes.extend(found);
    Some(bytes)
}

/// The finding in the bytes of a file, if it is whole and of this.
fn read<T: DeserializeOwned>(shelf: &Shelf, key: Digest, bytes: &[u8]) -> Option<T> {
    let (head, found) = bytes.split_at(bytes.iter().position(|byte| *byte == b'\n')?);
    let found = &found[1..];
    let is_whole = serde_json::from_slice::<Head>(head).ok()? == Head::new(shelf, key, found);
    if is_whole { postcard::from_bytes(found).ok() } else { None }
}

/// Notes that a file is of use, so that others make room before it.
fn touch(path: &Path) {
    if let Ok(file) = File::options().write(true).open(path) {
        // Where that is not allowed it counts as old.
        let _ = file.set_modified(SystemTime::now());
    }
}

/// Removes the files of a kind that were not used for longest until the others take no more than so many bytes.
fn trim(folder: &Path, kind: &str, most: u64) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let file = |entry: std::fs::DirEntry| {
        let about = entry.metadata().ok().filter(std::fs::Metadata::is_file)?;
        let is_ours = entry.path().extension().is_some_and(|e| e == kind);
        is_ours.then_some((about.modified().ok()?, about.len(), entry.path()))
    };
    let mut files: Vec<_> = entries.flatten().filter_map(file).collect();
    files.sort_by(|a, b| b.cmp(a));
    let mut total = 0;
    for (_, size, path) in files {
        total += size;
        if total > most {
            // One that another process has removed is gone as well.
            let _ = std::fs::remove_file(path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    const SHELF: Shelf = Shelf { name: "numbers", kind: "list", revision: 1, most: 1000 };

    fn key(x: u64) -> Digest {
        let mut key = Digest::default();
        key.whole(x);
        key
    }

    #[test]
    fn what_was_saved_is_loaded_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::at(folder.path().join("not there yet"));
        let load = |shelf: &Shelf, x: u64| store.load::<Vec<f64>>(shelf, key(x));
        assert_eq!(load(&SHELF, 7), None);
        store.save(&SHELF, key(7), &vec![0.5, -0.0]);
        let bits = |found: Option<Vec<f64>>| found.map(|v| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>());
        assert_eq!(bits(load(&SHELF, 7)), bits(Some(vec![0.5, -0.0])));
        assert_eq!(load(&SHELF, 8), None);
        assert_eq!(load(&Shelf { revision: 2, ..SHELF }, 7), None);
        assert_eq!(load(&Shelf { name: "others", ..SHELF }, 7), None);
        store.save(&SHELF, key(8), &vec![1.0; 1000]);
        assert_eq!(load(&SHELF, 8), None, "one so large would drive out all others");
    }

    #[test]
    fn a_file_with_a_byte_that_is_wrong_is_none() {
        let found = (3.5, vec![1_u32, 2, 3], "a text".to_owned());
        let whole = |bytes: &[u8]| read::<(f64, Vec<u32>, String)>(&SHELF, key(7), bytes);
        let bytes = bytes(&SHELF, key(7), &found).unwrap();
        assert_eq!(whole(&bytes), Some(found));
        for i in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[i] ^= 1;
            assert!(whole(&damaged).is_none(), "{i}");
            assert!(whole(&bytes[..i]).is_none(), "{i}");
        }
    }

    #[test]
    fn what_was_not_used_for_longest_makes_room() {
        let folder = tempfile::tempdir().unwrap();
        for (i, name) in ["0.list", "1.list", "2.list", "3.txt"].into_iter().enumerate() {
            let path = folder.path().join(name);
            std::fs::write(&path, [0; 100]).unwrap();
            let age = Duration::from_secs(1000 * i as u64);
            let file = File::options().write(true).open(path).unwrap();
            file.set_modified(SystemTime::now() - age).unwrap();
        }
        let left = || {
            let names = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name());
            let mut names: Vec<_> = names.map(|name| name.into_string().unwrap()).collect();
            names.sort();
            names
        };
        trim(folder.path(), "list", 300);
        assert_eq!(left().len(), 4);
        touch(&folder.path().join("2.list"));
        trim(folder.path(), "list", 250);
        assert_eq!(left(), ["0.list", "2.list", "3.txt"]);
    }
}
