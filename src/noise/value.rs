//! Value noise with the quintic fade (Gamito 2009, 4.3.1).
//!
//! Every node of the integer lattice carries a value, uniform in `(-1, 1)`, and between nodes the
//! noise is their smooth interpolation (see [`blend`](super::blend)). Where gradient noise has no
//! power at low frequencies, value noise has most of its power there: soft blotches of all sizes
//! above a cell. Its extrema lie on nodes, which shows as a grid, its one vice. Over space and all
//! seeds it has mean 0 and variance `(181/231)^3 / 3`, which is 0.16036.

use super::basis::Basis;
use super::blend::{self, Blended};
use super::bulk;
use super::lattice::Lattice;
use super::node::Level;
use super::parameter::Settings;
use crate::num::{Bounds, Class, Jets, Order, Point};

/// Value noise at unit frequency: one lattice cell is one unit long.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub struct Value;

impl Basis for Value {
    fn new(_: &Settings) -> Self {
        Value
    }

    fn class(&self) -> Class {
        Class::C2
    }

    /// Proven by `examples/certify_noise.rs` (see [`certify`](super::certify)). The suprema
    /// themselves are 1, 15/4, 225/16 and 120, and are attained on whole planes of points, which is why
    /// boxes show a little less here than for other noises.
    #[inline]
    fn bounds(&self) -> Bounds {
        Bounds { range: 1.0, lipschitz: 3.78, hessian: 14.2, third: 121.2 }
    }

    /// The mean power spectrum is that of the weight, since nodes are independent: greatest at zero,
    /// and, averaged over shells of wave vectors, 20 dB below that at 0.90 cycles a cell (0.88 in planes).
    fn band(&self) -> f64 {
        0.9
    }

    #[inline(always)]
    fn rounding(&self) -> [f64; 3] {
        blend::rounding(&self.bounds())
    }

    fn jets(&self, lattice: &Lattice, at: [&[f64]; 3], out: Jets<'_>) {
        bulk::jets(|| Blended::<1, Level>::new(lattice), at, out);
    }

    fn jet(&self, lattice: &Lattice, order: Order, at: [f64; 3]) -> Point {
        bulk::jet(Blended::<1, Level>::new(lattice), order, at)
    }
}
