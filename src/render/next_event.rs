//! Light that comes straight from suns, lamps and the sky to where paths met something: next event estimation.
//!
//! From every place a ray goes out to each light, to a point of its disc. What it would bring waits until it is known
//! whether anything stands in its way, so that rays of all places are cast together.

use super::Prepared;
use super::gather;
use super::light::{self, Disc, Surroundings};
use super::path::{Paths, Trace};
use super::reflect::{Drawn, Reflector};
use super::sample::Purpose;
use super::stats::Stage;
use super::water::Water;
use super::worker::Seer;
use crate::cast::{Hit, Ray};
use crate::scene::{Light, Sun};
use glam::DVec3;

/// A ray to a light, and what it would bring to a patch: reflected by it, and by what is below it.
#[derive(Clone, Copy)]
pub(super) struct Errand {
    patch: usize,
    brings: DVec3,
    below: DVec3,
    is_sky: bool,
}

impl Errand {
    /// Adds what it brings to what leaves its patch.
    fn deliver(&self, shine: &mut [gather::Light], glow: &mut [DVec3]) {
        let shine = &mut shine[self.patch];
        if self.is_sky {
            shine.indirect += self.brings
        } else {
            shine.direct += self.brings
        }
        glow[self.patch] += self.below;
    }
}

impl Paths {
    /// Finds the light that comes to all patches straight, and leaves them towards the eye.
    pub(super) fn ask_lights(&mut self, seer: &mut Seer<'_>, step: u32, to: &mut Trace<'_>) {
        let stage = Stage::begin();
        let (scene, air) = (seer.scene, seer.scene.air.as_ref());
        let water = seer.water;
        let around = Surroundings { sky: &scene.sky, air, suns: &scene.suns };
        self.shine.clear();
        self.shine
            .extend(self.patches.iter().map(|p| gather::Light { direct: p.emission, ..Default::default() }));
        self.glow.clear();
        self.glow.resize(self.patches.len(), DVec3::ZERO);
        self.rays.clear();
        self.errands.clear();
        for (number, light) in (0u32..).zip(&scene.lights) {
            for i in 0..self.patches.len() {
                let (patch, path) = (self.patches[i], self.seen[i]);
                let sample = &to.samples[path.sample];
                let disc = Disc::of(light, patch.position, air);
                let from = disc.direction(sample.pair(Purpose::Light { step, number }));
                let mut errand = Errand { patch: i, brings: DVec3::ZERO, below: DVec3::ZERO, is_sky: false };
                let shadows = light::has_shadows(light);
                if let Some(water) = water.as_ref().filter(|_| i >= self.dry) {
                    let facing = patch.facing(from);
                    let irradiance = disc.irradiance;
                    errand.brings = facing * water.value(&patch, -path.direction, from) * irradiance;
                    errand.below = water.glow(irradiance * facing * water.entering(facing));
                    self.send_for(scene, errand, from, disc.distance, shadows);
                    continue;
                }
                let arrives = |from: DVec3| match water.as_ref().filter(|_| path.is_below()) {
                    Some(water) => disc.irradiance * water.entering(around.up(patch.position).dot(from)),
                    None => disc.irradiance,
                };
                let reflector = Reflector::new(&patch, scene.reflecting.as_ref());
                let density = disc.density().filter(|_| reflector.mirrors());
                errand.brings = reflector.lit(-path.direction, from, density) * arrives(from);
                self.send_for(scene, errand, from, disc.distance, shadows);
                let purpose = Purpose::Glint { step };
                let glint = density
                    .and_then(|_| {
                        reflector.glint(sample.number(purpose), sample.pair(purpose), -path.direction)
                    })
                    .filter(|glint| disc.holds(glint.direction));
                if let (Some(glint), Some(density)) = (glint, density) {
                    errand.brings = glint.lit(density) * arrives(glint.direction);
                    self.send_for(scene, errand, glint.direction, disc.distance, shadows);
                }
            }
        }
        self.ask_sky(scene, &around, water.as_ref(), step, to);
        self.return_errands(seer, to);
        self.drown(seer);
        stage.end(&mut to.stats.seconds.shadow, &mut to.stats.octaves.shadow);
    }

    /// The light of the sky, where it is not found by paths that escape.
    fn ask_sky(
        &mut self,
        scene: &Prepared,
        around: &Surroundings<'_>,
        water: Option<&Water>,
        step: u32,
        to: &Trace<'_>,
    ) {
        let reach = scene.settings.occlusion;
        for i in 0..self.patches.len() {
            let (patch, path) = (self.patches[i], self.seen[i]);
            if i >= self.dry {
                let light = around.ambient(&patch) * std::f64::consts::PI;
                self.glow[i] += water.map_or(DVec3::ZERO, |water| water.glow(light));
                continue;
            }
            // A path that is followed on finds the sky by itself.
            if scene.settings.bounces > 0 {
                continue;
            }
            let reflector = Reflector::new(&patch, scene.reflecting.as_ref());
            if reach == 0.0 {
                self.shine[i].indirect += reflector.ambient(-path.direction, around);
                continue;
            }
            let sample = &to.samples[path.sample];
            let purpose = Purpose::Onward { step };
            let drawn = reflector.sample(sample.number(purpose), sample.pair(purpose), -path.direction);
            let Some(Drawn { direction, share, .. }) =
                drawn.filter(|drawn| patch.normal.dot(drawn.direction) > 0.0)
            else {
                continue;
            };
            let brings = share * around.radiance(patch.position, direction);
            self.send(
                scene,
                Errand { patch: i, brings, below: DVec3::ZERO, is_sky: true },
                direction,
                reach,
                true,
            );
        }
    }

    /// Sends out a ray for a light, if it may bring anything.
    fn send_for(&mut self, scene: &Prepared, errand: Errand, from: DVec3, distance: f64, shadows: bool) {
        if errand.brings != DVec3::ZERO || errand.below != DVec3::ZERO {
            self.send(scene, errand, from, distance, shadows);
        }
    }

    /// Sends out a ray, or takes what it would bring at once where nothing can be in its way.
    fn send(&mut self, scene: &Prepared, errand: Errand, direction: DVec3, distance: f64, shadows: bool) {
        let origin = scene.lifted(&self.patches[errand.patch], 1.0);
        match scene.onward_ray(origin, direction, distance).filter(|_| shadows) {
            Some(ray) => {
                self.errands.push(errand);
                self.rays.push(ray);
            }
            None => errand.deliver(&mut self.shine, &mut self.glow),
        }
    }

    /// Casts the rays that were sent out, and takes what those bring that met nothing.
    fn return_errands(&mut self, seer: &mut Seer<'_>, to: &mut Trace<'_>) {
        self.hits.clear();
        self.hits.resize(self.rays.len(), Hit::MISS);
        seer.caster.any_hits(&self.rays, &mut self.hits, &mut to.stats.shadow, to.cancel);
        for ((errand, hit), cost) in self.errands.iter().zip(&self.hits).zip(seer.caster.costs()) {
            if !hit.is_hit() {
                errand.deliver(&mut self.shine, &mut self.glow);
            }
            self.outcomes[self.seen[errand.patch].sample].evaluations += cost;
        }
    }

    /// Takes from what lies under water the light that the water above takes away.
    fn drown(&mut self, seer: &mut Seer<'_>) {
        self.dim.clear();
        self.dim.resize(self.dry, DVec3::ONE);
        let (Some(water), Some(sea)) = (seer.water, &mut seer.sea) else { return };
        let which: Vec<usize> = (0..self.dry).filter(|&i| self.seen[i].is_below()).collect();
        let places: Vec<DVec3> = which.iter().map(|&i| self.patches[i].position).collect();
        for (i, depth) in which.into_iter().zip(sea.surface.depths(&places)) {
            self.dim[i] = water.through(depth);
            self.shine[i] = self.shine[i].times(self.dim[i]);
        }
    }

    /// Finds out where in the air suns shine, for shafts of light between shadows of the ground.
    pub(super) fn look_for_suns(&mut self, seer: &mut Seer<'_>, step: u32, to: &mut Trace<'_>) {
        self.nodes.clear();
        self.sunny.clear();
        let (Some(air), true) = (&seer.scene.air, step == 0 && seer.scene.has_shafts()) else { return };
        let stage = Stage::begin();
        self.rays.clear();
        self.owners.clear();
        let suns = (0u32..).zip(&seer.scene.lights).filter_map(|(number, light)| match light {
            Light::Sun(sun) => Some((number, sun)),
            Light::Lamp(_) => None,
        });
        let suns: Vec<(u32, &Sun)> = suns.collect();
        let (mut places, mut asked) = (Vec::new(), Vec::new());
        for path in &self.paths {
            let sample = &to.samples[path.sample];
            let jitter = sample.number(Purpose::Air { step });
            places.clear();
            air.nodes(path.origin, path.direction, path.distance, jitter, &mut places);
            for &(number, sun) in &suns {
                let towards =
                    Disc::of_sun(sun, DVec3::ONE).direction(sample.pair(Purpose::Light { step, number }));
                let may_be_hidden = sun.shadows && sun.irradiance != DVec3::ZERO;
                for (order, place) in places.iter().enumerate().filter(|_| may_be_hidden) {
                    if let Some(ray) = seer.scene.onward_ray(*place, towards, f64::INFINITY) {
                        // It begins in the air.
                        let near = ray.near.max(ray.tolerance.least);
                        asked.push((order, self.sunny.len() + order, Ray { near, ..ray }));
                    }
                }
                self.sunny.resize(self.sunny.len() + places.len(), 1.0);
            }
            self.nodes.push(suns.len() * places.len());
        }
        // Places of the same order along neighbouring lines are near to one another.
        asked.sort_by_key(|(order, ..)| *order);
        self.owners.extend(asked.iter().map(|(_, owner, _)| *owner));
        self.rays.extend(asked.iter().map(|(.., ray)| *ray));
        self.hits.clear();
        self.hits.resize(self.rays.len(), Hit::MISS);
        seer.caster.any_hits(&self.rays, &mut self.hits, &mut to.stats.shadow, to.cancel);
        for (owner, hit) in self.owners.iter().zip(&self.hits) {
            self.sunny[*owner] = if hit.is_hit() { 0.0 } else { 1.0 };
        }
        stage.end(&mut to.stats.seconds.shadow, &mut to.stats.octaves.shadow);
    }
}
