//! What colours rough tiles have.
//!
//! A tile that is not proven free shows the place where a surface is expected in its middle, or else where it may begin
//! at the earliest, which lies on another surface of the same field, `f = c > 0`, around the solid. Its colour is that
//! of the field's own there, in the light of the same lamps and the same sky but without shadows; where that surface
//! turns away from the eye, as it may near a crease, it is turned towards it. Water mirrors the sky alone, and hides what is
//! below. So rough tiles are as bright as finished ones, and nothing jumps; those of what moves are the mean of all
//! moments.

use super::super::gather::{Light, Met, Outcome, Sum};
use super::super::light;
use super::super::reflect::Reflector;
use super::super::surface::Patch;
use super::super::water::{Water, Way};
use super::super::worker::Shot;
use super::super::{Pixel, Prepared, Rect, View};
use super::queue::Tile;
use super::scout::{Scout, What};
use super::{Rough, Steering};
use glam::DVec3;
use std::f64::consts::PI;
use std::sync::atomic::AtomicBool;

/// The point of a lamp, of a lens and of a step through the air that stands for all.
const MIDDLE: f64 = 0.5;

/// What tiles show at one moment.
#[derive(Clone)]
pub(super) struct Moment<'a> {
    pub scene: &'a Prepared,
    water: Option<Water>,
    /// Light that comes back from all around, where the eye is under water.
    under: Option<DVec3>,
}

/// Where a surface begins, and which: a sight's.
type Face = (usize, DVec3);

impl Scout<'_> {
    /// The colours of tiles; of those that nothing is known of, none.
    pub fn paint(&mut self, tiles: &[Tile], cancel: &AtomicBool) -> Vec<Rough> {
        let (known, count) =
            (tiles.iter().filter(|tile| tile.strands.is_some()).collect::<Vec<_>>(), self.moments.len());
        let faces: Vec<Option<Face>> =
            known.iter().flat_map(|tile| (0..count).map(|moment| self.face(tile, moment))).collect();
        let mut patches = vec![None; faces.len()];
        for (number, sight) in self.sights.iter_mut().enumerate() {
            let (mut own, mut seen, mut found) = (Vec::new(), Vec::new(), Vec::new());
            for (i, face) in faces.iter().enumerate() {
                if let Some((_, at)) = face.filter(|(sight, _)| *sight == number) {
                    own.push(i);
                    seen.push((at, line(&sight.scene.view, &known[i / count].rect).1));
                }
            }
            sight.surface.patches(&seen, &mut found, cancel);
            own.into_iter().zip(found).for_each(|(i, patch)| patches[i] = Some((number, patch)));
        }
        let rough = |(tile, patches): (&&Tile, &[Option<(usize, Patch)>])| {
            self.rough(&tile.rect, tile.level, |moment| patches[moment])
        };
        known.iter().zip(patches.chunks(count)).map(rough).collect()
    }

    /// A tile that shows nothing but what is behind everything.
    pub fn nothing(&self, rect: &Rect, level: usize) -> Rough {
        self.rough(rect, level, |_| None)
    }

    /// The nearest place where a surface may begin in the middle of a tile.
    fn face(&self, tile: &Tile, moment: usize) -> Option<Face> {
        let strands = tile.strands.iter().flatten();
        let own = strands.filter(|strand| self.sights[strand.sight].moment == moment);
        let faces = own.map(|strand| (strand.sight, strand.bundle.face()));
        faces.min_by(|a, b| self.depth(a).partial_cmp(&self.depth(b)).unwrap_or(std::cmp::Ordering::Equal))
    }

    /// How far away a face is, after all that is in front of it in any case.
    fn depth(&self, &(sight, at): &Face) -> (bool, f64) {
        let sight = &self.sights[sight];
        (sight.what == What::Moon, sight.scene.view.depth(at))
    }

    /// A tile that shows what there is at each moment.
    fn rough(&self, rect: &Rect, level: usize, patch: impl Fn(usize) -> Option<(usize, Patch)>) -> Rough {
        let mut sum = Sum::NONE;
        for (i, moment) in self.moments.iter().enumerate() {
            let met = patch(i).map(|(sight, patch)| (&self.sights[sight], patch));
            let outcome = match met {
                None => moment.open(rect),
                Some((sight, patch)) if sight.what == What::Moon => {
                    let mut outcome = moment.open(rect);
                    outcome.put_behind(&Moment::alone(sight.scene).met(rect, patch, false));
                    outcome
                }
                Some((sight, patch)) => moment.met(rect, patch, sight.what == What::Sea),
            };
            sum.add(&outcome, self.background);
        }
        // Nothing was sampled.
        let pixel = Pixel { samples: 0.0, ..sum.resolve() };
        let background = self.background.as_vec3().to_array();
        Rough { rect: *rect, side: Steering::SIDES[level], pixel, background }
    }
}

impl<'a> Moment<'a> {
    /// That of a shot.
    pub fn new(shot: &Shot<'a>) -> Moment<'a> {
        let sea = shot.sea.map(|sea| sea.scene);
        Moment {
            water: sea.and(shot.scene.sea.as_ref()).map(Water::new),
            under: sea.and_then(|sea| shot.scene.glow_below(sea)),
            ..Moment::alone(shot.scene)
        }
    }

    /// That of a scene with nothing beside its solid.
    fn alone(scene: &'a Prepared) -> Moment<'a> {
        Moment { scene, water: None, under: None }
    }

    /// Whether the eye is under water, and so does not see its surface.
    pub fn is_under_water(&self) -> bool {
        self.under.is_some()
    }

    /// Nothing but air, or water.
    fn open(&self, rect: &Rect) -> Outcome {
        let (origin, direction) = line(&self.scene.view, rect);
        let (through, sky) = self.veil((origin, direction, f64::INFINITY));
        let mut outcome = Outcome::default();
        outcome.see(None, through);
        outcome.add(Light { sky, ..Light::default() }, 0);
        outcome
    }

    /// A patch of the solid, or of water.
    fn met(&self, rect: &Rect, mut patch: Patch, is_water: bool) -> Outcome {
        let (origin, direction) = line(&self.scene.view, rect);
        for normal in [&mut patch.normal, &mut patch.shading] {
            // As in a mirror that the eye looks straight into: what faces up still does.
            *normal -= 2.0 * normal.dot(direction).max(0.0) * direction;
        }
        let distance = patch.position.distance(origin);
        let (through, scattered) = self.veil((origin, direction, distance));
        let water = self.water.filter(|_| is_water);
        let leaves =
            water.map_or_else(|| self.shine(&patch, -direction), |w| self.mirror(&w, &patch, -direction));
        let mut light = leaves.times(through);
        light.sky += scattered;
        let footprint = self.scene.view.footprint(distance);
        let mut outcome = Outcome::default();
        outcome.see(Some(Met { patch, distance, footprint }), through);
        outcome.add(light, 0);
        outcome
    }

    /// What is between the eye and what it sees: the share of light that gets through, and what it adds.
    fn veil(&self, line: (DVec3, DVec3, f64)) -> (DVec3, DVec3) {
        match (self.under, &self.water) {
            (Some(glow), Some(water)) => {
                let through = water.through(line.2);
                (through, glow * (DVec3::ONE - through))
            }
            _ => self.scene.around().along(line, MIDDLE, &[]),
        }
    }

    /// What leaves a patch of the solid, as if nothing stood in the way of any light.
    fn shine(&self, patch: &Patch, to_eye: DVec3) -> Light {
        let reflector = Reflector::new(patch, self.scene.reflecting.as_ref());
        let straight = self.straight(patch, |from| reflector.lit(to_eye, from, None));
        let indirect = reflector.ambient(to_eye, &self.scene.around());
        Light { direct: patch.emission + straight, indirect, sky: DVec3::ZERO }
    }

    /// What leaves a patch of water: what it mirrors, and what comes back from the deep.
    fn mirror(&self, water: &Water, patch: &Patch, to_eye: DVec3) -> Light {
        let around = self.scene.around();
        let falls =
            self.straight(patch, |from| DVec3::splat(patch.facing(from))) + PI * around.ambient(patch);
        let comes = |way: Way| {
            let light =
                if way.is_down { water.glow(falls) } else { around.radiance(patch.position, way.direction) };
            way.share * light
        };
        let indirect = water.ways(patch, to_eye, None).into_iter().flatten().map(comes).sum();
        let direct = self.straight(patch, |from| patch.facing(from) * water.value(patch, to_eye, from));
        Light { direct, indirect, sky: DVec3::ZERO }
    }

    /// Light that comes to a patch straight from suns and lamps, as much of it as `share` says of where it comes from.
    fn straight(&self, patch: &Patch, share: impl Fn(DVec3) -> DVec3) -> DVec3 {
        let comes = |light| {
            let disc = light::Disc::of(light, patch.position, self.scene.air.as_ref());
            share(disc.direction([MIDDLE; 2])) * disc.irradiance
        };
        self.scene.lights.iter().map(comes).sum()
    }
}

/// The line of sight through the middle of a tile, and of the lens.
fn line(view: &View, rect: &Rect) -> (DVec3, DVec3) {
    let middle = |at: u32, size: u32| f64::from(at) + 0.5 * f64::from(size);
    view.ray(middle(rect.x, rect.width), middle(rect.y, rect.height), [MIDDLE; 2])
}
