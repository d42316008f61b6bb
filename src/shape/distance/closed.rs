//! A mesh as a closed surface: equal points are one, holes have lids.
//!
//! A set of oriented triangles is closed if every edge is passed as often one way as the other. Then
//! its winding number is a whole number off the surface, whatever else the triangles do: meet three at
//! an edge, pass through one another, lie on top of one another. What is missing to that, the edges
//! that are passed more often one way, enters and leaves every point equally often, so that it can be
//! taken apart into loops; each gets a fan of triangles to the mean of its points.

use super::super::Mesh;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// Three corners, counter-clockwise as seen from outside.
pub(super) type Corners = [DVec3; 3];

/// The triangles of a mesh and of its lids. A surface that is inside out, so that it holds a negative
/// volume, is turned.
pub(super) fn closed(mesh: &Mesh) -> Vec<Corners> {
    let (points, number) = welded(&mesh.points);
    let named = mesh.triangles.iter().map(|t| t.map(|i| number[i as usize]));
    let mut triangles: Vec<[u32; 3]> = named.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    let mut lids = Vec::new();
    for rim in loops(&rims(&triangles)) {
        let sum: DVec3 = rim.iter().map(|i| points[*i as usize] / rim.len() as f64).sum();
        let next = rim.iter().cycle().skip(1);
        match rim[..] {
            [a, b, c] => triangles.push([a, b, c]),
            _ => lids
                .extend(rim.iter().zip(next).map(|(a, b)| [points[*a as usize], points[*b as usize], sum])),
        }
    }
    let mut all: Vec<Corners> = triangles.iter().map(|t| t.map(|i| points[i as usize])).collect();
    all.extend(lids);
    if volume(&all) < 0.0 {
        all.iter_mut().for_each(|t| t.swap(1, 2));
    }
    all
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
fn volume(triangles: &[Corners]) -> f64 {
    let Some([origin, ..]) = triangles.first() else { return 0.0 };
    triangles.iter().map(|[a, b, c]| (a - origin).dot((b - origin).cross(c - origin))).sum()
}
