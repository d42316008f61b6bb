//! The spline of a grid at points and around them.

use super::{Edge, Grid};
use crate::num::{
    Bounds, Class, Interval, Jets, Kernel, Local, Order, Point, ROUNDOFF, Weights, cubic, widest,
};

/// What one axis contributes to a point: up to four coefficients and their weights.
struct Taps {
    /// How many count: four, or one along an axis of one sample.
    count: usize,
    /// Where they are, in steps of the array.
    at: [usize; 4],
    weights: Weights<f64, 4>,
}

impl Taps {
    #[inline(always)]
    fn new(u: f64, n: usize, stride: usize, edge: Edge) -> Taps {
        if n == 1 {
            let weights = Weights { value: [1.0, 0.0, 0.0, 0.0], first: [0.0; 4], second: [0.0; 4] };
            return Taps { count: 1, at: [0; 4], weights };
        }
        let size = n as f64;
        // A clamped spline is constant from one spacing beyond its samples on.
        let u = if edge == Edge::Clamp { u.clamp(-2.0, size + 1.0) } else { u };
        let cell = u.floor();
        let weights = cubic(u - cell);
        let at = match edge {
            Edge::Clamp => {
                let last = n as isize - 1;
                let first = cell as isize - 1;
                std::array::from_fn(|k| (first + k as isize).clamp(0, last) as usize * stride)
            }
            Edge::Repeat => {
                // Far away the quotient is rounded, by no more than one period; beyond 2^53 cells
                // there is no telling cells apart, but an index must still be one.
                let mut first = cell - 1.0 - size * ((cell - 1.0) / size).floor();
                if first < 0.0 {
                    first += size;
                }
                let first = (first as usize).min(n - 1);
                std::array::from_fn(|k| {
                    let i = first + k;
                    (if i < n { i } else { i % n }) * stride
                })
            }
        };
        Taps { count: 4, at, weights }
    }
}

/// A weighted sum of rows of four coefficients, along x.
type Row = [f64; 4];

#[inline(always)]
fn accumulate(sum: &mut Row, weight: f64, row: &Row) {
    for k in 0..4 {
        sum[k] += weight * row[k];
    }
}

#[inline(always)]
fn dot(weights: &Row, row: &Row) -> f64 {
    (weights[0] * row[0] + weights[1] * row[1]) + (weights[2] * row[2] + weights[3] * row[3])
}

impl Grid {
    /// The jet at a point, up to order 0, 1 or 2. Rows along x are first summed over y and z with all
    /// four of their elements side by side, in vectors; what is left is one row for each derivative
    /// by y and z.
    #[inline(always)]
    fn point<const ORDER: usize>(&self, at: [f64; 3]) -> Point {
        let [nx, ny, _] = self.frame.size;
        let strides = [1, nx, nx * ny];
        let [tx, ty, tz] = [0, 1, 2].map(|axis| {
            let u = (at[axis] - self.frame.origin[axis]) * self.scale[axis];
            Taps::new(u, self.frame.size[axis], strides[axis], self.frame.edge)
        });
        let mut rows = [[0.0; 4]; 6];
        let [plain, by_y, by_z, by_yy, by_zz, by_yz] = &mut rows;
        for k in 0..tz.count {
            for j in 0..ty.count {
                let start = tz.at[k] + ty.at[j];
                let row: Row = tx.at.map(|x| self.coefficients[start + x]);
                let (y, z) = (&ty.weights, &tz.weights);
                accumulate(plain, y.value[j] * z.value[k], &row);
                if ORDER >= 1 {
                    accumulate(by_y, y.first[j] * z.value[k], &row);
                    accumulate(by_z, y.value[j] * z.first[k], &row);
                }
                if ORDER >= 2 {
                    accumulate(by_yy, y.second[j] * z.value[k], &row);
                    accumulate(by_zz, y.value[j] * z.second[k], &row);
                    accumulate(by_yz, y.first[j] * z.first[k], &row);
                }
            }
        }
        let ([plain, by_y, by_z, by_yy, by_zz, by_yz], x, s) = (&rows, &tx.weights, self.scale);
        let mut p = Point { value: dot(&x.value, plain), ..Point::default() };
        if ORDER >= 1 {
            p.grad = [s[0] * dot(&x.first, plain), s[1] * dot(&x.value, by_y), s[2] * dot(&x.value, by_z)];
        }
        if ORDER >= 2 {
            p.hess = [
                s[0] * s[0] * dot(&x.second, plain),
                s[1] * s[1] * dot(&x.value, by_yy),
                s[2] * s[2] * dot(&x.value, by_zz),
                s[0] * s[1] * dot(&x.first, by_y),
                s[0] * s[2] * dot(&x.first, by_z),
                s[1] * s[2] * dot(&x.value, by_yz),
            ];
        }
        p
    }

    #[inline(always)]
    fn lanes<const ORDER: usize>(&self, at: [&[f64]; 3], out: &mut Jets<'_>) {
        for lane in 0..out.value.len() {
            let p = self.point::<ORDER>([at[0][lane], at[1][lane], at[2][lane]]);
            out.value[lane] = p.value;
            if let Some(grad) = &mut out.grad {
                (0..3).for_each(|k| grad[k][lane] = p.grad[k]);
            }
            if let Some(hess) = &mut out.hess {
                (0..6).for_each(|k| hess[k][lane] = p.hess[k]);
            }
        }
    }
}

impl Kernel for Grid {
    fn class(&self) -> Class {
        Class::C2
    }

    #[inline]
    fn bounds(&self) -> Bounds {
        self.pyramid().all()
    }

    fn jets(&self, at: [&[f64]; 3], mut out: Jets<'_>) {
        widest(
            #[inline(always)]
            || match (&out.grad, &out.hess) {
                (None, _) => self.lanes::<0>(at, &mut out),
                (Some(_), None) => self.lanes::<1>(at, &mut out),
                (Some(_), Some(_)) => self.lanes::<2>(at, &mut out),
            },
        );
    }

    fn is_uniform(&self) -> bool {
        false
    }

    fn local(&self, order: Order, at: [f64; 3], radius: f64) -> Local {
        let bounds = self.pyramid().around(&self.frame, self.scale, at, radius);
        Local::uniform(self.jet(order, at), bounds)
    }

    /// A value is a mean of coefficients.
    fn over(&self, x: &[Interval; 3]) -> Option<Interval> {
        if !x.iter().all(|x| x.is_finite()) {
            return None;
        }
        let half = x.map(|x| x.rad() * (1.0 + 8.0 * ROUNDOFF));
        let values = self.pyramid().values(&self.frame, self.scale, x.map(Interval::mid), half);
        Some(values + Interval::radius(256.0 * ROUNDOFF * self.pyramid().magnitude()))
    }

    fn error(&self, size: f64) -> [f64; 3] {
        // A weight is off by up to 8 roundoffs of 1 (of 2 and 4 for derivatives), four of them on each
        // of three axes; sums over three axes add 12. The offset from the origin rounds, and its
        // product with the scale, which is exact by definition.
        let b = self.bounds();
        let most = self.pyramid().magnitude();
        let varies = |axis: &usize| self.frame.size[*axis] > 1;
        let scale = (0..3).filter(varies).map(|axis| self.scale[axis]).fold(0.0, f64::max);
        let away = self.frame.origin.iter().fold(0.0, |most: f64, o| most.max(o.abs()));
        let shift = 6.0 * ROUNDOFF * (size + away);
        [
            160.0 * ROUNDOFF * most + b.lipschitz * shift,
            512.0 * ROUNDOFF * most * scale + b.hessian * shift,
            2048.0 * ROUNDOFF * most * scale * scale + b.third * shift,
        ]
    }
}
