//! Procedural noises: random functions of position, each known by its jet at points and by proven
//! bounds on its derivatives.
//!
//! A noise is a [`Kernel`]: a hash of the integer lattice and the seed stands for randomness, so its
//! value depends on position and seed alone. Everything else follows from the jet and the bounds:
//! with the range `[-A, A]`, Lipschitz constant `L` and bounds `M2`, `M3` on the second and third
//! derivatives, one evaluation at the centre of a box encloses the noise on all of it (see
//! [`num`](crate::num)), however many lattice cells the box spans.
//!
//! - A kind of noise is a [`Basis`], one file each; [`Kind`] is the list of them with their
//!   parameters, and [`Noise`] is one of them with a seed, a period and a frequency.
//! - [`Fractal`] sums octaves of a noise; a [`Recipe`] says which and how.
//! - A noise may stand for its slope along an axis ([`Part`]), which makes flows of it.
//! - [`certify`] computes the bounds.
//!
//! To add a noise, write its file and add one line to the list at the end of this one.

mod basis;
mod batches;
mod blend;
mod bulk;
mod bundle;
mod cascade;
mod cellular;
pub mod certify;
mod count;
mod fractal;
mod gabor;
mod gradient;
mod lattice;
mod limits;
mod mean;
mod model;
mod node;
mod octave;
mod parameter;
mod recipe;
mod scatter;
mod shape;
mod simplex;
mod slope;
mod sparse;
mod sum;
#[cfg(test)]
mod tests;
mod value;
mod value_gradient;
mod wavelet;
mod waves;
mod weierstrass;

pub use basis::Basis;
pub use cellular::Cellular;
pub use count::evaluated;
pub use fractal::{Fractal, Given};
pub use gabor::Gabor;
pub use gradient::Gradient;
pub use lattice::Lattice;
pub use limits::Surroundings;
pub use model::{Combination, Model, Signal};
pub use node::Directions;
pub use parameter::{Allowed, Exact, Parameter, Setting, Settings};
pub use recipe::{Hurst, Invalid, Recipe};
pub use simplex::Simplex;
pub use sparse::Sparse;
pub use value::Value;
pub use value_gradient::ValueGradient;
pub use wavelet::Wavelet;
pub use waves::Waves;
pub use weierstrass::Weierstrass;

use crate::num::{Bounds, Class, Jets, Kernel, Local, Order, Point, ROUNDOFF, widest};
use batches::{BALLS, BATCH, MEDIUM, SMALL, balls, batch, gather, times};
use count::count;
use slope::{Slope, steeper};
use std::hash::{Hash, Hasher};

/// A noise of some kind, seeded and scaled: `N(frequency x)`.
///
/// Two noises are equal when they are the same bit for bit, which is what sharing expressions asks.
#[derive(Clone, Copy, Debug)]
pub struct Noise {
    /// Which noise.
    pub kind: Kind,
    /// Seed and period.
    pub lattice: Lattice,
    /// Lattice cells a unit of length.
    pub frequency: f64,
    /// The noise itself, or a derivative of it.
    pub part: Part,
}

/// What of a noise is meant.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Part {
    /// Its value.
    #[default]
    Value,
    /// Its slope along an axis (0, 1, 2), of `N(frequency x)` by `x`.
    Slope(u8),
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
    /// A noise at unit frequency that does not tile.
    pub const fn new(kind: Kind, seed: u64) -> Noise {
        Noise { kind, lattice: Lattice { seed, period: [0; 3] }, frequency: 1.0, part: Part::Value }
    }

    /// The same at another frequency.
    pub const fn at_frequency(self, frequency: f64) -> Noise {
        Noise { frequency, ..self }
    }

    /// The same with another seed.
    pub const fn seeded(self, seed: u64) -> Noise {
        Noise { lattice: Lattice { seed, ..self.lattice }, ..self }
    }

    /// The slope of the noise along an axis (0, 1, 2).
    pub const fn slope(self, axis: u8) -> Noise {
        Noise { part: Part::Slope(axis), ..self }
    }

    /// The noise itself, of which this may be a part.
    const fn whole(self) -> Noise {
        Noise { part: Part::Value, ..self }
    }

    fn identity(&self) -> (Kind, Lattice, u64, Part) {
        (self.kind, self.lattice, self.frequency.to_bits(), self.part)
    }

    /// Jets of the value at points, `B` of them at a time.
    fn scaled_jets<const B: usize>(&self, at: [&[f64]; 3], out: &mut Jets<'_>) {
        let k = self.frequency;
        for start in (0..at[0].len()).step_by(B) {
            let scaled = gather::<B>(
                at,
                start,
                #[inline(always)]
                |[x, y, z]| [x * k, y * k, z * k],
            );
            let mut part = batch::<B>(out, start);
            let count = part.value.len();
            self.kind.jets(
                &self.lattice,
                [0, 1, 2].map(|axis| &scaled[axis][..count]),
                batch::<B>(&mut part, 0),
            );
            widest(
                #[inline(always)]
                || {
                    if let Some(grad) = part.grad {
                        for axis in 0..3 {
                            times(grad[axis], k);
                        }
                    }
                    if let Some(hess) = part.hess {
                        for pair in 0..6 {
                            times(hess[pair], k * k);
                        }
                    }
                },
            );
        }
    }

    /// Half the step of differences along an axis: 2^-18 cells.
    fn step(&self) -> f64 {
        1.0 / (262_144.0 * self.frequency)
    }
}

/// The largest coordinate.
fn largest(at: [f64; 3]) -> f64 {
    at.iter().fold(0.0, |size: f64, x| size.max(x.abs()))
}

impl Noise {
    /// A ball in units of the lattice. The scaled centre is off by a roundoff of its size, and a kind may move it further.
    fn reached(&self, at: [f64; 3], radius: f64) -> ([f64; 3], f64) {
        let centre = at.map(|x| x * self.frequency);
        let off = (2.0 + self.kind.displacement()) * ROUNDOFF * largest(centre);
        (centre, radius * self.frequency * (1.0 + 8.0 * ROUNDOFF) + off)
    }

    /// What is known of a ball, in units of space.
    fn placed(&self, local: Local, radius: f64, reach: f64) -> Local {
        let k = self.frequency;
        let bounds = creased(local.bounds, &self.kind.bounds(), radius * k, reach).at_frequency(k);
        Local {
            jet: scaled(local.jet, k),
            bounds,
            bow: local.bow,
            sag: local.sag * k * k,
            turn: local.turn * k.abs(),
        }
    }
}

impl Kernel for Noise {
    fn class(&self) -> Class {
        match self.part {
            Part::Value => self.kind.class(),
            Part::Slope(_) => self.kind.class().of_slope(),
        }
    }

    #[inline]
    fn bounds(&self) -> Bounds {
        let bounds = self.kind.bounds().at_frequency(self.frequency);
        match self.part {
            Part::Value => bounds,
            Part::Slope(_) => steeper(bounds),
        }
    }

    fn jets(&self, at: [&[f64]; 3], mut out: Jets<'_>) {
        if let Part::Slope(axis) = self.part {
            return Slope::new(&self.whole(), axis, self.step()).jets(at, out);
        }
        count(at[0].len());
        if self.frequency == 1.0 && at[0].len() <= BATCH {
            self.kind.jets(&self.lattice, at, out);
        } else if at[0].len() <= SMALL {
            self.scaled_jets::<SMALL>(at, &mut out);
        } else if at[0].len() <= MEDIUM {
            self.scaled_jets::<MEDIUM>(at, &mut out);
        } else {
            self.scaled_jets::<BATCH>(at, &mut out);
        }
    }

    fn jet(&self, order: Order, at: [f64; 3]) -> Point {
        if let Part::Slope(axis) = self.part {
            return Slope::new(&self.whole(), axis, self.step()).jet(order, at);
        }
        count(1);
        let k = self.frequency;
        scaled(self.kind.jet(&self.lattice, order, at.map(|x| x * k)), k)
    }

    #[inline]
    fn is_uniform(&self) -> bool {
        self.kind.is_uniform()
    }

    fn local(&self, order: Order, at: [f64; 3], radius: f64) -> Local {
        if let Part::Slope(axis) = self.part {
            return Slope::new(&self.whole(), axis, self.step()).local(order, at, radius);
        }
        count(1);
        let (centre, reach) = self.reached(at, radius);
        self.placed(self.kind.local(&self.lattice, order, centre, reach), radius, reach)
    }

    fn locals(&self, order: Order, at: [&[f64]; 3], radius: &[f64], out: &mut [(Local, [f64; 3])]) {
        let ball = |i: usize| (at.map(|at| at[i]), radius[i]);
        let error = |at: [f64; 3]| self.error(largest(at));
        if let Part::Slope(axis) = self.part {
            let (whole, step) = (self.whole(), self.step());
            let slope = Slope::new(&whole, axis, step);
            for (i, out) in out.iter_mut().enumerate() {
                let (at, radius) = ball(i);
                *out = (slope.local(order, at, radius), error(at));
            }
            return;
        }
        count(out.len());
        let place = |at, radius| self.reached(at, radius);
        balls(at, radius, place, |first, centres, reach| {
            let mut locals = [Local::UNKNOWN.0; BALLS];
            let locals = &mut locals[..reach.len()];
            self.kind.locals(&self.lattice, order, centres, reach, locals);
            for (i, local) in locals.iter().enumerate() {
                let (at, radius) = ball(first + i);
                out[first + i] = (self.placed(*local, radius, reach[i]), error(at));
            }
        });
    }

    #[inline]
    fn error(&self, size: f64) -> [f64; 3] {
        if let Part::Slope(axis) = self.part {
            return Slope::new(&self.whole(), axis, self.step()).error(size);
        }
        // Scaled arguments are off by a roundoff of their size on each axis, budgeted as 3; scaled
        // derivatives by two of theirs.
        let (b, k) = (self.bounds(), self.frequency);
        let shift = (3.0 + self.kind.displacement()) * ROUNDOFF * size;
        let own = self.kind.rounding();
        // Where the gradient jumps, `local` accounts for the shift.
        let turn = if b.hessian.is_finite() { b.hessian * shift } else { 0.0 };
        [
            own[0] + b.lipschitz * shift,
            own[1] * k + 4.0 * ROUNDOFF * b.lipschitz + turn,
            own[2] * (k * k) + 4.0 * ROUNDOFF * b.hessian + b.third * shift,
        ]
    }
}

/// What is known of a ball that was grown from `radius` to `reach`, for use with the smaller radius.
///
/// The jet is taken at a rounded centre. Where second derivatives are bounded everywhere, the error
/// of a jet covers that. Where they are not, only `local` knows those around, and the growth of the
/// ball is charged to them: what bends by `M reach^2 / 2` bends by the larger `M'` with `radius`.
pub(super) fn creased(local: Bounds, everywhere: &Bounds, radius: f64, reach: f64) -> Bounds {
    if everywhere.hessian.is_finite() {
        return local;
    }
    let growth = reach / radius * (1.0 + 8.0 * ROUNDOFF);
    let hessian = if radius > 0.0 { local.hessian * growth * growth } else { f64::INFINITY };
    Bounds { hessian, ..local }
}

/// A jet at unit frequency as one at frequency `k`.
#[inline(always)]
fn scaled(p: Point, k: f64) -> Point {
    Point { value: p.value, grad: p.grad.map(|g| g * k), hess: p.hess.map(|h| h * (k * k)) }
}

/// A noise as the list has it.
pub struct Listing {
    /// Name in scripts.
    pub name: &'static str,
    /// One sentence of documentation.
    pub doc: &'static str,
    /// What it can be told.
    pub parameters: &'static [Parameter],
    /// The noise with parameters.
    pub build: fn(&Settings) -> Kind,
}

impl Listing {
    /// The noise with all parameters as they are unless said otherwise.
    pub fn plain(&self) -> Kind {
        (self.build)(&Settings::new(self.parameters))
    }
}

macro_rules! noises {
    ($($noise:ident, $name:literal, $doc:literal;)*) => {
        /// A kind of noise with its parameters.
        #[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
        pub enum Kind {
            $(#[doc = $doc] $noise($noise),)*
        }

        impl Kind {
            /// Every kind of noise.
            pub const ALL: &'static [Listing] = &[$(Listing {
                name: $name,
                doc: $doc,
                parameters: <$noise as Basis>::PARAMETERS,
                build: |settings| Kind::$noise(<$noise as Basis>::new(settings)),
            }),*];

            /// Name in scripts.
            pub fn name(&self) -> &'static str {
                match self { $(Kind::$noise(_) => $name,)* }
            }

            /// Continuity class.
            pub fn class(&self) -> Class {
                match self { $(Kind::$noise(noise) => noise.class(),)* }
            }

            /// Bounds at unit frequency.
            #[inline]
            pub fn bounds(&self) -> Bounds {
                match self { $(Kind::$noise(noise) => noise.bounds(),)* }
            }

            /// Upper -20 dB edge of the power spectrum in cycles a cell.
            pub fn band(&self) -> f64 {
                match self { $(Kind::$noise(noise) => noise.band(),)* }
            }

            /// Which periods the noise can have; `Err` says in words what a period must be.
            pub fn tiles(&self, period: [u32; 3]) -> Result<(), &'static str> {
                match self { $(Kind::$noise(noise) => noise.tiles(period),)* }
            }

            fn is_uniform(&self) -> bool {
                match self { $(Kind::$noise(noise) => noise.is_uniform(),)* }
            }

            fn rounding(&self) -> [f64; 3] {
                match self { $(Kind::$noise(noise) => noise.rounding(),)* }
            }

            fn displacement(&self) -> f64 {
                match self { $(Kind::$noise(noise) => noise.displacement(),)* }
            }

            /// Jets at a batch of points at unit frequency.
            pub fn jets(&self, lattice: &Lattice, at: [&[f64]; 3], out: Jets<'_>) {
                match self { $(Kind::$noise(noise) => noise.jets(lattice, at, out),)* }
            }

            fn jet(&self, lattice: &Lattice, order: Order, at: [f64; 3]) -> Point {
                match self { $(Kind::$noise(noise) => noise.jet(lattice, order, at),)* }
            }

            fn local(&self, lattice: &Lattice, order: Order, at: [f64; 3], radius: f64) -> Local {
                match self { $(Kind::$noise(noise) => noise.local(lattice, order, at, radius),)* }
            }

            fn locals(
                &self,
                lattice: &Lattice,
                order: Order,
                at: [&[f64]; 3],
                radius: &[f64],
                out: &mut [Local],
            ) {
                match self { $(Kind::$noise(noise) => noise.locals(lattice, order, at, radius, out),)* }
            }
        }
    };
}

noises! {
    Gradient, "gradient", "Gradient noise: smooth bumps of about two cells, zero at every node of its lattice; C2.";
    Cellular, "cellular", "Cellular noise: distances to the nearest of random nodes, pebbles or walls or facets; C0.";
    Wavelet, "wavelet", "Wavelet noise: one octave and nothing of the coarser ones, from splines in tiles; C1.";
    Waves, "waves", "Plane waves of one length in all directions: a smooth swell; in sums, Weierstrass-Mandelbrot; C2.";
    Weierstrass, "weierstrass", "Separable Weierstrass-Mandelbrot sum, a whole fractal: products of cosines along the axes; C2.";
    Value, "value", "Value noise: soft blotches of all sizes above a cell, its extrema on the nodes of its lattice; C2.";
    ValueGradient, "value_gradient", "Value-gradient noise: value noise and gradient noise on one lattice, added; C2.";
    Simplex, "simplex", "Simplex noise: bumps like those of gradient noise on a denser lattice that shows less; C2.";
    Sparse, "sparse", "Sparse convolution noise: random round bumps on random nodes, alike in all directions; C2, or C1 with kernel \"lewis\".";
    Gabor, "gabor", "Gabor noise: waves of one frequency under round bumps on random nodes, in all directions or about one; C2.";
}
