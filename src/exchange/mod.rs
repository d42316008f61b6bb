//! Files of other programs, in and out: drawings, polygon meshes, pictures and volumes.
//!
//! | module | formats | what they become |
//! |---|---|---|
//! | [`drawing`] | SVG | what an [`Outline`](crate::shape::outline::Outline) is made of |
//! | [`grid`] | raw numbers with a header in JSON | [`Samples`](crate::grid::Samples) of a volume |
//! | [`image`] | PNG, EXR | heights, and slices of volumes |
//! | [`mesh`] | glTF, OBJ, PLY, STL | a [`Mesh`](crate::shape::Mesh) |
//!
//! Readers take bytes, writers take anything that can be written to; where the bytes are, and that a
//! file appears whole or not at all, is the business of [`world`](crate::world).
//!
//! A file is a claim. Readers believe none of it: a count is compared with the bytes that follow before
//! there is room made for it, so that memory stays in proportion to the length of the file, an index with
//! the things that it counts, and a number with the finite ones. What is wrong is a [`Fault`], which
//! says where. Writers give the same bytes for the same data, always.

pub mod drawing;
mod fault;
pub mod grid;
pub mod image;
pub mod mesh;
mod text;

pub use fault::{Fault, Place};
