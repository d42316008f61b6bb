//! Scouts: threads that take rough tiles forwards.
//!
//! A tile shows what any of its lines of sight may meet: of the solid, of the sea that it stands in and of the moon behind
//! it, at every moment while the shutter is open. Each of these is a [`Sight`], and the lines through the tile to it are a
//! bundle, or two for a lens ([`Lines`]). A tile is free when all of them are; strands that are free are gone from its
//! parts.

use super::super::job::Film;
use super::super::surface::Surface;
use super::super::view::Lines;
use super::super::worker::{Shot, backdrop};
use super::super::{Job, Prepared, Rect};
use super::paint::Moment;
use super::queue::{Queue, Strand, Tile};
use super::{Rough, Steering, locked};
use crate::cast::{Bundle, CastStats, Reach};
use glam::DVec3;
use std::sync::Mutex;
use std::sync::atomic::Ordering;

/// What is seen at a moment.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum What {
    Solid,
    Sea,
    /// Behind everything else.
    Moon,
}

/// A way to see one solid at one moment.
pub(super) struct Sight<'a> {
    pub scene: &'a Prepared,
    pub what: What,
    /// The number of the moment.
    pub moment: usize,
    pub surface: Surface,
    reach: Box<dyn Reach>,
}

/// Takes rough tiles of a scene forwards.
pub(super) struct Scout<'a> {
    pub sights: Vec<Sight<'a>>,
    pub moments: Vec<Moment<'a>>,
    /// The light behind everything.
    pub background: DVec3,
    /// Pixels beyond its edges from which a tile gathers light.
    around: f64,
    /// Side of the smallest tiles, in pixels.
    finest: u32,
    pub stats: CastStats,
    /// Tiles painted.
    pub tiles: u64,
}

impl<'a> Sight<'a> {
    /// The sight of a shot's own solid, if whole tiles of it can be seen.
    fn new(shot: &Shot<'a>, moment: usize, what: What) -> Option<Sight<'a>> {
        let Shot { scene, reach, .. } = *shot;
        let surface = Surface::new(scene).unpainted();
        Some(Sight { scene, what, moment, surface, reach: reach?.clone_box() })
    }

    /// The same for another thread.
    fn again(&self) -> Sight<'a> {
        Sight { surface: Surface::new(self.scene).unpainted(), reach: self.reach.clone_box(), ..*self }
    }
}

impl<'a> Scout<'a> {
    /// A scout for some shots, unless there is something of which whole tiles cannot be seen.
    pub fn new(shots: &[Shot<'a>], finest: u32) -> Option<Scout<'a>> {
        let moments: Vec<Moment<'_>> = shots.iter().map(Moment::new).collect();
        let mut sights = Vec::new();
        for (i, (shot, moment)) in shots.iter().zip(&moments).enumerate() {
            sights.push(Sight::new(shot, i, What::Solid)?);
            if let Some(sea) = shot.sea.filter(|_| !moment.is_under_water()) {
                sights.push(Sight::new(sea, i, What::Sea)?);
            }
            if let Some(moon) = shot.moon {
                sights.push(Sight::new(moon, i, What::Moon)?);
            }
        }
        let around = (shots.first()?.scene.settings.filter().reach() - 0.5).max(0.0);
        let (stats, background) = (CastStats::default(), backdrop(shots));
        Some(Scout { sights, moments, background, around, finest, stats, tiles: 0 })
    }

    /// Another one, for another thread.
    pub fn again(&self) -> Scout<'a> {
        let sights = self.sights.iter().map(Sight::again).collect();
        Scout { sights, moments: self.moments.clone(), stats: CastStats::default(), tiles: 0, ..*self }
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
        let settings = self.moments[0].scene.settings;
        Rect::whole(settings.width, settings.height)
    }

    /// Lines up a tile, a part of another if it is one; or paints it at once, if it passes everything by.
    fn enqueue(
        &self,
        square: Rect,
        level: usize,
        of: Option<&[Strand]>,
        tiles: &mut Vec<Tile>,
        painted: &mut Vec<Rough>,
    ) {
        let Some(rect) = square.intersection(&self.whole()) else { return };
        let strands = self.strands(&rect, of);
        match strands {
            Some(strands) if strands.is_empty() => painted.push(self.nothing(&rect, level)),
            strands => tiles.push(Tile { rect, level, strands }),
        }
    }

    /// The lines of sight through a tile, which go on from those of another if it is a part of that.
    fn strands(&self, rect: &Rect, of: Option<&[Strand]>) -> Option<Vec<Strand>> {
        // As much as a beam of the caster is worth, if not more.
        let rays = rect.area().max(64) as usize;
        let mut strands = Vec::new();
        for (sight, Sight { scene, .. }) in self.sights.iter().enumerate() {
            let Prepared { settings, view, tolerance, .. } = scene;
            for Lines { piece, frame, rectangle } in view.lines(rect, self.around)? {
                let bundle = match of {
                    None => Bundle::new(&frame, rectangle, &settings.bounds, (rays, *tolerance)),
                    Some(of) => {
                        let own = of.iter().find(|strand| (strand.sight, strand.piece) == (sight, piece));
                        own.and_then(|s| s.bundle.part(&frame, rectangle, &settings.bounds, rays))
                    }
                };
                strands.extend(bundle.map(|bundle| Strand { sight, piece, bundle }));
            }
        }
        Some(strands)
    }

    /// Takes tiles forwards and paints them. Returns their parts.
    pub fn survey(&mut self, mut tiles: Vec<Tile>, film: &Mutex<Film<'_>>, job: &Job<'_>) -> Vec<Tile> {
        self.advance(&mut tiles, job);
        let mut painted = self.paint(&tiles, job.cancel);
        if job.cancel.load(Ordering::Relaxed) {
            return Vec::new();
        }
        self.tiles += painted.len() as u64;
        let mut parts = Vec::new();
        for Tile { rect, level, strands } in tiles {
            let is_free = strands.as_ref().is_some_and(Vec::is_empty);
            let side = Steering::SIDES.get(level + 1).filter(|side| !is_free && **side >= self.finest);
            let Some(&side) = side else { continue };
            for (x, y) in [(0, 0), (side, 0), (0, side), (side, side)] {
                let square = Rect { x: rect.x + x, y: rect.y + y, width: side, height: side };
                self.enqueue(square, level + 1, strands.as_deref(), &mut parts, &mut painted);
            }
        }
        locked(film).paint(&painted, job);
        parts
    }

    /// Takes the strands of tiles forwards, all that see the same together, and drops those that are free.
    fn advance(&mut self, tiles: &mut [Tile], job: &Job<'_>) {
        for (sight, Sight { reach, .. }) in self.sights.iter_mut().enumerate() {
            let strands = tiles.iter_mut().flat_map(|tile| tile.strands.iter_mut().flatten());
            let own = strands.filter(|strand| strand.sight == sight).map(|strand| &mut strand.bundle);
            reach.advance(&mut own.collect::<Vec<_>>(), &mut self.stats, job.cancel);
        }
        for strands in tiles.iter_mut().filter_map(|tile| tile.strands.as_mut()) {
            strands.retain(|strand| !strand.bundle.is_free());
        }
    }
}
