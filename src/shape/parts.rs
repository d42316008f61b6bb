//! Parts of a mesh: what hangs together by edges or points.

use super::Mesh;

/// Which part each point belongs to.
#[derive(Clone, Debug, PartialEq)]
pub struct Parts {
    /// Its number; none of points that no triangle has.
    of: Vec<Option<u32>>,
    /// How many there are.
    count: usize,
}

impl Parts {
    /// Of a mesh that has passed [`Mesh::check`], numbered in the order of their first points.
    pub fn of(mesh: &Mesh) -> Parts {
        let mut above: Vec<u32> = (0..mesh.points.len() as u32).collect();
        let mut is_used = vec![false; mesh.points.len()];
        for [a, b, c] in &mesh.triangles {
            [a, b, c].into_iter().for_each(|i| is_used[*i as usize] = true);
            for other in [b, c] {
                let (x, y) = (root(&mut above, *a), root(&mut above, *other));
                above[x.max(y) as usize] = x.min(y);
            }
        }
        let (mut of, mut count) = (vec![None; above.len()], 0);
        for i in (0..above.len()).filter(|&i| is_used[i]) {
            // The least point of a part comes first.
            let least = root(&mut above, i as u32) as usize;
            if least == i {
                of[i] = Some(count);
                count += 1;
            }
            of[i] = of[least];
        }
        Parts { of, count: count as usize }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The points of each part, in order.
    pub fn points(&self) -> Vec<Vec<u32>> {
        let mut points = vec![Vec::new(); self.count];
        for (i, part) in self.of.iter().enumerate() {
            part.iter().for_each(|part| points[*part as usize].push(i as u32));
        }
        points
    }

    /// The volume within each part, below zero where its outside is within: the surface of a void.
    pub fn volumes(&self, mesh: &Mesh) -> Vec<f64> {
        let mut volumes = vec![0.0; self.count];
        // Seen from a point of the part, since what is far from the origin would be lost in rounding.
        let mut from = vec![None; self.count];
        for (i, [a, ..]) in mesh.triangles.iter().enumerate() {
            let [p, q, r] = mesh.corners(i);
            if let Some(part) = self.of[*a as usize] {
                let from = *from[part as usize].get_or_insert(p);
                volumes[part as usize] += (p - from).dot((q - from).cross(r - from)) / 6.0;
            }
        }
        volumes
    }

    /// The mesh without some of its parts.
    pub fn without(&self, mesh: &Mesh, is_left_out: &[bool]) -> Mesh {
        let stays = |point: usize| self.of[point].is_some_and(|part| !is_left_out[part as usize]);
        let stay: Vec<usize> = (0..mesh.points.len()).filter(|i| stays(*i)).collect();
        let mut number = vec![0; mesh.points.len()];
        stay.iter().enumerate().for_each(|(new, old)| number[*old] = new as u32);
        let triangles = mesh.triangles.iter().filter(|t| stays(t[0] as usize));
        Mesh {
            points: stay.iter().map(|i| mesh.points[*i]).collect(),
            triangles: triangles.map(|t| t.map(|i| number[i as usize])).collect(),
            normals: stay.iter().filter_map(|i| mesh.normals.get(*i).copied()).collect(),
            colors: stay.iter().filter_map(|i| mesh.colors.get(*i).copied()).collect(),
        }
    }
}

/// The least point that hangs together with one; paths are halved on the way.
fn root(above: &mut [u32], mut at: u32) -> u32 {
    while above[at as usize] != at {
        above[at as usize] = above[above[at as usize] as usize];
        at = above[at as usize];
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// A tetrahedron on the axes, or what is around it.
    fn corner(is_void: bool) -> Mesh {
        let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let turned = |[a, b, c]: [u32; 3]| if is_void { [a, c, b] } else { [a, b, c] };
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        Mesh { points, triangles: triangles.map(turned).to_vec(), ..Mesh::default() }
    }

    #[test]
    fn parts_are_told_apart_and_left_out() {
        // A point that nothing has, and two tetrahedra whose points alternate.
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let triangles = faces.iter().flat_map(|t| [t.map(|i| 2 * i + 1), t.map(|i| 2 * i + 2)]).collect();
        let mesh = Mesh {
            points: (0..9).map(|i| DVec3::splat(f64::from(i))).collect(),
            triangles,
            normals: Vec::new(),
            colors: (0..9).map(|i| [i as f32; 3]).collect(),
        };
        let parts = Parts::of(&mesh);
        assert_eq!((parts.count(), parts.points()), (2, vec![vec![1, 3, 5, 7], vec![2, 4, 6, 8]]));
        let second = parts.without(&mesh, &[true, false]);
        assert_eq!(second.triangles, faces);
        assert_eq!(second.points, [2.0, 4.0, 6.0, 8.0].map(DVec3::splat));
        assert_eq!(second.colors, [2.0, 4.0, 6.0, 8.0].map(|c| [c; 3]));
        assert_eq!(second.check(), Ok(()));
        assert_eq!(Parts::of(&second).count(), 1);
        assert_eq!(Parts::of(&second).volumes(&corner(false)), [1.0 / 6.0]);
        assert_eq!(Parts::of(&second).volumes(&corner(true)), [-1.0 / 6.0]);
        let mut far = corner(true);
        far.points.iter_mut().for_each(|p| *p = 0.125 * *p + 6.0e9);
        assert_eq!(Parts::of(&far).volumes(&far), [-1.0 / 6.0 / 512.0]);
        assert_eq!(parts.without(&mesh, &[true, true]), Mesh::default());
    }
}
