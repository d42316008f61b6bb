//! Where the surface is nearly flat, vertices are merged.
//!
//! Cells are gathered into larger cells, level by level, eight into one (Schaefer, Ju and Warren 2007). The
//! patches of a larger cell are the unions of patches of its parts that are connected in it. One may be
//! represented by a single vertex if it is near all planes of its crossings and the mesh stays a manifold:
//! the union is a disc,
//!
//! ```text
//! patches - arcs between them + crossings within = 1          (its Euler characteristic)
//! ```
//!
//! and its border passes each face of the larger cell at most once: the edges around each face have no crossing
//! of it or two. Nor are colours merged that differ to the eye: points are all that a mesh has for them.

use super::contour::Vertex;
use super::lattice::Place;
use super::quadric::Quadric;
use super::weave::Quad;
use glam::DVec3;
use std::collections::HashMap;

/// A patch of a cell of some level.
#[derive(Clone, Copy, Debug)]
struct Patch {
    parent: Option<u32>,
    quadric: Quadric,
    normal: DVec3,
    shades: Shades,
    euler: i32,
    /// Crossings of the cell's edges, by number.
    crossings: [u16; 12],
    level: u32,
    cell: Place,
    may_stand: bool,
}

/// How far colours may differ that one vertex stands for, as shares of what a screen can show.
const ALIKE: f32 = 0.06;

/// Colours from the least to the largest, channel by channel, as screens show them.
#[derive(Clone, Copy, Debug)]
struct Shades {
    low: [f32; 3],
    high: [f32; 3],
}

impl Shades {
    const NONE: Shades = Shades { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    fn join(&mut self, other: &Shades) {
        for k in 0..3 {
            self.low[k] = self.low[k].min(other.low[k]);
            self.high[k] = self.high[k].max(other.high[k]);
        }
    }

    fn are_alike(&self) -> bool {
        (0..3).all(|k| self.high[k] - self.low[k] <= ALIKE)
    }
}

/// The colours of vertices and of those next to them: on both sides of an edge between two colours none are merged.
fn shades_around(count: usize, quads: &[Quad], colors: &[[f32; 3]]) -> Vec<Shades> {
    let own = |i: usize| colors.get(i).map_or(Shades::NONE, |&c| Shades { low: c, high: c });
    let mut shades: Vec<Shades> = (0..count).map(own).collect();
    for quad in quads {
        let mut all = Shades::NONE;
        quad.vertices.iter().for_each(|v| all.join(&own(*v as usize)));
        quad.vertices.iter().for_each(|v| shades[*v as usize].join(&all));
    }
    shades
}

/// The patches of all levels: first the vertices, then patches made of earlier ones.
pub(super) struct Forest {
    patches: Vec<Patch>,
    leaves: usize,
}

/// What vertices have become: for each the number of the one that stands for it, and these.
pub(super) struct Merged {
    pub of: Vec<u32>,
    pub places: Vec<DVec3>,
    pub normals: Vec<DVec3>,
}

impl Forest {
    /// Gathers vertices as far as a distance, in steps of the lattice, and their colours allow, where there are any.
    pub fn new(vertices: &[Vertex], quads: &[Quad], distance: f64, colors: &[[f32; 3]]) -> Forest {
        let shades = shades_around(vertices.len(), quads, colors);
        let leaf = |(i, v): (usize, &Vertex)| Patch {
            parent: None,
            quadric: v.quadric,
            normal: v.normal,
            shades: shades[i],
            euler: 1,
            crossings: [0; 12],
            level: 0,
            cell: v.cell,
            may_stand: true,
        };
        let mut forest =
            Forest { patches: vertices.iter().enumerate().map(leaf).collect(), leaves: vertices.len() };
        // The patch of the current level that each vertex belongs to.
        let mut top: Vec<u32> = (0..vertices.len() as u32).collect();
        let meetings = Meetings::new(vertices, quads);
        for level in 1..=meetings.levels() {
            let made = forest.gather(level, &mut top, &meetings);
            forest.count_crossings(level, &top, quads, made);
            for patch in &mut forest.patches[made..] {
                patch.may_stand = patch.shades.are_alike() && patch.is_simple() && patch.is_flat(distance);
            }
        }
        forest
    }

    /// Makes the patches of a level out of those of the level before. Returns the number of the first.
    fn gather(&mut self, level: u32, top: &mut [u32], meetings: &Meetings) -> usize {
        let made = self.patches.len();
        let mut union = Union::default();
        for [a, b] in meetings.arcs(level) {
            union.join(top[*a as usize], top[*b as usize]);
        }
        let mut new_of: HashMap<u32, u32> = HashMap::new();
        // In the order of the vertices, whatever the order of the arcs was.
        for &old in top.iter() {
            let Some(root) = union.root(old) else { continue };
            if self.patches[old as usize].parent.is_some() {
                continue;
            }
            let next = self.patches.len() as u32;
            let new = *new_of.entry(root).or_insert(next);
            if new == next {
                let cell = self.patches[old as usize].cell.map(|i| i >> level << level);
                self.patches.push(Patch {
                    parent: None,
                    quadric: Quadric::default(),
                    normal: DVec3::ZERO,
                    shades: Shades::NONE,
                    euler: 0,
                    crossings: [0; 12],
                    level,
                    cell,
                    may_stand: false,
                });
            }
            self.patches[old as usize].parent = Some(new);
            let Patch { quadric, normal, shades, euler, .. } = self.patches[old as usize];
            let patch = &mut self.patches[new as usize];
            patch.quadric.join(&quadric);
            patch.normal += normal;
            patch.shades.join(&shades);
            patch.euler += euler;
        }
        for top in top.iter_mut() {
            *top = self.patches[*top as usize].parent.unwrap_or(*top);
        }
        for [a, _] in meetings.arcs(level) {
            self.patches[top[*a as usize] as usize].euler -= 1;
        }
        for a in meetings.crossings(level) {
            self.patches[top[*a as usize] as usize].euler += 1;
        }
        made
    }

    /// Counts the crossings of the edges of a level's cells by patches that were made for it.
    fn count_crossings(&mut self, level: u32, top: &[u32], quads: &[Quad], made: usize) {
        for quad in quads {
            let axis = usize::from(quad.axis);
            let on_edge = |axis: usize| quad.at[axis % 3].trailing_zeros() >= level;
            if !(on_edge(axis + 1) && on_edge(axis + 2)) {
                continue;
            }
            // The vertex after u and v sees the edge at its start, that before u at u = 1, and so on.
            for (vertex, offset) in quad.vertices.into_iter().zip([0, 1, 3, 2]) {
                let patch = top[vertex as usize] as usize;
                if patch >= made {
                    self.patches[patch].crossings[4 * axis + offset] += 1;
                }
            }
        }
    }

    /// Lets the patches that stand for some vertices stand no more. Says whether there were any.
    pub fn part(&mut self, vertices: impl Iterator<Item = u32>) -> bool {
        let mut any = false;
        let standing: Vec<usize> = vertices.map(|v| self.standing(v as usize)).collect();
        for patch in standing.into_iter().filter(|&patch| patch >= self.leaves) {
            self.patches[patch].may_stand = false;
            any = true;
        }
        any
    }

    /// The largest patch that may stand for a vertex.
    fn standing(&self, vertex: usize) -> usize {
        let (mut found, mut at) = (vertex, vertex);
        while let Some(parent) = self.patches[at].parent {
            at = parent as usize;
            if self.patches[at].may_stand {
                found = at;
            }
        }
        found
    }

    /// What has become of the vertices.
    pub fn merged(&self, vertices: &[Vertex]) -> Merged {
        let mut merged =
            Merged { of: Vec::with_capacity(self.leaves), places: Vec::new(), normals: Vec::new() };
        let mut number = vec![u32::MAX; self.patches.len()];
        for vertex in 0..self.leaves {
            let standing = self.standing(vertex);
            if number[standing] == u32::MAX {
                number[standing] = merged.places.len() as u32;
                let patch = &self.patches[standing];
                merged.places.push(if standing < self.leaves {
                    vertices[standing].place
                } else {
                    patch.place()
                });
                merged.normals.push(patch.normal.normalize_or(DVec3::Y));
            }
            merged.of.push(number[standing]);
        }
        merged
    }
}

impl Patch {
    fn place(&self) -> DVec3 {
        let lo = DVec3::from_array(self.cell.map(f64::from));
        self.quadric.least_within(lo, lo + f64::from(1_u32 << self.level))
    }

    fn is_flat(&self, distance: f64) -> bool {
        self.quadric.distance(self.place()) <= distance
    }

    /// Whether one vertex can take the place of all.
    fn is_simple(&self) -> bool {
        let is_disc = self.euler == 1;
        let crossings = |axis: usize, u: usize, v: usize| self.crossings[4 * axis + u + 2 * v];
        let mut faces = (0..3).flat_map(|axis| [0, 1].map(|side| (axis, side)));
        let passes_once = faces.all(|(axis, side)| {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            // Offsets of the edges along u are those along (v, axis), of the edges along v those along (axis, u).
            let around =
                crossings(u, 0, side) + crossings(u, 1, side) + crossings(v, side, 0) + crossings(v, side, 1);
            around == 0 || around == 2
        });
        is_disc && passes_once && self.crossings.iter().any(|c| *c > 0)
    }
}

/// Which vertices become neighbours within one cell, by the level at which they do.
struct Meetings {
    /// Pairs of vertices on both sides of an arc.
    arcs: Vec<Vec<[u32; 2]>>,
    /// A vertex at each crossing.
    crossings: Vec<Vec<u32>>,
}

impl Meetings {
    fn new(vertices: &[Vertex], quads: &[Quad]) -> Meetings {
        let mut meetings = Meetings { arcs: Vec::new(), crossings: Vec::new() };
        let cell = |v: u32| vertices[v as usize].cell;
        // The first level at which cells are parts of the same one.
        let level = |a: Place, b: Place| {
            let differ = (0..3).fold(0, |bits, axis| bits | a[axis] ^ b[axis]);
            (u32::BITS - differ.leading_zeros()) as usize
        };
        for quad in quads {
            let [a, b, c, d] = quad.vertices;
            // A cell that has two that are opposite has the other two as well.
            let whole = level(cell(a), cell(c));
            meetings.reach(whole);
            meetings.crossings[whole].push(a);
            for (from, to) in [(a, b), (b, c), (c, d), (d, a)] {
                meetings.arcs[level(cell(from), cell(to))].push([from.min(to), from.max(to)]);
            }
        }
        for arcs in &mut meetings.arcs {
            arcs.sort_unstable();
            arcs.dedup();
        }
        meetings
    }

    fn reach(&mut self, level: usize) {
        while self.arcs.len() <= level {
            self.arcs.push(Vec::new());
            self.crossings.push(Vec::new());
        }
    }

    fn levels(&self) -> u32 {
        self.arcs.len().saturating_sub(1) as u32
    }

    fn arcs(&self, level: u32) -> &[[u32; 2]] {
        &self.arcs[level as usize]
    }

    fn crossings(&self, level: u32) -> &[u32] {
        &self.crossings[level as usize]
    }
}

/// Disjoint sets of numbers.
#[derive(Default)]
struct Union(HashMap<u32, u32>);

impl Union {
    /// The least of a number's set, if it is in one.
    fn root(&self, mut a: u32) -> Option<u32> {
        loop {
            let next = *self.0.get(&a)?;
            if next == a {
                return Some(a);
            }
            a = next;
        }
    }

    fn join(&mut self, a: u32, b: u32) {
        let [a, b] = [a, b].map(|x| {
            self.0.entry(x).or_insert(x);
            self.root(x).unwrap_or(x)
        });
        self.0.insert(a.max(b), a.min(b));
    }
}
