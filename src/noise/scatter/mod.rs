//! Noises made of scattered nodes: where the nodes are, and sums over those near a point.
//!
//! Space is cut into unit cells, and every cell holds a few nodes whose places and weights are
//! hashed from the cell's number, the seed and the number of the node within its cell. A spot of
//! radius 1 sits on every node (Lewis 1989; van Wijk 1991), so a point sees none but the nodes of
//! the 3 x 3 x 3 block of cells around its own:
//!
//! ```text
//! N(x) = sum_i w_i phi_i(x - n_i)        phi_i = 0 beyond distance 1
//! ```
//!
//! What the spots look like is told by a [`Spot`].
//!
//! **Placement.** *Uniform*: a fixed number of nodes, each uniform in the cell. *Poisson*: the number
//! is a Poisson variable, so that nothing at all tells where the cells are; it is cut off four
//! deviations above its mean, without which the noise would have no bounds. *Disc*: one node to a
//! cell, uniform in the cell less a margin of 0.3 on every side; no two nodes are closer than 0.6,
//! as on a Poisson disc, and derivatives of more than half the usual size cannot occur.
//!
//! **Weights** are independent, with mean 0 and variance 1. *Bell*: the sum of three uniform
//! variables, a bell that ends at 3 deviations and is computed exactly. *Uniform*: none beyond
//! `sqrt 3`, hence smaller bounds. Because weights are independent of all else and have mean zero,
//! mean and autocovariance of the noise are stationary for the uniform placement with any fixed
//! number of nodes (the expectation of `sum phi(x - n) phi(y - n)` is an integral over all of space);
//! the disc placement modulates the variance from cell centre to corner.
//!
//! **Speed.** One point at a time, the cells are the lanes of a vector; in bulk the points are. Cells
//! out of reach are skipped, alike for all lanes. Every spot contributes exact zeros beyond its
//! radius and sums run in one order, by node number and then by cell, so all ways give the same
//! bits.
//!
//! **Bounds in a ball.** The nodes near a ball are known, each at a distance from its centre that is
//! known up to the radius; so is the size of its spot's derivatives ([`Spot::sizes`]). Their sum
//! bounds the noise there, and so does the derivative at the centre plus what the next order adds on
//! the way; the smaller wins. For small balls this is many times tighter than any bound for all of
//! space, which has to expect all nodes of all cells at their worst places.

mod bulk;
mod near;
#[cfg(test)]
mod tests;
mod together;

pub(super) use bulk::jets;
pub(super) use near::{jet, local};
pub(super) use together::locals;

use super::lattice::{Lattice, hash};
use super::parameter::{Allowed, Parameter, Settings};
use crate::num::Point;

/// Where nodes are.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Placement {
    Uniform,
    Poisson,
    Disc,
}

/// How nodes are scattered.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) struct Scatter {
    /// Nodes to a cell, or their mean number; 1 for discs.
    nodes: u8,
    pub(super) placement: Placement,
    /// Whether weights are bells.
    bell: bool,
}

/// Nodes to a cell.
pub(super) const NODES: Parameter = Parameter {
    name: "nodes",
    doc: "nodes to a cell, the mean number for \"poisson\"; \"disc\" has one whatever this is",
    allowed: Allowed::Whole { least: 1, most: MOST as u32, default: 1 },
};

/// Where nodes are.
pub(super) const PLACEMENT: Parameter = Parameter {
    name: "placement",
    doc: "where nodes are: that many anywhere in every cell, as many as a Poisson variable says, or one kept away from all others",
    allowed: Allowed::Choice(&["uniform", "poisson", "disc"]),
};

/// The law of the weights.
pub(super) const WEIGHTS: Parameter = Parameter {
    name: "weights",
    doc: "weights of nodes: a bell that ends at 3 deviations, or uniform with the same variance",
    allowed: Allowed::Choice(&["bell", "uniform"]),
};

/// Largest number of nodes to a cell that can be asked for.
const MOST: usize = 8;

/// Margin of a cell that its node keeps in disc placement.
pub(super) const MARGIN: f64 = 0.3;

/// Most nodes that a cell can have.
const SLOTS: usize = 20;

/// For every mean number of nodes: the most that there can be, the mean and four deviations.
const MOST_OF_POISSON: [usize; MOST] = [5, 8, 10, 12, 14, 16, 18, SLOTS];

/// A hash is below entry `[mean - 1][n]` with the probability that there are more than `n` nodes.
const TAILS: [[u32; SLOTS]; MOST] = tails();

const fn tails() -> [[u32; SLOTS]; MOST] {
    let mut all = [[0; SLOTS]; MOST];
    let mut none = 1.0;
    let mut mean = 1;
    while mean <= MOST {
        none /= std::f64::consts::E;
        // The probabilities of n nodes, and of more.
        let (mut exactly, mut more, mut n) = (none, 1.0, 0);
        while n < MOST_OF_POISSON[mean - 1] {
            more -= exactly;
            all[mean - 1][n] = (more * 4_294_967_296.0) as u32;
            n += 1;
            exactly *= mean as f64 / n as f64;
        }
        mean += 1;
    }
    all
}

impl Scatter {
    pub(super) fn new(settings: &Settings) -> Scatter {
        let placement = match settings.name(PLACEMENT.name) {
            "poisson" => Placement::Poisson,
            "disc" => Placement::Disc,
            _ => Placement::Uniform,
        };
        let nodes = match placement {
            Placement::Disc => 1,
            _ => settings.number(NODES.name).clamp(1.0, MOST as f64) as u8,
        };
        Scatter { nodes, placement, bell: settings.name(WEIGHTS.name) != "uniform" }
    }

    /// Most nodes that a cell can have.
    pub(super) fn slots(&self) -> usize {
        match self.placement {
            Placement::Poisson => MOST_OF_POISSON[usize::from(self.nodes) - 1],
            _ => usize::from(self.nodes),
        }
    }

    /// Bound on the sum of the sizes of the weights of a cell.
    pub(super) fn most_weight(&self) -> f64 {
        self.slots() as f64 * if self.bell { 3.0 } else { 1.732_050_808 }
    }

    /// Roundoffs of sums over all nodes in reach, of sizes that add up to the bound for one: as many
    /// as there are terms, and 64 for each term by itself.
    pub(super) fn roundoffs(&self) -> f64 {
        (27 * self.slots() + 64) as f64
    }

    fn draw(&self, lattice: &Lattice) -> Draw {
        let margin = if self.placement == Placement::Disc { MARGIN } else { 0.0 };
        Draw {
            key: lattice.key(),
            margin,
            step: (1.0 - 2.0 * margin) / (1 << COORDINATE_BITS) as f64,
            side: 1.0 - 2.0 * margin,
            bell: self.bell,
            slots: self.slots(),
            tail: (self.placement == Placement::Poisson).then(|| &TAILS[usize::from(self.nodes) - 1]),
        }
    }
}

/// A node as seen from a point.
#[derive(Clone, Copy)]
pub(super) struct Node {
    /// The point less the node.
    pub d: [f64; 3],
    /// What its spot is multiplied by.
    pub weight: f64,
    /// A word of randomness; [`next`] gives more.
    pub word: u32,
}

/// A spot around a node, of radius 1.
pub(super) trait Spot: Copy + Send + Sync {
    /// The spot of a node, times its weight: exact zeros from distance 1 on, whatever is random about
    /// it. Without branches, for lanes.
    fn jet<const ORDER: u8>(&self, node: &Node) -> Point;

    /// Bounds on the sizes of value, gradient, second and third directional derivatives of spots of
    /// weight 1, at distances from `near` (which is below 1) to `far`. They may be off by 1e-12.
    fn sizes(&self, near: f64, far: f64) -> [f64; 4];
}

const COORDINATE_BITS: u32 = 22;

/// Tells the numbers of nodes, and the number of nodes, of one cell from one another.
const NUMBER: u32 = 0x27d4_eb2f;
const COUNT: u32 = 0x1656_67b1;

/// One more word from a word.
#[inline(always)]
pub(super) fn next(word: u32) -> u32 {
    (word ^ (word >> 15)).wrapping_mul(0xd168_aaad)
}

/// The upper bits of a word as a whole number that converts to `f64` in lanes.
#[inline(always)]
fn upper(word: u32, bits: u32) -> f64 {
    f64::from((word >> (32 - bits)) as i32)
}

/// The upper 31 bits of a word as a number in `[0, 1)`.
#[inline(always)]
pub(super) fn uniform(word: u32) -> f64 {
    upper(word, 31) * (0.5 / (1 << 30) as f64)
}

/// All that nodes are drawn from.
#[derive(Clone, Copy)]
struct Draw {
    key: [u32; 2],
    margin: f64,
    /// Side of the part of a cell that may hold nodes, and what a unit of a coordinate is worth.
    side: f64,
    step: f64,
    bell: bool,
    slots: usize,
    tail: Option<&'static [u32; SLOTS]>,
}

impl Draw {
    /// Node number `slot` of the cell with a word, seen from a point that is `reach` away from the
    /// least corner of where nodes may be.
    #[inline(always)]
    fn node(&self, word: u32, slot: usize, reach: [f64; 3]) -> Node {
        let x = hash(word ^ (slot as u32).wrapping_mul(NUMBER), self.key);
        let (y, z) = (next(x), next(next(x)));
        let w = next(z);
        let place = |axis: usize, word: u32| reach[axis] - upper(word, COORDINATE_BITS) * self.step;
        // Three numbers of ten bits; their variances of (1024^2 - 1) / 12 add up to that of a
        // variable with unit variance, times 512^2 and less a millionth.
        let sum = (w >> 22) + (w >> 12 & 1023) + (w >> 2 & 1023);
        let bell = f64::from(sum as i32) * (1.0 / 512.0) - 3069.0 / 1024.0;
        const ROOT: f64 = 1.732_050_807_568_877_2;
        let flat = upper(w, 31) * (ROOT / (1 << 30) as f64) - ROOT;
        Node {
            d: [place(0, x), place(1, y), place(2, z)],
            weight: if self.bell { bell } else { flat },
            word: next(w),
        }
    }

    /// The word that decides how many nodes a cell has.
    #[inline(always)]
    fn count(&self, word: u32) -> u32 {
        hash(word ^ COUNT, self.key)
    }

    /// Square of the distance along an axis to the part of a cell that may hold nodes.
    #[inline(always)]
    fn distance(&self, reach: f64) -> f64 {
        let above = reach - self.side;
        let out = if above > -reach { above } else { -reach };
        if out < 0.0 { 0.0 } else { out * out }
    }
}

/// Squared distance beyond which no rounding brings a node within reach of its spot.
const BEYOND: f64 = 1.0 + 1e-12;
