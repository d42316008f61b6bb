//! A mesh as a closed surface: equal points are one, holes have lids.
//!
//! A set of oriented triangles is closed if every edge is passed as often one way as the other. Then
//! its winding number is a whole number off the surface, whatever else the triangles do: meet three at
//! an edge, pass through one another, lie on top of one another. What is missing to that, the edges
//! that are passed more often one way, enters and leaves every point equally often, so that it can be
//! taken apart into loops; each gets a fan of triangles to the mean of its points.

use super::super::Mesh;
use super::oriented::{turn_all, turned_alike};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// Three corners, counter-clockwise as seen from outside.
pub(super) type Corners = [DVec3; 3];

/// The triangles of a mesh and of its lids, turned alike (`oriented.rs`), and which part each is of.
pub(super) fn closed(mesh: &Mesh) -> (Vec<Corners>, Vec<u32>) {
    let (points, number) = welded(&mesh.points);
    let named = mesh.triangles.iter().map(|t| t.map(|i| number[i as usize]));
    let mut triangles: Vec<[u32; 3]> = named.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    let mut part = turned_alike(&mut triangles);
    let rims = rims(&triangles);
    let at_edge = parts_at(&rims, &triangles, &part);
    let mut all: Vec<Corners> = triangles.iter().map(|t| t.map(|i| points[i as usize])).collect();
    for rim in loops(&rims) {
        let corners: Vec<DVec3> = rim.iter().map(|i| points[*i as usize]).collect();
        let before = all.len();
        match corners[..] {
            [a, b, c] => all.push([a, b, c]),
            _ => {
                let sum: DVec3 = corners.iter().map(|p| p / corners.len() as f64).sum();
                let next = corners.iter().cycle().skip(1);
                all.extend(corners.iter().zip(next).map(|(a, b)| [*a, *b, sum]));
            }
        }
        let own = at_edge.get(&ends(rim[0], rim[1])).copied().unwrap_or_default();
        part.resize(part.len() + all.len() - before, own);
    }
    turn_all(&mut all);
    (all, part)
}

/// An edge, whichever way it is passed.
fn ends(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// The part of a triangle at each of some edges.
fn parts_at(edges: &[[u32; 2]], triangles: &[[u32; 3]], part: &[u32]) -> HashMap<[u32; 2], u32> {
    let mut parts: HashMap<[u32; 2], u32> = edges.iter().map(|[a, b]| (ends(*a, *b), 0)).collect();
    if !parts.is_empty() {
        for ([a, b, c], part) in triangles.iter().zip(part) {
            for edge in [ends(*a, *b), ends(*b, *c), ends(*c, *a)] {
                parts.entry(edge).and_modify(|known| *known = *part);
            }
        }
    }
    parts
}

/// The different points, and which of them each point is.
fn welded(points: &[DVec3]) -> (Vec<DVec3>, Vec<u32>) {
    let mut seen: HashMap<[u64; 3], u32> = HashMap::with_capacity(points.len());
    let mut different = Vec::new();
    let mut name = |p: &DVec3| {
        // Both zeros are zero.
        let p = *p + DVec3::ZERO;
        *seen.entry(p.to_array().map(f64::to_bits)).or_insert_with(|| {
            different.push(p);
            (different.len() - 1) as u32
        })
    };
    let number = points.iter().map(&mut name).collect();
    (different, number)
}

/// The edges that are missing, each as often as it is, in order.
fn rims(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let sides = |[a, b, c]: &[u32; 3]| [[*a, *b], [*b, *c], [*c, *a]];
    let mut edges: Vec<([u32; 2], bool)> = triangles
        .par_iter()
        .flat_map_iter(sides)
        .map(|[a, b]| if a < b { ([a, b], true) } else { ([b, a], false) })
        .collect();
    edges.par_sort_unstable();
    let mut missing = Vec::new();
    for same in edges.chunk_by(|a, b| a.0 == b.0) {
        let [a, b] = same[0].0;
        let forward = same.iter().filter(|e| e.1).count();
        let back = same.len() - forward;
        missing.extend(std::iter::repeat_n([b, a], forward.saturating_sub(back)));
        missing.extend(std::iter::repeat_n([a, b], back.saturating_sub(forward)));
    }
    missing.sort_unstable();
    missing
}

/// Takes edges apart into loops that pass no point twice.
fn loops(edges: &[[u32; 2]]) -> Vec<Vec<u32>> {
    // Where to go on from each point, last first.
    let mut from: HashMap<u32, Vec<u32>> = HashMap::new();
    edges.iter().rev().for_each(|[a, b]| from.entry(*a).or_default().push(*b));
    let mut found = Vec::new();
    for [start, _] in edges {
        let mut path = vec![*start];
        let mut place = HashMap::from([(*start, 0)]);
        while let Some(next) = path.last().and_then(|at| from.get_mut(at)).and_then(Vec::pop) {
            if let Some(&first) = place.get(&next) {
                let rim = path.split_off(first + 1);
                rim.iter().for_each(|p| {
                    place.remove(p);
                });
                found.push([&[next], &rim[..]].concat());
            } else {
                place.insert(next, path.len());
                path.push(next);
            }
        }
    }
    found
}

/// The volume that is enclosed, up to rounding.
pub(super) fn volume(triangles: &[Corners]) -> f64 {
    let Some([origin, ..]) = triangles.first() else { return 0.0 };
    triangles.iter().map(|[a, b, c]| (a - origin).dot((b - origin).cross(c - origin))).sum()
}
