//! A region cut into cubes, with what is known of the field around each.
//!
//! What is known of a cube depends on nothing but where it is, so that threads may share the tree, and it makes no
//! difference who asks first. Beyond so many cubes nothing is kept any more: then it is found again by whoever asks.

use crate::cast::Ray;
use crate::num::{ROUNDOFF, Taylor};
use crate::scene::Aabb;
use glam::DVec3;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Children of a cube.
const PARTS: usize = 8;

/// Times that the region is cut at most.
pub(super) const DEEPEST: u32 = 48;

/// Cubes that are cut at most: some 400 MB.
const MOST: usize = 1 << 19;

/// How much more than its half diagonal the radius of the ball around a cube is, as a share of half its side.
const ROOM: f64 = 0.01;

/// The field over the ball around a cube: `value + grad . (x - middle)` but for `bow`, with gradients that are no further
/// than `turn` from the one in the middle, and not below `least`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fact {
    pub value: f64,
    pub grad: DVec3,
    pub bow: f64,
    pub turn: f64,
    pub least: f64,
    /// Whether it has a value all over the ball.
    pub is_defined: bool,
    /// Bound on the length of gradients.
    pub steep: f64,
}

impl Fact {
    /// From an expansion over a ball.
    pub fn new(f: &Taylor, radius: f64) -> Fact {
        // Derivatives of expansions are in units of the ball.
        let scale = 1.0 / radius;
        Fact {
            value: f.value,
            grad: scale * DVec3::from_array(f.grad),
            bow: f.bow[0],
            turn: scale * f.turn[0] * (1.0 + 1e-12),
            least: f.range.lo,
            is_defined: f.range.is_finite(),
            steep: scale * f.steepness() * (1.0 + 1e-12),
        }
    }
}

/// One of the cubes that there are after so many cuts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Cube {
    pub level: u32,
    at: [u64; 3],
}

impl Cube {
    /// The largest cube around `other`, which is of the same size, that this one is not in.
    pub fn largest_around(&self, other: Cube) -> Cube {
        let differ = (0..3).fold(0, |differ, axis| differ | (self.at[axis] ^ other.at[axis]));
        let up = (u64::BITS - differ.leading_zeros()).saturating_sub(1);
        Cube { level: other.level - up.min(other.level), at: other.at.map(|at| at >> up) }
    }
}

/// The cubes; see the module text.
#[derive(Debug)]
pub(super) struct Tree {
    corner: DVec3,
    side: f64,
    root: Node,
    cut: AtomicUsize,
}

#[derive(Debug, Default)]
struct Node {
    /// The value in the middle.
    value: OnceLock<f64>,
    fact: OnceLock<Fact>,
    parts: OnceLock<Box<[Node; PARTS]>>,
}

impl Tree {
    pub fn new(region: &Aabb) -> Tree {
        let (middle, half) = (0.5 * (region.min + region.max), 0.5 * (region.max - region.min).max_element());
        let half = (1.0 + 1e-7) * half + f64::MIN_POSITIVE;
        Tree { corner: middle - half, side: 2.0 * half, root: Node::default(), cut: AtomicUsize::new(0) }
    }

    /// All cubes together.
    pub fn bounds(&self) -> Aabb {
        Aabb { min: self.corner, max: self.corner + self.side }
    }

    /// Half the side of cubes after so many cuts.
    fn half(&self, level: u32) -> f64 {
        0.5 * self.side / (1u64 << level) as f64
    }

    /// The ball around a cube, and what is close to it.
    pub fn ball(&self, cube: Cube) -> (DVec3, f64) {
        let half = self.half(cube.level);
        let middle = self.corner + half * (2.0 * DVec3::from_array(cube.at.map(|at| at as f64)) + 1.0);
        (middle, (3f64.sqrt() + ROOM) * half)
    }

    /// How many times the region is cut at most before cubes are so small that what is rounded counts along a ray.
    pub fn deepest(&self, ray: &Ray) -> u32 {
        let smallest = 0.25 * ROOM * self.half(0) / self.rounding(ray, ray.near.abs().max(ray.far.abs()));
        (smallest as u64).checked_ilog2().unwrap_or(0).min(DEEPEST)
    }

    /// How far, on any axis, places on a ray up to `t` and faces may be from where they are computed.
    pub fn rounding(&self, ray: &Ray, t: f64) -> f64 {
        ray.rounding(t) + 4.0 * ROUNDOFF * (self.corner.abs().max_element() + self.side)
    }

    /// The cube of a size that a ray comes into, or is in, at `t`. What is close to a face is taken to be behind it, so
    /// that rays get on.
    pub fn cube(&self, ray: &Ray, t: f64, level: u32) -> Cube {
        let (half, last) = (self.half(level), (1u64 << level) - 1);
        let ahead = 2.0 * self.rounding(ray, t.abs()) * ray.direction.signum();
        let place = (ray.at(t) + ahead - self.corner) / (2.0 * half);
        Cube { level, at: place.to_array().map(|x| (x as u64).min(last)) }
    }

    /// The part of a cube that a ray is in at `t`; the closest one where the ray is about to leave the cube.
    pub fn part(&self, cube: Cube, ray: &Ray, t: f64) -> Cube {
        let Cube { level, at } = self.cube(ray, t, cube.level + 1);
        Cube {
            level,
            at: std::array::from_fn(|axis| at[axis].clamp(2 * cube.at[axis], 2 * cube.at[axis] + 1)),
        }
    }

    /// Where a ray that is in a cube at `t` leaves it.
    pub fn exit(&self, ray: &Ray, t: f64, cube: Cube) -> f64 {
        let half = self.half(cube.level);
        let mut exit = f64::INFINITY;
        for axis in 0..3 {
            let direction = ray.direction[axis];
            if direction == 0.0 {
                continue;
            }
            let face = cube.at[axis] as f64 + f64::from(u8::from(direction > 0.0));
            let at = (self.corner[axis] + 2.0 * half * face - ray.origin[axis]) / direction;
            exit = exit.min(at);
        }
        exit.max(t)
    }

    /// The value in the middle of a cube, if it is known.
    pub fn value(&self, cube: Cube) -> Option<f64> {
        self.node(cube)?.value.get().copied()
    }

    /// What is known around a cube.
    pub fn fact(&self, cube: Cube) -> Option<&Fact> {
        self.node(cube)?.fact.get()
    }

    fn node(&self, cube: Cube) -> Option<&Node> {
        let mut node = &self.root;
        for up in (0..cube.level).rev() {
            node = &node.parts.get()?[part(cube, up)];
        }
        Some(node)
    }

    /// Keeps a value, if there is room. Whoever was first has found the same.
    pub fn keep_value(&self, cube: Cube, value: f64) {
        self.room(cube).map(|node| node.value.set(value));
    }

    /// Keeps what was found out, if there is room.
    pub fn keep_fact(&self, cube: Cube, fact: Fact) {
        self.room(cube).map(|node| node.fact.set(fact));
    }

    /// The node of a cube, made if need be.
    fn room(&self, cube: Cube) -> Option<&Node> {
        let mut node = &self.root;
        for up in (0..cube.level).rev() {
            if node.parts.get().is_none() && self.cut.fetch_add(1, Ordering::Relaxed) >= MOST {
                return None;
            }
            node = &node.parts.get_or_init(Box::default)[part(cube, up)];
        }
        Some(node)
    }
}

/// The part of its ancestor of so many levels above its parent that a cube is in.
fn part(cube: Cube, up: u32) -> usize {
    (0..3).map(|axis| ((cube.at[axis] >> up & 1) as usize) << axis).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cast::Tolerance;
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    #[test]
    fn rays_get_on_from_wherever_they_begin_and_are_in_the_balls_around_their_cubes() {
        let mut rng = StdRng::seed_from_u64(8);
        for half in [1.4, 10.0, 100.0] {
            let tree = Tree::new(&Aabb::cube(half));
            for i in 0..640 {
                // All signs, and along axes and faces; from the middle of the region too.
                let sign = |axis: u32| [1.0, -1.0, 0.0, -0.0][i / 4usize.pow(axis) % 4];
                let mut at = |most: f64| rng.random_range(0.0..most);
                let direction = DVec3::new(sign(0) * at(1.0), sign(1) * at(1.0), sign(2) * at(1.0));
                let Some(direction) = direction.try_normalize() else { continue };
                let origin = if i % 2 == 0 { DVec3::ZERO } else { DVec3::new(at(0.1), at(0.1), at(0.1)) };
                let (far, tolerance) = (half - 0.2, Tolerance::fixed(1e-9));
                let ray = Ray { origin, direction, near: 0.0, far, tolerance };
                for level in [1, 6, 20, tree.deepest(&ray)] {
                    let (mut t, mut cube) = (0.0, tree.cube(&ray, 0.0, level));
                    for _ in 0..100 {
                        let (exit, (middle, radius)) = (tree.exit(&ray, t, cube), tree.ball(cube));
                        let off = |t: f64| ray.at(t).distance(middle);
                        assert!(off(t).max(off(exit)) <= radius, "{ray:?} at {t}, {exit}: {cube:?}");
                        if exit >= ray.far {
                            break;
                        }
                        let next = tree.cube(&ray, exit, level);
                        assert!(next != cube || exit > t, "{ray:?} at {t} in {cube:?}");
                        (t, cube) = (exit, next);
                    }
                }
            }
        }
    }
}
