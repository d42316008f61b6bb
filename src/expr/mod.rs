//! Expression graphs: what a script builds.
//!
//! Nodes are hash-consed: equal expressions are one node, whatever the order in which they were
//! built. Constants are folded and the identities of arithmetic applied on the way in. Arguments
//! precede their users, so that every walk over a graph is a loop over increasing node numbers and
//! no expression is too deep. A node remembers the place in the script that made it. [`text`] reads
//! expressions that other programs wrote.

mod carried;
mod derivative;
mod fingerprint;
mod fold;
mod graph;
mod linear;
mod mirror;
pub mod text;

pub use derivative::NoGradient;
pub use fold::{Identity, identity};
pub use graph::{Flow, Graph, Input, Node, NodeId, TooLarge};
