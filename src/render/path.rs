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

use super::air::Atmosphere;
use super::gather::{Light, Sum};
use super::light::{self, Surroundings};
use super::reflect::Reflector;
use super::sample::{Purpose, Sample};
use super::surface::Patch;
use super::worker::Seer;
use super::{Job, Prepared, Stats};
use crate::cast::{Hit, Ray, Tolerance};
use crate::noise;
use crate::scene;
use glam::DVec3;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// A path on its way.
#[derive(Clone, Copy)]
struct Path {
    sample: usize,
    origin: DVec3,
    direction: DVec3,
    /// Share of light that gets from here to the eye, by channel.
    weight: DVec3,
    /// Distance to the solid, and the number of the patch there; infinite for a miss.
    distance: f64,
    patch: usize,
}

/// A ray to a light, and what it would bring.
#[derive(Clone, Copy)]
struct Errand {
    patch: usize,
    brings: DVec3,
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
    patches: Vec<Patch>,
    /// The sample of each patch, and the direction towards where it is seen from.
    seen: Vec<(usize, DVec3)>,
    /// What leaves each patch on the way back.
    shine: Vec<Light>,
    errands: Vec<Errand>,
    /// Light that each sample has brought.
    brought: Vec<DVec3>,
    /// Whether the sun shines at places in the air.
    sunny: Vec<f64>,
    /// How many of these places belong to each path.
    nodes: Vec<usize>,
    /// Share of the background that each sample covers.
    alphas: Vec<f64>,
}

impl Paths {
    /// Follows samples until they end, and adds what they bring to their pixels; `None` when the job was cancelled.
    pub fn trace(
        &mut self,
        seer: &mut Seer<'_>,
        samples: &[Sample],
        sums: &mut [Sum],
        stats: &mut Stats,
        job: &Job<'_>,
    ) -> Option<()> {
        let on = |job: &Job<'_>| (!job.is_cancelled()).then_some(());
        let mut to = Tally { samples, sums, stats, cancel: job.cancel };
        self.begin(seer.scene, samples);
        for bounce in 0..=seer.scene.settings.bounces {
            self.cast(seer, bounce, &mut to);
            self.meet(seer, &mut to);
            on(job)?;
            self.ask_lights(seer, bounce, &mut to);
            on(job)?;
            self.gather(seer, bounce, &mut to);
            on(job)?;
            if bounce == seer.scene.settings.bounces || self.patches.is_empty() {
                break;
            }
            self.go_on(seer.scene, bounce, samples);
        }
        for (i, sample) in samples.iter().enumerate() {
            to.sums[sample.in_tile].end(self.alphas[i], self.brought[i]);
        }
        Some(())
    }

    /// Starts a path for each sample.
    fn begin(&mut self, scene: &Prepared, samples: &[Sample]) {
        let Prepared { view, .. } = scene;
        self.brought.clear();
        self.brought.resize(samples.len(), DVec3::ZERO);
        self.alphas.clear();
        self.alphas.resize(samples.len(), 0.0);
        self.paths.clear();
        self.paths.extend(samples.iter().enumerate().map(|(i, sample)| Path {
            sample: i,
            origin: view.eye,
            direction: view.direction(sample.place[0], sample.place[1]),
            weight: DVec3::ONE,
            distance: f64::INFINITY,
            patch: 0,
        }));
    }

    /// Casts the rays of all paths.
    fn cast(&mut self, seer: &mut Seer<'_>, bounce: u32, to: &mut Tally<'_>) {
        let stage = Stage::begin();
        let scene = seer.scene;
        self.rays.clear();
        self.owners.clear();
        for (i, path) in self.paths.iter().enumerate() {
            let ray = match bounce {
                0 => scene.view.ray(path.direction, &scene.settings.bounds, scene.tolerance),
                _ => scene.onward_ray(path.origin, path.direction, f64::INFINITY),
            };
            if let Some(ray) = ray {
                self.owners.push(i);
                self.rays.push(ray);
            }
        }
        self.hits.clear();
        self.hits.resize(self.rays.len(), Hit::MISS);
        let cast = if bounce == 0 { &mut to.stats.primary } else { &mut to.stats.bounced };
        seer.caster.first_hits(&self.rays, &mut self.hits, cast, to.cancel);
        for ((owner, hit), cost) in self.owners.iter().zip(&self.hits).zip(seer.caster.costs()) {
            let path = &mut self.paths[*owner];
            path.distance = hit.t;
            to.sum(path.sample).evaluations += cost;
        }
        let Stats { seconds, octaves, .. } = to.stats;
        match bounce {
            0 => stage.end(&mut seconds.primary, &mut octaves.primary),
            _ => stage.end(&mut seconds.bounced, &mut octaves.bounced),
        }
    }

    /// Finds normals and colours where rays met the solid.
    fn meet(&mut self, seer: &mut Seer<'_>, to: &mut Tally<'_>) {
        let stage = Stage::begin();
        let mut seen = Vec::new();
        self.seen.clear();
        for path in self.paths.iter_mut().filter(|p| p.distance.is_finite()) {
            path.patch = seen.len();
            self.seen.push((path.sample, -path.direction));
            seen.push((path.origin + path.distance * path.direction, path.direction));
        }
        seer.surface.patches(&seen, &mut self.patches, to.cancel);
        to.stats.undefined += self.patches.iter().filter(|p| p.undefined).count() as u64;
        stage.end(&mut to.stats.seconds.surface, &mut to.stats.octaves.surface);
    }

    /// Finds the light that comes to all patches straight, and leaves them towards the eye.
    fn ask_lights(&mut self, seer: &mut Seer<'_>, bounce: u32, to: &mut Tally<'_>) {
        let stage = Stage::begin();
        let scene = seer.scene;
        let air = seer.air.as_ref();
        self.shine.clear();
        self.shine.extend(self.patches.iter().map(|p| Light { direct: p.emission, ..Light::default() }));
        self.rays.clear();
        self.errands.clear();
        for (number, light) in (0u32..).zip(&scene.lights) {
            for i in 0..self.patches.len() {
                let (patch, (sample, to_eye)) = (&self.patches[i], self.seen[i]);
                let u = to.samples[sample].pair(Purpose::Light { bounce, number });
                let arriving = light::arriving(light, patch.position, u, air);
                let facing = patch.shading.dot(arriving.from);
                if facing <= 0.0 || patch.normal.dot(arriving.from) <= 0.0 {
                    continue;
                }
                let value = Reflector::new(patch, scene.material.as_ref()).value(to_eye, arriving.from);
                let errand = Errand { patch: i, brings: value * arriving.irradiance * facing, is_sky: false };
                self.send(scene, errand, arriving.from, arriving.distance, light::has_shadows(light));
            }
        }
        if scene.settings.bounces == 0 {
            self.ask_sky(scene, air, to);
        }
        self.return_errands(seer, to);
        stage.end(&mut to.stats.seconds.shadow, &mut to.stats.octaves.shadow);
    }

    /// The light of the sky, where it is not found by paths that escape.
    fn ask_sky(&mut self, scene: &Prepared, air: Option<&Atmosphere>, to: &Tally<'_>) {
        let around = Surroundings { sky: &scene.sky, air, suns: &scene.suns };
        let reach = scene.settings.occlusion;
        for i in 0..self.patches.len() {
            let (patch, (sample, to_eye)) = (self.patches[i], self.seen[i]);
            let reflector = Reflector::new(&patch, scene.material.as_ref());
            if reach == 0.0 {
                self.shine[i].indirect += reflector.ambient(to_eye, &around, &patch);
                continue;
            }
            let purpose = Purpose::Onward { bounce: 0 };
            let (choice, u) = (to.samples[sample].number(purpose), to.samples[sample].pair(purpose));
            let Some((direction, share)) = reflector.sample(choice, u, to_eye) else { continue };
            let brings = share * around.radiance(patch.position, direction);
            self.send(scene, Errand { patch: i, brings, is_sky: true }, direction, reach, true);
        }
    }

    /// Sends out a ray, or takes what it would bring at once where nothing can be in its way.
    fn send(&mut self, scene: &Prepared, errand: Errand, direction: DVec3, distance: f64, shadows: bool) {
        let origin = scene.lifted(&self.patches[errand.patch]);
        match scene.onward_ray(origin, direction, distance).filter(|_| shadows) {
            Some(ray) => {
                self.errands.push(errand);
                self.rays.push(ray);
            }
            None => errand.deliver(&mut self.shine),
        }
    }

    /// Casts the rays that were sent out, and takes what those bring that met nothing.
    fn return_errands(&mut self, seer: &mut Seer<'_>, to: &mut Tally<'_>) {
        self.hits.clear();
        self.hits.resize(self.rays.len(), Hit::MISS);
        seer.caster.any_hits(&self.rays, &mut self.hits, &mut to.stats.shadow, to.cancel);
        for ((errand, hit), cost) in self.errands.iter().zip(&self.hits).zip(seer.caster.costs()) {
            if !hit.is_hit() {
                errand.deliver(&mut self.shine);
            }
            to.sum(self.seen[errand.patch].0).evaluations += cost;
        }
    }

    /// Finds out where in the air the sun shines, for shafts of light between shadows of the ground.
    fn look_for_sun(&mut self, seer: &mut Seer<'_>, bounce: u32, to: &mut Tally<'_>) {
        self.nodes.clear();
        self.sunny.clear();
        let (Some(air), Some(scene::Light::Sun(sun))) = (&seer.air, seer.scene.lights.first()) else {
            return;
        };
        if bounce > 0 || !seer.scene.has_shafts() {
            return;
        }
        let stage = Stage::begin();
        self.rays.clear();
        self.owners.clear();
        let mut places = Vec::new();
        for path in &self.paths {
            let sample = &to.samples[path.sample];
            let jitter = sample.number(Purpose::Air { bounce });
            places.clear();
            air.nodes(path.origin, path.direction, path.distance, jitter, &mut places);
            let towards = light::on_disc(sun, sample.pair(Purpose::Light { bounce, number: 0 }));
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

    /// Adds what the paths bring from here to their pixels, through the air.
    fn gather(&mut self, seer: &mut Seer<'_>, bounce: u32, to: &mut Tally<'_>) {
        self.look_for_sun(seer, bounce, to);
        let start = Instant::now();
        let scene = seer.scene;
        let around = Surroundings { sky: &scene.sky, air: seer.air.as_ref(), suns: &scene.suns };
        let mut sunny = self.sunny.as_slice();
        for (i, path) in self.paths.iter_mut().enumerate() {
            let sample = &to.samples[path.sample];
            let patch =
                path.distance.is_finite().then(|| (&self.patches[path.patch], self.shine[path.patch]));
            let own = sunny.split_off(..self.nodes.get(i).copied().unwrap_or(0)).unwrap_or_default();
            if bounce > 0 && patch.is_none() {
                let radiance = path.weight * around.radiance(path.origin, path.direction);
                to.bring(path.sample, &mut self.brought, Light { indirect: radiance, ..Light::default() });
                continue;
            }
            let jitter = sample.number(Purpose::Air { bounce });
            let (through, scattered) = path.air(around.air, &scene.suns, jitter, own);
            let mut brought = patch.map_or(Light::default(), |(_, shine)| shine).times(through);
            brought.sky += scattered;
            if bounce > 0 {
                brought = Light { indirect: path.weight * brought.total(), ..Light::default() };
            } else if let Some((patch, _)) = patch {
                self.alphas[path.sample] = 1.0;
                to.sum(path.sample).see(patch, path.distance, scene.view.pixel() * path.distance);
            } else {
                self.alphas[path.sample] = 1.0 - through.element_sum() / 3.0;
            }
            path.weight *= through;
            to.bring(path.sample, &mut self.brought, brought);
        }
        to.stats.seconds.shading += start.elapsed().as_secs_f64();
    }

    /// Goes on from where paths met the solid, in directions drawn as its material reflects.
    fn go_on(&mut self, scene: &Prepared, bounce: u32, samples: &[Sample]) {
        let (patches, seen) = (&self.patches, &self.seen);
        let onward = |path: Path| {
            let patch = path.distance.is_finite().then(|| &patches[path.patch])?;
            let (sample, to_eye) = seen[path.patch];
            let purpose = Purpose::Onward { bounce };
            let (choice, u) = (samples[sample].number(purpose), samples[sample].pair(purpose));
            let reflector = Reflector::new(patch, scene.material.as_ref());
            let (direction, share) = reflector.sample(choice, u, to_eye)?;
            let weight = path.weight * share;
            let goes = patch.normal.dot(direction) > 0.0 && weight.max_element() > 0.0;
            let origin = scene.lifted(patch);
            goes.then_some(Path { origin, direction, weight, distance: f64::INFINITY, ..path })
        };
        let paths: Vec<Path> = self.paths.drain(..).filter_map(onward).collect();
        self.paths = paths;
    }
}

impl Path {
    /// What the air does to light that comes along the last piece of the path: the share that gets through, and what it adds.
    fn air(
        &self,
        air: Option<&Atmosphere>,
        suns: &[(DVec3, DVec3)],
        jitter: f64,
        sunny: &[f64],
    ) -> (DVec3, DVec3) {
        let Some(air) = air else { return (DVec3::ONE, DVec3::ZERO) };
        let seen = air.along(self.origin, self.direction, self.distance, suns, jitter, sunny);
        (seen.transmittance, seen.scattered)
    }
}

impl Errand {
    /// Adds what it brings to what leaves its patch.
    fn deliver(&self, shine: &mut [Light]) {
        let shine = &mut shine[self.patch];
        if self.is_sky { shine.indirect += self.brings } else { shine.direct += self.brings }
    }
}

/// Where results of stages go.
struct Tally<'a> {
    samples: &'a [Sample],
    sums: &'a mut [Sum],
    stats: &'a mut Stats,
    cancel: &'a AtomicBool,
}

impl Tally<'_> {
    /// What the pixel of a sample has gathered.
    fn sum(&mut self, sample: usize) -> &mut Sum {
        &mut self.sums[self.samples[sample].in_tile]
    }

    /// Adds light to a sample.
    fn bring(&mut self, sample: usize, brought: &mut [DVec3], light: Light) {
        brought[sample] += light.total();
        self.sum(sample).add(light);
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

    /// A point a few tolerances above a patch, where rays begin that are not to meet it.
    fn lifted(&self, patch: &Patch) -> DVec3 {
        let rounding = 64.0 * f64::EPSILON * patch.position.abs().max_element();
        patch.position + (4.0 * self.tolerance_from(patch.position) + rounding) * patch.normal
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
