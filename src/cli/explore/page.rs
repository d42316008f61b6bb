//! `orogen explore` with a page: a server that waits for Ctrl-C.

use super::super::interrupt::Interrupt;
use super::super::report::{Outcome, Terminal, err, plural};
use super::super::serve::Server;
use super::routes::{Hall, routes};
use super::{Args, Beginning, begin};
use crate::session::explore::Atelier;
use std::sync::mpsc::channel;

/// Runs the command.
pub fn run(args: &Args, terminal: &Terminal) -> Outcome {
    let (pressed, end) = channel();
    // Nobody listens any more only when the program ends.
    let interrupt = Interrupt::listen(move || pressed.send(()).unwrap_or_default());
    let Beginning { subject, gallery, size } = begin(args, terminal, None, &interrupt.flag())?;
    let axes = plural(gallery.space().axes.len() as u64, "parameter");
    let hall = Hall::new(args, size, Atelier::new(subject), gallery);
    let server = Server::start(args.listen, *terminal, |guard| routes(hall, guard))?;
    err(format_args!("{} is at {}", args.script.display(), terminal.bold(&server.address)));
    err(terminal.dim(format_args!("{axes} to explore; Ctrl-C ends it")));
    // It ends with Ctrl-C, or at once where nobody can tell of that.
    let _ = end.recv();
    Ok(())
}
