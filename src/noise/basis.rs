//! What a kind of noise states about itself.

use super::lattice::Lattice;
use super::parameter::{Parameter, Settings};
use crate::num::{Bounds, Class, Jets, Local, Order, Point, ROUNDOFF};
use std::fmt::Debug;
use std::hash::Hash;

/// A kind of noise with its parameters, at unit frequency: about one feature to a lattice cell.
///
/// Its randomness comes from the [`Lattice`] alone: the seed, and the period after which it tiles.
pub trait Basis: Copy + Eq + Hash + Debug + Send + Sync + 'static {
    /// What it can be told.
    const PARAMETERS: &'static [Parameter] = &[];

    /// The noise with these parameters, which are in their ranges.
    fn new(settings: &Settings) -> Self;

    /// Continuity class.
    fn class(&self) -> Class;

    /// Bounds over all of space and all seeds, proven.
    fn bounds(&self) -> Bounds;

    /// Frequency in cycles a cell above which the noise has less than a hundredth of its peak power
    /// density: its upper -20 dB edge, which decides when an octave is too fine for a pixel.
    fn band(&self) -> f64;

    /// Which periods the noise can have; `Err` says in words what a period must be.
    fn tiles(&self, period: [u32; 3]) -> Result<(), &'static str> {
        let _ = period;
        Ok(())
    }

    /// Jets at a batch of points; see [`Kernel::jets`](crate::num::Kernel::jets).
    fn jets(&self, lattice: &Lattice, at: [&[f64]; 3], out: Jets<'_>);

    /// The jet at one point, with the same bits as in a batch.
    fn jet(&self, lattice: &Lattice, order: Order, at: [f64; 3]) -> Point;

    /// Whether `local` knows no more than the global bounds do.
    #[inline(always)]
    fn is_uniform(&self) -> bool {
        true
    }

    /// What is known of a ball; see [`Kernel::local`](crate::num::Kernel::local).
    fn local(&self, lattice: &Lattice, order: Order, at: [f64; 3], radius: f64) -> Local {
        let _ = radius;
        Local::uniform(self.jet(lattice, order, at), self.bounds())
    }

    /// What is known of a batch of balls, the same as of each alone.
    fn locals(&self, lattice: &Lattice, order: Order, at: [&[f64]; 3], radius: &[f64], out: &mut [Local]) {
        for (i, out) in out.iter_mut().enumerate() {
            *out = self.local(lattice, order, at.map(|at| at[i]), radius[i]);
        }
    }

    /// Absolute errors of a value, a gradient component and a second derivative from arithmetic
    /// alone, the position being exact.
    ///
    /// The default is for lattice noises with a quintic fade. The fade is off by up to 24 roundoffs
    /// near 1, on each of three axes alike, across a difference of corners of up to about 1: 72
    /// roundoffs and those of the blend, budgeted as 128. Gradients and Hessians have 256 and 1024
    /// times their larger bounds.
    #[inline(always)]
    fn rounding(&self) -> [f64; 3] {
        let b = self.bounds();
        [128.0 * ROUNDOFF * b.range, 256.0 * ROUNDOFF * b.lipschitz, 1024.0 * ROUNDOFF * b.hessian]
    }

    /// By how many roundoffs of its size the noise's own arithmetic may displace a position. None for
    /// lattice noises, whose fractional coordinates are exact.
    #[inline(always)]
    fn displacement(&self) -> f64 {
        0.0
    }
}
