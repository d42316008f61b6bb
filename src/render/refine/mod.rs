//! Pictures that refine: rough tiles at once, smaller ones instead of them, and in the end the picture as it is.
//!
//! ```text
//! tiles of 128 pixels --> 64 --> 32 --> 16 --> 8 --> the picture's own tiles, ray by ray
//! ```
//!
//! A rough tile is one colour. It is that of the background where it is proven that no line of sight through the tile
//! meets the solid ([`Reach`]), and has no parts; elsewhere it is that of the place where the solid begins in its
//! middle at the earliest, and its quarters follow. So every picture on the way shows all of the solid, and more of what
//! is beside it the rougher it is (Gamito 2009, chapter 7).
//!
//! The tiles at the end are those of any other picture, rendered by the same [`Worker`]s: pictures that were refined
//! equal pictures that were not, bit for bit. Not even where tiles are free do they take anything over from what came
//! before, because how rays are grouped shows in the last bits of their hits; what the rough tiles cost is what
//! refining costs.
//!
//! Somebody who watches can ask for a region of interest at any time ([`Steering::focus`]): its tiles jump the queue,
//! down to the finished ones.
//!
//! [`Reach`]: crate::cast::Reach

mod paint;
mod queue;
mod scout;
mod snapshots;

use super::irradiance::Gathered;
use super::job::{Film, finish};
use super::worker::{Shot, Worker, backdrop};
use super::{Job, Picture, Pixel, Rect, RenderError, Stats};
use queue::{Queue, Work};
use rayon::prelude::*;
use scout::Scout;
pub use snapshots::Snapshots;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// A rough tile: one pixel that stands for all of its.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rough {
    /// Where it is.
    pub rect: Rect,
    /// Its side, of [`Steering::SIDES`], were it not cut off by the border of the picture.
    pub side: u32,
    /// What it shows: nothing but background, or a moon, where the depth is infinite.
    pub pixel: Pixel,
    /// The light behind everything.
    pub background: [f32; 3],
}

/// How somebody who watches steers what is refined first, and how far before the finished tiles are due.
#[derive(Debug)]
pub struct Steering {
    finest: u32,
    region: Mutex<Option<Rect>>,
    /// Counts the times that the region was changed.
    changes: AtomicUsize,
}

impl Steering {
    /// Sides of rough tiles in pixels, largest first.
    pub const SIDES: [u32; 8] = [128, 64, 32, 16, 8, 4, 2, 1];

    /// With rough tiles down to a side.
    pub fn down_to(side: u32) -> Steering {
        Steering { finest: side, region: Mutex::default(), changes: AtomicUsize::new(0) }
    }

    /// Asks for a part of the picture before all others, or for none.
    pub fn focus(&self, region: Option<Rect>) {
        let before = std::mem::replace(&mut *locked(&self.region), region);
        self.changes.fetch_add(usize::from(before != region), Ordering::Release);
    }

    /// The region, if it is another than after so many changes.
    fn changed_since(&self, changes: &mut usize) -> Option<Option<Rect>> {
        let now = self.changes.load(Ordering::Acquire);
        (now != *changes).then(|| {
            *changes = now;
            *locked(&self.region)
        })
    }
}

impl Default for Steering {
    /// With rough tiles as small as is worth the while: smaller ones hardly look better, and take time from those that are
    /// rendered.
    fn default() -> Steering {
        Steering::down_to(8)
    }
}

/// What is behind a lock. A thread that panicked while it held it ends the picture anyway.
pub(super) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Renders as [`render_moments`](super::render_moments) does, rough tiles first where the shots have ways to make
/// them. A cancelled job gives the tiles that were finished; where there is none, the window of the picture is empty.
///
/// # Errors
/// As for [`render_moments`](super::render_moments).
pub fn refine(shots: &[Shot<'_>], job: &Job<'_>, steering: &Steering) -> Result<Picture, RenderError> {
    let mut picture = develop(shots, job, steering)?;
    if picture.pixels.is_empty() {
        picture.window = Rect { x: 0, y: 0, width: 0, height: 0 };
    }
    Ok(picture)
}

/// The same, but a picture without a finished tile has no pixels at all.
pub(super) fn develop(
    shots: &[Shot<'_>],
    job: &Job<'_>,
    steering: &Steering,
) -> Result<Picture, RenderError> {
    let scene = shots.first().ok_or(RenderError::Samples(0))?.scene;
    let start = Instant::now();
    let mut picture = Picture::reserved(&scene.settings, backdrop(shots).as_vec3().to_array())?;
    let queue = Queue::new(&picture, rayon::current_num_threads());
    let film = Mutex::new(Film::new(&mut picture, queue.finished_tiles()));
    let scout = Scout::new(shots, steering.finest);
    let queue = Mutex::new(queue);
    if let Some(scout) = &scout {
        scout.begin(&queue, &film, job);
    }
    let threads = rayon::current_num_threads().min(locked(&queue).finished_tiles());
    let gathered = |moment| Gathered::new(&scene.settings, moment, shots.len());
    let gathered: Vec<_> = (0..shots.len()).map(gathered).collect();
    let hand = |_| Hand { worker: Worker::new(shots, &gathered), scout: scout.as_ref().map(Scout::again) };
    let mut hands: Vec<Hand<'_>> = (0..threads).map(hand).collect();
    hands.par_iter_mut().with_max_len(1).for_each(|hand| hand.work(&queue, &film, job, steering));
    drop(film);
    let stats = hands.iter().map(Hand::stats).collect();
    finish(&mut picture, shots, stats);
    picture.stats.seconds.wall = start.elapsed().as_secs_f64();
    Ok(picture)
}

/// One thread, with what it needs for either kind of tile.
struct Hand<'a> {
    worker: Worker<'a>,
    scout: Option<Scout<'a>>,
}

impl Hand<'_> {
    fn work(&mut self, queue: &Mutex<Queue>, film: &Mutex<Film<'_>>, job: &Job<'_>, steering: &Steering) {
        while !job.cancel.load(Ordering::Relaxed) {
            let work = locked(queue).next(steering);
            match (work, &mut self.scout) {
                (Some(Work::Finished(rect)), _) => {
                    let Some(pixels) = self.worker.tile(&rect, job) else { break };
                    locked(film).put(&rect, pixels, job);
                }
                (Some(Work::Rough(tiles)), Some(scout)) => {
                    let parts = scout.survey(tiles, film, job);
                    locked(queue).extend(parts);
                }
                _ => break,
            }
        }
    }

    fn stats(&self) -> Stats {
        let mut stats = self.worker.stats;
        if let Some(scout) = &self.scout {
            (stats.rough, stats.tiles) = (scout.stats, scout.tiles);
        }
        stats
    }
}
