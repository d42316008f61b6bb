//! Light that bounces, gathered at some places of a picture and shared by those around them: an irradiance cache, after Ward,
//! Rubinstein and Clear (1988).
//!
//! The places are what the eye sees in the middle of every n-th pixel of every n-th row. From each, paths go on to all
//! sides and bring the radiances `L_k` from directions `w_k`, evenly over the half of them above the surface, whose normal
//! is `m`. What is kept is, by channel, the *light vector* (Gershun 1936), of which chance decides only what differs from
//! the mean `L`, and the mean radiance `H` from within 15 degrees of the horizon:
//!
//! ```text
//! V  =  pi L m  +  2 pi / N  sum (L_k - L) w_k
//! ```
//!
//! A matt surface there, with a normal `s`, its bumps included, gets
//!
//! ```text
//! E  =  s . V  +  pi H (1 - s . m)
//! ```
//!
//! For `s = m` that is the irradiance. As normals turn from there, the first term has the right slope: the halves above two
//! surfaces differ in light along the horizon alone, which counts for nothing yet. The second is what these differ by, if
//! light along the horizon is all alike; instead of light from below the surface that it stands on, a bump gets what that
//! [throws](super::reflect) to it. So light that is the same from all sides has the right value whatever the
//! normals.
//!
//! Between the places light is blended as by a cubic B-spline, among those that lie in about the same plane and face about
//! the same way, on one side of the seam of a picture all around. Where too few of these are near, where a surface does not
//! follow Lambert's law, and under water, paths go on by themselves. What is lost is how light varies within a few distances between places other than by the normal, and what
//! 64 directions leave to chance does not average out: it makes faint blotches of that size.
//!
//! Places are looked at in blocks that are the same whoever comes there first, and whatever else is in the picture.

use super::material::{Frame, uniform_hemisphere};
use super::path::{Path, Paths, Trace};
use super::refine::locked;
use super::reflect::Reflector;
use super::sample::{Purpose, Sample};
use super::surface::Patch;
use super::worker::Seer;
use super::{Prepared, Settings};
use crate::num::cubic;
use ahash::HashMap;
use glam::DVec3;
use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};
use std::sync::{Arc, Mutex};

/// Paths from each place: so many go evenly over the hemisphere. Several moments have them together, but each at least the
/// second number.
const PATHS: u32 = 64;
const PATHS_AT_ONCE: u32 = 4;

/// Sine of the angle below which light comes along the horizon.
const LOW: f64 = 0.25;

/// Places along a block.
const SIDE: u32 = 4;

/// Blocks that all moments remember together, at most: some 45 MB.
const REMEMBERED: usize = 1 << 14;

/// Weight that places have to have together, of 1.
const ENOUGH: f64 = 0.1;

/// How far a place may lie beside the plane of another, and from it in that plane, in distances between places; and
/// the least cosine between their normals.
const BESIDE: f64 = 2.0;
const ALONG: f64 = 4.0;
const ALIKE: f64 = 0.4;

/// Which place, or which block of them: its column and row.
type Node = [u32; 2];

/// What is known of the places of a block, row by row.
type Block = [Option<Record>; (SIDE * SIDE) as usize];

/// Where a block is found as soon as somebody has filled it.
type Room = Mutex<Option<Arc<Block>>>;

/// What is kept of a place.
#[derive(Clone, Copy, Debug)]
struct Record {
    position: DVec3,
    /// Distance to the next place: facing the eye, and along the surface.
    apart: [f64; 2],
    light: Arriving,
}

/// Light that comes to a place from above its surface.
#[derive(Clone, Copy, Debug)]
struct Arriving {
    /// Normal of the surface.
    normal: DVec3,
    /// The light vector of each channel.
    vector: [DVec3; 3],
    /// Mean radiance along the horizon.
    horizon: DVec3,
}

/// What the eye sees at a place of a block.
struct Seen {
    place: u32,
    path: Path,
    patch: Patch,
}

/// What was gathered at one moment, for all threads.
#[derive(Debug)]
pub(super) struct Gathered {
    /// Pixels from place to place.
    spacing: u32,
    /// Paths from each place, and the number of the first, so that each moment has its own.
    paths: u32,
    first: u32,
    /// Places across the picture, and down.
    sides: [u32; 2],
    /// Blocks that are remembered, at most.
    capacity: usize,
    blocks: Mutex<HashMap<Node, Arc<Room>>>,
}

/// A thread's hand in that.
pub(super) struct Irradiance {
    gathered: Arc<Gathered>,
    paths: Paths,
}

impl Gathered {
    /// Nothing yet, at one of some moments; none if it is not asked for.
    pub fn new(settings: &Settings, moment: usize, moments: usize) -> Option<Arc<Gathered>> {
        let Settings { irradiance_spacing: spacing, bounces, width, height, .. } = *settings;
        (spacing > 0 && bounces > 0).then(|| {
            let sides = [width, height].map(|side| side.div_ceil(spacing));
            // Powers of two are even over the hemisphere.
            let paths = (PATHS / moments.next_power_of_two() as u32).max(PATHS_AT_ONCE);
            let first = moment as u32 * paths;
            let capacity = REMEMBERED / moments.max(1);
            Arc::new(Gathered { spacing, paths, first, sides, capacity, blocks: Mutex::default() })
        })
    }

    /// The places around one, in distances between places, with their weights.
    fn around(&self, at: [f64; 2]) -> impl Iterator<Item = (Node, f64)> + use<> {
        let (low, sides) = (at.map(f64::floor), self.sides);
        let weights: [[f64; 4]; 2] = std::array::from_fn(|axis| cubic(at[axis] - low[axis]).value);
        (0..16_usize).filter_map(move |i| {
            let steps = [i % 4, i / 4];
            let place: [f64; 2] = std::array::from_fn(|axis| low[axis] + steps[axis] as f64 - 1.0);
            let is_inside = (0..2).all(|axis| place[axis] >= 0.0 && place[axis] < f64::from(sides[axis]));
            is_inside.then(|| (place.map(|x| x as u32), weights[0][steps[0]] * weights[1][steps[1]]))
        })
    }

    /// Where a patch appears, in distances between places, if its light can be shared.
    fn place(&self, scene: &Prepared, patch: &Patch) -> Option<[f64; 2]> {
        let is_matt = Reflector::new(patch, scene.reflecting.as_ref()).is_lambertian();
        let at = is_matt.then(|| scene.view.project(patch.position)).flatten()?;
        Some(at.map(|x| (x - 0.5) / f64::from(self.spacing)))
    }

    /// The room for a block. Whoever finds it empty fills it, and others wait.
    fn room(&self, block: Node) -> Arc<Room> {
        let mut blocks = locked(&self.blocks);
        if blocks.len() >= self.capacity && !blocks.contains_key(&block) {
            blocks.clear();
        }
        blocks.entry(block).or_default().clone()
    }
}

impl Irradiance {
    /// To take part.
    pub fn new(gathered: Arc<Gathered>) -> Irradiance {
        Irradiance { gathered, paths: Paths::default() }
    }

    /// The light from all around that leaves patches towards everywhere, where it is known from places near them; `None`
    /// when the job was cancelled.
    pub fn leaving(
        &mut self,
        seer: &mut Seer<'_>,
        patches: &[Patch],
        to: &mut Trace<'_>,
    ) -> Option<Vec<Option<DVec3>>> {
        let gathered = self.gathered.clone();
        let at: Vec<_> = patches.iter().map(|patch| gathered.place(seer.scene, patch)).collect();
        let cells: BTreeSet<[i64; 2]> = at.iter().flatten().map(|at| at.map(|x| x.floor() as i64)).collect();
        let nodes = cells.into_iter().flat_map(|cell| gathered.around(cell.map(|x| x as f64)));
        let wanted: BTreeSet<Node> = nodes.map(|(node, _)| node.map(|x| x / SIDE)).collect();
        let mut blocks: HashMap<Node, Arc<Block>> = HashMap::default();
        for block in wanted {
            blocks.insert(block, self.block(seer, block, to)?);
        }
        let record = |[x, y]: Node| {
            let block = blocks.get(&[x / SIDE, y / SIDE])?;
            block[(y % SIDE * SIDE + x % SIDE) as usize].as_ref()
        };
        let leaving = |(patch, at): (&Patch, &Option<[f64; 2]>)| {
            let near = gathered.around((*at)?);
            let near = near.filter_map(|(node, weight)| Some((record(node)?, weight)));
            blend(patch, near).map(|light| patch.albedo * light / PI)
        };
        Some(patches.iter().zip(&at).map(leaving).collect())
    }

    /// What is known of a block, from now on at least.
    fn block(&mut self, seer: &mut Seer<'_>, block: Node, to: &mut Trace<'_>) -> Option<Arc<Block>> {
        let room = self.gathered.room(block);
        let mut room = locked(&room);
        if room.is_none() {
            *room = Some(Arc::new(self.gather(seer, block, to)?));
        }
        room.clone()
    }

    /// Looks at the places of a block, and follows paths from them.
    fn gather(&mut self, seer: &mut Seer<'_>, block: Node, to: &mut Trace<'_>) -> Option<Block> {
        let gathered = self.gathered.clone();
        let node = |i: u32| [block[0] * SIDE + i % SIDE, block[1] * SIDE + i / SIDE];
        let nodes: Vec<u32> =
            (0..SIDE * SIDE).filter(|i| (0..2).all(|axis| node(*i)[axis] < gathered.sides[axis])).collect();
        let pixel = |i: u32| node(i).map(|x| x * gathered.spacing);
        let middles: Vec<Sample> = nodes.iter().map(|i| Sample::new(pixel(*i), 0, 0, 0)).collect();
        self.paths.meet_middles(seer, &mut to.of(&middles));
        let seen =
            |(path, patch): (&Path, &Patch)| Seen { place: nodes[path.sample], path: *path, patch: *patch };
        let seen = self.paths.dry_patches().map(seen);
        let seen: Vec<Seen> = seen.filter(|seen| gathered.place(seer.scene, &seen.patch).is_some()).collect();
        let mut out: Block = Default::default();
        for (light, seen) in self.arriving(seer, &seen, pixel, to)?.into_iter().zip(seen) {
            out[seen.place as usize] = Some(Record::new(seer.scene, gathered.spacing, &seen, light));
        }
        Some(out)
    }

    /// Follows paths from patches, for the light that comes there.
    fn arriving(
        &mut self,
        seer: &mut Seer<'_>,
        seen: &[Seen],
        pixel: impl Fn(u32) -> [u32; 2],
        to: &mut Trace<'_>,
    ) -> Option<Vec<Arriving>> {
        let Gathered { paths, first, .. } = *self.gathered;
        let seed = seer.scene.settings.seed;
        let mut samples = Vec::with_capacity(seen.len() * paths as usize);
        let mut onward = Vec::with_capacity(samples.capacity());
        for Seen { place, patch, .. } in seen {
            let (frame, origin) = (Frame::around(patch.normal), seer.scene.lifted(patch, 1.0));
            for index in first..first + paths {
                let sample = Sample::new(pixel(*place), index, seed, 0);
                let u = sample.pair(Purpose::Onward { step: 0 });
                let direction = frame.to_world(uniform_hemisphere(u));
                onward.push(Path::onward(samples.len(), origin, direction));
                samples.push(sample);
            }
        }
        let directions: Vec<DVec3> = onward.iter().map(|path| path.direction).collect();
        self.paths.follow_on(seer, onward, &mut to.of(&samples))?;
        let lights: Vec<DVec3> = self.paths.outcomes.iter().map(|outcome| outcome.total()).collect();
        let count = paths as usize;
        let brought = directions.chunks_exact(count).zip(lights.chunks_exact(count));
        let all = seen.iter().zip(brought);
        Some(all.map(|(seen, (d, lights))| Arriving::new(seen.patch.normal, d, lights)).collect())
    }
}

impl Record {
    /// Of what the eye sees, and the light that comes there.
    fn new(scene: &Prepared, spacing: u32, Seen { path, patch, .. }: &Seen, light: Arriving) -> Record {
        let Patch { position, normal, .. } = *patch;
        let facing = f64::from(spacing) * scene.view.footprint(path.distance);
        // Seen at a glance a surface goes far from pixel to pixel.
        let apart = [facing, facing / normal.dot(path.direction).abs().max(0.05)];
        Record { position, apart, light }
    }

    /// How far a patch is like this place, from 0 to 1.
    fn agreement(&self, patch: &Patch) -> f64 {
        let (way, [facing, along]) = (patch.position - self.position, self.apart);
        let normal = self.light.normal;
        let beside = way.dot(normal).abs().max(way.dot(patch.normal).abs()) / (BESIDE * facing);
        let along = way.length() / (ALONG * along);
        let turned = (1.0 - patch.normal.dot(normal)) / (1.0 - ALIKE);
        let share = |far: f64| (1.0 - far * far).max(0.0);
        share(beside) * share(along) * share(turned)
    }
}

impl Arriving {
    /// By what comes from directions above a surface.
    fn new(normal: DVec3, directions: &[DVec3], lights: &[DVec3]) -> Arriving {
        let mean = |lights: &mut dyn Iterator<Item = DVec3>| {
            let (sum, count) =
                lights.fold((DVec3::ZERO, 0.0), |(sum, count), light| (sum + light, count + 1.0));
            sum / f64::max(count, 1.0)
        };
        let all = mean(&mut lights.iter().copied());
        let vector = |channel: usize| {
            let beyond = |(direction, light): (&DVec3, &DVec3)| (light[channel] - all[channel]) * *direction;
            let beyond = directions.iter().zip(lights).map(beyond).sum::<DVec3>();
            PI * all[channel] * normal + TAU / lights.len() as f64 * beyond
        };
        let low = directions.iter().zip(lights).filter(|(direction, _)| direction.dot(normal) < LOW);
        let horizon = mean(&mut low.map(|(_, light)| *light));
        Arriving { normal, vector: std::array::from_fn(vector), horizon }
    }

    /// Irradiance of a surface with a normal, bumps included.
    fn irradiance(&self, normal: DVec3) -> DVec3 {
        let along = DVec3::from_array(self.vector.map(|vector| vector.dot(normal)));
        (along + PI * (1.0 - normal.dot(self.normal)) * self.horizon).max(DVec3::ZERO)
    }
}

/// Light that comes to a patch, by places around it; none if too few are like it.
fn blend<'a>(patch: &Patch, near: impl Iterator<Item = (&'a Record, f64)>) -> Option<DVec3> {
    let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
    for (record, weight) in near {
        let weight = weight * record.agreement(patch);
        sum += weight * record.light.irradiance(patch.shading);
        weights += weight;
    }
    (weights >= ENOUGH).then(|| sum / weights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::sequence;

    /// What comes to a surface from above, by a formula.
    fn arriving(normal: DVec3, light: impl Fn(DVec3) -> DVec3) -> Arriving {
        let frame = Frame::around(normal);
        let direction = |k: u32| frame.to_world(uniform_hemisphere(sequence::point(7, k, 0)));
        let directions: Vec<DVec3> = (0..4096).map(direction).collect();
        let lights: Vec<DVec3> = directions.iter().map(|d| light(*d)).collect();
        Arriving::new(normal, &directions, &lights)
    }

    #[test]
    fn even_light_has_its_value_whatever_the_normals() {
        let m = DVec3::new(0.3, 0.8, -0.2).normalize();
        let light = arriving(m, |_| DVec3::new(1.0, 0.5, 0.0));
        for turned in [m, (m + 0.4 * DVec3::X).normalize(), (m - DVec3::Z).normalize()] {
            assert!((light.irradiance(turned) - PI * DVec3::new(1.0, 0.5, 0.0)).length() < 1e-12);
        }
    }

    #[test]
    fn light_has_the_right_value_and_slope() {
        // L = max(w . a, 0)^2: over the half above n, E = pi / 8 (1 + 3 (n . a)^2 + ...) is summed up by brute force.
        let a = DVec3::new(0.6, 0.7, 0.1).normalize();
        let light = |d: DVec3| DVec3::splat(d.dot(a).max(0.0).powi(2));
        let m = DVec3::new(0.1, 0.9, 0.3).normalize();
        let exact = |n: DVec3| {
            let frame = Frame::around(n);
            let all = (0..65_536).map(|k| frame.to_world(uniform_hemisphere(sequence::point(3, k, 0))));
            TAU / 65_536.0 * all.map(|d| light(d).x * d.dot(n)).sum::<f64>()
        };
        let found = arriving(m, light);
        assert!((found.irradiance(m).x / exact(m) - 1.0).abs() < 2e-3);
        for aside in [DVec3::X, DVec3::Z, DVec3::new(-1.0, 0.2, 0.5)] {
            let turned = (m + 0.2 * aside).normalize();
            let (slope, right) =
                (found.irradiance(turned).x - found.irradiance(m).x, exact(turned) - exact(m));
            assert!((slope - right).abs() < 0.03 * exact(m), "{slope} {right}");
        }
    }
}
