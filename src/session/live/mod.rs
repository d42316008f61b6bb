//! Live: a picture of a script that people watch and steer while it is made.
//!
//! ```text
//! files --saved--> .------.  --script--> scene --rough, better, full--> Canvas --new blocks--> people
//! people --Command-> | Wish | ------------------------------------------> Report ------------->
//!                  '------'
//! ```
//!
//! One thread, the [`studio`], draws; all others only say what they want. Each change of the wish starts a new picture at
//! once, except that the roughest picture of the one before is finished first: else nothing at all would be seen while
//! somebody drags a slider. What is wished for outlives the script's changes: the camera and the parameters stay when a
//! file is saved.

mod canvas;
mod steer;
mod studio;
mod wish;

#[cfg(test)]
mod tests;

pub use canvas::{Canvas, News};
pub use steer::Move;
pub use wish::{Command, Message, Refused, Report, Slider, Stage};

use super::picking::{Picked, Picker};
use super::{Loaded, Order, Session};
use crate::diag::Diagnostic;
use crate::field::Watch;
use crate::render::{Picture, Steering};
use crate::scene::{Camera, Param, Scene};
use crate::script::rewrite;
use crate::world::atomic;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use wish::Wish;

/// What happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// Something is new in the report or on the canvas.
    Changed,
    /// The script was read: there are perhaps other messages, and other files to watch.
    Read,
    /// A full picture is there.
    Finished,
}

/// A full picture, and what it is of.
#[derive(Clone)]
pub struct Finished {
    /// The picture.
    pub picture: Arc<Picture>,
    /// The scene, with what people changed.
    pub scene: Arc<Scene>,
    /// The script that made it.
    pub loaded: Arc<Loaded>,
}

/// A picture that people watch. Dropping it ends the work.
pub struct Live {
    script: PathBuf,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// What the studio and everybody else have in common.
struct Shared {
    state: Mutex<State>,
    /// Rung when the studio has something to do.
    bell: Condvar,
    canvas: Mutex<Canvas>,
    tell: Box<dyn Fn(Event) + Send + Sync>,
    /// Says what is at a pixel of a scene.
    picker: Mutex<Option<(Arc<Scene>, Picker)>>,
}

#[derive(Default)]
struct State {
    wish: Wish,
    /// Counts what was wished for.
    wishes: u64,
    /// A file was perhaps saved.
    saved: bool,
    closing: bool,
    /// What is being drawn.
    running: Option<Running>,
    report: Arc<Report>,
    /// Parameters of the script as it is.
    params: Vec<Param>,
    /// The camera in use.
    camera: Option<Camera>,
    loaded: Option<Arc<Loaded>>,
    files: Vec<PathBuf>,
    finished: Option<Finished>,
    subject: Option<Subject>,
}

/// What the picture is of that is drawn, or was drawn last.
#[derive(Clone)]
struct Subject {
    scene: Arc<Scene>,
    loaded: Arc<Loaded>,
    order: Order,
}

/// A picture under way.
struct Running {
    cancel: Arc<AtomicBool>,
    steering: Arc<Steering>,
    start: Instant,
    /// Whether something of it can be seen.
    seen: bool,
}

/// How long a picture may take to show something before a newer wish takes its place.
const PATIENCE: Duration = Duration::from_millis(300);

impl State {
    /// Stops what is under way, if it was seen, or took too long to be.
    fn supersede(&mut self) {
        self.wishes += 1;
        if let Some(running) = &self.running
            && (running.seen || running.start.elapsed() > PATIENCE)
        {
            running.cancel.store(true, Ordering::SeqCst);
        }
    }
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn canvas(&self) -> MutexGuard<'_, Canvas> {
        self.canvas.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Live {
    /// Starts to draw. `tell` is called on other threads, often, and should be quick.
    pub fn new(session: Session, order: Order, tell: impl Fn(Event) + Send + Sync + 'static) -> Live {
        let wish = Wish {
            params: session.params.clone(),
            time: session.time,
            caster: order.caster,
            ..Wish::default()
        };
        let state = State { wish, wishes: 1, saved: true, ..State::default() };
        let shared = Arc::new(Shared {
            state: Mutex::new(state),
            bell: Condvar::new(),
            canvas: Mutex::new(Canvas::new([1, 1])),
            tell: Box::new(tell),
            picker: Mutex::new(None),
        });
        let script = session.script().to_path_buf();
        let studio = studio::Studio::new(shared.clone(), session, order);
        Live { script, shared, thread: Some(std::thread::spawn(move || studio.work())) }
    }

    /// A file was perhaps saved.
    pub fn saved(&self) {
        let mut state = self.shared.state();
        state.saved = true;
        // What is drawn shows what is no longer so.
        if let Some(running) = &state.running {
            running.cancel.store(true, Ordering::SeqCst);
        }
        self.shared.bell.notify_all();
    }

    /// Obeys a command.
    ///
    /// # Errors
    /// [`Refused`]
    pub fn command(&self, command: &Command) -> Result<(), Refused> {
        let mut state = self.shared.state();
        let before = state.wish.clone();
        match command {
            Command::Move(movement) => {
                let camera = state.camera.ok_or(Refused::Nothing)?;
                let moved = self.moved(movement, &camera)?;
                (state.wish.camera, state.camera) = (Some(moved), Some(moved));
            }
            Command::Region(_) => {
                state.wish.obey(command, &[])?;
                // What is being drawn goes on, in another order.
                if let Some(running) = &state.running {
                    running.steering.focus(state.wish.region);
                }
                let region = state.wish.region.map(|r| [r.x, r.y, r.width, r.height]);
                Arc::make_mut(&mut state.report).region = region;
                drop(state);
                (self.shared.tell)(Event::Changed);
                return Ok(());
            }
            other => {
                let params = state.params.clone();
                state.wish.obey(other, &params)?;
            }
        }
        if state.wish != before {
            state.supersede();
            self.shared.bell.notify_all();
        }
        Ok(())
    }

    /// A camera after a movement that holds on to what the canvas shows.
    fn moved(&self, movement: &Move, camera: &Camera) -> Result<Camera, Refused> {
        if !movement.is_finite() {
            return Err(Refused::Number("a movement"));
        }
        let canvas = self.shared.canvas();
        let [width, height] = canvas.size.map(f64::from);
        let [x, y] = movement.place();
        let held = canvas.view.and_then(|view| canvas.point([x * width, y * height], &view));
        Ok(movement.of(camera, held.unwrap_or_else(|| steer::beyond(camera, [x, y], width / height))))
    }

    /// The script.
    pub fn script(&self) -> &Path {
        &self.script
    }

    /// What people are told.
    pub fn report(&self) -> Arc<Report> {
        self.shared.state().report.clone()
    }

    /// What they see. Nothing is drawn while it is held.
    pub fn canvas(&self) -> MutexGuard<'_, Canvas> {
        self.shared.canvas()
    }

    /// The last full picture, as long as it is of what is shown now.
    pub fn finished(&self) -> Option<Finished> {
        self.shared.state().finished.clone()
    }

    /// What the script came to when it was read last.
    pub fn loaded(&self) -> Option<Arc<Loaded>> {
        self.shared.state().loaded.clone()
    }

    /// The files to watch.
    pub fn files(&self) -> Vec<PathBuf> {
        self.shared.state().files.clone()
    }

    /// What is at a place of the picture, as shares of its width and height. The first question about a scene takes as long
    /// as it takes to begin a picture of it.
    ///
    /// # Errors
    /// A diagnostic if there is nothing to ask about.
    pub fn pick(&self, [x, y]: [f64; 2]) -> Result<Picked, Box<Diagnostic>> {
        let nothing = || Box::new(Diagnostic::error(Refused::Nothing.to_string()));
        let Subject { scene, loaded, order } = self.shared.state().subject.clone().ok_or_else(nothing)?;
        let mut kept = self.shared.picker.lock().unwrap_or_else(PoisonError::into_inner);
        let mut picker = match kept.take() {
            Some((of, picker)) if Arc::ptr_eq(&of, &scene) => picker,
            _ => Picker::new(
                &loaded,
                &scene,
                &order,
                &Watch { cancel: &AtomicBool::new(false), progress: &|_| () },
            )?,
        };
        let [width, height] = order.size.map_or([1.0; 2], |(w, h)| [f64::from(w), f64::from(h)]);
        let picked = picker.pick(x * width, y * height);
        *kept = Some((scene, picker));
        Ok(picked)
    }

    /// Writes the values that parameters have into the script, as their defaults. Gives the files that were written.
    ///
    /// # Errors
    /// A diagnostic for the first that cannot be written; then nothing is.
    pub fn write_defaults(&self) -> Result<Vec<PathBuf>, Box<Diagnostic>> {
        let (params, loaded) = {
            let state = self.shared.state();
            (state.params.clone(), state.loaded.clone())
        };
        let changed: Vec<&Param> = params.iter().filter(|p| p.value != p.default).collect();
        let mut texts: Vec<(PathBuf, String, bool)> = loaded.iter().flat_map(|l| scripts(l)).collect();
        for param in changed {
            write_default(&mut texts, param)?;
        }
        let mut written = Vec::new();
        for (path, text, _) in texts.into_iter().filter(|(_, _, changed)| *changed) {
            atomic::write(&path, |file| file.write_all(text.as_bytes()))
                .map_err(|e| Box::new(Diagnostic::error(e.to_string())))?;
            written.push(path);
        }
        if !written.is_empty() {
            // From here on they are the script's own, and follow it.
            self.shared.state().wish.params.clear();
            self.saved();
        }
        Ok(written)
    }
}

/// The scripts that were read from disk.
fn scripts(loaded: &Loaded) -> impl Iterator<Item = (PathBuf, String, bool)> + '_ {
    let is_script = |path: &Path| path.extension().is_some_and(|e| e == "rhai");
    let texts = loaded.reads.contents().filter(move |(path, _)| is_script(path));
    texts.filter_map(|(path, bytes)| {
        Some((path.to_path_buf(), std::str::from_utf8(bytes?).ok()?.to_owned(), false))
    })
}

/// Writes a default into the one text that has it.
fn write_default(texts: &mut [(PathBuf, String, bool)], param: &Param) -> Result<(), Box<Diagnostic>> {
    let mut failure = None;
    for (_, text, changed) in texts {
        match rewrite::with_default(text, param) {
            Ok(new) => {
                (*text, *changed) = (new, true);
                return Ok(());
            }
            Err(error) if failure.is_none() => failure = Some(error),
            Err(_) => {}
        }
    }
    Err(failure.unwrap_or_else(|| Box::new(Diagnostic::error("there is no script to write into"))))
}

impl Drop for Live {
    fn drop(&mut self) {
        {
            let mut state = self.shared.state();
            state.closing = true;
            if let Some(running) = &state.running {
                running.cancel.store(true, Ordering::SeqCst);
            }
            self.shared.bell.notify_all();
        }
        if let Some(thread) = self.thread.take() {
            // A panic there was reported, and ended the program.
            let _ = thread.join();
        }
    }
}
