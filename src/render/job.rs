//! The job of rendering: who watches it and can stop it, and what comes of it.

use super::air::Atmosphere;
use super::refine::{Rough, Steering, develop};
use super::worker::Shot;
use super::{Picture, Pixel, Prepared, Rect, RenderError, Stats, tile};
use crate::cast::Caster;
use crate::diag::Diagnostic;
use glam::DVec3;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// How far a job has come, in tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Finished.
    pub done: usize,
    /// In all.
    pub total: usize,
}

/// A finished tile.
#[derive(Clone, Copy, Debug)]
pub struct Fine<'a> {
    /// Where it is; it may reach beyond the window that is rendered.
    pub rect: Rect,
    /// Its pixels, row by row.
    pub pixels: &'a [Pixel],
    /// The light behind everything.
    pub background: [f32; 3],
}

impl Fine<'_> {
    /// The pixel at a column and a row of the picture, within the tile.
    pub fn pixel(&self, x: u32, y: u32) -> Pixel {
        self.pixels[((y - self.rect.y) * self.rect.width + x - self.rect.x) as usize]
    }
}

/// Who watches a job, and can stop it. The functions are called from any thread, one at a time.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// Set it to stop soon; what is finished by then is kept.
    pub cancel: &'a AtomicBool,
    /// Told after every tile.
    pub progress: &'a (dyn Fn(Progress) + Sync),
    /// Given every finished tile.
    pub tile: &'a (dyn Fn(&Fine<'_>) + Sync),
    /// Given every rough tile of a picture that [refines](super::refine()). Smaller ones follow larger ones, finished ones
    /// follow both, and none is told of after one that is better. None are made where nobody wants them.
    pub rough: Option<&'a (dyn Fn(&Rough) + Sync)>,
}

impl<'a> Job<'a> {
    /// A job that nobody watches.
    pub fn unwatched(cancel: &'a AtomicBool) -> Self {
        Job { cancel, progress: &|_| (), tile: &|_| (), rough: None }
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
    let still: Vec<Shot<'_>> = shots.iter().map(|shot| Shot { reach: None, ..*shot }).collect();
    let mut picture = develop(&still, job, &Steering::default())?;
    picture.fill();
    Ok(picture)
}

/// A picture in the making.
pub(super) struct Film<'a> {
    picture: &'a mut Picture,
    /// Finished tiles in all.
    total: usize,
    /// Which tiles are finished, row by row.
    finished: Vec<bool>,
}

impl<'a> Film<'a> {
    /// A film for a picture of so many tiles.
    pub fn new(picture: &'a mut Picture, total: usize) -> Film<'a> {
        let count =
            picture.width.div_ceil(tile::SIDE) as usize * picture.height.div_ceil(tile::SIDE) as usize;
        Film { picture, total, finished: vec![false; count] }
    }

    /// Numbers of the tiles that meet a rectangle.
    fn numbers(&self, rect: &Rect) -> impl Iterator<Item = usize> + use<> {
        let columns = self.picture.width.div_ceil(tile::SIDE);
        let range = |from: u32, to: u32| from / tile::SIDE..to.div_ceil(tile::SIDE);
        let (across, down) = (range(rect.x, rect.right()), range(rect.y, rect.bottom()));
        down.flat_map(move |y| across.clone().map(move |x| (y * columns + x) as usize))
    }

    /// Puts a finished tile in its place, and tells of it, unless the first one comes too late.
    pub fn put(&mut self, rect: &Rect, pixels: &[Pixel], job: &Job<'_>) {
        if !self.picture.fill_until(job.cancel) {
            return;
        }
        self.picture.put(rect, pixels);
        self.picture.tiles += 1;
        self.picture.finished = self.picture.tiles as usize == self.total;
        self.numbers(rect).for_each(|i| self.finished[i] = true);
        (job.tile)(&Fine { rect: *rect, pixels, background: self.picture.background });
        (job.progress)(Progress { done: self.picture.tiles as usize, total: self.total });
    }

    /// Tells of rough tiles, but not of those that come too late.
    pub fn paint(&self, tiles: &[Rough], job: &Job<'_>) {
        let is_late = |tile: &&Rough| self.numbers(&tile.rect).any(|i| self.finished[i]);
        if let Some(see) = job.rough {
            tiles.iter().filter(|tile| !is_late(tile)).for_each(see);
        }
    }
}

/// Adds to a picture what it cost, and what is odd about it.
pub(super) fn finish(picture: &mut Picture, shots: &[Shot<'_>], threads: Vec<Stats>) {
    picture.stats.threads = threads.len() as u64;
    for stats in threads {
        picture.stats += stats;
    }
    for shot in shots {
        let values = shot.caster.values().filter(|values| !Arc::ptr_eq(values, &shot.scene.cells));
        for cells in [&shot.scene.cells].into_iter().chain(&values) {
            let one = cells.prunings();
            let all = &mut picture.stats.prunings;
            (all.tapes, all.instructions, all.whole) =
                (all.tapes + one.tapes, all.instructions + one.instructions, one.whole);
        }
    }
    picture.warnings = shots.first().map_or(Vec::new(), |shot| warnings(shot.scene, picture));
}

fn warnings(scene: &Prepared, picture: &Picture) -> Vec<Diagnostic> {
    let mut warnings = scene.warnings.clone();
    warnings.extend(scene.air.as_ref().and_then(|air| elsewhere(air, picture)));
    if picture.empty && picture.finished && picture.is_whole() {
        let glance = &scene.probe.glance;
        warnings.push(if glance.inside == 0 {
            let or = if glance.undefined > 0 { " or undefined" } else { "" };
            Diagnostic::warning(format!(
                "there is no solid within the bounds: the field is positive{or} wherever it was tried"
            ))
            .hint("check the sign of the field (negative is inside), or widen the bounds")
        } else {
            Diagnostic::warning("the camera does not see the solid").hint(
                "turn the camera's target towards it; step back, or closer where it is smaller than a pixel",
            )
        });
    }
    let share =
        |n: u64| format!("{:.2}% of the samples", 100.0 * n as f64 / picture.stats.samples.max(n) as f64);
    if picture.stats.undefined > 0 {
        let share = share(picture.stats.undefined);
        let message =
            format!("colour or finish is not a number in {share} (such colours are shown in magenta)");
        warnings.push(Diagnostic::warning(message).hint("guard divisions and square roots with max or abs"));
    }
    if picture.stats.flat > 0 {
        let share = share(picture.stats.flat);
        let message = format!("the surface has no normal in {share} (it is shown as if it faced the eye)");
        warnings.push(
            Diagnostic::warning(message).hint(
                "there is none where a field jumps or is flat, nor beside places where it has no value",
            ),
        );
    }
    warnings
}

/// A warning about air that is that of a planet of another size: nothing that is seen is anywhere near its ground.
fn elsewhere(air: &Atmosphere, picture: &Picture) -> Option<Diagnostic> {
    if !(picture.finished && picture.is_whole()) {
        return None;
    }
    let seen = picture.pixels.iter().filter(|pixel| pixel.depth.is_finite());
    let far = |pixel: &Pixel| DVec3::from_array(pixel.position.map(f64::from)).length();
    let (least, most) = seen.map(far).fold((f64::INFINITY, 0.0_f64), |(a, b), r| (a.min(r), b.max(r)));
    let [ground, top] = air.reach();
    // What is deeper than the air is high is no valley of its ground.
    let is_elsewhere = least > top || most < 2.0 * ground - top;
    (least.is_finite() && is_elsewhere).then(|| {
        let message = format!(
            "the air is that of a planet of radius {ground}, and all that is seen of the solid is {least:.3} to {most:.3} from the \
             origin"
        );
        Diagnostic::warning(message).hint(
            "give the air the planet's radius, as in planet::earth_air(#{ radius: 2.0 }); it surrounds the origin",
        )
    })
}
