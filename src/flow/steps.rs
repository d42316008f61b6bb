//! How many steps a flow takes, and what they do to points.
//!
//! Steps are equally long everywhere, so that the map is as smooth as the velocity and has an inverse; a method that chose
//! them for each trajectory would tear space a little wherever its choice changes. So the choice is made beforehand:
//! trajectories from probes are followed in so many steps and in twice as many, and so on until they end in the same
//! places, to within a share of how far the flow carries points on average.
//!
//! A step moves no two points into one if what it adds to them varies less than they are apart. With `L` a Lipschitz bound of
//! the velocity, and `x = h L`, that of `h/6 (k1 + 2 k2 + 2 k3 + k4)` is
//!
//! ```text
//! x + x^2/2 + x^3/6 + x^4/24  <  e^x - 1  <=  1        for x <= ln 2
//! ```
//!
//! which is seen to at the probes, and can be [proven](are_one_to_one) for all points of a cube.

use super::matrix::UP;
use super::{Code, Parts, advect};
use crate::num::{Dual, Interval, Kernel, Many, Slope, mix, uniform};
use std::collections::BinaryHeap;
use std::f64::consts::LN_2;

/// How close the steps come to the flow.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Precision {
    /// So many steps.
    Steps(u32),
    /// An error of this share of how far points are carried on average; the bits of the number, so that it can be hashed.
    Share(u64),
}

/// Most steps that a flow takes.
pub const MOST: u32 = 512;

/// Fewest steps that are chosen.
const FEWEST: u32 = 4;

/// Trajectories side by side.
pub(super) const LANES: usize = 16;

/// Half the cube around the origin in which solids are by habit.
const HALF: f64 = 1.5;

/// Points that are probed: many all over the cube, and as many where the velocity is largest, as far as enclosures tell.
/// These find what moves in a small part of the cube alone, such as a shell or the reach of a brush.
pub(super) fn probes<V: Code<3>>(velocity: &V) -> Vec<[f64; 3]> {
    const COUNT: u64 = 256;
    const CUTS: usize = 64;
    let spread = |i: u64| std::array::from_fn(|axis| HALF * (2.0 * uniform(mix(3 * i + axis as u64)) - 1.0));
    let mut probes: Vec<[f64; 3]> = (0..COUNT).map(spread).collect();
    let mut run = velocity.runner::<Interval>();
    let mut cubes = Cubes::new(HALF, |at| speed(&run(&at)));
    for _ in 0..CUTS {
        let Some(cube) = cubes.cut() else { break };
        probes.push(cube.middle);
    }
    probes
}

/// Steps that keep the mean error of a flow below a share of how far it carries points, as far as trajectories from
/// probes tell.
pub(super) fn choose<V: Code<3>>(velocity: &V, tolerance: f64, probes: &[[f64; 3]]) -> u32 {
    let axis = |axis: usize| probes.iter().map(|p| p[axis]).collect::<Vec<f64>>();
    let (x, y, z) = (axis(0), axis(1), axis(2));
    let after = |steps: u32| ends(velocity, steps, [&x, &y, &z]);
    let mut steps = FEWEST.max(one_to_one(velocity, probes));
    let mut ends = after(steps);
    while steps < MOST {
        let finer = after(2 * steps);
        // The method is of fourth order: what is left of the error is little more than what has gone.
        if moved(&ends, &finer) <= tolerance * moved(probes, &finer) {
            break;
        }
        (steps, ends) = (2 * steps, finer);
    }
    steps.min(MOST)
}

/// The root of the mean squared distance between points, as far as there is one. Not the largest: where a trajectory
/// passes a crease of the velocity, no method is of high order.
fn moved(from: &[[f64; 3]], to: &[[f64; 3]]) -> f64 {
    let square = |(a, b): (&[f64; 3], &[f64; 3])| (0..3).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum::<f64>();
    let squares: Vec<f64> = from.iter().zip(to).map(square).filter(|d| d.is_finite()).collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}

/// Steps so short that none moves two points into one, as far as slopes at these points tell.
fn one_to_one<V: Code<3>>(velocity: &V, probes: &[[f64; 3]]) -> u32 {
    let mut run = velocity.runner::<Dual>();
    let mut slope = |y: &[f64; 3]| {
        let u = run(&std::array::from_fn(|axis| Dual::coordinate(y[axis], axis)));
        u.iter().flat_map(|u| u.grad).map(|g| g * g).sum::<f64>().sqrt()
    };
    let steepest = probes.iter().map(&mut slope).filter(|s| s.is_finite()).fold(0.0, f64::max);
    ((steepest / LN_2).ceil() as u32).clamp(1, MOST).next_power_of_two()
}

/// Pieces that a cube is cut into for a proof.
const CUTS: usize = 512;

/// How far a velocity carries points of a cube at most; none where that cannot be told.
pub(super) fn reach<V: Code<3>>(velocity: &V, half: f64) -> Option<f64> {
    let mut run = velocity.runner::<Interval>();
    let mut stays = |reach: f64| Cubes::new(half + reach, |at| speed(&run(&at))).are_all_below(reach, CUTS);
    // Trajectories do not leave a cube that is larger by how far the velocity carries points of it.
    [0.125, 0.5, 2.0, 8.0].map(|share| share * half).into_iter().find(|reach| stays(*reach))
}

/// Whether it is proven that so many steps move no two points of the cube of points not further than `half` along any
/// axis into one.
pub(super) fn are_one_to_one<V: Code<3>>(velocity: &V, steps: u32, half: f64) -> bool {
    let enough = LN_2 * f64::from(steps);
    // What holds of all of space is known of noises.
    let norm = |parts: [f64; 3]| parts.iter().map(|part| part * part).sum::<f64>().sqrt() * UP;
    match velocity.parts() {
        Parts::Kernels(parts) => {
            return norm(parts.map(|(kernel, k)| k * kernel.bounds().lipschitz)) < enough;
        }
        Parts::Slope(kernel, k) => return k.abs() * kernel.bounds().hessian < enough,
        Parts::Any => {}
    }
    let Some(reach) = reach(velocity, half) else {
        return false;
    };
    let mut run = velocity.runner::<Slope>();
    let steepest = |at: [Interval; 3]| {
        norm(run(&std::array::from_fn(|axis| Slope::coordinate(at[axis], axis))).map(|u| u.norm))
    };
    Cubes::new(half + reach, steepest).are_all_below(enough, CUTS)
}

/// Bound on the length of a velocity.
fn speed(u: &[Interval; 3]) -> f64 {
    u.iter().map(|u| u.mag() * u.mag()).sum::<f64>().sqrt() * UP
}

/// A cube, and a bound on something in it.
struct Cube {
    bound: f64,
    middle: [f64; 3],
    half: f64,
}

/// By the bound, where there is none first; smaller ones first among equals.
impl Ord for Cube {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.bound.total_cmp(&other.bound).then(other.half.total_cmp(&self.half))
    }
}

impl PartialOrd for Cube {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Cube {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Cube {}

/// A cube in pieces, of which those are cut further where a bound is largest.
struct Cubes<B> {
    bound: B,
    waiting: BinaryHeap<Cube>,
}

impl<B: FnMut([Interval; 3]) -> f64> Cubes<B> {
    fn new(half: f64, bound: B) -> Self {
        let mut cubes = Cubes { bound, waiting: BinaryHeap::new() };
        cubes.add([0.0; 3], half);
        cubes
    }

    /// Adds a piece, unless there is nothing in it.
    fn add(&mut self, middle: [f64; 3], half: f64) {
        let bound = (self.bound)(middle.map(|c| Interval::around(c, half))).abs();
        if bound != 0.0 {
            self.waiting.push(Cube { bound, middle, half });
        }
    }

    /// Cuts the piece with the largest bound into eight, and returns it.
    fn cut(&mut self) -> Option<Cube> {
        let cube = self.waiting.pop()?;
        let half = 0.5 * cube.half;
        for corner in 0..8 {
            let side = |axis: usize| if corner >> axis & 1 == 0 { -half } else { half };
            self.add(std::array::from_fn(|axis| cube.middle[axis] + side(axis)), half);
        }
        Some(cube)
    }

    /// Whether the bound is below a number everywhere, as so many cuts tell.
    fn are_all_below(mut self, most: f64, cuts: usize) -> bool {
        let is_below = |cubes: &Self| cubes.waiting.peek().is_none_or(|cube| cube.bound < most);
        for _ in 0..cuts {
            if is_below(&self) {
                return true;
            }
            self.cut();
        }
        is_below(&self)
    }
}

/// Where trajectories end.
pub(super) fn ends<V: Code<3>>(velocity: &V, steps: u32, at: [&[f64]; 3]) -> Vec<[f64; 3]> {
    let mut ends = vec![[0.0; 3]; at[0].len()];
    let mut run = velocity.runner();
    in_lanes(
        at,
        |x, _| x,
        |from| advect(&mut run, steps, &from, |Many(v)| v.iter().all(|v| *v == 0.0)),
        |i, end| ends[i] = end,
    );
    ends
}

/// Puts points through a function in lanes: `start` makes a coordinate, `store` takes a lane of the result. Lanes to
/// spare repeat the last point.
pub(super) fn in_lanes<T: Copy, const N: usize>(
    at: [&[f64]; 3],
    start: impl Fn(f64, usize) -> T,
    mut image: impl FnMut([Many<T, LANES>; 3]) -> [Many<T, LANES>; N],
    mut store: impl FnMut(usize, [T; N]),
) {
    let count = at[0].len();
    for first in (0..count).step_by(LANES) {
        let lane = |axis: usize, i: usize| start(at[axis][(first + i).min(count - 1)], axis);
        let values = image(std::array::from_fn(|axis| Many(std::array::from_fn(|i| lane(axis, i)))));
        for i in 0..LANES.min(count - first) {
            store(first + i, values.each_ref().map(|Many(lanes)| lanes[i]));
        }
    }
}
