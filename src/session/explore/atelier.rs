//! Draws specimens in the background: what was asked for last comes first, and what nobody waits for any longer never.

use super::{Genome, Subject};
use crate::diag::Diagnostic;
use crate::session::Order;
use std::collections::{HashMap, HashSet};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

/// Pictures that are drawn at a time. A picture begins with work for one thread, such as running its script; meanwhile
/// another keeps the other cores busy.
const WORKERS: usize = 2;

/// Whose picture, and its width and height.
pub type Key = (usize, (u32, u32));

/// The bytes of a PNG, or why there is none.
pub type Drawn = Result<Arc<[u8]>, Box<Diagnostic>>;

/// Somebody's wish for a picture. It is given up when this is dropped.
#[derive(Debug)]
pub struct Ticket(Arc<AtomicBool>);

impl Drop for Ticket {
    fn drop(&mut self) {
        self.0.store(true, Ordering::SeqCst);
    }
}

/// One picture to draw.
struct Task {
    key: Key,
    genome: Genome,
    cancel: Arc<AtomicBool>,
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
    running: HashMap<Key, Arc<AtomicBool>>,
    finished: HashMap<Key, Drawn>,
    closing: bool,
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Draws until the end.
    fn work(&self) {
        while let Some(Task { key, genome, cancel, tell }) = self.next() {
            let known = self.state().finished.get(&key).cloned();
            let drawn = known.or_else(|| {
                let order = Order { size: Some(key.1), samples: Some(1), ..Order::default() };
                let drawn = self.subject.draw(&genome, &order, &cancel).map(|png| png.map(Arc::from));
                // What was stopped may have failed because of that.
                drawn.transpose().filter(|_| !cancel.load(Ordering::SeqCst))
            });
            let mut state = self.state();
            state.running.remove(&key);
            if let Some(drawn) = &drawn {
                state.finished.insert(key, drawn.clone());
            }
            drop(state);
            // Others may wait for the same picture.
            self.bell.notify_all();
            if let Some(drawn) = drawn {
                tell(drawn);
            }
        }
    }

    /// Waits for something to draw that nobody else draws; `None` at the end.
    fn next(&self) -> Option<Task> {
        let mut state = self.state();
        loop {
            if state.closing {
                return None;
            }
            state.waiting.retain(|task| !task.cancel.load(Ordering::SeqCst));
            let running: HashSet<Key> = state.running.keys().copied().collect();
            if let Some(newest) = state.waiting.iter().rposition(|task| !running.contains(&task.key)) {
                let task = state.waiting.remove(newest);
                state.running.insert(task.key, task.cancel.clone());
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
    pub fn ask(&self, key: Key, genome: Genome, tell: impl FnOnce(Drawn) + Send + 'static) -> Ticket {
        let cancel = Arc::new(AtomicBool::new(false));
        let task = Task { key, genome, cancel: cancel.clone(), tell: Box::new(tell) };
        self.shared.state().waiting.push(task);
        self.shared.bell.notify_one();
        Ticket(cancel)
    }
}

impl Drop for Atelier {
    fn drop(&mut self) {
        {
            let mut state = self.shared.state();
            state.closing = true;
            state.running.values().for_each(|cancel| cancel.store(true, Ordering::SeqCst));
            self.shared.bell.notify_all();
        }
        for thread in self.threads.drain(..) {
            // A panic there was reported, and ended the program.
            let _ = thread.join();
        }
    }
}
