//! Fields on grids: what cannot be computed at a single point, sampled once and made a function again.
//!
//! Spectral synthesis, erosion and the like know no point without knowing all others, so they give
//! arrays of samples. A [`Grid`] makes of these a C2 function of space that enters expressions like a
//! noise does: the cubic spline through the samples, with proven bounds.
//!
//! - [`Frame`] says where samples lie: a *volume* of three axes, or a *heightfield*, which has one
//!   sample along y and is constant in that direction.
//! - [`Samples`] are values in a frame, to be computed with.
//! - [`Grid`] is the spline through samples, a [`Kernel`](crate::num::Kernel).
//!
//! What makes samples, one file each: [`spectrum`] (random fields of a given power spectrum, the sea),
//! [`additions`] (successive random additions), [`spot`] (spot noise), [`erosion`] (water) and
//! [`weathering`] (slopes that crumble). All random numbers are hashes of seed and place, and no sum
//! depends on the number of threads.

pub mod additions;
mod bound;
pub mod erosion;
mod kernel;
mod random;
pub mod spectrum;
pub mod spot;
#[cfg(test)]
mod tests;
pub mod weathering;

pub use crate::num::Edge;

use crate::num::{Digest, Order, interpolate_cubic};
use bound::Pyramid;
use rayon::prelude::*;
use std::hash::{Hash, Hasher};
use std::sync::{Arc, OnceLock};

/// Samples that a grid may have: 512 MiB.
pub const MOST_SAMPLES: usize = 1 << 26;

/// Asks whether a long job is to stop.
pub type Cancel<'a> = &'a (dyn Fn() -> bool + Sync);

/// The answer of a job that goes on to its end.
pub fn never() -> bool {
    false
}

/// Why there is no grid.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum Failure {
    /// An axis has no samples, or all together have too many.
    #[error("a grid of {} x {} x {} samples is not possible: there must be from 1 to {MOST_SAMPLES}", .0[0], .0[1], .0[2])]
    Size([usize; 3]),
    /// The number of values is not that of the frame.
    #[error("a grid of {wanted} samples cannot be made of {given} values")]
    Count {
        /// Values.
        given: usize,
        /// Places.
        wanted: usize,
    },
    /// Samples too close or too far apart, or nowhere.
    #[error("samples cannot be {0} apart: the distance must be from 1e-12 to 1e12")]
    Spacing(f64),
    /// Too far away.
    #[error("a grid cannot lie at {0}: coordinates go to 1e15")]
    Place(f64),
    /// Infinite, or not a number, or so large that its differences are.
    #[error("sample {index} of the grid is {value}: samples must be finite and below 1e100")]
    Value {
        /// Which.
        index: usize,
        /// What it is.
        value: f64,
    },
    /// The transform wants powers of two.
    #[error("spectral synthesis needs powers of two along each axis, not {0}")]
    Power(usize),
    /// A spectrum must be finite and not negative.
    #[error("the spectrum is {value} at the frequency ({}, {}, {})", .at[0], .at[1], .at[2])]
    Spectrum {
        /// Its value.
        value: f64,
        /// Where.
        at: [f64; 3],
    },
    /// All samples are the same, so they cannot be given a unit variance.
    #[error("{0} is zero everywhere")]
    Silent(&'static str),
    /// A job for heightfields was given a volume.
    #[error("{0} works on heightfields, and this grid is a volume")]
    Volume(&'static str),
    /// Somebody wanted it to stop.
    #[error("the grid was not finished")]
    Cancelled,
}

/// Where samples lie.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Frame {
    /// Samples along each axis. An axis of one sample is a direction in which nothing changes.
    pub size: [usize; 3],
    /// Where the first sample lies.
    pub origin: [f64; 3],
    /// Distance of neighbouring samples.
    pub spacing: [f64; 3],
    /// What lies beyond the last sample.
    pub edge: Edge,
}

impl Frame {
    /// The frame whose samples fill the box from `min` to `max`. A clamped grid has samples on both
    /// ends; one that repeats has them on the first, since the last is the first again.
    ///
    /// # Errors
    /// When there are too many samples, or the box is empty or out of bounds.
    pub fn over(size: [usize; 3], min: [f64; 3], max: [f64; 3], edge: Edge) -> Result<Self, Failure> {
        let gaps = |n: usize| if edge == Edge::Repeat { n } else { n.max(2) - 1 };
        let spacing = std::array::from_fn(|axis| {
            if size[axis] == 1 { 1.0 } else { (max[axis] - min[axis]) / gaps(size[axis]) as f64 }
        });
        Frame { size, origin: min, spacing, edge }.checked()
    }

    /// The frame, if a grid can have it.
    ///
    /// # Errors
    /// When it cannot.
    pub fn checked(self) -> Result<Self, Failure> {
        let count = self.size.iter().try_fold(1usize, |product, n| product.checked_mul(*n));
        if !count.is_some_and(|count| (1..=MOST_SAMPLES).contains(&count)) {
            return Err(Failure::Size(self.size));
        }
        if let Some(wrong) = self.spacing.iter().find(|s| !(1e-12..=1e12).contains(*s)) {
            return Err(Failure::Spacing(*wrong));
        }
        match self.origin.iter().find(|o| !(-1e15..=1e15).contains(*o)) {
            Some(wrong) => Err(Failure::Place(*wrong)),
            None => Ok(self),
        }
    }

    /// Number of samples.
    pub fn count(&self) -> usize {
        self.size.iter().product()
    }

    /// Whether nothing changes along y.
    pub fn is_heightfield(&self) -> bool {
        self.size[1] == 1
    }

    /// The three numbers of a sample, counted along x first, then y, then z.
    pub fn index(&self, i: usize) -> [usize; 3] {
        let [nx, ny, _] = self.size;
        [i % nx, i / nx % ny, i / (nx * ny)]
    }

    /// Where a sample lies. The samples of a heightfield lie in the plane of its origin.
    pub fn place(&self, i: usize) -> [f64; 3] {
        let index = self.index(i);
        std::array::from_fn(|axis| self.origin[axis] + index[axis] as f64 * self.spacing[axis])
    }

    /// Lengths of the edges of the region that the samples stand for, one cell each.
    pub fn extent(&self) -> [f64; 3] {
        std::array::from_fn(|axis| self.size[axis] as f64 * self.spacing[axis])
    }

    /// The number of the sample `step` away along an axis of `n` from number `i`.
    #[inline(always)]
    pub(crate) fn neighbour(&self, i: usize, step: isize, n: usize) -> usize {
        match self.edge {
            Edge::Repeat => (i as isize + step).rem_euclid(n as isize) as usize,
            Edge::Clamp => (i as isize + step).clamp(0, n as isize - 1) as usize,
        }
    }
}

/// Values in a frame.
#[derive(Clone, PartialEq, Debug)]
pub struct Samples {
    /// Where they lie.
    pub frame: Frame,
    /// What they are, along x first, then y, then z.
    pub values: Vec<f64>,
}

impl Samples {
    /// The values of a function; it is cloned for every worker, so it may have memory of its own.
    ///
    /// # Errors
    /// When cancelled.
    pub fn of<F>(frame: Frame, f: F, cancel: Cancel<'_>) -> Result<Samples, Failure>
    where
        F: FnMut([f64; 3]) -> f64 + Clone + Send + Sync,
    {
        let frame = frame.checked()?;
        let mut values = vec![0.0; frame.count()];
        // Rows are handed out whole: one question to `cancel` and one clone for each is cheap.
        values.par_chunks_mut(frame.size[0]).enumerate().try_for_each_init(
            || f.clone(),
            |f, (row, values)| {
                if cancel() {
                    return Err(Failure::Cancelled);
                }
                for (i, value) in values.iter_mut().enumerate() {
                    *value = f(frame.place(row * frame.size[0] + i));
                }
                Ok(())
            },
        )?;
        Ok(Samples { frame, values })
    }

    /// Smallest and largest value.
    pub fn extremes(&self) -> (f64, f64) {
        let widen = |(lo, hi): (f64, f64), v: &f64| (lo.min(*v), hi.max(*v));
        self.values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), widen)
    }

    /// Mean value and mean square deviation from it.
    pub fn moments(&self) -> (f64, f64) {
        let count = self.values.len() as f64;
        let mean = total(&self.values) / count;
        let squares: Vec<f64> = self.values.iter().map(|v| (v - mean) * (v - mean)).collect();
        (mean, total(&squares) / count)
    }

    /// The same with zero mean and unit variance.
    fn standardized(mut self, what: &'static str) -> Result<Self, Failure> {
        let (mean, variance) = self.moments();
        let deviation = variance.sqrt();
        if let Some(index) = self.values.iter().position(|v| !v.is_finite()) {
            return Err(Failure::Value { index, value: self.values[index] });
        }
        if deviation == 0.0 || !deviation.is_finite() {
            return Err(Failure::Silent(what));
        }
        self.values.iter_mut().for_each(|v| *v = (*v - mean) / deviation);
        Ok(self)
    }

    /// The heightfield that a job needs.
    fn heightfield(&self, job: &'static str) -> Result<(), Failure> {
        if self.frame.is_heightfield() { Ok(()) } else { Err(Failure::Volume(job)) }
    }
}

/// Sum of many values, by halves: in a fixed order, and off by the logarithm of their number only.
pub fn total(values: &[f64]) -> f64 {
    if values.len() <= 64 {
        return values.iter().sum();
    }
    let (a, b) = values.split_at(values.len() / 2);
    total(a) + total(b)
}

/// An immutable field known from samples.
///
/// ```text
/// level + sum_ijk c_ijk B(u - i) B(v - j) B(w - k),     (u, v, w) = (x - origin) / spacing
/// ```
///
/// with the cubic B-spline `B` (see [`num::bspline`](crate::num)). It is C2 whatever the coefficients
/// are, and so across the edges: a grid that repeats has periodic coefficients, and a clamped one
/// repeats the coefficients of its faces for ever. A clamped field still passes through its outermost
/// samples, comes to rest within two spacings beyond them, and is constant from there on (at the
/// outermost coefficient, which is near the sample).
///
/// The [`Kernel`](crate::num::Kernel) is the spline without `level`, the middle between the extreme
/// coefficients: it goes as far up as down, as the bounds of kernels do.
#[derive(Clone, Debug)]
pub struct Grid {
    frame: Frame,
    /// One over the spacing.
    scale: [f64; 3],
    level: f64,
    coefficients: Arc<[f64]>,
    /// Made when it is first asked for: grids that only others are made of never are.
    bounds: Arc<OnceLock<Pyramid>>,
    digest: Digest,
}

impl Grid {
    /// The spline through samples.
    ///
    /// # Errors
    /// When the frame is impossible, or the samples do not fit it or are not finite.
    pub fn through(samples: &Samples) -> Result<Grid, Failure> {
        let frame = samples.frame.checked()?;
        if let Some(index) =
            samples.values.iter().position(|v| v.abs().partial_cmp(&1e100).is_none_or(|o| o.is_ge()))
        {
            return Err(Failure::Value { index, value: samples.values[index] });
        }
        let mut coefficients = samples.values.clone();
        if coefficients.len() == frame.count() {
            for axis in 0..3 {
                prefilter(&mut coefficients, frame, axis);
            }
        }
        Grid::spline(frame, coefficients)
    }

    /// The spline with these coefficients, which it approaches without passing through them.
    ///
    /// # Errors
    /// As [`through`](Grid::through).
    pub fn spline(frame: Frame, mut coefficients: Vec<f64>) -> Result<Grid, Failure> {
        let frame = frame.checked()?;
        if coefficients.len() != frame.count() {
            return Err(Failure::Count { given: coefficients.len(), wanted: frame.count() });
        }
        if let Some(index) = coefficients.iter().position(|v| !v.is_finite()) {
            return Err(Failure::Value { index, value: coefficients[index] });
        }
        let widen = |(lo, hi): (f64, f64), v: &f64| (lo.min(*v), hi.max(*v));
        let (lo, hi) = coefficients.iter().fold((f64::INFINITY, f64::NEG_INFINITY), widen);
        let level = 0.5 * (lo + hi);
        coefficients.iter_mut().for_each(|c| *c -= level);
        let scale = frame.spacing.map(|s| 1.0 / s);
        let mut digest = Digest::default();
        digest.numbers([level]);
        digest.numbers(coefficients.iter().copied());
        Ok(Grid { frame, scale, level, coefficients: coefficients.into(), bounds: Arc::default(), digest })
    }

    /// Finds its bounds, if they were not found yet. Who is to evaluate it by many threads does so before: they all help to
    /// find them, and one that waited for another would wait for itself.
    ///
    /// # Errors
    /// When cancelled.
    pub fn bind(&self, cancel: Cancel<'_>) -> Result<(), Failure> {
        if self.bounds.get().is_none() {
            let found = Pyramid::new(&self.frame, self.scale, &self.coefficients, cancel);
            if cancel() {
                return Err(Failure::Cancelled);
            }
            // Whoever was quicker found the same.
            let _ = self.bounds.set(found);
        }
        Ok(())
    }

    /// Its bounds.
    fn pyramid(&self) -> &Pyramid {
        self.bounds.get_or_init(|| Pyramid::new(&self.frame, self.scale, &self.coefficients, &never))
    }

    /// Where its samples lie.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// What is to be added to the kernel.
    pub fn level(&self) -> f64 {
        self.level
    }

    /// Value at a point.
    pub fn value(&self, at: [f64; 3]) -> f64 {
        self.level + crate::num::Kernel::jet(self, Order::Value, at).value
    }

    /// The field at its samples: those that the spline was laid through, up to rounding.
    pub fn samples(&self) -> Samples {
        let mut values = self.coefficients.to_vec();
        for axis in 0..3 {
            each_line(&mut values, self.frame.size, axis, |line| {
                let old = line.to_vec();
                let n = line.len();
                for i in 0..n {
                    let [before, after] = match (1..n - 1).contains(&i) {
                        true => [old[i - 1], old[i + 1]],
                        false => [-1, 1].map(|step| old[self.frame.neighbour(i, step, n)]),
                    };
                    line[i] = old[i] + (before - 2.0 * old[i] + after) / 6.0;
                }
            });
        }
        values.iter_mut().for_each(|v| *v += self.level);
        Samples { frame: self.frame, values }
    }

    /// What it is, in 16 bytes: the same grid has the same in every run of the program.
    pub fn fingerprint(&self) -> Digest {
        let mut digest = Digest::default();
        self.hash(&mut digest);
        digest
    }

    fn identity(&self) -> (Digest, [usize; 3], [u64; 3], [u64; 3], Edge) {
        let Frame { size, origin, spacing, edge } = self.frame;
        (self.digest, size, origin.map(f64::to_bits), spacing.map(f64::to_bits), edge)
    }
}

impl PartialEq for Grid {
    fn eq(&self, other: &Self) -> bool {
        let bits = |g: &Grid| g.coefficients.iter().map(|c| c.to_bits()).collect::<Vec<_>>();
        self.identity() == other.identity()
            && self.level.to_bits() == other.level.to_bits()
            && (Arc::ptr_eq(&self.coefficients, &other.coefficients) || bits(self) == bits(other))
    }
}

impl Eq for Grid {}

impl Hash for Grid {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.identity().hash(state);
    }
}

/// From samples to coefficients along one axis.
fn prefilter(values: &mut [f64], frame: Frame, axis: usize) {
    each_line(values, frame.size, axis, |line| interpolate_cubic(line, frame.edge));
}

/// Runs a job on every line of an array along an axis. It leaves a line of one sample as it is, and is not asked to.
fn each_line(
    values: &mut [f64],
    [nx, ny, nz]: [usize; 3],
    axis: usize,
    job: impl Fn(&mut [f64]) + Sync + Send,
) {
    match axis {
        _ if [nx, ny, nz][axis] == 1 => {}
        0 => values.par_chunks_mut(nx).for_each(job),
        1 => values.par_chunks_mut(nx * ny).for_each(|slab| columns(slab, nx, ny, &job)),
        // Lines across all slabs: one thread for each would tear the array apart.
        _ => columns(values, nx * ny, nz, &job),
    }
}

/// Runs a job on every column of a matrix with rows of `width`, several columns at a time so that
/// memory is read in order.
fn columns(matrix: &mut [f64], width: usize, height: usize, job: impl Fn(&mut [f64])) {
    const TOGETHER: usize = 16;
    let mut lines = vec![0.0; TOGETHER * height];
    for first in (0..width).step_by(TOGETHER) {
        let count = TOGETHER.min(width - first);
        for (row, part) in matrix.chunks_exact(width).enumerate() {
            for k in 0..count {
                lines[k * height + row] = part[first + k];
            }
        }
        lines.chunks_exact_mut(height).take(count).for_each(&job);
        for (row, part) in matrix.chunks_exact_mut(width).enumerate() {
            for k in 0..count {
                part[first + k] = lines[k * height + row];
            }
        }
    }
}
