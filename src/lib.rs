//! orogen: procedural solids from scripts.
pub mod noise;
pub mod num;
pub mod op;
