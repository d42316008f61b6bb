//! What a picture cost, and how far it is to be trusted.

use crate::cast::CastStats;
use crate::noise;
use crate::tape::Prunings;
use std::ops::AddAssign;
use std::time::Instant;

/// Seconds spent, summed over threads unless said otherwise.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Seconds {
    /// Rays through the pixels.
    pub primary: f64,
    /// Normals and colours.
    pub surface: f64,
    /// Rays to lights.
    pub shadow: f64,
    /// Rays from the solid onwards.
    pub bounced: f64,
    /// Light and air.
    pub shading: f64,
    /// From start to end, on the clock on the wall.
    pub wall: f64,
}

/// Noises evaluated, by what for; see [`noise::evaluated`](crate::noise::evaluated) for what counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Octaves {
    /// By rays through the pixels.
    pub primary: u64,
    /// For normals and colours.
    pub surface: u64,
    /// By rays to lights.
    pub shadow: u64,
    /// By rays from the solid onwards.
    pub bounced: u64,
}

/// What a picture cost, and how far it is to be trusted.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Stats {
    /// Rays through the pixels; a ray that misses the bounds counts as not cast.
    pub primary: CastStats,
    /// Lines of sight through rough tiles, which are no rays: what it took to take them forwards.
    pub rough: CastStats,
    /// Rays to lights.
    pub shadow: CastStats,
    /// Rays from the solid onwards.
    pub bounced: CastStats,
    /// Octaves of noise that were evaluated.
    pub octaves: Octaves,
    /// Tapes that were pruned for parts of the bounds.
    pub prunings: Prunings,
    /// Where the time went.
    pub seconds: Seconds,
    /// Rough tiles painted.
    pub tiles: u64,
    /// Pixels finished.
    pub pixels: u64,
    /// Samples finished.
    pub samples: u64,
    /// Samples whose colour or finish is not a number (such colours are shown in magenta).
    pub undefined: u64,
    /// Samples of surface without a normal, which is shown as if it faced the eye.
    pub flat: u64,
    /// Threads that could take part.
    pub threads: u64,
}

impl Stats {
    /// Rays of all kinds whose answer is not proven.
    pub fn uncertified(&self) -> u64 {
        self.primary.uncertified + self.shadow.uncertified + self.bounced.uncertified
    }
}

impl AddAssign for Seconds {
    fn add_assign(&mut self, o: Seconds) {
        self.primary += o.primary;
        self.surface += o.surface;
        self.shadow += o.shadow;
        self.bounced += o.bounced;
        self.shading += o.shading;
        self.wall += o.wall;
    }
}

impl AddAssign for Octaves {
    fn add_assign(&mut self, o: Octaves) {
        self.primary += o.primary;
        self.surface += o.surface;
        self.shadow += o.shadow;
        self.bounced += o.bounced;
    }
}

impl AddAssign for Stats {
    fn add_assign(&mut self, o: Stats) {
        self.primary += o.primary;
        self.rough += o.rough;
        self.shadow += o.shadow;
        self.bounced += o.bounced;
        self.octaves += o.octaves;
        self.seconds += o.seconds;
        self.tiles += o.tiles;
        self.pixels += o.pixels;
        self.samples += o.samples;
        self.undefined += o.undefined;
        self.flat += o.flat;
        self.threads += o.threads;
    }
}

/// The clock of a stage.
pub(super) struct Stage {
    time: Instant,
    octaves: u64,
}

impl Stage {
    /// Now.
    pub(super) fn begin() -> Stage {
        Stage { time: Instant::now(), octaves: noise::evaluated() }
    }

    /// Adds what has passed since, and the octaves that this thread has evaluated.
    pub(super) fn end(self, seconds: &mut f64, octaves: &mut u64) {
        *seconds += self.time.elapsed().as_secs_f64();
        *octaves += noise::evaluated() - self.octaves;
    }
}
