//! A choice that waits until the caster is needed: it takes a trial, which pictures that refine need not wait for.

use super::{CastStats, Caster, Hit, Ray, auto};
use crate::field::Field;
use crate::scene::Aabb;
use crate::tape::Cells;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// The caster that [`Kind::Auto`](super::Kind::Auto) chooses, chosen when it is first used, by whichever thread that is.
pub struct Later {
    own: Option<Box<dyn Caster>>,
    choice: Arc<Mutex<Choice>>,
}

/// What all clones share.
struct Choice {
    chosen: Option<Box<dyn Caster>>,
    field: Field,
    region: Aabb,
    cells: Arc<Cells>,
    typical: Vec<Vec<Ray>>,
}

impl Later {
    /// Arguments as of [`caster_in`](super::caster_in).
    pub fn new(field: Field, region: Aabb, cells: Arc<Cells>, typical: Vec<Vec<Ray>>) -> Later {
        let choice = Choice { chosen: None, field, region, cells, typical };
        Later { own: None, choice: Arc::new(Mutex::new(choice)) }
    }

    /// The caster; none where it is not chosen yet and `cancel` is set.
    fn caster(&mut self, cancel: &AtomicBool) -> Option<&mut Box<dyn Caster>> {
        if self.own.is_none() {
            self.own = self.choice.lock().unwrap_or_else(PoisonError::into_inner).caster(cancel);
        }
        self.own.as_mut()
    }
}

impl Choice {
    fn caster(&mut self, cancel: &AtomicBool) -> Option<Box<dyn Caster>> {
        let Choice { chosen, field, region, cells, typical } = self;
        if chosen.is_none() {
            let tried = auto(field, region, cells, typical, cancel);
            // What was chosen in a hurry means nothing.
            *chosen = (!cancel.load(Ordering::Relaxed)).then_some(tried);
        }
        chosen.as_ref().map(|caster| caster.clone_box())
    }
}

impl Caster for Later {
    fn first_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool) {
        if let Some(caster) = self.caster(cancel) {
            caster.first_hits(rays, out, stats, cancel);
        }
    }

    fn any_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool) {
        if let Some(caster) = self.caster(cancel) {
            caster.any_hits(rays, out, stats, cancel);
        }
    }

    fn costs(&self) -> &[f64] {
        self.own.as_ref().map_or(&[], |caster| caster.costs())
    }

    fn insides(&self) -> &[f64] {
        self.own.as_ref().map_or(&[], |caster| caster.insides())
    }

    fn values(&self) -> Option<Arc<Cells>> {
        self.choice.lock().unwrap_or_else(PoisonError::into_inner).chosen.as_ref()?.values()
    }

    fn clone_box(&self) -> Box<dyn Caster> {
        Box::new(Later { own: None, choice: self.choice.clone() })
    }
}
