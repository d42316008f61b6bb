//! Tiles: small squares of the picture, each rendered by one thread in stages that handle many
//! rays at once.

use super::sample::{Purpose, Strata, uniform};
use super::surface::{Patch, Surface};
use super::{Job, Pixel, Prepared, Rect, Stats, light, stars};
use crate::cast::{Caster, Hit, Ray, Tolerance};
use crate::noise;
use glam::DVec3;
use std::ops::Range;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Side of a tile in pixels.
const SIDE: u32 = 32;

/// Rays that a stage handles at once, about: enough for full batches, few enough that their state
/// stays in the cache and a cancelled job stops soon.
const GROUP: u32 = 4096;

/// The tiles of a picture, those in the middle first: that is where people look.
pub fn tiles(width: u32, height: u32) -> Vec<Rect> {
    let starts = |size: u32| (0..size).step_by(SIDE as usize);
    let tile = |x: u32, y: u32| Rect { x, y, width: SIDE.min(width - x), height: SIDE.min(height - y) };
    let mut tiles: Vec<Rect> = starts(height).flat_map(|y| starts(width).map(move |x| tile(x, y))).collect();
    let off = |at: u32, size: u32, whole: u32| i64::from(2 * at + size) - i64::from(whole);
    tiles.sort_by_key(|t| off(t.x, t.width, width).pow(2) + off(t.y, t.height, height).pow(2));
    tiles
}

/// A sample on its way from a ray to light.
#[derive(Clone, Copy)]
struct Sample {
    /// Number of the pixel in the tile.
    pixel: usize,
    direction: DVec3,
    /// Random number for the air.
    jitter: f64,
    /// Distance to the solid, and the number of the patch there; infinite for a miss.
    distance: f64,
    patch: usize,
}

/// What a pixel has gathered so far.
#[derive(Clone, Copy)]
struct Sum {
    color: DVec3,
    alpha: f64,
    nearest: f64,
    position: DVec3,
    normal: DVec3,
    evaluations: f64,
}

/// One thread's caster and memory.
pub(super) struct Worker<'a> {
    scene: &'a Prepared,
    caster: Box<dyn Caster>,
    surface: Surface,
    strata: Strata,
    pub(super) stats: Stats,
    sums: Vec<Sum>,
    samples: Vec<Sample>,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    patches: Vec<Patch>,
    /// The pixel of each patch.
    patch_pixels: Vec<usize>,
    lit: Vec<bool>,
    pixels: Vec<Pixel>,
}

impl<'a> Worker<'a> {
    pub(super) fn new(scene: &'a Prepared, caster: Box<dyn Caster>) -> Self {
        Worker {
            scene,
            caster,
            surface: Surface::new(scene),
            strata: Strata::new(scene.settings.samples),
            stats: Stats::default(),
            sums: Vec::new(),
            samples: Vec::new(),
            rays: Vec::new(),
            hits: Vec::new(),
            patches: Vec::new(),
            patch_pixels: Vec::new(),
            lit: Vec::new(),
            pixels: Vec::new(),
        }
    }

    /// Renders a tile; `None` when the job was cancelled before it was finished.
    pub(super) fn tile(&mut self, rect: &Rect, job: &Job<'_>) -> Option<&[Pixel]> {
        let none = Sum {
            color: DVec3::ZERO,
            alpha: 0.0,
            nearest: f64::INFINITY,
            position: DVec3::ZERO,
            normal: DVec3::ZERO,
            evaluations: 0.0,
        };
        let area = rect.width * rect.height;
        self.sums.clear();
        self.sums.resize(area as usize, none);
        let samples = self.scene.settings.samples;
        let at_once = (GROUP / area).max(1);
        for first in (0..samples).step_by(at_once as usize) {
            self.primary(rect, first..samples.min(first + at_once), job.cancel);
            self.surface(job.cancel);
            if job.is_cancelled() {
                return None;
            }
            self.shadows(job.cancel);
            self.shade();
            if job.is_cancelled() {
                return None;
            }
        }
        self.stats.pixels += u64::from(area);
        self.stats.samples += u64::from(area) * u64::from(samples);
        self.pixels.clear();
        self.pixels.extend(self.sums.iter().map(|sum| resolve(sum, samples)));
        Some(&self.pixels)
    }

    /// Casts rays through the pixels of the tile.
    fn primary(&mut self, rect: &Rect, samples: Range<u32>, cancel: &AtomicBool) {
        let stage = Stage::begin();
        let Prepared { settings, view, tolerance, .. } = self.scene;
        self.samples.clear();
        self.rays.clear();
        let mut owners = Vec::new();
        for (column, row) in places(rect) {
            let (x, y) = (rect.x + column, rect.y + row);
            let id = u64::from(y) << 32 | u64::from(x);
            for s in samples.clone() {
                let [u, v] = self.strata.place(id, s, settings.seed);
                let direction = view.direction(f64::from(x) + u, f64::from(y) + v);
                if let Some(ray) = view.ray(direction, &settings.bounds, *tolerance) {
                    owners.push(self.samples.len());
                    self.rays.push(ray);
                }
                self.samples.push(Sample {
                    pixel: (row * rect.width + column) as usize,
                    direction,
                    jitter: uniform(id, s, Purpose::Air, settings.seed),
                    distance: f64::INFINITY,
                    patch: 0,
                });
            }
        }
        self.hits.clear();
        self.hits.resize(self.rays.len(), Hit::MISS);
        self.caster.first_hits(&self.rays, &mut self.hits, &mut self.stats.primary, cancel);
        for ((owner, hit), cost) in owners.into_iter().zip(&self.hits).zip(self.caster.costs()) {
            let sample = &mut self.samples[owner];
            sample.distance = hit.t;
            self.sums[sample.pixel].evaluations += cost;
        }
        stage.end(&mut self.stats.seconds.primary, &mut self.stats.octaves.primary);
    }

    /// Finds normals and colours where rays met the solid.
    fn surface(&mut self, cancel: &AtomicBool) {
        let stage = Stage::begin();
        let eye = self.scene.view.eye;
        let mut seen = Vec::new();
        self.patch_pixels.clear();
        for sample in self.samples.iter_mut().filter(|s| s.distance.is_finite()) {
            sample.patch = seen.len();
            self.patch_pixels.push(sample.pixel);
            seen.push((eye + sample.distance * sample.direction, sample.direction));
        }
        self.surface.patches(&seen, &mut self.patches, cancel);
        self.stats.undefined += self.patches.iter().filter(|p| p.undefined).count() as u64;
        stage.end(&mut self.stats.seconds.surface, &mut self.stats.octaves.surface);
    }

    /// Casts rays towards the sun from the patches that face it.
    fn shadows(&mut self, cancel: &AtomicBool) {
        let stage = Stage::begin();
        let sun = &self.scene.sun;
        self.lit.clear();
        self.lit.extend(self.patches.iter().map(|p| light::faces(p, sun)));
        if sun.shadows {
            self.rays.clear();
            let mut owners = Vec::new();
            for (i, patch) in self.patches.iter().enumerate().filter(|&(i, _)| self.lit[i]) {
                if let Some(ray) = self.scene.shadow_ray(patch) {
                    owners.push(i);
                    self.rays.push(ray);
                }
            }
            self.hits.clear();
            self.hits.resize(self.rays.len(), Hit::MISS);
            self.caster.any_hits(&self.rays, &mut self.hits, &mut self.stats.shadow, cancel);
            for ((owner, hit), cost) in owners.into_iter().zip(&self.hits).zip(self.caster.costs()) {
                self.lit[owner] = !hit.is_hit();
                self.sums[self.patch_pixels[owner]].evaluations += cost;
            }
        }
        stage.end(&mut self.stats.seconds.shadow, &mut self.stats.octaves.shadow);
    }

    /// Adds the light of all samples to their pixels.
    fn shade(&mut self) {
        let start = Instant::now();
        let Prepared { sun, sky, view, .. } = self.scene;
        let air = self.scene.air.as_ref();
        let suns = [(sun.direction, sun.irradiance)];
        for sample in &self.samples {
            let sum = &mut self.sums[sample.pixel];
            let hit = sample.distance.is_finite();
            let (mut color, mut alpha) = (DVec3::ZERO, 0.0);
            if hit {
                let patch = &self.patches[sample.patch];
                color = light::reflected(patch, sun, self.lit[sample.patch], sky, air);
                alpha = 1.0;
                if sample.distance < sum.nearest {
                    (sum.nearest, sum.position, sum.normal) = (sample.distance, patch.position, patch.normal);
                }
            }
            if !hit && sky.stars > 0.0 {
                color = stars::radiance(sample.direction, view.pixel(), sky.stars);
            }
            if let Some(air) = air {
                let (eye, jitter) = (view.eye, sample.jitter);
                let seen = air.along(eye, sample.direction, sample.distance, &suns, jitter, &[]);
                color = color * seen.transmittance + seen.scattered;
                if !hit {
                    alpha = 1.0 - seen.transmittance.element_sum() / 3.0;
                }
            }
            sum.color += color;
            sum.alpha += alpha;
        }
        self.stats.seconds.shading += start.elapsed().as_secs_f64();
    }
}

/// The clock of a stage.
struct Stage {
    time: Instant,
    octaves: u64,
}

impl Stage {
    /// Now.
    fn begin() -> Stage {
        Stage { time: Instant::now(), octaves: noise::evaluated() }
    }

    /// Adds what has passed since, and the octaves that this thread has evaluated.
    fn end(self, seconds: &mut f64, octaves: &mut u64) {
        *seconds += self.time.elapsed().as_secs_f64();
        *octaves += noise::evaluated() - self.octaves;
    }
}

impl Prepared {
    /// The ray from a patch towards the sun, as far as the bounds go. It starts a few tolerances
    /// above the solid, so as not to meet the patch that it comes from.
    fn shadow_ray(&self, patch: &Patch) -> Option<Ray> {
        let tolerance = self.tolerance.at(patch.position.distance(self.view.eye));
        let rounding = 64.0 * f64::EPSILON * patch.position.abs().max_element();
        let origin = patch.position + (4.0 * tolerance + rounding) * patch.normal;
        let direction = self.sun.direction;
        // A patch on a face of the bounds may start its ray outside, where nothing is promised.
        let (enter, far) = self.settings.bounds.clip(origin, direction)?;
        let (near, tolerance) = (enter.max(0.0), Tolerance::fixed(tolerance));
        (near < far).then_some(Ray { origin, direction, near, far, tolerance })
    }
}

/// Columns and rows of the pixels of one of the [`tiles`], counted from its corner: neighbours among them are neighbours
/// in the picture, so that the rays of a batch stay together.
pub fn places(rect: &Rect) -> impl Iterator<Item = (u32, u32)> + use<> {
    let Rect { width, height, .. } = *rect;
    (0..SIDE * SIDE).map(unravel).filter(move |&(x, y)| x < width && y < height)
}

/// Column and row of the `i`-th pixel of a tile, in Morton's order.
fn unravel(i: u32) -> (u32, u32) {
    let every_other = |i: u32| (0..SIDE.ilog2()).fold(0, |x, bit| x | (i >> (2 * bit) & 1) << bit);
    (every_other(i), every_other(i >> 1))
}

fn resolve(sum: &Sum, samples: u32) -> Pixel {
    let share = 1.0 / f64::from(samples);
    Pixel {
        color: (sum.color * share).as_vec3().to_array(),
        alpha: (sum.alpha * share) as f32,
        depth: sum.nearest as f32,
        position: sum.position.as_vec3().to_array(),
        normal: sum.normal.as_vec3().to_array(),
        evaluations: sum.evaluations as f32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once() {
        for (width, height) in [(1, 1), (16, 16), (17, 33), (100, 5)] {
            let mut seen = vec![0; (width * height) as usize];
            for t in tiles(width, height) {
                for (x, y) in (t.y..t.y + t.height).flat_map(|y| (t.x..t.x + t.width).map(move |x| (x, y))) {
                    seen[(y * width + x) as usize] += 1;
                }
            }
            assert!(seen.iter().all(|&n| n == 1));
        }
    }

    #[test]
    fn the_order_within_a_tile_visits_every_pixel() {
        let whole = Rect { x: 0, y: 0, width: SIDE, height: SIDE };
        let mut seen: Vec<_> = places(&whole).collect();
        seen.sort();
        seen.dedup();
        assert_eq!(seen.len(), (SIDE * SIDE) as usize);
        assert_eq!(seen.last(), Some(&(SIDE - 1, SIDE - 1)));
    }
}
