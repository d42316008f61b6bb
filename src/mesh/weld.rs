//! Points of a mesh that are one place.
//!
//! Where an edge or a corner of the solid passes from one cell to the next, both may put a vertex at the same place, and
//! the edge between the two has no length. Numbers of 32 bits, which some formats have, make more of such. Who
//! reads the file and takes equal points for one finds triangles that are none, and edges of one triangle or of
//! four. So the ends of an edge without length are made one, and the two triangles at it are left out.
//!
//! The mesh stays the closed surface that it is if the ends have no other neighbours in common than the
//! two corners opposite to the edge, and the triangles are not all of a tetrahedron (the *link condition*: Dey,
//! Edelsbrunner, Guha and Nekhayev 1999):
//!
//! ```text
//!      c               c
//!    / | \             |
//!   *  |  *          * | *
//!   |\ | /|           \|/
//!   * a-b *    ->    *-a-*        triangles abc and adb are gone
//!   |/ | \|           /|\
//!   *  |  *          * | *
//!    \ | /             |
//!      d               d
//! ```
//!
//! Other points that are equal belong to sheets that touch there, or to a sliver too thin for the numbers. All but one of
//! them are moved inwards by as little as the numbers allow.

use crate::shape::Mesh;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// An edge is as good as one without length if it is as short as that, as a share of a cell.
pub(super) const SHORT: f64 = 1.0 / 1_048_576.0;

/// Steps by which points are moved apart, at most.
const MOST_STEPS: u32 = 1024;

/// The mesh without edges as short as that, and without equal points.
pub(super) fn welded(mut mesh: Mesh, short: f64) -> Mesh {
    collapse(&mut mesh, short);
    part(&mut mesh, |p| p, f64::EPSILON);
    mesh
}

/// The mesh with points that numbers of 32 bits can hold, no two of which are equal; as it is where they are
/// too large for these.
pub fn rounded(mesh: &Mesh) -> Mesh {
    let single = |p: DVec3| p.as_vec3().as_dvec3();
    let mut rounded = mesh.clone();
    rounded.points.iter_mut().for_each(|p| *p = single(*p));
    if rounded.check().is_err() {
        return mesh.clone();
    }
    collapse(&mut rounded, 0.0);
    part(&mut rounded, single, f64::from(f32::EPSILON));
    rounded
}

/// Makes the ends of short edges one point each.
fn collapse(mesh: &mut Mesh, short: f64) {
    let is_short = |a: u32, b: u32| {
        let [a, b] = [a, b].map(|i| mesh.points[i as usize]);
        a.distance_squared(b) <= short * short
    };
    let sides = mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    // A closed mesh has each edge in either direction.
    let mut edges: Vec<[u32; 2]> = sides.filter(|&[a, b]| a < b && is_short(a, b)).collect();
    if edges.is_empty() {
        return;
    }
    edges.sort_unstable();
    let mut welder = Welder::new(mesh, &edges);
    // One that is in the way of another may be gone afterwards.
    loop {
        let before = edges.len();
        edges.retain(|edge| !welder.collapse(*edge));
        if edges.len() == before {
            break;
        }
    }
    sweep(mesh);
}

/// Makes points one.
struct Welder<'a> {
    mesh: &'a mut Mesh,
    /// The triangles around the ends of short edges.
    around: BTreeMap<u32, Vec<u32>>,
    /// What points that are gone have become.
    became: BTreeMap<u32, u32>,
}

impl Welder<'_> {
    fn new<'a>(mesh: &'a mut Mesh, edges: &[[u32; 2]]) -> Welder<'a> {
        let mut around: BTreeMap<u32, Vec<u32>> =
            edges.as_flattened().iter().map(|point| (*point, Vec::new())).collect();
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            for point in triangle {
                if let Some(around) = around.get_mut(point) {
                    around.push(t as u32);
                }
            }
        }
        Welder { mesh, around, became: BTreeMap::new() }
    }

    fn now(&self, mut point: u32) -> u32 {
        while let Some(next) = self.became.get(&point) {
            point = *next;
        }
        point
    }

    /// Makes the ends of an edge one point, if the surface allows it. Says whether they are one.
    fn collapse(&mut self, edge: [u32; 2]) -> bool {
        let [a, b] = edge.map(|point| self.now(point));
        if a == b {
            return true;
        }
        let (of_a, of_b) = (self.neighbours(a), self.neighbours(b));
        let is_tetrahedron = of_a.len() == 3 && of_b.len() == 3;
        let can = of_a.contains(&b) && of_a.intersection(&of_b).count() == 2 && !is_tetrahedron;
        if can {
            self.join(a.min(b), a.max(b));
        }
        can
    }

    fn neighbours(&self, point: u32) -> BTreeSet<u32> {
        let triangles = self.around[&point].iter().map(|t| self.mesh.triangles[*t as usize]);
        triangles.filter(is_one).flatten().filter(|other| *other != point).collect()
    }

    /// Lets the second point become the first.
    fn join(&mut self, a: u32, b: u32) {
        self.became.insert(b, a);
        for t in self.around.remove(&b).unwrap_or_default() {
            self.mesh.triangles[t as usize].iter_mut().filter(|i| **i == b).for_each(|i| *i = a);
            self.around.entry(a).or_default().push(t);
        }
        let triangles = &self.mesh.triangles;
        self.around.entry(a).or_default().retain(|t| is_one(&triangles[*t as usize]));
        if let [Some(of_a), Some(of_b)] = [a, b].map(|i| self.mesh.normals.get(i as usize).copied()) {
            self.mesh.normals[a as usize] = (of_a + of_b).try_normalize().unwrap_or(of_a);
        }
    }
}

/// Whether a triangle has three different corners.
fn is_one([a, b, c]: &[u32; 3]) -> bool {
    a != b && b != c && c != a
}

/// Leaves out triangles that are none, and points that none has.
fn sweep(mesh: &mut Mesh) {
    mesh.triangles.retain(is_one);
    let mut is_used = vec![false; mesh.points.len()];
    mesh.triangles.as_flattened().iter().for_each(|i| is_used[*i as usize] = true);
    let mut count = 0;
    let number: Vec<u32> = is_used
        .iter()
        .map(|used| {
            count += u32::from(*used);
            count.saturating_sub(1)
        })
        .collect();
    mesh.triangles.as_flattened_mut().iter_mut().for_each(|i| *i = number[*i as usize]);
    keep(&mut mesh.points, &is_used);
    keep(&mut mesh.normals, &is_used);
    keep(&mut mesh.colors, &is_used);
}

fn keep<T>(items: &mut Vec<T>, is_kept: &[bool]) {
    let mut is_kept = is_kept.iter();
    items.retain(|_| is_kept.next().is_some_and(|kept| *kept));
}

/// What is equal for equal points: minus zero is zero.
fn key(p: DVec3) -> [u64; 3] {
    (p + 0.0).to_array().map(f64::to_bits)
}

/// Moves equal points apart, to places that are `round`, by steps of a share of the largest coordinate.
fn part(mesh: &mut Mesh, round: impl Fn(DVec3) -> DVec3, share: f64) {
    let mut keys: Vec<([u64; 3], usize)> = mesh.points.iter().map(|p| key(*p)).zip(0..).collect();
    keys.par_sort_unstable();
    let equal = keys.windows(2).filter(|pair| pair[0].0 == pair[1].0).map(|pair| pair[1].1);
    let largest = mesh.points.iter().fold(0.0, |largest: f64, p| largest.max(p.abs().max_element()));
    let mut taken = BTreeSet::new();
    for i in equal {
        let inward = -mesh.normals.get(i).copied().unwrap_or(DVec3::Y) * (share * largest);
        let is_free = |p: &DVec3| {
            let key = key(*p);
            keys.binary_search_by_key(&key, |(key, _)| *key).is_err() && !taken.contains(&key)
        };
        let mut places = (1..MOST_STEPS).map(|steps| round(mesh.points[i] + inward * f64::from(steps)));
        if let Some(place) = places.find(is_free) {
            taken.insert(key(place));
            mesh.points[i] = place;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Census;

    /// Two pyramids on a ring of points around the z axis.
    fn pyramids(ring: &[DVec3]) -> Mesh {
        let n = ring.len() as u32;
        let sides = (0..n).flat_map(|i| {
            let next = (i + 1) % n;
            [[i, next, n], [next, i, n + 1]]
        });
        let points: Vec<DVec3> = ring.iter().copied().chain([DVec3::Z, -DVec3::Z]).collect();
        let normals = points.iter().map(|p| p.normalize_or(DVec3::Z)).collect();
        Mesh { triangles: sides.collect(), colors: vec![[0.5; 3]; points.len()], points, normals }
    }

    fn check(mesh: &Mesh) -> Census {
        assert_eq!(mesh.check(), Ok(()));
        let census = Census::of(mesh);
        assert!(census.is_closed_manifold(), "{mesh:?}");
        let places: BTreeSet<[u64; 3]> = mesh.points.iter().map(|p| key(*p)).collect();
        assert_eq!(places.len(), mesh.points.len(), "{mesh:?}");
        census
    }

    #[test]
    fn edges_without_length_are_gone() {
        let ring = [DVec3::X, DVec3::Y, DVec3::Y, DVec3::new(-0.0, 1.0, 0.0), -DVec3::X, -DVec3::Y];
        let mesh = welded(pyramids(&ring), 0.0);
        assert_eq!((check(&mesh).triangles, mesh.points.len()), (8, 6));
        assert_eq!(mesh.points, [DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y, DVec3::Z, -DVec3::Z]);
        assert!(mesh.normals[1].distance(DVec3::Y) < 1e-15);
        let near = [DVec3::X, DVec3::Y, DVec3::Y + 1e-9, -DVec3::X, -DVec3::Y];
        assert_eq!(check(&welded(pyramids(&near), 1e-8)).points, 6);
        assert_eq!(check(&welded(pyramids(&near), 0.0)).points, 7);
    }

    #[test]
    fn what_would_be_no_surface_is_moved_apart() {
        // Nothing is left of a ring of two, nor of a tetrahedron with fewer points.
        let flat = welded(pyramids(&[DVec3::X, DVec3::Y, DVec3::Y]), 0.0);
        assert_eq!((check(&flat).triangles, flat.points.len()), (6, 5));
        let mesh = Mesh {
            points: vec![DVec3::X, DVec3::X, DVec3::Y, DVec3::Z],
            triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
            ..Mesh::default()
        };
        let thin = welded(mesh.clone(), 0.0);
        assert_eq!(check(&thin).triangles, 4);
        assert!(thin.points.iter().zip(&mesh.points).all(|(a, b)| a.distance(*b) < 1e-15));
    }

    #[test]
    fn parts_that_touch_are_moved_apart() {
        let one = pyramids(&[DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y]);
        let n = one.points.len() as u32;
        let both = Mesh {
            points: one
                .points
                .iter()
                .copied()
                .chain(one.points.iter().map(|p| *p + 2.0 * DVec3::X))
                .collect(),
            triangles: one
                .triangles
                .iter()
                .copied()
                .chain(one.triangles.iter().map(|t| t.map(|i| i + n)))
                .collect(),
            normals: one.normals.repeat(2),
            colors: Vec::new(),
        };
        for parted in [welded(both.clone(), 0.0), rounded(&both)] {
            assert_eq!(check(&parted).parts, 2);
            let [a, b] = [parted.points[0], parted.points[(n + 2) as usize]];
            assert!(a.x < b.x && a.distance(b) < 1e-6, "{a} {b}");
        }
    }

    #[test]
    fn rounding_makes_points_one() {
        let (far, close) = (DVec3::splat(1000.0), DVec3::new(-1e-6, 2e-6, 0.0));
        let mut mesh = pyramids(&[DVec3::X, DVec3::Y, DVec3::Y + close, -DVec3::X, -DVec3::Y]);
        mesh.points.iter_mut().for_each(|p| *p += far);
        assert_eq!(check(&welded(mesh.clone(), 0.0)).points, 7);
        let single = rounded(&mesh);
        assert_eq!(check(&single).points, 6);
        assert!(single.points.iter().all(|p| p.as_vec3().as_dvec3() == *p));
        mesh.points[0].x = 1e300;
        assert_eq!(rounded(&mesh), mesh);
    }
}
