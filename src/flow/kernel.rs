//! A field that a flow has carried along, as a kernel.

use super::pack::BALLS;
use super::stage::Rounding;
use super::step::{LANES, ends, in_lanes};
use super::tube::Tube;
use super::{Code, Parts, Precision, advect, steps};
use crate::num::{Bounds, Centred, Class, Dual, Jet, Jets, Kernel, Local, Many, Number, Order, Taylors};

/// A field evaluated where a flow carries points to; see the [module](super).
#[derive(Debug)]
pub struct Flowed<V, F> {
    velocity: V,
    field: F,
    steps: u32,
    /// What both are off by where they do not say.
    rounding: [Rounding; 2],
}

impl<V: Code<3>, F: Code<1>> Flowed<V, F> {
    /// The field that a velocity carries along for a unit of time, against its direction.
    pub fn new(velocity: V, field: F, precision: Precision) -> Self {
        let busy = steps::probes(&velocity);
        let steps = match precision {
            Precision::Steps(steps) => steps.clamp(1, steps::MOST),
            Precision::Share(bits) => steps::choose(&velocity, f64::from_bits(bits), &busy),
        };
        // Kernels say so themselves.
        let says = !matches!(velocity.parts(), Parts::Any);
        let own = if says { Rounding::default() } else { roundings(&velocity, &busy) };
        let rounding = [own, roundings(&field, &busy)];
        Flowed { velocity, field, steps, rounding }
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

    /// How far points of the cube of points not further than `half` along any axis are carried at most; none where that
    /// cannot be told.
    pub fn reach(&self, half: f64) -> Option<f64> {
        steps::reach(&self.velocity, half)
    }

    /// Whether it is proven that no two points come to one, and to every place one, so that what is carried keeps its
    /// topology.
    pub fn is_one_to_one(&self) -> bool {
        steps::are_one_to_one(&self.velocity, self.steps)
    }

    /// Whether it is proven that no two points of the cube of points not further than `half` along any axis come to one.
    pub fn is_one_to_one_within(&self, half: f64) -> bool {
        steps::are_one_to_one_within(&self.velocity, self.steps, half)
    }

    /// Where the flow carries points to, and what the field is there.
    pub fn trace(&self, at: [&[f64]; 3]) -> (Vec<[f64; 3]>, Vec<f64>) {
        let ends = ends(&self.velocity, self.steps, at);
        let mut values = vec![0.0; ends.len()];
        let [x, y, z] = [0, 1, 2].map(|axis| ends.iter().map(|end| end[axis]).collect::<Vec<f64>>());
        let mut run = self.field.runner::<Many<f64, { LANES }>>();
        in_lanes([&x, &y, &z], |x, _| x, |at| run(&at), |i, [value]| values[i] = value);
        (ends, values)
    }

    /// The field at the ends of trajectories: `start` makes a coordinate, `store` takes a lane of the result.
    fn carried<T: Centred + Copy>(
        &self,
        at: [&[f64]; 3],
        start: impl Fn(f64, usize) -> T,
        is_still: impl Fn(&T) -> bool,
        mut store: impl FnMut(usize, &T),
    ) {
        if let [x] = at[0] {
            let from = [start(*x, 0), start(at[1][0], 1), start(at[2][0], 2)];
            let end = advect(self.velocity.runner::<T>(), self.steps, &from, is_still);
            let [value] = self.field.runner::<T>()(&end);
            return store(0, &value);
        }
        let (mut velocity, mut field) = (self.velocity.runner(), self.field.runner());
        let end = |from: [Many<T, { LANES }>; 3]| {
            field(&advect(&mut velocity, self.steps, &from, |Many(lanes)| lanes.iter().all(&is_still)))
        };
        in_lanes(at, start, end, |i, [value]| store(i, &value));
    }
}

/// What values and gradients are off by at points not further than 1 from the origin, as far as probes tell, with room
/// for other places: balls as small as this one is have nothing but rounding in them.
fn roundings<C: Code<N>, const N: usize>(code: &C, busy: &[[f64; 3]]) -> Rounding {
    const SMALL: f64 = 1e-13;
    const ROOM: f64 = 16.0;
    let mut run = code.runner::<Taylors<BALLS>>();
    let (mut value_off, mut grads) = (0.0, Vec::with_capacity(N * busy.len()));
    let mut numbers = [Taylors::<BALLS>::constant(0.0); 3];
    for batch in busy.chunks_exact(BALLS) {
        for (lane, at) in batch.iter().enumerate() {
            Taylors::set_ball(&mut numbers, lane, *at, SMALL);
        }
        for value in run(&numbers) {
            for lane in 0..BALLS {
                // Less what bends within the ball; at a crease, where that is not bounded, nothing is left.
                let value = value.lane(lane);
                let bent = value.curvature();
                value_off = f64::max(value_off, ROOM * (value.bow[0] - 0.5 * bent));
                grads.push([ROOM * (value.turn[0] - bent), value.steepness()].map(|x| x / SMALL));
            }
        }
    }
    let mut steep: Vec<f64> = grads.iter().map(|[_, steep]| *steep).filter(|s| s.is_finite()).collect();
    steep.sort_by(f64::total_cmp);
    // Where little of space moves, next to no slope is no measure.
    let mostly = steep.get(steep.len() / 2).map_or(1.0, |median| median.max(1.0));
    let share = grads.iter().map(|[off, steep]| off / (mostly + steep));
    Rounding { value: value_off, grad: share.fold(0.0, f64::max), mostly }
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
        let Jets { value, grad, hess } = out;
        match (grad, hess) {
            (None, _) if value.len() > 1 => value.copy_from_slice(&self.trace(at).1),
            (None, _) => self.carried(at, |x, _| x, |v| *v == 0.0, |i, v: &f64| value[i] = *v),
            (Some(mut grad), None) => self.carried(
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
                let (mut velocity, mut field) = (self.velocity.runner(), self.field.runner());
                for i in 0..at[0].len() {
                    let from = std::array::from_fn(|axis| Jet::coordinate(at[axis][i], axis));
                    let end = advect(&mut velocity, self.steps, &from, |v| *v == Jet::constant(0.0));
                    let [v] = field(&end);
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
        let tube = Tube::new(&self.velocity, &self.field, self.steps, self.rounding);
        for (batch, out) in out.chunks_mut(BALLS).enumerate() {
            let own = batch * BALLS..batch * BALLS + out.len();
            tube.locals(at.map(|at| &at[own.clone()]), &radius[own.clone()], out);
        }
    }

    fn error(&self, _: f64) -> [f64; 3] {
        // Known of each ball only.
        [f64::INFINITY; 3]
    }
}
