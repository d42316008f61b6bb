//! Figures of answers: shown where the terminal can, and written to a file where one is named, or where nothing can
//! be shown.

use super::Shell;
use crate::analysis::plot::Figure;
use crate::cli::pictures::Way;
use crate::cli::report::{Outcome, out};
use crate::diag::Diagnostic;
use crate::world::atomic;
use std::path::{Path, PathBuf};

/// Size of figures in files.
const SIZE: (u32, u32) = (800, 720);

/// A figure of an answer.
pub struct Drawing<'a> {
    /// The name of its file, without its ending, where none is given.
    pub name: &'a str,
    /// The file that it goes to.
    pub file: Option<&'a Path>,
    /// Makes it, in about so many pixels.
    pub figure: &'a dyn Fn((u32, u32)) -> Result<Figure, Box<Diagnostic>>,
    /// Makes it of characters, in so many columns and rows.
    pub characters: &'a dyn Fn((u32, u32)) -> String,
}

impl Drawing<'_> {
    /// Shows and writes it.
    pub fn deliver(&self, shell: &Shell) -> Outcome {
        let way = shell.screen.way();
        match way {
            Way::None => {}
            Way::Blocks => out((self.characters)(shell.screen.characters())),
            _ => {
                let figure = (self.figure)(shell.screen.figure()).map_err(|e| shell.say(&e))?;
                shell.screen.show_figure(&figure);
            }
        }
        let unseen = (way == Way::None).then(|| PathBuf::from(self.name).with_extension("png"));
        let Some(path) = self.file.map(Path::to_path_buf).or(unseen) else { return Ok(()) };
        let figure = (self.figure)(SIZE).map_err(|e| shell.say(&e))?;
        atomic::write(&path, |f| figure.write_png(f))
            .map_err(|e| shell.say(&Diagnostic::error(e.to_string())))?;
        out(format_args!("{}: {}x{}", path.display(), figure.width, figure.height));
        Ok(())
    }
}

/// A text that is cut where there is no more room.
pub fn shortened(text: &str, characters: usize) -> String {
    if text.chars().count() <= characters {
        return text.to_owned();
    }
    text.chars().take(characters.saturating_sub(3)).chain("...".chars()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_are_cut() {
        assert_eq!(shortened("äöü", 3), "äöü");
        assert_eq!(shortened("äöüäöü", 5), "äö...");
        assert_eq!(shortened("abcd", 0), "...");
    }
}
