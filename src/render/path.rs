//! Paths of light, followed backwards from the eye, all those of a tile together:
//!
//! ```text
//! rays --> first hits --> normals, colours --> rays to lights --> light --> rays onwards
//!  ^                                                                             |
//!  '-----------------------------------------------------------------------------'
//! ```
//!
//! What reaches the eye along a path is a sum over the places where it was reflected: of what the solid gives off there and
//! of the light that came there straight, times the shares that the places on the way reflected (Kajiya 1986). Where to go on
//! is drawn as the material reflects, so that these shares are close to its colour. Suns and lamps are asked for at every place
//! and never found by chance, the sky is found by paths that escape and never asked for: each kind of light comes in
//! once, and the mean over all samples is right for the bounces that are allowed.
//!
//! On the surface of a sea a path parts in two: one is reflected, and one goes down.

use super::air::Atmosphere;
use super::gather::{Light, Met, Outcome};
use super::light::{self, Surroundings};
use super::reflect::Reflector;
use super::sample::{Purpose, Sample};
use super::surface::{Patch, Surface};
use super::view::piece;
use super::water::Water;
use super::worker::Seer;
use super::{Prepared, Stats};
use crate::cast::{Hit, Ray, Tolerance};
use crate::noise;
use crate::scene;
use glam::DVec3;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// How often a path may be reflected by water, beside its bounces.
const REFLECTIONS: u32 = 2;

/// A path on its way.
#[derive(Clone, Copy)]
pub(super) struct Path {
    sample: usize,
    origin: DVec3,
    direction: DVec3,
    /// Share of light that gets from here to the eye, by channel.
    weight: DVec3,
    /// How often it has been reflected by the solid.
    bounce: u32,
    /// Light that comes back from all around, where it is under water.
    under: Option<DVec3>,
    /// Distance to what is met next; infinite for a miss.
    distance: f64,
    /// Whether that is water.
    is_water: bool,
    /// The number of the patch there.
    patch: usize,
}

/// A ray to a light, and what it would bring to a patch: reflected by it, and by what is below it.
#[derive(Clone, Copy)]
struct Errand {
    patch: usize,
    brings: DVec3,
    below: DVec3,
    is_sky: bool,
}

/// Memory for the paths of a tile.
#[derive(Default)]
pub(super) struct Paths {
    paths: Vec<Path>,
    rays: Vec<Ray>,
    /// Whose the rays are.
    owners: Vec<usize>,
    hits: Vec<Hit>,
    /// Of the solid first, then of water.
    patches: Vec<Patch>,
    /// How many of them are of the solid.
    dry: usize,
    /// The path of each patch.
    seen: Vec<Path>,
    /// What leaves each patch on the way back.
    shine: Vec<Light>,
    /// What comes back from the water below it.
    glow: Vec<DVec3>,
    /// Share of light that reaches each patch of the solid through the water above it.
    dim: Vec<DVec3>,
    errands: Vec<Errand>,
    /// Whether the sun shines at places in the air.
    sunny: Vec<f64>,
    /// How many of these places belong to each path.
    nodes: Vec<usize>,
    /// What comes of each sample.
    pub outcomes: Vec<Outcome>,
}

/// What the stages of a trace have in common.
pub(super) struct Trace<'a> {
    pub samples: &'a [Sample],
    pub stats: &'a mut Stats,
    pub cancel: &'a AtomicBool,
}

impl Trace<'_> {
    fn go_on(&self) -> Option<()> {
        (!self.cancel.load(Ordering::Relaxed)).then_some(())
    }
}

impl Paths {
    /// Follows samples until they end; `None` when the job was cancelled. What comes of them is in `outcomes`.
    pub fn follow(&mut self, seer: &mut Seer<'_>, to: &mut Trace<'_>) -> Option<()> {
        self.begin(seer, to.samples);
        let most = seer.scene.settings.bounces + if seer.sea.is_some() { REFLECTIONS } else { 0 };
        for step in 0..=most {
            self.cast(seer, step, to);
            self.meet(seer, to);
            to.go_on()?;
            self.ask_lights(seer, step, to);
            to.go_on()?;
            self.gather(seer, step, to);
            to.go_on()?;
            if step == most || self.patches.is_empty() {
                break;
            }
            self.go_on(seer, step, to);
        }
        Some(())
    }

    /// Starts a path for each sample.
    fn begin(&mut self, seer: &Seer<'_>, samples: &[Sample]) {
        let (scene, under) = (seer.scene, seer.under_water());
        self.outcomes.clear();
        self.outcomes.resize(samples.len(), Outcome::default());
        self.paths.clear();
        self.paths.extend(samples.iter().enumerate().map(|(i, sample)| {
            let (origin, direction) = sample.line(&scene.view);
            Path {
                sample: i,
                origin,
                direction,
                weight: DVec3::ONE,
                bounce: 0,
                under,
                distance: f64::INFINITY,
                is_water: false,
                patch: 0,
            }
        }));
    }

    /// Finds what all paths meet next: the solid, or water before it.
    fn cast(&mut self, seer: &mut Seer<'_>, step: u32, to: &mut Trace<'_>) {
        let stage = Stage::begin();
        self.cast_at(seer, step, to, |_| true);
        if let Some(sea) = &mut seer.sea {
            let solid: Vec<f64> = self.paths.iter().map(|path| path.distance).collect();
            self.cast_at(sea, step, to, |path| path.under.is_none());
            for (path, solid) in self.paths.iter_mut().zip(solid) {
                path.is_water = path.under.is_none() && path.distance < solid;
                path.distance = path.distance.min(solid);
            }
        }
        let Stats { seconds, octaves, .. } = to.stats;
        match step {
            0 => stage.end(&mut seconds.primary, &mut octaves.primary),
            _ => stage.end(&mut seconds.bounced, &mut octaves.bounced),
        }
    }

    /// Distances of paths to one solid; those not chosen keep theirs.
    fn cast_at(
        &mut self,
        seer: &mut Seer<'_>,
        step: u32,
        to: &mut Trace<'_>,
        chosen: impl Fn(&Path) -> bool,
    ) {
        let scene = seer.scene;
        self.rays.clear();
        self.owners.clear();
        for (i, path) in self.paths.iter_mut().enumerate().filter(|(_, path)| chosen(path)) {
            path.distance = f64::INFINITY;
            let ray = match step {
                0 => piece((path.origin, path.direction), &scene.settings.bounds, scene.tolerance),
                _ => scene.onward_ray(path.origin, path.direction, f64::INFINITY),
            };
            if let Some(ray) = ray {
                self.owners.push(i);
                self.rays.push(ray);
            }
        }
        self.hits.clear();
        self.hits.resize(self.rays.len(), Hit::MISS);
        let cast = if step == 0 { &mut to.stats.primary } else { &mut to.stats.bounced };
        seer.caster.first_hits(&self.rays, &mut self.hits, cast, to.cancel);
        for ((owner, hit), cost) in self.owners.iter().zip(&self.hits).zip(seer.caster.costs()) {
            let path = &mut self.paths[*owner];
            path.distance = hit.t;
            self.outcomes[path.sample].evaluations += cost;
        }
    }

    /// Finds normals and colours where paths met something.
    fn meet(&mut self, seer: &mut Seer<'_>, to: &mut Trace<'_>) {
        let stage = Stage::begin();
        self.seen.clear();
        self.patches.clear();
        self.meet_one(&mut seer.surface, false, to);
        self.dry = self.patches.len();
        if let Some(sea) = &mut seer.sea {
            self.meet_one(&mut sea.surface, true, to);
        }
        stage.end(&mut to.stats.seconds.surface, &mut to.stats.octaves.surface);
    }

    /// The same for those that met water, or those that did not.
    fn meet_one(&mut self, surface: &mut Surface, is_water: bool, to: &mut Trace<'_>) {
        let mut places = Vec::new();
        let met = |path: &&mut Path| path.distance.is_finite() && path.is_water == is_water;
        for path in self.paths.iter_mut().filter(met) {
            path.patch = self.seen.len();
            self.seen.push(*path);
            places.push((path.origin + path.distance * path.direction, path.direction));
        }
        let mut patches = Vec::new();
        surface.patches(&places, &mut patches, to.cancel);
        for (patch, path) in patches.iter_mut().zip(&self.seen[self.patches.len()..]) {
            if path.bounce > 0 {
                patch.blur();
            }
        }
        to.stats.undefined += patches.iter().filter(|p| p.undefined).count() as u64;
        self.patches.append(&mut patches);
    }

    /// Finds the light that comes to all patches straight, and leaves them towards the eye.
    fn ask_lights(&mut self, seer: &mut Seer<'_>, step: u32, to: &mut Trace<'_>) {
        let stage = Stage::begin();
        let (scene, air) = (seer.scene, seer.scene.air.as_ref());
        let water = seer.water();
        self.shine.clear();
        self.shine.extend(self.patches.iter().map(|p| Light { direct: p.emission, ..Light::default() }));
        self.glow.clear();
        self.glow.resize(self.patches.len(), DVec3::ZERO);
        self.rays.clear();
        self.errands.clear();
        for (number, light) in (0u32..).zip(&scene.lights) {
            for i in 0..self.patches.len() {
                let (patch, path) = (&self.patches[i], self.seen[i]);
                let u = to.samples[path.sample].pair(Purpose::Light { step, number });
                let arriving = light::arriving(light, patch.position, u, air);
                let facing = patch.shading.dot(arriving.from);
                if facing <= 0.0 || patch.normal.dot(arriving.from) <= 0.0 {
                    continue;
                }
                let irradiance = arriving.irradiance * facing;
                let (value, below) = match &water {
                    Some(water) if i >= self.dry => {
                        (water.value(patch, -path.direction, arriving.from), water.glow(irradiance))
                    }
                    _ => {
                        let reflector = Reflector::new(patch, scene.reflecting.as_ref());
                        (reflector.value(-path.direction, arriving.from), DVec3::ZERO)
                    }
                };
                let errand = Errand { patch: i, brings: value * irradiance, below, is_sky: false };
                self.send(scene, errand, arriving.from, arriving.distance, light::has_shadows(light));
            }
        }
        self.ask_sky(scene, air, water.as_ref(), step, to);
        self.return_errands(seer, to);
        self.drown(seer);
        stage.end(&mut to.stats.seconds.shadow, &mut to.stats.octaves.shadow);
    }

    /// The light of the sky, where it is not found by paths that escape.
    fn ask_sky(
        &mut self,
        scene: &Prepared,
        air: Option<&Atmosphere>,
        water: Option<&Water>,
        step: u32,
        to: &Trace<'_>,
    ) {
        let around = Surroundings { sky: &scene.sky, air, suns: &scene.suns };
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
                self.shine[i].indirect += reflector.ambient(-path.direction, &around);
                continue;
            }
            let sample = &to.samples[path.sample];
            let purpose = Purpose::Onward { step };
            let drawn = reflector.sample(sample.number(purpose), sample.pair(purpose), -path.direction);
            let Some((direction, share)) = drawn.filter(|(direction, _)| patch.normal.dot(*direction) > 0.0)
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
        let (Some(water), Some(sea)) = (seer.water(), &mut seer.sea) else { return };
        let which: Vec<usize> = (0..self.dry).filter(|&i| self.seen[i].under.is_some()).collect();
        let places: Vec<DVec3> = which.iter().map(|&i| self.patches[i].position).collect();
        for (i, depth) in which.into_iter().zip(sea.surface.depths(&places)) {
            self.dim[i] = water.through(depth);
            self.shine[i] = self.shine[i].times(self.dim[i]);
        }
    }

    /// Finds out where in the air the sun shines, for shafts of light between shadows of the ground.
    fn look_for_sun(&mut self, seer: &mut Seer<'_>, step: u32, to: &mut Trace<'_>) {
        self.nodes.clear();
        self.sunny.clear();
        let (Some(air), Some(scene::Light::Sun(sun))) = (&seer.scene.air, seer.scene.lights.first()) else {
            return;
        };
        if step > 0 || !seer.scene.has_shafts() {
            return;
        }
        let stage = Stage::begin();
        self.rays.clear();
        self.owners.clear();
        let mut places = Vec::new();
        for path in &self.paths {
            let sample = &to.samples[path.sample];
            let jitter = sample.number(Purpose::Air { step });
            places.clear();
            air.nodes(path.origin, path.direction, path.distance, jitter, &mut places);
            let towards = light::on_disc(sun, sample.pair(Purpose::Light { step, number: 0 }));
            for place in &places {
                if let Some(ray) = seer.scene.onward_ray(*place, towards, f64::INFINITY) {
                    self.owners.push(self.sunny.len());
                    self.rays.push(ray);
                }
                self.sunny.push(1.0);
            }
            self.nodes.push(places.len());
        }
        self.hits.clear();
        self.hits.resize(self.rays.len(), Hit::MISS);
        seer.caster.any_hits(&self.rays, &mut self.hits, &mut to.stats.shadow, to.cancel);
        for (owner, hit) in self.owners.iter().zip(&self.hits) {
            self.sunny[*owner] = if hit.is_hit() { 0.0 } else { 1.0 };
        }
        stage.end(&mut to.stats.seconds.shadow, &mut to.stats.octaves.shadow);
    }

    /// Adds what paths bring from here to their samples, through the air or the water.
    fn gather(&mut self, seer: &mut Seer<'_>, step: u32, to: &mut Trace<'_>) {
        self.look_for_sun(seer, step, to);
        let start = Instant::now();
        let (scene, water) = (seer.scene, seer.water());
        let around = Surroundings { sky: &scene.sky, air: seer.scene.air.as_ref(), suns: &scene.suns };
        let mut sunny = self.sunny.as_slice();
        for (i, path) in self.paths.iter_mut().enumerate() {
            let (lit, others) = sunny.split_at(self.nodes.get(i).copied().unwrap_or(0));
            sunny = others;
            let patch = path.distance.is_finite().then(|| &self.patches[path.patch]);
            let mut brought = patch.map_or(Light::default(), |_| self.shine[path.patch]);
            let through = match (path.under, &water) {
                (Some(glow), Some(water)) => {
                    let through = water.through(path.distance);
                    brought = brought.times(through);
                    brought.indirect += glow * (DVec3::ONE - through);
                    through
                }
                _ if step > 0 && patch.is_none() => {
                    brought.indirect = around.radiance(path.origin, path.direction);
                    DVec3::ONE
                }
                _ => {
                    let jitter = to.samples[path.sample].number(Purpose::Air { step });
                    let (through, scattered) = around.along(path.ray(), jitter, lit);
                    brought = brought.times(through);
                    brought.sky += scattered;
                    through
                }
            };
            let outcome = &mut self.outcomes[path.sample];
            if step == 0 {
                let footprint = scene.view.footprint(path.distance);
                outcome.see(
                    patch.map(|patch| Met { patch: *patch, distance: path.distance, footprint }),
                    through,
                );
            }
            outcome.add(brought.times(path.weight), step);
            path.weight *= through;
        }
        to.stats.seconds.shading += start.elapsed().as_secs_f64();
    }

    /// Goes on from what paths met: from the solid in a direction drawn as its material reflects, from water in two.
    fn go_on(&mut self, seer: &Seer<'_>, step: u32, to: &Trace<'_>) {
        let (scene, water) = (seer.scene, seer.water());
        let mut onward = Vec::new();
        for path in self.paths.drain(..).filter(|path| path.distance.is_finite()) {
            let patch = &self.patches[path.patch];
            match &water {
                Some(water) if path.is_water => {
                    for way in water.ways(patch, -path.direction).into_iter().flatten() {
                        let weight = path.weight * way.share;
                        let under = way.is_down.then(|| self.glow[path.patch]);
                        let origin = scene.lifted(patch, if way.is_down { -1.0 } else { 1.0 });
                        onward.push(Path { origin, direction: way.direction, weight, under, ..path });
                    }
                }
                _ if path.bounce < scene.settings.bounces => {
                    let (sample, purpose) = (&to.samples[path.sample], Purpose::Onward { step });
                    let reflector = Reflector::new(patch, scene.reflecting.as_ref());
                    let drawn =
                        reflector.sample(sample.number(purpose), sample.pair(purpose), -path.direction);
                    let Some((direction, share)) = drawn else { continue };
                    let weight = path.weight * share * self.dim[path.patch];
                    if patch.normal.dot(direction) > 0.0 && weight.max_element() > 0.0 {
                        let (origin, bounce) = (scene.lifted(patch, 1.0), path.bounce + 1);
                        onward.push(Path { origin, direction, weight, bounce, under: None, ..path });
                    }
                }
                _ => {}
            }
        }
        self.paths = onward;
    }
}

impl Path {
    /// Its last piece: where it begins, in which direction, and how long it is.
    fn ray(&self) -> (DVec3, DVec3, f64) {
        (self.origin, self.direction, self.distance)
    }
}

impl Errand {
    /// Adds what it brings to what leaves its patch.
    fn deliver(&self, shine: &mut [Light], glow: &mut [DVec3]) {
        let shine = &mut shine[self.patch];
        if self.is_sky {
            shine.indirect += self.brings
        } else {
            shine.direct += self.brings
        }
        glow[self.patch] += self.below;
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
    /// Tolerance of rays that begin at a point of the solid.
    fn tolerance_from(&self, p: DVec3) -> f64 {
        self.tolerance.at(p.distance(self.view.eye))
    }

    /// A point a few tolerances above a patch, or below, on a `side` of 1 or -1, where rays begin that are not to meet it.
    fn lifted(&self, patch: &Patch, side: f64) -> DVec3 {
        let rounding = 64.0 * f64::EPSILON * patch.position.abs().max_element();
        patch.position + side * (4.0 * self.tolerance_from(patch.position) + rounding) * patch.normal
    }

    /// A ray from a point onwards, so far or as far as the bounds go.
    fn onward_ray(&self, origin: DVec3, direction: DVec3, distance: f64) -> Option<Ray> {
        // What begins on a face of the bounds may begin outside, where nothing is promised.
        let (enter, leave) = self.settings.bounds.clip(origin, direction)?;
        let (near, far) = (enter.max(0.0), leave.min(distance));
        let tolerance = Tolerance::fixed(self.tolerance_from(origin));
        (near < far).then_some(Ray { origin, direction, near, far, tolerance })
    }

    /// Whether the ground throws shadows into the air.
    fn has_shafts(&self) -> bool {
        self.sky.air.is_some_and(|air| air.shafts)
    }
}
