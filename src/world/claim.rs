//! Files that several processes make together, each by one of them.
//!
//! Whoever makes a file holds a lock on another beside it, `.NAME.claim`. The system gives the lock back when its holder
//! ends, however that happens, so what a killed process left undone is free at once. A claim only saves work: the file
//! itself appears whole whoever writes it ([`atomic`](super::atomic)), so where there are no locks, as on some network
//! drives, or where two processes come by one in the moment in which it is given back, both make the same file.

use super::atomic::{WriteError, failed, folder_of};
use std::ffi::OsString;
use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

/// The claim to a file; it is given back when it is dropped.
#[derive(Debug)]
pub struct Claim {
    path: PathBuf,
    _lock: File,
}

impl Claim {
    /// Claims a file that is to be made; `None` if another process has done so.
    ///
    /// # Errors
    /// [`WriteError`] if nothing can be written beside the file.
    pub fn take(path: &Path) -> Result<Option<Claim>, WriteError> {
        let beside = beside(path)?;
        let lock = File::options().create(true).truncate(false).write(true).open(&beside);
        let lock = lock.map_err(|source| failed(path, source))?;
        match lock.try_lock() {
            Err(TryLockError::WouldBlock) => Ok(None),
            Ok(()) | Err(TryLockError::Error(_)) => Ok(Some(Claim { path: beside, _lock: lock })),
        }
    }

    /// Takes away what is left of the claim of a process that was killed.
    ///
    /// # Errors
    /// As for [`take`](Claim::take).
    pub fn tidy(path: &Path) -> Result<(), WriteError> {
        if beside(path)?.exists() {
            drop(Claim::take(path)?);
        }
        Ok(())
    }
}

/// The file that is locked.
fn beside(path: &Path) -> Result<PathBuf, WriteError> {
    let name = path.file_name().ok_or_else(|| WriteError::NotAFile(path.to_owned()))?;
    let mut hidden = OsString::from(".");
    hidden.push(name);
    hidden.push(".claim");
    Ok(folder_of(path).join(hidden))
}

impl Drop for Claim {
    fn drop(&mut self) {
        // What stays behind is empty, and taken over by the next claim.
        let _ = fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let claim = Claim::take(&path).unwrap();
        assert!(claim.is_some());
        assert!(Claim::take(&path).unwrap().is_none());
        assert!(Claim::take(&folder.path().join("b.png")).unwrap().is_some());
        drop(claim);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        fs::write(folder.path().join(".a.png.claim"), "").unwrap();
        Claim::tidy(&path).unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        assert!(Claim::take(&path).unwrap().is_some());
        assert!(Claim::take(&folder.path().join("gone/a.png")).is_err());
    }
}
