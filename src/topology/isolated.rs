//! Minima and maxima that no Hessian tells of: the tip of a cone, as a sphere has in its centre, and flat ones.
//!
//! If the field rises outwards all over a small sphere, everything inside of it together is to the rest of the
//! solid what a minimum is (Poincare and Hopf: the indices of what is inside add up to one, whatever it is; and
//! the ball is connected). Likewise for a maximum. The sphere is covered by balls: in one of radius `h` about
//! `a + r n` the slope away from `a` is positive where
//!
//! ```text
//! (r / h) g . n  >  |g| + (r / h + 1) turn_0
//! ```

use super::point::{CriticalPoint, Kind};
use super::search::{Balls, LANES};
use crate::scene::Aabb;
use glam::DVec3;

/// Rows and columns of patches on a face of the cube that is blown up to the sphere, tried one after the other.
const PATCHES: [usize; 2] = [8, 24];

/// Radii that are tried, each twice the one before.
const RADII: u32 = 12;

/// A minimum or maximum that makes up all that is critical in a box, if there is a sphere around it that proves it.
pub fn isolated(field: &mut Balls, around: &Aabb) -> Option<CriticalPoint> {
    let centre = 0.5 * (around.min + around.max);
    let first = around.diagonal();
    (0..RADII).map(|k| first * f64::from(1 << k)).find_map(|radius| {
        let sides = [(1.0, Kind::Minimum), (-1.0, Kind::Maximum)];
        let (_, kind) = sides
            .into_iter()
            .find(|(sign, _)| PATCHES.iter().any(|&patches| rises(field, centre, radius, patches, *sign)))?;
        let range = field.eval(std::iter::once((centre, radius))).lane(0).range;
        Some(CriticalPoint {
            position: centre,
            error: radius,
            value: range.mid(),
            value_error: range.rad(),
            kind,
            eigenvalues: [0.0; 3],
            down: DVec3::X,
            alone: radius,
            smooth: false,
        })
    })
}

/// Whether the field, times `sign`, is proven to rise outwards all over a sphere.
fn rises(field: &mut Balls, centre: DVec3, radius: f64, patches: usize, sign: f64) -> bool {
    // Half the diagonal of a patch on the cube of half side 1; it is smaller on the sphere.
    let share = 1.01 * std::f64::consts::SQRT_2 / patches as f64;
    let places: Vec<DVec3> = normals(patches).collect();
    places.chunks(LANES).all(|normals| {
        let balls = field.eval(normals.iter().map(|n| (centre + radius * n, share * radius)));
        normals.iter().enumerate().all(|(i, n)| {
            let f = balls.lane(i);
            let g = sign * DVec3::from_array(f.grad);
            g.dot(*n) / share > (g.length() + (1.0 / share + 1.0) * f.turn[0]) * (1.0 + 1e-9)
        })
    })
}

/// The middles of so many patches along each edge of a cube's faces, blown up to the unit sphere.
fn normals(patches: usize) -> impl Iterator<Item = DVec3> {
    let at = move |i: usize| (2.0 * i as f64 + 1.0) / patches as f64 - 1.0;
    let places = (0..patches).flat_map(move |i| (0..patches).map(move |j| (at(i), at(j))));
    places.flat_map(|(u, v)| {
        [-1.0, 1.0].into_iter().flat_map(move |w| {
            [DVec3::new(u, v, w), DVec3::new(v, w, u), DVec3::new(w, u, v)].map(DVec3::normalize)
        })
    })
}
