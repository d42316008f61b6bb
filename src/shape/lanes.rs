//! Batches of a function that is known at one point at a time.

use crate::num::{Jets, Order, Point};
use glam::DVec3;

/// Fills a batch lane by lane.
pub(super) fn fill(at: [&[f64]; 3], mut out: Jets<'_>, jet: impl Fn(Order, DVec3) -> Point) {
    let order = match (&out.grad, &out.hess) {
        (None, _) => Order::Value,
        (Some(_), None) => Order::Gradient,
        (Some(_), Some(_)) => Order::Hessian,
    };
    for lane in 0..out.value.len() {
        let p = jet(order, DVec3::new(at[0][lane], at[1][lane], at[2][lane]));
        out.value[lane] = p.value;
        if let Some(grad) = &mut out.grad {
            (0..3).for_each(|k| grad[k][lane] = p.grad[k]);
        }
        if let Some(hess) = &mut out.hess {
            (0..6).for_each(|k| hess[k][lane] = p.hess[k]);
        }
    }
}
