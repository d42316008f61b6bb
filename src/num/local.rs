//! What kernels say of all of space, and of balls in it.

use super::slope::length;
use super::{Interval, Point, ROUNDOFF};

/// Bounds on a kernel over all of space, rounded up: suprema of the absolute value, of the
/// gradient's norm, and of the second and third directional derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// `|N| <= range`.
    pub range: f64,
    /// `|grad N| <= lipschitz`.
    pub lipschitz: f64,
    /// `|u^T H u| <= hessian` for unit `u`.
    pub hessian: f64,
    /// Lipschitz constant of the Hessian (spectral norm); infinite unless the kernel is C2.
    pub third: f64,
}

impl Bounds {
    /// Whether so far from a point its value says no more than the range does.
    #[inline(always)]
    pub fn drown(&self, reach: f64) -> bool {
        self.range < f64::INFINITY && self.lipschitz * reach >= 2.0 * self.range
    }

    /// Bounds of `N(k x)`.
    #[inline]
    pub fn at_frequency(self, k: f64) -> Bounds {
        let k = k.abs();
        Bounds {
            range: self.range,
            lipschitz: self.lipschitz * k,
            hessian: self.hessian * k * k,
            third: self.third * k * k * k,
        }
    }

    /// Bounds of `k N(x)`.
    #[inline]
    pub fn times(self, k: f64) -> Bounds {
        let k = k.abs();
        Bounds {
            range: self.range * k,
            lipschitz: self.lipschitz * k,
            hessian: self.hessian * k,
            third: self.third * k,
        }
    }
}

/// What a kernel says about the ball of points within a radius of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Local {
    /// The jet at the centre.
    pub jet: Point,
    /// Bounds that hold throughout the ball.
    pub bounds: Bounds,
    /// Encloses `N(x) - N(c) - grad N(c) . (x - c)` in the ball, beyond what the bounds say.
    pub bow: Interval,
    /// The same is at most `sag |x - c|^2 / 2` in the ball; infinite where no more is known than by `bounds`.
    pub sag: f64,
    /// How far gradients in the ball may be from the one at the centre; infinite where no more is known than by `bounds`.
    pub turn: f64,
}

impl Local {
    /// Nothing, with errors beyond all bounds: what a batch is before it is filled.
    pub const UNKNOWN: (Local, [f64; 3]) = {
        let infinite = f64::INFINITY;
        let jet = Point { value: 0.0, grad: [0.0; 3], hess: [0.0; 6] };
        let bounds = Bounds { range: infinite, lipschitz: infinite, hessian: infinite, third: infinite };
        (Local { jet, bounds, bow: Interval::ENTIRE, sag: infinite, turn: infinite }, [infinite; 3])
    };

    /// The jet and the bounds are all there is to say.
    #[inline(always)]
    pub fn uniform(jet: Point, bounds: Bounds) -> Local {
        Local { jet, bounds, bow: Interval::ENTIRE, sag: f64::INFINITY, turn: f64::INFINITY }
    }

    /// What a smooth kernel knows of the ball of `radius` from the jet at its centre, of which every
    /// entry is known to within `error` of its order. With `h` its norm and `M` the bound on third derivatives,
    ///
    /// ```text
    /// |H(x)| <= h + M r      |grad N(x)| <= |grad N(c)| + h r + M r^2 / 2      bow <= h r^2 / 2 + M r^3 / 6
    /// ```
    ///
    /// For sums of many terms, which seldom all agree, that is far less than the global bounds.
    #[inline]
    pub fn smooth(jet: Point, bounds: Bounds, error: [f64; 3], radius: f64) -> Local {
        let up = 1.0 + 64.0 * ROUNDOFF;
        let [xx, yy, zz, xy, xz, yz] = jet.hess;
        // The Frobenius norm, of which the off-diagonal entries are half.
        let square = xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + xz * xz + yz * yz);
        let h = square.sqrt() * up + 3.0 * error[2];
        let third = bounds.third * radius;
        let [x, y, z] = jet.grad;
        let g = (x * x + y * y + z * z).sqrt() + radius * (h + 0.5 * third) + 2.0 * error[1];
        let least = |a: f64, b: f64| if a < b { a } else { b };
        Local {
            jet,
            bounds: Bounds {
                lipschitz: least(g * up, bounds.lipschitz),
                hessian: least((h + third) * up, bounds.hessian),
                ..bounds
            },
            bow: Interval::radius(radius * radius * (0.5 * h + third / 6.0) * up),
            sag: f64::INFINITY,
            turn: f64::INFINITY,
        }
    }

    /// How far the kernel departs from its tangent plane within `reach` of the centre.
    #[inline(always)]
    pub(super) fn bend(&self, reach: f64) -> Interval {
        // An unbounded second derivative bends nothing at the centre itself.
        let hessian = if self.sag < self.bounds.hessian { self.sag } else { self.bounds.hessian };
        let bend = if reach == 0.0 { 0.0 } else { 0.5 * hessian * reach * reach };
        Interval::radius(bend).meet(self.bow)
    }
}

/// What gradients have in common: none of them leans far from an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lean {
    /// Of unit length.
    pub axis: [f64; 3],
    /// `g . axis >= least` for all gradients `g`; from 0 to 1.
    pub least: f64,
}

impl Lean {
    /// Encloses `g . d` for gradients no longer than `L`: of the part `a` of `d` along the axis there is from `least a`
    /// to `L a`, and of the part `b` across at most `sqrt(L^2 - least^2) b` either way.
    pub(super) fn along(&self, d: [Interval; 3], lipschitz: f64) -> Interval {
        let up = 1.0 + 64.0 * ROUNDOFF;
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let length = |a: [f64; 3]| length(a.map(f64::abs));
        let middle = d.map(|d| d.mid());
        let along = dot(middle, self.axis);
        let across: [f64; 3] = std::array::from_fn(|i| middle[i] - along * self.axis[i]);
        let sine = (lipschitz * lipschitz - self.least * self.least).max(0.0).sqrt() * up;
        let spread = length(d.map(|d| d.rad())) + 16.0 * ROUNDOFF * length(middle);
        Interval::new(self.least, lipschitz) * along
            + Interval::radius((sine * length(across) + lipschitz * spread) * up)
    }
}
