//! Bent rays: the heuristic of the thesis for flowed solids (Gamito 2009, 9.3), shared by rays that go the same way.
//!
//! A straight ray against a flowed solid is a bent ray `s(t)`, carried along by the flow, against the solid as it was
//! before. With `r = |f(s)| / lambda` at both ends of a span, `lambda` a Lipschitz bound of the solid before, a span
//! is passed by where
//!
//! ```text
//! |s(b) - s(a)| < min(r_a, r_b)                                                                     (9.23)
//! ```
//!
//! and else is halved, down to the tolerance. The bent ray between two samples may leave both balls and come back: it
//! is not proven that nothing was missed, so that no answer of this caster is certified. Where the flow is weak, it
//! seldom errs; where it is strong, pieces of the solid are missing.
//!
//! In the thesis each ray works alone, down to the tolerance. Here, in the same spirit:
//!
//! - Rays that go the same way are a beam, which is sampled at its four edges. It passes by a span where no two samples at its
//!   ends are farther apart than the least `r` of them is. One that is too wide for any span is cut into quarters, and these
//!   into rays, which go on where it ended. Shadow rays are marched from their other ends, where they still go
//!   together (see [`beam`](super::beam)).
//! - A span of a ray that was halved has three samples (`sample.rs`). Where they lie in a straight row, with values like those
//!   of a parabola that has no root, the span is passed by; where the parabola has one, Newton's steps lead to that of
//!   the bent ray. This is for spans of a few pixels: so near the surface (9.23) takes a number of samples that grows
//!   with the precision, and over more there may be something small between the samples.
//! - Where the last samples say how far ahead a root is, the span is cut behind that and not in its middle.

mod sample;
mod way;

use super::beam::{Frame, Line, Section, gather, is_real, quarters, trimmed, turned};
use super::{CastStats, Caster, Hit, Ray};
use crate::tape::Flowed;
use glam::DVec3;
use sample::Sample;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use way::{Next, Task, Way};

/// Rays of the widest beams, and of the smallest, which take as many samples as four rays.
const WIDEST: usize = 256;
const SMALLEST: usize = 8;

/// Lines along which a beam is sampled.
const EDGES: usize = 4;

/// What goes along a way.
struct Walker<T, const N: usize> {
    way: Way<N>,
    who: T,
}

/// Rays of a group that go together.
struct Beam {
    rays: Range<usize>,
    frame: Frame,
    section: Section,
}

/// Where rays go on by themselves, in the end.
type Thin = Walker<usize, 1>;

impl Walker<Beam, EDGES> {
    /// Cuts the beam into parts, or into rays where these would be too few.
    fn cut(&self, rays: &[Ray], lines: &[Line], parts: &mut Vec<Self>, thin: &mut Vec<Thin>) {
        let Beam { rays: own, frame, .. } = &self.who;
        for range in quarters(own.clone()).filter_map(|range| trimmed(range, |i| is_real(&rays[i]))) {
            if range.len() < SMALLEST {
                thin.extend(range.filter_map(|i| self.ray(i, &rays[i], &lines[i])));
                continue;
            }
            let section = Section::around(frame, &lines[range.clone()]);
            let beam = |way| Walker { way, who: Beam { rays: range, frame: *frame, section } };
            parts.extend(self.way.left(section.depth, |depth| depth).map(beam));
        }
    }

    /// One of its rays, which goes on alone; `None` where it ends before the beam did.
    fn ray(&self, who: usize, ray: &Ray, line: &Line) -> Option<Thin> {
        let way = if is_real(ray) {
            self.way.left([ray.near, ray.far], |depth| line.distance(depth))
        } else {
            None
        };
        way.map(|way| Walker { way, who })
    }
}

/// Casts bent rays.
pub(super) struct Bent {
    flowed: Arc<Flowed>,
    /// Lipschitz bound of the solid before.
    lipschitz: f64,
    costs: Vec<f64>,
}

impl Bent {
    pub fn new(flowed: Arc<Flowed>, lipschitz: f64) -> Bent {
        Bent { flowed, lipschitz, costs: Vec::new() }
    }

    /// Samples at so many places each.
    fn samples<const N: usize>(&self, places: &[(f64, [DVec3; N])]) -> Vec<Sample<N>> {
        let all = || places.iter().flat_map(|place| place.1);
        let axis = |axis: usize| all().map(|p| p[axis]).collect::<Vec<f64>>();
        let (ends, values) = self.flowed.trace([&axis(0), &axis(1), &axis(2)]);
        let sample = |(i, &(depth, _)): (usize, &(f64, [DVec3; N]))| Sample {
            depth,
            at: std::array::from_fn(|k| DVec3::from_array(ends[N * i + k])),
            values: std::array::from_fn(|k| values[N * i + k]),
        };
        places.iter().enumerate().map(sample).collect()
    }

    /// Has all walkers go on until they come to an end, of which `done` is told.
    fn walk<T, const N: usize>(
        &self,
        mut walkers: Vec<Walker<T, N>>,
        next: impl Fn(&mut Walker<T, N>) -> Next,
        place: impl Fn(&T, f64) -> [DVec3; N],
        tell: impl Fn(&mut Walker<T, N>, Sample<N>),
        mut done: impl FnMut(Walker<T, N>, Next),
        cancel: &AtomicBool,
    ) {
        while !walkers.is_empty() && !cancel.load(Ordering::Relaxed) {
            let (mut going, mut places) = (Vec::new(), Vec::new());
            for mut walker in walkers {
                match next(&mut walker) {
                    Next::Ask(depth) => {
                        places.push((depth, place(&walker.who, depth)));
                        going.push(walker);
                    }
                    end => done(walker, end),
                }
            }
            for (walker, sample) in going.iter_mut().zip(self.samples(&places)) {
                tell(walker, sample);
            }
            walkers = going;
        }
    }

    /// The first hits of rays, or any.
    fn cast(&mut self, rays: &[Ray], is_any: bool, stats: &mut CastStats, cancel: &AtomicBool) -> Vec<f64> {
        let mut costs = vec![0.0; rays.len()];
        let mut lines = vec![Line::NOTHING; rays.len()];
        let (mut beams, mut thin) = (Vec::new(), Vec::new());
        let task = |ray: usize| Task { lipschitz: self.lipschitz, tolerance: rays[ray].tolerance, is_any };
        gather(rays, WIDEST, is_any, |range, frame| {
            let own = range.clone().filter(|&i| is_real(&rays[i]));
            let alone = |i: usize| Walker { way: Way::between([rays[i].near, rays[i].far]), who: i };
            let Some(frame) = frame.filter(|_| range.len() >= SMALLEST) else {
                return thin.extend(own.map(alone));
            };
            own.for_each(|i| lines[i] = frame.line(&rays[i]));
            let section = Section::around(&frame, &lines[range.clone()]);
            beams
                .push(Walker { way: Way::between(section.depth), who: Beam { rays: range, frame, section } });
        });
        while !beams.is_empty() {
            let mut parts = Vec::new();
            self.walk(
                beams,
                |beam| beam.way.along_beam(&task(beam.who.rays.start)),
                |beam, depth| beam.section.corners(&beam.frame, depth),
                |beam, sample| beam.way.tell(sample),
                |beam, end| {
                    let (own, samples) = (beam.who.rays.clone(), EDGES as u64 * u64::from(beam.way.asked));
                    stats.evaluations += samples;
                    stats.shared += samples;
                    stats.steps += u64::from(beam.way.asked);
                    let share = samples as f64 / own.len() as f64;
                    costs[own].iter_mut().for_each(|cost| *cost += share);
                    if !matches!(end, Next::Free) {
                        beam.cut(rays, &lines, &mut parts, &mut thin);
                    }
                },
                cancel,
            );
            beams = parts;
        }
        let mut met = vec![f64::INFINITY; rays.len()];
        self.walk(
            thin,
            |ray| ray.way.along_ray(&task(ray.who)),
            |&ray, t| [rays[ray].at(t)],
            |ray, sample| ray.way.tell_ray(sample, &task(ray.who)),
            |ray, end| {
                costs[ray.who] += f64::from(ray.way.asked);
                stats.evaluations += u64::from(ray.way.asked);
                stats.steps += u64::from(ray.way.asked);
                if let Next::Met(t) = end {
                    met[ray.who] = t;
                }
            },
            cancel,
        );
        self.costs = costs;
        met
    }
}

impl Caster for Bent {
    fn first_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool) {
        let met = self.cast(rays, false, stats, cancel);
        answer(met.into_iter(), out, stats, cancel);
    }

    fn any_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool) {
        let turned: Vec<Ray> = rays.iter().map(turned).collect();
        let met = self.cast(&turned, true, stats, cancel);
        // Somewhere behind the beginning.
        let near = |(t, ray): (f64, &Ray)| if t.is_finite() { ray.near } else { t };
        answer(met.into_iter().zip(rays).map(near), out, stats, cancel);
    }

    fn costs(&self) -> &[f64] {
        &self.costs
    }

    fn clone_box(&self) -> Box<dyn Caster> {
        Box::new(Bent::new(self.flowed.clone(), self.lipschitz))
    }
}

/// Takes where rays meet the solid for their hits, unless they were given up.
fn answer(met: impl Iterator<Item = f64>, out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool) {
    stats.rays += out.len() as u64;
    stats.uncertified += out.len() as u64;
    if cancel.load(Ordering::Relaxed) {
        return;
    }
    for (hit, t) in out.iter_mut().zip(met) {
        *hit = Hit { t, certified: false };
        stats.hits += u64::from(hit.is_hit());
    }
}
