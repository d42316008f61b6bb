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
use super::tips::towards;
use crate::num::{Interval, Many, Slope};
use crate::tape::{Evaluator, Tape};
use glam::DVec3;
use std::sync::Arc;

/// Parts of blocks of so many cells along an edge or more have tapes of their own, where the block's has so much work or more.
const PRUNED: (u32, u64) = (4, 64);

/// Parts of space that are looked at together: what is cut has so many parts.
const PARTS: usize = 8;

/// So few are looked at one by one.
const FEW: usize = 2;

/// A part of space.
type Region = [Interval; 3];

/// What looks at parts of space.
pub(super) struct Prover {
    one: Evaluator<Slope>,
    many: Evaluator<Many<Slope, PARTS>>,
}

impl Prover {
    pub fn new(tape: &Arc<Tape>) -> Prover {
        Prover { one: Evaluator::new(tape.clone()), many: Evaluator::new(tape.clone()) }
    }

    /// The field where the coordinates are in so many parts of space, and its slopes along what theirs are taken along.
    fn slopes(&mut self, tape: &Arc<Tape>, parts: &[[Slope; 3]]) -> Vec<Slope> {
        if parts.len() <= FEW {
            let one = self.one.turn_to(tape);
            return parts.iter().map(|part| *one.eval(part)).collect();
        }
        let many = self.many.turn_to(tape);
        let mut found = Vec::with_capacity(parts.len());
        for parts in parts.chunks(PARTS) {
            let lanes =
                [0, 1, 2].map(|axis| Many(std::array::from_fn(|i| parts[i.min(parts.len() - 1)][axis])));
            found.extend(&many.eval(&lanes).0[..parts.len()]);
        }
        found
    }

    /// The same with slopes along the axes.
    fn over(&mut self, tape: &Arc<Tape>, regions: &[Region]) -> Vec<Slope> {
        let along_axes = |region: &Region| std::array::from_fn(|axis| Slope::coordinate(region[axis], axis));
        self.slopes(tape, &regions.iter().map(along_axes).collect::<Vec<_>>())
    }
}

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

impl Known {
    fn of(slope: &Slope) -> Known {
        let excludes_zero = |i: &Interval| i.lo > 0.0 || i.hi < 0.0;
        if excludes_zero(&slope.value) {
            Known::Same { inside: slope.value.hi < 0.0 }
        } else if slope.grad.iter().any(excludes_zero) {
            Known::Regular
        } else {
            Known::Nothing
        }
    }
}

/// A cell of a block of which nothing is proven.
pub(super) fn doubt(
    block: &Block,
    contour: &Contour,
    lattice: &Lattice,
    prover: &mut Prover,
) -> Option<Place> {
    let is_open = |slope: &Slope| matches!(Known::of(slope), Known::Nothing);
    let whole = prover.over(&block.tape, &[lattice.region(block.at, SIDE)]);
    let mut pending = Vec::new();
    pending.extend(whole.iter().any(is_open).then(|| (block.at, SIDE, block.tape.clone())));
    while let Some((at, cells, tape)) = pending.pop() {
        let is_long = (PRUNED.0..SIDE).contains(&cells) && tape.work() >= PRUNED.1;
        let tape = if is_long { Arc::new(tape.prune(&lattice.region(at, cells))) } else { tape };
        let (parts, cells) = (eighths(at, cells / 2), cells / 2);
        let found = prover.over(&tape, &parts.map(|at| lattice.region(at, cells)));
        let open = parts.into_iter().zip(found).filter(|(_, slope)| is_open(slope));
        if cells == 1 {
            let open: Vec<_> = open.collect();
            // Where nothing is proven of one, mostly nothing is of the others.
            let (first, others) = open.split_at(open.len().min(1));
            let mut leaves = Leaves { contour, lattice, tape: &tape, prover };
            match leaves.unproven(first).or_else(|| leaves.unproven(others)) {
                None => continue,
                unproven => return unproven,
            }
        }
        pending.extend(open.map(|(at, _)| (at, cells, tape.clone())));
    }
    None
}

/// Cells of which values and slopes along the axes say nothing.
struct Leaves<'a> {
    contour: &'a Contour,
    lattice: &'a Lattice,
    tape: &'a Arc<Tape>,
    prover: &'a mut Prover,
}

impl Leaves<'_> {
    /// One of them of which nothing is proven by anything else.
    fn unproven(&mut self, cells: &[(Place, Slope)]) -> Option<Place> {
        // Two directions for each in which the field may rise everywhere in it.
        let mut ways = Vec::with_capacity(2 * cells.len());
        for &(at, slope) in cells {
            let passed = self.contour.cell(at);
            let normal = passed.map(|cell| self.contour.vertices[cell.first as usize].normal);
            if let Some(way) = normal.or_else(|| self.beside(at)) {
                // At a corner of the solid all faces that meet there have a part in the middle of what the gradient may
                // be, those too that no corner of the cell is nearest to.
                ways.extend([way, gradient(&slope).normalize_or(DVec3::Y)].map(|way| (at, way)));
            }
        }
        let along = |(at, way): &(Place, DVec3)| towards(self.lattice.region(*at, 1), *way);
        let found = self.prover.slopes(self.tape, &ways.iter().map(along).collect::<Vec<_>>());
        let rises = |found: &[Slope]| found.iter().any(|slope| slope.grad[0].lo > 0.0);
        let unproven = ways.chunks(2).zip(found.chunks(2)).find(|(_, found)| !rises(found));
        unproven.map(|(ways, _)| ways[0].0)
    }

    /// The mean of the gradients at the corners of a cell that the surface does not pass, which is that of both sides of a crease;
    /// none if what has extreme values in the cell is proven to be on the same side as its corners.
    fn beside(&mut self, at: Place) -> Option<DVec3> {
        let points = eighths(at, 1).map(|at| self.lattice.corner(at).to_array().map(Interval::point));
        let corners = self.prover.over(self.tape, &points);
        let is_same = side(&corners).is_some_and(|inside| {
            let parts = self.prover.over(self.tape, &halves(self.lattice.region(at, 1)));
            parts.iter().map(Known::of).all(|known| match known {
                Known::Same { inside: here } => here == inside,
                Known::Regular => true,
                Known::Nothing => false,
            })
        });
        (!is_same).then(|| corners.iter().map(gradient).sum::<DVec3>().normalize_or(DVec3::Y))
    }
}

/// The middle of what a gradient may be.
fn gradient(slope: &Slope) -> DVec3 {
    DVec3::from_array(slope.grad.map(Interval::mid))
}

/// On which side all corners of a cell lie; none if one of them is a tip that was cut off.
fn side(corners: &[Slope]) -> Option<bool> {
    let mut sides = corners.iter().map(|corner| match corner.value {
        Interval { lo, .. } if lo > 0.0 => Some(false),
        Interval { hi, .. } => (hi < 0.0).then_some(true),
    });
    let first = sides.next()??;
    sides.all(|side| side == Some(first)).then_some(first)
}

fn eighths(at: Place, cells: u32) -> [Place; PARTS] {
    std::array::from_fn(|i| std::array::from_fn(|axis| at[axis] + (i as u32 >> axis & 1) * cells))
}

/// A region, cut along all axes.
fn halves(region: Region) -> [Region; PARTS] {
    std::array::from_fn(|i| {
        std::array::from_fn(|axis| {
            let (Interval { lo, hi }, mid) = (region[axis], region[axis].mid());
            if i >> axis & 1 == 0 { Interval::new(lo, mid) } else { Interval::new(mid, hi) }
        })
    })
}
