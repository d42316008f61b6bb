//! What becomes of a ball that a flow carries along.
//!
//! A trajectory starts in the middle of the ball of radius `r`; another one, that starts `e` away, is `d_s` away from it at
//! stage `s` of a step, where the velocity is
//!
//! ```text
//! u(y_s + d_s) = u(y_s) + J_s d_s + b_s          b_s = d_s^T H_s d_s / 2 + c_s
//! ```
//!
//! The steps are linear in positions and velocities. So, exactly, what becomes of the ball is what becomes of it by the
//! `J_s` alone, and each `b_s` carried on by those behind it. Seen by a field with gradient `g` at the end, that is
//!
//! ```text
//! f(end) - f(middle) = (P^T g) . e + sum_s l_s . b_s + (what f itself departs by)
//! ```
//!
//! with `l_s` the covector that the velocity of a stage matters by, which comes back from the end through the transposed
//! `J_s` (the adjoint of the method: back through a step from `p`, with shares of `h`,
//! `l4 = p/6`, `l3 = p/3 + J4^T l4`, `l2 = p/3 + J3^T l3 / 2`, `l1 = p/6 + J2^T l2 / 2`, and `p + sum J_s^T l_s` before it).
//!
//! **Radii.** `|d_s| <= rho_s`, from the linear part `P_s` and a bound `eta_s` on what it leaves out, step by step:
//! `rho = |P| r + eta`, `eta <- |M| eta + q`, where `M` is the linear part of a step and `q` bounds what the `b_s` in it come to.
//!
//! **To second order** `d_s` is `P_s e` but for `eta_s`. The quadratic forms add up to the second derivatives of the flowed
//! field in the middle; only what they leave out is bounded by norms:
//!
//! ```text
//! Q = sum_s P_s^T (l_s . H_s) P_s          |l_s . b_s - form| <= |l_s| |c_s| + |l_s . H_s| (2 rho_s + eta_s) eta_s / 2
//! ```
//!
//! **Derivatives** anywhere in the ball: the covectors there differ from those in the middle by no more than `v`, which
//! comes back in the same way, fed by how much `J_s` varies over its ball; the second derivatives are then at most
//! `sum_s (|l_s| + v_s) |H_s| W_s^2`, where `W_s` bounds the derivative of a stage by the start all over the ball.
//!
//! All of it is for the map as it would be without rounding. What velocities, slopes and places in the middle may be off by
//! is carried along (`off`, `blur`), and counts among what linear parts leave out.

use super::Code;
use super::matrix::{Matrix, ONE, UP, Vector, length, matrix, norm, times, vector};
use super::pack::{BALLS, Pack};
use super::sight::seen_back;
use super::stage::{KnownKernel, Parts, Rounding, Stage};
use crate::num::{Local, Number, ROUNDOFF, Taylors, widest};
use std::cell::Cell;

/// Where the points of a ball are within a step.
#[derive(Clone, Copy, Default)]
struct Place {
    at: Vector,
    radius: Pack,
    /// Derivative by the point at the step's start, and what it leaves out.
    linear: Matrix,
    rest: Pack,
    /// What the middle may be off by, what of that is due to this place alone, and what the derivative may be off by.
    off: Pack,
    rounding: Pack,
    blur: Pack,
    /// Bounds on the first and second derivatives by the point at the step's start.
    steep: Pack,
    bent: Pack,
    /// Zero where the radius shrinks with that at the step's start, else infinite.
    loose: Pack,
}

/// What velocities add, over time: their sum, its linear part, what that leaves out, how far it may be from the one
/// in the middle, what it and the linear part may be off by, bounds on its first and second derivatives, and the sum
/// of the speeds.
#[derive(Clone, Copy, Default)]
struct Change {
    velocity: Vector,
    linear: Matrix,
    rest: Pack,
    spread: Pack,
    /// The same without what is known of all of space.
    goes: Pack,
    off: Pack,
    blur: Pack,
    steep: Pack,
    bent: Pack,
    speed: Pack,
}

impl Change {
    #[inline(always)]
    fn new(stage: &Stage, place: &Place) -> Change {
        let steep = stage.steep * place.steep;
        // The slope at the middle is computed where that is computed to be.
        let blur = stage.blur + stage.turned(place.off);
        Change {
            velocity: stage.velocity,
            linear: times(&stage.slope, &place.linear),
            rest: stage.steep * place.rest + stage.bow,
            spread: stage.spread,
            goes: stage.steep * place.radius,
            // Where the middle would be without rounding is in the ball as well.
            off: (stage.steep * place.off).least(stage.spread) + stage.off,
            blur: blur * place.steep + stage.steep * place.blur + 16.0 * ROUNDOFF * steep,
            steep,
            bent: stage.bent * place.steep * place.steep + stage.steep * place.bent,
            speed: length(&stage.velocity),
        }
    }

    #[inline(always)]
    fn add(&mut self, k: f64, o: &Change) {
        let (velocity, linear) = (self.velocity, self.linear);
        self.velocity = vector(
            #[inline(always)]
            |i| velocity[i] + k * o.velocity[i],
        );
        self.linear = matrix(
            #[inline(always)]
            |i, j| linear[i][j] + k * o.linear[i][j],
        );
        self.rest += k * o.rest;
        self.spread += k * o.spread;
        self.goes += k * o.goes;
        self.off += k * o.off;
        self.blur += k * o.blur;
        self.steep += k * o.steep;
        self.bent += k * o.bent;
        self.speed += k * o.speed;
    }
}

/// The state of a trajectory between steps.
#[derive(Clone, Copy)]
pub(super) struct Ball {
    pub at: Vector,
    /// `P`, and what it leaves out.
    pub linear: Matrix,
    pub rest: Pack,
    /// Radius of the ball at the start, and now.
    pub start: Pack,
    pub radius: Pack,
    /// Bounds on first and second derivatives by the point at the start.
    pub steep: Pack,
    pub bent: Pack,
    /// What the middle and `P` may be off by.
    pub off: Pack,
    pub blur: Pack,
    /// Zero where the radius shrinks with that at the start, and all that is left out with its square, else infinite.
    pub loose: Pack,
}

/// A stage of a step, as the way back needs it.
#[derive(Clone, Copy, Default)]
pub(super) struct Past {
    /// The velocity there.
    pub stage: Stage,
    /// Derivative of the place by the start.
    pub linear: Matrix,
    /// What rounding of the place adds to what expansions of the velocity leave out; what the quadratic one leaves out
    /// besides for each of the second derivative, since points are not quite where `linear` says.
    pub moved: Pack,
    pub cross: Pack,
    /// The largest second derivative by the start.
    pub bent: Pack,
}

/// A step, as the way back needs it.
#[derive(Clone, Copy, Default)]
pub(super) struct Step {
    pub stages: [Past; 4],
    /// What its end may be off by, and what rounding on the way back adds to what is left out.
    pub off: Pack,
    pub rounding: Pack,
    /// Its largest derivative, and how much that varies.
    pub steep: Pack,
    pub turn: Pack,
}

impl Place {
    /// How far derivatives may be from the one in the middle so far from the step's start.
    #[inline(always)]
    fn turned(&self, reach: Pack) -> Pack {
        (self.bent * reach).least(2.0 * self.steep)
    }
}

impl Past {
    /// Sets what follows from where the stage is.
    #[inline(always)]
    fn place(&mut self, ball: &Ball, place: &Place) {
        let rest = norm(&place.linear) * ball.rest + place.rest;
        self.linear = times(&place.linear, &ball.linear);
        let bent = UP * (place.bent * ball.steep * ball.steep + place.steep * ball.bent);
        let blur = place.blur * ball.steep + place.steep * ball.blur;
        let steep = UP * (place.steep * ball.steep).least(norm(&self.linear) + bent * ball.start + blur);
        self.moved = self.stage.steep * place.rounding;
        self.cross = 0.5 * UP * ((2.0 * place.radius + rest) * rest);
        self.bent = UP * (self.stage.bent * steep * steep);
    }
}

impl Ball {
    #[inline(always)]
    fn new(at: Vector, radius: Pack) -> Ball {
        let (zero, one) = (Pack::ZERO, Pack::ONE);
        Ball {
            at,
            linear: ONE,
            rest: zero,
            start: radius,
            radius,
            steep: one,
            bent: zero,
            off: zero,
            blur: zero,
            loose: zero,
        }
    }

    /// The place of a stage: so much time after the start, at the velocity of the stage before.
    #[inline(always)]
    fn place(&self, time: f64, change: &Change) -> Place {
        let radius = self.radius;
        let at = vector(
            #[inline(always)]
            |i| self.at[i] + time * change.velocity[i],
        );
        let linear = matrix(
            #[inline(always)]
            |i, j| ONE[i][j] + time * change.linear[i][j],
        );
        let rounding = 4.0 * ROUNDOFF * (length(&self.at) + time * change.speed);
        let steep = UP * (Pack::ONE + time * change.steep);
        let linear_rounding = 32.0 * ROUNDOFF * steep;
        let rest = UP * (time * change.rest + rounding + linear_rounding * radius);
        let off = UP * (time * change.off + rounding);
        let scaled = (norm(&linear) * radius + rest).least(radius + time * change.goes + off);
        let (reached, loose) = scaled.least_or_loose(radius + time * change.spread + off);
        Place {
            at,
            radius: UP * reached,
            loose,
            linear,
            rest,
            off,
            rounding,
            blur: UP * (time * change.blur + linear_rounding),
            steep,
            bent: time * UP * change.bent,
        }
    }

    /// Moves the ball to where it is after a step of length `h`, and completes the step.
    #[inline(always)]
    fn advance(&mut self, h: f64, [k1, k2, k3, k4]: &[Change; 4], step: &mut Step) {
        let mut sum = Change::default();
        sum.add(h / 6.0, k1);
        sum.add(h / 3.0, k2);
        sum.add(h / 3.0, k3);
        sum.add(h / 6.0, k4);
        let end = self.place(1.0, &sum);
        let own = norm(&end.linear);
        let turn = UP * (end.blur + end.turned(self.radius));
        let jacobian = UP * end.steep.least(own + turn);
        let linear = times(&end.linear, &self.linear);
        let stretch = norm(&linear);
        let rest = UP * (own * self.rest + end.rest);
        let bent = UP * (jacobian * self.bent + end.bent * self.steep * self.steep);
        let lost = end.blur + end.turned(self.off) + 16.0 * ROUNDOFF * end.steep;
        let off = UP * (jacobian * self.off + end.off);
        let blur = UP * (jacobian * self.blur + lost * self.steep);
        let steep = UP * (jacobian * self.steep).least(stretch + blur + bent * self.start);
        let start = self.start;
        let by_norms = (stretch * start + rest).least(steep * start + off);
        let (radius, loose) = (UP * by_norms).least_or_loose(UP * end.radius);
        let loose = loose.least(end.loose);
        // The covector that comes back through the step is rounded some hundred times.
        let rounding = end.rounding + 256.0 * ROUNDOFF * (end.steep * self.radius);
        (step.off, step.rounding, step.steep, step.turn) = (end.off, rounding, jacobian, turn);
        (self.at, self.linear, self.rest, self.radius) = (end.at, linear, rest, radius);
        (self.steep, self.bent, self.off, self.blur) = (steep, bent, off, blur);
        self.loose += loose;
    }
}

/// What is known of a field over balls, after a velocity has carried them along.
pub(super) struct Tube<'a, V: Code<3>, F> {
    velocity: &'a V,
    parts: Known<'a, V::Part>,
    field: &'a F,
    steps: u32,
    /// What both are off by at points not further than 1, where they do not say.
    rounding: [Rounding; 2],
}

/// What a velocity is made of, with what holds for all balls.
enum Known<'a, K> {
    Nothing,
    Kernels([KnownKernel<'a, K>; 3]),
    Slope(KnownKernel<'a, K>),
}

thread_local! {
    /// Steps to write on: a dozen kilobytes each, not worth clearing for each batch of balls.
    static STEPS: Cell<Vec<Step>> = const { Cell::new(Vec::new()) };
}

/// The smallest radius, relative to the size of the coordinates: rounding is what such balls are made of.
const SPECK: f64 = 1e-14;

impl<'a, V: Code<3>, F: Code<1>> Tube<'a, V, F> {
    pub fn new(velocity: &'a V, field: &'a F, steps: u32, rounding: [Rounding; 2]) -> Self {
        let parts = match velocity.parts() {
            Parts::Any => Known::Nothing,
            Parts::Kernels(parts) => Known::Kernels(parts.map(|(kernel, k)| KnownKernel::new(kernel, k))),
            Parts::Slope(kernel, k) => Known::Slope(KnownKernel::new(kernel, k)),
        };
        Tube { velocity, parts, field, steps, rounding }
    }

    /// The field over as many balls as `out` has entries, 8 at most and one at least, with what its jets in the middle may
    /// be off by.
    pub fn locals(&self, at: [&[f64]; 3], radius: &[f64], out: &mut [(Local, [f64; 3])]) {
        // Lanes to spare repeat the last one.
        let last = out.len() - 1;
        let middle = at.map(|at| Pack::from_fn(|i| at[i.min(last)]));
        let size = middle.iter().fold(Pack::ONE, |size, x| size.larger(x.abs()));
        let start = Ball::new(middle, Pack::from_fn(|i| radius[i.min(last)]).larger(SPECK * size));
        let mut steps = STEPS.take();
        let (ball, moves) = self.followed(start, size, &mut steps);
        // Lanes that do not move are where they were, and have taken no steps.
        let own = |i: usize| if moves[i] { &ball } else { &start };
        let mut numbers = [Taylors::<BALLS>::constant(0.0); 3];
        for i in 0..BALLS {
            Taylors::set_ball(&mut numbers, i, own(i).at.map(|x| x.0[i]), own(i).radius.0[i]);
        }
        let [values] = self.field.runner::<Taylors<BALLS>>()(&numbers);
        let (h, rounding) = (1.0 / f64::from(self.steps), self.rounding[1].at(size));
        let seen = |ball: &Ball, steps: &[Step]| {
            widest(
                #[inline(always)]
                || seen_back(&values, ball, (h, steps), rounding),
            )
        };
        let moved = moves.contains(&true).then(|| seen(&ball, &steps[..self.steps as usize]));
        let still = moves.contains(&false).then(|| seen(&start, &[]));
        for (i, out) in out.iter_mut().enumerate() {
            let own = if moves[i] { &moved } else { &still };
            if let Some(seen) = own {
                *out = seen.local(i);
            }
        }
        STEPS.set(steps);
    }

    /// Where balls come to, and which of them move, with the steps on the way; nothing is said of those that do not move.
    fn followed(&self, start: Ball, size: Pack, steps: &mut Vec<Step>) -> (Ball, [bool; BALLS]) {
        let h = 1.0 / f64::from(self.steps);
        let mut run = self.velocity.runner::<Taylors<BALLS>>();
        if steps.len() < self.steps as usize {
            steps.resize_with(self.steps as usize, Step::default);
        }
        let (mut ball, mut moves) = (start, [true; BALLS]);
        let (mut changes, mut place) = ([Change::default(); 4], Place::default());
        for (number, step) in steps.iter_mut().take(self.steps as usize).enumerate() {
            for stage in 0..4 {
                let time = [0.0, 0.5, 0.5, 1.0][stage] * h;
                let past = &mut step.stages[stage];
                widest(
                    #[inline(always)]
                    || {
                        let still = Change::default();
                        place = ball.place(time, if stage == 0 { &still } else { &changes[stage - 1] });
                    },
                );
                self.stage(&place, size, &mut run, &mut past.stage);
                if number == 0 && stage == 0 {
                    moves = past.stage.moves();
                    if moves == [false; BALLS] {
                        return (start, moves);
                    }
                }
                widest(
                    #[inline(always)]
                    || {
                        changes[stage] = Change::new(&past.stage, &place);
                        past.place(&ball, &place);
                    },
                );
                ball.loose += place.loose + past.stage.loose;
            }
            widest(
                #[inline(always)]
                || ball.advance(h, &changes, step),
            );
        }
        (ball, moves)
    }
}

impl<V: Code<3>, F> Tube<'_, V, F> {
    /// The velocity at a place.
    fn stage(
        &self,
        place: &Place,
        size: Pack,
        run: &mut impl FnMut(&[Taylors<BALLS>; 3]) -> [Taylors<BALLS>; 3],
        out: &mut Stage,
    ) {
        match &self.parts {
            Known::Kernels(parts) => out.set_kernels(parts, &place.at, place.radius),
            Known::Slope(part) => out.set_slope(part, &place.at, place.radius),
            Known::Nothing => {
                let mut numbers = [Taylors::<BALLS>::constant(0.0); 3];
                for i in 0..BALLS {
                    Taylors::set_ball(&mut numbers, i, place.at.map(|x| x.0[i]), place.radius.0[i]);
                }
                let (u, is_gradient) = (run(&numbers), self.velocity.is_gradient());
                widest(
                    #[inline(always)]
                    || out.set(&u, place.radius, is_gradient, self.rounding[0].at(size)),
                );
            }
        }
    }
}
