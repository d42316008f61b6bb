//! Casting by beams with certificates on both sides.
//!
//! Rays that go the same way, from one point or alongside one another, share what is certain of all of them. A beam
//! of 64 rays marches until its own width is what limits it; its four quarters go on from there, then their
//! quarters, then the rays, each with a prediction of its root from the last answer of its beam (the
//! notes on ray casting, 9.6; Keeter's and others' tiles are the same idea with intervals). Where the field is flat across
//! a beam its last answer ends its rays as well (`close.rs`), and where it falls along all of its rays, values at points do
//! (`fall.rs`). Beams of all tiles at one level are answered together, in batches.
//!
//! Shadow rays all begin on the surface, where nothing can be shared. So they are marched from their other
//! ends: the beam crosses free space at once, and what is left to its rays is the last bit, down to where each
//! began. Rays that light is reflected along are shortened in the same way before each goes on alone: the sky
//! above them is free.

mod batch;
mod bundle;
mod close;
mod fall;
mod frame;
mod gather;
mod march;
mod onward;
mod sketch;
mod thin;
mod worth;

use super::{CastStats, Caster, Hit, Ray};
use crate::num::Class;
use crate::tape::{Cells, Evaluator};
pub(super) use batch::Batches;
pub use bundle::Bundle;
use bundle::FIRST;
pub(super) use bundle::{State, march_bundles};
use close::Closing;
use fall::Falls;
pub use frame::Frame;
pub(super) use frame::{Line, Section};
pub(super) use gather::{gather, is_from_surface, is_real, quarters, trimmed, turned};
use glam::DVec3;
use march::{March, PIECES};
pub(super) use onward::Onward;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use thin::{Thin, Want, march_alone};

/// Rays of the widest beams, where the field is the same expression everywhere,
const WIDEST: usize = 64;

/// and where parts of it matter in some places only: what is far from all of them is long to evaluate.
const WIDEST_OF_PARTS: usize = 1024;

/// Rays of the smallest beams; and where there are parts: much is close to a beam that is not close to its rays.
const SMALLEST: usize = 2;
const SMALLEST_OF_PARTS: usize = 5;

/// Casts by beams; see the module text.
pub(super) struct Beams {
    cells: Arc<Cells>,
    wide: Batches<2>,
    thin: Batches<0>,
    /// The field at single points.
    points: Evaluator<f64>,
    /// For a field that is one expression everywhere: of parts, each ball would have a tape of its own.
    falls: Option<Falls>,
    /// Whether every ray begins next to the surface and marches alone.
    is_alone: bool,
    memory: Memory,
}

/// Lists that are kept from group to group.
#[derive(Default)]
struct Memory {
    beams: Vec<Beam>,
    parts: Vec<Beam>,
    /// All rays, as they look from the frames of their beams: what is left of them.
    lines: Vec<Line>,
    closing: Closing,
    thin: Vec<Thin>,
    /// Numbers of the rays that belong to no beam.
    alone: Vec<usize>,
    /// Entries of a list that are under way.
    active: Vec<usize>,
    /// Rays turned around.
    turned: Vec<Ray>,
    /// Evaluations for each ray of the last group.
    costs: Vec<f64>,
    /// Where each ray of the last group is inside, or infinity.
    insides: Vec<f64>,
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
    /// Those of its rays that have not ended.
    fn left(&self, lines: &[Line]) -> impl Iterator<Item = usize> {
        self.rays.clone().filter(|&i| lines[i].is_real())
    }

    /// Shares an evaluation among them.
    fn charge(&self, lines: &[Line], costs: &mut [f64]) {
        let share = 1.0 / self.left(lines).count() as f64;
        self.left(lines).for_each(|i| costs[i] += share);
    }

    /// Cuts the beam into parts, or into rays where these would be fewer than `smallest`.
    fn cut(
        &self,
        (rays, lines): (&[Ray], &[Line]),
        (want, smallest): (Want, usize),
        (parts, thin): (&mut Vec<Beam>, &mut Vec<Thin>),
        out: &mut [Hit],
    ) {
        for all in quarters(self.rays.clone()) {
            let Some(range) = trimmed(all, |i| lines[i].is_real()) else { continue };
            let left = range.clone().filter(|&i| lines[i].is_real());
            let count = left.clone().count();
            if count >= smallest {
                let section = Section::around(&self.bundle.frame, &lines[range.clone()]);
                match self.bundle.onward(section, count) {
                    Some(bundle) => parts.push(Beam { rays: range, bundle }),
                    None => left.for_each(|i| out[i] = Hit::MISS),
                }
                continue;
            }
            for i in left {
                match self.onward(i, (&rays[i], &lines[i]), want) {
                    Some(ray) => thin.push(ray),
                    None => out[i] = Hit::MISS,
                }
            }
        }
    }

    /// A ray of the beam, which goes on alone; `None` where it ends before the beam did.
    fn onward(&self, number: usize, (ray, line): (&Ray, &Line), want: Want) -> Option<Thin> {
        let Bundle { frame, march, .. } = &self.bundle;
        let distance = |depth: f64| line.distance(depth);
        let free = march.free.max(line.depth[0]);
        let near = distance(free - frame.hair(free)).max(ray.near);
        if near > ray.far {
            return None;
        }
        let stretch = distance(free + march.stretch) - distance(free);
        let root = self.bundle.root(&line.place).map(distance);
        let left = Ray { near, ..*ray };
        Some(Thin::new(number, left, want.march(&left, stretch, root)))
    }
}

impl Beams {
    pub(super) fn new(cells: Arc<Cells>) -> Beams {
        let (wide, thin) = Default::default();
        let points = Evaluator::new(cells.tape().clone());
        let is_smooth = cells.is_uniform() && cells.tape().class() > Class::Jump;
        let falls = is_smooth.then(|| Falls::new(cells.clone()));
        Beams { wide, thin, points, falls, cells, is_alone: false, memory: Memory::default() }
    }

    /// The same for rays that begin next to the surface, where they have nothing in common.
    pub(super) fn alone(cells: Arc<Cells>) -> Beams {
        Beams { is_alone: true, falls: None, ..Beams::new(cells) }
    }

    /// The same with memory of its own.
    pub(super) fn again(&self) -> Beams {
        let made = if self.is_alone { Beams::alone } else { Beams::new };
        made(self.cells.clone())
    }

    /// The widest beams of a group, and the rays that go alone.
    fn gather(&mut self, rays: &[Ray], want: Want, out: &mut [Hit]) {
        let Memory { beams, alone, lines, .. } = &mut self.memory;
        lines.clear();
        lines.resize(rays.len(), Line::NOTHING);
        let widest = if self.cells.is_uniform() { WIDEST } else { WIDEST_OF_PARTS };
        if self.is_alone {
            alone.extend((0..rays.len()).filter(|&i| is_real(&rays[i])));
        } else {
            gather(rays, widest, want == Want::Any, |range, frame| {
                let own = range.clone().filter(|&i| is_real(&rays[i]));
                let Some(frame) = frame else { return alone.extend(own) };
                own.clone().for_each(|i| lines[i] = frame.line(&rays[i]));
                let section = Section::around(&frame, &lines[range.clone()]);
                let [near, far] = section.depth;
                let march = March::new(near, far, FIRST * (far - near), None);
                let all = (own.count(), rays[range.start].tolerance);
                let bundle = Bundle::of(frame, section, march, all);
                // Any hit needs no bracket around a root.
                let bundle = if want == Want::First { bundle.that_closes() } else { bundle };
                beams.push(Beam { rays: range, bundle });
            });
        }
        for (hit, _) in out.iter_mut().zip(rays).filter(|(_, ray)| !is_real(ray)) {
            *hit = Hit::MISS;
        }
    }

    /// Marches beams until each is free or too wide to go on.
    fn march_beams(&mut self, stats: &mut CastStats, cancel: &AtomicBool) {
        let Memory { beams, lines, active, costs, .. } = &mut self.memory;
        march_bundles((&self.cells, &mut self.wide), (beams, active), stats, cancel, |beam| {
            beam.charge(lines, costs)
        });
    }

    /// Marches rays to their ends.
    fn march_rays(&mut self, want: Want, stats: &mut CastStats, cancel: &AtomicBool) {
        let Memory { thin, active, costs, .. } = &mut self.memory;
        active.clear();
        active.extend(0..thin.len());
        let goes_on = || !cancel.load(Ordering::Relaxed);
        while !active.is_empty() && goes_on() {
            let mut asked_by = Vec::with_capacity(active.len());
            for &i in active.iter().take_while(|_| goes_on()) {
                asked_by.extend(thin[i].place(&self.cells).map(|tape| (tape, i)));
            }
            stats.evaluations += asked_by.len() as u64;
            stats.steps += asked_by.len() as u64;
            stats.work += self.thin.answer(
                (&mut thin[..], asked_by),
                |thin| (thin.piece, thin.coordinates()),
                |thin, _, answer, _| {
                    let mut value = |at: DVec3| *self.points.eval(&at.to_array());
                    let tape = self.cells.tape();
                    let mut answer = if thin.is_defined(&self.cells) {
                        answer
                    } else {
                        thin.checked(answer, tape, &mut value)
                    };
                    // Across a jump of a part nothing is told from zero, be it ever so short.
                    answer.whole &= tape.class() > Class::Jump;
                    thin.tell(&answer, want, value);
                    costs[thin.ray] += 1.0;
                },
                cancel,
            );
            active.retain(|&i| thin[i].hit.is_none());
        }
    }
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
        self.march_together(rays, want, out, stats, cancel);
        let Memory { thin, alone, .. } = &mut self.memory;
        thin.extend(alone.drain(..).map(|i| {
            // Those of which anything is wanted were turned around for the sake of beams.
            let line = if want == Want::Any { turned(&rays[i]) } else { rays[i] };
            Thin::new(i, line, march_alone(&line, self.is_alone))
        }));
        self.march_rays(want, stats, cancel);
        let Memory { thin, insides, .. } = &mut self.memory;
        for thin in &*thin {
            let Thin { ray, march, hit, .. } = thin;
            if let Some(hit) = *hit {
                if let Some(t) = thin.inside(&rays[*ray]) {
                    insides[*ray] = if want == Want::Any { -t } else { t };
                }
                // Any hit is somewhere behind the beginning.
                let t = match want {
                    Want::Any if hit.is_hit() => -rays[*ray].far,
                    _ => hit.t.max(rays[*ray].near),
                };
                out[*ray] = Hit { t, ..hit };
                stats.hits += u64::from(hit.is_hit());
                stats.uncertified += u64::from(!hit.certified);
                stats.given_up += u64::from(march.pieces > PIECES && !hit.certified);
            }
        }
    }

    /// Marches beams until what is left of each is rays, which are to go on alone; the others have missed.
    fn march_together(
        &mut self,
        rays: &[Ray],
        want: Want,
        out: &mut [Hit],
        stats: &mut CastStats,
        cancel: &AtomicBool,
    ) {
        self.memory.beams.clear();
        self.memory.thin.clear();
        self.memory.alone.clear();
        self.gather(rays, want, out);
        while !self.memory.beams.is_empty() {
            self.march_beams(stats, cancel);
            if let Some(falls) = &mut self.falls {
                let Memory { beams, lines, thin, costs, insides, .. } = &mut self.memory;
                falls.end(want, beams, (rays, lines), (thin, out, insides, costs), stats, cancel);
            }
            let smallest = if self.cells.is_uniform() { SMALLEST } else { SMALLEST_OF_PARTS };
            let Memory { beams, parts, lines, thin, insides, closing, .. } = &mut self.memory;
            for beam in beams.iter() {
                match (beam.bundle.state, beam.bundle.closed()) {
                    (State::Free, _) => beam.left(lines).for_each(|i| out[i] = Hit::MISS),
                    (_, Some(answer)) => {
                        stats.hits += closing.end(beam, answer, (rays, lines), thin, (out, insides));
                        beam.cut((rays, lines), (want, smallest), (parts, thin), out);
                    }
                    (State::Ended, _) => beam.cut((rays, lines), (want, smallest), (parts, thin), out),
                    // Given up.
                    (State::Marching, _) => {}
                }
            }
            beams.clear();
            std::mem::swap(beams, parts);
        }
    }

    /// Shortens rays from surfaces by what is free before their other ends, where they still keep together.
    fn shorten(&mut self, rays: &mut [Ray], stats: &mut CastStats, cancel: &AtomicBool) {
        self.turn(rays);
        let mut turned = std::mem::take(&mut self.memory.turned);
        let others = turned.iter_mut().zip(&*rays).filter(|(_, ray)| !is_from_surface(ray));
        others.for_each(|(turned, _)| turned.far = f64::NEG_INFINITY);
        // Of no interest: what misses here is cast to nowhere.
        let mut missed = vec![Hit::MISS; rays.len()];
        self.march_together(&turned, Want::Any, &mut missed, stats, cancel);
        // Those that are free all along are in no list.
        let end = |ray: &Ray| if is_from_surface(ray) { f64::NEG_INFINITY } else { ray.far };
        let mut far: Vec<f64> = rays.iter().map(end).collect();
        self.memory.alone.iter().for_each(|&i| far[i] = rays[i].far);
        self.memory.thin.iter().for_each(|thin| far[thin.ray] = -thin.march.free);
        rays.iter_mut().zip(far).for_each(|(ray, far)| ray.far = ray.far.min(far));
        self.memory.turned = turned;
    }

    /// Counts rays, and makes room for what they cost.
    fn begin(&mut self, rays: &[Ray], stats: &mut CastStats) {
        stats.rays += rays.len() as u64;
        self.memory.costs.clear();
        self.memory.costs.resize(rays.len(), 0.0);
        self.memory.insides.clear();
        self.memory.insides.resize(rays.len(), f64::INFINITY);
    }

    /// Turns rays around.
    fn turn(&mut self, rays: &[Ray]) {
        self.memory.turned.clear();
        self.memory.turned.extend(rays.iter().map(turned));
    }
}

impl Caster for Beams {
    fn first_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool) {
        self.begin(rays, stats);
        let mut own = rays.iter().filter(|ray| is_from_surface(ray));
        let first = own.next();
        if self.is_alone || !own.any(|ray| first.is_some_and(|first| ray.origin != first.origin)) {
            return self.cast(rays, Want::First, out, stats, cancel);
        }
        let mut short = rays.to_vec();
        self.shorten(&mut short, stats, cancel);
        if !cancel.load(Ordering::Relaxed) {
            self.cast(&short, Want::First, out, stats, cancel);
        }
    }

    fn any_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool) {
        self.begin(rays, stats);
        self.turn(rays);
        let turned = std::mem::take(&mut self.memory.turned);
        self.cast(&turned, Want::Any, out, stats, cancel);
        self.memory.turned = turned;
    }

    fn costs(&self) -> &[f64] {
        &self.memory.costs
    }

    fn insides(&self) -> &[f64] {
        &self.memory.insides
    }

    fn clone_box(&self) -> Box<dyn Caster> {
        Box::new(self.again())
    }
}
