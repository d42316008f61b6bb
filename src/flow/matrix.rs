//! Matrices of three rows, and bounds on what they do to lengths.

use super::pack::Pack;
use crate::num::ROUNDOFF;

/// Vectors.
pub(super) type Vector = [Pack; 3];

/// Matrices by rows.
pub(super) type Matrix = [[Pack; 3]; 3];

/// Symmetric matrices: xx, yy, zz, xy, xz, yz.
pub(super) type Symmetric = [Pack; 6];

pub(super) const ONE: Matrix = {
    let (zero, one) = (Pack::ZERO, Pack::ONE);
    [[one, zero, zero], [zero, one, zero], [zero, zero, one]]
};

/// Covers the rounding of sums of up to a hundred terms that are not negative.
pub(super) const UP: f64 = 1.0 + 256.0 * ROUNDOFF;

// Entries are written out one by one. Of loops over them the compiler would make vectors across entries, which it must
// gather, instead of vectors across balls.

/// A vector by its entries.
#[inline(always)]
pub(super) fn vector(entry: impl Fn(usize) -> Pack) -> Vector {
    [entry(0), entry(1), entry(2)]
}

/// A matrix by its entries.
#[inline(always)]
pub(super) fn matrix(entry: impl Fn(usize, usize) -> Pack) -> Matrix {
    [
        [entry(0, 0), entry(0, 1), entry(0, 2)],
        [entry(1, 0), entry(1, 1), entry(1, 2)],
        [entry(2, 0), entry(2, 1), entry(2, 2)],
    ]
}

/// A symmetric matrix by its entries.
#[inline(always)]
pub(super) fn symmetric(entry: impl Fn(usize, usize) -> Pack) -> Symmetric {
    [entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)]
}

/// Six numbers of symmetric matrices one by one.
#[inline(always)]
pub(super) fn six(number: impl Fn(usize) -> Pack) -> Symmetric {
    [number(0), number(1), number(2), number(3), number(4), number(5)]
}

/// `a b`.
#[inline(always)]
pub(super) fn times(a: &Matrix, b: &Matrix) -> Matrix {
    matrix(
        #[inline(always)]
        |i, j| a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j],
    )
}

/// `m^T v`.
#[inline(always)]
pub(super) fn transposed_times(m: &Matrix, v: &Vector) -> Vector {
    vector(
        #[inline(always)]
        |j| m[0][j] * v[0] + m[1][j] * v[1] + m[2][j] * v[2],
    )
}

/// `m^T s m`.
#[inline(always)]
pub(super) fn congruent(m: &Matrix, [xx, yy, zz, xy, xz, yz]: &Symmetric) -> Symmetric {
    let s = times(&[[*xx, *xy, *xz], [*xy, *yy, *yz], [*xz, *yz, *zz]], m);
    symmetric(
        #[inline(always)]
        |i, j| m[0][i] * s[0][j] + m[1][i] * s[1][j] + m[2][i] * s[2][j],
    )
}

/// Length, rounded up.
#[inline(always)]
pub(super) fn length([x, y, z]: &Vector) -> Pack {
    UP * (*x * *x + *y * *y + *z * *z).sqrt()
}

/// Bound on the spectral norm: the root of the largest eigenvalue of `A A^T`.
#[inline(always)]
pub(super) fn norm(a: &Matrix) -> Pack {
    let square = symmetric(
        #[inline(always)]
        |i, j| a[i][0] * a[j][0] + a[i][1] * a[j][1] + a[i][2] * a[j][2],
    );
    let trace = square[0] + square[1] + square[2];
    // Rounding of the entries.
    UP * (UP * (largest(&square).larger(Pack::ZERO) + 32.0 * ROUNDOFF * trace)).sqrt()
}

/// The largest eigenvalue of a symmetric matrix, from above. With `m` the mean of the three, and `x = m + t`, they are the
/// roots of `t^3 - s t - d`, of which none lies above the start; from there Newton's method comes down towards the largest
/// and never passes it, since the cubic is convex there.
#[inline(always)]
pub(super) fn largest(a: &Symmetric) -> Pack {
    let m = 1.0 / 3.0 * (a[0] + a[1] + a[2]);
    let [xx, yy, zz] = [a[0] - m, a[1] - m, a[2] - m];
    let [xy, xz, yz] = [a[3], a[4], a[5]];
    let s = 0.5 * (xx * xx + yy * yy + zz * zz) + xy * xy + xz * xz + yz * yz;
    let d = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
    let start = (4.0 / 3.0 * s).sqrt();
    let mut t = start;
    for _ in 0..3 {
        t = t - ((t * t - s) * t - d).positive_quotient(3.0 * (t * t) - s);
    }
    // Rounding of the entries, of the cubic and of what is found from it.
    m + t + 256.0 * ROUNDOFF * (start + m.abs())
}

/// Bound on the spectral norm of a symmetric matrix, by the sum of the fourth powers of its eigenvalues, which is
/// the sum of squares of its square.
#[inline(always)]
pub(super) fn spread(s: &Symmetric) -> Pack {
    let [xx, yy, zz, xy, xz, yz] = *s;
    let own = [xx * xx + xy * xy + xz * xz, xy * xy + yy * yy + yz * yz, xz * xz + yz * yz + zz * zz];
    let mixed = [xx * xy + xy * yy + xz * yz, xx * xz + xy * yz + xz * zz, xy * xz + yy * yz + yz * zz];
    let sum = |v: &Vector| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    // What is so small that its fourth power is zero counts as well.
    UP * (sum(&own) + 2.0 * sum(&mixed)).sqrt().sqrt() + 1e-70 * Pack::ONE
}
