//! Scouts: threads that paint rough tiles.
//!
//! A tile that is not proven free shows the place where the surface is expected in its middle, or else where it may begin
//! at the earliest, which lies on another surface of the same field, `f = c > 0`, around the solid. Its colour is that
//! of the field's own there, in the light of the same lamps and the same sky but without shadows; where that surface
//! turns away from the eye, as it may near a crease, it is turned towards it. So rough tiles are as bright as finished
//! ones, and nothing jumps.

use super::super::gather::{Light, Met, Outcome, Sum};
use super::super::job::Film;
use super::super::light::{self, Surroundings};
use super::super::reflect::Reflector;
use super::super::surface::{Patch, Surface};
use super::super::worker::Shot;
use super::super::{Job, Pixel, Prepared, Rect, View};
use super::queue::{Queue, Tile};
use super::{Rough, Steering, locked};
use crate::cast::{Bundle, CastStats, Frame, Reach};
use glam::DVec3;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// The point of a lamp, and of a step through the air, that stands for all.
const MIDDLE: f64 = 0.5;

/// Paints rough tiles of a scene.
pub(super) struct Scout<'a> {
    scene: &'a Prepared,
    frame: Frame,
    /// Pixels beyond its edges from which a tile gathers light.
    around: f64,
    /// Side of the smallest tiles, in pixels.
    finest: u32,
    reach: Box<dyn Reach>,
    surface: Surface,
    pub stats: CastStats,
    /// Tiles painted.
    pub tiles: u64,
}

impl<'a> Scout<'a> {
    /// A scout for some shots; `None` where tiles cannot be painted roughly: by lenses and all around, for what moves, and
    /// where there is something beside the solid.
    pub fn new(shots: &[Shot<'a>], finest: u32) -> Option<Scout<'a>> {
        let [Shot { scene, reach: Some(reach), moon: None, sea: None, .. }] = shots else { return None };
        let around = (scene.settings.filter().reach() - 0.5).max(0.0);
        Some(Scout {
            scene,
            frame: scene.view.frame()?,
            around,
            finest,
            reach: reach.clone_box(),
            surface: Surface::new(scene).unpainted(),
            stats: CastStats::default(),
            tiles: 0,
        })
    }

    /// Another one, for another thread.
    pub fn again(&self) -> Scout<'a> {
        let surface = Surface::new(self.scene).unpainted();
        let (stats, tiles) = (CastStats::default(), 0);
        Scout { reach: self.reach.clone_box(), surface, stats, tiles, ..*self }
    }

    /// Lines up the largest tiles.
    pub fn begin(&self, queue: &Mutex<Queue>, film: &Mutex<Film<'_>>, job: &Job<'_>) {
        let side = Steering::SIDES[0];
        let (mut tiles, mut painted) = (Vec::new(), Vec::new());
        let whole = self.whole();
        for y in (0..whole.height).step_by(side as usize) {
            for x in (0..whole.width).step_by(side as usize) {
                self.enqueue(Rect { x, y, width: side, height: side }, 0, None, &mut tiles, &mut painted);
            }
        }
        locked(film).paint(&painted, job);
        locked(queue).extend(tiles);
    }

    /// The whole picture.
    fn whole(&self) -> Rect {
        Rect::whole(self.scene.settings.width, self.scene.settings.height)
    }

    /// Lines up a tile, a part of another if it is one; or paints it at once, if it passes the bounds by.
    fn enqueue(
        &self,
        square: Rect,
        level: usize,
        of: Option<&Bundle>,
        tiles: &mut Vec<Tile>,
        painted: &mut Vec<Rough>,
    ) {
        let Some(rect) = square.intersection(&self.whole()) else { return };
        let Prepared { settings, view, tolerance, .. } = self.scene;
        // As much as a beam of the caster is worth, if not more.
        let (rectangle, rays) = (view.rectangle(&rect, self.around), rect.area().max(64) as usize);
        let bundle = match of {
            Some(bundle) => bundle.part(rectangle, &settings.bounds, rays),
            None => Bundle::new(&self.frame, rectangle, &settings.bounds, (rays, *tolerance)),
        };
        match bundle {
            Some(bundle) => tiles.push(Tile { rect, level, bundle }),
            None => painted.push(Rough { rect, side: square.width, pixel: self.background(&rect) }),
        }
    }

    /// Takes tiles forwards and paints them. Returns their parts.
    pub fn survey(&mut self, tiles: Vec<Tile>, film: &Mutex<Film<'_>>, job: &Job<'_>) -> Vec<Tile> {
        let (rects, mut bundles): (Vec<_>, Vec<_>) =
            tiles.into_iter().map(|tile| ((tile.rect, tile.level), tile.bundle)).unzip();
        self.reach.advance(&mut bundles, &mut self.stats, job.cancel);
        let mut painted = self.paint(&rects, &bundles, job.cancel);
        if job.cancel.load(Ordering::Relaxed) {
            return Vec::new();
        }
        self.tiles += painted.len() as u64;
        let mut parts = Vec::new();
        for ((rect, level), bundle) in rects.iter().zip(&bundles).filter(|(_, bundle)| !bundle.is_free()) {
            let Some(&side) = Steering::SIDES.get(level + 1).filter(|side| **side >= self.finest) else {
                continue;
            };
            for (x, y) in [(0, 0), (side, 0), (0, side), (side, side)] {
                let square = Rect { x: rect.x + x, y: rect.y + y, width: side, height: side };
                self.enqueue(square, level + 1, Some(bundle), &mut parts, &mut painted);
            }
        }
        locked(film).paint(&painted, job);
        parts
    }

    /// The colours of tiles.
    fn paint(&mut self, rects: &[(Rect, usize)], bundles: &[Bundle], cancel: &AtomicBool) -> Vec<Rough> {
        let view = &self.scene.view;
        let met = rects.iter().zip(bundles).filter(|(_, bundle)| !bundle.is_free());
        let seen: Vec<_> = met.map(|((rect, _), bundle)| (bundle.face(), line(view, rect).1)).collect();
        let mut patches = Vec::with_capacity(seen.len());
        self.surface.patches(&seen, &mut patches, cancel);
        let mut patches = patches.into_iter();
        let paint = |(&(rect, level), bundle): (&(Rect, usize), &Bundle)| {
            let patch = if bundle.is_free() { None } else { patches.next() };
            let pixel = patch.map_or_else(|| self.background(&rect), |patch| self.met(&rect, patch));
            Rough { rect, side: Steering::SIDES[level], pixel }
        };
        rects.iter().zip(bundles).map(paint).collect()
    }

    /// A tile that shows a patch.
    fn met(&self, rect: &Rect, mut patch: Patch) -> Pixel {
        let (origin, direction) = line(&self.scene.view, rect);
        for normal in [&mut patch.normal, &mut patch.shading] {
            // As in a mirror that the eye looks straight into: what faces up still does.
            *normal -= 2.0 * normal.dot(direction).max(0.0) * direction;
        }
        let distance = patch.position.distance(origin);
        let (through, scattered) = self.around().along((origin, direction, distance), MIDDLE, &[]);
        let mut light = self.shine(&patch, -direction).times(through);
        light.sky += scattered;
        let footprint = self.scene.view.footprint(distance);
        developed(light, Some(Met { patch, distance, footprint }), through)
    }

    /// A tile that shows nothing but air.
    fn background(&self, rect: &Rect) -> Pixel {
        let (origin, direction) = line(&self.scene.view, rect);
        let (through, sky) = self.around().along((origin, direction, f64::INFINITY), MIDDLE, &[]);
        developed(Light { sky, ..Light::default() }, None, through)
    }

    fn around(&self) -> Surroundings<'_> {
        let Prepared { sky, air, suns, .. } = self.scene;
        Surroundings { sky, air: air.as_ref(), suns }
    }

    /// What leaves a patch, as if nothing stood in the way of any light.
    fn shine(&self, patch: &Patch, to_eye: DVec3) -> Light {
        let Prepared { lights, air, reflecting, .. } = self.scene;
        let reflector = Reflector::new(patch, reflecting.as_ref());
        let straight = |light| {
            let light::Arriving { from, irradiance, .. } =
                light::arriving(light, patch.position, [MIDDLE; 2], air.as_ref());
            let facing = patch.shading.dot(from);
            if facing > 0.0 { reflector.value(to_eye, from) * irradiance * facing } else { DVec3::ZERO }
        };
        let direct = patch.emission + lights.iter().map(straight).sum::<DVec3>();
        Light { direct, indirect: reflector.ambient(to_eye, &self.around()), sky: DVec3::ZERO }
    }
}

/// The line of sight through the middle of a tile.
fn line(view: &View, rect: &Rect) -> (DVec3, DVec3) {
    let middle = |at: u32, size: u32| f64::from(at) + 0.5 * f64::from(size);
    view.ray(middle(rect.x, rect.width), middle(rect.y, rect.height), [MIDDLE; 2])
}

/// Light as a pixel.
fn developed(light: Light, met: Option<Met>, through: DVec3) -> Pixel {
    let mut outcome = Outcome::default();
    outcome.see(met, through);
    outcome.add(light, 0);
    let mut sum = Sum::NONE;
    sum.add(&outcome);
    // Nothing was sampled.
    Pixel { samples: 0.0, ..sum.resolve() }
}
