//! Makes `scripts/knot.obj`, a rope in a trefoil knot: `cargo run --release --example knot > scripts/knot.obj`.
//!
//! It shows how a mesh is made in Rust and written to a file.

use glam::DVec3;
use orogen::exchange::mesh::{Format, write};
use orogen::shape::Mesh;
use std::f64::consts::TAU;
use std::io;

/// Corners along the rope and around it.
const SIZE: [u32; 2] = [132, 14];

/// The middle of the rope, once around for `t` from 0 to 1.
fn middle(t: f64) -> DVec3 {
    let (a, b) = (2.0 * TAU * t, 3.0 * TAU * t);
    let radius = 2.0 + libm::cos(b);
    DVec3::new(radius * libm::cos(a), 1.1 * libm::sin(b), radius * libm::sin(a))
}

/// A point of the surface: `s` goes around the rope, whose five strands wind around it.
fn point(t: f64, s: f64) -> DVec3 {
    let along = (middle(t + 1e-4) - middle(t - 1e-4)).normalize();
    let across = along.cross(DVec3::Y).normalize();
    let up = across.cross(along);
    let radius = 0.52 + 0.07 * libm::cos(5.0 * TAU * s + 12.0 * TAU * t);
    let p = middle(t) + radius * (across * libm::cos(TAU * s) + up * libm::sin(TAU * s));
    // Four digits are plenty, and a short file.
    (p * 1e4).round() / 1e4
}

fn main() -> io::Result<()> {
    let [n, m] = SIZE;
    let mut mesh = Mesh::default();
    for i in 0..n {
        for j in 0..m {
            mesh.points.push(point(f64::from(i) / f64::from(n), f64::from(j) / f64::from(m)));
            let corner = |i: u32, j: u32| (i % n) * m + j % m;
            let (a, b, c, d) = (corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let format = Format::of("knot.obj").map_err(io::Error::other)?;
    write(format, &mesh, &mut io::stdout().lock())
}
