//! Who watches a long job, and can stop it.

use std::sync::atomic::{AtomicBool, Ordering};

/// Who watches a job, and can stop it.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    /// Set it to stop soon.
    pub cancel: &'a AtomicBool,
    /// Told the share that is done, from any thread.
    pub progress: &'a (dyn Fn(f64) + Sync),
}

impl Watch<'_> {
    /// Whether to go on.
    ///
    /// # Errors
    /// [`Stopped`] if not.
    pub fn check(&self) -> Result<(), Stopped> {
        if self.cancel.load(Ordering::Relaxed) { Err(Stopped) } else { Ok(()) }
    }
}

impl std::fmt::Debug for Watch<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Watch").field("cancel", self.cancel).finish_non_exhaustive()
    }
}

/// Somebody wanted it to stop.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[error("it was not finished")]
pub struct Stopped;
