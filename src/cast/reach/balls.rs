//! Bundles forwards by empty balls: cone tracing (thesis, 7.2).
//!
//! Where `f > 0` and `f` has the Lipschitz bound `L`, the ball of radius `f / L` is empty. Around a place of the middle
//! line at depth `z` it covers the whole section of the bundle, a disc of radius `r(z)`, if it is larger than that,
//! and then also the sections around: with the step `q` of the middle line for a unit of depth, and its part `a`
//! across the frame, points at depth `z + s` are within
//!
//! ```text
//! (s |q|)^2 + 2 |s| a r(z + s) + r(z + s)^2          r(z + s) = r(z) + g s
//! ```
//!
//! squared, of its middle, and `s` goes up to where that is the square of the ball's radius. Balls that follow one another
//! must leave no gap between the sections that they cover.
//!
//! Nothing is known of the field outside of the region. Places of the middle line that lie there are moved to its
//! nearest point, which brings them closer to all points of the region: a ball around the one that is empty within the
//! region is so around the other.

use super::Reach;
use crate::cast::CastStats;
use crate::cast::beam::{Bundle, State};
use crate::num::{Many, ROUNDOFF};
use crate::scene::Aabb;
use crate::tape::{Cells, Evaluator};
use glam::DVec3;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Places evaluated together.
const LANES: usize = 32;

/// How far beyond its ball a bundle looks next, as a multiple of its radius: as speculative sphere tracing does.
const RELAXATION: f64 = 1.46;

/// A bundle ends where a ball covers less depth ahead than this share of its own width: its parts will do better.
const NARROW: f64 = 0.5;

/// Goes forwards by balls; see the module text.
pub(super) struct Balls {
    lipschitz: f64,
    region: Aabb,
    cells: Arc<Cells>,
    points: Evaluator<Many<f64, LANES>>,
    probes: Vec<Probe>,
}

/// A bundle under way.
#[derive(Clone, Copy)]
struct Probe {
    bundle: usize,
    /// The depth of the ball that is asked for, and its middle.
    depth: f64,
    at: DVec3,
}

impl Balls {
    pub(super) fn new(lipschitz: f64, region: Aabb, cells: Arc<Cells>) -> Balls {
        let points = Evaluator::new(cells.tape().clone());
        Balls { lipschitz, region, cells, points, probes: Vec::new() }
    }

    /// The field at all probes, by the tapes of the places where they are; `tell` gets each value. Once `cancel` is
    /// set, no more are told.
    fn ask(&mut self, stats: &mut CastStats, cancel: &AtomicBool, mut tell: impl FnMut(&mut Probe, f64)) {
        let Balls { cells, points, probes, .. } = self;
        stats.evaluations += probes.len() as u64;
        stats.shared += probes.len() as u64;
        stats.steps += probes.len() as u64;
        let places = probes.iter().enumerate().map(|(i, probe)| (i, probe.at.to_array(), 0.0));
        for same in cells.tapes_around(places).chunk_by(|a, b| Arc::ptr_eq(a.0, b.0)) {
            points.turn_to(same[0].0);
            for batch in same.chunks(LANES).take_while(|_| !cancel.load(Ordering::Relaxed)) {
                // Idle lanes repeat the last.
                let place = |lane: usize| probes[batch[lane.min(batch.len() - 1)].1].at;
                let values = points
                    .eval(&std::array::from_fn(|axis| Many(std::array::from_fn(|lane| place(lane)[axis]))));
                stats.work += same[0].0.work() * LANES as u64;
                let values = values.0;
                batch.iter().zip(values).for_each(|(&(_, i), value)| tell(&mut probes[i], value));
            }
        }
    }
}

impl Bundle {
    /// The ball to look at first, or next.
    fn probe(&self, bundle: usize, depth: f64, region: &Aabb) -> Probe {
        let middle = self.section.spine_at(&self.frame, depth);
        Probe { bundle, depth, at: middle.clamp(region.min, region.max) }
    }

    /// Takes the radius of the ball at a depth, and gives the depth of the next.
    fn take_ball(&mut self, depth: f64, radius: f64) -> Option<f64> {
        let covered = self.section.covered(depth, radius);
        let leaves_no_gap = |[behind, _]: &[f64; 2]| depth - behind <= self.march.free;
        match covered.filter(leaves_no_gap) {
            Some([_, beyond]) => {
                self.march.skip(depth + beyond);
                if self.march.free >= self.march.far {
                    self.state = State::Free;
                    return None;
                }
                if beyond < NARROW * self.section.radius(depth) {
                    self.state = State::Ended;
                    return None;
                }
                Some((depth + RELAXATION * beyond).min(self.march.far))
            }
            // It was too far ahead; one around the frontier leaves no gap.
            None if depth > self.march.free => Some(self.march.free),
            None => {
                self.state = State::Ended;
                None
            }
        }
    }
}

impl Reach for Balls {
    fn advance(&mut self, bundles: &mut [&mut Bundle], stats: &mut CastStats, cancel: &AtomicBool) {
        let (region, lipschitz) = (self.region, self.lipschitz);
        let marching = bundles.iter().enumerate().filter(|(_, bundle)| bundle.state == State::Marching);
        self.probes.clear();
        self.probes.extend(marching.map(|(i, bundle)| bundle.probe(i, bundle.march.free, &region)));
        while !self.probes.is_empty() && !cancel.load(Ordering::Relaxed) {
            let mut backtracks = 0;
            self.ask(stats, cancel, |probe, f| {
                let bundle = &mut *bundles[probe.bundle];
                // A hair less, for the rounding of the field, of this division, and of the place.
                let rounding = 8.0 * ROUNDOFF * probe.at.abs().max_element() + bundle.frame.hair(probe.depth);
                let radius = f / lipschitz * (1.0 - 1e-12) - rounding;
                match bundle.take_ball(probe.depth, radius) {
                    Some(next) => {
                        backtracks += u64::from(next < probe.depth);
                        *probe = bundle.probe(probe.bundle, next, &region);
                    }
                    None => probe.depth = f64::NAN,
                }
            });
            stats.backtracks += backtracks;
            self.probes.retain(|probe| !probe.depth.is_nan());
        }
        stats.culled += bundles.iter().filter(|bundle| bundle.is_free()).count() as u64;
    }

    fn clone_box(&self) -> Box<dyn Reach> {
        Box::new(Balls::new(self.lipschitz, self.region, self.cells.clone()))
    }
}
