//! Procedural noises: random functions of position, each known by its jet at points and by proven
//! bounds on its derivatives.
//!
//! A noise is a [`Kernel`]: a hash of the integer lattice and the seed stands for randomness, so its
//! value depends on position and seed alone. Everything else follows from the jet and the bounds:
//! with the range `[-A, A]`, Lipschitz constant `L` and bounds `M2`, `M3` on the second and third
//! derivatives, one evaluation at the centre of a box encloses the noise on all of it (see
//! [`num`](crate::num)), however many lattice cells the box spans.
//!
//! - [`Gradient`] and its neighbours are the noises at unit frequency, one file each.
//! - [`Kind`] is the list of them; [`Noise`] is one of them with a seed and a frequency.
//! - [`Fractal`] sums octaves of a noise.
//! - [`certify`] computes the bounds.
//!
//! To add a noise, write its file and add one line to the list at the end of this one.

mod cascade;
pub mod certify;
mod fractal;
mod gradient;
mod octave;
mod shape;
mod sum;
#[cfg(test)]
mod tests;

pub use fractal::{Fractal, Invalid, Model, Recipe};
pub use gradient::Gradient;

use crate::num::{Bounds, Class, Jets, Kernel, Order, Point, widest};
use std::hash::{Hash, Hasher};

/// A noise of some kind, seeded and scaled: `N(frequency x)`.
///
/// Two noises are equal when they are the same bit for bit, which is what sharing expressions asks.
#[derive(Clone, Copy, Debug)]
pub struct Noise {
    /// Which noise.
    pub kind: Kind,
    /// Names the random field; different seeds give unrelated fields.
    pub seed: u64,
    /// Lattice cells a unit of length.
    pub frequency: f64,
}

impl PartialEq for Noise {
    fn eq(&self, other: &Self) -> bool {
        self.identity() == other.identity()
    }
}

impl Eq for Noise {}

impl Hash for Noise {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.identity().hash(state);
    }
}

impl Noise {
    fn identity(&self) -> (Kind, u64, u64) {
        (self.kind, self.seed, self.frequency.to_bits())
    }
}

/// Points whose scaled coordinates are held at a time.
pub(crate) const BATCH: usize = 64;

/// Copies one batch of coordinates through `map`, which sees a point at a time.
#[inline(always)]
pub(crate) fn gather(at: [&[f64]; 3], start: usize, map: impl Fn([f64; 3]) -> [f64; 3]) -> [[f64; BATCH]; 3] {
    let count = (at[0].len() - start).min(BATCH);
    let [x, y, z] = at.map(|at| &at[start..start + count]);
    let mut scaled = [[0.0; BATCH]; 3];
    let [u, v, w] = &mut scaled;
    for i in 0..count {
        [u[i], v[i], w[i]] = map([x[i], y[i], z[i]]);
    }
    scaled
}

/// The part of `out` from `start`, at most a batch long.
#[inline(always)]
pub(crate) fn batch<'a>(out: &'a mut Jets<'_>, start: usize) -> Jets<'a> {
    let end = (start + BATCH).min(out.value.len());
    Jets {
        value: &mut out.value[start..end],
        grad: out.grad.as_mut().map(|g| g.each_mut().map(|g| &mut g[start..end])),
        hess: out.hess.as_mut().map(|h| h.each_mut().map(|h| &mut h[start..end])),
    }
}

impl Kernel for Noise {
    fn class(&self) -> Class {
        self.kind.class()
    }

    #[inline]
    fn bounds(&self) -> Bounds {
        self.kind.bounds().at_frequency(self.frequency)
    }

    fn jets(&self, at: [&[f64]; 3], mut out: Jets<'_>) {
        let k = self.frequency;
        for start in (0..at[0].len()).step_by(BATCH) {
            let scaled = widest(
                #[inline(always)]
                || gather(at, start, |p| p.map(|x| x * k)),
            );
            let mut part = batch(&mut out, start);
            let count = part.value.len();
            self.kind.jets(self.seed, [0, 1, 2].map(|axis| &scaled[axis][..count]), batch(&mut part, 0));
            widest(
                #[inline(always)]
                || {
                    part.grad.into_iter().flatten().flatten().for_each(|g| *g *= k);
                    part.hess.into_iter().flatten().flatten().for_each(|h| *h *= k * k);
                },
            );
        }
    }

    fn jet(&self, order: Order, at: [f64; 3]) -> Point {
        let k = self.frequency;
        let p = self.kind.jet(self.seed, order, at.map(|x| x * k));
        Point { value: p.value, grad: p.grad.map(|g| g * k), hess: p.hess.map(|h| h * (k * k)) }
    }
}

/// splitmix64's finaliser (Steele, Lea, Flood 2014): every bit of the result depends on all of `x`.
#[inline(always)]
pub(crate) fn mix(x: u64) -> u64 {
    let z = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

macro_rules! noises {
    ($($noise:ident, $name:literal, $doc:literal;)*) => {
        /// The kinds of noise.
        #[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
        pub enum Kind {
            $(#[doc = $doc] $noise,)*
        }

        impl Kind {
            /// Every kind of noise.
            pub const ALL: &'static [Kind] = &[$(Kind::$noise),*];

            /// Name in scripts.
            pub fn name(self) -> &'static str {
                match self { $(Kind::$noise => $name,)* }
            }

            /// One sentence of documentation.
            pub fn doc(self) -> &'static str {
                match self { $(Kind::$noise => $doc,)* }
            }

            /// Continuity class.
            pub fn class(self) -> Class {
                match self { $(Kind::$noise => $noise { seed: 0 }.class(),)* }
            }

            /// Bounds at unit frequency.
            #[inline]
            pub fn bounds(self) -> Bounds {
                match self { $(Kind::$noise => $noise { seed: 0 }.bounds(),)* }
            }

            fn jets(self, seed: u64, at: [&[f64]; 3], out: Jets<'_>) {
                match self { $(Kind::$noise => $noise { seed }.jets(at, out),)* }
            }

            fn jet(self, seed: u64, order: Order, at: [f64; 3]) -> Point {
                match self { $(Kind::$noise => $noise { seed }.jet(order, at),)* }
            }
        }
    };
}

noises! {
    Gradient, "gradient", "Gradient noise: smooth bumps of about two cells, zero at every node of its lattice; C2.";
}
