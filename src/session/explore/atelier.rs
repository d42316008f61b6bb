//! Draws specimens in the background: rough pictures before finished ones, of either what was asked for last first, and
//! what nobody waits for any longer never.

use super::{Genome, Subject};
use crate::diag::Diagnostic;
use crate::session::Order;
use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// Pictures that are drawn at a time. A picture begins with work for one thread, such as running its script; meanwhile
/// another keeps the other cores busy.
const WORKERS: usize = 2;

/// For so long a picture is drawn that may be rough, before it is left as it is.
const MOMENT: Duration = Duration::from_millis(400);

/// Whose picture, and its width and height.
pub type Key = (usize, (u32, u32));

/// How good a picture has to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grade {
    /// As good as it gets in a moment.
    Rough,
    /// All of it.
    Finished,
}

impl Grade {
    /// Whether nothing better is to be drawn.
    fn is_met_by(self, drawn: &Drawn) -> bool {
        self == Grade::Rough || drawn.as_ref().map_or(true, |image| image.grade == Grade::Finished)
    }
}

/// A picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// The bytes of a PNG.
    pub png: Arc<[u8]>,
    /// How good it is.
    pub grade: Grade,
}

/// A picture, or why there is none.
pub type Drawn = Result<Image, Box<Diagnostic>>;

/// Somebody's wish for a picture. It is given up when this is dropped.
#[derive(Debug)]
pub struct Ticket(Arc<Reins>);

impl Drop for Ticket {
    fn drop(&mut self) {
        self.0.give_up();
    }
}

/// What stops the work on a picture. It also stops when enough of a rough one is there, which is not to give it up.
#[derive(Debug, Default)]
struct Reins {
    given_up: AtomicBool,
    stop: Arc<AtomicBool>,
}

impl Reins {
    fn give_up(&self) {
        self.given_up.store(true, Ordering::SeqCst);
        self.stop.store(true, Ordering::SeqCst);
    }

    fn is_given_up(&self) -> bool {
        self.given_up.load(Ordering::SeqCst)
    }
}

/// One picture to draw.
struct Task {
    key: Key,
    grade: Grade,
    genome: Genome,
    reins: Arc<Reins>,
    tell: Box<dyn FnOnce(Drawn) + Send>,
}

/// Pictures drawn in the background. Dropping it ends the work.
pub struct Atelier {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
}

struct Shared {
    state: Mutex<State>,
    /// Rung when there is something to do.
    bell: Condvar,
    subject: Subject,
}

#[derive(Default)]
struct State {
    /// Those that wait, the newest last.
    waiting: Vec<Task>,
    /// Those that are drawn, with what stops them.
    running: HashMap<Key, Arc<Reins>>,
    /// The best there is of each.
    known: HashMap<Key, Drawn>,
    closing: bool,
}

impl State {
    /// Which of those that wait is drawn next: the newest that is quick, or else the newest.
    fn due(&self) -> Option<usize> {
        let is_free = |task: &Task| !self.running.contains_key(&task.key);
        let rough = self.waiting.iter().rposition(|task| task.grade == Grade::Rough && is_free(task));
        rough.or_else(|| self.waiting.iter().rposition(is_free))
    }
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Draws until the end.
    fn work(&self) {
        while let Some(task) = self.next() {
            let known =
                self.state().known.get(&task.key).filter(|drawn| task.grade.is_met_by(drawn)).cloned();
            let drawn = known.or_else(|| self.draw(&task));
            let mut state = self.state();
            state.running.remove(&task.key);
            if let Some(drawn) = &drawn {
                state.known.insert(task.key, drawn.clone());
            }
            drop(state);
            // Others may wait for the same picture.
            self.bell.notify_all();
            if let Some(drawn) = drawn {
                (task.tell)(drawn);
            }
        }
    }

    /// Draws a picture; `None` if it was given up.
    fn draw(&self, Task { key, grade, genome, reins, .. }: &Task) -> Option<Drawn> {
        let order = Order { size: Some(key.1), samples: Some(1), ..Order::default() };
        let drawn = match grade {
            Grade::Rough => self.subject.sketch(genome, &order, (MOMENT, &reins.stop)),
            Grade::Finished => {
                self.subject.draw(genome, &order, &reins.stop).map(|png| png.map(|png| (png, true)))
            }
        };
        let image = |(png, finished): (Vec<u8>, bool)| Image {
            png: Arc::from(png),
            grade: if finished { Grade::Finished } else { Grade::Rough },
        };
        // What was given up may have failed because of that.
        drawn.map(|drawn| drawn.map(image)).transpose().filter(|_| !reins.is_given_up())
    }

    /// Waits for something to draw that nobody else draws; `None` at the end.
    fn next(&self) -> Option<Task> {
        let mut state = self.state();
        loop {
            if state.closing {
                return None;
            }
            state.waiting.retain(|task| !task.reins.is_given_up());
            if let Some(due) = state.due() {
                let task = state.waiting.remove(due);
                state.running.insert(task.key, task.reins.clone());
                return Some(task);
            }
            state = self.bell.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl Atelier {
    /// For pictures of a script.
    pub fn new(subject: Subject) -> Atelier {
        let shared = Arc::new(Shared { state: Mutex::default(), bell: Condvar::new(), subject });
        let worker = |_| {
            let shared = shared.clone();
            std::thread::spawn(move || shared.work())
        };
        let threads = (0..WORKERS).map(worker).collect();
        Atelier { shared, threads }
    }

    /// The script.
    pub fn subject(&self) -> &Subject {
        &self.shared.subject
    }

    /// Asks for a picture. `tell` is called on another thread once it is there, and never if the ticket is dropped before.
    pub fn ask(
        &self,
        (key, grade): (Key, Grade),
        genome: Genome,
        tell: impl FnOnce(Drawn) + Send + 'static,
    ) -> Ticket {
        let reins = Arc::new(Reins::default());
        let task = Task { key, grade, genome, reins: reins.clone(), tell: Box::new(tell) };
        self.shared.state().waiting.push(task);
        self.shared.bell.notify_one();
        Ticket(reins)
    }
}

impl Drop for Atelier {
    fn drop(&mut self) {
        {
            let mut state = self.shared.state();
            state.closing = true;
            state.running.values().for_each(|reins| reins.give_up());
            self.shared.bell.notify_all();
        }
        for thread in self.threads.drain(..) {
            // A panic there was reported, and ended the program.
            let _ = thread.join();
        }
    }
}
