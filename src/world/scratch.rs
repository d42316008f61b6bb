//! Numbers that a job needs once more and that do not fit into memory.
//!
//! They go to a file without a name, beside the one that comes of them, where there must be room anyway.
//! It is gone when it is closed, however the process ends.

use super::atomic::{WriteError, destination, failed, folder_of};
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, Write};
use std::path::{Path, PathBuf};

/// Bytes that pass at a time.
const PIECE: usize = 1 << 16;

/// Numbers on their way to the disk.
#[derive(Debug)]
pub struct Scratch {
    file: BufWriter<File>,
    path: PathBuf,
}

/// Numbers on their way back, in the same order.
#[derive(Debug)]
pub struct Kept(BufReader<File>);

impl Scratch {
    /// Room in the folder of a file that is still to be written.
    ///
    /// # Errors
    /// [`WriteError`] where nothing can be written.
    pub fn beside(path: &Path) -> Result<Scratch, WriteError> {
        let file =
            tempfile::tempfile_in(folder_of(&destination(path)?)).map_err(|source| failed(path, source))?;
        Ok(Scratch { file: BufWriter::with_capacity(PIECE, file), path: path.to_owned() })
    }

    /// Keeps numbers.
    ///
    /// # Errors
    /// When the disk is full or broken.
    pub fn push(&mut self, values: &[f64]) -> io::Result<()> {
        values.iter().try_for_each(|v| self.file.write_all(&v.to_le_bytes()))
    }

    /// Turns back to the first number.
    ///
    /// # Errors
    /// [`WriteError`] when the disk is full or broken.
    pub fn finish(self) -> Result<Kept, WriteError> {
        let Scratch { file, path } = self;
        let rewound = file.into_inner().map_err(io::Error::from).and_then(|mut file| {
            file.rewind()?;
            Ok(file)
        });
        let file = rewound.map_err(|source| failed(&path, source))?;
        Ok(Kept(BufReader::with_capacity(PIECE, file)))
    }
}

impl Kept {
    /// The next numbers.
    ///
    /// # Errors
    /// When the disk is broken, or there are not so many.
    pub fn next(&mut self, values: &mut [f64]) -> io::Result<()> {
        let mut bytes = [0; 8];
        for value in values {
            self.0.read_exact(&mut bytes)?;
            *value = f64::from_le_bytes(bytes);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back_and_nothing_stays() {
        let folder = tempfile::tempdir().unwrap();
        let mut scratch = Scratch::beside(&folder.path().join("a.png")).unwrap();
        let values: Vec<f64> = (0..20_000).map(|i| 1.0 / f64::from(i)).collect();
        scratch.push(&values).unwrap();
        scratch.push(&[f64::NAN]).unwrap();
        let mut kept = scratch.finish().unwrap();
        let (mut back, mut last) = (vec![0.0; values.len()], [0.0]);
        kept.next(&mut back).unwrap();
        kept.next(&mut last).unwrap();
        assert!(back == values && last[0].is_nan() && kept.next(&mut last).is_err());
        drop(kept);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        assert!(Scratch::beside(&folder.path().join("gone/a.png")).is_err());
    }
}
