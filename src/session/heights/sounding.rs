//! Heights by rays: from outside towards the centre, or straight down, to where the solid is first met.
//!
//! All rays to a centre end there, so those of a tile are a bundle like those from a camera's eye, only that they
//! run towards their common point: a ray is `centre - t u` for `t` from where it enters the bounds to zero. Casters
//! share what is certain of a bundle, and the first hit is the outermost surface, proven to be.

use super::chart::Chart;
use super::{Datum, go_on};
use crate::cast::{self, CastStats, Caster, Hit, Kind, Ray, Sifted, Tolerance};
use crate::diag::Diagnostic;
use crate::field::Field;
use crate::field::Watch;
use crate::render::{self, Rect, RenderError};
use crate::scene::{Aabb, Scene, Spacing};
use crate::session::topology::Sieve;
use crate::session::whereabouts;
use crate::tape::Cells;
use glam::DVec3;
use rayon::prelude::*;
use std::io;
use std::ops::AddAssign;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// How far a hit may lie above the surface, as a share of how far anything is from the origin: less than a
/// millimetre on the Earth. Roundings are far below, and so is what 32 bits can tell of its mountains.
const PRECISION: f64 = 1e-10;

/// What was found.
#[derive(Clone, Copy, Debug)]
pub struct Tally {
    /// Lowest height; infinity where there is none.
    pub lowest: f64,
    /// Highest height; minus infinity where there is none.
    pub highest: f64,
    /// Rays that met nothing down to the centre, or to the bottom.
    pub missed: u64,
    /// Rays that were inside the solid where they entered the bounds.
    pub cut: u64,
    /// What casting cost, and how much of it is not certified.
    pub cast: CastStats,
}

impl Default for Tally {
    fn default() -> Tally {
        let (lowest, highest) = (f64::INFINITY, f64::NEG_INFINITY);
        Tally { lowest, highest, missed: 0, cut: 0, cast: CastStats::default() }
    }
}

impl AddAssign for Tally {
    fn add_assign(&mut self, o: Tally) {
        self.lowest = self.lowest.min(o.lowest);
        self.highest = self.highest.max(o.highest);
        self.missed += o.missed;
        self.cut += o.cut;
        self.cast += o.cast;
    }
}

/// Measures the heights of a map, from its first row to its last.
pub(super) struct Sounder {
    line: Line,
    workers: Vec<Worker>,
    /// Pixels that are done.
    done: u64,
}

/// What turns a pixel into a ray.
#[derive(Clone, Copy)]
struct Line {
    chart: Chart,
    datum: Datum,
    bounds: Aabb,
    tolerance: Tolerance,
}

/// One thread's caster and memory.
struct Worker {
    caster: Box<dyn Caster>,
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    /// Of a tile, row by row.
    heights: Vec<f64>,
    tally: Tally,
}

impl Sounder {
    /// Prepares a scene, of whose solid a sieve says what is kept, for the threads of the current pool.
    ///
    /// # Errors
    /// A diagnostic if its expression is too large, its bounds are empty, or the job was stopped.
    pub(super) fn new(
        scene: &Scene,
        sieve: Option<&Sieve>,
        (chart, datum): (Chart, Datum),
        cancel: &AtomicBool,
    ) -> Result<Sounder, Box<Diagnostic>> {
        // Octaves that are finer than a pixel fade out.
        let (center, spacing) = match datum {
            Datum::Globe { center, .. } => (center, Spacing::Angle { from: center, angle: chart.pixel() }),
            Datum::Plane { center, depth } => (center, Spacing::Even(depth * chart.pixel())),
        };
        let (graph, roots) = spacing
            .limit(&scene.graph, &[scene.surface.field])
            .map_err(|e| RenderError::TooLarge(e).diagnostic())?;
        let field = Field::new(&graph, roots[0]);
        let mut bounds = whereabouts::region(scene, &field);
        if let (Datum::Plane { center, depth }, None) = (datum, scene.bounds) {
            // Land that goes on beyond what is looked for by itself.
            let [right, down] = chart.off(f64::from(chart.width()), f64::from(chart.size));
            let half = depth * DVec3::new(right, 0.0, down);
            let ends = Aabb { min: center - half, max: center + half };
            bounds.min = bounds.min.min(ends.min.with_y(bounds.min.y));
            bounds.max = bounds.max.max(ends.max.with_y(bounds.max.y));
        }
        let Aabb { min, max } = bounds;
        if !(min.is_finite() && max.is_finite() && min.cmplt(max).all()) {
            return Err(Box::new(RenderError::Bounds.diagnostic()));
        }
        let reach = min.abs().max(max.abs()).max(center.abs()).max_element();
        let line = Line { chart, datum, bounds, tolerance: Tolerance::fixed(PRECISION * reach) };
        let cells = Arc::new(Cells::of_sides(field.tape().clone(), &bounds.intervals()));
        let mut caster = cast::caster_in(Kind::Auto, &field, &bounds, &cells, &line.typical_rays(), cancel)
            .map_err(|e| Diagnostic::error(e.to_string()))?;
        if let Some(sieve) = sieve {
            caster = Box::new(Sifted::new(caster, &cells, &bounds, sieve.judge()));
        }
        let workers = (0..rayon::current_num_threads()).map(|_| Worker::new(caster.clone_box())).collect();
        Ok(Sounder { line, workers, done: 0 })
    }

    /// How far a height may be above the surface.
    pub(super) fn precision(&self) -> f64 {
        self.line.tolerance.least
    }

    /// The next rows of the map, face after face; NaN where there is nothing. Rows of two faces are never
    /// asked for at once.
    ///
    /// # Errors
    /// When stopped.
    pub(super) fn next(&mut self, rows: &mut [f64], watch: &Watch<'_>) -> io::Result<()> {
        let Chart { size, .. } = self.line.chart;
        let width = self.line.chart.width();
        let row = self.done / u64::from(width);
        let (face, first) = ((row / u64::from(size)) as usize, (row % u64::from(size)) as u32);
        let tiles = render::tiles(width, (rows.len() / width as usize) as u32);
        let (next, line, count) = (AtomicUsize::new(0), &self.line, rows.len());
        let done = AtomicU64::new(self.done);
        let map = Mutex::new(rows);
        self.workers.par_iter_mut().with_max_len(1).for_each(|worker| {
            while let Some(tile) = tiles.get(next.fetch_add(1, Ordering::Relaxed)) {
                worker.sound(line, face, &Rect { y: tile.y + first, ..*tile }, watch.cancel);
                if watch.cancel.load(Ordering::Relaxed) {
                    break;
                }
                let mut map = map.lock().unwrap_or_else(PoisonError::into_inner);
                for (y, row) in (tile.y as usize..).zip(worker.heights.chunks_exact(tile.width as usize)) {
                    let start = y * width as usize + tile.x as usize;
                    map[start..start + row.len()].copy_from_slice(row);
                }
                drop(map);
                let area = u64::from(tile.width * tile.height);
                let done = done.fetch_add(area, Ordering::Relaxed) + area;
                (watch.progress)(done as f64 / line.chart.pixels() as f64);
            }
        });
        go_on(watch)?;
        self.done += count as u64;
        Ok(())
    }

    /// What was found so far.
    pub(super) fn tally(&self) -> Tally {
        let mut all = Tally::default();
        self.workers.iter().for_each(|worker| all += worker.tally);
        all
    }
}

impl Line {
    /// The ray to the centre of the globe, or down, through a place in a picture, with its origin where heights are
    /// measured from; none where it passes the bounds.
    fn ray(&self, face: usize, x: f64, y: f64) -> Option<Ray> {
        let direction = -self.chart.direction(face, x, y);
        let (origin, end) = match self.datum {
            Datum::Globe { center, .. } => (center, 0.0),
            Datum::Plane { center, depth } => {
                let [right, down] = self.chart.off(x, y);
                (center + depth * DVec3::new(right, 0.0, down), f64::INFINITY)
            }
        };
        let (near, far) = self.bounds.clip(origin, direction)?;
        let far = far.min(end);
        (near < far).then_some(Ray { origin, direction, near, far, tolerance: self.tolerance })
    }

    /// Bundles of neighbouring rays all over the map, for choosing a caster.
    fn typical_rays(&self) -> Vec<Vec<Ray>> {
        /// Bundles along a side, and rays along a side of a bundle.
        const BUNDLES: u32 = 3;
        const RAYS: u32 = 8;
        let place = |i: u32, side: u32| (f64::from(i) + 0.5) / f64::from(BUNDLES) * f64::from(side);
        let bundle = |i: u32| {
            let face = i as usize % self.chart.faces();
            let x = place(i % BUNDLES, self.chart.width());
            let y = place(i / BUNDLES, self.chart.size);
            let ray = |j: u32| self.ray(face, x + f64::from(j % RAYS), y + f64::from(j / RAYS));
            (0..RAYS * RAYS).filter_map(ray).collect()
        };
        (0..BUNDLES * BUNDLES).map(bundle).collect()
    }
}

impl Worker {
    fn new(caster: Box<dyn Caster>) -> Worker {
        let (rays, hits, heights) = (Vec::new(), Vec::new(), Vec::new());
        Worker { caster, rays, hits, heights, tally: Tally::default() }
    }

    /// Measures a tile of a face.
    fn sound(&mut self, line: &Line, face: usize, tile: &Rect, cancel: &AtomicBool) {
        self.rays.clear();
        let mut owners = Vec::new();
        for (column, row) in render::places(tile) {
            let [x, y] = [tile.x + column, tile.y + row].map(|place| f64::from(place) + 0.5);
            if let Some(ray) = line.ray(face, x, y) {
                owners.push((row * tile.width + column) as usize);
                self.rays.push(ray);
            }
        }
        self.hits.clear();
        self.hits.resize(self.rays.len(), Hit::MISS);
        self.caster.first_hits(&self.rays, &mut self.hits, &mut self.tally.cast, cancel);
        self.heights.clear();
        self.heights.resize((tile.width * tile.height) as usize, f64::NAN);
        let radius = match line.datum {
            Datum::Globe { radius, .. } => radius,
            Datum::Plane { .. } => 0.0,
        };
        let met =
            owners.into_iter().zip(self.rays.iter().zip(&self.hits)).filter(|(_, (_, hit))| hit.is_hit());
        for (pixel, (ray, hit)) in met {
            let height = -hit.t - radius;
            self.heights[pixel] = height;
            self.tally.lowest = self.tally.lowest.min(height);
            self.tally.highest = self.tally.highest.max(height);
            self.tally.cut += u64::from(hit.t <= ray.near + line.tolerance.least);
        }
        self.tally.missed += self.heights.iter().filter(|height| height.is_nan()).count() as u64;
    }
}
