//! Notices that files are saved.
//!
//! Editors save in many ways: they write in place, write a new file and rename it over the old one,
//! or move the old one away first. What they have in common is an event in the *folder*, so folders
//! are watched, and events about other files in them are dropped. One save makes several events;
//! they are reported once, when they have been quiet for [`QUIET`].
//!
//! An event means "look again", not "this changed": whoever is told reads the files and compares.

use notify::event::{AccessKind, AccessMode, EventKind, ModifyKind, RenameMode};
use notify::{Event, RecommendedWatcher, RecursiveMode, Watcher};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How long events must pause before a save counts as finished.
pub const QUIET: Duration = Duration::from_millis(40);

/// The same where the last event says that a file is complete: renames are told of in several pieces.
const SETTLED: Duration = Duration::from_millis(3);

/// After this time a save is reported even if events go on.
const PATIENCE: Duration = Duration::from_millis(500);

/// The files that matter, as absolute paths without links in their folders.
type Wanted = Arc<Mutex<BTreeSet<PathBuf>>>;

/// The system gives no events: too many watches, or none supported.
#[derive(Debug, thiserror::Error)]
#[error("cannot watch {}: {source}", folder.display())]
pub struct WatchError {
    /// The folder that cannot be watched.
    pub folder: PathBuf,
    source: notify::Error,
}

/// A set of watched files. Dropping it ends the watch.
pub struct Watch {
    watcher: RecommendedWatcher,
    folders: BTreeSet<PathBuf>,
    wanted: Wanted,
}

impl Watch {
    /// Watches nothing yet. `saved` is called on another thread, once per save of a file of the set.
    ///
    /// # Errors
    /// When the system offers no way to watch files.
    pub fn new(saved: impl FnMut() + Send + 'static) -> Result<Watch, WatchError> {
        let wanted = Wanted::default();
        let (sender, receiver) = channel();
        let matters = wanted.clone();
        let on_event = move |event: notify::Result<Event>| {
            // An error means that events were lost, so anything may have happened.
            let settled = event.as_ref().is_ok_and(settles);
            if event.is_ok_and(|e| !concerns(&e, &matters)) {
                return;
            }
            // Nobody listens any more only while the watch is being dropped.
            let _ = sender.send(if settled { SETTLED } else { QUIET });
        };
        let watcher = notify::recommended_watcher(on_event)
            .map_err(|source| WatchError { folder: PathBuf::from("."), source })?;
        std::thread::spawn(move || debounce(&receiver, saved));
        Ok(Watch { watcher, folders: BTreeSet::new(), wanted })
    }

    /// Watches these files and no others. Files and folders that do not exist yet are waited for.
    ///
    /// # Errors
    /// When a folder cannot be watched; the others are.
    pub fn set_files<'a>(&mut self, files: impl IntoIterator<Item = &'a Path>) -> Result<(), WatchError> {
        let (mut wanted, mut folders) = (BTreeSet::new(), BTreeSet::new());
        for file in files {
            for (folder, path) in locations(file) {
                folders.insert(folder);
                wanted.insert(path);
            }
        }
        *self.wanted.lock().unwrap_or_else(PoisonError::into_inner) = wanted;
        for gone in self.folders.difference(&folders) {
            // It may have been deleted, which ends its watch as well.
            let _ = self.watcher.unwatch(gone);
        }
        self.folders.retain(|folder| folders.contains(folder));
        let mut result = Ok(());
        for folder in folders {
            if self.folders.contains(&folder) {
                continue;
            }
            match self.watcher.watch(&folder, RecursiveMode::NonRecursive) {
                Ok(()) => drop(self.folders.insert(folder)),
                Err(source) => result = Err(WatchError { folder, source }),
            }
        }
        result
    }
}

/// Whether an event may have changed what is read from one of the files.
fn concerns(event: &Event, wanted: &Wanted) -> bool {
    match event.kind {
        EventKind::Access(AccessKind::Close(AccessMode::Write)) => {}
        EventKind::Access(_) => return false,
        _ => {}
    }
    let wanted = wanted.lock().unwrap_or_else(PoisonError::into_inner);
    // A path above a file matters too: a folder that appears, vanishes or is renamed.
    event.paths.iter().any(|path| wanted.iter().any(|file| file.starts_with(path)))
}

/// Whether a file is complete after an event: it was written and closed, or moved to its place.
fn settles(event: &Event) -> bool {
    matches!(
        event.kind,
        EventKind::Access(AccessKind::Close(AccessMode::Write))
            | EventKind::Modify(ModifyKind::Name(RenameMode::To | RenameMode::Both))
    )
}

/// Calls `saved` once for each burst of events, until the watch is dropped. Each event says how long the pause after it
/// must be to end the burst.
fn debounce(events: &Receiver<Duration>, mut saved: impl FnMut()) {
    while let Ok(mut pause) = events.recv() {
        let first = Instant::now();
        while first.elapsed() < PATIENCE {
            match events.recv_timeout(pause) {
                Ok(next) => pause = next,
                Err(RecvTimeoutError::Timeout) => break,
                Err(RecvTimeoutError::Disconnected) => return,
            }
        }
        saved();
    }
}

/// Where a file may change: its own folder, and that of the file it links to. Each is the folder to
/// watch, the nearest one that exists, and the path that events will name.
fn locations(file: &Path) -> Vec<(PathBuf, PathBuf)> {
    let mut found: Vec<_> = location(file).into_iter().collect();
    if let Ok(target) = file.canonicalize()
        && let Some(other) = location(&target)
        && !found.contains(&other)
    {
        found.push(other);
    }
    found
}

fn location(file: &Path) -> Option<(PathBuf, PathBuf)> {
    let absolute = std::path::absolute(file).ok()?;
    let existing = absolute.ancestors().skip(1).find(|folder| folder.is_dir())?;
    let folder = existing.canonicalize().ok()?;
    let path = folder.join(absolute.strip_prefix(existing).ok()?);
    Some((folder, path))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    /// A folder under watch, and how many saves of `a` and `sub/b` were seen.
    struct Bench {
        folder: tempfile::TempDir,
        saves: Receiver<()>,
        _watch: Watch,
    }

    impl Bench {
        fn new() -> Bench {
            let folder = tempfile::tempdir().unwrap();
            fs::write(folder.path().join("a"), "1").unwrap();
            let (sender, saves) = channel();
            let mut watch = Watch::new(move || sender.send(()).unwrap_or_default()).unwrap();
            let files = [folder.path().join("a"), folder.path().join("sub/b")];
            watch.set_files(files.iter().map(PathBuf::as_path)).unwrap();
            Bench { folder, saves, _watch: watch }
        }

        fn path(&self, name: &str) -> PathBuf {
            self.folder.path().join(name)
        }

        fn saw_a_save(&self) -> bool {
            let seen = self.saves.recv_timeout(Duration::from_secs(5)).is_ok();
            seen && self.saves.recv_timeout(Duration::from_millis(200)).is_err()
        }
    }

    #[test]
    fn a_write_is_one_save() {
        let bench = Bench::new();
        fs::write(bench.path("a"), "2").unwrap();
        assert!(bench.saw_a_save());
    }

    #[test]
    fn a_rename_over_the_file_is_a_save() {
        let bench = Bench::new();
        fs::write(bench.path("new"), "2").unwrap();
        fs::rename(bench.path("new"), bench.path("a")).unwrap();
        assert!(bench.saw_a_save());
    }

    #[test]
    fn a_file_that_appears_with_its_folder_is_a_save() {
        let bench = Bench::new();
        fs::create_dir(bench.path("sub")).unwrap();
        fs::write(bench.path("sub/b"), "2").unwrap();
        assert!(bench.saw_a_save());
    }

    #[test]
    fn reading_and_other_files_are_no_saves() {
        let bench = Bench::new();
        fs::write(bench.path("other"), "2").unwrap();
        fs::read(bench.path("a")).unwrap();
        assert!(bench.saves.recv_timeout(Duration::from_millis(300)).is_err());
    }
}
