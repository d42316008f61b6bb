//! Samples of a bent ray, or of the lines of a beam side by side, and what three of them in a row look like.

use glam::DVec3;

/// How far the middle of three places in a row may be from halfway between the others, as a share of how far these are
/// apart, for a line through them to be called straight; and how far the middle of a beam may be from its corners' mean.
const STRAIGHT: f64 = 0.0625;

/// Places at a depth, where the flow carries them, and the solid before it flowed there: of one line, or of the middle of a
/// beam and its four corners.
#[derive(Clone, Copy)]
pub(super) struct Sample<const N: usize> {
    pub depth: f64,
    pub at: [DVec3; N],
    pub values: [f64; N],
}

/// A root on a line: its depth, and how fast the field falls there.
#[derive(Clone, Copy)]
pub(super) struct Root {
    pub depth: f64,
    pub slope: f64,
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

    /// Whether none is.
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

    /// How far the value in the middle is from that of a plane through the corners, and how far the corners are from one;
    /// infinite where the places themselves are that far off. Nothing of a single line.
    fn fold(&self) -> f64 {
        let (Some((middle, corners)), Some((value, values))) =
            (self.at.split_first(), self.values.split_first())
        else {
            return 0.0;
        };
        let ([a, b, c, d], [f, g, h, i]) = (corners, values) else { return 0.0 };
        let bulge = (0.25 * (a + b + c + d)).distance(*middle).max(0.25 * (a + d - b - c).length());
        if bulge > STRAIGHT * self.width() {
            return f64::INFINITY;
        }
        (0.25 * (f + g + h + i) - value).abs() + (0.25 * (f + i - g - h)).abs()
    }
}

/// How far the middle one of three values is from halfway between the others, if the places are in a straight row.
fn sag<const N: usize>([a, m, b]: &[Sample<N>; 3], line: usize) -> Option<f64> {
    let (from, to) = (a.at[line], b.at[line]);
    let is_straight = from.midpoint(to).distance(m.at[line]) <= STRAIGHT * from.distance(to);
    is_straight.then(|| m.values[line] - 0.5 * (a.values[line] + b.values[line]))
}

/// Whether a parabola through three values only falls, or only rises, with twice the sag as well.
fn is_monotonic(a: f64, b: f64, sag: f64) -> bool {
    8.0 * sag.abs() <= (a - b).abs()
}

/// Whether three samples in a row, the middle one halfway, are outside and look as if all between them were: straight, with
/// values like those of a parabola that has no root, bent twice as much.
pub(super) fn goes_free<const N: usize>(row: &[Sample<N>; 3]) -> bool {
    let fold = row.iter().map(Sample::fold).fold(0.0, f64::max);
    row.iter().all(Sample::is_outside)
        && (0..N).all(|line| {
            let [a, b] = [row[0].values[line], row[2].values[line]];
            sag(row, line).is_some_and(|sag| {
                let dip = if is_monotonic(a, b, sag) { 0.0 } else { sag.abs() };
                a.min(b) > 2.0 * (fold + dip)
            })
        })
}

/// The roots of all lines, where each falls from above to below zero along three samples that look straight.
pub(super) fn crossing<const N: usize>(row: &[Sample<N>; 3]) -> Option<[Root; N]> {
    let [first, _, last] = row;
    let is_within = first.is_outside() && last.is_inside();
    let fold = row.iter().map(Sample::fold).fold(0.0, f64::max);
    if !is_within || !fold.is_finite() {
        return None;
    }
    let mut roots = [Root { depth: 0.0, slope: 0.0 }; N];
    for (line, root) in roots.iter_mut().enumerate() {
        let (a, b, sag) = (first.values[line], last.values[line], sag(row, line)?);
        if !is_monotonic(a, b, sag) || 8.0 * fold > a - b {
            return None;
        }
        // Of `a + linear u + square u^2`, for `u` from 0 to 1.
        let (linear, square, length) = (b - a + 4.0 * sag, -4.0 * sag, last.depth - first.depth);
        let u = 2.0 * a / ((linear * linear - 4.0 * square * a).sqrt() - linear);
        *root = Root { depth: first.depth + u * length, slope: -(linear + 2.0 * square * u) / length };
    }
    Some(roots)
}
