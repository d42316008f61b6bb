//! orogen: procedural solids from scripts.
pub mod num;
pub mod op;
