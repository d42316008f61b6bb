//! Files of other programs: what is written comes back, and hostile files are refused.

mod gltf;
mod heights;
mod hostile;
mod memory;
mod meshes;
mod pictures;
mod round;

use glam::DVec3;
use orogen::exchange::mesh::{self, Format};
use orogen::shape::Mesh;

/// A lumpy ball of `12 n^2` triangles with normals and colours, all of its points exact in 32 bits.
fn lump(n: usize) -> Mesh {
    let mut mesh = Mesh::default();
    for face in 0..6 {
        let (axis, sign) = (face / 2, if face % 2 == 0 { 1.0 } else { -1.0 });
        let first = mesh.points.len() as u32;
        let at = |i: usize| 2.0 * i as f64 / n as f64 - 1.0;
        for j in 0..=n {
            for i in 0..=n {
                let mut p = DVec3::ZERO;
                p[axis] = sign;
                p[(axis + 1) % 3] = at(i);
                p[(axis + 2) % 3] = sign * at(j);
                let p = (p.normalize() * (1.0 + 0.1 * libm::sin(7.0 * p.x + 5.0 * p.y))).as_vec3();
                mesh.points.push(p.into());
                mesh.normals.push(p.normalize().into());
                mesh.colors.push((0.5 + 0.4 * p).into());
            }
        }
        let corner = |i: usize, j: usize| first + (j * (n + 1) + i) as u32;
        for j in 0..n {
            for i in 0..n {
                let [a, b, c, d] =
                    [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| corner(i, j));
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    mesh
}

fn written(format: Format, mesh: &Mesh) -> Vec<u8> {
    let mut bytes = Vec::new();
    mesh::write(format, mesh, &mut bytes).unwrap();
    bytes
}

/// The corners of all triangles, whatever points are called.
fn surface(mesh: &Mesh) -> Vec<[DVec3; 3]> {
    (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect()
}

/// What the reader says against a file.
#[track_caller]
fn fault(name: &str, bytes: &[u8]) -> String {
    mesh::read(name, bytes).unwrap_err().to_string()
}
