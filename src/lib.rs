//! orogen: procedural solids from scripts.

// Module documentation is for readers of the source too, who can follow links to private items.
#![allow(rustdoc::private_intra_doc_links)]
// What tests make of random numbers need not be the same on every platform.
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod cast;
pub mod cli;
pub mod diag;
pub mod expr;
pub mod field;
pub mod noise;
pub mod num;
pub mod op;
pub mod render;
pub mod scene;
pub mod script;
pub mod session;
pub mod tape;
pub mod world;
