//! The constants of noises, computed: a search from below, a proof from above.
//!
//! A bound that a noise states is a theorem, and its proof is a program: one file here for each
//! family of noises. [`ALL`] lists what they are asked to prove; `examples/certify_noise.rs` walks
//! the list and prints a table of what a search found, what was proven, and how far apart they are.
//! A bound is good when it lies above whatever an adversarial search finds and within a few
//! thousandths of it.

mod lattice;
mod scattered;

pub use lattice::{Method, SLACK, Witness, largest, prove, search};
pub use scattered::Spots;

/// A noise with fixed parameters whose bounds are to be proven.
pub trait Subject: Sync {
    /// Name in tables: the noise, then the settings that are not the default.
    fn name(&self) -> &'static str;

    /// What is claimed, in an order in which every claim leans on those before it.
    fn claims(&self) -> Vec<Claim>;

    /// The largest value of a derivative of this order that a search from so many starts finds: a
    /// lower bound on the supremum.
    fn search(&self, order: usize, starts: u64) -> f64;

    /// Proves a claim, those before it being proven. Returns how many boxes that took, or `None` if
    /// the claim is false or `budget` boxes do not settle one of its parts.
    fn prove(&self, claim: &Claim, budget: u64) -> Option<u64>;
}

/// The claim that no derivative of an order exceeds a bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Claim {
    /// Order of the derivative: 0 for the value.
    pub order: usize,
    /// What the bound is called: `A`, `L`, `M2`, `M3`, and beyond those `M4`, `M5`.
    pub name: &'static str,
    /// The bound.
    pub bound: f64,
}

/// Everything that is proven.
pub const ALL: &[&dyn Subject] = &[
    &lattice::Edges,
    &Spots { name: "sparse", ..SPOTS },
    &Spots { name: "sparse disc", margin: true, ..SPOTS },
    &Spots { name: "sparse lewis", lewis: true, ..SPOTS },
    &Spots { name: "sparse lewis disc", lewis: true, margin: true, ..SPOTS },
    &Spots { name: "gabor", frequency: 2.0, ..SPOTS },
    &Spots { name: "gabor disc", margin: true, frequency: 2.0, ..SPOTS },
    &Spots { name: "gabor 0.5", frequency: 0.5, ..SPOTS },
    &Spots { name: "gabor 8", frequency: 8.0, ..SPOTS },
];

const SPOTS: Spots = Spots { name: "", lewis: false, margin: false, frequency: 0.0 };
