//! What is known of a velocity over balls.
//!
//! Any velocity says so by Taylor expansions. Most are noises, though, with a factor, at the point itself, or the slope of
//! one: these are asked directly, many balls at a time, which is several times quicker. With `H` the second derivatives
//! of a noise in the middle of a ball of radius `r`, and `M2`, `M3` its bounds,
//!
//! ```text
//! a component      slope k g    bow k min(M2 r^2 / 2, |H| r^2 / 2 + M3 r^3 / 6)
//! a slope          slope k H    bow k M3 r^2 / 2
//! ```
//!
//! The derivatives of a slope are a symmetric matrix, of which these are bounds as a whole.

use super::matrix::{Matrix, Symmetric, UP, Vector, length, norm, six, spread, vector};
use super::pack::{BALLS, Pack};
use crate::num::{Bounds, Growing, Jets, Kernel, ROUNDOFF, Taylors, widest};

/// What values that are computed at a point may be off by, and gradients as a share of how steep it is there and mostly is
/// together.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rounding {
    pub value: f64,
    pub grad: f64,
    pub mostly: f64,
}

/// The same for many points.
#[derive(Clone, Copy)]
pub(super) struct Roundings {
    pub value: Pack,
    grad: Pack,
    mostly: Pack,
}

impl Roundings {
    /// What gradients may be off by where it is so steep.
    #[inline(always)]
    pub fn of_grad(self, steep: Pack) -> Pack {
        self.grad * (self.mostly + steep)
    }
}

impl Rounding {
    /// From what it is at points not further than 1, for points not further than `size`.
    #[inline(always)]
    pub fn at(self, size: Pack) -> Roundings {
        Roundings { value: self.value * size, grad: self.grad * size, mostly: self.mostly * Pack::ONE }
    }
}

/// What a velocity is made of.
#[derive(Debug)]
pub enum Parts<'a, K> {
    /// Anything.
    Any,
    /// Three kernels at the point, with factors.
    Kernels([(&'a K, f64); 3]),
    /// The slope of a kernel at the point, with a factor.
    Slope(&'a K, f64),
}

/// A kernel with its factor, and what holds for all balls.
pub(super) struct KnownKernel<'a, K> {
    kernel: &'a K,
    factor: f64,
    bounds: Bounds,
    growing: Growing,
}

impl<'a, K: Kernel> KnownKernel<'a, K> {
    pub fn new(kernel: &'a K, factor: f64) -> Self {
        KnownKernel { kernel, factor, bounds: kernel.bounds(), growing: Growing::new(kernel) }
    }
}

/// A velocity over balls.
#[derive(Clone, Copy, Default)]
pub(super) struct Stage {
    pub velocity: Vector,
    pub slope: Matrix,
    /// Second derivatives of its components, where they say anything.
    pub hess: Option<[Symmetric; 3]>,
    /// What `slope` leaves out of the velocity over the ball, and what is left out with second derivatives.
    pub bow: Pack,
    pub rest: Pack,
    /// How far the velocity may be from the one in the middle.
    pub spread: Pack,
    /// Bounds on first and second derivatives over the ball, and on how far first ones may be from `slope`.
    pub steep: Pack,
    pub bent: Pack,
    pub turn: Pack,
    /// What the velocity and the slope in the middle may be off by.
    pub off: Pack,
    pub blur: Pack,
    /// Whether `bow` and `rest` shrink with the square of the ball, but for rounding: else infinite.
    pub loose: Pack,
}

impl Stage {
    /// Where anything moves.
    pub fn moves(&self) -> [bool; BALLS] {
        let still = |i: usize| self.velocity.iter().all(|v| v.0[i] == 0.0) && self.spread.0[i] == 0.0;
        std::array::from_fn(|i| !still(i))
    }

    /// How far slopes may be from the one in the middle so far from it, within the ball.
    #[inline(always)]
    pub fn turned(&self, reach: Pack) -> Pack {
        (self.bent * reach).least(self.turn)
    }

    /// From what is known of the components. A gradient has the same bounds on all its components for what their
    /// expansions leave out, which are bounds on the symmetric matrix of its derivatives as a whole; what is rounded is not.
    #[inline(always)]
    pub fn set(&mut self, u: &[Taylors<BALLS>; 3], radius: Pack, is_gradient: bool, rounding: Roundings) {
        let (out, scale) = (self, radius.inverse());
        let (mut bow, mut rest, mut spread) = ([Pack::ZERO; 3], [Pack::ZERO; 3], [Pack::ZERO; 3]);
        let (mut turn, mut bent) = ([Pack::ZERO; 3], [Pack::ZERO; 3]);
        let mut hess = [[Pack::ZERO; 6]; 3];
        for i in 0..3 {
            let lanes: [_; BALLS] = std::array::from_fn(|l| u[i].lane(l));
            out.velocity[i] = Pack::from_fn(|l| lanes[l].value);
            for j in 0..3 {
                out.slope[i][j] = scale * Pack::from_fn(|l| lanes[l].grad[j]);
            }
            for k in 0..6 {
                hess[i][k] = scale * scale * Pack::from_fn(|l| lanes[l].hess[k]);
            }
            bow[i] = Pack::from_fn(|l| lanes[l].bow[0]);
            rest[i] = Pack::from_fn(|l| lanes[l].bow[1]);
            let above = Pack::from_fn(|l| lanes[l].range.hi - lanes[l].value);
            spread[i] = above.larger(Pack::from_fn(|l| lanes[l].value - lanes[l].range.lo));
            turn[i] = Pack::from_fn(|l| lanes[l].turn[0]);
            bent[i] = Pack::from_fn(|l| lanes[l].curvature());
        }
        out.hess = Some(hess);
        let (own, turn) = (norm(&out.slope), scale * all(&turn, is_gradient));
        out.blur = 2.0 * UP * rounding.of_grad(own + turn);
        out.off = 2.0 * rounding.value;
        let rounded = out.off + out.blur * radius;
        out.bow = all(&bow, is_gradient) + rounded;
        out.rest = all(&rest, is_gradient) + rounded;
        out.spread = length(&spread);
        out.turn = turn + out.blur;
        out.steep = UP * (own + out.turn);
        out.bent = scale * scale * all(&bent, is_gradient);
        out.loose = f64::INFINITY * Pack::ONE;
    }
}

/// A bound on all three components, which is one on each where they are a gradient.
#[inline(always)]
fn all(rows: &Vector, is_gradient: bool) -> Pack {
    if is_gradient { rows[0].larger(rows[1]).larger(rows[2]) } else { length(rows) }
}

/// Jets of a kernel in the middles of balls.
struct Middles {
    value: Pack,
    grad: Vector,
    hess: Symmetric,
    /// The largest coordinates.
    size: Pack,
}

impl Middles {
    fn new<K: Kernel>(kernel: &K, at: &Vector) -> Self {
        let size = at[0].abs().larger(at[1].abs()).larger(at[2].abs());
        let (value, grad, hess) = (Pack::ZERO, [Pack::ZERO; 3], [Pack::ZERO; 6]);
        let mut out = Middles { value, grad, hess, size };
        let jets = Jets {
            value: &mut out.value.0,
            grad: Some(out.grad.each_mut().map(|g| &mut g.0[..])),
            hess: Some(out.hess.each_mut().map(|h| &mut h.0[..])),
        };
        kernel.jets([&at[0].0, &at[1].0, &at[2].0], jets);
        out
    }
}

/// How the errors of a kernel grow, for many points.
#[inline(always)]
fn errors(growing: &Growing, size: Pack) -> [Pack; 3] {
    vector(
        #[inline(always)]
        |order| {
            Pack::from_fn(
                #[inline(always)]
                |i| growing.of(order, size.0[i]),
            )
        },
    )
}

/// Bounds on a component of a velocity: `bow`, `rest`, `spread`, `steep`, `bent`, `turn`, `off` and `blur` of a [`Stage`].
type Row = [Pack; 8];

impl Stage {
    /// Of three kernels.
    pub fn set_kernels<K: Kernel>(&mut self, parts: &[KnownKernel<'_, K>; 3], at: &Vector, radius: Pack) {
        let out = self;
        let mut squares: Row = [Pack::ZERO; 8];
        let hess = out.hess.insert([[Pack::ZERO; 6]; 3]);
        for (row, known) in parts.iter().enumerate() {
            let (k, middles) = (known.factor, Middles::new(known.kernel, at));
            widest(
                #[inline(always)]
                || {
                    out.velocity[row] = k * middles.value;
                    out.slope[row] = vector(
                        #[inline(always)]
                        |axis| k * middles.grad[axis],
                    );
                    hess[row] = six(
                        #[inline(always)]
                        |entry| k * middles.hess[entry],
                    );
                    let bounds = of_kernel(known, &middles, radius);
                    for (square, bound) in squares.iter_mut().zip(bounds) {
                        *square += k * k * (bound * bound);
                    }
                },
            );
        }
        let all = squares.map(|square| UP * square.sqrt());
        [out.bow, out.rest, out.spread, out.steep, out.bent, out.turn, out.off, out.blur] = all;
        out.loose = Pack::ZERO;
    }

    /// Of the slope of a kernel.
    pub fn set_slope<K: Kernel>(&mut self, known: &KnownKernel<'_, K>, at: &Vector, r: Pack) {
        let (k, bounds, middles) = (known.factor, known.bounds, Middles::new(known.kernel, at));
        widest(
            #[inline(always)]
            || {
                let (error, g) = (errors(&known.growing, middles.size), length(&middles.grad));
                let [xx, yy, zz, xy, xz, yz] = six(
                    #[inline(always)]
                    |entry| k * middles.hess[entry],
                );
                let (factor, all) = (k.abs() * UP, Pack::ONE);
                let (third, hessian) = (bounds.third * r, bounds.hessian * all);
                let curved = spread(&middles.hess) + 3.0 * error[2];
                let steep = hessian.least(curved + third);
                let off = 2.0 * (error[1] + ROUNDOFF * g);
                let blur = 3.0 * error[2] + 2.0 * ROUNDOFF * curved;
                let bow = factor * (0.5 * third * r + off + blur * r);
                // One by one: `hess` is not worth copying.
                self.velocity = [k * middles.grad[0], k * middles.grad[1], k * middles.grad[2]];
                self.slope = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
                self.hess = None;
                (self.bow, self.rest, self.off, self.blur) = (bow, bow, factor * off, factor * blur);
                self.spread = factor * ((steep * r).least(bounds.lipschitz * all + g) + off);
                self.steep = factor * steep;
                self.bent = factor * bounds.third * all;
                self.turn = factor * (third.least(hessian + curved) + blur);
                self.loose = Pack::ZERO;
            },
        );
    }
}

/// What is known of a kernel over balls, beside its jets.
#[inline(always)]
fn of_kernel<K>(known: &KnownKernel<'_, K>, middles: &Middles, r: Pack) -> Row {
    let (bounds, all) = (known.bounds, Pack::ONE);
    let error = errors(&known.growing, middles.size);
    let (g, value, third) = (length(&middles.grad), middles.value.abs(), bounds.third * r);
    let curved = spread(&middles.hess) + 3.0 * error[2];
    let hessian = bounds.hessian * all;
    let bent = hessian.least(curved + third);
    let goes = (curved + 0.5 * third).least(hessian) * r;
    let steep = (bounds.lipschitz * all).least(g + 2.0 * error[1] + goes);
    // A factor rounds once more.
    let off = error[0] + 2.0 * ROUNDOFF * value;
    let blur = 2.0 * (error[1] + ROUNDOFF * g);
    let rounded = off + blur * r;
    let bow = (0.5 * hessian).least(0.5 * curved + 1.0 / 6.0 * third) * r * r + rounded;
    let bend = 1.5 * error[2] + 4.0 * ROUNDOFF * curved + 1.0 / 6.0 * third;
    let rest = bend * r * r + rounded;
    let spread = (steep * r).least(bounds.range * all + value) + off;
    let turn = (bent * r).least(2.0 * bounds.lipschitz * all) + blur;
    [bow, rest, spread, steep, bent, turn, off, blur]
}
