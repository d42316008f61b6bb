//! One octave of a fractal: a noise seen through a rotation, a scaling and a shift.
//!
//! ```text
//! y = M x + t,  M = k R         value N(y),  gradient M^T grad N,  Hessian M^T H M
//! ```
//!
//! Turning every octave its own way hides the lattice, and moving it keeps the octaves' zeros from
//! meeting at the origin (Worley; Gamito 2009, 3.3.2). The rotation lives inside the kernel rather
//! than in the coordinates that reach it, since a turned box would have to be boxed again, while
//! the bounds of a kernel are the same in every direction.

use super::batches::{BATCH, MEDIUM, SMALL, balls, batch, gather};
use super::slope::Slope;
use super::{Noise, Part, creased, largest};
use crate::num::{Bounds, Class, Jets, Kernel, Local, Order, Point, ROUNDOFF, mix, uniform, widest};

/// A rotated, scaled and shifted noise.
#[derive(Clone, Copy, Debug)]
pub(super) struct Octave {
    /// The noise at the octave's own seed and frequency.
    pub noise: Noise,
    /// Its placement, where it is not the plain one.
    pub placement: Option<Placement>,
}

/// A rotation `R` (rows) and a shift in lattice cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    turn: [[f64; 3]; 3],
    shift: [f64; 3],
}

/// Shifts reach this many cells: more than the eye compares, too few to cost precision.
const REACH: f64 = 256.0;

impl Placement {
    /// A uniformly random rotation and shift, drawn by hashing `seed`.
    ///
    /// The rotation is that of a uniform unit quaternion (Shoemake 1992) from three uniform
    /// numbers; the angles go through `libm` so that every platform turns alike.
    pub(super) fn random(seed: u64) -> Placement {
        let uniform = |i: u64| uniform(mix(mix(seed) ^ i));
        let (u, a, b) = (uniform(1), uniform(2) * std::f64::consts::TAU, uniform(3) * std::f64::consts::TAU);
        let (r, s) = ((1.0 - u).sqrt(), u.sqrt());
        let (x, y, z, w) = (r * libm::sin(a), r * libm::cos(a), s * libm::sin(b), s * libm::cos(b));
        let turn = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
        ];
        Placement { turn, shift: [4, 5, 6].map(|i| uniform(i) * REACH) }
    }

    #[inline(always)]
    fn place(&self, k: f64, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let row = |i: usize| {
            let [a, b, c] = self.turn[i];
            k * (a * x + b * y + c * z) + self.shift[i]
        };
        [row(0), row(1), row(2)]
    }

    /// Jets of the turned noise as jets in space.
    #[inline(always)]
    fn turn_back(&self, k: f64, out: Jets<'_>) {
        let count = out.value.len();
        if let Some(grad) = out.grad {
            let [x, y, z] = grad.map(|g| &mut g[..count]);
            for i in 0..count {
                [x[i], y[i], z[i]] = self.gradient(k, [x[i], y[i], z[i]]);
            }
        }
        if let Some(hess) = out.hess {
            let [a, b, c, d, e, f] = hess.map(|h| &mut h[..count]);
            for i in 0..count {
                [a[i], b[i], c[i], d[i], e[i], f[i]] = self.hessian(k, [a[i], b[i], c[i], d[i], e[i], f[i]]);
            }
        }
    }

    /// A jet of the turned noise as a jet in space.
    fn turned(&self, k: f64, order: Order, p: Point) -> Point {
        let mut out = Point { value: p.value, ..Point::default() };
        if order >= Order::Gradient {
            out.grad = self.gradient(k, p.grad);
        }
        if order >= Order::Hessian {
            out.hess = self.hessian(k, p.hess);
        }
        out
    }

    /// `k R^T g`
    #[inline(always)]
    fn gradient(&self, k: f64, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [a, b, c] = &self.turn;
        let column = |j: usize| k * (a[j] * x + b[j] * y + c[j] * z);
        [column(0), column(1), column(2)]
    }

    /// `k^2 R^T H R`
    #[inline(always)]
    fn hessian(&self, k: f64, [xx, yy, zz, xy, xz, yz]: [f64; 6]) -> [f64; 6] {
        let column = |j: usize| {
            let (a, b, c) = (self.turn[0][j], self.turn[1][j], self.turn[2][j]);
            [xx * a + xy * b + xz * c, xy * a + yy * b + yz * c, xz * a + yz * b + zz * c]
        };
        let h = [column(0), column(1), column(2)];
        let entry = |i: usize, j: usize| {
            let (a, b, c) = (self.turn[0][i], self.turn[1][i], self.turn[2][i]);
            k * k * (a * h[j][0] + b * h[j][1] + c * h[j][2])
        };
        [entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)]
    }
}

impl Octave {
    fn unit(&self) -> Noise {
        Noise { frequency: 1.0, ..self.noise }
    }

    /// The centre of a ball as the noise sees it, and its radius there: a ball stays a ball when it is turned. (It grows by
    /// the rounding of the matrix.)
    fn reached(&self, placement: &Placement, at: [f64; 3], radius: f64) -> ([f64; 3], f64) {
        let k = self.noise.frequency;
        let reach = radius * k * (1.0 + 32.0 * ROUNDOFF) + 32.0 * ROUNDOFF * (k * largest(at) + REACH);
        (placement.place(k, at), reach)
    }

    /// What is known of a ball from what the noise knows of where it is [placed](Octave::reached).
    fn placed(&self, placement: &Placement, order: Order, local: &Local, radius: f64, reach: f64) -> Local {
        let k = self.noise.frequency;
        let bounds = creased(local.bounds, &self.noise.kind.bounds(), radius * k, reach);
        let (sag, turn) = (local.sag * k * k, local.turn * k.abs());
        let jet = placement.turned(k, order, local.jet);
        Local { jet, bounds: bounds.at_frequency(k), bow: local.bow, sag, turn }
    }

    /// Jets of the placed noise, `B` points at a time.
    fn placed_jets<const B: usize>(&self, placement: &Placement, at: [&[f64]; 3], out: &mut Jets<'_>) {
        let (noise, k) = (self.unit(), self.noise.frequency);
        for start in (0..at[0].len()).step_by(B) {
            let placed = gather::<B>(
                at,
                start,
                #[inline(always)]
                |p| placement.place(k, p),
            );
            let mut part = batch::<B>(out, start);
            let count = part.value.len();
            noise.jets([0, 1, 2].map(|axis| &placed[axis][..count]), batch::<B>(&mut part, 0));
            widest(
                #[inline(always)]
                || placement.turn_back(k, part),
            );
        }
    }

    /// The octave of which this one is the slope along an axis in space, and that axis. Where it is
    /// not turned, the noise knows its slopes itself.
    fn slope_of(&self) -> Option<(Octave, u8)> {
        match (self.noise.part, self.placement) {
            (Part::Slope(axis), Some(_)) => Some((Octave { noise: self.noise.whole(), ..*self }, axis)),
            _ => None,
        }
    }
}

impl Kernel for Octave {
    fn class(&self) -> Class {
        self.noise.class()
    }

    /// Those of the noise: rotations keep norms. (The matrix is a rotation up to a few roundoffs,
    /// and the constants of a noise are rounded up by far more.)
    #[inline]
    fn bounds(&self) -> Bounds {
        self.noise.bounds()
    }

    fn jets(&self, at: [&[f64]; 3], mut out: Jets<'_>) {
        let Some(placement) = &self.placement else { return self.noise.jets(at, out) };
        if let Some((of, axis)) = self.slope_of() {
            return Slope::new(&of, axis, self.noise.step()).jets(at, out);
        }
        if at[0].len() <= SMALL {
            self.placed_jets::<SMALL>(placement, at, &mut out);
        } else if at[0].len() <= MEDIUM {
            self.placed_jets::<MEDIUM>(placement, at, &mut out);
        } else {
            self.placed_jets::<BATCH>(placement, at, &mut out);
        }
    }

    fn jet(&self, order: Order, at: [f64; 3]) -> Point {
        let Some(placement) = &self.placement else { return self.noise.jet(order, at) };
        if let Some((of, axis)) = self.slope_of() {
            return Slope::new(&of, axis, self.noise.step()).jet(order, at);
        }
        let k = self.noise.frequency;
        placement.turned(k, order, self.unit().jet(order, placement.place(k, at)))
    }

    #[inline]
    fn is_uniform(&self) -> bool {
        self.noise.is_uniform()
    }

    fn local(&self, order: Order, at: [f64; 3], radius: f64) -> Local {
        let Some(placement) = &self.placement else { return self.noise.local(order, at, radius) };
        if let Some((of, axis)) = self.slope_of() {
            return Slope::new(&of, axis, self.noise.step()).local(order, at, radius);
        }
        let (centre, reach) = self.reached(placement, at, radius);
        let local = self.unit().local(order, centre, reach);
        self.placed(placement, order, &local, radius, reach)
    }

    fn locals(&self, order: Order, at: [&[f64]; 3], radius: &[f64], out: &mut [(Local, [f64; 3])]) {
        let Some(placement) = &self.placement else { return self.noise.locals(order, at, radius, out) };
        let ball = |i: usize| (at.map(|at| at[i]), radius[i]);
        let error = |at: [f64; 3]| self.error(largest(at));
        if self.slope_of().is_some() {
            for (i, out) in out.iter_mut().enumerate() {
                let (at, radius) = ball(i);
                *out = (self.local(order, at, radius), error(at));
            }
            return;
        }
        let place = |at, radius| self.reached(placement, at, radius);
        balls(at, radius, place, |first, centres, reach| {
            let out = &mut out[first..first + reach.len()];
            self.unit().locals(order, centres, reach, out);
            for (i, out) in out.iter_mut().enumerate() {
                let (at, radius) = ball(first + i);
                *out = (self.placed(placement, order, &out.0, radius, reach[i]), error(at));
            }
        });
    }

    /// As for any kernel, with the error of `M x + t` in place of that of `k x`: a row of three
    /// products, each entry off by a few roundoffs of its own, then a shift.
    #[inline]
    fn error(&self, size: f64) -> [f64; 3] {
        if let Some((of, axis)) = self.slope_of() {
            return Slope::new(&of, axis, self.noise.step()).error(size);
        }
        match self.placement {
            None => self.noise.error(size),
            Some(_) => {
                // The default charges 3 roundoffs a unit of size; this is at most 18 in Euclidean
                // norm, and a shift of `REACH` cells is worth `REACH / k` units.
                let reach = REACH / self.noise.frequency;
                let [a, b, c] = self.noise.error(6.0 * size + 2.0 * reach);
                // Turning back mixes the components, whose errors add up by at most the largest
                // row sum, sqrt(3), once for a gradient and twice for a Hessian.
                let bounds = self.bounds();
                let turned = 32.0 * ROUNDOFF;
                [a, 1.75 * b + turned * bounds.lipschitz, 3.0 * c + 4.0 * turned * bounds.hessian]
            }
        }
    }
}
