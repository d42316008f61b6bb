//! What took long to find, on disk, so that the next run need not find it again.
//!
//! A [`Store`] is a folder: `OROGEN_CACHE` if that is set, else `orogen` in `XDG_CACHE_HOME` or in `.cache` at home;
//! nowhere if it is set to `off`. Each kind of finding has a [`Shelf`] in it, a folder of files that are named after what they
//! are the findings of. The first line of a file holds that name, a fingerprint of all that the program was compiled of, and
//! a digest of the rest: a file that does not match, or cannot be read, is as if it were not there. So what another version
//! has found is found anew. Files may be removed at any time; those that were not used for longest are when there are too
//! many.

use super::atomic;
use crate::num::Digest;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::env::var_os;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

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
    /// Bytes that its files may take.
    pub most: u64,
}

/// How names of files end.
const KIND: &str = "kept";

/// One file may take this share of what all may: it should not drive out all others.
const SHARE: u64 = 3;

/// What the program is made of.
const SOURCES: &str = env!("OROGEN_SOURCES");

/// Nobody takes so long to write a file.
const ABANDONED: Duration = Duration::from_secs(3600);

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
        self.folder.join(shelf.name).join(format!("{key}.{KIND}"))
    }

    /// What was found of something before, if it is still there.
    pub fn load<T: DeserializeOwned>(&self, shelf: &Shelf, key: Digest) -> Option<T> {
        let path = self.file(shelf, key);
        // Who reads from something else than a file may wait for ever.
        std::fs::metadata(&path).ok().filter(|about| about.is_file())?;
        let found = read(key, &std::fs::read(&path).ok()?)?;
        touch(&path);
        Some(found)
    }

    /// Keeps what was found of something, where that is possible; that it is not is no harm.
    pub fn save(&self, shelf: &Shelf, key: Digest, found: &impl Serialize) {
        let path = self.file(shelf, key);
        let Some(bytes) = bytes(key, found).filter(|bytes| bytes.len() as u64 <= shelf.most / SHARE) else {
            return;
        };
        if let Some(folder) = path.parent()
            && std::fs::create_dir_all(folder).is_ok()
        {
            // Next time it is found anew.
            let _ = atomic::write(&path, |f| f.write_all(&bytes));
            trim(folder, shelf.most);
        }
    }
}

/// What is on the first line of a file; the finding follows.
#[derive(Serialize, Deserialize, PartialEq)]
struct Head {
    sources: String,
    key: String,
    digest: String,
}

impl Head {
    fn new(key: Digest, found: &[u8]) -> Head {
        let mut digest = Digest::default();
        digest.bytes(found);
        Head { sources: SOURCES.to_owned(), key: key.to_string(), digest: digest.to_string() }
    }
}

/// The bytes of a file.
fn bytes(key: Digest, found: &impl Serialize) -> Option<Vec<u8>> {
    let found = postcard::to_allocvec(found).ok()?;
    let mut bytes = serde_json::to_vec(&Head::new(key, &found)).ok()?;
    bytes.push(b'\n');
    bytes.extend(found);
    Some(bytes)
}

/// The finding in the bytes of a file, if it is whole and of this.
fn read<T: DeserializeOwned>(key: Digest, bytes: &[u8]) -> Option<T> {
    let (head, found) = bytes.split_at(bytes.iter().position(|byte| *byte == b'\n')?);
    let found = &found[1..];
    let is_whole = serde_json::from_slice::<Head>(head).ok()? == Head::new(key, found);
    if is_whole { postcard::from_bytes(found).ok() } else { None }
}

/// Notes that a file is of use, so that others make room before it.
fn touch(path: &Path) {
    if let Ok(file) = File::options().write(true).open(path) {
        // Where that is not allowed it counts as old.
        let _ = file.set_modified(SystemTime::now());
    }
}

/// Removes the files that were not used for longest until the others take no more than so many bytes, and those that somebody who
/// was killed has begun.
fn trim(folder: &Path, most: u64) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let file = |entry: std::fs::DirEntry| {
        let about = entry.metadata().ok().filter(std::fs::Metadata::is_file)?;
        Some((about.modified().ok()?, about.len(), entry.path()))
    };
    let (mut kept, others): (Vec<_>, Vec<_>) = entries
        .flatten()
        .filter_map(file)
        .partition(|(_, _, path)| path.extension().is_some_and(|e| e == KIND));
    kept.sort_by(|a, b| b.cmp(a));
    let mut total = 0;
    let too_many = kept.into_iter().filter(|(_, size, _)| {
        total += size;
        total > most
    });
    let is_old = |time: &SystemTime| time.elapsed().is_ok_and(|age| age > ABANDONED);
    let begun = others.into_iter().filter(|(time, _, path)| atomic::is_begun(path) && is_old(time));
    for (_, _, path) in too_many.chain(begun) {
        // One that another process has removed is gone as well.
        let _ = std::fs::remove_file(path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    const SHELF: Shelf = Shelf { name: "numbers", most: 3000 };

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
        assert_eq!(load(&Shelf { name: "others", ..SHELF }, 7), None);
        store.save(&SHELF, key(8), &vec![1.0; 200]);
        assert_eq!(load(&SHELF, 8), None, "one so large drives out others");
        let file = std::fs::read(store.file(&SHELF, key(7))).unwrap();
        assert!(String::from_utf8_lossy(&file).contains(SOURCES), "another program finds nothing");
    }

    #[test]
    fn a_file_with_a_byte_that_is_wrong_is_none() {
        let found = (3.5, vec![1_u32, 2, 3], "a text".to_owned());
        let whole = |bytes: &[u8]| read::<(f64, Vec<u32>, String)>(key(7), bytes);
        let bytes = bytes(key(7), &found).unwrap();
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
        let names = ["0.kept", "1.kept", "2.kept", "3.txt", ".orogen-4.tmp"];
        for (i, name) in names.into_iter().enumerate() {
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
        trim(folder.path(), 300);
        assert_eq!(left(), ["0.kept", "1.kept", "2.kept", "3.txt"], "what was begun an hour ago is gone");
        std::fs::write(folder.path().join(".orogen-5.tmp"), "").unwrap();
        touch(&folder.path().join("2.kept"));
        trim(folder.path(), 250);
        assert_eq!(left(), [".orogen-5.tmp", "0.kept", "2.kept", "3.txt"]);
    }
}
