//! The pieces of the B-splines of the first four orders, written out: their left halves.

/// Distribution and density at `x` up to the middle of the B-spline of an order from 1 to 4.
#[inline]
pub(super) fn left(order: u32, x: f64) -> [f64; 2] {
    if x < 0.0 {
        return [0.0, 0.0];
    }
    match (order, x < 1.0) {
        (1, _) => [x, 1.0],
        (2, _) => [x * x / 2.0, x],
        (3, true) => [x * x * x / 6.0, x * x / 2.0],
        (3, false) => {
            let from_middle = x - 1.5;
            let square = from_middle * from_middle;
            [0.5 + from_middle * (0.75 - square / 3.0), 0.75 - square]
        }
        (_, true) => {
            let cube = x * x * x;
            [cube * x / 24.0, cube / 6.0]
        }
        _ => {
            let from_middle = x - 2.0;
            let square = from_middle * from_middle;
            let fourth = square * from_middle * (1.0 / 3.0 + from_middle / 8.0);
            [0.5 + from_middle * (2.0 / 3.0) - fourth, 2.0 / 3.0 - square * (1.0 + 0.5 * from_middle)]
        }
    }
}
