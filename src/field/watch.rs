//! Who watches a long job, and can stop it.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

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

impl Watch<'_> {
    /// Does a part of the job, which takes it from one share to another. What is told does not go back.
    pub fn part<T>(&self, from: f64, to: f64, work: impl FnOnce(&Watch<'_>) -> T) -> T {
        let most = AtomicU64::new(0);
        let progress = |share: f64| {
            // The bits of numbers that are not negative are in the order of the numbers.
            let share = share.clamp(0.0, 1.0);
            let told = f64::from_bits(most.fetch_max(share.to_bits(), Ordering::Relaxed)).max(share);
            (self.progress)(from + (to - from) * told);
        };
        work(&Watch { cancel: self.cancel, progress: &progress })
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[test]
    fn parts_of_a_job_fill_one_bar() {
        let told = Mutex::new(Vec::new());
        let progress = |share| told.lock().unwrap().push(share);
        let watch = Watch { cancel: &AtomicBool::new(false), progress: &progress };
        watch.part(0.0, 0.5, |part| [0.5, 1.0].map(part.progress));
        watch.part(0.5, 1.0, |part| [0.0, 0.5, 0.25, 1.0].map(part.progress));
        assert_eq!(told.into_inner().unwrap(), [0.25, 0.5, 0.5, 0.75, 0.75, 1.0]);
    }
}
