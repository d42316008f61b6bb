//! The analysis itself: realisations to threads, sums in order.

use super::covariance::{self, Covariance};
use super::radial::Radial;
use super::spectrum::{self, Spectrum};
use super::verdict::Verdict;
use super::{Analysis, Plan, Refusal, Watch};
use crate::field::{Moments, Survey, survey};
use crate::num::Many;
use crate::scene::{Ensemble, Member};
use crate::tape::{Evaluator, Tape};
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Points in space at which a realisation is sampled for its moments.
const POINTS: usize = 4096;

/// Points evaluated together.
const LANES: usize = 64;

/// Measures a random field, on the threads of the current rayon pool.
///
/// # Errors
/// [`Refusal`]
pub fn analyse(ensemble: &Ensemble, plan: &Plan, watch: &Watch<'_>) -> Result<Analysis, Refusal> {
    plan.validate()?;
    let count = ensemble.members.len();
    if count < 2 {
        return Err(Refusal::Few);
    }
    let tapes: Vec<Arc<Tape>> = ensemble.members.iter().map(tape).collect();
    let periodic = ensemble.period == Some(f64::from(plan.side)) && repeats(&tapes[0], plan);
    let job = Job { ensemble, plan, watch, tapes, periodic, done: AtomicUsize::new(0) };
    let first: Vec<Sampled> = (0..count).into_par_iter().map(|i| job.sampled(i)).collect::<Result<_, _>>()?;
    let lines: Vec<f64> = first.iter().flat_map(|s| s.lines.iter().copied()).collect();
    let covariance = Covariance::of(&lines);
    let (moments, [mean_error, variance_error]) = moments(&first).ok_or(Refusal::Few)?;
    let (spectrum, sample) = job.spectrum(moments.mean)?;
    let radial = Radial::of(&spectrum, count);
    let verdict = Verdict::of(&covariance, &radial, &moments, ensemble.octaves);
    Ok(Analysis {
        plan: *plan,
        realisations: count,
        periodic,
        moments,
        mean_error,
        variance_error,
        covariance,
        spectrum,
        radial,
        verdict,
        sample,
    })
}

fn tape(member: &Member) -> Arc<Tape> {
    Arc::new(Tape::new(&member.graph, &[member.root]))
}

/// Whether a field is the same a side farther along every axis, as it has to be if no window is to be
/// laid over it. Seen, not believed: a sum or a warp of noises that repeat need not repeat itself.
fn repeats(tape: &Arc<Tape>, plan: &Plan) -> bool {
    let mut rows = Rows::new(tape);
    let side = f64::from(plan.side);
    let mut row = |from: [f64; 3]| {
        let mut out = vec![0.0; 2 * LANES];
        rows.add(from[0], 0.37, [from[1], from[2]], 1.0, &mut out);
        out
    };
    let here = row([0.0; 3]);
    let size = here.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    (0..3).all(|axis| {
        let mut from = [0.0; 3];
        from[axis] = side;
        row(from).iter().zip(&here).all(|(a, b)| (a - b).abs() <= 1e-6 * size)
    })
}

/// What is sampled of a realisation besides its plane.
struct Sampled {
    survey: Survey,
    lines: Vec<f64>,
}

/// Moments of all samples, and standard errors of mean and variance.
fn moments(parts: &[Sampled]) -> Option<(Moments, [f64; 2])> {
    let each: Vec<Moments> = parts.iter().filter_map(|s| Moments::of(&s.survey)).collect();
    let all = Survey {
        values: parts.iter().flat_map(|s| s.survey.values.iter().copied()).collect(),
        slopes: parts.iter().flat_map(|s| s.survey.slopes.iter().copied()).collect(),
    };
    let n = each.len() as f64;
    let error = |of: fn(&Moments) -> f64| {
        let mean = each.iter().map(of).sum::<f64>() / n;
        let spread = each.iter().map(|m| (of(m) - mean) * (of(m) - mean)).sum::<f64>();
        libm::sqrt(spread / (n * (n - 1.0)))
    };
    Some((Moments::of(&all)?, [error(|m| m.mean), error(|m| m.variance)]))
}

/// Evaluates rows of points, a batch at a time.
struct Rows {
    field: Evaluator<Many<f64, LANES>>,
}

impl Rows {
    fn new(tape: &Arc<Tape>) -> Rows {
        Rows { field: Evaluator::new(tape.clone()) }
    }

    /// Adds `weight` times the field at `(x + i step, y, z)` to each entry.
    fn add(&mut self, x: f64, step: f64, [y, z]: [f64; 2], weight: f64, out: &mut [f64]) {
        let (y, z) = (Many([y; LANES]), Many([z; LANES]));
        for (batch, part) in out.chunks_mut(LANES).enumerate() {
            let x = Many(std::array::from_fn(|lane| x + step * (batch * LANES + lane) as f64));
            let Many(values) = self.field.eval(&[x, y, z]);
            part.iter_mut().zip(values).for_each(|(out, v)| *out += weight * v);
        }
    }
}

struct Job<'a> {
    ensemble: &'a Ensemble,
    plan: &'a Plan,
    watch: &'a Watch<'a>,
    tapes: Vec<Arc<Tape>>,
    periodic: bool,
    /// Realisations whose planes are done.
    done: AtomicUsize,
}

impl Job<'_> {
    fn check(&self) -> Result<(), Refusal> {
        if self.watch.cancel.load(Ordering::Relaxed) { Err(Refusal::Cancelled) } else { Ok(()) }
    }

    fn sampled(&self, index: usize) -> Result<Sampled, Refusal> {
        self.check()?;
        let tape = &self.tapes[index];
        // Whole cells, about as many as make a few units of length.
        let apart = self.ensemble.cell * (4.0 / self.ensemble.cell).ceil().max(1.0);
        // No more than have room side by side: beyond that a field that repeats has the same again.
        let count = (f64::from(self.plan.side) / apart) as usize;
        let mut rows = Rows::new(tape);
        let mut lines = vec![0.0; count.clamp(1, covariance::LINES) * covariance::POINTS];
        for (l, line) in lines.chunks_exact_mut(covariance::POINTS).enumerate() {
            rows.add(0.0, 1.0 / covariance::SAMPLES as f64, [l as f64 * apart, 0.0], 1.0, line);
        }
        let survey = survey(tape, f64::from(self.plan.side), index * POINTS, POINTS);
        let defined = survey.values.iter().chain(&survey.slopes).chain(&lines).all(|v| v.is_finite());
        if defined { Ok(Sampled { survey, lines }) } else { Err(Refusal::Undefined(index + 1)) }
    }

    /// The spectrum of all planes, and the first plane.
    fn spectrum(&self, mean: f64) -> Result<(Spectrum, Vec<f64>), Refusal> {
        let (edge, count) = (self.plan.edge(), self.tapes.len());
        let window = spectrum::window(edge, self.periodic);
        let step = 1.0 / f64::from(self.plan.samples);
        let side = f64::from(self.plan.side);
        let mut sum = vec![0.0; edge * edge];
        // As many pairs at a time as there are threads, since each needs room of its own; added up
        // in order, so that the number of threads does not matter.
        let together = 2 * rayon::current_num_threads().max(1);
        for start in (0..count).step_by(together) {
            let pairs: Vec<usize> = (start..(start + together).min(count)).step_by(2).collect();
            let powers: Vec<Vec<f64>> =
                pairs.into_par_iter().map(|i| self.pair(i, mean, &window)).collect::<Result<_, _>>()?;
            for power in powers {
                sum.iter_mut().zip(power).for_each(|(sum, p)| *sum += p);
            }
        }
        let dimensions = if self.plan.solid { 3 } else { 2 };
        let (cell, volume) = (0..dimensions).fold((1.0, 1.0), |(c, v), _| (c * step, v * side));
        let scale = cell * cell / (volume * count as f64);
        sum.iter_mut().for_each(|s| *s *= scale);
        let mean_power = mean * mean * volume;
        sum[(edge / 2) * (edge + 1)] += mean_power;
        let sample = self.plane(0, 0.0, &vec![1.0; edge], false)?;
        Ok((Spectrum { edge, step: 1.0 / side, density: sum, mean_power }, sample))
    }

    /// The summed power of two realisations, or of the last one.
    fn pair(&self, first: usize, mean: f64, window: &[f64]) -> Result<Vec<f64>, Refusal> {
        let a = self.plane(first, mean, window, self.plan.solid)?;
        let second = first + 1 < self.tapes.len();
        let b = if second { Some(self.plane(first + 1, mean, window, self.plan.solid)?) } else { None };
        let power = spectrum::power(&a, b.as_deref(), self.plan.edge());
        let done = self.done.fetch_add(1 + usize::from(second), Ordering::Relaxed) + 1 + usize::from(second);
        (self.watch.progress)(done as f64 / self.tapes.len() as f64);
        power.map_err(|_| Refusal::Power { what: "samples", value: self.plan.samples })
    }

    /// A realisation on the plane z = 0, or summed up across it; less the mean, times the window.
    fn plane(&self, index: usize, mean: f64, window: &[f64], solid: bool) -> Result<Vec<f64>, Refusal> {
        let (edge, step) = (self.plan.edge(), 1.0 / f64::from(self.plan.samples));
        let mut rows = Rows::new(&self.tapes[index]);
        let mut out = vec![0.0; edge * edge];
        let layers = if solid { window } else { &[1.0] };
        let total: f64 = layers.iter().sum();
        for (y, row) in out.chunks_exact_mut(edge).enumerate() {
            self.check()?;
            for (z, weight) in layers.iter().enumerate() {
                rows.add(0.0, step, [y as f64 * step, z as f64 * step], *weight, row);
            }
            let mean = mean * total;
            row.iter_mut().zip(window).for_each(|(v, w)| *v = (*v - mean) * w * window[y]);
            if !row.iter().all(|v| v.is_finite()) {
                return Err(Refusal::Undefined(index + 1));
            }
        }
        Ok(out)
    }
}
