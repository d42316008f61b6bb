//! The fast Fourier transform, radix 2, of one, two or three dimensions.
//!
//! ```text
//! forward   F_k = sum_x f_x exp(-2 pi i k x / n)        inverse (unscaled)   f_x = sum_k F_k exp(+2 pi i k x / n)
//! ```
//!
//! Forward and then inverse multiplies by the number of elements. It is our own, and short, because
//! of what it must promise: the same bits on every machine. Libraries choose their algorithm by
//! processor and fuse multiplications where that is faster, and either changes the last digits.
//! Here the order of operations is fixed, and the roots of unity come from `libm`.
//!
//! The algorithm is Cooley and Tukey's (1965): elements are put in bit-reversed order, then
//! transforms of length 2, 4, 8 ... are made of pairs of those of half the length. An array of
//! several dimensions is transformed along its rows, turned so that the next axis lies along the
//! rows, and so on until every axis has had its turn. Rows do not influence one another, so the
//! number of threads changes nothing either.

use rayon::prelude::*;
use std::ops::{Add, Mul, Sub};

/// A complex number.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Complex {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
}

impl Complex {
    /// `exp(i angle)`
    #[inline]
    pub fn turn(angle: f64) -> Self {
        let (im, re) = libm::sincos(angle);
        Complex { re, im }
    }

    /// The mirror image at the real axis.
    #[inline(always)]
    pub fn conj(self) -> Self {
        Complex { re: self.re, im: -self.im }
    }

    /// `k` times the number.
    #[inline(always)]
    pub fn scale(self, k: f64) -> Self {
        Complex { re: self.re * k, im: self.im * k }
    }

    /// Square of the absolute value.
    #[inline(always)]
    pub fn norm_squared(self) -> f64 {
        self.re * self.re + self.im * self.im
    }
}

impl Add for Complex {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Complex { re: self.re + o.re, im: self.im + o.im }
    }
}

impl Sub for Complex {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Complex { re: self.re - o.re, im: self.im - o.im }
    }
}

impl Mul for Complex {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Complex { re: self.re * o.re - self.im * o.im, im: self.re * o.im + self.im * o.re }
    }
}

/// Which way a transform goes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Direction {
    /// From values to frequencies.
    Forward,
    /// From frequencies to values, without the division by the number of elements.
    Inverse,
}

/// A transform that cannot be made.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub enum Unfit {
    /// Halving does not end at 1.
    #[error("{0} is not a power of two")]
    Length(usize),
    /// The sizes of the axes do not multiply to the number of elements.
    #[error("the array has {given} elements, and its sizes multiply to {wanted}")]
    Count {
        /// Elements of the array.
        given: usize,
        /// Product of the sizes.
        wanted: usize,
    },
}

/// What transforms of one length share: the roots of unity.
#[derive(Clone, Debug)]
pub struct Fft {
    length: usize,
    /// `exp(-2 pi i k / n)` for `k < n / 2`.
    roots: Vec<Complex>,
}

impl Fft {
    /// Transforms of a length.
    ///
    /// # Errors
    /// Unless the length is a power of two.
    pub fn new(length: usize) -> Result<Self, Unfit> {
        if !length.is_power_of_two() {
            return Err(Unfit::Length(length));
        }
        let step = -std::f64::consts::TAU / length as f64;
        let roots = (0..length / 2).map(|k| Complex::turn(step * k as f64)).collect();
        Ok(Fft { length, roots })
    }

    /// Transforms a row in place. Only rows of this length are touched.
    pub fn row(&self, row: &mut [Complex], direction: Direction) {
        let n = self.length;
        if n < 2 || row.len() != n {
            return;
        }
        let shift = usize::BITS - n.trailing_zeros();
        for i in 0..n {
            let j = i.reverse_bits() >> shift;
            if i < j {
                row.swap(i, j);
            }
        }
        let mut half = 1;
        while half < n {
            let stride = n / (2 * half);
            for pair in row.chunks_exact_mut(2 * half) {
                let (low, high) = pair.split_at_mut(half);
                for k in 0..half {
                    let root = self.roots[k * stride];
                    let root = if direction == Direction::Forward { root } else { root.conj() };
                    let odd = high[k] * root;
                    high[k] = low[k] - odd;
                    low[k] = low[k] + odd;
                }
            }
            half *= 2;
        }
    }
}

/// Transforms an array of three dimensions, the first of which lies along the rows:
/// `data[(k * sizes[1] + j) * sizes[0] + i]`. Fewer dimensions have sizes of 1.
///
/// # Errors
/// Unless every size is a power of two and their product is the number of elements.
pub fn transform(data: &mut Vec<Complex>, sizes: [usize; 3], direction: Direction) -> Result<(), Unfit> {
    let wanted = sizes.iter().product();
    if data.len() != wanted {
        return Err(Unfit::Count { given: data.len(), wanted });
    }
    for size in sizes {
        if size == 1 {
            // Its rows are single elements, and turning such an array moves nothing.
            continue;
        }
        let fft = Fft::new(size)?;
        data.par_chunks_mut(size).for_each(|row| fft.row(row, direction));
        *data = turned(data, size);
    }
    Ok(())
}

/// The array with its next axis along the rows and the present one last. After as many turns as there
/// are axes it is as it was.
fn turned(data: &[Complex], row: usize) -> Vec<Complex> {
    let rows = data.len() / row;
    let mut out = vec![Complex::default(); data.len()];
    /// Rows that are written together, so that what is read of a row is used while it is at hand.
    const TOGETHER: usize = 8;
    out.par_chunks_mut(rows * TOGETHER).enumerate().for_each(|(band, part)| {
        let first = band * TOGETHER;
        for r in 0..rows {
            for (k, column) in part.chunks_exact_mut(rows).enumerate() {
                column[r] = data[r * row + first + k];
            }
        }
    });
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::mix;

    fn noise(count: usize) -> Vec<Complex> {
        let part = |i: u64| (mix(i) >> 11) as f64 / (1u64 << 52) as f64 - 1.0;
        (0..count as u64).map(|i| Complex { re: part(2 * i), im: part(2 * i + 1) }).collect()
    }

    fn distance(a: &[Complex], b: &[Complex]) -> f64 {
        a.iter().zip(b).map(|(a, b)| (*a - *b).norm_squared()).sum::<f64>().sqrt()
    }

    /// The definition.
    fn slow(data: &[Complex], [nx, ny, nz]: [usize; 3], sign: f64) -> Vec<Complex> {
        let index = |i: usize| [i % nx, i / nx % ny, i / (nx * ny)];
        (0..data.len())
            .map(|k| {
                let k = index(k);
                data.iter().enumerate().fold(Complex::default(), |sum, (x, value)| {
                    let x = index(x);
                    let turns = (k[0] * x[0]) as f64 / nx as f64
                        + (k[1] * x[1]) as f64 / ny as f64
                        + (k[2] * x[2]) as f64 / nz as f64;
                    sum + *value * Complex::turn(sign * std::f64::consts::TAU * turns)
                })
            })
            .collect()
    }

    #[test]
    fn equals_the_definition() {
        for sizes in [[1, 1, 1], [2, 1, 1], [16, 1, 1], [8, 1, 4], [4, 8, 1], [4, 2, 16], [1, 1, 32]] {
            let data = noise(sizes.iter().product());
            for (direction, sign) in [(Direction::Forward, -1.0), (Direction::Inverse, 1.0)] {
                let mut fast = data.clone();
                transform(&mut fast, sizes, direction).unwrap();
                assert!(distance(&fast, &slow(&data, sizes, sign)) < 1e-11, "{sizes:?}");
            }
        }
    }

    #[test]
    fn comes_back_and_keeps_energy() {
        let sizes = [32, 8, 64];
        let data = noise(32 * 8 * 64);
        let count = data.len() as f64;
        let mut there = data.clone();
        transform(&mut there, sizes, Direction::Forward).unwrap();
        let energy = |d: &[Complex]| d.iter().map(|c| c.norm_squared()).sum::<f64>();
        // Parseval's theorem.
        assert!((energy(&there) / count / energy(&data) - 1.0).abs() < 1e-13);
        transform(&mut there, sizes, Direction::Inverse).unwrap();
        there.iter_mut().for_each(|c| *c = c.scale(1.0 / count));
        assert!(distance(&there, &data) < 1e-11);
    }

    #[test]
    fn refuses_what_it_cannot_do() {
        assert_eq!(Fft::new(12).err(), Some(Unfit::Length(12)));
        assert_eq!(Fft::new(0).err(), Some(Unfit::Length(0)));
        let got = transform(&mut noise(8), [4, 4, 1], Direction::Forward);
        assert_eq!(got, Err(Unfit::Count { given: 8, wanted: 16 }));
    }
}
