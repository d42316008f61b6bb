//! What becomes of a ball that a flow carries along.
//!
//! A trajectory starts in the middle of the ball of radius `r0`; another one, that starts `e` away, is
//!
//! ```text
//! P e + s      |s| <= s_k      P = M_k ... M_1      s_(k+1) <= |M_k| s_k + q_k
//! ```
//!
//! away after `k` steps. `M_k` is the derivative of a step on the middle trajectory, and `q_k` bounds what it leaves
//! out of the step, and of the four velocities in it, over the ball that the points are in by then: of radius
//! `|P| r0 + s_k`. So the linear part is what it is, turned and stretched by each step in turn; only the rest is
//! bounded by norms. A field with gradient `g` at the end, that departs from it by `b` over the last ball, departs over
//! the first one from the gradient `P^T g` by
//!
//! ```text
//! b + sum_k |p_(k+1)| q_k      p_k = M_k^T p_(k+1)      p_N = g
//! ```
//!
//! since what is lost in a step is seen through all the steps behind it, in the direction that matters to the field.
//! Sharper than stretching by the largest eigenvalue of the velocity's slope all the way (8.1 of the notes on flow
//! mapping), and as certain, for the steps themselves are the map.
//!
//! First and second derivatives over the ball follow by norms: with `J` and `H` bounding those of a step,
//!
//! ```text
//! W <- J W      Z <- J Z + H W^2      |grad F| <= |grad f| W      |Hess F| <= |grad f| Z + |Hess f| W^2
//! ```

use super::Code;
use super::stage::{Matrix, Parts, Stage, of_kernels, of_slope};
use crate::num::{Bounds, Interval, Local, Number, Point, ROUNDOFF, Taylor, Taylors, widest};

/// Covers the rounding of sums of up to a hundred terms that are not negative.
pub(super) const UP: f64 = 1.0 + 256.0 * ROUNDOFF;

/// What values and gradients that are computed at a point may be off by.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rounding {
    pub value: f64,
    pub grad: f64,
}

const ONE: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// `a + k b c`.
#[inline(always)]
fn fused(a: &Matrix, k: f64, b: &Matrix, c: &Matrix) -> Matrix {
    let mut out = *a;
    for i in 0..3 {
        for j in 0..3 {
            out[i][j] += k * (b[i][0] * c[0][j] + b[i][1] * c[1][j] + b[i][2] * c[2][j]);
        }
    }
    out
}

#[inline(always)]
fn transposed_times(m: &Matrix, v: [f64; 3]) -> [f64; 3] {
    let mut out = [0.0; 3];
    for j in 0..3 {
        out[j] = m[0][j] * v[0] + m[1][j] * v[1] + m[2][j] * v[2];
    }
    out
}

/// Length, rounded up.
#[inline(always)]
pub(super) fn length([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt() * UP
}

#[inline(always)]
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if a >= b { a } else { b }
}

/// The smaller of two bounds. One that is no number, as what is unbounded times zero, bounds nothing.
#[inline(always)]
pub(super) fn least(a: f64, b: f64) -> f64 {
    if a <= b || b.is_nan() { a } else { b }
}

/// Bound on the spectral norm: the root of the largest eigenvalue of `A A^T`. With `m` the mean of its eigenvalues, and
/// `x = m + t`, these are the roots of `t^3 - s t - d`, of which none lies above the start; from there Newton's method
/// comes down towards the largest and never passes it, since the cubic is convex there.
#[inline(always)]
fn norm(a: &Matrix) -> f64 {
    let mut b = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            b[i][j] = a[i][0] * a[j][0] + a[i][1] * a[j][1] + a[i][2] * a[j][2];
        }
    }
    let trace = b[0][0] + b[1][1] + b[2][2];
    let m = trace / 3.0;
    let [xx, yy, zz] = [b[0][0] - m, b[1][1] - m, b[2][2] - m];
    let [xy, xz, yz] = [b[0][1], b[0][2], b[1][2]];
    let s = 0.5 * (xx * xx + yy * yy + zz * zz) + xy * xy + xz * xz + yz * yz;
    let d = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
    let mut t = (4.0 / 3.0 * s).sqrt();
    for _ in 0..3 {
        let slope = 3.0 * t * t - s;
        let value = (t * t - s) * t - d;
        let step = if slope > 0.0 && value > 0.0 { value / slope } else { 0.0 };
        t -= step;
    }
    // Rounding of the entries, of the cubic and of what is found from it: relative to the sum of squares.
    ((m + t).max(0.0) + 256.0 * ROUNDOFF * trace).sqrt() * UP
}

/// Where the points of a ball are within a step.
#[derive(Clone, Copy)]
struct Place {
    at: [f64; 3],
    radius: f64,
    /// Derivative by the point at the step's start, and what it leaves out.
    linear: Matrix,
    rest: f64,
    /// What the middle may be off by.
    off: f64,
    /// Bounds on the first and second derivatives by the point at the step's start.
    steep: f64,
    bent: f64,
}

/// What a velocity at a place adds, over time: its linear part, what that leaves out, how far it may be from the one in
/// the middle, what that may be off by, and bounds on its first and second derivatives.
#[derive(Clone, Copy, Default)]
struct Change {
    velocity: [f64; 3],
    linear: Matrix,
    rest: f64,
    spread: f64,
    off: f64,
    steep: f64,
    bent: f64,
}

impl Change {
    #[inline(always)]
    fn new(stage: &Stage, place: &Place, rounding: Rounding) -> Change {
        Change {
            velocity: stage.velocity,
            linear: fused(&[[0.0; 3]; 3], 1.0, &stage.slope, &place.linear),
            rest: stage.steep * place.rest + stage.bow,
            spread: stage.spread,
            off: stage.steep * place.off + rounding.value,
            steep: stage.steep * place.steep,
            bent: stage.bent * place.steep * place.steep + stage.steep * place.bent,
        }
    }

    #[inline(always)]
    fn add(&mut self, k: f64, o: &Change) {
        for i in 0..3 {
            self.velocity[i] += k * o.velocity[i];
            for j in 0..3 {
                self.linear[i][j] += k * o.linear[i][j];
            }
        }
        self.rest += k * o.rest;
        self.spread += k * o.spread;
        self.off += k * o.off;
        self.steep += k * o.steep;
        self.bent += k * o.bent;
    }
}

/// The state of a trajectory between steps.
#[derive(Clone, Copy)]
struct Ball {
    at: [f64; 3],
    /// `P`, and what it leaves out.
    linear: Matrix,
    rest: f64,
    /// Radius of the ball at the start, and now.
    start: f64,
    radius: f64,
    /// Bounds on first and second derivatives by the point at the start, and what the computed first ones are off by.
    steep: f64,
    bent: f64,
    off: f64,
}

/// A step, as the way back needs it.
#[derive(Clone, Copy)]
struct Step {
    linear: Matrix,
    rest: f64,
    off: f64,
}

impl Ball {
    #[inline(always)]
    fn new(at: [f64; 3], radius: f64) -> Ball {
        Ball { at, linear: ONE, rest: 0.0, start: radius, radius, steep: 1.0, bent: 0.0, off: 0.0 }
    }

    /// The place of a stage: so much time after the start, at the velocity of the stage before.
    #[inline(always)]
    fn place(&self, time: f64, change: &Change) -> Place {
        let radius = self.radius;
        let mut at = self.at;
        let mut linear = ONE;
        for i in 0..3 {
            at[i] += time * change.velocity[i];
            for j in 0..3 {
                linear[i][j] += time * change.linear[i][j];
            }
        }
        let rounding = 4.0 * ROUNDOFF * (length(self.at) + time * length(change.velocity));
        let linear_rounding = 32.0 * ROUNDOFF * (1.0 + time * change.steep);
        let rest = (time * change.rest + rounding + linear_rounding * radius) * UP;
        let steep = (1.0 + time * change.steep) * UP;
        Place {
            at,
            radius: least(
                norm(&linear) * radius + rest,
                least(steep * radius, radius + time * change.spread) + rounding,
            ) * UP,
            linear,
            rest,
            off: (time * change.off + rounding) * UP,
            steep,
            bent: time * change.bent * UP,
        }
    }

    /// The ball after a step of length `h`.
    #[inline(always)]
    fn after(&self, h: f64, [k1, k2, k3, k4]: &[Change; 4], rounding: Rounding) -> (Ball, Step) {
        let mut sum = Change::default();
        sum.add(h / 6.0, k1);
        sum.add(h / 3.0, k2);
        sum.add(h / 3.0, k3);
        sum.add(h / 6.0, k4);
        let end = self.place(1.0, &sum);
        let jacobian = least(end.steep, norm(&end.linear) + end.bent * self.radius) * UP;
        let linear = fused(&[[0.0; 3]; 3], 1.0, &end.linear, &self.linear);
        let rest = (norm(&end.linear) * self.rest + end.rest) * UP;
        let steep = jacobian * self.steep * UP;
        let lost = h * rounding.grad * end.steep + 64.0 * ROUNDOFF * end.steep + end.bent * end.off;
        let ball = Ball {
            at: end.at,
            linear,
            rest,
            start: self.start,
            radius: least(end.radius, least(norm(&linear) * self.start + rest, steep * self.start)) * UP,
            steep,
            bent: (jacobian * self.bent + end.bent * self.steep * self.steep) * UP,
            off: (jacobian * self.off + lost * self.steep) * UP,
        };
        (ball, Step { linear: end.linear, rest: end.rest, off: end.off })
    }
}

/// What is known of a field over `B` balls, after a velocity has carried them along.
pub(super) struct Tube<'a, V, F> {
    pub velocity: &'a V,
    pub field: &'a F,
    pub steps: u32,
    /// Roundings of both, for points not further than 1.
    pub rounding: [Rounding; 2],
}

/// The smallest radius, relative to the size of the coordinates: rounding is what such balls are made of.
const SPECK: f64 = 1e-14;

impl<V: Code<3>, F: Code<1>> Tube<'_, V, F> {
    /// The field over balls, with what its jets in the middle may be off by.
    pub fn locals<const B: usize>(&self, at: &[[f64; 3]; B], radius: &[f64; B]) -> [(Local, [f64; 3]); B] {
        let h = 1.0 / f64::from(self.steps);
        let size = |i: usize| 1.0_f64.max(at[i][0].abs()).max(at[i][1].abs()).max(at[i][2].abs());
        let mut balls: [Ball; B] = std::array::from_fn(|i| Ball::new(at[i], radius[i].max(SPECK * size(i))));
        let mut run = self.velocity.runner::<Taylors<B>>();
        let mut numbers = [Taylors::<B>::constant(0.0); 3];
        let mut steps: Vec<[Step; B]> = Vec::with_capacity(self.steps as usize);
        let rounding = |i: usize, k: usize| Rounding {
            value: self.rounding[k].value * size(i),
            grad: self.rounding[k].grad * size(i),
        };
        'steps: for step in 0..self.steps {
            let mut changes = [[Change::default(); 4]; B];
            let mut known = [Stage::default(); B];
            for stage in 0..4 {
                let time = [0.0, 0.5, 0.5, 1.0][stage] * h;
                let mut places = [Place {
                    at: [0.0; 3],
                    radius: 0.0,
                    linear: ONE,
                    rest: 0.0,
                    off: 0.0,
                    steep: 1.0,
                    bent: 0.0,
                }; B];
                for i in 0..B {
                    let before = if stage == 0 { Change::default() } else { changes[i][stage - 1] };
                    places[i] = balls[i].place(time, &before);
                }
                self.stages(&places, &rounding, &mut run, &mut numbers, &mut known);
                if step == 0 && stage == 0 && known.iter().all(Stage::is_still) {
                    break 'steps;
                }
                for i in 0..B {
                    changes[i][stage] = Change::new(&known[i], &places[i], rounding(i, 0));
                }
            }
            let mut taken = [Step { linear: ONE, rest: 0.0, off: 0.0 }; B];
            widest(
                #[inline(always)]
                || {
                    for i in 0..B {
                        (balls[i], taken[i]) = balls[i].after(h, &changes[i], rounding(i, 0));
                    }
                },
            );
            steps.push(taken);
        }
        for i in 0..B {
            Taylors::set_ball(&mut numbers, i, balls[i].at, balls[i].radius);
        }
        let [values] = self.field.runner::<Taylors<B>>()(&numbers);
        std::array::from_fn(|i| {
            let way = steps.iter().rev().map(|steps| &steps[i]);
            seen_back(&values.lane(i), &balls[i], way, rounding(i, 1))
        })
    }
}

impl<V: Code<3>, F> Tube<'_, V, F> {
    /// The velocity at the places of a stage.
    fn stages<const B: usize>(
        &self,
        places: &[Place; B],
        rounding: &impl Fn(usize, usize) -> Rounding,
        run: &mut impl FnMut(&[Taylors<B>; 3]) -> [Taylors<B>; 3],
        numbers: &mut [Taylors<B>; 3],
        out: &mut [Stage; B],
    ) {
        let at: [[f64; B]; 3] = std::array::from_fn(|axis| std::array::from_fn(|i| places[i].at[axis]));
        let radius: [f64; B] = std::array::from_fn(|i| places[i].radius);
        match self.velocity.parts() {
            Parts::Kernels(parts) => of_kernels(&parts, &at, &radius, out),
            Parts::Slope(kernel, k) => of_slope(kernel, k, &at, &radius, out),
            Parts::Any => {
                for i in 0..B {
                    Taylors::set_ball(numbers, i, places[i].at, radius[i]);
                }
                let u = run(numbers);
                for i in 0..B {
                    let u = [u[0].lane(i), u[1].lane(i), u[2].lane(i)];
                    out[i] = Stage::new(&u, radius[i], self.velocity.is_gradient(), rounding(i, 0));
                }
            }
        }
    }
}

/// A field at the end of a trajectory as it looks from the start; see the module text.
fn seen_back<'a>(
    f: &Taylor,
    ball: &Ball,
    way: impl Iterator<Item = &'a Step>,
    rounding: Rounding,
) -> (Local, [f64; 3]) {
    let (scale, r) = (1.0 / ball.radius, ball.start);
    let (steep, bent) = (f.steepness() * scale, f.curvature() * scale * scale);
    let mut p = f.grad.map(|g| g * scale);
    let (mut bow, mut off) = (f.bow[0], rounding.value);
    for step in way {
        bow += length(p) * step.rest;
        off += length(p) * step.off;
        p = transposed_times(&step.linear, p);
    }
    bow = (bow + 8.0 * ROUNDOFF * length(p) * r) * UP;
    let hessian = (steep * ball.bent + bent * ball.steep * ball.steep) * UP;
    // Without a bound on second derivatives the gradient serves the bow alone, which holds for it as it is computed.
    let grad_off = (steep * ball.off + rounding.grad * ball.steep + bent * off * ball.steep) * UP;
    let grad_off = if hessian.is_finite() { grad_off } else { 0.0 };
    let own = length(p);
    let lipschitz = least(steep * ball.steep, own + hessian * r + grad_off) * UP;
    // All of the last ball may say more than the gradient; then that is taken for zero, and may be off by all of itself.
    let spread = larger(f.range.hi - f.value, f.value - f.range.lo);
    let is_far = spread < own * r + bow;
    let (grad, bow) = if is_far { ([0.0; 3], spread) } else { (p, bow) };
    // No two gradients differ by more than their lengths; twice that, since half of it times the radius must bound the bow.
    let hessian = if is_far { 2.0 * lipschitz / r } else { least(hessian, 2.0 * (lipschitz + own) / r) } * UP;
    let jet = Point { value: f.value, grad, hess: [0.0; 6] };
    // The range is that of the bow, which need not have zero in its middle.
    let bounds = Bounds { range: f64::INFINITY, lipschitz, hessian, third: f64::INFINITY };
    (Local { jet, bounds, bow: Interval::radius(bow) }, [off * UP, grad_off, 0.0])
}
