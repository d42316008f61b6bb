//! How many steps a flow takes.
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

use super::cubes::Cubes;
use super::matrix::UP;
use super::step::ends;
use super::{Code, Parts};
use crate::num::{Dual, Interval, Kernel, Slope, mix, uniform};
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

/// Half the cube around the origin in which solids are by habit, and halves of the larger cubes that are probed if next to
/// nothing moves in that.
const HALVES: [f64; 4] = [1.5, 12.0, 96.0, 768.0];

/// What moves by less than this share of half a cube, in the time that a flow takes, does not move in it.
const STILL: f64 = 1e-6;

/// Points that are spread over a cube, of those that are probed.
const SPREAD: usize = 256;

/// Points that are probed: those of the least cube in which anything is seen to move.
pub(super) fn probes<V: Code<3>>(velocity: &V) -> Vec<[f64; 3]> {
    let mut run = velocity.runner::<Interval>();
    let mut moves =
        |p: &[f64; 3], half: f64| run(&p.map(Interval::point)).iter().any(|u| u.mig() > STILL * half);
    let sets = HALVES.iter().map(|half| (*half, probes_within(velocity, *half)));
    let found = sets.into_iter().find(|(half, probes)| probes.iter().any(|p| moves(p, *half)));
    found.map(|(_, probes)| probes).unwrap_or_else(|| probes_within(velocity, HALVES[0]))
}

/// The probes, without those in singular places, as the middle of a field of directions is. No step is short enough there, so
/// that they say nothing of how many there should be. A probe that was looked for is in such a place if the velocity is out of
/// all proportion steeper there than at any that was spread where the velocity is fast.
fn ordinary<V: Code<3>>(velocity: &V, probes: &[[f64; 3]]) -> Vec<[f64; 3]> {
    const FAST: f64 = 0.125;
    const PROPORTION: f64 = 16.0;
    let pace = pace(velocity, probes);
    let fastest = pace.iter().map(|(speed, _)| *speed).filter(|speed| speed.is_finite()).fold(0.0, f64::max);
    let fast = pace.iter().take(SPREAD).filter(|(speed, _)| *speed >= FAST * fastest);
    let steepest = fast.map(|(_, slope)| *slope).filter(|slope| slope.is_finite()).fold(0.0, f64::max);
    let limit = if steepest > 0.0 { PROPORTION * steepest } else { f64::INFINITY };
    let is_ordinary = |i: usize| i < SPREAD || pace[i].1 <= limit;
    (0..probes.len()).filter(|i| is_ordinary(*i)).map(|i| probes[i]).collect()
}

/// How fast a velocity is at points, and how steep.
fn pace<V: Code<3>>(velocity: &V, at: &[[f64; 3]]) -> Vec<(f64, f64)> {
    let mut run = velocity.runner::<Dual>();
    let length = |parts: &mut dyn Iterator<Item = f64>| parts.map(|part| part * part).sum::<f64>().sqrt();
    let pace = |y: &[f64; 3]| {
        let u = run(&std::array::from_fn(|axis| Dual::coordinate(y[axis], axis)));
        (length(&mut u.iter().map(|u| u.value)), length(&mut u.iter().flat_map(|u| u.grad)))
    };
    at.iter().map(pace).collect()
}

/// Many points all over a cube, and some where the velocity is largest, as far as enclosures tell. These find what moves
/// in a small part of the cube alone, such as a shell or the reach of a brush.
fn probes_within<V: Code<3>>(velocity: &V, half: f64) -> Vec<[f64; 3]> {
    const CUTS: usize = 64;
    let spread = |i: u64| std::array::from_fn(|axis| half * (2.0 * uniform(mix(3 * i + axis as u64)) - 1.0));
    let mut probes: Vec<[f64; 3]> = (0..SPREAD as u64).map(spread).collect();
    let mut run = velocity.runner::<Interval>();
    let mut cubes = Cubes::new(half, |at| speed(&run(&at)));
    for _ in 0..CUTS {
        let Some(cube) = cubes.cut() else { break };
        probes.push(cube.middle);
    }
    probes
}

/// Steps that keep the mean error of a flow below a share of how far it carries points, as far as trajectories from
/// probes tell.
pub(super) fn choose<V: Code<3>>(velocity: &V, tolerance: f64, probes: &[[f64; 3]]) -> u32 {
    let probes = &ordinary(velocity, probes)[..];
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
    let slopes = pace(velocity, probes).into_iter().map(|(_, slope)| slope);
    let steepest = slopes.filter(|s| s.is_finite()).fold(0.0, f64::max);
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

/// Whether it is proven that so many steps move no two points into one, wherever they are: that the velocity is as steep
/// nowhere in space, as those of noises are. Then to every place a point is moved.
pub(super) fn are_one_to_one<V: Code<3>>(velocity: &V, steps: u32) -> bool {
    let enough = steep(steps);
    if let Parts::Slope(kernel, k) = velocity.parts() {
        return k.abs() * kernel.bounds().hessian < enough;
    }
    steepness(velocity)([Interval::ENTIRE; 3]) < enough
}

/// Whether it is proven that so many steps move no two points of the cube of points not further than `half` along any
/// axis into one.
pub(super) fn are_one_to_one_within<V: Code<3>>(velocity: &V, steps: u32, half: f64) -> bool {
    let Some(reach) = reach(velocity, half) else {
        return false;
    };
    Cubes::new(half + reach, steepness(velocity)).are_all_below(steep(steps), CUTS)
}

/// How steep a velocity of so many steps may be.
fn steep(steps: u32) -> f64 {
    LN_2 * f64::from(steps)
}

/// Bound on how steep a velocity is in a box.
fn steepness<V: Code<3>>(velocity: &V) -> impl FnMut([Interval; 3]) -> f64 + use<'_, V> {
    let norm = |parts: [f64; 3]| parts.iter().map(|part| part * part).sum::<f64>().sqrt() * UP;
    let mut run = velocity.runner::<Slope>();
    move |at| norm(run(&std::array::from_fn(|axis| Slope::coordinate(at[axis], axis))).map(|u| u.norm))
}

/// Bound on the length of a velocity.
fn speed(u: &[Interval; 3]) -> f64 {
    u.iter().map(|u| u.mag() * u.mag()).sum::<f64>().sqrt() * UP
}
