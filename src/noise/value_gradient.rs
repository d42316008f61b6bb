//! Value-gradient noise: every node carries a value and a direction (Gamito 2009, 4.12).
//!
//! The sum of value noise and gradient noise on one lattice, at the price of one: the corners of a
//! cell are blended once (see [`blend`](super::blend)). It has the low frequencies of value noise, yet
//! its extrema are off the nodes. Value and direction of a node are independent, so variances add up,
//! to 0.23328.

use super::basis::Basis;
use super::blend::{self, Blended};
use super::bulk;
use super::lattice::Lattice;
use super::node::{Directions, LevelAnd, OnEdges, OnSphere};
use super::parameter::{Parameter, Settings};
use crate::num::{Bounds, Class, Jets, Order, Point};

/// Value-gradient noise at unit frequency: one lattice cell is one unit long.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub struct ValueGradient {
    /// Directions of the nodes.
    pub directions: Directions,
}

impl Basis for ValueGradient {
    const PARAMETERS: &'static [Parameter] = &[Directions::PARAMETER];

    fn new(settings: &Settings) -> Self {
        ValueGradient { directions: Directions::of(settings) }
    }

    fn class(&self) -> Class {
        Class::C2
    }

    /// Proven by `examples/certify_noise.rs` (see [`certify`](super::certify)).
    #[inline]
    fn bounds(&self) -> Bounds {
        match self.directions {
            Directions::Edges => Bounds { range: 2.0365, lipschitz: 7.503, hessian: 28.55, third: 272.5 },
            Directions::Sphere => Bounds { range: 2.2249, lipschitz: 7.703, hessian: 29.4, third: 286.0 },
        }
    }

    /// The power spectra of value noise and gradient noise add up: greatest at zero, and 20 dB below
    /// that at 1.02 cycles a cell, averaged over shells of wave vectors (1.00 in planes).
    fn band(&self) -> f64 {
        1.05
    }

    #[inline(always)]
    fn rounding(&self) -> [f64; 3] {
        blend::rounding(&self.bounds())
    }

    fn jets(&self, lattice: &Lattice, at: [&[f64]; 3], out: Jets<'_>) {
        match self.directions {
            Directions::Edges => bulk::jets(|| Blended::<2, LevelAnd<OnEdges>>::new(lattice), at, out),
            Directions::Sphere => bulk::jets(|| Blended::<4, LevelAnd<OnSphere>>::new(lattice), at, out),
        }
    }

    fn jet(&self, lattice: &Lattice, order: Order, at: [f64; 3]) -> Point {
        match self.directions {
            Directions::Edges => bulk::jet(Blended::<2, LevelAnd<OnEdges>>::new(lattice), order, at),
            Directions::Sphere => bulk::jet(Blended::<4, LevelAnd<OnSphere>>::new(lattice), order, at),
        }
    }
}
