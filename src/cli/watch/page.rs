//! `orogen watch` with a page: a server, and a loop that answers saves and Ctrl-C.

use super::super::interrupt::Interrupt;
use super::super::report::{Outcome, Terminal, err};
use super::super::serve::Server;
use super::super::work::{self, Work};
use super::routes::{Hall, routes};
use super::{Args, POLL};
use crate::session::live::{Event, Live};
use crate::world::watch::Watch;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use tokio::sync::watch;

/// Something to answer.
enum Call {
    /// A file was perhaps saved.
    Saved,
    /// Something happened in the studio.
    Live(Event),
    /// Ctrl-C.
    Interrupted,
}

/// Runs the command.
pub fn run(args: &Args, work: Work, terminal: &Terminal) -> Outcome {
    let (sender, calls) = channel();
    let pressed = sender.clone();
    let _interrupt = Interrupt::listen(move || pressed.send(Call::Interrupted).unwrap_or_default());
    let Work { session, order, .. } = work;
    let (news, heard) = watch::channel(0);
    let told = sender.clone();
    let live = Arc::new(Live::new(session, order, move |event| {
        news.send_modify(|count| *count += 1);
        if event != Event::Changed {
            // Nobody listens any more only when the program ends.
            told.send(Call::Live(event)).unwrap_or_default();
        }
    }));
    let looked_at = live.clone();
    let hall = |guard| Hall { live: looked_at, news: heard, guard };
    let server = Server::start(args.listen, *terminal, |guard| routes(hall(guard)))?;
    err(format_args!("{} is at {}", args.script.display(), terminal.bold(&server.address)));
    err(terminal.dim("Ctrl-C ends the watch"));
    let watched = follow(&live, sender, &calls, terminal);
    drop(server);
    watched
}

/// Answers calls until Ctrl-C.
fn follow(live: &Live, sender: Sender<Call>, calls: &Receiver<Call>, terminal: &Terminal) -> Outcome {
    let mut watch = Watch::new(move || sender.send(Call::Saved).unwrap_or_default()).ok();
    loop {
        match calls.recv_timeout(POLL) {
            // Where the system cannot tell of changes, looking every second has to do.
            Ok(Call::Saved) | Err(RecvTimeoutError::Timeout) => {
                // Folders may have come and gone.
                look_at(&mut watch, live);
                live.saved();
            }
            Ok(Call::Live(Event::Read)) => {
                look_at(&mut watch, live);
                if let Some(loaded) = live.loaded() {
                    work::report(&loaded, terminal);
                }
            }
            Ok(Call::Live(Event::Finished)) => {
                if let Some(finished) = live.finished() {
                    let seconds = live.report().whole;
                    err(terminal.dim(work::summary(live.script(), &finished.picture, seconds)));
                }
            }
            Ok(Call::Live(Event::Changed)) => {}
            Ok(Call::Interrupted) | Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
    }
}

/// Watches the files that matter now.
fn look_at(watch: &mut Option<Watch>, live: &Live) {
    let files = live.files();
    if watch.as_mut().is_some_and(|w| w.set_files(files.iter().map(PathBuf::as_path)).is_err()) {
        *watch = None;
    }
}
