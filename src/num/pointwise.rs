//! Functions that are known at points only, and of one number more than a point.
//!
//! A sum of many octaves is such a function of a point and of the footprint there. Numbers that
//! stand for points need not see the octaves one by one: the sum writes one jet, to which the chain
//! rule is applied once. Enclosures do see them, since over a box each octave is bounded by itself.

use super::{Jets, Order};

/// Second derivatives of a [`Point4`], as pairs of arguments; the fourth is the further one.
const PAIRS4: [(usize, usize); 10] =
    [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 3), (3, 3)];

/// A jet in three coordinates and a further argument; parts beyond the order asked for are zero.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Point4 {
    /// Value.
    pub value: f64,
    /// Gradient.
    pub grad: [f64; 4],
    /// Second derivatives: xx, yy, zz, xy, xz, yz, xs, ys, zs, ss with the further argument s.
    pub hess: [f64; 10],
}

impl Point4 {
    /// The jet as a batch of one, up to an order.
    #[inline(always)]
    pub fn as_jets(&mut self, order: Order) -> Jets4<'_> {
        let one = std::slice::from_mut;
        let [x, y, z, s] = self.grad.each_mut().map(one);
        let [xx, yy, zz, xy, xz, yz, xs, ys, zs, ss] = self.hess.each_mut().map(one);
        let (gradient, hessian) = (order >= Order::Gradient, order >= Order::Hessian);
        Jets4 {
            space: Jets {
                value: one(&mut self.value),
                grad: gradient.then_some([x, y, z]),
                hess: hessian.then_some([xx, yy, zz, xy, xz, yz]),
            },
            slope: gradient.then_some(s),
            bend: hessian.then_some([xs, ys, zs, ss]),
        }
    }

    /// The second derivatives as a matrix of the first `N` arguments.
    #[inline(always)]
    pub(super) fn matrix<const N: usize>(&self) -> [[f64; N]; N] {
        let mut m = [[0.0; N]; N];
        for (h, (i, j)) in self.hess.into_iter().zip(PAIRS4) {
            if i < N && j < N {
                m[i][j] = h;
                m[j][i] = h;
            }
        }
        m
    }
}

/// Where a batch of such jets is written: the coordinates' part, and the further argument's.
#[derive(Debug)]
pub struct Jets4<'a> {
    /// Value, gradient and Hessian in the coordinates.
    pub space: Jets<'a>,
    /// First derivatives by the further argument, if gradients are wanted.
    pub slope: Option<&'a mut [f64]>,
    /// Second derivatives with the further argument, if Hessians are wanted: xs, ys, zs, ss.
    pub bend: Option<[&'a mut [f64]; 4]>,
}

/// A function of a point, and of one number more where that is given.
pub trait Pointwise: Sync {
    /// Jets at a batch of points. Every slice has the same length; the parts of the further argument
    /// are left alone where there is none. Lanes do not influence one another.
    fn jets(&self, at: [&[f64]; 3], with: Option<&[f64]>, out: Jets4<'_>);

    /// The jet at one point, with the same bits as in a batch.
    fn jet(&self, order: Order, at: [f64; 3], with: Option<f64>) -> Point4;
}
