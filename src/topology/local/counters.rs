//! What finding out takes, as it goes on.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// What is counted; see [`LocalStats`](super::LocalStats). The last three are nanoseconds.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Count {
    Asked,
    Looked,
    Quick,
    Paths,
    Voxels,
    Minima,
    Saddles,
    Moats,
    Unknown,
    Crowded,
    Impatient,
    Lines,
    Streaming,
    Locating,
}

/// A number of each.
#[derive(Debug, Default)]
pub struct Counters([AtomicU64; Count::Locating as usize + 1]);

impl Counters {
    pub fn add(&self, what: Count, number: usize) {
        self.0[what as usize].fetch_add(number as u64, Ordering::Relaxed);
    }

    /// Adds the time since a part of the work began.
    pub fn add_time(&self, what: Count, start: Instant) {
        self.0[what as usize].fetch_add(start.elapsed().as_nanos() as u64, Ordering::Relaxed);
    }

    pub fn get(&self, what: Count) -> u64 {
        self.0[what as usize].load(Ordering::Relaxed)
    }

    /// Counting begins anew.
    pub fn clear(&self) {
        self.0.iter().for_each(|counter| counter.store(0, Ordering::Relaxed));
    }
}
