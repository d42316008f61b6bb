//! How far whole bundles of lines of sight are proven to meet nothing: what pictures that refine step by step are
//! made of.
//!
//! A tile of a picture is a bundle of lines ([`Bundle`]). Taken forwards until its own width is in the way, it shows
//! where its part of the solid may begin at the earliest; its quarters go on from there. Whatever is not proven free
//! is painted, so that every picture on the way shows all of the solid, and perhaps more. Two ways:
//!
//! | way | looks at | by | thesis | in |
//! |---|---|---|---|---|
//! | [`Balls`] | balls around places of the middle line | a Lipschitz bound of all of the region | 7.2 | `balls.rs` |
//! | [`Bands`] | pieces of the bundle | enclosures, also where there is no such bound | 7.3 | `bands.rs` |
//!
//! Both measure by depth planes that all tiles of a picture share, so that a part starts exactly where its whole
//! ended. (Gamito, *Techniques for Stochastic Implicit Surface Modelling and Rendering*, 2009, chapter 7, has cones,
//! each with tilted discs of its own, for the one, and a tree of cells with a search in depth for the other.)

mod balls;
mod bands;

use super::beam::Bundle;
use super::{CastStats, Caster};
use crate::scene::Aabb;
use crate::tape::Cells;
use balls::Balls;
use bands::Bands;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A way to take bundles forwards. One value serves one thread; `clone_box` makes another.
pub trait Reach: Send {
    /// Takes bundles forwards as far as each is proven to meet nothing as a whole. Once `cancel` is set, those that
    /// are still under way are left where they are.
    fn advance(&mut self, bundles: &mut [&mut Bundle], stats: &mut CastStats, cancel: &AtomicBool);

    /// The same with memory of its own, for another thread.
    fn clone_box(&self) -> Box<dyn Reach>;
}

/// The way that goes with a caster of rays within a region: by balls for those that trace spheres, with the same bound, and
/// by bands for all others.
pub fn reach(caster: &dyn Caster, region: &Aabb, cells: &Arc<Cells>) -> Box<dyn Reach> {
    if let Some(lipschitz) = caster.lipschitz() {
        let values = caster.values().unwrap_or_else(|| cells.of_values(&region.intervals()));
        return Box::new(Balls::new(lipschitz, *region, values));
    }
    Box::new(Bands::new(cells.clone()))
}
