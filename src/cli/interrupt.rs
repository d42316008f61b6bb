//! Ctrl-C: the first one asks for an orderly end, the second one ends the program at once.
//!
//! An orderly end is the command's business: `render` writes what it has, `watch` leaves, `repl`
//! gives up the evaluation. A second Ctrl-C does no damage either, since files are written beside
//! their place and renamed into it. A session that somebody types into is worth more than an evaluation: there
//! a third one is needed.

use super::progress::Progress;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// The flag that Ctrl-C raises.
pub type Flag = Arc<AtomicBool>;

/// Ctrl-C as seen by one command.
#[derive(Clone, Debug, Default)]
pub struct Interrupt {
    flag: Flag,
    count: Arc<AtomicUsize>,
}

impl Interrupt {
    /// Starts listening; `first` is called on another thread for the first Ctrl-C (and the first
    /// after each [`reset`](Interrupt::reset)). Also taken for Ctrl-C: a polite request of the
    /// system to end, and the terminal being closed.
    pub fn listen(first: impl Fn() + Send + 'static) -> Interrupt {
        Interrupt::enduring(1, first)
    }

    /// Listens for a session: two presses are taken for impatience, and only the third for an end.
    pub fn patient() -> Interrupt {
        Interrupt::enduring(2, || {})
    }

    /// Listens, and ends the program at the press after so many.
    fn enduring(presses: usize, first: impl Fn() + Send + 'static) -> Interrupt {
        let interrupt = Interrupt::default();
        let (heard, first) = (interrupt.clone(), Mutex::new(first));
        // Without the handler Ctrl-C ends the program at once, which does no damage.
        let _ = ctrlc::set_handler(move || {
            let earlier = heard.count.fetch_add(1, Ordering::SeqCst);
            if earlier >= presses {
                std::process::exit(1);
            }
            heard.flag.store(true, Ordering::SeqCst);
            if earlier == 0 {
                first.lock().unwrap_or_else(PoisonError::into_inner)();
            }
        });
        interrupt
    }

    /// Listens for a job that stops soon, and says so.
    pub fn stopping(progress: &Progress) -> Interrupt {
        let bar = progress.clone();
        Interrupt::listen(move || bar.say("stopping (Ctrl-C again quits at once)"))
    }

    /// The flag, to hand to long jobs.
    pub fn flag(&self) -> Flag {
        self.flag.clone()
    }

    /// Forgets earlier presses.
    pub fn reset(&self) {
        self.flag.store(false, Ordering::SeqCst);
        self.count.store(0, Ordering::SeqCst);
    }
}
