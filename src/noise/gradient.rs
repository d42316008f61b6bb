//! Gradient noise with the quintic fade (Perlin 2002; Gamito 2009, 4.2).
//!
//! Every node of the integer lattice carries a direction, one of twelve or any, chosen by a hash of
//! the node; around it the noise is the linear function with that gradient, blended into those of
//! the other corners of a cell (see [`blend`](super::blend)). At a node the noise is zero. Over space
//! and all seeds it has mean 0 and variance 0.07292, whichever the directions: its second moments
//! depend on those of the directions alone.

use super::basis::Basis;
use super::blend::{self, Blended};
use super::bulk;
use super::lattice::Lattice;
use super::node::{Directions, OnEdges, OnSphere};
use super::parameter::{Parameter, Settings};
use crate::num::{Bounds, Class, Jets, Order, Point};

/// Gradient noise at unit frequency: one lattice cell is one unit long.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub struct Gradient {
    /// Directions of the nodes.
    pub directions: Directions,
}

impl Gradient {
    /// With the twelve directions.
    pub const EDGES: Gradient = Gradient { directions: Directions::Edges };
    /// With directions uniform on the sphere.
    pub const SPHERE: Gradient = Gradient { directions: Directions::Sphere };
}

impl Basis for Gradient {
    const PARAMETERS: &'static [Parameter] = &[Directions::PARAMETER];

    fn new(settings: &Settings) -> Self {
        Gradient { directions: Directions::of(settings) }
    }

    fn class(&self) -> Class {
        Class::C2
    }

    /// Proven by `examples/certify_noise.rs` (see [`certify`](super::certify)). The suprema
    /// themselves, as far as a search can tell, are 1.036354, 3.75, 14.465146 and 150.670246 for the
    /// twelve directions.
    #[inline]
    fn bounds(&self) -> Bounds {
        match self.directions {
            Directions::Edges => Bounds { range: 1.0364, lipschitz: 3.751, hessian: 14.53, third: 150.8 },
            Directions::Sphere => Bounds { range: 1.2249, lipschitz: 3.952, hessian: 15.12, third: 164.2 },
        }
    }

    /// Nodes are independent, so the mean power spectrum is that of one node's part, whose Fourier
    /// transform is the gradient of that of the weight. Averaged over shells of wave vectors it peaks at
    /// 0.48 cycles a cell and is 20 dB down at 1.19, in planes at 1.15 to 1.18; a little is added.
    fn band(&self) -> f64 {
        1.25
    }

    /// With the twelve directions, half of what other nodes are charged: the differences to the three
    /// neighbours of a node are 1 at most.
    #[inline(always)]
    fn rounding(&self) -> [f64; 3] {
        let errors = blend::rounding(&self.bounds());
        if self.directions == Directions::Edges { errors.map(|e| 0.5 * e) } else { errors }
    }

    fn jets(&self, lattice: &Lattice, at: [&[f64]; 3], out: Jets<'_>) {
        match self.directions {
            Directions::Edges => bulk::jets(|| Blended::<1, OnEdges>::new(lattice), at, out),
            Directions::Sphere => bulk::jets(|| Blended::<3, OnSphere>::new(lattice), at, out),
        }
    }

    fn jet(&self, lattice: &Lattice, order: Order, at: [f64; 3]) -> Point {
        match self.directions {
            Directions::Edges => bulk::jet(Blended::<1, OnEdges>::new(lattice), order, at),
            Directions::Sphere => bulk::jet(Blended::<3, OnSphere>::new(lattice), order, at),
        }
    }
}
