//! How steep the field may be near the surface, and because of which lines.

use super::sight::Sight;
use crate::expr::NodeId;
use crate::field::{Stopped, Terms, Watch};
use crate::session::ledger::{Ledger, Line};
use crate::tape::Cells;
use glam::DVec3;
use serde::Serialize;
use std::collections::{BTreeMap, HashSet};
use std::time::{Duration, Instant};

/// Boxes that are looked at,
const BOXES: usize = 240;

/// and how many pixels they reach from a point of the surface: a beam of 64 rays is as wide as such a box.
pub(super) const REACH: f64 = 4.0;

/// Lines of which it is found out what the bound would be without them.
const LINES: usize = 12;

/// After so long, boxes or lines that are left are not looked at any more.
const PATIENCE: Duration = Duration::from_millis(1000);

/// Corners of a box, every other one, where samples are taken besides its middle.
pub(super) const CORNERS: [[f64; 3]; 4] =
    [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];

/// How steep the field may be near the surface: averages over boxes around points of it, which reach four pixels to each
/// side.
#[derive(Clone, Debug, Serialize)]
pub struct Bound {
    /// Bound of the slope.
    pub mean: f64,
    /// The largest of all boxes.
    pub most: f64,
    /// The largest slope of a few samples in each box.
    pub steepest: f64,
    /// Share of the boxes in which there is no bound; the other numbers are of the rest.
    pub unbounded: f64,
    /// The lines that the bound comes from, the steepest first; their shares sum to one.
    pub lines: Vec<LineBound>,
}

impl Bound {
    /// How many times as steep as the samples the bound is.
    pub fn looseness(&self) -> f64 {
        self.mean / self.steepest
    }
}

/// What a line adds to the bound.
#[derive(Clone, Debug, Serialize)]
pub struct LineBound {
    /// The line.
    #[serde(flatten)]
    pub line: Line,
    /// Its share.
    pub share: f64,
    /// What the bound would be if the terms of this line did not vary; found out for the first dozen, if that is quick.
    pub without: Option<f64>,
    /// How many times as steep as in the samples the bounds of its terms are.
    pub looseness: f64,
}

/// What is known of a term, summed over boxes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TermSlopes {
    /// Share of the bound times the bound.
    part: f64,
    /// Bounds, and largest slopes of samples.
    bounds: f64,
    samples: f64,
    /// Boxes in which it has no bound, and is why the field has none.
    pub boundless: usize,
}

/// The terms of the field, and how many boxes were looked at.
#[derive(Debug, Default)]
pub(super) struct Slopes {
    pub terms: BTreeMap<NodeId, TermSlopes>,
    pub boxes: usize,
}

/// Bounds around points of the surface, by cells that keep values.
pub(super) fn of(
    cells: &Cells,
    seen: &[Sight],
    ledger: &Ledger,
    watch: &Watch<'_>,
) -> Result<(Bound, Slopes), Stopped> {
    let step = seen.len().div_ceil(BOXES).max(1);
    let mut seen: Vec<&Sight> = seen.iter().step_by(step).collect();
    let (mut slopes, mut bounds, mut steepest) = (Slopes::default(), Vec::new(), 0.0);
    let start = Instant::now();
    for sight in &seen {
        watch.check()?;
        if start.elapsed() > PATIENCE {
            break;
        }
        slopes.boxes += 1;
        if let Some((bound, sample)) = look(cells, sight, &mut slopes) {
            bounds.push(bound);
            steepest += sample;
        }
    }
    seen.truncate(slopes.boxes);
    let (bounded, sum) = (bounds.len().max(1) as f64, bounds.iter().sum::<f64>());
    let mut lines = by_line(&slopes, ledger, sum);
    let start = Instant::now();
    for line in lines.iter_mut().take(LINES) {
        watch.check()?;
        if start.elapsed() > PATIENCE {
            break;
        }
        line.without = Some(without(cells, &seen, &slopes, ledger, &line.line));
    }
    let bound = Bound {
        mean: sum / bounded,
        most: bounds.iter().copied().fold(0.0, f64::max),
        steepest: steepest / bounded,
        unbounded: 1.0 - bounds.len() as f64 / seen.len().max(1) as f64,
        lines,
    };
    Ok((bound, slopes))
}

fn terms(cells: &Cells, sight: &Sight) -> Terms {
    Terms::new(cells.tape_around(sight.p.to_array(), REACH * sight.footprint).clone())
}

/// Looks at the box around a point: its bound, and the largest slope of its samples. `None` if there is no bound.
fn look(cells: &Cells, sight: &Sight, slopes: &mut Slopes) -> Option<(f64, f64)> {
    let terms = terms(cells, sight);
    let found = terms.steepness(&sight.region(REACH));
    if !found.bound.is_finite() {
        for (slot, _) in &found.shares {
            slopes.terms.entry(terms.node(*slot)).or_default().boundless += 1;
        }
        return None;
    }
    let corners = CORNERS.map(|corner| sight.p + REACH * sight.footprint * DVec3::from_array(corner));
    let mut samples = terms.slopes_at(sight.p.to_array());
    for corner in corners {
        let there = terms.slopes_at(corner.to_array());
        // A slope that is not a number is none.
        samples.iter_mut().zip(there).for_each(|(sample, slope)| *sample = sample.max(slope));
    }
    for (slot, share) in &found.shares {
        let term = slopes.terms.entry(terms.node(*slot)).or_default();
        term.part += share * found.bound;
        term.bounds += found.bound_of(*slot);
        term.samples += samples[*slot as usize];
    }
    Some((found.bound, samples[terms.root() as usize]))
}

/// The lines that terms belong to.
fn by_line(slopes: &Slopes, ledger: &Ledger, sum: f64) -> Vec<LineBound> {
    let mut lines: BTreeMap<Line, TermSlopes> = BTreeMap::new();
    for (node, term) in &slopes.terms {
        let line = lines.entry(ledger.line(*node)).or_default();
        line.part += term.part;
        line.bounds += term.bounds;
        line.samples += term.samples;
    }
    let of = |(line, all): (Line, TermSlopes)| LineBound {
        line,
        share: all.part / sum,
        without: None,
        looseness: all.bounds / all.samples,
    };
    let mut lines: Vec<LineBound> = lines.into_iter().filter(|(_, all)| all.part > 0.0).map(of).collect();
    lines.sort_by(|a, b| b.share.total_cmp(&a.share));
    lines
}

/// The mean bound if the terms of a line did not vary.
fn without(cells: &Cells, seen: &[&Sight], slopes: &Slopes, ledger: &Ledger, line: &Line) -> f64 {
    let still: HashSet<NodeId> =
        slopes.terms.keys().copied().filter(|node| ledger.line(*node) == *line).collect();
    let bounds = seen
        .iter()
        .map(|sight| terms(cells, sight).bound_without(&sight.region(REACH), |node| still.contains(&node)));
    let bounds: Vec<f64> = bounds.filter(|bound| bound.is_finite()).collect();
    bounds.iter().sum::<f64>() / bounds.len().max(1) as f64
}
