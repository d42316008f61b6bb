//! Questions about a whole region, answered by cutting it up. What is left of the tape in a part of the
//! region answers for that part.

use super::Field;
use crate::num::{Dual, Interval, Number, Slope};
use crate::scene::Aabb;
use crate::tape::{Cells, Evaluator};
use glam::DVec3;

/// A field that is evaluated on one kind of number in parts of a region.
struct Parts<'a, T> {
    cells: &'a Cells,
    evaluator: Evaluator<T>,
}

impl<'a, T: Number> Parts<'a, T> {
    fn new(cells: &'a Cells) -> Self {
        Parts { cells, evaluator: Evaluator::new(cells.tape().clone()) }
    }

    fn eval(&mut self, part: &Aabb, at: &[T; 3]) -> &T {
        let part = part.intervals();
        let reach = part.map(Interval::rad).into_iter().fold(0.0, f64::max);
        self.evaluator.turn_to(self.cells.tape_around(part.map(Interval::mid), reach));
        self.evaluator.eval(at)
    }
}

/// The eight halves of a box.
fn octants(b: &Aabb) -> impl Iterator<Item = Aabb> + use<> {
    let Aabb { min, max } = *b;
    let mid = (min + max) * 0.5;
    (0..8).map(move |i| {
        let upper = glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0);
        Aabb { min: DVec3::select(upper, mid, min), max: DVec3::select(upper, max, mid) }
    })
}

fn hull(a: Aabb, b: Aabb) -> Aabb {
    Aabb { min: a.min.min(b.min), max: a.max.max(b.max) }
}

/// Where a solid may be within a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Extent {
    /// Proven: there is nothing in the region.
    Empty,
    /// Proven: the part of the solid in the region lies in this box.
    Within(Aabb),
    /// The solid may go on beyond the region.
    Open(Aabb),
}

/// Cells that a search may look at before it settles for what it has.
const CELLS: usize = 4096;

/// Finds a box around the solid `f <= 0` in `region`, by excluding cells where `f > 0` is certain.
pub fn extent(field: &Field, region: &Aabb) -> Extent {
    let tapes = Cells::new(field.tape().clone(), &region.intervals());
    let mut ranges = Parts::<Interval>::new(&tapes);
    let mut cells = vec![*region];
    let mut found;
    loop {
        #[allow(clippy::neg_cmp_op_on_partial_ord)] // a cell that has no value is not excluded
        cells.retain(|cell| !(ranges.eval(cell, &cell.intervals()).lo > 0.0));
        let Some(all) = cells.iter().copied().reduce(hull) else { return Extent::Empty };
        found = all;
        if cells.len() * 8 > CELLS || found.diagonal() < 1e-9 * region.diagonal() {
            break;
        }
        cells = cells.iter().flat_map(octants).collect();
    }
    // A little air, so that rays start outside of a solid that fills its cells.
    let margin = 1e-3 * found.diagonal();
    let grown = Aabb { min: found.min - margin, max: found.max + margin };
    let touches = found.min.cmple(region.min).any() || found.max.cmpge(region.max).any();
    if touches {
        Extent::Open(Aabb { min: grown.min.max(region.min), max: grown.max.min(region.max) })
    } else {
        Extent::Within(grown)
    }
}

/// Lipschitz bound of `f` over the part of a region where `f >= 0` is possible, which is all that a
/// ray approaching from outside ever sees. Infinite where there is no bound.
pub fn lipschitz_outside(field: &Field, region: &Aabb) -> f64 {
    let tapes = Cells::new(field.tape().clone(), &region.intervals());
    let (mut slopes, mut duals) = (Parts::<Slope>::new(&tapes), Parts::<Dual>::new(&tapes));
    let mut bound: f64 = 0.0;
    let mut cells = vec![*region];
    for level in 0.. {
        let last = cells.len() * 8 > CELLS;
        let mut steep = Vec::new();
        for cell in cells {
            let x = cell.intervals();
            let slope = *slopes.eval(&cell, &[0, 1, 2].map(|axis| Slope::coordinate(x[axis], axis)));
            if slope.value.hi < 0.0 {
                continue;
            }
            // A cell that is no steeper than what is known anyway needs no cutting.
            if last || slope.norm <= bound {
                bound = bound.max(slope.norm);
            } else {
                steep.push((slope.norm, cell));
            }
        }
        if steep.is_empty() {
            break;
        }
        // The corner values of steep cells bound from below how far cutting can get.
        let mut corner = |cell: &Aabb| {
            let p = cell.min.to_array();
            let dual = duals.eval(cell, &[0, 1, 2].map(|axis| Dual::coordinate(p[axis], axis)));
            DVec3::from_array(dual.grad).length()
        };
        let lowest = steep.iter().map(|(_, cell)| corner(cell)).fold(0.0, f64::max);
        let settled = level > 0 && steep.iter().all(|(norm, _)| *norm <= 1.02 * lowest.max(bound));
        if settled {
            bound = steep.iter().map(|s| s.0).fold(bound, f64::max);
            break;
        }
        cells = steep.iter().flat_map(|(_, cell)| octants(cell)).collect();
    }
    bound
}
