//! Which parts of a solid are joined to one another.
//!
//! Noise that is added to a solid breaks crumbs off it. To tell them from the solid, and to know how many handles
//! and voids it has, there are two ways:
//!
//! * **Morse theory** ([`Complex`]), for fields with continuous second derivatives. As a level rises, the
//!   topology of `f < level` changes at critical points alone: a component is born at a minimum, two are joined or a
//!   ring closes at a 1-saddle, a tunnel is filled or a void closed off at a 2-saddle, a void filled at a maximum.
//!   So the critical points below zero, and which minima the paths downhill from 1-saddles come to, say all there
//!   is to say (Gamito 2009, chapter 8, with tolerances; here with proofs).
//! * **Flooding** ([`flood`]), for every field that has enclosures: an octree whose cells are in, out, or have a
//!   proven way downhill. It needs no derivatives of second order, and gives no counts.
//!
//! Where there are too many critical points to find them all, as on planets, [`local`] finds those that a question
//! is about.
//!
//! ```text
//! search:   cells --one evaluation on a ball each--> free of critical points | at most one | cut in eight
//! polish:   Newton's method, and the proof that there is one
//! complex:  basins of minima, paths downhill from saddles, union-find: components
//! ```
//!
//! What could not be decided is part of every result: degenerate critical points, values too close to zero, paths that
//! leave the region, and faces of the region that the solid may reach through ([`is_closed`]). Where there is none of
//! it, the result is a theorem about the solid in the region.

mod basin;
mod border;
mod cell;
mod complex;
mod descent;
pub mod flood;
mod isolated;
pub mod local;
mod matrix;
mod point;
mod polish;
mod search;
mod separatrix;
mod sets;
mod star;
mod verdict;
mod voids;

pub use border::is_closed;
pub use complex::{Arc1, Complex, Component, Locator};
pub use point::{CriticalPoint, Kind};
pub use search::{Critical, Search, SearchStats, search};
pub use separatrix::separatrices;
pub use voids::{Void, Voids, voids_by_flood, voids_by_points};
