//! Paths of light, followed backwards from the eye, thousands of a tile together:
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

use super::Stats;
use super::gather::{Light, Met, Outcome};
use super::irradiance::Irradiance;
use super::light::Surroundings;
use super::next_event::Errand;
use super::rays::piece;
use super::reflect::{Drawn, Reflector};
use super::sample::{Purpose, Sample};
use super::stats::Stage;
use super::surface::{Patch, Surface};
use super::worker::Seer;
use crate::cast::{Hit, Ray};
use crate::num::morton2;
use crate::scene::Finish;
use glam::DVec3;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// How often a path may be reflected by water, beside its bounces.
const REFLECTIONS: u32 = 2;

/// A path on its way.
#[derive(Clone, Copy)]
pub(super) struct Path {
    pub(super) sample: usize,
    pub(super) origin: DVec3,
    pub(super) direction: DVec3,
    /// Share of light that gets from here to the eye, by channel.
    pub(super) weight: DVec3,
    /// How often it has been reflected by the solid.
    pub(super) bounce: u32,
    /// The roughness of the roughest of these reflections, 1 for what is matt.
    pub(super) blur: f64,
    /// Light that comes back from all around, where it is under water.
    pub(super) under: Option<DVec3>,
    /// Whether it left something that is under water. What water takes away is counted there, so it goes on as in the dry.
    pub(super) from_below: bool,
    /// Distance to what is met next; infinite for a miss.
    pub(super) distance: f64,
    /// Whether that is water.
    pub(super) is_water: bool,
    /// The number of the patch there.
    pub(super) patch: usize,
}

/// Memory for paths that are followed together.
#[derive(Default)]
pub(super) struct Paths {
    pub(super) paths: Vec<Path>,
    pub(super) rays: Vec<Ray>,
    /// Whose the rays are.
    pub(super) owners: Vec<usize>,
    pub(super) hits: Vec<Hit>,
    /// Of the solid first, then of water.
    pub(super) patches: Vec<Patch>,
    /// How many of them are of the solid.
    pub(super) dry: usize,
    /// The path of each patch.
    pub(super) seen: Vec<Path>,
    /// What leaves each patch on the way back.
    pub(super) shine: Vec<Light>,
    /// What comes back from the water below it.
    pub(super) glow: Vec<DVec3>,
    /// Share of light that reaches each patch of the solid through the water above it.
    pub(super) dim: Vec<DVec3>,
    /// Whether the light from all around a patch is known, so that no path need go on for it.
    shared: Vec<bool>,
    pub(super) errands: Vec<Errand>,
    /// Whether suns shine at places in the air: of each path, at all places one sun after the other.
    pub(super) sunny: Vec<f64>,
    /// How many of these belong to each path.
    pub(super) nodes: Vec<usize>,
    /// What comes of each sample.
    pub outcomes: Vec<Outcome>,
}

/// What the stages of a trace have in common.
pub(super) struct Trace<'a> {
    pub samples: &'a [Sample],
    pub stats: &'a mut Stats,
    pub cancel: &'a AtomicBool,
    /// Where light is shared between places that the eye sees.
    pub irradiance: Option<&'a mut Irradiance>,
}

impl Trace<'_> {
    /// The same for other samples, of which each path goes on by itself.
    pub fn of<'b>(&'b mut self, samples: &'b [Sample]) -> Trace<'b> {
        Trace { samples, stats: self.stats, cancel: self.cancel, irradiance: None }
    }

    fn go_on(&self) -> Option<()> {
        (!self.cancel.load(Ordering::Relaxed)).then_some(())
    }
}

impl Paths {
    /// Follows samples until they end; `None` when the job was cancelled. What comes of them is in `outcomes`.
    pub fn follow(&mut self, seer: &mut Seer<'_>, to: &mut Trace<'_>) -> Option<()> {
        self.begin(seer, to.samples.iter().map(|sample| sample.line(&seer.scene.view)));
        self.run(seer, 0, to)
    }

    /// Follows paths that have been reflected once already, one for each sample; what `outcomes` get is the light that comes
    /// along them.
    pub fn follow_on(&mut self, seer: &mut Seer<'_>, onward: Vec<Path>, to: &mut Trace<'_>) -> Option<()> {
        self.outcomes.clear();
        self.outcomes.resize(to.samples.len(), Outcome::default());
        self.paths = side_by_side(onward);
        self.run(seer, 1, to)
    }

    /// Finds what is met first from the middle of the lens, and nothing else.
    pub fn meet_middles(&mut self, seer: &mut Seer<'_>, to: &mut Trace<'_>) {
        let middle = |sample: &Sample| seer.scene.view.ray(sample.place[0], sample.place[1], [0.5; 2]);
        self.begin(seer, to.samples.iter().map(middle));
        self.cast(seer, 0, to);
        self.meet(seer, to);
    }

    /// Takes all paths from step to step, until they end.
    fn run(&mut self, seer: &mut Seer<'_>, first: u32, to: &mut Trace<'_>) -> Option<()> {
        let most = seer.scene.settings.bounces + if seer.sea.is_some() { REFLECTIONS } else { 0 };
        for step in first..=most {
            self.cast(seer, step, to);
            self.meet(seer, to);
            if step == 0 {
                to.stats.undefined += self.patches.iter().filter(|p| p.undefined).count() as u64;
                to.stats.flat += self.patches.iter().filter(|p| p.is_flat).count() as u64;
            }
            to.go_on()?;
            self.ask_lights(seer, step, to);
            to.go_on()?;
            self.share(seer, step, to)?;
            self.gather(seer, step, to);
            to.go_on()?;
            if step == most || self.patches.is_empty() {
                break;
            }
            self.go_on(seer, step, to);
        }
        Some(())
    }

    /// What of the solid was met, with the paths there.
    pub fn dry_patches(&self) -> impl Iterator<Item = (&Path, &Patch)> {
        self.seen.iter().zip(&self.patches[..self.dry])
    }

    /// Starts a path for each sample, along its line of sight.
    fn begin(&mut self, seer: &Seer<'_>, lines: impl Iterator<Item = (DVec3, DVec3)>) {
        let under = seer.under_water();
        self.paths.clear();
        let path = |(i, (origin, direction)): (usize, _)| Path { under, ..Path::new(i, origin, direction) };
        self.paths.extend(lines.enumerate().map(path));
        self.outcomes.clear();
        self.outcomes.resize(self.paths.len(), Outcome::default());
    }

    /// Finds what all paths meet next: the solid, or water before it.
    fn cast(&mut self, seer: &mut Seer<'_>, step: u32, to: &mut Trace<'_>) {
        let stage = Stage::begin();
        self.cast_at(seer, step, to, |_| true);
        if let Some(sea) = &mut seer.sea {
            let solid: Vec<f64> = self.paths.iter().map(|path| path.distance).collect();
            self.cast_at(sea, step, to, |path| !path.is_below());
            for (path, solid) in self.paths.iter_mut().zip(solid) {
                path.is_water = !path.is_below() && path.distance < solid;
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
            patch.blur(path.blur);
        }
        self.patches.append(&mut patches);
    }

    /// Adds the light from all around, as far as it is known, to what leaves what the eye sees.
    fn share(&mut self, seer: &mut Seer<'_>, step: u32, to: &mut Trace<'_>) -> Option<()> {
        self.shared.clear();
        self.shared.resize(self.patches.len(), false);
        // Water takes from the light that is gathered below it, as much as there is above each place.
        if step > 0 || seer.under_water().is_some() {
            return Some(());
        }
        let Some(irradiance) = to.irradiance.take() else { return Some(()) };
        let leaving = irradiance.leaving(seer, &self.patches[..self.dry], to)?;
        to.irradiance = Some(irradiance);
        for (i, light) in leaving.into_iter().enumerate() {
            self.shared[i] = light.is_some();
            self.shine[i].indirect += light.unwrap_or_default();
        }
        Some(())
    }

    /// Adds what paths bring from here to their samples, through the air or the water.
    fn gather(&mut self, seer: &mut Seer<'_>, step: u32, to: &mut Trace<'_>) {
        self.look_for_suns(seer, step, to);
        let start = Instant::now();
        let (scene, water) = (seer.scene, seer.water);
        let around = Surroundings { sky: &scene.sky, air: seer.scene.air.as_ref(), suns: &scene.suns };
        let mut sunny = self.sunny.as_slice();
        for (i, path) in self.paths.iter_mut().enumerate() {
            // Air takes its time.
            if i % 64 == 0 && to.go_on().is_none() {
                return;
            }
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
        let (scene, water) = (seer.scene, seer.water);
        let mut onward = Vec::new();
        for path in self.paths.drain(..).filter(|path| path.distance.is_finite()) {
            let patch = &self.patches[path.patch];
            match &water {
                Some(water) if path.is_water => {
                    let u = to.samples[path.sample].pair(Purpose::Onward { step });
                    let blur = path.blur.max(patch.finish[Finish::Roughness as usize]);
                    for way in water.ways(patch, -path.direction, Some(u)).into_iter().flatten() {
                        let weight = path.weight * way.share;
                        let under = way.is_down.then(|| self.glow[path.patch]);
                        let origin = scene.lifted(patch, if way.is_down { -1.0 } else { 1.0 });
                        onward.push(Path { origin, direction: way.direction, weight, under, blur, ..path });
                    }
                }
                _ if path.bounce < scene.settings.bounces && !self.shared[path.patch] => {
                    let (sample, purpose) = (&to.samples[path.sample], Purpose::Onward { step });
                    let reflector = Reflector::new(patch, scene.reflecting.as_ref());
                    let drawn =
                        reflector.sample(sample.number(purpose), sample.pair(purpose), -path.direction);
                    let Some(Drawn { direction, share, blur }) = drawn else { continue };
                    let weight = path.weight * share * self.dim[path.patch];
                    if patch.normal.dot(direction) > 0.0 && weight.max_element() > 0.0 {
                        let (origin, bounce) = (scene.lifted(patch, 1.0), path.bounce + 1);
                        let (from_below, blur) = (path.is_below(), path.blur.max(blur));
                        onward.push(Path {
                            origin,
                            direction,
                            weight,
                            bounce,
                            blur,
                            under: None,
                            from_below,
                            ..path
                        });
                    }
                }
                _ => {}
            }
        }
        self.paths = side_by_side(onward);
    }
}

/// Those that go alongside one another are cast together.
fn side_by_side(mut paths: Vec<Path>) -> Vec<Path> {
    paths.sort_by_cached_key(|path| around_directions(path.direction));
    paths
}

/// Where a direction lies on a curve through all of them: Morton's, over the square that the octahedron folds out to.
fn around_directions(d: DVec3) -> u64 {
    let p = d / d.abs().element_sum();
    let [x, y] = match p.z < 0.0 {
        true => [(1.0 - p.y.abs()).copysign(p.x), (1.0 - p.x.abs()).copysign(p.y)],
        false => [p.x, p.y],
    };
    morton2([x, y].map(|t| ((t + 1.0) * 0.5 * f64::from(DIRECTIONS)) as u32))
}

/// Steps of that curve along each side of the square.
const DIRECTIONS: u32 = 256;

impl Path {
    /// Of a sample, from something matt, where it was reflected for the first time.
    pub(super) fn onward(sample: usize, origin: DVec3, direction: DVec3) -> Path {
        Path { bounce: 1, blur: 1.0, ..Path::new(sample, origin, direction) }
    }

    /// Of a sample, from the eye.
    fn new(sample: usize, origin: DVec3, direction: DVec3) -> Path {
        Path {
            sample,
            origin,
            direction,
            weight: DVec3::ONE,
            bounce: 0,
            blur: 0.0,
            under: None,
            from_below: false,
            distance: f64::INFINITY,
            is_water: false,
            patch: 0,
        }
    }

    /// Whether it is, or was, under water.
    pub(super) fn is_below(&self) -> bool {
        self.under.is_some() || self.from_below
    }

    /// Its last piece: where it begins, in which direction, and how long it is.
    fn ray(&self) -> (DVec3, DVec3, f64) {
        (self.origin, self.direction, self.distance)
    }
}
