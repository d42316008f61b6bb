//! Cells cut into sixty-four parts, of which one evaluation says which are empty and which are all inside.
//!
//! With `h` half the edge of a part and `v` its middle, in units of the ball around the cell, the field in all of the part
//! is
//!
//! ```text
//! f + g . v + v^T H v / 2   +-   (h sum |g + H v|_i  +  h^2 / 2 sum |H_ij|  +  bow_1)
//! ```
//!
//! Sets of parts are bits of a number, `x + 4 y + 16 z`, so that all of a set
//! grows by one part to all sides in a dozen instructions.

use super::super::search::{Balls, LANES};
use super::bricks::{Bricks, name};
use super::grid::{Grid, Voxel};
use super::proofs::{Known, Proof, Proofs};
use crate::num::{Taylor, widest};
use glam::DVec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::Arc;

/// Parts along an edge.
const EDGE: usize = 4;

/// How far parts reach beyond their borders, as a share of them: that covers how points and borders are rounded.
const MARGIN: f64 = 1e-6;

/// A set of the parts of a cell.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Parts(pub u64);

/// Bits of neighbours along each axis, and those of the parts at its low end.
const AXES: [(u32, u64); 3] =
    [(1, 0x1111_1111_1111_1111), (4, 0x000f_000f_000f_000f), (16, 0x0000_0000_0000_ffff)];

/// Where the parts are along each axis, in halves of their edges from the middle of the cell.
const MIDDLES: [[f64; 64]; 3] = {
    let mut middles = [[0.0; 64]; 3];
    let mut i = 0;
    while i < 64 {
        (middles[0][i], middles[1][i], middles[2][i]) =
            ((2 * (i % 4)) as f64 - 3.0, (2 * (i / 4 % 4)) as f64 - 3.0, (2 * (i / 16)) as f64 - 3.0);
        i += 1;
    }
    middles
};

impl Parts {
    /// None of them.
    pub const NONE: Parts = Parts(0);

    /// The part of a cell that holds a point of it.
    pub fn of(grid: &Grid, voxel: Voxel, p: DVec3) -> Parts {
        let cell = grid.cell(voxel);
        let place = (p - (cell.centre - cell.half)) / (2.0 * cell.half) * EDGE as f64;
        let [x, y, z] = place.to_array().map(|i| i.clamp(0.0, EDGE as f64 - 1.0) as u32);
        Parts(1 << (x + 4 * y + 16 * z))
    }

    /// One of them.
    pub fn first(self) -> Option<Parts> {
        self.any().then(|| Parts(1 << self.0.trailing_zeros()))
    }

    /// The middle of the first of them.
    pub fn middle(self, grid: &Grid, voxel: Voxel) -> DVec3 {
        let i = self.0.trailing_zeros() as usize % 64;
        let cell = grid.cell(voxel);
        cell.centre + cell.half * DVec3::new(MIDDLES[0][i], MIDDLES[1][i], MIDDLES[2][i]) / EDGE as f64
    }

    /// Whether there is one.
    pub fn any(self) -> bool {
        self != Parts::NONE
    }

    /// Those that both have.
    pub fn and(self, o: Parts) -> Parts {
        Parts(self.0 & o.0)
    }

    /// Those that one of the two has.
    pub fn or(self, o: Parts) -> Parts {
        Parts(self.0 | o.0)
    }

    /// Those that another does not have.
    pub fn without(self, o: Parts) -> Parts {
        Parts(self.0 & !o.0)
    }

    /// Of the cell so many cells farther along an axis, the parts that are beside one of these along it; of this one, these
    /// as well.
    fn along(self, axis: usize, offset: i64) -> Parts {
        let (Parts(bits), (shift, low)) = (self, AXES[axis]);
        let high = low << (3 * shift);
        Parts(match offset {
            0 => bits | (bits & !high) << shift | (bits & !low) >> shift,
            1 => (bits & high) >> (3 * shift),
            _ => (bits & low) << (3 * shift),
        })
    }

    /// Of this cell, these parts and those that touch one of them.
    fn touching(self) -> Parts {
        self.along(0, 0).along(1, 0).along(2, 0)
    }

    /// The offsets of other cells with parts that touch one of these, and those parts.
    fn touched(self, mut tell: impl FnMut([i64; 3], Parts)) {
        for x in -1..=1 {
            let beside = self.along(0, x);
            for y in (-1..=1).filter(|_| beside.any()) {
                let beside = beside.along(1, y);
                for z in (-1..=1).filter(|_| beside.any()) {
                    let beside = beside.along(2, z);
                    if beside.any() && [x, y, z] != [0; 3] {
                        tell([x, y, z], beside);
                    }
                }
            }
        }
    }

    /// Those of `room` that one comes to from these without leaving it.
    pub fn flood(self, room: Parts) -> Parts {
        let mut reached = self.and(room);
        loop {
            let next = reached.touching().and(room);
            if next == reached {
                return reached;
            }
            reached = next;
        }
    }
}

/// What is known of the parts of a cell.
#[derive(Clone, Copy, Debug, Default)]
pub struct Block {
    /// Those that may have something of the solid in them.
    pub solid: Parts,
    /// Those that are all inside.
    pub inside: Parts,
}

impl Block {
    /// By what is known of a ball around the cell, whose edges are so long in units of the ball, and whether the solid is
    /// where the field is below zero in all of it: elsewhere it may be empty.
    fn new(f: &Taylor, edge: f64, is_known: bool) -> Block {
        if f.range.lo > 0.0 {
            return Block::default();
        }
        let (middle, reach) = widest(
            #[inline(always)]
            || values(f, 0.5 * edge / EDGE as f64),
        );
        let set = |test: &dyn Fn(f64, f64) -> bool| {
            let bit = |i: usize| u64::from(test(middle[i], reach[i])) << i;
            Parts((0..64).map(bit).fold(0, |all, bit| all | bit))
        };
        let empty = set(&|middle, reach| middle - reach > 0.0);
        let inside = if is_known { set(&|middle, reach| middle + reach < 0.0) } else { Parts::NONE };
        Block { solid: Parts(!0).without(empty), inside }
    }
}

/// A field in the middles of all parts of a cell, whose edges are twice `half`, and how far it may be from that in them.
#[inline(always)]
fn values(f: &Taylor, half: f64) -> ([f64; 64], [f64; 64]) {
    let [xx, yy, zz, xy, xz, yz] = f.hess;
    let [gx, gy, gz] = f.grad;
    let far = half * (1.0 + MARGIN);
    let bent = xx.abs() + yy.abs() + zz.abs() + 2.0 * (xy.abs() + xz.abs() + yz.abs());
    let size = f.value.abs() + f.steepness() + f.curvature();
    let lost = 0.5 * far * far * bent + f.bow[1] + 1e-12 * size;
    let (mut middle, mut reach) = ([0.0; 64], [0.0; 64]);
    for i in 0..64 {
        let [x, y, z] = [half * MIDDLES[0][i], half * MIDDLES[1][i], half * MIDDLES[2][i]];
        let (hx, hy, hz) = (xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z);
        middle[i] = f.value + x * (gx + 0.5 * hx) + y * (gy + 0.5 * hy) + z * (gz + 0.5 * hz);
        reach[i] = far * ((gx + hx).abs() + (gy + hy).abs() + (gz + hz).abs()) + lost;
    }
    (middle, reach)
}

/// Bricks of cells that are remembered. Floods from places next to one another come to the same ones.
const KNOWN: usize = 1 << 12;

/// Cells that come next of which so many are looked through for some that are new.
const AHEAD: usize = 4 * LANES;

/// Cells of a grid that were looked at.
#[derive(Clone, Debug)]
pub struct Blocks {
    /// How often voxels are halved for them.
    pub level: u32,
    pub grid: Grid,
    /// With what is proven of them, once somebody has asked.
    known: Bricks<Option<Block>, Option<Arc<Proofs>>>,
}

impl Blocks {
    /// None yet of those that voxels halved so often make.
    pub fn new(voxels: &Grid, level: u32) -> Blocks {
        Blocks { level, grid: voxels.halved(level), known: Bricks::new() }
    }

    /// What is known of one that was looked at last.
    pub fn get(&self, voxel: Voxel) -> Block {
        self.known.get(voxel).unwrap_or_default()
    }

    /// What is proven of one that was looked at last.
    pub fn proofs(&mut self, known: &Known, voxel: Voxel) -> &Proofs {
        let level = self.level;
        self.known.head(voxel).get_or_insert_with(|| known.brick(level, voxel, None))
    }

    /// Something is proven of parts of cells, those of one brick after those of another.
    pub fn learn(&mut self, known: &Known, what: Proof, parts: &[(Voxel, Parts)]) {
        for of_brick in parts.chunk_by(|a, b| name(a.0) == name(b.0)) {
            let head = self.known.head(of_brick[0].0);
            let held = head.take();
            let brick = head.insert(known.brick(self.level, of_brick[0].0, held));
            of_brick.iter().for_each(|&(voxel, parts)| brick.add(what, voxel, parts));
        }
    }

    /// Looks at cells, at most [`LANES`] of them, and where that leaves lanes idle, at some that come next.
    pub fn look(&mut self, field: &mut Balls, voxels: &[Voxel], next: impl Iterator<Item = Voxel>) {
        if self.known.len() > KNOWN {
            self.known.clear();
        }
        let is_new = |voxel: &Voxel| self.known.get(*voxel).is_none();
        let mut new: Vec<Voxel> = voxels.iter().copied().filter(is_new).collect();
        if new.is_empty() {
            return;
        }
        new.extend(next.take(AHEAD).filter(is_new).take(LANES - new.len()));
        let balls: Vec<(DVec3, f64)> = new.iter().map(|&voxel| self.grid.ball(voxel)).collect();
        let values = *field.eval(balls.iter().copied());
        for (i, (voxel, (centre, radius))) in new.into_iter().zip(balls).enumerate() {
            let is_known = field.is_within(centre, radius) && field.is_defined_around(centre, radius);
            let block = Block::new(&values.lane(i), self.grid.size() / radius, is_known);
            *self.known.at(voxel) = Some(block);
        }
    }
}

/// What a flood knows of a cell.
#[derive(Clone, Copy, Debug, Default)]
struct Reached {
    /// What was taken in, and what touches that.
    within: Parts,
    touched: Parts,
    /// Whether it is to be gone on from.
    waits: bool,
}

/// A flood from part to part of cells, which takes in what touches.
#[derive(Debug)]
pub struct Flood {
    cells: Bricks<Reached>,
    /// How many are touched.
    count: usize,
    waiting: BinaryHeap<Reverse<(u64, Voxel)>>,
}

impl Flood {
    /// From the part that holds a place.
    pub fn new(grid: &Grid, at: DVec3) -> Flood {
        let voxel = grid.voxel(at);
        let mut cells = Bricks::new();
        *cells.at(voxel) = Reached { within: Parts::NONE, touched: Parts::of(grid, voxel, at), waits: true };
        Flood { cells, count: 1, waiting: BinaryHeap::from([Reverse((0, voxel))]) }
    }

    /// Some cells to go on from: of those that are touched, the ones of least cost.
    pub fn next(&mut self) -> Vec<Voxel> {
        let next = |_| self.waiting.pop().map(|Reverse((_, voxel))| voxel);
        let batch: Vec<Voxel> = (0..LANES).map_while(next).collect();
        batch.iter().for_each(|&voxel| self.cells.at(voxel).waits = false);
        batch
    }

    /// Cells to go on from later, some of the next ones first.
    pub fn ahead(&self) -> impl Iterator<Item = Voxel> + '_ {
        self.waiting.iter().map(|Reverse((_, voxel))| *voxel)
    }

    /// How many cells it touches.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Takes in what is touched of a cell, within these of its parts; returns what is new.
    pub fn take(&mut self, voxel: Voxel, room: Parts, cost: impl Fn(Voxel) -> u64) -> Parts {
        let Flood { cells, count, waiting } = self;
        let reached = cells.at(voxel);
        let fresh = reached.touched.flood(room).without(reached.within);
        reached.within = reached.within.or(fresh);
        fresh.touched(|offset, touched| {
            let beside = Voxel(std::array::from_fn(|axis| voxel.0[axis] + offset[axis]));
            let reached = cells.at(beside);
            if !touched.without(reached.touched).without(reached.within).any() {
                return;
            }
            *count += usize::from(!reached.touched.any());
            reached.touched = reached.touched.or(touched);
            if !reached.waits {
                reached.waits = true;
                waiting.push(Reverse((cost(beside), beside)));
            }
        });
        fresh
    }

    /// What was taken in.
    pub fn within(self) -> Vec<(Voxel, Parts)> {
        let cells = self.cells.all().map(|(voxel, reached)| (voxel, reached.within));
        cells.filter(|(_, within)| within.any()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places of the parts of a set.
    fn places(parts: Parts) -> Vec<[i64; 3]> {
        (0..64).filter(|i| parts.0 >> i & 1 == 1).map(|i| [i % 4, i / 4 % 4, i / 16]).collect()
    }

    #[test]
    fn parts_touch_those_beside_them_and_no_others() {
        for part in 0..64 {
            let one = Parts(1 << part);
            let [from] = places(one)[..] else { panic!("one part") };
            let mut touched = places(one.touching());
            one.touched(|offset, parts| {
                touched
                    .extend(places(parts).iter().map(|at| [0, 1, 2].map(|axis| at[axis] + 4 * offset[axis])));
            });
            touched.sort_unstable();
            let mut beside: Vec<[i64; 3]> = (0..27)
                .map(|i| [from[0] + i % 3 - 1, from[1] + i / 3 % 3 - 1, from[2] + i / 9 - 1])
                .collect();
            beside.sort_unstable();
            assert_eq!(touched, beside);
        }
    }

    #[test]
    fn floods_stay_in_their_room() {
        let wall = Parts(0x0000_0000_ffff_0000);
        let room = Parts(!0).without(wall);
        assert_eq!(Parts(1).flood(room), Parts(0xffff));
        let with_a_gap = room.or(Parts(1 << 16));
        assert_eq!(Parts(1).flood(with_a_gap), with_a_gap);
        assert_eq!(Parts(1).flood(wall), Parts::NONE);
    }

    #[test]
    fn parts_are_as_they_are_said_to_be() {
        // f = x y + z^2 / 2 - 0.1 over a ball of radius 0.8 about a place: its expansion is exact but for rounding.
        let (centre, radius) = (DVec3::new(0.3, -0.2, 0.4), 0.8);
        let value = |p: DVec3| p.x * p.y + 0.5 * p.z * p.z - 0.1;
        let f = Taylor {
            value: value(centre),
            grad: [centre.y, centre.x, centre.z].map(|g| g * radius),
            hess: [0.0, 0.0, 1.0, 1.0, 0.0, 0.0].map(|h| h * radius * radius),
            bow: [1.0, 1e-12],
            turn: [1.0, 1e-12],
            twist: 0.0,
            range: crate::num::Interval { lo: -2.0, hi: 2.0 },
        };
        let edge = 2.0 / 3.0_f64.sqrt();
        let block = Block::new(&f, edge, true);
        assert!(!Block::new(&f, edge, false).inside.any());
        let mut kinds = [0; 3];
        for (i, at) in places(Parts(!0)).into_iter().enumerate() {
            let low = (DVec3::from_array(at.map(|i| i as f64)) / 4.0 - 0.5) * edge;
            let samples =
                (0..1000).map(|k| DVec3::new((k % 10) as f64, (k / 10 % 10) as f64, (k / 100) as f64) / 9.0);
            let values = samples.map(|share| value(centre + radius * (low + 0.25 * edge * share)));
            let [least, most] = values.fold([f64::MAX, f64::MIN], |[a, b], v| [v.min(a), v.max(b)]);
            let (solid, inside) = (block.solid.0 >> i & 1 == 1, block.inside.0 >> i & 1 == 1);
            assert!(solid || least > 0.0, "{at:?}");
            assert!(!inside || most < 0.0, "{at:?}");
            kinds[usize::from(solid) + usize::from(inside)] += 1;
        }
        assert!(kinds.iter().all(|n| *n > 5), "{kinds:?}");
    }

    #[test]
    fn points_are_in_their_parts() {
        let grid = Grid::new(0.25);
        for i in 0..1000 {
            let p = DVec3::new(0.7, -0.5, 0.51) + 1e-3 * f64::from(i) * DVec3::new(1.0, 0.7, -1.3);
            let voxel = grid.voxel(p);
            let [at] = places(Parts::of(&grid, voxel, p))[..] else { panic!("one part") };
            let cell = grid.cell(voxel);
            let middle = cell.centre - cell.half + DVec3::from_array(at.map(|i| (i as f64 + 0.5) / 16.0));
            assert!((p - middle).abs().max_element() <= 0.5 / 16.0 + 1e-12, "{p} {middle}");
        }
    }
}
