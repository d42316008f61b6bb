//! Inside or outside: how often a closed surface winds around a point.
//!
//! From one point to another the winding number of a closed surface changes by one at every triangle
//! that the segment between them passes: up where it enters through the front, down where it leaves.
//! So it is known everywhere once it is known somewhere, and that takes no sum over all triangles, no
//! expansion and no tolerance: a **witness** nearby, of known winding number, and the triangles on the
//! way.
//!
//! Witnesses stand on a lattice over the surface's box, about as many as there are triangles; those on
//! its rim are outside, where the number is zero, and each passes it on to its neighbour. A point that
//! is closer to a witness than to the surface needs no more than that: there is nothing in between.
//! Far from the surface the sign costs one look into a table.
//!
//! **Certainty.** With `A`, `B`, `C` the corners as seen from one end and `e` the vector to the other
//! end, all that is asked of a triangle is the signs of
//!
//! ```text
//! e . (A x B)    e . (B x C)    e . (C x A)     which side of each edge the line passes
//! A . (B x C),  and that less their sum         which side of the plane the ends are on
//! ```
//!
//! The first kind and `A . (B x C)` are sums of six products of three differences, each of which eight
//! roundings touch: off by less than 48 roundoffs times the largest such product, and trusted beyond 64.
//! Where a sign that matters cannot be trusted, since the segment grazes an edge, another witness is asked,
//! in another direction. The last resort, of a point within rounding of the surface, is to be outside: there
//! the sign moves the distance by less than its rounding.

use super::closed::Corners;
use super::lattice::Lattice;
use super::nearest::{choose, larger};
use super::tree::{IS_BLOCK, Node, Tree, WIDE, in_frame};
use crate::num::{ROUNDOFF, widest};
use glam::DVec3;
use rayon::prelude::*;
use std::hint::black_box;

/// Winding numbers on a lattice.
#[derive(Clone, Debug)]
pub(super) struct Witnesses {
    lattice: Lattice,
    number: Vec<i32>,
}

/// Of a witness that does not know.
const UNKNOWN: i32 = i32::MIN;

/// What is too close to tell changes the winding number by this.
const UNSURE: f64 = f64::INFINITY;

/// How a triangle that a segment from `x + e` to `x` passes changes the winding number: by one up from the
/// front to the back, by one down the other way, not at all beside it, by [`UNSURE`] too close to it.
#[inline(always)]
fn pass([a, b, c]: Corners, x: DVec3, e: DVec3) -> f64 {
    let (a, b, c) = (a - x, b - x, c - x);
    let size = [a, b, c].into_iter().flat_map(|p| p.to_array()).fold(0.0, |m, t| larger(m, t.abs()));
    let reach = larger(larger(e.x.abs(), e.y.abs()), e.z.abs());
    let trust = 64.0 * ROUNDOFF * size * size;
    let bc = b.cross(c);
    let (u, v, w) = (e.dot(a.cross(b)), e.dot(bc), e.dot(c.cross(a)));
    let near = a.dot(bc);
    let far = near - (u + v + w);
    // Nothing here may branch, or triangles could not be done side by side.
    let side = trust * reach;
    let (up, down) = ([u > side, v > side, w > side], [u < -side, v < -side, w < -side]);
    let all = |s: [bool; 3]| s[0] & s[1] & s[2];
    let any = |s: [bool; 3]| s[0] | s[1] | s[2];
    let (here, there) = (trust * size, trust * (size + 3.0 * reach));
    let same = (near > here) & (far > there) | (near < -here) & (far < -there);
    let inward = all(up) & (near > here) & (far < -there);
    let outward = all(down) & (near < -here) & (far > there);
    let passed = choose(inward, 1.0, choose(outward, -1.0, UNSURE));
    choose(same | any(up) & any(down), 0.0, passed)
}

/// The surface, to be passed through.
#[derive(Clone, Copy)]
pub(super) struct Surface<'a> {
    pub tree: &'a Tree,
    /// Largest coordinate.
    pub size: f64,
}

impl Surface<'_> {
    /// The winding number at `x` less that at `from`, where it can be told. The stack may hold anything.
    pub(super) fn change(&self, from: DVec3, x: DVec3, stack: &mut Vec<u32>) -> Option<i32> {
        widest(
            #[inline(always)]
            || self.passed(from, x, stack),
        )
    }

    #[inline(always)]
    fn passed(&self, from: DVec3, x: DVec3, stack: &mut Vec<u32>) -> Option<i32> {
        let e = from - x;
        let slack = 64.0 * ROUNDOFF * (self.size + from.abs().max(x.abs()).max_element());
        let mut sum = 0.0;
        stack.clear();
        stack.extend((!self.tree.nodes.is_empty()).then_some(0));
        while let Some(child) = stack.pop() {
            if child & IS_BLOCK == 0 {
                let node = &self.tree.nodes[child as usize];
                let mut met = met(node, x, from, slack);
                while met != 0 {
                    stack.push(node.child[met.trailing_zeros() as usize]);
                    met &= met - 1;
                }
                continue;
            }
            let block = &self.tree.blocks[(child & !IS_BLOCK) as usize];
            let changes = block.map(
                #[inline(always)]
                // Corners that are not there are not numbers.
                |t| choose(t[0].x.is_nan(), 0.0, pass(t, x, e)),
            );
            sum += changes.iter().sum::<f64>();
            if sum == UNSURE {
                return None;
            }
        }
        Some(sum as i32)
    }
}

/// Which boxes of a node a segment may meet, a bit each: those that no plane of a face sets apart from it. Segments
/// are short, so that there is little to gain by other planes. Children that are not there are infinitely far.
#[inline(always)]
fn met(node: &Node, x: DVec3, y: DVec3, slack: f64) -> u32 {
    let x = in_frame(x, node.origin, &node.axes);
    let y = in_frame(y, node.origin, &node.axes);
    let (least, most) = ((x.min(y) - slack).to_array(), (x.max(y) + slack).to_array());
    // Boxes that are too large for their numbers have no gap.
    let mut gap = [0.0; WIDE];
    for axis in 0..3 {
        for i in 0..WIDE {
            let before = f64::from(node.lo[axis][i]) - most[axis];
            let after = least[axis] - f64::from(node.hi[axis][i]);
            let off = choose(before > after, before, after);
            gap[i] = choose(off > gap[i], off, gap[i]);
        }
    }
    // Through memory: else the compiler does not compute the eight side by side.
    let gap = black_box(gap);
    (0..WIDE).fold(0, |met, i| met | u32::from(gap[i] <= 0.0) << i)
}

/// Most witnesses.
const MOST: f64 = 4e6;

impl Witnesses {
    /// Witnesses over a box that holds the surface, for so many triangles.
    pub(super) fn new(surface: Surface<'_>, within: (DVec3, DVec3), triangles: usize) -> Witnesses {
        let mut lattice = Lattice::new(within, (2.0 * triangles as f64).clamp(64.0, MOST), 3);
        // Off the places that things made by people are at, and beyond the box on every side.
        lattice.origin -= lattice.step * DVec3::new(0.731_058_6, 0.618_034, 0.549_306_1);
        let row = |row| numbers_of_row(surface, lattice.row(row));
        let number = (0..lattice.rows()).into_par_iter().flat_map_iter(row).collect();
        Witnesses { lattice, number }
    }

    /// Whether the lattice has such a place.
    #[inline(always)]
    fn has(&self, at: [isize; 3]) -> bool {
        (0..3).all(|i| 0 <= at[i] && at[i] < self.lattice.size[i] as isize)
    }

    /// The witness at a place of the lattice, and its number if it knows.
    #[inline(always)]
    fn known(&self, at: [isize; 3]) -> Option<(DVec3, i32)> {
        let at = self.has(at).then(|| at.map(|i| i as usize))?;
        let number = self.number[self.lattice.number(at)];
        (number != UNKNOWN).then(|| (self.lattice.place(at), number))
    }

    /// Whether `x` is inside, so far from the surface, which is off by at most `slack`. The stack may hold
    /// anything.
    #[inline(always)]
    pub(super) fn is_inside(
        &self,
        surface: Surface<'_>,
        x: DVec3,
        (distance, slack): (f64, f64),
        stack: &mut Vec<u32>,
    ) -> bool {
        let at = self.lattice.nearest(x);
        if let Some((witness, number)) = self.known(at)
            && (x - witness).length() + slack < distance
        {
            return number > 0;
        }
        // Around the lattice there is nothing.
        let is_within = distance > slack && self.has(at);
        is_within && self.ask(surface, x, at, stack).is_some_and(|number| number > 0)
    }

    /// The winding number at `x`, where it can be told. The stack may hold anything.
    pub(super) fn number(&self, surface: Surface<'_>, x: DVec3, stack: &mut Vec<u32>) -> Option<i32> {
        let at = self.lattice.nearest(x);
        if self.has(at) { self.ask(surface, x, at, stack) } else { Some(0) }
    }

    /// The winding number at `x` according to the first witness around a place that can tell.
    #[cold]
    #[inline(never)]
    fn ask(&self, surface: Surface<'_>, x: DVec3, at: [isize; 3], stack: &mut Vec<u32>) -> Option<i32> {
        // The nearest, its neighbours, and all around them.
        for reach in 0..3_isize {
            let near = -reach..=reach;
            for (i, j, k) in near
                .clone()
                .flat_map(|k| near.clone().flat_map(move |j| (-reach..=reach).map(move |i| (i, j, k))))
            {
                if i.abs().max(j.abs()).max(k.abs()) < reach {
                    continue;
                }
                if let Some((witness, number)) = self.known([at[0] + i, at[1] + j, at[2] + k])
                    && let Some(change) = surface.change(witness, x, stack)
                {
                    return Some(number + change);
                }
            }
        }
        None
    }
}

/// The winding numbers of the witnesses of a row, the first of which is outside.
fn numbers_of_row(surface: Surface<'_>, mut places: impl Iterator<Item = DVec3>) -> Vec<i32> {
    let Some(mut last) = places.next() else { return Vec::new() };
    let (mut number, mut numbers, mut stack) = (0, vec![0], Vec::new());
    for here in places {
        let change = surface.change(last, here, &mut stack);
        if let Some(change) = change {
            (last, number) = (here, number + change);
        }
        numbers.push(change.map_or(UNKNOWN, |_| number));
    }
    numbers
}
