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
pub use wish::{Command, Message, Refused, Report, Stage};

use super::picking::{Picked, Picker};
use super::topology::Labels;
use super::{Loaded, Order, Session};
use crate::diag::Diagnostic;
use crate::field::Watch;
use crate::render::{Picture, Steering, View};
use crate::scene::{Camera, Param, Scene};
use crate::script::rewrite;
use crate::world::World;
use crate::world::atomic::FileSet;
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
    world: Arc<dyn World + Send + Sync>,
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
    picker: Mutex<Option<Kept>>,
}

/// A picker, the scene that it is of, and whether it knows components.
type Kept = (Arc<Scene>, bool, Picker);

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
    /// The components of the solid, if they were looked at.
    labels: Option<(Arc<Loaded>, Labels)>,
}

/// What the picture is of that is drawn, or was drawn last.
#[derive(Clone)]
struct Subject {
    scene: Arc<Scene>,
    loaded: Arc<Loaded>,
    order: Order,
    /// Raised when another takes its place.
    gone: Arc<AtomicBool>,
}

/// A picture under way.
struct Running {
    cancel: Arc<AtomicBool>,
    steering: Arc<Steering>,
    start: Instant,
    /// Whether something of it can be seen.
    seen: bool,
    /// Whether somebody waits to lose their patience with it.
    timed: bool,
}

/// How long a picture may take to show something before a newer wish takes its place.
const PATIENCE: Duration = Duration::from_millis(300);

impl State {
    /// Stops what is under way, now if it was seen, else when it takes too long to be.
    fn supersede(&mut self) {
        self.wishes += 1;
        let Some(running) = &mut self.running else { return };
        let left = PATIENCE.saturating_sub(running.start.elapsed());
        if running.seen || left.is_zero() {
            running.cancel.store(true, Ordering::SeqCst);
        } else if !std::mem::replace(&mut running.timed, true) {
            let cancel = running.cancel.clone();
            std::thread::spawn(move || {
                std::thread::sleep(left);
                cancel.store(true, Ordering::SeqCst);
            });
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
        let (script, world) = (session.script().to_path_buf(), session.world.clone());
        let studio = studio::Studio::new(shared.clone(), session, order);
        Live { script, world, shared, thread: Some(std::thread::spawn(move || studio.work())) }
    }

    /// A file was perhaps saved; nothing happens unless one that the script read reads differently now.
    pub fn saved(&self) {
        if self.loaded().is_some_and(|loaded| !loaded.reads.changed_in(self.world.as_ref())) {
            return;
        }
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
                // All of it, or nothing.
                let mut wish = before.clone();
                wish.obey(other, &state.params)?;
                state.wish = wish;
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
        let held = held.unwrap_or_else(|| steer::beyond(camera, [x, y], width / height));
        let moved = movement.of(camera, held);
        // Whoever comes too close, or too far, stays where they are.
        let [width, height] = canvas.size;
        View::new(&moved, width, height).map(|_| moved).map_err(|_| Refused::Number("a movement"))
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
        loop {
            let (subject, labels) = {
                let state = self.shared.state();
                (state.subject.clone(), state.labels.clone())
            };
            let subject = subject.ok_or_else(nothing)?;
            match self.pick_in(&subject, labels, [x, y]) {
                // What was asked about is no longer shown.
                Err(_) if subject.gone.load(Ordering::SeqCst) => {}
                picked => return picked,
            }
        }
    }

    /// What is at a place of the picture of a subject.
    fn pick_in(
        &self,
        subject: &Subject,
        labels: Option<(Arc<Loaded>, Labels)>,
        [x, y]: [f64; 2],
    ) -> Result<Picked, Box<Diagnostic>> {
        let Subject { scene, loaded, order, gone } = subject;
        let labels = labels.filter(|(of, _)| Arc::ptr_eq(of, loaded)).map(|(_, labels)| labels);
        let mut kept = self.shared.picker.lock().unwrap_or_else(PoisonError::into_inner);
        let mut picker = match kept.take() {
            Some((of, named, picker)) if Arc::ptr_eq(&of, scene) && named == labels.is_some() => picker,
            _ => {
                let watch = Watch { cancel: gone, progress: &|_| () };
                let picker = Picker::new(loaded, scene, order, &watch)?;
                match labels.clone() {
                    Some(labels) => picker.with_labels(labels),
                    None => picker,
                }
            }
        };
        let [width, height] = order.size.map_or([1.0; 2], |(w, h)| [f64::from(w), f64::from(h)]);
        let picked = picker.pick(x * width, y * height);
        *kept = Some((scene.clone(), labels.is_some(), picker));
        Ok(picked)
    }

    /// Writes the values that parameters have into the script, as their defaults. Gives the files that were written.
    ///
    /// # Errors
    /// A diagnostic for the first file that cannot be written; then none is.
    pub fn write_defaults(&self) -> Result<Vec<PathBuf>, Box<Diagnostic>> {
        let (mut params, loaded, set) = {
            let state = self.shared.state();
            (state.params.clone(), state.loaded.clone(), state.wish.params.clone())
        };
        for param in &mut params {
            if let Some(Ok(value)) = set.get(&param.name).map(|value| param.domain.admit(value)) {
                param.value = value;
            }
        }
        params.retain(|p| p.value != p.default);
        let scripts = loaded.iter().flat_map(|loaded| loaded.reads.scripts(&self.script));
        let (paths, before): (Vec<PathBuf>, Vec<String>) =
            scripts.map(|(path, text)| (path.to_path_buf(), text.to_owned())).unzip();
        if !params.is_empty() && paths.first() != Some(&self.script) {
            return Err(Box::new(Diagnostic::error("there is no script to write into")));
        }
        let mut after = before.clone();
        // Whatever is new comes first, so the last of them is written first.
        for param in params.iter().rev() {
            rewrite::write_default(&mut after, &[], param);
        }
        let texts = before.iter().zip(&after);
        let changed = paths.iter().zip(texts).filter(|(_, (before, after))| before != after);
        let mut files = FileSet::default();
        let mut written = Vec::new();
        let failed = |e: crate::world::atomic::WriteError| Box::new(Diagnostic::error(e.to_string()));
        for (path, (old, new)) in changed {
            if !self.world.read(path).is_ok_and(|now| *now == **old) {
                let error = format!("{} was changed just now", path.display());
                return Err(Box::new(
                    Diagnostic::error(error).hint("try again when the page shows the change"),
                ));
            }
            files.add(path, |file| file.write_all(new.as_bytes())).map_err(failed)?;
            written.push(path.clone());
        }
        files.commit().map_err(failed)?;
        // From here on they are the script's own, and follow it.
        self.shared.state().wish.params.retain(|name, value| set.get(name) != Some(value));
        self.saved();
        Ok(written)
    }
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
