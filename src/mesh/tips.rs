//! Tips that the lattice shows as crumbs.
//!
//! Corners that are inside hang together along edges, and across faces whose saddle says so. A tip of the solid may reach
//! a corner in between: that is inside, none of its neighbours is, and what joins it with the body passes through
//! a cell along a diagonal. The mesh then has a crumb around that one corner, which floats before the body.
//!
//! Where it is proven that the solid holds a whole diagonal from such a corner to one of the body, the corner
//! counts as outside. What is lost of the tip is shorter than the diagonal of a cell, as with any tip that ends between
//! corners, and nothing else changes, since the crumb touches nothing. A crumb of which that is not proven stays: it may
//! be a part of its own.
//!
//! Along a piece of a diagonal the field `f` is negative if its enclosure is, or if it is negative at both ends and the
//! derivative of it along the diagonal keeps its sign.

use super::blocks::Block;
use super::contour::{Cell, Contour};
use super::lattice::{Lattice, Place, block_of};
use super::patches::NONE;
use super::weave::Web;
use crate::num::{Interval, Slope};
use crate::tape::{Evaluator, Tape};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Times that a diagonal is halved for the sake of the proof.
const HALVINGS: u32 = 5;

/// The crossings of a crumb in each of its cells.
const AROUND_CORNER: usize = 3;

/// The corners that count as outside.
pub(super) fn tips(
    tape: &Arc<Tape>,
    lattice: &Lattice,
    blocks: &[Block],
    contours: &[Contour],
) -> BTreeSet<Place> {
    let web = Web::new(contours);
    let is_crumb = |at: &Place, block: usize| {
        (0..8).all(|c| {
            let cell = cell_with(*at, c).and_then(|cell| web.cell(cell, block));
            cell.is_some_and(|(_, cell)| is_alone(cell, c))
        })
    };
    let firsts = (0..contours.len())
        .into_par_iter()
        .flat_map_iter(|i| contours[i].cells.iter().filter(|cell| is_alone(cell, 0)).map(move |c| (c.at, i)));
    let crumbs: Vec<(Place, usize)> = firsts.filter(|(at, block)| is_crumb(at, *block)).collect();
    let known: BTreeSet<Place> = crumbs.iter().map(|(at, _)| *at).collect();
    let slopes = || Evaluator::<Slope>::new(tape.clone());
    let hangs = |slopes: &mut Evaluator<Slope>, (at, block): &(Place, usize)| {
        (0..8).any(|c| {
            let Some((block, cell)) = cell_with(*at, c).and_then(|cell| web.cell(cell, *block)) else {
                return false;
            };
            let opposite = (0..8).filter(|&other| other != c && cell.inside >> other & 1 == 1);
            let body = opposite.map(|other| corner_of(cell.at, other)).filter(|other| !known.contains(other));
            let mut ends = body.map(|other| [*at, other].map(|at| lattice.corner(at)));
            ends.any(|ends| holds(&blocks[block].tape, ends, slopes))
        })
    };
    let tips = crumbs.par_iter().map_init(slopes, |slopes, crumb| hangs(slopes, crumb).then_some(crumb.0));
    tips.flatten().collect()
}

/// The first cells of the blocks that have a corner.
pub(super) fn blocks_with(at: Place) -> impl Iterator<Item = Place> {
    (0..8).filter_map(move |c| cell_with(at, c)).map(block_of)
}

/// The cell that has a corner as that number.
fn cell_with(at: Place, number: usize) -> Option<Place> {
    let mut cell = at;
    for (axis, i) in cell.iter_mut().enumerate() {
        *i = i.checked_sub((number >> axis & 1) as u32)?;
    }
    Some(cell)
}

fn corner_of(cell: Place, number: usize) -> Place {
    std::array::from_fn(|axis| cell[axis] + (number >> axis & 1) as u32)
}

/// Whether a corner of a cell is inside, and the surface parts it from all others.
fn is_alone(cell: &Cell, number: usize) -> bool {
    if cell.inside >> number & 1 == 0 {
        return false;
    }
    let edges = [0, 1, 2].map(|axis| {
        let mut start = corner_of([0; 3], number);
        start[axis] = 0;
        4 * axis + (start[(axis + 1) % 3] + 2 * start[(axis + 2) % 3]) as usize
    });
    let patches = edges.map(|edge| cell.patches.of_edge[edge]);
    let patch = patches[0];
    let size = cell.patches.of_edge.iter().filter(|other| **other == patch).count();
    patch != NONE && patches == [patch; 3] && size == AROUND_CORNER
}

/// Whether the solid is proven to hold a line between two places that are inside.
fn holds(tape: &Arc<Tape>, [from, to]: [DVec3; 2], slopes: &mut Evaluator<Slope>) -> bool {
    slopes.turn_to(tape);
    tape.is_defined(&hull(from, to)) && is_inside(from, to, HALVINGS, slopes)
}

fn is_inside(from: DVec3, to: DVec3, halvings: u32, slopes: &mut Evaluator<Slope>) -> bool {
    let along = *slopes.eval(&towards(hull(from, to), (to - from).normalize_or(DVec3::Y)));
    if along.value.hi < 0.0 {
        return true;
    }
    let mut is_negative = |p: DVec3| slopes.eval(&towards(hull(p, p), DVec3::Y)).value.hi < 0.0;
    if !(is_negative(from) && is_negative(to)) {
        return false;
    }
    if along.grad[0].lo >= 0.0 || along.grad[0].hi <= 0.0 {
        return true;
    }
    let middle = 0.5 * (from + to);
    halvings > 0
        && is_inside(from, middle, halvings - 1, slopes)
        && is_inside(middle, to, halvings - 1, slopes)
}

fn hull(a: DVec3, b: DVec3) -> [Interval; 3] {
    std::array::from_fn(|axis| Interval::new(a[axis].min(b[axis]), a[axis].max(b[axis])))
}

/// The coordinates of a region, with a direction as the first that slopes are taken along.
pub(super) fn towards(region: [Interval; 3], direction: DVec3) -> [Slope; 3] {
    let (a, b) = direction.any_orthonormal_pair();
    std::array::from_fn(|axis| Slope {
        value: region[axis],
        grad: [direction, a, b].map(|d| Interval::point(d[axis])),
        norm: f64::INFINITY,
    })
}
