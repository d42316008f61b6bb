//! Explore: many pictures of one script, each with other parameters, to choose among and to breed.
//!
//! ```text
//! Space --sample, narrow, breed--> Specimen --Atelier--> picture
//!            ^                        |
//!            '------ favourites <-----'--export--> script
//! ```
//!
//! A [`Space`] is the box of all values that the parameters may have, each range seen as the unit interval. A
//! [`Gallery`] holds what was taken from it, generation by generation: plain data, made of nothing but the space, a
//! seed and the commands that it was given, so that the same choices lead to the same specimens again. A [`Subject`]
//! is the script, as it was when it was read; an [`Atelier`] draws in the background, roughly where that is asked for.
//!
//! On request children differ in expressions, too. A [`Genome`] then has a text of its own, in which a number, an
//! operation or a subtree is another one than in that of a parent; a [`Nurse`] tries what comes of it.

mod atelier;
mod breed;
mod gallery;
mod hilbert;
mod mutate;
mod nursery;
mod sample;
mod sketch;
mod space;
mod subject;

#[cfg(test)]
mod tests;

pub use atelier::{Atelier, Drawn, Grade, Image, Key, Ticket};
pub use gallery::{Command, Gallery, Generation, MOST, Refused, Specimen, Way};
pub use mutate::Change;
pub use nursery::{Nurse, Nursery, Raise};
pub use space::{Axis, Space};
pub use subject::{Genome, Subject, freeze};
