//! The way ahead along a ray or a beam: spans that are passed by, halved, or found to be straight.

use super::sample::{Root, Sample, crossing, goes_free};
use crate::cast::Tolerance;

/// Spans that rays are cut into before anything is known of them: one alone would be passed by where the solid is small.
const SPANS: usize = 8;

/// Samples that are taken of a ray or a beam before it is given up.
const PATIENCE: u32 = 1 << 16;

/// A beam is cut where its samples are farther apart across it than this share of how far they are along it.
const NARROW: f64 = 0.5;

/// A root is taken where a step so many times the tolerance leads to it: the slope is known well enough for that.
const LAST: f64 = 8.0;

/// Steps towards an expected root before it is looked for by halves.
const STEPS: u32 = 6;

/// What looks straight along so many times the tolerance, some pixels of a picture, is taken to be so: along more, something
/// might be between the samples.
const NEAR: f64 = 2000.0;

/// Where a root is expected a way is sampled so many times as far ahead, behind it.
const BEHIND: f64 = 1.25;

/// What is asked of a way.
#[derive(Clone, Copy)]
pub(super) struct Task {
    /// Lipschitz bound of the solid before it flowed.
    pub lipschitz: f64,
    pub tolerance: Tolerance,
    /// Whether any place in the solid will do.
    pub is_any: bool,
}

/// What is to be done next on a way.
pub(super) enum Next {
    /// Sample it at this depth.
    Ask(f64),
    /// There is nothing in it.
    Free,
    /// It does not go on as a whole from here.
    Stuck,
    /// The solid is met.
    Met(f64),
}

/// A way ahead along so many lines at once.
pub(super) struct Way<const N: usize> {
    /// Depths, the nearest last, with what was sampled there.
    places: Vec<(f64, Option<Sample<N>>)>,
    /// The sample before the first of these.
    last: Option<Sample<N>>,
    /// The depth from which a root was last expected.
    expecting: f64,
    /// The place that was asked about.
    wanted: usize,
    /// Whether the first span was halved by what was asked.
    is_halved: bool,
    /// Where a root is expected; the last step towards it, and how many there were.
    root: Option<Root>,
    step: f64,
    steps: u32,
    met: Option<f64>,
    pub asked: u32,
}

/// Both ends of a span.
type Span<const N: usize> = [Sample<N>; 2];

impl<const N: usize> Way<N> {
    /// Through depths that increase.
    fn new(depths: impl DoubleEndedIterator<Item = f64>) -> Self {
        let places = depths.rev().map(|depth| (depth, None)).collect();
        let (step, expecting) = (f64::INFINITY, f64::NEG_INFINITY);
        let (root, met, last) = (None, None, None);
        Way { places, last, expecting, wanted: 0, is_halved: false, root, step, steps: 0, met, asked: 0 }
    }

    /// Between two depths, in equal spans.
    pub fn between([near, far]: [f64; 2]) -> Self {
        Way::new((0..=SPANS).map(|k| near + (far - near) * k as f64 / SPANS as f64))
    }

    /// What is left of it between two depths, as places of another way.
    pub fn left<const M: usize>(&self, [near, far]: [f64; 2], depth: impl Fn(f64) -> f64) -> Option<Way<M>> {
        let near = self.places.last().map_or(near, |front| depth(front.0).max(near));
        let own = self.places.iter().rev().map(|place| depth(place.0));
        let inner: Vec<f64> = own.filter(|depth| *depth > near && *depth < far).collect();
        (near <= far).then(|| Way::new([near].into_iter().chain(inner).chain([far])))
    }

    /// The first span, or what is to be done before it is known.
    fn first(&mut self) -> Result<Span<N>, Next> {
        let [.., (_, end), (_, start)] = &self.places[..] else { return Err(Next::Free) };
        let last = self.places.len() - 1;
        match (start, end) {
            (Some(start), Some(end)) => return Ok([*start, *end]),
            (None, _) => self.wanted = last,
            _ => self.wanted = last - 1,
        }
        Err(Next::Ask(self.places[self.wanted].0))
    }

    /// Whether the first span is passed by, since (9.23) holds and it begins outside.
    fn passes(&mut self, [a, b]: &Span<N>, task: &Task) -> bool {
        let apart = a.distance(b).max(a.width()).max(b.width());
        let passes =
            a.is_outside() && self.asked <= PATIENCE && apart * task.lipschitz < a.least().min(b.least());
        if passes {
            self.last = Some(*a);
            self.places.pop();
        }
        passes
    }

    /// Cuts the first span behind where all lines are expected to have met the solid, as they have fallen so far; once. Whether
    /// it did.
    fn foresee(&mut self) -> bool {
        let (Some(last), [.., (far, _), (near, Some(a))]) = (self.last, &self.places[..]) else {
            return false;
        };
        if self.expecting >= *near {
            return false;
        }
        self.expecting = *near;
        let length = |line: usize| {
            let (before, now) = (last.values[line], a.values[line]);
            if now > 0.0 && now < before {
                now * (a.depth - last.depth) / (before - now)
            } else {
                f64::INFINITY
            }
        };
        let depth = near + BEHIND * (0..N).map(length).fold(0.0, f64::max);
        let is_short = depth < near + 0.75 * (far - near);
        if is_short {
            self.places.insert(self.places.len() - 1, (depth, None));
        }
        is_short
    }

    /// Halves the first span.
    fn halve(&mut self) {
        if let [.., (far, _), (near, _)] = self.places[..] {
            self.places.insert(self.places.len() - 1, (0.5 * (near + far), None));
        }
    }

    /// What was sampled where it was asked for.
    pub fn tell(&mut self, sample: Sample<N>) {
        self.asked += 1;
        self.places[self.wanted].1 = Some(sample);
    }

    /// What is next along a beam.
    pub fn along_beam(&mut self, task: &Task) -> Next {
        loop {
            let span = match self.first() {
                Ok(span) => span,
                Err(next) => return next,
            };
            if self.passes(&span, task) || span[0].is_outside() && self.foresee() {
                continue;
            }
            let [a, b] = span;
            let (width, mut length) = (a.width().max(b.width()), a.length(&b));
            let reach = a.least() / task.lipschitz;
            let is_lost = !a.is_outside() || a.width() >= reach || self.asked > PATIENCE;
            if !is_lost && length > NARROW * width && b.depth - a.depth > task.tolerance.at(a.depth) {
                self.halve();
                continue;
            }
            // Its parts need not look at what is too long for them as well.
            while length >= reach && length > NARROW * width && length.is_finite() {
                self.halve();
                length *= 0.5;
            }
            return Next::Stuck;
        }
    }
}

impl Way<1> {
    /// What is next along a ray.
    pub fn along_ray(&mut self, task: &Task) -> Next {
        loop {
            if let Some(t) = self.met {
                return Next::Met(t);
            }
            if let Some(root) = self.root {
                return Next::Ask(root.depth);
            }
            let span = match self.first() {
                Ok(span) => span,
                Err(next) => return next,
            };
            if self.looks_straight(&span, task) || self.passes(&span, task) {
                continue;
            }
            let [a, b] = span;
            let is_short = b.depth - a.depth <= task.tolerance.at(a.depth);
            if a.is_inside() || b.is_inside() && (is_short || task.is_any) {
                return Next::Met(a.depth);
            }
            if is_short || self.asked > PATIENCE {
                self.places.pop();
            } else if !self.foresee() {
                self.halve();
                self.is_halved = true;
            }
        }
    }

    /// Whether the first span and the next, which were one before it was halved, look straight: then both are passed by, or a
    /// root is expected in them.
    fn looks_straight(&mut self, [start, middle]: &Span<1>, task: &Task) -> bool {
        let is_halved = std::mem::take(&mut self.is_halved);
        let [.., (_, Some(end)), _, _] = &self.places[..] else { return false };
        if !is_halved || end.depth - start.depth > NEAR * task.tolerance.at(start.depth) {
            return false;
        }
        let row = [*start, *middle, *end];
        if goes_free(&row) {
            self.last = Some(*middle);
            self.places.truncate(self.places.len() - 2);
            return true;
        }
        let root = if task.is_any { None } else { crossing(&row) };
        (self.root, self.step, self.steps) = (root, f64::INFINITY, 0);
        root.is_some()
    }

    /// What was sampled where it was asked for.
    pub fn tell_ray(&mut self, sample: Sample<1>, task: &Task) {
        let Some(root) = self.root else { return self.tell(sample) };
        self.asked += 1;
        let front = self.places.last().map_or(root.depth, |front| front.0);
        let (step, tolerance) = (sample.values[0] / root.slope, task.tolerance.at(root.depth));
        if step.abs() <= LAST * tolerance {
            self.met = Some((root.depth + step - 0.5 * tolerance).clamp(front, root.end));
            return;
        }
        // The slope between the last two places, where that is one.
        let slope = root.slope * (1.0 - step / self.step);
        let slope = if slope > 0.25 * root.slope && slope < 4.0 * root.slope { slope } else { root.slope };
        let depth = root.depth + sample.values[0] / slope;
        let is_between = depth >= front && depth <= root.end;
        let is_closer = step.abs() < 0.5 * self.step.abs() && self.steps < STEPS;
        (self.step, self.steps) = (step, self.steps + 1);
        self.root = (is_between && is_closer).then_some(Root { depth, slope, ..root });
    }
}
