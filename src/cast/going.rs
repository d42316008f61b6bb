//! Rays on their way through a solid of which a judge rejects something: where each is, and how it got there.

use super::{CastStats, Hit, Ray};
use std::sync::atomic::{AtomicBool, Ordering};

/// A ray under way.
#[derive(Clone, Copy)]
pub(super) struct Going {
    /// Of the group.
    pub ray: usize,
    /// Whether nothing that counts was missed so far, and if not, whether that is for want of a proof.
    pub certified: bool,
    pub given_up: bool,
    pub place: Place,
}

/// Where a ray is.
#[derive(Clone, Copy)]
pub(super) enum Place {
    /// Outside, or at its beginning; nothing before this counts.
    Free(f64),
    /// At a hit, which is to be judged.
    Met(Met),
    /// Inside what was rejected.
    Rejected(f64),
}

impl Place {
    pub fn t(self) -> f64 {
        let (Place::Free(t) | Place::Met(Met { t, .. }) | Place::Rejected(t)) = self;
        t
    }
}

/// A hit at `t`, which is to be judged by the place `at`.
#[derive(Clone, Copy)]
pub(super) struct Met {
    pub t: f64,
    pub at: f64,
    pub how: How,
}

/// How a ray met something.
#[derive(Clone, Copy)]
pub(super) enum How {
    /// It is inside.
    Entered,
    /// The same, as its caster says: too close to the surface to go on from there.
    Known,
    /// It may not be; all that is close enough to matter ends here.
    Grazed { end: f64 },
    /// It was inside of something else, and no gap was found.
    Stayed,
}

/// Rays on their way to their hits.
pub(super) struct Sifting<'a> {
    pub rays: &'a [Ray],
    pub out: &'a mut [Hit],
    pub going: Vec<Going>,
    /// All that was counted, each cast for itself.
    pub stats: CastStats,
    /// Rays given up here.
    pub given_up: u64,
    /// What is counted once for each ray.
    pub total: CastStats,
    pub cancel: &'a AtomicBool,
}

impl<'a> Sifting<'a> {
    /// Nothing is under way yet; `stats` are those of what was done before.
    pub fn new(rays: &'a [Ray], out: &'a mut [Hit], stats: CastStats, cancel: &'a AtomicBool) -> Sifting<'a> {
        let total = CastStats { rays: rays.len() as u64, ..CastStats::default() };
        Sifting { rays, out, going: Vec::new(), stats, given_up: 0, total, cancel }
    }

    pub fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }

    pub fn ray(&self, going: &Going) -> &Ray {
        &self.rays[going.ray]
    }

    /// A ray has its answer.
    pub fn settle(&mut self, going: Going, hit: Hit) {
        let hit = Hit { certified: hit.certified && going.certified, ..hit };
        self.out[going.ray] = hit;
        self.total.hits += u64::from(hit.is_hit());
        self.total.uncertified += u64::from(!hit.certified);
        self.given_up += u64::from(going.given_up);
    }
}

impl Going {
    pub fn new(ray: usize, near: f64, certified: bool) -> Going {
        Going { ray, certified, given_up: false, place: Place::Free(near) }
    }

    /// Goes on, with or without a proof.
    pub fn at(self, place: Place, proven: bool) -> Going {
        Going { place, certified: self.certified && proven, given_up: self.given_up || !proven, ..self }
    }
}
