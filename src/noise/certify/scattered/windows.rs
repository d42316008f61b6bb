//! Largest values over windows: what the nodes of each of 27 cells can add, for all places of a point
//! at once.
//!
//! Along each axis the maxima of all windows of one length take three comparisons an entry, however
//! long the window: cut the line into blocks as long as windows, then every window is the end of one
//! block and the start of the next (van Herk 1992; Gil and Werman 1993).

/// Maxima of a table over the offsets between a place of the cell and the nodes of each cell.
pub(super) struct Windows {
    /// By number of the place less the start of the cell of nodes, from `-n` to `2n` along each axis.
    most: Vec<f32>,
    n: usize,
}

impl Windows {
    /// From a table of `2n` entries along each axis for the offsets from `-1` to 1, `n` places to a
    /// cell, whose nodes keep a margin of so many places.
    pub(super) fn new(mut table: Vec<f32>, n: usize, margin: usize) -> Windows {
        let mut shape = [2 * n; 3];
        for _ in 0..3 {
            table = slide(&table, shape, n, margin);
            shape = [3 * n, shape[0], shape[1]];
        }
        Windows { most: table, n }
    }

    /// Sum over all cells for the place with a number.
    #[inline]
    pub(super) fn sum(&self, place: usize) -> f64 {
        let n = self.n;
        let [a, b, c] = [place / n / n, place / n % n, place % n];
        (0..9)
            .map(|o| {
                let row = ((a + o / 3 * n) * 3 * n + b + o % 3 * n) * 3 * n + c;
                f64::from(self.most[row]) + f64::from(self.most[row + n]) + f64::from(self.most[row + 2 * n])
            })
            .sum()
    }

    /// Sums for all places.
    pub(super) fn sums(&self) -> impl Iterator<Item = f64> {
        (0..self.n.pow(3)).map(|place| self.sum(place))
    }
}

/// Sliding maxima along the last axis over the offsets between a place and a cell; the axes move on by
/// one, so that three calls do all.
///
/// A place `i` of `n` and the cell at `o` are apart by `i - n o - n + margin` to `i - n o - margin`
/// places; the result has an entry for each `i - n o`, from `-n` on.
fn slide(table: &[f32], shape: [usize; 3], n: usize, margin: usize) -> Vec<f32> {
    let [outer, middle, inner] = shape;
    let length = n + 1 - 2 * margin;
    let padded = 3 * n + length - 1;
    let mut out = vec![0.0; outer * middle * 3 * n];
    let (mut line, mut heads, mut tails) = (vec![0.0; padded], vec![0.0; padded], vec![0.0; padded]);
    for a in 0..outer {
        for b in 0..middle {
            let from = &table[(a * middle + b) * inner..][..inner];
            line.fill(0.0);
            for (i, value) in from.iter().enumerate() {
                // The first window starts at place -2 n + margin, and the line at -n.
                if let Some(slot) = (i + n).checked_sub(margin).and_then(|at| line.get_mut(at)) {
                    *slot = *value;
                }
            }
            for i in 0..padded {
                let fresh = i % length == 0;
                heads[i] = if fresh { line[i] } else { f32::max(heads[i - 1], line[i]) };
            }
            for i in (0..padded).rev() {
                let fresh = i + 1 == padded || (i + 1) % length == 0;
                tails[i] = if fresh { line[i] } else { f32::max(tails[i + 1], line[i]) };
            }
            for i in 0..3 * n {
                out[(i * outer + a) * middle + b] = f32::max(tails[i], heads[i + length - 1]);
            }
        }
    }
    out
}
