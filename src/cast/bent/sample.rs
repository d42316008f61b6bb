//! Samples of a bent ray, or of the edges of a beam side by side, and what three of a ray in a row look like.

use glam::DVec3;

/// How far the middle of three places in a row may be from halfway between the others, as a share of how far these are
/// apart, for a line through them to be called straight.
const STRAIGHT: f64 = 0.0625;

/// Where the flow carries the places of so many lines at a depth, and the solid before it flowed there.
#[derive(Clone, Copy)]
pub(super) struct Sample<const N: usize> {
    pub depth: f64,
    pub at: [DVec3; N],
    pub values: [f64; N],
}

/// A root on a line: its depth, how fast the field falls there, and the depth before which it is.
#[derive(Clone, Copy)]
pub(super) struct Root {
    pub depth: f64,
    pub slope: f64,
    pub end: f64,
}

impl<const N: usize> Sample<N> {
    /// The least distance from zero.
    pub fn least(&self) -> f64 {
        self.values.iter().fold(f64::INFINITY, |least, value| least.min(value.abs()))
    }

    /// Whether all places are outside.
    pub fn is_outside(&self) -> bool {
        self.values.iter().all(|value| *value > 0.0)
    }

    /// Whether all are inside.
    pub fn is_inside(&self) -> bool {
        self.values.iter().all(|value| *value <= 0.0)
    }

    /// The largest distance between its places.
    pub fn width(&self) -> f64 {
        let pairs = (0..N).flat_map(|i| (0..i).map(move |j| (i, j)));
        pairs.fold(0.0, |most, (i, j)| self.at[i].distance(self.at[j]).max(most))
    }

    /// The largest distance between its places and those of another.
    pub fn distance(&self, other: &Self) -> f64 {
        self.at.iter().flat_map(|a| other.at.map(|b| a.distance(b))).fold(0.0, f64::max)
    }

    /// The largest distance between a place and the same of another.
    pub fn length(&self, other: &Self) -> f64 {
        self.at.iter().zip(&other.at).fold(0.0, |most, (a, b)| a.distance(*b).max(most))
    }
}

/// How far the middle one of three values is from halfway between the others, if the places are in a straight row.
fn sag([a, m, b]: &[Sample<1>; 3]) -> Option<f64> {
    let ([from], [middle], [to]) = (a.at, m.at, b.at);
    let is_straight = from.midpoint(to).distance(middle) <= STRAIGHT * from.distance(to);
    is_straight.then(|| m.values[0] - 0.5 * (a.values[0] + b.values[0]))
}

/// Whether a parabola through three values only falls, or only rises, with twice the sag as well.
fn is_monotonic(a: f64, b: f64, sag: f64) -> bool {
    8.0 * sag.abs() <= (a - b).abs()
}

/// Whether three samples in a row, the middle one halfway, are outside and look as if all between them were: straight, with
/// values like those of a parabola that has no root, bent twice as much.
pub(super) fn goes_free(row: &[Sample<1>; 3]) -> bool {
    let [a, b] = [row[0].values[0], row[2].values[0]];
    row.iter().all(Sample::is_outside)
        && sag(row).is_some_and(|sag| is_monotonic(a, b, sag) || a.min(b) > 2.0 * sag.abs())
}

/// The root along three samples that look straight, where the field falls from above to below zero.
pub(super) fn crossing(row: &[Sample<1>; 3]) -> Option<Root> {
    let [first, _, last] = row;
    let (a, b, sag) = (first.values[0], last.values[0], sag(row)?);
    if !first.is_outside() || !last.is_inside() || !is_monotonic(a, b, sag) {
        return None;
    }
    // Of `a + linear u + square u^2`, for `u` from 0 to 1.
    let (linear, square, length) = (b - a + 4.0 * sag, -4.0 * sag, last.depth - first.depth);
    let u = 2.0 * a / ((linear * linear - 4.0 * square * a).sqrt() - linear);
    let slope = -(linear + 2.0 * square * u) / length;
    Some(Root { depth: first.depth + u * length, slope, end: last.depth })
}
