//! Casting by beams with certificates on both sides.
//!
//! Rays that start at one point and keep together share what is certain of all of them. A beam of 64
//! rays marches until its own width is what limits it; its four quarters go on from there, then their
//! quarters, then the rays, each with a prediction of its root from the last answer of its beam (the
//! notes on ray casting, 9.6; Keeter's and others' tiles are the same idea with intervals). Beams of
//! all tiles at one level are answered together, in batches.

mod bundle;
mod march;

use super::{CastStats, Caster, Hit, Ray};
use crate::num::{Interval, Number, Parabola, Parabolas};
use crate::tape::{Evaluator, Tape};
use bundle::{Frame, Section};
use march::{Answer, March, Next, PIECES, Piece};
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Questions answered together.
const LANES: usize = 16;

/// Rays of the widest beams.
const WIDEST: usize = 64;

/// Parts that a beam is cut into.
const PARTS: usize = 4;

/// A beam marches while its pieces are longer than this share of its radius.
const NARROW: f64 = 0.3;

/// First stretch of a part of a beam, as a share of the way to where its root is expected.
const TOWARDS: f64 = 0.4;

/// Casts by beams; see the module text.
pub(super) struct Beams {
    tape: Arc<Tape>,
    wide: Evaluator<Parabolas<LANES, 2>>,
    thin: Evaluator<Parabolas<LANES, 0>>,
    /// Evaluations for each ray of the last group.
    costs: Vec<f64>,
}

/// Rays that march together.
struct Beam {
    /// Of the group.
    rays: Range<usize>,
    frame: usize,
    section: Section,
    march: March,
    last: Sketch,
}

/// A ray under way.
struct Thin {
    ray: usize,
    march: March,
}

/// What the field is like around the end of a beam: middles of the last answer.
#[derive(Clone, Copy, Default)]
struct Sketch {
    piece: Option<Piece>,
    /// Value, slope and bend along the beam.
    along: [f64; 3],
    /// Slopes across, to the edges of the section.
    across: [f64; 2],
}

impl Sketch {
    /// Where the field is expected to be zero, at a place in the section given in units of its extent.
    fn root(&self, [x, y]: [f64; 2]) -> Option<f64> {
        let piece = self.piece?;
        let [value, slope, bend] = self.along;
        let e = descent([value + x * self.across[0] + y * self.across[1], slope, bend])?;
        Some(piece.mid + e * piece.half)
    }
}

/// The place near zero where a parabola falls through zero, within a few units.
fn descent([c, b, a]: [f64; 3]) -> Option<f64> {
    if b >= 0.0 || b.is_nan() {
        return None;
    }
    // The root next to the straight line's; where the parabola has none, the line's.
    let root = -2.0 * c / (b - (b * b - 4.0 * a * c).max(0.0).sqrt());
    (root.abs() < 8.0).then_some(root)
}

fn middle(x: Interval) -> f64 {
    0.5 * (x.lo + x.hi)
}

/// A lane as an answer.
fn answer<const K: usize>(f: &Parabola<K>, piece: Piece) -> (Answer, Sketch) {
    let along = [f.value, f.slope, f.bend].map(middle);
    let mut sketch = Sketch { piece: Some(piece), along, across: [0.0; 2] };
    for k in 0..K {
        sketch.across[k] = f.side[k];
    }
    let root = sketch.root([0.0; 2]);
    (Answer { halves: f.halves(), root, finite: f.range.is_finite() }, sketch)
}

impl Beams {
    pub(super) fn new(tape: Arc<Tape>) -> Beams {
        let (wide, thin) = (Evaluator::new(tape.clone()), Evaluator::new(tape.clone()));
        Beams { tape, wide, thin, costs: Vec::new() }
    }

    /// The widest beams of a group, and the rays that go alone.
    fn gather(rays: &[Ray], frames: &mut Vec<Frame>, out: &mut [Hit]) -> (Vec<Beam>, Vec<Thin>) {
        let (mut beams, mut alone) = (Vec::new(), Vec::new());
        for start in (0..rays.len()).step_by(WIDEST) {
            let own = start..(start + WIDEST).min(rays.len());
            let Some(range) = trimmed(rays, own) else { continue };
            let members: Vec<Ray> = rays[range.clone()].iter().copied().filter(is_real).collect();
            match Frame::new(&members) {
                Some(frame) => {
                    frames.push(frame);
                    let near =
                        members.iter().map(|r| r.near / frame.stretch(r)).fold(f64::INFINITY, f64::min);
                    let section = Section::around(&frame, &members);
                    let far =
                        members.iter().map(|r| r.far / frame.stretch(r)).fold(f64::NEG_INFINITY, f64::max);
                    // Depths are rounded: all of every ray, and a hair more.
                    let (near, far) = (near - near.abs() * 1e-15, far + far.abs() * 1e-15);
                    let march = March::new(near, far, 0.25 * (far - near), None);
                    beams.push(Beam {
                        rays: range,
                        frame: frames.len() - 1,
                        section,
                        march,
                        last: Sketch::default(),
                    });
                }
                None => alone.extend(range.filter(|&i| is_real(&rays[i])).map(|ray| {
                    let Ray { near, far, .. } = rays[ray];
                    Thin { ray, march: March::new(near, far, 0.25 * (far - near), None) }
                })),
            }
        }
        for (hit, _) in out.iter_mut().zip(rays).filter(|(_, ray)| !is_real(ray)) {
            *hit = Hit::MISS;
        }
        (beams, alone)
    }

    /// Marches beams until each is free or too wide to go on; returns those.
    fn march_beams(
        &mut self,
        mut beams: Vec<Beam>,
        frames: &[Frame],
        stats: &mut CastStats,
        cancel: &AtomicBool,
    ) -> Vec<Beam> {
        let mut done = Vec::with_capacity(beams.len());
        let mut next = Vec::with_capacity(beams.len());
        let mut p = [Parabolas::constant(0.0); 3];
        while !beams.is_empty() && !cancel.load(Ordering::Relaxed) {
            for batch in chunks(&mut beams) {
                let mut pieces = [Piece { mid: 0.0, half: 0.0 }; LANES];
                let mut asked = Vec::with_capacity(LANES);
                for mut beam in batch {
                    let piece = beam.march.piece();
                    if piece.half < NARROW * beam.section.radius(piece.mid) {
                        done.push(beam);
                        continue;
                    }
                    let lane = asked.len();
                    pieces[lane] = piece;
                    beam.section.ask(&frames[beam.frame], piece, &mut p, lane);
                    asked.push(beam);
                }
                if asked.is_empty() {
                    continue;
                }
                stats.evaluations += asked.len() as u64;
                stats.shared += asked.len() as u64;
                let f = self.wide.eval(&p);
                for (lane, mut beam) in asked.into_iter().enumerate() {
                    let (answer, sketch) = answer(&f.lane(lane), pieces[lane]);
                    beam.last = sketch;
                    let share = 1.0 / beam.rays.len() as f64;
                    self.costs[beam.rays.clone()].iter_mut().for_each(|cost| *cost += share);
                    stats.steps += 1;
                    match beam.march.tell(pieces[lane], &answer, 0.0) {
                        Next::Free => stats.culled += 1,
                        Next::Root(..) => done.push(beam),
                        Next::Look if beam.march.pieces > 200 => done.push(beam),
                        Next::Look => next.push(beam),
                    }
                }
            }
            std::mem::swap(&mut beams, &mut next);
        }
        done
    }

    /// Cuts beams that have come to their ends into parts.
    fn cut(beams: Vec<Beam>, frames: &[Frame], rays: &[Ray]) -> (Vec<Beam>, Vec<Thin>) {
        let (mut parts, mut alone) = (Vec::new(), Vec::new());
        for beam in beams {
            let frame = &frames[beam.frame];
            let whole = beam.rays.len();
            let size = (whole.next_power_of_two() / PARTS).max(1);
            let relative = |[x, y]: [f64; 2]| {
                let Section { centre, extent } = beam.section;
                [(x - centre[0]) / extent[0], (y - centre[1]) / extent[1]]
            };
            let stretch = beam.march.stretch;
            for start in beam.rays.clone().step_by(size) {
                let Some(range) = trimmed(rays, start..(start + size).min(beam.rays.end)) else { continue };
                if range.len() == 1 {
                    let ray = &rays[range.start];
                    let scale = frame.stretch(ray);
                    let root = beam.last.root(relative(frame.place(ray))).map(|z| z * scale);
                    let near =
                        (beam.march.free * scale - beam.march.free.abs() * scale * 1e-14).max(ray.near);
                    if near > ray.far {
                        continue;
                    }
                    alone.push(Thin {
                        ray: range.start,
                        march: March::new(near, ray.far, stretch * scale, root),
                    });
                } else {
                    let section = Section::around(frame, &rays[range.clone()]);
                    let root = beam.last.root(relative(section.centre));
                    let ahead = root.map_or(0.0, |r| TOWARDS * (r - beam.march.free));
                    let march = March::new(beam.march.free, beam.march.far, stretch.max(ahead), None);
                    parts.push(Beam { rays: range, frame: beam.frame, section, march, last: beam.last });
                }
            }
        }
        (parts, alone)
    }

    /// Marches rays to their ends.
    fn march_rays(
        &mut self,
        mut rays: Vec<Thin>,
        all: &[Ray],
        out: &mut [Hit],
        stats: &mut CastStats,
        cancel: &AtomicBool,
    ) {
        let mut next = Vec::with_capacity(rays.len());
        let mut p = [Parabolas::constant(0.0); 3];
        while !rays.is_empty() && !cancel.load(Ordering::Relaxed) {
            for batch in chunks(&mut rays) {
                let mut pieces = [Piece { mid: 0.0, half: 0.0 }; LANES];
                let mut batch: Vec<Thin> = batch.collect();
                for (lane, thin) in batch.iter_mut().enumerate() {
                    let ray = &all[thin.ray];
                    let piece = thin.march.piece();
                    pieces[lane] = piece;
                    let at = ray.at(piece.mid);
                    let blur = ray.rounding(piece.mid.abs() + piece.half);
                    for axis in 0..3 {
                        let slope = piece.half * ray.direction[axis];
                        p[axis].set(lane, &Parabola::coordinate(at[axis], slope, [], 0.0, blur));
                    }
                }
                stats.evaluations += batch.len() as u64;
                let f = self.thin.eval(&p);
                for (lane, mut thin) in batch.into_iter().enumerate() {
                    let ray = &all[thin.ray];
                    let (answer, _) = answer(&f.lane(lane), pieces[lane]);
                    self.costs[thin.ray] += 1.0;
                    stats.steps += 1;
                    let tolerance = ray.tolerance.at(thin.march.free);
                    let outcome = thin.march.tell(pieces[lane], &answer, tolerance);
                    let finite = thin.march.finite;
                    out[thin.ray] = match outcome {
                        Next::Free => Hit { certified: finite, ..Hit::MISS },
                        Next::Root(a, b) => {
                            Hit { t: answer.root.unwrap_or(a).clamp(a, b), certified: finite }
                        }
                        Next::Look if thin.march.pieces > PIECES => {
                            stats.given_up += 1;
                            Hit { t: thin.march.free, certified: false }
                        }
                        Next::Look => {
                            next.push(thin);
                            continue;
                        }
                    };
                    stats.hits += u64::from(out[thin.ray].is_hit());
                    stats.uncertified += u64::from(!out[thin.ray].certified);
                }
            }
            std::mem::swap(&mut rays, &mut next);
        }
    }
}

/// Takes all entries, a batch at a time.
fn chunks<T>(all: &mut Vec<T>) -> impl Iterator<Item = impl Iterator<Item = T>> {
    let mut rest = std::mem::take(all).into_iter();
    std::iter::from_fn(move || {
        let batch: Vec<T> = rest.by_ref().take(LANES).collect();
        (!batch.is_empty()).then(|| batch.into_iter())
    })
}

/// Whether there is anything of a ray.
fn is_real(ray: &Ray) -> bool {
    ray.near <= ray.far
}

/// The range from the first ray of which there is anything to the last.
fn trimmed(rays: &[Ray], range: Range<usize>) -> Option<Range<usize>> {
    let first = range.clone().find(|&i| is_real(&rays[i]))?;
    let last = range.rev().find(|&i| is_real(&rays[i]))?;
    Some(first..last + 1)
}

impl Caster for Beams {
    fn first_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool) {
        stats.rays += rays.len() as u64;
        out.fill(Hit::MISS);
        self.costs.clear();
        self.costs.resize(rays.len(), 0.0);
        let mut frames = Vec::new();
        let (mut beams, mut alone) = Self::gather(rays, &mut frames, out);
        while !beams.is_empty() {
            let done = self.march_beams(beams, &frames, stats, cancel);
            let (parts, thin) = Self::cut(done, &frames, rays);
            alone.extend(thin);
            beams = parts;
        }
        self.march_rays(alone, rays, out, stats, cancel);
    }

    fn costs(&self) -> &[f64] {
        &self.costs
    }

    fn clone_box(&self) -> Box<dyn Caster> {
        Box::new(Beams::new(self.tape.clone()))
    }
}
