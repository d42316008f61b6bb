//! A kernel's slope along an axis, as a kernel of its own: what flows along gradients are made of.
//!
//! Differentiating shifts everything by one order. The slope's value is the kernel's gradient, its
//! gradient the kernel's Hessian; its range is the kernel's Lipschitz bound, and so on, up to the
//! third derivative, of whose own slope nothing is known. A C2 kernel has a C1 slope.
//!
//! Second derivatives of a slope are third derivatives of the kernel, which kernels do not state.
//! At points they are central differences of the exact Hessian, good to six digits or so; enclosures
//! never read them, since the slope's third derivatives are declared unbounded.

use crate::num::{Bounds, Class, Interval, Jets, Kernel, Local, Order, Point};

/// `d/dx_axis` of a kernel.
pub(super) struct Slope<'a, K> {
    of: &'a K,
    axis: usize,
    /// Half the step of differences: a millionth or so of a feature of the kernel.
    step: f64,
}

/// Where the second derivatives by an axis and x, y, z are among the six.
const ROW: [[usize; 3]; 3] = [[0, 3, 4], [3, 1, 5], [4, 5, 2]];

/// Points differentiated at a time.
const BATCH: usize = super::BATCH;

/// Bounds of the slope.
pub(super) fn steeper(b: Bounds) -> Bounds {
    Bounds { range: b.lipschitz, lipschitz: b.hessian, hessian: b.third, third: f64::INFINITY }
}

impl<'a, K: Kernel> Slope<'a, K> {
    /// The slope along an axis (0, 1, 2).
    pub(super) fn new(of: &'a K, axis: u8, step: f64) -> Self {
        Slope { of, axis: usize::from(axis.min(2)), step }
    }

    /// The kernel's jet, one order up, as the slope's.
    fn shifted(&self, order: Order, at: [f64; 3], of: Point) -> Point {
        let mut p = Point { value: of.grad[self.axis], ..Point::default() };
        if order >= Order::Gradient {
            p.grad = ROW[self.axis].map(|k| of.hess[k]);
        }
        if order >= Order::Hessian {
            let [(above, high), (below, low)] = [self.step, -self.step].map(|h| {
                let mut q = at;
                q[self.axis] += h;
                (q[self.axis], self.of.jet(Order::Hessian, q).hess)
            });
            // The step that the coordinate really took.
            let width = above - below;
            p.hess = std::array::from_fn(|k| (high[k] - low[k]) / width);
        }
        p
    }

    fn up(order: Order) -> Order {
        match order {
            Order::Value => Order::Gradient,
            Order::Gradient | Order::Hessian => Order::Hessian,
        }
    }
}

impl<K: Kernel> Kernel for Slope<'_, K> {
    fn class(&self) -> Class {
        self.of.class().of_slope()
    }

    fn bounds(&self) -> Bounds {
        steeper(self.of.bounds())
    }

    fn jets(&self, at: [&[f64]; 3], mut out: Jets<'_>) {
        if out.hess.is_some() {
            // Rare enough to go point by point.
            for i in 0..at[0].len() {
                let p = self.jet(Order::Hessian, at.map(|at| at[i]));
                out.value[i] = p.value;
                out.grad.iter_mut().flatten().zip(p.grad).for_each(|(out, g)| out[i] = g);
                out.hess.iter_mut().flatten().zip(p.hess).for_each(|(out, h)| out[i] = h);
            }
            return;
        }
        let (mut value, mut grad, mut hess) = ([0.0; BATCH], [[0.0; BATCH]; 3], [[0.0; BATCH]; 6]);
        let wants_gradient = out.grad.is_some();
        for start in (0..at[0].len()).step_by(BATCH) {
            let end = (start + BATCH).min(at[0].len());
            let count = end - start;
            let own = Jets {
                value: &mut value[..count],
                grad: Some(grad.each_mut().map(|g| &mut g[..count])),
                hess: wants_gradient.then_some(hess.each_mut().map(|h| &mut h[..count])),
            };
            self.of.jets(at.map(|at| &at[start..end]), own);
            out.value[start..end].copy_from_slice(&grad[self.axis][..count]);
            for (out, k) in out.grad.iter_mut().flatten().zip(ROW[self.axis]) {
                out[start..end].copy_from_slice(&hess[k][..count]);
            }
        }
    }

    fn jet(&self, order: Order, at: [f64; 3]) -> Point {
        self.shifted(order, at, self.of.jet(Self::up(order), at))
    }

    fn is_uniform(&self) -> bool {
        self.of.is_uniform()
    }

    fn local(&self, order: Order, at: [f64; 3], radius: f64) -> Local {
        let local = self.of.local(Self::up(order), at, radius);
        Local {
            jet: self.shifted(order, at, local.jet),
            bounds: steeper(local.bounds),
            // The kernel's own bow says nothing about that of its slope.
            bow: Interval::ENTIRE,
            sag: f64::INFINITY,
            turn: f64::INFINITY,
        }
    }

    fn error(&self, size: f64) -> [f64; 3] {
        let [_, gradient, hessian] = self.of.error(size);
        [gradient, hessian, f64::INFINITY]
    }
}
