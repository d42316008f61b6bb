//! Boxes within boxes around the parts of a shape, so that a search meets few of them.
//!
//! A part is known by a box that holds it and by its *girth*: what its function may lie below the
//! distance to the box. So a part whose box is no nearer than `limit + girth` cannot be below `limit`.

use glam::DVec3;

/// What is known of a part, or of several.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    /// The least corner.
    pub lo: DVec3,
    /// The greatest corner.
    pub hi: DVec3,
    /// How far below the distance to the box the part's function may be.
    pub girth: f64,
}

impl Extent {
    /// The box of points.
    pub fn of(points: impl IntoIterator<Item = DVec3>, girth: f64) -> Extent {
        let nothing = Extent { lo: DVec3::INFINITY, hi: DVec3::NEG_INFINITY, girth };
        let grow = |e: Extent, p| Extent { lo: e.lo.min(p), hi: e.hi.max(p), girth };
        points.into_iter().fold(nothing, grow)
    }

    /// Nothing of what is within is below this at a point.
    #[inline(always)]
    pub fn floor(&self, x: DVec3) -> f64 {
        (self.lo - x).max(x - self.hi).max(DVec3::ZERO).length() - self.girth
    }

    /// The extent around some; there is at least one.
    pub fn around(extents: impl IntoIterator<Item = Extent>) -> Extent {
        let nothing = Extent::of([], f64::NEG_INFINITY);
        extents.into_iter().fold(nothing, Extent::hull)
    }

    fn hull(self, o: Extent) -> Extent {
        Extent { lo: self.lo.min(o.lo), hi: self.hi.max(o.hi), girth: self.girth.max(o.girth) }
    }
}

/// A box of boxes, or of parts.
#[derive(Clone, Copy, Debug)]
struct Node {
    extent: Extent,
    /// First part, and how many there are, of a box of parts.
    parts: (u32, u32),
    /// The second box of a box of boxes; the first one follows it.
    second: u32,
}

/// What a walk visits.
pub(super) enum Group<'a> {
    /// A box, by its number.
    Box(usize, &'a Extent),
    /// A part, by its number.
    Part(usize),
}

/// Parts a box.
const FEW: usize = 4;

/// The boxes around parts, which are called by their numbers.
#[derive(Debug)]
pub(super) struct Boxes {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl Boxes {
    /// The boxes around parts of these extents.
    pub fn new(parts: &[Extent]) -> Boxes {
        let mut boxes = Boxes { nodes: Vec::new(), order: (0..parts.len() as u32).collect() };
        if !parts.is_empty() {
            boxes.build(parts, 0, parts.len());
        }
        boxes
    }

    /// Halves the parts along the longest edge of the box around them.
    fn build(&mut self, parts: &[Extent], first: usize, end: usize) {
        let own = &mut self.order[first..end];
        let of = |i: &u32| parts[*i as usize];
        let extent = Extent::around(own.iter().map(of));
        let here = self.nodes.len();
        let leaf = Node { extent, parts: (first as u32, own.len() as u32), second: 0 };
        self.nodes.push(leaf);
        if own.len() <= FEW {
            return;
        }
        let edge = extent.hi - extent.lo;
        let axis = (0..3).fold(0, |best, axis| if edge[axis] > edge[best] { axis } else { best });
        let middle = |i: &u32| of(i).lo[axis] + of(i).hi[axis];
        let half = own.len() / 2;
        own.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)).then(a.cmp(b)));
        self.build(parts, first, first + half);
        self.nodes[here] = Node { parts: (0, 0), second: self.nodes.len() as u32, ..leaf };
        self.build(parts, first + half, end);
    }

    /// Visits all parts that may be below a limit at a point, those in nearer boxes first. A visit
    /// tells the limit from then on.
    #[inline(always)]
    pub fn below(&self, x: DVec3, mut limit: f64, mut visit: impl FnMut(usize) -> f64) {
        // Halving leaves at most 32 levels, each with one box put aside.
        let mut aside = [(0u32, 0.0); 40];
        let mut count = 0usize;
        let Some(root) = self.nodes.first() else { return };
        let mut next = Some((0u32, root.extent.floor(x)));
        while let Some((at, floor)) = next.take().or_else(|| {
            count = count.checked_sub(1)?;
            Some(aside[count])
        }) {
            // What is not a number is not known to be above.
            if floor >= limit {
                continue;
            }
            let node = &self.nodes[at as usize];
            let (first, parts) = node.parts;
            if parts > 0 {
                for i in &self.order[first as usize..(first + parts) as usize] {
                    limit = visit(*i as usize);
                }
                continue;
            }
            let [a, b] = [at + 1, node.second].map(|i| (i, self.nodes[i as usize].extent.floor(x)));
            let (near, far) = if b.1 < a.1 { (b, a) } else { (a, b) };
            aside[count] = far;
            count += 1;
            next = Some(near);
        }
    }

    /// Visits all parts in boxes that pass a test, in a fixed order.
    #[inline(always)]
    pub fn each(&self, keep: impl Fn(&Extent) -> bool, mut visit: impl FnMut(usize)) {
        self.walk(|group| match group {
            Group::Box(_, extent) => keep(extent),
            Group::Part(i) => {
                visit(i);
                false
            }
        });
    }

    /// Visits boxes, and goes into those of which the visit says so, down to the parts.
    #[inline(always)]
    pub fn walk(&self, mut visit: impl FnMut(Group<'_>) -> bool) {
        let mut aside = [0u32; 40];
        let mut count = usize::from(!self.nodes.is_empty());
        while count > 0 {
            count -= 1;
            let at = aside[count];
            let node = &self.nodes[at as usize];
            if !visit(Group::Box(at as usize, &node.extent)) {
                continue;
            }
            let (first, parts) = node.parts;
            for i in &self.order[first as usize..(first + parts) as usize] {
                visit(Group::Part(*i as usize));
            }
            if parts == 0 {
                (aside[count], aside[count + 1]) = (node.second, at + 1);
                count += 2;
            }
        }
    }

    /// For each box, by its number, the sum of something over the parts within.
    pub fn sums(&self, of: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut sums = vec![0.0; self.nodes.len()];
        // What is within a box comes after it.
        for (at, node) in self.nodes.iter().enumerate().rev() {
            let (first, parts) = node.parts;
            sums[at] = match parts {
                0 => sums[at + 1] + sums[node.second as usize],
                _ => {
                    self.order[first as usize..(first + parts) as usize].iter().map(|i| of(*i as usize)).sum()
                }
            };
        }
        sums
    }
}
