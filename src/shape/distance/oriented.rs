//! Which side of a triangle is outside, where a mesh is not of one mind.
//!
//! Triangles that share an edge with no third one are turned alike, the way most of those are that hang together so;
//! where that cannot be, as on a Möbius strip, they are left as they are. A mesh that encloses less than
//! nothing is turned as a whole, with all its voids. Then a closed part that does so has its outside within: it is the
//! surface of a void where others wind around it, so that nothing is left in there, and is turned where less than
//! nothing is.

use super::closed::{Corners, volume};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::{BTreeMap, HashMap};

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

/// Turns all triangles if they enclose less than nothing, as where the mesh is inside out with all its voids.
pub(super) fn turn_all(triangles: &mut [Corners]) {
    if volume(triangles) < 0.0 {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
}

/// Turns parts that are inside out, and says whether there are any. Given are the number of the part of each triangle,
/// and how often all of them wind around a point.
pub(super) fn turn_parts(
    triangles: &mut [Corners],
    part: &[u32],
    winding: impl Fn(DVec3) -> Option<i32>,
) -> bool {
    let mut parts: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    part.iter().enumerate().for_each(|(i, part)| parts.entry(*part).or_default().push(i));
    if parts.len() == 1 {
        return false;
    }
    let is_inside_out = |members: &&Vec<usize>| {
        let own: Vec<Corners> = members.iter().map(|i| triangles[*i]).collect();
        volume(&own) < 0.0
            && before(&own).and_then(&winding).is_some_and(|turns| turns < 0)
            && is_closed(&own)
    };
    let wrong: Vec<usize> = parts.values().filter(is_inside_out).flatten().copied().collect();
    wrong.iter().for_each(|i| triangles[*i].swap(1, 2));
    !wrong.is_empty()
}

/// A place just before the widest of some triangles, on the side that is outside by it: within a part that is inside
/// out, and within the void if it is that of one.
fn before(triangles: &[Corners]) -> Option<DVec3> {
    let normal = |t: &Corners| (t[1] - t[0]).cross(t[2] - t[0]);
    let area = |t: &Corners| normal(t).length();
    let widest = triangles.iter().max_by(|a, b| area(a).total_cmp(&area(b)))?;
    let off = 1e-6 * area(widest).sqrt() * normal(widest).try_normalize()?;
    Some(widest.iter().sum::<DVec3>() / 3.0 + off)
}

/// Whether each edge is passed as often one way as the other: else triangles enclose nothing by themselves.
fn is_closed(triangles: &[Corners]) -> bool {
    let mut edges: HashMap<[[u64; 3]; 2], i32> = HashMap::new();
    for [a, b, c] in triangles.iter().map(|t| t.map(|p| p.to_array().map(f64::to_bits))) {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            let (edge, way) = if from < to { ([from, to], 1) } else { ([to, from], -1) };
            *edges.entry(edge).or_default() += way;
        }
    }
    edges.values().all(|passed| *passed == 0)
}
