//! Symmetric 3x3 matrices as six numbers xx, yy, zz, xy, xz, yz.

use crate::num::spectral;
use glam::{DMat3, DVec3};

/// The matrix.
pub fn matrix([xx, yy, zz, xy, xz, yz]: [f64; 6]) -> DMat3 {
    DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz])
}

/// Eigenvalues in increasing order with unit eigenvectors, by Jacobi's rotations: each makes one entry beside the
/// diagonal zero, and the squares of these shrink until rounding is all that is left.
pub fn eigen(h: [f64; 6]) -> ([f64; 3], [DVec3; 3]) {
    let (mut a, mut v) = (matrix(h), DMat3::IDENTITY);
    let off = |a: &DMat3| a.y_axis.x.abs() + a.z_axis.x.abs() + a.z_axis.y.abs();
    let size = a.x_axis.x.abs() + a.y_axis.y.abs() + a.z_axis.z.abs() + off(&a);
    for _ in 0..24 {
        let left = off(&a);
        if left <= 1e-16 * size || left.is_nan() {
            break;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let apq = a.col(q)[p];
            if apq == 0.0 {
                continue;
            }
            let theta = (a.col(q)[q] - a.col(p)[p]) / (2.0 * apq);
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let mut turn = DMat3::IDENTITY;
            turn.col_mut(p)[p] = c;
            turn.col_mut(q)[q] = c;
            turn.col_mut(q)[p] = t * c;
            turn.col_mut(p)[q] = -t * c;
            a = turn.transpose() * a * turn;
            v *= turn;
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| a.col(i)[i].total_cmp(&a.col(j)[j]));
    (order.map(|i| a.col(i)[i]), order.map(|i| v.col(i)))
}

/// The smallest eigenvalue, to half of all digits at least: a root of the characteristic polynomial by cosines
/// (Smith 1961). It is much quicker to have than all of them with their vectors.
pub fn least_eigenvalue([xx, yy, zz, xy, xz, yz]: [f64; 6]) -> f64 {
    let mean = (xx + yy + zz) / 3.0;
    let (a, b, c) = (xx - mean, yy - mean, zz - mean);
    let off = xy * xy + xz * xz + yz * yz;
    let size = ((a * a + b * b + c * c + 2.0 * off) / 6.0).sqrt();
    if size == 0.0 {
        return mean;
    }
    let determinant = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz);
    mean + size * least_root((0.5 * determinant / (size * size * size)).clamp(-1.0, 1.0))
}

/// The least root of `t^3 - 3 t - 2 cos a`, which is `2 cos(a/3 + 2 pi/3)`, from the cosine.
///
/// It is analytic in `s = sin(a/2)`: a polynomial, fitted for `0 <= s <= 1` by least squares, has it to 3e-11, which takes a
/// fraction of the time of an arc cosine and a cosine. Even and odd powers are summed side by side.
fn least_root(cosine: f64) -> f64 {
    const EVEN: [f64; 6] = [
        -1.000_000_000_02,
        0.222_221_910_895,
        0.065_781_327_040_3,
        0.032_611_760_456_7,
        0.013_477_184_634_9,
        0.001_806_534_098_17,
    ];
    const ODD: [f64; 6] = [
        -1.154_700_532_09,
        -0.106_910_626_708,
        -0.045_353_974_237_4,
        -0.022_547_826_204_4,
        -0.006_134_499_726_89,
        -0.000_251_258_150_214,
    ];
    let square = 0.5 - 0.5 * cosine;
    let sum = |k: [f64; 6]| k.iter().rev().fold(0.0, |sum, k| sum * square + k);
    sum(EVEN) + square.sqrt() * sum(ODD)
}

/// What was computed as the inverse `Y` of a matrix `H`, and what is certain of both.
#[derive(Clone, Copy, Debug)]
pub struct Inverse {
    /// `Y`
    pub entries: [f64; 6],
    /// Bound on its spectral norm.
    pub norm: f64,
    /// Bound on that of `I - Y H`.
    pub defect: f64,
    /// Lower bound on the smallest absolute eigenvalue of `H`; not positive where the inverse is none.
    pub least: f64,
}

/// The inverse, by cofactors. Where `|I - Y H| <= e < 1`, the smallest singular value of `H` is at least `(1 - e) / |Y|`.
#[inline(always)]
pub fn inverse(h: [f64; 6]) -> Inverse {
    let [xx, yy, zz, xy, xz, yz] = h;
    let [a, b, c] = [yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy];
    let over = 1.0 / (xx * a + xy * b + xz * c);
    let (d, e, f) = (xx * zz - xz * xz, xx * yy - xy * xy, xy * xz - xx * yz);
    let y = [a * over, d * over, e * over, b * over, c * over, f * over];
    let norm = spectral(y);
    let (of, by, mut square) = (rows(h), rows(y), 0.0);
    for i in 0..3 {
        for j in 0..3 {
            let one = if i == j { 1.0 } else { 0.0 };
            let off = one - (by[i][0] * of[0][j] + by[i][1] * of[1][j] + by[i][2] * of[2][j]);
            square += off * off;
        }
    }
    // Products of three with sums of three, and the norms of both, are off by less than this.
    let rounding = 32.0 * f64::EPSILON * norm * spectral(h);
    let defect = square.sqrt() * (1.0 + 1e-14) + rounding;
    let least = (1.0 - defect) / norm * (1.0 - 1e-14);
    let exists = (least > 0.0) & (least < f64::INFINITY);
    Inverse { entries: y, norm, defect, least: if exists { least } else { 0.0 } }
}

impl Inverse {
    /// Whether there is an inverse.
    #[inline(always)]
    pub fn exists(&self) -> bool {
        self.least > 0.0
    }

    /// `Y g`
    #[inline(always)]
    pub fn times(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [a, b, c] = rows(self.entries);
        [a[0] * x + a[1] * y + a[2] * z, b[0] * x + b[1] * y + b[2] * z, c[0] * x + c[1] * y + c[2] * z]
    }
}

/// The rows of the matrix, which are its columns.
#[inline(always)]
pub fn rows([xx, yy, zz, xy, xz, yz]: [f64; 6]) -> [[f64; 3]; 3] {
    [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    #[test]
    fn eigenvectors_make_the_matrix_diagonal() {
        let mut rng = StdRng::seed_from_u64(3);
        for _ in 0..200 {
            let h: [f64; 6] = std::array::from_fn(|_| rng.random_range(-2.0..2.0));
            let (values, vectors) = eigen(h);
            assert!(values[0] <= values[1] && values[1] <= values[2]);
            assert!((least_eigenvalue(h) - values[0]).abs() < 1e-9);
            for (value, vector) in values.into_iter().zip(vectors) {
                assert!((matrix(h) * vector - value * vector).length() < 1e-13);
                assert!((vector.length() - 1.0).abs() < 1e-14);
            }
            let (known, sizes) = (inverse(h), values.map(f64::abs));
            let least = sizes.into_iter().fold(f64::INFINITY, f64::min);
            assert!(known.exists() && known.least <= least * (1.0 + 1e-9));
            assert!(known.norm >= (1.0 - 1e-9) / least && known.norm < 1.8 / least, "{h:?}");
            let [x, y, z] = known.times((matrix(h) * DVec3::new(1.0, 2.0, 3.0)).to_array());
            let missed = DVec3::new(x, y, z).distance(DVec3::new(1.0, 2.0, 3.0));
            assert!(missed < 4.0 * known.defect && known.defect < 1e-9, "{h:?}");
        }
    }

    #[test]
    fn the_least_root_is_that_of_cosines() {
        for i in -1000..=1000 {
            let cosine = f64::from(i) / 1000.0;
            let root = 2.0 * libm::cos((libm::acos(cosine) + std::f64::consts::TAU) / 3.0);
            assert!((least_root(cosine) - root).abs() < 3e-11, "{cosine}");
        }
    }

    #[test]
    fn singular_matrices_have_no_inverse() {
        for h in [[1.0, 1.0, 0.0, 1.0, 0.0, 0.0], [0.0; 6], [f64::NAN; 6], [f64::INFINITY; 6]] {
            assert!(!inverse(h).exists(), "{h:?}");
        }
        for hole in 0..6 {
            let mut h = [1.0, 2.0, 3.0, 0.1, 0.2, 0.3];
            assert!(inverse(h).exists());
            h[hole] = f64::NAN;
            assert!(!inverse(h).exists(), "{hole}");
        }
    }
}
