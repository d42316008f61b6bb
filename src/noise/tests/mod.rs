//! What every noise and fractal owes: enclosures that enclose, batches that equal their lanes.

mod fractals;
mod kinds;

pub(super) use fractals::check_box;
pub(super) use kinds::jets_of;

use super::*;
use crate::num::{
    Affine, Centred, Dual, Interval, Jet, Level, Many, Number, Reduced, Slope, Symbol, limit_simd, mix,
};

/// A small generator with a fixed start, so that every run tests the same.
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Random(seed)
    }

    pub(super) fn unit(&mut self) -> f64 {
        self.0 += 1;
        (mix(self.0.wrapping_mul(0x9e37_79b9_7f4a_7c15)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(super) fn point(&mut self, size: f64) -> [f64; 3] {
        [0, 1, 2].map(|_| (2.0 * self.unit() - 1.0) * size)
    }
}

/// A random box: any size, often with corners on lattice planes. Returned as centre and radii.
pub(super) fn random_box(random: &mut Random) -> ([f64; 3], [f64; 3]) {
    let size = 10_f64.powf(random.unit() * 7.0 - 6.0);
    let mut centre = random.point(4.0);
    let radius = random.point(size).map(f64::abs);
    let kind = random.unit();
    if kind < 0.2 {
        centre = centre.map(f64::round);
    } else if kind < 0.4 {
        centre = [0, 1, 2].map(|axis| centre[axis].round() / 1.5 + radius[axis]);
    }
    (centre, radius)
}

pub(super) fn within(i: Interval, x: f64, slack: f64) -> bool {
    i.lo - slack <= x && x <= i.hi + slack
}

/// A number in twice the precision: the sum of two.
#[derive(Clone, Copy, Debug)]
pub(super) struct Two(pub f64, pub f64);

impl Two {
    /// The exact sum of two numbers (Knuth).
    pub(super) fn sum(a: f64, b: f64) -> Two {
        let s = a + b;
        let t = s - a;
        Two(s, (a - (s - t)) + (b - t))
    }
}

impl std::ops::Add for Two {
    type Output = Two;
    fn add(self, b: Two) -> Two {
        let s = Two::sum(self.0, b.0);
        Two::sum(s.0, s.1 + self.1 + b.1)
    }
}

impl std::ops::Mul for Two {
    type Output = Two;
    fn mul(self, b: Two) -> Two {
        let p = self.0 * b.0;
        Two::sum(p, self.0.mul_add(b.0, -p) + self.0 * b.1 + self.1 * b.0)
    }
}

/// Checks a jet and its stated rounding against one in twice the precision.
pub(super) fn compare(noise: &Noise, p: [f64; 3], exact: [Two; 10]) {
    let jet = noise.jet(Order::Hessian, p);
    let all = std::iter::once(&jet.value).chain(&jet.grad).chain(&jet.hess);
    for (k, (x, exact)) in all.zip(exact).enumerate() {
        let within = noise.kind.rounding()[[0, 1, 1, 1, 2, 2, 2, 2, 2, 2][k]];
        let error = ((x - exact.0) - exact.1).abs();
        assert!(error <= within, "{:?} {k} {p:?}: {error:e} above {within:e}", noise.kind);
    }
}
