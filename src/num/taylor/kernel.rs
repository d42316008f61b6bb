//! Kernels at expansions.
//!
//! A kernel `N` is known by its jet at the centre of the argument, and by bounds `A`, `L`, `M2`, `M3` on its
//! derivatives. Within `d` of the centre each order is bounded by the next one over that distance or by its own
//! range, whichever is less:
//!
//! ```text
//! |N - N_c - g.y| <= M2 d^2 / 2      |grad N - g| <= M2 d          |H - H_c| <= M3 d
//! |N - quadratic| <= M3 d^3 / 6      |grad N - g - H y| <= M3 d^2 / 2
//! ```
//!
//! Where `M3 d` is more than twice `M2` the Hessian says nothing of the ball, and is replaced by zero, which
//! is at most `M2` off; likewise the gradient and the value. So the fine octaves of a sum do not blur what is known of
//! the coarse ones. The argument's own expansion enters by the chain rule, as for functions (`lift.rs`),
//! with vectors and matrices for the three arguments together.

use super::batch::Taylors;
use super::{ROUND_UP, Taylor, least, length, spectral};
use crate::num::interval::choose;
use crate::num::jet::matrix;
use crate::num::number::{Growing, Jets};
use crate::num::simd::widest;
use crate::num::{Bounds, Function, Interval, Kernel, Local, Order, PAIRS, Point, ROUNDOFF};

/// Covers the rounding of sums of up to thirty products of four, whose sizes add up to at most nine times the
/// product of norms (Frobenius norms are no more than the root of three times spectral ones, and sums of nine sizes no
/// more than three times those).
const SUMS: f64 = 400.0;

/// What is known of the middle of a ball of which only the range of the kernel counts.
const UNSEEN: Point = Point { value: f64::NAN, grad: [0.0; 3], hess: [0.0; 6] };

/// What arguments are like in all balls of a batch: expansions that leave out nothing, as those of coordinates do,
const EXACT: u8 = 0;
/// such without second derivatives in the centre,
const STRAIGHT: u8 = 1;
/// or any.
const BENT: u8 = 2;

/// The three arguments together. Of arguments that are `LIKE` that, no time is lost with what is zero.
#[derive(Clone, Copy)]
struct Argument<const LIKE: u8> {
    x: [Taylor; 3],
    /// Norm of the Jacobian in the centre.
    slope: f64,
    /// Norms of what the expansions leave out.
    bow: [f64; 2],
    turn: [f64; 2],
    twist: f64,
    /// Norm of all second derivatives.
    curved: f64,
    /// How far the point goes.
    far: f64,
}

impl<const LIKE: u8> Argument<LIKE> {
    /// Of a lane.
    #[inline(always)]
    fn at<const B: usize>(p: [&Taylors<B>; 3], i: usize) -> Self {
        Argument::new([p[0].lane(i), p[1].lane(i), p[2].lane(i)])
    }

    #[inline(always)]
    fn new(x: [Taylor; 3]) -> Self {
        let slope = jacobian(&x);
        let together = |part: [f64; 3]| if LIKE == EXACT { 0.0 } else { length(part) };
        let bow = [0, 1].map(|k| together([x[0].bow[k], x[1].bow[k], x[2].bow[k]]));
        let turn = [0, 1].map(|k| together([x[0].turn[k], x[1].turn[k], x[2].turn[k]]));
        Argument {
            slope,
            bow,
            turn,
            twist: together([x[0].twist, x[1].twist, x[2].twist]),
            curved: if LIKE == BENT {
                together([spectral(x[0].hess), spectral(x[1].hess), spectral(x[2].hess)])
            } else {
                0.0
            },
            far: (slope + bow[0]) * ROUND_UP,
            x,
        }
    }
}

/// What arguments are like.
#[inline(always)]
fn likeness<const B: usize>(p: [&Taylors<B>; 3]) -> u8 {
    let (mut is_bent, mut is_off) = (false, false);
    for x in p {
        for i in 0..B {
            for pair in 0..6 {
                is_bent |= x.hess[pair][i] != 0.0;
            }
            for k in 0..2 {
                is_off |= (x.bow[k][i] != 0.0) | (x.turn[k][i] != 0.0);
            }
            is_off |= x.twist[i] != 0.0;
        }
    }
    if is_bent {
        BENT
    } else if is_off {
        STRAIGHT
    } else {
        EXACT
    }
}

/// Bound on the spectral norm of the matrix whose rows are the gradients: the root of the largest row sum of
/// `J J^T`, which is exact where the rows are perpendicular and alike.
#[inline(always)]
fn jacobian(x: &[Taylor; 3]) -> f64 {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let [a, b, c] = [x[0].grad, x[1].grad, x[2].grad];
    let [ab, ac, bc] = [dot(a, b).abs(), dot(a, c).abs(), dot(b, c).abs()];
    let rows = [dot(a, a) + ab + ac, ab + dot(b, b) + bc, ac + bc + dot(c, c)];
    let larger = |a: f64, b: f64| choose(a > b, a, b);
    larger(larger(rows[0], rows[1]), rows[2]).sqrt() * ROUND_UP
}

/// What is known of a kernel within a distance.
struct Known {
    value: f64,
    grad: [f64; 3],
    hess: [f64; 6],
    /// How far it may be from these: values, to first and second order in the place, gradients likewise, and
    /// Hessians.
    bow: [f64; 2],
    turn: [f64; 2],
    twist: f64,
    range: Interval,
}

impl Known {
    /// From the jet in the centre, of which each order may be off by `error`.
    #[inline(always)]
    fn new(local: &Local, error: [f64; 3], far: f64) -> Known {
        let Local { jet, bounds: b, bow, sag, turn } = local;
        let is_value = jet.value.is_finite() & !b.drown(far);
        let grad_sum = jet.grad[0] + jet.grad[1] + jet.grad[2] + error[1];
        // Also where nothing is known of second derivatives, but of what the gradient leaves out.
        let bend = least(0.5 * least(b.hessian, *sag) * far * far, bow.mag());
        let is_grad = is_value & grad_sum.is_finite() & (bend < b.lipschitz * far);
        let mut hess_sum = error[2];
        for k in 0..6 {
            hess_sum += jet.hess[k];
        }
        let is_hess = is_grad & hess_sum.is_finite() & (b.third * far < 2.0 * b.hessian);
        let value = choose(is_value, jet.value, 0.0);
        let (mut grad, mut hess) = ([0.0; 3], [0.0; 6]);
        for k in 0..3 {
            grad[k] = choose(is_grad, jet.grad[k], 0.0);
        }
        for k in 0..6 {
            hess[k] = choose(is_hess, jet.hess[k], 0.0);
        }
        let [e0, e1, e2] = error;
        let twist = choose(is_hess, b.third * far + e2, b.hessian);
        let differ = (length(jet.grad) + b.lipschitz) * ROUND_UP;
        let first = choose(is_grad, least(least(b.hessian * far, differ), *turn) + e1, b.lipschitz);
        let second = choose(is_hess, 0.5 * b.third * far * far + e1 + e2 * far, first);
        // Values: the Lipschitz bound where the gradient is left out, the range where the value is.
        let flat = choose(is_value, least(b.lipschitz * far, f64::INFINITY) + e0, b.range);
        let tilted = e0 + e1 * far + bend;
        let curved = e0 + far * (e1 + e2 * far + b.third * far * far / 6.0);
        let tilted = choose(is_grad, tilted, flat);
        let cone = Interval::around(value, flat * ROUND_UP);
        Known {
            value,
            grad,
            hess,
            bow: [tilted * ROUND_UP, choose(is_hess, curved, tilted) * ROUND_UP],
            turn: [first * ROUND_UP, second * ROUND_UP],
            twist: twist * ROUND_UP,
            range: cone.meet(Interval::radius(b.range)),
        }
    }
}

impl<const B: usize> Taylors<B> {
    /// Writes the image of a point under a kernel to `out`.
    pub(super) fn image<K: Kernel + ?Sized>(k: &K, p: [&Self; 3], out: &mut Self) {
        let blind = Self::blind(&k.bounds(), p);
        if k.is_uniform() || blind == [true; B] {
            out.uniform(k, p, &blind);
        } else {
            out.local(k, p, &blind);
        }
    }

    /// Which balls are so large that only the range of the kernel counts; each for itself, so that no lane depends on its
    /// neighbours.
    fn blind(bounds: &Bounds, p: [&Self; 3]) -> [bool; B] {
        let ranges = p.map(|p| &p.range);
        widest(
            #[inline(always)]
            || {
                let mut blind = [false; B];
                for i in 0..B {
                    let mut wide: f64 = 0.0;
                    for axis in 0..3 {
                        wide = wide.max(0.5 * (ranges[axis][1][i] - ranges[axis][0][i]));
                    }
                    blind[i] = bounds.drown(wide * (1.0 - 1e-9));
                }
                blind
            },
        )
    }

    /// The image under a kernel of which the jets and the bounds are all there is to say.
    fn uniform<K: Kernel + ?Sized>(&mut self, k: &K, p: [&Self; 3], blind: &[bool; B]) {
        let bounds = k.bounds();
        let (mut value, mut grad, mut hess) = ([0.0; B], [[0.0; B]; 3], [[0.0; B]; 6]);
        if blind != &[true; B] {
            let out = Jets {
                value: &mut value,
                grad: Some(grad.each_mut().map(|g| &mut g[..])),
                // Of no use where nothing bounds how they vary.
                hess: bounds.third.is_finite().then_some(hess.each_mut().map(|h| &mut h[..])),
            };
            k.jets([&p[0].value, &p[1].value, &p[2].value], out);
        }
        let jets = Centres { value, grad, hess, blind, error: Growing::new(k), bounds };
        self.compose(p, &jets);
    }

    /// Composes jets with the arguments of a kernel; compiled once for all kernels.
    #[inline(never)]
    fn compose(&mut self, p: [&Self; 3], jets: &Centres<'_, B>) {
        widest(
            #[inline(always)]
            || match likeness(p) {
                EXACT => self.fill(
                    #[inline(always)]
                    |i| jets.composed(i, &Argument::<EXACT>::at(p, i)),
                ),
                STRAIGHT => self.fill(
                    #[inline(always)]
                    |i| jets.composed(i, &Argument::<STRAIGHT>::at(p, i)),
                ),
                _ => self.fill(
                    #[inline(always)]
                    |i| jets.composed(i, &Argument::<BENT>::at(p, i)),
                ),
            },
        );
    }

    /// The image of three numbers under a function that knows as much of a ball as a kernel does; says whether it is
    /// one.
    #[inline(always)]
    pub(super) fn around<F: Function<N>, const N: usize>(f: &F, x: &[&Self; N], out: &mut Self) -> bool {
        let [a, b, c] = x[..] else { return false };
        if f.around([1.0; N], 0.0).is_none() {
            return false;
        }
        // Of points themselves mostly; for each kind of arguments more, all functions would be compiled once more.
        if likeness([a, b, c]) == EXACT {
            out.fill(
                #[inline(always)]
                |i| composed_around(f, x, i, &Argument::<EXACT>::at([a, b, c], i)),
            );
        } else {
            out.fill(
                #[inline(always)]
                |i| composed_around(f, x, i, &Argument::<BENT>::at([a, b, c], i)),
            );
        }
        true
    }

    /// The image under a kernel that knows more about a small ball than about all of space.
    fn local<K: Kernel + ?Sized>(&mut self, k: &K, p: [&Self; 3], blind: &[bool; B]) {
        let mut far = [0.0; B];
        widest(
            #[inline(always)]
            || {
                for i in 0..B {
                    far[i] = Argument::<BENT>::at(p, i).far;
                }
            },
        );
        // The balls that the kernel sees, side by side.
        let (mut seen, mut count) = ([0; B], 0);
        let (mut at, mut radius) = ([[0.0; B]; 3], [0.0; B]);
        for i in (0..B).filter(|&i| !blind[i]) {
            (at[0][count], at[1][count], at[2][count]) = (p[0].value[i], p[1].value[i], p[2].value[i]);
            (radius[count], seen[i]) = (far[i], count);
            count += 1;
        }
        let mut locals = [Local::UNKNOWN; B];
        let balls = at.each_ref().map(|at| &at[..count]);
        k.locals(Order::Hessian, balls, &radius[..count], &mut locals[..count]);
        let (bounds, growing) = (k.bounds(), Growing::new(k));
        let mut told = Told { parts: [[0.0; B]; PARTS] };
        for i in 0..B {
            told.set(
                i,
                &if blind[i] {
                    (Local::uniform(UNSEEN, bounds), growing.at(size(&Argument::<BENT>::at(p, i))))
                } else {
                    locals[seen[i]]
                },
            );
        }
        self.fill_widest(
            #[inline(always)]
            |i| {
                let (local, error) = told.lane(i);
                Taylor::composed(&Known::new(&local, error, far[i]), &Argument::<BENT>::at(p, i))
            },
        );
    }
}

/// What a kernel of which the jets and the bounds are all there is to say knows of balls.
struct Centres<'a, const B: usize> {
    value: [f64; B],
    grad: [[f64; B]; 3],
    hess: [[f64; B]; 6],
    /// Of which only the range counts.
    blind: &'a [bool; B],
    error: Growing,
    bounds: Bounds,
}

impl<const B: usize> Centres<'_, B> {
    /// A lane at an argument.
    #[inline(always)]
    fn composed<const LIKE: u8>(&self, i: usize, x: &Argument<LIKE>) -> Taylor {
        let mut jet = UNSEEN;
        if !self.blind[i] {
            (jet.value, jet.grad) = (self.value[i], [self.grad[0][i], self.grad[1][i], self.grad[2][i]]);
            for k in 0..6 {
                jet.hess[k] = self.hess[k][i];
            }
        }
        let error = self.error.at(size(x));
        Taylor::composed(&Known::new(&Local::uniform(jet, self.bounds), error, x.far), x)
    }
}

/// A lane of the image under a function that knows of a ball what a kernel does.
#[inline(always)]
fn composed_around<F: Function<N>, const N: usize, const B: usize, const LIKE: u8>(
    f: &F,
    x: &[&Taylors<B>; N],
    i: usize,
    argument: &Argument<LIKE>,
) -> Taylor {
    let mut at = [0.0; N];
    for k in 0..N {
        at[k] = x[k].value[i];
    }
    match f.around(at, argument.far) {
        Some((local, error)) => Taylor::composed(&Known::new(&local, error, argument.far), argument),
        None => Taylor::constant(f64::NAN),
    }
}

/// Numbers that say what a kernel knows of a ball, and how far its jet may be off.
const PARTS: usize = 21;

/// What a kernel knows of balls, as a structure of arrays: a loop that picks each from somewhere is not vectorised.
struct Told<const B: usize> {
    parts: [[f64; B]; PARTS],
}

impl<const B: usize> Told<B> {
    fn set(&mut self, i: usize, (local, error): &(Local, [f64; 3])) {
        let Local { jet, bounds, bow, sag, turn } = *local;
        let ([x, y, z], [xx, yy, zz, xy, xz, yz], [e0, e1, e2]) = (jet.grad, jet.hess, *error);
        let Bounds { range, lipschitz, hessian, third } = bounds;
        let parts: [f64; PARTS] = [
            jet.value, x, y, z, xx, yy, zz, xy, xz, yz, range, lipschitz, hessian, third, bow.lo, bow.hi,
            sag, turn, e0, e1, e2,
        ];
        for (lanes, part) in self.parts.iter_mut().zip(parts) {
            lanes[i] = part;
        }
    }

    #[inline(always)]
    fn lane(&self, i: usize) -> (Local, [f64; 3]) {
        let part = |k: usize| self.parts[k][i];
        let jet = Point {
            value: part(0),
            grad: [part(1), part(2), part(3)],
            hess: [part(4), part(5), part(6), part(7), part(8), part(9)],
        };
        let bounds = Bounds { range: part(10), lipschitz: part(11), hessian: part(12), third: part(13) };
        let bow = Interval { lo: part(14), hi: part(15) };
        (Local { jet, bounds, bow, sag: part(16), turn: part(17) }, [part(18), part(19), part(20)])
    }
}

/// Largest coordinate in the centre.
#[inline(always)]
fn size<const LIKE: u8>(x: &Argument<LIKE>) -> f64 {
    let larger = |a: f64, b: f64| choose(a > b, a, b);
    larger(larger(x.x[0].value.abs(), x.x[1].value.abs()), x.x[2].value.abs())
}

impl Taylor {
    /// The chain rule for a kernel.
    #[inline(always)]
    fn composed<const LIKE: u8>(n: &Known, x: &Argument<LIKE>) -> Taylor {
        let mut out = Taylor::constant(n.value);
        let h = matrix(n.hess);
        // Rows of `H_N J`.
        let mut bent = [[0.0; 3]; 3];
        for i in 0..3 {
            for axis in 0..3 {
                out.grad[axis] += n.grad[i] * x.x[i].grad[axis];
                for j in 0..3 {
                    bent[i][axis] += h[i][j] * x.x[j].grad[axis];
                }
            }
        }
        for pair in 0..6 {
            let (row, column) = PAIRS[pair];
            for i in 0..3 {
                let own = if LIKE == BENT { n.grad[i] * x.x[i].hess[pair] } else { 0.0 };
                out.hess[pair] += own + x.x[i].grad[row] * bent[i][column];
            }
        }
        let (g, h) = (length(n.grad), spectral(n.hess));
        let steep = (x.slope + x.turn[0]) * ROUND_UP;
        out.bow = [
            (n.bow[0] + g * x.bow[0]) * ROUND_UP,
            (n.bow[1] + g * x.bow[1] + 0.5 * h * x.bow[0] * (x.far + x.slope)) * ROUND_UP,
        ];
        out.turn = [
            (n.turn[0] * steep + g * x.turn[0]) * ROUND_UP,
            (steep * (n.turn[1] + h * x.bow[0]) + g * x.turn[1] + x.turn[0] * h * x.slope) * ROUND_UP,
        ];
        out.twist = (n.twist * steep * steep
            + h * x.turn[0] * (steep + x.slope)
            + g * x.twist
            + n.turn[0] * (x.curved + x.twist))
            * ROUND_UP;
        // Entries are sums of products whose sizes the norms bound.
        let rounding = SUMS * ROUNDOFF;
        out.blur([0.0, rounding * g * x.slope, rounding * (h * x.slope * x.slope + g * x.curved)]);
        out.narrowed(n.range)
    }
}
