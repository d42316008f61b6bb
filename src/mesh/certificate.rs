//! Whether anything may have been missed.
//!
//! A part of the solid that the mesh does not know of, or a hole in it, ends everywhere, so that the field has
//! an extreme value in it: a *critical point*, where no direction leads on. So let every cell that may hold
//! surface be such that the derivative in some direction, an axis or the normal of its vertex, is proven not to be
//! zero in it; along creases its enclosure holds the slopes of both sides and all between. Then critical
//! points lie only in parts of space over which the field keeps its sign, and which are whole cells: their
//! corners were seen, and are on the right side of the mesh, but for those at tips that hang together with a part. Nothing is missed, however small, and no two
//! parts are taken for one that are not connected through a cell.
//!
//! Cells of which that cannot be proven are cut further for the sake of the proof. Blocks with a cell that is left
//! are counted, and that is said: there the solid may have detail below the size of a cell that the mesh does not
//! show. A block is given up at its first such cell: where the surface is rougher than the mesh, nearly all cells
//! are, and to find that out of each would take longer than the mesh.

use super::blocks::Block;
use super::contour::Contour;
use super::lattice::{Lattice, Place, SIDE};
use super::tips::slopes_along;
use crate::num::{Interval, Slope};
use crate::tape::Evaluator;
use glam::DVec3;
use std::sync::Arc;

/// Times that a cell is cut for the sake of the proof.
const CUTS: u32 = 1;

/// Parts of blocks of so many cells along an edge or more have tapes of their own, where the block's has so much work or more.
const PRUNED: (u32, u64) = (4, 64);

/// What a part of space is known not to have.
enum Known {
    /// Surface; all of it is inside, or outside.
    Same {
        inside: bool,
    },
    /// Critical points.
    Regular,
    Nothing,
}

/// A cell of a block of which nothing is proven.
pub(super) fn doubt(
    block: &Block,
    contour: &Contour,
    lattice: &Lattice,
    slopes: &mut Evaluator<Slope>,
) -> Option<Place> {
    let mut pending = vec![(block.at, SIDE, block.tape.clone())];
    while let Some((at, cells, tape)) = pending.pop() {
        let region = lattice.region(at, cells);
        match known(region, slopes.turn_to(&tape)) {
            Known::Same { .. } | Known::Regular => {}
            Known::Nothing if cells > 1 => {
                let is_long = (PRUNED.0..SIDE).contains(&cells) && tape.work() >= PRUNED.1;
                let tape = if is_long { Arc::new(tape.prune(&region)) } else { tape };
                pending.extend(eighths(at, cells / 2).map(|(at, cells)| (at, cells, tape.clone())));
            }
            Known::Nothing if is_proven(at, contour, lattice, slopes) => {}
            Known::Nothing => return Some(at),
        }
    }
    None
}

/// Whether nothing is missed in a cell, by more than the derivatives along the axes.
fn is_proven(at: Place, contour: &Contour, lattice: &Lattice, slopes: &mut Evaluator<Slope>) -> bool {
    let region = lattice.region(at, 1);
    let is_regular = match contour.cell(at) {
        Some(cell) => rises_along(region, contour.vertices[cell.first as usize].normal, slopes),
        None => {
            let inside = side(at, lattice, slopes);
            inside.is_some_and(|inside| is_same(region, inside, CUTS, slopes))
                || rises_along(region, mean_gradient(at, lattice, slopes), slopes)
        }
    };
    is_regular || rises_along(region, middle_gradient(region, slopes), slopes)
}

/// The middle of what the gradient may be in a region: at a corner of the solid all faces that meet there
/// have a part in it, those too that no corner of the cell is nearest to.
fn middle_gradient(region: [Interval; 3], slopes: &mut Evaluator<Slope>) -> DVec3 {
    DVec3::from_array(value(region, slopes).grad.map(Interval::mid)).normalize_or(DVec3::Y)
}

/// The mean of the gradients at the corners of a cell, which is that of both sides of a crease.
fn mean_gradient(at: Place, lattice: &Lattice, slopes: &mut Evaluator<Slope>) -> DVec3 {
    let corners = eighths(at, 1).map(|(corner, _)| {
        let point = lattice.corner(corner).to_array().map(Interval::point);
        DVec3::from_array(value(point, slopes).grad.map(Interval::mid))
    });
    corners.sum::<DVec3>().normalize_or(DVec3::Y)
}

/// Whether the field rises along a direction everywhere in a region.
fn rises_along(region: [Interval; 3], direction: DVec3, slopes: &mut Evaluator<Slope>) -> bool {
    slopes_along(region, direction, slopes).grad[0].lo > 0.0
}

fn eighths(at: Place, cells: u32) -> impl Iterator<Item = (Place, u32)> {
    (0..8_u32).map(move |i| (std::array::from_fn(|axis| at[axis] + (i >> axis & 1) * cells), cells))
}

/// On which side all corners of a cell lie that the surface does not pass; none if one of them is a tip that was cut off.
fn side(at: Place, lattice: &Lattice, slopes: &mut Evaluator<Slope>) -> Option<bool> {
    let mut sides = eighths(at, 1).map(|(corner, _)| {
        let corner = lattice.corner(corner).to_array().map(Interval::point);
        let Interval { lo, hi } = value(corner, slopes).value;
        if lo > 0.0 { Some(false) } else { (hi < 0.0).then_some(true) }
    });
    let first = sides.next()??;
    sides.all(|side| side == Some(first)).then_some(first)
}

fn value(region: [Interval; 3], slopes: &mut Evaluator<Slope>) -> Slope {
    *slopes.eval(&std::array::from_fn(|axis| Slope::coordinate(region[axis], axis)))
}

fn known(region: [Interval; 3], slopes: &mut Evaluator<Slope>) -> Known {
    let slope = value(region, slopes);
    let excludes_zero = |i: &Interval| i.lo > 0.0 || i.hi < 0.0;
    if excludes_zero(&slope.value) {
        Known::Same { inside: slope.value.hi < 0.0 }
    } else if slope.grad.iter().any(excludes_zero) {
        Known::Regular
    } else {
        Known::Nothing
    }
}

/// Whether what has extreme values in a part of a cell is on the same side as the cell's corners.
fn is_same(region: [Interval; 3], inside: bool, cuts: u32, slopes: &mut Evaluator<Slope>) -> bool {
    match known(region, slopes) {
        Known::Same { inside: here } => here == inside,
        Known::Regular => true,
        Known::Nothing if cuts == 0 => false,
        Known::Nothing => (0..8_u32).all(|i| {
            let half = std::array::from_fn(|axis| {
                let Interval { lo, hi } = region[axis];
                let mid = region[axis].mid();
                if i >> axis & 1 == 0 { Interval::new(lo, mid) } else { Interval::new(mid, hi) }
            });
            is_same(half, inside, cuts - 1, slopes)
        }),
    }
}
