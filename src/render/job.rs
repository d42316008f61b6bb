//! The job of rendering: tiles to threads, and a way to watch and to stop it.

use super::tile::tiles;
use super::worker::{Shot, Worker};
use super::{Picture, Pixel, Prepared, Rect, RenderError};
use crate::cast::Caster;
use crate::diag::Diagnostic;
use rayon::prelude::*;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Instant;

/// How far a job has come, in tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Finished.
    pub done: usize,
    /// In all.
    pub total: usize,
}

/// Who watches a job, and can stop it. The functions are called from any thread, one at a time.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// Set it to stop soon; what is finished by then is kept.
    pub cancel: &'a AtomicBool,
    /// Told after every tile.
    pub progress: &'a (dyn Fn(Progress) + Sync),
    /// Given every finished tile, with its pixels row by row; it may reach beyond the window that is rendered.
    pub tile: &'a (dyn Fn(&Rect, &[Pixel]) + Sync),
}

impl<'a> Job<'a> {
    /// A job that nobody watches.
    pub fn unwatched(cancel: &'a AtomicBool) -> Self {
        Job { cancel, progress: &|_| (), tile: &|_, _| () }
    }
}

impl std::fmt::Debug for Job<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Job").field("cancel", self.cancel).finish_non_exhaustive()
    }
}

/// Renders a scene with a caster made for its field, on the threads of the current rayon pool.
/// A cancelled job gives the tiles that were finished.
///
/// # Errors
/// [`RenderError::Memory`] if there is no room for the picture.
pub fn render(scene: &Prepared, caster: &dyn Caster, job: &Job<'_>) -> Result<Picture, RenderError> {
    render_moments(&[Shot::of(scene, caster)], job)
}

/// Renders what moves: the mean over all moments, which differ in time alone.
///
/// # Errors
/// As for [`render`]; [`RenderError::Samples`] if there is no moment.
pub fn render_moments(shots: &[Shot<'_>], job: &Job<'_>) -> Result<Picture, RenderError> {
    let scene = shots.first().ok_or(RenderError::Samples(0))?.scene;
    let start = Instant::now();
    let mut picture = Picture::new(&scene.settings, scene.sky.background.as_vec3().to_array())?;
    let mut tiles = tiles(picture.width, picture.height);
    tiles.retain(|tile| tile.intersection(&picture.window).is_some());
    let threads = rayon::current_num_threads().min(tiles.len());
    let mut workers: Vec<Worker<'_>> = (0..threads).map(|_| Worker::new(shots)).collect();
    let next = AtomicUsize::new(0);
    let film = Mutex::new(&mut picture);
    workers.par_iter_mut().with_max_len(1).for_each(|worker| {
        while let Some(rect) = tiles.get(next.fetch_add(1, Ordering::Relaxed)) {
            let Some(pixels) = worker.tile(rect, job) else { break };
            let mut film = film.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            film.put(rect, pixels);
            film.tiles += 1;
            (job.tile)(rect, pixels);
            (job.progress)(Progress { done: film.tiles as usize, total: tiles.len() });
        }
    });
    picture.finished = picture.tiles as usize == tiles.len();
    for worker in &workers {
        picture.stats += worker.stats;
    }
    for shot in shots {
        let one = shot.scene.cells.prunings();
        let all = &mut picture.stats.prunings;
        (all.tapes, all.instructions, all.whole) =
            (all.tapes + one.tapes, all.instructions + one.instructions, one.whole);
    }
    picture.stats.threads = threads as u64;
    picture.stats.seconds.wall = start.elapsed().as_secs_f64();
    picture.empty = picture.pixels.iter().all(|p| p.depth.is_infinite());
    picture.warnings = warnings(scene, &picture);
    Ok(picture)
}

fn warnings(scene: &Prepared, picture: &Picture) -> Vec<Diagnostic> {
    let mut warnings = scene.warnings.clone();
    if picture.empty && picture.finished && picture.is_whole() {
        warnings.push(if scene.probe.inside == 0 {
            Diagnostic::warning(
                "there is no solid within the bounds: the field is positive wherever it was tried",
            )
            .hint("check the sign of the field (negative is inside), or widen the bounds")
        } else {
            Diagnostic::warning("the camera does not see the solid")
                .hint("turn the camera's target towards it, step back, or widen the field of view")
        });
    }
    if picture.stats.undefined > 0 {
        let share = 100.0 * picture.stats.undefined as f64 / picture.stats.samples as f64;
        let message =
            format!("colour or normal is not a number in {share:.2}% of the samples (shown in magenta)");
        warnings.push(Diagnostic::warning(message).hint("guard divisions and square roots in the colour"));
    }
    warnings
}
