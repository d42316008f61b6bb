//! Casting by beams with certificates on both sides.
//!
//! Rays that start at one point and keep together share what is certain of all of them. A beam of 64
//! rays marches until its own width is what limits it; its four quarters go on from there, then their
//! quarters, then the rays, each with a prediction of its root from the last answer of its beam (the
//! notes on ray casting, 9.6; Keeter's and others' tiles are the same idea with intervals). Beams of
//! all tiles at one level are answered together, in batches.
//!
//! Shadow rays are parallel, and all begin on the surface, where nothing can be shared. So they are
//! marched from their other ends: the beam crosses free space at once, and what is left to its rays is
//! the last bit, down to where each began.

mod batch;
mod bundle;
mod frame;
mod march;
mod sketch;
mod thin;
mod worth;

use super::{CastStats, Caster, Hit, Ray};
use crate::tape::{Cells, Evaluator};
pub(super) use batch::Batches;
pub use bundle::Bundle;
use bundle::FIRST;
pub(super) use bundle::{State, march_bundles};
pub use frame::Frame;
use frame::{Section, is_real};
use glam::DVec3;
use march::{March, PIECES};
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use thin::{Thin, Want};

/// Rays of the widest beams, where the field is the same expression everywhere,
const WIDEST: usize = 64;

/// and where parts of it matter in some places only: what is far from all of them is long to evaluate.
const WIDEST_OF_PARTS: usize = 1024;

/// Parts that a beam is cut into.
const PARTS: usize = 4;

/// Casts by beams; see the module text.
pub(super) struct Beams {
    cells: Arc<Cells>,
    wide: Batches<2>,
    thin: Batches<0>,
    /// The field at single points.
    points: Evaluator<f64>,
    memory: Memory,
}

/// Lists that are kept from group to group.
#[derive(Default)]
struct Memory {
    beams: Vec<Beam>,
    parts: Vec<Beam>,
    thin: Vec<Thin>,
    /// Entries of a list that are under way.
    active: Vec<usize>,
    /// Rays turned around.
    turned: Vec<Ray>,
    /// Evaluations for each ray of the last group.
    costs: Vec<f64>,
}

/// Rays that march together.
struct Beam {
    /// Of the group.
    rays: Range<usize>,
    bundle: Bundle,
}

impl AsRef<Bundle> for Beam {
    fn as_ref(&self) -> &Bundle {
        &self.bundle
    }
}

impl AsMut<Bundle> for Beam {
    fn as_mut(&mut self) -> &mut Bundle {
        &mut self.bundle
    }
}

impl Beam {
    /// Cuts the beam into parts, or into rays.
    fn cut(
        &self,
        rays: &[Ray],
        want: Want,
        (parts, thin): (&mut Vec<Beam>, &mut Vec<Thin>),
        out: &mut [Hit],
    ) {
        let Bundle { frame, march, .. } = &self.bundle;
        let size = (self.rays.len().next_power_of_two() / PARTS).max(1);
        for start in self.rays.clone().step_by(size) {
            let all = start..(start + size).min(self.rays.end);
            let Some(range) = trimmed(rays, all) else { continue };
            if range.len() > 1 {
                let section = Section::around(frame, &rays[range.clone()]);
                match self.bundle.onward(section, range.len()) {
                    Some(bundle) => parts.push(Beam { rays: range, bundle }),
                    None => out[range].fill(Hit::MISS),
                }
            } else {
                let ray = &rays[range.start];
                let distance = |depth: f64| frame.distance(ray, depth);
                let free = march.free;
                let near = distance(free - frame.hair(free)).max(ray.near);
                if near > ray.far {
                    out[range.start] = Hit::MISS;
                    continue;
                }
                let stretch = distance(free + march.stretch) - distance(free);
                let root = self.bundle.root(frame.place(ray)).map(distance);
                let march = want.march(near, ray.far, stretch, root);
                thin.push(Thin::new(range.start, march));
            }
        }
    }
}

impl Beams {
    pub(super) fn new(cells: Arc<Cells>) -> Beams {
        let (wide, thin) = (Batches::new(cells.tape()), Batches::new(cells.tape()));
        let points = Evaluator::new(cells.tape().clone());
        Beams { wide, thin, points, cells, memory: Memory::default() }
    }

    /// The widest beams of a group, and the rays that go alone.
    fn gather(&mut self, rays: &[Ray], want: Want, out: &mut [Hit]) {
        let Memory { beams, thin, .. } = &mut self.memory;
        let widest = if self.cells.is_uniform() { WIDEST } else { WIDEST_OF_PARTS };
        for start in (0..rays.len()).step_by(widest) {
            let own = start..(start + widest).min(rays.len());
            let Some(range) = trimmed(rays, own) else { continue };
            if let Some(frame) = Frame::new(&rays[range.clone()]) {
                let section = Section::around(&frame, &rays[range.clone()]);
                let [near, far] = section.depth;
                let march = March::new(near, far, FIRST * (far - near), None);
                let own = (range.len(), rays[range.start].tolerance);
                beams.push(Beam { rays: range, bundle: Bundle::of(frame, section, march, own) });
            } else {
                thin.extend(range.filter(|&i| is_real(&rays[i])).map(|ray| {
                    let Ray { near, far, .. } = rays[ray];
                    Thin::new(ray, want.march(near, far, FIRST * (far - near), None))
                }));
            }
        }
        for (hit, _) in out.iter_mut().zip(rays).filter(|(_, ray)| !is_real(ray)) {
            *hit = Hit::MISS;
        }
    }

    /// Marches beams until each is free or too wide to go on.
    fn march_beams(&mut self, stats: &mut CastStats, cancel: &AtomicBool) {
        let Memory { beams, active, costs, .. } = &mut self.memory;
        march_bundles(
            (&self.cells, &mut self.wide),
            (beams, active),
            stats,
            cancel,
            |Beam { rays, .. }| {
                let share = 1.0 / rays.len() as f64;
                costs[rays.clone()].iter_mut().for_each(|cost| *cost += share);
            },
        );
    }

    /// Marches rays to their ends.
    fn march_rays(&mut self, rays: &[Ray], want: Want, stats: &mut CastStats, cancel: &AtomicBool) {
        let Memory { thin, active, costs, .. } = &mut self.memory;
        active.clear();
        active.extend(0..thin.len());
        let goes_on = || !cancel.load(Ordering::Relaxed);
        while !active.is_empty() && goes_on() {
            for &i in active.iter().take_while(|_| goes_on()) {
                let ray = &rays[thin[i].ray];
                thin[i].place(&self.cells, ray);
            }
            active.retain(|&i| thin[i].hit.is_none());
            stats.evaluations += active.len() as u64;
            stats.steps += active.len() as u64;
            stats.work += self.thin.answer(
                &self.cells,
                (&mut thin[..], &active[..]),
                |thin| thin::around(&rays[thin.ray], thin.piece),
                |thin| (thin.piece, thin.coordinates(&rays[thin.ray])),
                |thin, _, answer| {
                    let ray = &rays[thin.ray];
                    let mut value = |at: DVec3| *self.points.eval(&at.to_array());
                    let answer =
                        if self.cells.is_defined() { answer } else { thin.checked(ray, answer, &mut value) };
                    thin.tell(ray, &answer, want, value);
                    costs[thin.ray] += 1.0;
                },
                cancel,
            );
            active.retain(|&i| thin[i].hit.is_none());
        }
    }
}

/// The range from the first ray of which there is anything to the last.
fn trimmed(rays: &[Ray], range: Range<usize>) -> Option<Range<usize>> {
    let first = range.clone().find(|&i| is_real(&rays[i]))?;
    let last = range.rev().find(|&i| is_real(&rays[i]))?;
    Some(first..last + 1)
}

impl Beams {
    fn cast(
        &mut self,
        rays: &[Ray],
        want: Want,
        out: &mut [Hit],
        stats: &mut CastStats,
        cancel: &AtomicBool,
    ) {
        stats.rays += rays.len() as u64;
        let memory = &mut self.memory;
        memory.beams.clear();
        memory.thin.clear();
        memory.costs.clear();
        memory.costs.resize(rays.len(), 0.0);
        self.gather(rays, want, out);
        while !self.memory.beams.is_empty() {
            self.march_beams(stats, cancel);
            let Memory { beams, parts, thin, .. } = &mut self.memory;
            for beam in beams.iter() {
                match beam.bundle.state {
                    State::Free => out[beam.rays.clone()].fill(Hit::MISS),
                    State::Ended => beam.cut(rays, want, (parts, thin), out),
                    // Given up.
                    State::Marching => {}
                }
            }
            beams.clear();
            std::mem::swap(beams, parts);
        }
        self.march_rays(rays, want, stats, cancel);
        for Thin { ray, march, hit, .. } in &self.memory.thin {
            if let Some(hit) = *hit {
                out[*ray] = hit;
                stats.hits += u64::from(hit.is_hit());
                stats.uncertified += u64::from(!hit.certified);
                stats.given_up += u64::from(march.pieces > PIECES && !hit.certified);
            }
        }
    }
}

impl Caster for Beams {
    fn first_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool) {
        self.cast(rays, Want::First, out, stats, cancel);
    }

    fn any_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool) {
        let mut turned = std::mem::take(&mut self.memory.turned);
        turned.clear();
        turned.extend(rays.iter().map(|&Ray { origin, direction, near, far, tolerance }| Ray {
            origin,
            direction: -direction,
            near: -far,
            far: -near,
            tolerance,
        }));
        self.cast(&turned, Want::Any, out, stats, cancel);
        self.memory.turned = turned;
        for (hit, ray) in out.iter_mut().zip(rays).filter(|(hit, _)| hit.is_hit()) {
            // Somewhere behind the beginning.
            hit.t = ray.near;
        }
    }

    fn costs(&self) -> &[f64] {
        &self.memory.costs
    }

    fn clone_box(&self) -> Box<dyn Caster> {
        Box::new(Beams::new(self.cells.clone()))
    }
}
