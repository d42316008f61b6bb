//! The nearest nodes of points that stay about where they are, as those do that a flow carries along.
//!
//! Space is cut into *plots*, half a cell wide. Only few nodes can be the nearest of a point in a plot: with `c` its
//! middle and `p`, `q` the offsets of two nodes from there,
//!
//! ```text
//! |x - p|^2 - |x - q|^2  =  |p|^2 - |q|^2 + 2 (q - p).x  <=  |p|^2 - |q|^2 + |q - p|_1 / 2
//! ```
//!
//! over the plot, and where this is below zero the node at `q` is out of the question. Four are left, as a rule. What is
//! found out of a plot is remembered, so that neither cells are hashed again nor nodes looked at that are too far.
//!
//! Points are taken sixteen at a time, as lanes. Each lane has the nodes of its plot in a column, which is written
//! anew when the lane leaves the plot; so they are compared side by side, without anything being looked up. As in
//! `scout.rs` that is done in single precision, then the nearest is measured, and lanes that are not certain are searched for
//! by themselves: the outcome is that of [`Search::nearest`], bit for bit, whatever is remembered.
//!
//! Lanes that do not stay are not worth columns. So these are used where most lanes are where they were when
//! they were last asked for.

use super::metric::{Euclidean, Metric};
use super::scout::{GRAINS, Ground};
use super::search::{Found, GRAIN, Search};
use crate::noise::lattice::{Lattice, split};
use std::cell::Cell;

/// Points at a time.
pub(super) const LANES: usize = 16;

/// Groups of lanes of a batch that are remembered, noises, and plots.
const GROUPS: usize = 4;
const NOISES: usize = 8;
const PLOTS: usize = 1 << 13;

/// Nodes of a plot, at most.
const MOST: usize = 12;

/// How many lanes may move on at once.
const FEW: u32 = 4;

/// Where no node is, in grains: beyond all caps.
const NOWHERE: i32 = 1 << 20;

/// How far the middle of a plot is from its corners, twice, and a little more.
const ACROSS: f64 = 0.867;

/// Beyond all roundings of squares of distances.
const MARGIN: f64 = 1e-9;

/// A plot: the cell, and by three bits which of its octants.
type Place = [u32; 4];

/// What is known of a plot.
#[derive(Clone, Copy)]
struct Plot {
    noise: u64,
    place: Place,
    /// How many nodes there are; none if there may be more than there is room for.
    count: u32,
    /// Where they are, relative to the cell, in grains, less half a grain.
    nodes: [[i32; 3]; MOST],
}

/// Lanes with the nodes of their plots.
#[derive(Clone)]
struct Group {
    /// Where lanes were when they were last asked for, and of which plots they have the nodes.
    last: [[u32; LANES]; 4],
    own: [[u32; LANES]; 4],
    /// How many these are; without any, lanes are searched for by themselves.
    count: [u32; LANES],
    nodes: [[[i32; LANES]; 3]; MOST],
}

impl Group {
    const NEW: Group = Group {
        last: [[0; LANES]; 4],
        own: [[u32::MAX; LANES]; 4],
        count: [0; LANES],
        nodes: [[[NOWHERE; LANES]; 3]; MOST],
    };
}

/// Groups of a noise.
struct Noise {
    lattice: Lattice,
    /// Names it for as long as it is remembered.
    name: u64,
    groups: [Group; GROUPS],
}

/// What a thread remembers.
#[derive(Default)]
struct Plots {
    plots: Vec<Plot>,
    noises: Vec<Noise>,
    /// How many noises there were.
    named: u64,
}

thread_local! {
    static PLOTS_OF_THREAD: Cell<Plots> = Cell::default();
}

/// The plots of a noise, as a thread remembers them.
pub(super) struct Memory {
    plots: Plots,
    noise: usize,
    /// The next group of lanes.
    group: usize,
}

impl Memory {
    /// For a batch of points.
    pub(super) fn of(lattice: &Lattice) -> Memory {
        let mut plots = PLOTS_OF_THREAD.take();
        if plots.plots.is_empty() {
            plots.plots.resize(PLOTS, Plot::NOTHING);
        }
        let noise = plots.noise(lattice);
        Memory { plots, noise, group: 0 }
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        PLOTS_OF_THREAD.set(std::mem::take(&mut self.plots));
    }
}

impl Plots {
    /// Which noise it is; one that is new takes the place of the oldest.
    fn noise(&mut self, lattice: &Lattice) -> usize {
        if let Some(known) = self.noises.iter().position(|noise| noise.lattice == *lattice) {
            return known;
        }
        let place = self.named as usize % NOISES;
        self.named += 1;
        let noise = Noise { lattice: *lattice, name: self.named, groups: [const { Group::NEW }; GROUPS] };
        match self.noises.get_mut(place) {
            Some(oldest) => *oldest = noise,
            None => self.noises.push(noise),
        }
        place
    }
}

impl Plot {
    const NOTHING: Plot = Plot { noise: 0, place: [0; 4], count: 0, nodes: [[NOWHERE; 3]; MOST] };

    /// Finds out which nodes matter.
    fn survey(noise: u64, place: Place, search: &Search<'_, Euclidean>) -> Plot {
        let plot = Plot { noise, place, ..Plot::NOTHING };
        let middle: [f64; 3] = std::array::from_fn(|axis| 0.25 + 0.5 * f64::from(place[3] >> axis & 1));
        let at = std::array::from_fn(|axis| f64::from(place[axis] as i32) + middle[axis]);
        let nearest: Found<1, 1> = search.nearest(at);
        let limit = nearest.measure[0][0].sqrt() + ACROSS;
        if limit >= search.cap {
            return plot;
        }
        // Offsets of nodes from the middle: multiples of half a grain, and as such exact.
        let mut nodes: Vec<[f64; 3]> = Vec::with_capacity(32);
        search.within(at, limit, |d| nodes.push(d.map(|d| -d)));
        let square = |p: &[f64; 3]| p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
        let is_ahead = |p: &[f64; 3], q: &[f64; 3]| {
            let apart: f64 = (0..3).map(|axis| (p[axis] - q[axis]).abs()).sum();
            square(p) - square(q) + 0.5 * apart < -MARGIN
        };
        let mut count = 0;
        let mut found = plot;
        for q in nodes.iter().filter(|q| !nodes.iter().any(|p| is_ahead(p, q))) {
            if count == MOST {
                return plot;
            }
            found.nodes[count] = std::array::from_fn(|axis| ((middle[axis] + q[axis]) / GRAIN - 0.5) as i32);
            count += 1;
        }
        Plot { count: count as u32, ..found }
    }
}

/// Where a plot is remembered.
fn entry(noise: u64, [x, y, z, octant]: Place) -> usize {
    let words = [x, y, z, octant ^ (noise as u32) << 3];
    let mixed = words.into_iter().fold(0, |h: u32, word| (h.rotate_left(5) ^ word).wrapping_mul(0x9e37_79b1));
    (mixed >> 16) as usize % PLOTS
}

impl Memory {
    /// The nearest nodes of a group of points. Where lanes are searched for by themselves anyway, they are searched for
    /// together.
    #[inline(always)]
    pub(super) fn nearest(
        &mut self,
        search: &Search<'_, Euclidean>,
        ground: &mut Ground<LANES>,
        at: &[[f64; LANES]; 3],
        found: &mut Found<1, LANES>,
    ) {
        let (group, mut place) = (self.group, [[0; LANES]; 4]);
        self.group += 1;
        let mut t = [[0.0; LANES]; 3];
        found.nowhere = [0.0; LANES];
        for axis in 0..3 {
            for i in 0..LANES {
                let (cell, fraction) = split(at[axis][i]);
                place[axis][i] = cell;
                place[3][i] |= u32::from(fraction >= 0.5) << axis;
                t[axis][i] = fraction;
                found.nowhere[i] += fraction * 0.0;
            }
        }
        if group >= GROUPS || !self.stays(group, &place, search) {
            return search.nearest_of_group(ground, at, found);
        }
        let unsure = self.plots.noises[self.noise].groups[group].measure(search, &t, found);
        search.one_by_one(&unsure, at, found);
    }

    /// Whether lanes are where they were, but for a few. Then they have the nodes of their plots.
    #[inline(always)]
    fn stays(&mut self, group: usize, place: &[[u32; LANES]; 4], search: &Search<'_, Euclidean>) -> bool {
        let Plots { plots, noises, .. } = &mut self.plots;
        let Noise { name, groups, .. } = &mut noises[self.noise];
        let group = &mut groups[group];
        let moved = differ(&group.last, place);
        group.last = *place;
        if moved.iter().sum::<u32>() > FEW {
            return false;
        }
        let stale = differ(&group.own, place);
        if stale.iter().fold(0, |any, stale| any | stale) != 0 {
            for i in (0..LANES).filter(|i| stale[*i] != 0) {
                let place = place.map(|words| words[i]);
                group.enter(i, recall(plots, *name, place, search));
            }
        }
        true
    }
}

/// Which lanes are at different places: 1, or else 0.
#[inline(always)]
fn differ(a: &[[u32; LANES]; 4], b: &[[u32; LANES]; 4]) -> [u32; LANES] {
    let mut differ = [0; LANES];
    for i in 0..LANES {
        let bits = (a[0][i] ^ b[0][i]) | (a[1][i] ^ b[1][i]) | (a[2][i] ^ b[2][i]) | (a[3][i] ^ b[3][i]);
        differ[i] = u32::from(bits != 0);
    }
    differ
}

/// What is known of a plot, from now on at least.
#[inline(never)]
fn recall<'a>(plots: &'a mut [Plot], noise: u64, place: Place, search: &Search<'_, Euclidean>) -> &'a Plot {
    let plot = &mut plots[entry(noise, place)];
    if plot.noise != noise || plot.place != place {
        *plot = Plot::survey(noise, place, search);
    }
    plot
}

impl Group {
    /// A lane has come to another plot.
    #[inline(always)]
    fn enter(&mut self, i: usize, plot: &Plot) {
        for (own, word) in self.own.iter_mut().zip(plot.place) {
            own[i] = word;
        }
        let written = self.count[i].max(plot.count) as usize;
        for (nodes, node) in self.nodes.iter_mut().zip(plot.nodes).take(written) {
            for axis in 0..3 {
                nodes[axis][i] = node[axis];
            }
        }
        self.count[i] = plot.count;
    }

    /// The nearest nodes of points, given by their fractions. Which lanes are unsure.
    #[inline(always)]
    fn measure(
        &self,
        search: &Search<'_, Euclidean>,
        t: &[[f64; LANES]; 3],
        found: &mut Found<1, LANES>,
    ) -> [bool; LANES] {
        let (metric, nothing) = (search.metric, search.nothing());
        let mut from = [[0.0; LANES]; 3];
        for axis in 0..3 {
            for i in 0..LANES {
                from[axis][i] = (t[axis][i] * f64::from(GRAINS) - 0.5) as f32;
            }
        }
        let mut trail = Trail { best: [nothing; LANES], next: [nothing; LANES], node: [[NOWHERE; LANES]; 3] };
        let most = self.count.iter().fold(0, |most, count| most.max(*count));
        for nodes in &self.nodes[..most as usize] {
            trail.visit(metric, &from, nodes);
        }
        let scale = metric.measure([f64::from(GRAINS), 0.0, 0.0], f64::INFINITY);
        let cap = metric.measure([search.cap, 0.0, 0.0], f64::INFINITY);
        found.measure = [[cap; LANES]];
        found.offset = [[[0.0; LANES]; 3]];
        let [u, v, w] = &trail.node;
        let offset = [offsets(&t[0], u), offsets(&t[1], v), offsets(&t[2], w)];
        let mut unsure = [false; LANES];
        for i in 0..LANES {
            let offset = [offset[0][i], offset[1][i], offset[2][i]];
            let measure = metric.measure(offset, f64::INFINITY);
            let measure = if trail.best[i] < nothing { measure } else { f64::INFINITY };
            found.insert(i, measure, offset);
        }
        for i in 0..LANES {
            let next = f64::from(trail.next[i] - SLACK);
            unsure[i] = (self.count[i] == 0) | (found.measure[0][i] * scale >= next);
        }
        unsure
    }
}

/// Offsets along an axis of points, given by their fractions, from nodes, in cells.
#[inline(always)]
fn offsets(t: &[f64; LANES], nodes: &[i32; LANES]) -> [f64; LANES] {
    let mut offsets = [0.0; LANES];
    for i in 0..LANES {
        // Rounded as in a search: first the cell, then the node.
        let (step, rest) = (nodes[i] >> 10, nodes[i] & 1023);
        offsets[i] = t[i] - f64::from(step) - 0.5 * GRAIN - f64::from(rest) * GRAIN;
    }
    offsets
}

/// The nearest node so far, in single precision, and the measure of the best of the others.
struct Trail {
    best: [f32; LANES],
    next: [f32; LANES],
    node: [[i32; LANES]; 3],
}

impl Trail {
    /// Looks at a node of each lane. Written out, so that it is compiled to vectors.
    #[inline(always)]
    fn visit(&mut self, metric: Euclidean, from: &[[f32; LANES]; 3], nodes: &[[i32; LANES]; 3]) {
        let ([x, y, z], [u, v, w], node) = (from, nodes, &mut self.node);
        for i in 0..LANES {
            let measure = metric.rough([x[i] - u[i] as f32, y[i] - v[i] as f32, z[i] - w[i] as f32]);
            let old = self.best[i];
            let nearer = measure < old;
            let other = if nearer { old } else { measure };
            self.best[i] = if nearer { measure } else { old };
            self.next[i] = if other < self.next[i] { other } else { self.next[i] };
            node[0][i] = if nearer { u[i] } else { node[0][i] };
            node[1][i] = if nearer { v[i] } else { node[1][i] };
            node[2][i] = if nearer { w[i] } else { node[2][i] };
        }
    }
}

/// What measures in single precision may be off by.
const SLACK: f32 = match Euclidean::SLACK {
    Some(slack) => slack,
    None => f32::INFINITY,
};

#[cfg(test)]
mod tests {
    use super::super::Norm;
    use super::*;
    use crate::noise::tests::Random;

    #[test]
    fn plots_have_the_nearest_nodes_of_all_their_points() {
        let (mut random, mut nodes, mut empty) = (Random::new(5), 0, 0);
        for i in 0..2000_u32 {
            let lattice = Lattice { seed: 3, period: if i % 2 == 0 { [0; 3] } else { [5, 1, 0] } };
            let search = Norm::euclidean(&lattice);
            let place = [i.wrapping_mul(7919) % 40, u32::MAX - i % 20, i % 13, i % 8];
            let plot = Plot::survey(1, place, &search);
            // On a lattice that repeats after a cell, some places have no node near them, and all of those along a line do.
            nodes += if i % 2 == 0 { plot.count } else { 0 };
            empty += u32::from(plot.count == 0 && i % 2 == 0);
            for _ in 0..if plot.count == 0 { 0 } else { 50 } {
                let t: [f64; 3] = std::array::from_fn(|k| {
                    0.5 * (f64::from(place[3] >> k & 1) + 0.999 * random.unit().abs())
                });
                let at = std::array::from_fn(|k| f64::from(place[k] as i32) + t[k]);
                let nearest = search.nearest::<1>(at).measure[0][0];
                let own = plot.nodes[..plot.count as usize].iter().map(|node| {
                    let d: [f64; 3] = std::array::from_fn(|k| t[k] - (f64::from(node[k]) + 0.5) * GRAIN);
                    d.iter().map(|d| d * d).sum::<f64>()
                });
                let own = own.fold(f64::INFINITY, f64::min);
                assert!((own - nearest).abs() < 1e-12, "{place:?} {t:?} {own} {nearest}");
            }
        }
        // Few, and seldom too many.
        assert!(nodes < 1000 * 5 && empty < 10, "{nodes} {empty}");
    }
}
