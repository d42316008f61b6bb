//! Where the planes of a surface meet.
//!
//! A vertex lies where the sum of squared distances from tangent planes is least (Garland and Heckbert 1997;
//! Ju, Losasso, Schaefer and Warren 2002): on a flat piece anywhere on the plane, on an edge of the solid on
//! the edge, at a corner in the corner. Directions in which the planes say nothing keep the mean of the points.

use crate::scene::Aabb;
use glam::{DMat3, DVec3};

/// The sum over planes `n . (x - p) = 0` of `(n . (x - p))^2`, and the sum of the points `p`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Quadric {
    /// Sum of `n n^T`: xx, yy, zz, xy, xz, yz.
    square: [f64; 6],
    /// Sum of `n (n . p)`.
    linear: DVec3,
    /// Sum of `(n . p)^2`.
    constant: f64,
    /// Sum of `p`.
    points: DVec3,
    count: f64,
}

/// Directions whose share of the largest is smaller say nothing. (The usual choice: noise in the normals of a
/// nearly flat piece must not throw the vertex far off.)
const VAGUE: f64 = 0.05;

/// The share of an edge of the solid in a box that is kept free at either end: the next box has the same edge, and two
/// vertices at the place where it passes from one to the other would be one.
const INSET: f64 = 1.0 / 16.0;

impl Quadric {
    /// Adds a plane through `p` with the unit normal `n`.
    pub fn add(&mut self, p: DVec3, n: DVec3) {
        let d = n.dot(p);
        let products = [n.x * n.x, n.y * n.y, n.z * n.z, n.x * n.y, n.x * n.z, n.y * n.z];
        self.square.iter_mut().zip(products).for_each(|(sum, x)| *sum += x);
        self.linear += n * d;
        self.constant += d * d;
        self.points += p;
        self.count += 1.0;
    }

    /// Adds the planes of another.
    pub fn join(&mut self, other: &Quadric) {
        self.square.iter_mut().zip(other.square).for_each(|(sum, x)| *sum += x);
        self.linear += other.linear;
        self.constant += other.constant;
        self.points += other.points;
        self.count += other.count;
    }

    /// Mean of the points.
    pub fn mean(&self) -> DVec3 {
        self.points / self.count
    }

    fn times(&self, x: DVec3) -> DVec3 {
        let [xx, yy, zz, xy, xz, yz] = self.square;
        DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]) * x
    }

    /// The root of the mean square distance of a point from the planes.
    pub fn distance(&self, x: DVec3) -> f64 {
        let sum = x.dot(self.times(x)) - 2.0 * x.dot(self.linear) + self.constant;
        (sum.max(0.0) / self.count).sqrt()
    }

    /// The point of least distance within a box around the mean: the nearest to the mean where there are many, and on
    /// the way to it from the mean where there is none.
    pub fn least_within(&self, lo: DVec3, hi: DVec3) -> DVec3 {
        let mean = self.mean();
        let rest = self.linear - self.times(mean);
        let (values, vectors) = eigen(self.square);
        let largest = values.into_iter().fold(0.0, f64::max);
        let is_told = values.map(|value| value > VAGUE * largest);
        let told = (0..3).filter(|&k| is_told[k]);
        let way: DVec3 = told.clone().map(|k| vectors[k] * (vectors[k].dot(rest) / values[k])).sum();
        let region = Aabb { min: lo, max: hi };
        if told.count() == 2 {
            // An edge of the solid, which may pass the box though its point next to the mean does not.
            let along = (0..3).find(|&k| !is_told[k]).map_or(DVec3::ZERO, |k| vectors[k]);
            let ends = region.clip(mean + way, along);
            if let Some((near, far)) = ends.filter(|(near, far)| (far - near).is_finite()) {
                let free = INSET * (far - near);
                return (mean + way + along * 0.0_f64.clamp(near + free, far - free)).clamp(lo, hi);
            }
        }
        let share = region.clip(mean, way).map_or(0.0, |(_, far)| far.min(1.0));
        (mean + way * share).clamp(lo, hi)
    }
}

/// Eigenvalues and unit eigenvectors of a symmetric matrix (xx, yy, zz, xy, xz, yz) by Jacobi's rotations.
fn eigen([xx, yy, zz, xy, xz, yz]: [f64; 6]) -> ([f64; 3], [DVec3; 3]) {
    let mut a = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    let mut v = [DVec3::X, DVec3::Y, DVec3::Z];
    let scale = xx + yy + zz;
    // Each sweep squares what is left off the diagonal; six are enough from anywhere.
    for _ in 0..6 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q].abs() <= 1e-15 * scale {
                continue;
            }
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            let r = 3 - p - q;
            let (pr, qr) = (a[p][r], a[q][r]);
            a[p][p] -= t * a[p][q];
            a[q][q] += t * a[p][q];
            (a[p][q], a[q][p]) = (0.0, 0.0);
            (a[p][r], a[q][r]) = (c * pr - s * qr, s * pr + c * qr);
            (a[r][p], a[r][q]) = (a[p][r], a[q][r]);
            (v[p], v[q]) = (v[p] * c - v[q] * s, v[p] * s + v[q] * c);
        }
    }
    ([a[0][0], a[1][1], a[2][2]], v)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_meet_where_they_do() {
        let corner = DVec3::new(0.3, -0.2, 0.7);
        let planes = [DVec3::X, DVec3::new(0.0, 0.6, 0.8), DVec3::new(0.6, 0.0, -0.8)];
        let mut quadric = Quadric::default();
        for n in planes {
            quadric.add(corner + n.any_orthogonal_vector() * 0.4, n);
        }
        let least = quadric.least_within(corner - 9.0, corner + 9.0);
        assert!(least.distance(corner) < 1e-12 && quadric.distance(corner) < 1e-7);
        assert!((quadric.distance(corner + DVec3::X) - (1.36_f64 / 3.0).sqrt()).abs() < 1e-7);
        let half = DVec3::splat(0.05);
        let near = quadric.least_within(quadric.mean() - half, quadric.mean() + half);
        assert!((near - quadric.mean()).abs().max_element() <= 0.05 + 1e-15);
    }

    #[test]
    fn what_planes_do_not_say_is_the_mean() {
        let mut quadric = Quadric::default();
        for p in [DVec3::ZERO, DVec3::X, DVec3::Y] {
            quadric.add(p, DVec3::Z);
        }
        let least = quadric.least_within(DVec3::ZERO, DVec3::ONE);
        assert!(least.distance(DVec3::new(1.0, 1.0, 0.0) / 3.0) < 1e-12);
    }

    #[test]
    fn edges_stay_edges_where_they_leave_the_box() {
        // The edge x = 0.2 - z, y = 0.9 leaves the unit box below its middle.
        let mut quadric = Quadric::default();
        for p in [DVec3::new(0.1, 0.5, 0.1), DVec3::new(0.2, 0.1, 0.0)] {
            quadric.add(p, DVec3::new(1.0, 0.0, 1.0).normalize());
        }
        quadric.add(DVec3::new(0.9, 0.9, 0.9), DVec3::Y);
        let at = quadric.least_within(DVec3::ZERO, DVec3::ONE);
        assert!((at.x + at.z - 0.2).abs() < 1e-12 && (at.y - 0.9).abs() < 1e-12, "{at}");
        // Not where they leave it: the next box has a vertex on the rest of the same edge.
        assert!(at.min_element() > 0.01, "{at}");
    }

    #[test]
    fn eigenvectors_make_up_the_matrix() {
        let m = [2.0, 0.5, -1.0, 0.3, 0.9, -0.4];
        let (values, vectors) = eigen(m);
        for (axis, row) in
            [[m[0], m[3], m[4]], [m[3], m[1], m[5]], [m[4], m[5], m[2]]].into_iter().enumerate()
        {
            let back: DVec3 = (0..3).map(|k| vectors[k] * vectors[k][axis] * values[k]).sum();
            assert!(back.distance(DVec3::from_array(row)) < 1e-12, "{back} {row:?}");
        }
    }
}
