//! Which side of a triangle is outside, where a mesh is not of one mind.
//!
//! Triangles that share an edge with no third one are turned alike, the way most of those are that hang together so;
//! where that cannot be, as on a Möbius strip, they are left as they are. A closed part that encloses less than nothing has
//! its outside within: it is the surface of a void where other parts wind around it, and else is turned.

use super::closed::{Corners, volume};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashMap;
use std::f64::consts::TAU;

/// Turns triangles, given by the numbers of their points, as their neighbours are; for each the number of its part.
pub(super) fn turned_alike(triangles: &mut [[u32; 3]]) -> Vec<u32> {
    let across = neighbours(triangles);
    let mut part = vec![u32::MAX; triangles.len()];
    let mut is_turned = vec![false; triangles.len()];
    let mut parts = 0;
    for first in 0..triangles.len() {
        if part[first] != u32::MAX {
            continue;
        }
        part[first] = parts;
        let (mut members, mut done, mut is_sound) = (vec![first], 0, true);
        while let Some(&here) = members.get(done) {
            done += 1;
            for &(there, is_alike) in across[here].iter().flatten() {
                let wanted = is_turned[here] ^ !is_alike;
                if part[there] == u32::MAX {
                    (part[there], is_turned[there]) = (parts, wanted);
                    members.push(there);
                } else {
                    is_sound &= is_turned[there] == wanted;
                }
            }
        }
        let turned = members.iter().filter(|i| is_turned[**i]).count();
        let are_most = 2 * turned > members.len();
        for i in members {
            if is_sound && is_turned[i] != are_most {
                triangles[i].swap(1, 2);
            }
        }
        parts += 1;
    }
    part
}

/// Across each edge of each triangle the only other one there, and whether both pass the edge in opposite ways.
fn neighbours(triangles: &[[u32; 3]]) -> Vec<[Option<(usize, bool)>; 3]> {
    let mut edges = Vec::with_capacity(3 * triangles.len());
    for (i, t) in triangles.iter().enumerate() {
        for side in 0..3 {
            let (a, b) = (t[side], t[(side + 1) % 3]);
            edges.push(([a.min(b), a.max(b)], i, side, a < b));
        }
    }
    edges.par_sort_unstable();
    let mut across = vec![[None; 3]; triangles.len()];
    for same in edges.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, i, side, forward), (_, k, other, back)] = *same {
            across[i][side] = Some((k, forward != back));
            across[k][other] = Some((i, forward != back));
        }
    }
    across
}

/// Turns parts that are inside out, each triangle with the number of its part.
pub(super) fn turn_parts(triangles: &mut [Corners], part: &[u32]) {
    if volume(triangles) < 0.0 {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    let mut parts: HashMap<u32, Vec<usize>> = HashMap::new();
    part.iter().enumerate().for_each(|(i, part)| parts.entry(*part).or_default().push(i));
    let mut parts: Vec<Part> = parts.into_values().map(|members| Part::new(members, triangles)).collect();
    if parts.len() == 1 {
        return;
    }
    // Of those within one another the outer ones come first.
    parts.sort_by(|a, b| b.volume.abs().total_cmp(&a.volume.abs()).then(a.members.cmp(&b.members)));
    for i in 0..parts.len() {
        if parts[i].volume < 0.0 && parts[i].is_closed(triangles) && !is_void(&parts, i, triangles) {
            parts[i].members.iter().for_each(|t| triangles[*t].swap(1, 2));
        }
    }
}

/// Triangles that hang together.
struct Part {
    members: Vec<usize>,
    volume: f64,
    lo: DVec3,
    hi: DVec3,
}

impl Part {
    fn new(members: Vec<usize>, triangles: &[Corners]) -> Part {
        let own: Vec<Corners> = members.iter().map(|i| triangles[*i]).collect();
        let corners = own.as_flattened().iter();
        let (lo, hi) =
            corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), p| (lo.min(*p), hi.max(*p)));
        Part { volume: volume(&own), members, lo, hi }
    }

    /// Whether each edge is passed as often one way as the other: else it encloses nothing by itself.
    fn is_closed(&self, triangles: &[Corners]) -> bool {
        let mut edges: HashMap<[[u64; 3]; 2], i32> = HashMap::new();
        for [a, b, c] in self.members.iter().map(|i| triangles[*i].map(|p| p.to_array().map(f64::to_bits))) {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                let (edge, way) = if from < to { ([from, to], 1) } else { ([to, from], -1) };
                *edges.entry(edge).or_default() += way;
            }
        }
        edges.values().all(|passed| *passed == 0)
    }
}

/// Whether other parts wind around one.
fn is_void(parts: &[Part], which: usize, triangles: &[Corners]) -> bool {
    let own = &parts[which];
    let area = |i: &usize| triangles[*i].map(|p| p - triangles[*i][0]);
    let area = |i: &usize| area(i)[1].cross(area(i)[2]).length();
    let Some(&widest) = own.members.iter().max_by(|a, b| area(a).total_cmp(&area(b))) else { return false };
    let x = triangles[widest].iter().sum::<DVec3>() / 3.0;
    let holds = |part: &&Part| part.lo.cmplt(own.lo).all() && own.hi.cmplt(part.hi).all();
    let around = parts.iter().filter(holds).flat_map(|part| &part.members);
    around.map(|i| solid_angle(triangles[*i], x)).sum::<f64>() > TAU
}

/// The solid angle of a triangle, positive from behind (van Oosterom and Strackee, 1983).
fn solid_angle(triangle: Corners, x: DVec3) -> f64 {
    let [a, b, c] = triangle.map(|p| p - x);
    let [u, v, w] = [a, b, c].map(DVec3::length);
    let below = u * v * w + a.dot(b) * w + b.dot(c) * u + c.dot(a) * v;
    2.0 * libm::atan2(a.dot(b.cross(c)), below)
}
