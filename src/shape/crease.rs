//! Edges that look sharp.
//!
//! Programs that show a mesh blend the normals of points over its triangles. At a sharp edge that smears
//! both sides into each other, unless each side has points of its own there, at the same place but with
//! another normal. So the triangles around a point are taken apart into groups, within which one leads to
//! the next across edges that are not sharp; each group but the first gets a copy of the point.

use super::Mesh;
use glam::DVec3;

/// The same surface, with points doubled along edges where the normals of the triangles differ by more than
/// so many degrees, and around triangles without area, which have none. It has holes in name only: copies of a
/// point have its place, bit for bit.
pub fn creased(mesh: &Mesh, degrees: f64) -> Mesh {
    let normals: Vec<DVec3> = (0..mesh.triangles.len()).map(|t| normal(mesh, t)).collect();
    let least = libm::cos(degrees.to_radians());
    let mut creased = mesh.clone();
    for (point, fan) in fans(mesh).into_iter().enumerate() {
        let is_smooth = |a: usize, b: usize| {
            let (a, b) = (normals[fan[a] / 3], normals[fan[b] / 3]);
            a.dot(b).clamp(-1.0, 1.0) >= least
        };
        let groups = groups(mesh, &fan, is_smooth);
        let is_split = groups.iter().any(|group| *group != 0);
        for group in (0..fan.len()).filter(|group| is_split && groups.contains(group)) {
            let own: Vec<usize> = (0..fan.len()).filter(|i| groups[*i] == group).map(|i| fan[i]).collect();
            let number = if group == 0 { point } else { copy(&mut creased, point) };
            own.iter().for_each(|corner| creased.triangles[corner / 3][corner % 3] = number as u32);
            if let Some(n) = creased.normals.get_mut(number) {
                let sum: DVec3 = own.iter().map(|corner| angle(mesh, *corner) * normals[corner / 3]).sum();
                *n = sum.try_normalize().unwrap_or(*n);
            }
        }
    }
    creased
}

/// The unit normal of a triangle; zero if it has no area.
fn normal(mesh: &Mesh, triangle: usize) -> DVec3 {
    let [a, b, c] = mesh.corners(triangle);
    (b - a).cross(c - a).normalize_or_zero()
}

/// The angle at a corner, in radians.
fn angle(mesh: &Mesh, corner: usize) -> f64 {
    let p = mesh.corners(corner / 3);
    let [a, b, c] = std::array::from_fn(|k| p[(corner % 3 + k) % 3]);
    let (u, v) = (b - a, c - a);
    libm::atan2(u.cross(v).length(), u.dot(v))
}

/// The corners at each point: three times the number of the triangle, and which of its corners it is.
fn fans(mesh: &Mesh) -> Vec<Vec<usize>> {
    let mut fans = vec![Vec::new(); mesh.points.len()];
    for (corner, point) in mesh.triangles.as_flattened().iter().enumerate() {
        fans[*point as usize].push(corner);
    }
    fans
}

/// Which group each corner of a fan belongs to, by the first corner of the group.
fn groups(mesh: &Mesh, fan: &[usize], is_smooth: impl Fn(usize, usize) -> bool) -> Vec<usize> {
    // The two other points of the triangle.
    let others = |i: usize| [1, 2].map(|k| mesh.triangles[fan[i] / 3][(fan[i] % 3 + k) % 3]);
    let mut group: Vec<usize> = (0..fan.len()).collect();
    for i in 0..fan.len() {
        for j in 0..i {
            let is_joined = others(i).iter().any(|p| others(j).contains(p)) && is_smooth(i, j);
            let (from, to) = (group[i].max(group[j]), group[i].min(group[j]));
            if is_joined && from != to {
                group.iter_mut().filter(|g| **g == from).for_each(|g| *g = to);
            }
        }
    }
    group
}

/// Adds a copy of a point, and says its number.
fn copy(mesh: &mut Mesh, point: usize) -> usize {
    mesh.points.push(mesh.points[point]);
    if let Some(normal) = mesh.normals.get(point).copied() {
        mesh.normals.push(normal);
    }
    if let Some(color) = mesh.colors.get(point).copied() {
        mesh.colors.push(color);
    }
    mesh.points.len() - 1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube of two triangles a side.
    fn cube() -> Mesh {
        let points: Vec<DVec3> =
            (0..8).map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2))).collect();
        let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        let normals = points.iter().map(|p| (*p - 0.5).normalize()).collect();
        Mesh { points, triangles, normals, colors: vec![[0.5; 3]; 8] }
    }

    #[test]
    fn a_cube_has_three_points_at_each_corner() {
        let creased = creased(&cube(), 30.0);
        assert_eq!((creased.points.len(), creased.check()), (24, Ok(())));
        for t in 0..creased.triangles.len() {
            let flat = normal(&creased, t);
            assert_eq!(creased.corners(t), cube().corners(t));
            assert!(creased.triangles[t].iter().all(|i| creased.normals[*i as usize].distance(flat) < 1e-12));
        }
    }

    #[test]
    fn what_is_smooth_stays_as_it_is() {
        assert_eq!(creased(&cube(), 100.0), cube());
    }
}
