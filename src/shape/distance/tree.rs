//! A hierarchy of boxes around triangles, eight to a node.
//!
//! The surface-area heuristic, in bins, splits a set of triangles in two until there are eight; those
//! of more than a block become nodes of their own. Two numbers are what memory traffic hangs on: a node
//! is four cache lines, since boxes are kept in single precision relative to an origin of the node's
//! own, rounded outwards; and a block is a few triangles as a structure of arrays, with their corners
//! as they are.
//!
//! Which triangles go where depends on the triangles alone, so the hierarchy is the same on any number
//! of threads.

use super::closed::Corners;
use crate::num::fetch;
use glam::DVec3;
use rayon::prelude::*;
use std::hint::black_box;

/// Children of a node.
pub(super) const WIDE: usize = 8;
/// Triangles of a block.
pub(super) const BLOCK: usize = 8;
/// Bins of the heuristic, along each axis.
const BINS: usize = 16;
/// Below this many triangles a job is not worth sharing.
const ALONE: usize = 4096;
/// From this depth on sets are halved, whatever the heuristic says: 2^31 triangles are below in no more
/// than 31 steps further.
const DEEP: u32 = 21;

/// A child that is not there.
pub(super) const NOTHING: u32 = u32::MAX;
/// Set in the number of a child that is a block.
pub(super) const IS_BLOCK: u32 = 1 << 31;

/// Eight boxes and what is in them.
#[repr(C, align(64))]
#[derive(Clone, Debug)]
pub(super) struct Node {
    /// What the boxes are relative to.
    pub origin: DVec3,
    /// The axes of the boxes, of unit length and at right angles up to rounding.
    pub axes: [DVec3; 3],
    /// Numbers of nodes, of blocks with [`IS_BLOCK`], or [`NOTHING`].
    pub child: [u32; WIDE],
    /// Least corners, by axis.
    pub lo: [[f32; WIDE]; 3],
    /// Greatest corners, by axis.
    pub hi: [[f32; WIDE]; 3],
}

/// A few triangles; where there are fewer, the corners of the others are not numbers.
#[repr(C, align(64))]
#[derive(Clone, Debug)]
pub(super) struct Block {
    /// By corner and axis.
    pub corner: [[[f64; BLOCK]; 3]; 3],
}

/// The hierarchy; the first node is the root. A triangle's number is that of its block times
/// [`BLOCK`] and its lane.
#[derive(Clone, Debug, Default)]
pub(super) struct Tree {
    pub nodes: Vec<Node>,
    pub blocks: Vec<Block>,
}

/// A triangle on its way into the hierarchy.
#[derive(Clone, Copy)]
struct Item {
    lo: DVec3,
    hi: DVec3,
    number: u32,
}

/// What the boxes of a node are measured in.
struct Frame {
    origin: DVec3,
    axes: [DVec3; 3],
}

impl Item {
    /// Twice the middle.
    fn middle(&self) -> DVec3 {
        self.lo + self.hi
    }
}

/// A box; the empty one is inside out.
#[derive(Clone, Copy)]
struct Bound {
    lo: DVec3,
    hi: DVec3,
}

impl Bound {
    const EMPTY: Bound = Bound { lo: DVec3::INFINITY, hi: DVec3::NEG_INFINITY };

    fn add(&mut self, lo: DVec3, hi: DVec3) {
        self.lo = self.lo.min(lo);
        self.hi = self.hi.max(hi);
    }

    fn of(items: &[Item]) -> Bound {
        let mut bound = Bound::EMPTY;
        items.iter().for_each(|i| bound.add(i.lo, i.hi));
        bound
    }

    /// Half the surface.
    fn area(&self) -> f64 {
        let d = (self.hi - self.lo).max(DVec3::ZERO);
        d.x * d.y + d.y * d.z + d.z * d.x
    }
}

impl Tree {
    /// The hierarchy of some triangles that are not degenerate.
    pub(super) fn new(triangles: &[Corners]) -> Tree {
        let item = |number| Item { lo: DVec3::ZERO, hi: DVec3::ZERO, number };
        let mut items: Vec<Item> = (0..triangles.len() as u32).map(item).collect();
        if items.is_empty() { Tree::default() } else { grow(&mut items, triangles, 0) }
    }

    /// Has a child fetched from memory that is soon to be looked at.
    #[inline(always)]
    pub(super) fn fetch(&self, child: u32) {
        let at = (child & !IS_BLOCK) as usize;
        if child & IS_BLOCK == 0 {
            fetch(&self.nodes[at]);
        } else {
            fetch(&self.blocks[at]);
        }
    }

    /// The corners of a triangle.
    #[inline(always)]
    pub(super) fn triangle(&self, number: u32) -> Option<Corners> {
        let block = self.blocks.get(number as usize / BLOCK)?;
        Some(block.triangle(number as usize % BLOCK))
    }
}

/// The hierarchy of some items, of which there is at least one.
fn grow(items: &mut [Item], triangles: &[Corners], depth: u32) -> Tree {
    let frame = Frame::new(items, triangles);
    items.iter_mut().for_each(|item| frame.measure(item, triangles));
    let groups = groups(items, depth);
    let mut parts: Vec<&mut [Item]> = Vec::with_capacity(WIDE);
    let mut rest = items;
    for count in groups {
        let (part, others) = rest.split_at_mut(count);
        parts.push(part);
        rest = others;
    }
    let bounds: Vec<Bound> = parts.iter().map(|p| Bound::of(p)).collect();
    let sub = |part: &mut &mut [Item]| match part.len() {
        0..=BLOCK => Tree { nodes: Vec::new(), blocks: vec![Block::new(part, triangles)] },
        _ => grow(part, triangles, depth + 1),
    };
    let total: usize = parts.iter().map(|p| p.len()).sum();
    let children: Vec<Tree> = match total > ALONE {
        true => parts.par_iter_mut().map(sub).collect(),
        false => parts.iter_mut().map(sub).collect(),
    };
    let mut tree = Tree { nodes: vec![Node::new(frame, &bounds)], blocks: Vec::new() };
    // What is looked at together lies together: first the blocks, then what is below.
    let (blocks, below): (Vec<_>, Vec<_>) =
        children.into_iter().enumerate().partition(|c| c.1.nodes.is_empty());
    for (i, child) in blocks.into_iter().chain(below) {
        tree.nodes[0].child[i] = tree.append(child);
    }
    tree
}

impl Tree {
    /// Takes another one in, and says what it is to be called.
    fn append(&mut self, other: Tree) -> u32 {
        let is_block = other.nodes.is_empty();
        let (nodes, blocks) = (self.nodes.len() as u32, self.blocks.len() as u32);
        self.blocks.extend(other.blocks);
        self.nodes.extend(other.nodes.into_iter().map(|mut node| {
            for child in &mut node.child {
                *child += match *child {
                    NOTHING => 0,
                    c if c & IS_BLOCK != 0 => blocks,
                    _ => nodes,
                };
            }
            node
        }));
        if is_block { blocks | IS_BLOCK } else { nodes }
    }
}

impl Frame {
    /// The third axis is the mean normal of the triangles, so that patches lie flat in their boxes.
    fn new(items: &[Item], triangles: &[Corners]) -> Frame {
        let mut all = Bound::EMPTY;
        let mut normal = DVec3::ZERO;
        for item in items {
            let [a, b, c] = triangles[item.number as usize];
            normal += (b - a).cross(c - a);
            [a, b, c].into_iter().for_each(|p| all.add(p, p));
        }
        let normal = normal.try_normalize().unwrap_or(DVec3::Z);
        let (side, up) = normal.any_orthonormal_pair();
        Frame { origin: 0.5 * all.lo + 0.5 * all.hi, axes: [side, up, normal] }
    }

    /// Finds the box of an item, relative to the frame.
    fn measure(&self, item: &mut Item, triangles: &[Corners]) {
        let [a, b, c] = triangles[item.number as usize].map(|p| in_frame(p, self.origin, &self.axes));
        (item.lo, item.hi) = (a.min(b).min(c), a.max(b).max(c));
    }
}

/// A point relative to a frame.
#[inline(always)]
pub(super) fn in_frame(p: DVec3, origin: DVec3, axes: &[DVec3; 3]) -> DVec3 {
    let p = p - origin;
    DVec3::new(p.dot(axes[0]), p.dot(axes[1]), p.dot(axes[2]))
}

impl Node {
    fn new(Frame { origin, axes }: Frame, bounds: &[Bound]) -> Node {
        let mut node = Node {
            origin,
            axes,
            child: [NOTHING; WIDE],
            lo: [[f32::INFINITY; WIDE]; 3],
            hi: [[f32::NEG_INFINITY; WIDE]; 3],
        };
        for (i, b) in bounds.iter().enumerate() {
            let (lo, hi) = (b.lo.to_array(), b.hi.to_array());
            for axis in 0..3 {
                node.lo[axis][i] = (lo[axis] as f32).next_down();
                node.hi[axis][i] = (hi[axis] as f32).next_up();
            }
        }
        node
    }
}

impl Block {
    /// The corners of a triangle.
    #[inline(always)]
    pub(super) fn triangle(&self, lane: usize) -> Corners {
        self.corner.map(|p| DVec3::new(p[0][lane], p[1][lane], p[2][lane]))
    }

    /// A number for each triangle, whatever for those that are absent.
    #[inline(always)]
    pub(super) fn map(&self, f: impl Fn(Corners) -> f64) -> [f64; BLOCK] {
        // A loop of so few steps would be taken apart before it could be done side by side, so the
        // compiler must not know how many they are.
        let count = black_box(BLOCK).min(BLOCK);
        let [a, b, c] = &self.corner;
        let [ax, ay, az] = [&a[0][..count], &a[1][..count], &a[2][..count]];
        let [bx, by, bz] = [&b[0][..count], &b[1][..count], &b[2][..count]];
        let [cx, cy, cz] = [&c[0][..count], &c[1][..count], &c[2][..count]];
        let mut out = [0.0; BLOCK];
        let to = &mut out[..count];
        for i in 0..count {
            let (a, b) = (DVec3::new(ax[i], ay[i], az[i]), DVec3::new(bx[i], by[i], bz[i]));
            to[i] = f([a, b, DVec3::new(cx[i], cy[i], cz[i])]);
        }
        out
    }

    /// Up to [`BLOCK`] triangles.
    fn new(items: &[Item], triangles: &[Corners]) -> Block {
        let mut block = Block { corner: [[[f64::NAN; BLOCK]; 3]; 3] };
        for (lane, item) in items.iter().enumerate().take(BLOCK) {
            for (corner, p) in triangles[item.number as usize].iter().enumerate() {
                (0..3).for_each(|axis| block.corner[corner][axis][lane] = p[axis]);
            }
        }
        block
    }
}

/// Orders items into up to [`WIDE`] groups, and says how many are in each.
fn groups(items: &mut [Item], depth: u32) -> Vec<usize> {
    /// Neighbours in the list, and how much they ask to be split.
    struct Group {
        start: usize,
        count: usize,
        cost: f64,
    }
    let group = |items: &[Item], start: usize, count: usize| {
        let own = &items[start..start + count];
        let cost = if count > BLOCK { Bound::of(own).area() * count as f64 } else { -1.0 };
        Group { start, count, cost }
    };
    let mut found = vec![group(items, 0, items.len())];
    while found.len() < WIDE {
        let worst = (0..found.len()).fold(0, |w, i| if found[i].cost > found[w].cost { i } else { w });
        let Group { start, count, cost } = found[worst];
        if cost < 0.0 {
            break;
        }
        let first = split(&mut items[start..start + count], depth);
        found[worst] = group(items, start, first);
        found.insert(worst + 1, group(items, start + first, count - first));
    }
    found.into_iter().map(|g| g.count).collect()
}

/// Orders items into two groups, and says how many are in the first: neither none nor all.
fn split(items: &mut [Item], depth: u32) -> usize {
    let mut middles = Bound::EMPTY;
    items.iter().for_each(|i| middles.add(i.middle(), i.middle()));
    let size = middles.hi - middles.lo;
    let place = if depth < DEEP { best_plane(items, &middles) } else { None };
    let Some((axis, bin)) = place else {
        let axis = size.max_position();
        let half = items.len() / 2;
        let key = |i: &Item| i.middle()[axis];
        items.select_nth_unstable_by(half, |a, b| key(a).total_cmp(&key(b)).then(a.number.cmp(&b.number)));
        return half;
    };
    let to_bin = Binning::new(&middles);
    let mut first = 0;
    for i in 0..items.len() {
        if to_bin.bin(&items[i])[axis] <= bin {
            items.swap(i, first);
            first += 1;
        }
    }
    first
}

/// Which bin an item is in.
struct Binning {
    origin: DVec3,
    scale: DVec3,
}

impl Binning {
    fn new(middles: &Bound) -> Binning {
        let size = middles.hi - middles.lo;
        let scale = |d: f64| if d > 0.0 && (BINS as f64 / d).is_finite() { BINS as f64 / d } else { 0.0 };
        Binning { origin: middles.lo, scale: DVec3::new(scale(size.x), scale(size.y), scale(size.z)) }
    }

    #[inline(always)]
    fn bin(&self, item: &Item) -> [usize; 3] {
        let at = (item.middle() - self.origin) * self.scale;
        [at.x, at.y, at.z].map(|t| (t as usize).min(BINS - 1))
    }
}

/// The axis and the last bin of the first group where a split costs least; none if all are in one bin.
fn best_plane(items: &[Item], middles: &Bound) -> Option<(usize, usize)> {
    let to_bin = Binning::new(middles);
    let mut bins = [[(Bound::EMPTY, 0_usize); BINS]; 3];
    for item in items {
        let at = to_bin.bin(item);
        for axis in 0..3 {
            let bin = &mut bins[axis][at[axis]];
            bin.0.add(item.lo, item.hi);
            bin.1 += 1;
        }
    }
    let cost = |b: &(Bound, usize)| b.0.area() * b.1.div_ceil(BLOCK) as f64;
    let join = |mut a: (Bound, usize), b: &(Bound, usize)| {
        a.0.add(b.0.lo, b.0.hi);
        (a.0, a.1 + b.1)
    };
    let mut best = None;
    let mut least = f64::INFINITY;
    for axis in 0..3 {
        let bins = &bins[axis];
        let mut after = [(Bound::EMPTY, 0); BINS];
        for i in (0..BINS - 1).rev() {
            after[i] = join(after[i + 1], &bins[i + 1]);
        }
        let mut before = (Bound::EMPTY, 0);
        for i in 0..BINS - 1 {
            before = join(before, &bins[i]);
            if before.1 > 0 && after[i].1 > 0 {
                let sum = cost(&before) + cost(&after[i]);
                if sum < least {
                    (least, best) = (sum, Some((axis, i)));
                }
            }
        }
    }
    best
}
