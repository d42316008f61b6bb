//! `:render`: a picture of the last solid or scene.

use super::Shell;
use crate::cli::pictures::{Way, figure_of};
use crate::cli::progress::Progress;
use crate::cli::report::{Outcome, err};
use crate::cli::work;
use crate::diag::Diagnostic;
use crate::render::{self, Job, Metadata};
use crate::session::{self, Order};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Renders to the terminal, as large as fits; with a file, or where no pictures are shown, to that in full size.
pub fn run(shell: &Shell, file: Option<&str>) -> Outcome {
    let scene = shell.solid(None)?;
    let stem = shell.script.as_deref().and_then(Path::file_stem).unwrap_or("repl".as_ref());
    let unseen = || (shell.screen.way() == Way::None).then(|| Path::new(stem).with_extension("png"));
    let path = file.map(PathBuf::from).or_else(unseen);
    if let Some(path) = &path {
        render::can_save(path).map_err(|e| shell.say(&Diagnostic::error(e.to_string())))?;
    }
    let size = path.is_none().then(|| shell.screen.fitted(scene.film.width, scene.film.height));
    let start = Instant::now();
    let name = path.as_deref().unwrap_or(Path::new("picture"));
    let progress = Progress::new(&shell.terminal, &name.display().to_string());
    let step = |p: render::Progress| progress.set(p.done as f64 / p.total.max(1) as f64);
    let flag = shell.interrupt.flag();
    let job = Job { progress: &step, ..Job::unwatched(&flag) };
    let picture = session::render(&scene, &Order { size, ..Order::default() }, &job);
    progress.finish();
    let picture = picture.map_err(|error| shell.say(&error))?;
    if !picture.finished {
        return Err(shell.say(&Diagnostic::error("stopped; no file was written")));
    }
    for warning in &picture.warnings {
        shell.say(warning);
    }
    shell.screen.show(&figure_of(&picture));
    if let Some(path) = &path {
        let saved = render::save(path, &picture, &Metadata::default());
        saved.map_err(|e| shell.say(&Diagnostic::error(e.to_string())))?;
    }
    err(work::summary(name, &picture, start.elapsed().as_secs_f64()));
    Ok(())
}
