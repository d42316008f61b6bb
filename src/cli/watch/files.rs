//! `orogen watch --headless`: a file that follows its script.
//!
//! Three things can happen at any time: a file is saved, a rendering ends, Ctrl-C is pressed. Each
//! arrives as an [`Event`] in one queue, and one loop answers them. Rendering happens on another
//! thread, quick coarse pictures first; a save stops it.

use super::super::interrupt::Interrupt;
use super::super::report::{Failure, Outcome, Terminal, err};
use super::super::work::{self, Work};
use super::POLL;
use crate::diag::Diagnostic;
use crate::render::{Job, Picture, Saved};
use crate::scene::Scene;
use crate::session::{self, Digests, Loaded, Order, Session};
use crate::world::watch::Watch;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Instant;

/// Something to answer.
enum Event {
    /// A file was perhaps saved.
    Saved,
    /// A picture of this attempt is there, or cannot be made.
    Drawn(u64, Stage, Box<Result<Picture, Box<Diagnostic>>>),
    /// Ctrl-C.
    Interrupted,
}

/// Which picture of an attempt.
#[derive(Clone, Copy, PartialEq)]
enum Stage {
    /// The first quick one.
    First,
    /// A better quick one.
    Better,
    /// The picture as it was ordered.
    Full,
}

/// Runs the command.
pub fn run(work: Work, terminal: &Terminal) -> Outcome {
    let (sender, events) = channel();
    let pressed = sender.clone();
    let interrupt = Interrupt::listen(move || pressed.send(Event::Interrupted).unwrap_or_default());
    let saved = sender.clone();
    let watch = Watch::new(move || saved.send(Event::Saved).unwrap_or_default());
    let mut state =
        State { work, terminal: *terminal, watch: watch.ok(), sender, interrupt, attempt: None, number: 0 };
    state.begin();
    state.follow(&events);
    Ok(())
}

/// The attempt at a picture that is under way.
struct Attempt {
    loaded: Arc<Loaded>,
    scene: Arc<Scene>,
    cancel: Arc<AtomicBool>,
    start: Instant,
    thread: std::thread::JoinHandle<()>,
}

struct State {
    work: Work,
    terminal: Terminal,
    /// `None` where the system cannot tell of changes; then looking every second has to do.
    watch: Option<Watch>,
    sender: Sender<Event>,
    interrupt: Interrupt,
    attempt: Option<Attempt>,
    /// Counts attempts, so that news of an earlier one are known as such.
    number: u64,
}

impl State {
    /// Answers events until Ctrl-C.
    fn follow(&mut self, events: &Receiver<Event>) {
        loop {
            match events.recv_timeout(POLL) {
                Ok(Event::Saved) | Err(RecvTimeoutError::Timeout) => {
                    if self.work.session.is_stale() {
                        self.begin();
                    }
                }
                Ok(Event::Drawn(number, stage, picture)) if number == self.number => {
                    self.show(stage, *picture)
                }
                Ok(Event::Drawn(..)) => {}
                Ok(Event::Interrupted) | Err(RecvTimeoutError::Disconnected) => break,
            }
        }
        self.stop();
    }

    /// Starts over: reads the script, and renders it if it is right.
    fn begin(&mut self) {
        self.stop();
        self.number += 1;
        let start = Instant::now();
        let cancel = Arc::new(AtomicBool::new(false));
        let loaded = self.work.session.load(&self.interrupt.flag());
        self.watch_files();
        let Some(scene) = work::report(&loaded, &self.terminal) else {
            return self.wait_for_save();
        };
        if let Err(Failure::Error(lost)) = self.work.spare(&loaded) {
            self.terminal.diagnostic(&lost, &loaded.sources);
            return self.wait_for_save();
        }
        let thread = {
            let (sender, number, order) = (self.sender.clone(), self.number, self.work.order);
            let (session, scene, cancel) = (self.work.session.clone(), scene.clone(), cancel.clone());
            std::thread::spawn(move || {
                draw(&session, &scene, &order, &cancel, |stage, picture| {
                    // Nobody listens any more only when the program ends.
                    sender.send(Event::Drawn(number, stage, Box::new(picture))).unwrap_or_default();
                })
            })
        };
        self.attempt = Some(Attempt { loaded, scene, cancel, start, thread });
    }

    /// Stops what is under way, and waits for that.
    fn stop(&mut self) {
        if let Some(attempt) = self.attempt.take() {
            attempt.cancel.store(true, Ordering::SeqCst);
            // A panic there was reported, and ended the program.
            let _ = attempt.thread.join();
        }
    }

    fn watch_files(&mut self) {
        let files = self.work.session.files();
        if let Some(watch) = &mut self.watch
            && watch.set_files(files.iter().map(PathBuf::as_path)).is_err()
        {
            // Looking every second still works.
            self.watch = None;
        }
    }

    /// A picture is there: writes it, and says so.
    fn show(&mut self, stage: Stage, picture: Result<Picture, Box<Diagnostic>>) {
        let Some(attempt) = &self.attempt else { return };
        let sources = &attempt.loaded.sources;
        let picture = match picture {
            Ok(picture) if picture.finished => picture,
            Ok(_) => return,
            Err(error) => {
                self.terminal.diagnostic(&error, sources);
                return self.wait_for_save();
            }
        };
        let saved = match stage {
            Stage::First | Stage::Better => self.save_preview(attempt, &picture),
            Stage::Full => {
                let saved = self.work.save(&attempt.loaded, &attempt.scene, &picture);
                saved.and_then(|file| self.work.save_stats(&file, &attempt.scene, &picture).map(|()| file))
            }
        };
        let elapsed = attempt.start.elapsed().as_secs_f64();
        match (saved, stage) {
            (Ok(_), Stage::Better) => {}
            (Ok(file), Stage::First) => {
                err(self.terminal.dim(format_args!("{} (preview)", work::summary(&file, &picture, elapsed))));
            }
            (Ok(file), Stage::Full) => {
                work::report_warnings(&attempt.loaded, &picture, &self.terminal);
                err(work::summary(&file, &picture, elapsed));
            }
            (Err(Failure::Error(error) | Failure::Usage(error)), _) => {
                self.terminal.diagnostic(&error, sources)
            }
            (Err(Failure::Reported), _) => {}
        }
    }

    /// Saves a quick picture as one that is not finished, unless the file holds the full one of this script already.
    fn save_preview(&self, attempt: &Attempt, picture: &Picture) -> Result<PathBuf, Failure> {
        let Attempt { loaded, scene, .. } = attempt;
        let file = self.work.output.clone();
        let is_made = Saved::open(&file)
            .is_ok_and(|saved| self.work.departure(&saved.about, &mut Digests::new()).is_none());
        if !is_made {
            self.work.save_to(&file, loaded, scene, &Picture { finished: false, ..picture.clone() })?;
        }
        Ok(file)
    }

    fn wait_for_save(&self) {
        let kept = if self.work.output.exists() { "; the last good picture stays" } else { "" };
        err(self.terminal.dim(format_args!("waiting for a save{kept}")));
    }
}

/// Renders quick pictures and then the full one.
fn draw(
    session: &Session,
    scene: &Arc<Scene>,
    order: &Order,
    cancel: &Arc<AtomicBool>,
    tell: impl Fn(Stage, Result<Picture, Box<Diagnostic>>),
) {
    let job = Job::unwatched(cancel);
    let mut stage = Stage::First;
    for coarseness in session::COARSENESS {
        match session::preview(scene, order, coarseness, &job) {
            Ok(Some(picture)) => tell(stage, Ok(picture)),
            Ok(None) => break,
            Err(error) => return tell(Stage::Full, Err(error)),
        }
        stage = Stage::Better;
    }
    if !cancel.load(Ordering::SeqCst) {
        tell(Stage::Full, session.render(scene, order, &job, cancel));
    }
}
