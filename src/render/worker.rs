//! Workers: threads with a caster and memory of their own, which render tiles.
//!
//! A pixel takes its samples in rounds, until it has all of them or enough. In each round those of some pixels of a tile go
//! together from stage to stage ([`path`](super::path)), many rays at once, those of one moment after those of
//! another: a picture of what moves is made of several [`Shot`]s.

use super::gather::{Outcome, PILOT, Sum};
use super::irradiance::{Gathered, Irradiance};
use super::path::{Paths, Trace};
use super::sample::Sample;
use super::surface::Surface;
use super::tile::places;
use super::water::Water;
use super::{Filter, Job, Pixel, Prepared, Rect, Stats, light, stars};
use crate::cast::{Caster, Reach};
use crate::num::sequence;
use glam::DVec3;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Rays that a stage handles at once, about: enough for full batches, few enough that their state
/// stays in the cache and a cancelled job stops soon.
const GROUP: usize = 4096;

/// Side of a block of pixels, which know together what each may have missed.
const BLOCK: u32 = 8;

/// The block of a pixel of a tile.
fn block(rect: &Rect, x: u32, y: u32) -> usize {
    (y / BLOCK * rect.width.div_ceil(BLOCK) + x / BLOCK) as usize
}

/// A scene at one moment, and a caster made for its field.
#[derive(Clone, Copy)]
pub struct Shot<'a> {
    /// The scene.
    pub scene: &'a Prepared,
    /// The caster.
    pub caster: &'a dyn Caster,
    /// How whole tiles are seen, for pictures that [refine](super::refine()); without it they appear tile by tile.
    pub reach: Option<&'a dyn Reach>,
    /// Its moon, in a space of its own.
    pub moon: Option<&'a Shot<'a>>,
    /// The surface of its water.
    pub sea: Option<&'a Shot<'a>>,
}

impl<'a> Shot<'a> {
    /// A scene with nothing beside its solid.
    pub fn of(scene: &'a Prepared, caster: &'a dyn Caster) -> Shot<'a> {
        Shot { scene, caster, reach: None, moon: None, sea: None }
    }
}

/// The light behind everything, as the shutter sees it: that of the first moment, where it stays, to the last bit.
pub(super) fn backdrop(shots: &[Shot<'_>]) -> DVec3 {
    let Some(first) = shots.first().map(|shot| shot.scene.sky.background) else { return DVec3::ZERO };
    let change: DVec3 = shots.iter().map(|shot| shot.scene.sky.background - first).sum();
    first + change / shots.len() as f64
}

/// What a thread needs to see a shot.
pub(super) struct Seer<'a> {
    pub scene: &'a Prepared,
    pub caster: Box<dyn Caster>,
    pub surface: Surface,
    pub moon: Option<Box<Seer<'a>>>,
    pub sea: Option<Box<Seer<'a>>>,
    /// What is below its surface.
    pub water: Option<Water>,
}

impl<'a> Seer<'a> {
    fn new(shot: &Shot<'a>) -> Seer<'a> {
        Seer {
            scene: shot.scene,
            caster: shot.caster.clone_box(),
            surface: Surface::new(shot.scene),
            moon: shot.moon.map(|moon| Box::new(Seer::new(moon))),
            sea: shot.sea.map(|sea| Box::new(Seer::new(sea))),
            water: shot.sea.and(shot.scene.sea.as_ref()).map(Water::new),
        }
    }

    /// Light that comes back from all around an eye under water.
    pub fn under_water(&self) -> Option<DVec3> {
        self.sea.as_ref().and_then(|sea| self.scene.glow_below(sea.scene))
    }
}

/// One thread.
pub(super) struct Worker<'a> {
    /// One for each moment.
    seers: Vec<Seer<'a>>,
    /// The light behind everything.
    background: DVec3,
    filter: Filter,
    pub(super) stats: Stats,
    sums: Vec<Sum>,
    samples: Vec<Sample>,
    /// In which moments have their turn.
    order: Vec<usize>,
    paths: Paths,
    /// Light that is shared, at each moment.
    irradiance: Vec<Option<Irradiance>>,
    /// Those that go past everything, to the moon.
    passing: Vec<Sample>,
    moon_paths: Paths,
    pixels: Vec<Pixel>,
}

impl<'a> Worker<'a> {
    /// For a picture at some moments, at which light was gathered or is to be.
    pub(super) fn new(shots: &[Shot<'a>], gathered: &[Option<Arc<Gathered>>]) -> Self {
        let settings = &shots[0].scene.settings;
        Worker {
            seers: shots.iter().map(Seer::new).collect(),
            background: backdrop(shots),
            filter: settings.filter(),
            stats: Stats::default(),
            sums: Vec::new(),
            samples: Vec::new(),
            order: sequence::order(shots.len()),
            paths: Paths::default(),
            irradiance: gathered.iter().map(|gathered| gathered.clone().map(Irradiance::new)).collect(),
            passing: Vec::new(),
            moon_paths: Paths::default(),
            pixels: Vec::new(),
        }
    }

    /// Renders a tile; `None` when the job was cancelled before it was finished.
    pub(super) fn tile(&mut self, rect: &Rect, job: &Job<'_>) -> Option<&[Pixel]> {
        let area = rect.width * rect.height;
        self.sums.clear();
        self.sums.resize(area as usize, Sum::NONE);
        let settings = self.seers[0].scene.settings;
        let mut pixels: Vec<(u32, u32)> = places(rect).collect();
        let at_once = GROUP * self.seers.len();
        let mut round = 0..if settings.noise > 0.0 { PILOT.min(settings.samples) } else { settings.samples };
        while !round.is_empty() && !pixels.is_empty() {
            // Samples of a pixel have more in common than pixels have: as many of them as there is room for go together.
            let most = (at_once / round.len()).max(1);
            let parts = pixels.len().div_ceil(most);
            for some in pixels.chunks(pixels.len().div_ceil(parts)) {
                for start in round.clone().step_by(at_once) {
                    self.take(rect, some, start..round.end.min(start + at_once as u32), job)?;
                }
            }
            let missed = self.missed(rect);
            pixels.retain(|&(x, y)| !self.is_done((y * rect.width + x) as usize, missed[block(rect, x, y)]));
            round = round.end..settings.samples.min(2 * round.end);
        }
        self.stats.pixels += u64::from(area);
        self.pixels.clear();
        self.pixels.extend(self.sums.iter().map(Sum::resolve));
        Some(&self.pixels)
    }

    /// Takes some of the samples of some of the pixels.
    fn take(&mut self, rect: &Rect, pixels: &[(u32, u32)], range: Range<u32>, job: &Job<'_>) -> Option<()> {
        for moment in 0..self.seers.len() {
            self.samples(rect, pixels, range.clone(), moment);
            self.trace(moment, job)?;
        }
        self.stats.samples += pixels.len() as u64 * range.len() as u64;
        Some(())
    }

    /// Follows the samples of a moment, and adds what comes of them to their pixels.
    fn trace(&mut self, moment: usize, job: &Job<'_>) -> Option<()> {
        let seer = &mut self.seers[moment];
        let irradiance = self.irradiance[moment].as_mut();
        let mut trace =
            Trace { samples: &self.samples, stats: &mut self.stats, cancel: job.cancel, irradiance };
        self.paths.follow(seer, &mut trace)?;
        let outcomes = &mut self.paths.outcomes;
        if let Some(moon) = &mut seer.moon {
            let is_open = |(sample, outcome): (&Sample, &Outcome)| outcome.is_open().then_some(*sample);
            self.passing.clear();
            self.passing.extend(self.samples.iter().zip(&*outcomes).filter_map(is_open));
            let mut trace = Trace {
                samples: &self.passing,
                stats: &mut self.stats,
                cancel: job.cancel,
                irradiance: None,
            };
            self.moon_paths.follow(moon, &mut trace)?;
            let open = outcomes.iter_mut().filter(|outcome| outcome.is_open());
            open.zip(&self.moon_paths.outcomes).for_each(|(outcome, behind)| outcome.put_behind(behind));
        }
        for (i, (sample, outcome)) in self.samples.iter().zip(outcomes).enumerate() {
            // Stars take their time.
            if i % 64 == 0 && job.cancel.load(Ordering::Relaxed) {
                return None;
            }
            if outcome.is_open() {
                let (_, direction) = sample.line(&seer.scene.view);
                let Prepared { lights, sky, view, .. } = seer.scene;
                let stars = match sky.stars {
                    0.0 => DVec3::ZERO,
                    brightness => stars::radiance(direction, view.pixel(), brightness),
                };
                outcome.put_beyond(light::beyond(lights, direction) + stars);
            }
            self.sums[sample.in_tile].add(outcome, self.background);
        }
        Some(())
    }

    /// Whether a pixel has enough samples, where pixels may have missed so much.
    fn is_done(&self, pixel: usize, missed: f64) -> bool {
        let settings = &self.seers[0].scene.settings;
        self.sums[pixel].is_enough(settings.noise, (self.gain(), settings.tone), missed)
    }

    /// What light is multiplied with before it is shown.
    fn gain(&self) -> f64 {
        libm::exp2(self.seers[0].scene.settings.exposure)
    }

    /// How much the pixels of each block of a tile may have missed, row by row: the mean over the block, or if that is more over
    /// the tile, for what is so rare that a whole block misses it.
    fn missed(&self, rect: &Rect) -> Vec<f64> {
        let gain = self.gain();
        let mut blocks = vec![(0.0, 0.0); block(rect, rect.width - 1, rect.height - 1) + 1];
        for (x, y) in places(rect) {
            let (sum, count) = &mut blocks[block(rect, x, y)];
            *sum += self.sums[(y * rect.width + x) as usize].missed(gain);
            *count += 1.0;
        }
        let all = blocks.iter().map(|(sum, _)| sum).sum::<f64>() / f64::from(rect.width * rect.height);
        blocks.into_iter().map(|(sum, count)| f64::max(sum / count, all)).collect()
    }

    /// Lists samples of pixels, as far as they belong to a moment.
    fn samples(&mut self, rect: &Rect, pixels: &[(u32, u32)], range: Range<u32>, moment: usize) {
        let seed = self.seers[0].scene.settings.seed;
        self.samples.clear();
        for &(column, row) in pixels {
            let (x, y) = (rect.x + column, rect.y + row);
            let in_tile = (row * rect.width + column) as usize;
            for sample in range.clone() {
                let one = Sample::new([x, y], sample, seed, in_tile);
                if one.moment(&self.order) == moment {
                    self.samples.push(one.placed(&self.filter));
                }
            }
        }
        // Samples are everywhere in their pixels, or beyond; rays that are cast together should be close together.
        if range.len() > 1 || self.filter.reach() > 0.5 {
            self.samples.sort_by_cached_key(Sample::along_curve);
        }
    }
}
