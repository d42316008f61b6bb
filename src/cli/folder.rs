//! Where the files go: a folder that is made with the first file in it, so that what fails leaves none
//! behind.

use super::progress::Progress;
use super::report::{Failure, Outcome, seconds};
use crate::diag::Diagnostic;
use crate::world::atomic;
use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::Path;
use std::time::Instant;

/// The folder of a run, and what was written into it.
pub struct Folder<'a> {
    path: &'a Path,
    written: Vec<String>,
    /// When the file that comes next was begun.
    start: Instant,
}

impl<'a> Folder<'a> {
    /// A folder that is there and can be written into, or can be made.
    pub fn new(path: &'a Path) -> Result<Folder<'a>, Failure> {
        let shown = path.display();
        let cannot = |why: String, hint: String| {
            Failure::error(format!("cannot make the folder {shown}: {why}"), hint)
        };
        let above = path.parent().filter(|above| !above.as_os_str().is_empty());
        match (fs::metadata(path), above) {
            (Ok(found), _) if !found.is_dir() => {
                let message = format!("{shown} is a file, and what is written needs a folder");
                return Err(Failure::error(message, "choose another name with -o, such as -o figures"));
            }
            (Err(_), Some(above)) if !above.exists() => {
                let above = above.display();
                return Err(cannot(format!("there is no {above}"), format!("create it: mkdir -p {above}")));
            }
            (Err(_), Some(above)) if !above.is_dir() => {
                let hint = "choose another place with -o".to_owned();
                return Err(cannot(format!("{} is a file", above.display()), hint));
            }
            _ => {}
        }
        // A folder can be made where a file could.
        let file = if path.is_dir() { path.join("index.html") } else { path.to_owned() };
        atomic::check(&file).map_err(|e| Diagnostic::error(e.to_string()))?;
        Ok(Folder { path, written: Vec::new(), start: Instant::now() })
    }

    /// Writes a file, and says so with the seconds that it took.
    pub fn write(
        &mut self,
        name: &str,
        ending: &str,
        progress: &Progress,
        fill: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
    ) -> Outcome {
        let file = self.path.join(format!("{name}.{ending}"));
        let made = match fs::create_dir(self.path) {
            Err(e) if e.kind() != io::ErrorKind::AlreadyExists => {
                let message = format!("cannot make the folder {} ({e})", self.path.display());
                return Err(Failure::error(message, "choose another with -o"));
            }
            made => made.is_ok(),
        };
        if let Err(e) = atomic::write(&file, fill) {
            if made {
                // It is as good as gone if it cannot be removed.
                let _ = fs::remove_dir(self.path);
            }
            return Err(Diagnostic::error(e.to_string()).into());
        }
        let spent = seconds(self.start.elapsed().as_secs_f64());
        progress.say(&format!("{} after {spent}", file.display()));
        self.start = Instant::now();
        self.written.push(format!("{name}.{ending}"));
        Ok(())
    }

    /// The files that were written.
    pub fn written(&self) -> &[String] {
        &self.written
    }

    /// What a run leaves that does not reach its end.
    pub fn account(&self) -> String {
        match self.written.as_slice() {
            [] => "no file was written".to_owned(),
            files => format!("written before that: {}", files.join(", ")),
        }
    }
}
