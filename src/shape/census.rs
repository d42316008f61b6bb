//! What kind of surface a mesh is: whether it is closed, oriented and a manifold, of how many parts it consists,
//! and its Euler characteristic.
//!
//! The triangles around a point make a *fan* if each begins with the edge that another ends with, round to the
//! first again. A mesh in which all points have one fan each is a closed and oriented manifold.

use super::{Mesh, Parts};
use rayon::prelude::*;

/// What is known of a mesh as a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Census {
    /// Points that triangles have.
    pub points: usize,
    /// Edges of triangles.
    pub edges: usize,
    /// Triangles.
    pub triangles: usize,
    /// Parts that hang together.
    pub parts: usize,
    /// Edges with a triangle on one side only.
    pub open_edges: usize,
    /// Points around which the triangles do not make one fan, or that no triangle has.
    pub flawed_points: usize,
    /// Which these are.
    pub flaws: Vec<bool>,
}

/// A corner: its point, the next in its triangle, and the one after.
type Corner = [u32; 3];

impl Census {
    /// Counts. The mesh must have passed [`Mesh::check`].
    pub fn of(mesh: &Mesh) -> Census {
        let turns = |[a, b, c]: &Corner| [[*a, *b, *c], [*b, *c, *a], [*c, *a, *b]];
        let mut corners: Vec<Corner> = mesh.triangles.par_iter().flat_map_iter(turns).collect();
        corners.par_sort_unstable();
        let mut start = vec![0; mesh.points.len() + 1];
        corners.iter().for_each(|c| start[c[0] as usize + 1] += 1);
        for i in 1..start.len() {
            start[i] += start[i - 1];
        }
        let around = |point: u32| &corners[start[point as usize]..start[point as usize + 1]];
        let flaws: Vec<bool> = (0..mesh.points.len() as u32).map(|p| !is_fan(around(p))).collect();
        let has = |from: u32, to: u32| around(from).binary_search_by_key(&to, |c| c[1]).is_ok();
        let open_edges = corners.iter().filter(|[a, b, _]| !has(*b, *a)).count();
        Census {
            points: (0..mesh.points.len() as u32).filter(|p| !around(*p).is_empty()).count(),
            edges: (corners.len() + open_edges) / 2,
            triangles: mesh.triangles.len(),
            parts: Parts::of(mesh).count(),
            open_edges,
            flawed_points: flaws.iter().filter(|flawed| **flawed).count(),
            flaws,
        }
    }

    /// Whether the mesh is closed, oriented and a manifold.
    pub fn is_closed_manifold(&self) -> bool {
        self.flawed_points == 0
    }

    /// Points minus edges plus triangles: twice the number of parts, less two for each handle of a closed surface.
    pub fn euler_characteristic(&self) -> i64 {
        self.points as i64 - self.edges as i64 + self.triangles as i64
    }
}

/// Whether the corners at a point, in the order of their next points, go round it once.
fn is_fan(corners: &[Corner]) -> bool {
    let Some(first) = corners.first() else { return false };
    let is_repeated = corners.windows(2).any(|pair| pair[0][1] == pair[1][1]);
    let (mut at, mut steps) = (first[2], 1);
    while at != first[1] && steps < corners.len() {
        let Ok(next) = corners.binary_search_by_key(&at, |c| c[1]) else { return false };
        at = corners[next][2];
        steps += 1;
    }
    !is_repeated && at == first[1] && steps == corners.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

    fn mesh(points: usize, triangles: &[[u32; 3]]) -> Mesh {
        Mesh { points: vec![DVec3::ZERO; points], triangles: triangles.to_vec(), ..Mesh::default() }
    }

    #[test]
    fn a_tetrahedron_is_a_sphere() {
        let census = Census::of(&mesh(4, &TETRAHEDRON));
        assert!(census.is_closed_manifold());
        assert_eq!((census.euler_characteristic(), census.parts, census.edges), (2, 1, 6));
    }

    #[test]
    fn flaws_are_found() {
        let open = Census::of(&mesh(4, &TETRAHEDRON[1..]));
        assert_eq!((open.open_edges, open.flawed_points, open.euler_characteristic()), (3, 3, 1));
        // Two that touch in a point.
        let other = TETRAHEDRON.map(|t| t.map(|i| if i == 0 { 0 } else { i + 3 }));
        let touching = Census::of(&mesh(7, &[TETRAHEDRON, other].concat()));
        assert_eq!((touching.open_edges, touching.parts), (0, 1));
        assert_eq!(touching.flaws.iter().position(|f| *f), Some(0));
        assert_eq!(touching.flawed_points, 1);
        // One turned inside out.
        let mut turned = TETRAHEDRON;
        turned[0].swap(0, 1);
        assert!(!Census::of(&mesh(4, &turned)).is_closed_manifold());
        // A point that nothing has.
        assert_eq!(Census::of(&mesh(5, &TETRAHEDRON)).flawed_points, 1);
        assert_eq!(Census::of(&Mesh::default()), Census::default());
    }
}
