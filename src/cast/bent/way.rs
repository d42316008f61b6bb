//! The way ahead along a ray or a beam: spans that are passed by, halved, or found to be straight.

use super::sample::{Root, Sample, crossing, goes_free};
use crate::cast::Tolerance;

/// Spans that rays are cut into before anything is known of them: one alone would be passed by where the solid is small.
const SPANS: usize = 8;

/// Samples that are taken of a ray or a beam before it is given up.
const PATIENCE: u32 = 1 << 16;

/// A beam is cut where its samples are farther apart across it than this share of how far they are along it.
const NARROW: f64 = 0.5;

/// The same where all lines enter the solid.
const CLOSE: f64 = 0.125;

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
pub(super) enum Next<const N: usize> {
    /// Sample it at this depth.
    Ask(f64),
    /// There is nothing in it.
    Free,
    /// It does not go on as a whole from here.
    Stuck,
    /// All its lines meet the solid, about here.
    Crosses([Root; N]),
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

    fn ask(&mut self, place: usize) -> Next<N> {
        self.wanted = place;
        Next::Ask(self.places[place].0)
    }

    /// The first two ends of spans, and the next to them where there is one.
    fn first(&mut self) -> Result<([f64; 2], [Sample<N>; 2]), Next<N>> {
        let [.., (far, end), (near, start)] = &self.places[..] else { return Err(Next::Free) };
        let last = self.places.len() - 1;
        match (start, end) {
            (Some(start), Some(end)) => Ok(([*near, *far], [*start, *end])),
            (None, _) => Err(self.ask(last)),
            _ => Err(self.ask(last - 1)),
        }
    }

    /// The first span that is not passed by, once both its ends are sampled; or what is to be done before.
    fn span(&mut self, task: &Task) -> Result<([f64; 2], [Sample<N>; 2]), Next<N>> {
        loop {
            let (depths, ends) = self.first()?;
            let near = depths[0];
            if std::mem::take(&mut self.is_halved)
                && let [.., (_, Some(end)), _, _] = &self.places[..]
            {
                let triple = [ends[0], ends[1], *end];
                let is_near = triple[2].depth - near < NEAR * task.tolerance.at(near);
                if is_near && goes_free(&triple) {
                    self.last = Some(triple[1]);
                    self.places.truncate(self.places.len() - 2);
                    continue;
                }
                if !task.is_any
                    && let Some(roots) = crossing(&triple)
                {
                    return Err(Next::Crosses(roots));
                }
            }
            let [a, b] = &ends;
            let apart = a.distance(b).max(a.width()).max(b.width());
            if self.asked > PATIENCE || apart * task.lipschitz >= a.least().min(b.least()) {
                return Ok((depths, ends));
            }
            self.last = Some(*a);
            self.places.pop();
        }
    }

    /// Cuts the first span behind where all lines are expected to have met the solid, as they have fallen so far; once. Whether
    /// it did.
    fn expect(&mut self) -> bool {
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
}

impl<const N: usize> Way<N> {
    /// What is next along a beam.
    pub fn along_beam(&mut self, task: &Task) -> Next<N> {
        loop {
            let ([near, far], [a, b]) = match self.span(task) {
                Ok(span) => span,
                Err(next) => return next,
            };
            let (width, mut length) = (a.width().max(b.width()), a.length(&b));
            let reach = a.least() / task.lipschitz;
            // What all lines enter is worth a closer look, however near it is.
            let enters = a.is_outside() && b.is_inside() && !task.is_any;
            let is_lost = !a.is_outside() || a.width() >= reach || self.asked > PATIENCE;
            if a.is_outside() && self.expect() {
                continue;
            }
            let goes_on = enters && length > CLOSE * width || !is_lost && length > NARROW * width;
            if goes_on && far - near > task.tolerance.at(near) {
                self.halve();
                self.is_halved = true;
                continue;
            }
            // Its parts need not look at what is too long for them as well.
            while length >= reach && length > NARROW * width {
                self.halve();
                length *= 0.5;
            }
            return Next::Stuck;
        }
    }

    /// What was sampled where it was asked for.
    pub fn tell(&mut self, sample: Sample<N>) {
        self.asked += 1;
        self.places[self.wanted].1 = Some(sample);
    }
}

impl Way<1> {
    /// The same, with a root to be looked for first.
    pub fn towards(self, root: Root) -> Self {
        let is_ahead = self.places.last().is_some_and(|front| front.0 <= root.depth);
        Way { root: Some(root).filter(|_| is_ahead), ..self }
    }

    /// What is next along a ray.
    pub fn along_ray(&mut self, task: &Task) -> Next<1> {
        loop {
            if let Some(t) = self.met {
                return Next::Met(t);
            }
            if let Some(root) = self.root {
                return Next::Ask(root.depth);
            }
            let ([near, far], [a, b]) = match self.span(task) {
                Ok(span) => span,
                Err(Next::Crosses([root])) => {
                    (self.root, self.step, self.steps) = (Some(root), f64::INFINITY, 0);
                    continue;
                }
                Err(next) => return next,
            };
            let is_short = far - near <= task.tolerance.at(near);
            if !a.is_outside() || !b.is_outside() && (is_short || task.is_any) {
                return Next::Met(near);
            }
            if is_short || self.asked > PATIENCE {
                self.places.pop();
            } else if !self.expect() {
                self.halve();
                self.is_halved = true;
            }
        }
    }

    /// What was sampled where it was asked for.
    pub fn tell_ray(&mut self, sample: Sample<1>, task: &Task) {
        let Some(root) = self.root else { return self.tell(sample) };
        self.asked += 1;
        let (step, tolerance) = (sample.values[0] / root.slope, task.tolerance.at(root.depth));
        let front = self.places.last().map_or(root.depth, |front| front.0);
        if step.abs() <= LAST * tolerance {
            self.met = Some((root.depth + step - 0.5 * tolerance).max(front));
            return;
        }
        // The slope between the last two places, where that is one.
        let slope = root.slope * (1.0 - step / self.step);
        let slope = if slope > 0.25 * root.slope && slope < 4.0 * root.slope { slope } else { root.slope };
        let depth = root.depth + sample.values[0] / slope;
        let is_closer = step.abs() < 0.5 * self.step.abs() && self.steps < STEPS && depth >= front;
        (self.step, self.steps) = (step, self.steps + 1);
        self.root = is_closer.then_some(Root { depth, slope });
    }
}
