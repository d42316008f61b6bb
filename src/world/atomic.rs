//! Files that appear whole or not at all.
//!
//! [`write()`] hands out a temporary file in the folder of its destination, and renames it into place
//! once everything in it has reached the disk. Whatever goes wrong before that, including the end
//! of the process, leaves the earlier file as it was. Files that belong together are a [`FileSet`]: the
//! first is renamed when all of them are on the disk. [`check`] asks beforehand whether that can
//! work, so that nobody renders for an hour into a folder that does not exist.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::{NamedTempFile, TempPath};

/// Why a file was not written: what happened, to which path, and what to do about it.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The folder does not exist.
    #[error("the folder {0:?} does not exist; create it, or choose another place for the file")]
    NoFolder(PathBuf),
    /// Something on the way to the file is a file.
    #[error("{0:?} is not a folder; choose another place for the file")]
    NotAFolder(PathBuf),
    /// The path names something that no file can replace.
    #[error("{0:?} exists and is not a file; choose another name")]
    NotAFile(PathBuf),
    /// The file is there and must not be changed.
    #[error("{0:?} is read-only; make it writable, or choose another name")]
    ReadOnly(PathBuf),
    /// No file can be created in the folder.
    #[error("cannot write into the folder {folder:?} ({source}); check its permissions, or choose another")]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The disk is full.
    #[error("the disk is full: {0:?} was not written; free some space and try again")]
    Full(PathBuf),
    /// Anything else.
    #[error("cannot write {path:?} ({source}); the earlier file, if there was one, is untouched")]
    Other {
        /// The file.
        path: PathBuf,
        /// What the system or the encoder said.
        source: io::Error,
    },
}

/// How names of files begin and end that are not finished.
const BEGUN: [&str; 2] = [".orogen-", ".tmp"];

/// Whether a path is that of a file that is not finished, by its name.
pub fn is_begun(path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str());
    name.is_some_and(|name| name.starts_with(BEGUN[0]) && name.ends_with(BEGUN[1]))
}

/// Writes a file through `fill`, atomically. Symbolic links are followed, and a file that is
/// replaced passes its permissions on.
///
/// # Errors
/// [`WriteError`]; what was at `path` before is then still there, and the temporary file is gone.
pub fn write(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
) -> Result<(), WriteError> {
    let mut alone = FileSet::default();
    alone.add(path, fill)?;
    alone.commit()
}

/// Has a file written by somebody else, such as another program, atomically: `make` is given the path of an empty
/// file to write to.
///
/// # Errors
/// [`WriteError`]; what was at `path` before is then still there, and the temporary file is gone.
pub fn write_by(path: &Path, make: impl FnOnce(&Path) -> io::Result<()>) -> Result<(), WriteError> {
    let mut alone = FileSet::default();
    alone.make(path, |temporary| make(temporary.path()))?;
    alone.commit()
}

/// Files that appear together: all of them are written out before the first appears, and those of a set that is
/// dropped never do.
#[derive(Debug, Default)]
pub struct FileSet {
    /// Where each file goes, and where it is until then. They are closed, since there may be more of them
    /// than a process can hold open.
    files: Vec<(PathBuf, TempPath)>,
}

impl FileSet {
    /// Adds a file, as [`write()`] would, but for the last step.
    ///
    /// # Errors
    /// [`WriteError`]; the set is then as it was.
    pub fn add(
        &mut self,
        path: &Path,
        fill: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
    ) -> Result<(), WriteError> {
        self.make(path, |temporary| write_through(temporary, fill))
    }

    /// Adds a file that `make` writes.
    fn make(
        &mut self,
        path: &Path,
        make: impl FnOnce(&mut NamedTempFile) -> io::Result<()>,
    ) -> Result<(), WriteError> {
        let path = destination(path)?;
        let mut temporary = create(&path)?;
        let written = make(&mut temporary).and_then(|()| {
            temporary.as_file().sync_all()?;
            keep_permissions(&path, &temporary)
        });
        written.map_err(|source| failed(&path, source))?;
        self.files.push((path, temporary.into_temp_path()));
        Ok(())
    }

    /// Renames all files into place, in the order in which they were added.
    ///
    /// # Errors
    /// [`WriteError`] of the first that cannot be renamed, as when somebody has taken the folder away in the
    /// meantime; those before it are then in place.
    pub fn commit(self) -> Result<(), WriteError> {
        let mut folders: Vec<PathBuf> = Vec::new();
        for (path, temporary) in self.files {
            temporary.persist(&path).map_err(|e| failed(&path, e.error))?;
            let folder = folder_of(&path);
            if folders.iter().all(|known| known != folder) {
                folders.push(folder.to_owned());
            }
        }
        folders.iter().for_each(|folder| sync_folder(folder));
        Ok(())
    }
}

/// Whether [`write()`] could write `path` now; leaves nothing behind.
///
/// # Errors
/// The error that [`write()`] would give.
pub fn check(path: &Path) -> Result<(), WriteError> {
    create(&destination(path)?).map(drop)
}

/// Copies a file to the first name that is free: its own with `~`, `~2` and so on after it. Returns that; nothing if there is
/// no file.
///
/// # Errors
/// [`WriteError`], also if the file is not fit to be replaced.
pub fn back_up(path: &Path) -> Result<Option<PathBuf>, WriteError> {
    let file = destination(path)?;
    if !file.is_file() {
        return Ok(None);
    }
    let named = |number: u32| {
        let mut name = path.as_os_str().to_owned();
        name.push(if number == 1 { "~".to_owned() } else { format!("~{number}") });
        PathBuf::from(name)
    };
    let free = (1..).map(named).find(|name| !name.exists()).unwrap_or_else(|| named(1));
    let bytes = fs::read(&file).map_err(|source| failed(path, source))?;
    write(&free, |f| f.write_all(&bytes))?;
    Ok(Some(free))
}

/// The file that `path` stands for, found fit to be written.
pub(super) fn destination(path: &Path) -> Result<PathBuf, WriteError> {
    if path.file_name().is_none() {
        return Err(WriteError::NotAFile(path.to_owned()));
    }
    let folder = folder_of(path);
    match fs::metadata(folder) {
        Ok(found) if found.is_dir() => {}
        Ok(_) => return Err(WriteError::NotAFolder(folder.to_owned())),
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Err(WriteError::NoFolder(folder.to_owned())),
        Err(e) if e.kind() == io::ErrorKind::NotADirectory => {
            return Err(WriteError::NotAFolder(folder.to_owned()));
        }
        Err(source) => return Err(WriteError::Folder { folder: folder.to_owned(), source }),
    }
    let Ok(found) = fs::metadata(path) else { return Ok(path.to_owned()) };
    if !found.is_file() {
        return Err(WriteError::NotAFile(path.to_owned()));
    }
    if found.permissions().readonly() {
        return Err(WriteError::ReadOnly(path.to_owned()));
    }
    fs::canonicalize(path).map_err(|source| failed(path, source))
}

/// The folder that a path is in; the current one where the path does not say.
pub(super) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn create(path: &Path) -> Result<NamedTempFile, WriteError> {
    let folder = folder_of(path);
    let mut builder = tempfile::Builder::new();
    builder.prefix(BEGUN[0]).suffix(BEGUN[1]);
    // Temporary files are private by default; this one becomes a file like any other (less umask).
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder).map_err(|source| match source.kind() {
        io::ErrorKind::StorageFull => WriteError::Full(path.to_owned()),
        _ => WriteError::Folder { folder: folder.to_owned(), source },
    })
}

fn write_through(
    temporary: &mut NamedTempFile,
    fill: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
) -> io::Result<()> {
    let mut buffered = BufWriter::with_capacity(1 << 16, temporary.as_file_mut());
    let filled = fill(&mut buffered).and_then(|()| buffered.flush());
    // What is left in the buffer of a failure is not worth writing.
    let (file, _) = buffered.into_parts();
    filled.map_err(|error| cause(file, error))
}

fn keep_permissions(path: &Path, temporary: &NamedTempFile) -> io::Result<()> {
    match fs::metadata(path) {
        Ok(earlier) => temporary.as_file().set_permissions(earlier.permissions()),
        Err(_) => Ok(()),
    }
}

/// Makes the rename itself durable. Where folders cannot be synced, the file is whole all the same.
fn sync_folder(folder: &Path) {
    if cfg!(unix)
        && let Ok(folder) = File::open(folder)
    {
        let _ = folder.sync_all();
    }
}

pub(super) fn failed(path: &Path, source: io::Error) -> WriteError {
    match source.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => WriteError::Full(path.to_owned()),
        _ => WriteError::Other { path: path.to_owned(), source },
    }
}

/// The error of an encoder, which may have lost the kind of the error behind it: if the disk takes
/// no more, that is the reason.
fn cause(file: &mut File, error: io::Error) -> io::Error {
    file.write_all(&[0; 1 << 16]).and_then(|()| file.sync_data()).err().unwrap_or(error)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write(&path, |f| f.write_all(b"one")).unwrap();
        write(&path, |f| f.write_all(b"two")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn a_failure_leaves_the_earlier_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        fs::write(&path, "earlier").unwrap();
        let full = |f: &mut BufWriter<&mut File>| {
            f.write_all(&[0; 1 << 20])?;
            Err(io::ErrorKind::StorageFull.into())
        };
        let error = write(&path, full).unwrap_err();
        assert!(matches!(error, WriteError::Full(_)), "{error}");
        assert_eq!(fs::read(&path).unwrap(), b"earlier");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn others_write_to_a_path() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_by(&path, |beside| fs::write(beside, "one")).unwrap();
        assert!(write_by(&path, |_| Err(io::ErrorKind::Other.into())).is_err());
        assert_eq!(fs::read(&path).unwrap(), b"one");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn a_panic_leaves_the_earlier_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        fs::write(&path, "earlier").unwrap();
        let job = std::panic::AssertUnwindSafe(|| write(&path, |_| panic!("encoder")));
        assert!(std::panic::catch_unwind(job).is_err());
        assert_eq!(fs::read(&path).unwrap(), b"earlier");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn files_of_a_set_appear_together_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let [a, b] = ["a.txt", "b.txt"].map(|name| folder.path().join(name));
        fs::write(&a, "earlier").unwrap();
        let mut set = FileSet::default();
        set.add(&a, |f| f.write_all(b"one")).unwrap();
        assert!(set.add(&b, |_| Err(io::ErrorKind::InvalidData.into())).is_err());
        assert_eq!(fs::read(&a).unwrap(), b"earlier");
        drop(set);
        assert_eq!((fs::read(&a).unwrap(), names(folder.path())), (b"earlier".into(), vec!["a.txt".into()]));
        let mut set = FileSet::default();
        set.add(&a, |f| f.write_all(b"one")).unwrap();
        set.add(&b, |f| f.write_all(b"two")).unwrap();
        set.commit().unwrap();
        assert_eq!((fs::read(&a).unwrap(), fs::read(&b).unwrap()), (b"one".into(), b"two".into()));
        assert_eq!(names(folder.path()), ["a.txt", "b.txt"]);
    }

    #[test]
    fn what_cannot_work_is_said_before() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("file"), "").unwrap();
        assert!(check(&at("new.png")).is_ok());
        assert!(matches!(check(&at("missing/new.png")), Err(WriteError::NoFolder(_))));
        assert!(matches!(check(&at("file/new.png")), Err(WriteError::NotAFolder(_))));
        assert!(matches!(check(folder.path()), Err(WriteError::NotAFile(_))));
        let mut permissions = fs::metadata(at("file")).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(at("file"), permissions).unwrap();
        assert!(matches!(check(&at("file")), Err(WriteError::ReadOnly(_))));
        assert_eq!(names(folder.path()), ["file"]);
    }

    #[cfg(unix)]
    #[test]
    fn permissions_and_links_are_kept() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, "earlier").unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write(&link, |f| f.write_all(b"new")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
    }
}
