//! Where a curve is zero, and where it only jumps over zero.
//!
//! Samples tell that a sign changes, not why: sin x has a zero there, tan x a pole, a step a jump. So the piece between
//! two signs is sampled again and again, more and more finely. As it shrinks, so does the difference of the values at its
//! ends if the function is continuous; at a jump it stays as it was, at a pole it grows.

use super::plot::Points;
use crate::diag::Diagnostic;

/// A piece is divided into so many.
const PARTS: usize = 32;
/// So many times.
const ROUNDS: usize = 6;

/// Samples that follow each other.
type Samples<'a> = &'a [(f64, f64)];

/// What a curve does at zero, from left to right.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Zeros {
    /// Where it is zero: stretches, most of which are places.
    pub zeros: Vec<(f64, f64)>,
    /// Where it changes its sign without being zero.
    pub jumps: Vec<f64>,
}

/// Samples a curve at so many places from one to another, both included.
pub trait Sample: Fn((f64, f64), usize) -> Result<Points, Box<Diagnostic>> {}
impl<F: Fn((f64, f64), usize) -> Result<Points, Box<Diagnostic>>> Sample for F {}

impl Zeros {
    /// Those of a curve with these samples.
    ///
    /// # Errors
    /// As for sampling more of it.
    pub fn of(points: Samples<'_>, sample: &impl Sample) -> Result<Zeros, Box<Diagnostic>> {
        let mut found = Zeros::default();
        let finite = |run: &Samples<'_>| run[0].1.is_finite();
        for run in points.chunk_by(|a, b| a.1.is_finite() && b.1.is_finite()).filter(finite) {
            let mut rest = run;
            while let Some((piece, after)) = next(rest) {
                found.note(piece, sample)?;
                rest = after;
            }
        }
        Ok(found)
    }

    /// Notes what is in a piece from a sign to the other, or of zeros.
    fn note(&mut self, piece: Samples<'_>, sample: &impl Sample) -> Result<(), Box<Diagnostic>> {
        let (from, to) = (piece[0], piece[piece.len() - 1]);
        if from.1 == 0.0 {
            self.zeros.push((from.0, to.0));
            return Ok(());
        }
        let (mut low, mut high) = (from, to);
        for _ in 0..ROUNDS {
            let points = sample((low.0, high.0), PARTS + 1)?;
            // What is no number in between has no sign to follow.
            let Some((change, _)) = next(&points) else { return Ok(()) };
            (low, high) = (change[0], change[change.len() - 1]);
            if low.1 == 0.0 {
                self.zeros.push((low.0, high.0));
                return Ok(());
            }
        }
        let (width, gap) = ((high.0 - low.0) / (to.0 - from.0), (high.1 - low.1) / (to.1 - from.1));
        let place = 0.5 * (low.0 + high.0);
        // The cube root is the steepest that is a zero here.
        if gap.abs() <= 4.0 * libm::cbrt(width) {
            self.zeros.push((place, place));
        } else {
            self.jumps.push(place);
        }
        Ok(())
    }
}

/// Whether a curve grows on and on about its largest sample, the more finely the more: at a pole it does.
///
/// # Errors
/// As for sampling more of it.
pub fn has_pole(points: Samples<'_>, sample: &impl Sample) -> Result<bool, Box<Diagnostic>> {
    let size = |p: &(f64, f64)| if p.1.is_finite() { p.1.abs() } else { 0.0 };
    let Some(top) = (0..points.len()).max_by(|a, b| size(&points[*a]).total_cmp(&size(&points[*b]))) else {
        return Ok(false);
    };
    let (low, high) = (points[top.saturating_sub(1)].0, points[(top + 1).min(points.len() - 1)].0);
    let finer = sample((low, high), PARTS + 1)?;
    Ok(finer.iter().any(|p| size(p) > 2.0 * size(&points[top])))
}

/// The first piece of samples from a sign to the other, or of zeros that no change of sign is at, and what follows it.
/// What follows begins with the last sample of a change.
fn next(points: Samples<'_>) -> Option<(Samples<'_>, Samples<'_>)> {
    let sign = |i: usize| points.get(i).map_or(0.0, |p| if p.1 == 0.0 { 0.0 } else { p.1.signum() });
    let mut i = 0;
    while i < points.len() {
        let zeros = points[i..].iter().take_while(|p| p.1 == 0.0).count();
        let end = i + zeros;
        match zeros {
            0 if sign(i) * sign(i + 1) < 0.0 => return Some((&points[i..=i + 1], &points[i + 1..])),
            0 => i += 1,
            // A single zero between two signs is looked at more closely: a step may be zero in its middle.
            1 if i > 0 && sign(i - 1) * sign(end) < 0.0 => {
                return Some((&points[i - 1..=end], &points[end..]));
            }
            _ => return Some((&points[i..end], &points[end..])),
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples((from, to): (f64, f64), count: usize, f: impl Fn(f64) -> f64) -> Points {
        let place = |i: usize| from + (to - from) * (i as f64 / (count - 1) as f64);
        (0..count).map(place).map(|x| (x, f(x))).collect()
    }

    fn zeros(ends: (f64, f64), f: impl Fn(f64) -> f64) -> Zeros {
        let sample = |ends: (f64, f64), count: usize| Ok(samples(ends, count, &f));
        Zeros::of(&samples(ends, 2001, &f), &sample).unwrap()
    }

    #[track_caller]
    fn check(found: &Zeros, zeros: &[f64], jumps: &[f64]) {
        let close =
            |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
        let places: Vec<f64> = found.zeros.iter().map(|z| z.0).collect();
        assert!(close(&places, zeros) && close(&found.jumps, jumps), "{found:?}");
    }

    #[test]
    fn zeros_are_no_poles_and_no_jumps() {
        use std::f64::consts::{FRAC_PI_2, PI};
        check(&zeros((0.0, 6.0), libm::tan), &[0.0, PI], &[FRAC_PI_2, 3.0 * FRAC_PI_2]);
        check(&zeros((-1.0, 1.1), |x| 1.0 / x), &[], &[0.0]);
        check(&zeros((-1.0, 1.0), |x| 1.0 / x), &[], &[]);
        let step = |x: f64| if x == 0.5 { 0.0 } else { (x - 0.5).signum() };
        check(&zeros((0.0, 1.0), step), &[], &[0.5]);
        check(&zeros((0.0, 1.3), step), &[], &[0.5]);
        check(&zeros((-1.0, 1.3), libm::cbrt), &[0.0], &[]);
        check(&zeros((-1.0, 1.3), |x| libm::tanh(1e6 * x)), &[0.0], &[]);
        check(&zeros((1e6, 1e6 + 1.0), |x| x - 1e6 - 0.3), &[1e6 + 0.3], &[]);
    }

    #[test]
    fn zeros_are_found_at_ends_where_curves_touch_and_over_stretches() {
        check(&zeros((0.0, 1.0), |x| x), &[0.0], &[]);
        check(&zeros((-1.0, 0.0), |x| x), &[0.0], &[]);
        check(&zeros((-1.0, 1.0), |x| x * x), &[0.0], &[]);
        assert_eq!(zeros((-1.0, 1.0), |x| x.max(0.0)).zeros, [(-1.0, 0.0)]);
        assert_eq!(zeros((-1.0, 1.0), |x| x - x.clamp(-0.5, 0.5)).zeros, [(-0.5, 0.5)]);
        check(&zeros((0.0, 1.0), |_| f64::NAN), &[], &[]);
    }

    #[test]
    fn poles_are_told_from_peaks_and_steps() {
        type Function = fn(f64) -> f64;
        let cases: [(Function, bool); 7] = [
            (libm::tan, true),
            (|x| 1.0 / (x * x), true),
            (|x| 1.0 / (x - 0.3), true),
            (|x| libm::exp(-1e5 * x * x), false),
            (f64::signum, false),
            (libm::log, false),
            (|_| f64::NAN, false),
        ];
        for (f, wanted) in cases {
            let sample = |ends: (f64, f64), count: usize| Ok(samples(ends, count, f));
            assert_eq!(has_pole(&samples((-1.0, 2.0), 2001, f), &sample).unwrap(), wanted);
        }
    }
}
