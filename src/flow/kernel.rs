//! A field that a flow has carried along, as a kernel.

use super::tube::{Rounding, Tube};
use super::{Code, Precision, advect, steps};
use crate::num::{Bounds, Centred, Class, Dual, Jet, Jets, Kernel, Local, Many, Number, Order, Taylors};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// A field evaluated where a flow carries points to; see the [module](super).
#[derive(Debug)]
pub struct Flowed<V, F> {
    velocity: V,
    field: F,
    steps: u32,
    rounding: [Rounding; 2],
    /// Trajectories that were followed, at points and around balls.
    followed: [AtomicU64; 2],
}

/// Trajectories side by side.
const LANES: usize = 16;
const BALLS: usize = 8;

impl<V: Code<3>, F: Code<1>> Flowed<V, F> {
    /// The field that a velocity carries along for a unit of time, against its direction.
    pub fn new(velocity: V, field: F, precision: Precision) -> Self {
        let steps = match precision {
            Precision::Steps(steps) => steps.clamp(1, steps::MOST),
            Precision::Share(bits) => steps::choose(&velocity, f64::from_bits(bits), &surface_points(&field)),
        };
        let rounding = [roundings(&velocity), roundings(&field)];
        Flowed { velocity, field, steps, rounding, followed: Default::default() }
    }

    /// Steps of the map.
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// The velocity.
    pub fn velocity(&self) -> &V {
        &self.velocity
    }

    /// The field before.
    pub fn field(&self) -> &F {
        &self.field
    }

    /// How many trajectories were followed so far, at points and around balls.
    pub fn followed(&self) -> [u64; 2] {
        self.followed.each_ref().map(|count| count.load(Relaxed))
    }

    /// Where the flow carries points to, and what the field is there.
    pub fn trace(&self, at: [&[f64]; 3]) -> (Vec<[f64; 3]>, Vec<f64>) {
        let count = at[0].len();
        self.followed[0].fetch_add(count as u64, Relaxed);
        let (mut ends, mut values) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for first in (0..count).step_by(LANES) {
            let lane = |axis: usize, i: usize| at[axis][(first + i).min(count - 1)];
            let from = std::array::from_fn(|axis| Many::<f64, LANES>(std::array::from_fn(|i| lane(axis, i))));
            let end =
                advect(self.velocity.runner(), self.steps, &from, |Many(v)| v.iter().all(|v| *v == 0.0));
            let [value] = self.field.runner()(&end);
            let lanes = LANES.min(count - first);
            ends.extend((0..lanes).map(|i| end.each_ref().map(|axis| axis.0[i])));
            values.extend_from_slice(&value.0[..lanes]);
        }
        (ends, values)
    }

    /// The field at the end of a trajectory.
    fn carried<T: Number>(&self, from: &[T; 3], is_still: impl Fn(&T) -> bool) -> T {
        let [value] =
            self.field.runner::<T>()(&advect(self.velocity.runner::<T>(), self.steps, from, is_still));
        value
    }

    /// Carries lanes in batches; `start` makes a coordinate, `store` takes a lane of the result.
    fn batches<T: Centred + Copy>(
        &self,
        at: [&[f64]; 3],
        start: impl Fn(f64, usize) -> T,
        is_still: impl Fn(&T) -> bool,
        mut store: impl FnMut(usize, &T),
    ) {
        let count = at[0].len();
        if let [x] = at[0] {
            store(0, &self.carried(&[start(*x, 0), start(at[1][0], 1), start(at[2][0], 2)], is_still));
            return;
        }
        for first in (0..count).step_by(LANES) {
            // Lanes to spare repeat the last one.
            let lane = |axis: usize, i: usize| start(at[axis][(first + i).min(count - 1)], axis);
            let from =
                std::array::from_fn(|axis| Many(std::array::from_fn::<T, LANES, _>(|i| lane(axis, i))));
            let Many(values) = self.carried(&from, |Many(lanes)| lanes.iter().all(&is_still));
            values.iter().enumerate().take(count - first).for_each(|(i, value)| store(first + i, value));
        }
    }
}

/// Points on the surface of a field, or near it: where lines from far outside to near the origin change sign, for what
/// matters of a flow happens there however thin the shell is that it happens in.
fn surface_points<F: Code<1>>(field: &F) -> Vec<[f64; 3]> {
    const LINES: u64 = 64;
    const CUTS: u32 = 40;
    let mut run = field.runner::<f64>();
    let mut value = |p: [f64; 3]| {
        let [v] = run(&p);
        v
    };
    let random = |i: u64| {
        std::array::from_fn(|axis| 2.0 * crate::num::uniform(crate::num::mix(3 * i + axis as u64)) - 1.0)
    };
    let mut found = Vec::new();
    for line in 0..LINES {
        let (out, inner): ([f64; 3], [f64; 3]) = (random(2 * line), random(2 * line + 1));
        let mut ends = [out.map(|x| 3.0 * x), inner.map(|x| 0.1 * x)];
        if !(value(ends[0]) > 0.0 && value(ends[1]) < 0.0) {
            continue;
        }
        for _ in 0..CUTS {
            let middle = std::array::from_fn(|axis| 0.5 * (ends[0][axis] + ends[1][axis]));
            ends[usize::from(value(middle) <= 0.0)] = middle;
        }
        found.push(ends[0]);
    }
    found
}

/// What values and gradients are off by at points not further than 1 from the origin, as far as probes tell, with room
/// for other places: balls as small as this one is have nothing but rounding in them.
fn roundings<C: Code<N>, const N: usize>(code: &C) -> Rounding {
    const SMALL: f64 = 1e-13;
    const ROOM: f64 = 16.0;
    let mut run = code.runner::<Taylors<BALLS>>();
    let mut worst = Rounding::default();
    let mut numbers = [Taylors::<BALLS>::constant(0.0); 3];
    for batch in 0..8 {
        for lane in 0..BALLS {
            let i = (batch * BALLS + lane) as u64;
            let at = std::array::from_fn(|axis| {
                2.0 * crate::num::uniform(crate::num::mix(3 * i + axis as u64)) - 1.0
            });
            Taylors::set_ball(&mut numbers, lane, at, SMALL);
        }
        for value in run(&numbers) {
            for lane in 0..BALLS {
                let value = value.lane(lane);
                let larger = |a: f64, b: f64| if b.is_finite() { a.max(b) } else { a };
                worst.value = larger(worst.value, ROOM * value.bow[0]);
                worst.grad = larger(worst.grad, ROOM * value.turn[0] / SMALL);
            }
        }
    }
    worst
}

impl<V: Code<3>, F: Code<1>> Kernel for Flowed<V, F> {
    /// That of its parts, but never C2: its second derivatives are continuous where theirs are, but no bound is
    /// known on how they vary.
    fn class(&self) -> Class {
        self.velocity.class().min(self.field.class()).min(Class::C1)
    }

    fn bounds(&self) -> Bounds {
        let infinite = f64::INFINITY;
        Bounds { range: infinite, lipschitz: infinite, hessian: infinite, third: infinite }
    }

    fn jets(&self, at: [&[f64]; 3], out: Jets<'_>) {
        let count = at[0].len();
        self.followed[0].fetch_add(count as u64, Relaxed);
        let Jets { value, grad, hess } = out;
        match (grad, hess) {
            (None, _) => self.batches(at, |x, _| x, |v| *v == 0.0, |i, v: &f64| value[i] = *v),
            (Some(mut grad), None) => self.batches(
                at,
                Dual::coordinate,
                |v| *v == Dual::constant(0.0),
                |i, v| {
                    value[i] = v.value;
                    (0..3).for_each(|k| grad[k][i] = v.grad[k]);
                },
            ),
            // Rare enough to go point by point.
            (Some(mut grad), Some(mut hess)) => {
                for i in 0..count {
                    let from = std::array::from_fn(|axis| Jet::coordinate(at[axis][i], axis));
                    let v: Jet = self.carried(&from, |v| *v == Jet::constant(0.0));
                    value[i] = v.value;
                    (0..3).for_each(|k| grad[k][i] = v.grad[k]);
                    (0..6).for_each(|k| hess[k][i] = v.hess[k]);
                }
            }
        }
    }

    fn is_uniform(&self) -> bool {
        false
    }

    fn local(&self, order: Order, at: [f64; 3], radius: f64) -> Local {
        let mut out = [Local::UNKNOWN];
        self.locals(order, [&at[..1], &at[1..2], &at[2..]], &[radius], &mut out);
        out[0].0
    }

    fn locals(&self, _: Order, at: [&[f64]; 3], radius: &[f64], out: &mut [(Local, [f64; 3])]) {
        let count = radius.len();
        self.followed[1].fetch_add(count as u64, Relaxed);
        let tube =
            Tube { velocity: &self.velocity, field: &self.field, steps: self.steps, rounding: self.rounding };
        for first in (0..count).step_by(BALLS) {
            let lane = |i: usize| (first + i).min(count - 1);
            let centres = std::array::from_fn(|i| at.map(|at| at[lane(i)]));
            let known = tube.locals::<BALLS>(&centres, &std::array::from_fn(|i| radius[lane(i)]));
            let end = count.min(first + BALLS);
            out[first..end].copy_from_slice(&known[..end - first]);
        }
    }

    fn error(&self, _: f64) -> [f64; 3] {
        // Known of each ball only.
        [f64::INFINITY; 3]
    }
}
