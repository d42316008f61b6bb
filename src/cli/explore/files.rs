//! `orogen explore --headless`: pictures in a folder, with a page that shows them and their values as JSON.

use super::super::folder::Folder;
use super::super::interrupt::Interrupt;
use super::super::progress::Progress;
use super::super::report::{Failure, Outcome, Terminal, err, plural};
use super::still::{figure, page};
use super::told::{Told, settings};
use super::{Args, Beginning, begin};
use crate::diag::Diagnostic;
use crate::session::Order;
use std::io::Write;
use std::path::Path;

/// Runs the command.
pub fn run(args: &Args, folder: &Path, terminal: &Terminal) -> Outcome {
    let progress = Progress::new(terminal, &args.script.display().to_string());
    let flag = Interrupt::stopping(&progress).flag();
    let mut files = Folder::new(folder)?;
    let Beginning { subject, gallery, size } = begin(args, terminal, Some(&progress), &flag)?;
    let order = Order { size: Some(size), samples: Some(1), ..Order::default() };
    let told = Told::new(args, &subject, &gallery, size);
    let mut figures = String::new();
    let mut failed = 0;
    for (id, genome) in (0..).map_while(|id| Some((id, gallery.genome(id)?))) {
        let values = &genome.values;
        match subject.draw(&genome, &order, &flag) {
            Ok(Some(png)) => {
                files.write(&id.to_string(), "png", &progress, |file| file.write_all(&png))?;
                figures += &figure(&told, id, values, None);
            }
            _ if flag.load(std::sync::atomic::Ordering::SeqCst) => {
                return Err(Failure::error("stopped before all was done", files.account()));
            }
            Ok(None) => {}
            Err(error) => {
                failed += 1;
                progress.say(&format!("picture {id} cannot be made:{}: {}", settings(values), error.message));
                figures += &figure(&told, id, values, Some(&error.message));
            }
        }
        progress.set((id + 1) as f64 / gallery.specimens.len() as f64);
    }
    let text = serde_json::to_string_pretty(&told)
        .map_err(|e| Diagnostic::error(format!("cannot write the gallery ({e})")))?;
    files.write("gallery", "json", &progress, |file| writeln!(file, "{text}"))?;
    files.write("index", "html", &progress, |file| file.write_all(page(&told, &figures).as_bytes()))?;
    progress.finish();
    let made = plural((gallery.specimens.len() - failed) as u64, "picture");
    err(format_args!("{}: {made} in {}", args.script.display(), folder.display()));
    Ok(())
}
