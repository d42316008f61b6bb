//! Shapes made of data: meshes, curves, outlines and the like, whose parts are too many to be written
//! down as operations.
//!
//! A [`Shape`] is a function of space that enters expressions as a noise or a grid does: a
//! [`Kernel`], known by its jet at points and by what it says of balls around them. Distances say much:
//! with `d` the distance from a closed set, at a point `c` outside of it,
//!
//! ```text
//! |d(x) - d(c)| <= |x - c|                                              (it is 1-Lipschitz)
//! d(x) - d(c) - grad d(c) . (x - c) <= |x - c|^2 / (2 (d(c) - |x - c|))     (it is semiconcave)
//! ```
//!
//! so that a search for the nearest part at one point encloses the distance over a whole box. Each
//! shape is one file that implements [`Body`].

mod boxes;
mod census;
pub mod convolution;
mod crease;
pub mod curve;
mod distance;
mod lanes;
#[cfg(test)]
mod laws;
mod mesh;
pub mod outline;
mod parts;
mod strand;
pub mod tetrahedra;

pub use census::Census;
pub use crease::creased;
pub use distance::{Distance, Unfit};
pub use mesh::{Flaw, Mesh};
pub use parts::Parts;

pub use crate::num::Digest;
use crate::num::Kernel;
use std::fmt::Debug;
use std::hash::{Hash, Hasher};
use std::sync::Arc;

/// What a shape is made of. Its [`Kernel`] has no bound on the values in general, so that it states
/// the [error](Kernel::error) of its values itself.
pub trait Body: Kernel + Debug + Send {
    /// What it is called in scripts.
    fn name(&self) -> &'static str;

    /// Everything that it is made of, in a fixed order.
    fn digest(&self, digest: &mut Digest);
}

/// An immutable function of space that is made of data; cheap to clone. Two are equal if they are made
/// of the same data.
#[derive(Clone, Debug)]
pub struct Shape {
    body: Arc<dyn Body>,
    digest: Digest,
}

impl Shape {
    /// The shape of a body.
    pub fn new(body: impl Body + 'static) -> Shape {
        let mut digest = Digest::default();
        digest.text(body.name());
        body.digest(&mut digest);
        Shape { body: Arc::new(body), digest }
    }

    /// What it is made of.
    pub fn body(&self) -> &dyn Body {
        &*self.body
    }
}

impl PartialEq for Shape {
    fn eq(&self, other: &Self) -> bool {
        self.digest == other.digest
    }
}

impl Eq for Shape {}

impl Hash for Shape {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.digest.hash(state);
    }
}
