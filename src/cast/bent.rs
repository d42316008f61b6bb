//! Bent rays: the heuristic of the thesis for flowed solids (Gamito 2009, 9.3), kept for comparison.
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

use super::{CastStats, Caster, Hit, Ray};
use crate::tape::Flowed;
use glam::DVec3;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Spans that a ray is cut into before anything is known of it: one alone would be passed by where the solid is small.
const SPANS: usize = 8;

/// Spans that are looked at before a ray is given up.
const PATIENCE: u32 = 1 << 16;

/// A place on a ray, where the flow carries it, and how far it is from the solid at least.
#[derive(Clone, Copy)]
struct Sample {
    t: f64,
    at: DVec3,
    value: f64,
}

/// A ray under way: the spans that are left, nearest last.
struct March {
    ray: usize,
    spans: Vec<[Sample; 2]>,
    asked: u32,
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

    /// Samples of rays.
    fn samples(&self, rays: &[Ray], places: &[(usize, f64)]) -> Vec<Sample> {
        let at: Vec<DVec3> = places.iter().map(|&(ray, t)| rays[ray].at(t)).collect();
        let axis = |axis: usize| at.iter().map(|p| p[axis]).collect::<Vec<f64>>();
        let (ends, values) = self.flowed.trace([&axis(0), &axis(1), &axis(2)]);
        let sample = |(i, &(_, t)): (usize, &(usize, f64))| Sample {
            t,
            at: DVec3::from_array(ends[i]),
            value: values[i],
        };
        places.iter().enumerate().map(sample).collect()
    }

    /// Whether (9.23) holds, which is no proof.
    fn is_passed_by(&self, [a, b]: &[Sample; 2]) -> bool {
        a.at.distance(b.at) * self.lipschitz < a.value.abs().min(b.value.abs())
    }

    /// Takes spans off a ray until one must be halved; the hit if there is none left.
    fn next(&self, ray: &Ray, march: &mut March) -> Option<Hit> {
        let found = |t: f64| Some(Hit { t, certified: false });
        while let Some(span) = march.spans.last() {
            let [a, b] = span;
            let enters = a.value > 0.0 && b.value <= 0.0;
            let is_short = b.t - a.t <= ray.tolerance.at(a.t);
            if a.value <= 0.0 || (is_short && enters) {
                return found(a.t);
            }
            if is_short || march.asked > PATIENCE || self.is_passed_by(span) {
                march.spans.pop();
                continue;
            }
            return None;
        }
        found(f64::INFINITY)
    }
}

impl Caster for Bent {
    fn first_hits(&mut self, rays: &[Ray], out: &mut [Hit], stats: &mut CastStats, cancel: &AtomicBool) {
        let mut costs = vec![0.0; rays.len()];
        let place = |ray: &Ray, k: usize| ray.near + (ray.far - ray.near) * k as f64 / SPANS as f64;
        let starts: Vec<(usize, f64)> = (0..rays.len())
            .flat_map(|i| (0..=SPANS).map(move |k| (i, k)))
            .map(|(i, k)| (i, place(&rays[i], k)))
            .collect();
        let first = self.samples(rays, &starts);
        let mut active: Vec<March> = Vec::with_capacity(rays.len());
        for (ray, samples) in first.chunks(SPANS + 1).enumerate() {
            let spans = samples.windows(2).rev().map(|w| [w[0], w[1]]).collect();
            active.push(March { ray, spans, asked: SPANS as u32 + 1 });
        }
        while !active.is_empty() && !cancel.load(Ordering::Relaxed) {
            active.retain_mut(|march| {
                let Some(hit) = self.next(&rays[march.ray], march) else { return true };
                out[march.ray] = hit;
                costs[march.ray] = f64::from(march.asked);
                stats.hits += u64::from(hit.is_hit());
                false
            });
            let middle = |march: &March| march.spans.last().map(|[a, b]| (march.ray, 0.5 * (a.t + b.t)));
            let halves: Vec<(usize, f64)> = active.iter().filter_map(middle).collect();
            for (march, middle) in active.iter_mut().zip(self.samples(rays, &halves)) {
                march.asked += 1;
                if let Some([a, b]) = march.spans.pop() {
                    march.spans.extend([[middle, b], [a, middle]]);
                }
            }
        }
        let asked: f64 = costs.iter().sum();
        stats.rays += rays.len() as u64;
        stats.uncertified += rays.len() as u64;
        stats.evaluations += asked as u64;
        stats.steps += asked as u64;
        self.costs = costs;
    }

    fn costs(&self) -> &[f64] {
        &self.costs
    }

    fn clone_box(&self) -> Box<dyn Caster> {
        Box::new(Bent::new(self.flowed.clone(), self.lipschitz))
    }
}
